"""What the sums, products and powers of a tree are, with their units; of what kind values are, a reader says.

Does: walks a tree; numbers, signs and units.
Assumes: a reader that knows names, calls and the arithmetic of its values.
Does not: know formulas.

A number without a unit fits beside any other in a sum, and is a pure number in a product.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable
from fractions import Fraction
from typing import Generic, NamedTuple, TypeVar

from codegen.errors import InputError
from verify.decimals import exact
from verify.language.parser import CallNode, Joined, Level, NameNode, Node, NumberNode, Prefixed, Source, Token
from verify.language.units import PURE, Unit, format_unit, times, unit_of

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
