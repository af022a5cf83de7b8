"""What other policies cost a team, and how far trees act as the expert that they come from.

Does: compares two profiles of one world in states of a region, in the states that the first one meets, and in play:
  changed actions, and measures before and after in the same episodes; asks the expert about the states that the trees
  meet, and counts by action and by leaf.
Assumes: opponents are the expert where it is shipped, else the profiles' own trees; the expert is found by its hash.
Does not: make the other policy, judge whether it is worth its price, or whether a difference matters.
"""

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np

from codegen import ir
from codegen.deciding import decide_at, list_decided
from codegen.floats import rational_literal
from codegen.intervals import Share, percent
from codegen.wording import format_count
from maviper.console import Console
from maviper.episodes import measures
from maviper.episodes.measures import Estimate, Mean, estimate, format_estimate
from maviper.episodes.play import Controller, Episodes, points, rollout, tree_policies
from maviper.evaluation.players import Player, find_shipped
from maviper.experts.expert import labels
from maviper.worlds import Measure, ParticleWorld, World, WorldState
from maviper.worlds.matching import NO_WORLD
from maviper.worlds.world import Int
from verify.claims.region import Region
from verify.question import Budgets
from verify.states.shares import SAMPLE_SEED, SAMPLES, find_unbounded
from verify.states.state import choose_actions, sample

MAX_CELLS = 2_000  # zones of an agent in which the actions differ; with more, their share is sampled


@dataclass(frozen=True)
class Compared:
    """A measure of the team in the same episodes: before, after, and the mean difference."""

    measure: Measure
    before: Estimate
    after: Estimate
    difference: Mean


@dataclass(frozen=True)
class Cost:
    """The cost of a change. States met are of whole episodes, and so not independent; None where none can be played."""

    uniform: Share | None  # of the region's states, by sampling: some agent's action changes; None without ranges
    exact: Fraction | None  # the same, exactly, where the zones tell it
    met: Share | None  # of the states that the team met before, in the held-out episodes
    opponents: str
    compared: tuple[Compared, ...] = ()

    def document(self) -> dict[str, Any]:
        """The cost as plain data."""
        exact = {} if self.exact is None else {"exact": rational_literal(self.exact)}
        return {
            "changed": {
                "region": None if self.uniform is None else self.uniform.document() | exact,
                "met": None if self.met is None else self.met.document(),
            },
            "opponents": self.opponents,
            "measures": [
                {
                    "measure": one.measure.name,
                    "episodes": one.difference.count,
                    "before": _interval(one.before),
                    "after": _interval(one.after),
                    "difference": _interval(one.difference),
                }
                for one in self.compared
            ],
        }

    def say(self, console: Console) -> None:
        """A line for what changed, and one a measure."""
        met = f"{self.met} of the states met, " if self.met else ""
        region = self.uniform if self.exact is None else f"{percent(float(self.exact))}, exactly,"
        unmeasured = "a share of the region that is not measured, as it has no stated range"
        whole = f"{region} of the region's states" if self.uniform else unmeasured
        console.line("changed", f"some action in {met}{whole}")
        for one in self.compared:
            low, high = one.difference.interval
            values = f"{format_estimate(one.before)} to {format_estimate(one.after)}"
            told = f"{values}, difference {one.difference.value:.3f} [{low:.3f}, {high:.3f}]"
            played = format_count(one.difference.count, "episode")
            console.line("measured", f"{one.measure.team} {one.measure.name}: {told}, {played}")


def measure_cost(
    before: ir.PolicyProfile,
    after: ir.PolicyProfile,
    teams: Collection[str],
    region: Region,
    world: ParticleWorld | None,
    expert: Player | None,
    episodes: int,
) -> Cost:
    """Measures what `after` costs some teams in play against the shipped expert, or else the profile's own trees."""
    uniform = exact = None
    if not find_unbounded(region):
        uniform = _count_differing(before, after, teams, sample(region, before.world, SAMPLES, SAMPLE_SEED)[0])
        exact = _exactly(before, after, teams, region)
    if world is None:
        return Cost(uniform, exact, None, NO_WORLD)
    seeds = range(measures.MEASUREMENT_SEEDS, measures.MEASUREMENT_SEEDS + episodes)
    others: Controller = tree_policies(before.agents) if expert is None else expert.controller
    tables: list[dict[Measure, ir.Float64]] = []
    met = None
    for profile in (before, after):
        own = tree_policies(profile.agents)
        lineup = [own if policy.team in teams else others for policy in profile.agents]
        played = rollout(world, lineup, seeds)
        parts = [measures.table(world, each) for each in played]
        tables.append({m: np.concatenate([part[m] for part in parts]) for m in parts[0] if m.team in teams})
        if met is None:
            states = [WorldState.concatenate(each.states[:-1]) for each in played]
            met = _count_differing(before, after, teams, np.concatenate([world.coordinates(state) for state in states]))
    compared = [
        Compared(
            measure, estimate(measure, old), estimate(measure, tables[1][measure]), _mean(tables[1][measure] - old)
        )
        for measure, old in tables[0].items()
    ]
    return Cost(uniform, exact, met, "the profile's own trees" if expert is None else str(expert), tuple(compared))


def sizes(profile: ir.PolicyProfile, agents: Sequence[str]) -> dict[str, dict[str, int]]:
    """Agent -> the leaves and the depth of its tree."""
    trees = {agent: profile.policy(agent).tree for agent in agents}
    return {
        agent: {"leaves": len(ir.leaves(tree)), "depth": int(ir.depth(tree).max())} for agent, tree in trees.items()
    }


def sizes_document(before: ir.PolicyProfile, after: ir.PolicyProfile, agents: Sequence[str]) -> dict[str, Any]:
    """Agent -> its sizes before and after, as plain data."""
    old, new = sizes(before, agents), sizes(after, agents)
    return {agent: {"before": old[agent], "after": new[agent]} for agent in agents}


def say_sizes(before: ir.PolicyProfile, after: ir.PolicyProfile, agents: Sequence[str]) -> str:
    """Leaves and depth of each agent before and after, in words."""
    parts: list[str] = []
    for agent, size in sizes_document(before, after, agents).items():
        leaves, depth = (f"{size['before'][part]} to {size['after'][part]}" for part in ("leaves", "depth"))
        parts.append(f"{agent} {leaves} leaves, depth {depth}")
    return "; ".join(parts)


def _mean(values: np.ndarray) -> Mean:
    found = estimate(Measure("", "difference", share=False), values)
    assert isinstance(found, Mean), found
    return found


def differing(
    before: ir.PolicyProfile, after: ir.PolicyProfile, agents: Sequence[str], coordinates: ir.Float64
) -> ir.Bool:
    """Where each of the agents acts differently, [n_agents, n]. `coordinates`: world states [n, n_coordinates]."""
    pairs = [(before.policy(agent), after.policy(agent)) for agent in agents]
    world = before.world
    return np.array(
        [choose_actions(old, coordinates, world) != choose_actions(new, coordinates, world) for old, new in pairs]
    )


def _count_differing(
    before: ir.PolicyProfile, after: ir.PolicyProfile, teams: Collection[str], coordinates: ir.Float64
) -> Share:
    """In how many states some agent of the teams acts differently."""
    agents = [policy.agent for team in teams for policy in before.team(team)]
    other = differing(before, after, agents, coordinates).any(axis=0)
    return Share(int(np.sum(other)), len(coordinates))


def _exactly(
    before: ir.PolicyProfile, after: ir.PolicyProfile, teams: Collection[str], region: Region
) -> Fraction | None:
    """In which share of a region some agent of the teams acts differently; None where zones do not tell it."""
    from verify.verdicts.differences import difference  # which imports the solver

    agents = [policy.agent for team in teams for policy in before.team(team)]
    least, most = difference(before, after, agents, region, budgets=Budgets(max_cells=MAX_CELLS)).together
    return least if least == most else None


def _interval(estimate: Estimate) -> dict[str, float | None]:
    """The value and its interval, whose ends are None where one episode bounds nothing."""
    low, high = (round(end, 6) if math.isfinite(end) else None for end in estimate.interval)
    return {"value": round(estimate.value, 6), "low": low, "high": high}


@dataclass(frozen=True)
class Counted:
    """In how many of some states an agent's tree acts as the expert."""

    agreeing: int
    states: int

    @property
    def share(self) -> float:
        """The share of agreeing states; 0 where there are none."""
        return self.agreeing / self.states if self.states else 0.0

    def __add__(self, other: "Counted") -> "Counted":
        return Counted(self.agreeing + other.agreeing, self.states + other.states)


@dataclass(frozen=True)
class Fidelity:
    """One agent: in all states, by the action that the expert takes, and by the leaf that decides."""

    agent: str
    whole: Counted
    by_action: Mapping[str, Counted]
    by_leaf: Mapping[int, Counted]

    def __add__(self, other: "Fidelity") -> "Fidelity":
        """The same agent in more states."""
        by_action = {name: count + other.by_action[name] for name, count in self.by_action.items()}
        by_leaf = {leaf: count + other.by_leaf[leaf] for leaf, count in self.by_leaf.items()}
        return Fidelity(self.agent, self.whole + other.whole, by_action, by_leaf)

    def document(self) -> dict[str, object]:
        """Returns the counts as plain data."""
        return {
            "agent": self.agent,
            "states": self.whole.states,
            "agreement": round(self.whole.share, 6),  # the word of before, in files that are committed
            "by_action": {name: [item.agreeing, item.states] for name, item in self.by_action.items()},
            "by_leaf": {str(leaf): [item.agreeing, item.states] for leaf, item in self.by_leaf.items()},
        }


def fidelity(profile: ir.PolicyProfile, world: World, episodes: Episodes) -> tuple[Fidelity, ...]:
    """Each agent's fidelity to the expert in the states of `episodes`; () where the expert is not shipped."""
    expert = find_shipped(profile.provenance.expert, world)
    if expert is None:
        return ()
    observations, state = points(episodes)
    wanted = labels(expert.controller, observations, state)  # pyright: ignore[reportArgumentType]
    alive = episodes.alive.reshape(wanted.shape)
    by_agent: list[Fidelity] = []
    for agent, (policy, seen) in enumerate(zip(profile.agents, observations, strict=True)):
        mine, asked = alive[:, agent], wanted[alive[:, agent], agent]
        leaf = ir.apply(policy.tree, seen[mine])
        right = decide_at(policy, leaf, seen[mine]) == asked
        names = list_decided(policy)
        by_action = _count_right(asked, right, np.arange(len(names)))
        whole = Counted(int(right.sum()), len(right))
        by_name = dict(zip(names, by_action.values(), strict=True))
        by_agent.append(Fidelity(policy.agent, whole, by_name, _count_right(leaf, right, ir.leaves(policy.tree))))
    return tuple(by_agent)


def _count_right(kind: Int, right: ir.Bool, kinds: Int) -> dict[int, Counted]:
    return {int(each): Counted(int(right[kind == each].sum()), int((kind == each).sum())) for each in kinds}
