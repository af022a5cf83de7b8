"""Certificates as files: written beside a report, and checked by `maviper check`.

Does: names the files of certificates; reads one with its profile, checks it, says so in a line.
Assumes: results of `verify.engine.verify`, or files that anyone wrote.
Does not: prove.
"""

from collections.abc import Sequence
from fractions import Fraction
from pathlib import Path

import click
import msgspec

from codegen.errors import ExitCode, RefusedError
from codegen.ir import PolicyProfile
from maviper import load, runs
from verify import certificate, episode_certificate
from verify.bounds import RejectedError
from verify.certificate import Certificate
from verify.claim import stated
from verify.closed_loop import LoopResult, whatever
from verify.engine import Result
from verify.episode_certificate import EpisodeCertificate
from verify.spec import Region, text
from verify.world import everywhere


def certificate_files(results: Sequence[Result | LoopResult]) -> dict[str, str]:
    """Certificates of proved results, and of regions found in others, file name -> text; numbered as in the report."""
    found: dict[str, str] = {}
    for place, result in enumerate(results, 1):
        inner = result.within if isinstance(result, Result) else None
        for proved, ending in ((result, ""), (inner, "-region")):
            if proved is not None and proved.certificate is not None:
                found[f"certificate-{place}-{result.claim.name}{ending}.json"] = _text(proved.certificate)
    return found


def _text(found: Certificate | EpisodeCertificate) -> str:
    return certificate.to_json(found) if isinstance(found, Certificate) else episode_certificate.to_json(found)


def check_command(path: Path, profile: Path | None) -> int:
    """The command `maviper check`; returns its exit code. RefusedError when the proof does not hold."""
    found = _read(runs.read(path, certificate.MAX_BYTES), str(path))
    beside = path.parent / runs.PROFILE_FILE if profile is None else profile
    loaded = load(beside)
    try:
        if isinstance(found, Certificate):
            closed, subject = certificate.accepted(found, loaded), _subject(found, loaded)
        else:
            closed, subject = episode_certificate.accepted(found, loaded), _episodes(found, loaded)
    except RejectedError as error:
        raise RefusedError(
            "the certificate is refused", f"{path}: {error}", "do not rely on it; `maviper verify` asks anew"
        ) from None
    click.echo(f"accepted  {subject}: {closed} branches closed, {found.size} bytes of proof")
    return ExitCode.DONE


class _Form(msgspec.Struct):
    certificate: str


def _read(text: bytes, where: str) -> Certificate | EpisodeCertificate:
    """A certificate of either kind; what says of neither that it is one is told as one about single decisions."""
    try:
        form = msgspec.json.decode(text, type=_Form).certificate
    except (msgspec.DecodeError, UnicodeDecodeError, RecursionError):
        form = ""
    about = form.rpartition("-")[0] == episode_certificate.FORM.rpartition("-")[0]
    return episode_certificate.from_json(text, where) if about else certificate.from_json(text, where)


def _subject(found: Certificate, profile: PolicyProfile) -> str:
    """What was proved, from what was checked."""
    claim = "a formula without a name" if found.claim is None else f"{found.claim.name} of the {found.claim.team}"
    if found.claim is None and found.eps:
        claim += f", though every feature is off by up to {_shown(found.eps)}"
    if found.claim is not None:
        claim += "".join(f", {name} {_shown(value)}" for name, value in stated(found.claim).items())
    return f"{claim} in {_place(found.region, profile)}, {found.semantics} arithmetic"


def _episodes(found: EpisodeCertificate, profile: PolicyProfile) -> str:
    """What was proved of episodes, and whatever others do."""
    claim = found.claim
    own = f" at {' '.join(claim.landmarks)}" if claim.landmarks else ""
    followed = sorted({" with ".join(part.followed) for part in found.parts})
    said = f"{claim.name} of the {claim.team}{own}, steps {claim.steps}, radius {_shown(claim.radius)}"
    opponents = any(profile.policy(agent).team != claim.team for part in found.parts for agent in part.followed)
    others = f"followed: {', '.join(followed)}, {whatever(opponents)}"
    return f"{said}, from rest in {_place(found.region, profile)}, {found.semantics} arithmetic; {others}"


def _place(region: Region, profile: PolicyProfile) -> str:
    """A region with its goals in words: it is called `start` only where it is the start region."""
    named = "region start" if region == everywhere(profile) else "a region of its own (see the file)"
    return named + (f", goal {' or '.join(region.goals)}" if region.goals else "")


def _shown(value: Fraction | str | tuple[str, ...]) -> str:
    if isinstance(value, Fraction):
        return text(value).strip('"')
    return value if isinstance(value, str) else " ".join(value)
