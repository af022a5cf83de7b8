#include <stddef.h>

#define ARRAY_SIZE(a) (sizeof(a) / sizeof((a)[0]))

struct step { float below; int pumps; };

static const struct step steps[] = {
    { 0.5f, 3 },
    { 1.2f, 2 },
    { 2.0f, 1 },
};

int pumps_needed(float level)
{
    size_t i;

    for (i = 0; i < ARRAY_SIZE(steps); ++i) {
        if (level < steps[i].below)
            return steps[i].pumps;
    }
    return 0;
}
