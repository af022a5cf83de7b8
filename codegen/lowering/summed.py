"""Trees with sums in the emission model.

Does: names their parts: terms, tests of sums, what leaves give, and the lines of nested ifs that these make.
Assumes: `summing` made them.
Does not: look anything up in a profile, or hold text of any language.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from codegen.floats import FLOAT32, NUMBERS, below_zero
from codegen.lowering.parts import Action, Double, Feature, Node
from codegen.numbers import decimal_literal
from codegen.sums import CONSTANT, DOUBLE_SUMS, FLOAT32_STEPS

# of float (True), of double: the last number below 0, and 0
BELOW_ZERO = {numbers == FLOAT32: decimal_literal(below_zero(numbers)) for numbers in NUMBERS}
ZERO = {True: Double("0x0p+0f", "0.0"), False: Double("0x0p+0", "0.0")}


@dataclass(frozen=True)
class Term:
    """A term of a sum: `size` times the feature, added or subtracted."""

    sign: str  # "+" or "-"
    size: Double | None  # without its sign; None: 1
    feature: Feature | None  # None: the term is its size


@dataclass(frozen=True)
class Output:
    """A number that an agent gives, and its bounds in the numbers that it is rounded to."""

    index: int
    name: str
    upper: str
    unit: str
    low: Double | None
    high: Double | None


@dataclass(frozen=True)
class Given:
    """The value of a leaf for an output: a sum, or a number that is clipped and rounded already."""

    output: Output
    terms: tuple[Term, ...]
    number: Double | None
    shown: str  # as people read it

    @property
    def written(self) -> str:
        """The sum as attributes of pictures have it: `weight:place,...`, in the order in which it is added."""
        if self.number:
            return f"{self.number.hex.removesuffix('f')}:{CONSTANT}"
        return format_terms(self.terms)

    @property
    def share(self) -> float | None:
        """Where a number lies between its output's bounds, from 0 to 1; None where it is none, or has no bounds."""
        low, high = self.output.low, self.output.high
        if not self.number or not low or not high or float(low.decimal) == float(high.decimal):
            return None
        least, most = float(low.decimal), float(high.decimal)
        return float(self.number.decimal) / (most - least) - least / (most - least)


def format_terms(terms: Sequence[Term]) -> str:
    """A sum in one word: `0x1p-1:3,-0x1p+0:0`; the place of a constant is -1."""
    parts = ((term, term.size.hex.removesuffix("f") if term.size else "0x1p+0") for term in terms)
    return ",".join(
        f"{'-' if term.sign == '-' else ''}{size}:{term.feature.index if term.feature else CONSTANT}"
        for term, size in parts
    )


@dataclass(frozen=True)
class SumNode:
    """A node of a tree with sums: `single` where it tests one feature, else the terms of the sum that it tests."""

    id: int
    single: Node | None
    terms: tuple[Term, ...]
    threshold: Double | None  # of the sum
    shown: str  # the test as people read it, for comments
    action: Action | None
    given: tuple[Given, ...]
    left: int
    right: int

    @property
    def sign(self) -> str:
        """The comparison of the sum. What asks for a sum below 0 is written so: compared with the last number below 0,
        a sum of 0 would go left where a thread takes subnormal numbers for zero.
        """
        last = self.threshold and BELOW_ZERO[self.threshold.hex.endswith("f")]
        return "<" if self.threshold and self.threshold.decimal == last else "<="

    @property
    def limit(self) -> Double | None:
        """The number that the sum is compared with."""
        return ZERO[self.threshold.hex.endswith("f")] if self.threshold and self.sign == "<" else self.threshold

    @property
    def split(self) -> bool:
        """True if it tests anything."""
        return self.action is None and not self.given

    @property
    def tested(self) -> str:
        """The sum or feature that it tests, as people read it."""
        return " ".join(self.shown.split(" ")[:-2])

    @property
    def test(self) -> str:
        """The comparison with its threshold, as people read it."""
        return " ".join(self.shown.split(" ")[-2:])

    @property
    def written(self) -> str:
        """The sum in one word, see `format_terms`."""
        return format_terms(self.terms)


@dataclass(frozen=True)
class SumLine:
    """A line of nested-if code, as `Line`."""

    kind: Literal["if", "else", "end", "leaf"]
    level: int
    node: SumNode

    def pad(self, width: int = 4, outer: int = 1) -> str:
        """The space before it, within `outer` levels of other code."""
        return " " * width * (self.level + outer)


@dataclass(frozen=True)
class Summed:
    """A tree whose tests or leaves have sums."""

    arithmetic: str
    gives: str
    outputs: tuple[Output, ...]  # (): leaves take actions
    nodes: tuple[SumNode, ...]
    lines: tuple[SumLine, ...]

    @property
    def doubled(self) -> bool:
        """True if float32 observations are added as doubles."""
        return self.arithmetic == DOUBLE_SUMS

    @property
    def stepwise(self) -> bool:
        """True if each operation is rounded to float32."""
        return self.arithmetic == FLOAT32_STEPS

    @property
    def gives_single(self) -> bool:
        """True if outputs are float32."""
        return self.gives == FLOAT32

    @property
    def kind(self) -> str:
        """The C type of outputs."""
        return "float" if self.gives_single else "double"

    @property
    def splits(self) -> int:
        """The number of nodes that test something."""
        return sum(node.split for node in self.nodes)

    @property
    def blank(self) -> bool:
        """True if no node reads the observation."""
        return not self.splits and not any(each.terms for node in self.nodes for each in node.given)
