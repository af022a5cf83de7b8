"""Refinement by return (ours): small changes to a team's trees, kept where the team plays better for them.

Does: proposes other actions at leaves, other tests at splits (of sums too, where they are asked for: growth/sums.py),
  new splits, smaller trees, and team-mates' trees of other iterates; races them in play; keeps the winner when its gain
  is beyond chance. So agents adapt to the final trees of their team-mates. Where actions have masks, every tree is made
  lawful before it plays. Trees that give numbers are moved by an evolution strategy instead; others that may test sums,
  with the second half of episodes.
Assumes: opponents, and team-mates outside the arena, at their experts.
Does not: look at labels or critics, but for the claims that the team was given counterexamples of.

The evolution strategy plays a team with all of its numbers moved a little, in random directions and their opposites, on
the same episodes, and takes a step in the direction that paid, of the length that plays best in further ones; where
leaves take actions, a short one in every round (antithetic pairs and common random numbers as in Salimans et al. 2017,
arXiv 1703.03864). Numbers move in units of what they do: outputs by parts of their ranges, thresholds by parts of the
deviation of what is tested, weights so that an output, or what is tested, moves as much over the observations that
reach the node. What no observation reaches stays. In the end the team is kept where it plays better than the one that
it started as, by more than chance, in episodes that chose nothing.
"""

import math
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from codegen import ir
from codegen.errors import InputError
from codegen.ir import NO_FEATURE, Float32, Float64, GrownTree
from codegen.lowering.deploy import SummedTree
from codegen.paths import Mask
from maviper.episodes import measures
from maviper.episodes.measures import estimate, score
from maviper.extraction.arena import (
    Arena,
    Candidate,
    merge_leaves,
    reaching,
    with_leaf,
    with_new_split,
    with_split,
)
from maviper.extraction.extraction import NO_EXAMPLES, QUIETLY, Examples, Extraction, Running, unseen
from maviper.extraction.growth.growing import Labelled, lawful
from maviper.extraction.growth.sums import as_summed, columns_of, tilt_tests, with_own_sums
from maviper.extraction.journal import (
    REFINING,
    WHOLE,
    Arrays,
    OnProgress,
    Part,
    Progress,
    count_leaves,
    pack_trees,
    unpack_trees,
)
from maviper.extraction.settings import SUMS, Settings
from maviper.files.jobs import side_by_side
from maviper.worlds import World

Trees = list[GrownTree]
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


def evolving_cost(scale: int = 1) -> int:
    """Episodes of one round that is so many times a small one."""
    return scale * (PLAYED * (1 + 2 * PAIRS) + RACED * (1 + len(STEPS)))


def round_scale(episodes: int) -> int:
    """Returns the size of a round as a multiple of a small one, with so many episodes for all rounds. Small rounds find
    the way from bad trees in few episodes; the gains of good ones drown in the differences between episodes.
    """
    return max(1, math.isqrt(episodes // (ROUNDS * evolving_cost())))


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
    `evolving_cost`.
    """
    spread, played = 1 - done * (1 - LAST_SPREAD), scale * PLAYED
    arena.scores([trees], played)  # for what its agents observe
    moves = [
        Moves.of(_as_summed(tree), seen, np.subtract(*reversed(arena.world.bounds[agent])))
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


MOVES = 48  # raced in a round
FIRST, GROWTH, LAST = 64, 4, 1_024  # episodes of the first heat, how many times more in each further one, of the last
FEWEST = 4  # that run the last heat
SPREADS = (0.02, 0.1, 0.3)  # of a threshold's new rank around its old one, among the observations that reach it
SECONDARY = 0.2  # weight of the team's other shares beside its primary measure
KEPT = 1.0  # weight in a score of the share of counterexamples in which the team fulfils its claim
LEAST_ROWS = 10  # observations that must reach a node before anything is changed there

Refined = tuple[Trees, int, Progress | None]  # trees, episodes played, the last progress


@dataclass(frozen=True)
class Limits:
    """The limits of a tree's size."""

    max_depth: int  # tests of masks do not count
    max_leaves: int = 0  # 0: as many as the depth allows
    sums: bool = False  # whether it may test them

    def allow_split(self, tree: GrownTree, depth: int) -> bool:
        """Returns True if a leaf at `depth` may be split."""
        return depth < self.max_depth and not 0 < self.max_leaves <= count_leaves([tree])


def refine_trees(
    asked: Extraction, agents: Sequence[int], chosen: Sequence[list[GrownTree]], running: Running = QUIETLY
) -> tuple[Trees, dict[str, int]]:
    """The refined tree of each of `agents`, and the episodes it took. `chosen`: their trees, the chosen one first.

    Each team is refined on its own, so several of them at a time.
    """
    world, on_progress = asked.world, running.on_progress
    if not asked.settings.refinement:
        return [trees[0] for trees in chosen], {}
    mine = dict(zip(agents, chosen, strict=True))
    tasks: list[tuple[Extraction, str, list[int], list[Trees]]] = []
    for team in world.teams:
        members = [agent for agent in world.members(team) if agent in mine]
        if members:
            own = replace(asked, examples=asked.examples.of_teams(team))
            tasks.append((own, team, members, [mine[agent] for agent in members]))
    refined_teams = list[Refined]()
    if running.jobs == 1:
        for place, task in enumerate(tasks):
            refined_teams.append(_team(*task, Part(place, len(tasks)), on_progress))
    else:
        for each in side_by_side(_team, tasks, running.jobs):
            refined_teams.append(each)
            if each[2]:
                on_progress(each[2])
    by_agent = {
        agent: tree
        for (_, _, members, _), (trees, *_) in zip(tasks, refined_teams, strict=True)
        for agent, tree in zip(members, trees, strict=True)
    }
    return [by_agent[agent] for agent in agents], {"refinement_episodes": sum(played for _, played, _ in refined_teams)}


def _team(
    asked: Extraction,
    team: str,
    agents: list[int],
    chosen: Sequence[Trees],
    part: Part = WHOLE,
    on_progress: OnProgress = unseen,
) -> Refined:
    """Rounds for one team until its episodes are spent: its trees, the episodes played, and the last progress.
    `asked`: with the examples of this team; `chosen`: of each agent its trees, the chosen one first; `part`: the team's
    place among the teams.
    """
    world, settings = asked.world, asked.settings
    arena = Arena(world, asked.expert, agents, settings.episodes(measures.REFINEMENT_SEEDS), SECONDARY)
    trees, others = [trees[0] for trees in chosen], [trees[1:] for trees in chosen]
    # The evolution strategy gets all episodes where trees give numbers, half where they may test sums, unless
    # counterexamples say more than play. (No world with masks has trees that test sums.)
    half, scale = settings.refinement // 2, round_scale(settings.refinement)
    halved = settings.splits == SUMS and not len(asked.examples) and half >= round_cost()
    spent = settings.refinement if world.continuous else half if halved else 0
    proposing = (settings.refinement - spent) // round_cost()
    evolving = count_steps(spent, evolving_cost(scale) if world.continuous else drift_cost())  # with the comparison
    last: Progress | None = None
    limits = Limits(settings.max_depth, settings.max_leaves, settings.splits == SUMS)
    start: Any = trees
    name = f"refine-{list(world.teams).index(team)}"  # a user's team may have any name
    steps = proposing + evolving
    since = math.inf
    for number in range(steps):
        if asked.is_over(since=since):
            trees = start if number > proposing else trees  # what was not judged yet counts for nothing
            break
        since, rng = time.monotonic(), np.random.default_rng([settings.seed, *agents, number])
        if number == proposing and not world.continuous:
            sizes = [len(world.features[agent]) for agent in agents]
            trees = [with_own_sums(tree, n_features) for tree, n_features in zip(trees, sizes, strict=True)]
        if number == proposing:
            start = trees
        if number < proposing:
            given: Any = refine_once, trees, others, limits, rng, asked.examples
        elif number < steps - 1:
            move, *scaled = (improve_numbers, scale) if world.continuous else (drift_tests,)
            given = move, trees, (number - proposing) / evolving, rng, *scaled
        else:
            given = judge, start, trees
        step = asked.journal.arrays(f"{name}-{number:04d}", _round, arena, *given)
        trees = unpack_trees({name: array for name, array in step.items() if "." in name})
        arena.used, arena.played = int(step["used"][0]), int(step["played"][0])
        estimates = {team: estimate(arena.primary, step["values"])}
        mean = float(score(arena.primary, step["values"]).mean())
        told = mean, mean, estimates, None, count_leaves(trees)
        last = Progress(REFINING, number + 1, steps, *told, part=part)
        on_progress(last)
    return (trees if world.continuous else [merge_leaves(tree) for tree in trees]), arena.played, last


def _round(arena: Arena, refine: Callable[..., tuple[Trees, Float64]], *given: Any) -> Arrays:
    """One round as a step of a journal. `refine`: of a team in the arena, given what follows."""
    trees, values = refine(arena, *given)
    spent = {"used": np.array([arena.used]), "played": np.array([arena.played]), "values": values}
    return pack_trees(trees) | spent


def check(settings: Settings, world: World) -> None:
    """InputError where there are episodes to refine by, but not enough for one round."""
    least = evolving_cost() + judging_cost() if world.continuous else round_cost()
    if 0 < settings.refinement < least:
        what = f"{settings.refinement} episodes are too few for one round of refinement"
        raise InputError(what, "--refinement-episodes", f"give 0, or {least} at least")


def round_cost() -> int:
    """Episodes of one round with all its moves."""
    cost, alive, episodes, played = FIRST, MOVES, FIRST, 0
    while True:
        cost += (alive + 1) * episodes
        played += episodes
        if played >= LAST:
            return cost
        alive, episodes = min(alive, max(FEWEST, alive // GROWTH)), played * (GROWTH - 1)


def refine_once(
    arena: Arena,
    trees: Trees,
    others: Sequence[Trees],
    limits: Limits,
    rng: np.random.Generator,
    examples: Examples = NO_EXAMPLES,
) -> tuple[Trees, Float64]:
    """One round: the team after the best move, or the same team when none helps, and its primary measure in the
    episodes of the last heat.

    `others`: further trees of each agent, for exchange. `examples`: the team's; scores count the share of them in which
    it fulfils its claim, so that what it learned from them is not given away for play.
    """
    arena.scores([trees], FIRST)  # for what its agents observe
    moves = proposals(arena, trees, others, limits, rng)
    moves = [moves[place] for place in map(int, rng.permutation(len(moves))[:MOVES])]
    if not moves:  # too few observations for any
        return trees, arena.values[0]
    kept = np.array(
        [examples.measure_claims(arena.world, dict(zip(arena.agents, one, strict=True))) for one in (trees, *moves)]
    )
    learned = KEPT * (kept[1:] - kept[0])[:, None]
    gains = np.zeros((len(moves), 0))
    episodes = FIRST
    while moves:
        scored = arena.scores([trees, *moves], episodes)  # the team as it is, then the moves
        gains = np.concatenate([gains, scored[1:] - scored[0] + learned], axis=1)
        if gains.shape[1] >= LAST:
            break
        order = np.argsort(-gains.mean(axis=1), kind="stable")
        best = list(map(int, order[: max(FEWEST, len(moves) // GROWTH)]))
        moves, gains, learned = [moves[place] for place in best], gains[best], learned[best]
        episodes = gains.shape[1] * (GROWTH - 1)
    best = int(gains.mean(axis=1).argmax())
    gain, error = gains[best].mean(), gains[best].std() / np.sqrt(gains.shape[1])
    return (list(moves[best]), arena.values[best + 1]) if gain > error else (trees, arena.values[0])


def proposals(
    arena: Arena, trees: Trees, others: Sequence[Trees], limits: Limits, rng: np.random.Generator
) -> list[Candidate]:
    """Teams that differ from `trees` in one tree, with tests at what the arena has seen in play."""
    candidates: list[Candidate] = []
    for place, agent in enumerate(arena.agents):
        n_actions, mask = len(arena.world.actions[agent]), arena.world.mask(agent)
        changed = [*_changes(trees[place], arena.seen[place], n_actions, limits, rng)]
        if mask is not None:
            changed = [*_lawful(changed, trees[place], arena.seen[place], mask, limits)]
        for tree in changed + others[place]:
            candidates.append([*trees[:place], tree, *trees[place + 1 :]])
    return candidates


def _lawful(
    changed: Sequence[GrownTree], tree: GrownTree, obs: Float32, mask: Mask, limits: Limits
) -> Iterator[GrownTree]:
    """Changed trees with the tests of the mask that they need. The next choice is what `tree` does most in `obs` there.
    A tree that could not have grown from `max_depth` and such tests is left out.
    """
    known = Labelled(obs, tree.action[ir.apply(tree, obs)])
    for each in changed:
        legal_tree = lawful(merge_leaves(each), mask, known)
        if ir.depth(legal_tree).max() < limits.max_depth + len(mask):
            yield legal_tree


def _quantile(values: Float32 | Float64, share: float) -> float:
    """One of the values, so large that a share of them is no larger."""
    return float(np.asarray(np.quantile(values, share, method="lower"), dtype=np.float64))


def _changes(
    tree: GrownTree, obs: Float32, n_actions: int, limits: Limits, rng: np.random.Generator
) -> Iterator[GrownTree]:
    depth, tested = ir.depth(tree), obs
    if limits.sums or isinstance(tree, SummedTree):
        tree = as_summed(tree, obs.shape[1])
        tested = columns_of(tree, obs)
    for node, rows in reaching(tree, tested).items():
        if len(rows) < LEAST_ROWS:
            continue
        here = tested[rows]
        anywhere = int(rng.integers(int(tested.shape[1])))
        at = _quantile(here[:, anywhere], rng.random())
        if tree.feature[node] == NO_FEATURE:
            action = int(tree.action[node])
            for other in range(n_actions):
                if other != action:
                    yield with_leaf(tree, node, other)
            if limits.allow_split(tree, int(depth[node])):
                other = int(rng.integers(n_actions))
                pair = (action, other) if rng.random() < 0.5 else (other, action)
                yield with_new_split(tree, node, anywhere, at, pair)
            continue
        yield with_leaf(tree, node, int(rng.integers(n_actions)))
        column = here[:, tree.feature[node]]
        rank = float((column <= tree.threshold[node]).mean())
        for spread in map(float, rng.choice(SPREADS, size=2)):
            moved = float(np.clip(rng.normal(rank, spread), 0, 1))
            yield with_split(tree, node, int(tree.feature[node]), _quantile(column, moved))
        yield with_split(tree, node, anywhere, at)
        if limits.sums and isinstance(tree, SummedTree):
            yield from tilt_tests(tree, node, here, rng)
