"""Cases of a rule by their conditions: the box and the further conditions of each, complete and without overlap.

Does: cuts conditions by the ranges of what they test; says where two cases share a state, or none holds one; what
  `otherwise` stands for.
Assumes: the ranges of all variables.
Does not: read texts, or know what cases say (motion.py).

What is left of the ranges once cases are taken away is a list of polytopes, found with each mode at one value.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction
from itertools import combinations, product
from typing import NamedTuple

from codegen.errors import InputError
from verify.decimals import plain
from verify.systems.language.conditions import outside
from verify.systems.regions import box_of, is_empty, narrow
from verify.systems.system import Affine, Box, HalfSpace, Interval, Polytope, Variable
from verify.toml_places import Place

OTHERWISE = "otherwise"
MAX_REGIONS = 4_096  # of all cases
NARROW = "write bounds with < on one side and >= on the other"


class CaseRegion(NamedTuple):
    """States of a case: a box that bounds all that some case tests, and what the box does not say."""

    where: Box
    when: Polytope


def case_regions(
    conditions: Sequence[Sequence[Polytope] | None], variables: Sequence[Variable], where: Place
) -> list[list[CaseRegion]]:
    """The regions of each case; None: whatever the others leave. InputError where cases overlap or leave a gap."""
    named = {name for each in conditions for region in each or () for half in region for name, _ in half.form.terms}
    tested = [one for one in variables if one.name in named]
    ranges = {one.name: one.range for one in tested}
    modes = {one.name: len(one.modes) for one in tested if one.modes}
    regions = [[_tight(each, modes) for each in given or ()] for given in conditions]
    last = next((number for number, given in enumerate(conditions) if given is None), None)
    others: list[Polytope] = []
    met: list[set[Polytope]] = [set() for _ in regions]  # of each case the polytopes that hold some state
    for fixed in _combinations(modes):
        whole = _with(box_of(ranges), fixed)
        kept = [{each: _restrict_region(each, fixed, whole) for each in given} for given in regions]
        held = [[part for part in given.values() if part is not None] for given in kept]
        for seen, given in zip(met, kept, strict=True):
            seen |= {each for each, part in given.items() if part is not None}
        _ensure_apart(held, where)
        for left in _subtract_regions(whole, [each for given in held for each in given]):
            if last is None:
                what = f"cases leave a gap: {_states(left, ranges, fixed, variables)}"
                raise InputError(what, where, f'add a case, or one with when = "{OTHERWISE}"')
            others.append((*left, *box_of({name: (value, value) for name, value in fixed.items()})))
            if len(others) > MAX_REGIONS:
                raise InputError(f"more than {MAX_REGIONS} cases", where, "test less")
    regions = [[each for each in given if each in seen] for given, seen in zip(regions, met, strict=True)]
    if last is not None:
        regions[last] = others
    for number, given in enumerate(regions):
        if not given:
            raise InputError(f"case {number + 1} holds no state of the ranges", where / number, "remove it")
    return [[_region(each, ranges) for each in given] for given in regions]


def _combinations(modes: Mapping[str, int]) -> Iterator[dict[str, Fraction]]:
    for values in product(*(range(count) for count in modes.values())):
        yield dict(zip(modes, map(Fraction, values), strict=True))


def _tight(region: Polytope, modes: Mapping[str, int]) -> Polytope:
    """A polytope whose bounds of single modes are whole numbers."""
    halves: list[HalfSpace] = []
    for half in region:
        match half.form.terms:
            case ((name, factor),) if name in modes:
                end = -half.form.constant / factor
                whole = Fraction(end.__floor__() if factor > 0 else end.__ceil__())
                if half.strict and whole == end:
                    whole += -1 if factor > 0 else 1
                sign = Fraction(1 if factor > 0 else -1)
                halves.append(HalfSpace(Affine.of({name: sign}, -sign * whole)))
            case _:
                halves.append(half)
    return tuple(halves)


def _with(region: Polytope, fixed: Mapping[str, Fraction]) -> Polytope:
    """A polytope with modes at values, in the other variables."""
    halves: list[HalfSpace] = []
    for half in region:
        terms = {name: factor for name, factor in half.form.terms if name not in fixed}
        added = sum((factor * fixed[name] for name, factor in half.form.terms if name in fixed), Fraction(0))
        halves.append(HalfSpace(Affine.of(terms, half.form.constant + added), half.strict))
    return tuple(half for half in dict.fromkeys(halves) if half.form.terms or not half.holds({}))


def _restrict_region(region: Polytope, fixed: Mapping[str, Fraction], whole: Polytope) -> Polytope | None:
    """A region with modes at values; None where it has no state then."""
    restricted = _with(region, fixed)
    return None if is_empty((*restricted, *whole)) else restricted


def _ensure_apart(held: Sequence[Sequence[Polytope]], where: Place) -> None:
    for (i, one), (j, other) in combinations(enumerate(held), 2):
        if any(is_empty((*a, *b)) is not True for a, b in product(one, other)):
            raise InputError(f"cases {i + 1} and {j + 1} overlap", where / j, NARROW)


def _subtract_regions(whole: Polytope, held: Sequence[Polytope]) -> list[Polytope]:
    """Polytopes that hold what is in none of some regions."""
    open_ = [whole]
    for region in held:
        parts: list[Polytope] = []
        for each in open_:
            for number, half in enumerate(region):
                ((opposite,),) = outside([(half,)])
                part = (*each, *region[:number], opposite)
                if not is_empty(part):
                    parts.append(tuple(dict.fromkeys(part)))
        open_ = parts
    return open_


def _region(region: Polytope, ranges: Mapping[str, Interval]) -> CaseRegion:
    """A polytope as a box and the rest."""
    box, rest = dict(ranges), list[HalfSpace]()
    for half in region:
        if len(half.form.terms) == 1:
            ((name, factor),) = half.form.terms
            inner = narrow(box[name], factor, -half.form.constant / factor)
            box[name] = inner if inner[0] <= inner[1] else box[name]
            if half.strict or inner[0] > inner[1]:
                rest.append(half)
        else:
            rest.append(half)
    return CaseRegion(box, tuple(dict.fromkeys(rest)))


def _states(
    region: Polytope, ranges: Mapping[str, Interval], fixed: Mapping[str, Fraction], variables: Sequence[Variable]
) -> str:
    """States in words."""
    names = {one.name: one.modes for one in variables}
    told = [f"{name} = {names[name][int(value)]}" for name, value in fixed.items()]
    box = _region(region, ranges).where
    told += [f"{name} in [{plain(low)}, {plain(high)}]" for name, (low, high) in box.items() if name not in fixed]
    return ", ".join(told)
