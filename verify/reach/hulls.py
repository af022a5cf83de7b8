"""Hulls of many symbolic states: polytopes that hold them, with short numbers.

Does: groups symbolic states that decide alike; bounds each group in the directions that tests, claims and steps make.
Assumes: bounds found by linear programs are proposals, so they are widened; the checker asks whether they hold.
Does not: say whether a claim holds of the hulls, which hold more states than there are.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from fractions import Fraction
from math import ceil, floor, frexp
from typing import NamedTuple

from codegen.numbers import nearest_double
from verify.checker.systems.proofs import Hull
from verify.checker.systems.rows import Branch, Row, Terms
from verify.checker.systems.trees import Choices, Decision, Split
from verify.checker.systems.walk import SystemQuestions
from verify.claims.formula import Linear, atoms
from verify.reach.programs import Programs, find_related
from verify.systems.system import Affine, HalfSpace, Piece

FINENESS = 12  # bits of a hull's width in which its bounds are given
SHORT = 32  # bits of a number that stays as it is
LEAST = 2.0**-16  # width by which what programs know nearly is widened
NEAR = Fraction(1, 10**9)
PULLED = 2  # steps over which directions are followed back
MAX_EACH = 4  # directions for each variable


class Extent(NamedTuple):
    """Between which numbers a direction lies, and whether these are exact: a program knows them nearly only."""

    low: Fraction
    high: Fraction
    exact: bool


class Hulls:
    """Hulls of symbolic states of one search."""

    def __init__(self, search: SystemQuestions, programs: Programs) -> None:
        self._search, self._programs = search, programs
        self._directions = _directions(search)
        self._stated: dict[str, list[Fraction]] = {}  # bounds of a variable by boxes of pieces
        for piece in search.system.pieces:
            for name, bounds in piece.where.items():
                self._stated.setdefault(name, []).extend(bounds)

    def group_branches(self, branches: Sequence[Branch], parts: int) -> list[list[int]]:
        """The numbers of branches that one hull is to hold: those that decide alike, each such group in `parts`."""
        cells: dict[object, list[int]] = {}
        centers = [self._center(branch) for branch in branches]
        for number, center in enumerate(centers):
            cells.setdefault(self._cell(center), []).append(number)
        return [group for cell in cells.values() for group in _split(cell, centers, parts)]

    def hull(self, branches: Sequence[Branch]) -> Hull:
        """A polytope that holds some branches of one step."""
        halves: list[HalfSpace] = []
        for terms in self._directions:
            extents = [self._extent(branch, terms) for branch in branches]
            low, high = min(each.low for each in extents), max(each.high for each in extents)
            form = Affine.of({name: weight for weight, name in terms})
            low, high = self._bounds(form, low, high, all(each.exact for each in extents))
            halves += [
                HalfSpace(Affine.of({name: -weight for name, weight in form.terms}, low)),
                HalfSpace(Affine.of(dict(form.terms), -high)),
            ]
        return Hull(branches[0].step, tuple(halves))

    def _bounds(self, form: Affine, low: Fraction, high: Fraction, exact: bool) -> tuple[Fraction, Fraction]:
        """Short bounds of a direction: as they are, or where the system has a bound, or a little outside."""
        wide = _widen_bounds(low, high) if low < high or not exact else (low, high)
        stated = self._stated.get(form.terms[0][0], ()) if len(form.terms) == 1 else ()
        below = [each for each in stated if wide[0] < each <= low + NEAR]
        above = [each for each in stated if high - NEAR <= each < wide[1]]
        return (
            low if exact and _is_short(low) else max(below, default=wide[0]),
            high if exact and _is_short(high) else min(above, default=wide[1]),
        )

    def _extent(self, branch: Branch, terms: Terms) -> Extent:
        reading = self._search.reading
        direction, scale = reading.direction(branch.motion, reading.sum(terms))
        constant = sum((weight * branch.at[name] for weight, name in terms), Fraction(0))
        if direction is None:
            return Extent(constant, constant, True)
        if not find_related(branch, direction):
            span = branch.span(direction)
            ends = scale * span.low, scale * span.high
            return Extent(constant + min(ends), constant + max(ends), True)
        least = self._programs.least(branch, Row(direction, True, Fraction(0), False)).value
        most = -self._programs.least(branch, Row(direction, False, Fraction(0), False)).value
        factor = scale * (1 << direction.bits)
        ends = factor * Fraction(least), factor * Fraction(most)
        return Extent(constant + min(ends), constant + max(ends), False)

    def _center(self, branch: Branch) -> dict[str, Fraction]:
        center: dict[str, Fraction] = {}
        for name in self._search.reading.order:
            low, high, _ = self._extent(branch, ((Fraction(1), name),))
            center[name] = (low + high) / 2
        return center

    def _cell(self, state: dict[str, Fraction]) -> object:
        """Returns what is decided in a state, its modes, and the pieces that may move it."""
        effects = [_at(decision, state) for decision in self._search.decisions]
        pieces = [number for number, piece in enumerate(self._search.system.pieces) if _holds(piece, state)]
        modes = [state[one.name] for one in self._search.system.variables if one.modes and one.name in state]
        return (*effects, *modes, *pieces)


def _at(decision: Decision, state: dict[str, Fraction]) -> Choices:
    """The effects of which each may be chosen in a state."""
    while isinstance(decision, Split):
        asked = decision.left_if
        total = sum((weight * state[name] for weight, name in asked.sum.terms), Fraction(0))
        left = total < asked.most or (total == asked.most and not asked.strict)
        decision = decision.left if left else decision.right
    return decision


def _holds(piece: Piece, state: dict[str, Fraction]) -> bool:
    known = [half for half in piece.when if all(name in state for name, _ in half.form.terms)]
    inside = all(low <= state[name] <= high for name, (low, high) in piece.where.items() if name in state)
    return inside and all(half.holds(state) for half in known)


def _split(group: list[int], centers: Sequence[dict[str, Fraction]], parts: int) -> list[list[int]]:
    """A group in parts of equal size, along the variable that varies most."""
    if parts <= 1 or len(group) <= 1:
        return [group]

    def varies(name: str) -> Fraction:
        values = [centers[number][name] for number in group]
        return max(values) - min(values)

    along = max(centers[group[0]], key=varies)
    ordered, half = sorted(group, key=lambda number: centers[number][along]), len(group) // 2
    return _split(ordered[:half], centers, parts // 2) + _split(ordered[half:], centers, parts // 2)


def _is_short(number: Fraction) -> bool:
    return number.denominator.bit_length() + number.numerator.bit_length() <= SHORT


def _widen_bounds(low: Fraction, high: Fraction) -> tuple[Fraction, Fraction]:
    """Bounds a little outside, as multiples of a power of two."""
    grid = Fraction(2) ** (frexp(max(nearest_double(high - low), LEAST))[1] - FINENESS)
    return floor(low / grid - Fraction(1, 8)) * grid, ceil(high / grid + Fraction(1, 8)) * grid


def _directions(search: SystemQuestions) -> list[Terms]:
    """Each variable alone, then the sums of tests and of the claim, then what these were some steps before."""
    reading, system = search.reading, search.system
    known = [feature.form for features in system.features.values() for feature in features.values()]
    known += [
        Affine.of({name: w for w, name in one.terms}) for one in atoms(search.claim.inside) if isinstance(one, Linear)
    ]
    sums = [form for form in known if len(form.terms) > 1 and all(name in reading.order for name, _ in form.terms)]
    directions = {_primitive(Affine.of({name: Fraction(1)})): None for name in reading.order}
    directions |= {_primitive(form): None for form in sums}
    level = list(directions)
    for _ in range(PULLED):
        level = [_primitive(pulled) for terms in level for pulled in _before(terms, system.pieces) if pulled.terms]
        for terms in level:
            if len(directions) < MAX_EACH * len(reading.order):
                directions[terms] = None
    return list(directions)


def _before(terms: Terms, pieces: Iterable[Piece]) -> list[Affine]:
    """Returns what a sum is made of before a step, by each piece."""
    forms: list[Affine] = []
    for piece in pieces:
        total = Affine()
        for weight, name in terms:
            total = total.plus(piece.move.get(name, Affine()), weight)
        forms.append(total)
    return forms


def _primitive(form: Affine) -> Terms:
    """The sum without its constant, its first weight 1."""
    lead = form.terms[0][1]
    return tuple((factor / lead, name) for name, factor in form.terms)
