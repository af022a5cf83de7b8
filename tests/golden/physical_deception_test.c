/* Replays physical_deception.vectors.txt: cc -std=c99 physical_deception_test.c -o test && ./test */
#include "physical_deception.h"
#include <stdio.h>
#include <string.h>
int main(void)
{
    static const int width[] = {8, 10, 10};
    static int (*const act[])(const float *) = {physical_deception_adversary_0_act, physical_deception_agent_0_act, physical_deception_agent_1_act};
    FILE *file = fopen("physical_deception.vectors.txt", "r");
    int agent, action, wrong = 0, n = 0;
    if (!file || fscanf(file, "%*[^\n]") == 1) return 2;
    while (fscanf(file, "%d %d", &agent, &action) == 2) {
        float x[10];
        for (int i = 0; i < width[agent]; i++) { unsigned int bits; if (fscanf(file, "%x", &bits) != 1) return 2; memcpy(&x[i], &bits, 4); }
        n++; wrong += act[agent](x) != action;
    }
    printf("%d vectors, %d wrong\n", n, wrong);
    return wrong != 0 || n == 0;
}
