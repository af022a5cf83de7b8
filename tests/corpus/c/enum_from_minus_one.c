struct state { double x, v; };
enum { L = -1, N, R };
static int sgn(double v) { if (v > 0.05) return 1; if (v < -0.05) return -1; return 0; }
int policy(const struct state *s)
{
    int want = -sgn(s->x);
    if (!want) want = -sgn(s->v);
    for (int i = 0; i < 2; ++i) if (s->x > 2.0 + i) return L;
    return want;
}
