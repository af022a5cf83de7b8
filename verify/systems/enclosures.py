"""The pieces of a system: rules as they are where they are affine, else affine enclosures over parts of ranges.

Does: cuts boxes; carries each part of an expression as an affine form with a remainder, in exact numbers; joins these
  errors with those that a user states.
Assumes: checked rules (motion.py); a box bounds every variable of an expression.
Does not: trust itself alone: verify/checker/systems/enclosures.py shows each enclosure again in another way.

A part is known as a form around the middle of the box, and an interval that holds all that the form leaves out. sin,
cos, tan, exp, powers, reciprocals, roots and clips of a part are enclosed by a line over its range. Between points at a
distance w a function whose second derivative is at most m stays within m w^2 / 8 of the chord, so a few points bound
the error. A root is highest above a line of slope s where it is 1 / (4 s) above it. Products keep their linear part;
the product of the deviations goes into the interval.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from itertools import chain, pairwise, product
from math import isqrt, prod
from typing import NamedTuple

from codegen.errors import InputError
from verify.decimals import plain
from verify.spending import BeyondError, tell
from verify.systems.expressions import Call, Expression, Name, Number, Pi, Power, Product, Quotient, Sum, affine, names
from verify.systems.statement import Rule
from verify.systems.system import Affine, Box, Interval, Piece, Variable

POINTS = 48  # at which a function is looked at for an enclosure
GRID = 10**10  # forms and errors of an enclosure are multiples of 1 / GRID
FINE = 2**64  # ... and of 1 / FINE on the way
SHORTEST = FINE**2  # terms of a series are multiples of 1 / SHORTEST
SLACK = Fraction(1, 16)  # by which errors are widened, so that another proof of them need not be as tight
LARGEST = 32  # of what sin, cos, tan and exp are taken
ZERO: Interval = (Fraction(0), Fraction(0))
PI: Interval = (Fraction(314159265358979323846264338327, 10**29), Fraction(314159265358979323846264338328, 10**29))
Line = Callable[[Fraction, Fraction], tuple[Fraction, Interval]]  # of a function over a range


class Enclosure(NamedTuple):
    """The values of an expression over a box: those of `form`, and an error anywhere in `error`."""

    form: Affine
    error: Interval


class UndefinedError(BeyondError):
    """Over the box a part of an expression is not defined everywhere, or numbers are too large."""


@dataclass(frozen=True)
class _Model:
    """A form around the middle of the box, and what it leaves out."""

    middle: Fraction
    slopes: Mapping[str, Fraction]
    rest: Interval


class Enclosing:
    """Enclosures over one box."""

    def __init__(self, box: Box) -> None:
        self.box = box
        self._middle = {name: (low + high) / 2 for name, (low, high) in box.items()}
        self._radius = {name: (high - low) / 2 for name, (low, high) in box.items()}
        self._known: dict[Expression, _Model] = {}

    def of(self, expression: Expression, where: object) -> Enclosure:
        """The enclosure of an expression that stands somewhere. InputError with the place if it may be undefined."""
        try:
            model = self._model(expression)
        except UndefinedError as undefined:
            states = ", ".join(f"{name} in [{plain(low)}, {plain(high)}]" for name, (low, high) in self.box.items())
            raise InputError(str(undefined), f"{where}: {states}", "narrow the ranges, or cut them") from None
        # in decimals, the error around 0 and widened
        slopes = {name: Fraction(round(slope * GRID), GRID) for name, slope in model.slopes.items()}
        lost, middle = Fraction(0), model.middle + (model.rest[0] + model.rest[1]) / 2
        for name, slope in slopes.items():
            low, high = self.box[name]
            lost += abs(slope - model.slopes[name]) * (high - low) / 2
            middle -= slope * (low + high) / 2
        constant = Fraction(round(middle * GRID), GRID)
        half = (model.rest[1] - model.rest[0]) / 2 + lost + abs(constant - middle)
        wide = Fraction((half * (1 + SLACK) * GRID).__ceil__() + 1, GRID)
        return Enclosure(Affine.of(slopes, constant), (-wide, wide))

    def _model(self, expression: Expression) -> _Model:
        if expression not in self._known:
            self._known[expression] = self._build_model(expression)
        return self._known[expression]

    def _build_model(self, expression: Expression) -> _Model:
        match expression:
            case Number(value):
                return _Model(value, {}, ZERO)
            case Pi():
                return self._fine((PI[0] + PI[1]) / 2, {}, ((PI[0] - PI[1]) / 2, (PI[1] - PI[0]) / 2))
            case Name(name):
                return _Model(self._middle[name], {name: Fraction(1)}, ZERO)
            case Sum(left, right):
                return self._sum(self._model(left), self._model(right))
            case Product(left, right):
                return self._product(self._model(left), self._model(right))
            case Quotient(left, right):
                below = self._model(right)
                apart = self._range(below) if _apart(self._range(below)) else self._bounds(right)
                return self._product(self._model(left), self._apply_curve(_reciprocal, below, apart))
            case Power(base, exponent):
                return self._apply_curve(lambda a, b: _power(exponent, a, b), self._model(base))
            case Call(_, argument, (low, high)):
                return self._apply_curve(lambda a, b: _clip(low, high, a, b), self._model(argument))
            case Call("sqrt", argument, _):
                return self._apply_curve(_root, self._model(argument), self._bounds(argument))
            case Call(function, argument, _):
                return self._apply_curve(LINES[function], self._model(argument))

    def _deviation(self, model: _Model) -> Fraction:
        """Returns how far the form comes from its value in the middle."""
        return sum((abs(slope) * self._radius[name] for name, slope in model.slopes.items()), Fraction(0))

    def _range(self, model: _Model) -> Interval:
        reach = self._deviation(model)
        return model.middle - reach + model.rest[0], model.middle + reach + model.rest[1]

    def _bounds(self, expression: Expression) -> Interval:
        """The range of a part, in which clips, roots, exponentials and even powers keep their sign."""
        low, high = self._range(self._model(expression))
        match expression:
            case Sum(left, right):
                least, most = _add_bounds(self._bounds(left), self._bounds(right))
            case Product(left, right):
                least, most = _times(self._bounds(left), self._bounds(right))
            case Quotient(left, right) if _apart(ends := self._bounds(right)):
                least, most = _times(self._bounds(left), (1 / ends[1], 1 / ends[0]))
            case Power(_, exponent) if exponent % 2 == 0:
                least, most = Fraction(0), high
            case Call("sin" | "cos", _, _):
                least, most = Fraction(-1), Fraction(1)
            case Call("exp" | "sqrt", _, _):
                least, most = Fraction(0), high
            case Call(_, _, (least, most)):
                pass
            case _:
                return low, high
        return max(low, least), min(high, most)

    def _sum(self, one: _Model, other: _Model) -> _Model:
        names = one.slopes.keys() | other.slopes.keys()
        slopes = {name: one.slopes.get(name, 0) + other.slopes.get(name, 0) for name in sorted(names)}
        return self._fine(one.middle + other.middle, slopes, _add_bounds(one.rest, other.rest))

    def _scale_model(self, model: _Model, factor: Fraction) -> _Model:
        slopes = {name: slope * factor for name, slope in model.slopes.items()}
        low, high = model.rest[0] * factor, model.rest[1] * factor
        return self._fine(model.middle * factor, slopes, (min(low, high), max(low, high)))

    def _product(self, one: _Model, other: _Model) -> _Model:
        for constant, factor in ((one, other), (other, one)):
            if not constant.slopes and constant.rest == ZERO:
                return self._scale_model(factor, constant.middle)
        names = sorted(one.slopes.keys() | other.slopes.keys())
        slopes = {
            name: one.middle * other.slopes.get(name, 0) + other.middle * one.slopes.get(name, 0) for name in names
        }
        both = self._deviation(one) * self._deviation(other)
        reach = other.middle - self._deviation(other), other.middle + self._deviation(other)
        rest = _add_bounds(_add_bounds((-both, both), _times(one.rest, reach)), _times(self._range(one), other.rest))
        return self._fine(one.middle * other.middle, slopes, rest)

    def _apply_curve(self, line: Line, model: _Model, bounds: Interval | None = None) -> _Model:
        """A function of a part, by a slope over the part's range and what is left when that is taken off."""
        slope, (least, most) = line(*(bounds or self._range(model)))
        scaled = self._scale_model(model, slope)
        middle = (least + most) / 2
        rest = _add_bounds(scaled.rest, (least - middle, most - middle))
        return self._fine(scaled.middle + middle, scaled.slopes, rest)

    def _fine(self, middle: Fraction, slopes: Mapping[str, Fraction | int], rest: Interval) -> _Model:
        """The model in short numbers."""
        rounded = {name: Fraction(round(slope * FINE), FINE) for name, slope in slopes.items()}
        lost = sum((abs(rounded[name] - slope) * self._radius[name] for name, slope in slopes.items()), Fraction(0))
        near = Fraction(round(middle * FINE), FINE)
        low, high = rest[0] + middle - near - lost, rest[1] + middle - near + lost
        kept = {name: slope for name, slope in rounded.items() if slope}
        return _Model(near, kept, (Fraction((low * FINE).__floor__(), FINE), Fraction((high * FINE).__ceil__(), FINE)))


def _add_bounds(one: Interval, other: Interval) -> Interval:
    return one[0] + other[0], one[1] + other[1]


def _times(one: Interval, other: Interval) -> Interval:
    ends = [a * b for a in one for b in other]
    return min(ends), max(ends)


def _apart(bounds: Interval) -> bool:
    """Returns True if 0 lies outside the bounds."""
    return bounds[0] > 0 or bounds[1] < 0


# --- functions of one number: a slope, and the range of the function less the sloped line


def _reciprocal(low: Fraction, high: Fraction) -> tuple[Fraction, Interval]:
    if not _apart((low, high)):
        raise UndefinedError("a denominator may be 0")
    least = min(abs(low), abs(high))
    return _line(lambda u: (1 / u, 1 / u), 2 / least**3, low, high)


def _power(exponent: int, low: Fraction, high: Fraction) -> tuple[Fraction, Interval]:
    most = max(abs(low), abs(high))
    bend = exponent * (exponent - 1) * most ** (exponent - 2)
    return _line(lambda u: (u**exponent, u**exponent), bend, low, high)


@lru_cache(maxsize=1 << 12)  # boxes that differ in other variables only ask the same
def _wave(function: str, low: Fraction, high: Fraction) -> tuple[Fraction, Interval]:
    if max(abs(low), abs(high)) > LARGEST:
        raise UndefinedError(f"{function} of more than {LARGEST}")
    return _line(lambda u: _wave_at(function, u), Fraction(1), low, high)


def _tan(low: Fraction, high: Fraction) -> tuple[Fraction, Interval]:
    """Of tan between two of its poles, where its second derivative is largest at an end."""
    if max(abs(low), abs(high)) > LARGEST:
        raise UndefinedError(f"tan of more than {LARGEST}")
    turns = [{((2 * end / pi + 1) / 2).__floor__() for pi in PI} for end in (low, high)]
    ends = [] if turns[0] != turns[1] or len(turns[0]) > 1 else [_tan_at(low), _tan_at(high)]
    if not ends:
        raise UndefinedError("tan may have a pole")
    steepest = max(abs(end) for bounds in ends for end in bounds)
    return _line(_tan_at, 2 * steepest * (1 + steepest**2), low, high)


@lru_cache(maxsize=1 << 12)
def _tan_at(u: Fraction) -> Interval:
    sin, cos = _wave_at("sin", u), _wave_at("cos", u)
    if not _apart(cos):
        raise UndefinedError("tan may have a pole")
    low, high = _times(sin, (1 / cos[1], 1 / cos[0]))
    return Fraction((low * SHORTEST).__floor__(), SHORTEST), Fraction((high * SHORTEST).__ceil__(), SHORTEST)


def _exp(low: Fraction, high: Fraction) -> tuple[Fraction, Interval]:
    if max(abs(low), abs(high)) > LARGEST:
        raise UndefinedError(f"exp of more than {LARGEST}")
    return _line(_exp_at, _exp_at(high)[1], low, high)


@lru_cache(maxsize=1 << 12)
def _exp_at(u: Fraction) -> Interval:
    """exp of a number of at most LARGEST, by Taylor's series, rounded as that of sin (see there).

    Terms fall by half at least once k is above 2 |u|, so what is left out is at most the last term.
    """
    top, under = u.as_integer_ratio()
    term = total = SHORTEST  # in multiples of 1 / SHORTEST
    k = 0
    while abs(term) * FINE * 4 > SHORTEST or k * under < 2 * abs(top):
        k += 1
        term = _round_quotient(term * top, under * k)
        total += term
    near = Fraction(total, SHORTEST)
    return max(near - Fraction(1, FINE), Fraction(0)), near + Fraction(1, FINE)


def _root(low: Fraction, high: Fraction) -> tuple[Fraction, Interval]:
    """Of a square root, which lies above its chord, and at most 1 / (4 slope) above a line through 0."""
    if low < 0:
        raise UndefinedError("sqrt of what may be below 0")
    ends = [(end, _root_at(end)) for end in (low, high)]
    slope = _near((ends[1][1][0] - ends[0][1][0]) / (high - low)) if low < high else Fraction(0)
    if slope <= 0:
        return Fraction(0), (ends[0][1][0], ends[1][1][1])
    return slope, (min(root[0] - slope * end for end, root in ends), 1 / (4 * slope))


def _root_at(u: Fraction) -> Interval:
    """The square root in multiples of 1 / FINE, from below and from above."""
    root = isqrt((u * SHORTEST).__floor__())
    return Fraction(root, FINE), Fraction(root + 1, FINE)


def _clip(least: Fraction, most: Fraction, low: Fraction, high: Fraction) -> tuple[Fraction, Interval]:
    """Of a clip, whose corners are all that counts."""
    ends = [min(max(u, least), most) for u in (low, high)]
    slope = (ends[1] - ends[0]) / (high - low) if low < high else Fraction(0)
    corners = [low, high, *(corner for corner in (least, most) if low < corner < high)]
    left = [min(max(u, least), most) - slope * u for u in corners]
    return slope, (min(left), max(left))


def _line(
    at: Callable[[Fraction], Interval], bend: Fraction, low: Fraction, high: Fraction
) -> tuple[Fraction, Interval]:
    """For a function by its enclosed values and the largest second derivative."""
    points = [_near(low + (high - low) * k / POINTS) for k in range(1, POINTS)]
    points = [low, *points, high] if low < high else [low]
    values = [at(u) for u in points]
    rise = values[-1][0] - values[0][0]
    slope = _near(rise / (high - low)) if low < high else Fraction(0)
    step = max((b - a for a, b in pairwise(points)), default=Fraction(0))
    beyond = bend * step * step / 8
    left = [(value[0] - slope * u, value[1] - slope * u) for u, value in zip(points, values, strict=True)]
    return slope, (min(bounds[0] for bounds in left) - beyond, max(bounds[1] for bounds in left) + beyond)


LINES: dict[str, Line] = {
    "sin": lambda low, high: _wave("sin", low, high),
    "cos": lambda low, high: _wave("cos", low, high),
    "tan": _tan,
    "exp": _exp,
}


def _near(number: Fraction) -> Fraction:
    return Fraction(round(number * FINE), FINE)


def _wave_at(function: str, u: Fraction) -> Interval:
    """sin or cos of a number of at most LARGEST, by Taylor's series.

    The remainder is at most the first term left out. Each term is rounded to 2^-128. Later terms carry that on, in sum
    by a factor of e^LARGEST < 2^47 at most. Of less than 2^8 terms all this is below 2^-64.
    """
    k = 1 if function == "sin" else 0
    top, under = u.as_integer_ratio()
    square, per_square = top * top, under * under
    term, per = (top, under) if k else (1, 1)  # all later terms are in multiples of 1 / SHORTEST
    first, others = Fraction(term, per), 0
    while abs(term) * FINE * 4 > per or k * under < abs(top):
        k += 2
        term = _round_quotient(-term * square * SHORTEST, per * per_square * k * (k - 1))
        others, per = others + term, SHORTEST
    near = first + Fraction(others, SHORTEST)
    return near - Fraction(1, FINE), near + Fraction(1, FINE)


def _round_quotient(number: int, by: int) -> int:
    """The whole number nearest to a quotient, ties to even."""
    whole, rest = divmod(number, by)
    return whole + (2 * rest > by or (2 * rest == by and whole % 2))


# --- a short form


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
    return prod(rule.cuts.get(name, 1) for name in list_curved(rule))


def list_curved(rule: Rule) -> tuple[str, ...]:
    """The variables of what is not affine, in order."""
    written = chain(rule.move.values(), *(added.values() for added in rule.effect.values()))
    return tuple(sorted({name for each in written if affine(each) is None for name in names(each)}))


def cells(rule: Rule, ranges: Mapping[str, Interval]) -> Iterator[Box]:
    """The boxes that a rule is enclosed over: its domain, cut where something is not affine."""
    whole, cut = domain(rule, ranges), list_curved(rule)
    sides = [split_interval(whole[name], rule.cuts.get(name, 1)) for name in cut]
    for chosen in product(*sides):
        yield {**whole, **dict(zip(cut, chosen, strict=True))}


def domain(rule: Rule, ranges: Mapping[str, Interval]) -> Box:
    """The box in which a rule says how the state moves: its own, and the ranges of what is not affine."""
    box = dict(rule.where)
    for name in list_curved(rule):
        (least, most), (low, high) = ranges[name], box.get(name, ranges[name])
        box[name] = (max(low, least), min(high, most)) if low <= most and high >= least else (low, high)
    return box


def split_interval(bounds: Interval, count: int) -> list[Interval]:
    """So many parts of an interval, equally wide."""
    low, high = bounds
    return list(pairwise(low + (high - low) * k / count for k in range(count + 1)))


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
        sums: dict[str, Interval] = {}
        for name, bounds in errors.items():
            low, high = (sum((each[side] for each in bounds), Fraction(0)) for side in (0, 1))
            if low or high:
                sums[name] = low, high
        yield Piece(box, move, effect, sums, rule.when, rule.choice)


def enclose_expression(expression: Expression, over: Enclosing, where: object) -> Enclosure:
    """The affine form that an expression is, or an enclosure of it. InputError with `where` if it may be undefined."""
    form = affine(expression)
    return over.of(expression, where) if form is None else Enclosure(form, ZERO)
