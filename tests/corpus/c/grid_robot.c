#include <stdbool.h>
#define FREE(i) (obs[i] >= 0.5f)
#define N 4
typedef enum { NORTH, EAST, SOUTH, WEST, STAY } Move;

static int count_free(const float obs[N])
{
    int n = 0, i;
    for (i = 0; i < N; i++)
        n += FREE(i);
    return n;
}

static bool dead_end(const float *obs) { return count_free(obs) == 1; }

/* obs: distance to the wall north, east, south, west, and the bearing of the goal */
Move robot(const float obs[5])
{
    Move preferred = obs[4] < 0.25f ? NORTH : obs[4] < 0.5f ? EAST : obs[4] < 0.75f ? SOUTH : WEST;

    if (count_free(obs) == 0) return STAY;
    if (dead_end(obs)) {
        for (int i = 0; i < N; ++i) if (FREE(i)) return (Move)i;
    }
    if (obs[preferred] >= 0.5f) return preferred;
    return FREE(NORTH) ? NORTH : FREE(EAST) ? EAST : FREE(SOUTH) ? SOUTH : WEST;
}
