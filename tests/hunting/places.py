"""World states in which a false word would show: on edges of tests, claims and regions, and beside them.

Does: samples a region's float64 states and moves them to where tests turn, to bounds of claims and regions, and to the
  neighbours of these; enumerates regions of at most one free coordinate on each axis, one state for each cell.
Assumes: features on one axis, as all games have; a coordinate's other values as they are.
Does not: import anything of ours, or judge.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from itertools import pairwise, product
from typing import Any

import numpy as np

from tests.hunting.reading import MACHINE, Agent, Array, Feature, Profile, fractions, measured, paths, summed

ROWS = 96  # states of a sample
ROUNDS = 3  # how often each is moved to an edge
MAX_ROWS = 12_000  # of an enumeration
MAX_EXACT_ROWS = 400
BITS = 64
ENUMERABLE = ("distinct_targets", "own_target", "no_double", "formula")


@dataclass(frozen=True)
class Case:
    """A question as the judge knows it: a profile, a claim and a region as plain data."""

    profile: Profile
    claim: Mapping[str, Any]
    region: Mapping[str, Any]
    semantics: str

    @property
    def names(self) -> list[str]:
        """The coordinates that the region bounds: the columns of states."""
        return list(self.region["box"])

    @property
    def goals(self) -> list[str | None]:
        """The goals; None alone without any."""
        return list(self.region["goals"]) or [None]

    @property
    def team(self) -> list[Agent]:
        """The agents that the claim is about."""
        return self.profile.team(self.claim["team"])

    @property
    def eps(self) -> Fraction:
        """By how much features may be off."""
        return self.claim.get("eps") or Fraction(0)

    @cached_property
    def bounds(self) -> Array:
        """The outermost float64 numbers of each interval, [names, 2]."""
        return np.array([inner(*bounds) for bounds in self.region["box"].values()])

    @cached_property
    def denominator(self) -> int:
        """A common denominator of all bounds and lengths of the question."""
        bounds = [bound for both in self.region["box"].values() for bound in both]
        return math.lcm(*(number.denominator for number in (*bounds, *lengths_of(self))))

    def boxed(self, states: Array) -> Array:
        """Which states lie in the region's box, exactly, [batch]."""
        if states.dtype != object:
            return ((states >= self.bounds[:, 0]) & (states <= self.bounds[:, 1])).all(axis=1)
        box = np.array([*self.region["box"].values()], dtype=object)
        return ((states >= box[:, 0]) & (states <= box[:, 1])).astype(bool).all(axis=1)

    def at(self, states: Array, goal: str | None) -> dict[str, Array]:
        """The columns of states [batch, names] by coordinate; a velocity that is left out is 0."""
        found = dict(zip(self.names, states.T, strict=True))
        rest = np.zeros(len(states), dtype=states.dtype)
        still = rest.astype(int).astype(object) if states.dtype == object else rest
        speeds = [f"{name}.v{axis}" for name in self.profile.movers for axis in "xy"]
        found |= {name: still for name in speeds if name not in found}
        return found | ({f"goal.{axis}": found[f"{goal}.{axis}"] for axis in "xy"} if goal else {})

    def column(self, name: str, goal: str | None) -> int | None:
        """The column of a coordinate, None where the region does not bound it."""
        named = f"{goal}.{name[-1]}" if name.startswith("goal.") else name
        return self.names.index(named) if named in self.region["box"] else None


def inner(low: Fraction, high: Fraction) -> tuple[float, float]:
    """The outermost float64 numbers of an interval; the first is above the second where it holds none."""
    first, last = float(low), float(high)
    first = math.nextafter(first, math.inf) if Fraction(first) < low else first
    last = math.nextafter(last, -math.inf) if Fraction(last) > high else last
    return first, last


def sampled(case: Case, goal: str | None, rng: np.random.Generator) -> Array:
    """Float64 states at and beside edges, most of them in the region, [batch, names]."""
    bounds = case.bounds
    if (bounds[:, 0] > bounds[:, 1]).any():
        return np.zeros((0, len(bounds)))
    share = rng.random((ROWS, len(bounds)))
    share[: ROWS // 4] = np.round(share[: ROWS // 4])
    states = bounds[:, 0] + share * (bounds[:, 1] - bounds[:, 0])
    states[: ROWS // 4] = np.where(share[: ROWS // 4] > 0.5, bounds[:, 1], bounds[:, 0])
    found = [_fitted(case, states, bounds, rng)]
    for turn in range(ROUNDS):
        moved = _to_tests(case, found[-1].copy(), goal, rng) if turn != 1 else _to_bounds(case, found[-1].copy(), rng)
        found.append(_fitted(case, np.clip(moved, bounds[:, 0], bounds[:, 1]), bounds, rng))
    return np.concatenate(found)


def _fitted(case: Case, states: Array, bounds: Array, rng: np.random.Generator) -> Array:
    """States moved towards the region's differences and distances."""
    for a, b, (low, high) in case.region["differences"]:
        first, second = case.names.index(a), case.names.index(b)
        wanted = np.clip(states[:, first] - states[:, second], float(low), float(high))
        moved = np.clip(states[:, second] + wanted, *bounds[first])
        states[:, first], states[:, second] = moved, np.clip(moved - wanted, *bounds[second])
    for a, b, least in case.region["apart"]:
        axis = str(rng.choice(["x", "y"]))
        first, second = case.names.index(f"{a}.{axis}"), case.names.index(f"{b}.{axis}")
        gap = states[:, first] - states[:, second]
        near = np.flatnonzero(np.abs(gap) < float(least))
        wanted = states[near, second] + np.where(gap[near] < 0, -1, 1) * float(least)
        states[near, first] = np.clip(wanted, *bounds[first])
    return states


def nudged(values: Array, rng: np.random.Generator) -> Array:
    """Float64 numbers, some of them moved to a neighbour or two."""
    for steps in rng.integers(-1, 2, (2, len(values))):
        values = np.where(steps == 0, values, np.nextafter(values, steps * 1e300))
    return values


def _to_tests(case: Case, states: Array, goal: str | None, rng: np.random.Generator) -> Array:
    """Moves each state to where a test on some agent's way turns, or beside it."""
    agents = case.team or list(case.profile.agents)
    agent = agents[int(rng.integers(len(agents)))]
    at = case.at(states, goal)
    ways = paths(agent, at, case.semantics)
    level = (rng.random(len(states)) * (agent.feature[ways] >= 0).sum(axis=0)).astype(int)
    nodes = ways[level, np.arange(len(states))]
    for number in agent.tested:
        rows = np.flatnonzero(agent.feature[nodes] == number)
        feature = agent.features[number]
        if len(rows) and feature.terms:
            weight, name = feature.terms[int(rng.integers(len(feature.terms)))]
            place = case.column(name, goal)
            if place is not None:
                rest = summed(feature, at)[rows] - weight * states[rows, place]
                edge = _edges(agent.threshold[nodes[rows]], feature, rng)
                states[rows, place] = nudged(weight * (edge - rest), rng)
    return states


def _edges(thresholds: Array, feature: Feature, rng: np.random.Generator) -> Array:
    """Where tests turn: thresholds, the numbers beside them, and the middles between these; 0 for functions."""
    if feature.function:
        return np.zeros(len(thresholds))
    side = rng.choice([-np.inf, np.inf], len(thresholds)).astype(thresholds.dtype)
    with np.errstate(over="ignore"):
        beside = np.clip(np.nextafter(thresholds, side).astype(float), -1e30, 1e30)
    exact = thresholds.astype(float)
    return np.choose(rng.integers(0, 3, len(exact)), [exact, beside, (exact + beside) / 2])


def _to_bounds(case: Case, states: Array, rng: np.random.Generator) -> Array:
    """Moves each state to where a distance of the claim or the region is just met, or two places coincide."""
    lengths = [0.0, *map(float, lengths_of(case))]
    axis, movers = str(rng.choice(["x", "y"])), [agent.name for agent in case.team] or case.profile.movers
    for rows in np.array_split(np.arange(len(states)), 8):
        place = case.names.index(f"{rng.choice(movers)}.{axis}")
        other = case.names.index(f"{rng.choice([name[:-2] for name in case.names if name[-2] == '.'])}.{axis}")
        offset = rng.choice([-1, 1]) * lengths[int(rng.integers(len(lengths)))]
        states[rows, place] = nudged(states[rows, other] + offset, rng)
    return states


def lengths_of(case: Case) -> list[Fraction]:
    """The lengths that claim and region compare distances with."""
    claim, region = case.claim, case.region
    found = [claim[key] for key in ("margin", "radius") if claim.get(key) is not None]
    found += [bound for *_, bounds in region["differences"] for bound in bounds]
    found += [least for *_, least in region["apart"]]
    found += [abs(number) for key in ("formula", "assume") for number in _constants(claim.get(key))]
    return sorted(set(map(abs, found)))


def _constants(node: Any) -> Iterator[Fraction]:
    if isinstance(node, Fraction):
        yield node
    elif isinstance(node, tuple):
        for part in node[1:]:
            yield from _constants(part)


# --- enumeration


def free(case: Case) -> list[str]:
    """The coordinates that the region does not fix."""
    return [name for name, (low, high) in case.region["box"].items() if low < high]


def enumerable(case: Case) -> bool:
    """Whether `cells` can list one state for each cell: at most one free coordinate on each axis."""
    axes = [name[-1] for name in free(case)]
    simple = case.claim["name"] in ENUMERABLE and not case.claim.get("mixed")
    return simple and not case.eps and len(set(axes)) == len(axes)


def cells(case: Case, goal: str | None) -> Array | None:
    """States of which each combination of tests and bounds that the region allows has one; None where too many.

    In machine arithmetic every float64 state falls out as one of them, in real arithmetic every rational one.
    """
    machine = case.semantics == MACHINE
    axes = [_along(case, name, goal, machine) for name in free(case)]
    if math.prod(map(len, axes)) > (MAX_ROWS if machine else MAX_EXACT_ROWS):
        return None
    fixed = case.bounds.tolist() if machine else [*case.region["box"].values()]
    if any(low > high for low, high in fixed):
        return np.zeros((0, len(fixed)))
    rows = list(product(*axes))
    states = np.empty((len(rows), len(fixed)), dtype=float if machine else object)
    states[:] = [low for low, _ in fixed]
    for place, name in enumerate(free(case)):
        states[:, case.names.index(name)] = [row[place] for row in rows]
    return states


def _along(case: Case, name: str, goal: str | None, machine: bool) -> list[Any]:
    """Values of a free coordinate: where something turns, what lies beside, and between."""
    low, high = case.region["box"][name]
    ends = set(_claimed(case, name)) | set(_tested_exactly(case, name, goal))
    if not machine:
        cuts = sorted({low, high, *(end for end in ends if low <= end <= high)})
        return sorted({*cuts, *((a + b) / 2 for a, b in pairwise(cuts))})
    first, last = inner(low, high)
    found = {first, last}
    for value in [*map(float, ends), *_turns(case, name, goal, first, last)]:
        found |= {value, math.nextafter(value, -math.inf), math.nextafter(value, math.inf)}
    cuts = sorted(value for value in found if first <= value <= last)
    return sorted({*cuts, *((a + b) / 2 for a, b in pairwise(cuts))})


def _claimed(case: Case, name: str) -> Iterator[Fraction]:
    """Where an inequality of claim or region turns: at a length from another coordinate, or from 0."""
    others = [low for other, (low, high) in case.region["box"].items() if other[-1] == name[-1] and low == high]
    for other, length, sign in product([Fraction(0), *others], [Fraction(0), *lengths_of(case)], (1, -1)):
        yield other + sign * length


def _tests(case: Case, name: str, goal: str | None) -> Iterator[tuple[Agent, Feature, int, Array]]:
    """The agents' features that read a coordinate, with its weight and their thresholds."""
    place = case.names.index(name)
    for agent in case.profile.agents:
        for number in agent.tested:
            feature = agent.features[number]
            weight = sum(weight for weight, term in feature.terms if case.column(term, goal) == place)
            if weight:
                yield agent, feature, weight, np.unique(agent.threshold[agent.feature == number])


def _tested_exactly(case: Case, name: str, goal: str | None) -> Iterator[Fraction]:
    """Where tests turn in exact arithmetic."""
    base = fractions([low for low, _ in case.region["box"].values()])[None]
    at = case.at(base, goal)
    for _, feature, weight, thresholds in _tests(case, name, goal):
        rest = summed(feature, at)[0] - weight * case.region["box"][name][0]
        for threshold in [0.0] if feature.function else thresholds.tolist():
            yield (Fraction(threshold) - rest) / weight


def _turns(case: Case, name: str, goal: str | None, first: float, last: float) -> Iterator[float]:
    """Where tests turn in machine arithmetic: by bisection over the float64 numbers of an interval."""
    base = case.bounds[:, 0]
    for _, feature, _, thresholds in _tests(case, name, goal):
        limits = np.unique(np.array([-0.5, 0.5], dtype=thresholds.dtype)) if feature.function else thresholds

        def left(values: Array, feature: Feature = feature, limits: Array = limits) -> Array:
            states = np.tile(base, (len(values), 1))
            states[:, case.names.index(name)] = values
            return measured(feature, case.at(states, goal), MACHINE, limits.dtype) <= limits

        low = np.full(len(limits), _ordinal(first), dtype=np.int64)
        high = np.full(len(limits), _ordinal(last), dtype=np.int64)
        begin = left(np.full(len(limits), first))
        for _ in range(BITS):
            middle = low + (high - low) // 2
            same = left(_value(middle)) == begin
            low, high = np.where(same, middle, low), np.where(same, high, middle)
        yield from _value(low).tolist()


def _ordinal(value: float) -> int:
    """The place of a float64 number among all of them."""
    bits = int(np.float64(value).view(np.int64))
    return bits if bits >= 0 else -(bits & (2**63 - 1))


def _value(ordinals: Array) -> Array:
    """The float64 numbers at places."""
    size = np.abs(ordinals).view(np.float64)
    return np.where(ordinals < 0, -size, size)


def scaled(states: Array, denominator: int) -> tuple[Array, int]:
    """States as integers, exactly, and how many times what they stand for these are."""
    ratios = [[value.as_integer_ratio() for value in row] for row in states.tolist()]
    scale = math.lcm(denominator, *(under for row in ratios for _, under in row))
    found = np.empty(states.shape, dtype=object)
    for place, row in enumerate(ratios):
        found[place] = [over * (scale // under) for over, under in row]
    return found, scale


def described(states: Sequence[Any], names: Sequence[str]) -> dict[str, Any]:
    """One state by coordinate."""
    return dict(zip(names, states, strict=True))
