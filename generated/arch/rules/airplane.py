"""Brakes the velocity along each axis of the body, and damps rates, which do not begin from the specified starts."""


def fx(obs):
    x4, x5, x6, x10, x11, x12 = obs
    if x4 <= 0.05:
        if x4 <= -0.04:
            return "forth2" if x4 <= -0.1 else "forth1"
        return "off"
    if x4 <= 0.35:
        return "back1" if x4 <= 0.17 else "back2"
    if x4 <= 0.6:
        return "back4"
    return "back7" if x4 <= 0.85 else "full_back"


def fy(obs):
    x4, x5, x6, x10, x11, x12 = obs
    if x5 <= 0.03:
        if x5 <= -0.04:
            return "forth05" if x5 <= -0.08 else "off"
        return "back05"
    if x5 <= 0.3:
        return "back1" if x5 <= 0.1 else "back2"
    if x5 <= 0.55:
        return "back4"
    return "back7" if x5 <= 0.85 else "full_back"


def fz(obs):
    x4, x5, x6, x10, x11, x12 = obs
    if x6 <= 0.07:
        if x6 <= 0.02:
            return "off" if x6 <= -0.03 else "back05"
        return "back1"
    if x6 <= 0.55:
        return "back2" if x6 <= 0.3 else "back4"
    return "back7" if x6 <= 0.85 else "full_back"


def mx(obs):
    x4, x5, x6, x10, x11, x12 = obs
    if x10 > 0.1:
        return "back"
    return "forth" if x10 <= -0.1 else "off"


def my(obs):
    x4, x5, x6, x10, x11, x12 = obs
    if x11 > 0.1:
        return "back"
    return "forth" if x11 <= -0.1 else "off"


def mz(obs):
    x4, x5, x6, x10, x11, x12 = obs
    if x12 > 0.1:
        return "back"
    return "forth" if x12 <= -0.1 else "off"
