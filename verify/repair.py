"""Repairs of a team: leaves from which a claim can fail are guarded until it is proved.

Does: finds the cheapest guard of a node, a small tree that keeps an agent engaged with one landmark wherever the node
  decides, for all claims about the agent, with tests on its own offset to it, by dynamic programming over the
  rectangles of a grid; gives each agent a landmark of its own, guards the leaves that counterexamples of the zone
  engine end in, or the splits above them where trees would get too deep; takes back guards that no proof needs.
Assumes: claims about matchings between a team and the landmarks; agents that observe their offsets to the landmarks on
  both axes; a radius above the margin.
Does not: give a verdict (verdicts/decisions.py decides anew, with both engines), measure play, write files.

A rectangle of offsets is safe for an action iff its points on which the action does not close all lie at the landmark.
Intervals are the exact ones of the deployed arithmetic, taken closed, so that safe here means safe there. A guard keeps
its agent engaged with the agent's landmark, so no leaf below it is met again and the search ends.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import product
from typing import NamedTuple, TypeAlias

import numpy as np

from codegen import ir
from codegen.boxes import box_of, leaves_below, upwards
from codegen.errors import InputError
from codegen.ir import NO_FEATURE, ActionSpec, AgentPolicy, Float64, Floats, Int32, PolicyProfile, Tree
from codegen.lowering.passes import difference, graft_parts
from codegen.numbers import round_down
from codegen.observe import observe
from codegen.paths import in_preorder
from verify.checker.thresholds import sides
from verify.claims.decisions import DecisionClaim, DistinctTargets, OwnTarget, engages
from verify.claims.formula import TRUE, Linear, for_goal, holds
from verify.claims.region import Interval, Region
from verify.question import AnyClaim, DecisionQuestion
from verify.result import Verdict
from verify.spending import tell
from verify.states.state import sample
from verify.zones import engine

PRICE = 1e-3  # of a further leaf, in shares of states whose action changes
UNLIMITED = -1  # levels
SMALLEST = float(np.finfo(np.float32).tiny)  # of the normal numbers; smaller thresholds are refused


class GuardCost(NamedTuple):
    """The cost of a guard: changed weight with the price of its leaves, then the progress that is lost."""

    price: float
    lost: float

    def __add__(self, other: "GuardCost") -> "GuardCost":  # type: ignore[override]
        return GuardCost(self.price + other.price, self.lost + other.lost)


@dataclass(frozen=True)
class Guard:
    """The tree that stands in the place of a node, and of all below it."""

    agent: str
    node: int  # of the tree before: a leaf, unless the depth asked for one of the splits above
    landmark: str
    tree: Tree
    changed: float  # share of the weighted states in which the action changes
    levels: int  # splits on its longest path


class Post(NamedTuple):
    """The purpose of a guard: a node, and the landmark with which its agent is to stay engaged."""

    policy: AgentPolicy
    node: int
    landmark: str


@dataclass(frozen=True)
class Seen:
    """States to weigh by, as one agent observes them."""

    rows: Floats  # [n, n_features]
    weight: Float64  # [n], of sum 1
    leaf: Int32  # [n] of the tree before


def offset_features(policy: AgentPolicy, landmark: str) -> tuple[int, int]:
    """The features that are the landmark's offset from the agent on x and y. InputError when it has none."""
    columns: list[int] = []
    for axis in "xy":
        wanted = {(1, f"{landmark}.{axis}"), (-1, f"{policy.agent}.{axis}")}
        for place, feature in enumerate(policy.features):
            meaning = feature.meaning
            if meaning is not None and not meaning.function and set(meaning.terms) == wanted:
                columns.append(place)
                break
        else:
            what = f"{policy.agent} does not observe its offset to {landmark} on {axis}"
            raise InputError(what, "", "guards test that offset: repair a team that observes it")
    return columns[0], columns[1]


def guard(asked: Sequence[DecisionQuestion], post: Post, seen: Seen, max_levels: int | None = None) -> Guard | None:
    """The cheapest guard of a node for a landmark, for all of some questions, at most `max_levels` deep; None when
    there is none.
    """
    return _Grid(asked, post, seen).cheapest(max_levels)


class _Action(NamedTuple):
    """An action: its effect, and the push along one axis alone by which it may close."""

    number: int
    effect: tuple[float, float]
    pushed: tuple[float, float]

    @classmethod
    def of(cls, number: int, action: ActionSpec) -> "_Action":
        effect = action.effect or (0.0, 0.0)
        return cls(number, effect, effect if 0 in effect else (0.0, 0.0))


class _Grid:
    """The offsets to one landmark that reach a node, cut where closing or being near begins and ends."""

    def __init__(self, asked: Sequence[DecisionQuestion], post: Post, seen: Seen) -> None:
        policy, node, landmark = post
        self._policy, self._node, self._landmark = policy, node, landmark
        self._features, self._semantics = offset_features(policy, landmark), asked[0].semantics
        self._claims = [question.claim for question in asked]
        box, drawn = box_of(policy.tree, node), sorted({line for claim in self._claims for line in _lines(claim)})
        self._lines: list[list[float]] = []
        self._ends: list[list[list[Fraction]]] = []  # by axis and claim, whose region has ends of its own
        for axis, feature in zip("xy", self._features, strict=True):
            below, above = box.low.get(feature), box.high.get(feature)
            least, most = (-np.inf if below is None else below), (np.inf if above is None else above)
            lines = [line for line in drawn if least < line < most]
            inner = [self._end(feature, line) for line in lines]
            self._lines.append(lines)
            self._ends.append([])
            for question in asked:
                low, high = _reach(question.region, policy.agent, landmark, axis)
                first = low if below is None else max(low, self._end(feature, below))
                last = high if above is None else min(high, self._end(feature, above))
                self._ends[-1].append([first, *inner, last])
        self._known: dict[tuple[_Cells, int], tuple[GuardCost, _Node] | None] = {}
        self._sides: dict[tuple[int, int, tuple[int, ...], float], tuple[bool, bool] | None] = {}
        self._alone: dict[_Cells, list[tuple[GuardCost, _Node]]] = {}  # leaves of a rectangle, however deep it lies
        below = leaves_below(policy.tree, node)
        here = np.isin(seen.leaf, below)
        self._weights, self._sums = self._sum_cells(seen.rows[here], seen.weight[here])
        acted = policy.tree.action[seen.leaf]
        self._kept = {  # action -> the weight in each cell of states that it is taken in
            int(action): self._sum_cells(seen.rows[here & (acted == action)], seen.weight[here & (acted == action)])[0]
            for action in np.unique(policy.tree.action[below])
        }
        actions = [_Action.of(number, action) for number, action in enumerate(policy.actions)]
        self._actions = sorted(actions, key=lambda action: action.number not in self._kept)  # those taken there first

    def cheapest(self, max_levels: int | None) -> Guard | None:
        """See `guard`."""
        levels = UNLIMITED if max_levels is None else max(0, max_levels)
        best = self._best((0, len(self._lines[0]) + 1, 0, len(self._lines[1]) + 1), levels)
        if best is None:
            return None
        tree = in_preorder(best[1], lambda node: node, self._policy.numbers)
        leaves = int((tree.feature == NO_FEATURE).sum())
        changed = best[0].price - PRICE * (leaves - 1)
        return Guard(self._policy.agent, self._node, self._landmark, tree, max(0.0, changed), _levels(best[1]))

    def _best(self, cells: "_Cells", levels: int) -> "tuple[GuardCost, _Node] | None":
        """Cost and tree for the cells from x0 up to x1 and y0 up to y1."""
        if (cells, levels) not in self._known:
            if cells not in self._alone:
                self._alone[cells] = list(self._leaves(cells))
            options = [*self._alone[cells], *self._splits(cells, levels)]
            self._known[cells, levels] = min(options, key=lambda item: item[0]) if options else None
        return self._known[cells, levels]

    def _leaves(self, cells: "_Cells") -> "Iterator[tuple[GuardCost, _Node]]":
        safe = [action for action in self._actions if self._safe(action.pushed, cells)]
        if not safe:
            return
        x0, x1, y0, y1 = cells
        weight, *sums = (float(table[x0:x1, y0:y1].sum()) for table in (self._weights, *self._sums))
        for action in safe:
            ahead = sum(part * total for part, total in zip(action.effect, sums, strict=True))
            kept = float(self._kept[action.number][x0:x1, y0:y1].sum()) if action.number in self._kept else 0.0
            yield GuardCost(weight - kept, -ahead), action.number

    def _splits(self, cells: "_Cells", levels: int) -> "Iterator[tuple[GuardCost, _Node]]":
        if not levels:
            return
        x0, x1, y0, y1 = cells
        further = levels - 1 if levels > 0 else levels
        cuts = [(0, cut, (x0, cut, y0, y1), (cut, x1, y0, y1)) for cut in range(x0 + 1, x1)]
        cuts += [(1, cut, (x0, x1, y0, cut), (x0, x1, cut, y1)) for cut in range(y0 + 1, y1)]
        for axis, cut, below, above in cuts:
            left = self._best(below, further)
            right = self._best(above, further) if left is not None else None
            if left is not None and right is not None:
                test = self._features[axis], self._lines[axis][cut - 1]
                yield left[0] + right[0] + GuardCost(PRICE, 0.0), (*test, left[1], right[1])

    def _safe(self, pushed: tuple[float, float], cells: "_Cells") -> bool:
        """Returns True if an action that pushes so keeps the agent engaged, by each claim, in all of a rectangle."""
        return all(self._keeps(claim, pushed, cells) for claim in range(len(self._claims)))

    def _keeps(self, claim: int, pushed: tuple[float, float], cells: "_Cells") -> bool:
        on_x, on_y = self._side(claim, 0, cells[:2], pushed[0]), self._side(claim, 1, cells[2:], pushed[1])
        if on_x is None or on_y is None:
            return True  # no state of the region is there
        return on_x[0] or on_y[0] or (on_x[1] and on_y[1])

    def _side(self, claim: int, axis: int, span: tuple[int, ...], push: float) -> tuple[bool, bool] | None:
        """Of one side of a rectangle: whether the push closes in all of it, and whether all where it does not is
        near. None where no state of the claim's region is there.
        """
        key = claim, axis, span, push
        if key not in self._sides:
            low, high = (self._ends[axis][claim][end] for end in span)
            self._sides[key] = None if low > high else _decide_engaged(self._claims[claim], low, high, Fraction(push))
        return self._sides[key]

    def _end(self, feature: int, threshold: float) -> Fraction:
        """Where the left side of a test ends, as an exact offset."""
        left = sides(self._policy.features[feature], threshold, self._policy.numbers, self._semantics)[0]
        assert isinstance(left, Linear), left
        return left.bound

    def _sum_cells(self, rows: Floats, weight: Float64) -> tuple[Float64, tuple[Float64, Float64]]:
        """Weight of the states in each cell, and their weighted sums of both offsets."""
        shape = (len(self._lines[0]) + 1, len(self._lines[1]) + 1)
        offsets = [rows[:, feature] for feature in self._features]
        cells = tuple(
            np.searchsorted(np.array(lines, dtype=np.float32), offset, side="left")
            for lines, offset in zip(self._lines, offsets, strict=True)
        )
        tables = [np.zeros(shape) for _ in range(3)]
        for table, values in zip(tables, (weight, weight * offsets[0], weight * offsets[1]), strict=True):
            np.add.at(table, cells, values)
        return tables[0], (tables[1], tables[2])


def _decide_engaged(claim: DecisionClaim, low: Fraction, high: Fraction, push: Fraction) -> tuple[bool, bool]:
    """Of offsets on one axis: whether the push closes on all of them, and whether those where it does not are near."""
    if push:
        least, most = sorted((push * low, push * high))
        if least > claim.margin:
            return True, True
        low, high = sorted((least / push, min(most, claim.margin) / push))
    return False, -claim.radius <= low and high <= claim.radius


_Node: TypeAlias = "int | tuple[int, float, _Node, _Node]"  # an action, or (feature, threshold, left, right)
_Cells: TypeAlias = tuple[int, int, int, int]


def _levels(node: _Node) -> int:
    return 0 if isinstance(node, int) else 1 + max(_levels(node[2]), _levels(node[3]))


def _lines(claim: DecisionClaim) -> list[float]:
    """Thresholds, ascending: far side of being near, where closing ends on either side, near side."""
    near = float(np.nextafter(round_down(np.float64(claim.radius)), np.float32(0)))
    above = float(np.nextafter(np.float32(claim.margin), np.float32(np.inf))) if claim.margin else 0.0
    above = max(above, SMALLEST) if above else above
    below = -max(float(np.nextafter(np.float32(above), np.float32(np.inf))), SMALLEST)
    return sorted({-near, below, above, near} if near > -below else {below, above})


def _reach(region: Region, agent: str, landmark: str, axis: str) -> Interval:
    """Between which ends the landmark's offset lies in the region."""
    own, mark = f"{agent}.{axis}", f"{landmark}.{axis}"
    low, high = region.box[mark][0] - region.box[own][1], region.box[mark][1] - region.box[own][0]
    for a, b, (least, most) in region.differences:
        if (a, b) == (mark, own):
            low, high = max(low, least), min(high, most)
        if (a, b) == (own, mark):
            low, high = max(low, -most), min(high, -least)
    return low, high


REPAIRABLE = (DistinctTargets.of, OwnTarget.of)
SAMPLES, SAMPLE_SEED = 50_000, 11  # uniform states that changes are weighed in
TRIED = 2  # matchings, the cheapest by an estimate first


@dataclass(frozen=True)
class Repair:
    """The outcome of a team's repair. `ended`: the zone engine proves the claim of `profile`."""

    profile: PolicyProfile
    roles: Mapping[str, str]  # agent -> its landmark
    guards: tuple[Guard, ...]
    rounds: int  # counterexamples that were met
    ended: bool
    reason: str = ""  # why it did not end

    @property
    def depth(self) -> int:
        """Splits on the longest path of any agent of the team."""
        return max(int(ir.depth(self.profile.policy(agent).tree).max()) for agent in self.roles)

    @property
    def price(self) -> float:
        """Share of weighed states in which an action changes, plus the price of further leaves."""
        return sum(one.changed + PRICE * ((len(one.tree.feature) - 1) // 2) for one in self.guards)


def is_repairable(claim: AnyClaim) -> bool:
    """Returns True if guards can make a claim true: matchings without errors of features, wherever a region reaches."""
    return isinstance(claim, DecisionClaim) and claim.of in REPAIRABLE and not claim.eps and claim.assume == TRUE


def refuse_repair(claim: str) -> InputError:
    """The error about a claim that is beyond this method."""
    return InputError(f"{claim} cannot be repaired", "--claim", f"only {' and '.join(REPAIRABLE)} can")


def repair(
    question: DecisionQuestion,
    visited: Float64 | None = None,
    max_depth: int | None = None,
    beside: Sequence[DecisionQuestion] = (),
    broken: Callable[[PolicyProfile], str] = lambda repaired: "",
) -> Repair:
    """The cheapest repair found over matchings of the team to the landmarks.

    `visited`: coordinates [n, n_coordinates] of states whose actions should stay, which weigh as much as uniform states
    of the region; what changes is weighed in the deployed arithmetic, whichever is asked about. `max_depth`: repairs
    within it are preferred. `beside`: questions about the same profile whose claims are repaired at the same time, by
    guards that keep all of them. `broken`: why a repair is none, since it breaks what else is to hold; "": it is one.
    InputError for a claim or a team beyond this method.
    """
    asked = (question, *beside)
    for each in asked:
        if not is_repairable(each.claim):
            raise refuse_repair(each.claim.shown)
    team = _Team(asked, visited, max_depth)
    tried = [_attempt(team, roles) for roles in team.matchings()]

    def rank(repair: Repair) -> tuple[bool, bool, float]:
        return not repair.ended, max_depth is not None and repair.depth > max_depth, repair.price

    failed = list[Repair]()
    for each in sorted(tried, key=rank):
        reason = broken(each.profile) if each.ended else each.reason
        if not reason:
            return each
        failed.append(replace(each, ended=False, reason=reason))
    return failed[0]


class _Team:
    """A team to repair: the guards of its leaves, made when they are asked for."""

    def __init__(self, asked: Sequence[DecisionQuestion], visited: Float64 | None, max_depth: int | None) -> None:
        self.asked, self.profile, self.semantics = asked, asked[0].profile, asked[0].semantics
        teams = {policy.agent: policy for question in asked for policy in question.team}
        self.policies = tuple(teams.values())
        self._about = {agent: [one for one in asked if teams[agent] in one.team] for agent in teams}
        self.landmarks = [landmark.name for landmark in self.profile.world.landmarks]
        for policy in self.policies:
            for landmark in self.landmarks:
                offset_features(policy, landmark)
        self._max_depth = max_depth
        self._levels = {policy.agent: ir.depth(policy.tree) for policy in self.policies}
        self._seen = {agent: _weigh_states(self._about[agent], policy, visited) for agent, policy in teams.items()}
        self._guards: dict[tuple[str, int, str], Guard | None] = {}

    def guard(self, policy: AgentPolicy, leaf: int, landmark: str) -> Guard | None:
        """The cheapest guard of a leaf. Where it would be too deep, that of the nearest split above which is not."""
        key = policy.agent, leaf, landmark
        if key not in self._guards:
            anywhere = Post(policy, leaf, landmark)
            self._guards[key] = self._within(anywhere) or self._make(anywhere)
        return self._guards[key]

    def _make(self, post: Post, levels: int | None = None) -> Guard | None:
        agent = post.policy.agent
        return guard(self._about[agent], post, self._seen[agent], levels)

    def _within(self, post: Post) -> Guard | None:
        """The guard of the nearest node, upwards from a leaf, that keeps within the depth asked for; None without."""
        policy, leaf, landmark = post
        if self._max_depth is None:
            return None
        for node in upwards(policy.tree, leaf):
            levels = self._max_depth - int(self._levels[policy.agent][node])
            nearest = self._make(Post(policy, node, landmark), levels)
            if nearest is not None:
                return nearest
        return None

    def matchings(self) -> list[dict[str, str]]:
        """The matchings to try: the one that claims fix, or those whose guards everywhere change least; of several
        teams each with each. InputError where claims about a team fix different ones.
        """
        costs = dict[tuple[str, str], float]()

        def cost(pairs: tuple[tuple[str, str], ...]) -> float:
            for agent, mark in pairs:
                if (agent, mark) not in costs:
                    costs[agent, mark] = self._everywhere(self.profile.policy(agent), mark)
            return sum(costs[pair] for pair in pairs)

        chosen = list[list[tuple[tuple[str, str], ...]]]()
        for name in dict.fromkeys(question.claim.team for question in self.asked):
            claims = [question.claim for question in self.asked if question.claim.team == name]
            sets = [
                [tuple((policy.agent, mark) for policy, mark in each) for each in claim.engagements(self.profile)]
                for claim in claims
            ]
            common = [pairs for pairs in sets[0] if all(pairs in others for others in sets)]
            if not common:
                what = f"{' and '.join(dict.fromkeys(claim.shown for claim in claims))} ask for different landmarks"
                raise InputError(what, f"team {name}", "guards keep one landmark an agent: repair one of the claims")
            chosen.append(sorted(common, key=cost)[:TRIED] if len(common) > 1 else common)
        return [dict(pair for pairs in way for pair in pairs) for way in product(*chosen)]

    def _everywhere(self, policy: AgentPolicy, landmark: str) -> float:
        guards = [self.guard(policy, int(leaf), landmark) for leaf in ir.leaves(policy.tree)]
        changed = {one.node: one.changed for one in guards if one is not None}
        return sum(changed.values()) + sum(one is None for one in guards)

    def insert_guards(self, guards: Mapping[tuple[str, int], Guard]) -> PolicyProfile:
        """The profile with guards in the places of nodes; all else decides as before, which is proved."""
        agents: list[AgentPolicy] = []
        for policy in self.profile.agents:
            parts = {node: one.tree for (agent, node), one in guards.items() if agent == policy.agent}
            if parts:
                tree = graft_parts(policy.tree, parts)
                assert difference(policy.tree, tree, len(policy.features), parts.keys()) is None
                policy = replace(policy, tree=tree, grown=None)
            agents.append(policy)
        return replace(self.profile, agents=tuple(agents))


def _weigh_states(asked: Sequence[DecisionQuestion], policy: AgentPolicy, visited: Float64 | None) -> Seen:
    """Uniform states of the regions and visited ones, each kind with half of the weight where both are there."""
    world, regions = asked[0].profile.world, list[Region]()
    for question in asked:
        if question.region not in regions:
            regions.append(question.region)
    drawn = np.concatenate([sample(region, world, SAMPLES, SAMPLE_SEED)[0] for region in regions])
    kinds = [drawn] if visited is None else [drawn, visited]
    kinds = [kind for kind in kinds if len(kind)] or [drawn]  # a region too thin to sample: only leaves have a price
    rows = observe(policy.features, np.concatenate(kinds), world, policy.numbers)
    weight = np.concatenate([np.full(len(kind), 1 / max(1, len(kind)) / len(kinds)) for kind in kinds])
    return Seen(rows, weight, ir.apply(policy.tree, rows))


def _attempt(team: _Team, roles: Mapping[str, str]) -> Repair:
    """Guards for one matching, from counterexample to counterexample."""
    guards, rounds = dict[tuple[str, int], Guard](), 0
    leaves = sum(len(ir.leaves(policy.tree)) for policy in team.policies)
    open_ = list(team.asked)
    while True:
        profile = team.insert_guards(guards)
        failing = next(_iterate_failing(open_, profile), None)
        if failing is None:
            break
        question, outcome = failing
        open_.sort(key=lambda one: one is not question)  # asked first, since it may fail elsewhere, too
        if outcome.state is None:
            reason = outcome.reason or f"the zone engine said {outcome.verdict.value}"
            return Repair(profile, roles, tuple(guards.values()), rounds, False, reason)
        rounds += 1
        tell(len(guards), leaves, "guards set, at most one per leaf")
        at, goal = dict(outcome.state), outcome.goal
        at |= {f"{ir.GOAL}.{axis}": at[f"{goal}.{axis}"] for axis in "xy"} if goal is not None else {}
        for policy in question.team:  # as they were before the repair
            now = profile.policy(policy.agent)
            action = int(now.tree.action[_leaf(now, team.semantics, at)])
            engaged = for_goal(engages(now, roles[now.agent], question.claim), goal)
            if holds(engaged, at, {now.agent: action}):
                continue
            leaf = _leaf(policy, team.semantics, at)
            above = {(policy.agent, node) for node in upwards(policy.tree, leaf)}
            assert not above & guards.keys(), f"the guard above leaf {leaf} of {policy.agent} does not hold"
            one = team.guard(policy, leaf, roles[policy.agent])
            if one is None:
                reason = f"no guard keeps {policy.agent} engaged with {roles[policy.agent]} at leaf {leaf}"
                return Repair(profile, roles, tuple(guards.values()), rounds, False, reason)
            for below in [key for key in guards if key[0] == policy.agent and one.node in upwards(policy.tree, key[1])]:
                del guards[below]
            guards[policy.agent, one.node] = one
    for key in sorted(guards, key=lambda key: (-guards[key].changed, key)):
        fewer = {other: one for other, one in guards.items() if other != key}
        if next(_iterate_failing(open_, team.insert_guards(fewer)), None) is None:
            guards = fewer
    return Repair(team.insert_guards(guards), roles, tuple(guards[key] for key in sorted(guards)), rounds, True)


def _iterate_failing(
    asked: Sequence[DecisionQuestion], profile: PolicyProfile
) -> Iterator[tuple[DecisionQuestion, engine.Outcome]]:
    """Yields the questions that zones do not prove of a profile, with what they say. InputError beyond zones."""
    for question in asked:
        try:
            outcome = engine.decide(question.of(profile))
        except engine.BeyondZonesError as error:
            what = "the claim needs more than difference bounds"
            raise InputError(what, str(error), "it cannot be repaired") from None
        if outcome.verdict is not Verdict.PROVED:
            yield question, outcome


def _leaf(policy: AgentPolicy, semantics: str, at: Mapping[str, Fraction]) -> int:
    """The leaf that an exact point reaches."""
    tree, node = policy.tree, ir.ROOT
    while tree.feature[node] != ir.NO_FEATURE:
        feature, threshold = policy.features[int(tree.feature[node])], float(tree.threshold[node])
        left = sides(feature, threshold, policy.numbers, semantics)[0]
        node = int(tree.left[node] if holds(left, at, {}) else tree.right[node])
    return node
