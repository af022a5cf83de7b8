"""What agents observe in an exact state of a stated system, and what they do there.

Does: observations; joint actions.
Assumes: a system that has the features of the profile.
Does not: move states.
"""

from collections.abc import Mapping
from fractions import Fraction

import numpy as np

from codegen.ir import AgentPolicy, Floats, PolicyProfile, act
from codegen.numbers import nearest_number
from verify.systems.system import Feature, Measure, State, System


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
    """Returns what an agent observes in a state, [1, n_features] of the numbers that it compares. KeyError for a
    feature that the system does not have.
    """
    features = system.features[policy.agent]
    exact = [measure_feature(features[feature.name], state) for feature in policy.features]
    return np.array([[nearest_number(value, policy.numbers) for value in exact]], dtype=policy.numbers)


def choose_actions(system: System, profile: PolicyProfile, state: State) -> Mapping[str, int]:
    """The number of the action that each agent takes in a state."""
    return {policy.agent: int(act(policy, observe_state(system, policy, state))[0]) for policy in profile.agents}
