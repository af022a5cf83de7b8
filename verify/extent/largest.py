"""Where a violated claim holds: the largest region found in which it is proved, and what is known of the others.

Does: looks for a region that leaves every violating zone out and loses few states, by cuts and by its own questions to
  the zone engine; joins it with the zones and their share.
Assumes: all violating zones are known (violations.py).
Does not: trust float64, which only guides cuts: the zone engine is asked afterwards.

A cut `a - b <= c` keeps every zone out whose least a - b is above c; so with the zones' least values in every direction
known, a cut is a threshold, and what it removes and loses is counted along sorted states. Bounds lie on a decimal grid.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from itertools import permutations

import numpy as np
import numpy.typing as npt

from codegen.intervals import Share
from codegen.ir import GOAL, Bool, Float64
from verify.claims.formula import TRUE
from verify.claims.region import Interval, Region
from verify.claims.region_files import everywhere
from verify.extent.violations import ExactShare, Failing, exact_part, exact_share, violations
from verify.question import DecisionQuestion
from verify.result import Verdict
from verify.spending import tell
from verify.states import shares
from verify.states.shares import SAMPLE_SEED, SAMPLES, explain_unstated, find_unbounded
from verify.states.state import batch, contains, sample
from verify.zones import engine
from verify.zones.engine import BeyondZonesError

GRID = 1000  # bounds are whole multiples of 1 / GRID
MAX_BACK = 5  # cuts that are taken back at a time
NEAR = 1e-9  # what float64 cannot tell apart
Int64 = npt.NDArray[np.int64]
Matrices = list[Float64]  # of zones, one array [zones, nodes, nodes] a group: most of a - b
Cuts = Mapping[int, int]  # direction -> most of a - b, in 1 / GRID


@dataclass(frozen=True)
class Obstacles:
    """The violating zones of some goals, in groups of coordinates that bounds on differences join."""

    groups: tuple[tuple[str, ...], ...]  # of each group the names of its nodes; "" is zero
    zones: Matrices

    @cached_property
    def directions(self) -> tuple[tuple[int, int, int], ...]:
        """(group, a, b) of every difference that may be bounded."""
        return tuple((g, a, b) for g, names in enumerate(self.groups) for a, b in permutations(range(len(names)), 2))

    def pair(self, direction: int) -> tuple[str, str]:
        """The names of a direction's nodes."""
        group, a, b = self.directions[direction]
        return self.groups[group][a], self.groups[group][b]

    def cut_zones(self, zones: Matrices, direction: int, most: int) -> Matrices:
        """The zones that a cut does not remove, cut."""
        group, a, b = self.directions[direction]
        kept = zones[group][:, b, a] + most / GRID >= 0
        surviving = [matrices[kept] for matrices in zones]
        bounds = surviving[group]
        through = bounds[:, :, a, None] + (most / GRID + bounds[:, b, :])[:, None, :]
        surviving[group] = np.minimum(bounds, through)
        return surviving

    def thresholds(self, zones: Matrices, direction: int) -> Int64:
        """For each zone the largest cut in a direction that removes it, [zones]."""
        group, a, b = self.directions[direction]
        return np.floor((-zones[group][:, b, a] - NEAR) * GRID).astype(np.int64)


def obstacles(failing: Sequence[Failing]) -> Obstacles:
    """The zones of some goals as arrays, over the components of all goals, joined where they overlap."""
    joined: list[list[str]] = []
    for one in failing:
        for component in range(len(one.problem.sizes)):
            names = [name for name, (own, _) in one.problem.places.items() if own == component]
            meeting = [group for group in joined if set(group) & set(names)]
            joined = [group for group in joined if group not in meeting]
            joined.append(list(dict.fromkeys([*(name for group in meeting for name in group), *names])))
    groups = tuple(("", *group) for group in joined)
    parts = [[_matrices(one, names) for names in groups] for one in failing]
    return Obstacles(groups, [np.concatenate([part[g] for part in parts]) for g in range(len(groups))])


def _matrices(one: Failing, names: Sequence[str]) -> Float64:
    """One goal's zones over the nodes of a group, [zones, nodes, nodes]."""
    lengths = {cell: cell / one.problem.scale for cell in {cell for _, cells in one.zones for cell in cells}}
    cells = np.array([[lengths[cell] for cell in cells] for _, cells in one.zones])
    cells = cells.reshape(len(one.zones), sum(size * size for size in one.problem.sizes))
    bounds = np.zeros((len(one.zones), len(names), len(names)))
    for (i, a), (j, b) in permutations(enumerate(names), 2):
        if one.problem.are_joined(a, b):
            bounds[:, i, j] = cells[:, one.problem.cell(a, b)]
        else:
            bounds[:, i, j] = cells[:, one.problem.cell(a, "")] + cells[:, one.problem.cell("", b)]
    return bounds


class Carver:
    """Cuts regions out of one region, guided by sampled states of it.

    `columns`: coordinate -> [states]; `weights`: what losing a state costs, [states].
    """

    def __init__(self, obstacles: Obstacles, columns: Mapping[str, Float64], weights: Float64) -> None:
        self.obstacles, self.weights = obstacles, weights
        zero = np.zeros(len(weights))
        pairs = [obstacles.pair(direction) for direction in range(len(obstacles.directions))]
        self.values = [columns.get(a, zero) - columns.get(b, zero) for a, b in pairs]
        self.order = [np.argsort(values, kind="stable") for values in self.values]
        self.sorted = [values[order] for values, order in zip(self.values, self.order, strict=True)]

    def inside(self, cuts: Cuts) -> Bool:
        """The states that cuts keep, [states]."""
        kept = np.ones(len(self.weights), dtype=bool)
        for direction, most in cuts.items():
            kept &= self.values[direction] <= most / GRID
        return kept

    def worth(self, cuts: Cuts) -> float:
        """The weight of the states that cuts keep."""
        return float(self.weights[self.inside(cuts)].sum())

    def carve(self, seed: int, cuts: Cuts, zones: Matrices) -> dict[int, int] | None:
        """More cuts, until no zone is left; None when the state `seed` cannot be kept."""
        carved = dict(cuts)
        while len(zones[0]):
            cut = self._cheapest(seed, carved, zones)
            if cut is None:
                return None
            direction, most = cut
            carved[direction] = min(most, carved.get(direction, most))
            zones = self.obstacles.cut_zones(zones, direction, most)
        return carved

    def _cheapest(self, seed: int, cuts: Cuts, zones: Matrices) -> tuple[int, int] | None:
        """The cut that loses least for each zone that it removes."""
        weights, best = self.weights * self.inside(cuts), None
        for direction in range(len(self.values)):
            at = self.obstacles.thresholds(zones, direction)
            at = at[at >= self.values[direction][seed] * GRID]
            if not len(at):
                continue
            most, counts = np.unique(at, return_counts=True)
            removed = np.cumsum(counts[::-1])[::-1]
            kept = np.concatenate([[0.0], np.cumsum(weights[self.order[direction]])])
            lost = kept[-1] - kept[np.searchsorted(self.sorted[direction], most / GRID, side="right")]
            cost = (lost + NEAR) / removed
            place = len(cost) - 1 - int(np.argmin(cost[::-1]))
            if best is None or cost[place] < best[0]:
                best = cost[place], direction, int(most[place])
        return None if best is None else best[1:]

    def remaining(self, cuts: Cuts) -> Matrices:
        """The zones that cuts leave."""
        zones = self.obstacles.zones
        for direction, most in cuts.items():
            zones = self.obstacles.cut_zones(zones, direction, most)
        return zones

    def improve_cuts(self, seed: int, cuts: Cuts, rounds: int, rng: np.random.Generator) -> dict[int, int]:
        """Cuts that keep more, or as much with fewer cuts: `rounds` times some are taken back and found anew."""
        best, worth = dict(cuts), self.worth(cuts)
        for _ in range(rounds if best else 0):
            count = int(rng.integers(1, min(MAX_BACK, len(best)) + 1))
            back = rng.choice(sorted(best), count, replace=False).tolist()
            kept = {direction: most for direction, most in best.items() if direction not in back}
            candidate = self.carve(seed, kept, self.remaining(kept))
            if candidate is None:
                continue
            gained = self.worth(candidate)
            if (gained, -len(candidate)) > (worth, -len(best)):
                best, worth = candidate, gained
        return best


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
    goals = [failing, *([one] for one in failing if len(failing) > 1)]  # all together, and each alone
    tries = [one for chosen in goals for one in _tries(chosen, states, len(failing))]
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
                box: dict[str, Interval] = {}  # its bounds on the grid
                for name, (low, high) in question.region.box.items():
                    middle, half = Fraction(float(states.columns[name][row])), (high - low) * SMALLER**number / 2
                    first, last = (Fraction(round(end * GRID), GRID) for end in (middle - half, middle + half))
                    box[name] = min(high, max(low, first)), max(low, min(high, last))
                yield replace(question.region, box=box)
            return


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
    return Region(box, goals, stated, region.apart, name="largest", whole=region.whole)


def _bounds(space: Obstacles, cuts: Cuts) -> list[tuple[str, str, Fraction]]:
    """(a, b, most of a - b) of each cut, "" standing for zero, in a fixed order."""
    return [(*space.pair(direction), Fraction(most, GRID)) for direction, most in sorted(cuts.items())]


BEYOND = (
    "an inequality of the claim bounds neither a coordinate nor a difference of two, so only a solver can decide it"
)
OVERLAPPING = "zones of different leaves overlap, in too many parts to count each state once"
OF_LEAVES = "the claim is about leaves and not about world states"


@dataclass(frozen=True)
class ProvedPart:
    """A part of the region in which the claim is proved: how much of it, and of the start region, it is."""

    region: Region
    exact: Fraction | None  # share of the region; None where it takes too many faces
    share: Share  # the same, sampled
    start: Share | None  # None where the start region has a coordinate without a range


@dataclass(frozen=True)
class Where:
    """The zones and regions that are known; each part that is missing has its reason."""

    reason: str = ""  # why there are no zones at all
    everywhere: bool = False
    failing: tuple[Failing, ...] = ()  # goal by goal
    share: ExactShare | None = None
    share_reason: str = ""
    part: ProvedPart | None = None
    part_reason: str = ""

    @property
    def complete(self) -> bool:
        """True if the zones are all that there are."""
        return all(one.complete for one in self.failing)

    @property
    def count(self) -> int:
        """The number of zones."""
        return sum(len(one.zones) for one in self.failing)


def where(question: DecisionQuestion, verdict: Verdict, name: str = "") -> Where:
    """Where a claim with that verdict holds and fails. `name`: of the region that is found."""
    claim = question.claim
    if not claim.per_state:
        return Where(OF_LEAVES)
    if verdict is Verdict.PROVED:
        return Where(everywhere=True)
    if verdict is Verdict.VACUOUS:
        return Where("the claim is about no world state of the region")
    try:
        failing = tuple(violations(question))
    except BeyondZonesError:
        return Where(BEYOND)
    extent = Where(failing=failing)
    if reason := explain_unstated(question):
        return replace(extent, share_reason=reason, part_reason=reason)
    if not extent.complete:
        spent = next((one.limit for one in failing if not one.complete and one.nodes > one.limit), 0)
        ending = f"there are more than {question.budgets.max_cells:,}; a larger --effort lists more"
        if spent:
            ending = f"the search ended after {spent:,} nodes; {question.budgets.hint('goes on')}"
        reason = f"not all violating zones are known: {ending}"
        extent = replace(extent, share_reason=reason, part_reason=reason)
        # a region inside a smaller one of which all are known; each smaller one might take as many nodes
        for candidate in () if spent else candidates(question, SAMPLE_SEED):
            inner = question.within(candidate)
            failing = tuple(violations(inner))
            if all(one.complete for one in failing):
                # without zones it holds in all of the candidate
                part = largest(inner, failing, SAMPLE_SEED) if any(one.zones for one in failing) else candidate
                if isinstance(part, str):
                    return replace(extent, part_reason=f"{reason}; in a smaller region: {part}")
                return replace(extent, part=_part(question, replace(part, name=name)), part_reason="")
        return extent
    share = exact_share(question, failing)
    extent = replace(extent, share=share) if isinstance(share, ExactShare) else replace(extent, share_reason=share)
    if isinstance(share, ExactShare) and not share.exact:
        extent = replace(extent, share_reason=OVERLAPPING)
    if not extent.count:
        return replace(extent, part_reason="no zone violates the claim over real positions")
    part = largest(question, failing, SAMPLE_SEED)
    if isinstance(part, str):
        return replace(extent, part_reason=part)
    return replace(extent, part=_part(question, replace(part, name=name)))


def _part(question: DecisionQuestion, part: Region) -> ProvedPart:
    start, share = everywhere(question.profile), _within(question, part, question.region)
    of_start = None if find_unbounded(start) else _within(question, part, start)
    return ProvedPart(part, exact_part(question, part), share, of_start)


def _within(question: DecisionQuestion, part: Region, whole: Region) -> Share:
    """The sampled share of a part in the states of a whole that meet the assumption."""
    profile, claim = question.profile, question.claim
    coordinates, goals = sample(whole, profile.world, SAMPLES, SAMPLE_SEED)
    if claim.assume != TRUE:
        kept = batch(coordinates, profile.world).holds(claim.assume, {})
        coordinates, goals = coordinates[kept], goals[kept]
    inside = contains(part, coordinates, profile.world)
    if part.goals:
        inside &= [profile.world.landmarks[int(goal)].name in part.goals for goal in goals]
    return Share(int(inside.sum()), len(inside))
