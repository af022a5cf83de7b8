"""From a question to a verdict that carries its evidence.

Does: asks the solver goal by goal, confirms counterexamples, measures the region's shares, runs the shuffled control.
Assumes: a checked profile; replays are given by the caller.
Does not: write reports (report.py).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction

import numpy as np

from codegen import ir
from codegen.ir import PolicyProfile
from verify import solve
from verify.certificate import Certificate
from verify.counterexample import Counterexample, Replay, confirmed, explain, near, violating_samples
from verify.encode import question, region_only
from verify.explanation import Explanation, explained
from verify.formula import TRUE
from verify.leaves import LeafFinding, leaf_findings
from verify.margins import Margin, grows_harder, largest_margin
from verify.opinions import Opinion, Zoned, agreeing, by_zones, largest_eps
from verify.properties import LEAVES, Property
from verify.shares import SAMPLE_SEED, Share, Shares, measure
from verify.solve import DEFAULT_BUDGET, Answer, ask
from verify.spec import MACHINE, Region, Verdict
from verify.where import Where
from verify.world import Point, verifiable

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
class Visited:
    """On-policy states, of whole episodes and so not independent: how many of them lie inside a region."""

    inside: int
    states: int
    episodes: int


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
    replays: tuple[str, ...]  # what replays a counterexample, beside the reference
    skipped: tuple[str, ...]  # replays that could not be had, with the reason
    resources: int
    budget: int
    solver: str
    visited: Visited | None  # on-policy states inside the region; None when the world cannot be played here
    semantics: str = MACHINE
    leaves: tuple[LeafFinding, ...] = ()  # of alive_leaves
    largest: Margin | None = None  # up to which margin a proved claim holds
    steady_up_to: Margin | None = None  # up to which errors of features a claim holds that zones proved with its own
    engines: tuple[Opinion, ...] = ()  # those that were asked; where two have a verdict, it is the same
    certificate: Certificate | None = None  # of a proof by zones; the checker accepted it
    branches: int = 0  # that the certificate closes
    explanation: Explanation | None = None  # of the counterexample
    where: Where | None = None  # where it holds, when that was asked
    within: "Result | None" = None  # the verdict in the largest region found


def decide(
    profile: PolicyProfile,
    claim: Property,
    region: Region,
    budget: int = DEFAULT_BUDGET,
    goals: Sequence[str] | None = None,
    semantics: str = MACHINE,
) -> Decision:
    """The bare decision, by Z3. `goals`: only these of the region's goals."""
    verifiable(profile, claim.team)
    nothing, spent = _nothing(claim, region, budget)
    if nothing:
        return Decision(Verdict.VACUOUS, spent, reason=nothing)
    open_reasons: list[str] = []
    for goal in (region.goals or ("",)) if goals is None else goals:
        answer = ask(question(profile, claim, region, goal, semantics=semantics), budget)
        spent += answer.resources
        if answer.holds:
            return Decision(Verdict.VIOLATED, spent, goal, answer)
        if answer.holds is None:
            open_reasons.append(f"goal {goal or 'none'}: {answer.reason} after {answer.resources} resource units")
    if open_reasons:
        return Decision(Verdict.UNKNOWN, spent, reason="; ".join(open_reasons) + "; a larger --budget may answer")
    return Decision(Verdict.PROVED, spent)


def _nothing(claim: Property, region: Region, budget: int) -> tuple[str, int]:
    """Why the claim speaks of no world state, or "" if it does; and the resources spent."""
    anything = ask(region_only(region), budget)
    if anything.holds is False:
        return "the region holds no world state", anything.resources
    if claim.assume == TRUE:
        return "", anything.resources
    met = _meeting(claim, region, budget)
    spent = anything.resources + sum(answer.resources for answer in met)
    if all(answer.holds is False for answer in met):
        return "no world state of the region meets the assumption", spent
    return "", spent


def _met(claim: Property, region: Region, budget: int) -> bool:
    """Whether some world state of the region is known to meet the assumption: else a proof may be about nothing."""
    if claim.assume == TRUE:
        return True
    return any(answer.holds for answer in _meeting(claim, region, budget))


def _meeting(claim: Property, region: Region, budget: int) -> list[Answer]:
    """For each goal, whether some world state of the region meets the assumption."""
    return [ask(region_only(region, claim.assume, goal), budget) for goal in region.goals or ("",)]


def verify(
    profile: PolicyProfile,
    claim: Property,
    region: Region,
    replays: Mapping[str, Replay],
    budget: int = DEFAULT_BUDGET,
    visited: Visited | None = None,
    skipped: Sequence[str] = (),
    semantics: str = MACHINE,
) -> Result:
    """The verdict on `claim` in `region`, with shares, control and a replayed counterexample.

    `skipped`: replays that could not be had, each with its reason, for the report.
    """
    if claim.name == LEAVES:
        return _alive(profile, claim, region, budget, visited)
    verifiable(profile, claim.team)
    zoned = by_zones(profile, claim, region, budget, semantics)
    verdict, reason, spent, point, second = _settled(profile, claim, region, budget, zoned, semantics)
    if verdict is Verdict.PROVED and not _met(claim, region, budget):
        verdict, reason = Verdict.UNKNOWN, "no world state that meets the assumption was found; a larger --budget may"
    counterexample = explanation = None
    if point is not None:
        counterexample = explain(profile, claim, point, replays)
        explanation = explained(profile, claim, region, counterexample, budget)
    measured = measure(profile, claim, region, SAMPLE_SEED)
    if verdict is Verdict.PROVED and measured.violating.hits and semantics == MACHINE:
        _ensure_none_violates(profile, claim, region)
    steady = verdict is Verdict.PROVED and claim.eps and zoned.certificate is not None
    control = Verdict.SKIPPED
    if verdict in (Verdict.PROVED, Verdict.VIOLATED):
        control = decide(shuffled(profile, claim.team), claim, region, budget, None, semantics).verdict
    return Result(
        claim=claim,
        region=region,
        verdict=verdict,
        reason=reason,
        shares=measured,
        control=control,
        counterexample=counterexample,
        replays=tuple(replays),
        skipped=tuple(skipped),
        resources=spent,
        budget=budget,
        solver=solve.solver_name(),
        visited=visited,
        semantics=semantics,
        largest=_largest(profile, claim, region, budget, semantics) if verdict is Verdict.PROVED else None,
        steady_up_to=largest_eps(profile, claim, region, budget, semantics) if steady else None,
        engines=(zoned.opinion, second),
        certificate=zoned.certificate if verdict is Verdict.PROVED else None,
        branches=zoned.branches,
        explanation=explanation,
    )


def _ensure_none_violates(profile: PolicyProfile, claim: Property, region: Region) -> None:
    """AssertionError for a sampled violation of a proved claim, if the referee confirms one: float64 sampling may
    misjudge a state on a boundary.
    """
    wrong = next(violating_samples(profile, claim, region), None)
    if wrong is not None:
        raise AssertionError(f"proved, yet {wrong} violates {claim.name}")


def _largest(profile: PolicyProfile, claim: Property, region: Region, budget: int, semantics: str) -> Margin | None:
    """Up to which margin a proved claim holds; None for claims that a margin does not make harder."""
    if not grows_harder(claim):
        return None

    def proved_at(margin: Fraction) -> bool:
        asked = replace(claim, margin=margin)
        return decide(profile, asked, region, budget, None, semantics).verdict is Verdict.PROVED

    return largest_margin(proved_at, claim.margin)


def _alive(profile: PolicyProfile, claim: Property, region: Region, budget: int, visited: Visited | None) -> Result:
    """The result of alive_leaves: PROVED when every leaf is reached, VIOLATED when one is proved to be dead."""
    nothing, spent = _nothing(claim, region, budget)
    findings: list[LeafFinding] = []
    if not nothing:
        findings, more = leaf_findings(profile, claim.team, region, budget)
        spent += more
    kinds = {finding.verdict for finding in findings}
    worst = next(kind for kind in (Verdict.VIOLATED, Verdict.UNKNOWN, Verdict.PROVED) if kind in kinds or not kinds)
    unasked = Share(0, 0)
    return Result(
        claim=claim,
        region=region,
        verdict=Verdict.VACUOUS if nothing else worst,
        reason=nothing or "; ".join(dict.fromkeys(one.reason for one in findings if one.reason)),
        shares=Shares(unasked, None, unasked),
        control=Verdict.SKIPPED,
        counterexample=None,
        replays=(),
        skipped=(),
        resources=spent,
        budget=budget,
        solver=solve.solver_name(),
        visited=visited,
        leaves=tuple(findings),
    )


def _settled(
    profile: PolicyProfile, claim: Property, region: Region, budget: int, zoned: Zoned, semantics: str
) -> tuple[Verdict, str, int, Point | None, Opinion]:
    """Verdict, reason, resources, for VIOLATED a confirmed point (goal after goal until one is), and Z3's opinion."""
    goals, only_real = list(region.goals or ("",)), False
    decision = decide(profile, claim, region, budget, goals, semantics)
    spent = decision.resources
    second = Opinion(solve.solver_name(), decision.verdict, spent, "resource units")
    if decision.verdict is not agreeing(zoned, second):
        answer = None if zoned.point is None else Answer(True, dict(zoned.point), 0)
        decision = Decision(zoned.opinion.verdict, 0, zoned.goal, answer)
    while decision.answer is not None:
        point, extra = confirmed(profile, claim, region, decision.goal, decision.answer, budget)
        spent += extra
        if point is None and zoned.point is not None and zoned.goal == decision.goal:
            point = near(profile, claim, region, decision.goal, zoned.point)
        if point is not None:
            return Verdict.VIOLATED, "", spent, point, second
        only_real = True
        goals = goals[goals.index(decision.goal) + 1 :]
        decision = decide(profile, claim, region, budget, goals, semantics)
        spent += decision.resources
    if only_real and decision.verdict in (Verdict.PROVED, Verdict.UNKNOWN):
        reason = "a real-valued world state violates the claim; no float64 state beside it was found to"
        return Verdict.UNKNOWN, reason, spent, None, second
    return decision.verdict, decision.reason, spent, None, second


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
