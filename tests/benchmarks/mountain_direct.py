"""Forty lines of numpy that know one question: from 10,000 thin starts the mountain car gets onto the hill.

Intervals are rounded outward in each operation; numpy's cos is taken to be off by less than 2**-40. Exits with 0 where
all is shown.
"""

import sys

import numpy as np

STEPS, STARTS, SLACK = 200, 10_000, 2.0**-40


def down(values):
    return np.nextafter(values, -np.inf)


def up(values):
    return np.nextafter(values, np.inf)


def plus(one, other):
    return down(one[0] + other[0]), up(one[1] + other[1])


def cosine(low, high):
    """Of angles between -2 pi and pi, by their ends and the extremes between them."""
    ends = np.cos(low), np.cos(high)
    least = np.where((low < -3.1415) & (high > -3.1416), -1.0, np.minimum(*ends) - SLACK)
    return least, np.where((low <= 0.0) & (high >= 0.0), 1.0, np.maximum(*ends) + SLACK)


def shown():
    """Whether the car gets there from all starts, and keeps to the stated ranges."""
    ends = np.linspace(-0.45, -0.4, STARTS + 1)
    place, speed = (ends[:-1], ends[1:]), (np.zeros(STARTS), np.zeros(STARTS))
    for _ in range(STEPS):
        low, high = cosine(down(3.0 * place[0]), up(3.0 * place[1]))
        pull = down(-0.0025 * high), up(-0.0025 * low)
        push = down(0.001 * np.sign(speed[0])), up(0.001 * np.sign(speed[1]))  # the faster, the more to the right
        speed = plus(plus(plus(speed, push), (down(pull[0]), up(pull[1]))), (-1e-12, 1e-12))
        place = plus(plus(place, speed), (-1e-12, 1e-12))
        open_ = ~(place[0] >= 0.5)
        place, speed = (place[0][open_], np.minimum(place[1][open_], 0.5)), (speed[0][open_], speed[1][open_])
        stated = (place[0] >= -1.2) & (speed[0] >= -0.07) & (speed[1] <= 0.07)
        if not len(stated) or not stated.all():
            return not len(stated)
    return False


if __name__ == "__main__":
    sys.exit(not shown())
