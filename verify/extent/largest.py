"""The largest region found in which a claim holds and means something: a box with bounds on differences.

Does: starts at conflicting states that fulfil the claim, cuts the violating zones off (carving.py), for all goals and
  for each alone, and takes the region that keeps most; asks the zone engine whether the claim is proved there.
Assumes: all violating zones are known (violations.py), at least one.
Does not: find the largest of all such regions: it is the best of a fixed number of tries.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction

import numpy as np

from codegen.ir import GOAL, Bool, Float64
from verify.claims.formula import TRUE
from verify.claims.region import Interval, Region
from verify.extent.carving import GRID, Carver, Cuts, Obstacles, obstacles
from verify.extent.violations import Failing
from verify.progress import tell
from verify.question import DecisionQuestion
from verify.result import Verdict
from verify.states import shares
from verify.states.state import batch, sample
from verify.zones import engine

SEEDS = 12  # conflicting states that are started from, for each choice of goals
DRAWN = 10_000  # states that guide the cuts
ROUNDS = 40  # in which cuts are taken back and found anew
NARROWED, SMALLER = 24, Fraction(3, 4)  # how often a region is narrowed, each time by so much
CONFLICTING = 2.0  # what losing a conflicting state costs; another one costs 1


@dataclass(frozen=True)
class _Try:
    """Cuts for some goals, from one seed; `worth` is of all goals, those left out counting nothing."""

    goals: tuple[str, ...]
    carver: Carver
    seed: int
    cuts: Cuts
    worth: float


@dataclass(frozen=True)
class _States:
    """Sampled states of a region: coordinate -> [states], and for each goal where the claim fails or could."""

    columns: Mapping[str, Float64]
    violating: Mapping[str | None, Bool]
    conflicting: Mapping[str | None, Bool]


def largest(question: DecisionQuestion, failing: Sequence[Failing], seed: int) -> Region | str:
    """A part of the region in which the zone engine proves the claim and some sampled state conflicts, or why not.

    `failing`: all violating zones of the region; `seed`: of every random draw.
    """
    states = _states(question, seed)
    if states is None:
        return "there are too many joint actions to say which states conflict"
    if not len(next(iter(states.violating.values()))):
        return "no sampled state lies in the region"
    tries = [one for goals in _choices(failing) for one in _tries(goals, states, len(failing))]
    if not tries:
        return f"of {DRAWN} states, none both conflicts and can be kept away from every violating zone"
    rng = np.random.default_rng(seed)
    for place, one in enumerate(sorted(tries, key=lambda carved: -carved.worth)[:SEEDS]):
        tell(place, min(len(tries), SEEDS), "regions carved out and tried to prove")
        cuts = one.carver.improve_cuts(one.seed, one.cuts, ROUNDS, rng)
        region = within(question.region, one.goals, one.carver.obstacles, cuts)
        if engine.decide(question.within(region)).verdict is Verdict.PROVED:
            return region
    return "no region that was tried could be proved"


def candidates(question: DecisionQuestion, seed: int) -> Iterator[Region]:
    """Smaller and smaller regions around a conflicting state that fulfils the claim; none where no sampled one does."""
    states = _states(question, seed)
    if states is None:
        return
    for goal, bad in states.violating.items():
        for row in np.flatnonzero(states.conflicting[goal] & ~bad)[:1]:
            for number in range(1, NARROWED):
                yield _around(question.region, states.columns, int(row), SMALLER**number)
            return


def _around(region: Region, columns: Mapping[str, Float64], row: int, share: Fraction) -> Region:
    """The part of a region within a share of its sides around a sampled state, its bounds on the grid."""
    box: dict[str, Interval] = {}
    for name, (low, high) in region.box.items():
        middle, half = Fraction(float(columns[name][row])), (high - low) * share / 2
        first, last = (Fraction(round(end * GRID), GRID) for end in (middle - half, middle + half))
        box[name] = min(high, max(low, first)), max(low, min(high, last))
    return replace(region, box=box)


def _states(question: DecisionQuestion, seed: int) -> _States | None:
    profile, claim = question.profile, question.claim
    coordinates, _ = sample(question.region, profile.world, DRAWN, seed)
    names = profile.world.coordinates()
    violating, conflicting = dict[str | None, Bool](), dict[str | None, Bool]()
    for goal in question.goals:
        for axis in "xy" if goal is not None else "":
            coordinates[:, names.index(f"{GOAL}.{axis}")] = coordinates[:, names.index(f"{goal}.{axis}")]
        violating[goal] = shares.violating(question, coordinates)
        conflict = shares.conflicts(question, coordinates)
        if conflict is None:
            return None
        conflicting[goal] = conflict
        if claim.assume != TRUE:
            conflicting[goal] &= batch(coordinates, profile.world).holds(claim.assume, {})
    return _States(dict(zip(names, coordinates.T, strict=True)), violating, conflicting)


def _choices(failing: Sequence[Failing]) -> list[Sequence[Failing]]:
    """All goals together, and each alone."""
    return [failing, *([one] for one in failing if len(failing) > 1)]


def _tries(failing: Sequence[Failing], states: _States, goals: int) -> list[_Try]:
    """Lists what is cut from each seed, with its worth."""
    names = tuple(one.goal for one in failing if one.goal is not None)
    bad = np.logical_or.reduce([states.violating[one.goal] for one in failing])
    conflict = np.logical_or.reduce([states.conflicting[one.goal] for one in failing])
    weights = np.where(bad, 0.0, np.where(conflict, CONFLICTING, 1.0))
    carver = Carver(obstacles(failing), states.columns, weights)
    tries: list[_Try] = []
    for seed in map(int, np.flatnonzero(conflict & ~bad)[:SEEDS]):
        cuts = carver.carve(seed, {}, carver.obstacles.zones)
        if cuts is not None:
            tries.append(_Try(names, carver, seed, cuts, carver.worth(cuts) * len(failing) / goals))
    return tries


def within(region: Region, goals: tuple[str, ...], space: Obstacles, cuts: Cuts) -> Region:
    """The part of a region that cuts leave, for some of its goals."""
    box: dict[str, Interval] = dict(region.box)
    for a, b, most in _bounds(space, cuts):
        low, high = box[a or b]
        if not b:
            box[a] = (low, min(high, most))
        elif not a:
            box[b] = (max(low, -most), high)
    differences = {(a, b): bounds for a, b, bounds in region.differences}
    for a, b, most in _bounds(space, cuts):
        if not a or not b:
            continue
        if (b, a) in differences:
            low, high = differences[b, a]
            differences[b, a] = (max(low, -most), high)
        else:
            low, high = differences.get((a, b), (box[a][0] - box[b][1], box[a][1] - box[b][0]))
            differences[a, b] = (low, min(high, most))
    stated = tuple((a, b, bounds) for (a, b), bounds in differences.items())
    return Region(box, goals, stated, region.apart, name="largest")


def _bounds(space: Obstacles, cuts: Cuts) -> list[tuple[str, str, Fraction]]:
    """(a, b, most of a - b) of each cut, "" standing for zero, in a fixed order."""
    return [(*space.pair(direction), Fraction(most, GRID)) for direction, most in sorted(cuts.items())]
