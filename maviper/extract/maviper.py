"""MAVIPER: joint extraction of the trees of all teams (paper, Algorithm MAVIPER, mixed cooperative-competitive form).

Does: the algorithm, line by line, and the choice of the best iterate; returns a policy profile with its provenance.
Assumes: an expert with centralized critics.
Does not: write files or print; progress goes to a callback.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import reduce
from operator import add
from types import MappingProxyType

import numpy as np

from codegen import ir
from codegen.errors import InputError, UnknownNameError
from codegen.ir import GrownTree
from maviper import version
from maviper.evaluate import metrics
from maviper.evaluate.metrics import Estimate
from maviper.evaluate.play import Controller, rollout, tree_policies
from maviper.experts.expert import Expert
from maviper.extract.dataset import Dataset, labels, points, resample
from maviper.extract.deploy import deployed
from maviper.extract.grow import train_joint_trees
from maviper.extract.weights import maviper_weights
from maviper.worlds import Measure, World

PRESETS = ("paper",)
EVALUATION_EPISODES = 1_000
MOST = 1_000_000  # of anything that is counted
EPISODES_PER_SEED = 100_000  # the episode seeds of two extraction seeds do not meet


@dataclass(frozen=True)
class Settings:
    """Settings of an extraction; the defaults are the paper's for physical deception."""

    preset: str = "paper"
    max_depth: int = 4
    iterations: int = 100
    rollouts: int = 50  # episodes an iteration
    max_samples: int = 300_000
    selection_episodes: int = 100  # per candidate and team
    patience: int = 10  # stop after so many iterations without a gain above the interval
    seed: int = 0

    def checked(self) -> "Settings":
        """The settings themselves; InputError or UnknownNameError when one cannot be used."""
        if self.preset not in PRESETS:
            raise UnknownNameError("preset", self.preset, PRESETS, "--preset")
        for name in ("max_depth", "iterations", "rollouts", "max_samples", "selection_episodes", "patience"):
            if not 1 <= getattr(self, name) <= MOST:
                where = f"--{name.replace('_', '-')}"
                raise InputError(f"{name} must be at least 1 and at most {MOST}, not {getattr(self, name)}", where)
        if self.max_depth > ir.MAX_DEPTH:
            raise InputError(f"max_depth must be at most {ir.MAX_DEPTH}", "--max-depth")
        if not 0 <= self.seed < 2**32:
            raise InputError("the seed must be from 0 to 4294967295", "--seed")
        if max(self.iterations * self.rollouts, self.selection_episodes) > EPISODES_PER_SEED:
            where = "--iterations times --rollouts, --selection-episodes"
            raise InputError(f"more than {EPISODES_PER_SEED} episodes in all", where)
        return self


@dataclass(frozen=True)
class Progress:
    """What one iteration gave: the mean over teams of the ratio to the expert, and the best so far."""

    iteration: int
    score: float
    best: float
    half_width: float  # of the best score's 95 % interval
    best_measured: dict[str, Estimate]  # team -> primary measure of the best iterate, against expert opponents
    leaves: int  # of the best iterate, all agents


def extract(
    world: World,
    expert: Expert,
    settings: Settings,
    on_iteration: Callable[[Progress], None] = lambda progress: None,
) -> ir.PolicyProfile:
    """The policy profile of the best iterate, with measured success and provenance."""
    settings.checked()
    rng = np.random.default_rng(settings.seed)
    offset = settings.seed * EPISODES_PER_SEED
    selection = range(metrics.SELECTION_SEEDS + offset, metrics.SELECTION_SEEDS + offset + settings.selection_episodes)
    experts: list[Controller] = [expert] * len(world.agents)
    expert_measured = metrics.evaluate(world, experts, selection)
    data: Dataset | None = None
    policies = experts  # line 1: no data yet, the first policies are the experts
    best: tuple[float, list[GrownTree], Progress] | None = None
    reference, since_gain = -np.inf, 0
    for iteration in range(settings.iterations):
        first = metrics.ROLLOUT_SEEDS + offset + iteration * settings.rollouts
        met = rollouts(world, expert, policies, range(first, first + settings.rollouts))  # line 3
        data = met if data is None else data + met  # line 4
        counts = [resample(weights, settings.max_samples, rng) for weights in data.weights.T]  # line 5
        grown = grow_teams(world, data, counts, settings.max_depth, rng)  # line 6
        policies = [tree_policies(agent_policies(world, grown))] * len(world.agents)
        measured = metrics.evaluate_teams(world, policies, experts, selection)
        score, half_width = joint_ratio(world, measured, expert_measured)
        if best is None or score > best[0]:
            leaves = sum(int((tree.feature == ir.NO_FEATURE).sum()) for tree in grown)
            reached = metrics.primary(world, measured)
            best = score, grown, Progress(iteration, score, score, half_width, reached, leaves)
        chosen = best[2]
        on_iteration(Progress(iteration, score, best[0], chosen.half_width, chosen.best_measured, chosen.leaves))
        since_gain += 1
        if best[0] > reference:
            reference, since_gain = best[0] + chosen.half_width, 0
        if since_gain >= settings.patience:
            break
    assert best is not None and data is not None
    facts = {"stopped_after": iteration + 1, "best_iteration": best[2].iteration + 1, "points": len(data)}
    return _profile(world, expert, settings, best[1], facts)


def _profile(
    world: World, expert: Expert, settings: Settings, grown: Sequence[GrownTree], facts: Mapping[str, int]
) -> ir.PolicyProfile:
    """The trees with where they come from and what they reach on held-out episodes."""
    training = asdict(settings) | dict(facts) | {"opponents_in_selection": "expert"}
    training["expert_algorithm"] = str(expert.card.get("algorithm", "unknown"))
    del training["seed"], training["preset"]
    agents = agent_policies(world, grown)
    provenance = ir.Provenance(
        algorithm="maviper",
        preset=settings.preset,
        seed=settings.seed,
        expert=expert.hash,
        tool=f"maviper {version()}",
        training=MappingProxyType(training),
        evaluation=MappingProxyType(evaluation(world, agents, expert)),
    )
    return ir.ensure(ir.PolicyProfile(world.spec, agents, provenance))


def rollouts(world: World, expert: Expert, policies: Sequence[Controller], seeds: Sequence[int]) -> Dataset:
    """Episodes of `policies`, labelled by the expert, with each agent's weights."""
    parts = []
    for episodes in rollout(world, policies, seeds):
        observations, state = points(episodes)
        wanted = labels(expert, observations, state)
        parts.append(Dataset(observations, wanted, maviper_weights(world, expert, observations, state, wanted)))
    return reduce(add, parts)


def grow_teams(
    world: World, data: Dataset, counts: Sequence[np.ndarray], max_depth: int, rng: np.random.Generator
) -> list[GrownTree]:
    """TrainJointTrees for each team; returns the trees in the world's order of agents."""
    trees: list[GrownTree | None] = [None] * len(world.agents)
    seeds = rng.integers(2**31, size=len(world.agents))
    for team in world.teams:
        members = world.members(team)
        grown = train_joint_trees(
            [data.observations[agent] for agent in members],
            data.labels[:, members],
            [counts[agent] for agent in members],
            [len(world.actions[agent]) for agent in members],
            max_depth,
            [int(seeds[agent]) for agent in members],
        )
        for agent, tree in zip(members, grown, strict=True):
            trees[agent] = tree
    return [tree for tree in trees if tree is not None]


def agent_policies(world: World, grown: Sequence[GrownTree]) -> tuple[ir.AgentPolicy, ...]:
    """The grown trees as deployed policies."""
    return tuple(
        ir.AgentPolicy(agent, world.team_of(agent), features, actions, deployed(tree), tree)
        for agent, features, actions, tree in zip(world.agents, world.features, world.actions, grown, strict=True)
    )


def joint_ratio(
    world: World, ours: Mapping[Measure, Estimate], theirs: Mapping[Measure, Estimate]
) -> tuple[float, float]:
    """Mean over teams of the primary measure's ratio to the expert's, and the half width of its 95 % interval."""
    ratios, widths = [], []
    for team in world.teams:
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


def evaluation(world: World, agents: Sequence[ir.AgentPolicy], expert: Expert) -> dict[str, float | int | str]:
    """Every measure of the trees against expert opponents and of the expert, on held-out episodes."""
    seeds = range(metrics.MEASUREMENT_SEEDS, metrics.MEASUREMENT_SEEDS + EVALUATION_EPISODES)
    trees: list[Controller] = [tree_policies(agents)] * len(agents)
    experts: list[Controller] = [expert] * len(agents)
    rows: dict[str, float | int | str] = {"episodes": EVALUATION_EPISODES}
    theirs = metrics.evaluate(world, experts, seeds)
    for measure, ours in metrics.evaluate_teams(world, trees, experts, seeds).items():
        low, high = (round(end, 6) for end in ours.interval)
        rows |= {measure.label: ours.value, f"{measure.label} low": low, f"{measure.label} high": high}
        rows[f"{measure.team} expert {measure.name}"] = theirs[measure].value
    return rows


def measured_of(rows: Mapping[str, float | int | str], measure: Measure) -> tuple[float, float]:
    """The trees' and the expert's value of a measure in what `evaluation` wrote."""
    return float(rows[measure.label]), float(rows[f"{measure.team} expert {measure.name}"])
