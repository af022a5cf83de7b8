"""Certificates as files: written beside a report, and checked by `maviper check`.

Does: names the files of certificates; reads one with its profile, checks it, says so in a line.
Assumes: results of `verify.engine.verify`, or files that anyone wrote.
Does not: prove.
"""

from collections.abc import Sequence
from pathlib import Path

import click

from codegen.errors import ExitCode, RefusedError
from maviper import load, runs
from verify import certificate
from verify.bounds import RejectedError
from verify.certificate import Certificate
from verify.closed_loop import LoopResult
from verify.engine import Result


def certificate_files(results: Sequence[Result | LoopResult]) -> dict[str, str]:
    """The certificates of proved results, file name -> text; numbered as in the report."""
    return {
        f"certificate-{place}-{result.claim.name}.json": certificate.to_json(result.certificate)
        for place, result in enumerate(results, 1)
        if isinstance(result, Result) and result.certificate is not None
    }


def check_command(path: Path, profile: Path | None) -> int:
    """The command `maviper check`; returns its exit code. RefusedError when the proof does not hold."""
    found = certificate.from_json(runs.read(path, certificate.MAX_BYTES), str(path))
    beside = path.parent / runs.PROFILE_FILE if profile is None else profile
    try:
        closed = certificate.accepted(found, load(beside))
    except RejectedError as error:
        raise RefusedError(
            "the certificate is refused", f"{path}: {error}", "do not rely on it; `maviper verify` asks anew"
        ) from None
    click.echo(f"accepted  {_subject(found)}: {closed} branches closed, {found.size} bytes of proof")
    return ExitCode.DONE


def _subject(found: Certificate) -> str:
    claim = "a formula without a name" if found.claim is None else f"{found.claim.name} of the {found.claim.team}"
    goals = f", goal {' or '.join(found.region.goals)}" if found.region.goals else ""
    return f"{claim} in region {found.region.name or 'given'}{goals}, {found.semantics} arithmetic"
