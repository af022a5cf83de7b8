"""The parts of the emission model that others are made of: numbers, features, actions, nodes, boxes.

Does: names them, and what follows from them at once, such as a test as languages write it.
Assumes: `lower` made them.
Does not: look anything up in a profile.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from codegen.floats import short_hex
from codegen.ir import Float64
from codegen.numbers import decimal_literal

SINGLE_BITS = 32
UNIT = 2.0**-53  # by what share of itself a number is off that is rounded to float64


@dataclass(frozen=True)
class Double:
    """A number, as languages write it."""

    hex: str
    decimal: str

    @classmethod
    def of(cls, value: float) -> "Double":
        """A number as languages write it, minus zero as zero."""
        return cls(short_hex(value + 0.0), decimal_literal(value + 0.0))


@dataclass(frozen=True)
class Feature:
    """A feature and its place in the observation."""

    index: int
    name: str
    upper: str
    unit: str
    low: str
    high: str
    low_hex: str  # the range in the agent's numbers, rounded outwards, as C literals
    high_hex: str
    low_seen: str  # the same as decimals, of the doubles that they are
    high_seen: str
    meaning: str
    function: str  # of the sum of `terms`; "" for the sum itself
    terms: tuple[tuple[str, str, str], ...] | None  # (sign, weight unless it is 1, coordinate); None: no meaning


@dataclass(frozen=True)
class Action:
    """An action and its number."""

    index: int
    name: str
    upper: str
    effect: tuple[str, str] | None  # the direction in which it pushes, where there is one
    legal_if: str  # the upper-case name of the feature that is 1 where it is legal; "": it always is


@dataclass(frozen=True)
class Node:
    """A node of the tree. Splits compare feature `feature` with a threshold, leaves take `action`."""

    id: int
    feature: Feature | None
    action: Action | None
    literal: str  # the threshold, exact, as a C literal
    bits: int  # of it as an unsigned number
    width: int  # how many these are
    double: str  # the deciding double, shortest decimal
    shown: str  # the test's number as people read it, for comments only; "< 0" for what is below 0
    test: str  # for them, too: "<= 0.1", "< 0"
    left: int
    right: int

    @property
    def hex_bits(self) -> str:
        """`bits` in hexadecimal digits, all of them."""
        return f"0x{self.bits:0{self.width // 4}x}"

    @property
    def below_zero(self) -> bool:
        """True if what is asked is x < 0. Code says so: compared with the last number below 0, a 0 would go left where
        a thread takes subnormal numbers for zero.
        """
        return self.bits == (1 << self.width - 1) + 1

    @property
    def in_c(self) -> str:
        """Sign and number of the test as C and C++ write it."""
        if self.below_zero:
            return "< 0x0p+0" + ("f" if self.width == SINGLE_BITS else "")
        return f"<= {self.literal}"

    @property
    def in_rust(self) -> str:
        """The same in Rust."""
        return "< 0.0" if self.below_zero else f"<= f{self.width}::from_bits({self.hex_bits})"

    @property
    def of_numbers(self) -> str:
        """The same where numbers are of the agent's type, in Python."""
        return "< 0.0" if self.below_zero else f"<= {self.double}"

    @property
    def of_doubles(self) -> str:
        """The same for doubles that are not rounded before, in Python and JavaScript."""
        return self.of_numbers if self.width > SINGLE_BITS else f"<= {self.double}"

    @property
    def negative(self) -> bool:
        """True if the threshold's sign is set, -0.0 included."""
        return self.bits >= 1 << self.width - 1

    @property
    def ordered(self) -> int:
        """The threshold as an integer in the order of its numbers: -0.0 is -1 there, but as a threshold 0."""
        half = 1 << self.width - 1
        return half - 1 - self.bits if self.bits > half else self.bits % half


class RaisedSum(NamedTuple):
    """A sum of variables with whole factors, as float64, and by what share of its terms' sizes it is raised.

    So raised it is never below the exact sum. With u = UNIT and P all sizes together, products are off by 2 u P and a
    bit, since factors may be rounded too, n - 1 sums of them by u P each, and the last sum, with the share, by u P and
    a bit. That is less than (n + 3) u P, in any order, with or without fused operations, and the share is 2 (n + 4) u.
    Underflow takes nothing: whole multiples of float64 numbers are multiples of 2**-1074, so that they are added
    exactly where P is below 2**-1021, and beyond that the share of P is above 2**-1071. What overflows becomes infinite
    or no number, and is within no bound.
    """

    terms: tuple[tuple[int, float], ...]  # variable, factor

    @property
    def factors(self) -> tuple[tuple[int, Double], ...]:
        """The terms as languages write them."""
        return tuple((column, Double.of(factor)) for column, factor in self.terms)

    @property
    def share(self) -> Double:
        """Of the sizes of all terms together."""
        return Double.of(self._share)

    @property
    def _share(self) -> float:
        return 2.0 * (len(self.terms) + 4) * UNIT

    def of(self, states: Float64) -> Float64:
        """It in each state [batch, variables], as code adds it: from left to right."""
        total, size = np.zeros(len(states)), np.zeros(len(states))
        with np.errstate(all="ignore"):
            for column, factor in self.terms:
                product = factor * states[:, column]
                total, size = total + product, size + np.abs(product)
            return np.asarray(total + self._share * size, dtype=np.float64)


class Ends(NamedTuple):
    """The least and most of each variable of a box, in the order of its part."""

    low: tuple[Double, ...]
    high: tuple[Double, ...]
