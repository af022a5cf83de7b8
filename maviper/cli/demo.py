"""The command demo.

Does: runs the tour (tour.py) into a folder.
Assumes: nothing outside the package; without a C compiler that part is skipped and said.
Does not: do anything that the other commands cannot do.
"""

from pathlib import Path

import click

from maviper.cli.group import Verb
from maviper.cli.options import FOLDER, console_of, option


@click.command(cls=Verb, example="maviper demo -o demo")
@option("-o", "--output", type=FOLDER, default=Path("demo"), show_default=True, help="The folder for results.")
@option("--seed", default=None, type=int, help="The seed of the extraction.")
@click.pass_context
def demo(context: click.Context, output: Path, seed: int | None) -> int:
    """Run the whole chain in a minute, on a shipped expert.

    It extracts trees, finds a state in which a claim about them fails, repairs them until the claim is proved, has
    the proof checked, compiles them and writes reports.
    """
    console = console_of(context)
    console.line("maviper", "physical deception: from a neural team to trees, a proof and code")
    from maviper.cli.tour import run

    return run(output, console, seed)
