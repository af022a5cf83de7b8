"""One extraction as a value: what it starts from, states in which a claim failed among it, and the profile at its end.

Does: holds together what every algorithm needs; labels each state in which a team shall fulfil a claim with a joint
  action that does, puts the states before an iteration's data, with a share of its weight, and says in how many of them
  trees fulfil it; makes the profile, with provenance and held-out measures.
Assumes: settings that were checked; claims about single decisions, of which the actions of one team decide; trees in
  the world's order of agents.
Does not: run anything; make or choose trees; read files (refitting.py); find states in which a claim fails (verify).
"""

import math
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from itertools import combinations, product
from types import MappingProxyType
from typing import Any

import numpy as np

from codegen import ir
from codegen.ir import Bool, Float32, Float64, GrownTree, Int32
from codegen.profiles import ensure
from maviper.episodes import measures
from maviper.episodes.measures import Estimate
from maviper.episodes.play import TALLY, Controller
from maviper.episodes.trees import among
from maviper.evaluation.held_out import evaluate_trees
from maviper.experts.expert import AS_GIVEN, Expert
from maviper.experts.finding import critic_of, origin_of, reward_weighed_by
from maviper.extraction.arena import stack_trees
from maviper.extraction.dataset import Dataset
from maviper.extraction.journal import NOTHING_KEPT, WHOLE, Journal, OnProgress, OnUnderway, Part
from maviper.extraction.settings import BUNDLES, DESCRIBED, NO_VOTES, PARTS, RELEASED, UNSAID, Settings
from maviper.files.profiles import version
from maviper.worlds import Measure, World
from maviper.worlds.matching import FEATURES_FILE
from maviper.worlds.world import Int
from verify.claims.formula import Formula, Or
from verify.states.values import Batch

MEASURED = 0.5  # of a limit of time, at most, is kept for held-out episodes
FEWEST = 2  # of them, in whatever time: one has no interval
SHARE = 0.2  # of the weight of a team's data, where there are examples for it
MAX_EACH = 100  # average points of the data that one such state may weigh, so that a few do not rule
MAX_JOINT = 4_096  # joint actions with the same number of changed agents that are tried in a state


@dataclass(frozen=True)
class Lesson:
    """`n` states for one claim."""

    team: str
    claim: Formula
    columns: Mapping[str, Float64]  # coordinate -> [n]
    observations: tuple[Float32, ...]  # of every agent, each [n, n_features], with a counterexample's errors
    labels: Int  # [n, n_agents]; what the team's agents do fulfils the claim

    def __len__(self) -> int:
        return len(self.labels)

    def meets_claim(self, world: World, trees: Mapping[int, GrownTree]) -> Bool:
        """Where the team fulfils the claim with these trees (agent -> tree), all others acting as labelled, [n]."""
        actions = dict[str, Int32]()
        for agent, name in enumerate(world.agents):
            acted = self.labels[:, agent]
            if agent in trees:
                only = np.zeros(len(self), dtype=np.int64)
                acted = stack_trees(world, agent, [trees[agent]]).act(only, self.observations[agent])
            actions[name] = acted.astype(np.int32)
        return Batch(self.columns, len(self)).holds(self.claim, actions)


@dataclass(frozen=True)
class Examples:
    """The lessons of one extraction. `share`: what they carry of the weight of a team's data."""

    lessons: tuple[Lesson, ...] = ()
    share: float = SHARE
    digest: str = ""  # of what they were made from

    def __len__(self) -> int:
        return sum(map(len, self.lessons))

    def of_teams(self, *teams: str) -> "Examples":
        """Those for some teams."""
        return replace(self, lessons=tuple(lesson for lesson in self.lessons if lesson.team in teams))

    def before(self, world: World, data: Dataset, some: Sequence[int] | None = None) -> Dataset:
        """The states of the lessons, then `data`. `some`: the agents that `data` has weights for; None: all.

        For agents of their teams the states carry `share` of all weight (less where there are few, see MAX_EACH), each
        the same; for others none. They come first, so that the rest may grow behind them.
        """
        if not self.lessons:
            return data
        agents = range(len(world.agents)) if some is None else some
        # where all weights are zero, every point in which the agent takes part counts alike
        alive = data.alive[:, list(agents)]
        theirs = np.where(data.weights.sum(axis=0) > 0, data.weights, alive)
        ours = list[Float64]()
        for agent, known, count in zip(agents, theirs.sum(axis=0), alive.sum(axis=0), strict=True):
            team = world.team_of(world.agents[agent])
            mine = np.concatenate([np.full(len(lesson), float(lesson.team == team)) for lesson in self.lessons])
            each = self.share / (1 - self.share) * known / max(1.0, mine.sum())
            ours.append(mine * min(each, MAX_EACH * known / count))
        observations = tuple(
            np.concatenate([lesson.observations[place] for lesson in self.lessons])
            for place in range(len(world.agents))
        )
        labels = np.concatenate([lesson.labels for lesson in self.lessons])
        everybody = np.ones(labels.shape, dtype=bool)
        return Dataset(observations, labels, np.stack(ours, axis=1), everybody) + replace(data, weights=theirs)

    def measure_claims(self, world: World, trees: Mapping[int, GrownTree]) -> float:
        """The share of all states in which their teams fulfil the claims with these trees; 1 without states."""
        per_lesson = [lesson.meets_claim(world, trees) for lesson in self.lessons]
        return float(np.concatenate(per_lesson).mean()) if per_lesson else 1.0

    @property
    def facts(self) -> dict[str, int | str]:
        """The provenance's entries about the examples."""
        return {"counterexamples": len(self), "counterexamples_from": self.digest} if self.lessons else {}


NO_EXAMPLES = Examples()


def counts_of(weights: Float64) -> Int:
    """Weights [n] as whole multiplicities, at least 1 where there is any weight: for algorithms that do not draw."""
    return np.maximum(np.rint(weights), weights > 0).astype(np.int64)


def lesson_of(
    world: World,
    expert: Expert,
    team: str,
    claim: Formula,
    columns: Mapping[str, Float64],
    observations: tuple[Float32, ...],
    state: Any,
) -> Lesson:
    """The states in which some action of the team fulfils the claim, with one that does; the others are left out.
    `columns`, `observations`: as of a lesson, of states in which the claim failed; `state`: the world's own of them.

    Where a claim can be fulfilled in several ways
    (the parts of an `or`, such as matchings of agents to landmarks), one of them is taken wherever it can be: the one
    that the expert's own actions fulfil in most of the states. Labels that go from way to way between neighbours cannot
    be learned by small trees. Of the actions that fulfil it, those that change the expert's for the fewest agents; of
    these the one that the critics of the team value most.
    """
    members, batch = world.members(team), Batch(columns, len(state))
    sizes = [len(world.actions[agent]) for agent in members]
    wanted = expert.act(range(len(world.agents)), observations, state)

    def holds(part: Formula, joint: Int) -> Bool:
        """Where the formula is true for joint actions [n, n_agents], [n]."""
        return batch.holds(part, {world.agents[agent]: joint[:, agent].astype(np.int32) for agent in members})

    def worth_of(joint: Int, rows: Int) -> Float64:
        """The mean Q of the team's agents for joint actions in some rows."""
        if not rows.size:
            return np.zeros(0)
        seen, given = [each[rows] for each in observations], np.full((1, joint.shape[1]), AS_GIVEN)
        q_values = [expert.q(agent, seen, state[rows], given, joint)[:, 0] for agent in members]
        return np.mean(q_values, axis=0)

    ways = claim.parts if isinstance(claim, Or) and claim.parts else (claim,)
    usual = max(ways, key=lambda way: int(holds(way, wanted).sum()))
    labels, missing = wanted.copy(), np.ones(len(state), dtype=bool)
    for part, level in product((usual, claim), _moves(sizes)):
        best = np.full(len(labels), -np.inf)
        for moves in level if missing.any() else ():
            joint = wanted.copy()
            joint[:, members] = (joint[:, members] + moves) % sizes
            rows = np.flatnonzero(missing & holds(part, joint))
            worth = worth_of(joint[rows], rows)
            better = worth > best[rows]
            labels[rows[better]], best[rows[better]] = joint[rows[better]], worth[better]
        missing &= np.isneginf(best)
    kept = {name: column[~missing] for name, column in columns.items()}
    return Lesson(team, claim, kept, tuple(seen[~missing] for seen in observations), labels[~missing])


def _moves(sizes: Sequence[int]) -> Iterator[list[tuple[int, ...]]]:
    """By how far each agent's action moves on from the expert's, for ever more changed agents, until one level of them
    has more than MAX_JOINT.
    """
    places = range(len(sizes))
    for changed in range(len(sizes) + 1):
        chosen = list(combinations(places, changed))
        if sum(math.prod(sizes[place] - 1 for place in each) for each in chosen) > MAX_JOINT:
            return
        yield [
            moves
            for each in chosen
            for moves in product(*(range(1, sizes[place]) if place in each else (0,) for place in places))
        ]


class OutOfTime(Exception):
    """The time is over within a round, which is given up."""


@dataclass(frozen=True)
class Extraction:
    """The inputs of an extraction: from an expert of a world, as the settings say."""

    world: World
    expert: Expert
    settings: Settings
    journal: Journal = NOTHING_KEPT  # keeps the steps that are done
    examples: Examples = NO_EXAMPLES  # states whose labels every iteration learns from as well
    ends: float = math.inf  # by the monotonic clock: the trees are to be measured by then

    def is_over(self, *further: int, since: float = math.inf) -> bool:
        """Returns True if it is time to measure the trees, with so many episodes of each further kind to be played
        before, and perhaps a step that takes as long as what went on `since` then.
        """
        if self.ends == math.inf:
            return False
        now = time.monotonic()
        return now + max(0.0, now - since) + self.measuring + TALLY.expect(self.world, *further) >= self.ends

    @property
    def measuring(self) -> float:
        """Seconds that are kept for held-out episodes."""
        expected = TALLY.expect(self.world, (len(self.world.teams) + 1) * self.settings.count_held_out(self.world))
        return expected if self.world.games is None else min(expected, MEASURED * self.settings.max_seconds)

    def fit_held_out(self) -> Settings:
        """The settings with as few held-out episodes as there is still time for, where a user's episodes take long."""
        count = self.settings.count_held_out(self.world)
        if self.ends == math.inf or self.world.games is None:
            return self.settings
        pace = TALLY.expect(self.world, len(self.world.teams) + 1) or math.inf
        fits = int(max(0.0, self.ends - time.monotonic()) / pace)
        return replace(self.settings, held_out=min(count, max(FEWEST, fits)))


def unseen(progress: object) -> None:
    """Shows a step to nobody."""
    del progress


@dataclass(frozen=True)
class Running:
    """The circumstances of a run, which never change what comes out."""

    on_progress: OnProgress = unseen
    jobs: int = 1  # agents or teams at the same time
    on_underway: OnUnderway = unseen  # told within a step that takes long
    part: Part = WHOLE


QUIETLY = Running()


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
    starts = zip(world.agents, world.counted_from, strict=False)
    numbered = {f"{agent} {ir.COUNTED}": first for agent, first in starts if first}
    provenance = ir.Provenance(
        algorithm=settings.algorithm,
        preset=settings.preset,
        seed=settings.seed,
        expert=origin_of(expert),
        tool=f"maviper {version()}",
        training=MappingProxyType({**training, **numbered}),
        evaluation=MappingProxyType(reached),
    )
    return ensure(ir.PolicyProfile(world.spec, visited, provenance))
