#include <stdint.h>
#include <stdbool.h>

#define TRUE_U8   ((uint8_t)1U)
#define FALSE_U8  ((uint8_t)0U)

typedef struct
{
    float  pressure_bar;
    float  flow_lpm;
    uint8_t door_closed;
} PressInputs_T;

uint8_t Press_IsSafe(const PressInputs_T * const inputs)
{
    uint8_t result = FALSE_U8;

    if (TRUE_U8 == inputs->door_closed)
    {
        if ((inputs->pressure_bar >= 2.0F) && (inputs->pressure_bar <= 6.0F))
        {
            result = (inputs->flow_lpm > 0.5F) ? TRUE_U8 : FALSE_U8;
        }
    }

    return result;
}
