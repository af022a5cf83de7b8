"""Trees of others as the agents of a game: played and verified like any other.

Does: gives each agent of a world its tree; ties features by name or place and actions by number or name; refuses what
  does not fit; plays a few episodes, in which ranges of features and visits of leaves are seen.
Assumes: `codegen.importers` has read the trees, and replays them; a world that a user named.
Does not: guess: a name that the world does not know is an error.

Numbers that a source gives are the world's outputs, in their order, cut to the world's bounds, as programs that play
its experts cut them.

Features are tied by name where the source knows some by the world's names, else by place. A whole number that a source
returns is the action of that number, in the environment's own count, which may begin elsewhere than at 0. Where the
world calls its features feature_0, feature_1, ... or its actions action_0, ..., the names that the source has for them
are kept.
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from codegen import ir
from codegen.check import identifier
from codegen.deciding import list_bounds
from codegen.errors import InputError, UnknownNameError, escape_text
from codegen.floats import FLOAT32
from codegen.importers.names import NUMBERED, Renaming, format_first, legal, renaming
from codegen.importers.origin import Names, profile_of
from codegen.importers.reading import Origin
from codegen.profiles import ensure
from codegen.wording import format_count
from maviper.episodes import measures
from maviper.episodes.trees import Counting
from maviper.worlds import WORLDS, World, find
from maviper.worlds.matching import OWN_NAMES
from maviper.worlds.outside.sources import is_named_by_user
from maviper.worlds.world import find_misplaced

EPISODES = 100  # that the trees play, so that the ranges of what they observe are known
MINUS = "minus_"
COUNTED = re.compile(rf"action_({MINUS})?[0-9]+")
ONE_VALUE = re.compile(r"(^|_)is_(minus_)?[0-9]+$")  # a feature of `wrap=flatten`
MAP = "write --{kind}s NEW=OLD for each that the world calls otherwise"


Spoken = Sequence[str] | None  # the names that a user gives, in order or as new=old


def find_game(name: str) -> World | None:
    """The game of ours, or the environment of a user, that a name says; None: neither."""
    return find(name, giving=True) if name in WORLDS or is_named_by_user(name) else None


def tie_trees(origins: Mapping[str, Origin], world: World, features: Spoken, actions: Spoken) -> ir.PolicyProfile:
    """The profile of a world's agents, each with one of the trees; observations are float32, as worlds show them.

    InputError where the world has other agents, features or actions than the trees.
    """
    policies: list[ir.AgentPolicy] = []
    facts: dict[str, Any] = {"observations": FLOAT32, OWN_NAMES: "the trees' own where the world has numbers"}
    sources: list[str] = []
    for place, (agent, origin) in enumerate(zip(world.agents, _by_agent(origins, world), strict=True)):
        policy, told = _tie_agent(origin, agent, world, place, features, actions)
        policies.append(policy)
        facts |= told
        sources.append(origin.kind)
    provenance = ir.Provenance("imported", "none", 0, "", ", ".join(dict.fromkeys(sources)), facts)
    profile = ensure(ir.PolicyProfile(world.spec, tuple(policies), provenance))
    # what the policies meet in episodes of the world
    counting = Counting(world, profile.agents)
    seeds = range(measures.MEASUREMENT_SEEDS, measures.MEASUREMENT_SEEDS + EPISODES)
    measures.evaluate(world, [counting] * len(profile.agents), seeds)
    return replace(profile, agents=counting.annotate_policies())


def _by_agent(origins: Mapping[str, Origin], world: World) -> list[Origin]:
    """The tree of each agent. A single tree is that of a single agent, whatever it is called."""
    if len(origins) == len(world.agents) == 1:
        return list(origins.values())
    known = {identifier(agent): agent for agent in world.agents}
    trees = {known.get(identifier(name), name): origin for name, origin in origins.items()}
    for name in trees:
        if name not in world.agents:
            raise UnknownNameError("agent", name, world.agents, world.name)
    missing = [agent for agent in world.agents if agent not in trees]
    if missing:
        what = f"{world.name} has {format_count(len(world.agents), 'agent')}, and {', '.join(missing)} has no tree"
        files = ",".join(f"{agent}=FILE" for agent in world.agents)
        raise InputError(what, "", f"give each agent a tree: --agents {files}")
    return [trees[agent] for agent in world.agents]


def _tie_agent(
    origin: Origin, agent: str, world: World, place: int, features: Spoken, actions: Spoken
) -> tuple[ir.AgentPolicy, dict[str, float | int | str]]:
    """An agent's policy, and what is told of it."""
    specs, choices = world.features[place], world.actions[place]
    tied, names = _features(origin, agent, [each.name for each in specs], renaming(features))
    if origin.vectors or world.continuous:
        return _giving(tied, names, agent, world, place)
    known = [each.name for each in choices]
    first = world.counted_from[place] if world.counted_from and not _is_placed(origin.placed, known) else 0
    numbers = _numbers(origin, agent, known, first, renaming(actions))
    taken = _action_names(origin, numbers, known, first, renaming(actions))
    source = replace(tied, labels=tuple(numbers), called={})
    profile = profile_of({agent: source}, Names(names, taken), FLOAT32)
    (policy,) = profile.agents
    kept = zip(specs, policy.features, strict=True), zip(choices, policy.actions, strict=True)
    policy = replace(
        policy,
        agent=agent,
        team=world.team_of(agent),
        features=tuple(replace(spec, name=own.name) for spec, own in kept[0]),
        actions=tuple(replace(spec, name=own.name) for spec, own in kept[1]),
    )
    returned = dict(zip(numbers, origin.labels, strict=True))
    lines = (
        f"{k} {each.name} <- {returned[k]}" if k in returned else f"{k} {each.name} (no leaf)"
        for k, each in enumerate(policy.actions)
    )
    (before, *_) = {key.rpartition(" ")[0] for key in profile.provenance.training if key.endswith(" given")}
    told = {f"{agent}{key.removeprefix(before)}": value for key, value in profile.provenance.training.items()}
    return policy, {**told, f"{agent} actions": ", ".join(lines)}


def _giving(
    origin: Origin, names: Sequence[str], agent: str, world: World, place: int
) -> tuple[ir.AgentPolicy, dict[str, float | int | str]]:
    """The policy of an agent that gives numbers, cut to the world's bounds. `names`: those of its features."""
    outputs = world.given[place]
    if not origin.vectors or not outputs:
        what = "gives numbers, and the world takes actions" if origin.vectors else "takes actions, and gives no numbers"
        raise InputError(f"the tree of {agent} {what}", world.name, "--outputs says that numbers are given")
    given = [each.name for each in outputs]
    _ensure_count(len(origin.vectors[0]), given, agent, "output")
    profile = profile_of({agent: origin}, Names(names, outputs=given), FLOAT32)
    (policy,) = profile.agents
    for (_, low, high), spec in zip(list_bounds(policy), outputs, strict=True):
        below = low is None or (spec.low is not None and low <= spec.low)
        above = high is None or (spec.high is not None and high >= spec.high)
        if not (below and above):  # the source cuts away what the world does not
            what = f"the source cuts {spec.name} to [{low}, {high}], and the world to [{spec.low}, {spec.high}]"
            raise InputError(what, agent, "leave the cut out, or test the sum: if u > 1: return 1.0")
    kept = zip(world.features[place], policy.features, strict=True)
    seen = tuple(replace(spec, name=own.name) for spec, own in kept)
    policy = replace(policy, agent=agent, team=world.team_of(agent), features=seen, outputs=outputs)
    (before, *_) = {key.rpartition(" ")[0] for key in profile.provenance.training if key.endswith(" given")}
    return policy, {f"{agent}{key.removeprefix(before)}": value for key, value in profile.provenance.training.items()}


# --- features


def _features(origin: Origin, agent: str, known: list[str], given: Renaming) -> tuple[Origin, list[str]]:
    """The source, which looks its features up by the world's names, or by place; and what they are called."""
    if given.plain is not None:  # the user's names for the world's features
        known = _call_anew(known, given.plain, agent, "feature")
    own = [given.rename(each) for each in origin.features]
    keys = {identifier(legal(each, "x")): each for each in known}
    inside = [identifier(legal(each, "x")) in keys for each in own]
    if origin.keyed or any(inside):
        for name, there in zip(own, inside, strict=True):
            if not there:
                raise UnknownNameError("feature", escape_text(name), known, f"{agent}: {MAP.format(kind='feature')}")
        notes, order = origin.notes, [list(keys).index(identifier(legal(each, "x"))) for each in own]
        if not origin.keyed and order != sorted(order):  # the world hands them over by place: either may be meant
            listed = ", ".join(map(escape_text, own[:30]))
            notes = (f"features are tied by name: the source has them in the order {listed}", *notes)
        return replace(origin, features=tuple(own), keyed=True, notes=notes), known
    if own or origin.n_features:
        _ensure_count(len(own) or origin.n_features, known, agent, "feature")
    read = max(origin.n_named, origin.n_read)
    if read > len(known):
        what = f"the source reads feature {read - 1}, and {agent} observes {len(known)}, from 0 on"
        raise InputError(what, agent, f"the world shows {', '.join(known)}")
    names = own if own and _is_numbered(known) else known
    return replace(origin, features=(), n_features=len(known)), names


def _call_anew(known: Sequence[str], names: Sequence[str], agent: str, kind: str) -> list[str]:
    """The user's names, in the order of the world. InputError for another number of them, and for a name of the world
    that stands elsewhere in it: the user means another order, and would get another action or feature.
    """
    _ensure_count(len(names), known, agent, kind)
    place = find_misplaced(known, names)
    if place is not None:
        what = f"{kind} {place} of {agent} is {known[place]} in this world, and --{kind}s calls it {names[place]}"
        advice = f"names are in the world's order, {', '.join(known[:30])}; leave --{kind}s out to keep these"
        raise InputError(what, agent, advice)
    return list(names)


def _ensure_count(count: int, known: Sequence[str], agent: str, kind: str) -> None:
    if count != len(known):
        what = f"{count} {kind}{'s' if count != 1 else ''} for {agent}, who has {len(known)} in this world"
        advice = f"they are {format_first(known)}"
        if count < len(known) and sum(map(bool, map(ONE_VALUE.search, known))) > 1:
            advice += "; these are values of whole numbers, which wrap=numbers shows as they are"
        raise InputError(what, agent, advice)


def _is_placed(names: Sequence[str], known: Sequence[str]) -> bool:
    """Returns True if a profile's actions have the world's places: so many, and none has another one's number."""
    fits = (name == own or not COUNTED.fullmatch(name) for name, own in zip(names, known, strict=False))
    return len(names) == len(known) and all(fits)


def _is_numbered(names: Sequence[str], first: int = 0) -> bool:
    """Returns True if names say no more than places, which are counted from `first` on."""
    parts = [NUMBERED.fullmatch(each) for each in names]
    return all(
        part is not None and int(part[2]) * (-1 if part[1].endswith(MINUS) else 1) == k
        for k, part in enumerate(parts, first)
    )


# --- actions


def _numbers(origin: Origin, agent: str, known: list[str], first: int, given: Renaming) -> list[int]:
    """The number in the world of each action that a source returns. `first`: what the environment calls number 0."""
    if given.plain is not None:
        known = _call_anew(known, given.plain, agent, "action")
    keys = {identifier(legal(each, "action")): k for k, each in enumerate(known)}
    indices = [_number(label, str(origin.called.get(label, "")), keys, first, given) for label in origin.labels]
    for label, number in zip(origin.labels, indices, strict=True):
        if number is None or number >= len(known):
            what = f"the source returns {escape_text(str(label))}, which is no action of {agent}"
            all_of = ", ".join(f"{k} {name}" for k, name in enumerate(known[:30], first))
            raise InputError(what, f"{agent}: its actions are {all_of}", MAP.format(kind="action"))
    numbers = [number for number in indices if number is not None]
    if len(set(numbers)) < len(numbers):
        raise InputError("two of the source's answers are the same action", agent, MAP.format(kind="action"))
    return numbers


def _number(label: Any, called: str, keys: Mapping[str, int], first: int, given: Renaming) -> int | None:
    """The number of one action: as the user says, as the number that the environment has for it, or by its name."""
    plain = label.item() if hasattr(label, "item") else label
    for old in (str(plain), called):
        if old in given.pairs:
            return keys.get(identifier(legal(given.pairs[old], "action")))
    if isinstance(plain, int | float):
        return int(plain) - first if plain >= first and plain == plain // 1 else None
    return keys.get(identifier(legal(plain, "action"))) if isinstance(plain, str) else None


def _action_names(origin: Origin, numbers: Sequence[int], known: list[str], first: int, given: Renaming) -> list[str]:
    """Names the world's actions: as the user says, or the source where the world has numbers."""
    if given.plain is not None:
        return list(given.plain)
    if not _is_numbered(known, first):
        return known
    called = dict(zip(numbers, (origin.called.get(label, "") for label in origin.labels), strict=True))
    return [str(called.get(k) or name) for k, name in enumerate(known)]
