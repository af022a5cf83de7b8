UPSHIFT_KMH = [(15, 1), (30, 2), (50, 3), (75, 4)]


def gear(speed_kmh, throttle):
    # kick-down
    if throttle > 0.9 and speed_kmh < 60:
        return 2
    for limit, g in UPSHIFT_KMH:
        if speed_kmh < limit:
            return g
    return 5
