"""A world that a file states, in play, as a PettingZoo environment.

Does: draws starts and errors by a seed; steps by the rules as they are written, in float64; shows what agents observe.
Assumes: a checked file (verify/systems).
Does not: load with what only proves: PettingZoo takes long to load.

An episode ends where the statement ends: after its steps, or where the state leaves the ranges of the variables.
"""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from typing import TYPE_CHECKING, Any

import numpy as np
from pettingzoo import ParallelEnv

from codegen.errors import InputError
from codegen.ir import FeatureSpec
from codegen.numbers import nearest_single
from maviper.worlds.stated.systems import Floats, FlowRule, Moving, draw_rule, read, start
from verify.systems.observing import function, measure_feature
from verify.systems.system import Affine, Feature, Measure

if TYPE_CHECKING:
    from gymnasium.spaces import Box, Discrete

    from verify.systems.statement import Statement


def make_environment(path: str) -> StatedEnv:
    """The environment of a file. InputError where it states no motion, or agents that give numbers."""
    statement = read(path)
    if not statement.moves:
        raise InputError("the file does not say how the state moves", path, "add [dynamics.next]")
    if statement.gives:
        what = f"{', '.join(statement.gives)} gives numbers, and play of a world file takes actions"
        raise InputError(what, path, "`maviper verify`, `maviper check` and `maviper replay` take such a file")
    return StatedEnv(statement, path)


class StatedEnv(ParallelEnv[str, Any, Any]):
    """A statement in play. It says about itself what `maviper.worlds.outside.pettingzoo` reads."""

    plays_here = True

    def __init__(self, statement: Statement, text: str) -> None:
        from gymnasium.spaces import Box, Discrete

        self.statement, self.metadata = statement, {"name": text}
        self.possible_agents = [agent.name for agent in statement.agents]
        self.agents: list[str] = []
        self.max_cycles = statement.system.steps
        self.state: Floats = {}
        self._moving = Moving(statement)
        self._rewards = {agent.name: function(agent.reward) for agent in statement.agents}
        self.teams: dict[str, tuple[str, ...]] = {}
        for agent in statement.agents:
            self.teams[agent.team] = (*self.teams.get(agent.team, ()), agent.name)
        self.action_names = {agent.name: tuple(agent.actions) for agent in statement.agents}
        self.features: dict[str, list[FeatureSpec]] = {}
        self._boxes: dict[str, Box] = {}
        for name in self.possible_agents:
            stated = statement.system.features[name].items()
            self.features[name] = [_spec(called, feature, statement) for called, feature in stated]
            ends = np.array([(each.low, each.high) for each in self.features[name]], np.float32)
            self._boxes[name] = Box(ends[:, 0], ends[:, 1])
        self._choices = {name: Discrete(len(names)) for name, names in self.action_names.items()}
        self._rng = np.random.default_rng()
        self._steps = 0

    def observation_space(self, agent: str) -> Box:
        """The ranges of the agent's features, [n_features] float32."""
        return self._boxes[agent]

    def action_space(self, agent: str) -> Discrete:
        """The agent's actions, in the order of the file."""
        return self._choices[agent]

    def reset(self, seed: int | None = None, options: Mapping[str, Any] | None = None) -> tuple[dict[str, Any], Any]:
        """Draws a start."""
        del options
        if seed is not None:
            self._rng = np.random.default_rng(seed)
        self.state, self._steps = start(self.statement, self._rng), 0
        self.agents = list(self.possible_agents)
        infos: dict[str, dict[str, Any]] = {agent: {} for agent in self.agents}
        return self._observe_agents(), infos

    def step(  # pyright: ignore[reportIncompatibleMethodOverride]
        self, actions: Mapping[str, int]
    ) -> tuple[dict[str, Any], ...]:
        """One step: observations, rewards, terminations, truncations and infos."""
        acted = self.agents
        chosen = {agent: self.action_names[agent][actions[agent]] for agent in acted}
        rule = draw_rule(self._moving.rules(self.state), self._rng)
        if isinstance(rule, FlowRule) and any(rule.jitter):
            after = rule.move_state(self.state, chosen, float(self._rng.uniform(*rule.jitter)))
        else:
            after = rule.move_state(self.state, chosen)
        for name, (low, high) in rule.error.items():
            after[name] += self._rng.uniform(low, high)
        left = not self._moving.rules(after)
        self.state = self._moving.clip_state(after)  # pyright: ignore[reportIncompatibleMethodOverride]
        self._steps += 1
        cut = not left and self._steps >= self.max_cycles
        rewards = {agent: paid(self.state) for agent, paid in self._rewards.items()}
        if left or cut:
            self.agents = []
        infos: dict[str, dict[str, Any]] = {agent: {} for agent in acted}
        return self._observe_agents(), rewards, dict.fromkeys(acted, left), dict.fromkeys(acted, cut), infos

    def _observe_agents(self) -> dict[str, Any]:
        """What each agent observes: of a flow with delays the state as it was some periods ago, drawn by the seed."""
        system = self.statement.system
        observations: dict[str, Any] = {}
        state, exact = self.state, {name: Fraction(number) for name, number in self.state.items()}
        for agent in self.possible_agents:
            if system.flow is not None and system.flow.kept:
                way = system.flow.seen[int(self._rng.integers(len(system.flow.seen)))]
                state = {name: self.state[way.get(name, name)] for name in self.state}
                exact = {name: Fraction(number) for name, number in state.items()}
            numbers = [_of(feature, state, exact) for feature in system.features[agent].values()]
            observations[agent] = np.array(numbers, np.float32)
        return observations


def _of(feature: Feature, state: Floats, exact: Mapping[str, Fraction]) -> np.float32:
    match feature:
        case Feature(Affine(((name, factor),), constant), Measure.VALUE) if factor == 1 and not constant:
            return np.float32(state[name])  # the same in less time
        case _:
            return nearest_single(measure_feature(feature, exact))


def _spec(name: str, feature: Feature, statement: Statement) -> FeatureSpec:
    """A feature as profiles hold it, without a meaning: coordinates of profiles are places and velocities."""
    ranges = {each.name: each.range for each in statement.system.variables}
    units = {each.name: each.unit for each in statement.system.variables}
    low = high = feature.form.constant
    for variable, factor in feature.form.terms:
        ends = [factor * end for end in ranges[variable]]
        low, high = low + min(ends), high + max(ends)
    match feature.measure:
        case Measure.SIGN:
            low, high = Fraction(-1), Fraction(1)
        case Measure.POSITIVE | Measure.EQUALS:
            low, high = Fraction(0), Fraction(1)
        case Measure.CLIP:
            assert feature.bounds is not None
            low, high = (min(max(end, feature.bounds[0]), feature.bounds[1]) for end in (low, high))
        case Measure.VALUE:
            pass
    only = {units[variable] for variable, _ in feature.form.terms}
    unit = only.pop() if len(only) == 1 and feature.measure in (Measure.VALUE, Measure.CLIP) else "1"
    return FeatureSpec(name, "none" if unit == "1" else unit, float(low), float(high), None)
