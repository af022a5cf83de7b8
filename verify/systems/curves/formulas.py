"""A formula with curves, by two without: one that it follows from, and one that follows from it.

Does: cuts the ranges of what curves name into cells; encloses each curve over each cell by an affine form and an error;
  makes comparisons stronger or weaker by that error.
Assumes: a formula over variables and the coordinates of curves (reading.py).
Does not: trust itself: the checker shows each enclosure again (verify/checker/systems/enclosures.py).

Within a cell a curve q lies in form + [low, high]. A comparison `sum + u q <= end` holds there if it does with the
larger of u low and u high for the error, and only if it does with the smaller. In a formula whose negations were pushed
to its comparisons, all of these count alike, so the formula becomes stronger or weaker as a whole. Comparisons whose
sides cannot meet in a cell are true or false there.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from functools import partial
from itertools import pairwise, product
from math import prod

from codegen.errors import InputError
from verify.claims.formula import FALSE, TRUE, And, Formula, Linear, Not, Or, below, conjunction, disjunction
from verify.claims.formula import normal as pushed
from verify.systems.claims import CurveOverCell
from verify.systems.enclosures import Enclosing
from verify.systems.language.expressions import Expression, names
from verify.systems.pieces import enclose_expression
from verify.systems.system import Affine, Box, Interval, Variable

MAX_CELLS = 4_096
CELLS, PARTS = 400, 40  # at most about so many, where a file does not say into how many parts ranges are cut


def without_curves(
    formula: Formula,
    curves: Mapping[str, Expression],
    variables: Sequence[Variable],
    cuts: Mapping[str, int],
    where: object,
) -> tuple[Formula, Formula, tuple[CurveOverCell, ...]]:
    """A formula that implies this one in all states of the ranges, one that it implies there, and the enclosures that
    say so. InputError with `where` for too many cells, and for a curve that is not defined everywhere.
    """
    named = sorted(frozenset[str]().union(*map(names, curves.values())))
    ranges = {one.name: one.range for one in variables}
    usual = min(max(2, round(CELLS ** (1 / max(len(named), 1)))), PARTS)
    counts = [cuts.get(name, usual) for name in named]
    if prod(counts) > MAX_CELLS:
        raise InputError(f"{prod(counts):,} cells, of at most {MAX_CELLS:,}", where, "cut ranges into fewer parts")
    stated = pushed(formula)
    by_cell: dict[tuple[str, tuple[Interval, ...]], CurveOverCell] = {}
    both: tuple[list[Formula], list[Formula]] = ([], [])
    for sides in product(*(_parts(ranges[name], count) for name, count in zip(named, counts, strict=True))):
        cell = dict(zip(named, sides, strict=True))
        over = Enclosing(cell)
        known: dict[str, CurveOverCell] = {}
        for name, expression in curves.items():
            own = {each: cell[each] for each in named if each in names(expression)}
            key = name, tuple(own.values())
            if key not in by_cell:
                by_cell[key] = CurveOverCell(expression, own, *enclose_expression(expression, over, where))
            known[name] = by_cell[key]
        box = {**ranges, **cell}
        for parts, stronger in zip(both, (True, False), strict=True):
            held = with_comparisons(stated, partial(_rewrite_comparison, known=known, stronger=stronger, box=box))
            parts.append(disjunction(beyond(cell), held))
    return conjunction(*both[0]), conjunction(*both[1]), tuple(by_cell.values())


def _parts(bounds: Interval, count: int) -> list[Interval]:
    low, high = bounds
    return list(pairwise(low + (high - low) * k / count for k in range(count + 1)))


def beyond(cell: Box) -> Formula:
    """That a state lies outside a cell."""
    sides = [(name, low, high) for name, (low, high) in cell.items()]
    return disjunction(
        *(below({name: 1}, low, strict=True) for name, low, _ in sides),
        *(below({name: -1}, -high, strict=True) for name, _, high in sides),
    )


def with_comparisons(formula: Formula, change: Callable[[Linear], Formula]) -> Formula:
    """A formula whose negations stand before actions alone, with something else in place of each comparison."""
    match formula:
        case Linear():
            return change(formula)
        case And(parts):
            return conjunction(*(with_comparisons(part, change) for part in parts))
        case Or(parts):
            return disjunction(*(with_comparisons(part, change) for part in parts))
        case Not(part):
            assert not isinstance(part, Linear)
            return formula
        case _:
            return formula


def _rewrite_comparison(atom: Linear, known: Mapping[str, CurveOverCell], stronger: bool, box: Box) -> Formula:
    """A comparison in a cell; true or false where the ranges of its variables say so."""
    total, off = Affine.of({}, -atom.bound), Fraction(0)
    for weight, name in atom.terms:
        if name not in known:
            total = total.plus(Affine.of({name: Fraction(1)}), weight)
            continue
        curve = known[name]
        total = total.plus(curve.form, weight)
        ends = [weight * end for end in curve.error]
        off += max(ends) if stronger else min(ends)
    total = total.plus(Affine.of({}, off))
    least = most = total.constant
    for name, factor in total.terms:
        ends = [factor * end for end in box[name]]
        least, most = least + min(ends), most + max(ends)
    if most < 0 or (most == 0 and not atom.strict):
        return TRUE
    if least > 0 or (least == 0 and atom.strict):
        return FALSE
    return below(dict(total.terms), -total.constant, atom.strict)
