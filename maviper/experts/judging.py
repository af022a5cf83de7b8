"""How good an expert is, in the game's own measure: what checkpoints are chosen by and cards report.

Does: one score from all teams' primary measures, and the tables behind it.
Assumes: a team whose measure is a share is judged in play among experts, by its log-odds: halving the failures counts
  alike at .5 and at .98. Any other is judged by the logarithm of its ratio to the script's measure in the same place,
  against the script's opponents, since touches among learners say nothing of either side. Without a script: as it is.
Does not: choose anything.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from codegen.errors import InputError
from codegen.intervals import Share
from maviper.episodes import measures
from maviper.episodes.measures import Estimate
from maviper.episodes.play import Controller
from maviper.experts.scripted import Scripted, scripted
from maviper.worlds import Measure, World, built_in

LEAST_RATIO = 1e-3


@dataclass(frozen=True)
class Judged:
    """A score (higher is better) and the estimates behind it."""

    score: float
    among: dict[Measure, Estimate]  # all agents experts; returns included
    against: dict[Measure, Estimate]  # each team against the script's opponents; {} where there are none
    scripts: dict[Measure, Estimate]  # the script in the place of every team; {} where nobody is compared with it

    def primary(self, world: World) -> dict[str, Estimate]:
        """What each team is judged by."""
        return {team: (self.against or self.among)[world.primary(team)] for team in world.teams}


def judge(world: World, controller: Controller, seeds: range) -> Judged:
    """Judges a controller of all agents on the episodes `seeds`."""
    everybody = [controller] * len(world.agents)
    among = measures.evaluate(world, everybody, seeds)
    script = _script(world)
    primary = [among[world.primary(team)] for team in world.teams]
    if all(isinstance(found, Share) for found in primary):
        return Judged(_mean([_log_odds(found) for found in primary]), among, {}, {})
    if script is None:
        return Judged(_mean([found.value for found in primary]), among, {}, {})
    scripts = _scripts(world.name, seeds)
    against = (
        measures.evaluate_teams(world, everybody, [script] * len(everybody), seeds) if len(world.teams) > 1 else {}
    )
    found = [math.log(max(ratio, LEAST_RATIO)) for ratio in ratios(world, against or among, scripts).values()]
    return Judged(_mean(found), among, against, scripts)


def ratios(world: World, against: dict[Measure, Estimate], scripts: dict[Measure, Estimate]) -> dict[str, float]:
    """Each team's primary measure as a ratio to the script's; above 1 is better than the script."""
    found = {team: world.primary(team) for team in world.teams}
    return {
        team: measures.ratio(measure, against[measure].value, scripts[measure].value) or 0.0
        for team, measure in found.items()
    }


def _log_odds(found: Estimate) -> float:
    """Of a share, with half a failure and half a success added, so that a perfect score is finite."""
    assert isinstance(found, Share)
    return math.log((found.hits + 0.5) / (found.count - found.hits + 0.5))


def _mean(values: Sequence[float]) -> float:
    return float(np.mean(values))


def _script(world: World) -> Scripted | None:
    try:
        return scripted(world)
    except InputError:
        return None


@lru_cache(maxsize=8)
def _scripts(name: str, seeds: range) -> dict[Measure, Estimate]:
    world = built_in(name)
    return measures.evaluate(world, [scripted(world)] * len(world.agents), seeds)
