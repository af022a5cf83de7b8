/* Times the emitted headers nested.h, ordered.h and walk.h of one team of four; see compiler.py. Prints nanoseconds a
 * decision (a row, four decisions), a line a round, the measures in the order of MEASURES there.
 */
#include <stdio.h>
#include <time.h>

#include "nested.h"
#include "ordered.h"
#include "walk.h"

enum { BLOCK = 4096, APART = POOL + 80 };
static float pool[4][POOL * FEATURES], slow[4][POOL * FEATURES], columns[POOL * FEATURES], apart[APART * FEATURES];
static unsigned char out[POOL];
static volatile long sink;

static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return 1e9 * (double)t.tv_sec + (double)t.tv_nsec;
}

static void fill(void)
{
    unsigned long long s = 88172645463325252ULL;
    for (int a = 0; a < 4; a++) {
        for (int i = 0; i < POOL * FEATURES; i++) {
            s ^= s << 13;
            s ^= s >> 7;
            s ^= s << 17;
            pool[a][i] = (float)((double)(s >> 11) / 9007199254740992.0 * 2.0 - 1.0);
            slow[a][i] = i < FEATURES ? pool[a][i] : slow[a][i - FEATURES] * 0.99f + 0.1f * pool[a][i];
        }
    }
    for (int i = 0; i < POOL; i++) {
        for (int k = 0; k < FEATURES; k++) {
            columns[k * POOL + i] = apart[k * APART + i] = pool[0][i * FEATURES + k];
        }
    }
}

static void say(double started, double count)
{
    printf("%.4f ", (now() - started) / count);
}

/* the next observation depends on the last action */
#define CHAIN(act)                                                   \
    {                                                                \
        double t = now();                                            \
        long long at = 1;                                                 \
        for (int i = 0; i < POOL; i++) {                             \
            at = ((i * 2654435761LL >> 5) + 7919 * act(&pool[0][at * FEATURES])) & (POOL - 1); \
        }                                                            \
        sink += (long)at;                                                  \
        say(t, POOL);                                                \
    }
#define FREE(act)                                                    \
    {                                                                \
        double t = now();                                            \
        long sum = 0;                                                \
        for (int i = 0; i < POOL; i++) {                             \
            sum += act(&pool[0][i * FEATURES]);                      \
        }                                                            \
        sink += sum;                                                 \
        say(t, POOL);                                                \
    }

/* as many rows at a time as stay in the cache: what is timed is the deciding, not the memory */
static void by_columns(const float *first, long distance)
{
    const float *x[FEATURES];
    double t = now();
    for (int round = 0; round < 64; round++) {
        for (int k = 0; k < FEATURES; k++) {
            x[k] = first + k * distance + round % 4 * BLOCK;
        }
        nested_agent_0_act_columns(x, BLOCK, out);
        sink += out[round];
    }
    say(t, 64.0 * BLOCK);
}

static void batches(void)
{
    double t = now();
    nested_agent_0_act_rows(pool[0], POOL, out);
    sink += out[7];
    say(t, POOL);
    by_columns(columns, POOL);
    by_columns(apart, APART);
}

static void four(float data[4][POOL * FEATURES])
{
    double t = now();
    long sum = 0;
    for (int i = 0; i < POOL; i++) {
        sum += nested_agent_0_act(&data[0][i * FEATURES]);
        sum += nested_agent_1_act(&data[1][i * FEATURES]);
        sum += nested_agent_2_act(&data[2][i * FEATURES]);
        sum += nested_agent_3_act(&data[3][i * FEATURES]);
    }
    sink += sum;
    say(t, POOL);
    t = now();
    for (int i = 0; i < POOL; i++) {
        int actions[4];
        const float *x[4];
        for (int a = 0; a < 4; a++) {
            x[a] = &data[a][i * FEATURES];
        }
        nested_act_all(x, actions);
        sum += actions[0] + actions[1] + actions[2] + actions[3];
    }
    sink += sum;
    say(t, POOL);
}

int main(void)
{
    fill();
    for (int round = 0; round < ROUNDS; round++) {
        CHAIN(nested_agent_0_act)
        CHAIN(ordered_agent_0_act)
        CHAIN(walk_agent_0_act)
        FREE(nested_agent_0_act)
        FREE(ordered_agent_0_act)
        FREE(walk_agent_0_act)
        batches();
        four(pool);
        four(slow);
        printf("\n");
    }
    return 0;
}
