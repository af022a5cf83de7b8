#include <stdint.h>

#define FLAG_DOOR (1u << 2)

typedef struct {
    int16_t temp_dC;
    uint8_t flags;
} frame_t;

static int spare(int raw) { return raw / 10 + 1; }

uint8_t climate(const frame_t *in)
{
    int t = in->temp_dC / 10;
    if (in->flags & FLAG_DOOR) return 3;
    if (t < -5) return 0;
    if (t > 20 && in->flags % 16 > 1) return 2;
    return 1;
}
