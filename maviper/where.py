"""Where claims hold, as lines and files.

Does: says in a few lines what `verify.where` found; the files of violating zones and of the regions found.
Assumes: results of `claims.verify_claims`.
Does not: look for anything.
"""

from collections.abc import Mapping, Sequence
from typing import Any

from codegen.errors import InputError
from codegen.ir import PolicyProfile
from maviper.console import Console
from maviper.questions import Asked
from verify.closed_loop import LoopResult
from verify.engine import Result
from verify.episodes import ClosedLoop
from verify.violations import DEFAULT_ZONES
from verify.where_report import zones_json

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
            files[result.where.part.region.name] = result.where.part.region.toml()
    return files


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
    exact = f"share not exact: {found.share_reason}" if found.share is None else _percent(float(found.share.value))
    console.line("", f"{found.count} violating zones, {exact}{' of the region exactly' if found.share else ''}")
    if found.part is None or inner is None:
        console.line("", f"no region in which it holds: {found.part_reason}")
        return
    share = found.part.share.value if found.part.exact is None else float(found.part.exact)
    line = f"{inner.verdict.value} in {_percent(share)} of the region, conflict share there {inner.shares.conflict}"
    if inner.visited is not None:
        line += f", {_percent(inner.visited.inside / inner.visited.states)} of on-policy states inside"
    console.line("", line)


def _percent(share: float) -> str:
    return f"{100 * share:.3g} %"
