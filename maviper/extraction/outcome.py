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
from codegen.profiles import ensure
from maviper.episodes import measures
from maviper.episodes.measures import Estimate
from maviper.episodes.play import Controller
from maviper.episodes.trees import among
from maviper.evaluation.held_out import evaluate_trees
from maviper.experts.expert import Expert
from maviper.experts.wrapped import critic_of, reward_weighed_by
from maviper.extraction.bundles import BUNDLES, DESCRIBED, NO_VOTES, PARTS
from maviper.extraction.settings import RELEASED, UNSAID, Settings
from maviper.files.profiles import version
from maviper.worlds import Measure, World
from maviper.worlds.matching import FEATURES_FILE


def joint_ratio(
    world: World,
    ours: Mapping[Measure, Estimate],
    theirs: Mapping[Measure, Estimate],
    teams: Sequence[str] | None = None,
) -> tuple[float, float]:
    """Mean over teams of the primary measure's ratio to the expert's, and the half width of its 95 % interval."""
    ratios, widths = list[float](), list[float]()
    for team in world.teams if teams is None else teams:
        measure = world.primary(team)
        # a divisor of zero counts as if it were one hit among all episodes
        value, base = ours[measure].value, max(abs(theirs[measure].value), 1 / theirs[measure].count)
        slope = 1 / base
        if measure.lower_is_better:
            value = max(value, 1 / ours[measure].count)
            slope = base / value**2
        low, high = ours[measure].interval
        compared = base if measure.lower_is_better else theirs[measure].value
        ratios.append(measures.quotient(measure, value, compared, base))
        widths.append((high - low) / 2 * slope)
    return float(np.mean(ratios)), float(np.sqrt(np.square(widths).sum()) / len(widths))


def finalist_score(world: World, expert: Expert, settings: Settings, agents: Sequence[ir.AgentPolicy]) -> float:
    """The mean ratio of the teams to the expert, on episodes that no extraction with these settings has seen: to choose
    among extraction seeds.
    """
    world = settings.judge_world(world)
    seeds = settings.episodes(measures.SELECTION_SEEDS)[-settings.count_held_out(world) :]
    experts: list[Controller] = [expert] * len(world.agents)
    ours = measures.evaluate_teams(world, among(world, agents, experts), experts, seeds)
    teams = [team for team in world.teams if any(policy.team == team for policy in agents)]
    return joint_ratio(world, ours, measures.evaluate(world, experts, seeds), teams)[0]


def profile_of(
    world: World,
    expert: Expert,
    settings: Settings,
    agents: Sequence[ir.AgentPolicy],
    facts: Mapping[str, int | str],
) -> ir.PolicyProfile:
    """Policies of all agents, or of some, with where they come from and what they reach on held-out episodes."""
    training = asdict(settings) | dict(facts) | {"opponents_in_selection": "expert"}
    training |= {FEATURES_FILE: world.features_from} if world.features_from else {}
    training["critic"] = critic_of(expert)
    training["critic_reward"] = reward_weighed_by(expert, world)
    training["expert_algorithm"] = str(expert.card.get("algorithm", "unknown"))
    if settings.algorithm in DESCRIBED:
        training["source"] = DESCRIBED[settings.algorithm]
    unsaid = [name for name in ("critic_reward", *UNSAID) if not training[name]]
    # an algorithm's name says the rest; of votes, the number is said too
    counted = settings.preset != RELEASED and BUNDLES[settings.algorithm]["least_right"] != NO_VOTES
    unsaid += [name for name in PARTS if name not in settings.changed and not (name == "least_right" and counted)]
    for name in ("seed", "preset", "algorithm", "held_out", *unsaid):
        del training[name]
    reached, visited = evaluate_trees(world, agents, expert, settings.count_held_out(world))
    provenance = ir.Provenance(
        algorithm=settings.algorithm,
        preset=settings.preset,
        seed=settings.seed,
        expert=expert.hash,
        tool=f"maviper {version()}",
        training=MappingProxyType(training),
        evaluation=MappingProxyType(reached),
    )
    return ensure(ir.PolicyProfile(world.spec, visited, provenance))
