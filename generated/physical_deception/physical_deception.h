/* Decision tree policies of 3 agents for the world physical-deception. Generated: do not edit.
 *
 * profile     607fd658935566560c33a9469996b8dc45389ba5998aa41d704298d8cf8ce8ce
 * made by     maviper 0.1.0, maviper, preset default, seed 0
 *
 * C99, no heap, no libc, no recursion, no state. For each agent A:
 *   int physical_deception_A_act(const float *x)      the action, from an observation of float32
 *   int physical_deception_A_finite(const float *x)   1 when every number of the observation is finite, else 0
 *
 * A split goes left iff x[feature] <= threshold, both float32, thresholds exact. NaN compares false and so goes right;
 * infinities follow <=. Check untrusted input with ..._finite first.
 */
#ifndef PHYSICAL_DECEPTION_607FD65893556656_H
#define PHYSICAL_DECEPTION_607FD65893556656_H

#ifdef __FAST_MATH__
#error "compile without -ffast-math: it changes what comparisons with NaN and tiny numbers mean"
#endif

#define PHYSICAL_DECEPTION_PROFILE "607fd658935566560c33a9469996b8dc45389ba5998aa41d704298d8cf8ce8ce"

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
    if (x[PHYSICAL_DECEPTION_ADVERSARY_0_X_LANDMARK_1_DX] <= -0x1.81df14p-2f) { /* node 0: -0.376828 */
        if (x[PHYSICAL_DECEPTION_ADVERSARY_0_X_LANDMARK_1_DY] <= 0x1.1fc284p-1f) { /* node 1: 0.562031 */
            if (x[PHYSICAL_DECEPTION_ADVERSARY_0_X_AGENT_1_DY] <= -0x1.59b98p-1f) { /* node 2: -0.675243 */
                if (x[PHYSICAL_DECEPTION_ADVERSARY_0_X_LANDMARK_0_DX] <= -0x1.fd069p-1f) { /* node 3: -0.994191 */
                    return PHYSICAL_DECEPTION_ADVERSARY_0_LEFT; /* leaf 4 */
                } else {
                    return PHYSICAL_DECEPTION_ADVERSARY_0_DOWN; /* leaf 5 */
                }
            } else {
                if (x[PHYSICAL_DECEPTION_ADVERSARY_0_X_AGENT_0_DX] <= 0x1.124b2cp-1f) { /* node 6: 0.53573 */
                    return PHYSICAL_DECEPTION_ADVERSARY_0_LEFT; /* leaf 7 */
                } else {
                    return PHYSICAL_DECEPTION_ADVERSARY_0_RIGHT; /* leaf 8 */
                }
            }
        } else {
            if (x[PHYSICAL_DECEPTION_ADVERSARY_0_X_LANDMARK_0_DX] <= -0x1.91c3cap-1f) { /* node 9: -0.784697 */
                if (x[PHYSICAL_DECEPTION_ADVERSARY_0_X_LANDMARK_1_DY] <= 0x1.78186ep+0f) { /* node 10: 1.46912 */
                    return PHYSICAL_DECEPTION_ADVERSARY_0_LEFT; /* leaf 11 */
                } else {
                    return PHYSICAL_DECEPTION_ADVERSARY_0_UP; /* leaf 12 */
                }
            } else {
                if (x[PHYSICAL_DECEPTION_ADVERSARY_0_X_AGENT_0_DX] <= -0x1.033a64p-1f) { /* node 13: -0.506305 */
                    return PHYSICAL_DECEPTION_ADVERSARY_0_LEFT; /* leaf 14 */
                } else {
                    return PHYSICAL_DECEPTION_ADVERSARY_0_UP; /* leaf 15 */
                }
            }
        }
    } else {
        if (x[PHYSICAL_DECEPTION_ADVERSARY_0_X_LANDMARK_0_DX] <= 0x1.3a007cp-1f) { /* node 16: 0.613285 */
            if (x[PHYSICAL_DECEPTION_ADVERSARY_0_X_AGENT_1_DY] <= -0x1.6fe972p-3f) { /* node 17: -0.179644 */
                if (x[PHYSICAL_DECEPTION_ADVERSARY_0_X_AGENT_0_DY] <= 0x1.395786p-1f) { /* node 18: 0.611996 */
                    return PHYSICAL_DECEPTION_ADVERSARY_0_DOWN; /* leaf 19 */
                } else {
                    return PHYSICAL_DECEPTION_ADVERSARY_0_UP; /* leaf 20 */
                }
            } else {
                if (x[PHYSICAL_DECEPTION_ADVERSARY_0_X_LANDMARK_1_DX] <= 0x1.69d17p-1f) { /* node 21: 0.706676 */
                    return PHYSICAL_DECEPTION_ADVERSARY_0_UP; /* leaf 22 */
                } else {
                    return PHYSICAL_DECEPTION_ADVERSARY_0_RIGHT; /* leaf 23 */
                }
            }
        } else {
            if (x[PHYSICAL_DECEPTION_ADVERSARY_0_X_LANDMARK_0_DY] <= 0x1.0f4d86p+0f) { /* node 24: 1.05978 */
                if (x[PHYSICAL_DECEPTION_ADVERSARY_0_X_LANDMARK_0_DY] <= -0x1.4158fp+0f) { /* node 25: -1.25526 */
                    return PHYSICAL_DECEPTION_ADVERSARY_0_DOWN; /* leaf 26 */
                } else {
                    return PHYSICAL_DECEPTION_ADVERSARY_0_RIGHT; /* leaf 27 */
                }
            } else {
                if (x[PHYSICAL_DECEPTION_ADVERSARY_0_X_LANDMARK_0_DX] <= 0x1.294d1cp+0f) { /* node 28: 1.16133 */
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
    if (x[PHYSICAL_DECEPTION_AGENT_0_X_LANDMARK_0_DY] <= -0x1.2f2b38p-7f) { /* node 0: -0.00925198 */
        if (x[PHYSICAL_DECEPTION_AGENT_0_X_LANDMARK_0_DX] <= 0x1.c22d7cp-3f) { /* node 1: 0.219813 */
            if (x[PHYSICAL_DECEPTION_AGENT_0_X_LANDMARK_0_DX] <= -0x1.5ef85ap-3f) { /* node 2: -0.171372 */
                if (x[PHYSICAL_DECEPTION_AGENT_0_X_LANDMARK_0_DY] <= -0x1.256f02p-2f) { /* node 3: -0.286556 */
                    return PHYSICAL_DECEPTION_AGENT_0_DOWN; /* leaf 4 */
                } else {
                    return PHYSICAL_DECEPTION_AGENT_0_LEFT; /* leaf 5 */
                }
            } else {
                if (x[PHYSICAL_DECEPTION_AGENT_0_X_LANDMARK_0_DY] <= -0x1.4b0c24p-4f) { /* node 6: -0.0808221 */
                    return PHYSICAL_DECEPTION_AGENT_0_DOWN; /* leaf 7 */
                } else {
                    return PHYSICAL_DECEPTION_AGENT_0_DOWN; /* leaf 8 */
                }
            }
        } else {
            if (x[PHYSICAL_DECEPTION_AGENT_0_X_LANDMARK_0_DY] <= -0x1.5ce23p-2f) { /* node 9: -0.340707 */
                if (x[PHYSICAL_DECEPTION_AGENT_0_X_LANDMARK_0_DX] <= 0x1.ef3e0ep-1f) { /* node 10: 0.96727 */
                    return PHYSICAL_DECEPTION_AGENT_0_DOWN; /* leaf 11 */
                } else {
                    return PHYSICAL_DECEPTION_AGENT_0_RIGHT; /* leaf 12 */
                }
            } else {
                if (x[PHYSICAL_DECEPTION_AGENT_0_X_AGENT_1_DX] <= -0x1.34980ap+0f) { /* node 13: -1.20544 */
                    return PHYSICAL_DECEPTION_AGENT_0_DOWN; /* leaf 14 */
                } else {
                    return PHYSICAL_DECEPTION_AGENT_0_RIGHT; /* leaf 15 */
                }
            }
        }
    } else {
        if (x[PHYSICAL_DECEPTION_AGENT_0_X_LANDMARK_0_DX] <= 0x1.a0761p-3f) { /* node 16: 0.20335 */
            if (x[PHYSICAL_DECEPTION_AGENT_0_X_LANDMARK_0_DX] <= -0x1.3db4f4p-3f) { /* node 17: -0.15513 */
                if (x[PHYSICAL_DECEPTION_AGENT_0_X_LANDMARK_0_DY] <= 0x1.6b481cp-3f) { /* node 18: 0.177384 */
                    return PHYSICAL_DECEPTION_AGENT_0_LEFT; /* leaf 19 */
                } else {
                    return PHYSICAL_DECEPTION_AGENT_0_UP; /* leaf 20 */
                }
            } else {
                if (x[PHYSICAL_DECEPTION_AGENT_0_X_LANDMARK_0_DY] <= 0x1.d6f1c2p-5f) { /* node 21: 0.0574883 */
                    return PHYSICAL_DECEPTION_AGENT_0_UP; /* leaf 22 */
                } else {
                    return PHYSICAL_DECEPTION_AGENT_0_UP; /* leaf 23 */
                }
            }
        } else {
            if (x[PHYSICAL_DECEPTION_AGENT_0_X_LANDMARK_0_DY] <= 0x1.444b8ep-2f) { /* node 24: 0.316694 */
                if (x[PHYSICAL_DECEPTION_AGENT_0_X_LANDMARK_0_DX] <= 0x1.05cd62p-2f) { /* node 25: 0.255666 */
                    return PHYSICAL_DECEPTION_AGENT_0_RIGHT; /* leaf 26 */
                } else {
                    return PHYSICAL_DECEPTION_AGENT_0_RIGHT; /* leaf 27 */
                }
            } else {
                if (x[PHYSICAL_DECEPTION_AGENT_0_X_LANDMARK_0_DX] <= 0x1.c4d6eap-1f) { /* node 28: 0.884452 */
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
    if (x[PHYSICAL_DECEPTION_AGENT_1_X_LANDMARK_1_DX] <= -0x1.aee5dap-4f) { /* node 0: -0.1052 */
        if (x[PHYSICAL_DECEPTION_AGENT_1_X_LANDMARK_1_DY] <= 0x1.a696aep-3f) { /* node 1: 0.206342 */
            if (x[PHYSICAL_DECEPTION_AGENT_1_X_LANDMARK_1_DY] <= -0x1.eb208ep-3f) { /* node 2: -0.239808 */
                if (x[PHYSICAL_DECEPTION_AGENT_1_X_LANDMARK_1_DX] <= -0x1.892a8p-2f) { /* node 3: -0.383951 */
                    return PHYSICAL_DECEPTION_AGENT_1_LEFT; /* leaf 4 */
                } else {
                    return PHYSICAL_DECEPTION_AGENT_1_DOWN; /* leaf 5 */
                }
            } else {
                if (x[PHYSICAL_DECEPTION_AGENT_1_X_LANDMARK_1_DX] <= -0x1.520536p-3f) { /* node 6: -0.165049 */
                    return PHYSICAL_DECEPTION_AGENT_1_LEFT; /* leaf 7 */
                } else {
                    return PHYSICAL_DECEPTION_AGENT_1_LEFT; /* leaf 8 */
                }
            }
        } else {
            if (x[PHYSICAL_DECEPTION_AGENT_1_X_LANDMARK_1_DX] <= -0x1.e2d064p-1f) { /* node 9: -0.942996 */
                if (x[PHYSICAL_DECEPTION_AGENT_1_X_ADVERSARY_0_DY] <= 0x1.7521dp+0f) { /* node 10: 1.45755 */
                    return PHYSICAL_DECEPTION_AGENT_1_LEFT; /* leaf 11 */
                } else {
                    return PHYSICAL_DECEPTION_AGENT_1_UP; /* leaf 12 */
                }
            } else {
                if (x[PHYSICAL_DECEPTION_AGENT_1_X_LANDMARK_1_DY] <= 0x1.6124b2p-1f) { /* node 13: 0.689733 */
                    return PHYSICAL_DECEPTION_AGENT_1_UP; /* leaf 14 */
                } else {
                    return PHYSICAL_DECEPTION_AGENT_1_UP; /* leaf 15 */
                }
            }
        }
    } else {
        if (x[PHYSICAL_DECEPTION_AGENT_1_X_LANDMARK_1_DY] <= 0x1.d701c4p-6f) { /* node 16: 0.028748 */
            if (x[PHYSICAL_DECEPTION_AGENT_1_X_LANDMARK_1_DX] <= 0x1.16344p-3f) { /* node 17: 0.135842 */
                if (x[PHYSICAL_DECEPTION_AGENT_1_X_LANDMARK_1_DY] <= -0x1.25d018p-4f) { /* node 18: -0.0717317 */
                    return PHYSICAL_DECEPTION_AGENT_1_DOWN; /* leaf 19 */
                } else {
                    return PHYSICAL_DECEPTION_AGENT_1_RIGHT; /* leaf 20 */
                }
            } else {
                if (x[PHYSICAL_DECEPTION_AGENT_1_X_LANDMARK_1_DY] <= -0x1.cb3c52p-3f) { /* node 21: -0.224236 */
                    return PHYSICAL_DECEPTION_AGENT_1_RIGHT; /* leaf 22 */
                } else {
                    return PHYSICAL_DECEPTION_AGENT_1_RIGHT; /* leaf 23 */
                }
            }
        } else {
            if (x[PHYSICAL_DECEPTION_AGENT_1_X_LANDMARK_1_DX] <= 0x1.7567cap-3f) { /* node 24: 0.182327 */
                if (x[PHYSICAL_DECEPTION_AGENT_1_X_LANDMARK_1_DY] <= 0x1.38544ep-4f) { /* node 25: 0.0762523 */
                    return PHYSICAL_DECEPTION_AGENT_1_UP; /* leaf 26 */
                } else {
                    return PHYSICAL_DECEPTION_AGENT_1_UP; /* leaf 27 */
                }
            } else {
                if (x[PHYSICAL_DECEPTION_AGENT_1_X_LANDMARK_1_DY] <= 0x1.180f64p-2f) { /* node 28: 0.273496 */
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

#endif /* PHYSICAL_DECEPTION_607FD65893556656_H */
