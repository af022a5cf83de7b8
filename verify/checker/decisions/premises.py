"""Whether a certificate shows that the left sides of its claim can hold: a state that meets each.

Does: asks that each state lies in the region, is one of the deployed arithmetic, and meets its left side, where each
  agent acts by its tree.
Assumes: names that the profile has.
Does not: find out which left sides a formula has. A certificate states them, and whoever checks it is told.
"""

from collections.abc import Mapping
from fractions import Fraction
from typing import NamedTuple

from codegen.errors import InputError
from codegen.ir import GOAL, NO_FEATURE, ROOT, AgentPolicy, PolicyProfile
from verify.checker.reading import RejectedError, region_formula
from verify.checker.thresholds import sides
from verify.claims.formula import Formula, agents, for_goal, holds
from verify.claims.region import Region
from verify.semantics import MACHINE

LARGEST = 2**1000  # more than any place of a world
Point = Mapping[str, Fraction]


class Premise(NamedTuple):
    """The left side of an implication, with a state that meets it."""

    formula: Formula
    goal: str | None
    state: Point


def check_premise(premise: Premise, profile: PolicyProfile, region: Region, semantics: str) -> None:
    """RejectedError where the state of a left side does not meet it."""
    formula, goal, state = premise
    if set(state) != set(region.box) or goal not in region.goal_cases:
        raise RejectedError("the state of a left side is not one of the region's")
    if not holds(region_formula(region), state, {}):
        raise RejectedError("the state of a left side does not lie in the region")
    if semantics == MACHINE and not all(map(_is_float64, state.values())):
        raise RejectedError("the state of a left side is not one of float64 numbers")
    at = state if goal is None else {**state, **{f"{GOAL}.{axis}": state[f"{goal}.{axis}"] for axis in "xy"}}
    actions = {agent: _act(profile.policy(agent), at, semantics) for agent in agents(formula)}
    if not holds(for_goal(formula, goal), at, actions):
        raise RejectedError("the state of a left side does not meet it")


def _is_float64(value: Fraction) -> bool:
    return abs(value) < LARGEST and Fraction(float(value)) == value


def _act(policy: AgentPolicy, at: Point, semantics: str) -> int:
    """The action that an agent takes in a state."""
    tree, node = policy.tree, ROOT
    while tree.feature[node] != NO_FEATURE:
        feature, threshold = policy.features[int(tree.feature[node])], float(tree.threshold[node])
        try:
            left = sides(feature, threshold, policy.numbers, semantics)[0]
        except InputError as error:
            raise RejectedError(error.what) from None
        node = int(tree.left[node] if holds(left, at, {}) else tree.right[node])
    return int(tree.action[node])
