"""States of a game in which claims about single decisions fail.

Does: finds such states beside one that breaks the claim by its world file, or anywhere in the claim's regions.
Assumes: a world file of states, as verification/worlds.py states it.
Does not: decide: each state is judged by whoever asked for it.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from typing import TypeVar

import numpy as np

from codegen.floats import FLOAT64
from codegen.ir import AgentPolicy, Bool, Float64, Floats, PolicyProfile, act
from codegen.observe import observe
from maviper.worlds.stated.observing import (
    PLACE,
    bound_region,
    find_coordinate,
    find_goal,
    list_observed,
    place_in,
    with_noise,
)
from verify.claims.region import Interval
from verify.claims.values import Batch
from verify.systems.claims import SystemClaim
from verify.systems.statement import Statement
from verify.systems.system import State, Variable

Number = TypeVar("Number")
SCALES = (-2, -6, -10, -14, -18, -22, -26)  # powers of two: how far states are drawn from one where a claim may fail
DRAWN, TRIED, SEED = 1_024, 4, 0  # states of a scale; of these, that seem to break the claim, those that are replayed
ANYWHERE = 16_384  # states that are drawn in a whole region
EXTREME = 0.5  # of drawn errors, those at an end of their bounds


def iterate_near(profile: PolicyProfile, statement: Statement, claim: SystemClaim, state: State) -> Iterator[State]:
    """States of the game beside another one: float64 coordinates and errors, the goal at a landmark, and the roundings
    that the game makes there. First the nearest ones, then those of some farther away in which the claim seems to fail.
    """
    drawable, goal = _list_drawable(profile, statement), _find_goal_in(profile, state)
    bounds = _bound_all(claim, drawable)
    for step in (0, 1, -1):
        moved = {one.name: place_in(state[one.name], bounds[one.name], step) for one in drawable}
        yield with_noise(profile, statement, {**moved, **_at_goal(goal, moved)})
    rng, near = np.random.default_rng(SEED), np.array([state[one.name] for one in drawable], np.float64)
    ends = _find_ends(drawable, bounds)
    for power in SCALES:
        drawn: Float64 = np.clip(near + 2.0**power * rng.uniform(-1.0, 1.0, (DRAWN, len(near))), *ends.T)
        yield from _iterate_broken(profile, statement, claim, goal, drawn)


def iterate_anywhere(profile: PolicyProfile, statement: Statement, claim: SystemClaim) -> Iterator[State]:
    """Some states of the game, of those drawn in the claim's regions, in which it seems to fail. Where none breaks it,
    others follow, with many coordinates at an end of their bounds, where sums are largest.
    """
    drawable, rng = _list_drawable(profile, statement), np.random.default_rng(SEED)
    erring = np.array([find_coordinate(one.name) not in profile.world.coordinates() for one in drawable])
    for pushed in (erring, np.ones_like(erring)):
        for region in claim.regions:
            ends = _find_ends(drawable, bound_region(region, _list_ranges(drawable)))
            drawn: Float64 = rng.uniform(ends[:, 0], ends[:, 1], (ANYWHERE, len(drawable)))
            if pushed.any():
                extreme: Bool = pushed & (rng.random(drawn.shape) < EXTREME)
                at_ends: Float64 = np.where(rng.random(drawn.shape) < 1 / 2, ends[:, 0], ends[:, 1])
                drawn = np.where(extreme, at_ends, drawn)
            yield from _iterate_broken(profile, statement, claim, find_goal(region), drawn)


def _list_drawable(profile: PolicyProfile, statement: Statement) -> list[Variable]:
    """The variables that a state of the game chooses: coordinates but the goal's place, and errors."""
    names = set(profile.world.coordinates())
    names |= {each.error for policy in profile.agents for each in list_observed(policy)}
    return [one for one in statement.system.variables if one.name in names]


def _find_ends(drawable: Sequence[Variable], bounds: Mapping[str, Interval]) -> Float64:
    """The float64 numbers within bounds, [n_drawable, 2]."""
    return np.array([[place_in(end, bounds[one.name], 0) for end in bounds[one.name]] for one in drawable], np.float64)


def _iterate_broken(
    profile: PolicyProfile, statement: Statement, claim: SystemClaim, goal: str | None, drawn: Float64
) -> Iterator[State]:
    """The first of drawn numbers, [n, n_drawable], in which the claim seems to fail."""
    names = [one.name for one in _list_drawable(profile, statement)]
    planes = dict(zip(names, drawn.T, strict=True))
    planes |= _at_goal(goal, planes)
    for row in np.flatnonzero(_seem_broken(profile, claim, planes, len(drawn)))[:TRIED]:
        moved = {name: Fraction(float(values[row])) for name, values in planes.items()}
        yield with_noise(profile, statement, moved)


def _list_ranges(drawable: Sequence[Variable]) -> dict[str, Interval]:
    return {one.name: one.range for one in drawable}


def _bound_all(claim: SystemClaim, drawable: Sequence[Variable]) -> dict[str, Interval]:
    """The box around all regions of a claim, but for differences."""
    ranges = _list_ranges(drawable)
    boxes = [bound_region(region, ranges) for region in claim.regions] or [ranges]
    return {
        one.name: (min(each[one.name][0] for each in boxes), max(each[one.name][1] for each in boxes))
        for one in drawable
    }


def _find_goal_in(profile: PolicyProfile, state: State) -> str | None:
    """The landmark at which the goal is in a state; None in a game without goal, or where it is at none."""
    for landmark in profile.world.landmarks:
        if all(state.get(f"{PLACE}.{axis}") == state[f"{landmark.name}.{axis}"] for axis in "xy"):
            return landmark.name
    return None


def _at_goal(goal: str | None, at: Mapping[str, Number]) -> dict[str, Number]:
    """The goal's place, where a landmark is."""
    return {f"{PLACE}.{axis}": at[f"{goal}.{axis}"] for axis in "xy"} if goal else {}


def _seem_broken(profile: PolicyProfile, claim: SystemClaim, planes: Mapping[str, Float64], count: int) -> Bool:
    """In which states the game's own agents seem to break a claim, but for roundings, [batch]."""
    at = {find_coordinate(name): values for name, values in planes.items()}
    rows = np.zeros((count, len(profile.world.coordinates())))
    for place, name in enumerate(profile.world.coordinates()):
        rows[:, place] = at.get(name, 0.0)
    actions = {each.agent: act(each, _observe_off(profile, each, rows, planes)) for each in profile.agents}
    asked = Batch(planes, count)
    return asked.holds(claim.inside, actions) & ~asked.holds(claim.formula, actions)


def _observe_off(profile: PolicyProfile, policy: AgentPolicy, rows: Float64, planes: Mapping[str, Float64]) -> Floats:
    """Returns an agent's observations where some features are off, but for the last digit, [batch, n_features]."""
    seen = observe(policy.features, rows, profile.world, policy.numbers)
    for each in list_observed(policy):
        if each.error in planes:
            place = policy.features.index(each.feature)
            bare = (replace(each.feature, meaning=replace(each.meaning, function="")),)
            off = observe(bare, rows, profile.world, FLOAT64)[:, 0] + planes[each.error]
            function = each.meaning.function
            seen[:, place] = off > 0 if function == "positive" else np.sign(off) if function else off
    return seen
