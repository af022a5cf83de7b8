import math

SWITCH_ANGLE = math.radians(12)
MAX_RATE = math.pi / 2


def balance(theta, theta_dot):
    if abs(math.degrees(theta)) > 30.0:
        return "give_up"
    if theta > SWITCH_ANGLE or theta_dot > MAX_RATE:
        return "push_right"
    if theta < -SWITCH_ANGLE or theta_dot < -MAX_RATE:
        return "push_left"
    return "wait"
