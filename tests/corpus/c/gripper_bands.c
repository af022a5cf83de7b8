#include "stdint.h"
#include <stddef.h>
#ifdef __cplusplus
extern "C" {
#endif

#define N_BANDS (sizeof bands / sizeof bands[0])
enum cmd { CMD_HOLD, CMD_CLOSE, CMD_OPEN, CMD_STOP };

struct band { double lo, hi; enum cmd cmd; };
static const struct band bands[] = {
    { -1e9, 0.5, CMD_CLOSE },
    {  0.5, 4.0, CMD_HOLD  },
    {  4.0, 1e9, CMD_OPEN  },
};

static int clamp_u8(double v) { return v < 0 ? 0 : v > 255 ? 255 : (int)v; }

enum cmd gripper_step(const double *x /* force [N], width [mm], temperature [degC] */)
{
    const double force = x[0], width = x[1];
    const int temp = clamp_u8(x[2]);
    size_t i;

    if (temp >= 70)
        return CMD_STOP;
    for (i = 0; i < N_BANDS; ++i) {
        const struct band *b = &bands[i];
        if (force >= b->lo && force < b->hi) {
            if (b->cmd == CMD_CLOSE && width <= 2.0)
                return CMD_HOLD;
            return b->cmd;
        }
    }
    return CMD_STOP;
}
#ifdef __cplusplus
}
#endif
