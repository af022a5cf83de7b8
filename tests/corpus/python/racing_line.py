"""Opponent driver of a top-down racing game."""

TURN_LEFT, STRAIGHT, TURN_RIGHT = -1, 0, 1


def steer(track_angle):
    if track_angle > 0.15:
        return TURN_LEFT
    if track_angle < -0.15:
        return TURN_RIGHT
    return STRAIGHT


def throttle(speed, curvature):
    limit = 20
    if curvature > 0.05:
        limit = 8
    elif curvature > 0.02:
        limit = 14
    return "gas" if speed < limit else "brake"
