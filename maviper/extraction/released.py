# pyright: basic
"""The authors' released code, its accidents included, where they matter for comparing with published numbers.

Does: its warm-up, weights, resampling, one-hot leaves, data collection and joint growth; its selection is in
  extraction/selection.
Assumes: the preset `released`; `extraction/algorithms.py` says which algorithms there are in this form.
Does not: repeat its start states (episode 0 of every batch is the same there) or its unseeded order of agents; seeds
  are ours. Nor its Fitted Q, whose look-ups never hit, so that it always stands still.

What it does otherwise than the paper: 500 expert episodes first; the weight is Q at the experts' joint action less the
minimum over all joint actions of the team, each averaged over the others', at least 0; a fifth of the points is set
aside before resampling, as many are drawn as weigh more than 0; nodes are filtered when they are made, on what their
ancestors kept, and projected trees learn from filtered points; the best iteration of each team is that of the highest
return in 100 episodes; nothing stops early. IVIPER's and Imitation DT's trees are fitted to one-hot actions, and a leaf
in which no action has a majority of more than half stands still. Imitation's collector starts a new episode at every
step after the first 25.

`Settings.undo` takes three of these back, one by one: `leaves` take their most frequent action, `restarts` let episodes
end first, and `warm-up` leaves as many expert episodes as a round has, which is how the paper's text begins.
"""

import math
from collections.abc import Sequence
from functools import partial
from itertools import product
from typing import Any

import numpy as np

from codegen.errors import InputError
from codegen.importers.scikit import read_sklearn_tree
from codegen.ir import NO_ACTION, NO_CHILD, NO_FEATURE, Bool, Float32, Float64, GrownTree
from maviper.episodes import measures
from maviper.episodes.play import Controller
from maviper.episodes.trees import agent_policies, among
from maviper.experts.expert import AS_GIVEN, Expert, labels
from maviper.extraction.dataset import Dataset, collect
from maviper.extraction.extraction import Extraction, counts_of
from maviper.extraction.growth.exact import cart
from maviper.extraction.growth.weights import in_play
from maviper.extraction.journal import Arrays
from maviper.extraction.selection import Selection
from maviper.extraction.settings import (
    IVIPER,
    IVIPER_RESAMPLING,
    LEAVES,
    MAVIPER,
    NO_PREDICTION,
    RELEASED,
    RESTARTS,
    VIPER,
    Settings,
)
from maviper.extraction.settings import WARM_UP as WARMING_UP
from maviper.worlds import World
from maviper.worlds.world import Int

FEWEST = 2  # points that a node needs


class _Node:
    """A node: the filtered points that made it, its class, its projected tree, and in time its split."""

    def __init__(self, rows: Int, depth: int, action: int, projected: Any) -> None:
        self.rows, self.depth, self.action, self.projected = rows, depth, action, projected
        self.feature, self.threshold = NO_FEATURE, 0.0
        self.left: _Node | None = None
        self.right: _Node | None = None


class _Growing:
    """One agent's tree while it grows."""

    def __init__(self, obs: Float32, labels: Int, counts: Int, n_actions: int, max_depth: int, seed: int) -> None:
        self.obs, self.labels, self.counts = obs, labels, counts
        self.n_actions, self.max_depth, self.seed = n_actions, max_depth, seed
        self.everything = np.flatnonzero(counts)
        self.root: _Node | None = None
        self.whole = self._fit(self.everything, max_depth)  # predicts until there is a root

    def _fit(self, rows: Int, depth: int) -> Any:
        return cart(self.obs[rows], self.labels[rows], self.counts[rows], depth, self.seed)

    def right(self) -> Bool:
        """Returns True for each point that is predicted as the expert acts, [n]."""
        if self.root is None:
            return np.equal(self.whole.predict(self.obs), self.labels)
        said = np.empty(len(self.obs), dtype=np.int64)
        stack = [(self.root, np.arange(len(self.obs)))]
        while stack:
            node, here = stack.pop()
            if not here.size:
                continue
            if node.left is not None and node.right is not None:
                goes_left = self.obs[here, node.feature] < node.threshold
                stack += [(node.left, here[goes_left]), (node.right, here[~goes_left])]
            else:
                said[here] = node.action if node.projected is None else node.projected.predict(self.obs[here])
        return np.equal(said, self.labels)

    def make_node(self, rows: Int, depth: int, keep: Bool) -> _Node:
        """A node from the points that reach it, filtered; from all of them where none is left."""
        kept = rows[keep[rows]]
        rows = kept if kept.size else rows
        action = int(np.bincount(self.labels[rows], self.counts[rows], self.n_actions).argmax())
        projected = None if depth >= self.max_depth else self._fit(rows, max(1, self.max_depth - depth))
        return _Node(rows, depth, action, projected)

    def grow(self, level: int, keep: Bool) -> None:
        """A pass: makes the root, or splits every node above `level` that has no children; the root is made anew first
        where it has none.
        """
        if self.root is None or (level == 1 and self.root.left is None):
            self.root = self.make_node(self.everything, 0, keep)
        stack = [self.root]
        while stack:
            node = stack.pop()
            if node.depth >= level:
                continue
            if node.left is not None and node.right is not None:
                stack += [node.right, node.left]
                continue
            split = best_split(self.obs[node.rows], self.labels[node.rows], self.counts[node.rows], self.n_actions)
            if split is None:
                continue
            node.feature, node.threshold = split
            goes_left = self.obs[node.rows, node.feature] < node.threshold
            parts = node.rows[goes_left], node.rows[~goes_left]
            if all(self.counts[part].sum() >= FEWEST for part in parts):
                node.left, node.right = (self.make_node(part, node.depth + 1, keep) for part in parts)

    def tree(self) -> GrownTree:
        """The tree grown so far; "less goes left" is "at most the float64 before it"."""
        rows: list[list[float]] = []

        def add(node: _Node) -> int:
            place = len(rows)
            rows.append([NO_FEATURE, 0.0, NO_CHILD, NO_CHILD, node.action])
            if node.left is not None and node.right is not None:
                before = float(np.nextafter(node.threshold, -np.inf))
                rows[place] = [node.feature, before, add(node.left), add(node.right), NO_ACTION]
            return place

        assert self.root is not None
        add(self.root)
        return GrownTree(*(np.array(column) for column in zip(*rows, strict=True)))


def best_split(obs: Float32, labels: Int, counts: Int, n_actions: int) -> tuple[int, float] | None:
    """The split of least weighted Gini impurity among the midpoints of neighbouring values, if it is an improvement;
    of equals the first feature's lowest.
    """
    weights = np.eye(n_actions)[labels] * counts[:, None]
    totals = weights.sum(axis=0)
    best, split = _purity(totals[None])[0] + 1e-9, None  # strictly better
    for feature, column in enumerate(np.ascontiguousarray(obs.T)):
        order = np.argsort(column, kind="stable")
        values = column[order].astype(np.float64)
        left = weights[order].cumsum(axis=0)[:-1]
        purity = np.where(values[1:] > values[:-1], _purity(left) + _purity(totals - left), -np.inf)
        if len(purity) and purity.max() > best:
            place = int(purity.argmax())
            best, split = purity[place], (feature, float((values[place] + values[place + 1]) / 2))
    return split


def _purity(counts: Float64) -> Float64:
    """Summed squares of class counts over their sum, per row; the impurity of two parts falls as theirs rises."""
    return np.square(counts).sum(axis=1) / np.maximum(counts.sum(axis=1), 1e-300)


def grow_team(
    observations: Sequence[Float32],
    labels: Int,
    counts: Sequence[Int],
    n_actions: Sequence[int],
    max_depth: int,
    rng: np.random.Generator,
    predicts: bool,
    alive: Bool,
) -> list[GrownTree]:
    """The trees of one team of N agents over n shared points. `observations`: per agent [n, n_features]; `labels`,
    `alive`: [n, N]; `counts`: per agent [n], how often its data set holds each point; `predicts`: whether points are
    filtered by votes. Who takes no part in a point has no vote.
    """
    team = [
        _Growing(obs, labels[:, agent], counts[agent], n_actions[agent], max_depth, int(rng.integers(2**31)))
        for agent, obs in enumerate(observations)
    ]
    keep = np.ones(len(labels), dtype=bool)
    for level in range(max_depth + 1):
        for agent in map(int, rng.permutation(len(team))):
            if predicts:  # more than half of the team
                right = [member.right() & votes for member, votes in zip(team, alive.T, strict=True)]
                keep = 2 * np.sum(right, axis=0) > alive.sum(axis=1)
            team[agent].grow(level, keep)
    return [member.tree() for member in team]


WARM_UP = 500  # expert episodes
SET_ASIDE = 5  # one point in so many only feeds printed accuracies
STAY = 0  # what an all-zero one-hot action does
MAX_JOINT = 3_125  # joint actions of all agents that the weight of a state may take: five agents of five actions
ALONE = (IVIPER, VIPER)  # whose rounds are one agent's, among experts
FREE_STEPS = 25  # of Imitation's collector, before its counter makes every step a start


def check(world: World, settings: Settings) -> None:
    """InputError where the weight would take more joint actions than can be tried in every state."""
    if settings.preset != RELEASED or settings.algorithm not in (MAVIPER, NO_PREDICTION):
        return
    count = math.prod(len(choices) for choices in world.actions)
    if count > MAX_JOINT:
        what = f"the released weight tries all joint actions in every state, here {count:.2g}, at most {MAX_JOINT:,}"
        raise InputError(what, "--preset released", "choose --preset paper or default, or a game of fewer agents")


def rounds(asked: Extraction, agents: Sequence[int], selection: Selection) -> int:
    """Runs MAVIPER and its ablations by the released code, or IVIPER and VIPER for one agent; see `dagger.dagger`."""
    world, expert, settings, journal = asked.world, asked.expert, asked.settings, asked.journal
    experts: list[Controller] = [expert] * len(world.agents)
    examples = asked.examples.of_teams(*(world.team_of(world.agents[agent]) for agent in agents))
    weigh = partial(weights, world, expert, settings, agents=agents)
    grow = partial(_grow_resampled, agent=agents[0]) if settings.algorithm in ALONE else grow_teams
    warm_up = settings.episodes(measures.ROLLOUT_SEEDS)[: WARM_UP if settings.keeps(WARMING_UP) else settings.rollouts]
    data = journal.load_or_collect("warm-up", collect, world, expert, experts, agents, warm_up, weigh).data
    for iteration in range(settings.iterations):
        step, known = f"{iteration:04d}", examples.before(world, data, agents)
        grown = journal.trees(f"{step}-trees", grow, world, known, settings, iteration)
        policies = among(world, agent_policies(world, grown, agents), experts)
        seeds = settings.rollout_episodes(iteration, WARM_UP)
        met = journal.load_or_collect(f"{step}-rollouts", collect, world, expert, policies, agents, seeds, weigh)
        data = data + met.data
        selection.note_rollouts(met.values, met.fidelity)
        if selection.offer(grown):
            break
    return len(data)


# --- MAVIPER and its ablations


def weights(
    world: World,
    expert: Expert,
    settings: Settings,
    observations: tuple[Float32, ...],
    state: object,
    wanted: Int,
    agents: Sequence[int] | None = None,
) -> Float64:
    """The weights of all agents, or of some, [n, len(agents)], at least 0."""
    moved = settings.algorithm == IVIPER_RESAMPLING
    weigh = partial(_own_weight, moved=moved) if moved or settings.algorithm in ALONE else _team_weight
    mine = range(len(world.agents)) if agents is None else agents
    columns = [weigh(world, expert, observations, state, wanted, agent) for agent in mine]
    return np.maximum(np.stack(columns, axis=1), 0)


def _team_weight(
    world: World, expert: Expert, observations: tuple[Float32, ...], state: Any, wanted: Int, agent: int
) -> Float64:
    """Q at the team's expert actions less the minimum over its joint actions, each averaged over others' actions."""
    weights = np.zeros(len(wanted))
    everybody_else = [other for other in range(len(world.agents)) if other != agent]
    for rows, playing in in_play(world.alive(state), agent, everybody_else):
        seen = tuple(each[rows] for each in observations)
        weights[rows] = _team_weight_among(world, expert, seen, state[rows], wanted[rows], agent, playing)
    return weights


def _team_weight_among(
    world: World,
    expert: Expert,
    observations: tuple[Float32, ...],
    state: Any,
    wanted: Int,
    agent: int,
    playing: Sequence[int],
) -> Float64:
    members = world.members(world.team_of(world.agents[agent]))
    team = [member for member in members if member == agent or member in playing]
    others = [other for other in playing if other not in members]
    every = list(product(*(range(len(world.actions[other])) for other in others)))
    theirs = np.array(every, dtype=np.int64).reshape(len(every), len(others))

    def average_q(ours: Int) -> Float64:
        joint = np.full((len(theirs), len(world.agents)), AS_GIVEN, dtype=np.int64)
        joint[:, others] = theirs
        joint[:, team] = ours
        return expert.q(agent, observations, state, joint, wanted).mean(axis=1)

    choices = product(*(range(len(world.actions[member])) for member in team))
    worst = np.min([average_q(np.array(ours)) for ours in choices], axis=0)
    return average_q(np.full(len(team), AS_GIVEN)) - worst


def _own_weight(
    world: World,
    expert: Expert,
    observations: tuple[Float32, ...],
    state: Any,
    wanted: Int,
    agent: int,
    moved: bool,
) -> Float64:
    """Maximum less minimum over own actions; others at expert actions, but if they are `moved`, those before the agent
    at their last action, where the released list of joint actions, changed in place, leaves them.
    """
    joint = np.full((len(world.actions[agent]), len(world.agents)), AS_GIVEN, dtype=np.int64)
    if moved:
        joint[:, :agent] = [len(world.actions[other]) - 1 for other in range(agent)]
    joint[:, agent] = np.arange(len(joint))
    weights = np.zeros(len(wanted))
    for rows, _ in in_play(world.alive(state), agent, []):
        seen = tuple(each[rows] for each in observations)
        weights[rows] = np.ptp(expert.q(agent, seen, state[rows], joint, wanted[rows]), axis=1)
    return weights


def grow_teams(world: World, data: Dataset, settings: Settings, iteration: int) -> list[GrownTree]:
    """The trees of all agents; without prediction every point is kept."""
    rng = np.random.default_rng([settings.seed, iteration])
    used = rng.permutation(len(data))[len(data) // SET_ASIDE :]
    columns = zip(data.weights.T, data.alive.T, strict=True)
    counts = [_draw_counts(column, alive, used, settings.max_samples, rng) for column, alive in columns]
    trees: dict[int, GrownTree] = {}
    for team in world.teams:
        members = world.members(team)
        grown = grow_team(
            [data.observations[agent] for agent in members],
            data.labels[:, members],
            [counts[agent] for agent in members],
            [len(world.actions[agent]) for agent in members],
            settings.max_depth,
            rng,
            settings.algorithm != NO_PREDICTION,
            data.alive[:, members],
        )
        trees |= dict(zip(members, grown, strict=True))
    return [trees[agent] for agent in range(len(world.agents))]


def _draw_counts(column: Float64, alive: Bool, used: Int, max_samples: int, rng: np.random.Generator) -> Int:
    """Draws the counts of the points: as many draws as points of positive weight among those used."""
    counts = np.zeros(len(column), dtype=np.int64)
    mine = column[used]
    positive = int((mine > 0).sum())
    if positive:
        counts[used] = rng.multinomial(min(max_samples, positive), mine / mine.sum())
    else:  # the released code divides by zero here
        counts[used] = alive[used]
    return counts


# --- one-hot trees: IVIPER and Imitation DT


def _grow_resampled(world: World, data: Dataset, settings: Settings, iteration: int, agent: int) -> list[GrownTree]:
    rng = np.random.default_rng([settings.seed, agent, iteration])
    everything = np.arange(len(data))
    counts = _draw_counts(data.weights[:, 0], data.alive[:, agent], everything, settings.max_samples, rng)
    rows = np.repeat(np.arange(len(data)), counts)
    rows = rng.permutation(rows)[len(rows) // SET_ASIDE :]  # split after resampling, so that duplicates leak
    kept = np.bincount(rows, minlength=len(data))
    n_actions = len(world.actions[agent])
    seen, acted = data.observations[agent], data.labels[:, agent]
    return [one_hot_tree(seen, acted, kept, n_actions, settings.max_depth, settings.keeps(LEAVES))]


def imitation(asked: Extraction, everybody: Sequence[int], selection: Selection) -> int:
    """Runs Imitation DT by the released code: almost all points are start states; see `dagger.dagger`."""
    world, expert, settings = asked.world, asked.expert, asked.settings
    journal, examples = asked.journal, asked.examples
    collected, stays = _starts if settings.keeps(RESTARTS) else _episodes, settings.keeps(LEAVES)
    data: Dataset | None = None
    for iteration in range(settings.iterations):
        step = f"{iteration:04d}"
        arrays = journal.arrays(f"{step}-rollouts", collected, world, expert, settings, iteration)
        new = tuple(arrays[f"observations.{agent:03d}"] for agent in everybody)
        met = Dataset(new, arrays["labels"], arrays["alive"].astype(np.float64), arrays["alive"])
        data = met if data is None else data + met
        known = examples.before(world, data)
        grown = [
            one_hot_tree(obs, labelled, counts_of(column), len(world.actions[agent]), settings.max_depth, stays)
            for agent, (obs, labelled, column) in enumerate(
                zip(known.observations, known.labels.T, known.weights.T, strict=True)
            )
        ]
        if selection.offer(grown):
            break
    return len(data) if data else 0


def _starts(world: World, expert: Expert, settings: Settings, iteration: int) -> Arrays:
    """Samples as many points as `rollouts` episodes have: in the first iteration one episode for FREE_STEPS, otherwise
    start states.
    """
    rng = np.random.default_rng([settings.seed, iteration])
    wanted = settings.rollouts * world.spec.episode_steps
    wanted = max(1, wanted - FREE_STEPS if iteration == 0 else wanted)
    at_once = world.games or wanted
    parts = [world.start(min(at_once, wanted - done), rng) for done in range(0, wanted, at_once)]
    state = parts[0] if len(parts) == 1 else type(parts[0]).concatenate(parts)
    observations = world.observe(state)
    acted = labels(expert, observations, state)
    met = Dataset(observations, acted, np.zeros(acted.shape), world.alive(state))
    if iteration == 0:
        met = _play_episodes(world, expert, settings.episodes(measures.ROLLOUT_SEEDS)[:1]) + met
    return _arrays(met)


def _episodes(world: World, expert: Expert, settings: Settings, iteration: int) -> Arrays:
    """Whole expert episodes: what the collector was to do."""
    return _arrays(_play_episodes(world, expert, settings.rollout_episodes(iteration)))


def _play_episodes(world: World, expert: Expert, seeds: Sequence[int]) -> Dataset:
    everybody = range(len(world.agents))
    zeros = lambda observations, state, acted: np.zeros(acted.shape)  # noqa: E731 - weights are not used here
    return collect(world, expert, [expert] * len(everybody), everybody, seeds, zeros).data


def _arrays(data: Dataset) -> Arrays:
    named = {f"observations.{agent:03d}": seen for agent, seen in enumerate(data.observations)}
    return {**named, "labels": data.labels, "alive": data.alive}


def one_hot_tree(
    obs: Float32, acted: Int, counts: Int, n_actions: int, max_depth: int, stays: bool = True
) -> GrownTree:
    """A tree of one output per action. If it `stays`, a leaf in which no action has more than half says none, and the
    agent stands still; otherwise it says the most frequent one.
    """
    from sklearn.tree import DecisionTreeClassifier

    used = counts > 0
    targets = np.eye(n_actions, dtype=np.int64)[acted[used]]
    fitted = DecisionTreeClassifier(max_depth=max_depth, random_state=0)
    tree = fitted.fit(obs[used], targets, sample_weight=counts[used]).tree_
    classes = [np.asarray(known) for known in fitted.classes_]
    # value: [n_nodes, n_outputs, n_classes] shares; an output that is never 1 has one class only
    said = np.zeros((tree.node_count, n_actions))
    for output, known in enumerate(classes):
        if 1 in known:
            said[:, output] = tree.value[:, output, int(np.flatnonzero(known == 1)[0])]
    action = np.where((said > 0.5).any(axis=1) | (not stays), said.argmax(axis=1), STAY)
    return read_sklearn_tree(tree, action)
