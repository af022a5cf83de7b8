"""MAVIPER: joint extraction of the trees of all teams (paper, Algorithm MAVIPER, mixed cooperative-competitive form).

Does: the algorithm, line by line, and the choice of the best iterate; returns a policy profile with its provenance.
Assumes: an expert with centralized critics.
Does not: write files or print; progress goes to a callback.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from types import MappingProxyType

import numpy as np

from codegen import ir
from codegen.errors import InputError, UnknownNameError
from codegen.ir import GrownTree
from maviper import version
from maviper.evaluate import metrics
from maviper.evaluate.play import Policy, play
from maviper.experts.network import Expert
from maviper.extract.dataset import Dataset, labels, resample, states
from maviper.extract.deploy import deployed
from maviper.extract.grow import train_joint_trees
from maviper.extract.weights import maviper_weights
from maviper.worlds import ParticleWorld
from verify.shares import Share

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
    best_success: dict[str, Share]  # team -> success of the best iterate, against expert opponents
    leaves: int  # of the best iterate, all agents


def extract(
    world: ParticleWorld,
    expert: Expert,
    settings: Settings,
    on_iteration: Callable[[Progress], None] = lambda progress: None,
) -> ir.PolicyProfile:
    """The policy profile of the best iterate, with measured success and provenance."""
    settings.checked()
    rng = np.random.default_rng(settings.seed)
    offset = settings.seed * EPISODES_PER_SEED
    selection = range(metrics.SELECTION_SEEDS + offset, metrics.SELECTION_SEEDS + offset + settings.selection_episodes)
    experts = expert.policies()
    expert_success = metrics.team_success(world, experts, experts, selection)[0]
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
        policies = [metrics.tree_policy(policy) for policy in agent_policies(world, grown)]
        success = metrics.team_success(world, policies, experts, selection)[0]
        score, half_width = joint_ratio(success, expert_success)
        if best is None or score > best[0]:
            n_leaves = sum(int((tree.feature == ir.NO_FEATURE).sum()) for tree in grown)
            best = score, grown, Progress(iteration, score, score, half_width, success, n_leaves)
        chosen = best[2]
        on_iteration(Progress(iteration, score, best[0], chosen.half_width, chosen.best_success, chosen.leaves))
        since_gain += 1
        if best[0] > reference:
            reference, since_gain = best[0] + chosen.half_width, 0
        if since_gain >= settings.patience:
            break
    assert best is not None and data is not None
    training = asdict(settings) | {"stopped_after": iteration + 1, "best_iteration": best[2].iteration + 1}
    training |= {"points": len(data), "opponents_in_selection": "expert"}
    del training["seed"], training["preset"]
    agents = agent_policies(world, best[1])
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


def rollouts(world: ParticleWorld, expert: Expert, policies: Sequence[Policy], seeds: Sequence[int]) -> Dataset:
    """Episodes of `policies`, labelled by the expert, with each agent's weights."""
    observations = states(play(world, policies, world.start_from_seeds(seeds)))
    wanted = labels(expert, observations)
    return Dataset(observations, wanted, maviper_weights(world, expert, observations, wanted))


def grow_teams(
    world: ParticleWorld, data: Dataset, counts: Sequence[np.ndarray], max_depth: int, rng: np.random.Generator
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


def agent_policies(world: ParticleWorld, grown: Sequence[GrownTree]) -> tuple[ir.AgentPolicy, ...]:
    """The grown trees as deployed policies."""
    return tuple(
        ir.AgentPolicy(agent, world.team_of(agent), features, actions, deployed(tree), tree)
        for agent, features, actions, tree in zip(world.agents, world.features, world.actions, grown, strict=True)
    )


def joint_ratio(success: dict[str, Share], expert_success: dict[str, Share]) -> tuple[float, float]:
    """Mean over teams of tree success over expert success, and the half width of its 95 % interval."""
    ratios, widths = [], []
    for team, measured in success.items():
        base = max(expert_success[team].value, 1 / expert_success[team].count)  # an expert that never wins
        ratios.append(measured.value / base)
        low, high = measured.interval
        widths.append((high - low) / 2 / base)
    return float(np.mean(ratios)), float(np.sqrt(np.square(widths).sum()) / len(widths))


def evaluation(world: ParticleWorld, agents: Sequence[ir.AgentPolicy], expert: Expert) -> dict[str, float | int | str]:
    """Success of the trees against expert opponents and of the expert, on held-out episodes, at each radius."""
    seeds = range(metrics.MEASUREMENT_SEEDS, metrics.MEASUREMENT_SEEDS + EVALUATION_EPISODES)
    trees = [metrics.tree_policy(policy) for policy in agents]
    experts = expert.policies()
    rows: dict[str, float | int | str] = {"episodes": EVALUATION_EPISODES}
    tree_rows = metrics.team_success(world, trees, experts, seeds)
    expert_rows = metrics.success(world, experts, seeds)
    for squared_radius, ours, theirs in zip(world.squared_radii, tree_rows, expert_rows, strict=True):
        label = f"r={squared_radius**0.5:.3g}"
        for team, measured in ours.items():
            rows[f"{team} success {label}"] = measured.value
            low, high = measured.interval
            rows |= {f"{team} success {label} low": round(low, 6), f"{team} success {label} high": round(high, 6)}
            rows[f"{team} expert success {label}"] = theirs[team].value
    return rows


def success_of(measured: Mapping[str, float | int | str], team: str, squared_radius: float) -> tuple[float, float]:
    """A team's success and its expert's in what `evaluation` wrote, at one radius."""
    label = f"r={squared_radius**0.5:.3g}"
    return float(measured[f"{team} success {label}"]), float(measured[f"{team} expert success {label}"])
