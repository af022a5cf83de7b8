"""The world that a profile was learned in, and names for what its agents observe: `--features-file names.toml`.

Does: finds our world with exactly the profile's spec, agents, features and actions; refuses worlds without places;
  gives the features of other people's games the names, units and ranges that a TOML file states.
Assumes: a checked profile; entries of the file in the order of the observation, one for each number beside a mask.
Does not: play, change what is observed, or name features of our own games, which have meanings.

In the file a table stands for an agent, for a team, or (`"*"`) for everybody else; the first of these that there is
counts:

    [agent_0]
    cart_position = "m"
    pole_angle = { unit = "rad", range = [-0.4, 0.4] }
"""

import hashlib
import tomllib
from collections.abc import Iterable, Mapping, Sequence
from copy import copy
from dataclasses import replace
from pathlib import Path
from typing import Any, cast

from codegen import ir
from codegen.check import identifier
from codegen.errors import InputError, UnknownNameError, escape_text
from codegen.floats import FLOAT32
from codegen.ir import MAX_LENGTH, NAME, FeatureSpec
from maviper.files import runs
from maviper.worlds import WORLDS, ParticleWorld, World, find_built_in
from maviper.worlds.remembering import Remembering, remembering
from maviper.worlds.world import find_misplaced, world_name

MAX_BYTES = 2**20
OPTION, EVERYBODY = "--features-file", "*"
MAX_UNIT = 40
ADVICE = 'write NAME = "UNIT", or NAME = { unit = "UNIT", range = [LOW, HIGH] }'


def with_names(world: World, path: Path) -> World:
    """The world with the features that a file names. InputError or UnknownNameError where the file does not fit it."""
    if isinstance(world, Remembering):
        return Remembering(with_names(world.plain, path), world.group)
    if isinstance(world, ParticleWorld):
        raise InputError(
            "the features of our own games have names and meanings", f"{OPTION}: {world.name}", "leave it out"
        )
    data = runs.read(path, MAX_BYTES)
    try:
        tables = tomllib.loads(data.decode())
    except (tomllib.TOMLDecodeError, ValueError, RecursionError) as error:
        raise InputError("not a TOML file", f"{path}: {error}"[:200], ADVICE) from None
    known = tuple(dict.fromkeys((*world.agents, *world.teams, EVERYBODY)))
    for name in tables:
        if name not in known:
            raise UnknownNameError("agent or team", escape_text(name), known, str(path))
    renamed = copy(world)
    renamed.features = tuple(_name_features(world, agent, tables, path) for agent in range(len(world.agents)))
    renamed.features_from = hashlib.sha256(data).hexdigest()
    return renamed


def _name_features(world: World, agent: int, tables: Mapping[str, Any], path: Path) -> tuple[FeatureSpec, ...]:
    """An agent's features; those that no table names stay as they are, those of a mask always do."""
    features, name = world.features[agent], world.agents[agent]
    table = next((each for each in (name, world.team_of(name), EVERYBODY) if each in tables), None)
    if table is None:
        return features
    where = f"{path}: [{table}]"
    mask = {place for place in world.mask(agent) or () if place is not None}
    places = [place for place in range(len(features)) if place not in mask]
    rows: dict[str, Any] = tables[table] if isinstance(tables[table], dict) else {}
    if len(rows) != len(places):
        count = len(rows)
        what = f"{count} features are named, but {name} observes {len(places)} numbers beside its mask"
        raise InputError(
            what if mask else what.removesuffix(" beside its mask"), where, "name them all, in their order"
        )
    own = [features[place].name for place in places]
    wrong = find_misplaced(own, list(rows))
    if wrong is not None:
        what = f"feature {wrong} of {name} is {own[wrong]}, and the file calls it {list(rows)[wrong]}"
        raise InputError(what, where, f"name them in their order: {', '.join(own[:30])}")
    specs = list(features)
    for place, (key, value) in zip(places, rows.items(), strict=True):
        specs[place] = _feature(features[place], key, value, where)
    taken: set[str] = set()
    for feature in specs:
        if identifier(feature.name) in taken:
            what = f"the name {feature.name} is taken: names differ by more than case, and from those of a mask"
            raise InputError(what, where, "choose another name")
        taken.add(identifier(feature.name))
    return tuple(specs)


def _feature(feature: FeatureSpec, name: str, value: Any, where: str) -> FeatureSpec:
    place = f"{where}: {escape_text(name)[:60]}"
    if not NAME.fullmatch(name):
        raise InputError("not a legal name of a feature", place, "a letter, then letters, digits, _ or -")
    stated: dict[str, Any] = {"unit": value} if isinstance(value, str) else value
    if not isinstance(value, str | dict) or not set(stated) <= {"unit", "range"}:
        raise InputError("neither a unit nor a table of unit and range", place, ADVICE)
    unit = stated.get("unit", feature.unit)
    if not isinstance(unit, str) or not unit.isprintable() or not 0 < len(unit) <= MAX_UNIT:
        raise InputError(f"the unit is not a text of 1 to {MAX_UNIT} characters that can be printed", place, ADVICE)
    low, high = feature.low, feature.high
    if "range" in stated:
        ends: list[Any] = cast("list[Any]", stated["range"]) if isinstance(stated["range"], list) else []
        if len(ends) != 2 or not all(type(end) in (int, float) for end in ends):
            raise InputError("the range is not [LOW, HIGH]", place, ADVICE)
        low, high = ends
        if not -MAX_LENGTH <= low <= high <= MAX_LENGTH:  # integers of any length
            raise InputError(f"the range needs LOW <= HIGH within {MAX_LENGTH:g}", place, ADVICE)
    return replace(feature, name=name, unit=unit, low=float(low), high=float(high))


NO_WORLD = "no built-in game has the profile's world, agents, features and actions, with float32 observations"
REPLAYED = "episode replay: only built-in games can be replayed"
OWN_NAMES = "names"  # in a provenance: of features and actions, where the world has no more than numbers
FEATURES_FILE = "features_file"  # in a provenance: the hash of a file that named the features
UNREPAIRED = (
    "repairs are for claims about landmarks; to change what this team does over observations, change the file that it "
    "came from, or learn from counterexamples: `maviper extract --counterexamples`"
)
OBSERVED = "claim what agents do over observations: see `maviper guide claims`"


def matching_world(profile: ir.PolicyProfile) -> World | None:
    """Our world with exactly the profile's spec, agents, teams, features and actions, or None."""
    try:
        world = remembering(find_built_in(world_name(profile.world)), profile)
    except InputError:  # another's world, or options of another version
        return None
    return world if plays(profile, world) else None


def not_ours(world: ir.WorldSpec) -> str:
    """Why no episode of a game can be replayed that is none of ours; "" for one of ours, in whatever version."""
    if world.name in WORLDS:
        return ""
    return (
        f"{REPLAYED}, and {world.reference or 'an imported tree plays none'}{' is not one' if world.reference else ''}"
    )


def matching_places(profile: ir.PolicyProfile) -> ParticleWorld | None:
    """Returns the world of `matching_world` if agents have places in it, or None."""
    world = matching_world(profile)
    return world if isinstance(world, ParticleWorld) else None


def ensure_places(world: ir.WorldSpec, features: Iterable[FeatureSpec], advice: str = OBSERVED) -> None:
    """InputError, with an advice, where a world has neither landmarks nor a feature that says where something is."""
    if not world.landmarks and all(feature.meaning is None for feature in features):
        what = f"claims speak of places and landmarks, and {world.name} has none"
        raise InputError(what, "", advice)


def plays(profile: ir.PolicyProfile, world: World) -> bool:
    """Returns True if a world has exactly the profile's spec, agents, teams, features and actions, and shows agents
    what they compare. Where a file named the profile's features, they are what the world has by their number alone;
    where an imported tree did, by their number and ranges, unless a name is the world's for something else.
    """
    facts = profile.provenance.training
    named, own = FEATURES_FILE in facts, OWN_NAMES in facts
    if world.spec != profile.world or len(profile.agents) != len(world.agents):
        return False
    if isinstance(world, Remembering) and not all(map(world.remembers_alike, profile.agents)):
        return False
    for agent, policy in enumerate(profile.agents):
        name, features, actions = world.agents[agent], world.features[agent], world.policy_actions[agent]
        if named:
            alike = len(features) == len(policy.features)
        else:
            alike = _nameless(features, own) == _nameless(policy.features, own)
        alike = alike and _nameless(actions, own) == _nameless(policy.actions, own)
        ours, theirs = (name, world.team_of(name), world.given[agent]), (policy.agent, policy.team, policy.outputs)
        if not alike or ours != theirs or policy.numbers != FLOAT32:  # as worlds show what agents observe
            return False
        for known, said in ((features, policy.features), (actions, policy.actions)):
            if find_misplaced([each.name for each in known], [each.name for each in said]) is not None:
                return False
    return True


def _nameless(specs: Sequence[FeatureSpec] | Sequence[ir.ActionSpec], own: bool) -> tuple[object, ...]:
    """Features or actions; without their names where these are a tree's `own`."""
    return tuple(replace(each, name="") for each in specs) if own else tuple(specs)
