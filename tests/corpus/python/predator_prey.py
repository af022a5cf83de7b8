"""Hand-written baselines for the predator-prey task of the lab course.

Every observation is [dx, dy, speed]: the other one's relative position and one's own speed.
"""

STAY, LEFT, RIGHT, DOWN, UP = range(5)


def _horizontal(dx):
    return RIGHT if dx > 0 else LEFT


def _vertical(dy):
    return UP if dy > 0 else DOWN


def predator(obs):
    dx, dy, speed = obs
    if -0.1 < dx < 0.1:
        return _vertical(dy)
    return _horizontal(dx)


def prey(obs):
    dx, dy, speed = obs
    if abs(dx) > 1.5 and abs(dy) > 1.5 and speed < 0.2:
        return STAY
    if abs(dy) < 0.3:
        return UP if dy <= 0 else DOWN
    return _horizontal(-dx)
