"""Brings the arm to rest."""


def arm(obs):
    x1, x2, x3, x4 = obs
    if x4 > 0.25:
        return "back"
    return "forth" if x4 <= -0.25 else "off"
