"""Units of variables and constants, as products of powers of symbols: `m/s^2`.

Does: reads a unit; multiplies and divides units, so that sums of unlike ones can be refused.
Assumes: a symbol is whatever a user writes. Radians are pure numbers.
Does not: convert. `m` and `cm` are two symbols that do not fit. A library of units would know both, but it computes
  conversions in floats, and refuses cars and customers.
"""

import re
from typing import TypeAlias

from codegen.errors import InputError

Unit: TypeAlias = tuple[tuple[str, int], ...]  # symbol and power, in order, no power 0

PURE: Unit = ()
PURE_WORDS = ("", "1", "none", "rad")
MAX_POWER = 12
ADVICE = "write it as in m, m/s, kg*m/s^2 or 1/s"
DERIVED: dict[str, Unit] = {  # what these symbols stand for
    "N": (("kg", 1), ("m", 1), ("s", -2)),
    "J": (("kg", 1), ("m", 2), ("s", -2)),
    "W": (("kg", 1), ("m", 2), ("s", -3)),
    "Pa": (("kg", 1), ("m", -1), ("s", -2)),
    "Hz": (("s", -1),),
}
_FACTOR = re.compile(r"\s*([*/]?)\s*(1|[A-Za-z%_]+[0-9]*)\s*(?:(?:\^|\*\*)\s*(-?[0-9]{1,2}))?")


def unit_of(text: str, where: object) -> Unit:
    """The unit that a text names. InputError with `where` for what is none."""
    if not text.isascii() or not text.isprintable():
        raise InputError(f"cannot read the unit {text[:40]!r}", where, ADVICE)
    if text.strip() in PURE_WORDS:
        return PURE
    powers: dict[str, int] = {}
    place, end = 0, len(text.rstrip())
    while place < end:
        found = _FACTOR.match(text, place)
        if found is None or bool(found[1]) != (place > 0):
            raise InputError(f"cannot read the unit {text[:40]!r}", where, ADVICE)
        if found[2] not in PURE_WORDS:
            sign = -1 if found[1] == "/" else 1
            for symbol, power in DERIVED.get(found[2], ((found[2], 1),)):
                powers[symbol] = powers.get(symbol, 0) + sign * power * int(found[3] or 1)
        place = found.end()
    return _unit(powers, where)


def times(one: Unit, other: Unit, power: int = 1) -> Unit:
    """A unit times a power of another."""
    powers = dict(one)
    for symbol, exponent in other:
        powers[symbol] = powers.get(symbol, 0) + power * exponent
    return tuple(sorted((symbol, exponent) for symbol, exponent in powers.items() if exponent))


def _unit(powers: dict[str, int], where: object) -> Unit:
    if any(abs(power) > MAX_POWER for power in powers.values()):
        raise InputError(f"powers in a unit may be at most {MAX_POWER}", where, ADVICE)
    return times(PURE, tuple(powers.items()))


def written(unit: Unit) -> str:
    """The unit as a file writes it."""
    above = "*".join(_power(symbol, power) for symbol, power in unit if power > 0)
    below = "".join(f"/{_power(symbol, -power)}" for symbol, power in unit if power < 0)
    return (above or "1") + below


def _power(symbol: str, power: int) -> str:
    return symbol if power == 1 else f"{symbol}^{power}"
