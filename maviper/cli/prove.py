"""The commands check, replay, repair and diff, and the claim robust.

Does: has a certificate checked, a counterexample replayed, a profile repaired, two profiles compared, or radii around
  observations computed; says what came out, and writes what was asked for.
Assumes: `maviper.verification` checks, replays, repairs, compares and computes.
Does not: prove, look for counterexamples, choose guards or decide verdicts.
"""

import json
from collections.abc import Collection, Mapping
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Any, Unpack

import click

from codegen.errors import ExitCode, InputError, escape_text
from codegen.wording import format_count
from maviper.cli.options import (
    FOLDER,
    OBSERVED_REGION,
    PATH,
    PROFILE,
    REGION,
    RESULTS,
    SETTING,
    Verb,
    option,
    options_of,
    output,
)
from maviper.options import DiffOptions, RepairOptions
from maviper.options.verbs import QUESTION

if TYPE_CHECKING:
    from codegen.ir import PolicyProfile
    from maviper.console import Console
    from maviper.verification.compared import OutputsCompared
    from maviper.verification.diff import Compared
    from maviper.verification.guarding import Guarded
    from maviper.verification.repair import Repaired
    from maviper.verification.robust import Changes


ROBUST = "--claim robust"
BUDGETS_OF_DIFF = ("max_nodes", "max_cells", "semantics")  # given by --set


@click.command(cls=Verb, example="maviper check generated/proved_defenders/certificate-1-distinct_targets.json")
@click.argument("certificate", type=PATH)
@option(
    "--profile",
    type=PATH,
    default=None,
    help="The profile that the certificate is about (default: profile.json beside it).",
)
@option(
    "--against",
    type=PATH,
    default=None,
    help="The second profile of a certificate by `maviper diff` (default: against.json beside it).",
)
@option(
    "--system",
    "world",
    type=PATH,
    default=None,
    help="The world file of a certificate about a stated system (default: world.toml beside it).",
)
def check(console: "Console", certificate: Path, profile: Path | None, against: Path | None, world: Path | None) -> int:
    """Check that a certificate proves its claim.

    `maviper verify -o` writes a CERTIFICATE for each claim that it proves, unless Z3 alone proves it. The checker
    closes every branch of the proof again with exact numbers, from the profile, the region and the claim. It shares
    only the arithmetic of thresholds with the engine that found the proof.

    `maviper diff -o` writes a CERTIFICATE if agents act alike in two profiles. Both are needed to check it.

    `maviper verify --system -o` writes a CERTIFICATE about a stated system. The world file is needed to check it: its
    bounds on dynamics that are not affine are proved again first.

    A CERTIFICATE may be packed with xz (`.json.xz`).

    A proof about episodes is about starts at rest. The agents in the proof follow their trees; all others may do
    anything.

    \b
    Exits with 0 if the proof holds, with 1 if it does not, and with 2 if the
    file cannot be read or is about another profile.
    """
    console.line("checking", str(certificate))
    from maviper.verification.files.certificates import check_file
    from verify.spending import listening

    with console.following("checking") as listener, listening(listener):
        proof = check_file(certificate, profile, against, world)
    closed = f"{format_count(proof.closed, proof.unit)}{' closed' if proof.unit == 'branch' else ''}"
    told = {"subject": proof.subject, "closed": proof.closed, "unit": proof.unit, "bytes": proof.size}
    size = f"{format_count(proof.size, 'byte')} of proof" if proof.size else "made again from the proof's recipe"
    line = f"accepted  {proof.subject}: {closed}, {size}"
    console.give({"accepted": True, **told}, [line])
    return ExitCode.DONE


@click.command(cls=Verb, example="maviper replay report/counterexample-1-distinct_targets.json")
@click.argument("counterexample", type=PATH)
@option(
    "--profile", type=PATH, default=None, help="The profile to replay it with (default: profile.json beside the file)."
)
@option(
    "--system",
    "world",
    type=PATH,
    default=None,
    help="The world file of a counterexample in a stated system (default: world.toml beside it).",
)
def replay(console: "Console", counterexample: Path, profile: Path | None, world: Path | None) -> int:
    """Replay a counterexample, with the same trees or others.

    `maviper verify -o` writes a COUNTEREXAMPLE for each violated claim. The reference, the compiled C and the
    environment replay it, and must act alike. A counterexample about episodes is played again from its start, one in a
    stated system in exact numbers with its errors.

    Exits with 1 if the claim fails there, and with 0 if it holds, as it should for a repaired profile.
    """
    console.line("replaying", str(counterexample))
    from maviper.files.profiles import find_profile
    from maviper.verification.files.counterexamples import ensure_counterexample
    from maviper.verification.files.counterexamples import replay as replayed

    ensure_counterexample(counterexample)  # before the profile beside it, which need not be there
    outcome = replayed(counterexample, find_profile(profile, beside=counterexample, sums=True), world)
    if not outcome.same_policy:
        console.line("profile", "not the one that the counterexample was made from")
    for agent, action in outcome.actions.items():
        was = outcome.before.get(agent, action)
        changed = "" if action == was else f" (was {escape_text(was)})"
        console.line(agent, f"{action}{changed}")
    told, _, said = outcome.says.partition(" ")
    console.line(told, f"{said}, which all act the same" if outcome.by else said)
    console.result("VIOLATED" if outcome.violated else "holds", outcome.property)
    facts = {"property": outcome.property, "violated": outcome.violated, "same_policy": outcome.same_policy}
    told = {"actions": dict(outcome.actions), "says": outcome.says, "replayed_by": list(outcome.by)}
    console.give(facts | told)
    return ExitCode.VIOLATED if outcome.violated else ExitCode.DONE


@click.command(cls=Verb, example="maviper repair demo/profile.json --max-depth 8 -o repaired")
@PROFILE
@option(
    "--claim",
    default="distinct_targets",
    show_default=True,
    metavar="CLAIM",
    section=QUESTION,
    help='distinct_targets or own_target, with parameters if you like: "own_target(radius=0.2)"; or a file of claims, '
    "or a world file.",
)
@REGION
@options_of(RepairOptions, "max_depth", "episodes")
@output("The folder for the repaired profile.")
def repair(
    console: "Console", profile: Path, claim: str, region: str, output: Path, **options: Unpack[RepairOptions]
) -> int:
    """Change the leaves that violate a claim until it is proved.

    Each agent of the team is assigned its own landmark. If a counterexample ends in a leaf of PROFILE, that leaf
    becomes a small tree that tests the agent's offset to its landmark: a guard. It keeps the agent engaged with the
    landmark: closing on it, or at it. If a tree would be deeper than allowed (--max-depth), the guard replaces a split
    above the leaf. All other leaves decide as before. Both engines must prove the claim in the region.

    If CLAIM is a file of claims, all of them are proved: guards keep those of the two kinds at the same time, and no
    other claim of the file may break.

    If CLAIM is a world file, its claims that episodes stay in a region are proved. A guard stands above a tree: it
    tests a feature that measures one variable, and acts before that leaves its bounds.

    The command reports how many actions change, and the team's measures before and after, in the same episodes. It
    writes the repaired profile, its certificate, the report, a page that plays it and the costs (repair.json).

    \b
    Exits with 0 if the claim is proved within --max-depth, with 1 if the
    trees are deeper, and with 3 if no repair was found. Then nothing is written.
    """
    console.line("repairing", str(profile))
    from codegen.policy_json import dumps
    from maviper.cli.results import say_repair
    from maviper.files import outputs, runs
    from maviper.files.profiles import load
    from maviper.page.page import FILE, page_of, unplayable
    from maviper.verification.ask import DEFAULT
    from maviper.verification.repair import find_claims, region_text, repair_profile, request, request_call
    from verify.spending import listening

    file = find_claims(claim)
    if file is None and claim.endswith(".toml"):
        return _repair_stated(console, profile, Path(claim), output, region, options)
    name, asked = request_call(claim, options) if file is None else (file, request(DEFAULT, options))
    before = load(profile)
    runs.room(output)
    outputs.ensure_own(output, {runs.PROFILE_FILE: dumps(before)}, outputs.REPAIR)
    given = [profile, Path(region), *([] if file is None else [file])]
    beside = outputs.without_given(output, region_text(region, before), {Path(region).name: Path(region)})
    outputs.ensure_free(output, outputs.REPAIR, beside, given, rf"{outputs.REPAIR.names}|{runs.PROFILE_FILE}")
    with console.following("repairing") as listener, listening(listener):
        outcome = repair_profile(before, name, region, asked, profile.name)
    if outcome.after is None:
        console.line("not repaired", f"{outcome.subject}: {outcome.repair.reason}")
        console.line("", f"{format_count(len(outcome.repair.guards), 'guard')} set; nothing was written")
        return _end_unrepaired(outcome.repair.reason, output, given, console)
    say_repair(outcome, console)
    page = {} if unplayable(outcome.after) else {FILE: page_of(outcome.after, outcome.results)}
    files = outputs.without_given(output, {**outcome.files, **page}, {Path(region).name: Path(region)})
    code = _write_repaired(outcome, outcome.after, files, output, given, console)
    console.result("next", f"maviper diff {profile} {output / runs.PROFILE_FILE}")
    depth, most = outcome.repair.depth, asked.max_depth
    if most is not None and depth > most:
        said = f"the trees have depth {depth}, more than the {most} asked for; extract with a smaller --max-depth"
        console.line("too deep", said)
        return ExitCode.VIOLATED
    return code


def _repair_stated(
    console: "Console", profile: Path, world: Path, output: Path, region: str, options: Mapping[str, Any]
) -> int:
    """Repairs by the claims of a world file."""
    from codegen.policy_json import dumps
    from maviper.evaluation.comparison import say_sizes
    from maviper.files import outputs, runs
    from maviper.files.profiles import load
    from maviper.verification.guarding import ensure_unasked, repair_stated
    from maviper.worlds.stated.certified import WORLD_FILE
    from verify.spending import listening
    from verify.systems.files import MAX_BYTES

    ensure_unasked(region, options)
    before, given = load(profile), {runs.PROFILE_FILE: profile, WORLD_FILE: world}
    runs.room(output)
    texts = {runs.PROFILE_FILE: dumps(before), WORLD_FILE: runs.read(world, MAX_BYTES)}
    known = outputs.without_given(output, texts, given)
    outputs.ensure_free(output, outputs.REPAIR, known, given.values(), rf"{outputs.REPAIR.names}|{runs.PROFILE_FILE}")
    with console.following("repairing") as listener, listening(listener):
        done = repair_stated(before, world, profile.name)
    for guard in done.guards:
        console.line("guard", guard.words)
    if done.after is None:
        console.line("not repaired", f"{world}: {done.reason}; nothing was written")
        return _end_unrepaired(done.reason, output, given.values(), console)
    console.line("repaired", say_sizes(before, done.after, done.guarded) or "nothing: each claim holds as it is")
    files = outputs.without_given(output, done.files, given)
    code = _write_repaired(done, done.after, files, output, given.values(), console)
    console.result("next", f"maviper evaluate {output / runs.PROFILE_FILE} --world WORLD")
    return code


def _end_unrepaired(reason: str, output: Path, given: Collection[Path], console: "Console") -> int:
    """Ends without a repair. What an earlier one left goes, as it would be taken for this one's."""
    from maviper.files import outputs

    if outputs.clear(output, outputs.REPAIR, given):
        console.line("removed", f"the files of an earlier repair in {output}")
    console.give({"repaired": False, "reason": reason})
    return ExitCode.INCONCLUSIVE


def _write_repaired(
    done: "Repaired | Guarded",
    after: "PolicyProfile",
    files: Mapping[str, str | bytes],
    output: Path,
    given: Collection[Path],
    console: "Console",
) -> int:
    """Says the verdicts on the repaired profile, and writes it with its files; the exit code of the verdicts."""
    from codegen.policy_json import content_hash
    from maviper.cli.results import exit_code, say_verdict
    from maviper.files import outputs, runs
    from maviper.verification.repair import COST_FILE

    for result in done.results:
        say_verdict(after, result, console)
    outputs.write_set(output, files, outputs.REPAIR, keep=given)
    console.line("wrote", f"{output / runs.PROFILE_FILE}  id {content_hash(after)[:16]}")
    for name in done.certificates:
        console.line("certificate", f"{output / name}; maviper check {output / name}")
    verdicts = [result.verdict for result in done.results]
    told = {"repaired": True, "verdicts": [each.value for each in verdicts], "wrote": str(output)}
    console.give(told | json.loads(done.files[COST_FILE]))
    return exit_code(verdicts)


@click.command(
    cls=Verb, settings=BUDGETS_OF_DIFF, example="maviper diff demo/extracted/profile.json demo/profile.json -o changed"
)
@click.argument("first", type=PATH)
@click.argument("second", type=PATH)
@OBSERVED_REGION
@options_of(DiffOptions)
@SETTING
@option("-o", "--output", type=FOLDER, default=None, section=RESULTS, help="Folder for data, certificate and page.")
def diff(
    console: "Console", first: Path, second: Path, region: str, output: Path | None, **options: Unpack[DiffOptions]
) -> int:
    """Find every state in which two teams of trees act differently.

    FIRST and SECOND are profiles of one world, or imported controllers, whose agents observe and may do the same. For
    each agent, the command lists the zones of states in which it acts differently: one leaf in each profile, and
    bounds. It gives their exact share of the region, the share of the states that FIRST meets in play, and an example
    of each zone. If there is no such state, it proves that, for games with a certificate for `maviper check`. If agents
    test sums or give numbers, it gives the largest difference of each output over the ranges of what they observe, and
    where.

    With -o, it writes difference.json, the certificate, both profiles, and a page that plays one team beside the other.

    \b
    Exits with 0 if all agents are proved to act alike, with 1 if some agent acts
    differently, and with 3 if a budget ended before there was an answer.
    """
    console.line("comparing", f"{first} with {second}")
    from codegen.policy_json import dumps
    from maviper.cli.results import exit_code
    from maviper.files import outputs, runs
    from maviper.files.profiles import load
    from maviper.verification.diff import AGAINST_FILE, compare_profiles, request
    from verify.spending import listening

    one, other = load(first, sums=True), load(second, sums=True)
    given = {runs.PROFILE_FILE: first, AGAINST_FILE: second}
    if output is not None:
        runs.room(output)
        texts = {runs.PROFILE_FILE: dumps(one), AGAINST_FILE: dumps(other)}
        known = outputs.without_given(output, texts, given)
        outputs.ensure_free(output, outputs.DIFF, known, [*outputs.list_elsewhere(output, given), Path(region)])
    with console.following("comparing") as listener, listening(listener):
        comparison = compare_profiles(one, other, region, request(**options))
    for label, text in comparison.lines:
        console.line(label, text)
    if output is not None:
        _write(output, comparison, given, Path(region), console)
    console.give(comparison.facts)
    return exit_code(comparison.verdicts)


def _write(
    folder: Path, compared: "Compared | OutputsCompared", given: Mapping[str, Path], region: Path, console: "Console"
) -> None:
    """All files, and the command that reads the certificate."""
    from maviper.files import outputs
    from maviper.page.page import FILE, compared_page_of, unplayable
    from maviper.verification.diff import CERTIFICATE_FILE, REPORT_FILE, Compared

    page: dict[str, str] = {}
    if isinstance(compared, Compared):
        no_page = unplayable(compared.found.first, compared.found.second)
        page = {} if no_page else {FILE: compared_page_of(compared)}
    else:
        no_page = compared.unplayable
    files = outputs.without_given(folder, {**compared.files, **page}, given)
    outputs.write_set(folder, files, outputs.DIFF, keep=[*given.values(), region])
    console.line("wrote", str(folder / REPORT_FILE))
    console.line("no page" if no_page else "page", no_page or str(folder / FILE))
    if CERTIFICATE_FILE in compared.files:
        console.line("certificate", f"{folder / CERTIFICATE_FILE}; maviper check {folder / CERTIFICATE_FILE}")


def tell_radii(
    console: "Console", profile: Path, observations: Path, output: Path | None, asked: Mapping[str, Any]
) -> int:
    """Computes how far the observations of a file may be off, and writes what was asked for: the claim `robust`, with
    what it says besides the file (`agent`, `error`, `least`, `most`, `certify`).
    """
    from maviper.files import outputs, runs
    from maviper.files.profiles import load
    from maviper.verification.robust import Changes, find_agent
    from maviper.verification.robust import robust as radii

    agent, certify, least, most = (asked.get(key) for key in ("agent", "certify", "least", "most"))
    loaded = load(profile, sums=True)
    gives = bool(find_agent(loaded, agent).outputs)
    # a bound of what the other kind of agent has, or one that decides nothing, is known before anything is proved
    if most is not None and not gives:
        raise InputError("most is for agents that give numbers", ROBUST, "write least=NUMBER, of radii")
    if least is not None and gives:
        raise InputError("least is for agents that take actions", ROBUST, "write most=NUMBER, of changes of outputs")
    if least is not None and least <= 0:
        raise InputError(f"no radius is below {least}, so this cannot fail", ROBUST, "write a number above 0")
    if most is not None and most < 0:
        raise InputError("no output changes by less than 0, so this cannot hold", ROBUST, "write 0 or more")
    kept = outputs.CHANGES if gives else outputs.ROBUST
    if output is not None:
        runs.room(output)
        outputs.ensure_free(output, kept, {}, [profile, observations], None if certify else outputs.NOTHING)
    table = radii(loaded, observations, agent, bool(certify), asked.get("error"))
    if isinstance(table, Changes):
        code = _tell_changes(console, table, most)
    else:
        console.line("radii", table.line)
        if certify:
            console.line(
                "proved", f"{len(table.certificates)} radii; the independent checker accepted each certificate"
            )
        code = ExitCode.DONE if least is None or table.least >= least else ExitCode.VIOLATED
    if output is not None:
        outputs.write_set(output, table.files, kept, keep=[profile, observations])
    console.give(table.document(), table.files[kept.mark].splitlines() if output is None else ())
    return code


def _tell_changes(console: "Console", table: "Changes", most: Fraction | None) -> ExitCode:
    """Says what sums up the changes of outputs."""
    console.line("changes", table.line)
    if not table.exact:
        console.line("bounds", 'some are bounds, since the tree tests sums; `maviper verify` decides name = "robust"')
    if most is None or table.largest <= most:
        return ExitCode.DONE
    return ExitCode.VIOLATED if table.largest_seen > most else ExitCode.INCONCLUSIVE
