"""Units of variables and constants, as products of powers of symbols: `m/s^2`, `m^0.5/s`.

Does: reads a unit; multiplies and divides units, so that sums of unlike ones can be refused.
Assumes: a symbol is whatever a user writes. Radians are pure numbers. A degree is a symbol of its own: pi/180, which
  it stands for, is no fraction, so sin, cos and tan take degrees, and sums of degrees and radians are refused.
Does not: convert. `m` and `cm` are two symbols that do not fit. A library of units would know both, but it computes
  conversions in floats, and refuses cars and customers.
"""

import re
from fractions import Fraction
from typing import TypeAlias

from codegen.errors import InputError
from verify.decimals import plain

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
    return _unit(powers, where)


def times(one: Unit, other: Unit, power: int | Fraction = 1) -> Unit:
    """A unit times a power of another."""
    powers = dict(one)
    for symbol, exponent in other:
        powers[symbol] = powers.get(symbol, Fraction(0)) + power * exponent
    return tuple(sorted((symbol, exponent) for symbol, exponent in powers.items() if exponent))


def _unit(powers: dict[str, Fraction], where: object) -> Unit:
    if any(abs(power) > MAX_POWER for power in powers.values()):
        raise InputError(f"powers in a unit may be at most {MAX_POWER}", where, ADVICE)
    return times(PURE, tuple(powers.items()))


def format_unit(unit: Unit) -> str:
    """The unit as a file writes it."""
    above = "*".join(_power(symbol, power) for symbol, power in unit if power > 0)
    below = "".join(f"/{_power(symbol, -power)}" for symbol, power in unit if power < 0)
    return (above or "1") + below


def _power(symbol: str, power: Fraction) -> str:
    told = plain(power)
    return symbol if power == 1 else f"{symbol}^({told})" if "/" in told else f"{symbol}^{told}"
