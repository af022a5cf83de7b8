"""Verification as a command: load, ask, print, write the report.

Does: turns options into questions and results into lines and an exit code.
Assumes: `claims` joins verifier and simulator.
Does not: decide verdicts.
"""

import shlex
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import click

from codegen.errors import ExitCode, InputError
from maviper import load, runs
from maviper.claims import find_claim, find_region, report_files, verify_claims
from maviper.console import Console
from verify.closed_loop import DEFAULT_ZONES, ClosedLoop, LoopResult
from verify.engine import DEFAULT_BUDGET, Result
from verify.properties import Property
from verify.spec import Verdict
from verify.spec import text as decimal
from verify.world import Point

MOST_ZONES = 10**12


def verify_command(profile: Path, options: Mapping[str, Any], console: Console) -> int:
    """The command `maviper verify`; returns its exit code."""
    budget = DEFAULT_BUDGET if options["budget"] is None else options["budget"]
    if not 0 < budget < 2**32:
        raise InputError("the budget must be between 1 and 2**32", "--budget")
    loaded = load(profile)
    if not 0 < options["zones"] <= MOST_ZONES:
        raise InputError(f"the budget of zones must be between 1 and {MOST_ZONES:,}", "--zones")
    parameters = {name: options[name] for name in ("margin", "radius", "steps")}
    parameters["landmarks"] = options["landmarks"] and [name.strip() for name in options["landmarks"].split(",")]
    region = find_region(options["region"], loaded)
    questions = [(find_claim(name, loaded, options["team"], **parameters), region) for name in options["names"]]
    output = options["output"]
    if output is not None:
        runs.folder(output)
    zones = options["zones"]
    results = verify_claims(loaded, questions, budget, zones)
    commands = [command(profile.name, claim, region.name, budget, zones) for claim, region in questions]
    say_results(results, console)
    files = report_files(loaded, results, commands, {})
    if output is not None:
        for name, text in files.items():
            runs.write(output / name, text)
        console.line("report", str(output / "report.html"))
    if options["as_json"]:
        click.echo(files["report.json"], nl=False)
    elif output is None:
        click.echo(files["report.txt"], nl=False)
    return exit_code(results)


def command(
    profile: str, claim: Property | ClosedLoop, region: str, budget: int = DEFAULT_BUDGET, zones: int = DEFAULT_ZONES
) -> str:
    """The command line that repeats a question, run beside the profile and the region file."""
    words = ["maviper", "verify", profile, "--property", claim.name, "--team", claim.team, "--region", region]
    if isinstance(claim, ClosedLoop):
        words += ["--steps", str(claim.steps), "--radius", decimal(claim.radius).strip('"')]
    elif claim.margin or claim.radius != Property("", "").radius:
        words += ["--margin", decimal(claim.margin).strip('"'), "--radius", decimal(claim.radius).strip('"')]
    words += ["--landmarks", ",".join(claim.landmarks)] if claim.landmarks else []
    if isinstance(claim, ClosedLoop):
        words += ["--zones", str(zones)] if zones != DEFAULT_ZONES else []
    elif budget != DEFAULT_BUDGET:
        words += ["--budget", str(budget)]
    return shlex.join(word.encode(errors="replace").decode() for word in words)


def say_results(results: Sequence[Result | LoopResult], console: Console) -> None:
    """One block of lines a result."""
    for result in results:
        console.line(
            result.verdict.value, f"{result.claim.name} of the {result.claim.team}, region {result.region.name}"
        )
        if isinstance(result, LoopResult):
            console.line("", f"violating {result.violating} of sampled starts, shuffled control {result.control.value}")
        else:
            conflict = f"conflict share {result.shares.conflict}, violating {result.shares.violating}"
            console.line("", f"{conflict}, shuffled control {result.control.value}")
        if result.reason:
            console.line("", result.reason)
        if isinstance(result, LoopResult):
            _say_course(result, console)
        elif result.counterexample is not None:
            found = result.counterexample
            acts = "; ".join(
                f"{view.agent} goes {view.action}, engaged with {', '.join(view.engaged_with) or 'no landmark'}"
                for view in found.agents
            )
            console.line("", f"counterexample: {acts}")
            console.line("", _place(found.point))
            console.line("", f"replayed by {', '.join(found.replayed)}")


def _say_course(result: LoopResult, console: Console) -> None:
    if result.verdict is Verdict.PROVED:
        followed = "; ".join(" with ".join(agents) for agents in result.followed)
        console.line("", f"{result.zones:,} zones; followed: {followed}; whatever all others do")
    if result.point is not None:
        ways = "; ".join(map(str, result.ways))
        console.line("", f"counterexample: {ways}")
        console.line("", _place(result.point))
        console.line("", f"replayed by {', '.join(('reference', *result.replays))}")


def _place(point: Point) -> str:
    place = ", ".join(f"{name} {value:g}" for name, value in point.position.items())
    return f"at {place}, goal {point.goal or 'none'}"


def exit_code(results: Sequence[Result | LoopResult]) -> int:
    """The worst verdict as an exit code: violated before inconclusive before proved."""
    verdicts = {result.verdict for result in results}
    if Verdict.VIOLATED in verdicts:
        return ExitCode.VIOLATED
    return ExitCode.DONE if verdicts == {Verdict.PROVED} else ExitCode.INCONCLUSIVE
