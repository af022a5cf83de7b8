"""Where claims hold, as files.

Does: the files of failing cells and of the regions found; keeps them from being written over a region asked about.
Assumes: results of `join.verify_claims`.
Does not: look for anything.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from codegen.errors import InputError
from codegen.ir import PolicyProfile
from codegen.policy_json import content_hash
from maviper.files.outputs import FOUND
from maviper.verification.ask import Asked, VerifyOptions
from verify.claims.region_files import region_toml
from verify.question import AnyClaim, Budgets
from verify.verdicts.decisions import DecisionResult


def repeat_command(asked: Asked, wanted: int | None) -> str:
    """The command line that repeats a question."""
    if wanted is None:
        return asked.command
    limited = "max_cells" in asked.claim.limits and wanted != Budgets().max_cells
    return f"{asked.command} --where" + (f" --max-cells {wanted}" if limited else "")


def region_file(number: int, claim: AnyClaim) -> str:
    """The name of the file of the region that is found for a claim; claims are counted from 1."""
    return f"region-{number}-{claim.name}.toml"


def zones_and_region(profile: PolicyProfile, place: int, result: DecisionResult) -> dict[str, str]:
    """`zones-N-NAME.json` of the zones known, `region-N-NAME.toml` of the region found, where there are any."""
    from verify.reports.where import zones_json  # imported here, as few ask where

    where, claim = result.evidence.where, result.claim
    if where is None:
        return {}
    files = {f"zones-{place}-{claim.name}.json": zones_json(profile, result)} if where.count else {}
    if where.part is not None:
        told = f"{FOUND} {claim.shown} of the {claim.team} holds in it; profile {content_hash(profile)}"
        files[where.part.region.name] = f"{told}\n{region_toml(where.part.region)}"
    return files


def ensure_free(output: Path, asked: Sequence[Asked], options: VerifyOptions) -> None:
    """InputError when a region found would be written over a region asked about, or a file that is no region found."""
    folders = [Path(options.region).parent, *([options.file.parent] if options.file else [])]
    regions = {(folder / one.region.name).resolve() for folder in folders for one in asked}
    for number, one in enumerate(asked, 1):
        path = output / region_file(number, one.claim)
        if path.resolve() in regions or (path.is_file() and not path.read_bytes().startswith(FOUND.encode())):
            raise InputError("the region found would overwrite a file", str(path), "choose another folder with -o")
