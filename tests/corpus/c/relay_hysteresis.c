#include <stdbool.h>

/* relay with 2 K of hysteresis */
bool relay(float temperature)
{
    static bool on = false;

    if (temperature < 19.0f)
        on = true;
    else if (temperature > 21.0f)
        on = false;

    return on;
}
