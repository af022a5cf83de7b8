#include <stdio.h>

float c_to_f(float c) { return c * 9.0f / 5.0f + 32.0f; }

const char *advice(float celsius)
{
    float f = c_to_f(celsius);

    if (f >= 103)
        return "danger";
    else if (f >= 91)
        return "caution";
    else if (f <= 32)
        return "frost";
    return "fine";
}
