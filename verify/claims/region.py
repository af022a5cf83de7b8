"""What a claim has whatever it is about, where it is claimed, and the possible answers: regions and verdicts.

Does: name, team and parameters of a claim; the data of a region, and its readable TOML form with exact numbers.
Assumes: a world whose coordinates are named by the profile's world spec.
Does not: decide anything.
"""

import re
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields
from enum import Enum
from fractions import Fraction
from typing import Any, NamedTuple, TypeGuard

from codegen.errors import InputError, UnknownNameError
from codegen.floats import rational_literal
from codegen.ir import PolicyProfile, WorldSpec

Parameter = Fraction | int | str | tuple[str, ...]
Interval = tuple[Fraction, Fraction]
Difference = tuple[str, str, Interval]  # (a, b, bounds of a - b)
Pair = tuple[str, str, Fraction]  # (entity, entity, least L-infinity distance)
MAX_NUMBER = 10**9  # largest length in a question; beyond it float64 positions are coarser than any world
START = "start"  # the name of the start region
MACHINE, REAL = "machine", "real"  # thresholds as the deployed arithmetic meets them, or as they are written
SEMANTICS = (MACHINE, REAL)
ADVICE = "see `maviper verify --help` for the form of a region file"


class Kind(Enum):
    """What a claim is about; the values are the words of reports."""

    DECISIONS = "decisions"  # in world states
    LEAVES = "leaves"  # of trees: whether a world state reaches them
    EPISODES = "episodes"  # from rest


@dataclass(frozen=True)
class AnyClaim:
    """A claim about a team."""

    team: str
    label: str = field(default="", compare=False, kw_only=True)

    @property
    def name(self) -> str:
        """The name of the property."""
        raise NotImplementedError

    @property
    def sentence(self) -> str:
        """The claim in words, without its assumption."""
        raise NotImplementedError

    @property
    def parameters(self) -> Mapping[str, Parameter]:
        """What the claim reads beside its team."""
        raise NotImplementedError

    @property
    def shown(self) -> str:
        """The label, or else the name."""
        return self.label or self.name

    @property
    def stated(self) -> dict[str, Parameter]:
        """The parameters that are not the usual ones; those that have no usual one are among them."""
        usual = {item.name: item.default for item in fields(self)}
        return {key: value for key, value in self.parameters.items() if key not in usual or value != usual[key]}


class Semantics(NamedTuple):
    """How the tests of trees read a world state: the arithmetic, and by how much each measured feature may be off."""

    arithmetic: str = MACHINE
    eps: Fraction = Fraction(0)


class Verdict(Enum):
    """The answer to a question; the values are the words that reports use."""

    PROVED = "PROVED"  # holds in every world state of the region, by the arithmetic asked about
    VIOLATED = "VIOLATED"  # fails in a world state that the referee confirmed by it
    VACUOUS = "VACUOUS"  # no world state lies in the region and meets the assumptions
    UNKNOWN = "UNKNOWN"  # the budget ended, or of the deployed arithmetic only a real-valued state was found
    SKIPPED = "SKIPPED"  # not asked


@dataclass(frozen=True)
class Region:
    """A set of world states: a closed interval for each position, bounds on differences, pairs kept apart."""

    box: Mapping[str, Interval]  # coordinate -> bounds: every position, and the velocities that matter
    goals: tuple[str, ...]  # landmarks that may be the goal; empty when the world has none
    differences: tuple[Difference, ...] = ()
    apart: tuple[Pair, ...] = ()
    name: str = field(default="", compare=False)

    @property
    def goal_cases(self) -> tuple[str | None, ...]:
        """The goals one by one; None alone where the world has none."""
        return goal_cases(self.goals)

    def document(self) -> dict[str, Any]:
        """The region as plain data, numbers as exact text."""
        return {
            "goals": list(self.goals),
            "box": {name: [text(bound) for bound in bounds] for name, bounds in self.box.items()},
            "difference": {f"{a} - {b}": [text(bound) for bound in bounds] for a, b, bounds in self.differences},
            "apart": {f"{a} - {b}": text(least) for a, b, least in self.apart},
        }

    def toml(self) -> str:
        """The region as a file that `read_region` reads back."""
        lines = ["# A region of world states: closed intervals, in the world's length unit, exact as written."]
        lines += [f"goals = [{', '.join(f'{goal!r}' for goal in self.goals)}]".replace("'", '"'), "", "[box]"]
        lines += [f'"{name}" = [{text(low)}, {text(high)}]' for name, (low, high) in self.box.items()]
        if self.differences:
            lines += ["", "[difference]"]
            lines += [f'"{a} - {b}" = [{text(low)}, {text(high)}]' for a, b, (low, high) in self.differences]
        if self.apart:
            lines += ["", "[apart]", *(f'"{a} - {b}" = {text(least)}' for a, b, least in self.apart)]
        return "\n".join(lines) + "\n"


def goal_cases(goals: tuple[str, ...]) -> tuple[str | None, ...]:
    """Goals one by one; None alone where there are none."""
    return goals or (None,)


def goal_text(goal: str | None) -> str:
    """A goal as files have it: "" where there is none."""
    return goal or ""


def goal_of(written: str) -> str | None:
    """The goal that `goal_text` wrote."""
    return written or None


def text(number: Fraction) -> str:
    """A number as files have it: a fraction is in quotes."""
    found = plain(number)
    return f'"{found}"' if "/" in found else found


def plain(number: Fraction) -> str:
    """A number as a decimal where it has a finite one, else as a fraction; `exact` reads both."""
    places = 0
    while (number * 10**places).denominator != 1:
        places += 1
        if places > 60:
            return rational_literal(number)
    digits = f"{abs((number * 10**places).numerator):0{places + 1}d}"
    sign = "-" if number < 0 else ""
    return sign + (f"{digits[:-places]}.{digits[-places:]}" if places else digits)


def positions(world: WorldSpec) -> tuple[str, ...]:
    """The coordinates that every region bounds: the positions of agents and landmarks, and the variables."""
    places = [f"{entity.name}.{axis}" for entity in world.agents + world.landmarks for axis in "xy"]
    return (*places, *(variable.name for variable in world.variables))


def velocities_of(world: WorldSpec) -> tuple[str, ...]:
    """The velocity coordinates of agents."""
    return tuple(f"{agent.name}.v{axis}" for agent in world.agents for axis in "xy")


def start_region(world: WorldSpec, velocities: Sequence[str] = ()) -> Region:
    """Every position that is a start, any goal, variables in their ranges; the named velocity coordinates as large as
    actions can make them.
    """
    return Region(_start_bounds(world, velocities), world.goals, name=START)


def _start_bounds(world: WorldSpec, velocities: Sequence[str]) -> dict[str, Interval]:
    starts = [entity.start or (world.start_low, world.start_high) for entity in world.agents + world.landmarks]
    bounds = [start for start in starts for _ in "xy"] + [(one.low, one.high) for one in world.variables]
    exact_bounds = [(Fraction(low), Fraction(high)) for low, high in bounds]
    box = dict(zip(positions(world), exact_bounds, strict=True))
    for name in velocities:
        agent = next(entity for entity in world.agents if name.rpartition(".")[0] == entity.name)
        limits = [Fraction(agent.max_speed)] if agent.max_speed is not None else []
        if world.damping:  # what a push adds, summed over all steps: f dt (1 + (1 - d) + (1 - d)^2 + ...)
            limits.append(Fraction(agent.force) * Fraction(world.dt) / Fraction(world.damping))
        if not limits or min(limits) > MAX_NUMBER:
            lacking = f"has a damping of only {world.damping}" if world.damping else "has no damping"
            raise InputError(f"nothing bounds {name}: the world {lacking}", "", "state its bounds in a region file")
        box[name] = (-min(limits), min(limits))
    return box


def read_region(source: str, world: WorldSpec, where: str, velocities: Sequence[str] = ()) -> Region:
    """The region of a TOML text. Coordinates that it does not bound have the start region's bounds; `default` bounds
    positions. `velocities`: the velocity coordinates that the region bounds too.
    """
    try:
        document = tomllib.loads(source, parse_float=str)
    except (tomllib.TOMLDecodeError, ValueError, ZeroDivisionError, RecursionError) as error:
        raise InputError("not a readable region file", f"{where}: {error}", ADVICE) from None
    return region_of(document, world, where, velocities)


def region_of(document: Mapping[str, object], world: WorldSpec, where: str, velocities: Sequence[str] = ()) -> Region:
    """As `read_region`, from a parsed document in which floats are texts."""
    for key in document:
        if key not in ("goals", "default", "box", "difference", "apart"):
            raise UnknownNameError("key", key, ("goals", "default", "box", "difference", "apart"), where)
    stated = _table(document, "box", where)
    box = _start_bounds(world, [name for name in velocities if name not in stated])
    box = dict.fromkeys((*positions(world), *velocities), (Fraction(0), Fraction(0))) | box  # in this order
    if "default" in document:
        box |= dict.fromkeys(positions(world), _interval(document["default"], f"{where}: default"))
    for name, bounds in stated.items():
        if name not in box:
            raise UnknownNameError("coordinate", name, box, f"{where}: box")
        box[name] = _interval(bounds, f"{where}: box.{name}")
    differences = _differences(document, list(box), where)
    apart = _apart(document, [entity.name for entity in world.agents + world.landmarks], where)
    goals = document.get("goals", list(world.goals))
    if not is_list(goals) or (not goals and world.goals):
        raise InputError("goals must be a list of landmarks", f"{where}: goals", ADVICE)
    for goal in goals:
        if goal not in world.goals:
            raise UnknownNameError("goal", str(goal), world.goals, f"{where}: goals")
    return Region(box, tuple(map(str, goals)), differences, apart, name=where)


def _differences(document: Mapping[str, object], names: Sequence[str], where: str) -> tuple[Difference, ...]:
    """The stated differences; what is said of a pair more than once, in either order, holds at once."""
    found: dict[tuple[str, str], Interval] = {}
    for pair, bounds in _table(document, "difference", where).items():
        a, b = _pair(pair, names, "coordinate", f"{where}: difference")
        low, high = _interval(bounds, f"{where}: difference.{pair}")
        if (b, a) in found and a != b:
            a, b, low, high = b, a, -high, -low
        before = found.get((a, b), (low, high))
        found[a, b] = _ordered(max(low, before[0]), min(high, before[1]), f"{where}: difference.{pair}")
    return tuple((a, b, bounds) for (a, b), bounds in found.items())


def _apart(document: Mapping[str, object], entities: Sequence[str], where: str) -> tuple[Pair, ...]:
    """The pairs kept apart; of the distances that are stated for a pair, in either order, the largest."""
    found: dict[tuple[str, str], Fraction] = {}
    for pair, least in _table(document, "apart", where).items():
        a, b = _pair(pair, entities, "entity", f"{where}: apart")
        a, b = (b, a) if (b, a) in found else (a, b)
        distance = number(least, f"{where}: apart.{pair}")
        found[a, b] = max(distance, found.get((a, b), distance))
    return tuple((a, b, least) for (a, b), least in found.items())


def is_list(value: object) -> TypeGuard[list[object]]:
    """Whether a value of a parsed document is a list."""
    return isinstance(value, list)


def is_table(value: object) -> TypeGuard[dict[str, object]]:
    """Whether a value of a parsed document is a table."""
    return isinstance(value, dict)


def _table(document: Mapping[str, object], key: str, where: str) -> Mapping[str, object]:
    table = document.get(key, {})
    if not is_table(table):
        raise InputError(f"{key} must be a table", f"{where}: {key}", ADVICE)
    return table


def _pair(pair: str, known: Sequence[str], kind: str, where: str) -> tuple[str, str]:
    names = [name.strip() for name in pair.split(" - ")]
    if len(names) != 2:
        raise InputError(f"cannot read {pair!r}", where, f'write "{known[0]} - {known[-1]}"' if known else "")
    for name in names:
        if name not in known:
            raise UnknownNameError(kind, name, known, where)
    return names[0], names[1]


def _interval(bounds: object, where: str) -> Interval:
    if not is_list(bounds) or len(bounds) != 2:
        raise InputError("bounds are two numbers, [low, high]", where, ADVICE)
    low, high = (number(bound, where) for bound in bounds)
    return _ordered(low, high, where)


def _ordered(low: Fraction, high: Fraction, where: str) -> Interval:
    if low > high:
        raise InputError(f"the lower bound {text(low)} is above the upper one {text(high)}", where, "swap them")
    return low, high


def number(value: object, where: str) -> Fraction:
    """The exact number of a TOML value whose floats were read as texts: an integer, or a text as `exact` reads it."""
    if isinstance(value, bool) or not isinstance(value, (int, str)):
        raise InputError("not a number", where, 'write 0.025 or "1/40"')
    if isinstance(value, int) and abs(value) > MAX_NUMBER:
        raise InputError(f"numbers may be at most {MAX_NUMBER}", where)
    return exact(str(value), where)


_DECIMAL = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d{1,3})?|[+-]?\d+/\d+")
MAX_DIGITS = 2_000


def exact(written: str, where: str) -> Fraction:
    """The number that a text states exactly: a decimal or a fraction such as 1/40. InputError for anything else."""
    plain = written.strip().replace("_", "")
    if len(plain) > MAX_DIGITS or not _DECIMAL.fullmatch(plain):
        raise InputError(f"not a number: {written[:40]!r}", where, "write 0.025 or 1/40")
    try:
        number = Fraction(plain)
    except ZeroDivisionError:
        raise InputError(f"not a number: {written[:40]!r}", where, "write 0.025 or 1/40") from None
    if abs(number) > MAX_NUMBER:
        raise InputError(f"numbers may be at most {MAX_NUMBER}", where)
    return number


def observed_velocities(profile: PolicyProfile) -> tuple[str, ...]:
    """The velocity coordinates that some agent observes, in the world's order."""
    meanings = [feature.meaning for policy in profile.agents for feature in policy.features if feature.meaning]
    seen = {name for meaning in meanings for _, name in meaning.terms}
    return tuple(name for name in velocities_of(profile.world) if name in seen)


def everywhere(profile: PolicyProfile) -> Region:
    """The start region of a profile: every start position, any goal, every observed velocity that actions can cause."""
    return start_region(profile.world, observed_velocities(profile))


def called(profile: PolicyProfile, region: Region) -> str:
    """What a region is called; `start` only where it is the start region, whatever its own name is."""
    return "" if region.name == START and not is_start(profile, region) else region.name


def is_start(profile: PolicyProfile, region: Region) -> bool:
    """Whether a region is the start region, by its bounds."""
    try:
        return region == everywhere(profile)
    except InputError:  # no damping bounds the velocities, so there is none
        return False


def ensure_team(profile: PolicyProfile, team: str) -> None:
    """UnknownNameError for a team of which the profile has no agent."""
    if not profile.team(team):
        raise UnknownNameError("team", team, teams(profile))


def teams(profile: PolicyProfile) -> list[str]:
    """The teams of a profile, in the order of its agents."""
    return list(dict.fromkeys(policy.team for policy in profile.agents))


def check_range(parameter: str, value: Fraction | int, most: int = MAX_NUMBER, least: int = 0) -> None:
    """InputError for a value out of its range."""
    if not least <= value <= most:
        raise InputError(f"{parameter} must be between {least} and {most}", parameter)
