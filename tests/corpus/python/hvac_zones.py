"""Single zone HVAC sequence: no memory, dead band between heating and cooling."""

HEATING_SETPOINT_C = 20.5
COOLING_SETPOINT_C = HEATING_SETPOINT_C + 3.5
SETBACK_K = 4.0


def hvac_mode(zone_temp, outdoor_temp, occupied, window_open):
    if window_open:
        return "off"

    if occupied:
        heat_below, cool_above = HEATING_SETPOINT_C, COOLING_SETPOINT_C
    else:
        heat_below = HEATING_SETPOINT_C - SETBACK_K
        cool_above = COOLING_SETPOINT_C + SETBACK_K

    if zone_temp < heat_below:
        return "heat"
    if zone_temp > cool_above:
        if outdoor_temp < 18:
            return "economizer"
        return "cool"
    return "fan" if occupied else "off"
