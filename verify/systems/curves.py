"""Formulas that name curves, such as `angle*spin`, or next values, such as `x' <= 2`, by formulas that name neither.

Does: reads the parts of a formula that are not affine as expressions, each a coordinate of its own, and encloses each
  over cells of the ranges; puts the rule of each piece, under each joint action, in the place of next values, with the
  worst and the best of its error.
Assumes: the names of a statement; pieces of a checked system, which say what holds of every step.
Does not: trust itself: the checker shows each enclosure again (verify/checker/systems/enclosures.py). It decides
  nothing.

A claim about a next value is one about all errors, all choices and all pieces that hold a state. A formula that holds
with the worst error of each comparison is true of all of them. Where rules are as they are written, one that holds at
the ends of all errors is implied by it; where they are enclosures, one with the best error of each comparison is.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from functools import partial
from itertools import product
from math import prod

from codegen.errors import InputError
from codegen.ir import AgentPolicy
from verify.claims.formula import (
    FALSE,
    TRUE,
    Acts,
    And,
    Formula,
    Linear,
    Not,
    Or,
    atoms,
    below,
    conjunction,
    disjunction,
    negate,
)
from verify.claims.formula import normal as pushed
from verify.language.parser import PRIME, CallNode, Joined, Level, NameNode, Node, Prefixed, Source, Token
from verify.language.units import Unit
from verify.systems.claims import CurveOverCell, atom
from verify.systems.enclosures import Enclosing, enclose_expression, split_interval
from verify.systems.expressions import Expression, names
from verify.systems.parsing import FUNCTIONS, Names, curve_of
from verify.systems.system import Affine, Box, HalfSpace, Interval, Piece, Variable


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
    for sides in product(*map(split_interval, (ranges[name] for name in named), counts)):
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
            held = with_comparisons(stated, partial(_put_forms, known=known, stronger=stronger, box=box))
            parts.append(disjunction(beyond(cell), held))
    return conjunction(*both[0]), conjunction(*both[1]), tuple(by_cell.values())


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


def _put_forms(atom: Linear, known: Mapping[str, CurveOverCell], stronger: bool, box: Box) -> Formula:
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


MAX_PARTS = 20_000  # of a formula: pieces times joint actions
MAX_ENDS = 4  # variables whose errors are taken to both ends
Worst = Callable[[Iterable[Fraction]], Fraction]  # of what errors add to a comparison
Action = Mapping[str, str]  # what each agent that matters does


def name_next_values(variables: Sequence[Variable]) -> dict[str, str]:
    """The names of next values, and whose they are. A mode has none: it is no number."""
    return {one.name + PRIME: one.name for one in variables if not one.modes}


def without_next(
    formula: Formula,
    pieces: Sequence[Piece],
    following: Mapping[str, str],
    acting: Mapping[str, AgentPolicy],
    exact: bool,
    where: object,
) -> tuple[Formula, Formula]:
    """A formula without next values that implies this one, and one that it implies. `exact`: pieces are the rules as
    they are written. InputError with `where` for too many pieces and actions.
    """
    stated = pushed(formula)
    terms = [name for part in atoms(stated) if isinstance(part, Linear) for _, name in part.terms]
    named = sorted({following[name] for name in terms if name in following})
    effects = [each for piece in pieces for each in piece.effect.items()]
    movers = {agent for (agent, _), forms in effects if forms.keys() & {*named}}
    moving = [agent for agent in acting if agent in movers]
    parts = len(pieces) * prod(len(acting[agent].actions) for agent in moving)
    if parts > MAX_PARTS:
        advice = "name fewer next values, or state the claim about fewer agents"
        raise InputError(f"{parts:,} pieces and joint actions, of at most {MAX_PARTS:,}", where, advice)
    numbers = {agent: {each.name: n for n, each in enumerate(acting[agent].actions)} for agent in moving}
    both: tuple[list[Formula], list[Formula]] = ([], [])
    for piece in pieces:
        elsewhere = _beyond(piece)
        for chosen in product(*(numbers[agent] for agent in moving)):
            actions = dict(zip(moving, chosen, strict=True))  # what each agent that matters does
            done = [negate(Acts(agent, numbers[agent][name])) for agent, name in actions.items()]
            after = {name + PRIME: piece.total(name, actions.items()) for name in named}
            errors = {name + PRIME: piece.error[name] for name in named if name in piece.error}
            surely = _put(stated, after, errors, max)
            maybe = conjunction(*_iterate_implied(stated, after, errors, exact))
            for formulas, held in zip(both, (surely, maybe), strict=True):
                formulas.append(disjunction(elsewhere, *done, held))
    return conjunction(*both[0]), conjunction(*both[1])


def _beyond(piece: Piece) -> Formula:
    """That a state is none of a piece."""
    return disjunction(beyond(piece.where), *(negate(atom(half)) for half in piece.when))


def _iterate_implied(
    formula: Formula, after: Mapping[str, Affine], errors: Mapping[str, Interval], exact: bool
) -> Iterator[Formula]:
    """Yields what a formula implies in a piece: itself at the ends of all errors; for enclosures, with the best."""
    if not exact:
        yield _put(formula, after, errors, min)
        return
    ends = [[(name, end) for end in dict.fromkeys(bounds)] for name, bounds in errors.items()]
    for chosen in product(*ends) if len(ends) <= MAX_ENDS else zip(*ends, strict=False):
        yield _put(formula, after, {name: (end, end) for name, end in chosen}, max)


def _put(formula: Formula, after: Mapping[str, Affine], errors: Mapping[str, Interval], worst: Worst) -> Formula:
    """A formula whose negations stand before actions alone, with forms in place of next values."""
    return with_comparisons(formula, partial(_put_next, after=after, errors=errors, worst=worst))


def _put_next(one: Linear, after: Mapping[str, Affine], errors: Mapping[str, Interval], worst: Worst) -> Formula:
    total = Affine.of({}, -one.bound)
    for weight, name in one.terms:
        if name not in after:
            total = total.plus(Affine.of({name: Fraction(1)}), weight)
            continue
        total = total.plus(after[name], weight)
        if name in errors:
            total = total.plus(Affine.of({}, worst(weight * end for end in errors[name])))
    return atom(HalfSpace(total, one.strict))
