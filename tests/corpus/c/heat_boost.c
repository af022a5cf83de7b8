#include <stdint.h>
#include <stdbool.h>
#define T_LOW  18.5f
#define T_HIGH (T_LOW + 3.0f)
typedef enum { HEAT_OFF = 0, HEAT_ON = 1, HEAT_BOOST = 2 } heat_t;
static inline bool too_cold(float t) { return t < T_LOW; }
heat_t control(const float x[2])
{
    heat_t out = HEAT_OFF;
    if (too_cold(x[0])) {
        out = (x[1] > 0.0f) ? HEAT_ON : HEAT_BOOST;
    } else if (x[0] >= T_HIGH) {
        out = HEAT_OFF;
    }
    return out;
}
