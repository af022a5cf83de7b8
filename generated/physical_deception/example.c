/* One decision of each agent. Build and run: cc -std=c99 example.c -o example && ./example */
#include "physical_deception.h"
#include <stdio.h>

int main(void)
{
    static const float x[10]; /* an observation: here all zero */
    printf("adversary_0 %d\n", physical_deception_adversary_0_act(x));
    printf("agent_0 %d\n", physical_deception_agent_0_act(x));
    printf("agent_1 %d\n", physical_deception_agent_1_act(x));
    return 0;
}
