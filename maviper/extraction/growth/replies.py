"""Best replies: an agent's best action in a state, given what its mates' trees do there.

Does: labels, weights and regrets of the points of one agent by the expert's Q at its mates' actions, as in iterated
  best response; keeps Q from round to round, and asks again only where a mate acts otherwise than before.
Assumes: points are appended, never changed; an expert that is its own best reply, so that its action is the label
  where all mates act as their experts, and among actions that Q values alike.
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
    """What one agent is taught of every point."""

    labels: Int  # [n]
    q: Float64  # [n, n_actions] of each own action beside what the others do
    legal: Bool  # [n, n_actions]

    @property
    def worth(self) -> Float64:
        """What it is worth to take the label, [n]: Q of it less that of the worst legal action, at least 0."""
        return np.maximum(0.0, _of(self.q, self.labels) - self._stake[1])

    @property
    def regrets(self) -> Float64:
        """What each action costs beside the label, [n, n_actions]: the Q that is lost, and LEAST_GAIN of what is at
        stake, by which another action has to be better to be the label; at least 0. An illegal action costs as much as
        the worst legal one.
        """
        best, worst = self._stake
        margin = LEAST_GAIN * (best - worst)
        q = np.where(self.legal, self.q, worst[:, None])
        regrets = np.maximum(0.0, (_of(self.q, self.labels) + margin)[:, None] - q)
        np.put_along_axis(regrets, self.labels[:, None], 0.0, axis=1)
        return regrets

    @property
    def _stake(self) -> tuple[Float64, Float64]:
        """Q of the best and of the worst legal action, each [n]."""
        return np.where(self.legal, self.q, -np.inf).max(axis=1), np.where(self.legal, self.q, np.inf).min(axis=1)


class Replies:
    """The best replies of one agent to its mates."""

    def __init__(self, world: World, expert: Expert, agent: int) -> None:
        self.world, self.expert, self.agent = world, expert, agent
        self.joint = joint_actions(world, agent, [])
        self._acting = np.zeros((0, len(world.agents)), dtype=np.int64)  # what Q was asked for, [n, n_agents]
        self._q = np.zeros((0, len(self.joint)))

    def to(self, acting: Int, data: Dataset, state: Any) -> Reply:
        """The reply to what the others do. `acting`: [n, n_agents] what each of them does; `state`: of all points."""
        q, legal = self._values(acting, data, state), legal_actions(self.world, self.agent, data.observations)
        expert = data.labels[:, self.agent]
        others = np.asarray(np.arange(acting.shape[1]) != self.agent, dtype=np.bool_)
        misled = (acting != data.labels)[:, others].any(axis=1)
        best, worst = np.where(legal, q, -np.inf).max(axis=1), np.where(legal, q, np.inf).min(axis=1)
        better = misled & (best - _of(q, expert) > LEAST_GAIN * (best - worst))
        labels = cast("Int", np.where(better, np.where(legal, q, -np.inf).argmax(axis=1), expert))
        return Reply(labels, q, legal)

    def _values(self, acting: Int, data: Dataset, state: Any) -> Float64:
        """Q of each own action beside what the others do, [n, n_actions]."""
        asked = acting.copy()
        asked[:, self.agent] = 0
        known = len(self._acting)
        fresh: Bool = np.ones(len(asked), dtype=bool)
        fresh[:known] = (self._acting != asked[:known]).any(axis=1)
        q_values = np.concatenate([self._q, np.empty((len(asked) - known, len(self.joint)))])
        rows = np.flatnonzero(fresh)
        for part in parts(rows, len(asked), max(1, ROWS_AT_ONCE // len(self.joint))):
            seen = [each[part] for each in data.observations]
            q_values[part] = self.expert.q(self.agent, seen, state[part], self.joint, asked[part])
        self._acting, self._q = asked, q_values
        return q_values


def _of(q: Float64, actions: Int) -> Float64:
    """Q of one action in each state, [n]."""
    return np.take_along_axis(q, actions[:, None], axis=1)[:, 0]
