"""Shows again that the pieces of a system hold what the rules of its file say, curved ones included.

Does: sums, products and functions of ranges, bounds of values and of slopes; for each piece and joint action the range
  of rule less piece, over parts of the box until each lies in the error.
Assumes: rules as a world file states them; Python's whole numbers.
Does not: use floats, share arithmetic with verify/systems/enclosures.py, or know how an enclosure was found.

Numbers are whole multiples of 2^-BITS here, and every operation rounds outwards. The values of an expression lie around
its value in the middle of the box, no farther off than its gradient times the way from there, and within the bounds
that its parts give. Where a slope has no bound, as that of a root at 0, parts alone count. A box that does not show a
bound is halved.

sin, cos and exp are short series of a small number, which is doubled until it is the one asked for. A series ends with
a term of one unit or less; from its second term on, each is less than half of the one before, so two units more than
hold the rest. pi is Machin's 16 arctan(1/5) - 4 arctan(1/239).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from fractions import Fraction
from functools import lru_cache
from itertools import product
from math import isqrt
from typing import NamedTuple, TypeAlias

from verify.checker.reading import RejectedError
from verify.systems.claims import CurveOverCell
from verify.systems.expressions import (
    Call,
    Expression,
    Name,
    Number,
    Pi,
    Power,
    Product,
    Quotient,
    Sum,
    affine,
    names,
    terms,
    total,
)
from verify.systems.statement import Rule, Statement
from verify.systems.system import Affine, Box, Interval, Piece, find_gap

BITS = 128
ONE = 1 << BITS
MAX_HALVINGS = 40  # of an angle
HALF = ONE >> 8  # of what the series are taken
LARGEST_EXPONENT = 64 * ONE


class Range(NamedTuple):
    """All numbers from `low` to `high`, in multiples of 2^-BITS."""

    low: int
    high: int


ValueAndSlope: TypeAlias = tuple[Range, Range | None]  # of a function over a range; None: the slope has no bound


class UnboundedError(RejectedError):
    """Over a box a part of an expression may not be defined."""


# --- arithmetic


def up(value: Fraction | int) -> int:
    """The least multiple that is not below a number."""
    return -(-value.numerator * ONE // value.denominator)


def exactly(value: Fraction | int) -> Range:
    """One number."""
    return Range(value.numerator * ONE // value.denominator, up(value))


def outwards(bounds: Interval) -> Range:
    """The numbers between two."""
    return Range(-up(-bounds[0]), up(bounds[1]))


def plus(one: Range, other: Range) -> Range:
    """Sums."""
    return Range(one.low + other.low, one.high + other.high)


def minus(one: Range, other: Range) -> Range:
    """Differences."""
    return Range(one.low - other.high, one.high - other.low)


def times(one: Range, other: Range) -> Range:
    """Products."""
    ends = (one.low * other.low, one.low * other.high, one.high * other.low, one.high * other.high)
    return Range(min(ends) >> BITS, -(-max(ends) >> BITS))


def scale_range(one: Range, factor: int) -> Range:
    """Multiples by a positive number."""
    return Range(one.low * factor, one.high * factor)


def power(base: Range, exponent: int) -> Range:
    """Powers by a whole number from 0."""
    if exponent == 0:
        return Range(ONE, ONE)
    if exponent % 2 == 0:
        most = max(abs(base.low), abs(base.high))
        least = 0 if base.low <= 0 <= base.high else min(abs(base.low), abs(base.high))
        base = Range(least, most)
    low, high = Range(base.low, base.low), Range(base.high, base.high)
    lowest, highest = low, high
    for _ in range(exponent - 1):
        lowest, highest = times(lowest, low), times(highest, high)
    return Range(lowest.low, highest.high)


def inverse(span: Range) -> ValueAndSlope:
    """1 over numbers, and the slope of that."""
    low, high = span
    if low <= 0 <= high:
        raise UnboundedError
    value = Range(ONE * ONE // high, -(-ONE * ONE // low))
    return value, _negative(times(value, value))


def _negative(span: Range) -> Range:
    return Range(-span.high, -span.low)


# --- functions


def _cos(angle: Range) -> ValueAndSlope:
    sin, cos = waves(angle)
    return cos, _negative(sin)


def _tan(angle: Range) -> ValueAndSlope:
    """tan grows where cos is not 0, so its values at both ends bound it; its slope is 1 more than its square."""
    _, cos = waves(angle)
    if cos.low <= 0 <= cos.high:
        raise UnboundedError
    ends = [times(sin, inverse(below)[0]) for sin, below in map(waves_at, angle)]
    value = Range(ends[0].low, ends[1].high)
    return value, plus(Range(ONE, ONE), power(value, 2))


def _exp(span: Range) -> ValueAndSlope:
    if max(abs(span.low), abs(span.high)) > LARGEST_EXPONENT:
        raise UnboundedError
    value = Range(exp_at(span.low).low, exp_at(span.high).high)
    return value, value


def _root(span: Range) -> ValueAndSlope:
    """A square root and its slope, 1 over twice the root."""
    if span.low < 0:
        raise UnboundedError
    value = Range(isqrt(span.low << BITS), isqrt(span.high << BITS) + 1)
    return value, inverse(scale_range(value, 2))[0] if value.low > 0 else None


FUNCTIONS: dict[str, Callable[[Range], ValueAndSlope]] = {
    "sin": lambda angle: waves(angle),
    "cos": _cos,
    "tan": _tan,
    "exp": _exp,
    "sqrt": _root,
}


def waves(angle: Range) -> tuple[Range, Range]:
    """sin and cos of all angles of a range: those of its middle, off by at most half its width."""
    middle = (angle.low + angle.high) // 2
    off = max(angle.high - middle, middle - angle.low)
    sin, cos = waves_at(middle)
    return _near(sin, off), _near(cos, off)


def _near(value: Range, off: int) -> Range:
    return Range(max(value.low - off, -ONE), min(value.high + off, ONE))


@lru_cache(maxsize=1 << 14)
def waves_at(angle: int) -> tuple[Range, Range]:
    """sin and cos of a number."""
    halvings = _halvings(angle)
    small = Range(angle >> halvings, -(-angle >> halvings))
    square = _negative(power(small, 2))
    sin, cos = _series(small, square, 1, 2), _series(Range(ONE, ONE), square, 0, 2)
    for _ in range(halvings):
        both, squared = times(sin, cos), power(sin, 2)
        sin, cos = scale_range(both, 2), Range(ONE - 2 * squared.high, ONE - 2 * squared.low)
    return sin, cos


@lru_cache(maxsize=1 << 14)
def exp_at(number: int) -> Range:
    """exp of a number, above 0."""
    halvings = _halvings(number)
    enclosure = _series(Range(ONE, ONE), Range(number >> halvings, -(-number >> halvings)), 0, 1)
    for _ in range(halvings):
        enclosure = times(enclosure, enclosure)
    return enclosure


def _halvings(number: int) -> int:
    """Returns how often a number is halved for a series."""
    count = 0
    while abs(number) >> count > HALF:
        count += 1
    if count > MAX_HALVINGS:
        raise RejectedError("a function of a number beyond all use")
    return count


def _series(first: Range, factor: Range, k: int, steps: int) -> Range:
    """The series that begins with a term, whose next terms are the ones before times factor / (k (k - 1)), or / k."""
    total = term = first
    while max(abs(term.low), abs(term.high)) > 1:
        k += steps
        grown, divisor = times(term, factor), k * (k - 1) if steps == 2 else k
        term = Range(grown.low // divisor, -(-grown.high // divisor))
        total = plus(total, term)
    return Range(total.low - 2, total.high + 2)


@lru_cache(maxsize=1)
def pi() -> Range:
    """pi, by its neighbours."""
    return minus(scale_range(_arctan(5), 16), scale_range(_arctan(239), 4))


def _arctan(n: int) -> Range:
    """arctan(1 / n): 1 / n - 1 / (3 n^3) + ..., whose rest is below the first term left out."""
    total, power_of, k = 0, ONE // n, 1
    lost = 1  # by terms that are rounded down, and by the rest
    while power_of:
        total += power_of // k if k % 4 == 1 else -(power_of // k)
        lost += 2
        power_of //= n * n
        k += 2
    return Range(total - lost, total + lost)


MAX_PARTS = 20_000  # of a box, for one bound
NONE: frozenset[str] = frozenset()
ZERO = Range(0, 0)


class SlopedRange(NamedTuple):
    """An expression and its derivatives over a box. `steep`: names by which no bound of the slope is known."""

    value: Range
    slopes: dict[str, Range]
    steep: frozenset[str] = NONE


class FormRanges(NamedTuple):
    """An affine form, its numbers as ranges."""

    constant: Range
    factors: dict[str, Range]


class FormDifference(NamedTuple):
    """The sum of some terms, less a form."""

    curved: tuple[Expression, ...]
    rest: Affine


NOTHING = FormDifference((), Affine())
NO_ERROR = Fraction(0), Fraction(0)
OnPiece = Callable[[int, int], None]  # how many pieces are shown, of how many


def ensure_enclosed(statement: Statement, on_piece: OnPiece = lambda done, most: None) -> int:
    """Checks that each piece holds what its rule says, else RejectedError; returns the number of bounds shown.
    `on_piece` is told of each piece.
    """
    ranges = {each.name: each.range for each in statement.system.variables}
    shown = 0
    owners = [_owner(piece, statement.rules) for piece in statement.system.pieces]
    for number, rule in enumerate(statement.rules):
        boxes = [piece.where for piece, owner in zip(statement.system.pieces, owners, strict=True) if owner == number]
        whole = dict(ranges)
        for name, (low, high) in rule.where.items():
            both = max(low, ranges[name][0]), min(high, ranges[name][1])
            whole[name] = both if both[0] <= both[1] else (low, high)
        if not boxes or find_gap(whole, boxes) is not None:
            raise RejectedError(f"pieces leave out states of rule {number + 1}")
    for number, (piece, owner) in enumerate(zip(statement.system.pieces, owners, strict=True), 1):
        rule = statement.rules[owner]
        for name in rule.move:
            error, stated = piece.error.get(name, NO_ERROR), rule.error.get(name, NO_ERROR)
            allowed = error[0] - stated[0], error[1] - stated[1]  # what the stated error leaves for the enclosure
            for curved, rest in _differences(piece, rule, name):
                if not curved and (rest != Affine() or not allowed[0] <= 0 <= allowed[1]):
                    raise RejectedError(f"piece {number}: {name} moves otherwise than the rule says")
                if curved:
                    _ensure_within(total(list(curved)), rest, piece.where, allowed, f"piece {number}: {name}")
                    shown += 1
        on_piece(number, len(owners))
    return shown


def ensure_curves(enclosures: Sequence[CurveOverCell], ranges: Box) -> int:
    """Checks enclosures of curves in a claim; returns their number. RejectedError where one does not hold its curve, or
    the cells of a curve leave out states of the ranges.
    """
    cells: dict[Expression, list[Box]] = {}
    for each in enclosures:
        cells.setdefault(each.curve, []).append(each.cell)
        exact = affine(each.curve) == each.form and each.error[0] <= 0 <= each.error[1]
        if not exact:
            _ensure_within(each.curve, each.form, each.cell, each.error, "a curve of the claim")
    for curve, boxes in cells.items():
        if find_gap({name: ranges[name] for name in names(curve)}, boxes) is not None:
            raise RejectedError("cells leave out states of a curve of the claim")
    return len(enclosures)


def _owner(piece: Piece, rules: Sequence[Rule]) -> int:
    """The rule in whose box a piece lies, with its conditions and choices."""
    for number, rule in enumerate(rules):
        inside = (
            name in piece.where and low <= piece.where[name][0] and piece.where[name][1] <= high
            for name, (low, high) in rule.where.items()
        )
        if all(inside) and rule.when == piece.when and rule.choice == piece.choice:
            return number
    raise RejectedError("a piece lies in the box of no rule")


def _differences(piece: Piece, rule: Rule, name: str) -> Iterator[FormDifference]:
    """Yields what the rule says of a variable less what the piece says, for all joint actions.

    What an agent does exactly as the rule says adds nothing, so joint actions that differ in such agents are one.
    """
    choices = dict.fromkeys([*rule.effect, *piece.effect])
    sides = [[_difference(rule.move[name], piece.move[name])]]
    for agent in dict.fromkeys(agent for agent, _ in choices):
        differences = [
            _difference(rule.effect.get(choice, {}).get(name), piece.effect.get(choice, {}).get(name))
            for choice in choices
            if choice[0] == agent
        ]
        sides.append(list(dict.fromkeys([NOTHING, *differences])))
    for chosen in product(*sides):
        rest = Affine()
        for each in chosen:
            rest = rest.plus(each.rest)
        yield FormDifference(tuple(term for each in chosen for term in each.curved), rest)


def _difference(expression: Expression | None, form: Affine | None) -> FormDifference:
    curved, rest = list[Expression](), form or Affine()
    for term in () if expression is None else terms(expression):
        known = affine(term)
        if known is None:
            curved.append(term)
        else:
            rest = rest.plus(known, Fraction(-1))
    return FormDifference(tuple(curved), rest)


def enclose(expression: Expression, box: Mapping[str, Range]) -> Range:
    """Bounds of an expression over a box. UnboundedError where a part of it may not be defined."""
    return _over(expression, FormRanges(ZERO, {}), box)[0]


# --- one bound


def _ensure_within(expression: Expression, form: Affine, box: Box, allowed: Interval, where: str) -> None:
    """RejectedError where it is not shown that an expression less a form lies within bounds over a box."""
    found_in = sorted(names(expression) | {name for name, _ in form.terms})
    if not box.keys() >= set(found_in):
        raise RejectedError(f"{where}: nothing bounds what is not affine")
    least, most = up(allowed[0]), -up(-allowed[1])
    known = FormRanges(exactly(form.constant), {name: exactly(factor) for name, factor in form.terms})
    open_ = [{name: outwards(box[name]) for name in found_in}]
    parts = 0
    while open_:
        parts += 1
        if parts > MAX_PARTS:
            raise RejectedError(f"{where}: its error was not shown over {MAX_PARTS} parts of the box")
        here = open_.pop()
        try:
            difference, worst = _over(expression, known, here)
        except UnboundedError:
            difference = Range(least - 1, most + 1)
            worst = max(here, key=lambda name: here[name].high - here[name].low, default="")
        if not least <= difference.low or not difference.high <= most:
            if not here or here[worst].high - here[worst].low < 4:
                raise RejectedError(f"{where}: its error is exceeded")
            low, high = here[worst]
            middle = (low + high) // 2
            open_ += [{**here, worst: Range(low, middle)}, {**here, worst: Range(middle, high)}]


def _over(expression: Expression, form: FormRanges, box: Mapping[str, Range]) -> tuple[Range, str]:
    """The range of the difference over a box, and the variable in which it changes most."""
    middle = {name: Range((low + high) // 2, (low + high) // 2) for name, (low, high) in box.items()}
    whole = _part(expression, box)
    slopes, natural = whole.slopes, minus(whole.value, _affine(form, box))
    if whole.steep:
        return natural, max(sorted(whole.steep), key=lambda name: box[name].high - box[name].low)
    at = _part(expression, middle).value
    difference = minus(at, _affine(form, middle))
    widest, most = next(iter(box), ""), -1
    for name, (low, high) in box.items():
        slope = minus(slopes.get(name, ZERO), form.factors.get(name, ZERO))
        way = Range(low - middle[name].low, high - middle[name].low)
        change = times(slope, way)
        difference = plus(difference, change)
        if change.high - change.low > most:
            widest, most = name, change.high - change.low
    return Range(max(difference.low, natural.low), min(difference.high, natural.high)), widest


def _affine(form: FormRanges, at: Mapping[str, Range]) -> Range:
    enclosure = form.constant
    for name, factor in form.factors.items():
        enclosure = plus(enclosure, times(factor, at[name]))
    return enclosure


def _part(expression: Expression, box: Mapping[str, Range]) -> SlopedRange:
    """Values and derivatives of an expression."""
    match expression:
        case Number(value):
            return SlopedRange(exactly(value), {})
        case Pi():
            return SlopedRange(pi(), {})
        case Name(name):
            return SlopedRange(box[name], {name: Range(ONE, ONE)})
        case Sum(left, right):
            one, other = _part(left, box), _part(right, box)
            slopes = _add_slopes(one.slopes, other.slopes)
            return SlopedRange(plus(one.value, other.value), slopes, one.steep | other.steep)
        case Product(left, right):
            return _product(_part(left, box), _part(right, box))
        case Quotient(left, right):
            return _product(_part(left, box), _apply_function(_part(right, box), inverse))
        case Power(base, exponent):
            part = _part(base, box)
            slope = scale_range(power(part.value, exponent - 1), exponent)
            return _apply_function(part, lambda _: (power(part.value, exponent), slope))
        case Call(_, argument, (lower, upper)):
            part, low, high = _part(argument, box), exactly(lower), exactly(upper)
            least, most = part.value
            value = Range(min(max(least, low.low), high.low), min(max(most, low.high), high.high))
            if low.high <= least and most <= high.low:
                return part
            if most < low.low or high.high < least:
                return SlopedRange(value, {})
            slopes = {name: Range(min(0, slope.low), max(0, slope.high)) for name, slope in part.slopes.items()}
            return SlopedRange(value, slopes, part.steep)
        case Call(function, argument, _):
            return _apply_function(_part(argument, box), FUNCTIONS[function])


def _apply_function(part: SlopedRange, function: Callable[[Range], ValueAndSlope]) -> SlopedRange:
    """A function of a part, by its values and slopes; without a bound of these all names of the part are steep."""
    value, slope = function(part.value)
    if slope is None:
        return SlopedRange(value, {}, part.steep | part.slopes.keys())
    return SlopedRange(value, {name: times(slope, inner) for name, inner in part.slopes.items()}, part.steep)


def _product(one: SlopedRange, other: SlopedRange) -> SlopedRange:
    first = {name: times(slope, other.value) for name, slope in one.slopes.items()}
    second = {name: times(slope, one.value) for name, slope in other.slopes.items()}
    return SlopedRange(times(one.value, other.value), _add_slopes(first, second), one.steep | other.steep)


def _add_slopes(one: dict[str, Range], other: dict[str, Range]) -> dict[str, Range]:
    return {name: plus(one.get(name, ZERO), other.get(name, ZERO)) for name in {**one, **other}}
