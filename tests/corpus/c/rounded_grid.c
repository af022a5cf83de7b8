#include <math.h>

int grid(float x, float y)
{
    int q = (int)floorf(fmaxf(fminf(x, 3.0f), -3.0f) * 2);
    int z = (int)lroundf(fminf(fmaxf(y, -1.f), 1.f));
    return q * 3 + z;
}
