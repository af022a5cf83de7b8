"""The built-in properties as a list, and property files to start from.

Does: names, sentences, and parameters with their defaults; writes commented claims with the names of a world or of a
  profile, over observations too; each of them can be asked as it is.
Assumes: for a file the name of a world, or the path of a profile's .json file.
Does not: decide, or say that a claim holds.
"""

import re
from fractions import Fraction
from itertools import chain
from pathlib import Path
from typing import Any, NamedTuple

from codegen.errors import InputError
from codegen.ir import MAX_LENGTH, ROOT, FeatureSpec, PolicyProfile, Tree
from codegen.lowering.render import render
from maviper.files.profiles import load
from maviper.verification.ask import format_parameter
from maviper.worlds import WORLDS, World, find
from maviper.worlds.matching import ensure_places, matching_world
from verify.claims.catalogue import NAMES, ZONES, in_general, readable, usual
from verify.claims.views import unread
from verify.decimals import exact, plain
from verify.question import Budgets


def list_properties() -> list[dict[str, Any]]:
    """The built-in properties as plain data: name, sentence, parameters with their defaults as texts.

    A text is empty where the default depends on the world.
    """
    properties: list[dict[str, Any]] = []
    for name in NAMES:
        values = usual(name) | ({ZONES: Budgets().max_zones} if ZONES in readable(name) else {})
        defaults = {key: "" if value is None else format_parameter(value) for key, value in values.items()}
        properties.append({"name": name, "sentence": in_general(name), "parameters": defaults})
    return properties


PLAIN = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")  # a name that formulas take without quotes
DIGITS = 3


def starter(subject: str) -> str:
    """A commented property file for a world, or for the profile in a .json file."""
    if not subject.endswith(".json"):
        return _of_world(find(subject), subject)
    profile = load(subject)
    played = matching_world(profile)
    if played is not None and not unread(profile):
        return _of_world(played, played.name)
    return _render_observed(profile, Path(subject).name)


def _of_world(world: World, name: str) -> str:
    """About world states, with the world's agents, landmarks and actions; else about observations."""
    try:
        ensure_places(world.spec, chain(*world.features))
    except InputError:
        if world.spec.name in WORLDS:
            raise
        return _render_observed(world, name)
    teams = {team: list(members) for team, members in world.teams.items()}
    marks = [mark.name for mark in world.spec.landmarks]
    fitting = [team for team, members in teams.items() if len(members) == len(marks)]
    team = fitting[0] if fitting else max(teams, key=lambda name: len(teams[name]))
    actions = [action.name for action in world.actions[world.agents.index(teams[team][0])]]
    meanings = [one.meaning for features in world.features for one in features]
    seen = {name for meaning in meanings if meaning is not None for _, name in meaning.terms}
    return render(
        "properties/starter.toml.j2",
        world=name,
        teams=teams,
        team=team,
        fits=bool(fitting),
        episodes=bool(fitting) and not any(entity.collides for entity in world.spec.landmarks),
        colliding=[name for name, entity in zip(world.agents, world.spec.agents, strict=True) if entity.collides],
        steps=world.spec.episode_steps,
        agents=teams[team],
        everybody=world.agents,
        landmarks=marks,
        goals=list(world.spec.goals),
        actions=actions,
        velocities=[name for name in world.spec.coordinates() if name in seen and name.endswith((".vx", ".vy"))],
    )


class _Actor(NamedTuple):
    """An agent as a starter shows it."""

    agent: str
    team: str
    features: tuple[FeatureSpec, ...]
    variables: tuple[str, ...]  # what formulas call its features
    actions: tuple[str, ...]  # as formulas write them


def _render_observed(of: World | PolicyProfile, name: str) -> str:
    """About observations: the agents of a world or of a profile, with a bound at which a tree tests."""
    trees = {policy.agent: policy.tree for policy in of.agents} if isinstance(of, PolicyProfile) else {}
    if isinstance(of, PolicyProfile):
        listed = [(policy.agent, policy.team, policy.features, policy.actions) for policy in of.agents]
    else:
        teams = map(of.team_of, of.agents)
        listed = list(zip(of.agents, teams, of.features, of.actions, strict=True))
    alone = len(listed) == 1
    actors = [
        _Actor(
            agent,
            team,
            features,
            tuple(_write_name("" if alone else agent, feature.name) for feature in features),
            tuple(_write_name("", action.name) for action in actions),
        )
        for agent, team, features, actions in listed
    ]
    actor = max(actors, key=lambda each: len(trees[each.agent].feature) if trees else 0)
    place, bound = _pick_test(actor, trees.get(actor.agent))
    return render(
        "properties/observed.toml.j2",
        about=name,
        profile=name if trees else "PROFILE",
        actors=actors,
        actor=actor,
        acting=_write_name("", actor.agent),
        place=place,
        bound=plain(bound),
        beyond=plain(bound + 1),
    )


def _write_name(agent: str, name: str) -> str:
    """A name as formulas write it."""
    parts = [each if PLAIN.fullmatch(each) else f"'{each}'" for each in (agent, name) if each]
    return ".".join(parts)


def _pick_test(actor: _Actor, tree: Tree | None) -> tuple[int, Fraction]:
    """A feature of an agent, and a number at which its tree, or else its range, is parted."""
    if tree is not None and len(tree.feature) > 1:
        return int(tree.feature[ROOT]), exact(f"{float(tree.threshold[ROOT]):.{DIGITS}f}", "")
    low, high = actor.features[0].low, actor.features[0].high
    middle = (low + high) / 2 if max(abs(low), abs(high)) < MAX_LENGTH else 0.0
    return 0, exact(f"{middle:.{DIGITS}f}", "")
