"""Refinement by return of the numbers in trees (ours): an evolution strategy on thresholds, and on what leaves give or,
where leaves take actions, on the weights of sums that are tested.

Does: plays a team with all of its numbers moved a little, in random directions and their opposites, on the same
  episodes; takes a step in the direction that paid, of the length that plays best in further ones; where leaves take
  actions, a short one in every round. In the end the team is kept where it plays better than the one that it started
  as, by more than chance, in episodes that chose nothing.
Assumes: opponents, and team-mates outside the arena, at their experts.
Does not: add terms to sums, or change what else is tested: a tree keeps its size in leaves and in numbers.

Antithetic pairs and common random numbers as in Salimans et al. 2017 (arXiv 1703.03864). Numbers move in units of what
they do: outputs by parts of their ranges, thresholds by parts of the deviation of what is tested, weights so that an
output, or what is tested, moves as much over the observations that reach the node. What no observation reaches stays.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from codegen.ir import NO_FEATURE, Float32, Float64, GrownTree
from codegen.lowering.deploy import SummedTree
from maviper.extraction.growth.sums import columns_of
from maviper.extraction.selection.arena import Arena, reaching
from maviper.worlds.world import bounds

PAIRS = 16  # directions of a round, each of them played forwards and backwards
PLAYED = 8  # episodes of each, in a small round
SPREAD = 0.05  # of an output, in parts of its range
TEST_SPREAD = 0.05  # of a threshold, in deviations of what is tested
LAST_SPREAD = 0.25  # of both, in parts of those in the first round: what rounds tend to
STEPS = (1.0, 2.0, 4.0)  # lengths, in spreads
RACED = 24  # episodes of each length, in a small round
ROUNDS = 40  # small ones; with more episodes than these take, rounds become more and larger alike
DRIFT = 0.3  # where leaves take actions: length of every step, in spreads
DRIFT_SPREAD = 2.0  # of tests there, in parts of TEST_SPREAD
DRIFT_PAIRS, DRIFT_PLAYED = 24, 24  # as PAIRS and PLAYED there
JUDGED = 200  # episodes of the team before and after
LEAST_SCALE = 0.25  # of a feature's deviation in a leaf, in parts of that over all observations

Trees = list[GrownTree]


@dataclass(frozen=True)
class Moves:
    """The changes of one tree's numbers for a unit of a direction."""

    thresholds: Float64  # [n_nodes]; 0 at leaves, and where no observation gets
    numbers: Float64  # [n_vectors, n_outputs, n_features + 1], the constant last; 0 where there is no term
    centers: Float64  # [n_vectors, n_features]: where a leaf's sums stay as they are when weights move
    tests: Float64  # [n_sums, n_features]; [0, n_features] where leaves give numbers
    tested_centers: Float64  # alike: where what is tested stays as far from the threshold

    @staticmethod
    def of(tree: SummedTree, obs: Float32, ranges: Float64) -> "Moves":
        """Of a tree that meets these observations; each split has a sum of its own if leaves take actions. `ranges`:
        [n_outputs], of the outputs.
        """
        wide = obs.astype(np.float64)
        tested, n_features = columns_of(tree, obs), wide.shape[1]
        thresholds, numbers = np.zeros(len(tree.feature)), np.zeros(tree.given.shape)
        centers, least = np.zeros((len(tree.given), n_features)), LEAST_SCALE * wide.std(axis=0)
        tests = np.zeros_like(tree.tests[: 0 if len(ranges) else None], dtype=np.float64)
        tested_centers = np.zeros_like(tests)
        for node, rows in reaching(tree, tested).items():
            scale = np.maximum(wide[rows].std(axis=0), least)
            parts = np.append(np.divide(1.0, scale, out=np.zeros_like(scale), where=scale > 0), 1.0)
            feature, vector = int(tree.feature[node]), int(tree.action[node])
            if feature != NO_FEATURE:
                thresholds[node] = TEST_SPREAD * tested[rows, feature].std()
                if n_features <= feature < n_features + len(tests):
                    terms = tree.tests[feature - n_features] != 0
                    tests[feature - n_features] = thresholds[node] * terms * parts[:-1] / np.sqrt(terms.sum())
                    tested_centers[feature - n_features] = wide[rows].mean(axis=0)
            elif len(ranges):
                centers[vector] = wide[rows].mean(axis=0)
                terms = np.concatenate([tree.given[vector, :, :-1] != 0, np.ones((len(ranges), 1), dtype=bool)], axis=1)
                count = terms.sum(axis=1, keepdims=True)
                numbers[vector] = SPREAD * ranges[:, None] * terms * parts / np.sqrt(count)
        return Moves(thresholds, numbers, centers, tests, tested_centers)

    @property
    def size(self) -> int:
        """The number of numbers in a direction."""
        return self.thresholds.size + self.numbers.size + self.tests.size

    def apply(self, tree: SummedTree, direction: Float64) -> SummedTree:
        """The tree moved in a direction, [size]."""
        first, last = self.thresholds.size, self.thresholds.size + self.numbers.size
        moved = direction[first:last].reshape(self.numbers.shape) * self.numbers
        moved[..., -1] -= np.einsum("vok,vk->vo", moved[..., :-1], self.centers)
        threshold, tests = tree.threshold + direction[:first] * self.thresholds, tree.tests
        if len(self.tests):
            tilted = (tests + direction[last:].reshape(tests.shape) * self.tests).astype(np.float32)
            summed = np.flatnonzero(tree.feature >= tests.shape[1])
            place = tree.feature[summed] - tests.shape[1]
            threshold[summed] += ((tilted.astype(np.float64) - tests) * self.tested_centers).sum(axis=1)[place]
            tests = tilted
        return replace(tree, threshold=threshold, tests=tests, given=tree.given + moved)


def round_cost(scale: int = 1) -> int:
    """Episodes of one round that is so many times a small one."""
    return scale * (PLAYED * (1 + 2 * PAIRS) + RACED * (1 + len(STEPS)))


def round_scale(episodes: int) -> int:
    """Returns the size of a round as a multiple of a small one, with so many episodes for all rounds. Small rounds find
    the way from bad trees in few episodes; the gains of good ones drown in the differences between episodes.
    """
    return max(1, math.isqrt(episodes // (ROUNDS * round_cost())))


def judging_cost() -> int:
    """Episodes of the last comparison."""
    return 2 * JUDGED


def drift_cost() -> int:
    """Episodes of one round of `drift_tests`."""
    return DRIFT_PLAYED * (1 + 2 * DRIFT_PAIRS)


def count_steps(episodes: int, cost: int) -> int:
    """Rounds of such a cost that so many episodes last for, and the comparison at the end; 0 where they are too few."""
    rounds = (episodes - judging_cost()) // cost
    return rounds + 1 if rounds > 0 else 0


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
    paid = _play_pairs(arena, trees, moves, directions, played)
    length = float(np.linalg.norm(paid))
    lengths = STEPS if length > 0 else ()
    ahead = [paid @ each / length for each in directions] if lengths else []
    steps = [_move(trees, moves, [length * each for each in ahead]) for length in lengths]
    best = int(arena.scores([trees, *steps], scale * RACED).mean(axis=1).argmax())
    return [trees, *steps][best], arena.values[best]


def drift_tests(arena: Arena, trees: Trees, done: float, rng: np.random.Generator) -> tuple[Trees, Float64]:
    """One round of trees whose leaves take actions and whose splits have sums of their own: the team after a short step
    in the direction that paid, and the primary measure of the team before it. `done`: as of `improve_numbers`.

    No race tells whether a step pays: it is less than chance in so few episodes, but adds up over rounds.
    """
    spread = DRIFT_SPREAD * (1 - done * (1 - LAST_SPREAD))
    arena.scores([trees], DRIFT_PLAYED)
    values, seen = arena.values[0], arena.seen
    moves = [Moves.of(_as_summed(tree), met, np.zeros(0)) for tree, met in zip(trees, seen, strict=True)]
    directions = [spread * rng.standard_normal((DRIFT_PAIRS, each.size)) for each in moves]
    paid = _play_pairs(arena, trees, moves, directions, DRIFT_PLAYED)
    length = float(np.linalg.norm(paid))
    ahead = [DRIFT * paid @ each / (length or 1.0) for each in directions]
    return _move(trees, moves, ahead), values


def _play_pairs(
    arena: Arena, trees: Trees, moves: Sequence[Moves], directions: Sequence[Float64], played: int
) -> Float64:
    """Returns each direction's score less the opposite one's, [n_pairs]. `directions`: per agent [n_pairs, size]."""
    pairs = len(directions[0])
    teams = [
        _move(trees, moves, [sign * each[pair] for each in directions]) for pair in range(pairs) for sign in (1, -1)
    ]
    scored = arena.scores(teams, played).mean(axis=1).reshape(pairs, 2)
    return scored[:, 0] - scored[:, 1]


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
