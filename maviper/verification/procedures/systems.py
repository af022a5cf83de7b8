"""What is done with claims about stated systems.

Does: has the world file's system answer them; asks of each left side of a formula whether it can hold, and gives a
  proof a state of each; asks a formula that fails again with one bound moved to the next float, and says with which
  bound it is proved; certificates and counterexamples as text.
Assumes: the stated world of the question for a bench.
Does not: decide.

`x < 80` holds at 80 - 1e-15, which an agent reads as 80. So `x < 80 implies acts(A) == low` fails for a tree that tests
just this, and is proved of `x <= 79.99999999999999`.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from fractions import Fraction
from functools import partial
from math import inf
from typing import Any

from codegen.ir import PolicyProfile
from codegen.numbers import nearest_number, neighbour
from codegen.wording import visible
from maviper.verification.files.systems import counterexample_document
from maviper.verification.procedures.procedure import Procedure
from maviper.verification.stated import StatedWorld
from verify.certificates.systems import to_json
from verify.claims.formula import Linear, atoms, below, negate, normal
from verify.claims.language.compared import last_of
from verify.decimals import plain
from verify.question import Question
from verify.result import Verdict
from verify.systems.claims import SystemClaim, SystemPremise
from verify.systems.curves import with_comparisons
from verify.systems.properties import find_numbers
from verify.verdicts.systems import SystemEvidence, SystemResult

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


MOST = 16  # bounds that are tried
SAID = "fails only where {name} is rounded when it is observed: proved with {moved} in place of {stated}"


def with_bound(result: SystemResult, world: StatedWorld) -> SystemResult:
    """The result, which says from which bound on its claim is proved, where only rounding makes it fail."""
    claim = result.claim
    if result.verdict is not Verdict.VIOLATED or not claim.about_decisions or claim.curved or world.statement.observed:
        return result
    numbers = find_numbers(world.statement, world.origin.agents)
    for stated, moved in list(_iterate_moved(claim, numbers))[:MOST]:
        formula = with_comparisons(normal(claim.formula), partial(_move, stated, moved))
        again = answer_alone(result.question, replace(claim, formula=formula), world)
        if again.verdict is Verdict.PROVED:
            left = any(stated in atoms(condition.claim.formula) for condition in claim.conditions)
            said = SAID.format(
                name=", ".join(name for _, name in stated.terms), moved=_spell(moved, left), stated=_spell(stated, left)
            )
            return replace(result, evidence=replace(result.evidence, rounding=said))
    return result


def _move(stated: Linear, moved: Linear, atom: Linear) -> Linear:
    return moved if atom == stated else atom


def _iterate_moved(claim: SystemClaim, numbers: Mapping[str, str]) -> Iterator[tuple[Linear, Linear]]:
    """Each bound on a variable that is observed, and the weaker one at the next float beyond what is read as it."""
    for atom in dict.fromkeys(atoms(normal(claim.formula))):
        if not isinstance(atom, Linear) or len(atom.terms) != 1:
            continue
        ((weight, name),) = atom.terms
        if not numbers.get(name):
            continue
        kind, bound = numbers[name], atom.bound / abs(weight)  # of the variable, or of its opposite
        end = bound if atom.strict else max(bound, Fraction(nearest_number(bound, kind)))
        after = float(neighbour(last_of(end, kind, below=atom.strict), inf, kind))
        moved = below({name: 1 if weight > 0 else -1}, Fraction(repr(after)), strict=True)
        if moved != atom and isinstance(moved, Linear):
            yield atom, moved


def _spell(atom: Linear, left: bool) -> str:
    """A bound in words; its opposite where it is of the left side of an implication."""
    ((weight, name),) = atom.terms
    low, strict = (weight < 0) != left, atom.strict != left
    return f"{name} {'>' if low else '<'}{'' if strict else '='} {plain(atom.bound / weight)}"


def _answer(question: Question[SystemClaim], bench: StatedWorld, region_file: str | None) -> SystemResult:
    """Nothing is said of where a claim holds: what an answer leaves open is a set of states, which the report names."""
    return with_bound(with_conditions(bench.answer(question), bench), bench)


def _verdict(question: Question[SystemClaim], bench: StatedWorld) -> tuple[Verdict, str]:
    result = with_conditions(bench.answer(question, beside=False), bench)
    return result.verdict, result.reason


def _counterexample(profile: PolicyProfile, result: SystemResult) -> tuple[dict[str, Any], str] | None:
    found = result.evidence.counterexample
    return None if found is None else (counterexample_document(result.question, found), "from its start, in world.toml")


PROCEDURE = Procedure(_answer, _verdict, to_json, _counterexample)  # the solver gives a second opinion alone
