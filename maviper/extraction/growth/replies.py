"""Best replies: an agent's best action in a state, given what its mates' trees do there.

Does: labels, weights and regrets of the points of one agent by the expert's Q at its mates' actions, as in iterated
  best response, less what Q also promises beside experts; keeps Q from round to round, and asks again only where a mate
  acts otherwise than before.
Assumes: points are appended, never changed; an expert that is its own best reply where all mates act as their experts:
  whatever a learned Q promises for another action there is an error of Q, and is taken off beside other mates too.
Does not: draw points or grow trees.
"""

from typing import Any, NamedTuple, cast

import numpy as np

from codegen.ir import Bool, Float64
from maviper.experts.expert import Expert
from maviper.extraction.dataset import Dataset
from maviper.extraction.growth.weights import ROWS_AT_ONCE, joint_actions, legal_actions, parts
from maviper.worlds import World
from maviper.worlds.world import Int

LEAST_GAIN = 0.2  # of what is at stake in a state: below it another action is taken to be the critic's error


class Reply(NamedTuple):
    """The labels and gains that one agent is taught at every point."""

    labels: Int  # [n]
    gains: Float64  # [n, n_actions] Q of each own action over that of the expert's, beside what the others do
    margin: Float64  # [n] by which another action has to be better to be the label
    legal: Bool  # [n, n_actions]

    @property
    def worth(self) -> Float64:
        """The worth of taking the label, [n]: its gain less that of the worst legal action, at least 0."""
        return np.maximum(0.0, _of(self.gains, self.labels) - self._least)

    @property
    def regrets(self) -> Float64:
        """The cost of each action beside the label, [n, n_actions]: the gain that is lost, and the margin; at least 0.
        An illegal action costs as much as the worst legal one.
        """
        gains = np.where(self.legal, self.gains, self._least[:, None])
        regrets = np.maximum(0.0, (_of(self.gains, self.labels) + self.margin)[:, None] - gains)
        np.put_along_axis(regrets, self.labels[:, None], 0.0, axis=1)
        return regrets

    @property
    def _least(self) -> Float64:
        """The gain of the worst legal action, [n]."""
        return -_best(-self.gains, self.legal)


class Replies:
    """The best replies of one agent to its mates."""

    def __init__(self, world: World, expert: Expert, agent: int) -> None:
        self.world, self.expert, self.agent = world, expert, agent
        self.joint = joint_actions(world, agent, [])
        self._acting = np.zeros((0, len(world.agents)), dtype=np.int64)  # what Q was asked for, [n, n_agents]
        self._q = np.zeros((0, len(self.joint)))
        self._usual = np.zeros((0, len(self.joint)))  # Q where all others act as their experts

    def to(self, acting: Int, data: Dataset, state: Any) -> Reply:
        """The reply to what the others do. `acting`: [n, n_agents] what each of them does; `state`: of all points."""
        q, legal = self._values(acting, data, state), legal_actions(self.world, self.agent, data.observations)
        expert = data.labels[:, self.agent]
        promised = np.maximum(0.0, self._usual - _of(self._usual, expert)[:, None])
        gains = q - _of(q, expert)[:, None] - promised
        margin = LEAST_GAIN * (_best(q, legal) + _best(-q, legal))
        replied = np.where(legal, gains, -np.inf).argmax(axis=1)
        labels = cast("Int", np.where(_best(gains, legal) > margin, replied, expert))
        return Reply(labels, gains, margin, legal)

    def _values(self, acting: Int, data: Dataset, state: Any) -> Float64:
        """Q of each own action beside what the others do, [n, n_actions]."""
        known, asked, experts = len(self._acting), acting.copy(), data.labels.copy()
        asked[:, self.agent] = experts[:, self.agent] = 0
        fresh = self._ask(experts, np.arange(known, len(experts)), data, state)
        self._usual = np.concatenate([self._usual, fresh])
        self._q = np.concatenate([self._q, fresh])
        before = np.concatenate([self._acting, experts[known:]])
        changed, misled = ((asked != other).any(axis=1) for other in (before, experts))
        back, rows = changed & ~misled, np.flatnonzero(changed & misled)
        self._q[back] = self._usual[back]
        self._q[rows] = self._ask(asked, rows, data, state)
        self._acting = asked
        return self._q

    def _ask(self, joint: Int, rows: Int, data: Dataset, state: Any) -> Float64:
        """Q of each own action in some points, [len(rows), n_actions]. `joint`: [n, n_agents] what the others do."""
        values = [np.empty((0, len(self.joint)))]
        for part in parts(rows, len(joint), max(1, ROWS_AT_ONCE // len(self.joint))):
            seen = [each[part] for each in data.observations]
            values.append(self.expert.q(self.agent, seen, state[part], self.joint, joint[part]))
        return np.concatenate(values)


def _best(values: Float64, legal: Bool) -> Float64:
    """The largest value among legal actions, [n]."""
    return np.where(legal, values, -np.inf).max(axis=1)


def _of(q: Float64, actions: Int) -> Float64:
    """Q of one action in each state, [n]."""
    return np.take_along_axis(q, actions[:, None], axis=1)[:, 0]
