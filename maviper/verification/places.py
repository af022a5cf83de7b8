"""Where claims hold, as files.

Does: the files of failing cells and of the regions found; keeps them from being written over a region asked about.
Assumes: results of `claims.verify_claims`.
Does not: look for anything.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from codegen.errors import InputError
from codegen.ir import PolicyProfile
from codegen.policy_json import content_hash
from maviper.verification.ask import Asked, VerifyOptions
from maviper.verification.join import region_file
from verify.claims.region import Kind
from verify.question import Budgets
from verify.verdicts.decisions import Result

if TYPE_CHECKING:
    from verify.verdicts.episodes import EpisodeResult

FOUND = "# Found by maviper verify --where:"  # what the file of a region found begins with


def repeated(asked: Asked, wanted: int | None) -> str:
    """The command line that repeats a question."""
    if wanted is None:
        return asked.command
    limited = asked.claim.kind is not Kind.EPISODES and wanted != Budgets().max_cells
    return f"{asked.command} --where" + (f" --max-cells {wanted}" if limited else "")


def where_files(profile: PolicyProfile, results: Sequence[Result | EpisodeResult]) -> dict[str, str]:
    """For each result with zones `zones-N-NAME.json`, for each region found `region-N-NAME.toml`, name -> text."""
    from verify.reports.where import zones_json  # imported here, as few ask where

    files: dict[str, str] = {}
    for place, result in enumerate(results, 1):
        if result.where is None:
            continue
        if result.where.count:
            files[f"zones-{place}-{result.claim.name}.json"] = zones_json(profile, result)
        if result.where.part is not None:
            told = (
                f"{FOUND} {result.claim.shown} of the {result.claim.team} holds in it; profile {content_hash(profile)}"
            )
            files[result.where.part.region.name] = f"{told}\n{result.where.part.region.toml()}"
    return files


def ensure_free(output: Path, asked: Sequence[Asked], options: VerifyOptions) -> None:
    """InputError when a region found would be written over a region asked about, or a file that is no region found."""
    folders = [Path(options.region).parent, *([options.file.parent] if options.file else [])]
    regions = {(folder / one.region.name).resolve() for folder in folders for one in asked}
    for number, one in enumerate(asked, 1):
        path = output / region_file(number, one.claim)
        if path.resolve() in regions or (path.is_file() and not path.read_bytes().startswith(FOUND.encode())):
            raise InputError("the region found would overwrite a file", str(path), "choose another folder with -o")
