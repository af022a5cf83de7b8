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
from maviper.certifying import certificate_files
from maviper.claims import find_region, report_files, verify_claims
from maviper.console import Console
from verify.engine import DEFAULT_BUDGET, Result
from verify.properties import Property, find_property
from verify.spec import Verdict
from verify.spec import text as decimal


def verify_command(profile: Path, options: Mapping[str, Any], console: Console) -> int:
    """The command `maviper verify`; returns its exit code."""
    budget = DEFAULT_BUDGET if options["budget"] is None else options["budget"]
    if not 0 < budget < 2**32:
        raise InputError("the budget must be between 1 and 2**32", "--budget")
    loaded = load(profile)
    parameters = {"margin": options["margin"], "radius": options["radius"]}
    region = find_region(options["region"], loaded)
    questions = [(find_property(name, loaded, options["team"], **parameters), region) for name in options["names"]]
    output = options["output"]
    if output is not None:
        runs.folder(output)
    results = verify_claims(loaded, questions, budget)
    commands = [command(profile.name, claim, region.name, budget) for claim, region in questions]
    say_results(results, console)
    files = report_files(loaded, results, commands, {})
    if output is not None:
        proofs = certificate_files(results)
        for name, text in (files | proofs).items():
            runs.write(output / name, text)
        console.line("report", str(output / "report.html"))
        for name in proofs:
            console.line("certificate", f"{output / name}; maviper check {output / name} --profile {profile}")
    if options["as_json"]:
        click.echo(files["report.json"], nl=False)
    elif output is None:
        click.echo(files["report.txt"], nl=False)
    return exit_code(results)


def command(profile: str, claim: Property, region: str, budget: int = DEFAULT_BUDGET) -> str:
    """The command line that repeats a question, run beside the profile and the region file."""
    words = ["maviper", "verify", profile, "--property", claim.name, "--team", claim.team, "--region", region]
    if claim.margin or claim.radius != Property("", "").radius:
        words += ["--margin", decimal(claim.margin).strip('"'), "--radius", decimal(claim.radius).strip('"')]
    if budget != DEFAULT_BUDGET:
        words += ["--budget", str(budget)]
    return shlex.join(word.encode(errors="replace").decode() for word in words)


def say_results(results: Sequence[Result], console: Console) -> None:
    """One block of lines a result."""
    for result in results:
        console.line(
            result.verdict.value, f"{result.claim.name} of the {result.claim.team}, region {result.region.name}"
        )
        conflict = f"conflict share {result.shares.conflict}, violating {result.shares.violating}"
        console.line("", f"{conflict}, shuffled control {result.control.value}")
        if result.reason:
            console.line("", result.reason)
        if result.counterexample is not None:
            found = result.counterexample
            acts = "; ".join(
                f"{view.agent} goes {view.action}, engaged with {', '.join(view.engaged_with) or 'no landmark'}"
                for view in found.agents
            )
            place = ", ".join(f"{name} {value:g}" for name, value in found.point.position.items())
            console.line("", f"counterexample: {acts}")
            console.line("", f"at {place}, goal {found.point.goal or 'none'}")
            console.line("", f"replayed by {', '.join(found.replayed)}")


def exit_code(results: Sequence[Result]) -> int:
    """The worst verdict as an exit code: violated before inconclusive before proved."""
    verdicts = {result.verdict for result in results}
    if Verdict.VIOLATED in verdicts:
        return ExitCode.VIOLATED
    return ExitCode.DONE if verdicts == {Verdict.PROVED} else ExitCode.INCONCLUSIVE
