"""What the sums, products and comparisons of a tree are: units of variables and constants, kinds of values, modes.

Does: reads, multiplies and divides units, products of powers of symbols such as `m/s^2`, so that sums of unlike ones
  can be refused; walks a tree for its numbers, signs and units; puts the number of a mode in place of its name.
Assumes: a reader that knows names, calls and the arithmetic of its values. A symbol is whatever a user writes. Radians
  are pure numbers. A degree is a symbol of its own: pi/180, which it stands for, is no fraction, so sin, cos and tan
  take degrees, and sums of degrees and radians are refused.
Does not: know formulas, or convert anything but times of whole values. `m` and `cm` are two symbols that do not fit. A
  library of units would know both, but it computes conversions in floats, and refuses cars and customers.

A number without a unit fits beside any other in a sum, and is a pure number in a product.
"""

import re
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from math import prod
from typing import Generic, NamedTuple, TypeAlias, TypeVar

from codegen.errors import InputError
from verify.decimals import exact, plain
from verify.language.parser import CallNode, Joined, Level, Listed, NameNode, Node, NumberNode, Prefixed, Source, Token

Unit: TypeAlias = tuple[tuple[str, Fraction], ...]  # symbol and power, in order, no power 0

PURE: Unit = ()
PURE_WORDS = ("", "1", "none", "rad")
MAX_POWER = 12
ADVICE = "write it as in m, m/s, kg*m/s^2, 1/s or m^0.5"
DEGREE: Unit = (("deg", Fraction(1)),)
DERIVED: dict[str, tuple[tuple[str, int], ...]] = {  # what these symbols stand for
    "N": (("kg", 1), ("m", 1), ("s", -2)),
    "J": (("kg", 1), ("m", 2), ("s", -2)),
    "W": (("kg", 1), ("m", 2), ("s", -3)),
    "Pa": (("kg", 1), ("m", -1), ("s", -2)),
    "Hz": (("s", -1),),
}
SECONDS = {"ms": Fraction(1, 1000), "s": Fraction(1), "min": Fraction(60), "h": Fraction(3600)}
_FACTOR = re.compile(
    r"\s*([*/]?)\s*(1|[A-Za-z%_]+[0-9]*)\s*(?:(?:\^|\*\*)\s*(-?[0-9]{1,2}(?:\.[0-9]{1,2})?|\(\s*-?[0-9]{1,2}\s*/\s*[1-9][0-9]?\s*\)))?"
)


def unit_of(text: str, where: object) -> Unit:
    """The unit that a text names. InputError with `where` for what is none."""
    if not text.isascii() or not text.isprintable():
        raise InputError(f"cannot read the unit {text[:40]!r}", where, ADVICE)
    if text.strip() in PURE_WORDS:
        return PURE
    powers: dict[str, Fraction] = {}
    place, end = 0, len(text.rstrip())
    while place < end:
        factor = _FACTOR.match(text, place)
        if factor is None or bool(factor[1]) != (place > 0):
            raise InputError(f"cannot read the unit {text[:40]!r}", where, ADVICE)
        if factor[2] not in PURE_WORDS:
            exponent = Fraction(re.sub(r"[\s()]", "", factor[3] or "1")) * (-1 if factor[1] == "/" else 1)
            for symbol, power in DERIVED.get(factor[2], ((factor[2], 1),)):
                powers[symbol] = powers.get(symbol, Fraction(0)) + exponent * power
        place = factor.end()
    if any(abs(power) > MAX_POWER for power in powers.values()):
        raise InputError(f"powers in a unit may be at most {MAX_POWER}", where, ADVICE)
    return times(PURE, tuple(powers.items()))


def times(one: Unit, other: Unit, power: int | Fraction = 1) -> Unit:
    """A unit times a power of another."""
    powers = dict(one)
    for symbol, exponent in other:
        powers[symbol] = powers.get(symbol, Fraction(0)) + power * exponent
    return tuple(sorted((symbol, exponent) for symbol, exponent in powers.items() if exponent))


def find_factor(one: Unit, other: Unit) -> Fraction | None:
    """Returns by what numbers in a unit are multiplied in another one that differs in units of time alone; None for any
    other.
    """
    powers = times(one, other, -1)
    if sum(power for _, power in powers) or any(symbol not in SECONDS or power % 1 for symbol, power in powers):
        return None
    return prod((SECONDS[symbol] ** int(power) for symbol, power in powers), start=Fraction(1))


def format_unit(unit: Unit) -> str:
    """The unit as a file writes it."""
    above = "*".join(_power(symbol, power) for symbol, power in unit if power > 0)
    below = "".join(f"/{_power(symbol, -power)}" for symbol, power in unit if power < 0)
    return (above or "1") + below


def _power(symbol: str, power: Fraction) -> str:
    told = plain(power)
    return symbol if power == 1 else f"{symbol}^({told})" if "/" in told else f"{symbol}^{told}"


Value = TypeVar("Value")
Read = TypeVar("Read")
MAX_EXPONENT = 8
WITH_UNITS = "give numbers their unit, as in 0.1[s]*v"


class Typed(NamedTuple, Generic[Value]):
    """A value and its unit; None: a bare number, which fits any."""

    value: Value
    unit: Unit | None


class Arithmetic(ABC, Generic[Value]):
    """Reads the sums of one text."""

    def __init__(self, source: Source) -> None:
        self.source = source
        self.misfits: list[InputError] = []  # sums of unlike units, first one first
        self.measured: Token | None = None  # the first number with a unit, or name of a constant

    # --- what values are

    @abstractmethod
    def constant(self, number: Fraction) -> Value:
        """A number."""

    @abstractmethod
    def negative(self, value: Value, sign: Token) -> Value:
        """A value with the other sign."""

    @abstractmethod
    def combine(self, left: Value, sign: Token, right: Value) -> Value:
        """Two values joined by +, * or /; a `-` is told as the sum that it is. InputError for what cannot be joined."""

    @abstractmethod
    def power(self, base: Value, sign: Token, exponent: int) -> Value:
        """A power of at least 2."""

    @abstractmethod
    def resolve_name(self, name: Token) -> Typed[Value]:
        """Returns the value that a name means. InputError for one that means no value."""

    @abstractmethod
    def resolve_call(self, call: CallNode) -> Typed[Value]:
        """Returns the value that a call means. InputError for one that means no value."""

    @abstractmethod
    def make_node_error(self, node: Node) -> InputError:
        """About a tree that states no value."""

    # --- trees

    def evaluate_node(self, node: Node) -> Typed[Value]:
        """The value of a tree. InputError with its place for what is none."""
        match node:
            case NumberNode(token, unit):
                self.measured = self.measured or (token if unit is not None else None)
                number = self.constant(self.read(exact, token.text, token))
                return Typed(number, None if unit is None else self.read(unit_of, unit, token))
            case NameNode(token):
                return self.resolve_name(token)
            case CallNode():
                return self.resolve_call(node)
            case Prefixed(token, signs, inside) if "not" not in signs:
                value = self.evaluate_node(inside)
                for sign in signs:
                    value = Typed(self.negative(value.value, token), value.unit) if sign == "-" else value
                return value
            case Joined(_, Level.POWER, base, ((sign, exponent),)):
                return self._power(self.evaluate_node(base), sign, exponent)
            case Joined(_, level, first, rest) if level in (Level.SUM, Level.PRODUCT):
                value = self.evaluate_node(first)
                for sign, other in rest:
                    value = self._combine(value, sign, self.evaluate_node(other))
                return value
            case _:
                raise self.make_node_error(node)

    def read(self, read: Callable[[str, str], Read], text: str, token: Token) -> Read:
        """Returns what `read` makes of a part of the text. InputError with its place."""
        try:
            return read(text, "")
        except InputError as error:
            raise self.source.wrong(error.what, token.place, error.next_step) from None

    def same(self, left: Typed[Value], right: Typed[Value], token: Token) -> Unit | None:
        """The unit of both; a bare number has that of the other."""
        if None not in (left.unit, right.unit) and left.unit != right.unit:
            what = f"units do not fit: {format_unit(left.unit or PURE)} and {format_unit(right.unit or PURE)}"
            self.misfits.append(self.source.wrong(what, token.place, WITH_UNITS))
        return right.unit if left.unit is None else left.unit

    def less(self, left: Node, right: Node) -> Typed[Value]:
        """One side of a comparison less the other."""
        return self._combine(self.evaluate_node(left), Token("mark", "-", right.token.place), self.evaluate_node(right))

    def _combine(self, left: Typed[Value], sign: Token, right: Typed[Value]) -> Typed[Value]:
        if sign.text in "+-":
            other = self.negative(right.value, sign) if sign.text == "-" else right.value
            return Typed(self.combine(left.value, sign._replace(text="+"), other), self.same(left, right, sign))
        unit = None
        if left.unit is not None or right.unit is not None:
            unit = times(left.unit or PURE, right.unit or PURE, 1 if sign.text == "*" else -1)
        return Typed(self.combine(left.value, sign, right.value), unit)

    def _power(self, base: Typed[Value], sign: Token, exponent: Node) -> Typed[Value]:
        digits = exponent.token.text if isinstance(exponent, NumberNode) and exponent.unit is None else ""
        try:
            power = int(digits, 0)
        except ValueError:
            power = 0
        if not 1 <= power <= MAX_EXPONENT:
            raise self.source.wrong(f"powers are whole, from 1 to {MAX_EXPONENT}", sign.place, "write such as x**2")
        if power == 1:
            return base
        return Typed(self.power(base.value, sign, power), base.unit and times(PURE, base.unit, power))


Modes = Mapping[str, Sequence[str]]  # variable -> the names of its values, in order
EQUALITY = ("==", "!=")
MODE = "mode"  # the kind of a token that names a mode in a comparison
BY_EQUALITY = "compare it by == or != with one of its modes"


def resolve_modes(source: Source, node: Node, modes: Modes) -> Node:
    """The tree with numbers for the names of modes. InputError where a mode is compared otherwise than by equality, or
    with what is none of its modes.
    """
    if not modes:
        return node
    match node:
        case Joined(token, Level.RELATION, first, rest):
            return _relate(source, token, [first, *(other for _, other in rest)], [sign for sign, _ in rest], modes)
        case Joined(token, level, first, rest):
            others = tuple((sign, resolve_modes(source, other, modes)) for sign, other in rest)
            return Joined(token, level, resolve_modes(source, first, modes), others)
        case Prefixed(token, signs, inside):
            return Prefixed(token, signs, resolve_modes(source, inside, modes))
        case CallNode(token, arguments):
            return CallNode(token, tuple(resolve_modes(source, each, modes) for each in arguments))
        case Listed(token, value, denied, names) if _mode(value, modes):
            equal = [
                _relate(source, token, [value, NameNode(name)], [Token("mark", "==", name.place)], modes)
                for name in names
            ]
            either = Joined(token, Level.OR, equal[0], tuple((names[0], each) for each in equal[1:]))
            comparison = either if either.rest else equal[0]
            return Prefixed(token, ("not",), comparison) if denied else comparison
        case _:
            return node


def is_compared(token: Token) -> bool:
    """Returns True if a name stands where a mode may stand."""
    return token.kind == MODE


def _mode(node: Node, modes: Modes) -> Sequence[str]:
    """The modes of the variable that a tree names; none for any other tree."""
    return modes.get(node.token.text, ()) if isinstance(node, NameNode) else ()


def _relate(source: Source, token: Token, sides: list[Node], signs: list[Token], modes: Modes) -> Node:
    """A comparison, or a chain of some."""
    known = [_mode(side, modes) for side in sides]
    operands = [resolve_modes(source, side, modes) for side in sides]
    for place, (sign, one, other) in enumerate(zip(signs, known, known[1:], strict=False)):
        if not one and not other:
            continue
        for at, names in ((place, one), (place + 1, other)):
            operands[at] = NameNode(sides[at].token._replace(kind=MODE)) if names else operands[at]
        if sign.text not in EQUALITY:
            raise source.wrong(f"modes are not ordered by {sign.text}", sign.place, BY_EQUALITY)
        if one and other and tuple(one) != tuple(other):
            raise source.wrong("these have other modes", sign.place, BY_EQUALITY)
        if not one or not other:
            at, names = (place + 1, one) if one else (place, other)
            operands[at] = _number(source, sides[at], names)
    return Joined(token, Level.RELATION, operands[0], tuple(zip(signs, operands[1:], strict=True)))


def _number(source: Source, node: Node, names: Sequence[str]) -> Node:
    if not isinstance(node, NameNode) or node.token.text not in names:
        raise source.unknown("mode", node.token, names)
    return NumberNode(node.token._replace(kind="number", text=str(names.index(node.token.text))))
