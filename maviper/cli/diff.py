"""The command diff.

Does: compares two profiles, says where they act differently, writes what was asked for.
Assumes: `maviper.verification.diff` compares.
Does not: decide.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Unpack

import click

from maviper.cli.group import Verb
from maviper.cli.options import FOLDER, PATH, REGION, RESULTS, console_of, option, options_of
from maviper.options import DiffOptions

if TYPE_CHECKING:
    from maviper.console import Console
    from maviper.verification.compared import OutputsCompared
    from maviper.verification.diff import Compared


@click.command(cls=Verb, example="maviper diff demo/extracted/profile.json demo/profile.json -o changed")
@click.argument("first", type=PATH)
@click.argument("second", type=PATH)
@REGION
@options_of(DiffOptions)
@option("-o", "--output", type=FOLDER, default=None, section=RESULTS, help="Folder for data, certificate and page.")
@option("--json", "as_json", is_flag=True, section=RESULTS, help="Print the comparison as JSON.")
@click.pass_context
def diff(
    context: click.Context,
    first: Path,
    second: Path,
    region: str,
    output: Path | None,
    as_json: bool,
    **options: Unpack[DiffOptions],
) -> int:
    """Find every state in which two profiles act differently.

    FIRST and SECOND are profiles of one world, whose agents observe and may do the same. For each agent, the command
    lists the zones of states in which it acts differently: one leaf in each profile, and bounds on positions. It gives
    their exact share of the region, the share of the states that FIRST meets in play, and an example of each zone. If
    there is no such state, it proves that, with a certificate for `maviper check`. Of agents that test sums or give
    numbers, it gives the largest difference of each output over the ranges of what they observe, and where.

    With -o, it writes difference.json, the certificate, both profiles, and a page that plays one team beside the other.

    \b
    Exits with 0 if all agents are proved to act alike, with 1 if some agent acts
    differently, and with 3 if a budget ended before there was an answer.
    """
    from codegen.policy_json import dumps
    from maviper.cli.results import exit_code
    from maviper.files import outputs, runs
    from maviper.files.profiles import load
    from maviper.verification.diff import AGAINST_FILE, compare_profiles, request
    from verify.progress import listening
    from verify.reports.differences import as_json as written

    console = console_of(context)
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
    if as_json:
        click.echo(written(comparison.facts), nl=False)
    return exit_code(comparison.verdicts)


def _write(
    folder: Path, compared: "Compared | OutputsCompared", given: Mapping[str, Path], region: Path, console: "Console"
) -> None:
    """All files, and the command that reads the certificate."""
    from maviper.files import outputs
    from maviper.page.differences import page_of
    from maviper.page.page import FILE, unplayable
    from maviper.verification.diff import CERTIFICATE_FILE, REPORT_FILE, Compared

    page: dict[str, str] = {}
    if isinstance(compared, Compared):
        no_page = unplayable(compared.found.first, compared.found.second)
        page = {} if no_page else {FILE: page_of(compared)}
    else:
        no_page = compared.unplayable
    files = outputs.without_given(folder, {**compared.files, **page}, given)
    outputs.write_set(folder, files, outputs.DIFF, keep=[*given.values(), region])
    console.line("wrote", str(folder / REPORT_FILE))
    console.line("no page" if no_page else "page", no_page or str(folder / FILE))
    if CERTIFICATE_FILE in compared.files:
        console.line("certificate", f"{folder / CERTIFICATE_FILE}; maviper check {folder / CERTIFICATE_FILE}")
