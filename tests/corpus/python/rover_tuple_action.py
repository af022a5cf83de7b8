"""Rover: the action is a pair (left wheel, right wheel)."""

FULL = 1.0
HALF = FULL / 2

FORWARD = (FULL, FULL)
SPIN_LEFT = (-HALF, HALF)
SPIN_RIGHT = (HALF, -HALF)
STOP = (0.0, 0.0)

NAMES = {FORWARD: "forward", SPIN_LEFT: "spin_left", SPIN_RIGHT: "spin_right", STOP: "stop"}


def wheels(bearing, distance):
    if distance < 0.2:
        command = STOP
    elif bearing < -0.3:
        command = SPIN_LEFT
    elif bearing > 0.3:
        command = SPIN_RIGHT
    else:
        command = FORWARD
    return NAMES[command]
