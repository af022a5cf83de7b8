"""How good a checkpoint is, in the game's own measures: what an expert is chosen by.

Does: one score from all teams' primary measures, in play among the run's own networks.
Assumes: a team whose measure is a share is judged in play among experts, by its log-odds: halving the failures counts
  alike at .5 and at .98. So is a world's only team, by its measure as it is. Touches among learners say nothing of
  either side, so that all other teams are rated against rivals: what a checkpoint gains on each of them, in the place
  of every team, on top of the rival's own rating.
Does not: choose anything, or ask a script.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from codegen.intervals import Share
from maviper.episodes import measures
from maviper.episodes.measures import Estimate
from maviper.episodes.play import Controller
from maviper.worlds import Measure, World

N_RIVALS = 3  # of a checkpoint: the best before it


@dataclass(frozen=True)
class Rival:
    """An earlier checkpoint of the same run."""

    controller: Controller
    score: float


@dataclass(frozen=True)
class Judged:
    """A score (higher is better) and the estimates in play among experts, returns included."""

    score: float
    among: dict[Measure, Estimate]

    def primary(self, world: World) -> dict[str, Estimate]:
        """Returns each team's primary measure, by which it is judged."""
        return {team: self.among[world.primary(team)] for team in world.teams}


def judge(world: World, controller: Controller, seeds: range, rivals: Sequence[Rival] = ()) -> Judged:
    """Judges a controller of all agents on the episodes `seeds`. `rivals` count in a world that is rated (`is_rated`);
    the first checkpoint of all has none and scores 0.
    """
    among = measures.evaluate(world, [controller] * len(world.agents), seeds)
    if not is_rated(world):
        return Judged(_mean([_worth(measure, among[measure]) for measure in _primary(world)]), among)
    ratings = [rival.score + advantage(world, controller, rival.controller, seeds) for rival in rivals]
    return Judged(_mean(ratings) if ratings else 0.0, among)


def scores(world: World, finalists: Sequence[Controller], seeds: range) -> list[float]:
    """A score of each, on the same episodes; in a rated world (`is_rated`), what it gains on the others on average."""
    if not is_rated(world):
        return [judge(world, controller, seeds).score for controller in finalists]
    gains = np.zeros((len(finalists), len(finalists)))
    for a, b in combinations(range(len(finalists)), 2):
        gains[a, b] = advantage(world, finalists[a], finalists[b], seeds)
        gains[b, a] = -gains[a, b]
    return (gains.sum(axis=1) / max(1, len(finalists) - 1)).tolist()


def is_rated(world: World) -> bool:
    """Returns True if checkpoints are rated against rivals: several teams, not all of whose measures are shares."""
    return len(world.teams) > 1 and not all(measure.share for measure in _primary(world))


def advantage(world: World, ours: Controller, theirs: Controller, seeds: range) -> float:
    """Measures by how much each team does better when `ours` plays it and `theirs` all others than the other way round:
    the mean over teams, in the measure's unit. What `ours` gains on `theirs`, `theirs` loses.
    """
    gained = dict.fromkeys(world.teams, 0.0)
    played: dict[tuple[bool, ...], dict[Measure, Estimate]] = {}
    for team in world.teams:
        members, measure = world.members(team), world.primary(team)
        for sign, mine in ((1, True), (-1, False)):
            who = tuple(mine if agent in members else not mine for agent in range(len(world.agents)))
            if who not in played:
                played[who] = measures.evaluate(world, [ours if each else theirs for each in who], seeds)
            gained[team] += sign * _worth(measure, played[who][measure])
    return _mean(list(gained.values()))


def _primary(world: World) -> list[Measure]:
    return [world.primary(team) for team in world.teams]


def _worth(measure: Measure, estimate: Estimate) -> float:
    """Higher is better. A share's log-odds, with half a failure and half a success added, so that a perfect one is
    finite.
    """
    value = estimate.value if not isinstance(estimate, Share) else _log_odds(estimate)
    return -value if measure.lower_is_better else value


def _log_odds(share: Share) -> float:
    return math.log((share.hits + 0.5) / (share.count - share.hits + 0.5))


def _mean(values: Sequence[float]) -> float:
    return float(np.mean(values))
