"""Deciding claims about episodes by zones: agents alone where that settles it, then with those whom they read.

Does: splits a claim into tasks, follows groups of agents, hands what a small group leaves open to the larger one.
Assumes: a claim and a profile that `rollout.playable` let pass.
Does not: sample the region (closed_loop.py) or step zones (unroll.py).

Whoever is not followed may do anything, so a small group leaves every start open that a larger one would: the larger
group needs to be followed only from the zones that are left.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from codegen import ir
from codegen.ir import Float64, PolicyProfile
from verify.batch import Start, Zones, closed, point_in, starts
from verify.episode_reading import Part
from verify.rollout import DEFAULT_ZONES, ClosedLoop, at_rest, first_failing, fulfilled, owned, play, playable
from verify.shares import SAMPLE_SEED
from verify.spec import Region, Verdict
from verify.unroll import Cut, Group, Search, away, ensure_exact, grouped, read_by, unmatched
from verify.world import Point, sample

MATCHING_SAMPLES = 2_000
PLAUSIBLE = 0.9  # of the sampled episodes; a matching that fits fewer is not tried agent by agent
TRIED_ZONES, TRIED_POINTS = 32, 4  # of a batch of failing zones, and of each of them
MOST_ROUNDS = 20  # batches of failing zones of a group in which real starts are looked for
MOST_LEFT = 200_000  # failing zones that are kept for the next group


@dataclass(frozen=True)
class Decision:
    """The verdict of the zones alone. `zones`: visited; `followed`: agents that were followed together for a proof."""

    verdict: Verdict
    zones: int
    reason: str = ""
    point: Point | None = None
    followed: tuple[tuple[str, ...], ...] = ()
    parts: tuple[Part, ...] = ()  # of a proved claim, what was proved by following whom, goal by goal


def decide(profile: PolicyProfile, claim: ClosedLoop, region: Region, budget: int = DEFAULT_ZONES) -> Decision:
    """The verdict by zones. InputError for worlds with contacts, and where rounding exceeds what proofs allow for."""
    playable(profile)
    places = [bound for name, bounds in region.box.items() if not name.endswith((".vx", ".vy")) for bound in bounds]
    ensure_exact(profile.world, claim.steps, max(map(abs, places)))
    parts = starts(region, profile.world)
    if not parts:
        return Decision(Verdict.VACUOUS, 0, "the region holds no start at rest")
    return _Decider(profile, claim, region, parts, budget).decision()


class _Violated(Exception):
    """A start was found that fails the claim."""

    def __init__(self, point: Point) -> None:
        super().__init__()
        self.point = point


@dataclass(frozen=True)
class _Task:
    """That some agents are where they should be: one agent at its landmark, or the team matched (landmark is "")."""

    agents: tuple[str, ...]
    landmark: str = ""


@dataclass(frozen=True)
class _Left:
    """What following a group left open: why, and the zones; None when they are not all known."""

    reason: str
    group: Group
    zones: Zones | None


class _Decider:
    """One decision: settled tasks are remembered, so goals that a group does not read count once."""

    def __init__(
        self, profile: PolicyProfile, claim: ClosedLoop, region: Region, parts: list[Start], budget: int
    ) -> None:
        self.profile, self.claim, self.region, self.parts, self.budget = profile, claim, region, parts, budget
        self.visited = 0
        self.team = tuple(policy.agent for policy in profile.team(claim.team))
        self.landmarks = [entity.name for entity in profile.world.landmarks]
        self.known: dict[tuple[_Task, str], _Left | None] = {}
        self.followed: list[tuple[str, ...]] = []
        self.shown: dict[Part, None] = {}

    def decision(self) -> Decision:
        """The verdict over all goals."""
        reasons: list[str] = []
        point = None
        try:
            for goal in self.region.goals or ("",):
                reasons += [f"goal {goal or 'none'}: {left.reason}" for left in self._for_goal(goal)]
        except _Violated as found:
            point = found.point
        verdict = Verdict.VIOLATED if point else Verdict.UNKNOWN if reasons else Verdict.PROVED
        reason = "" if point else "; ".join(dict.fromkeys(reasons))
        followed = tuple(dict.fromkeys(self.followed)) if verdict is Verdict.PROVED else ()
        parts = tuple(self.shown) if verdict is Verdict.PROVED else ()
        return Decision(verdict, self.visited, reason, point, followed, parts)

    def _for_goal(self, goal: str) -> list[_Left]:
        """What is open for one goal; nothing when the claim is proved."""
        matchings = owned(self.profile, self.claim)
        own = matchings[0] if len(matchings) == 1 else self._plausible(goal)
        found: list[_Left] | None = None
        if own is not None:
            tasks = [_Task((agent,), self.landmarks[number]) for agent, number in zip(self.team, own, strict=True)]
            found = [left for task in tasks if (left := self._task(task, goal))]
            if not found or len(matchings) == 1:
                return found
        left = self._attempt(_Task(self.team), self.team, goal, self._left(), found)
        return [left] if left else []

    def _plausible(self, goal: str) -> tuple[int, ...] | None:
        """The matching that most sampled episodes with this goal end in, if nearly all do."""
        where = at_rest(replace(self.region, goals=(goal,) if goal else ()))
        coordinates, _ = sample(where, self.profile.world, MATCHING_SAMPLES, SAMPLE_SEED)
        course, _ = play(self.profile, coordinates, self.claim.steps)
        shares = {
            own: float(
                fulfilled(
                    self.profile, replace(self.claim, landmarks=tuple(self.landmarks[k] for k in own)), course
                ).mean()
            )
            for own in owned(self.profile, self.claim)
            if len(coordinates)
        }
        best = max(shares, key=lambda own: shares[own], default=None)
        return best if best is not None and shares[best] >= PLAUSIBLE else None

    def _left(self) -> int:
        return max(0, self.budget - self.visited)

    def _task(self, task: _Task, goal: str) -> _Left | None:
        """What is open of a task; None when it is proved. Raises _Violated."""
        together = self._closure(task.agents)
        key = (task, goal if any(ir.GOAL in read_by(self.profile.policy(agent)) for agent in together) else "")
        if key not in self.known:
            left: _Left | None = None
            for agents in dict.fromkeys((task.agents, together)):
                budget = self._left() if agents == together else self._left() // 4
                left = self._attempt(task, agents, goal, budget, [left] if left else None)
                if left is None:
                    break
            self.known[key] = left
        return self.known[key]

    def _closure(self, agents: Sequence[str]) -> tuple[str, ...]:
        """The agents with the team-mates whom they read, and whom those read."""
        found = set(agents)
        while True:
            read = frozenset().union(*(read_by(self.profile.policy(agent)) for agent in found))
            more = found | (read & set(self.team))
            if more == found:
                return tuple(agent for agent in self.team if agent in found)
            found = more

    def _attempt(
        self, task: _Task, agents: tuple[str, ...], goal: str, budget: int, before: Sequence[_Left] | None
    ) -> _Left | None:
        """Follows a group from what is left `before`, or from the whole region; None when the task is proved."""
        claimed = [task.landmark] if task.landmark else self.landmarks
        group = grouped(self.profile, agents, goal, claimed)
        search = Search(group, self.claim.steps, self._cut(task, group), budget)
        kept: list[Zones] = []
        failing = partial(self._failing, group, goal, kept)
        try:
            ended = search.run(self._first(group, before), failing)
        finally:
            self.visited += search.visited
        if ended and not kept:
            self.followed.append(agents)
            agent = task.agents[0] if task.landmark else ""
            about = goal if any(ir.GOAL in read_by(self.profile.policy(one)) for one in agents) else ""
            self.shown[Part(agent, task.landmark, about, agents, b"")] = None
            return None
        who = " with ".join(agents)
        if not ended:
            spent = f"more than the budget of {self.budget:,} zones is needed ({self.visited:,} were visited)"
            return _Left(f"{who}: {spent}; a larger --zones may answer", group, None)
        zones = Zones.joined(kept)
        return _Left(
            f"{who}: {zones.count:,} zones are left in which the claim may fail, with other opponents or between "
            "float64 starts; no start from which this profile fails was found",
            group,
            zones if zones.count <= MOST_LEFT else None,
        )

    def _cut(self, task: _Task, group: Group) -> Cut:
        def cut(zones: Zones, step: int) -> Zones:
            if self.claim.name == "covers" and step < self.claim.steps:
                return zones
            if task.landmark:
                return away(zones, group, task.agents[0], task.landmark, self.claim.radius)
            return unmatched(zones, group, self.landmarks, self.claim.radius)

        return cut

    def _first(self, group: Group, before: Sequence[_Left] | None) -> Zones:
        whole = np.array([part.projected(group.entities) for part in self.parts])
        bounds, origin = whole, np.arange(len(whole))
        if before and all(left.zones is not None for left in before):
            found = [left.zones for left in before if left.zones is not None]
            origin = np.concatenate([zones.origin for zones in found])
            nodes = [[0, *(group.node(name) for name in left.group.entities)] for left in before]
            bounds = np.concatenate(
                [closed(whole[zones.origin], zones.bounds, place) for zones, place in zip(found, nodes, strict=True)]
            )
        return Zones.at_start(bounds, origin, len(group.agents), group.tests)

    def _failing(self, group: Group, goal: str, kept: list[Zones], zones: Zones) -> None:
        """Keeps zones that may fail, and looks for a real start in the first ones. Raises _Violated."""
        if len(kept) < MOST_ROUNDS:
            candidates = list(self._points(group, goal, zones))
            point = first_failing(self.profile, self.claim, self.region, candidates)
            if point is not None:
                raise _Violated(point)
        kept.append(zones)

    def _points(self, group: Group, goal: str, zones: Zones) -> Iterator[Point]:
        """Float64 points of some zones, the middle of each first."""
        rng = np.random.default_rng(SAMPLE_SEED)
        still = {name: 0.0 for name in self.region.box if name.endswith((".vx", ".vy"))}
        for row in np.unique(np.linspace(0, zones.count - 1, TRIED_ZONES).astype(int)):
            start = self.parts[int(zones.origin[row])]
            for trial in range(TRIED_POINTS):
                shape = (2, len(start.names))
                share: Float64 = rng.uniform(0, 1, shape) if trial else np.full(shape, 0.5)
                position = point_in(start, group.entities, zones.bounds[row], share)
                if position is not None:
                    position |= still
                    yield Point({name: position[name] for name in self.region.box}, goal)
