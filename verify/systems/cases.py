"""Cases of rules: the regions of states that conditions cut the ranges into, for each action that they speak of.

Does: says where two cases share a state, or none holds one, and what `otherwise` stands for; where conditions name what
  an action sets, cuts the ranges so that in each part an action takes one case.
Assumes: conditions as polytopes over variables, and over inputs that actions set to affine forms of these.
Does not: read texts, or say how the state moves.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from itertools import combinations, product
from typing import NamedTuple

from codegen.errors import InputError
from verify.decimals import plain
from verify.systems.expressions import affine
from verify.systems.parsing import outside
from verify.systems.statement import Agent
from verify.systems.system import Affine, Box, HalfSpace, Interval, Polytope, Variable, box_of, is_empty, narrow
from verify.toml_places import Place

OTHERWISE = "otherwise"
MAX_REGIONS = 4_096  # of all cases
NARROW = "write bounds with < on one side and >= on the other"
Conditions = Sequence[Sequence[Polytope] | None]  # of each case; None: whatever the others leave


class CaseRegion(NamedTuple):
    """States of a case: a box that bounds all that some case tests, and what the box does not say."""

    where: Box
    when: Polytope


class Part(NamedTuple):
    """States in which each action takes one case, by its number."""

    region: CaseRegion
    taken: Mapping[str, int]


def split_regions(
    whole: CaseRegion, conditions: Conditions, agent: Agent, variables: Sequence[Variable], where: Place
) -> list[Part]:
    """The parts of a region in which each action of an agent takes one case. InputError as of `case_regions`, for each
    action, and where an action sets what is not affine.
    """
    parts = [Part(whole, {})]
    known: dict[tuple[object, ...], list[list[CaseRegion]]] = {}
    for action, settings in agent.actions.items():
        forms = {name: affine(setting) for name, setting in settings.items()}
        own = tuple(
            None if each is None else tuple(_set_inputs(region, forms, where) for region in each) for each in conditions
        )
        if own not in known:
            known[own] = case_regions(own, variables, where, some=False)
        found: list[Part] = []
        for part, (number, regions) in product(parts, enumerate(known[own])):
            for region in regions:
                halves = [half for box, when in (part.region, region) for half in (*box_of(box), *when)]
                if not is_empty(tuple(halves)):
                    named = {name for half in halves for name, _ in half.form.terms}
                    both = _region(tuple(halves), {each.name: each.range for each in variables if each.name in named})
                    found.append(Part(both, {**part.taken, action: number}))
        parts = found
        if len(parts) > MAX_REGIONS:
            raise InputError(f"more than {MAX_REGIONS} cases", where, "test less")
    return parts


def _set_inputs(region: Polytope, forms: Mapping[str, Affine | None], where: Place) -> Polytope:
    """A polytope of states, for what an action sets."""
    halves: list[HalfSpace] = []
    for half in region:
        form = Affine((), half.form.constant)
        for name, factor in half.form.terms:
            setting = forms.get(name, Affine(((name, Fraction(1)),)))
            if setting is None:
                raise InputError(f"{name} is set to what is not affine", where, "set it to sums of variables")
            form = form.plus(setting, factor)
        halves.append(HalfSpace(form, half.strict))
    return tuple(halves)


def case_regions(
    conditions: Conditions, variables: Sequence[Variable], where: Place, some: bool = True
) -> list[list[CaseRegion]]:
    """The regions of each case. InputError where cases overlap or leave a gap, or one holds no state; not `some`: may
    hold none.
    """
    named = {name for each in conditions for region in each or () for half in region for name, _ in half.form.terms}
    tested = [one for one in variables if one.name in named]
    ranges = {one.name: one.range for one in tested}
    modes = {one.name: len(one.modes) for one in tested if one.modes}
    regions = [[_tight(each, modes) for each in given or ()] for given in conditions]
    last = next((number for number, given in enumerate(conditions) if given is None), None)
    others: list[Polytope] = []
    met: list[set[Polytope]] = [set() for _ in regions]  # of each case the polytopes that hold some state
    for values in product(*map(range, modes.values())):
        fixed = dict(zip(modes, map(Fraction, values), strict=True))
        whole = _with(box_of(ranges), fixed)
        held: list[list[Polytope]] = []  # of each case its polytopes that have a state with these modes
        for seen, given in zip(met, regions, strict=True):
            kept = {each: _with(each, fixed) for each in given}
            kept = {each: part for each, part in kept.items() if not is_empty((*part, *whole))}
            seen.update(kept)
            held.append(list(kept.values()))
        for (i, one), (j, other) in combinations(enumerate(held), 2):
            if any(is_empty((*a, *b)) is not True for a, b in product(one, other)):
                raise InputError(f"cases {i + 1} and {j + 1} overlap", where / j, NARROW)
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
        if some and not given:
            raise InputError(f"case {number + 1} holds no state of the ranges", where / number, "remove it")
    return [[_region(each, ranges) for each in given] for given in regions]


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
