"""What is done with claims about stated systems.

Does: has the world file's system answer them; certificates and counterexamples as text.
Assumes: the stated world of the question for a bench.
Does not: decide.
"""

from __future__ import annotations

from typing import Any

from codegen.ir import PolicyProfile
from maviper.verification.files.systems import counterexample_document
from maviper.verification.procedures.conditions import with_conditions
from maviper.verification.procedures.procedure import Procedure
from maviper.verification.procedures.rounding import with_bound
from maviper.verification.stated import StatedWorld
from verify.certificates.systems import to_json
from verify.question import Question
from verify.result import Verdict
from verify.systems.claims import SystemClaim
from verify.verdicts.systems import SystemResult


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
