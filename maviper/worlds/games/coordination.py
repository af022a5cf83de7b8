"""Coordination games: one joint decision, whose worth depends on a hidden state that each agent reads through noise.

Does: starts, decides and pays a batch of games; says exactly how likely readings are, so that nothing need be sampled.
Assumes: signals are independent and uniform; agents' readings are independent once the hidden state is given.
Does not: solve the games (tests/support/coordination.py); have places, time or landmarks, so claims about them are
  refused.

A hidden state is one level for each signal. A table says which convention it demands. An agent's *role* is how far the
convention that it chooses lies beyond the one demanded, so that role 0 is right. Climbing and penalty are the games of
Claus and Boutilier (1998), with roles for actions; a larger team gets the mean over its pairs.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from inspect import signature
from itertools import combinations
from typing import Any, ClassVar, cast

import numpy as np

from codegen.dynamics import motionless
from codegen.errors import InputError, UnknownNameError
from codegen.ir import ActionSpec, Bool, FeatureSpec, Float32, Float64
from maviper.worlds.payoffs import MATCHING, PAIRS, RULES
from maviper.worlds.seeds import uniforms
from maviper.worlds.world import Int, Measure, World, unusual

NAME, REFERENCE = "coordination", "maviper.worlds.referee.parallel_env"
AGENTS = "agents"
UNDECIDED = -1
USUAL_PAYOFF, USUAL_AGREE = 100, 0


@dataclass(frozen=True)
class Decisions:
    """A batch of games, before the joint decision or after it."""

    hidden: Int  # [batch] index of the hidden state
    readings: Int  # [batch, n_agents, n_signals] the levels that agents read
    chosen: Int  # [batch, n_agents] conventions; UNDECIDED before

    def __len__(self) -> int:
        return len(self.hidden)

    def __getitem__(self, rows: Any) -> "Decisions":
        return Decisions(self.hidden[rows], self.readings[rows], self.chosen[rows])

    @staticmethod
    def concatenate(states: Sequence["Decisions"]) -> "Decisions":
        """Several batches as one, in their order."""
        parts = ([getattr(state, name) for state in states] for name in ("hidden", "readings", "chosen"))
        return Decisions(*map(np.concatenate, parts))


class Coordination(World):
    """The game with `agents` agents; percentages are whole numbers.

    `noise`: how often a reading is wrong; `blur`: how much more often where a signal is not one that the agent's kind
    reads clearly. Of `kinds` kinds, agent i is of kind i % kinds, and kind k reads the signals j % kinds == k clearly.
    `payoff`: the weight of all agents being right, beside the share of agents that are; `agree`: what all agents on one
    wrong convention are worth of that. `table`: which of the tables from hidden states to conventions.
    """

    ranges: ClassVar = {
        "agents": (2, 6),
        "conventions": (2, 4),
        "signals": (1, 4),
        "levels": (2, 4),
        "kinds": (1, 3),
        "noise": (0, 50),
        "blur": (0, 50),
        "payoff": (0, 100),
        "agree": (0, 100),
        "table": (0, 999_999),
    }

    def __init__(
        self,
        agents: int = 3,
        conventions: int = 3,
        signals: int = 3,
        levels: int = 2,
        kinds: int = 2,
        noise: int = 0,
        blur: int = 10,
        payoff: int = USUAL_PAYOFF,
        agree: int = USUAL_AGREE,
        rule: str = MATCHING,
        table: int = 0,
    ) -> None:
        options: dict[str, int | str] = {"agents": agents, "conventions": conventions, "rule": rule, "table": table}
        options |= {"signals": signals, "levels": levels, "kinds": kinds, "noise": noise, "blur": blur}
        options |= {"payoff": payoff, "agree": agree}
        names = tuple(f"agent_{index}" for index in range(agents))
        self.spec = motionless(NAME, REFERENCE, names, 1, unusual(Coordination, options))
        if rule not in RULES:
            raise UnknownNameError("rule", rule, RULES, self.name)
        if rule in PAIRS and conventions != 3:
            raise InputError(f"{rule} has 3 conventions", self.name, "write conventions=3, or leave it out")
        if rule in PAIRS and (payoff, agree) != (USUAL_PAYOFF, USUAL_AGREE):
            raise InputError(f"{rule} has payoffs of its own", self.name, "leave payoff and agree out")
        self.teams = {AGENTS: names}
        self.kinds, self.signals, self.levels, self.rule = kinds, signals, levels, rule
        self.all_or_nothing, self.agree = payoff / 100, agree / 100
        features = (FeatureSpec(f"signal_{k}", "none", 0.0, levels - 1.0, None) for k in range(signals))
        self.features = (tuple(features),) * agents
        self.actions = (tuple(ActionSpec(f"convention_{k}", None) for k in range(conventions)),) * agents
        shares = Measure(AGENTS, "right"), Measure(AGENTS, "all right", share=True)
        self.measures = (Measure(AGENTS, "payoff"), *shares)
        clear = [[signal % kinds == kind for signal in range(signals)] for kind in range(kinds)]
        self.errors = np.where(clear, noise, noise + blur) / 100  # [kinds, n_signals] share of wrong readings

    @property
    def conventions(self) -> int:
        """The number of actions of each agent."""
        return len(self.actions[0])

    def kind(self, agent: int) -> int:
        """Returns the kind of an agent, which decides the signals that it reads clearly."""
        return agent % self.kinds

    # --- what is hidden, and how it is read

    @cached_property
    def cells(self) -> Int:
        """Every hidden state, which is also every reading, [n_cells, n_signals], the first signal slowest."""
        return np.indices((self.levels,) * self.signals).reshape(self.signals, -1).T

    def cell(self, levels: Int) -> Int:
        """The index in `cells` of levels [..., n_signals]."""
        return levels @ self.levels ** np.arange(self.signals)[::-1]

    @cached_property
    def demanded(self) -> Int:
        """The convention that each hidden state demands, [n_cells]: each convention as often as any, up to one."""
        drawn = uniforms(np.array([int(self.spec.options.get("table", 0))]), len(self.cells))[0]
        return np.argsort(np.argsort(drawn, kind="stable"), kind="stable") % self.conventions

    def likelihood(self, kind: int) -> Float64:
        """Returns each reading's probability in each hidden state, [n_cells hidden, n_cells read]; rows sum to 1."""
        likelihood: Float64 = np.ones((len(self.cells), len(self.cells)))
        for signal, error in enumerate(self.errors[kind]):
            level = self.cells[:, signal]
            likelihood *= cast("Float64", np.where(level[:, None] == level[None], 1 - error, error / (self.levels - 1)))
        return likelihood

    # --- playing

    def start(self, n: int, rng: np.random.Generator) -> Decisions:
        """`n` random hidden states with everybody's readings, from one generator."""
        return self._draw_states(rng.random((n, self._draws)))

    def start_from_seeds(self, seeds: Sequence[int] | Int) -> Decisions:
        """The start states of the reference environment after `reset(seed=...)`, one for each seed."""
        return self._draw_states(uniforms(np.asarray(seeds), self._draws))

    @property
    def _draws(self) -> int:
        return 1 + len(self.agents) * self.signals

    def _draw_states(self, uniform: Float64) -> Decisions:
        """From [batch, draws] numbers in [0, 1): the hidden state's first, then each agent's, signal by signal."""
        hidden = (uniform[:, 0] * len(self.cells)).astype(np.int64)
        drawn = uniform[:, 1:].reshape(len(uniform), len(self.agents), self.signals)
        errors = self.errors[[self.kind(agent) for agent in range(len(self.agents))]]
        wrong = drawn < errors
        # where a reading is wrong, the same number says by how many levels
        share = np.divide(drawn, errors, out=np.zeros_like(drawn), where=wrong)
        off = np.minimum((share * (self.levels - 1)).astype(np.int64), self.levels - 2) + 1
        readings = (self.cells[hidden][:, None] + np.where(wrong, off, 0)) % self.levels
        undecided = np.full((len(hidden), len(self.agents)), UNDECIDED)
        return Decisions(hidden, readings.astype(np.int8), undecided)  # readings are what copies of states cost

    def step(self, state: Decisions, actions: Int) -> Decisions:
        """The games with everybody's decision. `actions`: [batch, n_agents] conventions."""
        return Decisions(state.hidden, state.readings, np.asarray(actions, dtype=np.int64))

    def observe(self, state: Decisions) -> tuple[Float32, ...]:
        """Each agent's readings, [batch, n_signals] float32."""
        return tuple(state.readings.transpose(1, 0, 2).astype(np.float32))

    def alive(self, state: Decisions) -> Bool:
        """Everybody before the decision, nobody after it, [batch, n_agents]."""
        return state.chosen == UNDECIDED

    def terminated(self, state: Decisions) -> Bool:
        """Everybody after the decision, [batch, n_agents]."""
        return state.chosen != UNDECIDED

    # --- what decisions are worth

    def roles(self, state: Decisions) -> Int:
        """Returns the distance of each agent's convention beyond the one demanded, [batch, n_agents]."""
        return (state.chosen - self.demanded[state.hidden][:, None]) % self.conventions

    def payoff(self, roles: Int) -> Float64:
        """Returns the worth of roles [batch, n_agents] to every agent, [batch]."""
        if self.rule in PAIRS:
            pairs = list(combinations(range(len(self.agents)), 2))
            return np.mean([PAIRS[self.rule][roles[:, a], roles[:, b]] for a, b in pairs], axis=0)
        same = (roles == roles[:, :1]).all(axis=1)
        together = np.where(roles[:, 0] == 0, 1.0, self.agree) * same
        return (1 - self.all_or_nothing) * (roles == 0).mean(axis=1) + self.all_or_nothing * together

    def rewards(self, state: Decisions) -> Float64:
        """The payoff, the same for all agents, [batch, n_agents]."""
        return np.repeat(self.payoff(self.roles(state))[:, None], len(self.agents), axis=1)

    def values(self, states: Sequence[Decisions]) -> Float64:
        """The payoff; the share of agents that are right; whether all are."""
        right = self.roles(states[-1]) == 0
        return np.stack([self.rewards(states[-1])[:, 0], right.mean(axis=1), right.all(axis=1)])

    def reference_env(self) -> Any:
        """The game as a PettingZoo parallel environment."""
        from maviper.worlds.referee import parallel_env

        usual = {name: option.default for name, option in signature(Coordination).parameters.items()}
        return parallel_env(**{**usual, **self.spec.options})
