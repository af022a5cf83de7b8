"""Verifying a profile's claims: the verifier joined with simulator, compiled code and reference environment.

Does: hands `verify` its replays and the share of on-policy states, and makes the report's files.
Assumes: the profile's world is one of ours; otherwise only the reference replays.
Does not: decide verdicts.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping, Sequence
from contextlib import nullcontext
from types import ModuleType
from typing import TYPE_CHECKING, Any

from codegen import ir
from codegen.form import layout
from codegen.lowering.render import render
from codegen.profiles import ensure
from maviper.verification.bench import Bench
from maviper.verification.files.places import region_file
from maviper.verification.procedures.table import procedure
from verify.question import AnyClaim, Question
from verify.reports import report
from verify.result import AnyResult, Verdict

if TYPE_CHECKING:
    from maviper.verification.stated import StatedWorld


def verify_claims(questions: Sequence[Question[AnyClaim]], where: bool = False) -> list[AnyResult]:
    """A result for each question; all are about one profile. Those about episodes are of the deployed arithmetic.

    `where`: also where claims about single decisions hold, and from how many starts those about episodes fail.
    """
    return list(one_by_one(questions, where))


def one_by_one(
    questions: Sequence[Question[AnyClaim]], where: bool = False, stated: StatedWorld | None = None
) -> Iterator[AnyResult]:
    """Yields each result of `verify_claims` as soon as it is known. `stated`: the world file that they are about."""
    with _bench(questions) if stated is None else nullcontext(stated) as bench:
        for number, question in enumerate(questions, 1):
            found_in = region_file(number, question.claim) if where else None
            yield procedure(question.claim).answer(question, bench, found_in)


def _bench(questions: Sequence[Question[AnyClaim]]) -> Bench:
    return Bench.of(_profile_of(questions), any(question.viewed is not None for question in questions))


def verdicts(
    questions: Sequence[Question[AnyClaim]], stated: StatedWorld | None = None
) -> Iterator[tuple[Verdict, str]]:
    """The verdict on each question and its reason: those of `verify_claims`, without what a report says beside them."""
    if stated is None:
        _profile_of(questions)
    for question in questions:
        yield procedure(question.claim).verdict(question, stated)


def _profile_of(questions: Sequence[Question[AnyClaim]]) -> ir.PolicyProfile:
    """The one profile that questions are about."""
    profile = ensure(questions[0].origin)
    assert all(question.origin is profile for question in questions)
    return profile


def digests(files: Mapping[str, str | bytes]) -> dict[str, str]:
    """SHA-256 of each text in hexadecimal, by name."""
    encoded = {name: item.encode() if isinstance(item, str) else item for name, item in sorted(files.items())}
    return {name: hashlib.sha256(item).hexdigest() for name, item in encoded.items()}


def question_files(questions: Sequence[Question[AnyClaim]]) -> dict[str, str]:
    """The very questions, one per property and goal (of alive_leaves: one per leaf and goal), as SMT-LIB, name -> text.

    Claims about episodes have none: no solver is asked about them.
    """
    files: dict[str, str] = {}
    for number, question in enumerate(questions, 1):
        files |= procedure(question.claim).solver_files(number, question)
    return files


def report_files(facts: Mapping[str, Any], form: ModuleType = report) -> dict[str, str]:
    """report.html, report.json and report.txt of a document, name -> text. `form`: of games, or of stated systems."""
    return {
        "report.json": form.as_json(facts),
        "report.txt": form.as_text(facts),
        "report.html": form.as_html(facts),
    }


def certificate_files(results: Sequence[AnyResult]) -> dict[str, str]:
    """Certificates of proved results, and of regions found in others, file name -> text; numbered as in the report."""
    return {
        f"certificate-{place}-{result.claim.name}{ending}.json": procedure(result.claim).certificate(certificate)
        for place, result in enumerate(results, 1)
        for ending, certificate in result.evidence.certificates
    }


def counterexample_files(profile: ir.PolicyProfile, results: Sequence[AnyResult]) -> dict[str, str]:
    """For each violated claim a file, and a test that fails until a policy holds there."""
    files: dict[str, str] = {}
    for place, result in enumerate(results, 1):
        failure = procedure(result.claim).counterexample(profile, result)
        if failure is None:
            continue
        written, where = failure
        stem = f"counterexample-{place}-{result.claim.name}"
        files[f"{stem}.json"] = layout(written) + "\n"
        named = {"name": f"{stem}.json", "place": place, "where": where}
        files[f"test_{stem.replace('-', '_')}.py"] = render("tests/counterexample.py.j2", **named)
    return files


def where_files(profile: ir.PolicyProfile, results: Sequence[AnyResult]) -> dict[str, str]:
    """The files of all results, name -> text; results are counted from 1."""
    files: dict[str, str] = {}
    for place, result in enumerate(results, 1):
        files |= procedure(result.claim).places(profile, place, result)
    return files
