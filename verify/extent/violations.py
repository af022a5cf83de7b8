"""All zones in which a claim fails, and how much of the region they are, exactly.

Does: asks the zone engine for every tuple of leaves and clause of the denied claim that some state meets, in zones that
  have no point in common; adds up their volumes.
Assumes: a claim about single decisions, over difference bounds; else BeyondZonesError.
Does not: confirm points: a zone is of real states, and one narrower than a float may hold no float64 state.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from math import factorial, prod

from verify.claims.decisions import OwnFormula
from verify.claims.formula import negated
from verify.claims.region import MACHINE, Region
from verify.progress import tell
from verify.question import Budgets, DecisionQuestion
from verify.zones.engine import Tests, ZoneQuery
from verify.zones.search import Branch
from verify.zones.tables import EPSILON, Problem
from verify.zones.volume import DEFAULT_FACES, FacesError, Volumes


@dataclass(frozen=True)
class Failing:
    """One goal's violating zones: of each the agents' leaves and the closed matrices of its components."""

    goal: str | None
    agents: tuple[str, ...]  # whose leaves a zone names, in this order
    problem: Problem
    zones: tuple[Branch, ...]
    complete: bool  # whether these are all
    nodes: int  # search nodes

    def bounds(self, zone: Branch) -> dict[tuple[str, str], tuple[Fraction, bool]]:
        """(a, b) -> (most of a - b, whether it stays below); "" stands for zero. Only within components."""
        names = [[""] * size for size in self.problem.sizes]
        for name, (component, node) in self.problem.places.items():
            names[component][node] = name
        found, start = dict[tuple[str, str], tuple[Fraction, bool]](), 0
        for own in names:
            for i, a in enumerate(own):
                for j, b in enumerate(own):
                    if i != j:
                        units = zone[1][start + i * len(own) + j]
                        length = Fraction(-(-units // EPSILON) * EPSILON, self.problem.scale)
                        found[a, b] = length, units % EPSILON != 0
            start += len(own) ** 2
        return found


@dataclass(frozen=True)
class ExactShare:
    """Volumes of the zones, of the region (of states that meet the assumption) and of each zone, summed over goals."""

    violating: Fraction
    region: Fraction
    zones: tuple[tuple[Fraction, ...], ...]  # goal by goal, in the order of the zones

    @property
    def value(self) -> Fraction:
        """The share of the region in which the claim fails, goals being equally likely."""
        return self.violating / self.region


def violations(question: DecisionQuestion) -> list[Failing]:
    """The violating zones, goal after goal, `max_cells` in all, with at most `max_nodes` search nodes a goal; of
    features without errors, whatever the claim allows.

    BeyondZonesError when the question is not about difference bounds.
    """
    found: list[Failing] = []
    plain = question.with_eps(Fraction(0))
    tests = Tests.of(plain)
    for goal in plain.goals:
        known = sum(len(one.zones) for one in found)
        left = plain.budgets.max_cells - known
        tell(known, plain.budgets.max_cells, "failing cells found")
        found.append(_failing(plain, goal, tests, left))
    return found


def _failing(question: DecisionQuestion, goal: str | None, tests: Tests, most: int) -> Failing:
    query = ZoneQuery(question, goal, tests, apart=True)
    zones, complete = query.violations(most)
    return Failing(goal, tuple(query.agents), query.problem, tuple(zones), complete, query.nodes)


def exact_share(question: DecisionQuestion, found: Sequence[Failing], faces: int = DEFAULT_FACES) -> ExactShare | str:
    """The exact share of the zones in the region, which is that of violating states if the zones are all.

    Or why there is none: more than `faces` faces, or a region without volume.
    """
    volumes, fixed = Volumes(faces), fixed_coordinates(question.region)
    try:
        whole = _whole(question, volumes, fixed)
        each = tuple(_volumes(one, volumes, fixed) for one in found)
    except FacesError:
        return f"it takes more than {faces} faces"
    if not whole:
        return "the region has no volume"
    return ExactShare(sum((volume for own in each for volume in own), Fraction(0)), whole, each)


def exact_part(question: DecisionQuestion, part: Region, faces: int = DEFAULT_FACES) -> Fraction | None:
    """The exact share of a region that a part of it is, goals counted too; None beyond `faces` faces."""
    volumes, fixed = Volumes(faces), fixed_coordinates(question.region)
    try:
        inside = _whole(question.within(part), volumes, fixed)
        whole = _whole(question, volumes, fixed)
    except FacesError:
        return None
    return inside / whole if whole else None


def _whole(question: DecisionQuestion, volumes: Volumes, fixed: Mapping[str, str]) -> Fraction:
    """The volume of a region's states that meet the assumption, summed over goals. FacesError for too many zones."""
    total = Fraction(0)
    # where the assumption holds: the zones in which its denial fails
    denial = OwnFormula(question.claim.team, statement=negated(question.claim.assume))
    meeting = replace(question.about(denial), semantics=MACHINE, budgets=Budgets())
    for goal in meeting.goals:
        found = _failing(meeting, goal, Tests.of(meeting), meeting.budgets.max_cells)
        if not found.complete:
            raise FacesError
        total += sum(_volumes(found, volumes, fixed))
    return total


def _volumes(found: Failing, volumes: Volumes, fixed: Mapping[str, str]) -> tuple[Fraction, ...]:
    """The volume of each zone, in the coordinates that are not fixed."""
    free = [[0] for _ in found.problem.sizes]
    for name, (component, node) in found.problem.places.items():
        if name not in fixed:
            free[component].append(node)
    dimensions = [len(nodes) - 1 for nodes in free]
    unit = prod((found.problem.scale // EPSILON) ** d * factorial(d) for d in dimensions)
    return tuple(Fraction(_numerator(zone, found.problem.sizes, free, volumes), unit) for zone in found.zones)


def _numerator(zone: Branch, sizes: Sequence[int], free: Sequence[Sequence[int]], volumes: Volumes) -> int:
    total, start = 1, 0
    for size, nodes in zip(sizes, free, strict=True):
        # without strictness: units are EPSILON apart, and a path has fewer strict bounds than that
        cells = [-(-zone[1][start + i * size + j] // EPSILON) for i in nodes for j in nodes]
        total *= volumes.measure(cells, len(nodes)) if total else 0
        start += size * size
    return total


def fixed_coordinates(region: Region) -> dict[str, str]:
    """Coordinates that the region's box and differences set at a constant distance from another one ("" for zero)."""
    names = ["", *region.box]
    most = {(a, b): _box(region, a, "")[1] - _box(region, b, "")[0] for a in names for b in names}
    most |= {(name, name): Fraction(0) for name in names}
    for a, b, (low, high) in region.differences:
        most[a, b], most[b, a] = min(most[a, b], high), min(most[b, a], -low)
    for k in names:
        for a in names:
            for b in names:
                most[a, b] = min(most[a, b], most[a, k] + most[k, b])
    found: dict[str, str] = {}
    for place, name in enumerate(names):
        other = next((other for other in names[:place] if most[name, other] + most[other, name] <= 0), None)
        if other is not None and name:
            found[name] = other
    return found


def _box(region: Region, name: str, zero: str) -> tuple[Fraction, Fraction]:
    return (Fraction(0), Fraction(0)) if name == zero else region.box[name]
