"""The command verify with --world: verdicts about a system that a file states.

Does: takes the options that are about it; prints verdicts, writes the report and what belongs to it.
Assumes: `maviper.verification.stated` decides.
Does not: decide verdicts.
"""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from codegen.errors import InputError

if TYPE_CHECKING:
    from maviper.console import Console
    from maviper.verification.stated import StatedOptions, StatedVerified

OWN = ("world", "run_reference", "max_states", "max_programs")
SHARED = ("file", "verdict_only")
USUAL = {"region": "start", "semantics": "machine"}


def taken(options: dict[str, Any]) -> "StatedOptions | None":
    """What the options ask of a stated system; None where no world file is given. Takes its own options out.

    InputError for options that are about one of the two only.
    """
    own = {name: options.pop(name) for name in OWN}
    if own["world"] is None:
        for name in OWN[1:]:
            if own[name]:
                option = f"--{name.replace('_', '-')}"
                raise InputError(f"{option} has no effect without --world", option, "add --world FILE")
        return None
    for name, value in options.items():
        if name not in SHARED and value and value != USUAL.get(name):
            option = f"--{ {'names': 'property'}.get(name, name).replace('_', '-') }"
            advice = "leave it out; the file states claims and regions"
            raise InputError(f"{option} has no effect with --world", option, advice)
    from maviper.verification.stated import StatedOptions

    alone = bool(options.get("verdict_only"))
    if alone and own["run_reference"]:
        advice = "leave one of them out"
        raise InputError("--run-reference has no effect with --verdict-only", "--run-reference", advice)
    limits = own["max_states"], own["max_programs"]
    for option, limit in zip(("--max-states", "--max-programs"), limits, strict=True):
        if limit is not None and limit < 1:
            raise InputError(f"{option} must be at least 1, given {limit}", option, "leave it out for the usual limit")
    return StatedOptions(
        own["world"],
        options.get("file"),
        max_states=limits[0],
        max_programs=limits[1],
        run_reference=own["run_reference"],
        verdict_only=alone,
    )


def answered(
    profile: Path, asked: "StatedOptions", output: Path | None, as_json: bool, full: bool, console: "Console"
) -> int:
    """Decides, prints and writes; the exit code."""
    from codegen.policy_json import dumps
    from maviper.cli.results import exit_code
    from maviper.files import outputs, runs
    from maviper.files.profiles import load
    from maviper.verification.stated import MAX_WORLD_BYTES, PROPERTY_FILE, WORLD_FILE, verified
    from verify.progress import listening
    from verify.reports import systems as report

    if output is not None and asked.verdict_only:
        raise InputError("--verdict-only writes no report", "-o", "leave one of them out")
    loaded = load(profile)
    given = {runs.PROFILE_FILE: profile, WORLD_FILE: asked.world}
    given |= {} if asked.file is None else {PROPERTY_FILE: asked.file}
    if output is not None:
        runs.room(output)
        beside = outputs.without_given(
            output, {name: runs.read(path, MAX_WORLD_BYTES) for name, path in given.items()}, given
        )
        beside |= {runs.PROFILE_FILE: dumps(loaded)} if runs.PROFILE_FILE in beside else {}
        outputs.ensure_own(output, beside, outputs.VERIFY)
    with console.following("deciding") as listener, listening(listener):
        done = verified(loaded, asked)
    if asked.verdict_only:
        return _verdicts(done, as_json)
    told = done.document
    console.line("about", told["of"])
    for said in told["reference"].get("said", []):
        console.line("reference", said)
    for each in told["results"]:
        console.line(each["verdict"], each["property"])
        for line in report.lines(each):
            console.line("", line)
    if output is not None:
        _write(output, done, given, console)
    if as_json or full:
        click.echo(report.as_json(told) if as_json else report.as_text(told), nl=False)
    return exit_code([result.verdict for result in done.results])


def _verdicts(done: "StatedVerified", as_json: bool) -> int:
    """A line of standard output for each verdict, or an object for all; the exit code."""
    from maviper.cli.results import exit_code
    from maviper.console import say
    from verify.reports.systems import sentence

    of = sentence(done.statement.system)
    if as_json:
        found = [
            {"verdict": each.verdict.value, "property": each.claim.shown, "reason": each.reason}
            for each in done.results
        ]
        click.echo(json.dumps({"of": of, "results": found}, indent=2))
    else:
        for each in done.results:
            told = f"{each.verdict.value:<11} {each.claim.shown}, {of}"
            say(told + (f": {each.reason}" if each.reason else ""))
    return exit_code([result.verdict for result in done.results])


def _write(folder: Path, done: "StatedVerified", given: Mapping[str, Path], console: "Console") -> None:
    from maviper.files import outputs

    files = outputs.without_given(folder, done.files, given)
    outputs.write_set(folder, files, outputs.VERIFY, keep=[*given.values()])
    console.line("report", str(folder / "report.html"))
    for name in done.certificates:
        console.line("certificate", f"{folder / name}; maviper check {folder / name}")
    for name in done.counterexamples:
        console.line("replay", f"maviper replay {folder / name}")
