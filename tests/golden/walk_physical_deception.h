/* Decision tree policies of 3 agents for the world physical-deception. Generated: do not edit.
 *
 * profile     d7c7e9951b353c845e3729dfb7383e9f94192c6dfd621196d4fd4879d989808d
 * made by     tests, hand-made, preset none, seed 0
 * style       walk
 *
 * C99, also C++17; no heap, no libc, no recursion, no state. For each agent A:
 *   int physical_deception_A_act(const float *x)        the action, from an observation of float32
 *   int physical_deception_A_finite(const float *x)     1 when every number of the observation is finite, else 0
 *   int physical_deception_A_in_range(const float *x)   1 when every number is within its feature's range, else 0
 *   void physical_deception_A_act_rows(const float *x, long n, T *actions)              n observations, one after the other
 *   void physical_deception_A_act_columns(const float *const *x, long n, T *actions)    n observations, one array per feature
 *   void physical_deception_A_observe(const double *w, float *x)    what it observes in a world state: PHYSICAL_DECEPTION_W_... are its places
 *   int physical_deception_A_act_world(const double *w)  the action, from a world state
 * and for all agents, in the order of this file:
 *   void physical_deception_act_all(const float *const *x, int *actions)   the actions, from an observation of each
 *   void physical_deception_act_team(const double *w, int *actions)        the actions, from a world state
 * PHYSICAL_DECEPTION_DT is the time of a step, PHYSICAL_DECEPTION_DAMPING the share of its velocity that an agent loses in it,
 * PHYSICAL_DECEPTION_A_FORCE what a unit action adds to its velocity per unit of time.
 *
 * A split goes left iff x[feature] <= threshold, both float32, thresholds exact. NaN compares false and so goes right;
 * infinities follow <=. Check untrusted input with ..._finite first.
 *
 * Subnormal numbers count. A thread that takes them for zero (FTZ, DAZ) decides what lies next to zero otherwise; gcc sets
 * this at the start of a program that is linked with -ffast-math or -funsafe-math-optimizations, whatever compiled this
 * file. The style `ordered` has an ..._act that decides as stated there too.
 * From a world state an observation is made as the reference environment makes it: added in double, then rounded to float,
 * to nearest each time; so it does on machines that calculate with more digits (FLT_EVAL_METHOD), too.
 *
 * The tables of trees are in each unit that includes this file. They are in a program once where all its units define
 * PHYSICAL_DECEPTION_SHARED_TABLES before, and one of them also PHYSICAL_DECEPTION_OWN_TABLES.
 */
#ifndef PHYSICAL_DECEPTION_D7C7E9951B353C84_H
#define PHYSICAL_DECEPTION_D7C7E9951B353C84_H

#include <float.h>

#if defined(__FAST_MATH__) || defined(__ASSOCIATIVE_MATH__) || (defined(__FINITE_MATH_ONLY__) && (__FINITE_MATH_ONLY__ > 0))
#error "compile without -ffast-math, -funsafe-math-optimizations and -ffinite-math-only: they change NaN and tiny numbers"
#endif
#if defined(__cplusplus) && (__cplusplus < 201703L) && defined(__STRICT_ANSI__) && !defined(__clang__)
#error "thresholds are hexadecimal floats: compile with -std=c++17, or with -std=gnu++11 or -std=gnu++14"
#endif
#ifdef FLT_RADIX /* a checker that reads no system headers goes on */
#if (FLT_RADIX != 2) || (FLT_MANT_DIG != 24) || (FLT_MAX_EXP != 128) || (DBL_MANT_DIG != 53)
#error "float must be IEEE binary32 and double binary64"
#endif
#if (LDBL_MANT_DIG < 64) && (FLT_EVAL_METHOD != 0) && (FLT_EVAL_METHOD != 1) && (FLT_EVAL_METHOD != 16)
#error "sums of doubles are rounded in an unknown way here: compile for SSE2 (-msse2 -mfpmath=sse, /arch:SSE2)"
#endif
#endif

#define PHYSICAL_DECEPTION_PROFILE "d7c7e9951b353c845e3729dfb7383e9f94192c6dfd621196d4fd4879d989808d"
#define PHYSICAL_DECEPTION_DT 0.1
#define PHYSICAL_DECEPTION_DAMPING 0.25
#define PHYSICAL_DECEPTION_ADVERSARY_0_FORCE 5.0
#define PHYSICAL_DECEPTION_AGENT_0_FORCE 5.0
#define PHYSICAL_DECEPTION_AGENT_1_FORCE 5.0

enum {
    PHYSICAL_DECEPTION_W_ADVERSARY_0_X = 0, /* read by adversary_0, agent_0, agent_1 */
    PHYSICAL_DECEPTION_W_ADVERSARY_0_Y = 1, /* read by adversary_0, agent_0, agent_1 */
    PHYSICAL_DECEPTION_W_AGENT_0_X = 2, /* read by adversary_0, agent_0, agent_1 */
    PHYSICAL_DECEPTION_W_AGENT_0_Y = 3, /* read by adversary_0, agent_0, agent_1 */
    PHYSICAL_DECEPTION_W_AGENT_1_X = 4, /* read by adversary_0, agent_0, agent_1 */
    PHYSICAL_DECEPTION_W_AGENT_1_Y = 5, /* read by adversary_0, agent_0, agent_1 */
    PHYSICAL_DECEPTION_W_LANDMARK_0_X = 6, /* read by adversary_0, agent_0, agent_1 */
    PHYSICAL_DECEPTION_W_LANDMARK_0_Y = 7, /* read by adversary_0, agent_0, agent_1 */
    PHYSICAL_DECEPTION_W_LANDMARK_1_X = 8, /* read by adversary_0, agent_0, agent_1 */
    PHYSICAL_DECEPTION_W_LANDMARK_1_Y = 9, /* read by adversary_0, agent_0, agent_1 */
    PHYSICAL_DECEPTION_W_GOAL_X = 10, /* read by agent_0, agent_1 */
    PHYSICAL_DECEPTION_W_GOAL_Y = 11, /* read by agent_0, agent_1 */
    PHYSICAL_DECEPTION_W_ADVERSARY_0_VX = 12, /* not read */
    PHYSICAL_DECEPTION_W_ADVERSARY_0_VY = 13, /* not read */
    PHYSICAL_DECEPTION_W_AGENT_0_VX = 14, /* not read */
    PHYSICAL_DECEPTION_W_AGENT_0_VY = 15, /* not read */
    PHYSICAL_DECEPTION_W_AGENT_1_VX = 16, /* not read */
    PHYSICAL_DECEPTION_W_AGENT_1_VY = 17, /* not read */
    PHYSICAL_DECEPTION_N_COORDINATES = 18
};

/* 1 where doubles are added in double; x87 keeps more digits until they are stored */
static inline int physical_deception_direct(void)
{
    return ((FLT_EVAL_METHOD == 0) || (FLT_EVAL_METHOD == 1) || (FLT_EVAL_METHOD == 16)) ? 1 : 0;
}

/* a + b, rounded once to double, where more digits are kept. Storing the sum rounds it a second time, which is wrong
   where the first rounding ended halfway between two doubles: there, what that one cut off decides. */
static inline double physical_deception_wide_sum(double a, double b)
{
    const long double x = (long double)a;
    const long double y = (long double)b;
    const long double whole = x + y;
    const long double part = whole - x;
    const long double cut = (x - (whole - part)) + (y - part); /* a + b is exactly whole + cut */
    long double scale = 1.0L;
    if ((whole > 0x1p1000L) || (whole < -0x1p1000L)) {
        scale = 0.5L; /* so that no store overflows before the last */
    }
    const long double scaled = whole * scale;
    volatile double stored = (double)scaled;
    const long double rest = scaled - (long double)stored;
    const long double other = scaled + rest;
    const volatile double beside = (double)other;
    if (((cut > 0.0L) && (rest > 0.0L)) || ((cut < 0.0L) && (rest < 0.0L))) {
        if (((long double)beside >= other) && ((long double)beside <= other)) { /* halfway: `beside` is as near */
            stored = beside;
        }
    }
    if (scale < 1.0L) {
        stored = stored * 2.0;
    }
    return stored;
}

static inline double physical_deception_sum(double a, double b)
{
#if defined(__FMA__) && defined(__GNUC__) && defined(__x86_64__)
    __asm__("" : "+x"(a), "+x"(b)); /* no instruction; a product of the caller fused with the sum would not be rounded */
    double total = a + b;
#elif defined(__FP_FAST_FMA) || defined(__FMA__) || defined(__AVX2__) || defined(__aarch64__)
    const volatile double first = a; /* stored, for the same */
    const volatile double second = b;
    double total = first + second;
#else
    double total = a + b;
#endif
    if (physical_deception_direct() == 0) {
        total = physical_deception_wide_sum(a, b);
    }
    return total;
}

static inline float physical_deception_wide_single(double value)
{
    const volatile float stored = (float)value;
    return stored;
}

static inline float physical_deception_single(double value)
{
    float nearest = (float)value;
    if (physical_deception_direct() == 0) {
        nearest = physical_deception_wide_single(value);
    }
    return nearest;
}

#ifdef PHYSICAL_DECEPTION_SHARED_TABLES
extern const unsigned char physical_deception_adversary_0_action[1];
extern const float physical_deception_agent_0_threshold[7];
extern const unsigned char physical_deception_agent_0_feature[7];
extern const unsigned char physical_deception_agent_0_action[8];
extern const float physical_deception_agent_1_threshold[7];
extern const unsigned char physical_deception_agent_1_feature[7];
extern const unsigned char physical_deception_agent_1_action[8];
#define PHYSICAL_DECEPTION_TABLE const
#else
#define PHYSICAL_DECEPTION_TABLE static const
#endif
#if !defined(PHYSICAL_DECEPTION_SHARED_TABLES) || defined(PHYSICAL_DECEPTION_OWN_TABLES)
PHYSICAL_DECEPTION_TABLE unsigned char physical_deception_adversary_0_action[1] = {0};
PHYSICAL_DECEPTION_TABLE float physical_deception_agent_0_threshold[7] = {0x1.999998p-4f, 0x0p+0f, -0x1.555556p-2f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x1.fffffep+127f};
PHYSICAL_DECEPTION_TABLE unsigned char physical_deception_agent_0_feature[7] = {0, 3, 9, 0, 0, 0, 2};
PHYSICAL_DECEPTION_TABLE unsigned char physical_deception_agent_0_action[8] = {1, 1, 2, 2, 4, 4, 0, 0};
PHYSICAL_DECEPTION_TABLE float physical_deception_agent_1_threshold[7] = {-0x1.99999ap-5f, 0x0p+0f, 0x1.99999ap-5f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f};
PHYSICAL_DECEPTION_TABLE unsigned char physical_deception_agent_1_feature[7] = {4, 0, 4, 0, 0, 5, 0};
PHYSICAL_DECEPTION_TABLE unsigned char physical_deception_agent_1_action[8] = {1, 1, 1, 1, 3, 4, 2, 2};
#endif

/* adversary_0, team adversaries: 1 leaf, at most 0 comparisons; tables of 1 byte; 32 bytes of stack for ..._act_world */

enum {
    PHYSICAL_DECEPTION_ADVERSARY_0_X_LANDMARK_0_DX = 0, /* length, [-6.3, 6.3]: landmark_0.x - adversary_0.x */
    PHYSICAL_DECEPTION_ADVERSARY_0_X_LANDMARK_0_DY = 1, /* length, [-6.3, 6.3]: landmark_0.y - adversary_0.y */
    PHYSICAL_DECEPTION_ADVERSARY_0_X_LANDMARK_1_DX = 2, /* length, [-6.3, 6.3]: landmark_1.x - adversary_0.x */
    PHYSICAL_DECEPTION_ADVERSARY_0_X_LANDMARK_1_DY = 3, /* length, [-6.3, 6.3]: landmark_1.y - adversary_0.y */
    PHYSICAL_DECEPTION_ADVERSARY_0_X_AGENT_0_DX = 4, /* length, [-10.6, 10.6]: agent_0.x - adversary_0.x */
    PHYSICAL_DECEPTION_ADVERSARY_0_X_AGENT_0_DY = 5, /* length, [-10.6, 10.6]: agent_0.y - adversary_0.y */
    PHYSICAL_DECEPTION_ADVERSARY_0_X_AGENT_1_DX = 6, /* length, [-10.6, 10.6]: agent_1.x - adversary_0.x */
    PHYSICAL_DECEPTION_ADVERSARY_0_X_AGENT_1_DY = 7, /* length, [-10.6, 10.6]: agent_1.y - adversary_0.y */
    PHYSICAL_DECEPTION_ADVERSARY_0_N_FEATURES = 8
};

enum {
    PHYSICAL_DECEPTION_ADVERSARY_0_STAY = 0, /* pushes by (0.0, 0.0) */
    PHYSICAL_DECEPTION_ADVERSARY_0_LEFT = 1, /* pushes by (-1.0, 0.0) */
    PHYSICAL_DECEPTION_ADVERSARY_0_RIGHT = 2, /* pushes by (1.0, 0.0) */
    PHYSICAL_DECEPTION_ADVERSARY_0_DOWN = 3, /* pushes by (0.0, -1.0) */
    PHYSICAL_DECEPTION_ADVERSARY_0_UP = 4, /* pushes by (0.0, 1.0) */
    PHYSICAL_DECEPTION_ADVERSARY_0_N_ACTIONS = 5
};

static inline int physical_deception_adversary_0_act(const float *x)
{
    (void)x;
    return (int)physical_deception_adversary_0_action[0];
}

static inline int physical_deception_adversary_0_finite(const float *x)
{
    int finite = 1;
    int i;
    for (i = 0; i < PHYSICAL_DECEPTION_ADVERSARY_0_N_FEATURES; i++) {
        if (!((x[i] >= -0x1.fffffep+127f) && (x[i] <= 0x1.fffffep+127f))) {
            finite = 0;
        }
    }
    return finite;
}

static inline int physical_deception_adversary_0_in_range(const float *x)
{
    int within = 1;
    if (!((x[0] >= -0x1.933334p+2f) && (x[0] <= 0x1.933334p+2f))) {
        within = 0;
    }
    if (!((x[1] >= -0x1.933334p+2f) && (x[1] <= 0x1.933334p+2f))) {
        within = 0;
    }
    if (!((x[2] >= -0x1.933334p+2f) && (x[2] <= 0x1.933334p+2f))) {
        within = 0;
    }
    if (!((x[3] >= -0x1.933334p+2f) && (x[3] <= 0x1.933334p+2f))) {
        within = 0;
    }
    if (!((x[4] >= -0x1.533334p+3f) && (x[4] <= 0x1.533334p+3f))) {
        within = 0;
    }
    if (!((x[5] >= -0x1.533334p+3f) && (x[5] <= 0x1.533334p+3f))) {
        within = 0;
    }
    if (!((x[6] >= -0x1.533334p+3f) && (x[6] <= 0x1.533334p+3f))) {
        within = 0;
    }
    if (!((x[7] >= -0x1.533334p+3f) && (x[7] <= 0x1.533334p+3f))) {
        within = 0;
    }
    return within;
}

static inline void physical_deception_adversary_0_act_rows(const float *x, long n, unsigned char *actions)
{
    long row;
    (void)x;
    for (row = 0; row < n; row++) {
        actions[row] = physical_deception_adversary_0_action[0];
    }
}

static inline void physical_deception_adversary_0_act_columns(const float *const *x, long n, unsigned char *actions)
{
    (void)x;
    long first;
    long row;
    /* one select per split, leaves first, each into its own variable: compilers turn this into vector code */
    for (first = 0; first < n; first += 256) {
        float chosen[256];
        const long left = n - first;
        const long count = (left < 256) ? left : 256;
        for (row = 0; row < count; row++) {
            chosen[row] = 0.0f;
        }
        for (row = 0; row < count; row++) {
            actions[first + row] = (unsigned char)chosen[row];
        }
    }
}

static inline void physical_deception_adversary_0_observe(const double *w, float *x)
{
    x[0] = physical_deception_single(physical_deception_sum(w[PHYSICAL_DECEPTION_W_LANDMARK_0_X], -w[PHYSICAL_DECEPTION_W_ADVERSARY_0_X]));
    x[1] = physical_deception_single(physical_deception_sum(w[PHYSICAL_DECEPTION_W_LANDMARK_0_Y], -w[PHYSICAL_DECEPTION_W_ADVERSARY_0_Y]));
    x[2] = physical_deception_single(physical_deception_sum(w[PHYSICAL_DECEPTION_W_LANDMARK_1_X], -w[PHYSICAL_DECEPTION_W_ADVERSARY_0_X]));
    x[3] = physical_deception_single(physical_deception_sum(w[PHYSICAL_DECEPTION_W_LANDMARK_1_Y], -w[PHYSICAL_DECEPTION_W_ADVERSARY_0_Y]));
    x[4] = physical_deception_single(physical_deception_sum(w[PHYSICAL_DECEPTION_W_AGENT_0_X], -w[PHYSICAL_DECEPTION_W_ADVERSARY_0_X]));
    x[5] = physical_deception_single(physical_deception_sum(w[PHYSICAL_DECEPTION_W_AGENT_0_Y], -w[PHYSICAL_DECEPTION_W_ADVERSARY_0_Y]));
    x[6] = physical_deception_single(physical_deception_sum(w[PHYSICAL_DECEPTION_W_AGENT_1_X], -w[PHYSICAL_DECEPTION_W_ADVERSARY_0_X]));
    x[7] = physical_deception_single(physical_deception_sum(w[PHYSICAL_DECEPTION_W_AGENT_1_Y], -w[PHYSICAL_DECEPTION_W_ADVERSARY_0_Y]));
}

static inline int physical_deception_adversary_0_act_world(const double *w)
{
    float x[PHYSICAL_DECEPTION_ADVERSARY_0_N_FEATURES];
    physical_deception_adversary_0_observe(w, x);
    return physical_deception_adversary_0_act(x);
}

/* agent_0, team defenders: 5 leaves, at most 3 comparisons; tables of 43 bytes; 40 bytes of stack for ..._act_world */

enum {
    PHYSICAL_DECEPTION_AGENT_0_X_GOAL_DX = 0, /* length, [-6.3, 6.3]: goal.x - agent_0.x */
    PHYSICAL_DECEPTION_AGENT_0_X_GOAL_DY = 1, /* length, [-6.3, 6.3]: goal.y - agent_0.y */
    PHYSICAL_DECEPTION_AGENT_0_X_LANDMARK_0_DX = 2, /* length, [-6.3, 6.3]: landmark_0.x - agent_0.x */
    PHYSICAL_DECEPTION_AGENT_0_X_LANDMARK_0_DY = 3, /* length, [-6.3, 6.3]: landmark_0.y - agent_0.y */
    PHYSICAL_DECEPTION_AGENT_0_X_LANDMARK_1_DX = 4, /* length, [-6.3, 6.3]: landmark_1.x - agent_0.x */
    PHYSICAL_DECEPTION_AGENT_0_X_LANDMARK_1_DY = 5, /* length, [-6.3, 6.3]: landmark_1.y - agent_0.y */
    PHYSICAL_DECEPTION_AGENT_0_X_ADVERSARY_0_DX = 6, /* length, [-10.6, 10.6]: adversary_0.x - agent_0.x */
    PHYSICAL_DECEPTION_AGENT_0_X_ADVERSARY_0_DY = 7, /* length, [-10.6, 10.6]: adversary_0.y - agent_0.y */
    PHYSICAL_DECEPTION_AGENT_0_X_AGENT_1_DX = 8, /* length, [-10.6, 10.6]: agent_1.x - agent_0.x */
    PHYSICAL_DECEPTION_AGENT_0_X_AGENT_1_DY = 9, /* length, [-10.6, 10.6]: agent_1.y - agent_0.y */
    PHYSICAL_DECEPTION_AGENT_0_N_FEATURES = 10
};

enum {
    PHYSICAL_DECEPTION_AGENT_0_STAY = 0, /* pushes by (0.0, 0.0) */
    PHYSICAL_DECEPTION_AGENT_0_LEFT = 1, /* pushes by (-1.0, 0.0) */
    PHYSICAL_DECEPTION_AGENT_0_RIGHT = 2, /* pushes by (1.0, 0.0) */
    PHYSICAL_DECEPTION_AGENT_0_DOWN = 3, /* pushes by (0.0, -1.0) */
    PHYSICAL_DECEPTION_AGENT_0_UP = 4, /* pushes by (0.0, 1.0) */
    PHYSICAL_DECEPTION_AGENT_0_N_ACTIONS = 5
};

static inline int physical_deception_agent_0_act(const float *x)
{
    int i = 0;
    int level;
    for (level = 0; level < 3; level++) {
        i = (2 * i) + 1 + ((x[physical_deception_agent_0_feature[i]] <= physical_deception_agent_0_threshold[i]) ? 0 : 1);
    }
    return (int)physical_deception_agent_0_action[i - 7];
}

static inline int physical_deception_agent_0_finite(const float *x)
{
    int finite = 1;
    int i;
    for (i = 0; i < PHYSICAL_DECEPTION_AGENT_0_N_FEATURES; i++) {
        if (!((x[i] >= -0x1.fffffep+127f) && (x[i] <= 0x1.fffffep+127f))) {
            finite = 0;
        }
    }
    return finite;
}

static inline int physical_deception_agent_0_in_range(const float *x)
{
    int within = 1;
    if (!((x[0] >= -0x1.933334p+2f) && (x[0] <= 0x1.933334p+2f))) {
        within = 0;
    }
    if (!((x[1] >= -0x1.933334p+2f) && (x[1] <= 0x1.933334p+2f))) {
        within = 0;
    }
    if (!((x[2] >= -0x1.933334p+2f) && (x[2] <= 0x1.933334p+2f))) {
        within = 0;
    }
    if (!((x[3] >= -0x1.933334p+2f) && (x[3] <= 0x1.933334p+2f))) {
        within = 0;
    }
    if (!((x[4] >= -0x1.933334p+2f) && (x[4] <= 0x1.933334p+2f))) {
        within = 0;
    }
    if (!((x[5] >= -0x1.933334p+2f) && (x[5] <= 0x1.933334p+2f))) {
        within = 0;
    }
    if (!((x[6] >= -0x1.533334p+3f) && (x[6] <= 0x1.533334p+3f))) {
        within = 0;
    }
    if (!((x[7] >= -0x1.533334p+3f) && (x[7] <= 0x1.533334p+3f))) {
        within = 0;
    }
    if (!((x[8] >= -0x1.533334p+3f) && (x[8] <= 0x1.533334p+3f))) {
        within = 0;
    }
    if (!((x[9] >= -0x1.533334p+3f) && (x[9] <= 0x1.533334p+3f))) {
        within = 0;
    }
    return within;
}

static inline void physical_deception_agent_0_act_rows(const float *x, long n, unsigned char *actions)
{
    long row;
    /* eight observations side by side, so that none waits for another */
    const long together = n - (n % 8);
    for (row = 0; row < together; row += 8) {
        const float *const seen = &x[row * PHYSICAL_DECEPTION_AGENT_0_N_FEATURES];
        int i[8] = {0, 0, 0, 0, 0, 0, 0, 0};
        int level;
        int k;
        for (level = 0; level < 3; level++) {
            for (k = 0; k < 8; k++) {
                i[k] = (2 * i[k]) + 1 + ((seen[(k * PHYSICAL_DECEPTION_AGENT_0_N_FEATURES) + physical_deception_agent_0_feature[i[k]]] <= physical_deception_agent_0_threshold[i[k]]) ? 0 : 1);
            }
        }
        for (k = 0; k < 8; k++) {
            actions[row + k] = physical_deception_agent_0_action[i[k] - 7];
        }
    }
    for (row = together; row < n; row++) {
        const float *const seen = &x[row * PHYSICAL_DECEPTION_AGENT_0_N_FEATURES];
        int i = 0;
        int level;
        for (level = 0; level < 3; level++) {
            i = (2 * i) + 1 + ((seen[physical_deception_agent_0_feature[i]] <= physical_deception_agent_0_threshold[i]) ? 0 : 1);
        }
        actions[row] = physical_deception_agent_0_action[i - 7];
    }
}

static inline void physical_deception_agent_0_act_columns(const float *const *x, long n, unsigned char *actions)
{
    const float *const x0 = x[PHYSICAL_DECEPTION_AGENT_0_X_GOAL_DX];
    const float *const x2 = x[PHYSICAL_DECEPTION_AGENT_0_X_LANDMARK_0_DX];
    const float *const x3 = x[PHYSICAL_DECEPTION_AGENT_0_X_LANDMARK_0_DY];
    const float *const x9 = x[PHYSICAL_DECEPTION_AGENT_0_X_AGENT_1_DY];
    long first;
    long row;
    /* one select per split, leaves first, each into its own variable: compilers turn this into vector code */
    for (first = 0; first < n; first += 256) {
        float chosen[256];
        const long left = n - first;
        const long count = (left < 256) ? left : 256;
        for (row = 0; row < count; row++) {
            const float n6 = (x2[first + row] <= 0x1.fffffep+127f) ? 0.0f : 0.0f;
            const float n4 = (x9[first + row] <= -0x1.555556p-2f) ? 4.0f : n6;
            const float n1 = (x3[first + row] <= 0x0p+0f) ? 1.0f : 2.0f;
            const float n0 = (x0[first + row] <= 0x1.999998p-4f) ? n1 : n4;
            chosen[row] = n0;
        }
        for (row = 0; row < count; row++) {
            actions[first + row] = (unsigned char)chosen[row];
        }
    }
}

static inline void physical_deception_agent_0_observe(const double *w, float *x)
{
    x[0] = physical_deception_single(physical_deception_sum(w[PHYSICAL_DECEPTION_W_GOAL_X], -w[PHYSICAL_DECEPTION_W_AGENT_0_X]));
    x[1] = physical_deception_single(physical_deception_sum(w[PHYSICAL_DECEPTION_W_GOAL_Y], -w[PHYSICAL_DECEPTION_W_AGENT_0_Y]));
    x[2] = physical_deception_single(physical_deception_sum(w[PHYSICAL_DECEPTION_W_LANDMARK_0_X], -w[PHYSICAL_DECEPTION_W_AGENT_0_X]));
    x[3] = physical_deception_single(physical_deception_sum(w[PHYSICAL_DECEPTION_W_LANDMARK_0_Y], -w[PHYSICAL_DECEPTION_W_AGENT_0_Y]));
    x[4] = physical_deception_single(physical_deception_sum(w[PHYSICAL_DECEPTION_W_LANDMARK_1_X], -w[PHYSICAL_DECEPTION_W_AGENT_0_X]));
    x[5] = physical_deception_single(physical_deception_sum(w[PHYSICAL_DECEPTION_W_LANDMARK_1_Y], -w[PHYSICAL_DECEPTION_W_AGENT_0_Y]));
    x[6] = physical_deception_single(physical_deception_sum(w[PHYSICAL_DECEPTION_W_ADVERSARY_0_X], -w[PHYSICAL_DECEPTION_W_AGENT_0_X]));
    x[7] = physical_deception_single(physical_deception_sum(w[PHYSICAL_DECEPTION_W_ADVERSARY_0_Y], -w[PHYSICAL_DECEPTION_W_AGENT_0_Y]));
    x[8] = physical_deception_single(physical_deception_sum(w[PHYSICAL_DECEPTION_W_AGENT_1_X], -w[PHYSICAL_DECEPTION_W_AGENT_0_X]));
    x[9] = physical_deception_single(physical_deception_sum(w[PHYSICAL_DECEPTION_W_AGENT_1_Y], -w[PHYSICAL_DECEPTION_W_AGENT_0_Y]));
}

static inline int physical_deception_agent_0_act_world(const double *w)
{
    float x[PHYSICAL_DECEPTION_AGENT_0_N_FEATURES];
    physical_deception_agent_0_observe(w, x);
    return physical_deception_agent_0_act(x);
}

/* agent_1, team defenders: 4 leaves, at most 3 comparisons; tables of 43 bytes; 40 bytes of stack for ..._act_world */

enum {
    PHYSICAL_DECEPTION_AGENT_1_X_GOAL_DX = 0, /* length, [-6.3, 6.3]: goal.x - agent_1.x */
    PHYSICAL_DECEPTION_AGENT_1_X_GOAL_DY = 1, /* length, [-6.3, 6.3]: goal.y - agent_1.y */
    PHYSICAL_DECEPTION_AGENT_1_X_LANDMARK_0_DX = 2, /* length, [-6.3, 6.3]: landmark_0.x - agent_1.x */
    PHYSICAL_DECEPTION_AGENT_1_X_LANDMARK_0_DY = 3, /* length, [-6.3, 6.3]: landmark_0.y - agent_1.y */
    PHYSICAL_DECEPTION_AGENT_1_X_LANDMARK_1_DX = 4, /* length, [-6.3, 6.3]: landmark_1.x - agent_1.x */
    PHYSICAL_DECEPTION_AGENT_1_X_LANDMARK_1_DY = 5, /* length, [-6.3, 6.3]: landmark_1.y - agent_1.y */
    PHYSICAL_DECEPTION_AGENT_1_X_ADVERSARY_0_DX = 6, /* length, [-10.6, 10.6]: adversary_0.x - agent_1.x */
    PHYSICAL_DECEPTION_AGENT_1_X_ADVERSARY_0_DY = 7, /* length, [-10.6, 10.6]: adversary_0.y - agent_1.y */
    PHYSICAL_DECEPTION_AGENT_1_X_AGENT_0_DX = 8, /* length, [-10.6, 10.6]: agent_0.x - agent_1.x */
    PHYSICAL_DECEPTION_AGENT_1_X_AGENT_0_DY = 9, /* length, [-10.6, 10.6]: agent_0.y - agent_1.y */
    PHYSICAL_DECEPTION_AGENT_1_N_FEATURES = 10
};

enum {
    PHYSICAL_DECEPTION_AGENT_1_STAY = 0, /* pushes by (0.0, 0.0) */
    PHYSICAL_DECEPTION_AGENT_1_LEFT = 1, /* pushes by (-1.0, 0.0) */
    PHYSICAL_DECEPTION_AGENT_1_RIGHT = 2, /* pushes by (1.0, 0.0) */
    PHYSICAL_DECEPTION_AGENT_1_DOWN = 3, /* pushes by (0.0, -1.0) */
    PHYSICAL_DECEPTION_AGENT_1_UP = 4, /* pushes by (0.0, 1.0) */
    PHYSICAL_DECEPTION_AGENT_1_N_ACTIONS = 5
};

static inline int physical_deception_agent_1_act(const float *x)
{
    int i = 0;
    int level;
    for (level = 0; level < 3; level++) {
        i = (2 * i) + 1 + ((x[physical_deception_agent_1_feature[i]] <= physical_deception_agent_1_threshold[i]) ? 0 : 1);
    }
    return (int)physical_deception_agent_1_action[i - 7];
}

static inline int physical_deception_agent_1_finite(const float *x)
{
    int finite = 1;
    int i;
    for (i = 0; i < PHYSICAL_DECEPTION_AGENT_1_N_FEATURES; i++) {
        if (!((x[i] >= -0x1.fffffep+127f) && (x[i] <= 0x1.fffffep+127f))) {
            finite = 0;
        }
    }
    return finite;
}

static inline int physical_deception_agent_1_in_range(const float *x)
{
    int within = 1;
    if (!((x[0] >= -0x1.933334p+2f) && (x[0] <= 0x1.933334p+2f))) {
        within = 0;
    }
    if (!((x[1] >= -0x1.933334p+2f) && (x[1] <= 0x1.933334p+2f))) {
        within = 0;
    }
    if (!((x[2] >= -0x1.933334p+2f) && (x[2] <= 0x1.933334p+2f))) {
        within = 0;
    }
    if (!((x[3] >= -0x1.933334p+2f) && (x[3] <= 0x1.933334p+2f))) {
        within = 0;
    }
    if (!((x[4] >= -0x1.933334p+2f) && (x[4] <= 0x1.933334p+2f))) {
        within = 0;
    }
    if (!((x[5] >= -0x1.933334p+2f) && (x[5] <= 0x1.933334p+2f))) {
        within = 0;
    }
    if (!((x[6] >= -0x1.533334p+3f) && (x[6] <= 0x1.533334p+3f))) {
        within = 0;
    }
    if (!((x[7] >= -0x1.533334p+3f) && (x[7] <= 0x1.533334p+3f))) {
        within = 0;
    }
    if (!((x[8] >= -0x1.533334p+3f) && (x[8] <= 0x1.533334p+3f))) {
        within = 0;
    }
    if (!((x[9] >= -0x1.533334p+3f) && (x[9] <= 0x1.533334p+3f))) {
        within = 0;
    }
    return within;
}

static inline void physical_deception_agent_1_act_rows(const float *x, long n, unsigned char *actions)
{
    long row;
    /* eight observations side by side, so that none waits for another */
    const long together = n - (n % 8);
    for (row = 0; row < together; row += 8) {
        const float *const seen = &x[row * PHYSICAL_DECEPTION_AGENT_1_N_FEATURES];
        int i[8] = {0, 0, 0, 0, 0, 0, 0, 0};
        int level;
        int k;
        for (level = 0; level < 3; level++) {
            for (k = 0; k < 8; k++) {
                i[k] = (2 * i[k]) + 1 + ((seen[(k * PHYSICAL_DECEPTION_AGENT_1_N_FEATURES) + physical_deception_agent_1_feature[i[k]]] <= physical_deception_agent_1_threshold[i[k]]) ? 0 : 1);
            }
        }
        for (k = 0; k < 8; k++) {
            actions[row + k] = physical_deception_agent_1_action[i[k] - 7];
        }
    }
    for (row = together; row < n; row++) {
        const float *const seen = &x[row * PHYSICAL_DECEPTION_AGENT_1_N_FEATURES];
        int i = 0;
        int level;
        for (level = 0; level < 3; level++) {
            i = (2 * i) + 1 + ((seen[physical_deception_agent_1_feature[i]] <= physical_deception_agent_1_threshold[i]) ? 0 : 1);
        }
        actions[row] = physical_deception_agent_1_action[i - 7];
    }
}

static inline void physical_deception_agent_1_act_columns(const float *const *x, long n, unsigned char *actions)
{
    const float *const x4 = x[PHYSICAL_DECEPTION_AGENT_1_X_LANDMARK_1_DX];
    const float *const x5 = x[PHYSICAL_DECEPTION_AGENT_1_X_LANDMARK_1_DY];
    long first;
    long row;
    /* one select per split, leaves first, each into its own variable: compilers turn this into vector code */
    for (first = 0; first < n; first += 256) {
        float chosen[256];
        const long left = n - first;
        const long count = (left < 256) ? left : 256;
        for (row = 0; row < count; row++) {
            const float n3 = (x5[first + row] <= 0x0p+0f) ? 3.0f : 4.0f;
            const float n2 = (x4[first + row] <= 0x1.99999ap-5f) ? n3 : 2.0f;
            const float n0 = (x4[first + row] <= -0x1.99999ap-5f) ? 1.0f : n2;
            chosen[row] = n0;
        }
        for (row = 0; row < count; row++) {
            actions[first + row] = (unsigned char)chosen[row];
        }
    }
}

static inline void physical_deception_agent_1_observe(const double *w, float *x)
{
    x[0] = physical_deception_single(physical_deception_sum(w[PHYSICAL_DECEPTION_W_GOAL_X], -w[PHYSICAL_DECEPTION_W_AGENT_1_X]));
    x[1] = physical_deception_single(physical_deception_sum(w[PHYSICAL_DECEPTION_W_GOAL_Y], -w[PHYSICAL_DECEPTION_W_AGENT_1_Y]));
    x[2] = physical_deception_single(physical_deception_sum(w[PHYSICAL_DECEPTION_W_LANDMARK_0_X], -w[PHYSICAL_DECEPTION_W_AGENT_1_X]));
    x[3] = physical_deception_single(physical_deception_sum(w[PHYSICAL_DECEPTION_W_LANDMARK_0_Y], -w[PHYSICAL_DECEPTION_W_AGENT_1_Y]));
    x[4] = physical_deception_single(physical_deception_sum(w[PHYSICAL_DECEPTION_W_LANDMARK_1_X], -w[PHYSICAL_DECEPTION_W_AGENT_1_X]));
    x[5] = physical_deception_single(physical_deception_sum(w[PHYSICAL_DECEPTION_W_LANDMARK_1_Y], -w[PHYSICAL_DECEPTION_W_AGENT_1_Y]));
    x[6] = physical_deception_single(physical_deception_sum(w[PHYSICAL_DECEPTION_W_ADVERSARY_0_X], -w[PHYSICAL_DECEPTION_W_AGENT_1_X]));
    x[7] = physical_deception_single(physical_deception_sum(w[PHYSICAL_DECEPTION_W_ADVERSARY_0_Y], -w[PHYSICAL_DECEPTION_W_AGENT_1_Y]));
    x[8] = physical_deception_single(physical_deception_sum(w[PHYSICAL_DECEPTION_W_AGENT_0_X], -w[PHYSICAL_DECEPTION_W_AGENT_1_X]));
    x[9] = physical_deception_single(physical_deception_sum(w[PHYSICAL_DECEPTION_W_AGENT_0_Y], -w[PHYSICAL_DECEPTION_W_AGENT_1_Y]));
}

static inline int physical_deception_agent_1_act_world(const double *w)
{
    float x[PHYSICAL_DECEPTION_AGENT_1_N_FEATURES];
    physical_deception_agent_1_observe(w, x);
    return physical_deception_agent_1_act(x);
}

static inline void physical_deception_act_all(const float *const *x, int *actions)
{
    actions[0] = physical_deception_adversary_0_act(x[0]);
    actions[1] = physical_deception_agent_0_act(x[1]);
    actions[2] = physical_deception_agent_1_act(x[2]);
}

static inline void physical_deception_act_team(const double *w, int *actions)
{
    actions[0] = physical_deception_adversary_0_act_world(w);
    actions[1] = physical_deception_agent_0_act_world(w);
    actions[2] = physical_deception_agent_1_act_world(w);
}

#endif /* PHYSICAL_DECEPTION_D7C7E9951B353C84_H */
