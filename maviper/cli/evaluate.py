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
    help="Another SUBJECT for an agent or a team (repeatable).",
)
@option(
    "--against",
    multiple=True,
    metavar="OPPONENT",
    section=WHO,
    help="Another SUBJECT, scripted or random (repeatable).",
)
@option(
    "--expert",
    default=None,
    metavar="EXPERT",
    section=WHO,
    help="What ratios and fidelity refer to (default: a profile's own, if it is shipped).",
)
@option("--world", default=None, section=WHO, help="module:function of the environment, if it is your own.")
@option("--team", default=None, metavar="NAME", section=HOW, help="Measure one team only.")
@option("--episodes", default=1_000, show_default=True, section=HOW, help="Held-out episodes, at most 100,000.")
@option("--json", "as_json", is_flag=True, section=HOW, help="Print one JSON object.")
@click.pass_context
def evaluate(context: click.Context, subject: str, as_json: bool, **options: Any) -> int:
    """Measure a profile or an expert in play.

    SUBJECT is a profile (FILE.json), or an expert as `maviper extract` reads it; --with mixes them. FILE.json is always
    a profile.

    Each team plays against the opponents. The expert plays beside it, in the same place and the same episodes. The
    answer has measures, returns and ratios, all with intervals. A joint ratio is that of the whole team; an individual
    one is that of one agent among experts. For trees it adds their size, their comparisons per decision, and their
    fidelity to the expert. Opponents are the expert by default, or SUBJECT where there is no expert.
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
