"""What an expert's Q says of a state: how much it matters to act as the expert does there, and the best reply to mates.

Does: the paper's weights of MAVIPER and IVIPER, for centralized critics and for value networks; labels and
  weights of an agent whose mates act as their trees do, as in iterated best response, less what Q also promises beside
  experts. Q is kept from round to round, and asked again only where a mate acts otherwise than before.
Assumes: the expert acts greedily, so that V is Q at the expert's joint action, and is its own best reply where all
  mates act as their experts: whatever a learned Q promises for another action there is an error of Q, and is taken off
  beside other mates too. Points are appended, never changed.
Does not: average over every joint action where there are too many: beyond MAX_JOINT a fixed sample stands for them, and
  beyond MAX_BRANCHED, where play measures each, one that is drawn for each state; weigh states in which the agent no
  longer acts (0), or average over the actions of others who no longer do; look at what illegal actions are worth.
"""

from collections.abc import Iterator, Sequence
from itertools import product
from typing import Any, NamedTuple, cast

import numpy as np

from codegen.ir import Bool, Float32, Float64
from maviper.experts.expert import AS_GIVEN, MEASURED, Expert
from maviper.experts.finding import critic_of
from maviper.extraction.dataset import Dataset
from maviper.worlds import World
from maviper.worlds.world import Int, legal_in

ROWS_AT_ONCE = 25_600  # bounds the memory: states x joint actions, each with a row of hidden units
MAX_JOINT = 625  # joint actions of others that are enumerated
SAMPLED_JOINT = 32  # ... and how many are drawn where there are more
MAX_BRANCHED = 25  # joint actions of others that are enumerated where each costs episodes of play
SAMPLE_SEED = 11


def maviper_weights(
    world: World,
    expert: Expert,
    observations: tuple[Float32, ...],
    state: Any,
    labels: Int,
    agents: Sequence[int] | None = None,
) -> Float64:
    """The MAVIPER weight of every point for every agent, or for some `agents`, [n, n_agents] (paper, section MAVIPER).

    For agent i: the mean over joint actions of others, uniform, of Q_i(x, expert's a_i) - min over a_i of
    Q_i(x, a_i). The others are all other agents in a cooperative game, and those outside i's team in a mixed one, where
    team-mates stay at their expert actions. Who no longer acts is none of them.
    """
    columns = list[Float64]()
    for agent in range(len(world.agents)) if agents is None else agents:
        team = world.members(world.team_of(world.agents[agent])) if len(world.teams) > 1 else [agent]
        others = [other for other in range(len(world.agents)) if other not in team]
        columns.append(_weight(world, expert, agent, others, observations, state, labels))
    return np.stack(columns, axis=1)


def iviper_weights(
    world: World, expert: Expert, observations: tuple[Float32, ...], state: Any, labels: Int, agent: int
) -> Float64:
    """The IVIPER weight of every point for one agent, [n]: V - min over a_i of Q_i, all others at expert actions."""
    return _weight(world, expert, agent, [], observations, state, labels)


def in_play(alive: Bool, agent: int, others: list[int]) -> Iterator[tuple[Any, list[int]]]:
    """The states in which an agent acts, [n] rows at a time, each time with those of `others` who act in them too."""
    if alive[:, [agent, *others]].all():
        yield slice(None), others  # views, where copies would be as good
        return
    acting = np.flatnonzero(alive[:, agent])
    patterns, which = np.unique(np.packbits(alive[acting][:, others], axis=1), axis=0, return_inverse=True)
    for pattern in range(len(patterns)):
        rows = acting[which.ravel() == pattern]
        yield rows, [other for other in others if alive[rows[0], other]]


def _weight(
    world: World,
    expert: Expert,
    agent: int,
    others: list[int],
    observations: tuple[Float32, ...],
    state: Any,
    labels: Int,
) -> Float64:
    weights, n_own = np.zeros(len(labels)), len(world.actions[agent])
    for rows, playing in in_play(world.alive(state), agent, others):
        # a value network's Q_i does not depend on what others do
        asked = playing if expert.centralized else []
        joint, given = _pose_questions(world, expert, agent, asked, rows, labels)
        for part in parts(rows, len(labels), max(1, ROWS_AT_ONCE // len(joint))):
            seen = [each[part] for each in observations]
            q = expert.q(agent, seen, state[part], joint, given[part])
            by_own = q.reshape(len(q), n_own, -1)  # the agent's own action varies slowest
            chosen = np.take_along_axis(by_own, labels[part][:, agent, None, None], axis=1)[:, 0]
            least = np.where(legal_actions(world, agent, seen)[..., None], by_own, np.inf).min(axis=1)
            theirs = joint[: by_own.shape[2]]  # joint actions of the others
            weights[part] = _mean(world, chosen - least, asked, seen, theirs)
    return weights


def _pose_questions(
    world: World, expert: Expert, agent: int, others: list[int], rows: slice | Int, labels: Int
) -> tuple[Int, Int]:
    """The joint actions that Q is asked for in some states, and what AS_GIVEN stands for in each, [n, n_agents].

    Where Q is measured by play and others have many joint actions, each state gets one of a few: as many as an agent
    has actions, in which each of the others takes each action equally often (Latin hypercube sampling, McKay et al.
    1979). The draws of `resample` scatter more than this does.
    """
    choices = [len(world.actions[other]) for other in others]
    if critic_of(expert) != MEASURED or np.prod(choices, dtype=np.float64) <= MAX_BRANCHED:
        return joint_actions(world, agent, others), labels
    rng = np.random.default_rng([SAMPLE_SEED, agent])
    count = max(choices)
    theirs = np.stack([rng.permutation(count) % n for n in choices], axis=1)
    given, asked = labels.copy(), np.arange(len(labels))[rows]
    given[asked[:, None], others] = theirs[rng.permutation(len(asked)) % count]
    return joint_actions(world, agent, []), given


def legal_actions(world: World, agent: int, observations: Sequence[Float32]) -> Bool:
    """Marks an agent's legal actions in each state, [n, n_actions]."""
    mask = world.mask(agent)
    if mask is None:
        return np.ones((len(observations[agent]), len(world.actions[agent])), dtype=bool)
    return legal_in(mask, observations[agent])


def _mean(world: World, values: Float64, others: list[int], observations: Sequence[Float32], joint: Int) -> Float64:
    """The mean of values [n, n_joint] over the joint actions of others that are legal, [n]; over all where none is."""
    masked = [other for other in others if world.mask(other) is not None]
    if not masked:
        return values.mean(axis=1)
    legal = np.all([legal_actions(world, other, observations)[:, joint[:, other]] for other in masked], axis=0)
    legal |= ~legal.any(axis=1, keepdims=True)
    return np.where(legal, values, 0).sum(axis=1) / legal.sum(axis=1)


def parts(rows: slice | Int, count: int, at_once: int) -> Iterator[slice | Int]:
    """Rows of `count`, all or those listed, `at_once` at a time."""
    whole = isinstance(rows, slice)
    for low in range(0, count if whole else len(rows), at_once):
        part = slice(low, low + at_once)
        yield part if whole else rows[part]


def joint_actions(world: World, agent: int, others: list[int]) -> Int:
    """All actions of `agent` times joint actions of `others`, [n_joint, n_agents]; everybody else AS_GIVEN."""
    choices = [len(world.actions[other]) for other in others]
    if np.prod(choices, dtype=np.float64) <= MAX_JOINT:
        every = list(product(*(range(n) for n in choices)))
        theirs = np.array(every, dtype=np.int64).reshape(len(every), len(others))
    else:
        rng = np.random.default_rng([SAMPLE_SEED, agent])
        theirs = rng.integers(choices, size=(SAMPLED_JOINT, len(others)))
    n_own = len(world.actions[agent])
    joint = np.full((n_own * len(theirs), len(world.agents)), AS_GIVEN, dtype=np.int64)
    joint[:, agent] = np.repeat(np.arange(n_own), len(theirs))
    joint[:, others] = np.tile(theirs, (n_own, 1))
    return joint


LEAST_GAIN = 0.2  # of what is at stake in a state: below it another action is taken to be the critic's error


class Reply(NamedTuple):
    """What one agent is taught at every point."""

    labels: Int  # [n]
    worth: Float64  # [n] of taking the label: its gain less that of the worst legal action, at least 0


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
        return Reply(labels, np.maximum(0.0, _of(gains, labels) + _best(-gains, legal)))

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
