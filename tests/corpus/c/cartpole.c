#include <math.h>

#define LEFT 0
#define RIGHT 1
#define SMALL_ANGLE 0.03

/* theta-omega policy, see the Python version */
int cartpole_policy(const double obs[4])
{
    const double theta = obs[2];
    const double omega = obs[3];

    if (fabs(theta) < SMALL_ANGLE)
        return omega < 0 ? LEFT : RIGHT;
    return theta < 0 ? LEFT : RIGHT;
}
