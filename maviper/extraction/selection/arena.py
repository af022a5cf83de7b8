"""Candidates of a team on common episodes, and races among them.

Does: plays many candidates at once on the same start states, everybody else at the expert; finds the best with few
  episodes (sequential halving, Karnin et al. 2013; common random numbers), of teams or of each member.
Assumes: a world that can start the same episodes again.
Does not: make candidates.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np

from codegen.ir import Float32, Float64, GrownTree
from maviper.episodes.measures import score
from maviper.episodes.play import Controller, Episodes, in_columns, play
from maviper.extraction.selection.stack import Stack, SummedStack, stack_trees
from maviper.worlds import World
from maviper.worlds.world import Int

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
        seeds = self._next(episodes)
        values, parts = list[Float64](), list[Float64]()
        which = np.repeat(np.arange(len(candidates)), episodes)
        seen: list[list[Float32]] = [[] for _ in self.agents]
        starts = self.world.start_from_seeds(seeds) if self.world.games is None else None
        at_once = self.world.games or GAMES_AT_ONCE
        for low in range(0, len(which), at_once):
            rows = np.arange(low, min(low + at_once, len(which)))
            start = self.world.start_from_seeds(seeds[rows % episodes]) if starts is None else starts[rows % episodes]
            played = self._play(candidates, which[rows], start)
            first = np.flatnonzero(which[rows] == 0)
            for agent, met in zip(self.agents, seen, strict=True):
                met.append(played.observations[agent][:, first][played.alive[:, first, agent]])
            values.append(played.values[self.world.measures.index(self.primary)])
            parts.append(score(self.primary, values[-1]))
            if self.secondary and self._others:
                parts[-1] = parts[-1] + self.secondary * played.values[self._others].mean(axis=0)
        self.seen = [np.concatenate(met) for met in seen]
        self.played += len(which)
        self.values = np.concatenate(values).reshape(len(candidates), episodes)
        return np.concatenate(parts).reshape(len(candidates), episodes)

    def _next(self, episodes: int) -> Int:
        places = np.arange(self.used, self.used + episodes) % len(self.seeds)
        self.used += episodes
        return self.seeds.start + places

    def _play(self, candidates: Sequence[Candidate], which: Int, start: Any) -> Episodes:
        stacks = dict[int, tuple[Stack | SummedStack, Int]]()
        met, which = np.unique(which, return_inverse=True)
        here = list(map(int, met))
        for place, agent in enumerate(self.agents):
            trees = {id(candidates[index][place]): candidates[index][place] for index in here}
            number = {key: k for k, key in enumerate(trees)}
            mine = np.array([number[id(candidates[index][place])] for index in here])
            stacks[agent] = stack_trees(self.world, agent, list(trees.values())), mine[which]
        team = _Stacked(stacks)
        everybody = range(len(self.world.agents))
        return play(self.world, [team if agent in stacks else self.expert for agent in everybody], start)


def halving(
    scores: Callable[[Int, int], Float64], warm: Sequence[Float64], episodes: int, finalists: int = 1
) -> list[int]:
    """Indices of the best arms, best first, by sequential halving.

    `scores(arms, episodes)`: [n_arms, episodes], on episodes that all of these arms meet; `warm`: scores of each arm
    from elsewhere, a prior that counts in the first of several rounds, and where no episodes are spent; `episodes`: to
    spend in all; `finalists`: how many to return.
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
        weight = float(number == 0 < rounds - 1 or not count.any())
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
