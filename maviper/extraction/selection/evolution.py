"""Refinement by return of trees that give numbers (ours): an evolution strategy on leaves' numbers and thresholds.

Does: plays a team with all of its numbers moved a little, in random directions and their opposites, on the same
  episodes; takes a step in the direction that paid, of the length that plays best in further ones. In the end the team
  is kept where it plays better than the one that it started as, by more than chance, in episodes that chose nothing.
Assumes: trees whose leaves give numbers; opponents, and team-mates outside the arena, at their experts.
Does not: add terms to sums, or change what is tested: a tree keeps its size in leaves and in numbers.

Antithetic pairs and common random numbers as in Salimans et al. 2017 (arXiv 1703.03864). Numbers move in units of what
they do: outputs by parts of their ranges, thresholds by parts of the deviation of what is tested, weights so that an
output moves as much over the observations that reach the leaf. What no observation reaches stays.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from codegen.ir import NO_FEATURE, Float32, Float64, GrownTree
from codegen.lowering.deploy import SummedTree
from maviper.extraction.selection.arena import Arena
from maviper.extraction.selection.stack import reaching
from maviper.extraction.selection.tilting import columns_of
from maviper.worlds.world import bounds

PAIRS = 16  # directions of a round, each of them played forwards and backwards
PLAYED = 8  # episodes of each, in a small round
SPREAD = 0.05  # of an output, in parts of its range
TEST_SPREAD = 0.05  # of a threshold, in deviations of what is tested
LAST_SPREAD = 0.25  # of both, in parts of those in the first round: what rounds tend to
STEPS = (1.0, 2.0, 4.0)  # lengths, in spreads
RACED = 24  # episodes of each length, in a small round
ROUNDS = 40  # small ones; with more episodes than these take, rounds become more and larger alike
JUDGED = 200  # episodes of the team before and after
LEAST_SCALE = 0.25  # of a feature's deviation in a leaf, in parts of that over all observations

Trees = list[GrownTree]


@dataclass(frozen=True)
class Moves:
    """How far the numbers of one tree go for a unit of a direction."""

    thresholds: Float64  # [n_nodes]; 0 at leaves, and where no observation gets
    numbers: Float64  # [n_vectors, n_outputs, n_features + 1], the constant last; 0 where there is no term
    centers: Float64  # [n_vectors, n_features]: where a leaf's sums stay as they are when weights move

    @staticmethod
    def of(tree: SummedTree, obs: Float32, ranges: Float64) -> "Moves":
        """Of a tree that meets these observations. `ranges`: [n_outputs], of the outputs."""
        wide = obs.astype(np.float64)
        tested = columns_of(tree, obs)
        thresholds, numbers = np.zeros(len(tree.feature)), np.zeros(tree.given.shape)
        centers, least = np.zeros((len(tree.given), wide.shape[1])), LEAST_SCALE * wide.std(axis=0)
        for node, rows in reaching(tree, tested).items():
            if tree.feature[node] != NO_FEATURE:
                thresholds[node] = TEST_SPREAD * tested[rows, tree.feature[node]].std()
                continue
            vector = tree.action[node]
            centers[vector] = wide[rows].mean(axis=0)
            scale = np.maximum(wide[rows].std(axis=0), least)
            parts = np.append(np.divide(1.0, scale, out=np.zeros_like(scale), where=scale > 0), 1.0)
            terms = np.concatenate([tree.given[vector, :, :-1] != 0, np.ones((len(ranges), 1), dtype=bool)], axis=1)
            count = terms.sum(axis=1, keepdims=True)
            numbers[vector] = SPREAD * ranges[:, None] * terms * parts / np.sqrt(count)
        return Moves(thresholds, numbers, centers)

    @property
    def size(self) -> int:
        """How many numbers a direction has."""
        return self.thresholds.size + self.numbers.size

    def apply(self, tree: SummedTree, direction: Float64) -> SummedTree:
        """The tree moved in a direction, [size]."""
        first = self.thresholds.size
        moved = direction[first:].reshape(self.numbers.shape) * self.numbers
        moved[..., -1] -= np.einsum("vok,vk->vo", moved[..., :-1], self.centers)
        threshold = tree.threshold + direction[:first] * self.thresholds
        return replace(tree, threshold=threshold, given=tree.given + moved)


def round_cost(scale: int = 1) -> int:
    """Episodes of one round that is so many times a small one."""
    return scale * (PLAYED * (1 + 2 * PAIRS) + RACED * (1 + len(STEPS)))


def round_scale(episodes: int) -> int:
    """How many times a small one a round is, with so many episodes for all rounds. Small rounds find the way from bad
    trees in few episodes; the gains of good ones drown in the differences between episodes.
    """
    return max(1, math.isqrt(episodes // (ROUNDS * round_cost())))


def judging_cost() -> int:
    """Episodes of the last comparison."""
    return 2 * JUDGED


def improve_numbers(
    arena: Arena, trees: Trees, done: float, rng: np.random.Generator, scale: int = 1
) -> tuple[Trees, Float64]:
    """One round: the team after the step that plays best, or the same team when none does, and its primary measure in
    the episodes that compared them. `done`: the share of all rounds that are; steps become shorter. `scale`: as of
    `round_cost`.
    """
    spread, played = 1 - done * (1 - LAST_SPREAD), scale * PLAYED
    arena.scores([trees], played)  # for what its agents observe
    moves = [
        Moves.of(_as_summed(tree), seen, np.subtract(*reversed(bounds(arena.world.outputs[agent]))))
        for agent, tree, seen in zip(arena.agents, trees, arena.seen, strict=True)
    ]
    directions = [spread * rng.standard_normal((PAIRS, each.size)) for each in moves]
    pairs = [
        _move(trees, moves, [sign * each[pair] for each in directions]) for pair in range(PAIRS) for sign in (1, -1)
    ]
    scored = arena.scores(pairs, played).mean(axis=1).reshape(PAIRS, 2)
    paid = scored[:, 0] - scored[:, 1]
    length = float(np.linalg.norm(paid))
    lengths = STEPS if length > 0 else ()
    ahead = [paid @ each / length for each in directions] if lengths else []
    steps = [_move(trees, moves, [length * each for each in ahead]) for length in lengths]
    best = int(arena.scores([trees, *steps], scale * RACED).mean(axis=1).argmax())
    return [trees, *steps][best], arena.values[best]


def _move(trees: Trees, moves: Sequence[Moves], directions: Sequence[Float64]) -> Trees:
    return [each.apply(_as_summed(tree), way) for tree, each, way in zip(trees, moves, directions, strict=True)]


def _as_summed(tree: GrownTree) -> SummedTree:
    assert isinstance(tree, SummedTree)
    return tree


def judge(arena: Arena, before: Trees, after: Trees) -> tuple[Trees, Float64]:
    """The team after refinement where it plays better than before by more than chance, else that before; and its
    primary measure in the episodes that told.
    """
    scored = arena.scores([before, after], JUDGED)
    gains = scored[1] - scored[0]
    better = gains.mean() > gains.std() / np.sqrt(len(gains))
    return (after if better else before), arena.values[int(better)]
