"""Regions as people write them: TOML with exact numbers.

Does: reads the region of a file or of a table, with what it leaves out; writes one.
Assumes: a world whose coordinates are named by the profile's world spec.
Does not: open files.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from typing import TypeGuard

from codegen.errors import InputError, UnknownNameError
from codegen.ir import WorldSpec
from verify.claims.region import Difference, Interval, Pair, Region
from verify.claims.wording.starts import positions, start_bounds
from verify.decimals import number, text
from verify.toml_places import Place, parse

ADVICE = "see `maviper verify --help` for the form of a region file"


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
            raise UnknownNameError("key", key, ("goals", "default", "box", "difference", "apart"), where)
    stated = _table(document, "box", where)
    box = start_bounds(world, [name for name in velocities if name not in stated])
    box = dict.fromkeys((*positions(world), *velocities), (Fraction(0), Fraction(0))) | box  # in this order
    if "default" in document:
        box |= dict.fromkeys(positions(world), _interval(document["default"], where / "default"))
    for name, bounds in stated.items():
        if name not in box:
            raise UnknownNameError("coordinate", name, box, where / "box")
        box[name] = _interval(bounds, where / "box" / name)
    differences = _differences(document, list(box), where)
    apart = _apart(document, [entity.name for entity in world.agents + world.landmarks], where)
    goals = document.get("goals", list(world.goals))
    if not is_list(goals) or (not goals and world.goals):
        raise InputError("goals must be a list of landmarks", where / "goals", ADVICE)
    for goal in goals:
        if goal not in world.goals:
            raise UnknownNameError("goal", str(goal), world.goals, where / "goals")
    return Region(box, tuple(map(str, goals)), differences, apart)


def _differences(document: Mapping[str, object], names: Sequence[str], where: Place) -> tuple[Difference, ...]:
    """The stated differences; what is said of a pair more than once, in either order, holds at once."""
    differences: dict[tuple[str, str], Interval] = {}
    for pair, bounds in _table(document, "difference", where).items():
        a, b = _pair(pair, names, "coordinate", where / "difference")
        low, high = _interval(bounds, where / "difference" / pair)
        if (b, a) in differences and a != b:
            a, b, low, high = b, a, -high, -low
        before = differences.get((a, b), (low, high))
        differences[a, b] = _make_interval(max(low, before[0]), min(high, before[1]), where / "difference" / pair)
    return tuple((a, b, bounds) for (a, b), bounds in differences.items())


def _apart(document: Mapping[str, object], entities: Sequence[str], where: Place) -> tuple[Pair, ...]:
    """The pairs kept apart; of the distances that are stated for a pair, in either order, the largest."""
    distances: dict[tuple[str, str], Fraction] = {}
    for pair, least in _table(document, "apart", where).items():
        a, b = _pair(pair, entities, "entity", where / "apart")
        a, b = (b, a) if (b, a) in distances else (a, b)
        distance = number(least, where / "apart" / pair)
        distances[a, b] = max(distance, distances.get((a, b), distance))
    return tuple((a, b, least) for (a, b), least in distances.items())


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
    """The region as a file that `read_region` reads back."""
    lines = ["# A region of world states: closed intervals, in the world's length unit, exact as written."]
    lines += [f"goals = [{', '.join(f'{goal!r}' for goal in region.goals)}]".replace("'", '"'), "", "[box]"]
    lines += [f'"{name}" = [{text(low)}, {text(high)}]' for name, (low, high) in region.box.items()]
    if region.differences:
        lines += ["", "[difference]"]
        lines += [f'"{a} - {b}" = [{text(low)}, {text(high)}]' for a, b, (low, high) in region.differences]
    if region.apart:
        lines += ["", "[apart]", *(f'"{a} - {b}" = {text(least)}' for a, b, least in region.apart)]
    return "\n".join(lines) + "\n"
