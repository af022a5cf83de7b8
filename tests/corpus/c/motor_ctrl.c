/*****************************************************************************
 *  Module:   motor_ctrl.c
 *  Purpose:  Supervisory decision of the traction motor (MISRA C:2012 style)
 *****************************************************************************/
#include <stdint.h>
#include <stdbool.h>

#define TEMP_LIMIT_C        (105.0F)
#define TEMP_WARN_C         (0.9F * TEMP_LIMIT_C)
#define UNDERVOLTAGE_V      (280.0F)
#define SPEED_MAX_RPM       (9000)

typedef float   float32_t;

typedef enum
{
    MOTOR_RUN = 0,
    MOTOR_DERATE,
    MOTOR_COAST,
    MOTOR_SHUTDOWN
} MotorCmd_t;

MotorCmd_t Motor_Decide(float32_t temperature, float32_t voltage, int32_t speed);

MotorCmd_t Motor_Decide(float32_t temperature, float32_t voltage, int32_t speed)
{
    MotorCmd_t cmd = MOTOR_RUN;
    const bool overTemp = (temperature > TEMP_LIMIT_C);
    const bool underVolt = (voltage < UNDERVOLTAGE_V);

    if (overTemp || underVolt)
    {
        cmd = MOTOR_SHUTDOWN;
    }
    else if (speed > (int32_t)SPEED_MAX_RPM)
    {
        cmd = MOTOR_COAST;
    }
    else if (temperature > TEMP_WARN_C)
    {
        cmd = MOTOR_DERATE;
    }
    else
    {
        /* keep running */
    }

    return cmd;
}
