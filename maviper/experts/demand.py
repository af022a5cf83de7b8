"""Coordination demand: the loss when a teammate comes from another seed, and who takes which role.

Does: measures teams in which one member comes from another expert; the shares of the ways in which a team shares out
  its targets, and how well the start state tells which way it will be.
Assumes: experts of one world, trained alike from different seeds; a target is a landmark, or a prey for predators.
Does not: judge or choose an expert.
"""

from collections import Counter
from collections.abc import Mapping, Sequence
from importlib import import_module
from itertools import permutations, product
from typing import Any

import numpy as np

from codegen.ir import Float64
from maviper.episodes import measures
from maviper.episodes.play import Controller, Episodes, rollout
from maviper.worlds import ParticleWorld
from maviper.worlds.games.cooperative_navigation import AGENTS
from maviper.worlds.games.particle import distances, planes
from maviper.worlds.games.physical_deception import DEFENDERS
from maviper.worlds.games.predator_prey import PREDATORS, PREY
from maviper.worlds.world import Int

COVERING, HUNTING = (DEFENDERS, AGENTS), (PREDATORS,)
TREES = 200  # of the forest that predicts an assignment
DIGITS = 4


def demand(world: ParticleWorld, experts: Mapping[int, Controller], own: int, seeds: range) -> dict[str, Any]:
    """Both measures of the expert `own` among `experts` (training seed -> expert), as plain data for its card."""
    (alone,) = rollout(world, [experts[own]] * len(world.agents), seeds, keep=False)
    return {
        "episodes": len(seeds),
        "first_episode_seed": seeds[0],
        "team-mate of another seed": cross_seed(world, experts, own, seeds, alone),
        "roles": roles(world, alone),
    }


def cross_seed(
    world: ParticleWorld, experts: Mapping[int, Controller], own: int, seeds: range, alone: Episodes
) -> dict[str, Any]:
    """For each team of several: its primary measure as it is, in the episodes `alone`, and with one member of another
    seed, by seed: the mean over the members that are replaced. All other teams stay the expert's own.
    """
    everybody = range(len(world.agents))
    as_it_is = measures.estimates(measures.table(world, alone))

    def evaluate_lineup(lineup: Sequence[Controller], team: str) -> float:
        return measures.evaluate(world, lineup, seeds)[world.primary(team)].value

    by_team: dict[str, Any] = {}
    for team in (team for team, members in world.teams.items() if len(members) > 1):
        mixed = {
            str(seed): round(
                float(
                    np.mean(
                        [
                            evaluate_lineup([other if agent == place else experts[own] for agent in everybody], team)
                            for place in world.members(team)
                        ]
                    )
                ),
                DIGITS,
            )
            for seed, other in experts.items()
            if seed != own
        }
        own_value = as_it_is[world.primary(team)].value
        by_team[team] = {"measure": world.primary(team).name, "own": round(own_value, DIGITS), "mixed": mixed}
    return by_team


def roles(world: ParticleWorld, episodes: Episodes) -> dict[str, Any]:
    """For each team with targets to share out: the share of every assignment that occurs, the most frequent first, and
    how often a forest that sees the start state alone names the right one in episodes that it was not fitted to.
    """
    per_team: dict[str, Any] = {}
    for team in (team for team in (*COVERING, *HUNTING) if team in world.teams):
        names, taken = assignments(world, team, episodes)
        counts: Counter[int] = Counter(map(int, taken))
        shares = {names[label]: round(count / len(taken), DIGITS) for label, count in counts.most_common()}
        per_team[team] = {"shares": shares, **_predict_roles(world, episodes.states[0], taken)}
    return per_team


def assignments(world: ParticleWorld, team: str, episodes: Episodes) -> tuple[list[str], Int]:
    """The names of all assignments of a team, and which one each episode ends in, [batch].

    Whoever covers landmarks holds that one-to-one assignment whose distances at the end are the least in sum;
    predators hold the prey that each was nearest to on average.
    """
    members = world.members(team)
    if team in HUNTING:
        targets = world.members(PREY)
        gaps = np.mean([_gaps(state, members, targets) for state in episodes.states[1:]], axis=0)
        ways = list(product(range(len(targets)), repeat=len(members)))
    else:
        targets = list(range(len(world.agents), len(world.agents) + len(world.spec.landmarks)))
        gaps = _gaps(episodes.states[-1], members, targets)
        ways = list(permutations(range(len(targets)), len(members)))
    entities = [entity.name for entity in (*world.spec.agents, *world.spec.landmarks)]
    mine = [world.agents[member] for member in members]
    names = [", ".join(f"{a} {entities[targets[k]]}" for a, k in zip(mine, way, strict=True)) for way in ways]
    costs = [sum(gaps[place, target] for place, target in enumerate(way)) for way in ways]
    return names, np.argmin(costs, axis=0)


def _gaps(state: Any, members: Sequence[int], targets: Sequence[int]) -> Float64:
    """[n_members, n_targets, batch] distances."""
    position = planes(state.position)
    return distances(position[list(members), None], position[None, list(targets)])


def _predict_roles(world: ParticleWorld, start: Any, taken: Int) -> dict[str, float]:
    """Accuracy in the second half of the episodes of a forest fitted to the first, beside the share there of the
    first half's most frequent assignment.
    """
    ensemble: Any = import_module("sklearn.ensemble")
    half = len(taken) // 2
    entities = range(len(world.agents) + len(world.spec.landmarks))
    gaps = _gaps(start, entities, entities).reshape(-1, len(taken)).T
    seen = np.concatenate([world.coordinates(start), gaps], axis=1)
    forest = ensemble.RandomForestClassifier(TREES, random_state=0).fit(seen[:half], taken[:half])
    usual = Counter[int](map(int, taken[:half])).most_common(1)[0][0]
    return {
        "from the start state": round(float(forest.score(seen[half:], taken[half:])), DIGITS),
        "always the most frequent": round(float((taken[half:] == usual).mean()), DIGITS),
    }
