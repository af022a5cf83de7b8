"""Two engines on one question: the zone engine first, Z3 as the second opinion; and how much room a proof has.

Does: asks the zone engine, has its proofs checked, holds its verdict against Z3's; bisects for the largest closing
  margin, or error of features, up to which a claim stays proved, over a grid of decimals.
Assumes: a team whose policies are `verifiable`; that a claim only gets harder: with its margin, as every claim does
  that asks for engagement; with larger errors.
Does not: call a disagreement or a refused proof a verdict: both are our bugs, and raise AssertionError. It does not
  guess: a question that is not answered counts as not proved, so the room found is a lower bound.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction

import msgspec

from codegen.ir import PolicyProfile
from codegen.policy_json import content_hash
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
from verify.claims.region import goal_text
from verify.question import UNITS_A_NODE, DecisionQuestion
from verify.result import Margin, Opinion, Verdict
from verify.solver.solve import decide
from verify.zones import engine as zones
from verify.zones.engine import BeyondZonesError, Room

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
        raise AssertionError(
            f"the engines disagree: {first.engine} {first.verdict.value}, {second.engine} {second.verdict.value}"
        )
    return first.verdict
