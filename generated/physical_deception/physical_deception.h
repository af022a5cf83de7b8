/* Decision tree policies of 3 agents for the world physical-deception. Generated: do not edit.
 *
 * profile     492c3f7d7f8e3d05241ad5186d96513b2eca15b3543afe2d19b9bb9876d1fd2d
 * made by     maviper 0.1.0, maviper, preset paper, seed 0
 *
 * C99, no heap, no libc, no recursion, no state. For each agent A:
 *   int physical_deception_A_act(const float *x)      the action, from an observation of float32
 *   int physical_deception_A_finite(const float *x)   1 when every number of the observation is finite, else 0
 *
 * A split goes left iff x[feature] <= threshold, both float32, thresholds exact. NaN compares false and so goes right;
 * infinities follow <=. Check untrusted input with ..._finite first.
 */
#ifndef PHYSICAL_DECEPTION_492C3F7D7F8E3D05_H
#define PHYSICAL_DECEPTION_492C3F7D7F8E3D05_H

#ifdef __FAST_MATH__
#error "compile without -ffast-math: it changes what comparisons with NaN and tiny numbers mean"
#endif

#define PHYSICAL_DECEPTION_PROFILE "492c3f7d7f8e3d05241ad5186d96513b2eca15b3543afe2d19b9bb9876d1fd2d"

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
    if (x[PHYSICAL_DECEPTION_ADVERSARY_0_X_LANDMARK_0_DX] <= -0x1.43243ep-3f) { /* node 0: -0.157784 */
        if (x[PHYSICAL_DECEPTION_ADVERSARY_0_X_LANDMARK_1_DX] <= 0x1.04f026p-3f) { /* node 1: 0.127411 */
            if (x[PHYSICAL_DECEPTION_ADVERSARY_0_X_LANDMARK_0_DY] <= -0x1.31ca34p+0f) { /* node 2: -1.19449 */
                if (x[PHYSICAL_DECEPTION_ADVERSARY_0_X_LANDMARK_1_DX] <= -0x1.3f33eep-1f) { /* node 3: -0.623443 */
                    return PHYSICAL_DECEPTION_ADVERSARY_0_LEFT; /* leaf 4 */
                } else {
                    return PHYSICAL_DECEPTION_ADVERSARY_0_DOWN; /* leaf 5 */
                }
            } else {
                if (x[PHYSICAL_DECEPTION_ADVERSARY_0_X_LANDMARK_1_DY] <= 0x1.96d54cp-1f) { /* node 6: 0.794596 */
                    return PHYSICAL_DECEPTION_ADVERSARY_0_LEFT; /* leaf 7 */
                } else {
                    return PHYSICAL_DECEPTION_ADVERSARY_0_UP; /* leaf 8 */
                }
            }
        } else {
            if (x[PHYSICAL_DECEPTION_ADVERSARY_0_X_LANDMARK_0_DY] <= -0x1.f2f0a2p-2f) { /* node 9: -0.487246 */
                if (x[PHYSICAL_DECEPTION_ADVERSARY_0_X_LANDMARK_1_DY] <= 0x1.3d6cfp-1f) { /* node 10: 0.619972 */
                    return PHYSICAL_DECEPTION_ADVERSARY_0_DOWN; /* leaf 11 */
                } else {
                    return PHYSICAL_DECEPTION_ADVERSARY_0_RIGHT; /* leaf 12 */
                }
            } else {
                if (x[PHYSICAL_DECEPTION_ADVERSARY_0_X_LANDMARK_0_DY] <= 0x1.685566p-1f) { /* node 13: 0.703777 */
                    return PHYSICAL_DECEPTION_ADVERSARY_0_LEFT; /* leaf 14 */
                } else {
                    return PHYSICAL_DECEPTION_ADVERSARY_0_UP; /* leaf 15 */
                }
            }
        }
    } else {
        if (x[PHYSICAL_DECEPTION_ADVERSARY_0_X_LANDMARK_1_DX] <= -0x1.0ec7e6p-5f) { /* node 16: -0.0330543 */
            if (x[PHYSICAL_DECEPTION_ADVERSARY_0_X_LANDMARK_1_DY] <= -0x1.0f4232p-2f) { /* node 17: -0.264901 */
                if (x[PHYSICAL_DECEPTION_ADVERSARY_0_X_AGENT_0_DY] <= 0x1.4d39eep-2f) { /* node 18: 0.325416 */
                    return PHYSICAL_DECEPTION_ADVERSARY_0_DOWN; /* leaf 19 */
                } else {
                    return PHYSICAL_DECEPTION_ADVERSARY_0_LEFT; /* leaf 20 */
                }
            } else {
                if (x[PHYSICAL_DECEPTION_ADVERSARY_0_X_LANDMARK_0_DY] <= 0x1.712bcep-4f) { /* node 21: 0.0901297 */
                    return PHYSICAL_DECEPTION_ADVERSARY_0_LEFT; /* leaf 22 */
                } else {
                    return PHYSICAL_DECEPTION_ADVERSARY_0_UP; /* leaf 23 */
                }
            }
        } else {
            if (x[PHYSICAL_DECEPTION_ADVERSARY_0_X_LANDMARK_0_DY] <= -0x1.867f6ep-2f) { /* node 24: -0.381345 */
                if (x[PHYSICAL_DECEPTION_ADVERSARY_0_X_LANDMARK_0_DX] <= 0x1.65bb36p-2f) { /* node 25: 0.349347 */
                    return PHYSICAL_DECEPTION_ADVERSARY_0_DOWN; /* leaf 26 */
                } else {
                    return PHYSICAL_DECEPTION_ADVERSARY_0_RIGHT; /* leaf 27 */
                }
            } else {
                if (x[PHYSICAL_DECEPTION_ADVERSARY_0_X_LANDMARK_1_DY] <= 0x1.9b0306p-1f) { /* node 28: 0.802757 */
                    return PHYSICAL_DECEPTION_ADVERSARY_0_RIGHT; /* leaf 29 */
                } else {
                    return PHYSICAL_DECEPTION_ADVERSARY_0_UP; /* leaf 30 */
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
    if (x[PHYSICAL_DECEPTION_AGENT_0_X_LANDMARK_0_DX] <= 0x1.2745d8p-3f) { /* node 0: 0.144176 */
        if (x[PHYSICAL_DECEPTION_AGENT_0_X_LANDMARK_0_DY] <= 0x1.06511cp-3f) { /* node 1: 0.128084 */
            if (x[PHYSICAL_DECEPTION_AGENT_0_X_LANDMARK_0_DX] <= -0x1.9f6196p-5f) { /* node 2: -0.0507057 */
                if (x[PHYSICAL_DECEPTION_AGENT_0_X_LANDMARK_0_DY] <= -0x1.127c44p-1f) { /* node 3: -0.536104 */
                    return PHYSICAL_DECEPTION_AGENT_0_DOWN; /* leaf 4 */
                } else {
                    return PHYSICAL_DECEPTION_AGENT_0_LEFT; /* leaf 5 */
                }
            } else {
                if (x[PHYSICAL_DECEPTION_AGENT_0_X_LANDMARK_0_DY] <= -0x1.5797ccp-6f) { /* node 6: -0.0209712 */
                    return PHYSICAL_DECEPTION_AGENT_0_DOWN; /* leaf 7 */
                } else {
                    return PHYSICAL_DECEPTION_AGENT_0_LEFT; /* leaf 8 */
                }
            }
        } else {
            if (x[PHYSICAL_DECEPTION_AGENT_0_X_LANDMARK_0_DX] <= -0x1.2745fp-3f) { /* node 9: -0.144176 */
                if (x[PHYSICAL_DECEPTION_AGENT_0_X_LANDMARK_1_DY] <= 0x1.e9104ep-1f) { /* node 10: 0.955203 */
                    return PHYSICAL_DECEPTION_AGENT_0_LEFT; /* leaf 11 */
                } else {
                    return PHYSICAL_DECEPTION_AGENT_0_UP; /* leaf 12 */
                }
            } else {
                if (x[PHYSICAL_DECEPTION_AGENT_0_X_GOAL_DY] <= -0x1.cbf918p-1f) { /* node 13: -0.898385 */
                    return PHYSICAL_DECEPTION_AGENT_0_UP; /* leaf 14 */
                } else {
                    return PHYSICAL_DECEPTION_AGENT_0_UP; /* leaf 15 */
                }
            }
        }
    } else {
        if (x[PHYSICAL_DECEPTION_AGENT_0_X_LANDMARK_0_DY] <= -0x1.3c4354p-3f) { /* node 16: -0.154425 */
            if (x[PHYSICAL_DECEPTION_AGENT_0_X_GOAL_DX] <= 0x1.36b87p-1f) { /* node 17: 0.606876 */
                if (x[PHYSICAL_DECEPTION_AGENT_0_X_AGENT_1_DY] <= 0x1.0a6f06p-1f) { /* node 18: 0.520378 */
                    return PHYSICAL_DECEPTION_AGENT_0_DOWN; /* leaf 19 */
                } else {
                    return PHYSICAL_DECEPTION_AGENT_0_RIGHT; /* leaf 20 */
                }
            } else {
                if (x[PHYSICAL_DECEPTION_AGENT_0_X_GOAL_DX] <= 0x1.272c94p+0f) { /* node 21: 1.15302 */
                    return PHYSICAL_DECEPTION_AGENT_0_RIGHT; /* leaf 22 */
                } else {
                    return PHYSICAL_DECEPTION_AGENT_0_DOWN; /* leaf 23 */
                }
            }
        } else {
            if (x[PHYSICAL_DECEPTION_AGENT_0_X_LANDMARK_0_DY] <= 0x1.5ac0bp-2f) { /* node 24: 0.338626 */
                if (x[PHYSICAL_DECEPTION_AGENT_0_X_ADVERSARY_0_DX] <= -0x1.b061d4p-2f) { /* node 25: -0.422248 */
                    return PHYSICAL_DECEPTION_AGENT_0_RIGHT; /* leaf 26 */
                } else {
                    return PHYSICAL_DECEPTION_AGENT_0_RIGHT; /* leaf 27 */
                }
            } else {
                if (x[PHYSICAL_DECEPTION_AGENT_0_X_GOAL_DX] <= 0x1.89c8f2p-2f) { /* node 28: 0.384556 */
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
    if (x[PHYSICAL_DECEPTION_AGENT_1_X_LANDMARK_1_DX] <= -0x1.18da56p-6f) { /* node 0: -0.0171419 */
        if (x[PHYSICAL_DECEPTION_AGENT_1_X_LANDMARK_1_DY] <= -0x1.d61f44p-3f) { /* node 1: -0.229552 */
            if (x[PHYSICAL_DECEPTION_AGENT_1_X_LANDMARK_1_DX] <= -0x1.568f8ap+0f) { /* node 2: -1.33813 */
                if (x[PHYSICAL_DECEPTION_AGENT_1_X_LANDMARK_0_DY] <= 0x1.191d08p-5f) { /* node 3: 0.0343156 */
                    return PHYSICAL_DECEPTION_AGENT_1_LEFT; /* leaf 4 */
                } else {
                    return PHYSICAL_DECEPTION_AGENT_1_UP; /* leaf 5 */
                }
            } else {
                if (x[PHYSICAL_DECEPTION_AGENT_1_X_GOAL_DX] <= -0x1.ce96ap-2f) { /* node 6: -0.451746 */
                    return PHYSICAL_DECEPTION_AGENT_1_DOWN; /* leaf 7 */
                } else {
                    return PHYSICAL_DECEPTION_AGENT_1_DOWN; /* leaf 8 */
                }
            }
        } else {
            if (x[PHYSICAL_DECEPTION_AGENT_1_X_LANDMARK_1_DY] <= 0x1.8eb1e4p-2f) { /* node 9: 0.38935 */
                if (x[PHYSICAL_DECEPTION_AGENT_1_X_LANDMARK_1_DX] <= -0x1.0e71c2p-3f) { /* node 10: -0.132053 */
                    return PHYSICAL_DECEPTION_AGENT_1_LEFT; /* leaf 11 */
                } else {
                    return PHYSICAL_DECEPTION_AGENT_1_LEFT; /* leaf 12 */
                }
            } else {
                if (x[PHYSICAL_DECEPTION_AGENT_1_X_LANDMARK_1_DX] <= -0x1.513e72p-1f) { /* node 13: -0.65868 */
                    return PHYSICAL_DECEPTION_AGENT_1_LEFT; /* leaf 14 */
                } else {
                    return PHYSICAL_DECEPTION_AGENT_1_UP; /* leaf 15 */
                }
            }
        }
    } else {
        if (x[PHYSICAL_DECEPTION_AGENT_1_X_LANDMARK_1_DY] <= 0x1.111244p-2f) { /* node 16: 0.266671 */
            if (x[PHYSICAL_DECEPTION_AGENT_1_X_GOAL_DY] <= -0x1.b0c772p-3f) { /* node 17: -0.211318 */
                if (x[PHYSICAL_DECEPTION_AGENT_1_X_LANDMARK_0_DX] <= 0x1.b176bp-2f) { /* node 18: 0.423304 */
                    return PHYSICAL_DECEPTION_AGENT_1_DOWN; /* leaf 19 */
                } else {
                    return PHYSICAL_DECEPTION_AGENT_1_RIGHT; /* leaf 20 */
                }
            } else {
                if (x[PHYSICAL_DECEPTION_AGENT_1_X_LANDMARK_1_DX] <= 0x1.21080ep-2f) { /* node 21: 0.282257 */
                    return PHYSICAL_DECEPTION_AGENT_1_RIGHT; /* leaf 22 */
                } else {
                    return PHYSICAL_DECEPTION_AGENT_1_RIGHT; /* leaf 23 */
                }
            }
        } else {
            if (x[PHYSICAL_DECEPTION_AGENT_1_X_LANDMARK_1_DX] <= 0x1.3cc992p+0f) { /* node 24: 1.23745 */
                if (x[PHYSICAL_DECEPTION_AGENT_1_X_LANDMARK_0_DY] <= 0x1.9077ccp-4f) { /* node 25: 0.0977705 */
                    return PHYSICAL_DECEPTION_AGENT_1_UP; /* leaf 26 */
                } else {
                    return PHYSICAL_DECEPTION_AGENT_1_UP; /* leaf 27 */
                }
            } else {
                if (x[PHYSICAL_DECEPTION_AGENT_1_X_GOAL_DX] <= 0x1.dcdb62p-1f) { /* node 28: 0.931361 */
                    return PHYSICAL_DECEPTION_AGENT_1_DOWN; /* leaf 29 */
                } else {
                    return PHYSICAL_DECEPTION_AGENT_1_RIGHT; /* leaf 30 */
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

#endif /* PHYSICAL_DECEPTION_492C3F7D7F8E3D05_H */
