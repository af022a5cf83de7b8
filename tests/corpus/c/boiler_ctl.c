#include "boiler_cfg.h"
#include <stdint.h>

#ifndef BOILER_T_HIGH
#define BOILER_T_HIGH 92.0
#endif
#ifndef BOILER_P_HIGH
#define BOILER_P_HIGH 2.5
#endif

#define SET_IF(cond, var, val) do { if (cond) { (var) = (val); } } while (0)

typedef struct boiler_obs {
    double temperature;
    double pressure;
    int flame;
} boiler_obs;

typedef struct {
    int valve;
} boiler_cmd;

enum valve_pos { VALVE_CLOSED, VALVE_HALF = 5, VALVE_OPEN = 10 };

boiler_cmd boiler_step(boiler_obs o)
{
    boiler_cmd cmd = { VALVE_HALF };

    SET_IF(o.temperature < 70.0, cmd.valve, VALVE_OPEN);
    SET_IF(o.temperature > BOILER_T_HIGH, cmd.valve, VALVE_CLOSED);
    SET_IF(o.pressure > BOILER_P_HIGH || !o.flame, cmd.valve, VALVE_CLOSED);
    return cmd;
}
