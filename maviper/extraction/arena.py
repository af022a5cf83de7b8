"""Candidates of a team on common episodes, and races among them.

Does: applies a stack of trees to observations, each row with a tree of its own; copies trees with a small change; plays
  many candidates at once on the same start states, everybody else at the expert; finds the best with few episodes
  (sequential halving, Karnin et al. 2013; common random numbers), of teams or of each member.
Assumes: a world that can start the same episodes again; trees over the same features, their thresholds rounded as they
  are deployed; leaves that are changed take actions.
Does not: make candidates.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import Any

import numpy as np

from codegen import ir
from codegen.ir import CONSTANT, NO_ACTION, NO_CHILD, NO_FEATURE, ROOT, Bool, Float32, Float64, Floats, GrownTree, Sum
from codegen.lowering.deploy import SummedTree
from codegen.numbers import round_down
from codegen.sums import clip_values
from maviper.episodes.measures import score
from maviper.episodes.play import Controller, in_columns, play, start_games
from maviper.episodes.trees import agent_policies
from maviper.worlds import World
from maviper.worlds.world import Int


@dataclass(frozen=True)
class Stack:
    """`n_trees` trees padded to the same number of nodes; a leaf is its own child."""

    feature: Int  # [n_trees * n_nodes], as all others; 0 at a leaf
    threshold: Float32  # NaN at a leaf, so that every observation goes right
    left: Int  # places in these arrays
    right: Int
    action: Int
    n_nodes: int
    depth: int

    @staticmethod
    def of(trees: Sequence[GrownTree]) -> "Stack":
        """A stack of trees."""
        n_nodes = max(len(tree.feature) for tree in trees)
        size = len(trees) * n_nodes
        feature, action = np.zeros(size, dtype=np.int64), np.zeros(size, dtype=np.int64)
        threshold = np.full(size, np.nan, dtype=np.float32)
        left, right = np.arange(size), np.arange(size)
        depth = 0
        for index, tree in enumerate(trees):
            first = index * n_nodes
            here = slice(first, first + len(tree.feature))
            split = tree.feature != NO_FEATURE
            feature[here] = np.where(split, tree.feature, 0)
            threshold[here] = np.where(split, round_down(tree.threshold), np.float32(np.nan))
            left[here] = np.where(split, first + tree.left, left[here])
            right[here] = np.where(split, first + tree.right, right[here])
            action[here] = np.where(split, 0, tree.action)
            depth = max(depth, int(ir.depth(tree).max()))
        return Stack(feature, threshold, left, right, action, n_nodes, depth)

    def act(self, which: Int, obs: Float32) -> Int:
        """Returns the action of tree `which[row]` for each row of `obs` [n, n_features], [n]."""
        node = which * self.n_nodes
        flat, base = np.ascontiguousarray(obs).ravel(), np.arange(len(obs)) * obs.shape[1]
        for _ in range(self.depth):
            goes_left = flat[base + self.feature[node]] <= self.threshold[node]
            node = np.where(goes_left, self.left[node], self.right[node])
        return self.action[node]


@dataclass(frozen=True)
class SummedStack:
    """A `Stack` of trees that test sums or give numbers: what each node tests is a sum of few terms.

    Terms are added from left to right, as the reference does it. -0.0 stands for those that a shorter sum has not,
    since adding it changes no number. So observations are followed by -0.0 and 1, of which a constant is a multiple.
    """

    place: Int  # [n_trees * n_nodes, most terms] of a term's feature
    weight: Float64
    threshold: Float64  # [n_trees * n_nodes], as all others; NaN at a leaf, so that every observation goes right
    left: Int
    right: Int
    action: Int  # at a leaf: what it does, or its place in the vectors
    n_nodes: int
    depth: int
    places: Int  # [n_vectors, n_outputs, most terms] of the vectors that leaves give; empty where they act
    weights: Float64
    outputs: Sequence[ir.OutputSpec]

    @staticmethod
    def of(policies: Sequence[ir.AgentPolicy]) -> "SummedStack":
        """A stack of one agent's policies."""
        trees, outputs = [policy.tree for policy in policies], policies[0].outputs
        n_features, n_nodes = len(policies[0].features), max(len(tree.feature) for tree in trees)
        size, tests = len(trees) * n_nodes, list[Sum]()
        threshold, action = np.full(size, np.nan), np.zeros(size, np.int64)
        left, right = np.arange(size), np.arange(size)
        vectors: list[tuple[Sum, ...]] = []
        for index, tree in enumerate(trees):
            first = index * n_nodes
            here, split = slice(first, first + len(tree.feature)), tree.feature != NO_FEATURE
            single = [Sum(((1.0, feature),)) for feature in range(n_features)]
            known = [*single, *tree.sums, single[0]]  # a leaf may test anything: its feature is -1
            tests += [known[feature] for feature in tree.feature] + single[:1] * (n_nodes - len(tree.feature))
            threshold[here] = np.where(split, tree.threshold, np.nan)
            left[here] = np.where(split, first + tree.left, left[here])
            right[here] = np.where(split, first + tree.right, right[here])
            action[here] = np.where(split, 0, tree.action + len(vectors))
            vectors += tree.vectors
        depth = max(int(ir.depth(tree).max()) for tree in trees)
        place, weight = _pad_terms(tests, n_features)
        places, weights = _pad_terms([each for vector in vectors for each in vector], n_features)
        shape = len(vectors), len(outputs), -1
        vectored = (places.reshape(shape), weights.reshape(shape)) if vectors else (places, weights)
        return SummedStack(place, weight, threshold, left, right, action, n_nodes, depth, *vectored, outputs)

    def act(self, which: Int, obs: Float32) -> Any:
        """Returns the actions like `Stack.act`, or the numbers that agents give, [n, n_outputs] float32."""
        node, n_features = which * self.n_nodes, obs.shape[1]
        wide = np.empty((len(obs), n_features + 2))
        wide[:, :n_features], wide[:, n_features:] = obs, (-0.0, 1.0)
        flat, base = wide.ravel(), np.arange(len(obs)) * wide.shape[1]
        with np.errstate(over="ignore", under="ignore", invalid="ignore"):
            for _ in range(self.depth):
                tested = _add_terms(flat, base[:, None] + self.place[node], self.weight[node])
                node = np.where(tested <= self.threshold[node], self.left[node], self.right[node])
            action = self.action[node]
            if not self.outputs:
                return action
            values = _add_terms(flat, base[:, None, None] + self.places[action], self.weights[action])
            given = np.empty(values.shape, np.float32)
            for column, output in enumerate(self.outputs):
                given[:, column] = clip_values(values[:, column], output.low, output.high)
        return given


def _pad_terms(sums: Sequence[Sum], n_features: int) -> tuple[Int, Float64]:
    """The places and the weights of the terms of sums, [n_sums, most terms]; shorter sums end with terms of -0.0."""
    most = max((len(each.terms) for each in sums), default=0)
    places, weights = np.full((len(sums), most), n_features), np.ones((len(sums), most))
    for row, each in enumerate(sums):
        places[row, : len(each.terms)] = [n_features + 1 if at == CONSTANT else at for _, at in each.terms]
        weights[row, : len(each.terms)] = [weight for weight, _ in each.terms]
    return places, weights


def _add_terms(flat: Float64, places: Int, weights: Float64) -> Float64:
    """Sums of terms, from left to right. `places`, `weights`: [..., n_terms]."""
    terms = flat[places] * weights
    total = terms[..., 0]
    for column in range(1, terms.shape[-1]):
        total = total + terms[..., column]
    return total


def stack_trees(world: World, agent: int, trees: Sequence[GrownTree]) -> Stack | SummedStack:
    """Trees of an agent, to be asked at once."""
    if any(isinstance(tree, SummedTree) for tree in trees):
        return SummedStack.of([agent_policies(world, [tree], [agent])[0] for tree in trees])
    return Stack.of(trees)


def reaching(tree: GrownTree, obs: Floats) -> dict[int, Int]:
    """Returns node -> rows of `obs` that pass through it, for every node from the root down that any row reaches."""
    threshold = round_down(tree.threshold)
    rows_at: dict[int, Int] = {ROOT: np.arange(len(obs))}
    stack = [ROOT]
    while stack:
        node = stack.pop()
        if tree.feature[node] == NO_FEATURE:
            continue
        rows = rows_at[node]
        goes_left: Bool = obs[rows, tree.feature[node]] <= threshold[node]
        for child, part in ((int(tree.left[node]), rows[goes_left]), (int(tree.right[node]), rows[~goes_left])):
            if part.size:
                rows_at[child] = part
                stack.append(child)
    return rows_at


def with_leaf(tree: GrownTree, node: int, action: int) -> GrownTree:
    """The tree with a leaf at `node` instead of what is there."""
    arrays = _copies(tree)
    for array, value in zip(arrays, (NO_FEATURE, 0.0, NO_CHILD, NO_CHILD, action), strict=True):
        array[node] = value
    return _compact(tree, arrays)


def with_split(tree: GrownTree, node: int, feature: int, threshold: float) -> GrownTree:
    """The tree with another test at the split `node`."""
    arrays = _copies(tree)
    arrays[0][node], arrays[1][node] = feature, threshold
    return _with_arrays(tree, arrays)


def with_new_split(tree: GrownTree, leaf: int, feature: int, threshold: float, actions: tuple[int, int]) -> GrownTree:
    """The tree with a leaf turned into a split with two leaves."""
    n = len(tree.feature)
    added = ([NO_FEATURE] * 2, [0.0] * 2, [NO_CHILD] * 2, [NO_CHILD] * 2, list(actions))
    arrays = [np.concatenate([array, more]) for array, more in zip(_copies(tree), added, strict=True)]
    for array, value in zip(arrays, (feature, threshold, n, n + 1, NO_ACTION), strict=True):
        array[leaf] = value
    return _with_arrays(tree, arrays)


def merge_leaves(tree: GrownTree) -> GrownTree:
    """The tree without splits that decide nothing: equal sibling leaves become one, from the bottom up."""
    arrays = _copies(tree)
    feature, _, left, right, action = arrays
    order = np.argsort(-ir.depth(tree), kind="stable")
    for node in order:
        if feature[node] != NO_FEATURE:
            a, b = left[node], right[node]
            if feature[a] == feature[b] == NO_FEATURE and action[a] == action[b]:
                for array, value in zip(arrays, (NO_FEATURE, 0.0, NO_CHILD, NO_CHILD, action[a]), strict=True):
                    array[node] = value
    return _compact(tree, arrays)


def _with_arrays(tree: GrownTree, arrays: Sequence[np.ndarray]) -> GrownTree:
    """A tree of other arrays, with the sums that the tree may test."""
    return replace(tree, **dict(zip(("feature", "threshold", "left", "right", "action"), arrays, strict=True)))


def _copies(tree: GrownTree) -> list[np.ndarray]:
    return [array.copy() for array in (tree.feature, tree.threshold, tree.left, tree.right, tree.action)]


def _compact(tree: GrownTree, arrays: Sequence[np.ndarray]) -> GrownTree:
    """Without nodes that the root no longer leads to; the others keep their order."""
    feature, _, left, right, _ = arrays
    kept = np.zeros(len(feature), dtype=bool)
    stack = [ROOT]
    while stack:
        node = stack.pop()
        kept[node] = True
        if feature[node] != NO_FEATURE:
            stack += [int(left[node]), int(right[node])]
    place = np.append(np.cumsum(kept) - 1, NO_CHILD)  # the last entry is what NO_CHILD leads to
    feature, threshold, left, right, action = (array[kept] for array in arrays)
    return _with_arrays(tree, [feature, threshold, place[left], place[right], action])


GAMES_AT_ONCE = 8_192  # bounds the memory
MATCHED = 4  # episodes that a random team plays
MAX_TEAMS = 64  # that members' last trees may form
Candidate = Sequence[GrownTree]  # one tree for each of an arena's agents, in their order


@dataclass(frozen=True)
class _Stacked:
    """A controller: agents played by stacks of trees, each game with trees of its own."""

    stacks: dict[int, tuple[Stack | SummedStack, Int]]  # agent -> its trees, and which of them plays in each game

    def act(self, agents: Sequence[int], observations: Sequence[Float32], state: Any) -> Int:
        """Returns the action of each agent's tree; see `Controller.act`."""
        del state
        return in_columns([self.stacks[agent][0].act(self.stacks[agent][1], observations[agent]) for agent in agents])


class Arena:
    """Where candidates of one team meet the same episodes. Every call draws the next episodes of `seeds`.

    `secondary`: weight in a score of the mean of the team's other shares (such as success at a smaller radius), which
    still tell candidates apart where the primary measure is near its end.
    """

    def __init__(
        self, world: World, expert: Controller, agents: Sequence[int], seeds: range, secondary: float = 0.0
    ) -> None:
        self.world, self.expert, self.agents, self.seeds = world, expert, list(agents), seeds
        self.primary = world.primary(world.team_of(world.agents[self.agents[0]]))
        self.secondary = secondary
        self._others = [
            place
            for place, measure in enumerate(world.measures)
            if measure.share and measure.team == self.primary.team and measure != self.primary
        ]
        self.used = 0  # episode seeds
        self.played = 0  # episodes
        self.seen: list[Float32] = []  # per agent, what it observed in all episodes of the last call's first candidate
        self.values: Float64 = np.zeros((0, 0))  # the primary measure of the last call, [n_candidates, episodes]

    def scores(self, candidates: Sequence[Candidate], episodes: int) -> Float64:
        """Scores of each candidate in each of the next `episodes`, [n_candidates, episodes]; higher is better."""
        seeds = self.seeds.start + np.arange(self.used, self.used + episodes) % len(self.seeds)
        self.used += episodes
        values, parts = list[Float64](), list[Float64]()
        which = np.repeat(np.arange(len(candidates)), episodes)
        seen: list[list[Float32]] = [[] for _ in self.agents]
        starts = start_games(self.world, seeds) if self.world.games is None else None
        at_once = self.world.games or GAMES_AT_ONCE
        for low in range(0, len(which), at_once):
            rows = np.arange(low, min(low + at_once, len(which)))
            start = start_games(self.world, seeds[rows % episodes]) if starts is None else starts[rows % episodes]
            stacks = dict[int, tuple[Stack | SummedStack, Int]]()
            met, playing = np.unique(which[rows], return_inverse=True)  # candidates, and which of them has each game
            here = list(map(int, met))
            for place, agent in enumerate(self.agents):
                trees = {id(candidates[index][place]): candidates[index][place] for index in here}
                number = {key: k for k, key in enumerate(trees)}
                mine = np.array([number[id(candidates[index][place])] for index in here])
                stacks[agent] = stack_trees(self.world, agent, list(trees.values())), mine[playing]
            team, everybody = _Stacked(stacks), range(len(self.world.agents))
            played = play(self.world, [team if agent in stacks else self.expert for agent in everybody], start)
            first = np.flatnonzero(which[rows] == 0)
            for agent, observed in zip(self.agents, seen, strict=True):
                observed.append(played.observations[agent][:, first][played.alive[:, first, agent]])
            values.append(played.values[self.world.measures.index(self.primary)])
            parts.append(score(self.primary, values[-1]))
            if self.secondary and self._others:
                parts[-1] = parts[-1] + self.secondary * played.values[self._others].mean(axis=0)
        self.seen = [np.concatenate(each) for each in seen]
        self.played += len(which)
        self.values = np.concatenate(values).reshape(len(candidates), episodes)
        return np.concatenate(parts).reshape(len(candidates), episodes)


def halving(
    scores: Callable[[Int, int], Float64],
    warm: Sequence[Float64],
    episodes: int,
    finalists: int = 1,
    alike: bool = False,
) -> list[int]:
    """Indices of the best arms, best first, by sequential halving.

    `scores(arms, episodes)`: [n_arms, episodes], on episodes that all of these arms meet; `warm`: scores of each arm
    from elsewhere, a prior that counts in the first of several rounds, and where no episodes are spent; `episodes`: to
    spend in all; `finalists`: how many to return; `alike`: whether `warm` are scores of the same play, which then count
    as much as those of the race.
    """
    alive = np.arange(len(warm))
    prior, believed = np.array([known.sum() for known in warm]), np.array([float(len(known)) for known in warm])
    total, count = np.zeros(len(warm)), np.zeros(len(warm))
    rounds = max(1, int(np.ceil(np.log2(max(1, len(alive) / finalists)))))
    for number in range(rounds):
        each = episodes // (rounds * len(alive))
        if each:
            fresh = scores(alive, each)
            total[alive] += fresh.sum(axis=1)
            count[alive] += each
        weight = float(alike or number == 0 < rounds - 1 or not count.any())
        mean = (total + weight * prior)[alive] / np.maximum((count + weight * believed)[alive], 1)
        kept = max(finalists, (len(alive) + 1) // 2)
        alive = alive[np.argsort(-mean, kind="stable")[:kept]]
    return [int(arm) for arm in alive[:finalists]]


def halving_by_member(
    scores: Callable[[Int, int], Float64],
    warm: Sequence[Float64],
    members: int,
    episodes: int,
    rng: np.random.Generator,
) -> list[list[int]]:
    """For each member of a team the indices of its best arms, best first, every member having the same arms.

    Half of the episodes goes to heats in which each member's arms meet random ones of its mates, and the better half of
    them stays; the other half to a race (`halving`) among all teams of those that are left. `scores(teams, episodes)`:
    [n_teams, episodes], for arms by member [n_teams, members], on episodes that all of these teams meet; `warm`: as in
    `halving`, the same for all members.
    """
    left = max(1, int(MAX_TEAMS ** (1 / members) + 1e-9))
    prior = np.array([known.sum() for known in warm])
    believed = np.array([float(len(known)) for known in warm])
    alive = [np.arange(len(warm)) for _ in range(members)]
    heats = max(0, int(np.ceil(np.log2(max(1, len(warm) / left)))))
    for number in range(heats):
        count = len(alive[0])
        total = np.zeros((members, len(warm)))
        drawn = max(1, episodes // 2 // (heats * count * MATCHED))
        for _ in range(drawn):
            teams = np.stack([rng.permutation(mine) for mine in alive], axis=1)
            fresh = scores(teams, MATCHED).sum(axis=1)
            for member, mine in enumerate(teams.T):
                total[member, mine] += fresh
        weight = float(number == 0)
        mean = (total + weight * prior) / np.maximum(drawn * MATCHED + weight * believed, 1)
        kept = max(left, (count + 1) // 2)
        alive = [mine[np.argsort(-mean[member, mine], kind="stable")[:kept]] for member, mine in enumerate(alive)]
    teams = np.array(list(product(*alive)))
    spent = episodes // 2 if heats else 0
    (best,) = halving(lambda arms, each: scores(teams[arms], each), [np.zeros(0)] * len(teams), episodes - spent)
    return [
        [int(chosen), *(int(arm) for arm in mine if arm != chosen)]
        for chosen, mine in zip(teams[best], alive, strict=True)
    ]
