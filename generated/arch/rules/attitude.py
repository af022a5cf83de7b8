"""Brakes the rate of each axis until it is low."""


def first(obs):
    x1, x2, x3 = obs
    if x1 > 0.16:
        return "back"
    return "forth" if x1 <= -0.16 else "off"


def second(obs):
    x1, x2, x3 = obs
    if x2 > 0.12:
        return "back"
    return "forth" if x2 <= -0.12 else "off"


def third(obs):
    x1, x2, x3 = obs
    if x3 > 0.26:
        return "back"
    return "forth" if x3 <= -0.26 else "off"
