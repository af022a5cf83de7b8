"""Machine thresholds for zone engine and checker: when a split goes left, as a formula over world coordinates.

Does: the exact ends of half lines by integer arithmetic on significands; the two sides of a split, for every meaning.
Assumes: coordinates are finite float64, observed with one rounding to float64 (a sum of two) and, by an agent that
  compares float32, one to float32; weights of an agent that compares float64 are 1 or more, so that products are exact.
Does not: share code with solver/encode.py, the other engine's account of the same arithmetic.

A float is n * 2**e with the significand n normalised. What rounds to a float or below it are the numbers up to the
middle between it and the next one, and the middle itself iff n is even. The end of that half line is a float64 again,
so the same step gives the half line of the first rounding.
"""

from fractions import Fraction
from functools import lru_cache
from math import ldexp
from typing import NamedTuple, TypeAlias

from codegen.errors import InputError
from codegen.floats import FLOAT32, FLOAT64, below_zero
from codegen.ir import FeatureSpec
from verify.claims.formula import FALSE, TRUE, And, Formula, Linear, Or
from verify.kinds import MACHINE, REAL

NO_ERROR = Fraction(0)
AT_ONCE = 2  # coordinates that are added with one rounding
SINGLE, DOUBLE = (24, -149), (53, -1074)  # bits of a significand, least exponent
FORMATS = {FLOAT32: SINGLE, FLOAT64: DOUBLE}
_Terms: TypeAlias = tuple[tuple[Fraction, str], ...]
_Sums: TypeAlias = tuple[_Terms, _Terms]  # a sum and its opposite


class End(NamedTuple):
    """All numbers up to numerator * 2**exponent, or below it when `strict`."""

    numerator: int
    exponent: int
    strict: bool

    def value(self) -> Fraction:
        """The end as a number."""
        shifted = self.numerator << max(self.exponent, 0)
        return Fraction(shifted, 1 << max(-self.exponent, 0))


def _normalise_float(value: float, form: tuple[int, int]) -> tuple[int, int]:
    """(n, e) with value = n * 2**e and the significand n as long as the format allows."""
    bits, least = form
    n, denominator = value.as_integer_ratio()
    e = 1 - denominator.bit_length()
    spare = min(bits - abs(n).bit_length(), e - least) if n else e - least
    return (n << spare if spare >= 0 else n >> -spare), e - spare


def _up_to(n: int, e: int, form: tuple[int, int]) -> End:
    """The numbers that round to the float n * 2**e or to a smaller one."""
    bits, least = form
    if n == -(1 << (bits - 1)) and e > least:  # above a negative power of two the floats lie closer
        return End(4 * n + 1, e - 2, strict=False)
    return End(2 * n + 1, e - 1, strict=n % 2 != 0)


def _below(n: int, e: int, form: tuple[int, int]) -> tuple[int, int]:
    """The float just below n * 2**e, normalised."""
    bits, least = form
    if n == 1 << (bits - 1) and e > least:
        return 2 * n - 1, e - 1
    if n == 1 - (1 << bits):
        return -(1 << (bits - 1)), e + 1
    return n - 1, e


@lru_cache(maxsize=1 << 16)
def find_real_end(threshold: float, numbers: str) -> End:
    """The real numbers that are at most `threshold` once one rounding makes them the agent's numbers."""
    form = FORMATS[numbers]
    return _up_to(*_normalise_float(threshold, form), form)


def find_double_end(threshold: float, numbers: str) -> End:
    """The float64 numbers z that are at most `threshold` once they are the agent's numbers, as the threshold is."""
    if FORMATS[numbers] is DOUBLE:  # nothing rounds
        return End(*_normalise_float(threshold, DOUBLE), strict=False)
    return find_real_end(threshold, numbers)


@lru_cache(maxsize=1 << 16)
def find_twice_rounded_end(threshold: float, numbers: str) -> End:
    """The real numbers d that are at most `threshold` once they are float64 and then the agent's numbers."""
    if FORMATS[numbers] is DOUBLE:
        return find_real_end(threshold, numbers)
    tie = find_double_end(threshold, numbers)
    n, e = _normalise_float(ldexp(tie.numerator, tie.exponent), DOUBLE)
    return _up_to(*(_below(n, e, DOUBLE) if tie.strict else (n, e)), DOUBLE)


@lru_cache(maxsize=1 << 15)  # the same for every goal, and for engine and checker
def sides(
    feature: FeatureSpec, threshold: float, numbers: str, semantics: str = MACHINE, eps: Fraction = NO_ERROR
) -> tuple[Formula, Formula]:
    """(goes left, goes right) of a split on `feature` at a `threshold`, over world coordinates; `numbers`: what the
    agent compares, float32 or float64.

    With an `eps`, where some error of at most that much, added to the exact sum, leads to the side: the sides overlap.
    Constants and what says that two things are equal have no error. One coordinate with an error is no float64 number,
    so it is rounded as a difference is.

    InputError when the feature has no meaning, or is a sum of more than two coordinates (or a function of one) and the
    deployed arithmetic is asked about: it rounds after each addition, so its sides are no half lines.
    """
    meaning = feature.meaning
    if meaning is None or (semantics == MACHINE and len(meaning.terms) > AT_ONCE):
        raise InputError(f"feature {feature.name} is not a coordinate or a difference of two", str(meaning))
    terms = _exact(meaning.terms)
    if not meaning.terms:
        return _always(threshold >= 0)
    if meaning.function:
        # The sides for a function of a sum. Rounding keeps signs, and a sum of two float64 rounds to 0 only from 0.
        lowest = -1 if meaning.function == "sign" else 0
        if threshold < lowest or threshold >= 1:
            return _always(threshold >= 1)
        if meaning.function == "zero":  # 1 where the sum is 0
            at_most, above = _cut(terms, Fraction(0), False)
            below, at_least = _cut(terms, Fraction(0), True)
            return Or((below, above)), And((at_most, at_least))
        return _cut(terms, Fraction(0), threshold < 0, eps)
    if semantics == REAL:
        return _cut(terms, Fraction(threshold), False, eps)
    if FORMATS[numbers] is DOUBLE and threshold == below_zero(numbers) and not eps:
        return _cut(terms, Fraction(0), True)  # a sum of two float64 numbers rounds to 0 only from 0
    ends = find_double_end if len(meaning.terms) == 1 and not eps else find_twice_rounded_end
    end = ends(threshold, numbers)
    return _cut(terms, end.value(), end.strict, eps)


@lru_cache(maxsize=1 << 10)
def _exact(terms: tuple[tuple[float, str], ...]) -> _Sums:
    """A sum, and its opposite."""
    exact = tuple((Fraction(weight), name) for weight, name in terms)
    return exact, tuple((-weight, name) for weight, name in exact)


def _always(left: bool) -> tuple[Formula, Formula]:
    return (TRUE, FALSE) if left else (FALSE, TRUE)


def _cut(sums: _Sums, end: Fraction, strict: bool, eps: Fraction = NO_ERROR) -> tuple[Linear, Linear]:
    """At most the end (below it when strict), and the opposite; each up to `eps` further."""
    terms, opposite = sums
    to, beyond = (end + eps, eps - end) if eps else (end, -end)
    return Linear(terms, to, strict), Linear(opposite, beyond, not strict)
