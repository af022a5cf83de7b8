"""Brakes both rods, and lets them sink back slowly."""


def motors(obs):
    th1, th2, w1, w2 = obs
    if w1 <= -0.3:
        if w2 <= -0.3:
            return "push_push"
        return "push_brake" if w2 > 0.2 else "push_hold"
    if w1 > 0.2:
        if w2 <= -0.3:
            return "brake_push"
        return "brake_brake" if w2 > 0.2 else "brake_hold"
    if w2 <= -0.3:
        return "hold_push"
    return "hold_brake" if w2 > 0.2 else "hold_hold"
