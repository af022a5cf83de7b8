"""What an agent observes in a state of a system: exact values, rounded once.

Does: the value of a feature in a state; the float32 nearest to an exact number.
Assumes: a feature's form names variables of the state.
Does not: judge roundings of a simulator that adds in floats.
"""

import math
import struct
from fractions import Fraction

import numpy as np

from verify.systems.system import Feature, Measure, State


def measured(feature: Feature, state: State) -> Fraction:
    """The exact value of a feature in a state."""
    exact = feature.form.at(state)
    match feature.measure:
        case Measure.VALUE:
            return exact
        case Measure.SIGN:
            return Fraction((exact > 0) - (exact < 0))
        case Measure.POSITIVE:
            return Fraction(exact > 0)
        case Measure.CLIP:
            assert feature.bounds is not None
            return min(max(exact, feature.bounds[0]), feature.bounds[1])


def observed(feature: Feature, state: State) -> np.float32:
    """What an agent observes of it."""
    return nearest(measured(feature, state))


def nearest(exact: Fraction) -> np.float32:
    """The float32 nearest to a number, ties to even.

    A number between two doubles counts as the one of them whose last bit is 1. Midpoints of float32 numbers are doubles
    whose last bit is 0, so that this second rounding never meets a tie which the number itself is not.
    """
    near = float(exact)
    if near != exact and not struct.unpack("<q", struct.pack("<d", near))[0] & 1:
        near = math.nextafter(near, math.inf if exact > near else -math.inf)
    return np.float32(near)
