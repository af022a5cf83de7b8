"""Drives forward, turns by two radians while it brakes, and backs down to the origin."""


def pace(obs):
    x1, x2, x3, x4 = obs
    if x2 <= -1.76:
        return "push" if x4 <= 1.8 else "hold"
    if x1 <= 2.33:
        return "push" if x4 <= -0.2 else "hold"
    return "brake" if x4 > -1.99 else "hold"


def wheel(obs):
    x1, x2, x3, x4 = obs
    if x2 <= -1.44 or x3 <= 0.05:
        return "straight"
    return "right" if x3 > 0.205 else "slow_right"
