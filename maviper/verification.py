"""Verification as a command: load, ask, print, write the report.

Does: turns options into questions and results into lines and an exit code.
Assumes: `claims` joins verifier and simulator.
Does not: decide verdicts.
"""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import click

from codegen.errors import ExitCode, InputError
from codegen.policy_json import dumps, layout
from maviper import load, runs
from maviper.certifying import certificate_files
from maviper.claims import question_files, report_files, verify_claims
from maviper.console import Console
from maviper.failing import states_files
from maviper.questions import listed, questions
from maviper.replaying import counterexample_files
from maviper.where import ensure_free, repeated, say_where, where_files, zones_wanted
from verify.closed_loop import LoopResult
from verify.engine import DEFAULT_BUDGET, Result
from verify.episodes import ClosedLoop
from verify.properties import LEAVES
from verify.spec import REAL, Verdict
from verify.spec import text as decimal
from verify.world import Point


def verify_command(profile: Path, options: Mapping[str, Any], console: Console) -> int:
    """The command `maviper verify`; returns its exit code."""
    budget = DEFAULT_BUDGET if options["budget"] is None else options["budget"]
    if not 0 < budget < 2**32:
        raise InputError("the budget must be between 1 and 2**32", "--budget")
    loaded = load(profile)
    asked = questions(loaded, profile.name, options)
    wanted = zones_wanted(options)
    if wanted is not None and options["output"] is not None:
        ensure_free(options["output"], asked, options)
    for folder in (options["output"], options["smt"]):
        if folder is not None:
            runs.folder(folder)
    if options["smt"] is not None:
        for name, text in question_files(loaded, asked, options["semantics"]).items():
            runs.write(options["smt"] / name, text)
        console.line("questions", f"{options['smt']}, as SMT-LIB")
        for one in asked:
            if isinstance(one.claim, ClosedLoop):
                console.line("", f"not exported: {one.claim.shown}, which zones decide and no solver")
    pairs = [(one.claim, one.region) for one in asked]
    results = verify_claims(loaded, pairs, budget, options["semantics"], wanted)
    say_results(results, console)
    for one in asked:
        if wanted is not None and isinstance(one.claim, ClosedLoop):
            console.line("where", f"not for {one.claim.shown}, which is about episodes")
    files = report_files(loaded, results, [repeated(one, wanted) for one in asked], {})
    output = options["output"]
    if output is not None:
        proofs, failures = certificate_files(results), counterexample_files(loaded, results)
        places, states = where_files(loaded, results), states_files(loaded, asked, results)
        beside = {runs.PROFILE_FILE: dumps(loaded)} if failures else {}
        for name, text in (files | proofs | failures | places | states | beside).items():
            runs.write(output / name, text)
        console.line("report", str(output / "report.html"))
        for name in proofs:
            console.line("certificate", f"{output / name}; maviper check {output / name} --profile {profile}")
        for name in places:
            console.line("where", str(output / name))
        for name in failures:
            if name.endswith(".json"):
                console.line("replay", f"maviper replay {output / name}")
        for name in states:
            console.line("states", f"{output / name}; maviper extract EXPERT --counterexamples {output}")
    if options["as_json"]:
        click.echo(files["report.json"], nl=False)
    elif output is None:
        click.echo(files["report.txt"], nl=False)
    return exit_code(results)


def say_results(results: Sequence[Result | LoopResult], console: Console) -> None:
    """One block of lines a result."""
    for result in results:
        claim = result.claim
        named = claim.label or f"{claim.name} of the {claim.team}"
        named += f", region {result.region.name}"
        real = ", real arithmetic" if isinstance(result, Result) and result.semantics == REAL else ""
        console.line(result.verdict.value, named + real)
        if isinstance(result, LoopResult):
            _say_episodes(result, console)
        elif result.claim.name == LEAVES:
            _say_leaves(result, console)
        else:
            _say_decisions(result, console)
        if isinstance(result, Result) and result.where is not None:
            say_where(result, console)


def _say_decisions(result: Result, console: Console) -> None:
    """What a claim about single decisions rests on, or fails by."""
    conflict = result.shares.conflict or "not measured (too many joint actions)"
    shares = f"conflict share {conflict}, violating {result.shares.violating}"
    console.line("", f"{shares}, shuffled control {result.control.value}")
    if result.reason:
        console.line("", result.reason)
    if result.shares.changing is not None:
        console.line("", f"errors can change an action in {result.shares.changing}")
    if result.largest is not None:
        console.line("", f"stays proved up to margin {decimal(result.largest.proved)}")
    if result.steady_up_to is not None:
        console.line("", f"stays proved up to eps {decimal(result.steady_up_to.proved)}")
    if result.counterexample is not None:
        found = result.counterexample
        acts = "; ".join(
            f"{view.agent} goes {view.action}, engaged with {', '.join(view.engaged_with) or 'no landmark'}"
            for view in found.agents
        )
        console.line("", f"counterexample: {acts}")
        console.line("", _place(found.point))
        for view in found.agents:
            if view.errors:
                errors = ", ".join(f"{name} by {error:g}" for name, error in view.errors)
                console.line("", f"{view.agent} measures wrongly: {errors}")
        console.line("", f"replayed by {', '.join(found.replayed)}")
    if result.explanation is not None:
        _say_why(result.explanation.says(), console)


def _say_episodes(result: LoopResult, console: Console) -> None:
    """What a claim about episodes rests on, or fails by."""
    console.line("", f"violating {result.violating} of sampled starts, shuffled control {result.control.value}")
    if result.reason:
        console.line("", result.reason)
    if result.verdict is Verdict.PROVED:
        followed = "; ".join(" with ".join(agents) for agents in result.followed)
        console.line("", f"{result.zones:,} zones; followed: {followed}; {result.whatever}")
    if result.contacts:
        console.line("", f"contacts: {result.contacts}")
    if result.point is not None:
        console.line("", f"counterexample: {'; '.join(map(str, result.ways))}")
        console.line("", _place(result.point))
        console.line("", f"replayed by {', '.join(('reference', *result.replays))}")
    if result.explanation is not None:
        _say_why(result.explanation.says(), console)


def _say_why(said: Mapping[str, str], console: Console) -> None:
    """What else is known about a counterexample."""
    console.line("", said["unique"])
    console.line("", f"fails by {said['fails by']}")
    console.line("", said["free"])


def _place(point: Point) -> str:
    place = ", ".join(f"{name} {value:g}" for name, value in point.position.items())
    return f"at {place}, goal {point.goal or 'none'}"


def _say_leaves(result: Result, console: Console) -> None:
    """How many leaves are reached, and which are not."""
    for verdict, said in ((Verdict.PROVED, "reached"), (Verdict.VIOLATED, "dead"), (Verdict.UNKNOWN, "open")):
        found = [finding for finding in result.leaves if finding.verdict is verdict]
        named = "" if verdict is Verdict.PROVED else ": " + ", ".join(f"{one.agent} leaf {one.leaf}" for one in found)
        if found:
            console.line("", f"{len(found)} of {len(result.leaves)} leaves {said}{named}")
    if result.reason:
        console.line("", result.reason)


def exit_code(results: Sequence[Result | LoopResult]) -> int:
    """The worst verdict as an exit code: violated before inconclusive before proved."""
    verdicts = {result.verdict for result in results}
    if Verdict.VIOLATED in verdicts:
        return ExitCode.VIOLATED
    return ExitCode.DONE if verdicts == {Verdict.PROVED} else ExitCode.INCONCLUSIVE


def list_properties(as_json: bool) -> int:
    """The command `maviper properties list`."""
    if as_json:
        click.echo(layout({"properties": listed()}))
        return ExitCode.DONE
    for found in listed():
        click.echo(f"{found['name']}: {found['sentence']}")
        for name, default in found["parameters"].items():
            click.echo(f"  --{name} (default: {default or _of_the_world(found['name'], name)})")
    return ExitCode.DONE


def _of_the_world(claim: str, parameter: str) -> str:
    """A default that depends on the world, in words."""
    usual = {"steps": "the world's episode", "radius": "the distance at which they touch", "others": "one another"}
    if parameter in usual:
        return usual[parameter]
    return "any matching" if claim == "covers" else "the order of the world"
