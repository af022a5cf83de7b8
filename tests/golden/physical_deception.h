/* Decision tree policies of 3 agents for the world physical-deception. Generated: do not edit.
 *
 * profile     d7c7e9951b353c845e3729dfb7383e9f94192c6dfd621196d4fd4879d989808d
 * made by     tests, hand-made, preset none, seed 0
 *
 * C99, no heap, no libc, no recursion, no state. For each agent A:
 *   int physical_deception_A_act(const float *x)      the action, from an observation of float32
 *   int physical_deception_A_finite(const float *x)   1 when every number of the observation is finite, else 0
 *
 * A split goes left iff x[feature] <= threshold, both float32, thresholds exact. NaN compares false and so goes right;
 * infinities follow <=. Check untrusted input with ..._finite first.
 */
#ifndef PHYSICAL_DECEPTION_D7C7E9951B353C84_H
#define PHYSICAL_DECEPTION_D7C7E9951B353C84_H

#ifdef __FAST_MATH__
#error "compile without -ffast-math: it changes what comparisons with NaN and tiny numbers mean"
#endif

#define PHYSICAL_DECEPTION_PROFILE "d7c7e9951b353c845e3729dfb7383e9f94192c6dfd621196d4fd4879d989808d"

/* adversary_0, team adversaries: 1 leaves, at most 0 comparisons */

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
    PHYSICAL_DECEPTION_ADVERSARY_0_STAY = 0,
    PHYSICAL_DECEPTION_ADVERSARY_0_LEFT = 1,
    PHYSICAL_DECEPTION_ADVERSARY_0_RIGHT = 2,
    PHYSICAL_DECEPTION_ADVERSARY_0_DOWN = 3,
    PHYSICAL_DECEPTION_ADVERSARY_0_UP = 4,
    PHYSICAL_DECEPTION_ADVERSARY_0_N_ACTIONS = 5
};

static inline int physical_deception_adversary_0_act(const float *x)
{
    (void)x;
    return PHYSICAL_DECEPTION_ADVERSARY_0_STAY; /* leaf 0 */
}

static inline int physical_deception_adversary_0_finite(const float *x)
{
    int i;
    for (i = 0; i < PHYSICAL_DECEPTION_ADVERSARY_0_N_FEATURES; i++) {
        if (!(x[i] >= -0x1.fffffep+127f && x[i] <= 0x1.fffffep+127f)) {
            return 0;
        }
    }
    return 1;
}

/* agent_0, team defenders: 5 leaves, at most 3 comparisons */

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
    PHYSICAL_DECEPTION_AGENT_0_STAY = 0,
    PHYSICAL_DECEPTION_AGENT_0_LEFT = 1,
    PHYSICAL_DECEPTION_AGENT_0_RIGHT = 2,
    PHYSICAL_DECEPTION_AGENT_0_DOWN = 3,
    PHYSICAL_DECEPTION_AGENT_0_UP = 4,
    PHYSICAL_DECEPTION_AGENT_0_N_ACTIONS = 5
};

static inline int physical_deception_agent_0_act(const float *x)
{
    if (x[PHYSICAL_DECEPTION_AGENT_0_X_GOAL_DX] <= 0x1.999998p-4f) { /* node 0: 0.1 */
        if (x[PHYSICAL_DECEPTION_AGENT_0_X_LANDMARK_0_DY] <= 0x0p+0f) { /* node 1: 0 */
            return PHYSICAL_DECEPTION_AGENT_0_LEFT; /* leaf 2 */
        } else {
            return PHYSICAL_DECEPTION_AGENT_0_RIGHT; /* leaf 3 */
        }
    } else {
        if (x[PHYSICAL_DECEPTION_AGENT_0_X_AGENT_1_DY] <= -0x1.555556p-2f) { /* node 4: -0.333333 */
            return PHYSICAL_DECEPTION_AGENT_0_UP; /* leaf 5 */
        } else {
            if (x[PHYSICAL_DECEPTION_AGENT_0_X_LANDMARK_0_DX] <= 0x1.fffffep+127f) { /* node 6: 3.40282e+38 */
                return PHYSICAL_DECEPTION_AGENT_0_STAY; /* leaf 7 */
            } else {
                return PHYSICAL_DECEPTION_AGENT_0_STAY; /* leaf 8 */
            }
        }
    }
}

static inline int physical_deception_agent_0_finite(const float *x)
{
    int i;
    for (i = 0; i < PHYSICAL_DECEPTION_AGENT_0_N_FEATURES; i++) {
        if (!(x[i] >= -0x1.fffffep+127f && x[i] <= 0x1.fffffep+127f)) {
            return 0;
        }
    }
    return 1;
}

/* agent_1, team defenders: 4 leaves, at most 3 comparisons */

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
    PHYSICAL_DECEPTION_AGENT_1_STAY = 0,
    PHYSICAL_DECEPTION_AGENT_1_LEFT = 1,
    PHYSICAL_DECEPTION_AGENT_1_RIGHT = 2,
    PHYSICAL_DECEPTION_AGENT_1_DOWN = 3,
    PHYSICAL_DECEPTION_AGENT_1_UP = 4,
    PHYSICAL_DECEPTION_AGENT_1_N_ACTIONS = 5
};

static inline int physical_deception_agent_1_act(const float *x)
{
    if (x[PHYSICAL_DECEPTION_AGENT_1_X_LANDMARK_1_DX] <= -0x1.99999ap-5f) { /* node 0: -0.05 */
        return PHYSICAL_DECEPTION_AGENT_1_LEFT; /* leaf 1 */
    } else {
        if (x[PHYSICAL_DECEPTION_AGENT_1_X_LANDMARK_1_DX] <= 0x1.99999ap-5f) { /* node 2: 0.05 */
            if (x[PHYSICAL_DECEPTION_AGENT_1_X_LANDMARK_1_DY] <= 0x0p+0f) { /* node 3: 0 */
                return PHYSICAL_DECEPTION_AGENT_1_DOWN; /* leaf 4 */
            } else {
                return PHYSICAL_DECEPTION_AGENT_1_UP; /* leaf 5 */
            }
        } else {
            return PHYSICAL_DECEPTION_AGENT_1_RIGHT; /* leaf 6 */
        }
    }
}

static inline int physical_deception_agent_1_finite(const float *x)
{
    int i;
    for (i = 0; i < PHYSICAL_DECEPTION_AGENT_1_N_FEATURES; i++) {
        if (!(x[i] >= -0x1.fffffep+127f && x[i] <= 0x1.fffffep+127f)) {
            return 0;
        }
    }
    return 1;
}

#endif /* PHYSICAL_DECEPTION_D7C7E9951B353C84_H */
