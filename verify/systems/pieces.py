"""The pieces of a system, from the rules of a file: exact where a rule is affine, else enclosures over parts of ranges.

Does: cuts boxes; joins the errors of enclosures with those that a user states.
Assumes: checked rules (motion.py).
Does not: prove an enclosure (enclosures.py).
"""

from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction
from itertools import chain, pairwise, product

from codegen.errors import InputError
from verify.progress import tell
from verify.systems.enclosures import ZERO, Enclosing, Enclosure
from verify.systems.language.expressions import Expression, affine, names
from verify.systems.statement import Rule
from verify.systems.system import Affine, Box, Interval, Piece, Variable

MAX_PIECES = 4_096


def pieces(rules: Sequence[Rule], variables: Sequence[Variable], where: object) -> tuple[Piece, ...]:
    """The pieces of rules. InputError for more than MAX_PIECES, and where something may be undefined."""
    ranges = {variable.name: variable.range for variable in variables}
    most = sum(count(rule) for rule in rules)
    if most > MAX_PIECES:
        raise InputError(f"more than {MAX_PIECES} pieces", where, "cut ranges into fewer parts")
    parts: list[Piece] = []
    for rule in rules:
        for piece in _pieces(rule, ranges):
            parts.append(piece)
            tell(len(parts), most, "pieces made from rules")
    return tuple(parts)


def count(rule: Rule) -> int:
    """Counts the pieces that a rule becomes."""
    total = 1
    for name in list_curved(rule):
        total *= rule.cuts.get(name, 1)
    return total


def list_curved(rule: Rule) -> tuple[str, ...]:
    """The variables of what is not affine, in order."""
    written = chain(rule.move.values(), *(added.values() for added in rule.effect.values()))
    return tuple(sorted({name for each in written if affine(each) is None for name in names(each)}))


def cells(rule: Rule, ranges: Mapping[str, Interval]) -> Iterator[Box]:
    """The boxes that a rule is enclosed over: its domain, cut where something is not affine."""
    whole, cut = domain(rule, ranges), list_curved(rule)
    sides = [_parts(whole[name], rule.cuts.get(name, 1)) for name in cut]
    for chosen in product(*sides):
        yield {**whole, **dict(zip(cut, chosen, strict=True))}


def domain(rule: Rule, ranges: Mapping[str, Interval]) -> Box:
    """The box in which a rule says how the state moves: its own, and the ranges of what is not affine."""
    return {**rule.where, **{name: _within(rule.where, ranges, name) for name in list_curved(rule)}}


def _within(where: Box, ranges: Mapping[str, Interval], name: str) -> Interval:
    low, high = where.get(name, ranges[name])
    least, most = ranges[name]
    return (max(low, least), min(high, most)) if low <= most and high >= least else (low, high)


def _parts(bounds: Interval, n: int) -> list[Interval]:
    low, high = bounds
    ends = [low + (high - low) * k / n for k in range(n + 1)]
    return list(pairwise(ends))


def _pieces(rule: Rule, ranges: Mapping[str, Interval]) -> Iterator[Piece]:
    for box in cells(rule, ranges):
        over = Enclosing(box)
        move: dict[str, Affine] = {}
        effect: dict[tuple[str, str], dict[str, Affine]] = {}
        errors: dict[str, list[Interval]] = {name: [bounds] for name, bounds in rule.error.items()}
        for name, expression in rule.move.items():
            move[name], error = enclose_expression(expression, over, rule.place / "next" / name)
            errors.setdefault(name, []).append(error)
        by_agent: dict[tuple[str, str], Interval] = {}
        for (agent, action), added in rule.effect.items():
            for name, expression in added.items():
                form, error = enclose_expression(expression, over, rule.place / "next" / name)
                effect.setdefault((agent, action), {})[name] = form
                low, high = by_agent.get((agent, name), ZERO)
                by_agent[agent, name] = min(low, error[0]), max(high, error[1])
        for (_, name), error in by_agent.items():
            errors.setdefault(name, []).append(error)
        yield Piece(box, move, effect, _sum_errors(errors), rule.when, rule.choice)


def enclose_expression(expression: Expression, over: Enclosing, where: object) -> Enclosure:
    """The affine form that an expression is, or an enclosure of it. InputError with `where` if it may be undefined."""
    form = affine(expression)
    return over.of(expression, where) if form is None else Enclosure(form, ZERO)


def _sum_errors(errors: Mapping[str, Sequence[Interval]]) -> dict[str, Interval]:
    sums: dict[str, Interval] = {}
    for name, bounds in errors.items():
        low, high = (sum((each[side] for each in bounds), Fraction(0)) for side in (0, 1))
        if low or high:
            sums[name] = low, high
    return sums
