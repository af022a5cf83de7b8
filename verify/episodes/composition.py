"""Compositional proof by zones: each agent alone, then with the agents it observes, then all agents.

Does: splits a claim into tasks, follows groups of agents, keeps the part of each zone that may still violate the claim,
  hands what a small group leaves open to the larger one.
Assumes: a claim and a profile that `states.episodes.playable` lets pass.
Does not: sample the region (verdicts/episodes.py) or step zones (unroll.py).

Whoever is not followed may do anything, so a small group leaves every start open that a larger one would: the larger
group needs to be followed only from the smallest zone around those that are left: they overlap, and one zone soon
costs less than many. A proof that follows opponents is one about these opponents; it comes last, and only where a tree
reads them or contacts may push.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import partial
from itertools import product

import numpy as np

from codegen import ir
from codegen.dynamics import partners
from codegen.ir import Bool, Float64
from verify.checker.episodes.certificates import ProofPart
from verify.claims.claim import read_by
from verify.claims.episodes import EpisodeClaim
from verify.claims.region import goal_text
from verify.episodes.contacts import Pair, colliders, travels
from verify.episodes.unroll import EpisodeSearch, Group, build_group, ensure_exact, strides
from verify.episodes.zones import (
    GRID_SLACK,
    SCALE,
    Int64,
    Start,
    Zones,
    constrain_zones,
    hulls,
    intersect,
    narrow_start,
    point_in,
    starts,
)
from verify.question import EpisodeQuestion
from verify.result import Verdict
from verify.spending import tell_of_goal
from verify.states.episodes import at_rest, find_matchings, find_met_ways, first_failing, name_pairs, play, playable
from verify.states.shares import SAMPLE_SEED
from verify.states.state import State, sample
from verify.states.values import has_matching
from verify.zones.tables import BeyondZonesError


def away(zones: Zones, group: Group, agent: str, landmark: str, radius: Fraction) -> Zones:
    """The parts in which an agent may be farther than `radius` from a landmark. No start twice, but on common edges."""
    return _split_by_arrival(zones, _Target(group, agent, landmark, radius))[0]


class _Target:
    """An agent's arrival at a landmark."""

    def __init__(self, group: Group, agent: str, landmark: str, radius: Fraction) -> None:
        self._mover, self._ends = group.agents.index(agent), (group.node(agent), group.node(landmark))
        self._near = int(radius * SCALE // 1) - GRID_SLACK  # arrived for sure up to here

    def sides(self, zones: Zones) -> list[tuple[int, int, int, Int64]]:
        """(axis, p, q, limit [n]) for the four sides: who has start(p) - start(q) <= limit on all has arrived."""
        (p, q), limits = self._ends, list[tuple[int, int, int, Int64]]()
        for axis in range(2):
            least, most = zones.offsets(slice(None), self._mover, axis)
            limits += [(axis, p, q, self._near - most), (axis, q, p, self._near + least)]
        return limits

    def possible(self, zones: Zones) -> Bool:
        """Zones of which some part has arrived for sure, [n]."""
        arrives = np.ones(zones.count, dtype=bool)
        limits: list[Int64] = []
        for axis, p, q, limit in self.sides(zones):
            arrives &= limit > -zones.bounds[:, axis, q, p]
            limits.append(limit)
        # contacts may leave open more than the radius
        return arrives & (limits[0] + limits[1] > 0) & (limits[2] + limits[3] > 0)


def _split_by_arrival(zones: Zones, target: _Target) -> tuple[Zones, Zones]:
    """The parts in which the agent may be away, and those in which it has arrived for sure. Zones in which it cannot
    have arrived stay whole.
    """
    possible = target.possible(zones)
    if not possible.any():
        return zones, zones.take(slice(0))
    parts = [zones.take(~possible)]
    zones = zones.take(possible)
    for number in range(4):
        axis, p, q, limit = target.sides(zones)[number]
        # one unit of room: starts on the edge itself have arrived, and edges of edges would never end
        rows, bounds = constrain_zones(zones.bounds, axis, q, p, -limit, room=1)
        parts.append(zones.part(rows, bounds))
        zones = zones.part(*constrain_zones(zones.bounds, axis, p, q, limit))
    return Zones.join(parts), zones


def find_unmatched(
    zones: Zones, group: Group, agents: Sequence[str], landmarks: Sequence[str], radius: Fraction
) -> Zones:
    """The parts in which these agents of the group may not be matched to the landmarks. No start twice but on edges."""
    targets = [[_Target(group, agent, landmark, radius) for landmark in landmarks] for agent in agents]
    pairs = list(product(range(len(agents)), range(len(landmarks))))
    waiting, unmatchable = [(zones, np.zeros((len(agents), len(landmarks)), dtype=bool), 0)], [zones.take(slice(0))]
    while waiting:
        zones, arrived, asked = waiting.pop()
        if not zones.count or has_matching(arrived):
            continue
        may = np.repeat(arrived[None], zones.count, axis=0)
        for agent, landmark in pairs[asked:]:
            may[:, agent, landmark] = targets[agent][landmark].possible(zones)
        matchable = has_matching(may)
        unmatchable.append(zones.take(~matchable))
        if matchable.any():
            apart, near = _split_by_arrival(zones.take(matchable), targets[pairs[asked][0]][pairs[asked][1]])
            also = arrived.copy()
            also[pairs[asked]] = True
            waiting += [(apart, arrived, asked + 1), (near, also, asked + 1)]
    return Zones.join(unmatchable)


def too_near(zones: Zones, group: Group, a: str, b: str, radius: Fraction, step: int) -> tuple[Zones, Zones]:
    """The parts in which two entities are for sure at least `radius` apart on some axis, and those where they may be
    nearer.
    """
    pair = Pair(group.bodies[a], group.bodies[b], within=-int(-radius * SCALE // 1))
    apart, near = pair.split_apart(zones, step)
    return Zones.join(apart), near


MATCHING_SAMPLES = 2_000
PLAUSIBLE = 0.9  # of the sampled episodes; a matching that fits fewer is not tried agent by agent
TRIED_ZONES, TRIED_POINTS = 32, 4  # of a batch of failing zones, and of each of them
MAX_ROUNDS = 20  # batches of failing zones of a group in which real starts are looked for
SPENT = "more than the budget of {:,} zones is needed ({:,} were visited); a larger --effort may answer"
UNDECIDED = (
    "{:,} zones are undecided: the claim may fail there for other opponents, or at starts that are not float64{}; no "
    "start from which this profile fails was found; fewer --steps or a smaller region may be decided"
)
PUSHED = ", or in contacts, which are over-approximated"
MAX_LEFT = 200_000  # failing zones that are kept for the next group


@dataclass(frozen=True)
class ZonesDecision:
    """The verdict of the zones alone. `zones`: visited; `followed`: agents that were followed together for a proof."""

    verdict: Verdict
    zones: int
    reason: str = ""
    state: State | None = None
    followed: tuple[tuple[str, ...], ...] = ()
    parts: tuple[ProofPart, ...] = ()  # of a proved claim, what was proved by following whom, goal by goal
    touched: int = 0  # zones in which contacts are known between bounds only
    given_up: int = 0  # of these, the ones in which somebody's place was no longer known well enough to go on


def decide(question: EpisodeQuestion) -> ZonesDecision:
    """The verdict by zones. InputError where rounding exceeds what proofs allow for."""
    profile, claim, region = question.profile, question.claim, question.region
    playable(profile)
    claim.ensure(profile)
    places = [bound for name, bounds in region.box.items() if not name.endswith((".vx", ".vy")) for bound in bounds]
    ensure_exact(profile.world, claim.steps, max(map(abs, places)), max(strides(profile).values()))
    parts = starts(region, profile.world)
    if not parts:
        return ZonesDecision(Verdict.VACUOUS, 0, "the region holds no start at rest")
    try:
        return _Decider(question, parts).decision()
    except BeyondZonesError as error:
        return ZonesDecision(Verdict.UNKNOWN, 0, f"zones cannot follow this team: {error}")


class _Violated(Exception):
    """A start was found that fails the claim."""

    def __init__(self, state: State) -> None:
        super().__init__()
        self.state = state


class _Open(Exception):
    """A group leaves zones open, and a larger one is followed next."""


@dataclass(frozen=True)
class _Task:
    """A task of some agents of the team."""

    agents: tuple[str, ...]
    pairs: tuple[tuple[str, str], ...] = field(default=(), kw_only=True)  # that are to keep apart

    def entities(self, landmarks: Sequence[str]) -> list[str]:
        """Of whom it speaks, besides its agents. `landmarks`: all of the world."""
        return list(landmarks)

    @property
    def part(self) -> tuple[str, str]:
        """Its names in a certificate: an agent and a mark, or "" for both where it is about all of them."""
        return "", ""

    def open(self, zones: Zones, group: Group, claim: EpisodeClaim, landmarks: Sequence[str]) -> Zones:
        """The part of zones in which it is not yet done: agents and landmarks are not matched one-to-one."""
        return find_unmatched(zones, group, self.agents, landmarks, claim.radius)


@dataclass(frozen=True)
class _Arrive(_Task):
    """That one agent comes near its landmark."""

    landmark: str

    def entities(self, landmarks: Sequence[str]) -> list[str]:
        """The landmark."""
        return [self.landmark]

    @property
    def part(self) -> tuple[str, str]:
        """The agent and its landmark."""
        return self.agents[0], self.landmark

    def open(self, zones: Zones, group: Group, claim: EpisodeClaim, landmarks: Sequence[str]) -> Zones:
        """Where the agent is away from its landmark."""
        return away(zones, group, self.agents[0], self.landmark, claim.radius)


@dataclass(frozen=True)
class _Apart(_Task):
    """That pairs keep apart, at every step."""

    def entities(self, landmarks: Sequence[str]) -> list[str]:
        """Both of each pair."""
        return [name for pair in self.pairs for name in pair]

    @property
    def part(self) -> tuple[str, str]:
        """The pair, where it is one."""
        return self.pairs[0] if len(self.pairs) == 1 else ("", "")


@dataclass(frozen=True)
class _Left:
    """The part that following a group left open: why, and the zones; None when they are not all known."""

    reason: str
    task: _Task
    group: Group
    zones: Zones | None


class _Decider:
    """One decision: settled tasks are remembered, so goals that a group does not read count once."""

    def __init__(self, question: EpisodeQuestion, parts: list[Start]) -> None:
        profile, claim = question.profile, question.claim
        self.question, self.profile, self.claim, self.region = question, profile, claim, question.region
        self.parts, self.budget = parts, question.budgets.max_zones
        self.visited = self.touched = self.given_up = 0
        self.team = tuple(policy.agent for policy in profile.team(claim.team))
        self.landmarks = [entity.name for entity in profile.world.landmarks]
        self.known: dict[tuple[_Task, str | None], _Left | None] = {}
        self.followed: list[tuple[str, ...]] = []
        self.shown: dict[ProofPart, None] = {}
        needed = claim.apart or partners(profile.world)
        self.travel: Mapping[str, Int64] = (
            travels(profile.world, strides(profile), parts, claim.steps) if needed else {}
        )

    def decision(self) -> ZonesDecision:
        """The verdict over all goals."""
        reasons: list[str] = []
        state = None
        try:
            for goal in self.question.goals:
                reasons += [tell_of_goal(goal, left.reason) for left in self._for_goal(goal)]
        except _Violated as found:
            state = found.state
        verdict = Verdict.VIOLATED if state else Verdict.UNKNOWN if reasons else Verdict.PROVED
        reason = "" if state else "; ".join(dict.fromkeys(reasons))
        followed = tuple(dict.fromkeys(self.followed)) if verdict is Verdict.PROVED else ()
        parts = tuple(self.shown) if verdict is Verdict.PROVED else ()
        return ZonesDecision(verdict, self.visited, reason, state, followed, parts, self.touched, self.given_up)

    def _for_goal(self, goal: str | None) -> list[_Left]:
        """Returns what is open for one goal; nothing when the claim is proved."""
        if self.claim.apart:
            return self._decide_apart(goal)
        matchings = find_matchings(self.profile, self.claim)
        own = matchings[0] if len(matchings) == 1 else self._plausible(goal)
        open_tasks: list[_Left] | None = None
        if own is not None:
            tasks = [_Arrive((agent,), self.landmarks[number]) for agent, number in zip(self.team, own, strict=True)]
            open_tasks = [left for task in tasks if (left := self._task(task, goal))]
            if not open_tasks:
                return []
            if len(matchings) == 1:
                last = [self._last(left, goal) for left in open_tasks]
                return [left for left in last if left]
        left = self._last(self._attempt(_Task(self.team), self.team, goal, self._count_left(), open_tasks), goal)
        return [left] if left else []

    def _decide_apart(self, goal: str | None) -> list[_Left]:
        """Returns what is open of pairs that keep apart: each alone, then all those left together."""
        (pairs,) = name_pairs(self.profile, self.claim)
        tasks = [_Apart(tuple(name for name in pair if name in self.team), pairs=(pair,)) for pair in pairs]
        open_tasks = [left for task in tasks if (left := self._task(task, goal))]
        if not open_tasks:
            return []
        open_pairs = tuple(pair for left in open_tasks for pair in left.task.pairs)
        alone = len(open_tasks) == 1 and open_tasks[0].group.agents == self.team
        task = _Apart(self.team, pairs=open_pairs)
        left = open_tasks[0] if alone else self._attempt(task, self.team, goal, self._count_left(), open_tasks)
        left = self._last(left, goal)
        return [left] if left else []

    def _last(self, left: _Left | None, goal: str | None) -> _Left | None:
        """Returns what is open with the whole profile followed too, where that may settle what a smaller group left."""
        if left is None or left.zones is None or not self._count_left():
            return left
        agents, everybody = left.group.agents, tuple(policy.agent for policy in self.profile.agents)
        read = frozenset[str]().union(*(read_by(self.profile.policy(agent)) for agent in agents))
        named = frozenset(name for pair in left.task.pairs for name in pair)
        if not (read | named | colliders(self.profile.world, agents)) & set(everybody) - set(agents):
            return left
        return self._attempt(left.task, everybody, goal, self._count_left(), [left])

    def _plausible(self, goal: str | None) -> tuple[int, ...] | None:
        """The matching that most sampled episodes with this goal end in, if nearly all do."""
        where = at_rest(replace(self.region, goals=() if goal is None else (goal,)))
        coordinates, _ = sample(where, self.profile.world, MATCHING_SAMPLES, SAMPLE_SEED)
        episode, _ = play(self.profile, coordinates, self.claim.steps)
        if not len(coordinates):
            return None
        met = find_met_ways(self.profile, self.claim, episode)
        shares = {
            own: float(each.mean()) for own, each in zip(find_matchings(self.profile, self.claim), met, strict=True)
        }
        best = max(shares, key=lambda own: shares[own])
        return best if shares[best] >= PLAUSIBLE else None

    def _count_left(self) -> int:
        return max(0, self.budget - self.visited)

    def _task(self, task: _Task, goal: str | None) -> _Left | None:
        """Returns what is open of a task; None when it is proved. Raises _Violated."""
        together = self._closure(task.agents)
        key = task, self._goal_read(together, goal)
        if key not in self.known:
            left: _Left | None = None
            groups = dict.fromkeys((task.agents, together))
            if task.pairs and together == self.team and len(groups) > 1:
                del groups[together]  # followed once for all pairs
            for agents in groups:
                budget = self._count_left() if agents == together else self._count_left() // 4
                left = self._attempt(task, agents, goal, budget, [left] if left else None, agents != together)
                if left is None:
                    break
            self.known[key] = left
        return self.known[key]

    def _closure(self, agents: Sequence[str]) -> tuple[str, ...]:
        """The agents with the team-mates whom they read or may touch, and so on."""
        members = set(agents)
        while True:
            read = frozenset[str]().union(*(read_by(self.profile.policy(agent)) for agent in members))
            more = members | ((read | colliders(self.profile.world, tuple(members))) & set(self.team))
            if more == members:
                return tuple(agent for agent in self.team if agent in members)
            members = more

    def _attempt(
        self, task: _Task, agents: tuple[str, ...], goal: str | None, budget: int, before: Sequence[_Left] | None,
        brief: bool = False,
    ) -> _Left | None:  # fmt: skip
        """Follows a group from what is left `before`, or from the whole region; None when the task is proved.

        `brief`: the first zones left end it, as a larger group is followed next.
        """
        group = build_group(self.profile, agents, goal, task.entities(self.landmarks), self.travel)
        kept: list[Zones] = []
        failing = partial(self._failing, group, goal, kept, brief)
        search = EpisodeSearch(group, self.claim.steps, partial(self._cut, task, group, failing), budget)
        try:
            ended = search.run(self._first(group, before), failing)
        except _Open:
            return _Left("", task, group, None)
        finally:
            self.visited += search.visited
            self.touched += search.touched
            self.given_up += search.given_up
        if ended and not kept:
            self.followed.append(agents)
            self.shown[ProofPart(*task.part, goal_text(self._goal_read(agents, goal)), agents, b"")] = None
            return None
        who = " with ".join(group.agents)
        if not ended:
            return _Left(f"{who}: {SPENT.format(self.budget, self.visited)}", task, group, None)
        zones = Zones.join(kept)
        reason = UNDECIDED.format(zones.count, PUSHED if search.touched else "")
        return _Left(f"{who}: {reason}", task, group, zones if zones.count <= MAX_LEFT else None)

    def _goal_read(self, agents: Sequence[str], goal: str | None) -> str | None:
        """The goal, where one of the agents reads it."""
        return goal if any(ir.GOAL in read_by(self.profile.policy(agent)) for agent in agents) else None

    def _cut(self, task: _Task, group: Group, failing: Callable[[Zones], None], zones: Zones, step: int) -> Zones:
        """The parts of zones in which the claim may still fail after a step."""
        for pair in task.pairs:
            zones, near = too_near(zones, group, *pair, self.claim.radius, step)
            if near.count:
                failing(near)
        if task.pairs:
            return zones.take(slice(0)) if step == self.claim.steps else zones
        if not self.claim.always and step < self.claim.steps:
            return zones
        return task.open(zones, group, self.claim, self.landmarks)

    def _first(self, group: Group, before: Sequence[_Left] | None) -> Zones:
        whole = np.array([part.project(group.entities) for part in self.parts])
        bounds, origin = whole, np.arange(len(whole))
        if before and all(left.zones is not None for left in before):
            parts = [left.zones for left in before if left.zones is not None]
            origin = np.concatenate([zones.origin for zones in parts])
            nodes = [[0, *(group.node(name) for name in left.group.entities)] for left in before]
            bounds = np.concatenate(
                [intersect(whole[zones.origin], zones.bounds, place) for zones, place in zip(parts, nodes, strict=True)]
            )
            bounds, origin = hulls(bounds, origin)
        return Zones.at_start(bounds, origin, len(group.agents), group.tests, group.contacts is not None)

    def _failing(self, group: Group, goal: str | None, kept: list[Zones], brief: bool, zones: Zones) -> None:
        """Keeps zones that may fail, and looks for a real start in the first ones. Raises _Violated, _Open."""
        if len(kept) < MAX_ROUNDS:
            points = list[State]()  # of some zones, the middle of each first
            rng = np.random.default_rng(SAMPLE_SEED)
            still = {name: 0.0 for name in self.region.box if name.endswith((".vx", ".vy"))}
            for row in np.unique(np.linspace(0, zones.count - 1, TRIED_ZONES).astype(int)):
                origin = self.parts[int(zones.origin[row])]
                start = narrow_start(origin, group.entities, zones.bounds[row])
                for trial in range(TRIED_POINTS):
                    shape = (2, len(origin.names))
                    share: Float64 = rng.uniform(0, 1, shape) if trial else np.full(shape, 0.5)
                    if start is not None:
                        position = point_in(start, share) | still
                        points.append(State({name: position[name] for name in self.region.box}, goal))
            state = first_failing(self.question, points)
            if state is not None:
                raise _Violated(state)
        if brief:
            raise _Open
        kept.append(zones)
