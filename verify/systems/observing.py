"""What agents observe in an exact state of a stated system, and what they do there.

Does: the float32 or float64 nearest to an exact number; observations; joint actions.
Assumes: a system that has the features of the profile.
Does not: move states.
"""

import math
from collections.abc import Mapping
from fractions import Fraction

import numpy as np

from codegen.floats import FLOAT32
from codegen.ir import AgentPolicy, Floats, PolicyProfile, act
from codegen.numbers.rounding import nearest_double, neighbour
from verify.systems.system import Feature, Measure, State, System

MAX_FLOAT32 = Fraction(float(np.finfo(np.float32).max))
BEYOND = MAX_FLOAT32 + Fraction(2) ** 103  # from here on the nearest float32 is infinite


def nearest(exact: Fraction) -> np.float32:
    """The float32 nearest to a number, of two that are as near the even one; infinite beyond the largest."""
    if abs(exact) >= BEYOND:
        return np.float32(math.inf if exact > 0 else -math.inf)
    close = np.float32(float(max(-MAX_FLOAT32, min(MAX_FLOAT32, exact))))
    beside = [neighbour(close, -math.inf), close, neighbour(close, math.inf)]
    return min((each for each in beside if np.isfinite(each)), key=lambda each: _distance(each, exact))


def _distance(number: np.float32, exact: Fraction) -> tuple[Fraction, int]:
    odd = int(np.float32(number).view(np.uint32)) & 1
    return abs(Fraction(float(number)) - exact), odd


def measure_feature(feature: Feature, state: State) -> Fraction:
    """The exact value of a feature in a state."""
    value = feature.form.at(state)
    if feature.measure is Measure.SIGN:
        return Fraction((value > 0) - (value < 0))
    if feature.measure is Measure.POSITIVE:
        return Fraction(value > 0)
    if feature.measure is Measure.EQUALS:
        return Fraction(value == 0)
    if feature.measure is Measure.CLIP and feature.bounds is not None:
        return max(feature.bounds[0], min(feature.bounds[1], value))
    return value


def observe_state(system: System, policy: AgentPolicy, state: State) -> Floats:
    """What an agent observes in a state, [1, n_features] of the numbers that it compares. KeyError for a feature that
    the system does not have.
    """
    features = system.features[policy.agent]
    exact = [measure_feature(features[feature.name], state) for feature in policy.features]
    if policy.numbers == FLOAT32:
        return np.array([[nearest(value) for value in exact]], dtype=np.float32)
    return np.array([[nearest_double(value) for value in exact]], dtype=np.float64)


def choose_actions(system: System, profile: PolicyProfile, state: State) -> Mapping[str, int]:
    """The number of the action that each agent takes in a state."""
    return {policy.agent: int(act(policy, observe_state(system, policy, state))[0]) for policy in profile.agents}
