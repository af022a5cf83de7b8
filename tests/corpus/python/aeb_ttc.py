"""Automatic emergency braking by time to collision."""

TTC_WARN = 2.6
TTC_BRAKE = 1.2


def aeb(distance, closing_speed):
    if closing_speed <= 0:
        return "none"
    ttc = distance / closing_speed
    if ttc < TTC_BRAKE:
        return "brake"
    if ttc < TTC_WARN:
        return "warn"
    return "none"
