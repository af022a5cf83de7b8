"""The command robust.

Does: has radii around observations computed, and prints or writes the table.
Assumes: `maviper.verification.robust` computes.
Does not: prove.
"""

from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING

import click

from codegen.errors import ExitCode, InputError
from maviper.cli.group import Verb
from maviper.cli.options import FOLDER, PATH, PROFILE, console_of, fraction, option

if TYPE_CHECKING:
    from maviper.console import Console
    from maviper.verification.robust import Changes, Radii


@click.command(cls=Verb, example="maviper robust profile.json observations.csv --certify -o radii")
@PROFILE
@click.argument("observations", type=PATH)
@option("--agent", default=None, metavar="NAME", help="The agent (default: the only one).")
@option("--error", default=None, metavar="NUMBER", help="Of outputs: how far features may be off, or x=0.01,v=0.2.")
@option("--most", callback=fraction, metavar="NUMBER", help="Of outputs: exit with 1 if one changes by more.")
@option("--least", callback=fraction, metavar="NUMBER", help="Exit with 1 if a radius is smaller.")
@option("--certify", is_flag=True, help="Prove each radius, and check its certificate.")
@option("-o", "--output", type=FOLDER, default=None, help="Folder for radii.csv and the certificates.")
@option("--json", "as_json", is_flag=True, help="Print one JSON object.")
@click.pass_context
def robust(
    context: click.Context,
    profile: Path,
    observations: Path,
    agent: str | None,
    error: str | None,
    most: Fraction | None,
    least: Fraction | None,
    certify: bool,
    output: Path | None,
    as_json: bool,
) -> int:
    """Compute how far observations may be off.

    OBSERVATIONS is a CSV file whose first line names the features, or a JSON list. The radius is the largest error that
    changes no action: each feature may be off by up to that much (L-infinity). It is computed exactly from the tree,
    rounding to float32 included. Numbers beyond the ranges of features count too.

    Of an agent that gives numbers, the table says how far each output may change where features are off by up to
    --error: the least and the most that the code can give, rounding included. They are exact unless sums are tested.

    Without -o, the table is printed as CSV.
    """
    from codegen.policy_json import layout
    from maviper.files import outputs, runs
    from maviper.files.profiles import load
    from maviper.verification.robust import Changes, find_agent
    from maviper.verification.robust import robust as radii

    console = console_of(context)
    loaded = load(profile, sums=True)
    gives = bool(find_agent(loaded, agent).outputs)
    _ensure_asked(gives, least, most)
    kept = outputs.CHANGES if gives else outputs.ROBUST
    if output is not None:
        runs.room(output)
        outputs.ensure_free(output, kept, {}, [profile, observations], None if certify else outputs.NOTHING)
    table = radii(loaded, observations, agent, certify, error)
    if isinstance(table, Changes):
        code = _tell_changes(console, table, most)
    else:
        code = _tell_radii(console, table, least, certify)
    if output is not None:
        outputs.write_set(output, table.files, kept, keep=[profile, observations])
    if as_json:
        click.echo(layout(table.document()))
    elif output is None:
        click.echo(table.files[kept.mark], nl=False)
    return code


def _ensure_asked(gives: bool, least: Fraction | None, most: Fraction | None) -> None:
    """InputError for a bound of what the other kind of agent has, or one that decides nothing: known before anything is
    proved.
    """
    if most is not None and not gives:
        raise InputError("--most is for agents that give numbers", "--most", "write --least, of radii")
    if least is not None and gives:
        raise InputError("--least is for agents that take actions", "--least", "write --most, of changes of outputs")
    if least is not None and least <= 0:
        raise InputError(f"no radius is below {least}, so this cannot fail", "--least", "write a number above 0")
    if most is not None and most < 0:
        raise InputError("no output changes by less than 0, so this cannot hold", "--most", "write 0 or more")


def _tell_radii(console: "Console", table: "Radii", least: Fraction | None, certify: bool) -> ExitCode:
    """Says what sums up the radii."""
    console.line("radii", table.line)
    if certify:
        console.line("proved", f"{len(table.certificates)} radii; the independent checker accepted each certificate")
    return ExitCode.DONE if least is None or table.least >= least else ExitCode.VIOLATED


def _tell_changes(console: "Console", table: "Changes", most: Fraction | None) -> ExitCode:
    """Says what sums up the changes of outputs."""
    console.line("changes", table.line)
    if not table.exact:
        console.line("bounds", 'some are bounds, since the tree tests sums; `maviper verify` decides name = "robust"')
    if most is None or table.largest <= most:
        return ExitCode.DONE
    return ExitCode.VIOLATED if table.largest_seen > most else ExitCode.INCONCLUSIVE
