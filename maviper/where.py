"""Where claims hold, as lines and files.

Does: says in a few lines what `verify.where` found; the files of violating zones and of the regions found.
Assumes: results of `claims.verify_claims`.
Does not: look for anything.
"""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from codegen.errors import InputError
from codegen.ir import PolicyProfile
from codegen.policy_json import content_hash
from maviper.claims import region_file
from maviper.console import Console
from maviper.questions import Asked
from verify.closed_loop import LoopResult
from verify.engine import Result
from verify.episodes import ClosedLoop
from verify.violations import DEFAULT_ZONES
from verify.where_report import zones_json

FOUND = "# Found by maviper verify --where:"  # what the file of a region found begins with
MOST_ZONES = 1_000_000  # a zone takes about 2 KB


def zones_wanted(options: Mapping[str, Any]) -> int | None:
    """The violating zones that the options of `maviper verify` ask for at most; None without --where."""
    given = options["where_zones"]
    if given is not None and not options["where"]:
        raise InputError("nothing asks where the claims hold", "--where-zones", "add --where")
    if given is not None and not 0 < given <= MOST_ZONES:
        raise InputError(f"the zones must be between 1 and {MOST_ZONES}", "--where-zones")
    return (given or DEFAULT_ZONES) if options["where"] else None


def repeated(asked: Asked, wanted: int | None) -> str:
    """The command line that repeats a question."""
    if wanted is None or isinstance(asked.claim, ClosedLoop):
        return asked.command
    return f"{asked.command} --where" + (f" --where-zones {wanted}" if wanted != DEFAULT_ZONES else "")


def where_files(profile: PolicyProfile, results: Sequence[Result | LoopResult]) -> dict[str, str]:
    """For each result with zones `zones-N-NAME.json`, for each region found `region-N-NAME.toml`, name -> text."""
    files: dict[str, str] = {}
    for place, result in enumerate(results, 1):
        if not isinstance(result, Result) or result.where is None:
            continue
        if result.where.count:
            files[f"zones-{place}-{result.claim.name}.json"] = zones_json(profile, result)
        if result.where.part is not None:
            told = (
                f"{FOUND} {result.claim.shown} of the {result.claim.team} holds in it; profile {content_hash(profile)}"
            )
            files[result.where.part.region.name] = f"{told}\n{result.where.part.region.toml()}"
    return files


def ensure_free(output: Path, asked: Sequence[Asked], options: Mapping[str, Any]) -> None:
    """InputError when a region found would be written over a region asked about, or a file that is no region found."""
    folders = [Path(options["region"]).parent, *([options["properties"].parent] if options["properties"] else [])]
    regions = {(folder / one.region.name).resolve() for folder in folders for one in asked}
    for number, one in enumerate(asked, 1):
        path = output / region_file(number, one.claim)
        if path.resolve() in regions or (path.is_file() and not path.read_bytes().startswith(FOUND.encode())):
            raise InputError("the region found would overwrite a file", str(path), "choose another folder with -o")


def say_where(result: Result, console: Console) -> None:
    """Zones, exact share and the largest region found, in lines."""
    found, inner = result.where, result.within
    assert found is not None
    if found.everywhere or found.reason:
        said = (
            "holds everywhere in the region" if found.everywhere else f"where it holds: not available: {found.reason}"
        )
        console.line("", said)
        return
    zones = f"{found.count} violating {'zone' if found.count == 1 else 'zones'}"
    exact = f"share not exact: {found.share_reason}" if found.share is None else _percent(float(found.share.value))
    console.line("", f"{zones}, {exact}{' of the region exactly' if found.share else ''}")
    if found.part is None or inner is None:
        if found.complete:
            console.line("", f"no region to name: {found.part_reason}")
        return
    share = found.part.share.value if found.part.exact is None else float(found.part.exact)
    line = f"{inner.verdict.value} in {_percent(share)} of the region, conflict share there {inner.shares.conflict}"
    if inner.visited is not None:
        line += f", {_percent(inner.visited.inside / inner.visited.states)} of on-policy states inside"
    console.line("", line)


def _percent(share: float) -> str:
    return f"{100 * share:.3g} %"
