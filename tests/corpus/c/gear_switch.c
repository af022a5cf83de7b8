#include <stdint.h>

typedef enum {
    PARK = 0,
    REVERSE = 1,
    NEUTRAL = 2,
    DRIVE = 3
} selector_t;

#define KMH(x) ((x) / 3.6f)
#define IS_STANDING(v) ((v) < KMH(2.0f))

/* returns the gear to engage; 0 is neutral, -1 is reverse */
int8_t gear_request(uint8_t selector, float speed)
{
    switch (selector) {
    case PARK:
    case NEUTRAL:
        return 0;
    case REVERSE:
        return IS_STANDING(speed) ? -1 : 0;
    case DRIVE:
        if (speed < KMH(15.0f))
            return 1;
        else if (speed < KMH(35.0f))
            return 2;
        return 3;
    default:
        break;
    }
    return 0;
}
