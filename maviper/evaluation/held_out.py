"""Measures on held-out episodes, for a profile's provenance.

Does: every measure of the trees against expert opponents, beside the expert's; what the trees meet.
Assumes: trees in the world's order of agents.
Does not: choose trees.
"""

import math
from collections.abc import Mapping, Sequence

from codegen import ir
from maviper.episodes import measures
from maviper.episodes.play import Controller
from maviper.episodes.trees import Counting
from maviper.experts.expert import Expert
from maviper.worlds import Measure, World
from maviper.worlds.outside.sources import MAX_STEPS

EVALUATION_EPISODES = 1_000
OUTSIDE_EPISODES = 200  # in worlds of others, which are slower


def default_episodes(world: World) -> int:
    """Returns the number of held-out episodes that a line-up plays where nobody says it."""
    return EVALUATION_EPISODES if world.games is None else min(OUTSIDE_EPISODES, EVALUATION_EPISODES)


def evaluation(world: World, agents: Sequence[ir.AgentPolicy], expert: Expert) -> dict[str, float | int | str]:
    """Every measure of the trees against expert opponents and of the expert, on held-out episodes.

    An agent without a tree is played by the expert.
    """
    return evaluate_trees(world, agents, expert)[0]


def evaluate_trees(
    world: World, agents: Sequence[ir.AgentPolicy], expert: Expert, episodes: int = 0
) -> tuple[dict[str, float | int | str], tuple[ir.AgentPolicy, ...]]:
    """Returns the rows of `evaluation`, and the trees with what they met in the same episodes: leaf visits, feature
    ranges. `episodes`: of each line-up; 0: as the world says.
    """
    count = episodes or default_episodes(world)
    seeds = range(measures.MEASUREMENT_SEEDS, measures.MEASUREMENT_SEEDS + count)
    experts: list[Controller] = [expert] * len(world.agents)
    counting = Counting(world, agents)
    controllers = [counting if agent in counting.trees else expert for agent in range(len(world.agents))]
    rows: dict[str, float | int | str] = {"episodes": count}
    theirs = measures.evaluate(world, experts, seeds)
    for measure, ours in measures.evaluate_teams(world, controllers, experts, seeds).items():
        if measure.name == measures.CUT:
            counts = {measure.label: ours, f"{measure.team} expert {measure.name}": theirs[measure]}
            rows |= {name: round(each.value * each.count) for name, each in counts.items() if each.value}
            continue
        low, high = (round(end, 6) for end in ours.interval)
        rows[measure.label] = ours.value
        if math.isfinite(low):  # one episode has no interval
            rows |= {f"{measure.label} low": low, f"{measure.label} high": high}
        rows[f"{measure.team} expert {measure.name}"] = theirs[measure].value
    return rows, counting.annotate_policies()


def read_measure(rows: Mapping[str, float | int | str], measure: Measure) -> tuple[float, float]:
    """The trees' and the expert's value of a measure in what `evaluation` wrote."""
    return float(rows[measure.label]), float(rows[f"{measure.team} expert {measure.name}"])


def stop_of(world: World) -> str:
    """After how many steps episodes are stopped, where nobody states how long they are, and how to say it."""
    steps = f"{world.spec.episode_steps:,} steps"
    return f"{steps}, a length that nobody stated: write {world.name},{MAX_STEPS}=NUMBER"


def format_cut(rows: Mapping[str, float | int | str], team: str) -> str:
    """Describes how many held-out episodes, the team's and the expert's, were cut at an unstated length; "": none."""
    ours, theirs = (rows.get(f"{team} {who}{measures.CUT}", 0) for who in ("", "expert "))
    return f", {ours} and {theirs} of the episodes cut" if ours or theirs else ""
