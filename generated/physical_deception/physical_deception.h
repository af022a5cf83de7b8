/* Decision tree policies of 3 agents for the world physical-deception. Generated: do not edit.
 *
 * profile     883d3c4df60f96b6cb01ad91094f7a24fa39078550d2035691b80c4e5ca4e01f
 * made by     maviper 0.1.0, maviper, preset paper, seed 0
 *
 * C99, no heap, no libc, no recursion, no state. For each agent A:
 *   int physical_deception_A_act(const float *x)      the action, from an observation of float32
 *   int physical_deception_A_finite(const float *x)   1 when every number of the observation is finite, else 0
 *
 * A split goes left iff x[feature] <= threshold, both float32, thresholds exact. NaN compares false and so goes right;
 * infinities follow <=. Check untrusted input with ..._finite first.
 */
#ifndef PHYSICAL_DECEPTION_883D3C4DF60F96B6_H
#define PHYSICAL_DECEPTION_883D3C4DF60F96B6_H

#ifdef __FAST_MATH__
#error "compile without -ffast-math: it changes what comparisons with NaN and tiny numbers mean"
#endif

#define PHYSICAL_DECEPTION_PROFILE "883d3c4df60f96b6cb01ad91094f7a24fa39078550d2035691b80c4e5ca4e01f"

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
    if (x[PHYSICAL_DECEPTION_ADVERSARY_0_X_LANDMARK_0_DX] <= -0x1.4df79ap-2f) { /* node 0: -0.32614 */
        if (x[PHYSICAL_DECEPTION_ADVERSARY_0_X_LANDMARK_1_DX] <= -0x1.501c4p-5f) { /* node 1: -0.0410291 */
            if (x[PHYSICAL_DECEPTION_ADVERSARY_0_X_LANDMARK_1_DY] <= -0x1.143428p+0f) { /* node 2: -1.07892 */
                if (x[PHYSICAL_DECEPTION_ADVERSARY_0_X_LANDMARK_0_DY] <= -0x1.1a098ap-2f) { /* node 3: -0.275427 */
                    return PHYSICAL_DECEPTION_ADVERSARY_0_DOWN; /* leaf 4 */
                } else {
                    return PHYSICAL_DECEPTION_ADVERSARY_0_LEFT; /* leaf 5 */
                }
            } else {
                if (x[PHYSICAL_DECEPTION_ADVERSARY_0_X_LANDMARK_0_DY] <= 0x1.47306cp+0f) { /* node 6: 1.27808 */
                    return PHYSICAL_DECEPTION_ADVERSARY_0_LEFT; /* leaf 7 */
                } else {
                    return PHYSICAL_DECEPTION_ADVERSARY_0_UP; /* leaf 8 */
                }
            }
        } else {
            if (x[PHYSICAL_DECEPTION_ADVERSARY_0_X_LANDMARK_0_DY] <= -0x1.8ef392p-2f) { /* node 9: -0.389601 */
                if (x[PHYSICAL_DECEPTION_ADVERSARY_0_X_LANDMARK_1_DY] <= 0x1.14483ap-2f) { /* node 10: 0.269807 */
                    return PHYSICAL_DECEPTION_ADVERSARY_0_DOWN; /* leaf 11 */
                } else {
                    return PHYSICAL_DECEPTION_ADVERSARY_0_DOWN; /* leaf 12 */
                }
            } else {
                if (x[PHYSICAL_DECEPTION_ADVERSARY_0_X_LANDMARK_0_DY] <= 0x1.b5a286p-1f) { /* node 13: 0.854756 */
                    return PHYSICAL_DECEPTION_ADVERSARY_0_LEFT; /* leaf 14 */
                } else {
                    return PHYSICAL_DECEPTION_ADVERSARY_0_UP; /* leaf 15 */
                }
            }
        }
    } else {
        if (x[PHYSICAL_DECEPTION_ADVERSARY_0_X_LANDMARK_0_DY] <= -0x1.ee3d9cp-4f) { /* node 16: -0.120664 */
            if (x[PHYSICAL_DECEPTION_ADVERSARY_0_X_LANDMARK_1_DY] <= -0x1.537738p-3f) { /* node 17: -0.165755 */
                if (x[PHYSICAL_DECEPTION_ADVERSARY_0_X_LANDMARK_0_DX] <= 0x1.14ceb4p+0f) { /* node 18: 1.08128 */
                    return PHYSICAL_DECEPTION_ADVERSARY_0_DOWN; /* leaf 19 */
                } else {
                    return PHYSICAL_DECEPTION_ADVERSARY_0_RIGHT; /* leaf 20 */
                }
            } else {
                if (x[PHYSICAL_DECEPTION_ADVERSARY_0_X_LANDMARK_1_DX] <= -0x1.cdb10ap-4f) { /* node 21: -0.112718 */
                    return PHYSICAL_DECEPTION_ADVERSARY_0_LEFT; /* leaf 22 */
                } else {
                    return PHYSICAL_DECEPTION_ADVERSARY_0_RIGHT; /* leaf 23 */
                }
            }
        } else {
            if (x[PHYSICAL_DECEPTION_ADVERSARY_0_X_LANDMARK_1_DY] <= 0x1.9b6a98p-2f) { /* node 24: 0.401774 */
                if (x[PHYSICAL_DECEPTION_ADVERSARY_0_X_LANDMARK_1_DX] <= 0x1.7020b4p-3f) { /* node 25: 0.17975 */
                    return PHYSICAL_DECEPTION_ADVERSARY_0_UP; /* leaf 26 */
                } else {
                    return PHYSICAL_DECEPTION_ADVERSARY_0_RIGHT; /* leaf 27 */
                }
            } else {
                if (x[PHYSICAL_DECEPTION_ADVERSARY_0_X_LANDMARK_0_DX] <= 0x1.4bdfbap+0f) { /* node 28: 1.29638 */
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
    if (x[PHYSICAL_DECEPTION_AGENT_0_X_LANDMARK_0_DY] <= -0x1.297874p-4f) { /* node 0: -0.0726246 */
        if (x[PHYSICAL_DECEPTION_AGENT_0_X_LANDMARK_0_DX] <= 0x1.1a4ebap-1f) { /* node 1: 0.551382 */
            if (x[PHYSICAL_DECEPTION_AGENT_0_X_LANDMARK_0_DX] <= -0x1.866fa2p-4f) { /* node 2: -0.0953213 */
                if (x[PHYSICAL_DECEPTION_AGENT_0_X_GOAL_DY] <= -0x1.2a8976p-2f) { /* node 3: -0.29154 */
                    return PHYSICAL_DECEPTION_AGENT_0_DOWN; /* leaf 4 */
                } else {
                    return PHYSICAL_DECEPTION_AGENT_0_LEFT; /* leaf 5 */
                }
            } else {
                if (x[PHYSICAL_DECEPTION_AGENT_0_X_GOAL_DY] <= -0x1.49955p-3f) { /* node 6: -0.160929 */
                    return PHYSICAL_DECEPTION_AGENT_0_DOWN; /* leaf 7 */
                } else {
                    return PHYSICAL_DECEPTION_AGENT_0_DOWN; /* leaf 8 */
                }
            }
        } else {
            if (x[PHYSICAL_DECEPTION_AGENT_0_X_GOAL_DX] <= -0x1.438634p-2f) { /* node 9: -0.315942 */
                if (x[PHYSICAL_DECEPTION_AGENT_0_X_ADVERSARY_0_DX] <= -0x1.8f1d3ep-2f) { /* node 10: -0.38976 */
                    return PHYSICAL_DECEPTION_AGENT_0_DOWN; /* leaf 11 */
                } else {
                    return PHYSICAL_DECEPTION_AGENT_0_LEFT; /* leaf 12 */
                }
            } else {
                if (x[PHYSICAL_DECEPTION_AGENT_0_X_LANDMARK_0_DY] <= -0x1.8b97p-1f) { /* node 13: -0.772636 */
                    return PHYSICAL_DECEPTION_AGENT_0_DOWN; /* leaf 14 */
                } else {
                    return PHYSICAL_DECEPTION_AGENT_0_RIGHT; /* leaf 15 */
                }
            }
        }
    } else {
        if (x[PHYSICAL_DECEPTION_AGENT_0_X_LANDMARK_0_DX] <= 0x1.4d3938p-3f) { /* node 16: 0.162707 */
            if (x[PHYSICAL_DECEPTION_AGENT_0_X_LANDMARK_0_DY] <= 0x1.2b887cp-3f) { /* node 17: 0.146256 */
                if (x[PHYSICAL_DECEPTION_AGENT_0_X_LANDMARK_0_DX] <= -0x1.059c5p-6f) { /* node 18: -0.0159674 */
                    return PHYSICAL_DECEPTION_AGENT_0_LEFT; /* leaf 19 */
                } else {
                    return PHYSICAL_DECEPTION_AGENT_0_UP; /* leaf 20 */
                }
            } else {
                if (x[PHYSICAL_DECEPTION_AGENT_0_X_LANDMARK_0_DX] <= -0x1.749c52p-3f) { /* node 21: -0.181939 */
                    return PHYSICAL_DECEPTION_AGENT_0_LEFT; /* leaf 22 */
                } else {
                    return PHYSICAL_DECEPTION_AGENT_0_UP; /* leaf 23 */
                }
            }
        } else {
            if (x[PHYSICAL_DECEPTION_AGENT_0_X_LANDMARK_0_DY] <= 0x1.6bf024p-2f) { /* node 24: 0.355408 */
                if (x[PHYSICAL_DECEPTION_AGENT_0_X_LANDMARK_1_DY] <= 0x1.c7009p+0f) { /* node 25: 1.77735 */
                    return PHYSICAL_DECEPTION_AGENT_0_RIGHT; /* leaf 26 */
                } else {
                    return PHYSICAL_DECEPTION_AGENT_0_UP; /* leaf 27 */
                }
            } else {
                if (x[PHYSICAL_DECEPTION_AGENT_0_X_LANDMARK_0_DX] <= 0x1.f8c5a4p-2f) { /* node 28: 0.492941 */
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
    if (x[PHYSICAL_DECEPTION_AGENT_1_X_LANDMARK_1_DX] <= -0x1.8880b8p-5f) { /* node 0: -0.0479129 */
        if (x[PHYSICAL_DECEPTION_AGENT_1_X_LANDMARK_1_DY] <= -0x1.090a6ep-3f) { /* node 1: -0.129414 */
            if (x[PHYSICAL_DECEPTION_AGENT_1_X_LANDMARK_1_DX] <= -0x1.ad38dcp-2f) { /* node 2: -0.419162 */
                if (x[PHYSICAL_DECEPTION_AGENT_1_X_GOAL_DY] <= 0x1.9bf8e4p-2f) { /* node 3: 0.402317 */
                    return PHYSICAL_DECEPTION_AGENT_1_LEFT; /* leaf 4 */
                } else {
                    return PHYSICAL_DECEPTION_AGENT_1_UP; /* leaf 5 */
                }
            } else {
                if (x[PHYSICAL_DECEPTION_AGENT_1_X_LANDMARK_1_DY] <= -0x1.2fafeep-2f) { /* node 6: -0.29657 */
                    return PHYSICAL_DECEPTION_AGENT_1_DOWN; /* leaf 7 */
                } else {
                    return PHYSICAL_DECEPTION_AGENT_1_DOWN; /* leaf 8 */
                }
            }
        } else {
            if (x[PHYSICAL_DECEPTION_AGENT_1_X_LANDMARK_1_DY] <= 0x1.63aa22p-1f) { /* node 9: 0.694657 */
                if (x[PHYSICAL_DECEPTION_AGENT_1_X_LANDMARK_1_DX] <= -0x1.2d665cp-3f) { /* node 10: -0.147168 */
                    return PHYSICAL_DECEPTION_AGENT_1_LEFT; /* leaf 11 */
                } else {
                    return PHYSICAL_DECEPTION_AGENT_1_LEFT; /* leaf 12 */
                }
            } else {
                if (x[PHYSICAL_DECEPTION_AGENT_1_X_GOAL_DY] <= 0x1.aad256p-3f) { /* node 13: 0.208409 */
                    return PHYSICAL_DECEPTION_AGENT_1_LEFT; /* leaf 14 */
                } else {
                    return PHYSICAL_DECEPTION_AGENT_1_UP; /* leaf 15 */
                }
            }
        }
    } else {
        if (x[PHYSICAL_DECEPTION_AGENT_1_X_LANDMARK_1_DY] <= 0x1.2cd81ap-3f) { /* node 16: 0.146897 */
            if (x[PHYSICAL_DECEPTION_AGENT_1_X_LANDMARK_1_DX] <= 0x1.7355fep-2f) { /* node 17: 0.362633 */
                if (x[PHYSICAL_DECEPTION_AGENT_1_X_LANDMARK_1_DY] <= -0x1.8bcf1ap-3f) { /* node 18: -0.193266 */
                    return PHYSICAL_DECEPTION_AGENT_1_DOWN; /* leaf 19 */
                } else {
                    return PHYSICAL_DECEPTION_AGENT_1_RIGHT; /* leaf 20 */
                }
            } else {
                if (x[PHYSICAL_DECEPTION_AGENT_1_X_GOAL_DY] <= -0x1.c2b5d4p-1f) { /* node 21: -0.880293 */
                    return PHYSICAL_DECEPTION_AGENT_1_DOWN; /* leaf 22 */
                } else {
                    return PHYSICAL_DECEPTION_AGENT_1_RIGHT; /* leaf 23 */
                }
            }
        } else {
            if (x[PHYSICAL_DECEPTION_AGENT_1_X_LANDMARK_1_DX] <= 0x1.8bfd4cp-1f) { /* node 24: 0.773417 */
                if (x[PHYSICAL_DECEPTION_AGENT_1_X_ADVERSARY_0_DY] <= -0x1.818364p-1f) { /* node 25: -0.752956 */
                    return PHYSICAL_DECEPTION_AGENT_1_RIGHT; /* leaf 26 */
                } else {
                    return PHYSICAL_DECEPTION_AGENT_1_UP; /* leaf 27 */
                }
            } else {
                if (x[PHYSICAL_DECEPTION_AGENT_1_X_LANDMARK_0_DY] <= 0x1.b9dd64p-2f) { /* node 28: 0.431509 */
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

#endif /* PHYSICAL_DECEPTION_883D3C4DF60F96B6_H */
