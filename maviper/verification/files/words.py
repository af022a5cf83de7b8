"""What a certificate holds, in words: its formula and the bounds of its region, whatever other files say now.

Does: writes a formula with its numbers; names the bounds in which a region is not the start region.
Assumes: names of the profile that the certificate is about.
Does not: know property files or region files, which may have been changed since.
"""

from collections.abc import Iterator
from fractions import Fraction

from codegen.errors import InputError
from codegen.ir import PolicyProfile
from verify.claims.formula import Acts, And, Formula, Goal, Linear, Not, Or
from verify.claims.region import Interval, Region
from verify.claims.wording.starts import everywhere
from verify.decimals import plain

MOST = 300  # characters of a formula or a region that are shown
LEFT_OUT = "... (whole in the certificate)"


def formula_words(formula: Formula, profile: PolicyProfile) -> str:
    """A formula as text, cut where it is long."""
    return _cut(_write_formula(formula, profile))


def region_words(region: Region, profile: PolicyProfile) -> str:
    """The bounds of a region that the start region does not have, cut where they are many."""
    return _cut(", ".join(_bounds(region, profile)))


def _cut(text: str) -> str:
    return text if len(text) <= MOST else f"{text[:MOST]}{LEFT_OUT}"


def _write_formula(formula: Formula, profile: PolicyProfile) -> str:
    match formula:
        case Linear(terms, bound, strict):
            parts = [name if weight == 1 else f"{plain(weight)} * {name}" for weight, name in terms]
            return f"{' + '.join(parts) or '0'} {'<' if strict else '<='} {plain(bound)}"
        case Acts(agent, action):
            return f"acts({agent}) == {profile.policy(agent).actions[action].name}"
        case Goal(landmark):
            return f"goal == {landmark}"
        case Not(part):
            return f"not ({_write_formula(part, profile)})"
        case And(parts) | Or(parts):
            both = isinstance(formula, And)
            written = [_write_formula(part, profile) for part in parts]
            joined = (" and " if both else " or ").join(written) or ("true" if both else "false")
            return f"({joined})" if len(written) > 1 else joined


def _bounds(region: Region, profile: PolicyProfile) -> Iterator[str]:
    usual = _usual(profile)
    for name, bounds in region.box.items():
        if usual.get(name) != bounds:
            yield f"{name} in {_interval(*bounds)}"
    yield from (f"{a} - {b} in {_interval(*bounds)}" for a, b, bounds in region.differences)
    yield from (f"{a} and {b} at least {plain(least)} apart" for a, b, least in region.apart)


def _usual(profile: PolicyProfile) -> dict[str, Interval]:
    try:
        return dict(everywhere(profile).box)
    except InputError:  # no damping bounds the velocities
        return {}


def _interval(low: Fraction, high: Fraction) -> str:
    return f"[{plain(low)}, {plain(high)}]"
