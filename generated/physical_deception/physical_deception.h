/* Decision tree policies of 3 agents for the world physical-deception. Generated: do not edit.
 *
 * profile     a27715e718578d546237e99100a168586463d44b95b222d117df233b9ef66d68
 * made by     maviper 0.1.0, maviper, preset paper, seed 0
 *
 * C99, no heap, no libc, no recursion, no state. For each agent A:
 *   int physical_deception_A_act(const float *x)      the action, from an observation of float32
 *   int physical_deception_A_finite(const float *x)   1 when every number of the observation is finite, else 0
 *
 * A split goes left iff x[feature] <= threshold, both float32, thresholds exact. NaN compares false and so goes right;
 * infinities follow <=. Check untrusted input with ..._finite first.
 */
#ifndef PHYSICAL_DECEPTION_A27715E718578D54_H
#define PHYSICAL_DECEPTION_A27715E718578D54_H

#ifdef __FAST_MATH__
#error "compile without -ffast-math: it changes what comparisons with NaN and tiny numbers mean"
#endif

#define PHYSICAL_DECEPTION_PROFILE "a27715e718578d546237e99100a168586463d44b95b222d117df233b9ef66d68"

/* adversary_0, team adversaries: 16 leaves, at most 4 comparisons */

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
    if (x[PHYSICAL_DECEPTION_ADVERSARY_0_X_AGENT_0_DY] <= 0x1.63f876p-2f) { /* node 0: 0.347627 */
        if (x[PHYSICAL_DECEPTION_ADVERSARY_0_X_LANDMARK_1_DX] <= -0x1.157072p-1f) { /* node 1: -0.541874 */
            if (x[PHYSICAL_DECEPTION_ADVERSARY_0_X_AGENT_1_DY] <= -0x1.72e956p-1f) { /* node 2: -0.724436 */
                if (x[PHYSICAL_DECEPTION_ADVERSARY_0_X_LANDMARK_0_DX] <= -0x1.f9dba2p-3f) { /* node 3: -0.247001 */
                    return PHYSICAL_DECEPTION_ADVERSARY_0_LEFT; /* leaf 4 */
                } else {
                    return PHYSICAL_DECEPTION_ADVERSARY_0_DOWN; /* leaf 5 */
                }
            } else {
                if (x[PHYSICAL_DECEPTION_ADVERSARY_0_X_LANDMARK_1_DY] <= 0x1.1757d2p+0f) { /* node 6: 1.09118 */
                    return PHYSICAL_DECEPTION_ADVERSARY_0_LEFT; /* leaf 7 */
                } else {
                    return PHYSICAL_DECEPTION_ADVERSARY_0_UP; /* leaf 8 */
                }
            }
        } else {
            if (x[PHYSICAL_DECEPTION_ADVERSARY_0_X_LANDMARK_1_DY] <= -0x1.944ddcp-2f) { /* node 9: -0.394828 */
                if (x[PHYSICAL_DECEPTION_ADVERSARY_0_X_LANDMARK_0_DY] <= -0x1.2fb1bp-2f) { /* node 10: -0.296576 */
                    return PHYSICAL_DECEPTION_ADVERSARY_0_DOWN; /* leaf 11 */
                } else {
                    return PHYSICAL_DECEPTION_ADVERSARY_0_DOWN; /* leaf 12 */
                }
            } else {
                if (x[PHYSICAL_DECEPTION_ADVERSARY_0_X_LANDMARK_0_DX] <= 0x1.347e68p-1f) { /* node 13: 0.602527 */
                    return PHYSICAL_DECEPTION_ADVERSARY_0_DOWN; /* leaf 14 */
                } else {
                    return PHYSICAL_DECEPTION_ADVERSARY_0_RIGHT; /* leaf 15 */
                }
            }
        }
    } else {
        if (x[PHYSICAL_DECEPTION_ADVERSARY_0_X_LANDMARK_1_DX] <= 0x1.69d13ep-1f) { /* node 16: 0.706675 */
            if (x[PHYSICAL_DECEPTION_ADVERSARY_0_X_LANDMARK_0_DY] <= 0x1.51083cp-1f) { /* node 17: 0.658266 */
                if (x[PHYSICAL_DECEPTION_ADVERSARY_0_X_AGENT_0_DX] <= -0x1.5a89a4p-2f) { /* node 18: -0.338416 */
                    return PHYSICAL_DECEPTION_ADVERSARY_0_LEFT; /* leaf 19 */
                } else {
                    return PHYSICAL_DECEPTION_ADVERSARY_0_UP; /* leaf 20 */
                }
            } else {
                if (x[PHYSICAL_DECEPTION_ADVERSARY_0_X_LANDMARK_0_DX] <= -0x1.243a66p+0f) { /* node 21: -1.14152 */
                    return PHYSICAL_DECEPTION_ADVERSARY_0_LEFT; /* leaf 22 */
                } else {
                    return PHYSICAL_DECEPTION_ADVERSARY_0_UP; /* leaf 23 */
                }
            }
        } else {
            if (x[PHYSICAL_DECEPTION_ADVERSARY_0_X_LANDMARK_0_DY] <= 0x1.db755ap-1f) { /* node 24: 0.92863 */
                if (x[PHYSICAL_DECEPTION_ADVERSARY_0_X_AGENT_0_DY] <= 0x1.6b5c76p-2f) { /* node 25: 0.354845 */
                    return PHYSICAL_DECEPTION_ADVERSARY_0_UP; /* leaf 26 */
                } else {
                    return PHYSICAL_DECEPTION_ADVERSARY_0_RIGHT; /* leaf 27 */
                }
            } else {
                if (x[PHYSICAL_DECEPTION_ADVERSARY_0_X_AGENT_1_DX] <= 0x1.6b605ep-1f) { /* node 28: 0.70972 */
                    return PHYSICAL_DECEPTION_ADVERSARY_0_UP; /* leaf 29 */
                } else {
                    return PHYSICAL_DECEPTION_ADVERSARY_0_RIGHT; /* leaf 30 */
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

/* agent_0, team defenders: 16 leaves, at most 4 comparisons */

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
    if (x[PHYSICAL_DECEPTION_AGENT_0_X_LANDMARK_0_DY] <= -0x1.52160ep-5f) { /* node 0: -0.0412703 */
        if (x[PHYSICAL_DECEPTION_AGENT_0_X_LANDMARK_0_DX] <= 0x1.de4decp-3f) { /* node 1: 0.233547 */
            if (x[PHYSICAL_DECEPTION_AGENT_0_X_LANDMARK_0_DX] <= -0x1.e6dc5ep-3f) { /* node 2: -0.237725 */
                if (x[PHYSICAL_DECEPTION_AGENT_0_X_LANDMARK_0_DY] <= -0x1.b6c192p-2f) { /* node 3: -0.428473 */
                    return PHYSICAL_DECEPTION_AGENT_0_DOWN; /* leaf 4 */
                } else {
                    return PHYSICAL_DECEPTION_AGENT_0_LEFT; /* leaf 5 */
                }
            } else {
                if (x[PHYSICAL_DECEPTION_AGENT_0_X_LANDMARK_0_DY] <= -0x1.263716p-3f) { /* node 6: -0.14366 */
                    return PHYSICAL_DECEPTION_AGENT_0_DOWN; /* leaf 7 */
                } else {
                    return PHYSICAL_DECEPTION_AGENT_0_DOWN; /* leaf 8 */
                }
            }
        } else {
            if (x[PHYSICAL_DECEPTION_AGENT_0_X_LANDMARK_0_DX] <= 0x1.3631b2p-1f) { /* node 9: 0.605848 */
                if (x[PHYSICAL_DECEPTION_AGENT_0_X_LANDMARK_0_DY] <= -0x1.2bec7cp-2f) { /* node 10: -0.292894 */
                    return PHYSICAL_DECEPTION_AGENT_0_DOWN; /* leaf 11 */
                } else {
                    return PHYSICAL_DECEPTION_AGENT_0_RIGHT; /* leaf 12 */
                }
            } else {
                if (x[PHYSICAL_DECEPTION_AGENT_0_X_GOAL_DY] <= -0x1.362542p+0f) { /* node 13: -1.21151 */
                    return PHYSICAL_DECEPTION_AGENT_0_DOWN; /* leaf 14 */
                } else {
                    return PHYSICAL_DECEPTION_AGENT_0_RIGHT; /* leaf 15 */
                }
            }
        }
    } else {
        if (x[PHYSICAL_DECEPTION_AGENT_0_X_LANDMARK_0_DX] <= 0x1.93c616p-3f) { /* node 16: 0.197155 */
            if (x[PHYSICAL_DECEPTION_AGENT_0_X_LANDMARK_0_DX] <= -0x1.895cb4p-3f) { /* node 17: -0.192071 */
                if (x[PHYSICAL_DECEPTION_AGENT_0_X_LANDMARK_0_DY] <= 0x1.58f2ccp-1f) { /* node 18: 0.673727 */
                    return PHYSICAL_DECEPTION_AGENT_0_LEFT; /* leaf 19 */
                } else {
                    return PHYSICAL_DECEPTION_AGENT_0_UP; /* leaf 20 */
                }
            } else {
                if (x[PHYSICAL_DECEPTION_AGENT_0_X_LANDMARK_0_DY] <= 0x1.6b17aep-4f) { /* node 21: 0.0886456 */
                    return PHYSICAL_DECEPTION_AGENT_0_UP; /* leaf 22 */
                } else {
                    return PHYSICAL_DECEPTION_AGENT_0_UP; /* leaf 23 */
                }
            }
        } else {
            if (x[PHYSICAL_DECEPTION_AGENT_0_X_LANDMARK_0_DY] <= 0x1.f837a6p-3f) { /* node 24: 0.2462 */
                if (x[PHYSICAL_DECEPTION_AGENT_0_X_LANDMARK_0_DX] <= 0x1.222b44p-2f) { /* node 25: 0.283368 */
                    return PHYSICAL_DECEPTION_AGENT_0_RIGHT; /* leaf 26 */
                } else {
                    return PHYSICAL_DECEPTION_AGENT_0_RIGHT; /* leaf 27 */
                }
            } else {
                if (x[PHYSICAL_DECEPTION_AGENT_0_X_LANDMARK_0_DX] <= 0x1.43d682p-1f) { /* node 28: 0.632496 */
                    return PHYSICAL_DECEPTION_AGENT_0_UP; /* leaf 29 */
                } else {
                    return PHYSICAL_DECEPTION_AGENT_0_RIGHT; /* leaf 30 */
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

/* agent_1, team defenders: 16 leaves, at most 4 comparisons */

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
    if (x[PHYSICAL_DECEPTION_AGENT_1_X_LANDMARK_1_DX] <= -0x1.ddadfap-4f) { /* node 0: -0.116621 */
        if (x[PHYSICAL_DECEPTION_AGENT_1_X_LANDMARK_1_DY] <= 0x1.36c47cp-3f) { /* node 1: 0.151742 */
            if (x[PHYSICAL_DECEPTION_AGENT_1_X_LANDMARK_1_DY] <= -0x1.a4aa48p-3f) { /* node 2: -0.205403 */
                if (x[PHYSICAL_DECEPTION_AGENT_1_X_LANDMARK_1_DX] <= -0x1.71d20cp-2f) { /* node 3: -0.361153 */
                    return PHYSICAL_DECEPTION_AGENT_1_LEFT; /* leaf 4 */
                } else {
                    return PHYSICAL_DECEPTION_AGENT_1_DOWN; /* leaf 5 */
                }
            } else {
                if (x[PHYSICAL_DECEPTION_AGENT_1_X_ADVERSARY_0_DX] <= 0x1.74d392p-4f) { /* node 6: 0.0910221 */
                    return PHYSICAL_DECEPTION_AGENT_1_LEFT; /* leaf 7 */
                } else {
                    return PHYSICAL_DECEPTION_AGENT_1_LEFT; /* leaf 8 */
                }
            }
        } else {
            if (x[PHYSICAL_DECEPTION_AGENT_1_X_LANDMARK_1_DX] <= -0x1.861fdp-2f) { /* node 9: -0.380981 */
                if (x[PHYSICAL_DECEPTION_AGENT_1_X_LANDMARK_1_DY] <= 0x1.174a9cp-1f) { /* node 10: 0.545491 */
                    return PHYSICAL_DECEPTION_AGENT_1_LEFT; /* leaf 11 */
                } else {
                    return PHYSICAL_DECEPTION_AGENT_1_UP; /* leaf 12 */
                }
            } else {
                if (x[PHYSICAL_DECEPTION_AGENT_1_X_LANDMARK_1_DY] <= 0x1.148748p-2f) { /* node 13: 0.270047 */
                    return PHYSICAL_DECEPTION_AGENT_1_UP; /* leaf 14 */
                } else {
                    return PHYSICAL_DECEPTION_AGENT_1_UP; /* leaf 15 */
                }
            }
        }
    } else {
        if (x[PHYSICAL_DECEPTION_AGENT_1_X_LANDMARK_1_DY] <= 0x1.3be7a8p-4f) { /* node 16: 0.0771252 */
            if (x[PHYSICAL_DECEPTION_AGENT_1_X_LANDMARK_1_DX] <= 0x1.06bb86p-3f) { /* node 17: 0.128287 */
                if (x[PHYSICAL_DECEPTION_AGENT_1_X_LANDMARK_1_DY] <= -0x1.9a277cp-4f) { /* node 18: -0.100135 */
                    return PHYSICAL_DECEPTION_AGENT_1_DOWN; /* leaf 19 */
                } else {
                    return PHYSICAL_DECEPTION_AGENT_1_RIGHT; /* leaf 20 */
                }
            } else {
                if (x[PHYSICAL_DECEPTION_AGENT_1_X_LANDMARK_1_DY] <= -0x1.cdc5ecp-3f) { /* node 21: -0.225475 */
                    return PHYSICAL_DECEPTION_AGENT_1_RIGHT; /* leaf 22 */
                } else {
                    return PHYSICAL_DECEPTION_AGENT_1_RIGHT; /* leaf 23 */
                }
            }
        } else {
            if (x[PHYSICAL_DECEPTION_AGENT_1_X_LANDMARK_1_DX] <= 0x1.6eb53p-3f) { /* node 24: 0.179057 */
                if (x[PHYSICAL_DECEPTION_AGENT_1_X_GOAL_DX] <= -0x1.815536p+0f) { /* node 25: -1.50521 */
                    return PHYSICAL_DECEPTION_AGENT_1_RIGHT; /* leaf 26 */
                } else {
                    return PHYSICAL_DECEPTION_AGENT_1_UP; /* leaf 27 */
                }
            } else {
                if (x[PHYSICAL_DECEPTION_AGENT_1_X_LANDMARK_1_DY] <= 0x1.43699p-1f) { /* node 28: 0.631665 */
                    return PHYSICAL_DECEPTION_AGENT_1_RIGHT; /* leaf 29 */
                } else {
                    return PHYSICAL_DECEPTION_AGENT_1_UP; /* leaf 30 */
                }
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

#endif /* PHYSICAL_DECEPTION_A27715E718578D54_H */
