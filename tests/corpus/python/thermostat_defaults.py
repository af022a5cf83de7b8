THRESHOLDS = {"cold": 18.0, "warm": 22.0}
def thermostat(temp, humidity=50, *, night=False):
    target = THRESHOLDS["cold"] - (2 if night else 0)
    if temp <= target and not humidity >= 80:
        return "heat"
    if temp >= THRESHOLDS["warm"] or humidity > 85:
        return "cool"
    return "off"
