"""The command verify.

Does: asks what the options ask, prints verdicts, writes the report and what belongs to it; lists the built-in claims;
  writes a property file to start from.
Assumes: `maviper.verification.run` decides; `maviper.verification.ask.VerifyOptions` has a field for each option.
Does not: decide verdicts, or check values beyond their form.
"""

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from codegen.errors import ExitCode, InputError
from codegen.wording import format_count
from maviper import options as tables
from maviper.cli.options import (
    FOLDER,
    PATH,
    PROFILE,
    REGION,
    RESULTS,
    FolderPath,
    Verb,
    console_of,
    option,
    options_of,
    print_json,
)
from maviper.cli.prove import robust
from maviper.options.verbs import BUDGETS, QUESTION
from verify.claims.parameters import NAMES as PARAMETERS

if TYPE_CHECKING:
    from codegen.ir import PolicyProfile
    from maviper.console import Console
    from maviper.verification.ask import Asked, VerifyOptions
    from maviper.verification.run import Verified
    from maviper.verification.stated import StatedWorld
    from verify.result import Verdict


MAX_STARTER_BYTES = 2**24
ROBUST, OF_ROBUST = "robust", ("observations", "agent", "error", "least", "most", "certify")


def _write_starter(subject: str, output: Path | None) -> int:
    """Writes claims to start from, for the name of a world or a profile's file."""
    from maviper.files import runs
    from maviper.verification.starters import starter

    if output is not None:
        runs.target(output, "claims.toml")
    text = starter(subject)
    if output is None:
        click.echo(text, nl=False)
    elif not runs.create(output, text) and runs.read(output, MAX_STARTER_BYTES) != text.encode():
        raise InputError("the file exists, with other content", str(output), "choose another name with -o")
    return ExitCode.DONE


def print_properties(as_json: bool) -> int:
    """Prints the built-in properties, for people or as JSON."""
    from maviper.verification.starters import list_properties

    if as_json:
        print_json({"properties": list_properties()})
        return ExitCode.DONE
    for entry in list_properties():
        click.echo(f"{entry['name']}: {entry['sentence']}")
        for name, default in entry["parameters"].items():
            click.echo(f"  {name} (default: {default or _of_the_world(entry['name'], name)})")
    click.echo(f"{ROBUST}: no error of features changes what is done at the observations of a file")
    click.echo(f"  {', '.join(OF_ROBUST)} (see `maviper guide claims`)")
    return ExitCode.DONE


def _of_the_world(claim: str, parameter: str) -> str:
    """A default that depends on the world, in words."""
    usual = {"steps": "the world's episode", "radius": "the distance at which they touch", "others": "one another"}
    usual |= dict.fromkeys(("agents", "agent", "feature"), "none, state it") | {
        "order": "the profile's order",
        "features": "all of them",
    }
    if parameter in usual:
        return usual[parameter]
    return "any matching" if claim == "covers" else "the order of the world"


def _list_properties(context: click.Context, _parameter: click.Parameter, asked: bool) -> None:
    if asked and not context.resilient_parsing:
        print_properties(bool(context.obj and context.obj.get("json")))
        context.exit(ExitCode.DONE)


QUESTION_OPTIONS = (
    option(
        "--claim",
        "claims",
        multiple=True,
        metavar="CLAIM",
        section=QUESTION,
        help='A built-in claim, such as "reaches(steps=25)" (repeatable; default: distinct_targets).',
    ),
    option("--property", "names", multiple=True, metavar="NAME"),
    option("--properties", "file", type=PATH, default=None, section=QUESTION, help="A property file (TOML)."),
    option(
        "--list",
        is_flag=True,
        is_eager=True,
        expose_value=False,
        callback=_list_properties,
        section=QUESTION,
        help="List the built-in claims with their parameters.",
    ),
    option("--new", is_flag=True, section=QUESTION, help="Write claims to start from, for PROFILE or a world's name."),
    option(
        "--system",
        "world",
        type=PATH,
        default=None,
        section=QUESTION,
        help="A world file (TOML): claims are about the system that it states. Default: those of the file.",
    ),
    options_of(tables.SystemOptions, "run_reference"),
    REGION,
)


MAX_SECONDS = option(
    "--max-seconds",
    type=click.FloatRange(0, min_open=True),
    section=BUDGETS,
    help="End after so many seconds; claims without an answer by then are UNKNOWN.",
)
CALL = '--claim "{}"'
OLD_OPTIONS = {
    **{f"--{each}": CALL.format(f"NAME({each}=...)") for each in (*PARAMETERS, "team")},
    "--property": CALL.format("NAME"),
    **dict.fromkeys(("--solver-units", "--max-zones", "--max-boxes", "--max-cells"), "--effort low|normal|high"),
    "--world": "--system",
}


def add_verify_options(command: Any) -> Any:
    """Adds all of them to a command."""
    of_systems = options_of(tables.SystemOptions, "max_boxes")
    for each in reversed((*QUESTION_OPTIONS, options_of(tables.VerifyOptions), of_systems, MAX_SECONDS)):
        command = each(command)
    return command


@click.command(
    cls=Verb,
    json=True,
    renamed=OLD_OPTIONS,
    example="maviper verify demo/profile.json --region near.toml\n"
    'maviper verify demo/profile.json --claim "reaches(steps=25)" -o report',
)
@PROFILE
@add_verify_options
@option(
    "-o",
    "--output",
    type=FolderPath(".toml"),
    default=None,
    section=RESULTS,
    help="Folder for report, certificates and page; with --new, the file.",
)
@option("--verdict-only", is_flag=True, section=RESULTS, help="Print the verdicts alone, in less time.")
@option("--junit", type=PATH, default=None, section=RESULTS, help="File for the verdicts as JUnit XML, for CI.")
@option("--smt", type=FOLDER, default=None, section=RESULTS, help="Folder for the queries to Z3, as SMT-LIB.")
@click.pass_context
def verify(
    context: click.Context,
    profile: Path,
    claims: tuple[str, ...],
    output: Path | None,
    new: bool,
    as_json: bool,
    **options: Any,
) -> int:
    """Decide claims about a profile for every state of a region.

    Verdicts are about the deployed float arithmetic, rounding included. --list has the built-in claims. For claims of
    your own, --new writes a starter property file.

    reaches, covers and keeps_apart are about whole episodes that start in the region, at rest. reaches: each agent
    comes within the radius of its own landmark at some step. covers: after the last step, the team is matched to the
    landmarks. keeps_apart: no agent of the team comes too near to the others. Contact forces are over-approximated, so
    in worlds with contacts proofs need starts that are apart.

    If a claim is violated, --where lists every failing cell: one leaf per agent, and bounds on positions. It also gives
    the exact share of the region that these cells cover, and the largest region found in which the claim is proved
    although it could fail. With -o, this region is written as a file that --region reads.

    With --system, claims are about the system that a world file defines: stays_in, avoids, reaches and
    reaches_and_stays with regions of its variables, and formulas over single decisions. Verdicts are then of the stated
    dynamics, with the error that the file states; if it names an environment, 100,000 steps of that are compared with
    the statement.
    `maviper guide systems` has the form of the file.

    \b
    A region file states exact bounds. Positions that it omits have the bounds of
    the start region:
      goals = ["landmark_0"]
      default = [-1, 1]
      [box]
      "agent_0.x" = [-0.5, 0.25]
      [difference]
      "agent_0.x - agent_1.x" = [0, 1]
      [apart]
      "landmark_0 - landmark_1" = 0.2
    """
    if new:
        return _write_starter(str(profile), output)
    console = console_of(context)
    console.line("verifying", str(profile))
    if options.get("world") is None and any(each.partition("(")[0].strip() == ROBUST for each in claims):
        return context.invoke(robust, **_read_robust(claims), profile=profile, output=output, as_json=as_json)
    if output is not None:
        FOLDER.convert(output, next(each for each in context.command.params if each.name == "output"), context)
    return _decide_claims(profile, {**options, "claims": claims}, output, as_json, context.obj["verbose"], console)


def _read_robust(claims: Sequence[str]) -> dict[str, Any]:
    """What the claim `robust` says of the observations of a file, as the parameters of its command."""
    from verify.claims.calls import read_call
    from verify.decimals import number

    if len(claims) > 1:
        raise InputError(f"{ROBUST} is about the observations of a file", "--claim", "ask it alone")
    call = read_call(claims[0])
    for key in call:
        if key not in ("name", *OF_ROBUST):
            raise InputError(f"{ROBUST} has no parameter {key}", "--claim", f"it has {', '.join(OF_ROBUST)}")
    if "observations" not in call:
        raise InputError(f"{ROBUST} needs observations", "--claim", f"write {ROBUST}(observations=FILE)")
    bounds = {key: number(call[key], f"--claim: {key}") for key in ("most", "least") if key in call}
    texts = {key: str(call[key]) for key in ("agent", "error") if key in call}
    usual = dict.fromkeys(("agent", "error", "most", "least"))
    certify = call.get("certify", False) in (True, "true", "yes")
    return usual | texts | bounds | {"observations": Path(str(call["observations"])), "certify": certify}


def _decide_claims(
    profile: Path, options: dict[str, Any], output: Path | None, as_json: bool, full: bool, console: "Console"
) -> int:
    """Decides, prints and writes; the exit code."""
    from maviper.cli.exits import limit_seconds
    from maviper.cli.results import exit_code, say_details, say_results, say_verdict
    from maviper.files import runs
    from maviper.files.profiles import load
    from maviper.verification.ask import VerifyOptions
    from maviper.verification.run import pose_questions, verdicts, verify_questions
    from verify.claims.wording import spell_rounded
    from verify.result import Verdict
    from verify.spending import listening

    late = Verdict.UNKNOWN, "no answer in time"
    seconds, junit = options.pop("max_seconds"), options.pop("junit")
    asking = VerifyOptions.of(options).ensure_usable()
    if output is not None and asking.verdict_only:
        raise InputError("--verdict-only writes no report", "-o", "leave one of them out")
    loaded, unread = load(profile, sums=True), list[InputError]()
    with console.following("reading") as listener, listening(listener):
        asked, stated = pose_questions(loaded, profile.name, asking, unread.append)
    if any(one.question.viewed is not None for one in asked) and not asking.observations:
        console.line("observed", "no feature has a meaning, so claims are about what agents observe")
    for words in spell_rounded(dict.fromkeys(pair for one in asked for pair in one.claim.rounded)):
        console.line("number", words)
    given = {runs.PROFILE_FILE: profile, **(stated.given if stated else {})}
    _folders(output, asked, asking, console)
    if output is not None:
        _ensure_free(output, loaded, asked, asking, stated, given)
    if asking.verdict_only:
        answers = list(verdicts([one.question for one in asked], stated, asking.jobs))
        if junit is not None:
            _write_junit(junit, profile, asked, answers)
        return _end_with(_print_verdicts(asked, answers, stated, as_json), unread)
    with console.following("deciding") as listener, listening(listener):
        said = stated.said if stated else []
    for about, words in said:
        console.line(about, words)
    with console.following("deciding") as listener, listening(listener), limit_seconds(seconds) as is_over:
        done = verify_questions(loaded, asked, asking, lambda one: say_verdict(loaded, one, console), stated, is_over)
    if junit is not None:
        known = {id(one): result for one, result in zip(done.asked, done.results, strict=True)}
        answers = [(known[id(one)].verdict, known[id(one)].reason) if id(one) in known else late for one in asked]
        _write_junit(junit, profile, asked, answers)
    open_claims = [one for one in asked if one not in done.asked]
    for one in open_claims if is_over() else ():
        console.result(Verdict.UNKNOWN.value, f"{one.words}: no answer within {seconds:g} s (--max-seconds)")
    say_details(loaded, done.results, console)
    if full or asking.where:
        say_results(loaded, done.results, console)
    written: list[tuple[str, str]] = []
    if output is not None and done.results:
        written = _write(output, done, given, asking)
        console.result("report", str(output / "report.html"))
    console.result("next", _next_command(written, done, asked))
    for label, text in written if full or asking.where else ():
        console.line(label, text)
    if as_json or full:
        click.echo(done.printed(as_json), nl=False)
    if open_claims and is_over():
        return _end_with(exit_code([*(result.verdict for result in done.results), Verdict.UNKNOWN]), unread)
    if open_claims:
        console.line("interrupted", f"{len(done.results)} of {format_count(len(asked), 'claim')} decided")
        raise KeyboardInterrupt
    return _end_with(exit_code([result.verdict for result in done.results]), unread)


def _end_with(code: int, unread: "Sequence[InputError]") -> int:
    """The exit code. The fault of properties that cannot be read is told after the verdicts on the others."""
    for fault in unread:
        raise fault
    return code


def _ensure_free(
    folder: Path,
    profile: "PolicyProfile",
    asked: "Sequence[Asked]",
    options: "VerifyOptions",
    stated: "StatedWorld | None",
    given: "Mapping[str, Path]",
) -> None:
    """InputError where files that were given, or of somebody else, would be written over."""
    from codegen.policy_json import dumps
    from maviper.files import outputs, runs
    from maviper.verification.files.places import file_names, list_given

    texts = {runs.PROFILE_FILE: dumps(profile), **(stated.beside if stated else {})}
    known = outputs.without_given(folder, texts, given)
    read = [*outputs.list_elsewhere(folder, given), *list_given(options)]
    outputs.ensure_free(folder, outputs.VERIFY, known, read, file_names(asked, page=stated is None))


def _folders(
    output: Path | None,
    asked: "Sequence[Asked]",
    options: "VerifyOptions",
    console: "Console",
) -> None:
    """Folders for what will be written, before anything is decided; questions for other programs at once."""
    from maviper.files import runs
    from maviper.verification.files.places import ensure_free

    if output is not None and options.cells is not None:
        ensure_free(output, asked, options)
    for folder in (output, options.smt):
        if folder is not None:
            runs.room(folder)
    if options.smt is not None:
        _export(asked, options.smt, console)


def _write_junit(file: Path, profile: Path, asked: "Sequence[Asked]", answers: "Sequence[tuple[Verdict, str]]") -> None:
    from maviper.cli.results import write_junit
    from maviper.files import runs

    told = [(one.words, *answer) for one, answer in zip(asked, answers, strict=True)]
    runs.write(runs.target(file, "verdicts.xml"), write_junit(profile.name, told))


def _print_verdicts(
    asked: "Sequence[Asked]",
    decided: "Sequence[tuple[Verdict, str]]",
    stated: "StatedWorld | None",
    as_json: bool,
) -> int:
    """A line of standard output for each verdict, or an object for all; the exit code."""
    from maviper.cli.results import exit_code
    from maviper.console import say

    documents: list[dict[str, str]] = []
    answers: list[Verdict] = []
    for one, (verdict, reason) in zip(asked, decided, strict=True):
        answers.append(verdict)
        told = {"verdict": verdict.value, "property": one.claim.shown, "team": one.claim.team}
        documents.append(told | {"region": one.region.name, "reason": reason})
        if not as_json:
            say(f"{verdict.value:<11} {one.words}" + (f": {reason}" if reason else ""))
    if as_json:
        click.echo(json.dumps(({"of": stated.about} if stated else {}) | {"results": documents}, indent=2))
    return exit_code(answers)


def _export(asked: "Sequence[Asked]", folder: Path, console: "Console") -> None:
    """The questions for other programs, and which of the claims have none."""
    from maviper.files import outputs
    from maviper.verification.run import question_files

    files = question_files([one.question for one in asked])
    outputs.write_questions(folder, files)
    console.line("questions", f"{folder}, as SMT-LIB")
    for number, one in enumerate(asked, 1):
        if not any(name.startswith(f"{number:02d}-") for name in files):
            console.line("", f"not exported: {one.claim.shown}, which is decided by zones without a solver")


def _write(
    folder: Path, done: "Verified", given: "Mapping[str, Path]", options: "VerifyOptions"
) -> list[tuple[str, str]]:
    """Writes all files, without those of an earlier run; labels and texts of each, with the command that reads it."""
    from maviper.files import outputs, runs
    from maviper.verification.files.places import list_given

    page, no_page, page_file = dict[str, str](), "", Path()
    if done.stated is None:  # no page plays a system, and what makes pages takes long to load
        from maviper.page.page import FILE, page_of, unplayable

        no_page, page_file = unplayable(done.profile), folder / FILE
        page = {} if no_page else {FILE: page_of(done.profile, done.results)}
    files = outputs.without_given(folder, {**done.files, **page}, given)
    outputs.write_set(folder, files, outputs.VERIFY, keep=[*given.values(), *list_given(options)])
    written = [] if done.stated else [("no page" if no_page else "page", no_page or str(page_file))]
    beside = "" if done.stated else f" --profile {given[runs.PROFILE_FILE]}"
    for name in done.certificates:
        written.append(("certificate", f"{folder / name}; maviper check {folder / name}{beside}"))
    for name in done.places:
        written.append(("where", str(folder / name)))
    for name in done.counterexamples:
        if name.endswith(".json"):
            written.append(("replay", f"maviper replay {folder / name}"))
    for name in done.states:
        written.append(("states", f"{folder / name}; maviper extract EXPERT --counterexamples {folder}"))
    return written


def _next_command(written: "Sequence[tuple[str, str]]", done: "Verified", asked: "Sequence[Asked]") -> str:
    """What a reader does next: replay what fails, check what is proved, ask with more effort."""
    from verify.result import Verdict

    verdicts = [result.verdict for result in done.results]
    if len(verdicts) < len(asked) or (Verdict.UNKNOWN in verdicts and Verdict.VIOLATED not in verdicts):
        return "more may be decided with --effort high, or in a smaller region"
    if not written:
        return "-o FOLDER writes a report, with what `maviper replay` and `maviper check` take"
    wanted = "replay" if Verdict.VIOLATED in verdicts else "certificate"
    return next(
        (text.partition("; ")[2] or text for label, text in written if label == wanted), "maviper guide verdicts"
    )
