/* Decision tree policies of 2 agents for the world foraging-make. Generated: do not edit.
 *
 * profile     754a0530a27b6f1477b4210bacbc12d89b47cef58ca094ce387148643cde40b0
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
#ifndef FORAGING_754A0530A27B6F14_H
#define FORAGING_754A0530A27B6F14_H

#include <float.h>

#if defined(__FAST_MATH__) || defined(__ASSOCIATIVE_MATH__) || (defined(__FINITE_MATH_ONLY__) && (__FINITE_MATH_ONLY__ > 0))
#error "compile without -ffast-math, -funsafe-math-optimizations and -ffinite-math-only: they change NaN and tiny numbers"
#endif
#if defined(__cplusplus) && (__cplusplus < 201703L) && defined(__STRICT_ANSI__) && !defined(__clang__)
#error "thresholds are hexadecimal floats: compile with -std=c++17, or with -std=gnu++11 or -std=gnu++14"
#endif
#if (FLT_RADIX != 2) || (FLT_MANT_DIG != 24) || (FLT_MAX_EXP != 128) || (DBL_MANT_DIG != 53)
#error "float must be IEEE binary32 and double binary64"
#endif

#define FORAGING_PROFILE "754a0530a27b6f1477b4210bacbc12d89b47cef58ca094ce387148643cde40b0"
#define FORAGING_DT 0.0
#define FORAGING_DAMPING 0.0
#define FORAGING_FORAGER_0_FORCE 0.0
#define FORAGING_FORAGER_1_FORCE 0.0

/* forager_0, team foragers: 180 leaves, at most 8 comparisons; tables of 1,531 bytes where they are used */

enum {
    FORAGING_FORAGER_0_X_FOOD_0_DOWN = 0, /* cells, [-24.0, 24.0] */
    FORAGING_FORAGER_0_X_FOOD_0_RIGHT = 1, /* cells, [-24.0, 24.0] */
    FORAGING_FORAGER_0_X_FOOD_0_AWAY = 2, /* cells, [-24.0, 24.0] */
    FORAGING_FORAGER_0_X_FOOD_0_LATER = 3, /* cells, [-24.0, 24.0] */
    FORAGING_FORAGER_0_X_FOOD_1_DOWN = 4, /* cells, [-24.0, 24.0] */
    FORAGING_FORAGER_0_X_FOOD_1_RIGHT = 5, /* cells, [-24.0, 24.0] */
    FORAGING_FORAGER_0_X_FOOD_1_AWAY = 6, /* cells, [-24.0, 24.0] */
    FORAGING_FORAGER_0_X_FOOD_1_LATER = 7, /* cells, [-24.0, 24.0] */
    FORAGING_FORAGER_0_X_MATE_0_DOWN = 8, /* cells, [-24.0, 24.0] */
    FORAGING_FORAGER_0_X_MATE_0_RIGHT = 9, /* cells, [-24.0, 24.0] */
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
        if (x[FORAGING_FORAGER_0_X_FOOD_1_AWAY] <= 0x1.8p+0f) { /* node 1: 1.5 */
            if (x[FORAGING_FORAGER_0_X_MATE_0_RIGHT] <= -0x1p-1f) { /* node 2: -0.5 */
                if (x[FORAGING_FORAGER_0_X_FOOD_1_RIGHT] <= 0x1p-1f) { /* node 3: 0.5 */
                    if (x[FORAGING_FORAGER_0_X_MATE_0_RIGHT] <= -0x1.8p+0f) { /* node 4: -1.5 */
                        if (x[FORAGING_FORAGER_0_X_MATE_0_DOWN] <= 0x1p-1f) { /* node 5: 0.5 */
                            if (x[FORAGING_FORAGER_0_X_FOOD_1_DOWN] <= 0x1p-1f) { /* node 6: 0.5 */
                                return FORAGING_FORAGER_0_ACTION_5; /* leaf 7 */
                            } else {
                                return FORAGING_FORAGER_0_ACTION_2; /* leaf 8 */
                            }
                        } else {
                            return FORAGING_FORAGER_0_ACTION_5; /* leaf 9 */
                        }
                    } else {
                        if (x[FORAGING_FORAGER_0_X_FOOD_1_DOWN] <= 0x1p-1f) { /* node 10: 0.5 */
                            return FORAGING_FORAGER_0_ACTION_5; /* leaf 11 */
                        } else {
                            if (x[FORAGING_FORAGER_0_X_MATE_0_DOWN] <= -0x1p-1f) { /* node 12: -0.5 */
                                return FORAGING_FORAGER_0_ACTION_2; /* leaf 13 */
                            } else {
                                return FORAGING_FORAGER_0_ACTION_5; /* leaf 14 */
                            }
                        }
                    }
                } else {
                    if (x[FORAGING_FORAGER_0_X_MATE_0_DOWN] <= 0x1p-1f) { /* node 15: 0.5 */
                        return FORAGING_FORAGER_0_ACTION_2; /* leaf 16 */
                    } else {
                        return FORAGING_FORAGER_0_ACTION_4; /* leaf 17 */
                    }
                }
            } else {
                if (x[FORAGING_FORAGER_0_X_MATE_0_DOWN] <= -0x1.8p+0f) { /* node 18: -1.5 */
                    if (x[FORAGING_FORAGER_0_X_FOOD_1_DOWN] <= 0x1p-1f) { /* node 19: 0.5 */
                        return FORAGING_FORAGER_0_ACTION_5; /* leaf 20 */
                    } else {
                        return FORAGING_FORAGER_0_ACTION_4; /* leaf 21 */
                    }
                } else {
                    if (x[FORAGING_FORAGER_0_X_MATE_0_DOWN] <= -0x1p-1f) { /* node 22: -0.5 */
                        if (x[FORAGING_FORAGER_0_X_FOOD_1_DOWN] <= 0x1p-1f) { /* node 23: 0.5 */
                            return FORAGING_FORAGER_0_ACTION_5; /* leaf 24 */
                        } else {
                            if (x[FORAGING_FORAGER_0_X_MATE_0_RIGHT] <= 0x1p-1f) { /* node 25: 0.5 */
                                return FORAGING_FORAGER_0_ACTION_4; /* leaf 26 */
                            } else {
                                return FORAGING_FORAGER_0_ACTION_5; /* leaf 27 */
                            }
                        }
                    } else {
                        return FORAGING_FORAGER_0_ACTION_5; /* leaf 28 */
                    }
                }
            }
        } else {
            if (x[FORAGING_FORAGER_0_X_FOOD_1_LATER] <= 0x1p+0f) { /* node 29: 1 */
                if (x[FORAGING_FORAGER_0_X_FOOD_1_RIGHT] <= 0x1p-1f) { /* node 30: 0.5 */
                    if (x[FORAGING_FORAGER_0_X_FOOD_1_DOWN] <= 0x1.8p+0f) { /* node 31: 1.5 */
                        if (x[FORAGING_FORAGER_0_X_MATE_0_DOWN] <= 0x1p-1f) { /* node 32: 0.5 */
                            if (x[FORAGING_FORAGER_0_X_FOOD_1_DOWN] <= 0x1p-1f) { /* node 33: 0.5 */
                                if (x[FORAGING_FORAGER_0_X_FOOD_0_DOWN] <= -0x1p-1f) { /* node 34: -0.5 */
                                    return FORAGING_FORAGER_0_ACTION_5; /* leaf 35 */
                                } else {
                                    return FORAGING_FORAGER_0_ACTION_3; /* leaf 36 */
                                }
                            } else {
                                if (x[FORAGING_FORAGER_0_X_MATE_0_RIGHT] <= 0x1p-1f) { /* node 37: 0.5 */
                                    return FORAGING_FORAGER_0_ACTION_2; /* leaf 38 */
                                } else {
                                    return FORAGING_FORAGER_0_ACTION_3; /* leaf 39 */
                                }
                            }
                        } else {
                            if (x[FORAGING_FORAGER_0_X_FOOD_0_RIGHT] <= 0x1p-1f) { /* node 40: 0.5 */
                                if (x[FORAGING_FORAGER_0_X_FOOD_0_DOWN] <= -0x1p-1f) { /* node 41: -0.5 */
                                    return FORAGING_FORAGER_0_ACTION_3; /* leaf 42 */
                                } else {
                                    return FORAGING_FORAGER_0_ACTION_3; /* leaf 43 */
                                }
                            } else {
                                if (x[FORAGING_FORAGER_0_X_FOOD_1_LATER] <= -0x1p+0f) { /* node 44: -1 */
                                    return FORAGING_FORAGER_0_ACTION_4; /* leaf 45 */
                                } else {
                                    return FORAGING_FORAGER_0_ACTION_5; /* leaf 46 */
                                }
                            }
                        }
                    } else {
                        if (x[FORAGING_FORAGER_0_X_FOOD_0_AWAY] <= 0x1p-1f) { /* node 47: 0.5 */
                            if (x[FORAGING_FORAGER_0_X_FOOD_1_RIGHT] <= -0x1p-1f) { /* node 48: -0.5 */
                                if (x[FORAGING_FORAGER_0_X_MATE_0_RIGHT] <= -0x1p-1f) { /* node 49: -0.5 */
                                    return FORAGING_FORAGER_0_ACTION_2; /* leaf 50 */
                                } else {
                                    return FORAGING_FORAGER_0_ACTION_3; /* leaf 51 */
                                }
                            } else {
                                return FORAGING_FORAGER_0_ACTION_2; /* leaf 52 */
                            }
                        } else {
                            if (x[FORAGING_FORAGER_0_X_FOOD_0_RIGHT] <= 0x1p-1f) { /* node 53: 0.5 */
                                if (x[FORAGING_FORAGER_0_X_FOOD_0_DOWN] <= 0x1p-1f) { /* node 54: 0.5 */
                                    return FORAGING_FORAGER_0_ACTION_3; /* leaf 55 */
                                } else {
                                    return FORAGING_FORAGER_0_ACTION_2; /* leaf 56 */
                                }
                            } else {
                                if (x[FORAGING_FORAGER_0_X_MATE_0_RIGHT] <= 0x1.8p+0f) { /* node 57: 1.5 */
                                    return FORAGING_FORAGER_0_ACTION_4; /* leaf 58 */
                                } else {
                                    return FORAGING_FORAGER_0_ACTION_5; /* leaf 59 */
                                }
                            }
                        }
                    }
                } else {
                    if (x[FORAGING_FORAGER_0_X_FOOD_1_DOWN] <= 0x1p-1f) { /* node 60: 0.5 */
                        if (x[FORAGING_FORAGER_0_X_FOOD_0_AWAY] <= 0x1p-1f) { /* node 61: 0.5 */
                            return FORAGING_FORAGER_0_ACTION_4; /* leaf 62 */
                        } else {
                            if (x[FORAGING_FORAGER_0_X_MATE_0_DOWN] <= 0x1p-1f) { /* node 63: 0.5 */
                                if (x[FORAGING_FORAGER_0_X_FOOD_0_DOWN] <= -0x1p-1f) { /* node 64: -0.5 */
                                    return FORAGING_FORAGER_0_ACTION_1; /* leaf 65 */
                                } else {
                                    return FORAGING_FORAGER_0_ACTION_2; /* leaf 66 */
                                }
                            } else {
                                if (x[FORAGING_FORAGER_0_X_MATE_0_RIGHT] <= 0x1.8p+0f) { /* node 67: 1.5 */
                                    return FORAGING_FORAGER_0_ACTION_5; /* leaf 68 */
                                } else {
                                    return FORAGING_FORAGER_0_ACTION_4; /* leaf 69 */
                                }
                            }
                        }
                    } else {
                        if (x[FORAGING_FORAGER_0_X_MATE_0_RIGHT] <= 0x1p-1f) { /* node 70: 0.5 */
                            if (x[FORAGING_FORAGER_0_X_FOOD_0_RIGHT] <= -0x1p-1f) { /* node 71: -0.5 */
                                return FORAGING_FORAGER_0_ACTION_5; /* leaf 72 */
                            } else {
                                if (x[FORAGING_FORAGER_0_X_MATE_0_DOWN] <= 0x1.8p+0f) { /* node 73: 1.5 */
                                    return FORAGING_FORAGER_0_ACTION_4; /* leaf 74 */
                                } else {
                                    return FORAGING_FORAGER_0_ACTION_4; /* leaf 75 */
                                }
                            }
                        } else {
                            if (x[FORAGING_FORAGER_0_X_FOOD_1_RIGHT] <= 0x1.4p+1f) { /* node 76: 2.5 */
                                if (x[FORAGING_FORAGER_0_X_FOOD_0_DOWN] <= -0x1p-1f) { /* node 77: -0.5 */
                                    return FORAGING_FORAGER_0_ACTION_1; /* leaf 78 */
                                } else {
                                    return FORAGING_FORAGER_0_ACTION_2; /* leaf 79 */
                                }
                            } else {
                                if (x[FORAGING_FORAGER_0_X_MATE_0_RIGHT] <= 0x1.4p+1f) { /* node 80: 2.5 */
                                    return FORAGING_FORAGER_0_ACTION_4; /* leaf 81 */
                                } else {
                                    return FORAGING_FORAGER_0_ACTION_2; /* leaf 82 */
                                }
                            }
                        }
                    }
                }
            } else {
                if (x[FORAGING_FORAGER_0_X_FOOD_0_DOWN] <= -0x1p-1f) { /* node 83: -0.5 */
                    if (x[FORAGING_FORAGER_0_X_MATE_0_DOWN] <= -0x1p-1f) { /* node 84: -0.5 */
                        if (x[FORAGING_FORAGER_0_X_MATE_0_RIGHT] <= -0x1.4p+1f) { /* node 85: -2.5 */
                            if (x[FORAGING_FORAGER_0_X_MATE_0_DOWN] <= -0x1.8p+0f) { /* node 86: -1.5 */
                                return FORAGING_FORAGER_0_ACTION_2; /* leaf 87 */
                            } else {
                                if (x[FORAGING_FORAGER_0_X_FOOD_1_DOWN] <= 0x1.8p+0f) { /* node 88: 1.5 */
                                    return FORAGING_FORAGER_0_ACTION_0; /* leaf 89 */
                                } else {
                                    return FORAGING_FORAGER_0_ACTION_2; /* leaf 90 */
                                }
                            }
                        } else {
                            if (x[FORAGING_FORAGER_0_X_MATE_0_RIGHT] <= -0x1.8p+0f) { /* node 91: -1.5 */
                                if (x[FORAGING_FORAGER_0_X_MATE_0_DOWN] <= -0x1.8p+0f) { /* node 92: -1.5 */
                                    return FORAGING_FORAGER_0_ACTION_0; /* leaf 93 */
                                } else {
                                    return FORAGING_FORAGER_0_ACTION_5; /* leaf 94 */
                                }
                            } else {
                                if (x[FORAGING_FORAGER_0_X_MATE_0_DOWN] <= -0x1.4p+1f) { /* node 95: -2.5 */
                                    return FORAGING_FORAGER_0_ACTION_5; /* leaf 96 */
                                } else {
                                    return FORAGING_FORAGER_0_ACTION_5; /* leaf 97 */
                                }
                            }
                        }
                    } else {
                        if (x[FORAGING_FORAGER_0_X_FOOD_1_RIGHT] <= -0x1p-1f) { /* node 98: -0.5 */
                            if (x[FORAGING_FORAGER_0_X_MATE_0_RIGHT] <= -0x1p-1f) { /* node 99: -0.5 */
                                if (x[FORAGING_FORAGER_0_X_MATE_0_RIGHT] <= -0x1.4p+1f) { /* node 100: -2.5 */
                                    return FORAGING_FORAGER_0_ACTION_4; /* leaf 101 */
                                } else {
                                    return FORAGING_FORAGER_0_ACTION_5; /* leaf 102 */
                                }
                            } else {
                                return FORAGING_FORAGER_0_ACTION_3; /* leaf 103 */
                            }
                        } else {
                            if (x[FORAGING_FORAGER_0_X_MATE_0_RIGHT] <= 0x1p-1f) { /* node 104: 0.5 */
                                if (x[FORAGING_FORAGER_0_X_FOOD_1_DOWN] <= -0x1p-1f) { /* node 105: -0.5 */
                                    return FORAGING_FORAGER_0_ACTION_5; /* leaf 106 */
                                } else {
                                    return FORAGING_FORAGER_0_ACTION_1; /* leaf 107 */
                                }
                            } else {
                                if (x[FORAGING_FORAGER_0_X_MATE_0_DOWN] <= 0x1p-1f) { /* node 108: 0.5 */
                                    return FORAGING_FORAGER_0_ACTION_5; /* leaf 109 */
                                } else {
                                    return FORAGING_FORAGER_0_ACTION_1; /* leaf 110 */
                                }
                            }
                        }
                    }
                } else {
                    if (x[FORAGING_FORAGER_0_X_MATE_0_DOWN] <= 0x1p-1f) { /* node 111: 0.5 */
                        if (x[FORAGING_FORAGER_0_X_FOOD_1_LATER] <= 0x1.8p+1f) { /* node 112: 3 */
                            if (x[FORAGING_FORAGER_0_X_MATE_0_RIGHT] <= 0x1.4p+1f) { /* node 113: 2.5 */
                                if (x[FORAGING_FORAGER_0_X_FOOD_1_RIGHT] <= -0x1.4p+1f) { /* node 114: -2.5 */
                                    return FORAGING_FORAGER_0_ACTION_2; /* leaf 115 */
                                } else {
                                    return FORAGING_FORAGER_0_ACTION_2; /* leaf 116 */
                                }
                            } else {
                                if (x[FORAGING_FORAGER_0_X_FOOD_0_RIGHT] <= 0x1p-1f) { /* node 117: 0.5 */
                                    return FORAGING_FORAGER_0_ACTION_2; /* leaf 118 */
                                } else {
                                    return FORAGING_FORAGER_0_ACTION_4; /* leaf 119 */
                                }
                            }
                        } else {
                            if (x[FORAGING_FORAGER_0_X_FOOD_0_RIGHT] <= 0x1p-1f) { /* node 120: 0.5 */
                                if (x[FORAGING_FORAGER_0_X_MATE_0_RIGHT] <= -0x1.8p+0f) { /* node 121: -1.5 */
                                    return FORAGING_FORAGER_0_ACTION_5; /* leaf 122 */
                                } else {
                                    return FORAGING_FORAGER_0_ACTION_2; /* leaf 123 */
                                }
                            } else {
                                if (x[FORAGING_FORAGER_0_X_MATE_0_RIGHT] <= 0x1p-1f) { /* node 124: 0.5 */
                                    return FORAGING_FORAGER_0_ACTION_2; /* leaf 125 */
                                } else {
                                    return FORAGING_FORAGER_0_ACTION_5; /* leaf 126 */
                                }
                            }
                        }
                    } else {
                        if (x[FORAGING_FORAGER_0_X_FOOD_0_DOWN] <= 0x1p-1f) { /* node 127: 0.5 */
                            if (x[FORAGING_FORAGER_0_X_MATE_0_DOWN] <= 0x1.8p+0f) { /* node 128: 1.5 */
                                if (x[FORAGING_FORAGER_0_X_MATE_0_RIGHT] <= 0x1.cp+1f) { /* node 129: 3.5 */
                                    return FORAGING_FORAGER_0_ACTION_5; /* leaf 130 */
                                } else {
                                    return FORAGING_FORAGER_0_ACTION_2; /* leaf 131 */
                                }
                            } else {
                                if (x[FORAGING_FORAGER_0_X_FOOD_1_AWAY] <= 0x1.cp+1f) { /* node 132: 3.5 */
                                    return FORAGING_FORAGER_0_ACTION_5; /* leaf 133 */
                                } else {
                                    return FORAGING_FORAGER_0_ACTION_5; /* leaf 134 */
                                }
                            }
                        } else {
                            if (x[FORAGING_FORAGER_0_X_FOOD_1_LATER] <= 0x1.8p+1f) { /* node 135: 3 */
                                if (x[FORAGING_FORAGER_0_X_MATE_0_DOWN] <= 0x1.4p+1f) { /* node 136: 2.5 */
                                    return FORAGING_FORAGER_0_ACTION_2; /* leaf 137 */
                                } else {
                                    return FORAGING_FORAGER_0_ACTION_3; /* leaf 138 */
                                }
                            } else {
                                if (x[FORAGING_FORAGER_0_X_MATE_0_RIGHT] <= -0x1.8p+0f) { /* node 139: -1.5 */
                                    return FORAGING_FORAGER_0_ACTION_2; /* leaf 140 */
                                } else {
                                    return FORAGING_FORAGER_0_ACTION_5; /* leaf 141 */
                                }
                            }
                        }
                    }
                }
            }
        }
    } else {
        if (x[FORAGING_FORAGER_0_X_FOOD_0_DOWN] <= -0x1p-1f) { /* node 142: -0.5 */
            if (x[FORAGING_FORAGER_0_X_FOOD_0_RIGHT] <= -0x1p-1f) { /* node 143: -0.5 */
                if (x[FORAGING_FORAGER_0_X_FOOD_0_AWAY] <= 0x1.4p+1f) { /* node 144: 2.5 */
                    if (x[FORAGING_FORAGER_0_X_MATE_0_DOWN] <= -0x1p-1f) { /* node 145: -0.5 */
                        if (x[FORAGING_FORAGER_0_X_MATE_0_RIGHT] <= -0x1.8p+0f) { /* node 146: -1.5 */
                            if (x[FORAGING_FORAGER_0_X_FOOD_1_RIGHT] <= -0x1p-1f) { /* node 147: -0.5 */
                                if (x[FORAGING_FORAGER_0_X_FOOD_1_RIGHT] <= -0x1.8p+0f) { /* node 148: -1.5 */
                                    return FORAGING_FORAGER_0_ACTION_3; /* leaf 149 */
                                } else {
                                    return FORAGING_FORAGER_0_ACTION_3; /* leaf 150 */
                                }
                            } else {
                                if (x[FORAGING_FORAGER_0_X_MATE_0_DOWN] <= -0x1.8p+0f) { /* node 151: -1.5 */
                                    return FORAGING_FORAGER_0_ACTION_3; /* leaf 152 */
                                } else {
                                    return FORAGING_FORAGER_0_ACTION_1; /* leaf 153 */
                                }
                            }
                        } else {
                            return FORAGING_FORAGER_0_ACTION_3; /* leaf 154 */
                        }
                    } else {
                        if (x[FORAGING_FORAGER_0_X_FOOD_1_RIGHT] <= -0x1.8p+0f) { /* node 155: -1.5 */
                            return FORAGING_FORAGER_0_ACTION_3; /* leaf 156 */
                        } else {
                            if (x[FORAGING_FORAGER_0_X_MATE_0_RIGHT] <= 0x1p-1f) { /* node 157: 0.5 */
                                return FORAGING_FORAGER_0_ACTION_1; /* leaf 158 */
                            } else {
                                if (x[FORAGING_FORAGER_0_X_FOOD_1_DOWN] <= 0x1p-1f) { /* node 159: 0.5 */
                                    return FORAGING_FORAGER_0_ACTION_1; /* leaf 160 */
                                } else {
                                    return FORAGING_FORAGER_0_ACTION_3; /* leaf 161 */
                                }
                            }
                        }
                    }
                } else {
                    if (x[FORAGING_FORAGER_0_X_FOOD_1_RIGHT] <= -0x1p-1f) { /* node 162: -0.5 */
                        if (x[FORAGING_FORAGER_0_X_FOOD_1_LATER] <= 0x1.8p+1f) { /* node 163: 3 */
                            if (x[FORAGING_FORAGER_0_X_MATE_0_RIGHT] <= -0x1p-1f) { /* node 164: -0.5 */
                                if (x[FORAGING_FORAGER_0_X_FOOD_0_AWAY] <= 0x1.cp+1f) { /* node 165: 3.5 */
                                    return FORAGING_FORAGER_0_ACTION_1; /* leaf 166 */
                                } else {
                                    return FORAGING_FORAGER_0_ACTION_1; /* leaf 167 */
                                }
                            } else {
                                if (x[FORAGING_FORAGER_0_X_FOOD_0_RIGHT] <= -0x1.8p+0f) { /* node 168: -1.5 */
                                    return FORAGING_FORAGER_0_ACTION_3; /* leaf 169 */
                                } else {
                                    return FORAGING_FORAGER_0_ACTION_1; /* leaf 170 */
                                }
                            }
                        } else {
                            if (x[FORAGING_FORAGER_0_X_FOOD_0_DOWN] <= -0x1.4p+1f) { /* node 171: -2.5 */
                                if (x[FORAGING_FORAGER_0_X_FOOD_0_RIGHT] <= -0x1.8p+0f) { /* node 172: -1.5 */
                                    return FORAGING_FORAGER_0_ACTION_3; /* leaf 173 */
                                } else {
                                    return FORAGING_FORAGER_0_ACTION_1; /* leaf 174 */
                                }
                            } else {
                                if (x[FORAGING_FORAGER_0_X_FOOD_1_RIGHT] <= -0x1.8p+0f) { /* node 175: -1.5 */
                                    return FORAGING_FORAGER_0_ACTION_3; /* leaf 176 */
                                } else {
                                    return FORAGING_FORAGER_0_ACTION_3; /* leaf 177 */
                                }
                            }
                        }
                    } else {
                        if (x[FORAGING_FORAGER_0_X_MATE_0_DOWN] <= -0x1p-1f) { /* node 178: -0.5 */
                            if (x[FORAGING_FORAGER_0_X_FOOD_0_RIGHT] <= -0x1.8p+0f) { /* node 179: -1.5 */
                                if (x[FORAGING_FORAGER_0_X_FOOD_1_DOWN] <= -0x1p-1f) { /* node 180: -0.5 */
                                    return FORAGING_FORAGER_0_ACTION_3; /* leaf 181 */
                                } else {
                                    return FORAGING_FORAGER_0_ACTION_3; /* leaf 182 */
                                }
                            } else {
                                if (x[FORAGING_FORAGER_0_X_FOOD_1_LATER] <= -0x1p+0f) { /* node 183: -1 */
                                    return FORAGING_FORAGER_0_ACTION_3; /* leaf 184 */
                                } else {
                                    return FORAGING_FORAGER_0_ACTION_1; /* leaf 185 */
                                }
                            }
                        } else {
                            if (x[FORAGING_FORAGER_0_X_FOOD_1_RIGHT] <= 0x1p-1f) { /* node 186: 0.5 */
                                if (x[FORAGING_FORAGER_0_X_MATE_0_RIGHT] <= -0x1.8p+0f) { /* node 187: -1.5 */
                                    return FORAGING_FORAGER_0_ACTION_1; /* leaf 188 */
                                } else {
                                    return FORAGING_FORAGER_0_ACTION_3; /* leaf 189 */
                                }
                            } else {
                                if (x[FORAGING_FORAGER_0_X_MATE_0_RIGHT] <= 0x1.8p+0f) { /* node 190: 1.5 */
                                    return FORAGING_FORAGER_0_ACTION_1; /* leaf 191 */
                                } else {
                                    return FORAGING_FORAGER_0_ACTION_1; /* leaf 192 */
                                }
                            }
                        }
                    }
                }
            } else {
                if (x[FORAGING_FORAGER_0_X_FOOD_0_DOWN] <= -0x1.8p+0f) { /* node 193: -1.5 */
                    if (x[FORAGING_FORAGER_0_X_FOOD_1_LATER] <= -0x1p+0f) { /* node 194: -1 */
                        if (x[FORAGING_FORAGER_0_X_FOOD_1_RIGHT] <= 0x1p-1f) { /* node 195: 0.5 */
                            if (x[FORAGING_FORAGER_0_X_FOOD_0_RIGHT] <= 0x1p-1f) { /* node 196: 0.5 */
                                if (x[FORAGING_FORAGER_0_X_FOOD_1_RIGHT] <= -0x1p-1f) { /* node 197: -0.5 */
                                    return FORAGING_FORAGER_0_ACTION_1; /* leaf 198 */
                                } else {
                                    return FORAGING_FORAGER_0_ACTION_3; /* leaf 199 */
                                }
                            } else {
                                if (x[FORAGING_FORAGER_0_X_MATE_0_DOWN] <= 0x1p-1f) { /* node 200: 0.5 */
                                    return FORAGING_FORAGER_0_ACTION_4; /* leaf 201 */
                                } else {
                                    return FORAGING_FORAGER_0_ACTION_1; /* leaf 202 */
                                }
                            }
                        } else {
                            if (x[FORAGING_FORAGER_0_X_MATE_0_RIGHT] <= 0x1p-1f) { /* node 203: 0.5 */
                                if (x[FORAGING_FORAGER_0_X_FOOD_1_LATER] <= -0x1.8p+1f) { /* node 204: -3 */
                                    return FORAGING_FORAGER_0_ACTION_4; /* leaf 205 */
                                } else {
                                    return FORAGING_FORAGER_0_ACTION_1; /* leaf 206 */
                                }
                            } else {
                                if (x[FORAGING_FORAGER_0_X_MATE_0_DOWN] <= -0x1.cp+1f) { /* node 207: -3.5 */
                                    return FORAGING_FORAGER_0_ACTION_1; /* leaf 208 */
                                } else {
                                    return FORAGING_FORAGER_0_ACTION_1; /* leaf 209 */
                                }
                            }
                        }
                    } else {
                        if (x[FORAGING_FORAGER_0_X_FOOD_0_RIGHT] <= 0x1p-1f) { /* node 210: 0.5 */
                            if (x[FORAGING_FORAGER_0_X_MATE_0_DOWN] <= -0x1.2p+2f) { /* node 211: -4.5 */
                                if (x[FORAGING_FORAGER_0_X_FOOD_1_AWAY] <= 0x1.8p+0f) { /* node 212: 1.5 */
                                    return FORAGING_FORAGER_0_ACTION_4; /* leaf 213 */
                                } else {
                                    return FORAGING_FORAGER_0_ACTION_1; /* leaf 214 */
                                }
                            } else {
                                if (x[FORAGING_FORAGER_0_X_MATE_0_RIGHT] <= -0x1.cp+1f) { /* node 215: -3.5 */
                                    return FORAGING_FORAGER_0_ACTION_1; /* leaf 216 */
                                } else {
                                    return FORAGING_FORAGER_0_ACTION_1; /* leaf 217 */
                                }
                            }
                        } else {
                            if (x[FORAGING_FORAGER_0_X_FOOD_1_AWAY] <= 0x1.8p+0f) { /* node 218: 1.5 */
                                if (x[FORAGING_FORAGER_0_X_FOOD_1_DOWN] <= -0x1p-1f) { /* node 219: -0.5 */
                                    return FORAGING_FORAGER_0_ACTION_4; /* leaf 220 */
                                } else {
                                    return FORAGING_FORAGER_0_ACTION_1; /* leaf 221 */
                                }
                            } else {
                                if (x[FORAGING_FORAGER_0_X_MATE_0_RIGHT] <= -0x1p-1f) { /* node 222: -0.5 */
                                    return FORAGING_FORAGER_0_ACTION_1; /* leaf 223 */
                                } else {
                                    return FORAGING_FORAGER_0_ACTION_1; /* leaf 224 */
                                }
                            }
                        }
                    }
                } else {
                    if (x[FORAGING_FORAGER_0_X_MATE_0_DOWN] <= -0x1p-1f) { /* node 225: -0.5 */
                        if (x[FORAGING_FORAGER_0_X_MATE_0_RIGHT] <= 0x1p-1f) { /* node 226: 0.5 */
                            return FORAGING_FORAGER_0_ACTION_4; /* leaf 227 */
                        } else {
                            if (x[FORAGING_FORAGER_0_X_FOOD_1_AWAY] <= 0x1.4p+1f) { /* node 228: 2.5 */
                                if (x[FORAGING_FORAGER_0_X_FOOD_1_DOWN] <= 0x1.8p+0f) { /* node 229: 1.5 */
                                    return FORAGING_FORAGER_0_ACTION_1; /* leaf 230 */
                                } else {
                                    return FORAGING_FORAGER_0_ACTION_4; /* leaf 231 */
                                }
                            } else {
                                if (x[FORAGING_FORAGER_0_X_FOOD_1_RIGHT] <= 0x1.8p+0f) { /* node 232: 1.5 */
                                    return FORAGING_FORAGER_0_ACTION_4; /* leaf 233 */
                                } else {
                                    return FORAGING_FORAGER_0_ACTION_4; /* leaf 234 */
                                }
                            }
                        }
                    } else {
                        if (x[FORAGING_FORAGER_0_X_FOOD_1_AWAY] <= 0x1.2p+2f) { /* node 235: 4.5 */
                            if (x[FORAGING_FORAGER_0_X_MATE_0_RIGHT] <= -0x1p-1f) { /* node 236: -0.5 */
                                if (x[FORAGING_FORAGER_0_X_MATE_0_DOWN] <= 0x1.8p+0f) { /* node 237: 1.5 */
                                    return FORAGING_FORAGER_0_ACTION_4; /* leaf 238 */
                                } else {
                                    return FORAGING_FORAGER_0_ACTION_4; /* leaf 239 */
                                }
                            } else {
                                if (x[FORAGING_FORAGER_0_X_FOOD_1_AWAY] <= 0x1.cp+1f) { /* node 240: 3.5 */
                                    return FORAGING_FORAGER_0_ACTION_1; /* leaf 241 */
                                } else {
                                    return FORAGING_FORAGER_0_ACTION_1; /* leaf 242 */
                                }
                            }
                        } else {
                            if (x[FORAGING_FORAGER_0_X_FOOD_0_RIGHT] <= 0x1.8p+0f) { /* node 243: 1.5 */
                                if (x[FORAGING_FORAGER_0_X_FOOD_1_LATER] <= 0x1p+0f) { /* node 244: 1 */
                                    return FORAGING_FORAGER_0_ACTION_4; /* leaf 245 */
                                } else {
                                    return FORAGING_FORAGER_0_ACTION_1; /* leaf 246 */
                                }
                            } else {
                                if (x[FORAGING_FORAGER_0_X_MATE_0_DOWN] <= 0x1.4p+1f) { /* node 247: 2.5 */
                                    return FORAGING_FORAGER_0_ACTION_4; /* leaf 248 */
                                } else {
                                    return FORAGING_FORAGER_0_ACTION_1; /* leaf 249 */
                                }
                            }
                        }
                    }
                }
            }
        } else {
            if (x[FORAGING_FORAGER_0_X_FOOD_0_RIGHT] <= 0x1.8p+0f) { /* node 250: 1.5 */
                if (x[FORAGING_FORAGER_0_X_FOOD_0_DOWN] <= 0x1p-1f) { /* node 251: 0.5 */
                    if (x[FORAGING_FORAGER_0_X_FOOD_1_DOWN] <= 0x1p-1f) { /* node 252: 0.5 */
                        if (x[FORAGING_FORAGER_0_X_FOOD_0_RIGHT] <= -0x1.cp+1f) { /* node 253: -3.5 */
                            if (x[FORAGING_FORAGER_0_X_FOOD_1_LATER] <= -0x1.4p+2f) { /* node 254: -5 */
                                return FORAGING_FORAGER_0_ACTION_3; /* leaf 255 */
                            } else {
                                if (x[FORAGING_FORAGER_0_X_MATE_0_DOWN] <= 0x1.8p+0f) { /* node 256: 1.5 */
                                    return FORAGING_FORAGER_0_ACTION_1; /* leaf 257 */
                                } else {
                                    return FORAGING_FORAGER_0_ACTION_3; /* leaf 258 */
                                }
                            }
                        } else {
                            return FORAGING_FORAGER_0_ACTION_3; /* leaf 259 */
                        }
                    } else {
                        if (x[FORAGING_FORAGER_0_X_MATE_0_RIGHT] <= 0x1.8p+0f) { /* node 260: 1.5 */
                            if (x[FORAGING_FORAGER_0_X_MATE_0_RIGHT] <= -0x1p-1f) { /* node 261: -0.5 */
                                return FORAGING_FORAGER_0_ACTION_3; /* leaf 262 */
                            } else {
                                if (x[FORAGING_FORAGER_0_X_MATE_0_DOWN] <= -0x1p-1f) { /* node 263: -0.5 */
                                    return FORAGING_FORAGER_0_ACTION_3; /* leaf 264 */
                                } else {
                                    return FORAGING_FORAGER_0_ACTION_3; /* leaf 265 */
                                }
                            }
                        } else {
                            if (x[FORAGING_FORAGER_0_X_FOOD_1_RIGHT] <= 0x1p-1f) { /* node 266: 0.5 */
                                if (x[FORAGING_FORAGER_0_X_MATE_0_DOWN] <= -0x1p-1f) { /* node 267: -0.5 */
                                    return FORAGING_FORAGER_0_ACTION_2; /* leaf 268 */
                                } else {
                                    return FORAGING_FORAGER_0_ACTION_3; /* leaf 269 */
                                }
                            } else {
                                if (x[FORAGING_FORAGER_0_X_FOOD_1_LATER] <= -0x1p+0f) { /* node 270: -1 */
                                    return FORAGING_FORAGER_0_ACTION_3; /* leaf 271 */
                                } else {
                                    return FORAGING_FORAGER_0_ACTION_2; /* leaf 272 */
                                }
                            }
                        }
                    }
                } else {
                    if (x[FORAGING_FORAGER_0_X_FOOD_0_RIGHT] <= -0x1.4p+1f) { /* node 273: -2.5 */
                        if (x[FORAGING_FORAGER_0_X_FOOD_0_DOWN] <= 0x1.4p+1f) { /* node 274: 2.5 */
                            if (x[FORAGING_FORAGER_0_X_FOOD_1_LATER] <= 0x1.8p+1f) { /* node 275: 3 */
                                if (x[FORAGING_FORAGER_0_X_FOOD_1_DOWN] <= 0x1.4p+1f) { /* node 276: 2.5 */
                                    return FORAGING_FORAGER_0_ACTION_3; /* leaf 277 */
                                } else {
                                    return FORAGING_FORAGER_0_ACTION_3; /* leaf 278 */
                                }
                            } else {
                                if (x[FORAGING_FORAGER_0_X_MATE_0_DOWN] <= 0x1.8p+0f) { /* node 279: 1.5 */
                                    return FORAGING_FORAGER_0_ACTION_2; /* leaf 280 */
                                } else {
                                    return FORAGING_FORAGER_0_ACTION_3; /* leaf 281 */
                                }
                            }
                        } else {
                            if (x[FORAGING_FORAGER_0_X_FOOD_0_RIGHT] <= -0x1.cp+1f) { /* node 282: -3.5 */
                                if (x[FORAGING_FORAGER_0_X_FOOD_1_RIGHT] <= -0x1.8p+0f) { /* node 283: -1.5 */
                                    return FORAGING_FORAGER_0_ACTION_2; /* leaf 284 */
                                } else {
                                    return FORAGING_FORAGER_0_ACTION_3; /* leaf 285 */
                                }
                            } else {
                                return FORAGING_FORAGER_0_ACTION_2; /* leaf 286 */
                            }
                        }
                    } else {
                        if (x[FORAGING_FORAGER_0_X_FOOD_1_AWAY] <= 0x1.4p+1f) { /* node 287: 2.5 */
                            if (x[FORAGING_FORAGER_0_X_MATE_0_DOWN] <= 0x1p-1f) { /* node 288: 0.5 */
                                if (x[FORAGING_FORAGER_0_X_FOOD_1_LATER] <= -0x1p+0f) { /* node 289: -1 */
                                    return FORAGING_FORAGER_0_ACTION_3; /* leaf 290 */
                                } else {
                                    return FORAGING_FORAGER_0_ACTION_2; /* leaf 291 */
                                }
                            } else {
                                if (x[FORAGING_FORAGER_0_X_MATE_0_DOWN] <= 0x1.2p+2f) { /* node 292: 4.5 */
                                    return FORAGING_FORAGER_0_ACTION_3; /* leaf 293 */
                                } else {
                                    return FORAGING_FORAGER_0_ACTION_2; /* leaf 294 */
                                }
                            }
                        } else {
                            if (x[FORAGING_FORAGER_0_X_FOOD_1_RIGHT] <= 0x1.4p+1f) { /* node 295: 2.5 */
                                if (x[FORAGING_FORAGER_0_X_MATE_0_DOWN] <= 0x1.8p+0f) { /* node 296: 1.5 */
                                    return FORAGING_FORAGER_0_ACTION_2; /* leaf 297 */
                                } else {
                                    return FORAGING_FORAGER_0_ACTION_2; /* leaf 298 */
                                }
                            } else {
                                if (x[FORAGING_FORAGER_0_X_MATE_0_RIGHT] <= -0x1p-1f) { /* node 299: -0.5 */
                                    return FORAGING_FORAGER_0_ACTION_4; /* leaf 300 */
                                } else {
                                    return FORAGING_FORAGER_0_ACTION_2; /* leaf 301 */
                                }
                            }
                        }
                    }
                }
            } else {
                if (x[FORAGING_FORAGER_0_X_FOOD_0_DOWN] <= 0x1p-1f) { /* node 302: 0.5 */
                    if (x[FORAGING_FORAGER_0_X_MATE_0_RIGHT] <= 0x1p-1f) { /* node 303: 0.5 */
                        if (x[FORAGING_FORAGER_0_X_MATE_0_DOWN] <= -0x1p-1f) { /* node 304: -0.5 */
                            if (x[FORAGING_FORAGER_0_X_FOOD_1_RIGHT] <= -0x1p-1f) { /* node 305: -0.5 */
                                return FORAGING_FORAGER_0_ACTION_2; /* leaf 306 */
                            } else {
                                if (x[FORAGING_FORAGER_0_X_MATE_0_RIGHT] <= -0x1p-1f) { /* node 307: -0.5 */
                                    return FORAGING_FORAGER_0_ACTION_2; /* leaf 308 */
                                } else {
                                    return FORAGING_FORAGER_0_ACTION_4; /* leaf 309 */
                                }
                            }
                        } else {
                            if (x[FORAGING_FORAGER_0_X_FOOD_1_LATER] <= -0x1p+0f) { /* node 310: -1 */
                                return FORAGING_FORAGER_0_ACTION_4; /* leaf 311 */
                            } else {
                                if (x[FORAGING_FORAGER_0_X_FOOD_1_RIGHT] <= 0x1p-1f) { /* node 312: 0.5 */
                                    return FORAGING_FORAGER_0_ACTION_2; /* leaf 313 */
                                } else {
                                    return FORAGING_FORAGER_0_ACTION_4; /* leaf 314 */
                                }
                            }
                        }
                    } else {
                        if (x[FORAGING_FORAGER_0_X_MATE_0_DOWN] <= 0x1.4p+1f) { /* node 315: 2.5 */
                            if (x[FORAGING_FORAGER_0_X_MATE_0_RIGHT] <= 0x1.2p+2f) { /* node 316: 4.5 */
                                if (x[FORAGING_FORAGER_0_X_MATE_0_DOWN] <= -0x1.8p+0f) { /* node 317: -1.5 */
                                    return FORAGING_FORAGER_0_ACTION_4; /* leaf 318 */
                                } else {
                                    return FORAGING_FORAGER_0_ACTION_4; /* leaf 319 */
                                }
                            } else {
                                if (x[FORAGING_FORAGER_0_X_FOOD_0_RIGHT] <= 0x1.4p+1f) { /* node 320: 2.5 */
                                    return FORAGING_FORAGER_0_ACTION_4; /* leaf 321 */
                                } else {
                                    return FORAGING_FORAGER_0_ACTION_4; /* leaf 322 */
                                }
                            }
                        } else {
                            if (x[FORAGING_FORAGER_0_X_FOOD_1_RIGHT] <= -0x1p-1f) { /* node 323: -0.5 */
                                return FORAGING_FORAGER_0_ACTION_1; /* leaf 324 */
                            } else {
                                if (x[FORAGING_FORAGER_0_X_FOOD_1_AWAY] <= 0x1.8p+0f) { /* node 325: 1.5 */
                                    return FORAGING_FORAGER_0_ACTION_4; /* leaf 326 */
                                } else {
                                    return FORAGING_FORAGER_0_ACTION_4; /* leaf 327 */
                                }
                            }
                        }
                    }
                } else {
                    if (x[FORAGING_FORAGER_0_X_FOOD_0_DOWN] <= 0x1.8p+0f) { /* node 328: 1.5 */
                        if (x[FORAGING_FORAGER_0_X_MATE_0_DOWN] <= 0x1p-1f) { /* node 329: 0.5 */
                            if (x[FORAGING_FORAGER_0_X_FOOD_0_RIGHT] <= 0x1.cp+1f) { /* node 330: 3.5 */
                                if (x[FORAGING_FORAGER_0_X_FOOD_1_LATER] <= 0x1.cp+2f) { /* node 331: 7 */
                                    return FORAGING_FORAGER_0_ACTION_2; /* leaf 332 */
                                } else {
                                    return FORAGING_FORAGER_0_ACTION_4; /* leaf 333 */
                                }
                            } else {
                                if (x[FORAGING_FORAGER_0_X_FOOD_1_LATER] <= 0x1.4p+2f) { /* node 334: 5 */
                                    return FORAGING_FORAGER_0_ACTION_4; /* leaf 335 */
                                } else {
                                    return FORAGING_FORAGER_0_ACTION_2; /* leaf 336 */
                                }
                            }
                        } else {
                            if (x[FORAGING_FORAGER_0_X_FOOD_1_RIGHT] <= -0x1p-1f) { /* node 337: -0.5 */
                                if (x[FORAGING_FORAGER_0_X_MATE_0_DOWN] <= 0x1.cp+1f) { /* node 338: 3.5 */
                                    return FORAGING_FORAGER_0_ACTION_2; /* leaf 339 */
                                } else {
                                    return FORAGING_FORAGER_0_ACTION_4; /* leaf 340 */
                                }
                            } else {
                                if (x[FORAGING_FORAGER_0_X_MATE_0_RIGHT] <= -0x1p-1f) { /* node 341: -0.5 */
                                    return FORAGING_FORAGER_0_ACTION_4; /* leaf 342 */
                                } else {
                                    return FORAGING_FORAGER_0_ACTION_4; /* leaf 343 */
                                }
                            }
                        }
                    } else {
                        if (x[FORAGING_FORAGER_0_X_MATE_0_DOWN] <= 0x1.4p+1f) { /* node 344: 2.5 */
                            if (x[FORAGING_FORAGER_0_X_FOOD_1_RIGHT] <= 0x1.4p+1f) { /* node 345: 2.5 */
                                if (x[FORAGING_FORAGER_0_X_FOOD_1_LATER] <= -0x1.8p+1f) { /* node 346: -3 */
                                    return FORAGING_FORAGER_0_ACTION_2; /* leaf 347 */
                                } else {
                                    return FORAGING_FORAGER_0_ACTION_2; /* leaf 348 */
                                }
                            } else {
                                if (x[FORAGING_FORAGER_0_X_MATE_0_DOWN] <= 0x1.8p+0f) { /* node 349: 1.5 */
                                    return FORAGING_FORAGER_0_ACTION_2; /* leaf 350 */
                                } else {
                                    return FORAGING_FORAGER_0_ACTION_4; /* leaf 351 */
                                }
                            }
                        } else {
                            if (x[FORAGING_FORAGER_0_X_FOOD_1_LATER] <= -0x1p+0f) { /* node 352: -1 */
                                if (x[FORAGING_FORAGER_0_X_FOOD_1_RIGHT] <= 0x1p-1f) { /* node 353: 0.5 */
                                    return FORAGING_FORAGER_0_ACTION_2; /* leaf 354 */
                                } else {
                                    return FORAGING_FORAGER_0_ACTION_4; /* leaf 355 */
                                }
                            } else {
                                if (x[FORAGING_FORAGER_0_X_MATE_0_RIGHT] <= 0x1.8p+0f) { /* node 356: 1.5 */
                                    return FORAGING_FORAGER_0_ACTION_4; /* leaf 357 */
                                } else {
                                    return FORAGING_FORAGER_0_ACTION_2; /* leaf 358 */
                                }
                            }
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
    if (!((x[0] >= -0x1.8p+4f) && (x[0] <= 0x1.8p+4f))) {
        within = 0;
    }
    if (!((x[1] >= -0x1.8p+4f) && (x[1] <= 0x1.8p+4f))) {
        within = 0;
    }
    if (!((x[2] >= -0x1.8p+4f) && (x[2] <= 0x1.8p+4f))) {
        within = 0;
    }
    if (!((x[3] >= -0x1.8p+4f) && (x[3] <= 0x1.8p+4f))) {
        within = 0;
    }
    if (!((x[4] >= -0x1.8p+4f) && (x[4] <= 0x1.8p+4f))) {
        within = 0;
    }
    if (!((x[5] >= -0x1.8p+4f) && (x[5] <= 0x1.8p+4f))) {
        within = 0;
    }
    if (!((x[6] >= -0x1.8p+4f) && (x[6] <= 0x1.8p+4f))) {
        within = 0;
    }
    if (!((x[7] >= -0x1.8p+4f) && (x[7] <= 0x1.8p+4f))) {
        within = 0;
    }
    if (!((x[8] >= -0x1.8p+4f) && (x[8] <= 0x1.8p+4f))) {
        within = 0;
    }
    if (!((x[9] >= -0x1.8p+4f) && (x[9] <= 0x1.8p+4f))) {
        within = 0;
    }
    return within;
}

static inline void foraging_forager_0_act_rows(const float *x, long n, unsigned char *actions)
{
    static const float threshold[255] = {0x1.8p+0f, 0x1.8p+0f, -0x1p-1f, -0x1p-1f, 0x1p+0f, -0x1p-1f, 0x1.8p+0f, 0x1p-1f, -0x1.8p+0f, 0x1p-1f, -0x1p-1f, 0x1.4p+1f, -0x1.8p+0f, 0x1p-1f, 0x1p-1f, -0x1.8p+0f, 0x1p-1f, 0x1p-1f, -0x1p-1f, 0x1.8p+0f, 0x1p-1f, -0x1p-1f, 0x1p-1f, -0x1p-1f, -0x1p-1f, -0x1p+0f, -0x1p-1f, 0x1p-1f, -0x1.4p+1f, 0x1p-1f, 0x1.8p+0f, 0x1p-1f, 0x1p-1f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x1p-1f, 0x0p+0f, 0x1p-1f, 0x1p-1f, 0x1p-1f, 0x1p-1f, -0x1.4p+1f, -0x1p-1f, 0x1.8p+1f, 0x1p-1f, -0x1.8p+0f, -0x1.8p+0f, 0x1.8p+1f, -0x1p-1f, 0x1p-1f, 0x1p-1f, 0x1p-1f, 0x1.2p+2f, -0x1.cp+1f, 0x1.8p+0f, 0x1.4p+1f, 0x1.4p+1f, -0x1p-1f, 0x1.4p+1f, 0x1p-1f, 0x1.4p+1f, 0x1p-1f, 0x0p+0f, 0x0p+0f, -0x1p-1f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x1p-1f, 0x0p+0f, 0x0p+0f, 0x1p-1f, 0x1p-1f, -0x1p-1f, 0x1p-1f, 0x0p+0f, 0x1p-1f, -0x1p-1f, 0x1.4p+1f, -0x1.8p+0f, -0x1.8p+0f, -0x1p-1f, 0x1p-1f, 0x1.4p+1f, 0x1p-1f, 0x1.8p+0f, 0x1.8p+1f, -0x1p-1f, 0x0p+0f, 0x0p+0f, 0x1p-1f, -0x1p-1f, -0x1.4p+1f, -0x1.8p+0f, 0x1p-1f, 0x1p-1f, 0x1p-1f, -0x1.2p+2f, 0x1.8p+0f, 0x0p+0f, 0x1.4p+1f, -0x1p-1f, 0x1.8p+0f, -0x1.4p+2f, 0x0p+0f, -0x1p-1f, 0x1p-1f, 0x1.8p+1f, -0x1.cp+1f, 0x1p-1f, 0x1.4p+1f, -0x1p-1f, -0x1p+0f, 0x1.2p+2f, -0x1p-1f, 0x1.cp+1f, -0x1p-1f, 0x1.4p+1f, -0x1p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, -0x1p-1f, 0x1p-1f, -0x1p-1f, -0x1p+0f, -0x1p-1f, 0x0p+0f, 0x1p-1f, 0x1.8p+0f, 0x0p+0f, 0x0p+0f, -0x1p-1f, 0x1.8p+0f, 0x0p+0f, 0x1.8p+0f, -0x1p-1f, 0x1.4p+1f, 0x0p+0f, 0x1.8p+0f, -0x1.8p+0f, -0x1.4p+1f, -0x1.4p+1f, 0x0p+0f, -0x1p-1f, 0x1p-1f, -0x1.4p+1f, 0x1p-1f, -0x1.8p+0f, 0x1p-1f, 0x1.cp+1f, 0x1.cp+1f, 0x1.4p+1f, -0x1.8p+0f, -0x1.8p+0f, -0x1.8p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x1p-1f, 0x1.cp+1f, -0x1.8p+0f, -0x1.8p+0f, -0x1.8p+0f, -0x1p-1f, -0x1p+0f, -0x1.8p+0f, 0x1.8p+0f, -0x1p-1f, 0x1p-1f, -0x1.8p+1f, -0x1.cp+1f, 0x1.8p+0f, -0x1.cp+1f, -0x1p-1f, -0x1p-1f, 0x0p+0f, 0x0p+0f, 0x1.8p+0f, 0x1.8p+0f, 0x1.8p+0f, 0x1.cp+1f, 0x1p+0f, 0x1.4p+1f, 0x0p+0f, 0x1.8p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, -0x1p-1f, -0x1p-1f, -0x1p+0f, 0x1.4p+1f, 0x1.8p+0f, -0x1.8p+0f, 0x0p+0f, -0x1p+0f, 0x1.2p+2f, 0x1.8p+0f, -0x1p-1f, 0x0p+0f, -0x1p-1f, 0x0p+0f, 0x1p-1f, -0x1.8p+0f, 0x1.4p+1f, 0x0p+0f, 0x1.8p+0f, 0x1.cp+2f, 0x1.4p+2f, 0x1.cp+1f, -0x1p-1f, -0x1.8p+1f, 0x1.8p+0f, 0x1p-1f, 0x1.8p+0f};
    static const unsigned char feature[255] = {2, 6, 0, 9, 7, 1, 1, 5, 8, 5, 0, 2, 0, 0, 0, 9, 8, 4, 8, 4, 4, 8, 8, 8, 5, 7, 8, 4, 1, 9, 0, 8, 4, 0, 0, 0, 0, 4, 0, 8, 2, 2, 9, 9, 5, 7, 0, 9, 5, 7, 8, 5, 1, 9, 6, 1, 9, 0, 6, 8, 8, 8, 8, 4, 0, 0, 8, 0, 0, 0, 0, 0, 0, 0, 0, 0, 9, 0, 0, 4, 1, 5, 1, 0, 8, 1, 5, 8, 9, 9, 9, 9, 1, 8, 7, 5, 0, 0, 9, 9, 0, 1, 5, 1, 9, 8, 6, 0, 6, 9, 1, 7, 0, 9, 5, 7, 1, 8, 5, 5, 7, 9, 5, 1, 5, 5, 7, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 9, 0, 7, 9, 0, 0, 9, 0, 0, 0, 9, 0, 8, 0, 9, 0, 4, 8, 8, 9, 0, 4, 8, 5, 1, 9, 9, 9, 6, 8, 9, 5, 8, 0, 0, 0, 0, 0, 4, 2, 1, 1, 5, 4, 7, 9, 9, 5, 8, 7, 8, 6, 9, 4, 9, 0, 0, 4, 5, 8, 6, 7, 8, 0, 8, 0, 0, 0, 8, 8, 7, 4, 8, 5, 0, 7, 8, 8, 9, 0, 9, 0, 5, 8, 1, 0, 6, 7, 7, 8, 9, 7, 8, 5, 9};
    static const unsigned char action[256] = {5, 5, 2, 2, 5, 5, 5, 5, 5, 5, 5, 5, 2, 2, 5, 5, 2, 2, 2, 2, 2, 2, 2, 2, 4, 4, 4, 4, 4, 4, 4, 4, 5, 5, 5, 5, 5, 5, 5, 5, 4, 4, 4, 4, 4, 4, 4, 4, 5, 5, 5, 5, 4, 4, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 3, 2, 3, 3, 3, 4, 5, 2, 3, 2, 2, 3, 2, 4, 5, 4, 4, 4, 4, 1, 2, 5, 4, 5, 5, 4, 4, 1, 2, 4, 2, 2, 2, 0, 2, 0, 5, 5, 5, 4, 5, 3, 3, 5, 1, 5, 1, 2, 2, 2, 4, 5, 2, 2, 5, 5, 2, 5, 5, 2, 3, 2, 5, 3, 3, 3, 1, 3, 3, 3, 3, 3, 3, 3, 3, 1, 1, 1, 3, 1, 1, 3, 1, 3, 1, 3, 3, 3, 3, 3, 1, 1, 3, 1, 1, 1, 3, 4, 1, 4, 1, 1, 1, 4, 1, 1, 1, 4, 1, 1, 1, 4, 4, 4, 4, 1, 4, 4, 4, 4, 4, 1, 1, 4, 1, 4, 1, 3, 3, 1, 3, 3, 3, 3, 3, 3, 3, 3, 3, 2, 3, 3, 2, 3, 3, 2, 3, 2, 3, 2, 2, 3, 2, 3, 2, 2, 2, 4, 2, 2, 2, 2, 4, 4, 4, 2, 4, 4, 4, 4, 4, 1, 1, 4, 4, 2, 4, 4, 2, 2, 4, 4, 4, 2, 2, 2, 4, 2, 4, 4, 2};
    long row;
    /* eight observations side by side, so that none waits for another */
    const long together = n - (n % 8);
    for (row = 0; row < together; row += 8) {
        const float *const seen = &x[row * FORAGING_FORAGER_0_N_FEATURES];
        int i[8] = {0, 0, 0, 0, 0, 0, 0, 0};
        int level;
        int k;
        for (level = 0; level < 8; level++) {
            for (k = 0; k < 8; k++) {
                i[k] = (2 * i[k]) + 1 + ((seen[(k * FORAGING_FORAGER_0_N_FEATURES) + feature[i[k]]] <= threshold[i[k]]) ? 0 : 1);
            }
        }
        for (k = 0; k < 8; k++) {
            actions[row + k] = action[i[k] - 255];
        }
    }
    for (row = together; row < n; row++) {
        const float *const seen = &x[row * FORAGING_FORAGER_0_N_FEATURES];
        int i = 0;
        int level;
        for (level = 0; level < 8; level++) {
            i = (2 * i) + 1 + ((seen[feature[i]] <= threshold[i]) ? 0 : 1);
        }
        actions[row] = action[i - 255];
    }
}

static inline void foraging_forager_0_act_columns(const float *const *x, long n, unsigned char *actions)
{
    static const float threshold[255] = {0x1.8p+0f, 0x1.8p+0f, -0x1p-1f, -0x1p-1f, 0x1p+0f, -0x1p-1f, 0x1.8p+0f, 0x1p-1f, -0x1.8p+0f, 0x1p-1f, -0x1p-1f, 0x1.4p+1f, -0x1.8p+0f, 0x1p-1f, 0x1p-1f, -0x1.8p+0f, 0x1p-1f, 0x1p-1f, -0x1p-1f, 0x1.8p+0f, 0x1p-1f, -0x1p-1f, 0x1p-1f, -0x1p-1f, -0x1p-1f, -0x1p+0f, -0x1p-1f, 0x1p-1f, -0x1.4p+1f, 0x1p-1f, 0x1.8p+0f, 0x1p-1f, 0x1p-1f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x1p-1f, 0x0p+0f, 0x1p-1f, 0x1p-1f, 0x1p-1f, 0x1p-1f, -0x1.4p+1f, -0x1p-1f, 0x1.8p+1f, 0x1p-1f, -0x1.8p+0f, -0x1.8p+0f, 0x1.8p+1f, -0x1p-1f, 0x1p-1f, 0x1p-1f, 0x1p-1f, 0x1.2p+2f, -0x1.cp+1f, 0x1.8p+0f, 0x1.4p+1f, 0x1.4p+1f, -0x1p-1f, 0x1.4p+1f, 0x1p-1f, 0x1.4p+1f, 0x1p-1f, 0x0p+0f, 0x0p+0f, -0x1p-1f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x1p-1f, 0x0p+0f, 0x0p+0f, 0x1p-1f, 0x1p-1f, -0x1p-1f, 0x1p-1f, 0x0p+0f, 0x1p-1f, -0x1p-1f, 0x1.4p+1f, -0x1.8p+0f, -0x1.8p+0f, -0x1p-1f, 0x1p-1f, 0x1.4p+1f, 0x1p-1f, 0x1.8p+0f, 0x1.8p+1f, -0x1p-1f, 0x0p+0f, 0x0p+0f, 0x1p-1f, -0x1p-1f, -0x1.4p+1f, -0x1.8p+0f, 0x1p-1f, 0x1p-1f, 0x1p-1f, -0x1.2p+2f, 0x1.8p+0f, 0x0p+0f, 0x1.4p+1f, -0x1p-1f, 0x1.8p+0f, -0x1.4p+2f, 0x0p+0f, -0x1p-1f, 0x1p-1f, 0x1.8p+1f, -0x1.cp+1f, 0x1p-1f, 0x1.4p+1f, -0x1p-1f, -0x1p+0f, 0x1.2p+2f, -0x1p-1f, 0x1.cp+1f, -0x1p-1f, 0x1.4p+1f, -0x1p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, -0x1p-1f, 0x1p-1f, -0x1p-1f, -0x1p+0f, -0x1p-1f, 0x0p+0f, 0x1p-1f, 0x1.8p+0f, 0x0p+0f, 0x0p+0f, -0x1p-1f, 0x1.8p+0f, 0x0p+0f, 0x1.8p+0f, -0x1p-1f, 0x1.4p+1f, 0x0p+0f, 0x1.8p+0f, -0x1.8p+0f, -0x1.4p+1f, -0x1.4p+1f, 0x0p+0f, -0x1p-1f, 0x1p-1f, -0x1.4p+1f, 0x1p-1f, -0x1.8p+0f, 0x1p-1f, 0x1.cp+1f, 0x1.cp+1f, 0x1.4p+1f, -0x1.8p+0f, -0x1.8p+0f, -0x1.8p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x1p-1f, 0x1.cp+1f, -0x1.8p+0f, -0x1.8p+0f, -0x1.8p+0f, -0x1p-1f, -0x1p+0f, -0x1.8p+0f, 0x1.8p+0f, -0x1p-1f, 0x1p-1f, -0x1.8p+1f, -0x1.cp+1f, 0x1.8p+0f, -0x1.cp+1f, -0x1p-1f, -0x1p-1f, 0x0p+0f, 0x0p+0f, 0x1.8p+0f, 0x1.8p+0f, 0x1.8p+0f, 0x1.cp+1f, 0x1p+0f, 0x1.4p+1f, 0x0p+0f, 0x1.8p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, -0x1p-1f, -0x1p-1f, -0x1p+0f, 0x1.4p+1f, 0x1.8p+0f, -0x1.8p+0f, 0x0p+0f, -0x1p+0f, 0x1.2p+2f, 0x1.8p+0f, -0x1p-1f, 0x0p+0f, -0x1p-1f, 0x0p+0f, 0x1p-1f, -0x1.8p+0f, 0x1.4p+1f, 0x0p+0f, 0x1.8p+0f, 0x1.cp+2f, 0x1.4p+2f, 0x1.cp+1f, -0x1p-1f, -0x1.8p+1f, 0x1.8p+0f, 0x1p-1f, 0x1.8p+0f};
    static const unsigned char feature[255] = {2, 6, 0, 9, 7, 1, 1, 5, 8, 5, 0, 2, 0, 0, 0, 9, 8, 4, 8, 4, 4, 8, 8, 8, 5, 7, 8, 4, 1, 9, 0, 8, 4, 0, 0, 0, 0, 4, 0, 8, 2, 2, 9, 9, 5, 7, 0, 9, 5, 7, 8, 5, 1, 9, 6, 1, 9, 0, 6, 8, 8, 8, 8, 4, 0, 0, 8, 0, 0, 0, 0, 0, 0, 0, 0, 0, 9, 0, 0, 4, 1, 5, 1, 0, 8, 1, 5, 8, 9, 9, 9, 9, 1, 8, 7, 5, 0, 0, 9, 9, 0, 1, 5, 1, 9, 8, 6, 0, 6, 9, 1, 7, 0, 9, 5, 7, 1, 8, 5, 5, 7, 9, 5, 1, 5, 5, 7, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 9, 0, 7, 9, 0, 0, 9, 0, 0, 0, 9, 0, 8, 0, 9, 0, 4, 8, 8, 9, 0, 4, 8, 5, 1, 9, 9, 9, 6, 8, 9, 5, 8, 0, 0, 0, 0, 0, 4, 2, 1, 1, 5, 4, 7, 9, 9, 5, 8, 7, 8, 6, 9, 4, 9, 0, 0, 4, 5, 8, 6, 7, 8, 0, 8, 0, 0, 0, 8, 8, 7, 4, 8, 5, 0, 7, 8, 8, 9, 0, 9, 0, 5, 8, 1, 0, 6, 7, 7, 8, 9, 7, 8, 5, 9};
    static const unsigned char action[256] = {5, 5, 2, 2, 5, 5, 5, 5, 5, 5, 5, 5, 2, 2, 5, 5, 2, 2, 2, 2, 2, 2, 2, 2, 4, 4, 4, 4, 4, 4, 4, 4, 5, 5, 5, 5, 5, 5, 5, 5, 4, 4, 4, 4, 4, 4, 4, 4, 5, 5, 5, 5, 4, 4, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 3, 2, 3, 3, 3, 4, 5, 2, 3, 2, 2, 3, 2, 4, 5, 4, 4, 4, 4, 1, 2, 5, 4, 5, 5, 4, 4, 1, 2, 4, 2, 2, 2, 0, 2, 0, 5, 5, 5, 4, 5, 3, 3, 5, 1, 5, 1, 2, 2, 2, 4, 5, 2, 2, 5, 5, 2, 5, 5, 2, 3, 2, 5, 3, 3, 3, 1, 3, 3, 3, 3, 3, 3, 3, 3, 1, 1, 1, 3, 1, 1, 3, 1, 3, 1, 3, 3, 3, 3, 3, 1, 1, 3, 1, 1, 1, 3, 4, 1, 4, 1, 1, 1, 4, 1, 1, 1, 4, 1, 1, 1, 4, 4, 4, 4, 1, 4, 4, 4, 4, 4, 1, 1, 4, 1, 4, 1, 3, 3, 1, 3, 3, 3, 3, 3, 3, 3, 3, 3, 2, 3, 3, 2, 3, 3, 2, 3, 2, 3, 2, 2, 3, 2, 3, 2, 2, 2, 4, 2, 2, 2, 2, 4, 4, 4, 2, 4, 4, 4, 4, 4, 1, 1, 4, 4, 2, 4, 4, 2, 2, 4, 4, 4, 2, 2, 2, 4, 2, 4, 4, 2};
    long row;
    for (row = 0; row < n; row++) {
        int i = 0;
        int level;
        for (level = 0; level < 8; level++) {
            i = (2 * i) + 1 + ((x[feature[i]][row] <= threshold[i]) ? 0 : 1);
        }
        actions[row] = action[i - 255];
    }
}

/* forager_1, team foragers: 185 leaves, at most 8 comparisons; tables of 1,531 bytes where they are used */

enum {
    FORAGING_FORAGER_1_X_FOOD_0_DOWN = 0, /* cells, [-24.0, 24.0] */
    FORAGING_FORAGER_1_X_FOOD_0_RIGHT = 1, /* cells, [-24.0, 24.0] */
    FORAGING_FORAGER_1_X_FOOD_0_AWAY = 2, /* cells, [-24.0, 24.0] */
    FORAGING_FORAGER_1_X_FOOD_0_LATER = 3, /* cells, [-24.0, 24.0] */
    FORAGING_FORAGER_1_X_FOOD_1_DOWN = 4, /* cells, [-24.0, 24.0] */
    FORAGING_FORAGER_1_X_FOOD_1_RIGHT = 5, /* cells, [-24.0, 24.0] */
    FORAGING_FORAGER_1_X_FOOD_1_AWAY = 6, /* cells, [-24.0, 24.0] */
    FORAGING_FORAGER_1_X_FOOD_1_LATER = 7, /* cells, [-24.0, 24.0] */
    FORAGING_FORAGER_1_X_MATE_0_DOWN = 8, /* cells, [-24.0, 24.0] */
    FORAGING_FORAGER_1_X_MATE_0_RIGHT = 9, /* cells, [-24.0, 24.0] */
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
    if (x[FORAGING_FORAGER_1_X_FOOD_0_AWAY] <= 0x1.8p+0f) { /* node 0: 1.5 */
        if (x[FORAGING_FORAGER_1_X_FOOD_1_AWAY] <= 0x1.8p+0f) { /* node 1: 1.5 */
            if (x[FORAGING_FORAGER_1_X_MATE_0_RIGHT] <= -0x1p-1f) { /* node 2: -0.5 */
                if (x[FORAGING_FORAGER_1_X_FOOD_1_RIGHT] <= 0x1p-1f) { /* node 3: 0.5 */
                    if (x[FORAGING_FORAGER_1_X_MATE_0_RIGHT] <= -0x1.8p+0f) { /* node 4: -1.5 */
                        if (x[FORAGING_FORAGER_1_X_MATE_0_DOWN] <= 0x1p-1f) { /* node 5: 0.5 */
                            if (x[FORAGING_FORAGER_1_X_FOOD_1_DOWN] <= 0x1p-1f) { /* node 6: 0.5 */
                                return FORAGING_FORAGER_1_ACTION_5; /* leaf 7 */
                            } else {
                                return FORAGING_FORAGER_1_ACTION_2; /* leaf 8 */
                            }
                        } else {
                            if (x[FORAGING_FORAGER_1_X_MATE_0_RIGHT] <= -0x1.4p+1f) { /* node 9: -2.5 */
                                return FORAGING_FORAGER_1_ACTION_2; /* leaf 10 */
                            } else {
                                return FORAGING_FORAGER_1_ACTION_5; /* leaf 11 */
                            }
                        }
                    } else {
                        if (x[FORAGING_FORAGER_1_X_FOOD_1_DOWN] <= 0x1p-1f) { /* node 12: 0.5 */
                            return FORAGING_FORAGER_1_ACTION_5; /* leaf 13 */
                        } else {
                            if (x[FORAGING_FORAGER_1_X_MATE_0_DOWN] <= -0x1p-1f) { /* node 14: -0.5 */
                                return FORAGING_FORAGER_1_ACTION_2; /* leaf 15 */
                            } else {
                                return FORAGING_FORAGER_1_ACTION_5; /* leaf 16 */
                            }
                        }
                    }
                } else {
                    if (x[FORAGING_FORAGER_1_X_MATE_0_DOWN] <= 0x1p-1f) { /* node 17: 0.5 */
                        return FORAGING_FORAGER_1_ACTION_2; /* leaf 18 */
                    } else {
                        return FORAGING_FORAGER_1_ACTION_4; /* leaf 19 */
                    }
                }
            } else {
                if (x[FORAGING_FORAGER_1_X_MATE_0_DOWN] <= -0x1.8p+0f) { /* node 20: -1.5 */
                    if (x[FORAGING_FORAGER_1_X_FOOD_1_DOWN] <= 0x1p-1f) { /* node 21: 0.5 */
                        return FORAGING_FORAGER_1_ACTION_5; /* leaf 22 */
                    } else {
                        return FORAGING_FORAGER_1_ACTION_4; /* leaf 23 */
                    }
                } else {
                    if (x[FORAGING_FORAGER_1_X_MATE_0_RIGHT] <= 0x1p-1f) { /* node 24: 0.5 */
                        if (x[FORAGING_FORAGER_1_X_MATE_0_DOWN] <= -0x1p-1f) { /* node 25: -0.5 */
                            if (x[FORAGING_FORAGER_1_X_FOOD_1_DOWN] <= 0x1p-1f) { /* node 26: 0.5 */
                                return FORAGING_FORAGER_1_ACTION_5; /* leaf 27 */
                            } else {
                                return FORAGING_FORAGER_1_ACTION_4; /* leaf 28 */
                            }
                        } else {
                            return FORAGING_FORAGER_1_ACTION_5; /* leaf 29 */
                        }
                    } else {
                        return FORAGING_FORAGER_1_ACTION_5; /* leaf 30 */
                    }
                }
            }
        } else {
            if (x[FORAGING_FORAGER_1_X_FOOD_1_LATER] <= 0x1p+0f) { /* node 31: 1 */
                if (x[FORAGING_FORAGER_1_X_FOOD_1_RIGHT] <= 0x1p-1f) { /* node 32: 0.5 */
                    if (x[FORAGING_FORAGER_1_X_FOOD_1_RIGHT] <= -0x1p-1f) { /* node 33: -0.5 */
                        if (x[FORAGING_FORAGER_1_X_MATE_0_RIGHT] <= -0x1p-1f) { /* node 34: -0.5 */
                            if (x[FORAGING_FORAGER_1_X_FOOD_1_DOWN] <= 0x1p-1f) { /* node 35: 0.5 */
                                if (x[FORAGING_FORAGER_1_X_FOOD_0_DOWN] <= -0x1p-1f) { /* node 36: -0.5 */
                                    return FORAGING_FORAGER_1_ACTION_5; /* leaf 37 */
                                } else {
                                    return FORAGING_FORAGER_1_ACTION_3; /* leaf 38 */
                                }
                            } else {
                                if (x[FORAGING_FORAGER_1_X_FOOD_1_RIGHT] <= -0x1.4p+1f) { /* node 39: -2.5 */
                                    return FORAGING_FORAGER_1_ACTION_3; /* leaf 40 */
                                } else {
                                    return FORAGING_FORAGER_1_ACTION_2; /* leaf 41 */
                                }
                            }
                        } else {
                            if (x[FORAGING_FORAGER_1_X_MATE_0_DOWN] <= -0x1p-1f) { /* node 42: -0.5 */
                                if (x[FORAGING_FORAGER_1_X_FOOD_1_DOWN] <= 0x1p-1f) { /* node 43: 0.5 */
                                    return FORAGING_FORAGER_1_ACTION_3; /* leaf 44 */
                                } else {
                                    return FORAGING_FORAGER_1_ACTION_2; /* leaf 45 */
                                }
                            } else {
                                if (x[FORAGING_FORAGER_1_X_FOOD_1_DOWN] <= 0x1.4p+1f) { /* node 46: 2.5 */
                                    return FORAGING_FORAGER_1_ACTION_3; /* leaf 47 */
                                } else {
                                    return FORAGING_FORAGER_1_ACTION_2; /* leaf 48 */
                                }
                            }
                        }
                    } else {
                        if (x[FORAGING_FORAGER_1_X_FOOD_0_AWAY] <= 0x1p-1f) { /* node 49: 0.5 */
                            if (x[FORAGING_FORAGER_1_X_FOOD_1_DOWN] <= -0x1.8p+0f) { /* node 50: -1.5 */
                                return FORAGING_FORAGER_1_ACTION_5; /* leaf 51 */
                            } else {
                                return FORAGING_FORAGER_1_ACTION_2; /* leaf 52 */
                            }
                        } else {
                            if (x[FORAGING_FORAGER_1_X_FOOD_0_RIGHT] <= -0x1p-1f) { /* node 53: -0.5 */
                                if (x[FORAGING_FORAGER_1_X_FOOD_1_LATER] <= -0x1p+0f) { /* node 54: -1 */
                                    return FORAGING_FORAGER_1_ACTION_2; /* leaf 55 */
                                } else {
                                    return FORAGING_FORAGER_1_ACTION_3; /* leaf 56 */
                                }
                            } else {
                                if (x[FORAGING_FORAGER_1_X_MATE_0_RIGHT] <= 0x1.8p+0f) { /* node 57: 1.5 */
                                    return FORAGING_FORAGER_1_ACTION_4; /* leaf 58 */
                                } else {
                                    return FORAGING_FORAGER_1_ACTION_2; /* leaf 59 */
                                }
                            }
                        }
                    }
                } else {
                    if (x[FORAGING_FORAGER_1_X_FOOD_1_DOWN] <= 0x1p-1f) { /* node 60: 0.5 */
                        if (x[FORAGING_FORAGER_1_X_FOOD_0_AWAY] <= 0x1p-1f) { /* node 61: 0.5 */
                            return FORAGING_FORAGER_1_ACTION_4; /* leaf 62 */
                        } else {
                            if (x[FORAGING_FORAGER_1_X_MATE_0_RIGHT] <= 0x1.4p+1f) { /* node 63: 2.5 */
                                if (x[FORAGING_FORAGER_1_X_FOOD_0_DOWN] <= -0x1p-1f) { /* node 64: -0.5 */
                                    return FORAGING_FORAGER_1_ACTION_1; /* leaf 65 */
                                } else {
                                    return FORAGING_FORAGER_1_ACTION_2; /* leaf 66 */
                                }
                            } else {
                                if (x[FORAGING_FORAGER_1_X_FOOD_0_RIGHT] <= -0x1p-1f) { /* node 67: -0.5 */
                                    return FORAGING_FORAGER_1_ACTION_2; /* leaf 68 */
                                } else {
                                    return FORAGING_FORAGER_1_ACTION_4; /* leaf 69 */
                                }
                            }
                        }
                    } else {
                        if (x[FORAGING_FORAGER_1_X_MATE_0_RIGHT] <= 0x1p-1f) { /* node 70: 0.5 */
                            if (x[FORAGING_FORAGER_1_X_FOOD_0_RIGHT] <= -0x1p-1f) { /* node 71: -0.5 */
                                if (x[FORAGING_FORAGER_1_X_FOOD_1_DOWN] <= 0x1.8p+0f) { /* node 72: 1.5 */
                                    return FORAGING_FORAGER_1_ACTION_5; /* leaf 73 */
                                } else {
                                    return FORAGING_FORAGER_1_ACTION_2; /* leaf 74 */
                                }
                            } else {
                                if (x[FORAGING_FORAGER_1_X_MATE_0_DOWN] <= 0x1.8p+0f) { /* node 75: 1.5 */
                                    return FORAGING_FORAGER_1_ACTION_4; /* leaf 76 */
                                } else {
                                    return FORAGING_FORAGER_1_ACTION_4; /* leaf 77 */
                                }
                            }
                        } else {
                            if (x[FORAGING_FORAGER_1_X_FOOD_1_RIGHT] <= 0x1.4p+1f) { /* node 78: 2.5 */
                                if (x[FORAGING_FORAGER_1_X_FOOD_0_DOWN] <= -0x1p-1f) { /* node 79: -0.5 */
                                    return FORAGING_FORAGER_1_ACTION_1; /* leaf 80 */
                                } else {
                                    return FORAGING_FORAGER_1_ACTION_2; /* leaf 81 */
                                }
                            } else {
                                if (x[FORAGING_FORAGER_1_X_FOOD_1_DOWN] <= 0x1.8p+0f) { /* node 82: 1.5 */
                                    return FORAGING_FORAGER_1_ACTION_4; /* leaf 83 */
                                } else {
                                    return FORAGING_FORAGER_1_ACTION_2; /* leaf 84 */
                                }
                            }
                        }
                    }
                }
            } else {
                if (x[FORAGING_FORAGER_1_X_FOOD_0_DOWN] <= -0x1p-1f) { /* node 85: -0.5 */
                    if (x[FORAGING_FORAGER_1_X_MATE_0_DOWN] <= -0x1p-1f) { /* node 86: -0.5 */
                        if (x[FORAGING_FORAGER_1_X_MATE_0_RIGHT] <= -0x1.4p+1f) { /* node 87: -2.5 */
                            if (x[FORAGING_FORAGER_1_X_FOOD_1_DOWN] <= 0x1.8p+0f) { /* node 88: 1.5 */
                                return FORAGING_FORAGER_1_ACTION_0; /* leaf 89 */
                            } else {
                                if (x[FORAGING_FORAGER_1_X_FOOD_1_RIGHT] <= -0x1.8p+0f) { /* node 90: -1.5 */
                                    return FORAGING_FORAGER_1_ACTION_2; /* leaf 91 */
                                } else {
                                    return FORAGING_FORAGER_1_ACTION_2; /* leaf 92 */
                                }
                            }
                        } else {
                            if (x[FORAGING_FORAGER_1_X_MATE_0_RIGHT] <= -0x1.8p+0f) { /* node 93: -1.5 */
                                if (x[FORAGING_FORAGER_1_X_FOOD_1_RIGHT] <= 0x1p-1f) { /* node 94: 0.5 */
                                    return FORAGING_FORAGER_1_ACTION_5; /* leaf 95 */
                                } else {
                                    return FORAGING_FORAGER_1_ACTION_1; /* leaf 96 */
                                }
                            } else {
                                if (x[FORAGING_FORAGER_1_X_MATE_0_DOWN] <= -0x1.4p+1f) { /* node 97: -2.5 */
                                    return FORAGING_FORAGER_1_ACTION_5; /* leaf 98 */
                                } else {
                                    return FORAGING_FORAGER_1_ACTION_5; /* leaf 99 */
                                }
                            }
                        }
                    } else {
                        if (x[FORAGING_FORAGER_1_X_FOOD_1_RIGHT] <= -0x1p-1f) { /* node 100: -0.5 */
                            if (x[FORAGING_FORAGER_1_X_MATE_0_RIGHT] <= -0x1p-1f) { /* node 101: -0.5 */
                                if (x[FORAGING_FORAGER_1_X_MATE_0_DOWN] <= 0x1.8p+0f) { /* node 102: 1.5 */
                                    return FORAGING_FORAGER_1_ACTION_5; /* leaf 103 */
                                } else {
                                    return FORAGING_FORAGER_1_ACTION_3; /* leaf 104 */
                                }
                            } else {
                                return FORAGING_FORAGER_1_ACTION_3; /* leaf 105 */
                            }
                        } else {
                            if (x[FORAGING_FORAGER_1_X_FOOD_1_RIGHT] <= 0x1.4p+1f) { /* node 106: 2.5 */
                                if (x[FORAGING_FORAGER_1_X_MATE_0_DOWN] <= 0x1.8p+0f) { /* node 107: 1.5 */
                                    return FORAGING_FORAGER_1_ACTION_1; /* leaf 108 */
                                } else {
                                    return FORAGING_FORAGER_1_ACTION_4; /* leaf 109 */
                                }
                            } else {
                                if (x[FORAGING_FORAGER_1_X_FOOD_1_DOWN] <= 0x1p-1f) { /* node 110: 0.5 */
                                    return FORAGING_FORAGER_1_ACTION_5; /* leaf 111 */
                                } else {
                                    return FORAGING_FORAGER_1_ACTION_1; /* leaf 112 */
                                }
                            }
                        }
                    }
                } else {
                    if (x[FORAGING_FORAGER_1_X_MATE_0_DOWN] <= 0x1p-1f) { /* node 113: 0.5 */
                        if (x[FORAGING_FORAGER_1_X_MATE_0_RIGHT] <= 0x1.8p+0f) { /* node 114: 1.5 */
                            if (x[FORAGING_FORAGER_1_X_MATE_0_RIGHT] <= -0x1.8p+0f) { /* node 115: -1.5 */
                                if (x[FORAGING_FORAGER_1_X_FOOD_0_RIGHT] <= -0x1p-1f) { /* node 116: -0.5 */
                                    return FORAGING_FORAGER_1_ACTION_5; /* leaf 117 */
                                } else {
                                    return FORAGING_FORAGER_1_ACTION_2; /* leaf 118 */
                                }
                            } else {
                                if (x[FORAGING_FORAGER_1_X_FOOD_1_LATER] <= 0x1.cp+2f) { /* node 119: 7 */
                                    return FORAGING_FORAGER_1_ACTION_2; /* leaf 120 */
                                } else {
                                    return FORAGING_FORAGER_1_ACTION_5; /* leaf 121 */
                                }
                            }
                        } else {
                            if (x[FORAGING_FORAGER_1_X_FOOD_0_RIGHT] <= 0x1p-1f) { /* node 122: 0.5 */
                                return FORAGING_FORAGER_1_ACTION_2; /* leaf 123 */
                            } else {
                                if (x[FORAGING_FORAGER_1_X_FOOD_1_LATER] <= 0x1.8p+1f) { /* node 124: 3 */
                                    return FORAGING_FORAGER_1_ACTION_4; /* leaf 125 */
                                } else {
                                    return FORAGING_FORAGER_1_ACTION_5; /* leaf 126 */
                                }
                            }
                        }
                    } else {
                        if (x[FORAGING_FORAGER_1_X_MATE_0_RIGHT] <= 0x1.8p+0f) { /* node 127: 1.5 */
                            if (x[FORAGING_FORAGER_1_X_MATE_0_RIGHT] <= -0x1.8p+0f) { /* node 128: -1.5 */
                                if (x[FORAGING_FORAGER_1_X_FOOD_0_RIGHT] <= -0x1p-1f) { /* node 129: -0.5 */
                                    return FORAGING_FORAGER_1_ACTION_5; /* leaf 130 */
                                } else {
                                    return FORAGING_FORAGER_1_ACTION_2; /* leaf 131 */
                                }
                            } else {
                                if (x[FORAGING_FORAGER_1_X_MATE_0_DOWN] <= 0x1.4p+1f) { /* node 132: 2.5 */
                                    return FORAGING_FORAGER_1_ACTION_5; /* leaf 133 */
                                } else {
                                    return FORAGING_FORAGER_1_ACTION_5; /* leaf 134 */
                                }
                            }
                        } else {
                            if (x[FORAGING_FORAGER_1_X_FOOD_0_RIGHT] <= 0x1p-1f) { /* node 135: 0.5 */
                                if (x[FORAGING_FORAGER_1_X_MATE_0_DOWN] <= 0x1.4p+1f) { /* node 136: 2.5 */
                                    return FORAGING_FORAGER_1_ACTION_2; /* leaf 137 */
                                } else {
                                    return FORAGING_FORAGER_1_ACTION_2; /* leaf 138 */
                                }
                            } else {
                                if (x[FORAGING_FORAGER_1_X_MATE_0_RIGHT] <= 0x1.cp+1f) { /* node 139: 3.5 */
                                    return FORAGING_FORAGER_1_ACTION_5; /* leaf 140 */
                                } else {
                                    return FORAGING_FORAGER_1_ACTION_2; /* leaf 141 */
                                }
                            }
                        }
                    }
                }
            }
        }
    } else {
        if (x[FORAGING_FORAGER_1_X_FOOD_0_RIGHT] <= -0x1p-1f) { /* node 142: -0.5 */
            if (x[FORAGING_FORAGER_1_X_FOOD_0_DOWN] <= 0x1p-1f) { /* node 143: 0.5 */
                if (x[FORAGING_FORAGER_1_X_FOOD_0_DOWN] <= -0x1.8p+0f) { /* node 144: -1.5 */
                    if (x[FORAGING_FORAGER_1_X_FOOD_1_RIGHT] <= -0x1p-1f) { /* node 145: -0.5 */
                        if (x[FORAGING_FORAGER_1_X_FOOD_1_LATER] <= 0x1.8p+1f) { /* node 146: 3 */
                            if (x[FORAGING_FORAGER_1_X_FOOD_1_DOWN] <= -0x1.8p+0f) { /* node 147: -1.5 */
                                if (x[FORAGING_FORAGER_1_X_FOOD_1_RIGHT] <= -0x1.8p+0f) { /* node 148: -1.5 */
                                    return FORAGING_FORAGER_1_ACTION_1; /* leaf 149 */
                                } else {
                                    return FORAGING_FORAGER_1_ACTION_3; /* leaf 150 */
                                }
                            } else {
                                if (x[FORAGING_FORAGER_1_X_MATE_0_DOWN] <= -0x1.4p+1f) { /* node 151: -2.5 */
                                    return FORAGING_FORAGER_1_ACTION_1; /* leaf 152 */
                                } else {
                                    return FORAGING_FORAGER_1_ACTION_1; /* leaf 153 */
                                }
                            }
                        } else {
                            if (x[FORAGING_FORAGER_1_X_FOOD_0_DOWN] <= -0x1.4p+1f) { /* node 154: -2.5 */
                                if (x[FORAGING_FORAGER_1_X_FOOD_0_RIGHT] <= -0x1.8p+0f) { /* node 155: -1.5 */
                                    return FORAGING_FORAGER_1_ACTION_3; /* leaf 156 */
                                } else {
                                    return FORAGING_FORAGER_1_ACTION_1; /* leaf 157 */
                                }
                            } else {
                                if (x[FORAGING_FORAGER_1_X_MATE_0_RIGHT] <= -0x1.8p+0f) { /* node 158: -1.5 */
                                    return FORAGING_FORAGER_1_ACTION_3; /* leaf 159 */
                                } else {
                                    return FORAGING_FORAGER_1_ACTION_3; /* leaf 160 */
                                }
                            }
                        }
                    } else {
                        if (x[FORAGING_FORAGER_1_X_FOOD_1_RIGHT] <= 0x1p-1f) { /* node 161: 0.5 */
                            if (x[FORAGING_FORAGER_1_X_MATE_0_DOWN] <= 0x1p-1f) { /* node 162: 0.5 */
                                if (x[FORAGING_FORAGER_1_X_FOOD_1_DOWN] <= -0x1p-1f) { /* node 163: -0.5 */
                                    return FORAGING_FORAGER_1_ACTION_3; /* leaf 164 */
                                } else {
                                    return FORAGING_FORAGER_1_ACTION_1; /* leaf 165 */
                                }
                            } else {
                                if (x[FORAGING_FORAGER_1_X_FOOD_0_AWAY] <= 0x1.2p+2f) { /* node 166: 4.5 */
                                    return FORAGING_FORAGER_1_ACTION_1; /* leaf 167 */
                                } else {
                                    return FORAGING_FORAGER_1_ACTION_3; /* leaf 168 */
                                }
                            }
                        } else {
                            if (x[FORAGING_FORAGER_1_X_MATE_0_DOWN] <= -0x1.4p+1f) { /* node 169: -2.5 */
                                if (x[FORAGING_FORAGER_1_X_FOOD_1_RIGHT] <= 0x1.8p+0f) { /* node 170: 1.5 */
                                    return FORAGING_FORAGER_1_ACTION_3; /* leaf 171 */
                                } else {
                                    return FORAGING_FORAGER_1_ACTION_1; /* leaf 172 */
                                }
                            } else {
                                if (x[FORAGING_FORAGER_1_X_MATE_0_RIGHT] <= -0x1p-1f) { /* node 173: -0.5 */
                                    return FORAGING_FORAGER_1_ACTION_1; /* leaf 174 */
                                } else {
                                    return FORAGING_FORAGER_1_ACTION_1; /* leaf 175 */
                                }
                            }
                        }
                    }
                } else {
                    if (x[FORAGING_FORAGER_1_X_FOOD_0_DOWN] <= -0x1p-1f) { /* node 176: -0.5 */
                        if (x[FORAGING_FORAGER_1_X_MATE_0_DOWN] <= -0x1p-1f) { /* node 177: -0.5 */
                            if (x[FORAGING_FORAGER_1_X_MATE_0_RIGHT] <= -0x1p-1f) { /* node 178: -0.5 */
                                if (x[FORAGING_FORAGER_1_X_FOOD_1_LATER] <= 0x1p+0f) { /* node 179: 1 */
                                    return FORAGING_FORAGER_1_ACTION_3; /* leaf 180 */
                                } else {
                                    return FORAGING_FORAGER_1_ACTION_3; /* leaf 181 */
                                }
                            } else {
                                if (x[FORAGING_FORAGER_1_X_FOOD_0_RIGHT] <= -0x1.4p+1f) { /* node 182: -2.5 */
                                    return FORAGING_FORAGER_1_ACTION_3; /* leaf 183 */
                                } else {
                                    return FORAGING_FORAGER_1_ACTION_3; /* leaf 184 */
                                }
                            }
                        } else {
                            if (x[FORAGING_FORAGER_1_X_FOOD_1_RIGHT] <= -0x1.8p+0f) { /* node 185: -1.5 */
                                if (x[FORAGING_FORAGER_1_X_FOOD_0_RIGHT] <= -0x1.8p+0f) { /* node 186: -1.5 */
                                    return FORAGING_FORAGER_1_ACTION_1; /* leaf 187 */
                                } else {
                                    return FORAGING_FORAGER_1_ACTION_3; /* leaf 188 */
                                }
                            } else {
                                if (x[FORAGING_FORAGER_1_X_MATE_0_RIGHT] <= -0x1p-1f) { /* node 189: -0.5 */
                                    return FORAGING_FORAGER_1_ACTION_1; /* leaf 190 */
                                } else {
                                    return FORAGING_FORAGER_1_ACTION_1; /* leaf 191 */
                                }
                            }
                        }
                    } else {
                        if (x[FORAGING_FORAGER_1_X_FOOD_1_DOWN] <= 0x1p-1f) { /* node 192: 0.5 */
                            if (x[FORAGING_FORAGER_1_X_FOOD_0_RIGHT] <= -0x1.cp+1f) { /* node 193: -3.5 */
                                if (x[FORAGING_FORAGER_1_X_MATE_0_DOWN] <= 0x1.8p+0f) { /* node 194: 1.5 */
                                    return FORAGING_FORAGER_1_ACTION_1; /* leaf 195 */
                                } else {
                                    return FORAGING_FORAGER_1_ACTION_3; /* leaf 196 */
                                }
                            } else {
                                return FORAGING_FORAGER_1_ACTION_3; /* leaf 197 */
                            }
                        } else {
                            if (x[FORAGING_FORAGER_1_X_MATE_0_RIGHT] <= 0x1p-1f) { /* node 198: 0.5 */
                                if (x[FORAGING_FORAGER_1_X_MATE_0_RIGHT] <= -0x1p-1f) { /* node 199: -0.5 */
                                    return FORAGING_FORAGER_1_ACTION_3; /* leaf 200 */
                                } else {
                                    return FORAGING_FORAGER_1_ACTION_3; /* leaf 201 */
                                }
                            } else {
                                if (x[FORAGING_FORAGER_1_X_MATE_0_DOWN] <= -0x1p-1f) { /* node 202: -0.5 */
                                    return FORAGING_FORAGER_1_ACTION_2; /* leaf 203 */
                                } else {
                                    return FORAGING_FORAGER_1_ACTION_3; /* leaf 204 */
                                }
                            }
                        }
                    }
                }
            } else {
                if (x[FORAGING_FORAGER_1_X_FOOD_0_RIGHT] <= -0x1.4p+1f) { /* node 205: -2.5 */
                    if (x[FORAGING_FORAGER_1_X_FOOD_0_DOWN] <= 0x1.4p+1f) { /* node 206: 2.5 */
                        if (x[FORAGING_FORAGER_1_X_FOOD_1_LATER] <= 0x1p+0f) { /* node 207: 1 */
                            if (x[FORAGING_FORAGER_1_X_FOOD_1_DOWN] <= 0x1.4p+1f) { /* node 208: 2.5 */
                                if (x[FORAGING_FORAGER_1_X_MATE_0_RIGHT] <= -0x1.cp+1f) { /* node 209: -3.5 */
                                    return FORAGING_FORAGER_1_ACTION_3; /* leaf 210 */
                                } else {
                                    return FORAGING_FORAGER_1_ACTION_3; /* leaf 211 */
                                }
                            } else {
                                if (x[FORAGING_FORAGER_1_X_MATE_0_DOWN] <= 0x1p-1f) { /* node 212: 0.5 */
                                    return FORAGING_FORAGER_1_ACTION_2; /* leaf 213 */
                                } else {
                                    return FORAGING_FORAGER_1_ACTION_3; /* leaf 214 */
                                }
                            }
                        } else {
                            if (x[FORAGING_FORAGER_1_X_FOOD_0_DOWN] <= 0x1.8p+0f) { /* node 215: 1.5 */
                                if (x[FORAGING_FORAGER_1_X_FOOD_1_LATER] <= 0x1.8p+1f) { /* node 216: 3 */
                                    return FORAGING_FORAGER_1_ACTION_3; /* leaf 217 */
                                } else {
                                    return FORAGING_FORAGER_1_ACTION_3; /* leaf 218 */
                                }
                            } else {
                                if (x[FORAGING_FORAGER_1_X_FOOD_0_RIGHT] <= -0x1.cp+1f) { /* node 219: -3.5 */
                                    return FORAGING_FORAGER_1_ACTION_2; /* leaf 220 */
                                } else {
                                    return FORAGING_FORAGER_1_ACTION_2; /* leaf 221 */
                                }
                            }
                        }
                    } else {
                        if (x[FORAGING_FORAGER_1_X_FOOD_1_LATER] <= -0x1.8p+1f) { /* node 222: -3 */
                            if (x[FORAGING_FORAGER_1_X_FOOD_0_RIGHT] <= -0x1.cp+1f) { /* node 223: -3.5 */
                                return FORAGING_FORAGER_1_ACTION_3; /* leaf 224 */
                            } else {
                                return FORAGING_FORAGER_1_ACTION_2; /* leaf 225 */
                            }
                        } else {
                            return FORAGING_FORAGER_1_ACTION_2; /* leaf 226 */
                        }
                    }
                } else {
                    if (x[FORAGING_FORAGER_1_X_FOOD_1_AWAY] <= 0x1.4p+1f) { /* node 227: 2.5 */
                        if (x[FORAGING_FORAGER_1_X_MATE_0_DOWN] <= 0x1p-1f) { /* node 228: 0.5 */
                            if (x[FORAGING_FORAGER_1_X_FOOD_1_LATER] <= -0x1p+0f) { /* node 229: -1 */
                                return FORAGING_FORAGER_1_ACTION_3; /* leaf 230 */
                            } else {
                                if (x[FORAGING_FORAGER_1_X_MATE_0_RIGHT] <= -0x1.4p+1f) { /* node 231: -2.5 */
                                    return FORAGING_FORAGER_1_ACTION_2; /* leaf 232 */
                                } else {
                                    return FORAGING_FORAGER_1_ACTION_2; /* leaf 233 */
                                }
                            }
                        } else {
                            if (x[FORAGING_FORAGER_1_X_MATE_0_RIGHT] <= -0x1.4p+1f) { /* node 234: -2.5 */
                                if (x[FORAGING_FORAGER_1_X_FOOD_1_DOWN] <= 0x1.8p+0f) { /* node 235: 1.5 */
                                    return FORAGING_FORAGER_1_ACTION_3; /* leaf 236 */
                                } else {
                                    return FORAGING_FORAGER_1_ACTION_2; /* leaf 237 */
                                }
                            } else {
                                if (x[FORAGING_FORAGER_1_X_MATE_0_RIGHT] <= 0x1.8p+0f) { /* node 238: 1.5 */
                                    return FORAGING_FORAGER_1_ACTION_3; /* leaf 239 */
                                } else {
                                    return FORAGING_FORAGER_1_ACTION_3; /* leaf 240 */
                                }
                            }
                        }
                    } else {
                        if (x[FORAGING_FORAGER_1_X_FOOD_1_RIGHT] <= -0x1.8p+0f) { /* node 241: -1.5 */
                            if (x[FORAGING_FORAGER_1_X_MATE_0_DOWN] <= 0x1.8p+0f) { /* node 242: 1.5 */
                                if (x[FORAGING_FORAGER_1_X_FOOD_1_RIGHT] <= -0x1.cp+1f) { /* node 243: -3.5 */
                                    return FORAGING_FORAGER_1_ACTION_2; /* leaf 244 */
                                } else {
                                    return FORAGING_FORAGER_1_ACTION_2; /* leaf 245 */
                                }
                            } else {
                                if (x[FORAGING_FORAGER_1_X_FOOD_0_DOWN] <= 0x1.8p+0f) { /* node 246: 1.5 */
                                    return FORAGING_FORAGER_1_ACTION_3; /* leaf 247 */
                                } else {
                                    return FORAGING_FORAGER_1_ACTION_2; /* leaf 248 */
                                }
                            }
                        } else {
                            if (x[FORAGING_FORAGER_1_X_MATE_0_RIGHT] <= -0x1.cp+1f) { /* node 249: -3.5 */
                                if (x[FORAGING_FORAGER_1_X_FOOD_0_RIGHT] <= -0x1.8p+0f) { /* node 250: -1.5 */
                                    return FORAGING_FORAGER_1_ACTION_3; /* leaf 251 */
                                } else {
                                    return FORAGING_FORAGER_1_ACTION_2; /* leaf 252 */
                                }
                            } else {
                                if (x[FORAGING_FORAGER_1_X_MATE_0_RIGHT] <= -0x1.8p+0f) { /* node 253: -1.5 */
                                    return FORAGING_FORAGER_1_ACTION_2; /* leaf 254 */
                                } else {
                                    return FORAGING_FORAGER_1_ACTION_2; /* leaf 255 */
                                }
                            }
                        }
                    }
                }
            }
        } else {
            if (x[FORAGING_FORAGER_1_X_FOOD_0_DOWN] <= -0x1.8p+0f) { /* node 256: -1.5 */
                if (x[FORAGING_FORAGER_1_X_FOOD_1_LATER] <= -0x1p+0f) { /* node 257: -1 */
                    if (x[FORAGING_FORAGER_1_X_FOOD_1_DOWN] <= -0x1p-1f) { /* node 258: -0.5 */
                        if (x[FORAGING_FORAGER_1_X_FOOD_1_RIGHT] <= 0x1.8p+0f) { /* node 259: 1.5 */
                            if (x[FORAGING_FORAGER_1_X_FOOD_0_RIGHT] <= 0x1p-1f) { /* node 260: 0.5 */
                                if (x[FORAGING_FORAGER_1_X_FOOD_1_AWAY] <= 0x1.8p+0f) { /* node 261: 1.5 */
                                    return FORAGING_FORAGER_1_ACTION_4; /* leaf 262 */
                                } else {
                                    return FORAGING_FORAGER_1_ACTION_1; /* leaf 263 */
                                }
                            } else {
                                if (x[FORAGING_FORAGER_1_X_MATE_0_DOWN] <= -0x1p-1f) { /* node 264: -0.5 */
                                    return FORAGING_FORAGER_1_ACTION_4; /* leaf 265 */
                                } else {
                                    return FORAGING_FORAGER_1_ACTION_1; /* leaf 266 */
                                }
                            }
                        } else {
                            if (x[FORAGING_FORAGER_1_X_MATE_0_DOWN] <= -0x1.2p+2f) { /* node 267: -4.5 */
                                if (x[FORAGING_FORAGER_1_X_FOOD_1_DOWN] <= -0x1.8p+0f) { /* node 268: -1.5 */
                                    return FORAGING_FORAGER_1_ACTION_4; /* leaf 269 */
                                } else {
                                    return FORAGING_FORAGER_1_ACTION_1; /* leaf 270 */
                                }
                            } else {
                                return FORAGING_FORAGER_1_ACTION_1; /* leaf 271 */
                            }
                        }
                    } else {
                        if (x[FORAGING_FORAGER_1_X_MATE_0_RIGHT] <= 0x1p-1f) { /* node 272: 0.5 */
                            if (x[FORAGING_FORAGER_1_X_FOOD_0_AWAY] <= 0x1.6p+2f) { /* node 273: 5.5 */
                                if (x[FORAGING_FORAGER_1_X_MATE_0_DOWN] <= -0x1.8p+0f) { /* node 274: -1.5 */
                                    return FORAGING_FORAGER_1_ACTION_1; /* leaf 275 */
                                } else {
                                    return FORAGING_FORAGER_1_ACTION_1; /* leaf 276 */
                                }
                            } else {
                                if (x[FORAGING_FORAGER_1_X_FOOD_1_AWAY] <= 0x1.8p+0f) { /* node 277: 1.5 */
                                    return FORAGING_FORAGER_1_ACTION_4; /* leaf 278 */
                                } else {
                                    return FORAGING_FORAGER_1_ACTION_1; /* leaf 279 */
                                }
                            }
                        } else {
                            if (x[FORAGING_FORAGER_1_X_FOOD_1_LATER] <= -0x1.2p+3f) { /* node 280: -9 */
                                return FORAGING_FORAGER_1_ACTION_4; /* leaf 281 */
                            } else {
                                return FORAGING_FORAGER_1_ACTION_1; /* leaf 282 */
                            }
                        }
                    }
                } else {
                    if (x[FORAGING_FORAGER_1_X_FOOD_0_RIGHT] <= 0x1p-1f) { /* node 283: 0.5 */
                        if (x[FORAGING_FORAGER_1_X_MATE_0_DOWN] <= -0x1.2p+2f) { /* node 284: -4.5 */
                            if (x[FORAGING_FORAGER_1_X_FOOD_1_AWAY] <= 0x1.8p+0f) { /* node 285: 1.5 */
                                return FORAGING_FORAGER_1_ACTION_4; /* leaf 286 */
                            } else {
                                return FORAGING_FORAGER_1_ACTION_1; /* leaf 287 */
                            }
                        } else {
                            if (x[FORAGING_FORAGER_1_X_MATE_0_RIGHT] <= -0x1.cp+1f) { /* node 288: -3.5 */
                                if (x[FORAGING_FORAGER_1_X_FOOD_1_DOWN] <= -0x1p-1f) { /* node 289: -0.5 */
                                    return FORAGING_FORAGER_1_ACTION_1; /* leaf 290 */
                                } else {
                                    return FORAGING_FORAGER_1_ACTION_4; /* leaf 291 */
                                }
                            } else {
                                if (x[FORAGING_FORAGER_1_X_MATE_0_DOWN] <= 0x1p-1f) { /* node 292: 0.5 */
                                    return FORAGING_FORAGER_1_ACTION_1; /* leaf 293 */
                                } else {
                                    return FORAGING_FORAGER_1_ACTION_1; /* leaf 294 */
                                }
                            }
                        }
                    } else {
                        if (x[FORAGING_FORAGER_1_X_FOOD_1_RIGHT] <= 0x1p-1f) { /* node 295: 0.5 */
                            if (x[FORAGING_FORAGER_1_X_MATE_0_DOWN] <= -0x1.4p+1f) { /* node 296: -2.5 */
                                if (x[FORAGING_FORAGER_1_X_FOOD_1_LATER] <= 0x1p+0f) { /* node 297: 1 */
                                    return FORAGING_FORAGER_1_ACTION_4; /* leaf 298 */
                                } else {
                                    return FORAGING_FORAGER_1_ACTION_1; /* leaf 299 */
                                }
                            } else {
                                if (x[FORAGING_FORAGER_1_X_MATE_0_RIGHT] <= -0x1p-1f) { /* node 300: -0.5 */
                                    return FORAGING_FORAGER_1_ACTION_4; /* leaf 301 */
                                } else {
                                    return FORAGING_FORAGER_1_ACTION_1; /* leaf 302 */
                                }
                            }
                        } else {
                            if (x[FORAGING_FORAGER_1_X_MATE_0_RIGHT] <= -0x1p-1f) { /* node 303: -0.5 */
                                if (x[FORAGING_FORAGER_1_X_FOOD_1_DOWN] <= 0x1p-1f) { /* node 304: 0.5 */
                                    return FORAGING_FORAGER_1_ACTION_1; /* leaf 305 */
                                } else {
                                    return FORAGING_FORAGER_1_ACTION_4; /* leaf 306 */
                                }
                            } else {
                                if (x[FORAGING_FORAGER_1_X_FOOD_1_DOWN] <= 0x1p-1f) { /* node 307: 0.5 */
                                    return FORAGING_FORAGER_1_ACTION_1; /* leaf 308 */
                                } else {
                                    return FORAGING_FORAGER_1_ACTION_1; /* leaf 309 */
                                }
                            }
                        }
                    }
                }
            } else {
                if (x[FORAGING_FORAGER_1_X_FOOD_0_DOWN] <= 0x1p-1f) { /* node 310: 0.5 */
                    if (x[FORAGING_FORAGER_1_X_FOOD_0_DOWN] <= -0x1p-1f) { /* node 311: -0.5 */
                        if (x[FORAGING_FORAGER_1_X_MATE_0_DOWN] <= -0x1p-1f) { /* node 312: -0.5 */
                            if (x[FORAGING_FORAGER_1_X_MATE_0_RIGHT] <= 0x1.8p+0f) { /* node 313: 1.5 */
                                if (x[FORAGING_FORAGER_1_X_FOOD_1_LATER] <= -0x1.8p+1f) { /* node 314: -3 */
                                    return FORAGING_FORAGER_1_ACTION_1; /* leaf 315 */
                                } else {
                                    return FORAGING_FORAGER_1_ACTION_4; /* leaf 316 */
                                }
                            } else {
                                if (x[FORAGING_FORAGER_1_X_FOOD_1_AWAY] <= 0x1.4p+1f) { /* node 317: 2.5 */
                                    return FORAGING_FORAGER_1_ACTION_1; /* leaf 318 */
                                } else {
                                    return FORAGING_FORAGER_1_ACTION_4; /* leaf 319 */
                                }
                            }
                        } else {
                            if (x[FORAGING_FORAGER_1_X_MATE_0_RIGHT] <= -0x1p-1f) { /* node 320: -0.5 */
                                if (x[FORAGING_FORAGER_1_X_FOOD_1_RIGHT] <= -0x1.8p+0f) { /* node 321: -1.5 */
                                    return FORAGING_FORAGER_1_ACTION_1; /* leaf 322 */
                                } else {
                                    return FORAGING_FORAGER_1_ACTION_4; /* leaf 323 */
                                }
                            } else {
                                if (x[FORAGING_FORAGER_1_X_FOOD_1_AWAY] <= 0x1.cp+1f) { /* node 324: 3.5 */
                                    return FORAGING_FORAGER_1_ACTION_1; /* leaf 325 */
                                } else {
                                    return FORAGING_FORAGER_1_ACTION_1; /* leaf 326 */
                                }
                            }
                        }
                    } else {
                        if (x[FORAGING_FORAGER_1_X_MATE_0_RIGHT] <= 0x1p-1f) { /* node 327: 0.5 */
                            if (x[FORAGING_FORAGER_1_X_MATE_0_DOWN] <= -0x1p-1f) { /* node 328: -0.5 */
                                if (x[FORAGING_FORAGER_1_X_FOOD_1_RIGHT] <= -0x1p-1f) { /* node 329: -0.5 */
                                    return FORAGING_FORAGER_1_ACTION_2; /* leaf 330 */
                                } else {
                                    return FORAGING_FORAGER_1_ACTION_4; /* leaf 331 */
                                }
                            } else {
                                if (x[FORAGING_FORAGER_1_X_MATE_0_DOWN] <= 0x1p-1f) { /* node 332: 0.5 */
                                    return FORAGING_FORAGER_1_ACTION_4; /* leaf 333 */
                                } else {
                                    return FORAGING_FORAGER_1_ACTION_4; /* leaf 334 */
                                }
                            }
                        } else {
                            if (x[FORAGING_FORAGER_1_X_MATE_0_DOWN] <= 0x1.cp+1f) { /* node 335: 3.5 */
                                if (x[FORAGING_FORAGER_1_X_MATE_0_DOWN] <= 0x1.8p+0f) { /* node 336: 1.5 */
                                    return FORAGING_FORAGER_1_ACTION_4; /* leaf 337 */
                                } else {
                                    return FORAGING_FORAGER_1_ACTION_4; /* leaf 338 */
                                }
                            } else {
                                if (x[FORAGING_FORAGER_1_X_FOOD_1_RIGHT] <= -0x1p-1f) { /* node 339: -0.5 */
                                    return FORAGING_FORAGER_1_ACTION_1; /* leaf 340 */
                                } else {
                                    return FORAGING_FORAGER_1_ACTION_4; /* leaf 341 */
                                }
                            }
                        }
                    }
                } else {
                    if (x[FORAGING_FORAGER_1_X_FOOD_0_RIGHT] <= 0x1.4p+1f) { /* node 342: 2.5 */
                        if (x[FORAGING_FORAGER_1_X_FOOD_1_RIGHT] <= -0x1p-1f) { /* node 343: -0.5 */
                            if (x[FORAGING_FORAGER_1_X_FOOD_1_LATER] <= -0x1.8p+1f) { /* node 344: -3 */
                                return FORAGING_FORAGER_1_ACTION_4; /* leaf 345 */
                            } else {
                                if (x[FORAGING_FORAGER_1_X_FOOD_1_DOWN] <= 0x1.cp+1f) { /* node 346: 3.5 */
                                    return FORAGING_FORAGER_1_ACTION_2; /* leaf 347 */
                                } else {
                                    return FORAGING_FORAGER_1_ACTION_2; /* leaf 348 */
                                }
                            }
                        } else {
                            if (x[FORAGING_FORAGER_1_X_FOOD_0_DOWN] <= 0x1.8p+0f) { /* node 349: 1.5 */
                                if (x[FORAGING_FORAGER_1_X_MATE_0_RIGHT] <= 0x1p-1f) { /* node 350: 0.5 */
                                    return FORAGING_FORAGER_1_ACTION_4; /* leaf 351 */
                                } else {
                                    return FORAGING_FORAGER_1_ACTION_2; /* leaf 352 */
                                }
                            } else {
                                if (x[FORAGING_FORAGER_1_X_MATE_0_DOWN] <= 0x1.4p+1f) { /* node 353: 2.5 */
                                    return FORAGING_FORAGER_1_ACTION_2; /* leaf 354 */
                                } else {
                                    return FORAGING_FORAGER_1_ACTION_2; /* leaf 355 */
                                }
                            }
                        }
                    } else {
                        if (x[FORAGING_FORAGER_1_X_MATE_0_DOWN] <= 0x1p-1f) { /* node 356: 0.5 */
                            if (x[FORAGING_FORAGER_1_X_FOOD_0_RIGHT] <= 0x1.cp+1f) { /* node 357: 3.5 */
                                return FORAGING_FORAGER_1_ACTION_2; /* leaf 358 */
                            } else {
                                if (x[FORAGING_FORAGER_1_X_MATE_0_RIGHT] <= 0x1.4p+1f) { /* node 359: 2.5 */
                                    return FORAGING_FORAGER_1_ACTION_4; /* leaf 360 */
                                } else {
                                    return FORAGING_FORAGER_1_ACTION_2; /* leaf 361 */
                                }
                            }
                        } else {
                            if (x[FORAGING_FORAGER_1_X_FOOD_0_DOWN] <= 0x1.8p+0f) { /* node 362: 1.5 */
                                if (x[FORAGING_FORAGER_1_X_MATE_0_RIGHT] <= 0x1.2p+2f) { /* node 363: 4.5 */
                                    return FORAGING_FORAGER_1_ACTION_4; /* leaf 364 */
                                } else {
                                    return FORAGING_FORAGER_1_ACTION_2; /* leaf 365 */
                                }
                            } else {
                                if (x[FORAGING_FORAGER_1_X_MATE_0_RIGHT] <= 0x1p-1f) { /* node 366: 0.5 */
                                    return FORAGING_FORAGER_1_ACTION_4; /* leaf 367 */
                                } else {
                                    return FORAGING_FORAGER_1_ACTION_2; /* leaf 368 */
                                }
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
    if (!((x[0] >= -0x1.8p+4f) && (x[0] <= 0x1.8p+4f))) {
        within = 0;
    }
    if (!((x[1] >= -0x1.8p+4f) && (x[1] <= 0x1.8p+4f))) {
        within = 0;
    }
    if (!((x[2] >= -0x1.8p+4f) && (x[2] <= 0x1.8p+4f))) {
        within = 0;
    }
    if (!((x[3] >= -0x1.8p+4f) && (x[3] <= 0x1.8p+4f))) {
        within = 0;
    }
    if (!((x[4] >= -0x1.8p+4f) && (x[4] <= 0x1.8p+4f))) {
        within = 0;
    }
    if (!((x[5] >= -0x1.8p+4f) && (x[5] <= 0x1.8p+4f))) {
        within = 0;
    }
    if (!((x[6] >= -0x1.8p+4f) && (x[6] <= 0x1.8p+4f))) {
        within = 0;
    }
    if (!((x[7] >= -0x1.8p+4f) && (x[7] <= 0x1.8p+4f))) {
        within = 0;
    }
    if (!((x[8] >= -0x1.8p+4f) && (x[8] <= 0x1.8p+4f))) {
        within = 0;
    }
    if (!((x[9] >= -0x1.8p+4f) && (x[9] <= 0x1.8p+4f))) {
        within = 0;
    }
    return within;
}

static inline void foraging_forager_1_act_rows(const float *x, long n, unsigned char *actions)
{
    static const float threshold[255] = {0x1.8p+0f, 0x1.8p+0f, -0x1p-1f, -0x1p-1f, 0x1p+0f, 0x1p-1f, -0x1.8p+0f, 0x1p-1f, -0x1.8p+0f, 0x1p-1f, -0x1p-1f, -0x1.8p+0f, -0x1.4p+1f, -0x1p+0f, 0x1p-1f, -0x1.8p+0f, 0x1p-1f, 0x1p-1f, 0x1p-1f, -0x1p-1f, 0x1p-1f, -0x1p-1f, 0x1p-1f, -0x1p-1f, -0x1p-1f, 0x1.4p+1f, 0x1.4p+1f, -0x1p-1f, 0x1p-1f, -0x1p-1f, 0x1.4p+1f, 0x1p-1f, 0x1p-1f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, -0x1p-1f, 0x0p+0f, -0x1p-1f, 0x1p-1f, 0x1p-1f, 0x1p-1f, -0x1.4p+1f, -0x1p-1f, 0x1.8p+0f, 0x1.8p+0f, 0x1.8p+1f, 0x1p-1f, -0x1p-1f, 0x1p-1f, 0x1p+0f, -0x1.8p+1f, 0x1p-1f, -0x1.8p+0f, 0x1.8p+0f, 0x1p-1f, -0x1.2p+2f, 0x1p-1f, -0x1p-1f, 0x1p-1f, -0x1p-1f, 0x1p-1f, 0x1p-1f, -0x1.4p+1f, 0x0p+0f, -0x1p-1f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x1p-1f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x1p-1f, -0x1p-1f, -0x1.8p+0f, -0x1p-1f, 0x0p+0f, 0x1.4p+1f, -0x1p-1f, 0x1.4p+1f, 0x1.8p+0f, -0x1.8p+0f, -0x1p-1f, 0x1.4p+1f, -0x1.8p+0f, 0x1p-1f, -0x1.8p+0f, 0x1p-1f, -0x1.8p+0f, -0x1.4p+1f, 0x1p-1f, -0x1.4p+1f, -0x1p-1f, -0x1.8p+0f, -0x1.cp+1f, 0x1p-1f, 0x1.4p+1f, 0x1.8p+0f, -0x1.cp+1f, 0x0p+0f, -0x1p+0f, -0x1.4p+1f, 0x1.8p+0f, -0x1.cp+1f, 0x1p-1f, -0x1.2p+2f, 0x1.6p+2f, -0x1.2p+3f, 0x1.8p+0f, -0x1.cp+1f, -0x1.4p+1f, -0x1p-1f, 0x1.8p+0f, -0x1p-1f, -0x1p-1f, 0x1.cp+1f, -0x1.8p+1f, 0x1.8p+0f, 0x1.cp+1f, 0x1.8p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, -0x1p-1f, -0x1.4p+1f, 0x1p-1f, 0x1.4p+1f, 0x0p+0f, 0x0p+0f, -0x1p+0f, 0x1.8p+0f, 0x0p+0f, 0x0p+0f, -0x1p-1f, -0x1p-1f, 0x1.8p+0f, 0x1.8p+0f, -0x1p-1f, 0x1.8p+0f, 0x0p+0f, -0x1.8p+0f, 0x1p-1f, -0x1.4p+1f, 0x1.8p+0f, 0x0p+0f, 0x1.8p+0f, 0x1p-1f, -0x1p-1f, 0x1.cp+2f, 0x0p+0f, 0x1.8p+1f, -0x1p-1f, 0x1.4p+1f, 0x1.4p+1f, 0x1.cp+1f, -0x1.8p+0f, -0x1.4p+1f, -0x1.8p+0f, -0x1.8p+0f, -0x1p-1f, 0x1.2p+2f, 0x1.8p+0f, -0x1p-1f, 0x1p+0f, -0x1.4p+1f, -0x1.8p+0f, -0x1p-1f, 0x1.8p+0f, 0x0p+0f, -0x1p-1f, -0x1p-1f, -0x1.cp+1f, 0x1p-1f, 0x1.8p+1f, -0x1.cp+1f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, -0x1.4p+1f, 0x1.8p+0f, 0x1.8p+0f, -0x1.cp+1f, 0x1.8p+0f, -0x1.8p+0f, -0x1.8p+0f, 0x1.8p+0f, -0x1p-1f, -0x1.8p+0f, 0x0p+0f, -0x1.8p+0f, 0x1.8p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, -0x1p-1f, 0x1p-1f, 0x1p+0f, -0x1p-1f, 0x1p-1f, 0x1p-1f, -0x1.8p+1f, 0x1.4p+1f, -0x1.8p+0f, 0x1.cp+1f, -0x1p-1f, 0x1p-1f, 0x1.8p+0f, -0x1p-1f, 0x0p+0f, 0x1.cp+1f, 0x1p-1f, 0x1.4p+1f, 0x0p+0f, 0x1.4p+1f, 0x1.2p+2f, 0x1p-1f};
    static const unsigned char feature[255] = {2, 6, 1, 9, 7, 0, 0, 5, 8, 5, 0, 0, 1, 7, 0, 9, 8, 4, 9, 5, 4, 8, 8, 5, 0, 0, 6, 4, 1, 0, 1, 8, 4, 0, 0, 0, 0, 8, 0, 9, 2, 2, 9, 9, 5, 9, 9, 7, 5, 8, 4, 7, 7, 8, 5, 5, 9, 8, 5, 8, 9, 5, 8, 4, 9, 0, 8, 0, 0, 0, 0, 0, 0, 0, 0, 4, 0, 0, 0, 4, 8, 4, 1, 0, 9, 1, 5, 4, 9, 9, 5, 9, 1, 9, 1, 4, 0, 8, 8, 9, 5, 1, 9, 4, 0, 1, 0, 7, 9, 8, 9, 1, 8, 2, 7, 6, 9, 8, 9, 9, 9, 8, 8, 7, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 5, 4, 4, 0, 0, 7, 9, 0, 0, 0, 1, 4, 8, 0, 4, 0, 5, 5, 8, 8, 0, 8, 4, 1, 7, 0, 7, 1, 8, 8, 9, 5, 8, 1, 9, 4, 2, 5, 9, 7, 1, 1, 9, 8, 0, 9, 8, 9, 8, 7, 1, 0, 0, 0, 0, 0, 9, 4, 9, 5, 0, 1, 9, 6, 8, 4, 0, 8, 6, 0, 0, 0, 0, 4, 8, 7, 9, 4, 4, 7, 6, 5, 6, 5, 8, 8, 5, 0, 4, 9, 8, 0, 9, 9, 9};
    static const unsigned char action[256] = {5, 5, 2, 2, 2, 2, 5, 5, 5, 5, 5, 5, 2, 2, 5, 5, 2, 2, 2, 2, 2, 2, 2, 2, 4, 4, 4, 4, 4, 4, 4, 4, 5, 5, 5, 5, 5, 5, 5, 5, 4, 4, 4, 4, 4, 4, 4, 4, 5, 5, 4, 4, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 3, 3, 2, 3, 2, 3, 2, 5, 5, 2, 2, 2, 3, 4, 2, 4, 4, 4, 4, 1, 2, 2, 4, 5, 2, 4, 4, 1, 2, 4, 2, 0, 0, 2, 2, 5, 1, 5, 5, 5, 3, 3, 3, 1, 4, 5, 1, 5, 2, 2, 5, 2, 2, 4, 5, 5, 2, 5, 5, 2, 2, 5, 2, 1, 3, 1, 1, 3, 1, 3, 3, 3, 1, 1, 3, 3, 1, 1, 1, 3, 3, 3, 3, 1, 3, 1, 1, 1, 3, 3, 3, 3, 3, 2, 3, 3, 3, 2, 3, 3, 3, 2, 2, 3, 3, 2, 2, 2, 2, 2, 2, 3, 3, 2, 2, 3, 2, 3, 3, 2, 2, 3, 2, 3, 2, 2, 2, 4, 1, 4, 1, 4, 1, 1, 1, 1, 1, 4, 1, 4, 4, 1, 1, 4, 4, 1, 1, 1, 4, 1, 1, 4, 1, 4, 1, 1, 4, 1, 1, 1, 4, 1, 4, 1, 4, 1, 1, 2, 4, 4, 4, 4, 4, 1, 4, 4, 4, 2, 2, 4, 2, 2, 2, 2, 2, 4, 2, 4, 2, 4, 2};
    long row;
    /* eight observations side by side, so that none waits for another */
    const long together = n - (n % 8);
    for (row = 0; row < together; row += 8) {
        const float *const seen = &x[row * FORAGING_FORAGER_1_N_FEATURES];
        int i[8] = {0, 0, 0, 0, 0, 0, 0, 0};
        int level;
        int k;
        for (level = 0; level < 8; level++) {
            for (k = 0; k < 8; k++) {
                i[k] = (2 * i[k]) + 1 + ((seen[(k * FORAGING_FORAGER_1_N_FEATURES) + feature[i[k]]] <= threshold[i[k]]) ? 0 : 1);
            }
        }
        for (k = 0; k < 8; k++) {
            actions[row + k] = action[i[k] - 255];
        }
    }
    for (row = together; row < n; row++) {
        const float *const seen = &x[row * FORAGING_FORAGER_1_N_FEATURES];
        int i = 0;
        int level;
        for (level = 0; level < 8; level++) {
            i = (2 * i) + 1 + ((seen[feature[i]] <= threshold[i]) ? 0 : 1);
        }
        actions[row] = action[i - 255];
    }
}

static inline void foraging_forager_1_act_columns(const float *const *x, long n, unsigned char *actions)
{
    static const float threshold[255] = {0x1.8p+0f, 0x1.8p+0f, -0x1p-1f, -0x1p-1f, 0x1p+0f, 0x1p-1f, -0x1.8p+0f, 0x1p-1f, -0x1.8p+0f, 0x1p-1f, -0x1p-1f, -0x1.8p+0f, -0x1.4p+1f, -0x1p+0f, 0x1p-1f, -0x1.8p+0f, 0x1p-1f, 0x1p-1f, 0x1p-1f, -0x1p-1f, 0x1p-1f, -0x1p-1f, 0x1p-1f, -0x1p-1f, -0x1p-1f, 0x1.4p+1f, 0x1.4p+1f, -0x1p-1f, 0x1p-1f, -0x1p-1f, 0x1.4p+1f, 0x1p-1f, 0x1p-1f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, -0x1p-1f, 0x0p+0f, -0x1p-1f, 0x1p-1f, 0x1p-1f, 0x1p-1f, -0x1.4p+1f, -0x1p-1f, 0x1.8p+0f, 0x1.8p+0f, 0x1.8p+1f, 0x1p-1f, -0x1p-1f, 0x1p-1f, 0x1p+0f, -0x1.8p+1f, 0x1p-1f, -0x1.8p+0f, 0x1.8p+0f, 0x1p-1f, -0x1.2p+2f, 0x1p-1f, -0x1p-1f, 0x1p-1f, -0x1p-1f, 0x1p-1f, 0x1p-1f, -0x1.4p+1f, 0x0p+0f, -0x1p-1f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x1p-1f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x1p-1f, -0x1p-1f, -0x1.8p+0f, -0x1p-1f, 0x0p+0f, 0x1.4p+1f, -0x1p-1f, 0x1.4p+1f, 0x1.8p+0f, -0x1.8p+0f, -0x1p-1f, 0x1.4p+1f, -0x1.8p+0f, 0x1p-1f, -0x1.8p+0f, 0x1p-1f, -0x1.8p+0f, -0x1.4p+1f, 0x1p-1f, -0x1.4p+1f, -0x1p-1f, -0x1.8p+0f, -0x1.cp+1f, 0x1p-1f, 0x1.4p+1f, 0x1.8p+0f, -0x1.cp+1f, 0x0p+0f, -0x1p+0f, -0x1.4p+1f, 0x1.8p+0f, -0x1.cp+1f, 0x1p-1f, -0x1.2p+2f, 0x1.6p+2f, -0x1.2p+3f, 0x1.8p+0f, -0x1.cp+1f, -0x1.4p+1f, -0x1p-1f, 0x1.8p+0f, -0x1p-1f, -0x1p-1f, 0x1.cp+1f, -0x1.8p+1f, 0x1.8p+0f, 0x1.cp+1f, 0x1.8p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, -0x1p-1f, -0x1.4p+1f, 0x1p-1f, 0x1.4p+1f, 0x0p+0f, 0x0p+0f, -0x1p+0f, 0x1.8p+0f, 0x0p+0f, 0x0p+0f, -0x1p-1f, -0x1p-1f, 0x1.8p+0f, 0x1.8p+0f, -0x1p-1f, 0x1.8p+0f, 0x0p+0f, -0x1.8p+0f, 0x1p-1f, -0x1.4p+1f, 0x1.8p+0f, 0x0p+0f, 0x1.8p+0f, 0x1p-1f, -0x1p-1f, 0x1.cp+2f, 0x0p+0f, 0x1.8p+1f, -0x1p-1f, 0x1.4p+1f, 0x1.4p+1f, 0x1.cp+1f, -0x1.8p+0f, -0x1.4p+1f, -0x1.8p+0f, -0x1.8p+0f, -0x1p-1f, 0x1.2p+2f, 0x1.8p+0f, -0x1p-1f, 0x1p+0f, -0x1.4p+1f, -0x1.8p+0f, -0x1p-1f, 0x1.8p+0f, 0x0p+0f, -0x1p-1f, -0x1p-1f, -0x1.cp+1f, 0x1p-1f, 0x1.8p+1f, -0x1.cp+1f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, -0x1.4p+1f, 0x1.8p+0f, 0x1.8p+0f, -0x1.cp+1f, 0x1.8p+0f, -0x1.8p+0f, -0x1.8p+0f, 0x1.8p+0f, -0x1p-1f, -0x1.8p+0f, 0x0p+0f, -0x1.8p+0f, 0x1.8p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, -0x1p-1f, 0x1p-1f, 0x1p+0f, -0x1p-1f, 0x1p-1f, 0x1p-1f, -0x1.8p+1f, 0x1.4p+1f, -0x1.8p+0f, 0x1.cp+1f, -0x1p-1f, 0x1p-1f, 0x1.8p+0f, -0x1p-1f, 0x0p+0f, 0x1.cp+1f, 0x1p-1f, 0x1.4p+1f, 0x0p+0f, 0x1.4p+1f, 0x1.2p+2f, 0x1p-1f};
    static const unsigned char feature[255] = {2, 6, 1, 9, 7, 0, 0, 5, 8, 5, 0, 0, 1, 7, 0, 9, 8, 4, 9, 5, 4, 8, 8, 5, 0, 0, 6, 4, 1, 0, 1, 8, 4, 0, 0, 0, 0, 8, 0, 9, 2, 2, 9, 9, 5, 9, 9, 7, 5, 8, 4, 7, 7, 8, 5, 5, 9, 8, 5, 8, 9, 5, 8, 4, 9, 0, 8, 0, 0, 0, 0, 0, 0, 0, 0, 4, 0, 0, 0, 4, 8, 4, 1, 0, 9, 1, 5, 4, 9, 9, 5, 9, 1, 9, 1, 4, 0, 8, 8, 9, 5, 1, 9, 4, 0, 1, 0, 7, 9, 8, 9, 1, 8, 2, 7, 6, 9, 8, 9, 9, 9, 8, 8, 7, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 5, 4, 4, 0, 0, 7, 9, 0, 0, 0, 1, 4, 8, 0, 4, 0, 5, 5, 8, 8, 0, 8, 4, 1, 7, 0, 7, 1, 8, 8, 9, 5, 8, 1, 9, 4, 2, 5, 9, 7, 1, 1, 9, 8, 0, 9, 8, 9, 8, 7, 1, 0, 0, 0, 0, 0, 9, 4, 9, 5, 0, 1, 9, 6, 8, 4, 0, 8, 6, 0, 0, 0, 0, 4, 8, 7, 9, 4, 4, 7, 6, 5, 6, 5, 8, 8, 5, 0, 4, 9, 8, 0, 9, 9, 9};
    static const unsigned char action[256] = {5, 5, 2, 2, 2, 2, 5, 5, 5, 5, 5, 5, 2, 2, 5, 5, 2, 2, 2, 2, 2, 2, 2, 2, 4, 4, 4, 4, 4, 4, 4, 4, 5, 5, 5, 5, 5, 5, 5, 5, 4, 4, 4, 4, 4, 4, 4, 4, 5, 5, 4, 4, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 3, 3, 2, 3, 2, 3, 2, 5, 5, 2, 2, 2, 3, 4, 2, 4, 4, 4, 4, 1, 2, 2, 4, 5, 2, 4, 4, 1, 2, 4, 2, 0, 0, 2, 2, 5, 1, 5, 5, 5, 3, 3, 3, 1, 4, 5, 1, 5, 2, 2, 5, 2, 2, 4, 5, 5, 2, 5, 5, 2, 2, 5, 2, 1, 3, 1, 1, 3, 1, 3, 3, 3, 1, 1, 3, 3, 1, 1, 1, 3, 3, 3, 3, 1, 3, 1, 1, 1, 3, 3, 3, 3, 3, 2, 3, 3, 3, 2, 3, 3, 3, 2, 2, 3, 3, 2, 2, 2, 2, 2, 2, 3, 3, 2, 2, 3, 2, 3, 3, 2, 2, 3, 2, 3, 2, 2, 2, 4, 1, 4, 1, 4, 1, 1, 1, 1, 1, 4, 1, 4, 4, 1, 1, 4, 4, 1, 1, 1, 4, 1, 1, 4, 1, 4, 1, 1, 4, 1, 1, 1, 4, 1, 4, 1, 4, 1, 1, 2, 4, 4, 4, 4, 4, 1, 4, 4, 4, 2, 2, 4, 2, 2, 2, 2, 2, 4, 2, 4, 2, 4, 2};
    long row;
    for (row = 0; row < n; row++) {
        int i = 0;
        int level;
        for (level = 0; level < 8; level++) {
            i = (2 * i) + 1 + ((x[feature[i]][row] <= threshold[i]) ? 0 : 1);
        }
        actions[row] = action[i - 255];
    }
}

static inline void foraging_act_all(const float *const *x, int *actions)
{
    /* branch-free walks side by side, so that no agent waits for another and the time does not depend on the data */
    static const float threshold_0[255] = {0x1.8p+0f, 0x1.8p+0f, -0x1p-1f, -0x1p-1f, 0x1p+0f, -0x1p-1f, 0x1.8p+0f, 0x1p-1f, -0x1.8p+0f, 0x1p-1f, -0x1p-1f, 0x1.4p+1f, -0x1.8p+0f, 0x1p-1f, 0x1p-1f, -0x1.8p+0f, 0x1p-1f, 0x1p-1f, -0x1p-1f, 0x1.8p+0f, 0x1p-1f, -0x1p-1f, 0x1p-1f, -0x1p-1f, -0x1p-1f, -0x1p+0f, -0x1p-1f, 0x1p-1f, -0x1.4p+1f, 0x1p-1f, 0x1.8p+0f, 0x1p-1f, 0x1p-1f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x1p-1f, 0x0p+0f, 0x1p-1f, 0x1p-1f, 0x1p-1f, 0x1p-1f, -0x1.4p+1f, -0x1p-1f, 0x1.8p+1f, 0x1p-1f, -0x1.8p+0f, -0x1.8p+0f, 0x1.8p+1f, -0x1p-1f, 0x1p-1f, 0x1p-1f, 0x1p-1f, 0x1.2p+2f, -0x1.cp+1f, 0x1.8p+0f, 0x1.4p+1f, 0x1.4p+1f, -0x1p-1f, 0x1.4p+1f, 0x1p-1f, 0x1.4p+1f, 0x1p-1f, 0x0p+0f, 0x0p+0f, -0x1p-1f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x1p-1f, 0x0p+0f, 0x0p+0f, 0x1p-1f, 0x1p-1f, -0x1p-1f, 0x1p-1f, 0x0p+0f, 0x1p-1f, -0x1p-1f, 0x1.4p+1f, -0x1.8p+0f, -0x1.8p+0f, -0x1p-1f, 0x1p-1f, 0x1.4p+1f, 0x1p-1f, 0x1.8p+0f, 0x1.8p+1f, -0x1p-1f, 0x0p+0f, 0x0p+0f, 0x1p-1f, -0x1p-1f, -0x1.4p+1f, -0x1.8p+0f, 0x1p-1f, 0x1p-1f, 0x1p-1f, -0x1.2p+2f, 0x1.8p+0f, 0x0p+0f, 0x1.4p+1f, -0x1p-1f, 0x1.8p+0f, -0x1.4p+2f, 0x0p+0f, -0x1p-1f, 0x1p-1f, 0x1.8p+1f, -0x1.cp+1f, 0x1p-1f, 0x1.4p+1f, -0x1p-1f, -0x1p+0f, 0x1.2p+2f, -0x1p-1f, 0x1.cp+1f, -0x1p-1f, 0x1.4p+1f, -0x1p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, -0x1p-1f, 0x1p-1f, -0x1p-1f, -0x1p+0f, -0x1p-1f, 0x0p+0f, 0x1p-1f, 0x1.8p+0f, 0x0p+0f, 0x0p+0f, -0x1p-1f, 0x1.8p+0f, 0x0p+0f, 0x1.8p+0f, -0x1p-1f, 0x1.4p+1f, 0x0p+0f, 0x1.8p+0f, -0x1.8p+0f, -0x1.4p+1f, -0x1.4p+1f, 0x0p+0f, -0x1p-1f, 0x1p-1f, -0x1.4p+1f, 0x1p-1f, -0x1.8p+0f, 0x1p-1f, 0x1.cp+1f, 0x1.cp+1f, 0x1.4p+1f, -0x1.8p+0f, -0x1.8p+0f, -0x1.8p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x1p-1f, 0x1.cp+1f, -0x1.8p+0f, -0x1.8p+0f, -0x1.8p+0f, -0x1p-1f, -0x1p+0f, -0x1.8p+0f, 0x1.8p+0f, -0x1p-1f, 0x1p-1f, -0x1.8p+1f, -0x1.cp+1f, 0x1.8p+0f, -0x1.cp+1f, -0x1p-1f, -0x1p-1f, 0x0p+0f, 0x0p+0f, 0x1.8p+0f, 0x1.8p+0f, 0x1.8p+0f, 0x1.cp+1f, 0x1p+0f, 0x1.4p+1f, 0x0p+0f, 0x1.8p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, -0x1p-1f, -0x1p-1f, -0x1p+0f, 0x1.4p+1f, 0x1.8p+0f, -0x1.8p+0f, 0x0p+0f, -0x1p+0f, 0x1.2p+2f, 0x1.8p+0f, -0x1p-1f, 0x0p+0f, -0x1p-1f, 0x0p+0f, 0x1p-1f, -0x1.8p+0f, 0x1.4p+1f, 0x0p+0f, 0x1.8p+0f, 0x1.cp+2f, 0x1.4p+2f, 0x1.cp+1f, -0x1p-1f, -0x1.8p+1f, 0x1.8p+0f, 0x1p-1f, 0x1.8p+0f};
    static const unsigned char feature_0[255] = {2, 6, 0, 9, 7, 1, 1, 5, 8, 5, 0, 2, 0, 0, 0, 9, 8, 4, 8, 4, 4, 8, 8, 8, 5, 7, 8, 4, 1, 9, 0, 8, 4, 0, 0, 0, 0, 4, 0, 8, 2, 2, 9, 9, 5, 7, 0, 9, 5, 7, 8, 5, 1, 9, 6, 1, 9, 0, 6, 8, 8, 8, 8, 4, 0, 0, 8, 0, 0, 0, 0, 0, 0, 0, 0, 0, 9, 0, 0, 4, 1, 5, 1, 0, 8, 1, 5, 8, 9, 9, 9, 9, 1, 8, 7, 5, 0, 0, 9, 9, 0, 1, 5, 1, 9, 8, 6, 0, 6, 9, 1, 7, 0, 9, 5, 7, 1, 8, 5, 5, 7, 9, 5, 1, 5, 5, 7, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 9, 0, 7, 9, 0, 0, 9, 0, 0, 0, 9, 0, 8, 0, 9, 0, 4, 8, 8, 9, 0, 4, 8, 5, 1, 9, 9, 9, 6, 8, 9, 5, 8, 0, 0, 0, 0, 0, 4, 2, 1, 1, 5, 4, 7, 9, 9, 5, 8, 7, 8, 6, 9, 4, 9, 0, 0, 4, 5, 8, 6, 7, 8, 0, 8, 0, 0, 0, 8, 8, 7, 4, 8, 5, 0, 7, 8, 8, 9, 0, 9, 0, 5, 8, 1, 0, 6, 7, 7, 8, 9, 7, 8, 5, 9};
    static const unsigned char action_0[256] = {5, 5, 2, 2, 5, 5, 5, 5, 5, 5, 5, 5, 2, 2, 5, 5, 2, 2, 2, 2, 2, 2, 2, 2, 4, 4, 4, 4, 4, 4, 4, 4, 5, 5, 5, 5, 5, 5, 5, 5, 4, 4, 4, 4, 4, 4, 4, 4, 5, 5, 5, 5, 4, 4, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 3, 2, 3, 3, 3, 4, 5, 2, 3, 2, 2, 3, 2, 4, 5, 4, 4, 4, 4, 1, 2, 5, 4, 5, 5, 4, 4, 1, 2, 4, 2, 2, 2, 0, 2, 0, 5, 5, 5, 4, 5, 3, 3, 5, 1, 5, 1, 2, 2, 2, 4, 5, 2, 2, 5, 5, 2, 5, 5, 2, 3, 2, 5, 3, 3, 3, 1, 3, 3, 3, 3, 3, 3, 3, 3, 1, 1, 1, 3, 1, 1, 3, 1, 3, 1, 3, 3, 3, 3, 3, 1, 1, 3, 1, 1, 1, 3, 4, 1, 4, 1, 1, 1, 4, 1, 1, 1, 4, 1, 1, 1, 4, 4, 4, 4, 1, 4, 4, 4, 4, 4, 1, 1, 4, 1, 4, 1, 3, 3, 1, 3, 3, 3, 3, 3, 3, 3, 3, 3, 2, 3, 3, 2, 3, 3, 2, 3, 2, 3, 2, 2, 3, 2, 3, 2, 2, 2, 4, 2, 2, 2, 2, 4, 4, 4, 2, 4, 4, 4, 4, 4, 1, 1, 4, 4, 2, 4, 4, 2, 2, 4, 4, 4, 2, 2, 2, 4, 2, 4, 4, 2};
    static const float threshold_1[255] = {0x1.8p+0f, 0x1.8p+0f, -0x1p-1f, -0x1p-1f, 0x1p+0f, 0x1p-1f, -0x1.8p+0f, 0x1p-1f, -0x1.8p+0f, 0x1p-1f, -0x1p-1f, -0x1.8p+0f, -0x1.4p+1f, -0x1p+0f, 0x1p-1f, -0x1.8p+0f, 0x1p-1f, 0x1p-1f, 0x1p-1f, -0x1p-1f, 0x1p-1f, -0x1p-1f, 0x1p-1f, -0x1p-1f, -0x1p-1f, 0x1.4p+1f, 0x1.4p+1f, -0x1p-1f, 0x1p-1f, -0x1p-1f, 0x1.4p+1f, 0x1p-1f, 0x1p-1f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, -0x1p-1f, 0x0p+0f, -0x1p-1f, 0x1p-1f, 0x1p-1f, 0x1p-1f, -0x1.4p+1f, -0x1p-1f, 0x1.8p+0f, 0x1.8p+0f, 0x1.8p+1f, 0x1p-1f, -0x1p-1f, 0x1p-1f, 0x1p+0f, -0x1.8p+1f, 0x1p-1f, -0x1.8p+0f, 0x1.8p+0f, 0x1p-1f, -0x1.2p+2f, 0x1p-1f, -0x1p-1f, 0x1p-1f, -0x1p-1f, 0x1p-1f, 0x1p-1f, -0x1.4p+1f, 0x0p+0f, -0x1p-1f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x1p-1f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x1p-1f, -0x1p-1f, -0x1.8p+0f, -0x1p-1f, 0x0p+0f, 0x1.4p+1f, -0x1p-1f, 0x1.4p+1f, 0x1.8p+0f, -0x1.8p+0f, -0x1p-1f, 0x1.4p+1f, -0x1.8p+0f, 0x1p-1f, -0x1.8p+0f, 0x1p-1f, -0x1.8p+0f, -0x1.4p+1f, 0x1p-1f, -0x1.4p+1f, -0x1p-1f, -0x1.8p+0f, -0x1.cp+1f, 0x1p-1f, 0x1.4p+1f, 0x1.8p+0f, -0x1.cp+1f, 0x0p+0f, -0x1p+0f, -0x1.4p+1f, 0x1.8p+0f, -0x1.cp+1f, 0x1p-1f, -0x1.2p+2f, 0x1.6p+2f, -0x1.2p+3f, 0x1.8p+0f, -0x1.cp+1f, -0x1.4p+1f, -0x1p-1f, 0x1.8p+0f, -0x1p-1f, -0x1p-1f, 0x1.cp+1f, -0x1.8p+1f, 0x1.8p+0f, 0x1.cp+1f, 0x1.8p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, -0x1p-1f, -0x1.4p+1f, 0x1p-1f, 0x1.4p+1f, 0x0p+0f, 0x0p+0f, -0x1p+0f, 0x1.8p+0f, 0x0p+0f, 0x0p+0f, -0x1p-1f, -0x1p-1f, 0x1.8p+0f, 0x1.8p+0f, -0x1p-1f, 0x1.8p+0f, 0x0p+0f, -0x1.8p+0f, 0x1p-1f, -0x1.4p+1f, 0x1.8p+0f, 0x0p+0f, 0x1.8p+0f, 0x1p-1f, -0x1p-1f, 0x1.cp+2f, 0x0p+0f, 0x1.8p+1f, -0x1p-1f, 0x1.4p+1f, 0x1.4p+1f, 0x1.cp+1f, -0x1.8p+0f, -0x1.4p+1f, -0x1.8p+0f, -0x1.8p+0f, -0x1p-1f, 0x1.2p+2f, 0x1.8p+0f, -0x1p-1f, 0x1p+0f, -0x1.4p+1f, -0x1.8p+0f, -0x1p-1f, 0x1.8p+0f, 0x0p+0f, -0x1p-1f, -0x1p-1f, -0x1.cp+1f, 0x1p-1f, 0x1.8p+1f, -0x1.cp+1f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, -0x1.4p+1f, 0x1.8p+0f, 0x1.8p+0f, -0x1.cp+1f, 0x1.8p+0f, -0x1.8p+0f, -0x1.8p+0f, 0x1.8p+0f, -0x1p-1f, -0x1.8p+0f, 0x0p+0f, -0x1.8p+0f, 0x1.8p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, 0x0p+0f, -0x1p-1f, 0x1p-1f, 0x1p+0f, -0x1p-1f, 0x1p-1f, 0x1p-1f, -0x1.8p+1f, 0x1.4p+1f, -0x1.8p+0f, 0x1.cp+1f, -0x1p-1f, 0x1p-1f, 0x1.8p+0f, -0x1p-1f, 0x0p+0f, 0x1.cp+1f, 0x1p-1f, 0x1.4p+1f, 0x0p+0f, 0x1.4p+1f, 0x1.2p+2f, 0x1p-1f};
    static const unsigned char feature_1[255] = {2, 6, 1, 9, 7, 0, 0, 5, 8, 5, 0, 0, 1, 7, 0, 9, 8, 4, 9, 5, 4, 8, 8, 5, 0, 0, 6, 4, 1, 0, 1, 8, 4, 0, 0, 0, 0, 8, 0, 9, 2, 2, 9, 9, 5, 9, 9, 7, 5, 8, 4, 7, 7, 8, 5, 5, 9, 8, 5, 8, 9, 5, 8, 4, 9, 0, 8, 0, 0, 0, 0, 0, 0, 0, 0, 4, 0, 0, 0, 4, 8, 4, 1, 0, 9, 1, 5, 4, 9, 9, 5, 9, 1, 9, 1, 4, 0, 8, 8, 9, 5, 1, 9, 4, 0, 1, 0, 7, 9, 8, 9, 1, 8, 2, 7, 6, 9, 8, 9, 9, 9, 8, 8, 7, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 5, 4, 4, 0, 0, 7, 9, 0, 0, 0, 1, 4, 8, 0, 4, 0, 5, 5, 8, 8, 0, 8, 4, 1, 7, 0, 7, 1, 8, 8, 9, 5, 8, 1, 9, 4, 2, 5, 9, 7, 1, 1, 9, 8, 0, 9, 8, 9, 8, 7, 1, 0, 0, 0, 0, 0, 9, 4, 9, 5, 0, 1, 9, 6, 8, 4, 0, 8, 6, 0, 0, 0, 0, 4, 8, 7, 9, 4, 4, 7, 6, 5, 6, 5, 8, 8, 5, 0, 4, 9, 8, 0, 9, 9, 9};
    static const unsigned char action_1[256] = {5, 5, 2, 2, 2, 2, 5, 5, 5, 5, 5, 5, 2, 2, 5, 5, 2, 2, 2, 2, 2, 2, 2, 2, 4, 4, 4, 4, 4, 4, 4, 4, 5, 5, 5, 5, 5, 5, 5, 5, 4, 4, 4, 4, 4, 4, 4, 4, 5, 5, 4, 4, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 3, 3, 2, 3, 2, 3, 2, 5, 5, 2, 2, 2, 3, 4, 2, 4, 4, 4, 4, 1, 2, 2, 4, 5, 2, 4, 4, 1, 2, 4, 2, 0, 0, 2, 2, 5, 1, 5, 5, 5, 3, 3, 3, 1, 4, 5, 1, 5, 2, 2, 5, 2, 2, 4, 5, 5, 2, 5, 5, 2, 2, 5, 2, 1, 3, 1, 1, 3, 1, 3, 3, 3, 1, 1, 3, 3, 1, 1, 1, 3, 3, 3, 3, 1, 3, 1, 1, 1, 3, 3, 3, 3, 3, 2, 3, 3, 3, 2, 3, 3, 3, 2, 2, 3, 3, 2, 2, 2, 2, 2, 2, 3, 3, 2, 2, 3, 2, 3, 3, 2, 2, 3, 2, 3, 2, 2, 2, 4, 1, 4, 1, 4, 1, 1, 1, 1, 1, 4, 1, 4, 4, 1, 1, 4, 4, 1, 1, 1, 4, 1, 1, 4, 1, 4, 1, 1, 4, 1, 1, 1, 4, 1, 4, 1, 4, 1, 1, 2, 4, 4, 4, 4, 4, 1, 4, 4, 4, 2, 2, 4, 2, 2, 2, 2, 2, 4, 2, 4, 2, 4, 2};
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
    i_0 = (2 * i_0) + 1 + ((x_0[feature_0[i_0]] <= threshold_0[i_0]) ? 0 : 1);
    i_1 = (2 * i_1) + 1 + ((x_1[feature_1[i_1]] <= threshold_1[i_1]) ? 0 : 1);
    actions[0] = (int)action_0[i_0 - 255];
    actions[1] = (int)action_1[i_1 - 255];
}

#endif /* FORAGING_754A0530A27B6F14_H */
