/* Decision tree policies of 3 agents for the world physical-deception. Generated: do not edit.
 *
 * profile     e211f345166706452eb3d8a90b6927f886f2b2421f373afddae9e3e0ed1c9b58
 * made by     maviper 0.1.0, maviper, preset default, seed 0
 *
 * C99, no heap, no libc, no recursion, no state. For each agent A:
 *   int physical_deception_A_act(const float *x)      the action, from an observation of float32
 *   int physical_deception_A_finite(const float *x)   1 when every number of the observation is finite, else 0
 *
 * A split goes left iff x[feature] <= threshold, both float32, thresholds exact. NaN compares false and so goes right;
 * infinities follow <=. Check untrusted input with ..._finite first.
 */
#ifndef PHYSICAL_DECEPTION_E211F34516670645_H
#define PHYSICAL_DECEPTION_E211F34516670645_H

#ifdef __FAST_MATH__
#error "compile without -ffast-math: it changes what comparisons with NaN and tiny numbers mean"
#endif

#define PHYSICAL_DECEPTION_PROFILE "e211f345166706452eb3d8a90b6927f886f2b2421f373afddae9e3e0ed1c9b58"

/* adversary_0, team adversaries: 15 leaves, at most 4 comparisons */

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
    if (x[PHYSICAL_DECEPTION_ADVERSARY_0_X_AGENT_0_DX] <= 0x1.c1e8aep-2f) { /* node 0: 0.439364 */
        if (x[PHYSICAL_DECEPTION_ADVERSARY_0_X_AGENT_0_DY] <= 0x1.71283ep-1f) { /* node 1: 0.72101 */
            if (x[PHYSICAL_DECEPTION_ADVERSARY_0_X_AGENT_1_DY] <= 0x1.c270b6p-2f) { /* node 2: 0.439883 */
                if (x[PHYSICAL_DECEPTION_ADVERSARY_0_X_LANDMARK_1_DX] <= -0x1.6c7296p-2f) { /* node 3: -0.355906 */
                    return PHYSICAL_DECEPTION_ADVERSARY_0_LEFT; /* leaf 4 */
                } else {
                    return PHYSICAL_DECEPTION_ADVERSARY_0_DOWN; /* leaf 5 */
                }
            } else {
                if (x[PHYSICAL_DECEPTION_ADVERSARY_0_X_AGENT_1_DX] <= -0x1.2530e2p-1f) { /* node 6: -0.572639 */
                    return PHYSICAL_DECEPTION_ADVERSARY_0_LEFT; /* leaf 7 */
                } else {
                    return PHYSICAL_DECEPTION_ADVERSARY_0_UP; /* leaf 8 */
                }
            }
        } else {
            if (x[PHYSICAL_DECEPTION_ADVERSARY_0_X_LANDMARK_1_DX] <= 0x1.b40be8p-1f) { /* node 9: 0.851653 */
                if (x[PHYSICAL_DECEPTION_ADVERSARY_0_X_AGENT_0_DX] <= -0x1.342e5p+0f) { /* node 10: -1.20383 */
                    return PHYSICAL_DECEPTION_ADVERSARY_0_LEFT; /* leaf 11 */
                } else {
                    return PHYSICAL_DECEPTION_ADVERSARY_0_UP; /* leaf 12 */
                }
            } else {
                if (x[PHYSICAL_DECEPTION_ADVERSARY_0_X_AGENT_1_DY] <= 0x1.46e6c4p-3f) { /* node 13: 0.15962 */
                    return PHYSICAL_DECEPTION_ADVERSARY_0_RIGHT; /* leaf 14 */
                } else {
                    return PHYSICAL_DECEPTION_ADVERSARY_0_UP; /* leaf 15 */
                }
            }
        }
    } else {
        if (x[PHYSICAL_DECEPTION_ADVERSARY_0_X_LANDMARK_0_DY] <= -0x1.5aa9cap-1f) { /* node 16: -0.677077 */
            if (x[PHYSICAL_DECEPTION_ADVERSARY_0_X_AGENT_1_DX] <= 0x1.bd6d3p-5f) { /* node 17: 0.0543734 */
                if (x[PHYSICAL_DECEPTION_ADVERSARY_0_X_LANDMARK_1_DX] <= -0x1.91bccap-1f) { /* node 18: -0.784643 */
                    return PHYSICAL_DECEPTION_ADVERSARY_0_LEFT; /* leaf 19 */
                } else {
                    return PHYSICAL_DECEPTION_ADVERSARY_0_DOWN; /* leaf 20 */
                }
            } else {
                if (x[PHYSICAL_DECEPTION_ADVERSARY_0_X_LANDMARK_1_DY] <= 0x1.86d9fp-2f) { /* node 21: 0.381691 */
                    return PHYSICAL_DECEPTION_ADVERSARY_0_RIGHT; /* leaf 22 */
                } else {
                    return PHYSICAL_DECEPTION_ADVERSARY_0_UP; /* leaf 23 */
                }
            }
        } else {
            if (x[PHYSICAL_DECEPTION_ADVERSARY_0_X_LANDMARK_0_DY] <= 0x1.50c096p-1f) { /* node 24: 0.657719 */
                return PHYSICAL_DECEPTION_ADVERSARY_0_RIGHT; /* leaf 25 */
            } else {
                if (x[PHYSICAL_DECEPTION_ADVERSARY_0_X_LANDMARK_1_DX] <= 0x1.79919ep-1f) { /* node 26: 0.737439 */
                    return PHYSICAL_DECEPTION_ADVERSARY_0_UP; /* leaf 27 */
                } else {
                    return PHYSICAL_DECEPTION_ADVERSARY_0_RIGHT; /* leaf 28 */
                }
            }
        }
    }
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

/* agent_0, team defenders: 12 leaves, at most 4 comparisons */

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
    if (x[PHYSICAL_DECEPTION_AGENT_0_X_LANDMARK_0_DY] <= -0x1.3a4392p-6f) { /* node 0: -0.0191811 */
        if (x[PHYSICAL_DECEPTION_AGENT_0_X_LANDMARK_0_DX] <= 0x1.09afap-2f) { /* node 1: 0.259459 */
            if (x[PHYSICAL_DECEPTION_AGENT_0_X_LANDMARK_0_DX] <= -0x1.ce136p-3f) { /* node 2: -0.225623 */
                if (x[PHYSICAL_DECEPTION_AGENT_0_X_LANDMARK_0_DY] <= -0x1.b21d1cp-2f) { /* node 3: -0.423939 */
                    return PHYSICAL_DECEPTION_AGENT_0_DOWN; /* leaf 4 */
                } else {
                    return PHYSICAL_DECEPTION_AGENT_0_LEFT; /* leaf 5 */
                }
            } else {
                return PHYSICAL_DECEPTION_AGENT_0_DOWN; /* leaf 6 */
            }
        } else {
            if (x[PHYSICAL_DECEPTION_AGENT_0_X_LANDMARK_0_DY] <= -0x1.308222p-1f) { /* node 7: -0.594743 */
                if (x[PHYSICAL_DECEPTION_AGENT_0_X_LANDMARK_0_DX] <= 0x1.e5efb2p-1f) { /* node 8: 0.949094 */
                    return PHYSICAL_DECEPTION_AGENT_0_DOWN; /* leaf 9 */
                } else {
                    return PHYSICAL_DECEPTION_AGENT_0_RIGHT; /* leaf 10 */
                }
            } else {
                return PHYSICAL_DECEPTION_AGENT_0_RIGHT; /* leaf 11 */
            }
        }
    } else {
        if (x[PHYSICAL_DECEPTION_AGENT_0_X_LANDMARK_0_DX] <= 0x1.b3bd56p-3f) { /* node 12: 0.212763 */
            if (x[PHYSICAL_DECEPTION_AGENT_0_X_LANDMARK_0_DX] <= -0x1.5d66e4p-3f) { /* node 13: -0.170606 */
                if (x[PHYSICAL_DECEPTION_AGENT_0_X_LANDMARK_0_DY] <= 0x1.692ddap-1f) { /* node 14: 0.705428 */
                    return PHYSICAL_DECEPTION_AGENT_0_LEFT; /* leaf 15 */
                } else {
                    return PHYSICAL_DECEPTION_AGENT_0_UP; /* leaf 16 */
                }
            } else {
                return PHYSICAL_DECEPTION_AGENT_0_UP; /* leaf 17 */
            }
        } else {
            if (x[PHYSICAL_DECEPTION_AGENT_0_X_LANDMARK_0_DY] <= 0x1.b6319ep-2f) { /* node 18: 0.427924 */
                return PHYSICAL_DECEPTION_AGENT_0_RIGHT; /* leaf 19 */
            } else {
                if (x[PHYSICAL_DECEPTION_AGENT_0_X_LANDMARK_0_DX] <= 0x1.61ad88p-1f) { /* node 20: 0.690777 */
                    return PHYSICAL_DECEPTION_AGENT_0_UP; /* leaf 21 */
                } else {
                    return PHYSICAL_DECEPTION_AGENT_0_RIGHT; /* leaf 22 */
                }
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

/* agent_1, team defenders: 13 leaves, at most 4 comparisons */

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
    if (x[PHYSICAL_DECEPTION_AGENT_1_X_LANDMARK_1_DX] <= 0x1.6c8436p-3f) { /* node 0: 0.177987 */
        if (x[PHYSICAL_DECEPTION_AGENT_1_X_LANDMARK_1_DY] <= -0x1.20050ap-4f) { /* node 1: -0.0703173 */
            if (x[PHYSICAL_DECEPTION_AGENT_1_X_LANDMARK_1_DX] <= -0x1.07c544p-2f) { /* node 2: -0.257588 */
                if (x[PHYSICAL_DECEPTION_AGENT_1_X_LANDMARK_1_DY] <= -0x1.7531aep-1f) { /* node 3: -0.728895 */
                    return PHYSICAL_DECEPTION_AGENT_1_DOWN; /* leaf 4 */
                } else {
                    return PHYSICAL_DECEPTION_AGENT_1_LEFT; /* leaf 5 */
                }
            } else {
                return PHYSICAL_DECEPTION_AGENT_1_DOWN; /* leaf 6 */
            }
        } else {
            if (x[PHYSICAL_DECEPTION_AGENT_1_X_LANDMARK_1_DX] <= -0x1.10e0f4p-3f) { /* node 7: -0.133242 */
                if (x[PHYSICAL_DECEPTION_AGENT_1_X_LANDMARK_1_DY] <= 0x1.0f966ap-1f) { /* node 8: 0.530444 */
                    return PHYSICAL_DECEPTION_AGENT_1_LEFT; /* leaf 9 */
                } else {
                    return PHYSICAL_DECEPTION_AGENT_1_UP; /* leaf 10 */
                }
            } else {
                if (x[PHYSICAL_DECEPTION_AGENT_1_X_LANDMARK_1_DY] <= 0x1.35fe34p-4f) { /* node 11: 0.0756819 */
                    return PHYSICAL_DECEPTION_AGENT_1_STAY; /* leaf 12 */
                } else {
                    return PHYSICAL_DECEPTION_AGENT_1_UP; /* leaf 13 */
                }
            }
        }
    } else {
        if (x[PHYSICAL_DECEPTION_AGENT_1_X_LANDMARK_1_DY] <= 0x1.fe2a84p-1f) { /* node 14: 0.996418 */
            if (x[PHYSICAL_DECEPTION_AGENT_1_X_LANDMARK_1_DX] <= 0x1.144d04p-2f) { /* node 15: 0.269825 */
                if (x[PHYSICAL_DECEPTION_AGENT_1_X_LANDMARK_1_DY] <= -0x1.e44826p-3f) { /* node 16: -0.236466 */
                    return PHYSICAL_DECEPTION_AGENT_1_DOWN; /* leaf 17 */
                } else {
                    return PHYSICAL_DECEPTION_AGENT_1_RIGHT; /* leaf 18 */
                }
            } else {
                if (x[PHYSICAL_DECEPTION_AGENT_1_X_LANDMARK_0_DY] <= 0x1.ad4dd4p+0f) { /* node 19: 1.67697 */
                    return PHYSICAL_DECEPTION_AGENT_1_RIGHT; /* leaf 20 */
                } else {
                    return PHYSICAL_DECEPTION_AGENT_1_UP; /* leaf 21 */
                }
            }
        } else {
            if (x[PHYSICAL_DECEPTION_AGENT_1_X_GOAL_DX] <= 0x1.09743cp+0f) { /* node 22: 1.03693 */
                return PHYSICAL_DECEPTION_AGENT_1_UP; /* leaf 23 */
            } else {
                return PHYSICAL_DECEPTION_AGENT_1_RIGHT; /* leaf 24 */
            }
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

#endif /* PHYSICAL_DECEPTION_E211F34516670645_H */
