/* Decision tree policies of 2 agents for the world foraging-make. Generated: do not edit.
 *
 * profile     1d422d5f98303ee3108dfcde258835cce28b0ad93ebd3caa77a333ae166a04da
 * made by     maviper 0.1.0, maviper, preset default, seed 0
 * style       nested
 *
 * C99, also C++17; no heap, no libc, no recursion, no state. For each agent A:
 *   int foraging_A_act(const float *x)        the action, from an observation of float32
 *   int foraging_A_finite(const float *x)     1 when every number of the observation is finite, else 0
 *   int foraging_A_in_range(const float *x)   1 when every number is within its feature's range, else 0
 *   void foraging_A_act_rows(const float *x, long n, T *actions)              n observations, one after the other
 *   void foraging_A_act_columns(const float *const *x, long n, T *actions)    n observations, one array per feature
 * and for all agents, in the order of this file:
 *   void foraging_act_all(const float *const *x, int *actions)   the actions, from an observation of each
 * FORAGING_DT is the time of a step, FORAGING_DAMPING the share of its velocity that an agent loses in it,
 * FORAGING_A_FORCE what a unit action adds to its velocity per unit of time.
 *
 * A split goes left iff x[feature] <= threshold, both float32, thresholds exact. NaN compares false and so goes right;
 * infinities follow <=. Check untrusted input with ..._finite first.
 *
 * Subnormal numbers count. A thread that takes them for zero (FTZ, DAZ) decides what lies next to zero otherwise; gcc sets
 * this at the start of a program that is linked with -ffast-math or -funsafe-math-optimizations, whatever compiled this
 * file. The style `ordered` has an ..._act that decides as stated there too.
 */
#ifndef FORAGING_1D422D5F98303EE3_H
#define FORAGING_1D422D5F98303EE3_H

#include <float.h>

#if defined(__FAST_MATH__) || defined(__ASSOCIATIVE_MATH__) || (defined(__FINITE_MATH_ONLY__) && (__FINITE_MATH_ONLY__ > 0))
#error "compile without -ffast-math, -funsafe-math-optimizations and -ffinite-math-only: they change NaN and tiny numbers"
#endif
#if (FLT_RADIX != 2) || (FLT_MANT_DIG != 24) || (FLT_MAX_EXP != 128) || (DBL_MANT_DIG != 53)
#error "float must be IEEE binary32 and double binary64"
#endif

#define FORAGING_PROFILE "1d422d5f98303ee3108dfcde258835cce28b0ad93ebd3caa77a333ae166a04da"
#define FORAGING_DT 0.0
#define FORAGING_DAMPING 0.0
#define FORAGING_FORAGER_0_FORCE 0.0
#define FORAGING_FORAGER_1_FORCE 0.0

/* forager_0, team foragers: 63 leaves, at most 7 comparisons; tables of 763 bytes where they are used */

enum {
    FORAGING_FORAGER_0_X_FOOD_0_DOWN = 0, /* cells, [-99.0, 99.0] */
    FORAGING_FORAGER_0_X_FOOD_0_RIGHT = 1, /* cells, [-99.0, 99.0] */
    FORAGING_FORAGER_0_X_FOOD_0_AWAY = 2, /* cells, [-99.0, 99.0] */
    FORAGING_FORAGER_0_X_FOOD_0_LATER = 3, /* cells, [-99.0, 99.0] */
    FORAGING_FORAGER_0_X_FOOD_1_DOWN = 4, /* cells, [-99.0, 99.0] */
    FORAGING_FORAGER_0_X_FOOD_1_RIGHT = 5, /* cells, [-99.0, 99.0] */
    FORAGING_FORAGER_0_X_FOOD_1_AWAY = 6, /* cells, [-99.0, 99.0] */
    FORAGING_FORAGER_0_X_FOOD_1_LATER = 7, /* cells, [-99.0, 99.0] */
    FORAGING_FORAGER_0_X_MATE_0_DOWN = 8, /* cells, [-99.0, 99.0] */
    FORAGING_FORAGER_0_X_MATE_0_RIGHT = 9, /* cells, [-99.0, 99.0] */
    FORAGING_FORAGER_0_N_FEATURES = 10
};

enum {
    FORAGING_FORAGER_0_ACTION_0 = 0,
    FORAGING_FORAGER_0_ACTION_1 = 1,
    FORAGING_FORAGER_0_ACTION_2 = 2,
    FORAGING_FORAGER_0_ACTION_3 = 3,
    FORAGING_FORAGER_0_ACTION_4 = 4,
    FORAGING_FORAGER_0_ACTION_5 = 5,
    FORAGING_FORAGER_0_N_ACTIONS = 6
};

static inline int foraging_forager_0_act(const float *x)
{
    if (x[FORAGING_FORAGER_0_X_FOOD_0_AWAY] <= 0x1.8p+0f) { /* node 0: 1.5 */
        if (x[FORAGING_FORAGER_0_X_FOOD_1_LATER] <= -0x1p+0f) { /* node 1: -1 */
            if (x[FORAGING_FORAGER_0_X_FOOD_1_AWAY] <= 0x1.8p+0f) { /* node 2: 1.5 */
                return FORAGING_FORAGER_0_ACTION_5; /* leaf 3 */
            } else {
                if (x[FORAGING_FORAGER_0_X_FOOD_1_RIGHT] <= -0x1.8p+0f) { /* node 4: -1.5 */
                    if (x[FORAGING_FORAGER_0_X_FOOD_1_DOWN] <= 0x1.8p+0f) { /* node 5: 1.5 */
                        return FORAGING_FORAGER_0_ACTION_3; /* leaf 6 */
                    } else {
                        if (x[FORAGING_FORAGER_0_X_FOOD_1_RIGHT] <= -0x1.4p+1f) { /* node 7: -2.5 */
                            if (x[FORAGING_FORAGER_0_X_FOOD_1_DOWN] <= 0x1.4p+1f) { /* node 8: 2.5 */
                                return FORAGING_FORAGER_0_ACTION_3; /* leaf 9 */
                            } else {
                                return FORAGING_FORAGER_0_ACTION_3; /* leaf 10 */
                            }
                        } else {
                            return FORAGING_FORAGER_0_ACTION_2; /* leaf 11 */
                        }
                    }
                } else {
                    if (x[FORAGING_FORAGER_0_X_FOOD_1_RIGHT] <= 0x1.8p+0f) { /* node 12: 1.5 */
                        if (x[FORAGING_FORAGER_0_X_FOOD_1_LATER] <= -0x1.7ep+6f) { /* node 13: -95.5 */
                            if (x[FORAGING_FORAGER_0_X_FOOD_1_RIGHT] <= -0x1p-1f) { /* node 14: -0.5 */
                                return FORAGING_FORAGER_0_ACTION_3; /* leaf 15 */
                            } else {
                                return FORAGING_FORAGER_0_ACTION_4; /* leaf 16 */
                            }
                        } else {
                            if (x[FORAGING_FORAGER_0_X_FOOD_1_DOWN] <= -0x1p-1f) { /* node 17: -0.5 */
                                return FORAGING_FORAGER_0_ACTION_1; /* leaf 18 */
                            } else {
                                return FORAGING_FORAGER_0_ACTION_2; /* leaf 19 */
                            }
                        }
                    } else {
                        if (x[FORAGING_FORAGER_0_X_FOOD_1_DOWN] <= 0x1.8p+0f) { /* node 20: 1.5 */
                            if (x[FORAGING_FORAGER_0_X_FOOD_1_LATER] <= -0x1.7ep+6f) { /* node 21: -95.5 */
                                return FORAGING_FORAGER_0_ACTION_2; /* leaf 22 */
                            } else {
                                return FORAGING_FORAGER_0_ACTION_4; /* leaf 23 */
                            }
                        } else {
                            if (x[FORAGING_FORAGER_0_X_FOOD_1_RIGHT] <= 0x1.4p+1f) { /* node 24: 2.5 */
                                return FORAGING_FORAGER_0_ACTION_2; /* leaf 25 */
                            } else {
                                return FORAGING_FORAGER_0_ACTION_2; /* leaf 26 */
                            }
                        }
                    }
                }
            }
        } else {
            return FORAGING_FORAGER_0_ACTION_5; /* leaf 27 */
        }
    } else {
        if (x[FORAGING_FORAGER_0_X_FOOD_0_DOWN] <= -0x1p-1f) { /* node 28: -0.5 */
            if (x[FORAGING_FORAGER_0_X_FOOD_1_LATER] <= -0x1p+0f) { /* node 29: -1 */
                if (x[FORAGING_FORAGER_0_X_FOOD_1_AWAY] <= 0x1.8p+0f) { /* node 30: 1.5 */
                    return FORAGING_FORAGER_0_ACTION_5; /* leaf 31 */
                } else {
                    if (x[FORAGING_FORAGER_0_X_FOOD_1_RIGHT] <= -0x1p-1f) { /* node 32: -0.5 */
                        if (x[FORAGING_FORAGER_0_X_FOOD_1_DOWN] <= -0x1.8p+0f) { /* node 33: -1.5 */
                            if (x[FORAGING_FORAGER_0_X_FOOD_1_RIGHT] <= -0x1.4p+1f) { /* node 34: -2.5 */
                                return FORAGING_FORAGER_0_ACTION_3; /* leaf 35 */
                            } else {
                                return FORAGING_FORAGER_0_ACTION_1; /* leaf 36 */
                            }
                        } else {
                            if (x[FORAGING_FORAGER_0_X_FOOD_1_DOWN] <= 0x1.8p+0f) { /* node 37: 1.5 */
                                return FORAGING_FORAGER_0_ACTION_3; /* leaf 38 */
                            } else {
                                return FORAGING_FORAGER_0_ACTION_2; /* leaf 39 */
                            }
                        }
                    } else {
                        if (x[FORAGING_FORAGER_0_X_FOOD_1_DOWN] <= -0x1.8p+0f) { /* node 40: -1.5 */
                            if (x[FORAGING_FORAGER_0_X_FOOD_1_RIGHT] <= 0x1.4p+1f) { /* node 41: 2.5 */
                                return FORAGING_FORAGER_0_ACTION_1; /* leaf 42 */
                            } else {
                                return FORAGING_FORAGER_0_ACTION_4; /* leaf 43 */
                            }
                        } else {
                            if (x[FORAGING_FORAGER_0_X_FOOD_1_DOWN] <= -0x1p-1f) { /* node 44: -0.5 */
                                return FORAGING_FORAGER_0_ACTION_4; /* leaf 45 */
                            } else {
                                return FORAGING_FORAGER_0_ACTION_2; /* leaf 46 */
                            }
                        }
                    }
                }
            } else {
                if (x[FORAGING_FORAGER_0_X_FOOD_0_RIGHT] <= -0x1p-1f) { /* node 47: -0.5 */
                    if (x[FORAGING_FORAGER_0_X_MATE_0_RIGHT] <= 0x1p-1f) { /* node 48: 0.5 */
                        if (x[FORAGING_FORAGER_0_X_MATE_0_DOWN] <= -0x1p-1f) { /* node 49: -0.5 */
                            if (x[FORAGING_FORAGER_0_X_MATE_0_DOWN] <= -0x1.8p+0f) { /* node 50: -1.5 */
                                return FORAGING_FORAGER_0_ACTION_1; /* leaf 51 */
                            } else {
                                return FORAGING_FORAGER_0_ACTION_3; /* leaf 52 */
                            }
                        } else {
                            if (x[FORAGING_FORAGER_0_X_FOOD_0_RIGHT] <= -0x1.8p+0f) { /* node 53: -1.5 */
                                return FORAGING_FORAGER_0_ACTION_3; /* leaf 54 */
                            } else {
                                return FORAGING_FORAGER_0_ACTION_1; /* leaf 55 */
                            }
                        }
                    } else {
                        if (x[FORAGING_FORAGER_0_X_FOOD_0_RIGHT] <= -0x1.8p+0f) { /* node 56: -1.5 */
                            if (x[FORAGING_FORAGER_0_X_FOOD_0_DOWN] <= -0x1.8p+0f) { /* node 57: -1.5 */
                                return FORAGING_FORAGER_0_ACTION_1; /* leaf 58 */
                            } else {
                                return FORAGING_FORAGER_0_ACTION_3; /* leaf 59 */
                            }
                        } else {
                            return FORAGING_FORAGER_0_ACTION_1; /* leaf 60 */
                        }
                    }
                } else {
                    if (x[FORAGING_FORAGER_0_X_MATE_0_RIGHT] <= -0x1p-1f) { /* node 61: -0.5 */
                        if (x[FORAGING_FORAGER_0_X_FOOD_1_RIGHT] <= 0x1.4p+1f) { /* node 62: 2.5 */
                            if (x[FORAGING_FORAGER_0_X_FOOD_0_RIGHT] <= 0x1.4p+1f) { /* node 63: 2.5 */
                                return FORAGING_FORAGER_0_ACTION_1; /* leaf 64 */
                            } else {
                                return FORAGING_FORAGER_0_ACTION_4; /* leaf 65 */
                            }
                        } else {
                            if (x[FORAGING_FORAGER_0_X_FOOD_0_RIGHT] <= 0x1.8p+0f) { /* node 66: 1.5 */
                                return FORAGING_FORAGER_0_ACTION_1; /* leaf 67 */
                            } else {
                                return FORAGING_FORAGER_0_ACTION_4; /* leaf 68 */
                            }
                        }
                    } else {
                        if (x[FORAGING_FORAGER_0_X_MATE_0_DOWN] <= -0x1p-1f) { /* node 69: -0.5 */
                            if (x[FORAGING_FORAGER_0_X_MATE_0_DOWN] <= -0x1.8p+0f) { /* node 70: -1.5 */
                                return FORAGING_FORAGER_0_ACTION_1; /* leaf 71 */
                            } else {
                                return FORAGING_FORAGER_0_ACTION_4; /* leaf 72 */
                            }
                        } else {
                            if (x[FORAGING_FORAGER_0_X_MATE_0_RIGHT] <= 0x1.8p+0f) { /* node 73: 1.5 */
                                return FORAGING_FORAGER_0_ACTION_1; /* leaf 74 */
                            } else {
                                return FORAGING_FORAGER_0_ACTION_4; /* leaf 75 */
                            }
                        }
                    }
                }
            }
        } else {
            if (x[FORAGING_FORAGER_0_X_FOOD_0_RIGHT] <= -0x1p-1f) { /* node 76: -0.5 */
                if (x[FORAGING_FORAGER_0_X_MATE_0_RIGHT] <= -0x1.8p+0f) { /* node 77: -1.5 */
                    if (x[FORAGING_FORAGER_0_X_FOOD_0_RIGHT] <= -0x1.8p+0f) { /* node 78: -1.5 */
                        if (x[FORAGING_FORAGER_0_X_FOOD_1_LATER] <= -0x1p+0f) { /* node 79: -1 */
                            if (x[FORAGING_FORAGER_0_X_FOOD_1_RIGHT] <= -0x1p-1f) { /* node 80: -0.5 */
                                return FORAGING_FORAGER_0_ACTION_2; /* leaf 81 */
                            } else {
                                return FORAGING_FORAGER_0_ACTION_5; /* leaf 82 */
                            }
                        } else {
                            if (x[FORAGING_FORAGER_0_X_FOOD_0_DOWN] <= 0x1.8p+0f) { /* node 83: 1.5 */
                                return FORAGING_FORAGER_0_ACTION_3; /* leaf 84 */
                            } else {
                                return FORAGING_FORAGER_0_ACTION_2; /* leaf 85 */
                            }
                        }
                    } else {
                        return FORAGING_FORAGER_0_ACTION_2; /* leaf 86 */
                    }
                } else {
                    if (x[FORAGING_FORAGER_0_X_MATE_0_DOWN] <= 0x1p-1f) { /* node 87: 0.5 */
                        if (x[FORAGING_FORAGER_0_X_MATE_0_DOWN] <= -0x1p-1f) { /* node 88: -0.5 */
                            if (x[FORAGING_FORAGER_0_X_FOOD_1_LATER] <= -0x1p+0f) { /* node 89: -1 */
                                return FORAGING_FORAGER_0_ACTION_5; /* leaf 90 */
                            } else {
                                return FORAGING_FORAGER_0_ACTION_3; /* leaf 91 */
                            }
                        } else {
                            if (x[FORAGING_FORAGER_0_X_MATE_0_RIGHT] <= -0x1p-1f) { /* node 92: -0.5 */
                                return FORAGING_FORAGER_0_ACTION_2; /* leaf 93 */
                            } else {
                                return FORAGING_FORAGER_0_ACTION_3; /* leaf 94 */
                            }
                        }
                    } else {
                        if (x[FORAGING_FORAGER_0_X_FOOD_0_DOWN] <= 0x1p-1f) { /* node 95: 0.5 */
                            if (x[FORAGING_FORAGER_0_X_FOOD_1_LATER] <= -0x1.4p+2f) { /* node 96: -5 */
                                return FORAGING_FORAGER_0_ACTION_5; /* leaf 97 */
                            } else {
                                return FORAGING_FORAGER_0_ACTION_3; /* leaf 98 */
                            }
                        } else {
                            if (x[FORAGING_FORAGER_0_X_MATE_0_RIGHT] <= 0x1p-1f) { /* node 99: 0.5 */
                                return FORAGING_FORAGER_0_ACTION_3; /* leaf 100 */
                            } else {
                                return FORAGING_FORAGER_0_ACTION_2; /* leaf 101 */
                            }
                        }
                    }
                }
            } else {
                if (x[FORAGING_FORAGER_0_X_MATE_0_RIGHT] <= 0x1.8p+0f) { /* node 102: 1.5 */
                    if (x[FORAGING_FORAGER_0_X_MATE_0_RIGHT] <= 0x1p-1f) { /* node 103: 0.5 */
                        if (x[FORAGING_FORAGER_0_X_FOOD_1_AWAY] <= 0x1.8p+0f) { /* node 104: 1.5 */
                            if (x[FORAGING_FORAGER_0_X_FOOD_1_DOWN] <= 0x1p-1f) { /* node 105: 0.5 */
                                return FORAGING_FORAGER_0_ACTION_4; /* leaf 106 */
                            } else {
                                return FORAGING_FORAGER_0_ACTION_5; /* leaf 107 */
                            }
                        } else {
                            if (x[FORAGING_FORAGER_0_X_MATE_0_DOWN] <= 0x1.8p+0f) { /* node 108: 1.5 */
                                return FORAGING_FORAGER_0_ACTION_4; /* leaf 109 */
                            } else {
                                return FORAGING_FORAGER_0_ACTION_2; /* leaf 110 */
                            }
                        }
                    } else {
                        if (x[FORAGING_FORAGER_0_X_MATE_0_DOWN] <= -0x1p-1f) { /* node 111: -0.5 */
                            if (x[FORAGING_FORAGER_0_X_FOOD_1_LATER] <= -0x1p+0f) { /* node 112: -1 */
                                return FORAGING_FORAGER_0_ACTION_2; /* leaf 113 */
                            } else {
                                return FORAGING_FORAGER_0_ACTION_4; /* leaf 114 */
                            }
                        } else {
                            if (x[FORAGING_FORAGER_0_X_MATE_0_DOWN] <= 0x1p-1f) { /* node 115: 0.5 */
                                return FORAGING_FORAGER_0_ACTION_2; /* leaf 116 */
                            } else {
                                return FORAGING_FORAGER_0_ACTION_2; /* leaf 117 */
                            }
                        }
                    }
                } else {
                    if (x[FORAGING_FORAGER_0_X_FOOD_0_RIGHT] <= 0x1.8p+0f) { /* node 118: 1.5 */
                        return FORAGING_FORAGER_0_ACTION_2; /* leaf 119 */
                    } else {
                        if (x[FORAGING_FORAGER_0_X_FOOD_1_LATER] <= -0x1p+0f) { /* node 120: -1 */
                            if (x[FORAGING_FORAGER_0_X_FOOD_1_RIGHT] <= 0x1.4p+1f) { /* node 121: 2.5 */
                                return FORAGING_FORAGER_0_ACTION_2; /* leaf 122 */
                            } else {
                                return FORAGING_FORAGER_0_ACTION_4; /* leaf 123 */
                            }
                        } else {
                            return FORAGING_FORAGER_0_ACTION_4; /* leaf 124 */
                        }
                    }
                }
            }
        }
    }
}

static inline int foraging_forager_0_finite(const float *x)
{
    int finite = 1;
    int i;
    for (i = 0; i < FORAGING_FORAGER_0_N_FEATURES; i++) {
        if (!((x[i] >= -0x1.fffffep+127f) && (x[i] <= 0x1.fffffep+127f))) {
            finite = 0;
        }
    }
    return finite;
}

static inline int foraging_forager_0_in_range(const float *x)
{
    int within = 1;
    if (!((x[0] >= -0x1.8cp+6f) && (x[0] <= 0x1.8cp+6f))) {
        within = 0;
    }
    if (!((x[1] >= -0x1.8cp+6f) && (x[1] <= 0x1.8cp+6f))) {
        within = 0;
    }
    if (!((x[2] >= -0x1.8cp+6f) && (x[2] <= 0x1.8cp+6f))) {
        within = 0;
    }
    if (!((x[3] >= -0x1.8cp+6f) && (x[3] <= 0x1.8cp+6f))) {
        within = 0;
    }
    if (!((x[4] >= -0x1.8cp+6f) && (x[4] <= 0x1.8cp+6f))) {
        within = 0;
    }
    if (!((x[5] >= -0x1.8cp+6f) && (x[5] <= 0x1.8cp+6f))) {
        within = 0;
    }
    if (!((x[6] >= -0x1.8cp+6f) && (x[6] <= 0x1.8cp+6f))) {
        within = 0;
    }
    if (!((x[7] >= -0x1.8cp+6f) && (x[7] <= 0x1.8cp+6f))) {
        within = 0;
    }
    if (!((x[8] >= -0x1.8cp+6f) && (x[8] <= 0x1.8cp+6f))) {
        within = 0;
    }
    if (!((x[9] >= -0x1.8cp+6f) && (x[9] <= 0x1.8cp+6f))) {
        within = 0;
    }
    return within;
}

static inline void foraging_forager_0_act_rows(const float *x, long n, unsigned char *actions)
{
    static const float threshold[127] = {0x1.8p+0f, -0x1p+0f, -0x1p-1f, 0x1.8p+0f, 0x0p+0f, -0x1p+0f, -0x1p-1f, 0x0p+0f, -0x1.8p+0f, 0x0p+0f, 0x0p+0f, 0x1.8p+0f, -0x1p-1f, -0x1.8p+0f, 0x1.8p+0f, 0x0p+0f, 0x0p+0f, 0x1.8p+0f, 0x1.8p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, -0x1p-1f, 0x1p-1f, -0x1p-1f, -0x1.8p+0f, 0x1p-1f, 0x1p-1f, 0x1.8p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, -0x1.4p+1f, -0x1.7ep+6f, 0x1.8p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, -0x1.8p+0f, -0x1.8p+0f, -0x1p-1f, -0x1.8p+0f, 0x1.4p+1f, -0x1p-1f, -0x1p+0f, 0x0p+0f, -0x1p-1f, 0x1p-1f, 0x1.8p+0f, -0x1p-1f, 0x0p+0f, -0x1p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x1.4p+1f, 0x0p+0f, -0x1p-1f, -0x1p-1f, -0x1.7ep+6f, 0x1.4p+1f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, -0x1.4p+1f, 0x1.8p+0f, 0x1.4p+1f, -0x1p-1f, -0x1.8p+0f, -0x1.8p+0f, -0x1.8p+0f, 0x0p+0f, 0x1.4p+1f, 0x1.8p+0f, -0x1.8p+0f, 0x1.8p+0f, -0x1p-1f, 0x1.8p+0f, 0x0p+0f, 0x0p+0f, -0x1p+0f, -0x1p-1f, -0x1.4p+2f, 0x1p-1f, 0x1p-1f, 0x1.8p+0f, -0x1p+0f, 0x1p-1f, 0x0p+0f, 0x0p+0f, 0x1.4p+1f, 0x0p+0f};
    static const unsigned char feature[127] = {2, 7, 0, 6, 0, 7, 1, 0, 5, 0, 0, 6, 1, 9, 9, 0, 0, 4, 5, 0, 0, 0, 0, 0, 5, 9, 9, 1, 8, 9, 1, 0, 0, 0, 0, 0, 5, 7, 4, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 4, 4, 8, 1, 5, 8, 7, 0, 8, 0, 6, 8, 0, 7, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 4, 0, 5, 4, 7, 5, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 5, 4, 5, 4, 8, 1, 0, 0, 1, 1, 8, 9, 5, 0, 0, 0, 7, 9, 7, 9, 4, 8, 7, 8, 0, 0, 5, 0};
    static const unsigned char action[128] = {5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 3, 3, 3, 3, 3, 3, 2, 2, 3, 4, 1, 2, 2, 4, 2, 2, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 3, 1, 3, 2, 1, 4, 4, 2, 1, 3, 3, 1, 1, 3, 1, 1, 1, 4, 1, 4, 1, 4, 1, 4, 2, 5, 3, 2, 2, 2, 2, 2, 5, 3, 2, 3, 5, 3, 3, 2, 4, 5, 4, 2, 2, 4, 2, 2, 2, 2, 2, 2, 2, 4, 4, 4};
    long row;
    /* eight observations side by side, so that none waits for another */
    const long together = n - (n % 8);
    for (row = 0; row < together; row += 8) {
        const float *const seen = &x[row * FORAGING_FORAGER_0_N_FEATURES];
        int i[8] = {0, 0, 0, 0, 0, 0, 0, 0};
        int level;
        int k;
        for (level = 0; level < 7; level++) {
            for (k = 0; k < 8; k++) {
                i[k] = (2 * i[k]) + 1 + ((seen[(k * FORAGING_FORAGER_0_N_FEATURES) + feature[i[k]]] <= threshold[i[k]]) ? 0 : 1);
            }
        }
        for (k = 0; k < 8; k++) {
            actions[row + k] = action[i[k] - 127];
        }
    }
    for (row = together; row < n; row++) {
        const float *const seen = &x[row * FORAGING_FORAGER_0_N_FEATURES];
        int i = 0;
        int level;
        for (level = 0; level < 7; level++) {
            i = (2 * i) + 1 + ((seen[feature[i]] <= threshold[i]) ? 0 : 1);
        }
        actions[row] = action[i - 127];
    }
}

static inline void foraging_forager_0_act_columns(const float *const *x, long n, unsigned char *actions)
{
    const float *const x0 = x[FORAGING_FORAGER_0_X_FOOD_0_DOWN];
    const float *const x1 = x[FORAGING_FORAGER_0_X_FOOD_0_RIGHT];
    const float *const x2 = x[FORAGING_FORAGER_0_X_FOOD_0_AWAY];
    const float *const x4 = x[FORAGING_FORAGER_0_X_FOOD_1_DOWN];
    const float *const x5 = x[FORAGING_FORAGER_0_X_FOOD_1_RIGHT];
    const float *const x6 = x[FORAGING_FORAGER_0_X_FOOD_1_AWAY];
    const float *const x7 = x[FORAGING_FORAGER_0_X_FOOD_1_LATER];
    const float *const x8 = x[FORAGING_FORAGER_0_X_MATE_0_DOWN];
    const float *const x9 = x[FORAGING_FORAGER_0_X_MATE_0_RIGHT];
    long first;
    long row;
    /* one select per split, leaves first, each into its own variable: compilers turn this into vector code */
    for (first = 0; first < n; first += 256) {
        float chosen[256];
        const long left = n - first;
        const long count = (left < 256) ? left : 256;
        for (row = 0; row < count; row++) {
            const float n121 = (x5[first + row] <= 0x1.4p+1f) ? 2.0f : 4.0f;
            const float n120 = (x7[first + row] <= -0x1p+0f) ? n121 : 4.0f;
            const float n118 = (x1[first + row] <= 0x1.8p+0f) ? 2.0f : n120;
            const float n115 = (x8[first + row] <= 0x1p-1f) ? 2.0f : 2.0f;
            const float n112 = (x7[first + row] <= -0x1p+0f) ? 2.0f : 4.0f;
            const float n111 = (x8[first + row] <= -0x1p-1f) ? n112 : n115;
            const float n108 = (x8[first + row] <= 0x1.8p+0f) ? 4.0f : 2.0f;
            const float n105 = (x4[first + row] <= 0x1p-1f) ? 4.0f : 5.0f;
            const float n104 = (x6[first + row] <= 0x1.8p+0f) ? n105 : n108;
            const float n103 = (x9[first + row] <= 0x1p-1f) ? n104 : n111;
            const float n102 = (x9[first + row] <= 0x1.8p+0f) ? n103 : n118;
            const float n99 = (x9[first + row] <= 0x1p-1f) ? 3.0f : 2.0f;
            const float n96 = (x7[first + row] <= -0x1.4p+2f) ? 5.0f : 3.0f;
            const float n95 = (x0[first + row] <= 0x1p-1f) ? n96 : n99;
            const float n92 = (x9[first + row] <= -0x1p-1f) ? 2.0f : 3.0f;
            const float n89 = (x7[first + row] <= -0x1p+0f) ? 5.0f : 3.0f;
            const float n88 = (x8[first + row] <= -0x1p-1f) ? n89 : n92;
            const float n87 = (x8[first + row] <= 0x1p-1f) ? n88 : n95;
            const float n83 = (x0[first + row] <= 0x1.8p+0f) ? 3.0f : 2.0f;
            const float n80 = (x5[first + row] <= -0x1p-1f) ? 2.0f : 5.0f;
            const float n79 = (x7[first + row] <= -0x1p+0f) ? n80 : n83;
            const float n78 = (x1[first + row] <= -0x1.8p+0f) ? n79 : 2.0f;
            const float n77 = (x9[first + row] <= -0x1.8p+0f) ? n78 : n87;
            const float n76 = (x1[first + row] <= -0x1p-1f) ? n77 : n102;
            const float n73 = (x9[first + row] <= 0x1.8p+0f) ? 1.0f : 4.0f;
            const float n70 = (x8[first + row] <= -0x1.8p+0f) ? 1.0f : 4.0f;
            const float n69 = (x8[first + row] <= -0x1p-1f) ? n70 : n73;
            const float n66 = (x1[first + row] <= 0x1.8p+0f) ? 1.0f : 4.0f;
            const float n63 = (x1[first + row] <= 0x1.4p+1f) ? 1.0f : 4.0f;
            const float n62 = (x5[first + row] <= 0x1.4p+1f) ? n63 : n66;
            const float n61 = (x9[first + row] <= -0x1p-1f) ? n62 : n69;
            const float n57 = (x0[first + row] <= -0x1.8p+0f) ? 1.0f : 3.0f;
            const float n56 = (x1[first + row] <= -0x1.8p+0f) ? n57 : 1.0f;
            const float n53 = (x1[first + row] <= -0x1.8p+0f) ? 3.0f : 1.0f;
            const float n50 = (x8[first + row] <= -0x1.8p+0f) ? 1.0f : 3.0f;
            const float n49 = (x8[first + row] <= -0x1p-1f) ? n50 : n53;
            const float n48 = (x9[first + row] <= 0x1p-1f) ? n49 : n56;
            const float n47 = (x1[first + row] <= -0x1p-1f) ? n48 : n61;
            const float n44 = (x4[first + row] <= -0x1p-1f) ? 4.0f : 2.0f;
            const float n41 = (x5[first + row] <= 0x1.4p+1f) ? 1.0f : 4.0f;
            const float n40 = (x4[first + row] <= -0x1.8p+0f) ? n41 : n44;
            const float n37 = (x4[first + row] <= 0x1.8p+0f) ? 3.0f : 2.0f;
            const float n34 = (x5[first + row] <= -0x1.4p+1f) ? 3.0f : 1.0f;
            const float n33 = (x4[first + row] <= -0x1.8p+0f) ? n34 : n37;
            const float n32 = (x5[first + row] <= -0x1p-1f) ? n33 : n40;
            const float n30 = (x6[first + row] <= 0x1.8p+0f) ? 5.0f : n32;
            const float n29 = (x7[first + row] <= -0x1p+0f) ? n30 : n47;
            const float n28 = (x0[first + row] <= -0x1p-1f) ? n29 : n76;
            const float n24 = (x5[first + row] <= 0x1.4p+1f) ? 2.0f : 2.0f;
            const float n21 = (x7[first + row] <= -0x1.7ep+6f) ? 2.0f : 4.0f;
            const float n20 = (x4[first + row] <= 0x1.8p+0f) ? n21 : n24;
            const float n17 = (x4[first + row] <= -0x1p-1f) ? 1.0f : 2.0f;
            const float n14 = (x5[first + row] <= -0x1p-1f) ? 3.0f : 4.0f;
            const float n13 = (x7[first + row] <= -0x1.7ep+6f) ? n14 : n17;
            const float n12 = (x5[first + row] <= 0x1.8p+0f) ? n13 : n20;
            const float n8 = (x4[first + row] <= 0x1.4p+1f) ? 3.0f : 3.0f;
            const float n7 = (x5[first + row] <= -0x1.4p+1f) ? n8 : 2.0f;
            const float n5 = (x4[first + row] <= 0x1.8p+0f) ? 3.0f : n7;
            const float n4 = (x5[first + row] <= -0x1.8p+0f) ? n5 : n12;
            const float n2 = (x6[first + row] <= 0x1.8p+0f) ? 5.0f : n4;
            const float n1 = (x7[first + row] <= -0x1p+0f) ? n2 : 5.0f;
            const float n0 = (x2[first + row] <= 0x1.8p+0f) ? n1 : n28;
            chosen[row] = n0;
        }
        for (row = 0; row < count; row++) {
            actions[first + row] = (unsigned char)chosen[row];
        }
    }
}

/* forager_1, team foragers: 56 leaves, at most 7 comparisons; tables of 763 bytes where they are used */

enum {
    FORAGING_FORAGER_1_X_FOOD_0_DOWN = 0, /* cells, [-99.0, 99.0] */
    FORAGING_FORAGER_1_X_FOOD_0_RIGHT = 1, /* cells, [-99.0, 99.0] */
    FORAGING_FORAGER_1_X_FOOD_0_AWAY = 2, /* cells, [-99.0, 99.0] */
    FORAGING_FORAGER_1_X_FOOD_0_LATER = 3, /* cells, [-99.0, 99.0] */
    FORAGING_FORAGER_1_X_FOOD_1_DOWN = 4, /* cells, [-99.0, 99.0] */
    FORAGING_FORAGER_1_X_FOOD_1_RIGHT = 5, /* cells, [-99.0, 99.0] */
    FORAGING_FORAGER_1_X_FOOD_1_AWAY = 6, /* cells, [-99.0, 99.0] */
    FORAGING_FORAGER_1_X_FOOD_1_LATER = 7, /* cells, [-99.0, 99.0] */
    FORAGING_FORAGER_1_X_MATE_0_DOWN = 8, /* cells, [-99.0, 99.0] */
    FORAGING_FORAGER_1_X_MATE_0_RIGHT = 9, /* cells, [-99.0, 99.0] */
    FORAGING_FORAGER_1_N_FEATURES = 10
};

enum {
    FORAGING_FORAGER_1_ACTION_0 = 0,
    FORAGING_FORAGER_1_ACTION_1 = 1,
    FORAGING_FORAGER_1_ACTION_2 = 2,
    FORAGING_FORAGER_1_ACTION_3 = 3,
    FORAGING_FORAGER_1_ACTION_4 = 4,
    FORAGING_FORAGER_1_ACTION_5 = 5,
    FORAGING_FORAGER_1_N_ACTIONS = 6
};

static inline int foraging_forager_1_act(const float *x)
{
    if (x[FORAGING_FORAGER_1_X_FOOD_1_AWAY] <= 0x1.8p+0f) { /* node 0: 1.5 */
        if (x[FORAGING_FORAGER_1_X_FOOD_1_LATER] <= -0x1p+0f) { /* node 1: -1 */
            return FORAGING_FORAGER_1_ACTION_5; /* leaf 2 */
        } else {
            if (x[FORAGING_FORAGER_1_X_FOOD_0_AWAY] <= 0x1.8p+0f) { /* node 3: 1.5 */
                return FORAGING_FORAGER_1_ACTION_5; /* leaf 4 */
            } else {
                if (x[FORAGING_FORAGER_1_X_FOOD_0_RIGHT] <= -0x1p-1f) { /* node 5: -0.5 */
                    if (x[FORAGING_FORAGER_1_X_FOOD_0_DOWN] <= -0x1p-1f) { /* node 6: -0.5 */
                        if (x[FORAGING_FORAGER_1_X_FOOD_0_DOWN] <= -0x1.8p+0f) { /* node 7: -1.5 */
                            if (x[FORAGING_FORAGER_1_X_FOOD_0_RIGHT] <= -0x1.4p+1f) { /* node 8: -2.5 */
                                return FORAGING_FORAGER_1_ACTION_3; /* leaf 9 */
                            } else {
                                return FORAGING_FORAGER_1_ACTION_1; /* leaf 10 */
                            }
                        } else {
                            if (x[FORAGING_FORAGER_1_X_MATE_0_DOWN] <= -0x1p-1f) { /* node 11: -0.5 */
                                return FORAGING_FORAGER_1_ACTION_3; /* leaf 12 */
                            } else {
                                return FORAGING_FORAGER_1_ACTION_1; /* leaf 13 */
                            }
                        }
                    } else {
                        if (x[FORAGING_FORAGER_1_X_FOOD_1_AWAY] <= 0x1p-1f) { /* node 14: 0.5 */
                            if (x[FORAGING_FORAGER_1_X_FOOD_0_DOWN] <= 0x1.8p+0f) { /* node 15: 1.5 */
                                return FORAGING_FORAGER_1_ACTION_3; /* leaf 16 */
                            } else {
                                return FORAGING_FORAGER_1_ACTION_2; /* leaf 17 */
                            }
                        } else {
                            if (x[FORAGING_FORAGER_1_X_FOOD_1_DOWN] <= 0x1p-1f) { /* node 18: 0.5 */
                                return FORAGING_FORAGER_1_ACTION_2; /* leaf 19 */
                            } else {
                                return FORAGING_FORAGER_1_ACTION_3; /* leaf 20 */
                            }
                        }
                    }
                } else {
                    if (x[FORAGING_FORAGER_1_X_FOOD_0_RIGHT] <= 0x1.8p+0f) { /* node 21: 1.5 */
                        if (x[FORAGING_FORAGER_1_X_MATE_0_DOWN] <= -0x1p-1f) { /* node 22: -0.5 */
                            if (x[FORAGING_FORAGER_1_X_FOOD_0_DOWN] <= -0x1.8p+0f) { /* node 23: -1.5 */
                                return FORAGING_FORAGER_1_ACTION_1; /* leaf 24 */
                            } else {
                                return FORAGING_FORAGER_1_ACTION_4; /* leaf 25 */
                            }
                        } else {
                            if (x[FORAGING_FORAGER_1_X_FOOD_0_DOWN] <= -0x1p-1f) { /* node 26: -0.5 */
                                return FORAGING_FORAGER_1_ACTION_1; /* leaf 27 */
                            } else {
                                return FORAGING_FORAGER_1_ACTION_4; /* leaf 28 */
                            }
                        }
                    } else {
                        if (x[FORAGING_FORAGER_1_X_FOOD_1_RIGHT] <= 0x1p-1f) { /* node 29: 0.5 */
                            if (x[FORAGING_FORAGER_1_X_FOOD_0_DOWN] <= -0x1.8p+0f) { /* node 30: -1.5 */
                                return FORAGING_FORAGER_1_ACTION_1; /* leaf 31 */
                            } else {
                                return FORAGING_FORAGER_1_ACTION_4; /* leaf 32 */
                            }
                        } else {
                            return FORAGING_FORAGER_1_ACTION_1; /* leaf 33 */
                        }
                    }
                }
            }
        }
    } else {
        if (x[FORAGING_FORAGER_1_X_FOOD_1_LATER] <= -0x1p+0f) { /* node 34: -1 */
            if (x[FORAGING_FORAGER_1_X_FOOD_1_DOWN] <= 0x1.8p+0f) { /* node 35: 1.5 */
                if (x[FORAGING_FORAGER_1_X_FOOD_1_RIGHT] <= -0x1p-1f) { /* node 36: -0.5 */
                    if (x[FORAGING_FORAGER_1_X_FOOD_1_RIGHT] <= -0x1.8p+0f) { /* node 37: -1.5 */
                        if (x[FORAGING_FORAGER_1_X_FOOD_1_DOWN] <= -0x1.8p+0f) { /* node 38: -1.5 */
                            if (x[FORAGING_FORAGER_1_X_FOOD_1_RIGHT] <= -0x1.4p+1f) { /* node 39: -2.5 */
                                return FORAGING_FORAGER_1_ACTION_3; /* leaf 40 */
                            } else {
                                return FORAGING_FORAGER_1_ACTION_1; /* leaf 41 */
                            }
                        } else {
                            return FORAGING_FORAGER_1_ACTION_3; /* leaf 42 */
                        }
                    } else {
                        if (x[FORAGING_FORAGER_1_X_FOOD_1_DOWN] <= -0x1p-1f) { /* node 43: -0.5 */
                            if (x[FORAGING_FORAGER_1_X_FOOD_1_LATER] <= -0x1.2p+3f) { /* node 44: -9 */
                                return FORAGING_FORAGER_1_ACTION_3; /* leaf 45 */
                            } else {
                                return FORAGING_FORAGER_1_ACTION_1; /* leaf 46 */
                            }
                        } else {
                            if (x[FORAGING_FORAGER_1_X_MATE_0_DOWN] <= 0x1p-1f) { /* node 47: 0.5 */
                                return FORAGING_FORAGER_1_ACTION_2; /* leaf 48 */
                            } else {
                                return FORAGING_FORAGER_1_ACTION_3; /* leaf 49 */
                            }
                        }
                    }
                } else {
                    if (x[FORAGING_FORAGER_1_X_FOOD_1_RIGHT] <= 0x1.8p+0f) { /* node 50: 1.5 */
                        if (x[FORAGING_FORAGER_1_X_FOOD_1_DOWN] <= -0x1p-1f) { /* node 51: -0.5 */
                            if (x[FORAGING_FORAGER_1_X_FOOD_0_RIGHT] <= -0x1.4p+1f) { /* node 52: -2.5 */
                                return FORAGING_FORAGER_1_ACTION_4; /* leaf 53 */
                            } else {
                                return FORAGING_FORAGER_1_ACTION_1; /* leaf 54 */
                            }
                        } else {
                            if (x[FORAGING_FORAGER_1_X_MATE_0_DOWN] <= 0x1p-1f) { /* node 55: 0.5 */
                                return FORAGING_FORAGER_1_ACTION_2; /* leaf 56 */
                            } else {
                                return FORAGING_FORAGER_1_ACTION_4; /* leaf 57 */
                            }
                        }
                    } else {
                        if (x[FORAGING_FORAGER_1_X_FOOD_1_LATER] <= -0x1.7ep+6f) { /* node 58: -95.5 */
                            return FORAGING_FORAGER_1_ACTION_2; /* leaf 59 */
                        } else {
                            if (x[FORAGING_FORAGER_1_X_FOOD_0_DOWN] <= -0x1.cp+1f) { /* node 60: -3.5 */
                                return FORAGING_FORAGER_1_ACTION_1; /* leaf 61 */
                            } else {
                                return FORAGING_FORAGER_1_ACTION_4; /* leaf 62 */
                            }
                        }
                    }
                }
            } else {
                if (x[FORAGING_FORAGER_1_X_FOOD_1_RIGHT] <= 0x1.4p+1f) { /* node 63: 2.5 */
                    if (x[FORAGING_FORAGER_1_X_FOOD_1_RIGHT] <= -0x1.4p+1f) { /* node 64: -2.5 */
                        if (x[FORAGING_FORAGER_1_X_FOOD_1_DOWN] <= 0x1.4p+1f) { /* node 65: 2.5 */
                            return FORAGING_FORAGER_1_ACTION_3; /* leaf 66 */
                        } else {
                            return FORAGING_FORAGER_1_ACTION_2; /* leaf 67 */
                        }
                    } else {
                        if (x[FORAGING_FORAGER_1_X_FOOD_1_LATER] <= -0x1.8p+1f) { /* node 68: -3 */
                            return FORAGING_FORAGER_1_ACTION_2; /* leaf 69 */
                        } else {
                            if (x[FORAGING_FORAGER_1_X_FOOD_1_AWAY] <= 0x1.4p+1f) { /* node 70: 2.5 */
                                return FORAGING_FORAGER_1_ACTION_2; /* leaf 71 */
                            } else {
                                return FORAGING_FORAGER_1_ACTION_2; /* leaf 72 */
                            }
                        }
                    }
                } else {
                    if (x[FORAGING_FORAGER_1_X_FOOD_1_DOWN] <= 0x1.4p+1f) { /* node 73: 2.5 */
                        return FORAGING_FORAGER_1_ACTION_4; /* leaf 74 */
                    } else {
                        if (x[FORAGING_FORAGER_1_X_FOOD_1_RIGHT] <= 0x1.cp+1f) { /* node 75: 3.5 */
                            return FORAGING_FORAGER_1_ACTION_2; /* leaf 76 */
                        } else {
                            return FORAGING_FORAGER_1_ACTION_4; /* leaf 77 */
                        }
                    }
                }
            }
        } else {
            if (x[FORAGING_FORAGER_1_X_FOOD_0_AWAY] <= 0x1.8p+0f) { /* node 78: 1.5 */
                return FORAGING_FORAGER_1_ACTION_5; /* leaf 79 */
            } else {
                if (x[FORAGING_FORAGER_1_X_FOOD_0_DOWN] <= -0x1p-1f) { /* node 80: -0.5 */
                    if (x[FORAGING_FORAGER_1_X_FOOD_0_RIGHT] <= -0x1p-1f) { /* node 81: -0.5 */
                        if (x[FORAGING_FORAGER_1_X_FOOD_0_DOWN] <= -0x1.8p+0f) { /* node 82: -1.5 */
                            if (x[FORAGING_FORAGER_1_X_FOOD_0_RIGHT] <= -0x1.cp+1f) { /* node 83: -3.5 */
                                return FORAGING_FORAGER_1_ACTION_3; /* leaf 84 */
                            } else {
                                return FORAGING_FORAGER_1_ACTION_1; /* leaf 85 */
                            }
                        } else {
                            if (x[FORAGING_FORAGER_1_X_MATE_0_DOWN] <= -0x1p-1f) { /* node 86: -0.5 */
                                return FORAGING_FORAGER_1_ACTION_3; /* leaf 87 */
                            } else {
                                return FORAGING_FORAGER_1_ACTION_1; /* leaf 88 */
                            }
                        }
                    } else {
                        if (x[FORAGING_FORAGER_1_X_MATE_0_DOWN] <= -0x1.8p+0f) { /* node 89: -1.5 */
                            if (x[FORAGING_FORAGER_1_X_FOOD_0_RIGHT] <= 0x1.8p+0f) { /* node 90: 1.5 */
                                return FORAGING_FORAGER_1_ACTION_1; /* leaf 91 */
                            } else {
                                return FORAGING_FORAGER_1_ACTION_1; /* leaf 92 */
                            }
                        } else {
                            if (x[FORAGING_FORAGER_1_X_MATE_0_RIGHT] <= -0x1p-1f) { /* node 93: -0.5 */
                                return FORAGING_FORAGER_1_ACTION_1; /* leaf 94 */
                            } else {
                                return FORAGING_FORAGER_1_ACTION_4; /* leaf 95 */
                            }
                        }
                    }
                } else {
                    if (x[FORAGING_FORAGER_1_X_FOOD_0_RIGHT] <= -0x1.8p+0f) { /* node 96: -1.5 */
                        if (x[FORAGING_FORAGER_1_X_FOOD_0_DOWN] <= 0x1.8p+0f) { /* node 97: 1.5 */
                            if (x[FORAGING_FORAGER_1_X_FOOD_1_LATER] <= 0x1.cp+2f) { /* node 98: 7 */
                                return FORAGING_FORAGER_1_ACTION_3; /* leaf 99 */
                            } else {
                                return FORAGING_FORAGER_1_ACTION_3; /* leaf 100 */
                            }
                        } else {
                            if (x[FORAGING_FORAGER_1_X_FOOD_0_RIGHT] <= -0x1.4p+1f) { /* node 101: -2.5 */
                                return FORAGING_FORAGER_1_ACTION_3; /* leaf 102 */
                            } else {
                                return FORAGING_FORAGER_1_ACTION_2; /* leaf 103 */
                            }
                        }
                    } else {
                        if (x[FORAGING_FORAGER_1_X_FOOD_0_RIGHT] <= 0x1.8p+0f) { /* node 104: 1.5 */
                            if (x[FORAGING_FORAGER_1_X_FOOD_0_DOWN] <= 0x1.8p+0f) { /* node 105: 1.5 */
                                return FORAGING_FORAGER_1_ACTION_2; /* leaf 106 */
                            } else {
                                return FORAGING_FORAGER_1_ACTION_2; /* leaf 107 */
                            }
                        } else {
                            if (x[FORAGING_FORAGER_1_X_FOOD_0_AWAY] <= 0x1.4p+1f) { /* node 108: 2.5 */
                                return FORAGING_FORAGER_1_ACTION_4; /* leaf 109 */
                            } else {
                                return FORAGING_FORAGER_1_ACTION_4; /* leaf 110 */
                            }
                        }
                    }
                }
            }
        }
    }
}

static inline int foraging_forager_1_finite(const float *x)
{
    int finite = 1;
    int i;
    for (i = 0; i < FORAGING_FORAGER_1_N_FEATURES; i++) {
        if (!((x[i] >= -0x1.fffffep+127f) && (x[i] <= 0x1.fffffep+127f))) {
            finite = 0;
        }
    }
    return finite;
}

static inline int foraging_forager_1_in_range(const float *x)
{
    int within = 1;
    if (!((x[0] >= -0x1.8cp+6f) && (x[0] <= 0x1.8cp+6f))) {
        within = 0;
    }
    if (!((x[1] >= -0x1.8cp+6f) && (x[1] <= 0x1.8cp+6f))) {
        within = 0;
    }
    if (!((x[2] >= -0x1.8cp+6f) && (x[2] <= 0x1.8cp+6f))) {
        within = 0;
    }
    if (!((x[3] >= -0x1.8cp+6f) && (x[3] <= 0x1.8cp+6f))) {
        within = 0;
    }
    if (!((x[4] >= -0x1.8cp+6f) && (x[4] <= 0x1.8cp+6f))) {
        within = 0;
    }
    if (!((x[5] >= -0x1.8cp+6f) && (x[5] <= 0x1.8cp+6f))) {
        within = 0;
    }
    if (!((x[6] >= -0x1.8cp+6f) && (x[6] <= 0x1.8cp+6f))) {
        within = 0;
    }
    if (!((x[7] >= -0x1.8cp+6f) && (x[7] <= 0x1.8cp+6f))) {
        within = 0;
    }
    if (!((x[8] >= -0x1.8cp+6f) && (x[8] <= 0x1.8cp+6f))) {
        within = 0;
    }
    if (!((x[9] >= -0x1.8cp+6f) && (x[9] <= 0x1.8cp+6f))) {
        within = 0;
    }
    return within;
}

static inline void foraging_forager_1_act_rows(const float *x, long n, unsigned char *actions)
{
    static const float threshold[127] = {0x1.8p+0f, -0x1p+0f, -0x1p+0f, 0x0p+0f, 0x1.8p+0f, 0x1.8p+0f, 0x1.8p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, -0x1p-1f, -0x1p-1f, 0x1.4p+1f, 0x0p+0f, -0x1p-1f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, -0x1p-1f, 0x1.8p+0f, -0x1.8p+0f, 0x1.8p+0f, -0x1.4p+1f, 0x1.4p+1f, 0x0p+0f, 0x0p+0f, -0x1p-1f, -0x1.8p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, -0x1.8p+0f, 0x1p-1f, -0x1p-1f, 0x1p-1f, -0x1.8p+0f, -0x1p-1f, -0x1p-1f, -0x1.7ep+6f, 0x1.4p+1f, -0x1.8p+1f, 0x0p+0f, 0x1.cp+1f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, -0x1.8p+0f, -0x1.8p+0f, 0x1.8p+0f, 0x1.8p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, -0x1.4p+1f, -0x1p-1f, 0x1.8p+0f, 0x1p-1f, -0x1.8p+0f, -0x1p-1f, -0x1.8p+0f, 0x0p+0f, -0x1.4p+1f, 0x0p+0f, -0x1.2p+3f, 0x1p-1f, -0x1.4p+1f, 0x1p-1f, 0x0p+0f, -0x1.cp+1f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x1.4p+1f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, -0x1.cp+1f, -0x1p-1f, 0x1.8p+0f, -0x1p-1f, 0x1.cp+2f, -0x1.4p+1f, 0x1.8p+0f, 0x1.4p+1f};
    static const unsigned char feature[127] = {6, 7, 7, 0, 2, 4, 2, 0, 0, 0, 1, 5, 5, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 5, 5, 5, 4, 0, 0, 1, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 6, 8, 5, 4, 4, 4, 7, 4, 7, 0, 5, 0, 0, 0, 0, 0, 8, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 8, 0, 4, 0, 0, 0, 0, 5, 0, 7, 8, 1, 8, 0, 0, 0, 0, 0, 6, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 8, 1, 9, 7, 1, 0, 2};
    static const unsigned char action[128] = {5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 3, 1, 3, 1, 3, 2, 2, 3, 1, 4, 1, 4, 1, 4, 1, 1, 3, 1, 3, 3, 3, 1, 2, 3, 4, 1, 2, 4, 2, 2, 1, 4, 3, 3, 2, 2, 2, 2, 2, 2, 4, 4, 4, 4, 2, 2, 4, 4, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 3, 1, 3, 1, 1, 1, 1, 4, 3, 3, 3, 2, 2, 2, 4, 4};
    long row;
    /* eight observations side by side, so that none waits for another */
    const long together = n - (n % 8);
    for (row = 0; row < together; row += 8) {
        const float *const seen = &x[row * FORAGING_FORAGER_1_N_FEATURES];
        int i[8] = {0, 0, 0, 0, 0, 0, 0, 0};
        int level;
        int k;
        for (level = 0; level < 7; level++) {
            for (k = 0; k < 8; k++) {
                i[k] = (2 * i[k]) + 1 + ((seen[(k * FORAGING_FORAGER_1_N_FEATURES) + feature[i[k]]] <= threshold[i[k]]) ? 0 : 1);
            }
        }
        for (k = 0; k < 8; k++) {
            actions[row + k] = action[i[k] - 127];
        }
    }
    for (row = together; row < n; row++) {
        const float *const seen = &x[row * FORAGING_FORAGER_1_N_FEATURES];
        int i = 0;
        int level;
        for (level = 0; level < 7; level++) {
            i = (2 * i) + 1 + ((seen[feature[i]] <= threshold[i]) ? 0 : 1);
        }
        actions[row] = action[i - 127];
    }
}

static inline void foraging_forager_1_act_columns(const float *const *x, long n, unsigned char *actions)
{
    const float *const x0 = x[FORAGING_FORAGER_1_X_FOOD_0_DOWN];
    const float *const x1 = x[FORAGING_FORAGER_1_X_FOOD_0_RIGHT];
    const float *const x2 = x[FORAGING_FORAGER_1_X_FOOD_0_AWAY];
    const float *const x4 = x[FORAGING_FORAGER_1_X_FOOD_1_DOWN];
    const float *const x5 = x[FORAGING_FORAGER_1_X_FOOD_1_RIGHT];
    const float *const x6 = x[FORAGING_FORAGER_1_X_FOOD_1_AWAY];
    const float *const x7 = x[FORAGING_FORAGER_1_X_FOOD_1_LATER];
    const float *const x8 = x[FORAGING_FORAGER_1_X_MATE_0_DOWN];
    const float *const x9 = x[FORAGING_FORAGER_1_X_MATE_0_RIGHT];
    long first;
    long row;
    /* one select per split, leaves first, each into its own variable: compilers turn this into vector code */
    for (first = 0; first < n; first += 256) {
        float chosen[256];
        const long left = n - first;
        const long count = (left < 256) ? left : 256;
        for (row = 0; row < count; row++) {
            const float n108 = (x2[first + row] <= 0x1.4p+1f) ? 4.0f : 4.0f;
            const float n105 = (x0[first + row] <= 0x1.8p+0f) ? 2.0f : 2.0f;
            const float n104 = (x1[first + row] <= 0x1.8p+0f) ? n105 : n108;
            const float n101 = (x1[first + row] <= -0x1.4p+1f) ? 3.0f : 2.0f;
            const float n98 = (x7[first + row] <= 0x1.cp+2f) ? 3.0f : 3.0f;
            const float n97 = (x0[first + row] <= 0x1.8p+0f) ? n98 : n101;
            const float n96 = (x1[first + row] <= -0x1.8p+0f) ? n97 : n104;
            const float n93 = (x9[first + row] <= -0x1p-1f) ? 1.0f : 4.0f;
            const float n90 = (x1[first + row] <= 0x1.8p+0f) ? 1.0f : 1.0f;
            const float n89 = (x8[first + row] <= -0x1.8p+0f) ? n90 : n93;
            const float n86 = (x8[first + row] <= -0x1p-1f) ? 3.0f : 1.0f;
            const float n83 = (x1[first + row] <= -0x1.cp+1f) ? 3.0f : 1.0f;
            const float n82 = (x0[first + row] <= -0x1.8p+0f) ? n83 : n86;
            const float n81 = (x1[first + row] <= -0x1p-1f) ? n82 : n89;
            const float n80 = (x0[first + row] <= -0x1p-1f) ? n81 : n96;
            const float n78 = (x2[first + row] <= 0x1.8p+0f) ? 5.0f : n80;
            const float n75 = (x5[first + row] <= 0x1.cp+1f) ? 2.0f : 4.0f;
            const float n73 = (x4[first + row] <= 0x1.4p+1f) ? 4.0f : n75;
            const float n70 = (x6[first + row] <= 0x1.4p+1f) ? 2.0f : 2.0f;
            const float n68 = (x7[first + row] <= -0x1.8p+1f) ? 2.0f : n70;
            const float n65 = (x4[first + row] <= 0x1.4p+1f) ? 3.0f : 2.0f;
            const float n64 = (x5[first + row] <= -0x1.4p+1f) ? n65 : n68;
            const float n63 = (x5[first + row] <= 0x1.4p+1f) ? n64 : n73;
            const float n60 = (x0[first + row] <= -0x1.cp+1f) ? 1.0f : 4.0f;
            const float n58 = (x7[first + row] <= -0x1.7ep+6f) ? 2.0f : n60;
            const float n55 = (x8[first + row] <= 0x1p-1f) ? 2.0f : 4.0f;
            const float n52 = (x1[first + row] <= -0x1.4p+1f) ? 4.0f : 1.0f;
            const float n51 = (x4[first + row] <= -0x1p-1f) ? n52 : n55;
            const float n50 = (x5[first + row] <= 0x1.8p+0f) ? n51 : n58;
            const float n47 = (x8[first + row] <= 0x1p-1f) ? 2.0f : 3.0f;
            const float n44 = (x7[first + row] <= -0x1.2p+3f) ? 3.0f : 1.0f;
            const float n43 = (x4[first + row] <= -0x1p-1f) ? n44 : n47;
            const float n39 = (x5[first + row] <= -0x1.4p+1f) ? 3.0f : 1.0f;
            const float n38 = (x4[first + row] <= -0x1.8p+0f) ? n39 : 3.0f;
            const float n37 = (x5[first + row] <= -0x1.8p+0f) ? n38 : n43;
            const float n36 = (x5[first + row] <= -0x1p-1f) ? n37 : n50;
            const float n35 = (x4[first + row] <= 0x1.8p+0f) ? n36 : n63;
            const float n34 = (x7[first + row] <= -0x1p+0f) ? n35 : n78;
            const float n30 = (x0[first + row] <= -0x1.8p+0f) ? 1.0f : 4.0f;
            const float n29 = (x5[first + row] <= 0x1p-1f) ? n30 : 1.0f;
            const float n26 = (x0[first + row] <= -0x1p-1f) ? 1.0f : 4.0f;
            const float n23 = (x0[first + row] <= -0x1.8p+0f) ? 1.0f : 4.0f;
            const float n22 = (x8[first + row] <= -0x1p-1f) ? n23 : n26;
            const float n21 = (x1[first + row] <= 0x1.8p+0f) ? n22 : n29;
            const float n18 = (x4[first + row] <= 0x1p-1f) ? 2.0f : 3.0f;
            const float n15 = (x0[first + row] <= 0x1.8p+0f) ? 3.0f : 2.0f;
            const float n14 = (x6[first + row] <= 0x1p-1f) ? n15 : n18;
            const float n11 = (x8[first + row] <= -0x1p-1f) ? 3.0f : 1.0f;
            const float n8 = (x1[first + row] <= -0x1.4p+1f) ? 3.0f : 1.0f;
            const float n7 = (x0[first + row] <= -0x1.8p+0f) ? n8 : n11;
            const float n6 = (x0[first + row] <= -0x1p-1f) ? n7 : n14;
            const float n5 = (x1[first + row] <= -0x1p-1f) ? n6 : n21;
            const float n3 = (x2[first + row] <= 0x1.8p+0f) ? 5.0f : n5;
            const float n1 = (x7[first + row] <= -0x1p+0f) ? 5.0f : n3;
            const float n0 = (x6[first + row] <= 0x1.8p+0f) ? n1 : n34;
            chosen[row] = n0;
        }
        for (row = 0; row < count; row++) {
            actions[first + row] = (unsigned char)chosen[row];
        }
    }
}

static inline void foraging_act_all(const float *const *x, int *actions)
{
    /* branch-free walks side by side, so that no agent waits for another and the time does not depend on the data */
    static const float threshold_0[127] = {0x1.8p+0f, -0x1p+0f, -0x1p-1f, 0x1.8p+0f, 0x0p+0f, -0x1p+0f, -0x1p-1f, 0x0p+0f, -0x1.8p+0f, 0x0p+0f, 0x0p+0f, 0x1.8p+0f, -0x1p-1f, -0x1.8p+0f, 0x1.8p+0f, 0x0p+0f, 0x0p+0f, 0x1.8p+0f, 0x1.8p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, -0x1p-1f, 0x1p-1f, -0x1p-1f, -0x1.8p+0f, 0x1p-1f, 0x1p-1f, 0x1.8p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, -0x1.4p+1f, -0x1.7ep+6f, 0x1.8p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, -0x1.8p+0f, -0x1.8p+0f, -0x1p-1f, -0x1.8p+0f, 0x1.4p+1f, -0x1p-1f, -0x1p+0f, 0x0p+0f, -0x1p-1f, 0x1p-1f, 0x1.8p+0f, -0x1p-1f, 0x0p+0f, -0x1p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x1.4p+1f, 0x0p+0f, -0x1p-1f, -0x1p-1f, -0x1.7ep+6f, 0x1.4p+1f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, -0x1.4p+1f, 0x1.8p+0f, 0x1.4p+1f, -0x1p-1f, -0x1.8p+0f, -0x1.8p+0f, -0x1.8p+0f, 0x0p+0f, 0x1.4p+1f, 0x1.8p+0f, -0x1.8p+0f, 0x1.8p+0f, -0x1p-1f, 0x1.8p+0f, 0x0p+0f, 0x0p+0f, -0x1p+0f, -0x1p-1f, -0x1.4p+2f, 0x1p-1f, 0x1p-1f, 0x1.8p+0f, -0x1p+0f, 0x1p-1f, 0x0p+0f, 0x0p+0f, 0x1.4p+1f, 0x0p+0f};
    static const unsigned char feature_0[127] = {2, 7, 0, 6, 0, 7, 1, 0, 5, 0, 0, 6, 1, 9, 9, 0, 0, 4, 5, 0, 0, 0, 0, 0, 5, 9, 9, 1, 8, 9, 1, 0, 0, 0, 0, 0, 5, 7, 4, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 4, 4, 8, 1, 5, 8, 7, 0, 8, 0, 6, 8, 0, 7, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 4, 0, 5, 4, 7, 5, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 5, 4, 5, 4, 8, 1, 0, 0, 1, 1, 8, 9, 5, 0, 0, 0, 7, 9, 7, 9, 4, 8, 7, 8, 0, 0, 5, 0};
    static const unsigned char action_0[128] = {5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 3, 3, 3, 3, 3, 3, 2, 2, 3, 4, 1, 2, 2, 4, 2, 2, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 3, 1, 3, 2, 1, 4, 4, 2, 1, 3, 3, 1, 1, 3, 1, 1, 1, 4, 1, 4, 1, 4, 1, 4, 2, 5, 3, 2, 2, 2, 2, 2, 5, 3, 2, 3, 5, 3, 3, 2, 4, 5, 4, 2, 2, 4, 2, 2, 2, 2, 2, 2, 2, 4, 4, 4};
    static const float threshold_1[127] = {0x1.8p+0f, -0x1p+0f, -0x1p+0f, 0x0p+0f, 0x1.8p+0f, 0x1.8p+0f, 0x1.8p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, -0x1p-1f, -0x1p-1f, 0x1.4p+1f, 0x0p+0f, -0x1p-1f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, -0x1p-1f, 0x1.8p+0f, -0x1.8p+0f, 0x1.8p+0f, -0x1.4p+1f, 0x1.4p+1f, 0x0p+0f, 0x0p+0f, -0x1p-1f, -0x1.8p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, -0x1.8p+0f, 0x1p-1f, -0x1p-1f, 0x1p-1f, -0x1.8p+0f, -0x1p-1f, -0x1p-1f, -0x1.7ep+6f, 0x1.4p+1f, -0x1.8p+1f, 0x0p+0f, 0x1.cp+1f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, -0x1.8p+0f, -0x1.8p+0f, 0x1.8p+0f, 0x1.8p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, -0x1.4p+1f, -0x1p-1f, 0x1.8p+0f, 0x1p-1f, -0x1.8p+0f, -0x1p-1f, -0x1.8p+0f, 0x0p+0f, -0x1.4p+1f, 0x0p+0f, -0x1.2p+3f, 0x1p-1f, -0x1.4p+1f, 0x1p-1f, 0x0p+0f, -0x1.cp+1f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x1.4p+1f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, -0x1.cp+1f, -0x1p-1f, 0x1.8p+0f, -0x1p-1f, 0x1.cp+2f, -0x1.4p+1f, 0x1.8p+0f, 0x1.4p+1f};
    static const unsigned char feature_1[127] = {6, 7, 7, 0, 2, 4, 2, 0, 0, 0, 1, 5, 5, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 5, 5, 5, 4, 0, 0, 1, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 6, 8, 5, 4, 4, 4, 7, 4, 7, 0, 5, 0, 0, 0, 0, 0, 8, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 8, 0, 4, 0, 0, 0, 0, 5, 0, 7, 8, 1, 8, 0, 0, 0, 0, 0, 6, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 8, 1, 9, 7, 1, 0, 2};
    static const unsigned char action_1[128] = {5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 3, 1, 3, 1, 3, 2, 2, 3, 1, 4, 1, 4, 1, 4, 1, 1, 3, 1, 3, 3, 3, 1, 2, 3, 4, 1, 2, 4, 2, 2, 1, 4, 3, 3, 2, 2, 2, 2, 2, 2, 4, 4, 4, 4, 2, 2, 4, 4, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 3, 1, 3, 1, 1, 1, 1, 4, 3, 3, 3, 2, 2, 2, 4, 4};
    const float *const x_0 = x[0];
    const float *const x_1 = x[1];
    int i_0 = 0;
    int i_1 = 0;
    i_0 = (2 * i_0) + 1 + ((x_0[feature_0[i_0]] <= threshold_0[i_0]) ? 0 : 1);
    i_1 = (2 * i_1) + 1 + ((x_1[feature_1[i_1]] <= threshold_1[i_1]) ? 0 : 1);
    i_0 = (2 * i_0) + 1 + ((x_0[feature_0[i_0]] <= threshold_0[i_0]) ? 0 : 1);
    i_1 = (2 * i_1) + 1 + ((x_1[feature_1[i_1]] <= threshold_1[i_1]) ? 0 : 1);
    i_0 = (2 * i_0) + 1 + ((x_0[feature_0[i_0]] <= threshold_0[i_0]) ? 0 : 1);
    i_1 = (2 * i_1) + 1 + ((x_1[feature_1[i_1]] <= threshold_1[i_1]) ? 0 : 1);
    i_0 = (2 * i_0) + 1 + ((x_0[feature_0[i_0]] <= threshold_0[i_0]) ? 0 : 1);
    i_1 = (2 * i_1) + 1 + ((x_1[feature_1[i_1]] <= threshold_1[i_1]) ? 0 : 1);
    i_0 = (2 * i_0) + 1 + ((x_0[feature_0[i_0]] <= threshold_0[i_0]) ? 0 : 1);
    i_1 = (2 * i_1) + 1 + ((x_1[feature_1[i_1]] <= threshold_1[i_1]) ? 0 : 1);
    i_0 = (2 * i_0) + 1 + ((x_0[feature_0[i_0]] <= threshold_0[i_0]) ? 0 : 1);
    i_1 = (2 * i_1) + 1 + ((x_1[feature_1[i_1]] <= threshold_1[i_1]) ? 0 : 1);
    i_0 = (2 * i_0) + 1 + ((x_0[feature_0[i_0]] <= threshold_0[i_0]) ? 0 : 1);
    i_1 = (2 * i_1) + 1 + ((x_1[feature_1[i_1]] <= threshold_1[i_1]) ? 0 : 1);
    actions[0] = (int)action_0[i_0 - 127];
    actions[1] = (int)action_1[i_1 - 127];
}

#endif /* FORAGING_1D422D5F98303EE3_H */
