"""The command verify.

Does: asks what the options ask, prints verdicts, writes the report and what belongs to it; lists the built-in claims;
  writes a file of claims to start from.
Assumes: `maviper.verification.run` decides; `maviper.verification.ask.VerifyOptions` has a field for each option.
Does not: decide verdicts, or check values beyond their form.
"""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from codegen.errors import ExitCode, InputError
from codegen.wording import format_count
from maviper.cli.options import (
    FOLDER,
    OBSERVED_REGION,
    PATH,
    PROFILE,
    RESULTS,
    SETTING,
    FolderPath,
    Verb,
    console_of,
    option,
    options_of,
)
from maviper.cli.prove import tell_radii
from maviper.options.verbs import EXTENT, QUESTION, RARER, VERIFY_SETTINGS, LimitOptions, QuestionOptions, SystemOptions

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


def _list_claims(context: click.Context, _parameter: click.Parameter, asked: bool) -> None:
    """Prints the built-in claims, and ends."""
    if not asked or context.resilient_parsing:
        return
    from maviper.verification.starters import list_properties

    known, lines = list_properties(), list[str]()
    for entry in known:
        lines.append(f"{entry['name']}: {entry['sentence']}")
        for name, default in entry["parameters"].items():
            lines.append(f"  {name} (default: {default or _of_the_world(entry['name'], name)})")
    lines.append(f"{ROBUST}: no error of features changes what is done at the observations of a file")
    lines.append(f"  {', '.join(OF_ROBUST)} (see `maviper guide claims`)")
    console_of(context).give({"claims": known}, lines)
    context.exit(ExitCode.DONE)


def _of_the_world(claim: str, parameter: str) -> str:
    """A default that depends on the world, in words."""
    usual = {"steps": "the world's episode", "radius": "the distance at which they touch", "others": "one another"}
    usual |= dict.fromkeys(("agents", "agent", "feature"), "none, state it") | {
        "order": "the profile's order",
        "features": "all of them",
        "actions": "each by itself",
    }
    if parameter in usual:
        return usual[parameter]
    return "any matching" if claim == "covers" else "the order of the world"


@click.command(
    cls=Verb,
    settings=VERIFY_SETTINGS,
    example="maviper verify demo/profile.json --region near.toml\n"
    'maviper verify demo/profile.json --claim "reaches(steps=25)" -o report',
)
@PROFILE
@option(
    "--claim",
    "claims",
    multiple=True,
    metavar="CLAIM",
    section=QUESTION,
    help='A claim, such as "reaches(steps=25)" (repeatable; default: distinct_targets).',
)
@option("--claims", "file", type=PATH, default=None, metavar="FILE", section=QUESTION, help="A file of claims (TOML).")
@option(
    "--list",
    is_flag=True,
    is_eager=True,
    expose_value=False,
    callback=_list_claims,
    section=QUESTION,
    help="List the built-in claims with their parameters.",
)
@option("--new", is_flag=True, section=QUESTION, help="Write a file of claims to start from. PROFILE may be a world.")
@OBSERVED_REGION
@option(
    "--system",
    "world",
    type=PATH,
    default=None,
    metavar="FILE",
    section=QUESTION,
    help="A world file (TOML): claims are about the system that it states. Default: those of the file.",
)
@options_of(QuestionOptions)
@options_of(LimitOptions, "where", "effort", "jobs")
@options_of(SystemOptions, "since")
@option(
    "--max-seconds",
    type=click.FloatRange(0, min_open=True),
    metavar="SECONDS",
    section=EXTENT,
    help="End then; claims that are still open are UNKNOWN.",
)
@option(
    "-o",
    "--output",
    type=FolderPath(".toml"),
    default=None,
    section=RESULTS,
    help="Folder for report, certificates and page; with --new, the file.",
)
@option("--junit", type=PATH, default=None, metavar="FILE", section=RESULTS, help="File for the verdicts, for CI.")
@option("--verdict-only", is_flag=True, section=RARER, help="Print the verdicts alone, in less time.")
@option("--smt", type=FOLDER, default=None, metavar="FOLDER", section=RARER, help="Folder for the queries to Z3.")
@options_of(SystemOptions, "run_reference", "max_boxes")
@options_of(LimitOptions, "max_cells", "solver_units", "max_zones")
@SETTING
def verify(
    console: "Console", profile: Path, claims: tuple[str, ...], output: Path | None, new: bool, **options: Any
) -> int:
    """Decide claims about a team of trees, in every state of a region.

    Verdicts are about the deployed float arithmetic, rounding included. -o writes a report, a counterexample of each
    violated claim (`maviper replay`) and a certificate of each proved one (`maviper check`).

    `maviper guide claims` says how to write claims and regions, and `maviper guide systems` how to state a world.
    """
    context = click.get_current_context()
    if new:
        return _write_starter(str(profile), output)
    console.line("verifying", str(profile))
    if options.get("world") is None and any(each.partition("(")[0].strip() == ROBUST for each in claims):
        observations, asked = _read_robust(claims)
        _ensure_alone(options)
        return tell_radii(console, profile, observations, output, asked)
    if output is not None:
        FOLDER.convert(output, next(each for each in context.command.params if each.name == "output"), context)
    return _decide_claims(profile, {**options, "claims": claims}, output, context.obj["verbose"], console)


def _read_robust(claims: Sequence[str]) -> tuple[Path, dict[str, Any]]:
    """The claim `robust` as read: the file of observations, and the rest by name."""
    from verify.claims.catalogue import read_call
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
    certify = call.get("certify", False) in (True, "true", "yes")
    return Path(str(call["observations"])), {**texts, **bounds, "certify": certify}


def _ensure_alone(options: Mapping[str, Any]) -> None:
    """InputError for an option that the claim `robust` does not read."""
    from maviper.verification.ask import VerifyOptions

    timed = [f"--{name.replace('_', '-')}" for name in ("max_seconds", "junit") if options[name] is not None]
    others = VerifyOptions.of({name: value for name, value in options.items() if name not in ("max_seconds", "junit")})
    for flag in (*others.unusual.values(), *timed):
        raise InputError(f"{flag} has no effect with {ROBUST}", flag, "leave it out, or ask another claim")


def _decide_claims(profile: Path, options: dict[str, Any], output: Path | None, full: bool, console: "Console") -> int:
    """Decides, prints and writes; the exit code."""
    from maviper.cli.exits import limit_seconds
    from maviper.cli.results import Said, exit_code, say_results
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
        return _end_with(_print_verdicts(asked, answers, stated, console), unread)
    with console.following("deciding") as listener, listening(listener):
        said = stated.said if stated else []
    for about, words in said:
        console.line(about, words)
    with console.following("deciding") as listener, listening(listener), limit_seconds(seconds) as is_over:
        done = verify_questions(loaded, asked, asking, Said(loaded, len(asked), console), stated, is_over)
    if junit is not None:
        known = {id(one): result for one, result in zip(done.asked, done.results, strict=True)}
        answers = [(known[id(one)].verdict, known[id(one)].reason) if id(one) in known else late for one in asked]
        _write_junit(junit, profile, asked, answers)
    open_claims = [one for one in asked if one not in done.asked]
    for one in open_claims if is_over() else ():
        console.result(Verdict.UNKNOWN.value, f"{one.words}: no answer within {seconds:g} s (--max-seconds)")
    if full or asking.where:
        say_results(loaded, done.results, console)
    written: list[tuple[str, str]] = []
    if output is not None and done.results:
        written = _write(output, done, given, asking)
        console.result("report", str(output / "report.html"))
    console.result("next", _next_command(written, done, asked))
    for label, text in written if full or asking.where else ():
        console.line(label, text)
    if console.json or full:
        click.echo(done.printed(bool(console.json)), nl=False)
    if open_claims and is_over():
        return _end_with(exit_code([*(result.verdict for result in done.results), Verdict.UNKNOWN]), unread)
    if open_claims:
        console.line("interrupted", f"{len(done.results)} of {format_count(len(asked), 'claim')} decided")
        raise KeyboardInterrupt
    return _end_with(exit_code([result.verdict for result in done.results]), unread)


def _end_with(code: int, unread: "Sequence[InputError]") -> int:
    """The exit code. The fault of claims that cannot be read is told after the verdicts on the others."""
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
    from maviper.verification.files.states import file_names, list_given

    texts = {runs.PROFILE_FILE: dumps(profile), **(stated.beside if stated else {})}
    known = outputs.without_given(folder, texts, given)
    read = [*outputs.list_elsewhere(folder, given), *list_given(options)]
    outputs.ensure_free(folder, outputs.VERIFY, known, read, file_names(asked, page=stated is None))


def _folders(output: Path | None, asked: "Sequence[Asked]", options: "VerifyOptions", console: "Console") -> None:
    """Folders for what will be written, before anything is decided; questions for other programs at once."""
    from maviper.files import runs
    from maviper.verification.files.states import ensure_free

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
    asked: "Sequence[Asked]", decided: "Sequence[tuple[Verdict, str]]", stated: "StatedWorld | None", console: "Console"
) -> int:
    """A line of standard output for each verdict, or an object for all; the exit code."""
    from maviper.cli.results import exit_code

    documents: list[dict[str, str]] = []
    lines: list[str] = []
    for one, (verdict, reason) in zip(asked, decided, strict=True):
        told = {"verdict": verdict.value, "property": one.claim.shown, "team": one.claim.team}
        documents.append(told | {"region": one.region.name, "reason": reason})
        lines.append(f"{verdict.value:<11} {one.words}" + (f": {reason}" if reason else ""))
    console.give(({"of": stated.about} if stated else {}) | {"results": documents}, lines)
    return exit_code([verdict for verdict, _ in decided])


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
    from maviper.verification.files.states import list_given

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
