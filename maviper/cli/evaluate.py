"""The command evaluate.

Does: has a profile, an expert or a mix measured in play, and prints tables or JSON.
Assumes: `maviper.evaluation.run` finds who plays and measures.
Does not: play or count.
"""

from typing import Unpack

import click

from codegen.errors import ExitCode
from maviper.cli.group import Verb
from maviper.cli.options import console_of, option, options_of
from maviper.options import EvaluateOptions
from maviper.options.measuring import MEASURED


@click.command(cls=Verb, example="maviper evaluate demo/profile.json --against random --episodes 500")
@click.argument("subject")
@options_of(EvaluateOptions)
@option("--json", "as_json", is_flag=True, section=MEASURED, help="Print one JSON object.")
@click.pass_context
def evaluate(context: click.Context, subject: str, as_json: bool, **options: Unpack[EvaluateOptions]) -> int:
    """Measure a profile or an expert in play.

    SUBJECT is a profile, or an expert named as for `maviper extract`. A name that ends in .json is always a profile.
    --with mixes them.

    Each team plays against the opponents. For comparison, the expert plays the same episodes in its place. The output
    has measures, returns and ratios to the expert, all with intervals. For a joint ratio the whole team is replaced;
    for an individual ratio, one agent among experts. For trees, the output adds size, comparisons per decision, and
    fidelity to the expert. By default the opponents are the expert, or SUBJECT if there is no expert.
    """
    console = console_of(context)
    console.line("evaluating", subject)
    from codegen.policy_json import layout
    from maviper.console import say
    from maviper.evaluation.run import document, evaluate_named, lines, request

    asked = request(subject, **options)
    with console.live("playing", 1) as live:

        def show(done: int, total: int) -> None:
            live.total = total
            live.update(done, "episodes")

        measured = evaluate_named(asked, show)
    if as_json:
        click.echo(layout(document(asked, measured)))
    else:
        say("\n".join(lines(asked, measured)))
    return ExitCode.DONE
