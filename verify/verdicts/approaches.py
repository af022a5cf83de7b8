"""How near episodes come to the border of a claim about a stated system: the closest approach, in a variable's unit.

Does: measures the states of random episodes, or of a counterexample, against the half spaces of a claim's regions.
Assumes: states in float64; nothing is decided by these figures.
Does not: prove a distance; measure systems in continuous time, or claims about single decisions.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from fractions import Fraction
from typing import NamedTuple

import numpy as np

from codegen.ir import Float64, Int64, PolicyProfile
from codegen.lowering.render import brief
from codegen.numbers import nearest_double
from verify.reach.play import Planes, Play, Starts, random_starts, value
from verify.reach.results import SystemCounterexample
from verify.systems.claims import SystemClaim
from verify.systems.system import HalfSpace, System

EPISODES, SEED = 1_000, 1
ROUNDED = 2.0**-40  # of the ranges: a state no farther beyond a border is on it, but for the rounding of float64


@dataclass(frozen=True)
class ClosestApproach:
    """The state that comes nearest to a border, or goes farthest beyond it."""

    border: str  # such as "T = 22.5"
    gap: float  # from there, in `unit`
    unit: str  # of the variable; "": the border is of a sum
    step: int
    episodes: int  # random ones; 0: it is the counterexample, whose state lies beyond
    short: bool = False  # or which falls short of its goal


class _MeasuredBorder(NamedTuple):
    """A half space, the number that `gap` counts in, and the one in which borders are compared."""

    half: HalfSpace
    factor: float
    width: float


def closest(profile: PolicyProfile, system: System, claim: SystemClaim) -> ClosestApproach | None:
    """Among random episodes; None for claims that an episode fulfils at a step of its own, where all that is played
    leaves what is stated, and where an episode goes beyond the border, by errors of enclosures that no rule has.
    """
    if claim.about_decisions or claim.says.once or system.flow is not None:
        return None
    random = np.random.default_rng(SEED)
    start = random_starts(system, claim, Starts(EPISODES), random)
    if start is None:
        return None
    count, approach, least = len(next(iter(start.values()))), None, np.inf
    with np.errstate(over="ignore", invalid="ignore"):
        for step, state, alive in Play(profile, system).walk(start, random, claim.steps):
            if step < claim.by or not alive.any():
                continue
            levels, borders = _levels(system, claim, state)
            place = int(np.argmin(np.where(alive & np.isfinite(levels), levels, np.inf)))
            if alive[place] and levels[place] < -ROUNDED:
                return None
            if alive[place] and max(levels[place], 0.0) < least:
                least = max(levels[place], 0.0)
                approach = _approach(system, claim, int(borders[place]), float(least), step, count)
    return approach


def beyond(system: System, claim: SystemClaim, shown: SystemCounterexample) -> ClosestApproach | None:
    """By how much a counterexample breaks its claim: at its last state, or where it comes nearest to a goal."""
    if claim.about_decisions or system.flow is not None:
        return None
    steps = range(len(shown.states)) if claim.says.once else [shown.step]
    states = [shown.states[step] for step in steps]
    planes = {name: np.array([nearest_double(state[name]) for state in states]) for name in shown.start}
    levels, borders = _levels(system, claim, planes)
    place = int(np.argmax(levels))
    approach = _approach(system, claim, int(borders[place]), -float(levels[place]), steps[place], 0)
    return replace(approach, short=claim.says.once)


def _borders(system: System, claim: SystemClaim) -> list[list[_MeasuredBorder]]:
    """Those of each region."""
    widths = {one.name: float(one.range[1] - one.range[0]) for one in system.variables}

    def border(half: HalfSpace) -> _MeasuredBorder:
        terms = half.form.terms
        factor = abs(float(terms[0][1])) if len(terms) == 1 else 1.0
        return _MeasuredBorder(half, factor, sum(abs(float(weight)) * widths[name] for name, weight in terms) or 1.0)

    return [[border(half) for half in polytope] for polytope in claim.regions]


def _levels(system: System, claim: SystemClaim, state: Planes) -> tuple[Float64, Int64]:
    """Returns how far each state is from being excluded, as a share of the ranges, negative where it is; and the place
    of the border that says so, counted through all regions.
    """
    sign, first = (1.0 if claim.says.avoided else -1.0), 0
    levels: list[Float64] = []
    places: list[Int64] = []
    for borders in _borders(system, claim):
        rows = np.stack([sign * value(each.half.form, state) / each.width for each in borders])
        chosen = rows.argmax(axis=0) if claim.says.avoided else rows.argmin(axis=0)
        levels.append(np.take_along_axis(rows, chosen[None], axis=0)[0])
        places.append(chosen + first)
        first += len(borders)
    regions = np.stack(levels)
    region = regions.argmin(axis=0) if claim.says.avoided else regions.argmax(axis=0)
    chosen = region[None]
    return np.take_along_axis(regions, chosen, axis=0)[0], np.take_along_axis(np.stack(places), chosen, axis=0)[0]


def _approach(
    system: System, claim: SystemClaim, place: int, level: float, step: int, episodes: int
) -> ClosestApproach:
    nearest = [each for borders in _borders(system, claim) for each in borders][place]
    terms, constant = nearest.half.form.terms, float(nearest.half.form.constant)
    gap = 0.0 + level * nearest.width / nearest.factor
    if len(terms) == 1:
        ((name, factor),) = terms
        unit = next(one.unit for one in system.variables if one.name == name)
        border = f"{name} = {brief(-constant / float(factor) + 0.0)}"
        return ClosestApproach(border, gap, "" if unit == "1" else unit, step, episodes)
    parts = (f"{'-' if weight < 0 else ''}{_times(abs(weight))}{name}" for name, weight in terms)
    told = " + ".join(parts).replace("+ -", "- ")
    return ClosestApproach(f"{told} = {brief(-constant + 0.0)}", gap, "", step, episodes)


def _times(weight: Fraction) -> str:
    return "" if weight == 1 else f"{brief(float(weight))}*"
