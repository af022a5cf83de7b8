"""Cross-play: a team's measures when it, or one agent, replaces the expert.

Does: plays line-ups over the same episodes, each once; values, ratios and their intervals; how trees decide.
Assumes: controllers are deterministic, or draw by episode seed as `Uniform` does, so that episodes can be paired.
Does not: find controllers by name, or print (run.py).
"""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from codegen import ir
from codegen.deciding import decide_at, size
from codegen.intervals import Share
from codegen.ir import Float32, Float64
from maviper.episodes import measures
from maviper.episodes.measures import Estimate, likeness
from maviper.episodes.play import Controller, Episodes, play, start_games
from maviper.worlds import Measure, World
from maviper.worlds.world import Int

DRAWS = 2_000  # bootstrap samples of the episodes
MAX_COUNTS = 2**22  # at once; bounds the memory


def counts(episodes: int, rng: np.random.Generator, draws: int = DRAWS) -> Iterator[Int]:
    """Yields in parts how often each of the episodes is in a sample, [draws, episodes] over all parts."""
    at_once = max(1, MAX_COUNTS // episodes)
    for low in range(0, draws, at_once):
        rows = min(at_once, draws - low)
        drawn = rng.integers(episodes, size=(rows, episodes)) + episodes * np.arange(rows)[:, None]
        yield np.bincount(drawn.ravel(), minlength=rows * episodes).reshape(rows, episodes)


DRAW_SEED = 11
UNIFORM_SEED = 12
MAX_GAMES = 8_192  # played at once
MAX_NUMBERS = 2**25  # observed by all agents in the games that are played at once; bounds the memory

Lineup = tuple[Controller, ...]  # one for each agent, in the world's order
Key = tuple[int, ...]  # of a line-up: its controllers' identities
Watch = Callable[[Episodes], Float64]  # episodes -> [..., batch]


@dataclass(frozen=True)
class Interval:
    """A number with its 95 % interval; an end may be infinite. `cut`: how many of its episodes were stopped at a length
    that nobody stated.
    """

    value: float
    low: float
    high: float
    cut: int = 0

    def __str__(self) -> str:
        return f"{self.value:.3f} [{self.low:.3f}, {self.high:.3f}]{f', {self.cut} cut' if self.cut else ''}"


@dataclass(frozen=True)
class Alone:
    """One agent replaced among expert team-mates."""

    value: Interval
    ratio: Interval | None


@dataclass(frozen=True)
class Standing:
    """A team's measure against certain opponents; what needs an expert is None where nobody named one."""

    measure: Measure
    value: Interval | None  # the whole team is the subject; None for a partial measure that no episode knows
    expert: Interval | None = None  # the expert in the team's place
    joint: Interval | None = None  # ratio of the two; None also where it divides by zero
    individual: Alone | None = None  # the mean over agents
    agents: Mapping[str, Alone] | None = None  # agent -> the team when it alone is the subject


@dataclass(frozen=True)
class Cast:
    """The players when a team is measured."""

    team: str
    ours: Lineup
    expert: Lineup | None
    alone: Mapping[str, Lineup]  # agent -> it alone is the subject; {} without an expert

    @property
    def lineups(self) -> list[Lineup]:
        """All of them."""
        return [self.ours, *([] if self.expert is None else [self.expert]), *self.alone.values()]


def cast(
    world: World, team: str, subject: Sequence[Controller], others: Sequence[Controller], expert: Controller | None
) -> Cast:
    """The line-ups that measure `team` against `others`, who play all other teams."""
    members = world.members(team)

    def lineup(ours: Sequence[int]) -> Lineup:
        everybody = range(len(world.agents))
        mates = [others[agent] if expert is None or agent not in members else expert for agent in everybody]
        return tuple(subject[agent] if agent in ours else mates[agent] for agent in everybody)

    if expert is None:
        return Cast(team, lineup(members), None, {})
    return Cast(team, lineup(members), lineup([]), {world.agents[agent]: lineup([agent]) for agent in members})


class Uniform:
    """Every legal action as likely as any other. The draws of an episode follow from its seed, whoever else plays."""

    def __init__(self, world: World, seeds: Sequence[int] = ()) -> None:
        self.world = world
        shape = (world.spec.episode_steps, *world.acting_shape)
        # all steps of one episode from one generator, [batch, steps, n_agents] or, of numbers, [..., n_outputs]
        drawn = [np.random.default_rng([UNIFORM_SEED, seed]).random(shape) for seed in seeds]
        self._steps: Iterator[Float64] = iter(np.array(drawn).reshape(-1, *shape).swapaxes(0, 1))

    def start_episodes(self, seeds: Sequence[int]) -> "Uniform":
        """One that plays the episodes `seeds` from their start."""
        return Uniform(self.world, seeds)

    def act(self, agents: Sequence[int], observations: Sequence[Float32], state: Any) -> Int:
        """Returns random actions, once per step of the episodes that it was started for; see `Controller.act`."""
        return self.world.draw_actions(agents, observations, next(self._steps)[:, list(agents)])


class Stage:
    """The results of line-ups over the same episodes: `measures` are the world's, the teams' returns, those beside."""

    def __init__(self, world: World, seeds: range) -> None:
        self.world, self.seeds = world, seeds
        self.measures = (*measures.list_measures(world), *world.beside)
        self._cut: dict[Key, int] = {}  # episodes that were stopped at a length that nobody stated
        self._played: dict[Key, tuple[Lineup, Float64]] = {}  # the line-up is kept, so that its key stays its own
        self._draws: dict[Key, Float64] = {}
        self._starts: dict[range, Any] = {}

    def play(self, lineup: Lineup, watch: Watch | None = None) -> Float64:
        """Plays a line-up; what `watch` saw in its episodes, [..., n]."""
        values: list[Float64] = []
        seen: list[Float64] = []
        cut = 0
        for episodes in self._episodes(lineup):
            rows = measures.table(self.world, episodes)
            rows |= dict(zip(self.world.beside, self.world.values_beside(episodes.states[1:]), strict=True))
            values.append(np.stack([rows[measure] for measure in self.measures]))
            cut += int(episodes.cut.sum())
            seen.append(watch(episodes) if watch else np.empty((0, episodes.actions.shape[1])))
        self._cut[key(lineup)] = cut
        self._played[key(lineup)] = lineup, np.concatenate(values, axis=1)
        return np.concatenate(seen, axis=-1)

    def _episodes(self, lineup: Lineup) -> Iterator[Episodes]:
        """In batches of bounded size."""
        world = self.world
        numbers = world.spec.episode_steps * sum(len(features) for features in world.features)
        at_once = world.games_measured or max(1, min(MAX_GAMES, MAX_NUMBERS // numbers))
        for low in range(0, len(self.seeds), at_once):
            part = self.seeds[low : low + at_once]
            fresh = {id(each): each.start_episodes(part) for each in lineup if isinstance(each, Uniform)}
            yield play(world, [fresh.get(id(each), each) for each in lineup], self._start(part))

    def _start(self, seeds: range) -> Any:
        if self.world.games is not None:  # copies of an environment, which have to start anew
            return start_games(self.world, seeds)
        if seeds not in self._starts:
            self._starts[seeds] = self.world.start_from_seeds(seeds)
        return self._starts[seeds]

    def values(self, lineup: Lineup, measure: Measure) -> Float64:
        """A measure of each episode of a line-up that was played, [n]."""
        return self._played[key(lineup)][1][self.measures.index(measure)]

    def estimate(self, lineup: Lineup, measure: Measure) -> Interval:
        """The mean of a measure over the episodes of a line-up."""
        found = interval(measures.estimate(measure, self.values(lineup, measure)))
        return replace(found, cut=self.cut([lineup]))

    def cut(self, lineups: Sequence[Lineup]) -> int:
        """Returns the largest count of episodes in one line-up that were stopped at a length nobody stated."""
        return max(self._cut.get(key(lineup), 0) for lineup in lineups)

    def plays_alike(self, one: Lineup, other: Lineup) -> bool:
        """Returns True if two line-ups reached the same in each episode, in every measure and return."""
        return np.array_equal(self._played[key(one)][1], self._played[key(other)][1], equal_nan=True)

    def draws(self, lineup: Lineup, measure: Measure) -> Float64:
        """A measure's means over bootstrap samples of the episodes, the same ones for all line-ups, [DRAWS]."""
        if key(lineup) not in self._draws:
            means = resample_means(np.concatenate([values for _, values in self._played.values()]))
            parts = np.split(means, len(self._played))
            self._draws = dict(zip(self._played, parts, strict=True))
        return self._draws[key(lineup)][self.measures.index(measure)]


def key(lineup: Lineup) -> Key:
    """Returns the key that tells a line-up from others."""
    return tuple(map(id, lineup))


def resample_means(values: Float64, draws: int = DRAWS, seed: int = DRAW_SEED) -> Float64:
    """Means of each row of `values`, [k, n], over `draws` samples of n columns with replacement, [k, draws]."""
    n, rng = values.shape[1], np.random.default_rng(seed)
    return np.concatenate([values @ part.T.astype(np.float64) / n for part in counts(n, rng, draws)], axis=1)


# --- a team's standing


def standings(stage: Stage, cast: Cast) -> tuple[Standing, ...]:
    """Every measure of the team, of line-ups that have been played."""
    return tuple(_standing(stage, cast, measure) for measure in stage.measures if measure.team == cast.team)


def _standing(stage: Stage, cast: Cast, measure: Measure) -> Standing:
    if measure.partial:
        return Standing(measure, _where_known(stage, measure, cast.ours), _where_known(stage, measure, cast.expert))
    value = stage.estimate(cast.ours, measure)
    if cast.expert is None:
        return Standing(measure, value)
    expert = stage.estimate(cast.expert, measure)
    agents = {
        agent: Alone(stage.estimate(lineup, measure), ratio(stage, measure, [lineup], cast.expert))
        for agent, lineup in cast.alone.items()
    }
    alone = list(cast.alone.values())
    every = _mean_over_agents(measure, np.stack([stage.values(lineup, measure) for lineup in alone]))
    every = replace(every, cut=stage.cut(alone))
    individual = Alone(every, ratio(stage, measure, alone, cast.expert))
    return Standing(measure, value, expert, ratio(stage, measure, [cast.ours], cast.expert), individual, agents)


def _where_known(stage: Stage, measure: Measure, lineup: Lineup | None) -> Interval | None:
    """A partial measure's mean over the episodes that it speaks of; None without any."""
    values = np.empty(0) if lineup is None else stage.values(lineup, measure)
    known = values[~np.isnan(values)]
    return interval(measures.estimate(measure, known)) if len(known) else None


def interval(estimate: Estimate) -> Interval:
    """An estimate as a plain number with its interval."""
    return Interval(estimate.value, *estimate.interval)


def ratio(stage: Stage, measure: Measure, ours: Sequence[Lineup], theirs: Lineup) -> Interval | None:
    """The mean over `ours` of the performance ratio to `theirs`, with the interval of a paired bootstrap over episodes.

    None where a ratio divides by zero; an end of the interval is infinite where that many samples do. A bootstrap
    cannot leave a share of 0 or 1, so there the interval is that of `_ratio_of_shares`, unless all did the same.
    """
    base = stage.values(theirs, measure).mean()
    means = [stage.values(lineup, measure).mean() for lineup in ours]
    points = [measures.ratio(measure, mean, base) for mean in means]
    known, cut = [point for point in points if point is not None], stage.cut([*ours, theirs])
    if len(known) < len(points):
        return None
    value, n = float(np.mean(known)), len(stage.seeds)
    if measure.share and {0.0, 1.0} & {base, *means} and not all(stage.plays_alike(each, theirs) for each in ours):
        shares, divisor = [Share(round(mean * n), n) for mean in means], Share(round(base * n), n)
        pairs = [(divisor, each) if measure.lower_is_better else (each, divisor) for each in shares]
        low, high = np.mean([_ratio_of_shares(*pair) for pair in pairs], axis=0).tolist()
        return Interval(value, low, high, cut)
    if n == 1:
        return Interval(value, -math.inf, math.inf, cut)
    divisor = stage.draws(theirs, measure)
    with np.errstate(divide="ignore", invalid="ignore"):
        drawn = np.mean([measures.quotient(measure, stage.draws(lineup, measure), divisor) for lineup in ours], axis=0)
    ordered = np.sort(drawn[~np.isnan(drawn)])  # a sample of 0 over 0 says nothing
    at = [round(share * (len(ordered) - 1)) for share in (0.025, 0.975)]  # no interpolation: an end may be infinite
    low, high = ordered[at].tolist()
    return Interval(value, low, high, cut)


def _ratio_of_shares(ours: Share, theirs: Share) -> tuple[float, float]:
    """The 95 % interval of the ratio of two shares, of which theirs is not 0, from their Wilson intervals (MOVER-R:
    Donner and Zou 2012, Newcombe 2016). It takes them for independent: shares over the same episodes are closer.
    """
    (p, (l1, u1)), (q, (l2, u2)) = (ours.value, ours.interval), (theirs.value, theirs.interval)
    low, high = l1 * (2 * p - l1), u1 * (2 * p - u1)
    least, most = l2 * (2 * q - l2), u2 * (2 * q - u2)
    # the lower end with its numerator made rational, as 2q - u2 may be 0
    below = low / (p * q + math.sqrt(max(0.0, (p * q) ** 2 - low * most))) if low else 0.0
    return below, (p * q + math.sqrt(max(0.0, (p * q) ** 2 - high * least))) / least


def _mean_over_agents(measure: Measure, values: Float64) -> Interval:
    """The mean of [n_agents, n] values. Shares over the same episodes spread no wider on average than one share does,
    so theirs is the interval of as many hits as there are on average.
    """
    if not measure.share:
        return interval(measures.estimate(measure, values.mean(axis=0)))
    agents, n = values.shape
    hits = int(values.sum())
    low, high = Share(hits // agents, n), Share(-(-hits // agents), n)
    return Interval(hits / values.size, low.interval[0], high.interval[1])


# --- how trees decide


@dataclass(frozen=True)
class TreeFacts:
    """One agent's tree at work. States are those of episodes in which all agents are the subject, or the expert."""

    leaves: int
    numbers: int | None  # that stand in its tests and leaves; None: each has one
    depth: int  # comparisons of the longest decision
    comparisons: Interval  # of a decision in its own states
    fidelity_own: Interval | None  # share of its own states in which it acts as the expert would
    fidelity_expert: Interval | None  # the same in the expert's states


def decisions(trees: Mapping[int, ir.AgentPolicy], episodes: Episodes, wanted: Int | None) -> Float64:
    """For each tree its mean comparisons per decision and how like its actions are to those `wanted`, or NaN,
    [2, n_trees, batch], over the steps in which its agent acts. `wanted`: as `Episodes.actions`.
    """
    facts = np.full((2, len(trees), episodes.actions.shape[1]), np.nan)
    for row, (agent, policy) in enumerate(trees.items()):
        seen = episodes.observations[agent]
        leaf, alive = ir.apply(policy.tree, seen.reshape(-1, seen.shape[-1])).reshape(seen.shape[:2]), episodes.alive
        steps = alive[..., agent].sum(axis=0)
        facts[0, row] = (ir.depth(policy.tree)[leaf] * alive[..., agent]).sum(axis=0) / steps
        if wanted is not None:
            flat = seen.reshape(-1, seen.shape[-1])
            acted = decide_at(policy, leaf.reshape(-1), flat)
            right = likeness(policy.outputs, acted.reshape(*leaf.shape, *acted.shape[1:]), wanted[:, :, agent])
            facts[1, row] = (right * alive[..., agent]).sum(axis=0) / steps
    return facts


def tree_facts(trees: Mapping[int, ir.AgentPolicy], own: Float64, expert: Float64 | None) -> dict[str, TreeFacts]:
    """Agent -> facts, from what `decisions` saw in the subject's own episodes and in the expert's, if there is one."""
    facts: dict[str, TreeFacts] = {}
    for row, policy in enumerate(trees.values()):
        depth = int(ir.depth(policy.tree).max())
        fidelity = (None, None) if expert is None else (_within(own[1, row], 1.0), _within(expert[1, row], 1.0))
        sizes = len(ir.leaves(policy.tree)), size(policy) if policy.tree.arithmetic else None
        facts[policy.agent] = TreeFacts(*sizes, depth, _within(own[0, row], depth), *fidelity)
    return facts


def _within(values: Float64, most: float) -> Interval:
    """The mean of one number an episode, none of which is outside 0 and `most`."""
    mean = interval(measures.estimate(Measure("", ""), values))
    return Interval(mean.value, max(mean.low, 0.0), min(mean.high, most))
