# Runs on a Raspberry Pi in the lower field. Readings come from the ADS1115.
DRY = 35
VERY_DRY = 20
RAIN_PROB = 0.6

def water_minutes(soil_moisture, rain_probability, hour, air_temp):
    if rain_probability > RAIN_PROB and soil_moisture > VERY_DRY:
        return 0
    if 10 <= hour < 17 and air_temp > 28:
        return 0   # would only evaporate
    if soil_moisture < VERY_DRY:
        return 30
    if soil_moisture < DRY:
        return 15
    return 0
