/* Exports the decisions of physical_deception.h over n rows of observations; checks: 1 of a row that is finite, 2 of one within
 * the ranges, 3 of one that is both. */
#include "physical_deception.h"

void physical_deception_adversary_0_decide(const float *rows, long n, int *actions, int *checks);
void physical_deception_adversary_0_decide(const float *rows, long n, int *actions, int *checks)
{
    long i;
    for (i = 0; i < n; i++) {
        const float *x = rows + i * PHYSICAL_DECEPTION_ADVERSARY_0_N_FEATURES;
        actions[i] = physical_deception_adversary_0_act(x);
        checks[i] = physical_deception_adversary_0_finite(x) + 2 * physical_deception_adversary_0_in_range(x);
    }
}

void physical_deception_agent_0_decide(const float *rows, long n, int *actions, int *checks);
void physical_deception_agent_0_decide(const float *rows, long n, int *actions, int *checks)
{
    long i;
    for (i = 0; i < n; i++) {
        const float *x = rows + i * PHYSICAL_DECEPTION_AGENT_0_N_FEATURES;
        actions[i] = physical_deception_agent_0_act(x);
        checks[i] = physical_deception_agent_0_finite(x) + 2 * physical_deception_agent_0_in_range(x);
    }
}

void physical_deception_agent_1_decide(const float *rows, long n, int *actions, int *checks);
void physical_deception_agent_1_decide(const float *rows, long n, int *actions, int *checks)
{
    long i;
    for (i = 0; i < n; i++) {
        const float *x = rows + i * PHYSICAL_DECEPTION_AGENT_1_N_FEATURES;
        actions[i] = physical_deception_agent_1_act(x);
        checks[i] = physical_deception_agent_1_finite(x) + 2 * physical_deception_agent_1_in_range(x);
    }
}
