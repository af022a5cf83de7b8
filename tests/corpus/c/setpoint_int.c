#include <stdlib.h>

#define SETPOINT   72
#define TOLERANCE  2

enum { COOL = -1, OFF = 0, HEAT = 1 };

/* thermostat, whole degrees Fahrenheit */
int thermostat(int temperature, int occupied)
{
    int error = SETPOINT - temperature;
    int tolerance = occupied ? TOLERANCE : 3 * TOLERANCE;

    if (abs(error) <= tolerance)
        return OFF;
    return error > 0 ? HEAT : COOL;
}
