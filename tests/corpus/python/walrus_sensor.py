def classify(sensor):
    """Smoke alarm: ppm, temperature, humidity."""
    if (ppm := sensor[0]) > 300:
        return "ALARM"
    if ppm > 150 and (t := sensor[1]) > 57.0:
        return "ALARM"
    if ppm in (0, -1):
        return "FAULT"
    return "CLEAR" if sensor[-1] < 95 else "FAULT"
