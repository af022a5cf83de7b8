/* Pump station supervisor, state machine as a pure function of the sensors. */
#include <stdbool.h>
#include <stdint.h>
#include <math.h>

typedef enum { PUMP_OFF = 0, PUMP_ECO, PUMP_BOOST, PUMP_FAULT = 9 } pump_state_t;

typedef struct {
    float low_cm;
    float high_cm;
    float alarm_cm;
} levels_t;

static const levels_t LEVELS = { .low_cm = 40.0f, .high_cm = 180.0f, .alarm_cm = 240.0f };

#define CLAMP(v, lo, hi) ((v) < (lo) ? (lo) : ((v) > (hi) ? (hi) : (v)))
#define MA_TO_CM(ma) (((ma) - 4.0f) * (300.0f / 16.0f))

static inline bool sensor_ok(float ma)
{
    return ma >= 3.6f && ma <= 21.0f;
}

static pump_state_t by_level(float cm, bool cheap_power)
{
    if (cm >= LEVELS.alarm_cm)
        return PUMP_BOOST;
    if (cm >= LEVELS.high_cm)
        return cheap_power ? PUMP_ECO : PUMP_BOOST;
    if (cm > LEVELS.low_cm && cheap_power)
        return PUMP_ECO;
    return PUMP_OFF;
}

int pump_decide(float level_ma, float tariff_ct)
{
    const bool cheap = tariff_ct < 12.5f;
    pump_state_t next;

    if (!sensor_ok(level_ma)) {
        return PUMP_FAULT;
    }
    next = by_level(CLAMP(MA_TO_CM(level_ma), 0.0f, 300.0f), cheap);
    switch (next) {
    case PUMP_ECO:
    case PUMP_BOOST:
        break;
    default:
        next = PUMP_OFF;
    }
    return (int)next;
}
