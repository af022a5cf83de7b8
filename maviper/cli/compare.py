"""The command compare.

Does: has algorithms, depths and seeds compared on an expert, and prints what came out.
Assumes: `maviper.reproduction.compare` plans, makes and writes.
Does not: compute anything.
"""

from pathlib import Path
from typing import TYPE_CHECKING, Unpack

import click

from maviper.cli.options import Verb, options_of, output
from maviper.options import CompareOptions

if TYPE_CHECKING:
    from maviper.console import Console


@click.command(
    cls=Verb,
    example="maviper compare cooperative-navigation --max-episodes 400 -o compared\n"
    "maviper compare mygame:act --world mygame:make --depths 2,3 -o mine",
)
@click.argument("expert")
@options_of(CompareOptions)
@output("The folder of the comparison.")
def compare(console: "Console", expert: str, output: Path, **options: Unpack[CompareOptions]) -> int:
    """Compare algorithms and depths on an expert, over seeds.

    EXPERT is named as for `maviper extract`. Each algorithm is given the same number of episodes at every depth and
    seed, and its trees are measured in held-out episodes that the expert plays, too. The output has means with 95 %
    intervals, ratios to the expert, leaves, fidelity, episodes, CPU time, and verdicts on differences.

    The folder gets this table as CSV and LaTeX, a figure and the best trees. An interrupted call goes on when it is
    repeated, and several calls may work on one folder at the same time.
    """
    console.line("comparing", expert)
    from maviper.reproduction.compare import compare_algorithms, request

    found = compare_algorithms(expert, output, request(options), console)
    console.give(found.document, found.lines)
    return found.code
