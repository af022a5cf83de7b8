/* Times ways of deciding, each over the same pool, interleaved: prints nanoseconds of each in each round.
 * ways.h names them: WAYS(each) calls each(name, function), where function is int (const REAL *x). */
#define _POSIX_C_SOURCE 199309L
#include <stdio.h>
#include <stdlib.h>
#include <time.h>
#include "ways.h"

static REAL pool[POOL][FEATURES];

static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return 1e9 * (double)t.tv_sec + (double)t.tv_nsec;
}

/* the next observation depends on the last answer */
#define CHAIN(name, function)                                                                                         \
    {                                                                                                                 \
        unsigned at = 1;                                                                                              \
        const double begin = now();                                                                                   \
        for (long i = 0; i < POOL; i++) {                                                                             \
            at = (at * 5u + 1u + (unsigned)function(pool[at])) & (POOL - 1);                                          \
        }                                                                                                             \
        sink += at;                                                                                                   \
        printf("%.3f ", (now() - begin) / POOL);                                                                      \
    }
#define FREE(name, function)                                                                                          \
    {                                                                                                                 \
        unsigned total = 0;                                                                                           \
        const double begin = now();                                                                                   \
        for (long i = 0; i < POOL; i++) {                                                                             \
            total += (unsigned)function(pool[i]);                                                                     \
        }                                                                                                             \
        sink += total;                                                                                                \
        printf("%.3f ", (now() - begin) / POOL);                                                                      \
    }

int main(void)
{
    volatile unsigned sink = 0;
    srand(1);
    for (long i = 0; i < POOL; i++) {
        for (int k = 0; k < FEATURES; k++) {
            pool[i][k] = (REAL)(2.0 * rand() / RAND_MAX - 1.0);
        }
    }
    PREPARE
    for (int round = 0; round < ROUNDS; round++) {
        WAYS(CHAIN)
        WAYS(FREE)
        printf("\n");
    }
    return 0;
}
