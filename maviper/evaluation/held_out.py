"""Measures on held-out episodes, for a profile's provenance.

Does: every measure of the trees against expert opponents, beside the expert's; what the trees meet.
Assumes: trees in the world's order of agents.
Does not: choose trees.
"""

from collections.abc import Mapping, Sequence

from codegen import ir
from maviper.episodes import measures
from maviper.episodes.counting import Counting
from maviper.episodes.play import Controller
from maviper.experts.expert import Expert
from maviper.worlds import Measure, World

EVALUATION_EPISODES = 1_000


def evaluation(world: World, agents: Sequence[ir.AgentPolicy], expert: Expert) -> dict[str, float | int | str]:
    """Every measure of the trees against expert opponents and of the expert, on held-out episodes.

    An agent without a tree is played by the expert.
    """
    return evaluate_trees(world, agents, expert)[0]


def evaluate_trees(
    world: World, agents: Sequence[ir.AgentPolicy], expert: Expert
) -> tuple[dict[str, float | int | str], tuple[ir.AgentPolicy, ...]]:
    """As `evaluation`, and the trees with what they met in the same episodes: visits of leaves, ranges of features."""
    seeds = range(measures.MEASUREMENT_SEEDS, measures.MEASUREMENT_SEEDS + EVALUATION_EPISODES)
    experts: list[Controller] = [expert] * len(world.agents)
    counting = Counting(world, agents)
    controllers = [counting if agent in counting.trees else expert for agent in range(len(world.agents))]
    rows: dict[str, float | int | str] = {"episodes": EVALUATION_EPISODES}
    theirs = measures.evaluate(world, experts, seeds)
    for measure, ours in measures.evaluate_teams(world, controllers, experts, seeds).items():
        low, high = (round(end, 6) for end in ours.interval)
        rows |= {measure.label: ours.value, f"{measure.label} low": low, f"{measure.label} high": high}
        rows[f"{measure.team} expert {measure.name}"] = theirs[measure].value
    return rows, counting.annotate_policies()


def read_measure(rows: Mapping[str, float | int | str], measure: Measure) -> tuple[float, float]:
    """The trees' and the expert's value of a measure in what `evaluation` wrote."""
    return float(rows[measure.label]), float(rows[f"{measure.team} expert {measure.name}"])
