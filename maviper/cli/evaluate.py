"""The command evaluate.

Does: has a profile, an expert or a mix measured in play, and prints tables or JSON.
Assumes: `maviper.evaluation.run` finds who plays and measures.
Does not: play or count.
"""

from typing import Any

import click

from codegen.errors import ExitCode
from maviper.cli.group import Verb
from maviper.cli.options import console_of, option

WHO, HOW = "Who plays", "What is measured"


@click.command(cls=Verb, example="maviper evaluate demo/profile.json --against random --episodes 500")
@click.argument("subject")
@option(
    "--with",
    "replaced",
    multiple=True,
    metavar="NAME=SUBJECT",
    section=WHO,
    help="Let another SUBJECT play an agent or a team (repeatable).",
)
@option(
    "--against",
    multiple=True,
    metavar="OPPONENT",
    section=WHO,
    help="Opponents: another SUBJECT, scripted or random (repeatable).",
)
@option(
    "--expert",
    default=None,
    metavar="EXPERT",
    section=WHO,
    help="The expert to compare with (default: the profile's own, if it is shipped).",
)
@option(
    "--world",
    default=None,
    section=WHO,
    help="The world, where a file cannot say it: module:function, gymnasium:ID.",
)
@option("--team", default=None, metavar="NAME", section=HOW, help="Measure one team only.")
@option("--episodes", default=1_000, show_default=True, section=HOW, help="Held-out episodes, at most 100,000.")
@option("--json", "as_json", is_flag=True, section=HOW, help="Print one JSON object.")
@click.pass_context
def evaluate(context: click.Context, subject: str, as_json: bool, **options: Any) -> int:
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
    from maviper.evaluation.run import EvaluateOptions, document, evaluated, lines, request

    asked = request(subject, EvaluateOptions(**options))
    with console.live("playing", 1) as live:

        def show(done: int, total: int) -> None:
            live.total = total
            live.update(done, "line-ups")

        found = evaluated(asked, show)
    if as_json:
        click.echo(layout(document(asked, found)))
    else:
        say("\n".join(lines(asked, found)))
    return ExitCode.DONE
