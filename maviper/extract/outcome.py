"""What all algorithms end with: candidates scored on common episodes, the best of them as a profile.

Does: keeps the best candidate and knows when to stop; puts trees, provenance and held-out measures into a profile.
Assumes: candidates are scored against expert opponents on the same episodes (common random numbers).
Does not: make candidates.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from types import MappingProxyType

import numpy as np

from codegen import ir
from codegen.ir import GrownTree
from maviper import version
from maviper.evaluate import metrics
from maviper.evaluate.metrics import Estimate
from maviper.evaluate.play import Controller, tree_policies
from maviper.experts.expert import Expert
from maviper.extract.deploy import deployed
from maviper.extract.settings import EPISODES_PER_SEED, Settings
from maviper.worlds import Measure, World

EVALUATION_EPISODES = 1_000


@dataclass(frozen=True)
class Progress:
    """What one iteration gave: the mean over teams of the ratio to the expert, and the best so far."""

    iteration: int
    score: float
    best: float
    half_width: float  # of the best score's 95 % interval
    best_measured: dict[str, Estimate]  # team -> primary measure of the best iterate, against expert opponents
    leaves: int  # of the best iterate, all agents


OnIteration = Callable[[Progress], None]


class Selection:
    """The best of the candidates so far, scored by the mean ratio of the teams to the expert.

    A candidate has trees of all agents, each team of which meets expert opponents; or of some `agents`, among experts.
    """

    def __init__(
        self,
        world: World,
        expert: Expert,
        settings: Settings,
        on_iteration: OnIteration,
        agents: Sequence[int] | None = None,
    ) -> None:
        self.world, self.settings, self.on_iteration = world, settings, on_iteration
        self.agents = list(range(len(world.agents)) if agents is None else agents)
        self.teams = [team for team in world.teams if set(world.members(team)) & set(self.agents)]
        first = metrics.SELECTION_SEEDS + settings.seed * EPISODES_PER_SEED
        self.seeds = range(first, first + settings.selection_episodes)
        self.experts: list[Controller] = [expert] * len(world.agents)
        self.base = metrics.evaluate(world, self.experts, self.seeds)
        self.trees: list[GrownTree] | None = None
        self.best: Progress | None = None
        self.seen, self.reference, self.since_gain = 0, -np.inf, 0

    def offer(self, trees: Sequence[GrownTree]) -> bool:
        """Scores a candidate, trees in the order of `agents`; returns whether it is time to stop: no gain above the
        interval for `patience` of them.
        """
        world = self.world
        controllers = among(world, agent_policies(world, trees, self.agents), self.experts)
        if len(trees) == len(world.agents):
            measured = metrics.evaluate_teams(world, controllers, self.experts, self.seeds)
        else:
            measured = metrics.evaluate(world, controllers, self.seeds)
        score, half_width = joint_ratio(world, measured, self.base, self.teams)
        if self.best is None or score > self.best.score:
            leaves = sum(int((tree.feature == ir.NO_FEATURE).sum()) for tree in trees)
            reached = {team: measured[world.primary(team)] for team in self.teams}
            self.trees = list(trees)
            self.best = Progress(self.seen, score, score, half_width, reached, leaves)
        best = self.best
        self.on_iteration(Progress(self.seen, score, best.score, best.half_width, best.best_measured, best.leaves))
        self.seen, self.since_gain = self.seen + 1, self.since_gain + 1
        if best.score > self.reference:
            self.reference, self.since_gain = best.score + best.half_width, 0
        return self.since_gain >= self.settings.patience

    def profile(self, expert: Expert, facts: Mapping[str, int]) -> ir.PolicyProfile:
        """The best candidate as a profile."""
        assert self.trees is not None and self.best is not None
        found = {"stopped_after": self.seen, "best_iteration": self.best.iteration + 1, **facts}
        policies = agent_policies(self.world, self.trees, self.agents)
        return profile_of(self.world, expert, self.settings, policies, found)


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


def profile_of(
    world: World,
    expert: Expert,
    settings: Settings,
    agents: Sequence[ir.AgentPolicy],
    facts: Mapping[str, int],
) -> ir.PolicyProfile:
    """Policies of all agents, or of some, with where they come from and what they reach on held-out episodes."""
    training = asdict(settings) | dict(facts) | {"opponents_in_selection": "expert"}
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
