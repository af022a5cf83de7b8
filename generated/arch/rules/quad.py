"""Climbs to 1 m by where it will be in 0.8 s, and damps tilting, which does not begin from the specified starts."""


def lift(obs):
    ahead, x7, x8, x10, x11 = obs
    if ahead > 1.02:
        return "down" if ahead > 1.2 else "lower"
    if ahead <= 0.98:
        return "up" if ahead <= 0.8 else "higher"
    return "hover"


def roll(obs):
    ahead, x7, x8, x10, x11 = obs
    if x10 > 0.1:
        return "left"
    if x10 <= -0.1:
        return "right"
    if x7 > 0.1:
        return "left"
    return "right" if x7 <= -0.1 else "level"


def pitch(obs):
    ahead, x7, x8, x10, x11 = obs
    if x11 > 0.1:
        return "down"
    if x11 <= -0.1:
        return "up"
    if x8 > 0.1:
        return "down"
    return "up" if x8 <= -0.1 else "level"
