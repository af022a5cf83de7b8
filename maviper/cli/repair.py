"""The command repair.

Does: has a profile repaired, says what that changed and cost, writes the results.
Assumes: `maviper.verification.repair` repairs and measures.
Does not: choose guards or decide verdicts.
"""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Unpack

import click

from codegen.errors import ExitCode
from codegen.wording import format_count
from maviper.cli.group import Verb
from maviper.cli.options import PROFILE, REGION, console_of, option, options_of, output
from maviper.options import RepairOptions
from maviper.options.verification import QUESTION

if TYPE_CHECKING:
    from maviper.console import Console
    from maviper.verification.repair import Repaired


@click.command(cls=Verb, example="maviper repair demo/profile.json --max-depth 8 -o repaired")
@PROFILE
@option(
    "--property",
    "name",
    default="distinct_targets",
    show_default=True,
    metavar="NAME",
    section=QUESTION,
    help="distinct_targets or own_target.",
)
@REGION
@options_of(RepairOptions)
@output("The folder for the repaired profile.")
@click.pass_context
def repair(
    context: click.Context, profile: Path, name: str, region: str, output: Path, **options: Unpack[RepairOptions]
) -> int:
    """Change the leaves that violate a property until it is proved.

    Each agent of the team is assigned its own landmark. If a counterexample ends in a leaf of PROFILE, that leaf
    becomes a small tree that tests the agent's offset to its landmark: a guard. It keeps the agent engaged with the
    landmark: closing on it, or at it. Where trees would get deeper than --max-depth, the guard replaces a split above
    the leaf. All other leaves decide as before. Both engines must prove the property in the region.

    The command reports how many actions change, and the team's measures before and after, in the same episodes. It
    writes the repaired profile, its certificate, the report, a page that plays it and the costs (repair.json).

    \b
    Exits with 0 if the property is proved within --max-depth, with 1 if the
    trees are deeper, and with 3 if no repair was found. Then nothing is written.
    """
    from codegen.policy_json import content_hash, dumps
    from maviper.cli.results import exit_code, say_repair, say_results
    from maviper.files import outputs, runs
    from maviper.files.profiles import load
    from maviper.page.page import FILE, unplayable
    from maviper.page.results import page_of
    from maviper.verification.repair import region_text, repair_profile, request
    from verify.progress import listening

    console = console_of(context)
    asked = request(name, options)
    before = load(profile)
    runs.room(output)
    outputs.ensure_own(output, {runs.PROFILE_FILE: dumps(before)}, outputs.REPAIR)
    given = [profile, Path(region)]
    beside = outputs.without_given(output, region_text(region, before), {Path(region).name: Path(region)})
    outputs.ensure_free(output, outputs.REPAIR, beside, given, rf"{outputs.REPAIR.names}|{runs.PROFILE_FILE}")
    with console.following("repairing") as listener, listening(listener):
        outcome = repair_profile(before, name, region, asked, profile.name)
    if outcome.after is None:
        _say_unrepaired(outcome, output, given, console)
        return ExitCode.INCONCLUSIVE
    say_repair(outcome, console)
    say_results(outcome.after, outcome.results, console)
    page = {} if unplayable(outcome.after) else {FILE: page_of(outcome.after, outcome.results)}
    files = outputs.without_given(output, {**outcome.files, **page}, {Path(region).name: Path(region)})
    outputs.write_set(output, files, outputs.REPAIR, keep=given)
    console.line("wrote", f"{output / runs.PROFILE_FILE}  id {content_hash(outcome.after)[:16]}")
    for name in outcome.certificates:
        console.line("certificate", f"{output / name}; maviper check {output / name}")
    depth, most = outcome.repair.depth, asked.max_depth
    if most is not None and depth > most:
        console.line(
            "too deep",
            f"the trees have depth {depth}, more than the {most} asked for; extract with a smaller --max-depth",
        )
        return ExitCode.VIOLATED
    return exit_code([result.verdict for result in outcome.results])


def _say_unrepaired(outcome: "Repaired", output: Path, given: Sequence[Path], console: "Console") -> None:
    """Why there is no repair. What an earlier one left goes, as it would be taken for this one's."""
    from maviper.files import outputs

    subject = f"{outcome.claim.name} of the {outcome.claim.team}, region {outcome.region.name}"
    console.line("not repaired", f"{subject}: {outcome.repair.reason}")
    console.line("", f"{format_count(len(outcome.repair.guards), 'guard')} set; nothing was written")
    if outputs.clear(output, outputs.REPAIR, given):
        console.line("removed", f"the files of an earlier repair in {output}")
