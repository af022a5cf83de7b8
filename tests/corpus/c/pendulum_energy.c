#define _USE_MATH_DEFINES
#include <math.h>
#ifndef M_PI
#define M_PI 3.14159265358979323846
#endif

static const double kBalanceWindow = 15.0 * M_PI / 180.0;

typedef struct { double theta, omega; } Obs;

/* torque index: 0 = -max, 1 = none, 2 = +max */
int pendulum(Obs obs)
{
    const double a = fabs(obs.theta);
    if (a < kBalanceWindow) {
        if (obs.theta > 0.02) return 0;
        if (obs.theta < -0.02) return 2;
        return 1;
    }
    if (fmax(obs.omega, -8.0) > 0) return 2;
    return fmin(obs.omega, 8.0) < 0 ? 0 : 2;
}
