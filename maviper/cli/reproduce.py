"""The command reproduce.

Does: has the paper's experiments run and reported, or their plan said.
Assumes: `maviper.reproduction.run` plans, runs and writes.
Does not: know what a cell is.
"""

from pathlib import Path
from typing import Unpack

import click

from maviper.cli.group import Verb
from maviper.cli.options import console_of, options_of, output
from maviper.options import ReproduceOptions


@click.command(
    cls=Verb,
    example="maviper reproduce --quick -o reproduction\nmaviper reproduce --plan -o reproduction\n"
    "maviper reproduce --games physical-deception --depths 4 --jobs 2 -o mine",
)
@options_of(ReproduceOptions)
@output("The folder of the reproduction.")
@click.pass_context
def reproduce(context: click.Context, output: Path, **options: Unpack[ReproduceOptions]) -> int:
    """Reproduce the experiments of the MAVIPER paper.

    Every extraction, cross-play and expert is a cell: a folder with the values of all its episodes. Cells that are
    finished are never made again. So an interrupted call goes on when it is repeated, and several calls may work on one
    folder at the same time.

    A cell that fails is reported, the others go on, and the command ends with exit code 1.
    """
    console = console_of(context)
    console.line("reproducing", str(output))
    from maviper.console import say
    from maviper.reproduction.run import reproduce_paper, request

    done = reproduce_paper(output, request(options), console)
    if done.lines:
        say("\n".join(done.lines))
    return done.code
