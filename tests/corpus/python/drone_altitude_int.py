def altitude_band(alt_m, battery_pct):
    band = int(alt_m)  # whole metres
    if battery_pct <= 15:
        return "land"
    if band >= 120:
        return "descend"
    if band < 2:
        return "climb"
    return "hold"
