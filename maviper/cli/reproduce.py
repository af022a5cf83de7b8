"""The command reproduce.

Does: has the paper's experiments run and reported, or their plan said.
Assumes: `maviper.reproduction.run` plans, runs and writes.
Does not: know what a cell is.
"""

from pathlib import Path
from typing import Any

import click

from codegen.errors import InputError
from maviper.cli.group import Verb
from maviper.cli.options import console_of, names, option, output

WHAT, HOW = "What is reproduced", "How it runs"


def numbers(context: click.Context, parameter: click.Parameter, value: str | None) -> tuple[int, ...] | None:
    """Reads whole numbers with commas in between."""
    try:
        return None if value is None else tuple(int(word) for word in value.split(","))
    except ValueError:
        raise InputError(f"'{value}' is no list of numbers", f"--{parameter.name}", "write 2,4,6") from None


@click.command(
    cls=Verb,
    example="maviper reproduce --quick -o reproduction\nmaviper reproduce --plan -o reproduction\n"
    "maviper reproduce --games physical-deception --depths 4 --jobs 2 -o mine",
)
@option("--quick", is_flag=True, section=WHAT, help="Physical deception, depth 4, one seed: a minute.")
@option("--full", is_flag=True, section=WHAT, help="More: the ladder, preset released, leaf budgets, further experts.")
@option(
    "--experts",
    default="mappo",
    show_default=True,
    callback=names,
    metavar="NAMES",
    section=WHAT,
    help="mappo or maddpg (shipped), an expert of your own, or NAME=EXPERT; several with commas.",
)
@option("--games", default=None, callback=names, metavar="NAMES", section=WHAT, help="Some of the three games.")
@option("--depths", default=None, callback=numbers, metavar="NUMBERS", section=WHAT, help="Default: 2,4,6.")
@option(
    "--algorithms",
    default=None,
    callback=names,
    metavar="NAMES",
    section=WHAT,
    help="As for `maviper extract`, and rungs of the ladder (default: the paper's).",
)
@option(
    "--presets",
    default="paper",
    show_default=True,
    callback=names,
    metavar="NAMES",
    section=WHAT,
    help="paper, released, default.",
)
@option("--seeds", type=int, default=None, section=WHAT, help="Extraction seeds (default: 10, with --quick 1).")
@option("--plan", is_flag=True, section=HOW, help="Print the cells and their CPU time; make nothing.")
@option("--report-only", is_flag=True, section=HOW, help="Write table and report from what is finished.")
@option("--shard", default=None, metavar="I/N", section=HOW, help="Make part I of N, beside other calls on the folder.")
@option("--jobs", default=1, show_default=True, section=HOW, help="Cells at the same time.")
@option(
    "--backend", default="local", show_default=True, metavar="NAME", section=HOW, help="local or dask (maviper[scale])."
)
@option(
    "--scheduler",
    default=None,
    metavar="ADDRESS",
    section=HOW,
    help="Of the Dask scheduler (default: DASK_SCHEDULER_ADDRESS).",
)
@output("The folder of the reproduction.")
@click.pass_context
def reproduce(context: click.Context, output: Path, **options: Any) -> int:
    """Reproduce the experiments of the MAVIPER paper.

    Every extraction, cross-play and expert is a cell: a folder with the values of all its episodes. Cells that are
    finished are never made again. So an interrupted call goes on when it is repeated, and several calls may work on one
    folder at the same time.

    A cell that fails is reported, the others go on, and the command ends with exit code 1.
    """
    console = console_of(context)
    console.line("reproducing", str(output))
    from maviper.console import say
    from maviper.reproduction.run import ReproduceOptions, reproduced

    done = reproduced(output, ReproduceOptions(**options), console)
    if done.lines:
        say("\n".join(done.lines))
    return done.code
