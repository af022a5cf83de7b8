"""Where claims hold, as files.

Does: the files of failing cells and of the regions found; keeps them from being written over a region asked about.
Assumes: results of `join.verify_claims`.
Does not: look for anything.
"""

from __future__ import annotations

import re
import shlex
from collections.abc import Sequence
from pathlib import Path

from codegen.errors import InputError
from codegen.ir import PolicyProfile
from codegen.policy_json import content_hash
from maviper.files import outputs, runs
from maviper.verification.ask import MAX_FILE_BYTES, Asked, VerifyOptions, list_calls, usual_of
from verify.claims.calls import read_call
from verify.claims.files import properties
from verify.claims.region_files import region_toml
from verify.question import AnyClaim
from verify.toml_places import parse
from verify.verdicts.decisions import DecisionResult


def repeat_command(asked: Asked, wanted: int | None) -> str:
    """The command line that repeats a question."""
    if wanted is None:
        return asked.command
    limited = "max_cells" in asked.claim.limits and wanted != usual_of(asked.question.budgets).max_cells
    return f"{asked.command} --where" + (f" --set max_cells={wanted}" if limited else "")


def repeat_options(options: VerifyOptions) -> str:
    """The command line that asks the claims of options again, run beside `profile.json`, region and property file."""
    words = ["maviper", "verify", runs.PROFILE_FILE, "--region", Path(options.region).name]
    words += [] if options.file is None else ["--claims", options.file.name]
    words += [word for call in list_calls(options) for word in ("--claim", call)]
    return shlex.join(words)


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
        told = f"{outputs.FOUND} {claim.shown} of the {claim.team} holds in it; profile {content_hash(profile)}"
        files[where.part.region.name] = f"{told}\n{region_toml(where.part.region)}"
    return files


def file_names(asked: Sequence[Asked], page: bool) -> str:
    """A pattern of the names that a run on these questions may write into its folder. `page`: one that plays too."""
    claims = "|".join(rf"{number}-{re.escape(one.claim.name)}" for number, one in enumerate(asked, 1))
    names = rf"report\.(html|txt)|(certificate|counterexample|zones|states)-({claims})(-[\w-]+)?\.(json|csv)"
    return rf"{names}|play\.html" if page else names


def list_given(options: VerifyOptions) -> list[Path]:
    """The files that claims and regions are read from: the region, the property file, and the regions that it names, as
    seen from its own folder.
    """
    given = [Path(options.region)]
    if options.file is not None:
        text = runs.read(options.file, MAX_FILE_BYTES).decode()
        named = [table.get("region") for table, _ in properties(*parse(text, options.file.name, "not readable", ""))]
        given += [options.file, *(options.file.parent / each for each in named if isinstance(each, str))]
    asked = [read_call(written).get("region") for written in options.claims]
    return [*map(runs.ensure_visible, (*given, *(Path(each) for each in asked if isinstance(each, str))))]


def ensure_free(output: Path, asked: Sequence[Asked], options: VerifyOptions) -> None:
    """InputError when a region found would be written over a region asked about, or a file that is no region found."""
    regions = {path.resolve() for path in list_given(options)}
    for number, one in enumerate(asked, 1):
        path = output / region_file(number, one.claim)
        if path.resolve() in regions or (path.is_file() and not path.read_bytes().startswith(outputs.FOUND.encode())):
            raise InputError("the region found would overwrite a file", str(path), "choose another folder with -o")
