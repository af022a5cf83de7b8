"""Scenarios of VMAS as worlds, `vmas:balance,n_agents=3`: many games in one batch, by VMAS's own vectorisation.

Does: makes a scenario with discrete actions, or with VMAS's continuous ones by `continuous_actions=True`; starts each
  game of the batch from its own seed; steps all at once.
Assumes: the package `vmas` (extra `interop`); randomness in a scenario's start only, so that a seed and actions decide.
Does not: know what observations mean; end one agent's episode before the others' (VMAS does not either).
"""

from __future__ import annotations

import math
import re
import warnings
from collections.abc import Generator, Sequence
from contextlib import contextmanager
from copy import copy
from importlib import import_module
from itertools import product
from typing import Any

import numpy as np

from codegen.dynamics import motionless
from codegen.errors import InputError, MissingToolError, UnknownNameError
from codegen.ir import MAX_LENGTH, ActionSpec, Bool, FeatureSpec, Float32, Float64, OutputSpec
from codegen.process import FILTERS
from maviper.worlds.outside import sources
from maviper.worlds.outside.playing import MOMENTS, PAST, EnvStates, OutsideWorld
from maviper.worlds.outside.sources import is_mapping
from maviper.worlds.outside.spaces import MAX_FEATURES, bounds_of, fault_of
from maviper.worlds.seeds import fold_seed
from maviper.worlds.world import RETURN, Int, Measure

GAMES = 256  # in a batch
USUAL_STEPS = 100  # most scenarios go on until somebody stops them
OURS = ("device", "num_envs", "seed", "wrapper", "dict_spaces", "multidiscrete_actions", "clamp_actions")
GIVING = "continuous_actions"  # the option by which agents give numbers
FORCES = ("force_x", "force_y")  # what the two numbers of a body are that is pushed as they say


class VmasWorld(OutsideWorld):
    """The scenario that `text` names, GAMES games of it at once. Seeds of games: see `fold_seed`.

    MissingToolError without the package; UnknownNameError or InputError for what cannot be played.
    """

    games = GAMES

    def __init__(self, text: str) -> None:
        self.source = sources.parse_source(text)
        self._env = self._make_games(GAMES)
        agents = sources.legal_names([agent.name for agent in self._env.agents], "agent")
        steps = self.source.options.get(sources.MAX_STEPS)
        if steps is not None and (not isinstance(steps, int) or steps < 1):
            raise InputError(f"{sources.MAX_STEPS} is '{steps}'", text, "give a number from 1")
        name = re.sub(r"[^A-Za-z0-9_-]+", "-", f"vmas-{self.source.function}")
        self.length_known = self.length_stated = steps is not None
        self.spec = motionless(name, self.source.reference, agents, steps or USUAL_STEPS, self.source.options)
        self.teams = sources.teams_by_name(agents)
        self.measures = tuple(Measure(team, RETURN) for team in self.teams)
        with self._at_work("reset"):
            self._env.seed(0)
            seen = self._env.reset()
        self.features = tuple(self._features(agent, each) for agent, each in zip(agents, seen, strict=True))
        everybody = list(zip(self._env.agents, self._env.action_space, strict=True))
        giving = bool(self._env.continuous_actions)
        self.outputs = tuple(self._outputs(agent, choices) for agent, choices in everybody) if giving else ()
        names = [() if giving else _name_actions(agent, int(choices.n)) for agent, choices in everybody]
        self.actions = tuple(tuple(ActionSpec(name, None) for name in each) for each in names)
        self._moment = PAST

    def _make_games(self, n_games: int) -> Any:
        """A batch of games of the scenario."""
        try:
            vmas = import_module("vmas")
        except ImportError:
            advice = "install the extra: pip install 'maviper[interop]'"
            raise MissingToolError("VMAS scenarios need the package vmas", self.source.text, advice) from None
        scenario, options = self.source.function, dict(self.source.options)
        known = sorted({*vmas.scenarios, *vmas.mpe_scenarios, *vmas.debug_scenarios})
        if scenario not in known:
            raise UnknownNameError("VMAS scenario", scenario, known, self.source.text)
        taken = [key for key in options if key in OURS]
        if taken:
            what = f"{taken[0]} is not a scenario's option: {GAMES} games play at once"
            raise InputError(what, self.source.text, "leave it out")
        given = {key: sources.value_of(value) for key, value in options.items() if key != sources.MAX_STEPS}
        given.setdefault(GIVING, False)
        settings: dict[str, Any] = {"terminated_truncated": True, "seed": 0}
        with FILTERS, self._at_work("make_env"), warnings.catch_warnings(record=True) as said:
            warnings.simplefilter("always")
            env = vmas.make_env(scenario, num_envs=n_games, **settings, **given)
        unused = [str(each.message) for each in said if "passed but not used" in str(each.message)]
        if unused:
            where = f"{self.source.text}: {unused[0][:120]}"
            raise InputError("the scenario has no such option", where, "leave it out")
        return env

    @contextmanager
    def _at_work(self, doing: str) -> Generator[None]:
        """Sends VMAS's output to standard error, and turns what it raises into an InputError."""
        try:
            with sources.output_aside():
                yield
        except (Exception, SystemExit) as error:
            raise sources.fault(error, self.source, f"VMAS's {doing}") from error

    def _features(self, agent: str, seen: Any) -> tuple[FeatureSpec, ...]:
        """Features of one agent's observations in the whole batch, which may be a tensor or a dictionary of them."""
        parts = seen.items() if is_mapping(seen) else [("feature", seen)]
        names = [f"{key}_{place}" for key, part in parts for place in range(math.prod(part.shape[1:]))]
        if not 1 <= len(names) <= MAX_FEATURES:
            what = f"{agent} observes {len(names):,} numbers, of 1 to {MAX_FEATURES:,}"
            raise InputError(what, self.source.text, "choose another scenario, or other options")
        bounds = -MAX_LENGTH, MAX_LENGTH
        return tuple(FeatureSpec(name, "none", *bounds, None) for name in sources.legal_names(names, "feature"))

    def _outputs(self, agent: Any, choices: Any) -> tuple[OutputSpec, ...]:
        """The numbers that an agent gives. Those of a holonomic body are forces along the axes, before VMAS scales
        them.
        """
        from gymnasium.spaces import Box

        box = Box(choices.low, choices.high, dtype=np.float32)  # VMAS's own is one of the old package gym
        wrong = fault_of(box)
        if wrong:
            raise InputError(
                f"{agent.name}: {wrong.what}", self.source.text, "choose another scenario, or other options"
            )
        ends = bounds_of(box)
        pushed = type(agent.dynamics).__name__ == "Holonomic" and len(ends) == len(FORCES)
        names = FORCES if pushed else [f"output_{k}" for k in range(len(ends))]
        return tuple(OutputSpec(name, "none", *each) for name, each in zip(names, ends, strict=True))

    def start_from_seeds(self, seeds: Sequence[int] | Int) -> EnvStates:
        """The start states of at most `games` games, each after VMAS's `seed` and its `reset_at`."""
        assert 0 < len(seeds) <= GAMES, f"{len(seeds)} games asked of {GAMES}"
        self._moment = PAST
        with self._at_work("reset"):
            for place, seed in enumerate(seeds):
                self._env.seed(fold_seed(int(seed)))
                self._env.reset_at(place, return_observations=False)
            self._env.seed(0)
            seen, ended = self._env.get_from_scenario(
                get_observations=True, get_rewards=False, get_infos=False, get_dones=True
            )[:2]
        n = len(seeds)
        done = np.repeat(_array(ended)[:n, None] != 0, len(self.agents), axis=1)
        return self._enter_states(tuple(self._rows(each, n) for each in seen), np.zeros(done.shape), done)

    def step(self, state: EnvStates, actions: Int) -> EnvStates:
        """The next states; RuntimeError for any state but the newest. A game that has ended keeps its observations."""
        if state.moment == PAST or state.moment != self._moment:
            raise RuntimeError("only the newest state of all games can be stepped: the batch has moved on")
        acted = np.zeros((GAMES, *self.acting_shape), np.float32)
        acted[: len(state)] = np.asarray(actions)
        self._moment = PAST  # in case it fails
        with self._at_work("step"):
            seen, paid, ended, _, _ = self._env.step(self._columns(acted))
        n, over = len(state), state.done
        rows = [self._rows(each, n) for each in seen]
        observations = tuple(np.where(over[:, [k]], state.observations[k], each) for k, each in enumerate(rows))
        rewards = np.stack([_array(each)[:n].reshape(n).astype(np.float64) for each in paid], axis=1)
        return self._enter_states(observations, np.where(over, 0.0, rewards), over | (_array(ended)[:n, None] != 0))

    def _columns(self, acted: Float32) -> list[Float32]:
        """Returns each agent's actions in all games, [GAMES, 1], or the numbers that it gives, within its bounds."""
        if not self.continuous:
            return [column[:, None].copy() for column in acted.T]
        columns: list[Float32] = []
        for place, (low, high) in enumerate(self.bounds):
            columns.append(np.clip(acted[:, place, : len(low)], low, high).astype(np.float32))
        return columns

    def _enter_states(self, observations: tuple[Float32, ...], rewards: Float64, done: Bool) -> EnvStates:
        self._moment = next(MOMENTS)
        return EnvStates(observations, rewards, done, done, ~done, np.empty((*done.shape, 0)), self._moment)

    def _rows(self, seen: Any, n: int) -> Float32:
        """The first `n` games' observations, [n, n_features]."""
        parts = seen.values() if is_mapping(seen) else [seen]
        found = [_array(part)[:n].reshape(n, -1) for part in parts]
        return np.concatenate(found, axis=1).astype(np.float32)

    def reference_env(self) -> Any:
        """A fresh batch of one game, as VMAS makes it."""
        return self._make_games(1)

    def apart(self) -> VmasWorld:
        """The same world with a batch of its own, so that both can play."""
        twin = copy(self)
        twin._env, twin._moment = self._make_games(GAMES), PAST
        return twin


def _name_actions(agent: Any, n_actions: int) -> list[str]:
    """Names of an agent's actions. Of three on each of two axes the first stays, as VMAS has it."""
    if list(agent.discrete_action_nvec) != [3, 3] or n_actions != 9:
        return [f"action_{k}" for k in range(n_actions)]
    pairs = product(("", "left", "right"), ("", "down", "up"))
    return ["_".join(filter(None, pair)) or "stay" for pair in pairs]


def _array(tensor: Any) -> Any:
    return tensor.detach().cpu().numpy()
