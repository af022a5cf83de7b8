"""Curves that a formula names, such as `angle*spin`, and two formulas without them: a stronger and a weaker one.

Does: reads the parts of a formula that are not affine as expressions, each a coordinate of its own; cuts the ranges of
  what curves name into cells; encloses each curve over each cell by an affine form and an error; makes comparisons
  stronger or weaker by that error.
Assumes: the names of a statement.
Does not: trust itself: the checker shows each enclosure again (verify/checker/systems/enclosures.py).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from functools import partial
from itertools import pairwise, product
from math import prod

from codegen.errors import InputError
from verify.claims.formula import FALSE, TRUE, And, Formula, Linear, Not, Or, below, conjunction, disjunction
from verify.claims.formula import normal as pushed
from verify.language.parser import CallNode, Joined, Level, NameNode, Node, Prefixed, Source, Token
from verify.language.units import Unit
from verify.systems.claims import CurveOverCell
from verify.systems.enclosures import Enclosing
from verify.systems.language.expressions import Expression, names
from verify.systems.language.parsing import FUNCTIONS, Names, curve_of
from verify.systems.pieces import enclose_expression
from verify.systems.system import Affine, Box, Interval, Variable


@dataclass(frozen=True)
class Curves:
    """The substitutes for curves in a formula: expressions by the name of a coordinate that no file can have."""

    names: Names
    found: dict[str, Expression] = field(default_factory=dict[str, Expression])

    def is_curve(self, node: Node) -> bool:
        """Returns True if a tree is a product, quotient, power or function of what varies, which no sum is."""
        match node:
            case CallNode(token, _):
                return token.text in FUNCTIONS
            case Joined(_, Level.POWER, base, _):
                return self._varies(base)
            case Joined(_, Level.PRODUCT, first, rest):
                over = any(sign.text == "/" and self._varies(other) for sign, other in rest)
                return over or sum(map(self._varies, (first, *(other for _, other in rest)))) > 1
            case _:
                return False

    def _varies(self, node: Node) -> bool:
        match node:
            case NameNode(token):
                return token.text in self.names.known
            case Prefixed(_, _, inside):
                return self._varies(inside)
            case CallNode(_, inside):
                return any(map(self._varies, inside))
            case Joined(_, _, first, rest):
                return any(map(self._varies, (first, *(other for _, other in rest))))
            case _:
                return False

    def coordinate(self, source: Source, node: Node) -> tuple[str, Unit | None, Token | None]:
        """The name and the unit of the coordinate of a curve, and the first number in it that has a unit."""
        (expression, unit), measured = curve_of(source, node, self.names)
        known = {each: name for name, each in self.found.items()}
        name = known.get(expression, f"curve {len(known) + 1}")
        self.found[name] = expression
        return name, unit, measured


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
