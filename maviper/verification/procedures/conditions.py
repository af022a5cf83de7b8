"""Whether each left side of a formula about a stated system can hold: else the formula says nothing.

Does: asks of each left side whether it never holds; VACUOUS where that is proved; gives a proof a state of each.
Assumes: a result about the system of a stated world.
Does not: decide formulas.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from codegen.wording import visible
from verify.claims.formula import negate
from verify.question import Question
from verify.result import Verdict
from verify.systems.claims import SystemClaim, SystemPremise
from verify.verdicts.systems import SystemEvidence, SystemResult

if TYPE_CHECKING:
    from maviper.verification.stated import StatedWorld

NEVER = "no state meets the condition: {words}"
UNFOUND = "no state that meets the condition was found, and no proof that there is none: {words}"


def with_conditions(result: SystemResult, world: StatedWorld) -> SystemResult:
    """The result, unless a left side never holds, or none is known to; the certificate of a proof states what meets
    each.
    """
    if result.verdict not in (Verdict.PROVED, Verdict.UNKNOWN):
        return result
    premises: list[SystemPremise] = []
    for denied in result.claim.conditions:
        answer, words = answer_alone(result.question, denied.claim, world), visible(" ".join(denied.words.split()))
        shown = answer.evidence.counterexample
        if answer.verdict is Verdict.PROVED:
            return _leave_unproved(result, Verdict.VACUOUS, NEVER.format(words=words))
        if shown is None and result.verdict is Verdict.PROVED:
            return _leave_unproved(result, Verdict.UNKNOWN, UNFOUND.format(words=words))
        if shown is not None:
            premises.append(SystemPremise(negate(answer.claim.formula), shown.states[0]))
    certificate = result.evidence.certificate
    if certificate is None or not premises:
        return result
    stated = replace(certificate, claim=replace(certificate.claim, premises=tuple(premises)))
    return replace(result, evidence=replace(result.evidence, certificate=stated))


def answer_alone(question: Question[SystemClaim], claim: SystemClaim, world: StatedWorld) -> SystemResult:
    """The verdict on another claim about the world of a question."""
    alone = replace(world, claims=(claim,), options=replace(world.options, verdict_only=True))
    return alone.answer(replace(question, claim=claim), beside=False)


def _leave_unproved(result: SystemResult, verdict: Verdict, reason: str) -> SystemResult:
    return replace(result, verdict=verdict, reason=reason, evidence=SystemEvidence(boxes=result.evidence.boxes))
