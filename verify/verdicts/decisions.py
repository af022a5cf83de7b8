"""From a question about single decisions to a verdict that carries its evidence.

Does: asks the zone engine first, has its proofs checked, and Z3 goal by goal as the second opinion; confirms
  counterexamples, measures the region's shares, runs the shuffled control; bisects for the largest closing margin, or
  error of features, up to which a claim stays proved, over a grid of decimals.
Assumes: a checked profile; replays are given by the caller; a claim only gets harder with its margin, as every claim
  does that asks for engagement, and with larger errors.
Does not: write reports (reports/report.py), or guess: a question without an answer counts as not proved. A disagreement
  of the engines or a refused proof is no verdict: both are our bugs, and raise AssertionError.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import TYPE_CHECKING, Any, NamedTuple

import msgspec

from codegen.intervals import Share
from codegen.ir import PolicyProfile
from codegen.policy_json import content_hash
from codegen.wording import visible
from verify.certificates.games import may_name
from verify.checker.certificate import Certificate
from verify.checker.decisions import (
    FORM,
    MET,
    MET_PARTED,
    PARTED,
    DecisionCertificate,
    DecisionHeader,
    FormulaClaim,
    GoalProofs,
    Premise,
    check_certificate,
    check_premise,
)
from verify.checker.reading import RejectedError
from verify.claims.decisions import DecisionClaim
from verify.claims.formula import TRUE, Condition, agents, conjunction, negate
from verify.claims.region import goal_text
from verify.claims.wording import OwnFormula
from verify.counterexamples.explanation import Explanation, explain_counterexample
from verify.counterexamples.search import Counterexample, Stronger, confirm_point, explain, near, violating_samples
from verify.kinds import MACHINE, REAL
from verify.question import UNITS_A_NODE, DecisionQuestion
from verify.result import SETTLED, Control, Cost, Evidence, Margin, Opinion, Result, Verdict
from verify.solver import solve
from verify.solver.solve import Answer, LeafFinding, SolverDecision, about_nothing, decide, leaf_findings
from verify.states.shares import SAMPLE_SEED, Shares, measure
from verify.states.state import Replay, State
from verify.zones import engine as zones
from verify.zones.engine import BeyondZonesError, Room

if TYPE_CHECKING:
    from verify.extent.largest import Where


STEP = Fraction(1, 1000)  # the grid, in the world's length unit
MAX_QUESTIONS = 12
WIDEST = Fraction(2)  # beyond the sides of the start regions nothing is ahead


def room(question: DecisionQuestion) -> Margin | None:
    """Up to which margin a proved claim holds; None for claims that a margin does not make harder."""
    if not question.claim.hardens:
        return None

    def by_solver(margin: Fraction) -> bool:
        return decide(question.with_margin(margin)).verdict is Verdict.PROVED

    start = question.claim.margin
    try:
        proved_at = Room(question, STEP, steps_from(start)).is_proved_at
    except BeyondZonesError:
        proved_at = by_solver
    return largest_margin(proved_at, start)


def steps_from(start: Fraction) -> int:
    """Returns the maximum number of steps of the grid to ask about."""
    return max(0, int((WIDEST - start) / STEP))


def largest_margin(proved_at: Callable[[Fraction], bool], start: Fraction) -> Margin:
    """The largest margin (or error) of the grid found proved from `start` (which is) on, by bisection.

    `proved_at`: whether the claim is proved with a margin (or error).
    """
    steps = steps_from(start)
    if not steps:
        return Margin(start, None, 0)
    if proved_at(start + steps * STEP):
        return Margin(start + steps * STEP, None, 1)
    low, high, asked = 0, steps, 1
    while high - low > 1 and asked < MAX_QUESTIONS:
        middle = (low + high) // 2
        asked += 1
        if proved_at(start + middle * STEP):
            low = middle
        else:
            high = middle
    return Margin(start + low * STEP, start + high * STEP, asked)


ENGINE = "zones"


@dataclass(frozen=True)
class Zoned:
    """The zone engine's answer, and for a proof its certificate, accepted by the checker."""

    opinion: Opinion
    goal: str | None = None
    state: Mapping[str, Fraction] | None = None
    part: DecisionQuestion | None = None  # of the question, that fails in the state
    certificate: DecisionCertificate | None = None
    branches: int = 0  # that the certificate's proofs close
    beyond: str = ""  # why the question is beyond zones


def by_zones(question: DecisionQuestion) -> Zoned:
    """The zone engine's opinion, within as many search nodes as the solver's units buy (UNITS_A_NODE)."""
    claim = question.claim
    try:
        outcome = zones.decide(question.spending(max_nodes=max(1, question.budgets.solver_units // UNITS_A_NODE)))
    except zones.BeyondZonesError as error:
        return Zoned(Opinion(ENGINE, Verdict.SKIPPED, 0, "search nodes"), beyond=str(error))
    opinion = Opinion(ENGINE, outcome.verdict, outcome.nodes, "search nodes")
    if outcome.verdict is not Verdict.PROVED:
        return Zoned(opinion, outcome.goal, outcome.state, outcome.part)
    made = certify(question, outcome, claim if may_name(claim) else None)
    try:
        return Zoned(opinion, certificate=made, branches=check_certificate(made, question.origin))
    except RejectedError as error:
        raise AssertionError(f"the checker refuses the zone engine's proof of {claim.name}: {error}") from error


def certify(
    question: DecisionQuestion,
    outcome: zones.Outcome,
    named: DecisionClaim | None = None,
    pair: tuple[PolicyProfile, PolicyProfile] | None = None,
) -> DecisionCertificate:
    """The certificate of a proof. `pair`: two profiles that the question is about as one."""
    origin = question.origin if pair is None else pair[0]
    view = None if question.viewed is None else question.viewed.view
    header = DecisionHeader(
        certificate=FORM if question.parts == (question,) else PARTED,
        profile=content_hash(origin),
        inhabitant=outcome.inhabitant,
        semantics=question.semantics,
        region=question.region,
        against="" if pair is None else content_hash(pair[1]),
        view=view,
        eps=question.claim.eps,
    )
    proofs = {goal_text(goal): proof for goal, proof in outcome.proofs.items()}
    return Certificate(header, FormulaClaim(named, question.formula), GoalProofs(proofs))


def with_premises(
    certificate: DecisionCertificate, question: DecisionQuestion, premises: Sequence[Premise]
) -> DecisionCertificate:
    """The certificate of a formula with the left sides of its implications, of which the checker accepts the states."""
    header = certificate.header
    if certificate.claim.property is not None:
        return certificate
    for premise in premises:
        try:
            check_premise(premise, question.profile, header.region, header.semantics)
        except RejectedError as error:
            raise AssertionError(f"the checker refuses a state of {question.claim.name}: {error}") from error
    form = MET if header.certificate == FORM else MET_PARTED
    return replace(
        certificate,
        header=msgspec.structs.replace(header, certificate=form),
        claim=msgspec.structs.replace(certificate.claim, premises=tuple(premises)),
    )


def largest_eps(question: DecisionQuestion) -> Margin:
    """Up to which errors of features a claim that holds with its own keeps holding: each with a checked proof."""

    def is_proved_at(eps: Fraction) -> bool:
        return by_zones(question.with_eps(eps)).opinion.verdict is Verdict.PROVED

    return largest_margin(is_proved_at, question.claim.eps)


def agreeing(zoned: Zoned, second: Opinion) -> Verdict:
    """The verdict of the two: AssertionError when both have one and they differ."""
    first = zoned.opinion
    undecided = (Verdict.UNKNOWN, Verdict.SKIPPED)
    if first.verdict in undecided or second.verdict is Verdict.VACUOUS:  # zones do not ask what the assumption leaves
        return second.verdict
    if second.verdict not in (*undecided, first.verdict):
        what = f"the engines disagree: {first.engine} {first.verdict.value}, {second.engine} {second.verdict.value}"
        raise AssertionError(what)
    return first.verdict


UNIT = "resource units"
FEW = 2_000  # states that a control is tried in: most are violated in every tenth
SLIGHTLY = "a region that is a little smaller may be decided"
ONLY_REAL = f"a real-valued world state violates the claim; no float64 state near it was found that does; {SLIGHTLY}"
ONLY_ROUNDED = f"rounding within sums may make the claim fail; no float64 state was found in which it does; {SLIGHTLY}"


@dataclass(frozen=True)
class Visited:
    """On-policy states, of whole episodes and so not independent: how many of them lie inside a region."""

    inside: int
    states: int
    episodes: int


@dataclass(frozen=True, kw_only=True, repr=False)
class DecisionEvidence(Evidence):
    """The evidence for a verdict about single decisions, and all else that a report says of it.

    For example:

        maviper.verify(team, where=True).evidence.where
    """

    shares: Shares
    counterexample: Counterexample | None = None
    explanation: Explanation | None = None  #: of the counterexample
    visited: Visited | None = None  #: on-policy states inside the region; None when the world cannot be played here
    leaves: tuple[LeafFinding, ...] = ()  #: of alive_leaves
    largest: Margin | None = None  #: up to which margin a proved claim holds
    steady_up_to: Margin | None = None  #: up to which errors of features a claim holds that zones proved with its own
    certificate: DecisionCertificate | None = None  #: of a proof by zones
    solver: str = ""  #: its name and version
    alone: str = ""  #: why Z3 decides alone, where zones cannot speak
    where: Where | None = None  #: where it holds, when that was asked
    verdict_in_largest_region: DecisionResult | None = None  #: the verdict in the largest region found

    @property
    def certificates(self) -> Iterator[tuple[str, Any]]:
        """Also that of the region found."""
        yield from super().certificates
        inner = self.verdict_in_largest_region
        if inner is not None and inner.evidence.certificate is not None:
            yield "-region", inner.evidence.certificate

    @property
    def failing_state(self) -> State | None:
        """The world state in which the claim fails."""
        return None if self.counterexample is None else self.counterexample.state

    @property
    def plays_world(self) -> bool:
        """True if the states that its own episodes visit are known."""
        return self.visited is not None


DecisionResult = Result[DecisionClaim, DecisionEvidence]


class Settled(NamedTuple):
    """A verdict with its reason, what it took, for VIOLATED a confirmed point, and Z3's opinion."""

    verdict: Verdict
    reason: str
    spent: int
    state: State | None
    second: Opinion


def verify(
    question: DecisionQuestion,
    replays: Mapping[str, Replay],
    visited: Visited | None = None,
    skipped: Sequence[str] = (),
) -> DecisionResult:
    """The verdict on a question, with shares, control and a replayed counterexample.

    `skipped`: replays that could not be had, each with its reason, for the report.
    """
    claim = question.claim
    if not claim.per_state:
        return _alive(question, visited)
    zoned, (verdict, reason, spent, state, second) = _judge_question(question)
    reason = of_states(question, reason)
    beside = question.spending(solver_units=question.budgets.detail_units)
    counterexample = explanation = None
    if state is not None:
        counterexample = explain(beside, state, replays)
        explanation = explain_counterexample(beside, counterexample)
    measured = measure(beside, SAMPLE_SEED)
    if verdict is Verdict.PROVED:  # float64 sampling may misjudge a state on a boundary, so the referee confirms it
        wrong = next(violating_samples(beside), None)
        if wrong is not None:
            raise AssertionError(f"proved, yet {wrong} violates {claim.name}")
    steady = verdict is Verdict.PROVED and claim.eps and zoned.certificate is not None
    controls = beside.controls if verdict in SETTLED else []
    units = beside.budgets.solver_units // max(len(controls), 1)
    control = Control.of(_decide_control(each, units) for each in controls)
    evidence = DecisionEvidence(
        shares=measured,
        control=control,
        counterexample=counterexample,
        explanation=explanation,
        replays=tuple(replays),
        skipped=tuple(skipped),
        visited=visited,
        largest=room(beside) if verdict is Verdict.PROVED else None,
        steady_up_to=largest_eps(question) if steady else None,
        opinions=(zoned.opinion, second),
        certificate=zoned.certificate if verdict is Verdict.PROVED else None,
        branches=zoned.branches,
        solver=solve.solver_name(),
        alone=zoned.beyond,
    )
    return Result(question, verdict, reason, evidence, _cost(question, spent))


def _cost(question: DecisionQuestion, spent: int) -> Cost:
    return Cost(spent, question.budgets.solver_units, UNIT)


def verdict(question: DecisionQuestion) -> tuple[Verdict, str]:
    """The verdict of `verify` and its reason alone: without shares, control, margins and explanation."""
    if not question.claim.per_state:
        outcome = _alive(question, None)
        return outcome.verdict, outcome.reason
    settled = _judge_question(question)[1]
    return settled.verdict, of_states(question, settled.reason)


def of_states(question: DecisionQuestion, text: str) -> str:
    """A text about a question: over observations it speaks of these and of no world states."""
    return text if question.viewed is None else text.replace("world state", "observation")


def _judge_question(question: DecisionQuestion) -> tuple[Zoned, Settled]:
    """Returns what the zones say, and what is settled with Z3; a proof only where each left side can hold."""
    _ = question.team
    zoned = by_zones(question)
    settled = _settle_question(question, zoned)
    if settled.verdict not in (Verdict.PROVED, Verdict.UNKNOWN):
        return zoned, settled
    premises = list[Premise]()
    for condition in conditions_of(question.claim):
        verdict, reason, spent, state, _ = _meet_condition(question, condition)
        settled = settled._replace(spent=settled.spent + spent)
        if verdict is Verdict.VACUOUS or (state is None and settled.verdict is Verdict.PROVED):
            return zoned, settled._replace(verdict=verdict, reason=reason)
        if state is not None:
            exact = {name: Fraction(value) for name, value in state.position.items()}
            premises.append(Premise(condition.formula, goal_text(state.goal), exact))
    if zoned.certificate is not None and settled.verdict is Verdict.PROVED:
        zoned = replace(zoned, certificate=with_premises(zoned.certificate, question, premises))
    return zoned, settled


def conditions_of(claim: DecisionClaim) -> list[Condition]:
    """Lists what some state of the region must meet, or else a claim says nothing: the left sides of its implications,
    or the assumption alone.
    """
    if claim.assume == TRUE:
        return list(claim.conditions)
    both = [Condition(each.words, conjunction(claim.assume, each.formula)) for each in claim.conditions]
    return both or [Condition(claim.assumption, claim.assume)]


def _meet_condition(question: DecisionQuestion, condition: Condition) -> Settled:
    """A state of the region that meets a condition, without errors of features; VACUOUS where none does, else UNKNOWN
    where none was found.
    """
    claim, told = question.claim, visible(" ".join(condition.words.split()))
    denied = OwnFormula(claim.team, claim.margin, claim.radius, statement=negate(condition.formula))
    answer = _find_violation(question.about(denied))
    if answer.verdict is Verdict.PROVED and claim.eps and agents(condition.formula):  # an error may lead there
        answer = answer._replace(verdict=_find_violation(question.about(replace(denied, eps=claim.eps))).verdict)
    if answer.verdict is Verdict.PROVED:
        return answer._replace(
            verdict=Verdict.VACUOUS, reason=f"no world state of the region meets the condition: {told}"
        )
    if answer.state is None or answer.state.errors:
        asked = f"with {question.budgets.solver_units:,} resource units for each goal"
        hint = question.budgets.hint("may find one")
        reason = f"no world state that meets the condition was found {asked}: {told}; {hint}"
        return answer._replace(verdict=Verdict.UNKNOWN, reason=reason, state=None)
    return answer


def _find_violation(question: DecisionQuestion) -> Settled:
    """Settles a question, by zones alone where a state beside theirs is a violation."""
    zoned = by_zones(question)
    if zoned.state is not None and question.semantics == MACHINE:
        state = near(zoned.part or question, zoned.goal, zoned.state)
        if state is not None:
            return Settled(Verdict.VIOLATED, "", 0, state, zoned.opinion)
    return _settle_question(question, zoned)


def _decide_control(control: DecisionQuestion, units: int) -> Verdict:
    """The verdict on a control, by a few sampled states, else by zones, else by Z3 with so many units; UNKNOWN where
    rounding within sums alone may make its state a violation.
    """
    if next(violating_samples(control, FEW), None) is not None:
        return Verdict.VIOLATED
    zoned = by_zones(control)
    if zoned.opinion.verdict is Verdict.PROVED:
        return Verdict.PROVED
    failing = zoned.state is not None and near(zoned.part or control, zoned.goal, zoned.state)
    if failing or (zoned.opinion.verdict is Verdict.VIOLATED and control.semantics == REAL):
        return Verdict.VIOLATED
    decision = decide(control.spending(solver_units=units))
    if decision.answer is None or decision.exact:
        return decision.verdict
    state, _ = confirm_point(decision.part or control, decision.goal, decision.answer)
    return Verdict.UNKNOWN if state is None else decision.verdict


def _alive(question: DecisionQuestion, visited: Visited | None) -> DecisionResult:
    """The result of alive_leaves: PROVED when every leaf is reached, VIOLATED when one is proved to be dead."""
    nothing, spent = about_nothing(question)
    findings: list[LeafFinding] = []
    if not nothing:
        findings, more = leaf_findings(question)
        spent += more
    kinds = {finding.verdict for finding in findings}
    worst = next(kind for kind in (Verdict.VIOLATED, Verdict.UNKNOWN, Verdict.PROVED) if kind in kinds or not kinds)
    verdict = Verdict.VACUOUS if nothing else worst
    reason = nothing or "; ".join(dict.fromkeys(one.reason for one in findings if one.reason))
    unasked = Share(0, 0)
    shares, solver = Shares(unasked, None, unasked), solve.solver_name()
    evidence = DecisionEvidence(shares=shares, solver=solver, visited=visited, leaves=tuple(findings))
    return Result(question, verdict, of_states(question, reason), evidence, _cost(question, spent))


def _settle_question(question: DecisionQuestion, zoned: Zoned) -> Settled:
    """Verdict, reason, resources, for VIOLATED a confirmed point (case after case until one is), and Z3's opinion."""
    cases, only_real = question.cases, ""
    decided = zoned.opinion.verdict in (Verdict.PROVED, Verdict.VIOLATED)
    units = question.budgets.second_opinion_units if decided else question.budgets.solver_units
    failing = (zoned.part or question).spending(solver_units=question.budgets.detail_units)
    stronger, spent = Stronger(failing, zoned.goal), 0
    if zoned.state is not None:  # a clear violation that Z3 finds is its second opinion, too
        state, spent = confirm_point(failing, zoned.goal, None, stronger)
        if state is not None:
            second = Opinion(solve.solver_name(), Verdict.VIOLATED, spent, UNIT)
            return Settled(Verdict.VIOLATED, "", spent, state, second)
    decision = decide(question.spending(solver_units=units), cases)
    spent += decision.resources
    second = Opinion(solve.solver_name(), decision.verdict, decision.resources, UNIT)
    if decision.verdict is not agreeing(zoned, second):
        answer = None if zoned.state is None else Answer(True, dict(zoned.state), 0)
        decision = SolverDecision(zoned.opinion.verdict, 0, zoned.goal, answer, part=zoned.part)
    while decision.answer is not None:
        asked = decision.part or question
        asked = asked.spending(solver_units=question.budgets.detail_units)
        known = stronger if (asked.claim, decision.goal) == (failing.claim, zoned.goal) else None
        state, extra = confirm_point(asked, decision.goal, decision.answer, known)
        spent += extra
        if state is None and zoned.state is not None and zoned.goal == decision.goal:
            state = near(question, decision.goal, zoned.state)
        if state is not None:
            return Settled(Verdict.VIOLATED, "", spent, state, second)
        only_real = ONLY_REAL if decision.exact else ONLY_ROUNDED
        place = next(k for k, (goal, part) in enumerate(cases) if goal == decision.goal and part.claim == asked.claim)
        cases = cases[place + 1 :]
        decision = decide(question, cases)
        spent += decision.resources
    if only_real and decision.verdict in (Verdict.PROVED, Verdict.UNKNOWN):
        return Settled(Verdict.UNKNOWN, only_real, spent, None, second)
    return Settled(decision.verdict, decision.reason, spent, None, second)
