#include <math.h>
#ifndef M_PI
#define M_PI 3.14159265358979323846
#endif
int act(double angle, double rate) {
    const double k = M_PI / 180.0;
    double a = fabs(angle);
    int s = (angle > 0) - (angle < 0);
    if (a > 10 * k) return s + 1;
    return rate > 0 ? 2 : rate < 0 ? 0 : 1;
}
