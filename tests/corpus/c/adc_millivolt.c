#include <stdint.h>

/* 10 bit ADC, 5 V reference */
static uint32_t to_millivolt(uint16_t adc)
{
    return ((uint32_t)adc * 5000UL) / 1023UL;
}

uint8_t battery_level(uint16_t adc)
{
    uint32_t mv = to_millivolt(adc);

    if (mv < 3300U)
        return 0U;   /* empty */
    if (mv < 3600U)
        return 1U;   /* low   */
    if (mv < 4000U)
        return 2U;   /* good  */
    return 3U;       /* full  */
}
