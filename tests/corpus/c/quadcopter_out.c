#include <math.h>

#define DEG2RAD(d) ((d) * 3.14159265358979323846 / 180.0)

struct quad_state { double roll, pitch, altitude; };
struct quad_cmd { int action; };

static const double k_max_tilt = DEG2RAD(35);

static int clampi(int v, int lo, int hi)
{
    if (v < lo) return lo;
    if (v > hi) return hi;
    return v;
}

void quad_decide(const struct quad_state *s, struct quad_cmd *out)
{
    int severity = 0;

    if (fabs(s->roll) > k_max_tilt)
        severity += 2;
    if (fabs(s->pitch) > k_max_tilt)
        severity += 2;
    if (s->altitude < 1.5)
        severity++;

    out->action = clampi(severity, 0, 3);
}
