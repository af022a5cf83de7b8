"""Certificates as files: written beside a report, and checked by `maviper check`.

Does: names the files of certificates; reads one with its profile, checks it, says so in a line.
Assumes: results of `verify.engine.verify`, or files that anyone wrote.
Does not: prove.
"""

from collections.abc import Sequence
from fractions import Fraction
from pathlib import Path

import click

from codegen.errors import ExitCode, RefusedError
from maviper import load, runs
from verify import certificate
from verify.bounds import RejectedError
from verify.certificate import Certificate
from verify.claim import stated
from verify.closed_loop import LoopResult
from verify.engine import Result
from verify.spec import Region, text
from verify.world import everywhere


def certificate_files(results: Sequence[Result | LoopResult]) -> dict[str, str]:
    """Certificates of proved results, and of regions found in others, file name -> text; numbered as in the report."""
    found: dict[str, str] = {}
    for place, result in enumerate(results, 1):
        if not isinstance(result, Result):
            continue
        for proved, ending in ((result, ""), (result.within, "-region")):
            if proved is not None and proved.certificate is not None:
                found[f"certificate-{place}-{result.claim.name}{ending}.json"] = certificate.to_json(proved.certificate)
    return found


def check_command(path: Path, profile: Path | None) -> int:
    """The command `maviper check`; returns its exit code. RefusedError when the proof does not hold."""
    found = certificate.from_json(runs.read(path, certificate.MAX_BYTES), str(path))
    beside = path.parent / runs.PROFILE_FILE if profile is None else profile
    try:
        loaded = load(beside)
        closed = certificate.accepted(found, loaded)
    except RejectedError as error:
        raise RefusedError(
            "the certificate is refused", f"{path}: {error}", "do not rely on it; `maviper verify` asks anew"
        ) from None
    click.echo(
        f"accepted  {_subject(found, everywhere(loaded))}: {closed} branches closed, {found.size} bytes of proof"
    )
    return ExitCode.DONE


def _subject(found: Certificate, start: Region) -> str:
    """What was proved, from what was checked: a region is called `start` only where it is the start region."""
    claim = "a formula without a name" if found.claim is None else f"{found.claim.name} of the {found.claim.team}"
    if found.claim is None and found.eps:
        claim += f", though every feature is off by up to {_shown(found.eps)}"
    if found.claim is not None:
        claim += "".join(f", {name} {_shown(value)}" for name, value in stated(found.claim).items())
    goals = f", goal {' or '.join(found.region.goals)}" if found.region.goals else ""
    region = "region start" if found.region == start else "a region of its own (see the file)"
    return f"{claim} in {region}{goals}, {found.semantics} arithmetic"


def _shown(value: Fraction | str | tuple[str, ...]) -> str:
    if isinstance(value, Fraction):
        return text(value).strip('"')
    return value if isinstance(value, str) else " ".join(value)
