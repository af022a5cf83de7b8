"""What all algorithms end with: trees, provenance and held-out measures as a profile.

Does: trees as policies and as controllers among others; the ratio to the expert; the profile.
Assumes: trees in the world's order of agents.
Does not: make or choose trees.
"""

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from types import MappingProxyType

import numpy as np

from codegen import ir
from codegen.deploy import deployed
from codegen.ir import GrownTree
from maviper import version
from maviper.evaluate import metrics
from maviper.evaluate.metrics import Estimate
from maviper.evaluate.play import Controller, tree_policies
from maviper.experts.expert import Expert
from maviper.experts.wrapped import critic_of
from maviper.extract.settings import Settings
from maviper.worlds import Measure, World

EVALUATION_EPISODES = 1_000


def agent_policies(
    world: World, grown: Sequence[GrownTree], agents: Sequence[int] | None = None
) -> tuple[ir.AgentPolicy, ...]:
    """The grown trees of some agents (None: of all) as deployed policies."""
    found = []
    for agent, tree in zip(range(len(world.agents)) if agents is None else agents, grown, strict=True):
        name = world.agents[agent]
        given = (world.features[agent], world.actions[agent], deployed(tree), tree)
        found.append(ir.AgentPolicy(name, world.team_of(name), *given))
    return tuple(found)


def among(world: World, policies: Sequence[ir.AgentPolicy], others: Sequence[Controller]) -> list[Controller]:
    """A controller for each agent: its tree, or `others` where it has none."""
    trees = {policy.agent: policy for policy in policies}
    if len(trees) == len(world.agents):
        return [tree_policies([trees[agent] for agent in world.agents])] * len(world.agents)
    # a controller is asked by the agent's place, so the one tree stands in every place
    return [
        tree_policies([trees[agent]] * len(world.agents)) if agent in trees else other
        for agent, other in zip(world.agents, others, strict=True)
    ]


def joint_ratio(
    world: World,
    ours: Mapping[Measure, Estimate],
    theirs: Mapping[Measure, Estimate],
    teams: Sequence[str] | None = None,
) -> tuple[float, float]:
    """Mean over teams of the primary measure's ratio to the expert's, and the half width of its 95 % interval."""
    ratios, widths = [], []
    for team in world.teams if teams is None else teams:
        measure = world.primary(team)
        # a divisor of zero counts as if it were one hit among all episodes
        value, base = ours[measure].value, max(abs(theirs[measure].value), 1 / theirs[measure].count)
        ratio, slope = 1 + (value - theirs[measure].value) / base, 1 / base
        if measure.lower_is_better:
            value = max(value, 1 / ours[measure].count)
            ratio, slope = base / value, base / value**2
        low, high = ours[measure].interval
        ratios.append(ratio)
        widths.append((high - low) / 2 * slope)
    return float(np.mean(ratios)), float(np.sqrt(np.square(widths).sum()) / len(widths))


def finalist_score(world: World, expert: Expert, settings: Settings, agents: Sequence[ir.AgentPolicy]) -> float:
    """The mean ratio of the teams to the expert, on episodes that no extraction with these settings has seen: to choose
    among extraction seeds.
    """
    seeds = settings.episodes(metrics.SELECTION_SEEDS)[-EVALUATION_EPISODES:]
    experts: list[Controller] = [expert] * len(world.agents)
    ours = metrics.evaluate_teams(world, among(world, agents, experts), experts, seeds)
    teams = [team for team in world.teams if any(policy.team == team for policy in agents)]
    return joint_ratio(world, ours, metrics.evaluate(world, experts, seeds), teams)[0]


def profile_of(
    world: World,
    expert: Expert,
    settings: Settings,
    agents: Sequence[ir.AgentPolicy],
    facts: Mapping[str, int | str],
) -> ir.PolicyProfile:
    """Policies of all agents, or of some, with where they come from and what they reach on held-out episodes."""
    training = asdict(settings) | dict(facts) | {"opponents_in_selection": "expert"}
    training["critic"] = critic_of(expert)
    training["expert_algorithm"] = str(expert.card.get("algorithm", "unknown"))
    for name in ("seed", "preset", "algorithm", *(() if settings.agent else ("agent",))):
        del training[name]
    provenance = ir.Provenance(
        algorithm=settings.algorithm,
        preset=settings.preset,
        seed=settings.seed,
        expert=expert.hash,
        tool=f"maviper {version()}",
        training=MappingProxyType(training),
        evaluation=MappingProxyType(evaluation(world, agents, expert)),
    )
    return ir.ensure(ir.PolicyProfile(world.spec, tuple(agents), provenance))


def evaluation(world: World, agents: Sequence[ir.AgentPolicy], expert: Expert) -> dict[str, float | int | str]:
    """Every measure of the trees against expert opponents and of the expert, on held-out episodes.

    An agent without a tree is played by the expert.
    """
    seeds = range(metrics.MEASUREMENT_SEEDS, metrics.MEASUREMENT_SEEDS + EVALUATION_EPISODES)
    experts: list[Controller] = [expert] * len(world.agents)
    controllers = among(world, agents, experts)
    rows: dict[str, float | int | str] = {"episodes": EVALUATION_EPISODES}
    theirs = metrics.evaluate(world, experts, seeds)
    for measure, ours in metrics.evaluate_teams(world, controllers, experts, seeds).items():
        low, high = (round(end, 6) for end in ours.interval)
        rows |= {measure.label: ours.value, f"{measure.label} low": low, f"{measure.label} high": high}
        rows[f"{measure.team} expert {measure.name}"] = theirs[measure].value
    return rows


def measured_of(rows: Mapping[str, float | int | str], measure: Measure) -> tuple[float, float]:
    """The trees' and the expert's value of a measure in what `evaluation` wrote."""
    return float(rows[measure.label]), float(rows[f"{measure.team} expert {measure.name}"])
