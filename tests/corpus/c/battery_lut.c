#include <stdint.h>
#include <stddef.h>

/* open circuit voltage in mV -> charge level, from the data sheet */
static const uint16_t k_ocv_mv[] = { 3300, 3550, 3680, 3790, 3950, 4100 };

static uint8_t level_of(uint16_t mv)
{
    uint8_t level = 0;
    while (level < sizeof k_ocv_mv / sizeof *k_ocv_mv && mv >= k_ocv_mv[level])
        level++;
    return level;
}

typedef enum { CHARGE_FAST, CHARGE_SLOW, CHARGE_STOP } charge_t;

charge_t charger(uint16_t mv, int16_t temp_dC)
{
    if (temp_dC < 0 || temp_dC > 450)      /* tenths of a degree */
        return CHARGE_STOP;
    switch (level_of(mv)) {
    case 0: case 1: case 2: case 3:
        return temp_dC / 10 >= 10 ? CHARGE_FAST : CHARGE_SLOW;
    case 4: case 5:
        return CHARGE_SLOW;
    }
    return CHARGE_STOP;
}
