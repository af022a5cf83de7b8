"""Regions as people write them, and the start region of a world.

Does: reads regions from TOML with exact numbers, and writes them; where episodes start, and how fast agents may become.
Assumes: world coordinates as the profile's spec names them.
Does not: open files, or belong to what proofs rest on: a certificate states its region's bounds.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from typing import TypeGuard

from codegen.errors import InputError, UnknownNameError
from codegen.ir import PolicyProfile, WorldSpec
from verify.claims.region import Difference, Interval, Region
from verify.decimals import number, text
from verify.exact import MAX_NUMBER
from verify.toml_places import Place, parse

START = "start"  # the name of the start region


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
    return Region(start_bounds(world, velocities), world.goals, name=START)


def start_bounds(world: WorldSpec, velocities: Sequence[str]) -> dict[str, Interval]:
    """The bounds of the start region. InputError for a velocity that nothing bounds."""
    starts = [entity.start or (world.start_low, world.start_high) for entity in world.agents + world.landmarks]
    bounds = [start for start in starts for _ in "xy"] + [(one.low, one.high) for one in world.variables]
    exact_bounds = [(Fraction(low), Fraction(high)) for low, high in bounds]
    box = dict(zip(positions(world), exact_bounds, strict=True))
    for name in velocities:
        agent = next(entity for entity in world.agents if name.rpartition(".")[0] == entity.name)
        limits = [Fraction(agent.max_speed)] if agent.max_speed is not None else []
        if world.damping:  # what a push adds over all steps: f dt (1 + (1 - d) + (1 - d)^2 + ...)
            limits.append(Fraction(agent.force) * Fraction(world.dt) / Fraction(world.damping))
        if not limits or min(limits) > MAX_NUMBER:
            lacking = f"has a damping of only {world.damping}" if world.damping else "has no damping"
            raise InputError(f"nothing bounds {name}: the world {lacking}", "", "state its bounds in a region file")
        box[name] = (-min(limits), min(limits))
    return box


def find_observed_velocities(profile: PolicyProfile) -> tuple[str, ...]:
    """The velocity coordinates that some agent observes, in the world's order."""
    meanings = [feature.meaning for policy in profile.agents for feature in policy.features if feature.meaning]
    seen = {name for meaning in meanings for _, name in meaning.terms}
    return tuple(name for name in velocities_of(profile.world) if name in seen)


def everywhere(profile: PolicyProfile) -> Region:
    """The start region of a profile: every start position, any goal, every observed velocity that actions can cause."""
    return start_region(profile.world, find_observed_velocities(profile))


def name_region(profile: PolicyProfile, region: Region) -> str:
    """Returns a region's name; `start` only where it is the start region, whatever its own name is."""
    return "" if region.name == START and not is_start(profile, region) else region.name


def is_start(profile: PolicyProfile, region: Region) -> bool:
    """Returns True if a region is the start region, by its bounds."""
    try:
        return region == everywhere(profile)
    except InputError:  # no damping bounds the velocities, so there is none
        return False


ADVICE = "see `maviper guide claims` for the form of a region file"


def read_region(source: str, world: WorldSpec, name: str, velocities: Sequence[str] = ()) -> Region:
    """The region of a TOML text. Coordinates that it does not bound have the start region's bounds; `default` bounds
    positions. `velocities`: the velocity coordinates that the region bounds too.
    """
    document, place = parse(source, name, "not a readable region file", ADVICE)
    return replace(region_of(document, world, place, velocities), name=name)


def region_of(document: Mapping[str, object], world: WorldSpec, where: Place, velocities: Sequence[str] = ()) -> Region:
    """Reads a region as `read_region` does, from a parsed document in which floats are texts."""
    for key in document:
        if key not in ("goals", "default", "box", "difference", "apart"):
            raise UnknownNameError("key", key, ("goals", "default", "box", "difference", "apart"), where / key)
    stated = _table(document, "box", where)
    box = start_bounds(world, [name for name in velocities if name not in stated])
    box = dict.fromkeys((*positions(world), *velocities), (Fraction(0), Fraction(0))) | box  # in this order
    if "default" in document:
        box |= dict.fromkeys(positions(world), _interval(document["default"], where / "default"))
    for name, bounds in stated.items():
        if name not in box:
            raise UnknownNameError("coordinate", name, box, where / "box" / name)
        box[name] = _interval(bounds, where / "box" / name)
    differences = _differences(document, list(box), where)
    entities = [entity.name for entity in world.agents + world.landmarks]
    distances: dict[tuple[str, str], Fraction] = {}  # of those stated for a pair, in either order, the largest
    for pair, least in _table(document, "apart", where).items():
        a, b = _pair(pair, entities, "entity", where / "apart" / pair)
        a, b = (b, a) if (b, a) in distances else (a, b)
        distance = number(least, where / "apart" / pair)
        distances[a, b] = max(distance, distances.get((a, b), distance))
    apart = tuple((a, b, least) for (a, b), least in distances.items())
    goals = document.get("goals", list(world.goals))
    if not is_list(goals) or (not goals and world.goals):
        raise InputError("goals must be a list of landmarks", where / "goals", ADVICE)
    for place, goal in enumerate(goals):
        if goal not in world.goals:
            raise UnknownNameError("goal", str(goal), world.goals, where / "goals" / place)
    return Region(box, tuple(map(str, goals)), differences, apart)


def _differences(document: Mapping[str, object], names: Sequence[str], where: Place) -> tuple[Difference, ...]:
    """The stated differences; what is said of a pair more than once, in either order, holds at once."""
    differences: dict[tuple[str, str], Interval] = {}
    for pair, bounds in _table(document, "difference", where).items():
        a, b = _pair(pair, names, "coordinate", where / "difference" / pair)
        low, high = _interval(bounds, where / "difference" / pair)
        if (b, a) in differences and a != b:
            a, b, low, high = b, a, -high, -low
        before = differences.get((a, b), (low, high))
        differences[a, b] = _make_interval(max(low, before[0]), min(high, before[1]), where / "difference" / pair)
    return tuple((a, b, bounds) for (a, b), bounds in differences.items())


def is_list(value: object) -> TypeGuard[list[object]]:
    """Returns True if a value of a parsed document is a list."""
    return isinstance(value, list)


def is_table(value: object) -> TypeGuard[dict[str, object]]:
    """Returns True if a value of a parsed document is a table."""
    return isinstance(value, dict)


def _table(document: Mapping[str, object], key: str, where: Place) -> Mapping[str, object]:
    table = document.get(key, {})
    if not is_table(table):
        raise InputError(f"{key} must be a table", where / key, ADVICE)
    return table


def _pair(pair: str, known: Sequence[str], kind: str, where: Place) -> tuple[str, str]:
    names = [name.strip() for name in pair.split(" - ")]
    if len(names) != 2:
        raise InputError(f"cannot read {pair!r}", where, f'write "{known[0]} - {known[-1]}"' if known else "")
    for name in names:
        if name not in known:
            raise UnknownNameError(kind, name, known, where)
    return names[0], names[1]


def _interval(bounds: object, where: Place) -> Interval:
    if not is_list(bounds) or len(bounds) != 2:
        raise InputError("bounds are two numbers, [low, high]", where, ADVICE)
    low, high = (number(bound, where) for bound in bounds)
    return _make_interval(low, high, where)


def _make_interval(low: Fraction, high: Fraction, where: Place) -> Interval:
    if low > high:
        raise InputError(f"the lower bound {text(low)} is above the upper one {text(high)}", where, "swap them")
    return low, high


def region_toml(region: Region) -> str:
    """The region as a file that `read_region` reads back.

    For example:

        Path("near.toml").write_text(region_toml(region))
    """
    lines = ["# A region of world states: closed intervals, in the world's length unit, exact as written."]
    lines += [f"goals = [{', '.join(f'{goal!r}' for goal in region.goals)}]".replace("'", '"'), "", "[box]"]
    lines += [f'"{name}" = [{text(low)}, {text(high)}]' for name, (low, high) in region.box.items()]
    if region.differences:
        lines += ["", "[difference]"]
        lines += [f'"{a} - {b}" = [{text(low)}, {text(high)}]' for a, b, (low, high) in region.differences]
    if region.apart:
        lines += ["", "[apart]", *(f'"{a} - {b}" = {text(least)}' for a, b, least in region.apart)]
    return "\n".join(lines) + "\n"
