#include <stdbool.h>

/* sensor calibration of the load cell, then the trip limit */
#define GAIN   0.0125f
#define OFFSET 1.5f

bool overload(float counts, _Bool bypass)
{
    float kg;

    if (bypass)
        return false;
    kg = counts * GAIN + OFFSET;
    return kg > 40.0f;
}
