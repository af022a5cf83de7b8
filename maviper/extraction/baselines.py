# pyright: basic
"""Two baselines: fitted Q-Iteration (Ernst et al. 2005), the paper's second, and RGMDT (Chen et al., NeurIPS 2024).

Does: fits a regression tree to Q(o_i, a_i) from expert episodes, iterates, turns argmax over actions into one tree; or
  plays rounds in which each agent's tree is grown anew as a clustering of action values under a budget of leaves, the
  values being those of the expert's Q with all others at their current trees.
Assumes: for fitted Q, observations cut into the ten bins at -1, -0.75, ..., 1, and rewards of the environment; for
  RGMDT, an expert with a critic, or one of value networks.
Does not: look at the expert's critic, or leave its actions unless a share of exploration is asked for (fitted Q); claim
  to repeat published numbers, which are for other games, or any code of theirs, which nobody here saw (RGMDT).

What the description of RGMDT (arXiv 2410.16517) leaves open, and the reading chosen:
- Vectors are Q_i(x, a_i, the others' current actions) over a_i, less their mean: cosine distances then depend on
  differences between actions alone. Lengths are weights, so a state in which every action is worth the same is none.
- The description trains a network that assigns clusters and fits trees to it. Here the leaves are the clusters: splits
  are searched by the clustering loss itself (growth/best_first.py), so that nothing is lost between the two.
- A split tests one feature. Others act by their experts until they have a tree. Each round adds episodes of all current
  trees, the first round's being the experts'; one round is chosen as for the other algorithms.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from codegen import ir
from codegen.deciding import decide_taken
from codegen.errors import InputError
from codegen.ir import NO_ACTION, NO_CHILD, NO_FEATURE, Float32, Float64, GrownTree
from maviper.episodes.play import Controller, Episodes, rollout
from maviper.episodes.trees import agent_policies, among
from maviper.experts.expert import Expert
from maviper.experts.finding import critic_of
from maviper.extraction.arena import merge_leaves
from maviper.extraction.dataset import Dataset, Met, collect
from maviper.extraction.extraction import Extraction, OutOfTime
from maviper.extraction.growth.best_first import BestFirstTree
from maviper.extraction.growth.joint import BINS, Bins
from maviper.extraction.growth.weights import ROWS_AT_ONCE, joint_actions, parts
from maviper.extraction.selection import Selection
from maviper.extraction.settings import HISTOGRAM, Settings
from maviper.worlds import World
from maviper.worlds.world import Int

EDGES = np.arange(-1, 1.01, 0.25)  # bin k holds EDGES[k - 1] <= x < EDGES[k]
GAMMA = 0.95


def fitted_q(asked: Extraction, everybody: Sequence[int], selection: Selection) -> int:
    """Offers the trees of every round over `rollouts` expert episodes; returns how many points there were.

    Episodes and rounds are made again when a run goes on: together they take seconds.
    """
    world, settings = asked.world, asked.settings
    played = collect_episodes(world, asked.expert, settings, selection.cut)
    agents = [_Agent(world, index, played, settings) for index in everybody]
    for _ in range(settings.iterations):
        if selection.offer([agent.round() for agent in agents]):
            break
    return sum(int(episodes.alive.any(axis=2).sum()) for episodes in played)


def collect_episodes(
    world: World, expert: Expert, settings: Settings, over: Callable[[], bool] = lambda: False
) -> list[Episodes]:
    """The episodes that Q is fitted to: the expert's, a share `explore` of whose actions are uniform; `over`: as in
    `rollout`.
    """
    player: Controller = expert
    if settings.explore:
        choices = np.array([len(choices) for choices in world.actions])
        player = _Exploring(expert, settings.explore, choices, np.random.default_rng(settings.seed))
    return rollout(world, [player] * len(world.agents), settings.rollout_episodes(0), over=over)


@dataclass(frozen=True)
class _Exploring:
    """A controller some of whose actions are replaced by uniform ones."""

    controller: Controller
    share: float
    choices: Int  # [n_agents] how many actions each agent has
    rng: np.random.Generator

    def act(self, agents: Sequence[int], observations: Sequence[Float32], state: Any) -> Int:
        """Returns the controller's actions, a share of them replaced by uniform ones; see `Controller.act`."""
        chosen = self.controller.act(agents, observations, state)
        uniform = self.rng.integers(self.choices[list(agents)], size=chosen.shape)
        return np.where(self.rng.random(chosen.shape) < self.share, uniform, chosen)


class _Agent:
    """One agent's transitions, binned, and its Q so far. After the end of its episode there are none."""

    def __init__(self, world: World, index: int, played: list[Episodes], settings: Settings) -> None:
        self.settings, self.n_actions = settings, len(world.actions[index])
        seen, following, acted, paid, goes_on = [], [], [], [], []
        for episodes in played:
            mine = episodes.alive[..., index]
            last = world.observe(episodes.states[-1])[index]
            after = np.concatenate([episodes.observations[index][1:], last[None]])
            seen.append(episodes.observations[index][mine])
            following.append(after[mine])
            acted.append(episodes.actions[..., index][mine])
            paid.append(np.stack([world.rewards(state)[:, index] for state in episodes.states[1:]])[mine])
            goes_on.append(~np.stack([world.terminated(state)[:, index] for state in episodes.states[1:]])[mine])
        self.seen, self.following = (bin_observations(np.concatenate(parts)) for parts in (seen, following))
        self.acted, self.reward, self.goes_on = map(np.concatenate, (acted, paid, goes_on))
        self.tree: Any = None

    def round(self) -> GrownTree:
        """One iteration: Q becomes the reward and what the best action is worth afterwards, if anything follows; the
        greedy tree.
        """
        from sklearn.tree import DecisionTreeRegressor

        target = self.reward
        if self.tree is not None:
            ahead = [self.tree.predict(self._inputs(self.following, action)) for action in range(self.n_actions)]
            target = target + GAMMA * self.goes_on * np.max(ahead, axis=0)
        tree = DecisionTreeRegressor(max_depth=self.settings.max_depth, random_state=self.settings.seed)
        self.tree = tree.fit(self._inputs(self.seen, self.acted), target)
        return greedy(self.tree.tree_, self.seen.shape[1], self.n_actions)

    def _inputs(self, seen: Int, acted: Int | int) -> Float64:
        """[n, n_features + n_actions]: bins, then the action one-hot."""
        one_hot = np.zeros((len(seen), self.n_actions))
        one_hot[np.arange(len(seen)), acted] = 1.0
        return np.concatenate([seen.astype(np.float64), one_hot], axis=1)


def bin_observations(obs: np.ndarray) -> Int:
    """The bin of every number, [n, n_features] from 0 to 9."""
    return np.searchsorted(EDGES, obs.astype(np.float64), side="right")


def greedy(tree: Any, n_features: int, n_actions: int) -> GrownTree:
    """The actions that maximise a tree of Q over (bins, one-hot action), as a tree of actions.

    One Q tree a action lies over the other; a split that an earlier one on the path decides is left out, and equal
    siblings become one leaf. "bin <= k" is "x < EDGES[k]", which is "x <= the float before it". The depth may grow.
    """
    nodes: list[tuple[int, float, int, int, int]] = []  # feature, threshold, left, right, action

    def skip(node: int, action: int, low: Int, high: Int) -> int:
        """Down to a split on an observation that is still open between the bins `low` and `high`, or to a leaf."""
        while tree.children_left[node] != -1:
            feature, cut = int(tree.feature[node]), tree.threshold[node]
            if feature >= n_features:
                goes_left = (feature - n_features == action) <= cut
            elif high[feature] <= cut or low[feature] > cut:
                goes_left = high[feature] <= cut
            else:
                return node
            node = int(tree.children_left[node] if goes_left else tree.children_right[node])
        return node

    def overlay(at: list[int], low: Int, high: Int, depth: int) -> int:
        at = [skip(node, action, low, high) for action, node in enumerate(at)]
        opened = [node for node in at if tree.children_left[node] != -1]
        place = len(nodes)
        if not opened:
            best = int(np.argmax([tree.value[node].ravel()[0] for node in at]))
            nodes.append((NO_FEATURE, 0.0, NO_CHILD, NO_CHILD, best))
            return place
        if depth >= ir.MAX_DEPTH:
            raise InputError("the tree of actions is too deep", "--max-depth", "ask for a smaller depth")
        feature, cut = int(tree.feature[opened[0]]), int(np.floor(tree.threshold[opened[0]]))
        nodes.append((feature, float(np.nextafter(EDGES[cut], -np.inf)), NO_CHILD, NO_CHILD, NO_ACTION))
        below, above = high.copy(), low.copy()
        below[feature], above[feature] = cut, cut + 1
        left = overlay(at, low, below, depth + 1)
        right = overlay(at, above, high, depth + 1)
        if nodes[left][0] == NO_FEATURE and nodes[left] == nodes[right]:
            merged = nodes[left]
            del nodes[place:]
            nodes.append(merged)
        else:
            nodes[place] = (*nodes[place][:2], left, right, NO_ACTION)
        return place

    overlay([0] * n_actions, np.zeros(n_features, np.int64), np.full(n_features, len(EDGES), np.int64), 0)
    return GrownTree(*(np.array(column) for column in zip(*nodes, strict=True)))


def rgmdt(asked: Extraction, agents: Sequence[int], selection: Selection) -> int:
    """Offers the trees of every round to `selection`; returns how many points there were in the end.

    Rounds are made again when a run goes on. InputError for an expert without a critic.
    """
    world, settings = asked.world, asked.settings
    if critic_of(asked.expert) == "none":
        raise InputError("rgmdt clusters the expert's Q", "--critic none", "choose --critic learned or measured")
    points, trees = _Points(asked, agents), dict[int, GrownTree]()
    controllers: Sequence[Controller] = [asked.expert] * len(world.agents)
    for iteration in range(settings.iterations):
        try:
            met = points.play(controllers, settings.rollout_episodes(iteration), selection.cut)
        except OutOfTime:
            break
        selection.note_rollouts(met.values, met.fidelity)
        for agent in agents:
            trees[agent] = points.tree(agent, trees)
        if selection.offer([trees[agent] for agent in agents]):
            break
        controllers = among(world, agent_policies(world, [trees[agent] for agent in agents], agents), controllers)
    return len(points.data)


class _Points:
    """All states met so far, in which Q is asked."""

    data: Dataset

    def __init__(self, asked: Extraction, agents: Sequence[int]) -> None:
        self.asked, self.agents = asked, list(agents)
        self.state: Any = None

    def play(self, controllers: Sequence[Controller], seeds: range, over: Callable[[], bool] = lambda: False) -> Met:
        """More episodes, whose points join the others; `over`: as in `rollout`."""
        asked, states = self.asked, [] if self.state is None else [self.state]

        def keep_state(observations: tuple[Float32, ...], state: Any, wanted: Int) -> Float64:
            states.append(state)
            return np.ones((len(wanted), len(self.agents)))

        met = collect(asked.world, asked.expert, controllers, self.agents, seeds, keep_state, over)
        self.data = met.data if self.state is None else self.data + met.data
        self.state = states[0].concatenate(states)
        return met

    def tree(self, agent: int, trees: Mapping[int, GrownTree]) -> GrownTree:
        """An agent's tree, the others acting by `trees`, or by their experts where they have none."""
        settings = self.asked.settings
        rows = np.flatnonzero(self.data.alive[:, agent])[-settings.max_samples :]
        seen, values = self.data.observations[agent][rows], self._values(agent, trees, rows)
        bins = Bins.of(seen, BINS if settings.splits == HISTOGRAM else len(seen) + 1)
        vectors = values - values.mean(axis=1, keepdims=True)
        grown = BestFirstTree(bins.codes(seen), vectors, bins, settings.max_depth).grow_to(settings.leaves)
        return merge_leaves(grown)

    def _values(self, agent: int, trees: Mapping[int, GrownTree], rows: Int) -> Float64:
        """Q of each of an agent's actions, [len(rows), n_actions]."""
        world, expert, data = self.asked.world, self.asked.expert, self.data
        acting = data.labels[rows].copy()
        others = [other for other in trees if other != agent]
        policies = agent_policies(world, [trees[other] for other in others], others)
        for other, policy in zip(others, policies, strict=True):
            acting[:, other] = decide_taken(policy, data.observations[other][rows])
        joint = joint_actions(world, agent, [])
        q_values = np.empty((len(rows), len(joint)))
        for part in parts(slice(None), len(rows), max(1, ROWS_AT_ONCE // len(joint))):
            here = [seen[rows[part]] for seen in data.observations]
            q_values[part] = expert.q(agent, here, self.state[rows[part]], joint, acting[part])
        return q_values
