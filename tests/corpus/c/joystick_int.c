#include <stdlib.h>

typedef signed char s8;

/* dead zone and eight-way to four-way reduction, game pad driver */
int direction(s8 x, s8 y)
{
    const int dead = 16;

    if (abs(x) < dead && abs(y) < dead)
        return 0;
    if (y >= dead)
        return 1;
    if (y <= -dead)
        return 2;
    return x > 0 ? 3 : 4;
}
