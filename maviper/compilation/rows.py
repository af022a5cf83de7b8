"""Sums that regions bound, as columns of boxes: after the variables of a state come its raised sums.

Does: which sums regions name, with whole factors; narrows boxes to half spaces; leaves out bounds that say nothing.
Assumes: regions of half spaces, as files state them.
Does not: know proofs, or add floats itself (codegen/lowering/model.py raises sums by more than rounding can hide).
"""

from collections.abc import Iterable, Mapping, Sequence
from fractions import Fraction
from itertools import chain
from math import gcd, lcm

import numpy as np

from codegen.errors import InputError
from codegen.ir import Float64
from codegen.lowering.covering import Boxes
from codegen.lowering.model import RaisedSum
from verify.checker.covers.cuts import end_of
from verify.systems.statement import Statement
from verify.systems.system import HalfSpace, Polytope

LARGEST_FACTOR = 1 << 500  # of a sum, so that its products overflow for no likely number
Terms = tuple[tuple[str, int], ...]  # of a sum: variables, and whole factors without a common divisor
Columns = Mapping[Terms, int]  # of boxes: of each variable, and of each sum
Parts = tuple[Boxes, ...]


def list_columns(statement: Statement, regions: Iterable[Polytope]) -> Columns:
    """The columns of boxes: all variables, then the sums."""
    variables: list[Terms] = [((one.name, 1),) for one in statement.system.variables]
    return {terms: at for at, terms in enumerate([*variables, *_list_sums(regions)])}


def ensure_wide(regions: Iterable[Polytope], where: str) -> None:
    """InputError for a region that is flat along a sum of variables, or that weighs them by far too unlike factors."""
    for region in regions:
        bounds = dict[Terms, Fraction]()
        for terms, bound in map(_scale, region):
            bounds[terms] = min(bound, bounds.get(terms, bound))
            opposite = tuple((name, -factor) for name, factor in terms)
            named = f"a condition of the regions compares {' and '.join(name for name, _ in terms)}"
            if len(terms) > 1 and bound + bounds.get(opposite, 1 - bound) <= 0:
                what = f"{named} with one number, and rounding hides whether a sum is that"
                raise InputError(what, where, "state a region that has some width")
            if any(abs(factor) > LARGEST_FACTOR for _, factor in terms):
                raise InputError(f"{named} by factors that are too unlike", where, "state them in other units")


def narrow(columns: Columns, region: Polytope, low: Float64, high: Float64) -> None:
    """Narrows bounds, [columns] or [columns, n], to half spaces; rounded inward."""
    for half in region:
        terms, bound = _scale(half)
        last = end_of(bound, half.strict).last
        if not terms and last < 0.0:  # 0 is not within the bound: no state is
            low[...], high[...] = np.inf, -np.inf
        elif terms in columns:
            high[columns[terms]] = np.minimum(high[columns[terms]], last)
        elif terms:  # minus one variable
            at = columns[((terms[0][0], 1),)]
            low[at] = np.maximum(low[at], -last)


def widen(boxes: Boxes, columns: Columns) -> Boxes:
    """Boxes with columns for sums, which they do not bound."""
    more = (0, 0), (0, len(columns) - boxes.low.shape[1])
    return Boxes(np.pad(boxes.low, more, constant_values=-np.inf), np.pad(boxes.high, more, constant_values=np.inf))


def keep_sums(
    regions: Iterable[Polytope], names: Sequence[str], steps: Sequence[Parts]
) -> tuple[tuple[Parts, ...], tuple[RaisedSum, ...]]:
    """The boxes of the one list of a claim, without sums that are within their bounds all over a part; and the sums
    that are left. `names`: of the variables. InputError for sums of others.
    """
    columns = {name: at for at, name in enumerate(names)}
    listed = _list_sums(regions)
    if missing := [name for one in listed for name, _ in one if name not in columns]:
        what = f"a region compares {missing[0]} with other variables, and it is a rounding, which no state has"
        raise InputError(what, "--certificate", "leave it out of the regions; then verify again")
    sums = [RaisedSum(tuple((columns[name], float(factor)) for name, factor in one)) for one in listed]
    kept, parts = set[int](), list[Boxes]()
    for part in chain.from_iterable(steps):
        high = part.high.copy()
        for at, each in enumerate(sums, start=len(names)):
            corners = part.low[:, : len(names)].copy()  # in which the sum is largest
            for column, factor in each.terms:
                corners[:, column] = (part.high if factor > 0 else part.low)[:, column]
            if ((each.of(corners) <= high[:, at]) | (high[:, at] == np.inf)).all():
                high[:, at] = np.inf
            else:
                kept.add(at)
        parts.append(Boxes(part.low, high))
    left = [*range(len(names)), *sorted(kept)]
    narrowed = tuple(Boxes(part.low[:, left], part.high[:, left]) for part in parts)
    return (narrowed,), tuple(sums[at - len(names)] for at in sorted(kept))


def _list_sums(regions: Iterable[Polytope]) -> list[Terms]:
    """The sums of several variables that regions bound."""
    halves = chain.from_iterable(regions)
    return list(dict.fromkeys(terms for half in halves if len(terms := _scale(half)[0]) > 1))


def _scale(half: HalfSpace) -> tuple[Terms, Fraction]:
    """A half space as a sum with whole factors, and its bound."""
    terms, whole = half.form.terms, lcm(*(factor.denominator for _, factor in half.form.terms))
    scale = Fraction(whole, gcd(*(int(whole * factor) for _, factor in terms)) or 1)
    return tuple((name, int(scale * factor)) for name, factor in terms), -scale * half.form.constant
