"""Certificates and counterexamples about systems that files state; and how far the reading of any certificate is.

Does: names, reads and checks the files of such certificates, and replays such counterexamples; tells the bytes of a
  proof that the checker has read, and the pieces of a system that it has shown again.
Assumes: the checker reads a proof byte by byte, once.
Does not: prove, or change what is checked.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, cast

import msgspec

from codegen.errors import InputError, PartlyReadError, RefusedError, escape_text
from codegen.ir import PolicyProfile
from codegen.policy_json import content_hash
from codegen.wording import format_count
from maviper.files import kinds, runs
from maviper.files.profiles import find_profile
from maviper.worlds.stated.certified import (
    WORLD_FILE,
    ensure_accepted,
    ensure_plays,
    leave_stated,
    read_certificate,
    sentence,
)
from maviper.worlds.stated.systems import read
from verify.certificates.proofs import count_bytes
from verify.certificates.systems import claim_document
from verify.checker.certificate import MAX_BYTES, Bytes
from verify.checker.reading import RejectedError
from verify.checker.systems.enclosures import ensure_curves
from verify.checker.systems.proofs import Cover, FlowSets, SystemClaimJson, SystemProof, from_json, read_claim
from verify.exact import read_number
from verify.flows.episodes import FlowCourse
from verify.flows.episodes import replay_course as flow_replayed
from verify.question import Question
from verify.reach.replay import Course, is_start, replay_course
from verify.reach.results import SystemCounterexample
from verify.reach.rounded import truly
from verify.reports import systems as report
from verify.reports.courses import counterexample
from verify.spending import tell
from verify.subjects import ClosedLoop
from verify.systems import documents
from verify.systems.claims import SystemClaim
from verify.systems.files import MAX_BYTES as MAX_WORLD_BYTES
from verify.systems.observing import as_played
from verify.systems.properties import claims_in, claims_of, name_inputs
from verify.systems.statement import Statement
from verify.toml_places import parse

STEP = 2**14  # bytes of proof; a second or less


class FollowedProof(Bytes):
    """A proof that tells how much of it has been read."""

    def __iter__(self) -> Iterator[int]:
        for low in range(0, len(self), STEP):
            if low:
                tell(low, len(self), "bytes of proof read")
            yield from memoryview(self)[low : low + STEP]


def tell_shown(done: int, most: int) -> None:
    """That so many of the pieces of a system are shown again."""
    tell(done, most, "pieces shown again by the checker")


CLAIM_FILE = "claims.toml"  # beside certificates, where claims were asked from a file of their own
OLD_CLAIM_FILE = "properties.toml"  # as it was called
FORM = "maviper-system-counterexample-1"
ADVICE = "make it again with `maviper verify --system -o`"


def counterexample_document(question: Question[SystemClaim], episode: SystemCounterexample) -> dict[str, Any]:
    """Returns the contents of the file of a violated claim."""
    assert isinstance(question.subject, ClosedLoop)
    told, profile, claim = counterexample(episode), question.profile, question.claim
    return {
        "counterexample": FORM,
        "profile": content_hash(profile),
        "system": documents.content_hash(question.subject.system),
        "claim": claim_document(claim),
        **{key: told[key] for key in ("step", "start", "errors", "pieces", "actions")},
        **({} if claim.at_samples is None else {"at_samples": claim.at_samples}),
        **{key: told[key] for key in ("longer", "way", "rank") if key in told},
    }


class CounterexampleJson(msgspec.Struct, forbid_unknown_fields=True):
    """The members of the file; numbers are exact texts."""

    counterexample: str
    profile: str
    system: str
    claim: SystemClaimJson
    step: int
    start: dict[str, str]
    errors: list[dict[str, str]]
    pieces: list[int]
    actions: dict[str, list[str]]
    at_samples: bool | None = None  # of a flow: whether the claim is about samples only
    longer: str | list[str] = "0"  # of a flow: seconds by which periods are longer than stated: all, or each in turn
    way: int | list[int] = 0  # of a flow: which of its delays samples have, from 0: all, or each in turn
    rank: int = 0  # of a flow: which of the cases that hold a state is taken, in turn


def check_certificate(
    path: Path, profile: PolicyProfile | Path | None, world: Path | None
) -> tuple[str, int, int, str]:
    """Returns what the certificate in a file proves, in words, its branches or boxes, its bytes (0: a recipe), and what
    was counted. RefusedError when it does not hold.

    The pieces of the system are shown again from the rules of the file, then the proof is followed.
    """
    certificate, statement = read_certificate(path, world, FollowedProof)
    about = leave_stated(find_profile(profile, beside=path, sums=True), statement)
    closed = ensure_accepted(path, certificate, statement, about, told=tell_shown)
    statement, about = as_played(statement, about)
    stated = list(claims_of(statement, about, WORLD_FILE)) if statement.properties else []
    for name in (CLAIM_FILE, OLD_CLAIM_FILE):
        stated += _read_beside(statement, about, path.parent / name)
    try:
        curve = _of_curves(certificate.claim, statement, stated)
    except RejectedError as error:
        advice = "do not rely on it; run `maviper verify` again"
        raise RefusedError("an enclosure of the claim is refused", f"{path}: {escape_text(error)}", advice) from None
    said = f"{curve or sentence(certificate.claim, statement, about)}, {report.sentence(statement.system)}"
    said += _left_sides(certificate.claim, stated)
    label = next((each.label for each in stated if each == certificate.claim), "")  # never the certificate's own
    unit = report.name_units(certificate.proof)[0]
    return (
        f"{name_claim(replace(certificate.claim, label=label))}: {said}",
        closed,
        0 if isinstance(certificate.proof, Cover | FlowSets) else count_bytes(certificate.proof),
        unit,
    )


def read_earlier(since: Path, world: str, claims: Sequence[SystemClaim]) -> dict[int, tuple[SystemProof, ...]]:
    """The proofs of a certificate, or of those in a folder, by the place of the claim that each is of: one of that kind
    and label, whatever its numbers. InputError for files that are none, and for another world or claim.
    """
    files = sorted(since.glob("certificate-*.json")) if since.is_dir() else [since]
    if not files:
        raise InputError("the folder holds no certificate", str(since), "name one, or the folder of a `verify -o`")
    beside = files[0].parent / WORLD_FILE
    text = runs.read(beside, MAX_WORLD_BYTES).decode(errors="replace") if beside.exists() else ""
    before = parse(text, str(beside), "not a readable world file", ADVICE)[0].get("name", "system") if text else world
    if before != world:
        what = f"the certificate is about {escape_text(str(before))}, and the world file is {world}"
        raise InputError(what, str(files[0]), "name a certificate of this world")
    texts = {str(file): runs.read_unpacked(file, MAX_BYTES) for file in files}
    for file, data in texts.items():
        kinds.ensure(data, file, kinds.SYSTEM_CERTIFICATE.called, kinds.SYSTEM_CERTIFICATE)
    made = [from_json(data, file) for file, data in texts.items()]
    found = {
        place: tuple(one.proof for one in made if (one.claim.name, one.claim.label) == (claim.name, claim.label))
        for place, claim in enumerate(claims)
    }
    if not any(found.values()):
        asked = ", ".join(dict.fromkeys(each.shown for each in claims))
        what = f"the certificate is about {name_claim(made[0].claim)}, and this is not asked"
        raise InputError(what, str(files[0]), f"asked are: {asked}")
    return found


def _left_sides(claim: SystemClaim, stated: Sequence[SystemClaim]) -> str:
    """Describes what a certificate shows of the left sides of implications. `stated`: claims of the files beside it."""
    if not claim.about_decisions or any(each == claim and not each.conditions for each in stated):
        return ""
    if claim.premises:
        return f"; {format_count(len(claim.premises), 'state')} in it shown to meet its conditions"
    return "; if it is an implication, the certificate does not show that its left side can hold"


def _of_curves(claim: SystemClaim, statement: Statement, stated: Sequence[SystemClaim]) -> str:
    """Describes what a proof says of a formula with curves or outputs among claims of files; "" where there is none
    that the claim implies. RejectedError where its enclosures are not shown again.
    """
    for each in stated:
        if each == claim and each.curved is None and name_inputs(each.written) != each.written:
            return f"{each.sentence}: {' '.join(each.written.split())}"
        if each == claim and each.curved is not None:
            shown_again = ensure_curves(
                each.curved.enclosures, {one.name: one.range for one in statement.system.variables}
            )
            shown = f", by {format_count(shown_again, 'enclosure')} shown again" if shown_again else ""
            return f"{each.sentence}: {' '.join(each.written.split())}{shown}"
    return ""


def _read_beside(statement: Statement, profile: PolicyProfile, beside: Path) -> list[SystemClaim]:
    """The claims of a property file beside a certificate, as far as they are about the system; those of the game that
    it is made from are told in the system's words.
    """
    if not beside.exists():
        return []
    try:
        text = runs.read(beside, MAX_WORLD_BYTES).decode(errors="replace")
        return list(claims_in(text, statement, profile, beside.name))
    except PartlyReadError as error:
        return list(cast("tuple[SystemClaim, ...]", error.read))
    except InputError:
        return []


def name_claim(claim: SystemClaim) -> str:
    """Names a claim in a file: its kind, and its label as the file's word."""
    return claim.name + (f" (in the file: '{escape_text(claim.label)}')" if claim.label else "")


def replay(
    path: Path, profile: PolicyProfile, world: Path | None
) -> tuple[CounterexampleJson, SystemClaim, Any, bool, bool]:
    """A counterexample of a file, the claim in it, the episode that breaks it again (None where none does), and whether
    the system and the profile are those that it was made of.
    """
    document = runs.decode_file(path, MAX_BYTES, CounterexampleJson, "not a readable counterexample", ADVICE)
    statement = read(world or path.parent / WORLD_FILE)
    ensure_plays(profile, statement)
    statement, profile = as_played(statement, profile)
    try:
        claim = read_claim(document.claim)
        start = {name: read_number(value) for name, value in document.start.items()}
        errors = [{name: read_number(value) for name, value in each.items()} for each in document.errors]
        if set(start) != {each.name for each in statement.system.variables}:
            raise ValueError("its start names other variables than the world file")
        claim.ensure()
        if not is_start(statement.system, claim, start):
            where = f"{path}: $.start: {statement.system.name}"
            raise InputError("the counterexample does not start where the world file has starts", where, ADVICE)
        if statement.system.flow is None or claim.about_decisions:
            again = replay_course(profile, statement.system, claim, Course(start, errors, document.pieces))
            again = truly(statement, profile, claim, again) if again and statement.acting else again
        else:
            claim = replace(claim, at_samples=bool(document.at_samples))
            # a list is of what changes from period to period, and its last member stays
            longer = [document.longer] if isinstance(document.longer, str) else document.longer
            ways = [document.way] if isinstance(document.way, int) else document.way
            if not longer or not ways:
                raise ValueError("a list of periods or delays is empty")
            course = FlowCourse(start, errors or [{}], list(map(read_number, longer)), ways, document.rank)
            again = flow_replayed(profile, statement.system, claim, course)
    except (ValueError, LookupError, TypeError, ZeroDivisionError) as error:
        raise InputError("not a readable counterexample", f"{path}: {escape_text(error)}", ADVICE) from None
    same = document.system == documents.content_hash(statement.system)
    return document, claim, again, same, document.profile == content_hash(profile)
