"""Claims over observations: a number in a formula is what an agent compares, and a region what was seen of it.

Does: reads an inequality over one observed number as a test of the agent that observes it; finds regions by name.
Assumes: a view, whose variables are features.
Does not: touch sums of several numbers, or variables that agents observe in unlike types.

A claim says x < 0 of the float32 that an agent compares. Read of the float64 number before it is rounded, the claim
would fail at -1e-46, which the agent sees as 0; read as a test, both mean the same numbers.
"""

from collections.abc import Callable, Mapping
from dataclasses import replace
from fractions import Fraction
from math import inf

from codegen.errors import InputError
from codegen.ir import FeatureSpec, Meaning, PolicyProfile
from codegen.numbers.rounding import nearest_double, neighbour
from maviper.files.regions import find_region
from verify.checker.thresholds import sides
from verify.claims.formula import And, Formula, Linear, Not, Or, conjunction, disjunction
from verify.claims.region import Region
from verify.claims.uncertified.starts import START
from verify.claims.uncertified.views import RANGES, SEEN, UNLIKE, Viewed, build_seen_region, find_numbers

Observed = Mapping[str, tuple[FeatureSpec, str]]  # variable -> a feature that is it, and what its agents compare


def as_compared(view: PolicyProfile, semantics: str) -> Callable[[Formula], Formula]:
    """What reads formulas about a view so."""
    numbers = find_numbers(view)
    known = {
        variable: (replace(feature, meaning=Meaning(((1.0, variable),))), numbers[variable])
        for policy in view.agents
        for feature in policy.features
        for _, variable in (feature.meaning.terms if feature.meaning is not None else ())
        if numbers[variable] != UNLIKE
    }
    return lambda formula: _read(formula, known, semantics)


def _read(formula: Formula, known: Observed, semantics: str) -> Formula:
    match formula:
        case And(parts):
            return conjunction(*(_read(part, known, semantics) for part in parts))
        case Or(parts):
            return disjunction(*(_read(part, known, semantics) for part in parts))
        case Not(part):
            return Not(_read(part, known, semantics))
        case Linear(((weight, name),), bound, strict) if name in known:
            feature, numbers = known[name]
            # up to an end, or the opposite of what is below it
            last = last_of(bound / weight, numbers, below=strict == (weight > 0))
            return sides(feature, last, numbers, semantics)[0 if weight > 0 else 1]
        case _:
            return formula


def last_of(end: Fraction, numbers: str, below: bool) -> float:
    """The largest of the `numbers` that is at most `end`, or, where `below`, that is below it."""
    near = neighbour(neighbour(nearest_double(end), inf, numbers), inf, numbers)
    while Fraction(float(near)) > end or (below and Fraction(float(near)) == end):
        near = neighbour(near, -inf, numbers)
    return float(near)


def resolve_region(about: PolicyProfile, viewed: Viewed | None, name: str) -> Region:
    """The region of that name, or in that file. Over observations `start` is what was seen, where somebody looked, and
    `ranges` what the features' ranges are.
    """
    if viewed is None or name not in (START, SEEN, RANGES):
        return find_region(name, about)
    known = build_seen_region(viewed)
    if known is None and name == SEEN:
        raise InputError("the profile does not say what was seen", "--region seen", "leave it out")
    if known is None:
        return find_region(START, about)
    return known if name != RANGES else replace(find_region(START, about), name=RANGES)
