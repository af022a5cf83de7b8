#ifndef LANE_KEEPING_H
#define LANE_KEEPING_H

#ifdef __cplusplus
extern "C" {
#endif

#include <math.h>
#include <stdint.h>

typedef struct {
    float lateral_offset;   /* m, left positive */
    float heading_error;    /* rad */
    float speed;            /* m/s */
    uint8_t driver_override;
} lk_input_t;

typedef enum { LK_NONE, LK_STEER_LEFT, LK_STEER_RIGHT, LK_WARN } lk_action_t;

static const float LK_MIN_SPEED = 16.7f;
static const float LK_OFFSET = 0.45f;
static const float LK_HEADING = 0.035f;

static inline int lk_is_active(const lk_input_t *in)
{
    return in->speed >= LK_MIN_SPEED && !in->driver_override;
}

static inline lk_action_t lk_decide(const lk_input_t *in)
{
    if (!lk_is_active(in))
        return LK_NONE;
    if (fabsf(in->lateral_offset) > 2.0f * LK_OFFSET)
        return LK_WARN;
    if (in->lateral_offset > LK_OFFSET || in->heading_error > LK_HEADING)
        return LK_STEER_RIGHT;
    if (in->lateral_offset < -LK_OFFSET || in->heading_error < -LK_HEADING)
        return LK_STEER_LEFT;
    return LK_NONE;
}

#ifdef __cplusplus
}
#endif

#endif /* LANE_KEEPING_H */
