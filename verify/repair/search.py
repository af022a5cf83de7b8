"""Repairs of a team: leaves from which a claim can fail are guarded until it is proved.

Does: gives each agent a landmark of its own, guards the leaves that counterexamples of the zone engine end in, or the
  splits above them where trees would get too deep; takes back guards that the proof does not need.
Assumes: a claim about matchings between a team and the landmarks; agents that observe their offsets to the landmarks.
Does not: give a verdict (verdicts/decisions.py decides anew, with both engines), measure play, write files.

A guard keeps its agent engaged with the agent's landmark, so no leaf below it is met again and the search ends.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction

import numpy as np

from codegen import ir
from codegen.boxes import upwards
from codegen.errors import InputError
from codegen.ir import AgentPolicy, Float64, PolicyProfile
from codegen.lowering.passes import difference, graft_parts
from codegen.observe import observe
from verify.checker.thresholds import sides
from verify.claims.decisions import DistinctTargets, OwnTarget, engages
from verify.claims.formula import TRUE, for_goal, holds
from verify.progress import tell
from verify.question import DecisionQuestion
from verify.repair.guards import PRICE, Guard, Post, Seen, guard, offset_features
from verify.result import Verdict
from verify.states.state import sample
from verify.zones import engine

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


def refuse_repair(claim: str) -> InputError:
    """The error about a claim that is beyond this method."""
    return InputError(f"{claim} cannot be repaired", "--property", f"only {' and '.join(REPAIRABLE)} can")


def repair(question: DecisionQuestion, visited: Float64 | None = None, max_depth: int | None = None) -> Repair:
    """The cheapest repair found over matchings of the team to the landmarks.

    `visited`: coordinates [n, n_coordinates] of states whose actions should stay, which weigh as much as uniform states
    of the region; what changes is weighed in the deployed arithmetic, whichever is asked about. `max_depth`: repairs
    within it are preferred. InputError for a claim or a team beyond this method.
    """
    claim = question.claim
    if claim.of not in REPAIRABLE or claim.eps or claim.assume != TRUE:
        raise refuse_repair(claim.shown)
    team = _Team(question, visited, max_depth)
    tried = [_attempt(team, roles) for roles in team.matchings()]

    def rank(repair: Repair) -> tuple[bool, bool, float]:
        return not repair.ended, max_depth is not None and repair.depth > max_depth, repair.price

    return min(tried, key=rank)


class _Team:
    """A team to repair: the guards of its leaves, made when they are asked for."""

    def __init__(self, question: DecisionQuestion, visited: Float64 | None, max_depth: int | None) -> None:
        profile = question.profile
        self.question, self.profile, self.claim, self.semantics = question, profile, question.claim, question.semantics
        self.policies = question.team
        self.landmarks = [landmark.name for landmark in profile.world.landmarks]
        for policy in self.policies:
            for landmark in self.landmarks:
                offset_features(policy, landmark)
        self._max_depth = max_depth
        self._levels = {policy.agent: ir.depth(policy.tree) for policy in self.policies}
        self._seen = {policy.agent: _weigh_states(question, policy, visited) for policy in self.policies}
        self._guards: dict[tuple[str, int, str], Guard | None] = {}

    def guard(self, policy: AgentPolicy, leaf: int, landmark: str) -> Guard | None:
        """The cheapest guard of a leaf. Where it would be too deep, that of the nearest split above which is not."""
        key = policy.agent, leaf, landmark
        if key not in self._guards:
            anywhere = Post(policy, leaf, landmark)
            self._guards[key] = self._within(anywhere) or guard(self.question, anywhere, self._seen[policy.agent])
        return self._guards[key]

    def _within(self, post: Post) -> Guard | None:
        """The guard of the nearest node, upwards from a leaf, that keeps within the depth asked for; None without."""
        policy, leaf, landmark = post
        if self._max_depth is None:
            return None
        for node in upwards(policy.tree, leaf):
            levels = self._max_depth - int(self._levels[policy.agent][node])
            nearest = guard(self.question, Post(policy, node, landmark), self._seen[policy.agent], levels)
            if nearest is not None:
                return nearest
        return None

    def matchings(self) -> list[dict[str, str]]:
        """The matchings to try: the one that the claim fixes, or those whose guards everywhere change least."""
        names = [policy.agent for policy in self.policies]
        chosen = [tuple(mark for _, mark in each) for each in self.claim.engagements(self.profile)]
        if len(chosen) == 1:
            return [dict(zip(names, chosen[0], strict=True))]
        costs = {(p.agent, mark): self._everywhere(p, mark) for p in self.policies for mark in self.landmarks}
        chosen.sort(key=lambda marks: sum(costs[pair] for pair in zip(names, marks, strict=True)))
        return [dict(zip(names, marks, strict=True)) for marks in chosen[:TRIED]]

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


def _weigh_states(question: DecisionQuestion, policy: AgentPolicy, visited: Float64 | None) -> Seen:
    """Uniform states of the region and visited ones, each kind with half of the weight where both are there."""
    world = question.profile.world
    drawn, _ = sample(question.region, world, SAMPLES, SAMPLE_SEED)
    kinds = [drawn] if visited is None else [drawn, visited]
    kinds = [kind for kind in kinds if len(kind)] or [drawn]  # a region too thin to sample: only leaves have a price
    rows = observe(policy.features, np.concatenate(kinds), world, policy.numbers)
    weight = np.concatenate([np.full(len(kind), 1 / max(1, len(kind)) / len(kinds)) for kind in kinds])
    return Seen(rows, weight, ir.apply(policy.tree, rows))


def _attempt(team: _Team, roles: Mapping[str, str]) -> Repair:
    """Guards for one matching, from counterexample to counterexample."""
    guards, rounds = dict[tuple[str, int], Guard](), 0
    leaves = sum(len(ir.leaves(policy.tree)) for policy in team.policies)
    while True:
        profile = team.insert_guards(guards)
        try:
            outcome = engine.decide(team.question.of(profile))
        except engine.BeyondZonesError as error:
            raise InputError(
                "the claim needs more than difference bounds", str(error), "it cannot be repaired"
            ) from None
        if outcome.verdict is Verdict.PROVED:
            break
        if outcome.state is None:
            reason = outcome.reason or f"the zone engine said {outcome.verdict.value}"
            return Repair(profile, roles, tuple(guards.values()), rounds, False, reason)
        rounds += 1
        tell(len(guards), leaves, "guards set, at most one per leaf")
        for policy in _astray(team, profile, roles, outcome.state, outcome.goal):
            leaf = _leaf(policy, team.semantics, _at(outcome.state, outcome.goal))
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
        again = engine.decide(team.question.of(team.insert_guards(fewer)))
        if again.verdict is Verdict.PROVED:
            guards = fewer
    return Repair(team.insert_guards(guards), roles, tuple(guards[key] for key in sorted(guards)), rounds, True)


def _astray(
    team: _Team, profile: PolicyProfile, roles: Mapping[str, str], state: Mapping[str, Fraction], goal: str | None
) -> Sequence[AgentPolicy]:
    """The agents, with their trees before the repair, that are not engaged with their landmarks at a point."""
    at, astray = _at(state, goal), list[AgentPolicy]()
    for before in team.policies:
        now = profile.policy(before.agent)
        action = int(now.tree.action[_leaf(now, team.semantics, at)])
        if not holds(for_goal(engages(now, roles[now.agent], team.claim), goal), at, {now.agent: action}):
            astray.append(before)
    return astray


def _at(state: Mapping[str, Fraction], goal: str | None) -> dict[str, Fraction]:
    """The point with the coordinates of the goal."""
    return {**state, **({f"{ir.GOAL}.{axis}": state[f"{goal}.{axis}"] for axis in "xy"} if goal is not None else {})}


def _leaf(policy: AgentPolicy, semantics: str, at: Mapping[str, Fraction]) -> int:
    """The leaf that an exact point reaches."""
    tree, node = policy.tree, ir.ROOT
    while tree.feature[node] != ir.NO_FEATURE:
        feature, threshold = policy.features[int(tree.feature[node])], float(tree.threshold[node])
        left = sides(feature, threshold, policy.numbers, semantics)[0]
        node = int(tree.left[node] if holds(left, at, {}) else tree.right[node])
    return node
