"""From a question to a verdict that carries its evidence.

Does: asks the solver goal by goal, confirms counterexamples, measures the region's shares, runs the shuffled control.
Assumes: a checked profile; replays are given by the caller.
Does not: write reports (report.py).
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from codegen import ir
from codegen.ir import PolicyProfile
from verify import solve
from verify.counterexample import Counterexample, Replay, confirmed, explain
from verify.encode import question, region_only
from verify.shares import Share, Shares, measure
from verify.solve import DEFAULT_BUDGET, Answer, ask
from verify.spec import Property, Region, Verdict
from verify.world import verifiable

SHARE_SEED = 7
CONTROL_SEED = 0


@dataclass(frozen=True)
class Decision:
    """The solver's answer over all goals: the verdict, and for VIOLATED the goal and the model."""

    verdict: Verdict
    resources: int
    goal: str = ""
    answer: Answer | None = None
    reason: str = ""


@dataclass(frozen=True)
class Result:
    """A verdict with everything that a report says about it."""

    claim: Property
    region: Region
    verdict: Verdict
    reason: str
    shares: Shares
    control: Verdict  # of the same team with shuffled leaves; VIOLATED is what one hopes for
    counterexample: Counterexample | None
    resources: int
    budget: int
    solver: str
    on_policy_inside: Share | None  # of visited states that lie in the region's box


def decide(profile: PolicyProfile, claim: Property, region: Region, budget: int = DEFAULT_BUDGET) -> Decision:
    """The bare decision, by Z3."""
    verifiable(profile, claim.team)
    anything = ask(region_only(region), budget)
    spent = anything.resources
    if anything.holds is False:
        return Decision(Verdict.VACUOUS, spent, reason="the region holds no world state")
    open_reasons: list[str] = []
    for goal in region.goals or ("",):
        answer = ask(question(profile, claim, region, goal), budget)
        spent += answer.resources
        if answer.holds:
            return Decision(Verdict.VIOLATED, spent, goal, answer)
        if answer.holds is None:
            open_reasons.append(f"goal {goal or 'none'}: {answer.reason} after {answer.resources} resource units")
    if open_reasons:
        return Decision(Verdict.UNKNOWN, spent, reason="; ".join(open_reasons) + "; a larger --budget may answer")
    return Decision(Verdict.PROVED, spent)


def verify(
    profile: PolicyProfile,
    claim: Property,
    region: Region,
    replays: Mapping[str, Replay],
    budget: int = DEFAULT_BUDGET,
    on_policy_inside: Share | None = None,
) -> Result:
    """The verdict on `claim` in `region`, with shares, control and a replayed counterexample."""
    decision = decide(profile, claim, region, budget)
    verdict, reason, spent = decision.verdict, decision.reason, decision.resources
    counterexample = None
    if verdict is Verdict.VIOLATED:
        assert decision.answer is not None
        point, extra = confirmed(profile, claim, region, decision.goal, decision.answer, budget)
        spent += extra
        if point is None:
            verdict, reason = (
                Verdict.UNKNOWN,
                "a real-valued world state violates the claim, no float64 state near it does",
            )
        else:
            counterexample = explain(profile, claim, point, replays)
    measured = measure(profile, claim, region, SHARE_SEED)
    if verdict is Verdict.PROVED and measured.violating.hits:
        raise AssertionError(f"proved, yet {measured.violating.hits} sampled world states violate {claim.name}")
    control = Verdict.SKIPPED
    if verdict in (Verdict.PROVED, Verdict.VIOLATED):
        control = decide(shuffled(profile, claim.team), claim, region, budget).verdict
    return Result(
        claim=claim,
        region=region,
        verdict=verdict,
        reason=reason,
        shares=measured,
        control=control,
        counterexample=counterexample,
        resources=spent,
        budget=budget,
        solver=solve.solver_name(),
        on_policy_inside=on_policy_inside,
    )


def shuffled(profile: PolicyProfile, team: str, seed: int = CONTROL_SEED) -> PolicyProfile:
    """The control: the same trees, with the actions of each team member's leaves shuffled."""
    rng = np.random.default_rng(seed)
    policies = []
    for policy in profile.agents:
        if policy.team == team:
            action = policy.tree.action.copy()
            leaf = ir.leaves(policy.tree)
            action[leaf] = action[rng.permutation(leaf)]
            policy = replace(policy, tree=replace(policy.tree, action=action), grown=None)
        policies.append(policy)
    return replace(profile, agents=tuple(policies))
