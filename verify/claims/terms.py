"""The terms of formulas that users write: sums of coordinates, numbers beside a feature, and trees as text again.

Does: adds sums with maxima in them, and says what comparing two of them means, in exact arithmetic; reads an inequality
  over one feature as a test of the agents that observe it, and spells a float that a decimal means; lists the left
  sides of implications; spells trees.
Assumes: trees that were parsed (verify.language); all agents that observe a feature compare the same type of numbers.
Does not: read texts (written.py), or touch features in sums of several.

A claim says x < 0 of the float32 that an agent compares. Read of the float64 number before it is rounded, the claim
would fail at -1e-46, which the agent sees as 0; read as a test, both mean the same numbers.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from decimal import Decimal
from fractions import Fraction
from itertools import count, product
from math import ceil, floor, inf
from typing import NamedTuple

from numpy import iinfo

from codegen.floats import WHOLE
from codegen.numbers import nearest_double, nearest_number, neighbour
from verify.claims.formula import And, Formula, Linear, Not, Or, below, conjunction, disjunction, negate
from verify.language.parser import BARS, CallNode, Joined, Level, Listed, NameNode, Node, NumberNode, Prefixed


def list_conditions(node: Node) -> list[tuple[Node, ...]]:
    """The left side of each implication among the conjuncts of a tree: trees that it says hold together."""
    match node:
        case Joined(_, Level.AND, first, rest):
            return [each for part in (first, *(other for _, other in rest)) for each in list_conditions(part)]
        case Joined(_, Level.IMPLIES, first, _):
            return [(first,)]
        case Joined(_, Level.OR, first, rest):
            parts = [first, *(other for _, other in rest)]
            denied = [part.value for part in parts if isinstance(part, Prefixed) and part.signs.count("not") % 2]
            return [(each,) for each in denied] if len(denied) == len(parts) else [tuple(denied)] if denied else []
        case _:
            return []


def spell(node: Node, least: int = Level.IMPLIES) -> str:
    """The text of a tree, in parentheses where its operator binds less tightly than `least`."""
    match node:
        case NumberNode(token, unit):
            return token.text if unit is None else f"{token.text}[{unit}]"
        case NameNode(token):
            return f"'{token.text}'" if "-" in token.text else token.text
        case CallNode(token, arguments):
            inside = ", ".join(map(spell, arguments))
            return f"|{inside}|" if token.text == BARS else f"{spell(NameNode(token))}({inside})"
        case Prefixed(_, signs, value):
            level = Level.NOT if "not" in signs else Level.SIGN
            text = " ".join(signs) + " " * (level is Level.NOT) + spell(value, level)
        case Joined(_, level, first, rest):
            text = spell(first, level + 1) + "".join(f" {sign.text} {spell(other, level + 1)}" for sign, other in rest)
        case Listed(_, value, denied, names):
            level = Level.RELATION
            listed = ", ".join(spell(NameNode(name)) for name in names)
            text = f"{spell(value, level + 1)} {'not in' if denied else 'in'} [{listed}]"
    return text if level >= least else f"({text})"


def strip_signs(node: Node) -> Node:
    """Returns the tree behind signs."""
    return node.value if isinstance(node, Prefixed) and "not" not in node.signs else node


def find_single_name(node: Node) -> str:
    """The one name that a side of a comparison is, or is the absolute value of; "" for any other."""
    inside = strip_signs(node)
    if isinstance(inside, CallNode) and inside.token.text in ("abs", BARS) and len(inside.arguments) == 1:
        inside = strip_signs(inside.arguments[0])
    return inside.token.text if isinstance(inside, NameNode) else ""


MAX_CASES = 512  # atoms that one comparison may become
MAX_BITS = 4096  # of a number's numerator or denominator


@dataclass(frozen=True)
class CoordinateSum:
    """`offset` + weight * coordinate + ... + factor * max(sums) + ...; parts of a maximum have no maxima."""

    offset: Fraction = Fraction(0)
    terms: dict[str, Fraction] = field(default_factory=dict[str, Fraction])
    maxima: tuple[tuple[Fraction, tuple["CoordinateSum", ...]], ...] = ()

    @property
    def is_constant(self) -> bool:
        """True if the sum is a number."""
        return not self.terms and not self.maxima

    def __add__(self, other: "CoordinateSum") -> "CoordinateSum":
        terms = dict(self.terms)
        for name, weight in other.terms.items():
            terms[name] = terms.get(name, Fraction(0)) + weight
        kept = {name: weight for name, weight in terms.items() if weight}
        return CoordinateSum(self.offset + other.offset, kept, self.maxima + other.maxima)

    def times(self, factor: Fraction) -> "CoordinateSum":
        """Every part times a number; OverflowError when its digits grow beyond all use."""
        if not factor:
            return CoordinateSum()
        terms = {name: weight * factor for name, weight in self.terms.items()}
        multiple = CoordinateSum(
            self.offset * factor, terms, tuple((factor * weight, parts) for weight, parts in self.maxima)
        )
        numbers = (multiple.offset, *terms.values(), *(weight for weight, _ in multiple.maxima))
        if any(max(abs(n.numerator), n.denominator).bit_length() > MAX_BITS for n in numbers):
            raise OverflowError("the numbers grow too long")
        return multiple


def constant(value: Fraction) -> CoordinateSum:
    """A number."""
    return CoordinateSum(value)


def coordinate(name: str) -> CoordinateSum:
    """One coordinate."""
    return CoordinateSum(terms={name: Fraction(1)})


def largest(parts: Sequence[CoordinateSum]) -> CoordinateSum:
    """The largest of sums without maxima."""
    return parts[0] if len(parts) == 1 else CoordinateSum(maxima=((Fraction(1), tuple(parts)),))


def distance(a: str, b: str) -> CoordinateSum:
    """The L-infinity distance of two entities."""
    gaps = [coordinate(f"{a}.{axis}") + coordinate(f"{b}.{axis}").times(Fraction(-1)) for axis in "xy"]
    return largest([side for gap in gaps for side in (gap, gap.times(Fraction(-1)))])


def compare_sums(left: CoordinateSum, relation: str, right: CoordinateSum) -> Formula:
    """The formula of `left relation right`; OverflowError when it has too many cases."""
    difference = left + right.times(Fraction(-1))
    backwards = difference.times(Fraction(-1))
    made: dict[str, Callable[[], Formula]] = {
        "<=": lambda: _not_above(difference, False),
        "<": lambda: _not_above(difference, True),
        ">=": lambda: _not_above(backwards, False),
        ">": lambda: _not_above(backwards, True),
        "==": lambda: conjunction(_not_above(difference, False), _not_above(backwards, False)),
        "!=": lambda: negate(conjunction(_not_above(difference, False), _not_above(backwards, False))),
    }
    return made[relation]()


def _not_above(total: CoordinateSum, strict: bool) -> Formula:
    """`total` <= 0, or < 0: each added maximum bounds with all of its parts, each subtracted one with some part."""
    added = [parts for factor, parts in total.maxima if factor > 0]
    factors = [factor for factor, _ in total.maxima if factor > 0] + [f for f, _ in total.maxima if f < 0]
    taken = [parts for factor, parts in total.maxima if factor < 0]
    cases = 1
    for parts in (*added, *taken):
        cases *= len(parts)
    if cases > MAX_CASES:
        raise OverflowError(f"absolute values and distances make {cases} cases, at most {MAX_CASES} are allowed")
    plain = CoordinateSum(total.offset, total.terms)

    def atom(chosen: Sequence[CoordinateSum]) -> Formula:
        total = plain
        for factor, part in zip(factors, chosen, strict=True):
            total = total + part.times(factor)
        return below(dict(sorted(total.terms.items())), -total.offset, strict)

    return disjunction(*(conjunction(*(atom((*more, *less)) for more in product(*added))) for less in product(*taken)))


class Compared(NamedTuple):
    """A comparison of a feature: its numbers; (is at most, is above) one of these numbers, as formulas. `factor` and
    `offset`: what makes its number of the number in its unit, which formulas name.
    """

    numbers: str
    cut: Callable[[float], tuple[Formula, Formula]]
    factor: Fraction = Fraction(1)
    offset: Fraction = Fraction(0)


def read_as_compared(formula: Formula, known: Mapping[str, Compared]) -> Formula:
    """The formula whose inequalities over one feature are tests of it."""
    match formula:
        case And(parts):
            return conjunction(*(read_as_compared(part, known) for part in parts))
        case Or(parts):
            return disjunction(*(read_as_compared(part, known) for part in parts))
        case Not(part):
            return Not(read_as_compared(part, known))
        case Linear(((weight, name),), bound, strict) if name in known:
            numbers, cut, factor, offset = known[name]
            end = factor * bound / weight + offset
            # up to an end, or the opposite of what is below it
            return cut(last_of(end, numbers, below=strict == (weight > 0)))[0 if weight > 0 else 1]
        case Linear(terms, bound, strict) if any(name in known for _, name in terms):
            scales = [known[name][2:] if name in known else (Fraction(1), Fraction(0)) for _, name in terms]
            pairs = [(weight / factor, name) for (weight, name), (factor, _) in zip(terms, scales, strict=True)]
            moved = sum(weight * offset for (weight, _), (_, offset) in zip(pairs, scales, strict=True))
            return Linear(tuple(pairs), bound + moved, strict)
        case _:
            return formula


def last_of(end: Fraction, numbers: str, below: bool) -> float:
    """The largest of the `numbers` that is at most `end`, or, where `below`, that is below it. Of a type of whole
    numbers it is one less than the least of the type where all of these are above, and the type's largest at most.
    """
    if numbers in WHOLE:
        limits = iinfo(numbers)
        return float(min(max(ceil(end) - 1 if below else floor(end), limits.min - 1), limits.max))
    near = neighbour(neighbour(nearest_double(end), inf, numbers), inf, numbers)
    while Fraction(float(near)) > end or (below and Fraction(float(near)) == end):
        near = neighbour(near, -inf, numbers)
    return float(near)


def spell_unlike(near: float, exact: Fraction, numbers: str) -> str:
    """A float with as many digits, from 15 on, as tell it from other floats and from an exact number."""
    texts = (f"{Decimal(near):.{digits}g}" for digits in count(15))
    return next(text for text in texts if nearest_number(Fraction(text), numbers) == near and Fraction(text) != exact)
