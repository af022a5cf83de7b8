"""The commands demo, guide and reproduce.

Does: runs the tour (maviper/tour.py) into a folder; lists the topics of the manual, or lays out the page of one; has
  the paper's experiments run and reported, or their plan said.
Assumes: pages are Markdown that reads well in a terminal; `maviper.reproduction.run` plans, runs and writes.
Does not: do anything that the other commands cannot do.
"""

import os
import shutil
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Unpack

import click

from codegen.errors import ExitCode
from maviper.cli.options import FOLDER, Verb, option, options_of, output
from maviper.options import ReproduceOptions

if TYPE_CHECKING:
    from maviper.console import Console


WIDEST = 100  # columns of a page of the manual, on a wider terminal


@click.command(cls=Verb, example="maviper demo -o demo")
@option("-o", "--output", type=FOLDER, default=Path("demo"), show_default=True, help="The folder for results.")
@option("--seed", default=None, type=int, hidden=True, help="The seed of the extraction.")
def demo(console: "Console", output: Path, seed: int | None) -> int:
    """Run the whole chain in about 20 seconds, on a shipped expert.

    It extracts trees, finds a state in which a claim about them fails, repairs them until the claim is proved, has
    the proof checked, compiles them and writes reports.
    """
    console.line("maviper", "physical deception: from a neural team to trees, a proof and code")
    from maviper.tour import run_tour

    return run_tour(output, console, seed)


@click.command(cls=Verb, example="maviper guide\nmaviper guide claims")
@click.argument("topic", required=False)
def guide(console: "Console", topic: str | None) -> int:
    """Print a page of the manual, or the list of its topics.

    On a terminal the page is laid out at its width, and opens in your pager.
    """
    from maviper import manual

    if topic is None:
        titles = manual.topics()
        width = max(map(len, titles))
        lines = [
            line
            for kind, names in manual.KINDS.items()
            for line in (f"{kind}:", *(f"  {name:<{width}}  {titles[name]}" for name in names))
        ]
        console.give({"topics": dict(titles)}, lines)
    elif console.json:
        console.give({"topic": topic, "page": manual.page(topic)})
    elif sys.stdout.isatty():
        text = _laid_out(manual.page(topic))
        os.dup2(sys.stdout.fileno(), 1)  # a pager writes there
        click.echo_via_pager(text)
    else:
        click.echo(manual.page(topic), nl=False)
    return ExitCode.DONE


def _laid_out(page: str) -> str:
    """The page as the terminal shows Markdown, at its width; pictures and targets of links are left out."""
    from rich.console import Console
    from rich.markdown import Markdown
    from rich.theme import Theme

    theme = Theme({"markdown.code": "cyan", "markdown.code_block": "cyan"})  # not on black: terminals may be light
    width = min(shutil.get_terminal_size().columns, WIDEST)
    console = Console(width=width, force_terminal=True, theme=theme)
    with console.capture() as captured:
        console.print(Markdown(page, hyperlinks=False))
    return captured.get()


@click.command(
    cls=Verb,
    example="maviper reproduce --quick -o reproduction\nmaviper reproduce --plan -o reproduction\n"
    "maviper reproduce --games physical-deception --depths 4 --jobs 2 -o mine",
)
@options_of(ReproduceOptions)
@output("The folder of the reproduction.")
def reproduce(console: "Console", output: Path, **options: Unpack[ReproduceOptions]) -> int:
    """Reproduce the experiments of the MAVIPER paper.

    Every extraction, cross-play and expert is a cell: a folder with the values of all its episodes. Cells that are
    finished are never made again. So an interrupted call goes on when it is repeated, and several calls may work on one
    folder at the same time.

    A cell that fails is reported, the others go on, and the command ends with exit code 1.
    """
    console.line("reproducing", str(output))
    from maviper.reproduction.run import reproduce_paper, request

    done = reproduce_paper(output, request(options), console)
    console.give({"made": done.made, "failed": done.failed, "lines": done.lines}, done.lines)
    return done.code
