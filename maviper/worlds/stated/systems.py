"""A world that a file states, in play, as a PettingZoo environment: `system:FILE`.

Does: draws starts and errors by a seed; moves the state by the rules as they are written, in float64.
Assumes: a checked file (verify/systems).
Does not: prove. Proofs are about exact numbers; here each operation of a rule rounds.

An episode ends where the statement ends: after its steps, or where the state leaves the ranges of the variables.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from pettingzoo import ParallelEnv  # pyright: ignore[reportMissingTypeStubs]

from codegen.errors import InputError
from codegen.ir import FeatureSpec
from maviper.files import kinds, runs
from maviper.worlds.outside.sources import SYSTEM, named_by_user
from maviper.worlds.stated.flowing import FlowRule
from verify.systems.files import MAX_BYTES, statement_of
from verify.systems.language.expressions import function
from verify.systems.observing import measured, nearest
from verify.systems.system import Affine, Feature, Interval, Measure

if TYPE_CHECKING:
    from gymnasium.spaces import Box, Discrete

    from verify.systems.statement import Rule, Statement

DRAWS, TRIES = 1_000, 100  # of starts at once, until one lies in the start region
Floats = dict[str, float]


def read(path: str | Path) -> Statement:
    """What a world file states. InputError with the place of the first fault."""
    name = str(path)
    data = runs.read(Path(path), MAX_BYTES)
    kinds.ensure(data, name, kinds.WORLD.called, kinds.WORLD)
    try:
        return statement_of(data.decode(), Path(path).name)
    except UnicodeDecodeError:
        raise InputError("not a readable file", f"{name}: not UTF-8 text", "is this the right file?") from None


def file_of(world: str | Path) -> Path:
    """The world file that a user named, also as `system:FILE`. InputError for a world that is played, not stated."""
    name = str(world)
    if name.startswith(f"{SYSTEM}:"):
        return Path(name.removeprefix(f"{SYSTEM}:"))
    if not Path(name).exists() and named_by_user(name):
        what = "this world is played by its own code, which states no rules that a proof could use"
        advice = (
            "leave --world out: claims about observations hold in every world (`maviper properties new PROFILE`); "
            "or state the rules in a world file (`maviper guide systems`)"
        )
        raise InputError(what, f"--world {name}", advice)
    return Path(name)


def stated(path: str) -> Callable[[], StatedEnv]:
    """What makes the environment of a file."""
    return partial(_made, path)


def _made(path: str) -> StatedEnv:
    found = read(path)
    if not found.moves:
        raise InputError("the file does not say how the state moves", path, "add [dynamics.next]")
    if found.gives:
        what = f"{', '.join(found.gives)} gives numbers, and play of a world file takes actions"
        raise InputError(what, path, "`maviper verify`, `maviper check` and `maviper replay` take such a file")
    return StatedEnv(found, path)


class MovingRule:
    """A rule in floats."""

    def __init__(self, rule: Rule) -> None:
        self.error = {name: _floats(bounds) for name, bounds in rule.error.items()}
        self._where = [(name, *_floats(bounds)) for name, bounds in rule.where.items()]
        self._when = rule.when
        self.case = (rule.where, rule.when)
        self._move = {name: function(move) for name, move in rule.move.items()}
        self._effect = {
            choice: {name: function(added) for name, added in effects.items()}
            for choice, effects in rule.effect.items()
        }

    def holds(self, state: Mapping[str, float]) -> bool:
        """Whether a state lies in its box and meets its conditions."""
        if not all(low <= state[name] <= high for name, low, high in self._where):
            return False
        return not self._when or self._meets({name: Fraction(number) for name, number in state.items()})

    def _meets(self, exact: Mapping[str, Fraction]) -> bool:
        return all(half.holds(exact) for half in self._when)

    def moved(self, state: Mapping[str, float], actions: Mapping[str, str]) -> Floats:
        """The next state for a joint action by names, without an error."""
        found = {name: move(state) for name, move in self._move.items()}
        for choice in actions.items():
            for name, added in self._effect.get(choice, {}).items():
                found[name] += added(state)
        return found


AnyRule = MovingRule | FlowRule


class Moving:
    """A statement's ranges and rules in floats."""

    def __init__(self, statement: Statement) -> None:
        self.ranges = {each.name: _floats(each.range) for each in statement.system.variables}
        flow = statement.system.flow
        self._rules: list[AnyRule] = [MovingRule(rule) for rule in statement.rules]
        self._rules += [] if flow is None else [FlowRule(flow)]

    def within(self, state: Mapping[str, float]) -> bool:
        """Whether a state lies in the ranges of all variables."""
        return all(low <= state[name] <= high for name, (low, high) in self.ranges.items())

    def rules(self, state: Mapping[str, float]) -> list[AnyRule]:
        """The rules that hold in a state: none outside the ranges, several on a border."""
        return self.stated(state) if self.within(state) else []

    def stated(self, state: Mapping[str, float]) -> list[AnyRule]:
        """The rules whose boxes hold a state: a rule without a box holds beyond the ranges too."""
        return [rule for rule in self._rules if rule.holds(state)]

    def clipped(self, state: Mapping[str, float]) -> Floats:
        """The state nearest to one in the ranges."""
        return {name: min(max(number, self.ranges[name][0]), self.ranges[name][1]) for name, number in state.items()}


def drawn(rules: Sequence[AnyRule], rng: np.random.Generator) -> AnyRule:
    """One of the rules that hold in a state: the first, or any of those that differ from it in choices alone."""
    ways = [rule for rule in rules if rule.case == rules[0].case]
    return ways[int(rng.integers(len(ways)))] if len(ways) > 1 else ways[0]


def _floats(bounds: Interval) -> tuple[float, float]:
    return float(bounds[0]), float(bounds[1])


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
        self.features = {name: _specs(statement, name) for name in self.possible_agents}
        ends = {
            name: np.array([(each.low, each.high) for each in of], np.float32) for name, of in self.features.items()
        }
        self._boxes = {name: Box(found[:, 0], found[:, 1]) for name, found in ends.items()}
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
        return self._seen(), infos

    def step(  # pyright: ignore[reportIncompatibleMethodOverride]
        self, actions: Mapping[str, int]
    ) -> tuple[dict[str, Any], ...]:
        """One step: observations, rewards, terminations, truncations and infos."""
        acted = self.agents
        chosen = {agent: self.action_names[agent][actions[agent]] for agent in acted}
        rule = drawn(self._moving.rules(self.state), self._rng)
        after = rule.moved(self.state, chosen)
        for name, (low, high) in rule.error.items():
            after[name] += self._rng.uniform(low, high)
        left = not self._moving.rules(after)
        self.state = self._moving.clipped(after)  # pyright: ignore[reportIncompatibleMethodOverride]
        self._steps += 1
        cut = not left and self._steps >= self.max_cycles
        rewards = {agent: paid(self.state) for agent, paid in self._rewards.items()}
        if left or cut:
            self.agents = []
        infos: dict[str, dict[str, Any]] = {agent: {} for agent in acted}
        return self._seen(), rewards, dict.fromkeys(acted, left), dict.fromkeys(acted, cut), infos

    def _seen(self) -> dict[str, Any]:
        exact = {name: Fraction(number) for name, number in self.state.items()}
        features = self.statement.system.features
        return {
            agent: np.array([self._of(feature, exact) for feature in features[agent].values()], np.float32)
            for agent in self.possible_agents
        }

    def _of(self, feature: Feature, exact: Mapping[str, Fraction]) -> np.float32:
        match feature:
            case Feature(Affine(((name, factor),), constant), Measure.VALUE) if factor == 1 and not constant:
                return np.float32(self.state[name])  # the same in less time
            case _:
                return nearest(measured(feature, exact))


def start(statement: Statement, rng: np.random.Generator) -> Floats:
    """A start: uniform among the states that the box of the start region and its further conditions allow.

    InputError where none is found, since the region is too thin.
    """
    bounds = box(statement)
    further = [half for half in statement.system.start if len(half.form.terms) > 1]  # the box, rounded, is met by all
    for _ in range(TRIES):
        drawn = {name: rng.uniform(float(low), float(high), DRAWS) for name, (low, high) in bounds.items()}
        for k in range(DRAWS):
            state = {name: float(numbers[k]) for name, numbers in drawn.items()}
            exact = {name: Fraction(number) for name, number in state.items()}
            if all(half.holds(exact) for half in further):
                return state
    what = "no start was found: the start region is too thin beside its box"
    raise InputError(what, statement.system.name, "bound the start more tightly by its box")


def box(statement: Statement) -> dict[str, Interval]:
    """The bounds of each variable that the start region states by itself."""
    found = {each.name: each.range for each in statement.system.variables}
    for half in statement.system.start:
        match half.form.terms:
            case ((name, factor),):
                low, high = found[name]
                end = -half.form.constant / factor
                found[name] = (low, min(high, end)) if factor > 0 else (max(low, end), high)
            case _:
                pass
    return found


def _specs(statement: Statement, agent: str) -> list[FeatureSpec]:
    features = statement.system.features[agent]
    return [_spec(name, feature, statement) for name, feature in features.items()]


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
