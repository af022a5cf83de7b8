"""From a question about a stated system to a verdict that carries its evidence.

Does: has the system searched and a counterexample confirmed, asks the solver for a second opinion, runs the control.
Assumes: a checked profile; a system whose names, units and shapes were checked.
Does not: know the environment that a system is about, or read files.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from verify.flows import decide as flows
from verify.question import Question
from verify.reach import decide as reach
from verify.reach.results import ReachOutcome, SystemCounterexample
from verify.result import SETTLED, Control, Cost, Evidence, Opinion, Result, Verdict
from verify.solver import unrolled
from verify.spending import STATE
from verify.subjects import ClosedLoop
from verify.systems.claims import SystemClaim
from verify.verdicts import approaches
from verify.verdicts.approaches import ClosestApproach

if TYPE_CHECKING:
    from verify.checker.systems.proofs import SystemCertificate
    from verify.reach.results import OpenState

ENGINE, UNIT, BOXES = "reach", "symbolic states", "boxes"
FLOWS, SETS = "flows", "sets of states"
CONTROLS = 2_000_000  # boxes for all shuffled leaves together: they mostly fail at once
FEW = 256  # episodes of each that are played
ENCLOSED = "the claim fails within the enclosure error, but no violating episode of the exact rules was found"
NARROWER = ("more `cuts` where rules are not affine", "a smaller start region", "fewer steps")
Attempt = Callable[[], SystemCounterexample | None]
Confirm = Callable[[SystemCounterexample], SystemCounterexample | None]  # by the rules themselves; None: not broken


@dataclass(frozen=True, kw_only=True)
class SystemEvidence(Evidence):
    """What a verdict about a stated system rests on, and all else that a report says of it."""

    open: OpenState | None = None  # what an UNKNOWN leaves open, where that is a set of states
    helps: tuple[str, ...] = ()  # what may give an answer
    certificate: SystemCertificate | None = None
    counterexample: SystemCounterexample | None = None
    approach: ClosestApproach | None = (
        None  # how near episodes come to a border, or how far the counterexample goes beyond
    )
    environment: str = ""  # what the environment that the system is about says of the counterexample
    rounding: str = ""  # where a counterexample exists only by rounding: from which bound on the claim is proved
    programs: int = 0  # linear programs that were solved
    boxes: int = 0  # that were tried


SystemResult = Result[SystemClaim, SystemEvidence]


def verify_system(
    question: Question[SystemClaim],
    confirm: Confirm | None = None,
    beside: bool = True,
    attempt: Attempt | None = None,
    known: SystemCounterexample | None = None,
) -> SystemResult:
    """The verdict on a question. `confirm`: finds a counterexample again by rules that the system encloses; `beside`:
    with the solver's opinion and the control; `attempt`: looks for a counterexample where nothing else has one;
    `known`: one that was confirmed, so that nothing is searched.
    """
    flowing = is_flow(question)
    if known is not None:
        outcome = ReachOutcome(Verdict.VIOLATED, counterexample=known)
    else:
        outcome = _confirm_outcome(_decide(question), confirm)
    broken = attempt() if attempt is not None and outcome.verdict is Verdict.UNKNOWN else None
    if broken is not None:
        outcome = replace(outcome, verdict=Verdict.VIOLATED, reason="", counterexample=broken, open=None, helps=())
    settled = beside and outcome.verdict in SETTLED
    by_boxes = not outcome.states and outcome.certificate is not None
    own = Opinion(ENGINE, outcome.verdict, outcome.states, UNIT)
    own = Opinion(BOXES, outcome.verdict, outcome.boxes, BOXES) if by_boxes else own
    own = Opinion(FLOWS, outcome.verdict, outcome.boxes, SETS) if flowing else own
    evidence = SystemEvidence(
        control=_ask_controls(question) if settled else Control(),
        opinions=(own, _agreeing(question, outcome.verdict)) if settled and not flowing else (own,),
        certificate=outcome.certificate,
        branches=outcome.branches,
        counterexample=outcome.counterexample,
        approach=_approach(question, outcome) if beside else None,
        open=outcome.open,
        helps=outcome.helps,
        programs=outcome.programs,
        boxes=outcome.boxes,
    )
    cost = Cost(outcome.states, question.budgets.max_boxes // STATE, UNIT)
    return Result(question, outcome.verdict, outcome.reason, evidence, cost)


def _ask_controls(question: Question[SystemClaim]) -> Control:
    controls = question.controls
    limits = {"max_boxes": CONTROLS // max(len(controls), 1), "samples": FEW}
    return Control.of(_decide(control.spending(**limits)).verdict for control in controls)


def _decide(question: Question[SystemClaim]) -> ReachOutcome:
    return flows.decide(question) if is_flow(question) else reach.decide(question)


def _approach(question: Question[SystemClaim], outcome: ReachOutcome) -> ClosestApproach | None:
    """Measures how near random episodes come to the claim's border, or how far beyond it the counterexample goes."""
    assert isinstance(question.subject, ClosedLoop)
    profile, system = question.subject.profile, question.subject.system
    if outcome.counterexample is not None:
        return approaches.beyond(system, question.claim, outcome.counterexample)
    return None if outcome.verdict is Verdict.VACUOUS else approaches.closest(profile, system, question.claim)


def is_flow(question: Question[SystemClaim]) -> bool:
    """Returns True if a question is about episodes in continuous time."""
    assert isinstance(question.subject, ClosedLoop)
    return question.subject.system.flow is not None and not question.claim.about_decisions


def _confirm_outcome(outcome: ReachOutcome, confirm: Confirm | None) -> ReachOutcome:
    """The outcome, unless only the error of enclosures breaks the claim: then nothing is known of the rules."""
    if outcome.counterexample is None or confirm is None:
        return outcome
    again = confirm(outcome.counterexample)
    if again is None:
        return replace(outcome, verdict=Verdict.UNKNOWN, reason=ENCLOSED, helps=NARROWER, counterexample=None)
    return replace(outcome, counterexample=again)


def _agreeing(question: Question[SystemClaim], verdict: Verdict) -> Opinion:
    """The solver's opinion; AssertionError where it has another one."""
    second = unrolled.opinion(question)
    if second.verdict in SETTLED and second.verdict is not verdict:
        said = f"{ENGINE} {verdict.value}, {second.engine} {second.verdict.value}"
        raise AssertionError(f"the engines disagree on {question.claim.name}: {said}")
    return second
