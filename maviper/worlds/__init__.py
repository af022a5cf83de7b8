"""Worlds: our games, environments of other people, and systems that files state.

Does: finds a world by its name and options, `predator-prey,prey=1`; a user's environment by `module:function`; hands
  ours out as PettingZoo environments.
Assumes: a game is a class whose constructor's parameters are its options.
Does not: know policies, experts or learning.
"""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable, Mapping
from functools import partial
from typing import TYPE_CHECKING, Any

from codegen.errors import InputError, UnknownNameError
from maviper.worlds.games.cooperative_navigation import CooperativeNavigation
from maviper.worlds.games.coordination import RULES, Coordination
from maviper.worlds.games.features import GROUPS
from maviper.worlds.games.particle import PHYSICS_NAMES, ParticleWorld, WorldState
from maviper.worlds.games.physical_deception import PhysicalDeception
from maviper.worlds.games.predator_prey import OBSERVATIONS, PredatorPrey
from maviper.worlds.outside.making import add_maker
from maviper.worlds.outside.sources import SYSTEM, VMAS, Source, is_named_by_user, parse_source
from maviper.worlds.outside.spaces import refuse_numbers
from maviper.worlds.remembering import Remembering, split_memory
from maviper.worlds.world import Measure, World

if TYPE_CHECKING:
    from maviper.worlds.games.exported import WorldEnv

WORLDS: Mapping[str, type[World]] = {
    "physical-deception": PhysicalDeception,
    "cooperative-navigation": CooperativeNavigation,
    "predator-prey": PredatorPrey,
    "coordination": Coordination,
}
MAX_OF_A_KIND = 24  # agents, targets, obstacles
OF_GYMNASIUM = re.compile(r"[A-Za-z0-9_/]+-v[0-9]+")
SWITCHES = ("velocity", "shuffled", "continuous")
WORDS = {
    "features": GROUPS,
    "physics": PHYSICS_NAMES,
    "observation": OBSERVATIONS,
    "rule": RULES,
}  # that options may be
MEANINGS = {
    "defenders": "defenders, and as many landmarks",
    "velocity": "1: agents also observe their own velocity, as their last two features",
    "shuffled": "1: each agent sees the landmarks in an order of its own, drawn anew for each episode",
    "continuous": "1: agents give numbers in place of actions",
    "features": "further features, several with +; see maviper guide extraction",
    "physics": "how agents move; see maviper guide games",
    "agents": "agents, in navigation as many landmarks",
    "predators": "slower agents that chase",
    "prey": "faster agents that flee",
    "obstacles": "fixed obstacles",
    "observation": "what agents observe; paper: signs of distances, mpe2: distances, released: the authors' code",
    "conventions": "actions of each agent; 3 with climbing and penalty",
    "signals": "features of each agent",
    "levels": "values of a signal",
    "kinds": "groups of agents that read different signals well",
    "noise": "percent of wrong readings",
    "blur": "percent to add where a signal is not read clearly",
    "payoff": "percent of all or nothing",
    "agree": "percent that agreeing on a wrong convention is worth",
    "rule": "payoffs",
    "table": "which table from states to conventions",
}


def _maker_of(file: str) -> Callable[..., Any]:
    """Returns the maker of the environment of a world file. Its modules are imported where a name asks for it."""
    from maviper.worlds.stated.environment import make_environment

    return partial(make_environment, file)


add_maker(SYSTEM, _maker_of)


def find(name: str | World | Callable[..., Any], giving: bool = False) -> World:
    """The world of that name and options, of a function that returns an environment, or of a vector environment of
    Gymnasium, whose games are played as ours are; UnknownNameError with the closest match, or InputError, otherwise.

    `giving`: whether its agents may give numbers in place of choosing among actions. Whoever asks says so: elsewhere
    such a world is refused. `module:function` imports and runs a user's code, so a name that a data file states goes to
    `find_built_in` instead.
    """
    world = name if isinstance(name, World) else _resolve_world(name)
    if world.continuous and not giving:
        raise refuse_numbers(world.name)
    return world


def _resolve_world(name: str | Callable[..., Any]) -> World:
    if not isinstance(name, str):
        from maviper.worlds.outside.pettingzoo import PettingZooWorld

        if hasattr(name, "single_observation_space"):
            from maviper.worlds.outside.wrappers import of_batch

            name = of_batch(name)
        return PettingZooWorld(name, Source.of(name))
    plain, remembers = split_memory(name)
    if remembers:
        return Remembering(_resolve_world(plain), remembers)
    if not is_named_by_user(name):
        if OF_GYMNASIUM.fullmatch(name.partition(",")[0]):
            what = f"unknown world '{name}'"
            raise InputError(what, "", f"a game of Gymnasium is named by its module: gymnasium:{name}")
        if name.partition(",")[0].endswith(".toml"):
            raise InputError(f"unknown world '{name}'", "", f"a system defined in a world file is named system:{name}")
        return find_built_in(name)
    if parse_source(name).module == VMAS:
        from maviper.worlds.outside.vmas import VmasWorld

        return VmasWorld(name)
    from maviper.worlds.outside.pettingzoo import user_world

    return user_world(name)


def find_built_in(name: str) -> World:
    """Finds a world among our own games only: nothing is imported or run, whatever the name says; see `find`."""
    game, *choices = name.split(",")
    if game not in WORLDS:
        raise UnknownNameError("world", game, WORLDS, "an environment of your own is named module:function")
    usual = options_of(game)
    options: dict[str, int | str] = {}
    for choice in choices:
        key, separator, value = choice.partition("=")
        if key not in usual:
            raise UnknownNameError("option", key, usual, name)
        if not separator or not value:
            raise InputError(f"option {key} has no value", name, f"write {game},{key}=VALUE")
        if key in options:
            raise InputError(f"option {key} is given twice", name, "give it once")
        options[key] = _number(key, value, name) if isinstance(usual[key], int) else value
    make: Callable[..., World] = WORLDS[game]
    return make(**options)


def parallel_env(name: str, render_mode: str | None = None) -> WorldEnv:
    """One of our games as a PettingZoo parallel environment; observations and rewards are those of `find(name)`.

    `render_mode`: None or `rgb_array`. Names, errors: of `find_built_in`; UnknownNameError for another mode.
    """
    from maviper.worlds.games.exported import WorldEnv

    return WorldEnv(find_built_in(name), render_mode)


def options_of(game: str) -> dict[str, int | str]:
    """The options of one of our games, with their defaults."""
    return {key: parameter.default for key, parameter in inspect.signature(WORLDS[game]).parameters.items()}


def range_of(game: str, key: str) -> tuple[int, int]:
    """The least and the most that an option which is a number may be."""
    usual = (0, 1) if key in SWITCHES else (0 if key == "obstacles" else 1, MAX_OF_A_KIND)
    return WORLDS[game].ranges.get(key, usual)


def explain_option(game: str, key: str) -> str:
    """Describes an option of one of our games: its values, its default, its meaning."""
    usual = options_of(game)[key]
    values = ", ".join(WORDS[key]) if key in WORDS else "{} to {}".format(*range_of(game, key))
    return f"{values} (default: {'none' if usual == '' else usual})  {MEANINGS[key]}"


def _number(key: str, text: str, where: str) -> int:
    low, high = range_of(where.partition(",")[0], key)
    if not (text.isascii() and text.isdigit() and len(text) < 9) or not low <= int(text) <= high:
        raise InputError(f"option {key} is '{text[:20]}'", where, f"give a number from {low} to {high}")
    return int(text)


__all__ = [
    "WORLDS",
    "CooperativeNavigation",
    "Coordination",
    "Measure",
    "ParticleWorld",
    "PhysicalDeception",
    "PredatorPrey",
    "World",
    "WorldState",
    "explain_option",
    "find",
    "find_built_in",
    "options_of",
    "parallel_env",
    "range_of",
]
