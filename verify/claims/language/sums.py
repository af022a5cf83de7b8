"""Linear sums of coordinates with maxima in them, and what comparing two of them says.

Does: exact arithmetic; distances and absolute values as maxima; comparisons as formulas of linear atoms.
Assumes: the parts of a maximum are linear.
Does not: know text (formulas.py).
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from itertools import product

from verify.claims.formula import Formula, below, conjunction, disjunction, negate

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
