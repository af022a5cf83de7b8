"""All zones in which a claim fails, and how much of the region they are, exactly.

Does: asks the zone engine for every tuple of leaves and clause of the denied claim that some state meets; adds up the
  volumes of the zones. Where features may be off zones overlap: it cuts those of one goal, the largest first, into
  parts without a common point; beyond a budget of parts it bounds what a zone adds by its own volume.
Assumes: a claim about single decisions, over difference bounds; else BeyondZonesError.
Does not: confirm points: a zone is of real states, and one narrower than a float may hold no float64 state. It does not
  keep parts: one state may lie in zones of several leaves, and each zone is told whole.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import lru_cache, partial
from itertools import permutations
from math import factorial, lcm, prod
from typing import NamedTuple, TypeAlias

import numpy as np

from codegen.ir import Bool, Float64
from verify.claims.formula import negate
from verify.claims.region import Region
from verify.claims.wording import OwnFormula
from verify.kinds import MACHINE
from verify.question import Budgets, DecisionQuestion
from verify.spending import tell
from verify.zones.engine import Tests, ZoneQuery
from verify.zones.search import Branch
from verify.zones.tables import EPSILON, Problem
from verify.zones.volume import DEFAULT_FACES, FacesError, Volumes

DEFAULT_PARTS = 200_000  # that zones are cut into, over all goals
NEAR = 1e-9  # within which float64 does not say that zones have no common point
Cells: TypeAlias = list[list[list[int]]]  # a zone: a closed matrix for each component


class Union(NamedTuple):
    """The volume of a union: at least, at most, in the units of the zones' volumes; and the parts made for it."""

    least: int
    most: int
    parts: int


def union(
    problem: Problem,
    zones: Sequence[Branch],
    own: Sequence[int],
    fixed: Mapping[str, str],
    measure: Callable[[Branch], int],
    budget: int,
) -> Union:
    """The volume of all zones together. `own`: the volume of each; `fixed`: as of `find_fixed_coordinates`;
    `measure`: of a zone.
    """
    order = sorted(range(len(zones)), key=lambda number: (-own[number], number))
    cutter = _Cutter(problem, fixed)
    matrices = [cutter.matrices(zones[number][1]) for number in order]
    bounds = np.array([[cell / problem.scale for cell in zones[number][1]] for number in order])
    turned = bounds[:, cutter.turned] if len(bounds) else bounds
    least = most = made = 0
    for place, number in enumerate(order):
        tell(place, len(order), "failing cells made disjoint")
        earlier = np.flatnonzero(_overlapping(bounds[:place], turned[place]))
        parts = cutter.parts(matrices[place], [matrices[other] for other in earlier], bounds[earlier], budget - made)
        if parts is None:
            most += own[number]
            made = budget
            continue
        made += len(parts)
        volume = own[number] if not len(earlier) else sum(measure(((), cutter.flat(part))) for part in parts)
        least, most = least + volume, most + volume
    return Union(least, most, made)


def _overlapping(bounds: Float64, turned: Float64) -> Bool:
    """Returns which of some zones [zones, cells] may meet one whose matrices are `turned` [cells]."""
    return np.asarray((bounds + turned >= -NEAR).all(axis=1))


class _Cutter:
    """Cuts zones of one problem."""

    def __init__(self, problem: Problem, fixed: Mapping[str, str]) -> None:
        self._sizes, self._scale = problem.sizes, problem.scale

        def root(name: str) -> str:
            while name in fixed:
                name = fixed[name]
            return name

        self._tied = [[[root(a) == root(b) for b in own] for a in own] for own in problem.names]
        cells = [problem.cell(b, a, own) for own, names in enumerate(problem.names) for a in names for b in names]
        self.turned = np.array(cells)

    def matrices(self, cells: Sequence[int]) -> Cells:
        """A zone's cells as matrices."""
        # of a sum of strict bounds one unit less says enough, and its opposite can be stated
        even = [-(-cell // EPSILON) * EPSILON - (cell % EPSILON != 0) for cell in cells]
        matrices, start = list[list[list[int]]](), 0
        for size in self._sizes:
            matrices.append([even[start + i * size : start + (i + 1) * size] for i in range(size)])
            start += size * size
        return matrices

    def flat(self, zone: Cells) -> list[int]:
        """The cells of a zone, given as matrices, in one list: the inverse of `matrices`."""
        return [cell for matrix in zone for row in matrix for cell in row]

    def parts(self, zone: Cells, others: Sequence[Cells], bounds: Float64, most: int) -> list[Cells] | None:
        """Returns what is left of a zone without others, in parts; None where more than `most` are met on the way.

        `bounds`: the others' [others, cells], in units of length.
        """
        left, work, met = list[Cells](), [(zone, 0)], 0
        while work:
            part, first = work.pop()
            met += 1
            if met > most:
                return None
            turned = np.array([cell / self._scale for cell in self.flat(part)])[self.turned]
            near = (first + int(k) for k in np.flatnonzero(_overlapping(bounds[first:], turned)))
            number = next((number for number in near if not self._apart(part, others[number])), None)
            if number is None:
                left.append(part)
            else:
                work += [(piece, number + 1) for piece in self._without(part, others[number])]
        return left

    def _without(self, zone: Cells, other: Cells) -> Iterator[Cells]:
        """The parts of a zone that lie beyond one bound of another one and within those before."""
        left: Cells | None = zone
        for component, matrix in enumerate(other):
            for i, j in permutations(range(len(matrix)), 2):
                if left is None or left[component][i][j] <= matrix[i][j]:
                    continue
                beyond = self._cut(left, component, j, i, -matrix[i][j] - 1)
                if beyond is not None:
                    yield beyond
                left = self._cut(left, component, i, j, matrix[i][j])

    def _apart(self, zone: Cells, other: Cells) -> bool:
        """Returns True if two zones have no volume in common, as a pair of bounds alone says."""
        return any(
            a + b < 0 or (a + b == 0 and not tied)
            for one, two, ties in zip(zone, other, self._tied, strict=True)
            for row, column, tie in zip(one, zip(*two, strict=True), ties, strict=True)
            for a, b, tied in zip(row, column, tie, strict=True)
        )

    def _cut(self, zone: Cells, component: int, i: int, j: int, most: int) -> Cells | None:
        """The part of a zone with x_i - x_j <= most; None where that has no volume."""
        matrix = zone[component]
        thickness = most + matrix[j][i]
        if thickness < 0 or (not thickness and not self._tied[component][i][j]):
            return None
        if most >= matrix[i][j]:
            return zone
        onward = [most + far for far in matrix[j]]
        cut = [[min(a, row[i] + b) for a, b in zip(row, onward, strict=True)] for row in matrix]
        return [*zone[:component], cut, *zone[component + 1 :]]


MAX_MEETING = 20_000  # common parts of zones of several questions
USUAL_BITS = 256  # of bounds in units; with more, fewer faces are visited


@dataclass(frozen=True)
class Failing:
    """One goal's violating zones: of each the agents' leaves and the closed matrices of its components."""

    goal: str | None
    agents: tuple[str, ...]  # whose leaves a zone names, in this order
    problem: Problem
    zones: tuple[Branch, ...]
    complete: bool  # whether these are all
    nodes: int  # search nodes
    limit: int  # of search nodes

    def bounds(self, zone: Branch) -> dict[tuple[str, str], tuple[Fraction, bool]]:
        """(a, b) -> (most of a - b, whether it stays below); "" stands for zero. Only within components."""
        pairs = [pair for own in self.problem.names for pair in permutations(own, 2)]
        return {(a, b): _length(zone[1][self.problem.cell(a, b)], self.problem.scale) for a, b in pairs}


@lru_cache(maxsize=10_000)
def _length(units: int, scale: int) -> tuple[Fraction, bool]:
    """A bound of a zone as a length, and whether it is strict; zones of one tree share most of theirs."""
    return Fraction(-(-units // EPSILON) * EPSILON, scale), units % EPSILON != 0


@dataclass(frozen=True)
class ExactShare:
    """Volumes of the region (of its states that meet the assumption), of each zone, and of all zones together (`least`
    and `most` differ where that takes too many parts), of all goals together, in one unit.

    They are integers: to reduce a fraction for each zone may take minutes, where bounds have hundreds of digits.
    """

    region: int
    zones: tuple[tuple[int, ...], ...]  # goal by goal, in the order of the zones
    least: int
    most: int

    @property
    def exact(self) -> bool:
        """True if the share is known, and not only its bounds."""
        return self.least == self.most

    @property
    def value(self) -> Fraction:
        """The share of the region in which the claim fails, goals being equally likely; the least that it may be."""
        return Fraction(self.least, self.region)

    @property
    def upper(self) -> Fraction:
        """The most that the share may be."""
        return Fraction(self.most, self.region)


def violations(question: DecisionQuestion) -> list[Failing]:
    """The violating zones, goal after goal, `max_cells` in all, with at most `max_nodes` search nodes per goal.

    Where features may be off, a zone holds the states in which some errors lead the agents to its leaves, so zones of
    other leaves may hold them too. BeyondZonesError when the question is not about difference bounds.
    """
    failing: list[Failing] = []
    tests = Tests.of(question)
    for goal in question.goals:
        known = sum(len(one.zones) for one in failing)
        left = question.budgets.max_cells - known
        tell(known, question.budgets.max_cells, "failing cells found")
        failing.append(_failing(question, goal, tests, left))
    return failing


def _failing(question: DecisionQuestion, goal: str | None, tests: Tests, most: int) -> Failing:
    query = ZoneQuery(question, goal, tests, apart=True)
    zones, complete = query.violations(most)
    return Failing(goal, tuple(query.agents), query.problem, tuple(zones), complete, query.nodes, query.limit)


NO_VOLUME = "whole numbers have no volume"


def exact_share(question: DecisionQuestion, failing: Sequence[Failing], faces: int = DEFAULT_FACES) -> ExactShare | str:
    """The exact share of the zones in the region, which is that of violating states if the zones are all.

    Or why there is none: more than `faces` faces, or a region without volume, such as one of whole numbers.
    """
    if question.region.whole:
        return NO_VOLUME
    # a budget of faces that takes as long whatever the digits of the bounds
    longest = max((one.problem.scale.bit_length() for one in failing), default=0)
    volumes = Volumes(max(1, faces * USUAL_BITS // max(USUAL_BITS, longest)))
    fixed = find_fixed_coordinates(question.region)
    try:
        whole = _whole(question, volumes, fixed)
        each = [_volumes(one, volumes, fixed) for one in failing]
        together = _together(question, failing, [own for own, _ in each], volumes, fixed)
    except FacesError:
        return f"it takes more than {volumes.budget} faces"
    if not whole:
        return "the region has no volume"
    units = [unit for _, unit in each]
    unit = lcm(whole.denominator, *units)
    zones = tuple(tuple(volume * (unit // own) for volume in volumes) for volumes, own in each)
    least, most = (sum(ends[k] * (unit // own) for ends, own in zip(together, units, strict=True)) for k in range(2))
    return ExactShare(whole.numerator * (unit // whole.denominator), zones, least, most)


def measure_union(question: DecisionQuestion, failing: Sequence[Sequence[Failing]]) -> Fraction | None:
    """The share of the region that the zones of several questions make up together, each state counted once. None
    where that takes more than MAX_MEETING common parts or too many faces, or the region has no volume.

    `question`: about all that those questions ask, so that its bounds are theirs; `found`: of each all zones, which
    have no point in common. By inclusion and exclusion: zones of one question less what they share with those before.
    """
    volumes, fixed, tests = Volumes(), find_fixed_coordinates(question.region), Tests.of(question)
    total, left = Fraction(0), MAX_MEETING
    try:
        whole = _whole(question, volumes, fixed)
        for place, goal in enumerate(question.goals):
            problem = ZoneQuery(question, goal, tests, apart=True).problem
            groups = [
                [_convert_zone(zone, one[place].problem, problem) for zone in one[place].zones] for one in failing
            ]
            counted = _meeting(problem, groups, left)
            if counted is None:
                return None
            left -= sum(map(len, counted))
            for sign, zones in zip((1, -1), counted, strict=True):
                own, unit = _volumes(Failing(goal, (), problem, tuple(zones), True, 0, 0), volumes, fixed)
                total += sign * Fraction(sum(own), unit)
    except FacesError:
        return None
    return total / whole if whole else None


def _meeting(
    problem: Problem, groups: Sequence[Sequence[Branch]], most: int
) -> tuple[list[Branch], list[Branch]] | None:
    """Lists what is to be added up for the volume of all zones together, and what is to be taken away: common parts of
    zones of an odd and an even number of groups. None for more than `most`.
    """
    odd, even = list[Branch](), list[Branch]()
    for zones in groups:
        added, removed = list(zones), list[Branch]()
        for zone in zones:
            removed += filter(None, (_common(problem, zone, other) for other in odd))
            added += filter(None, (_common(problem, zone, other) for other in even))
            if len(odd) + len(even) + len(added) + len(removed) > most:
                return None
        odd, even = odd + added, even + removed
    return odd, even


def _common(problem: Problem, zone: Branch, other: Branch) -> Branch | None:
    """The common part of two zones; None where it is empty."""
    cells, start = list(map(min, zone[1], other[1])), 0
    for size in problem.sizes:
        rows = [cells[start + i * size : start + i * size + size] for i in range(size)]
        for k, through in enumerate(rows):
            for i, row in enumerate(rows):
                gap = row[k]
                rows[i] = [min(most, gap + beyond) for most, beyond in zip(row, through, strict=True)]
            if any(rows[i][i] < 0 for i in range(size)):
                return None
        cells[start : start + size * size] = [cell for row in rows for cell in row]
        start += size * size
    return (), cells


def _convert_zone(zone: Branch, problem: Problem, other: Problem) -> Branch:
    """A zone of one problem as a zone of another, which has all its bounds."""
    finer = other.scale // problem.scale

    def most(a: str, b: str) -> int:
        cell = zone[1][problem.cell(a, b)]
        length = -(-cell // EPSILON) * EPSILON
        return length * finer - (length - cell)  # strict bounds stay as much lower

    def entry(a: str, b: str) -> int:
        if a == b:
            return 0
        return most(a, b) if problem.are_joined(a, b) else most(a, "") + most("", b)

    return zone[0], [entry(a, b) for own in other.names for a in own for b in own]


def _together(
    question: DecisionQuestion,
    failing: Sequence[Failing],
    each: Sequence[Sequence[int]],
    volumes: Volumes,
    fixed: Mapping[str, str],
) -> list[tuple[int, int]]:
    """For each goal, between which bounds the volume of its zones together lies; without errors they never overlap."""
    if not question.claim.eps:
        return [(sum(own), sum(own)) for own in each]
    bounds: list[tuple[int, int]] = []
    left = DEFAULT_PARTS
    for one, own in zip(failing, each, strict=True):
        measure = partial(_numerator, sizes=one.problem.sizes, free=_free(one, fixed), volumes=volumes)
        least, most, parts = union(one.problem, one.zones, own, fixed, measure, left)
        left -= parts
        bounds.append((least, most))
    return bounds


def exact_part(question: DecisionQuestion, part: Region, faces: int = DEFAULT_FACES) -> Fraction | None:
    """The exact share of a region that a part of it is, goals counted too; None beyond `faces` faces."""
    volumes, fixed = Volumes(faces), find_fixed_coordinates(question.region)
    try:
        inside = _whole(question.within(part), volumes, fixed)
        whole = _whole(question, volumes, fixed)
    except FacesError:
        return None
    return inside / whole if whole else None


def _whole(question: DecisionQuestion, volumes: Volumes, fixed: Mapping[str, str]) -> Fraction:
    """The volume of a region's states that meet the assumption, of all goals. FacesError for too many zones."""
    total = Fraction(0)
    # where the assumption holds: the zones in which its denial fails
    denial = OwnFormula(question.claim.team, statement=negate(question.claim.assume))
    meeting = replace(question.about(denial), semantics=MACHINE, budgets=Budgets())
    for goal in meeting.goals:
        failing = _failing(meeting, goal, Tests.of(meeting), meeting.budgets.max_cells)
        if not failing.complete:
            raise FacesError
        parts, unit = _volumes(failing, volumes, fixed)
        total += Fraction(sum(parts), unit)
    return total


def _volumes(failing: Failing, volumes: Volumes, fixed: Mapping[str, str]) -> tuple[list[int], int]:
    """The volume of each zone, in the coordinates that are not fixed, and how many of its units one is."""
    free = _free(failing, fixed)
    dimensions = [len(nodes) - 1 for nodes in free]
    unit = prod((failing.problem.scale // EPSILON) ** d * factorial(d) for d in dimensions)
    parts: list[int] = []
    for number, zone in enumerate(failing.zones):
        tell(number, len(failing.zones), "volumes of failing cells added up")
        parts.append(_numerator(zone, failing.problem.sizes, free, volumes))
    return parts, unit


def _free(failing: Failing, fixed: Mapping[str, str]) -> list[list[int]]:
    """The nodes of each component that are not fixed, with the origin."""
    free = [[0] for _ in failing.problem.sizes]
    for name, (component, node) in failing.problem.places.items():
        if name not in fixed:
            free[component].append(node)
    return free


def _numerator(zone: Branch, sizes: Sequence[int], free: Sequence[Sequence[int]], volumes: Volumes) -> int:
    total, start = 1, 0
    for size, nodes in zip(sizes, free, strict=True):
        # without strictness: units are EPSILON apart, and a path has fewer strict bounds than that
        cells = [-(-zone[1][start + i * size + j] // EPSILON) for i in nodes for j in nodes]
        total *= volumes.measure(cells, len(nodes)) if total else 0
        start += size * size
    return total


def find_fixed_coordinates(region: Region) -> dict[str, str]:
    """Coordinates that the region's box and differences set at a constant distance from another one ("" for zero)."""
    names = ["", *region.box]
    most = {(a, b): _box(region, a, "")[1] - _box(region, b, "")[0] for a in names for b in names}
    most |= {(name, name): Fraction(0) for name in names}
    for a, b, (low, high) in region.differences:
        most[a, b], most[b, a] = min(most[a, b], high), min(most[b, a], -low)
    for k in dict.fromkeys(name for a, b, _ in region.differences for name in (a, b)):  # a box alone is closed
        for a in names:
            for b in names:
                most[a, b] = min(most[a, b], most[a, k] + most[k, b])
    fixed: dict[str, str] = {}
    for place, name in enumerate(names):
        other = next((other for other in names[:place] if most[name, other] + most[other, name] <= 0), None)
        if other is not None and name:
            fixed[name] = other
    return fixed


def _box(region: Region, name: str, zero: str) -> tuple[Fraction, Fraction]:
    return (Fraction(0), Fraction(0)) if name == zero else region.box[name]
