"""When agents observe a flow: the length of a period and its jitter, and how many periods ago what they observe was.

Does: reads `period`; keeps earlier values in variables of their own, which change at samples only.
Assumes: variables, and features that were checked.
Does not: know derivatives (reading.py).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction

from codegen.errors import InputError
from verify.claims.region_files import is_list, is_table
from verify.language.units import Unit, unit_of
from verify.systems.language.expressions import Expression, Name
from verify.systems.language.parsing import Names
from verify.systems.system import Affine, Feature, HalfSpace, Interval, Polytope, Variable
from verify.systems.values import as_constant, as_list, count, error_of, only
from verify.toml_places import Place

KEYS = ("length", "jitter", "delay")
MAX_DELAY = 32  # periods
MAX_VARIABLES = 256  # with those that keep earlier values
ADVICE = 'write period = "0.1 s", or a table with length, jitter and delay'


@dataclass(frozen=True)
class Sampling:
    """A period in seconds, by how much it may be longer, and the delays of observations in whole periods."""

    length: Fraction
    jitter: Interval = (Fraction(0), Fraction(0))
    delays: tuple[int, ...] = (0,)


def sampling_of(given: object, names: Names, where: Place) -> Sampling:
    """Reads `period`: a time, or a table. InputError with the place of the first fault."""
    second = unit_of("s", where)
    if not is_table(given):
        return Sampling(_length(given, second, names, where))
    only(given, KEYS, where)
    if "length" not in given:
        raise InputError("a period needs a length", where, 'write length = "0.1 s"')
    length = _length(given["length"], second, names, where / "length")
    jitter = error_of(given.get("jitter", 0), second, names, where / "jitter")
    if length + jitter[0] <= 0:
        what = f"a period of {length} s may be {length + jitter[0]} s long"
        raise InputError(what, where / "jitter", "keep the jitter below the length")
    return Sampling(length, jitter, _delays(given.get("delay", 0), where / "delay"))


def _length(given: object, second: Unit, names: Names, where: Place) -> Fraction:
    length = as_constant(given, second, names, where)
    if length <= 0:
        raise InputError(f"the period {length} is not above 0", where, ADVICE)
    return length


def _delays(given: object, where: Place) -> tuple[int, ...]:
    """Whole periods: one number, or the ends of an interval."""
    ends = as_list(given, where, 2) if is_list(given) else [given, given]
    low, high = (0 if end == 0 and not isinstance(end, bool) else count(end, where, MAX_DELAY) for end in ends)
    if low > high:
        raise InputError(f"the least delay {low} is above the largest one {high}", where, "swap them")
    return tuple(range(low, high + 1))


@dataclass(frozen=True)
class Keeping:
    """Variables that keep what others were at earlier samples: themselves, what bounds their starts, what becomes of
    them at a sample, which variable each keeps, and for each delay what is observed in place of what.
    """

    variables: tuple[Variable, ...] = ()
    start: Polytope = ()
    jumps: Mapping[str, Expression] = field(default_factory=dict[str, Expression])
    kept: Mapping[str, str] = field(default_factory=dict[str, str])
    seen: tuple[Mapping[str, str], ...] = ({},)


def keeping(
    delays: Sequence[int],
    variables: Sequence[Variable],
    features: Mapping[str, Mapping[str, Feature]],
    where: Place,
) -> Keeping:
    """Returns what delays need; before the first sample all was as at the start. InputError for too many variables."""
    tested = {name for of in features.values() for each in of.values() for name, _ in each.form.terms}
    late = [one for one in variables if one.name in tested]
    if not any(delays):
        return Keeping()
    ages = range(1, max(delays) + 1)
    if len(variables) + len(late) * len(ages) > MAX_VARIABLES:
        what = f"{len(late)} observed variables kept for {len(ages)} periods are too many"
        raise InputError(what, where, "a smaller delay, or features of fewer variables")
    added = [Variable(earlier(one.name, age), one.unit, one.range, one.modes) for age in ages for one in late]
    kept = {earlier(one.name, age): one.name for age in ages for one in late}
    jumps = {earlier(one.name, age): Name(earlier(one.name, age - 1)) for age in ages for one in late}
    seen = tuple({one.name: earlier(one.name, delay) for one in late if delay} for delay in delays)
    return Keeping(tuple(added), _alike(kept), jumps, kept, seen)


def earlier(name: str, age: int) -> str:
    """The variable that keeps what another was so many periods ago. No text can write it."""
    return f"{name} {age} ago" if age else name


def _alike(kept: Mapping[str, str]) -> Polytope:
    """Every start: what is kept is what the variable is."""
    one = Fraction(1)
    ways = [(a, b) for pair in kept.items() for a, b in (pair, pair[::-1])]
    return tuple(HalfSpace(Affine.of({a: one, b: -one})) for a, b in ways)
