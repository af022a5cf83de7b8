"""The command robust.

Does: has radii around observations computed, and prints or writes the table.
Assumes: `maviper.verification.robust` computes.
Does not: prove.
"""

from fractions import Fraction
from pathlib import Path

import click

from codegen.errors import ExitCode
from maviper.cli.group import Verb
from maviper.cli.options import FOLDER, PATH, PROFILE, console_of, fraction, option


@click.command(cls=Verb, example="maviper robust profile.json observations.csv --certify -o radii")
@PROFILE
@click.argument("observations", type=PATH)
@option("--agent", default=None, metavar="NAME", help="The agent (default: the only one).")
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
    least: Fraction | None,
    certify: bool,
    output: Path | None,
    as_json: bool,
) -> int:
    """Compute how far observations may be off.

    OBSERVATIONS is a CSV file whose first line names the features, or a JSON list. The radius is the largest error that
    changes no action: each feature may be off by up to that much (L-infinity). It is computed exactly from the tree,
    rounding to float32 included. Numbers beyond the ranges of features count too.

    Without -o, the table is printed as CSV.
    """
    from codegen.policy_json import layout
    from maviper.files import outputs, runs
    from maviper.files.profiles import load
    from maviper.verification.robust import robust as radii

    console = console_of(context)
    loaded = load(profile)
    if output is not None:
        runs.room(output)
    table = radii(loaded, observations, agent, certify)
    console.line("radii", table.line)
    if certify:
        console.line("proved", f"{len(table.certificates)} radii; the independent checker accepted each certificate")
    if output is not None:
        outputs.write_set(output, table.files, outputs.ROBUST)
    if as_json:
        click.echo(layout(table.document()))
    elif output is None:
        click.echo(table.files["radii.csv"], nl=False)
    return ExitCode.DONE if least is None or table.least >= least else ExitCode.VIOLATED
