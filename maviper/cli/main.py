"""The command line: all commands in one group.

Does: gathers the commands under chapters, states the exit codes, runs a command line inside a program.
Assumes: files of commands import nothing heavy before a command runs.
Does not: turn exceptions into exit codes (exits.py) or lay out help texts (options.py).
"""

import click

from maviper.cli import exits
from maviper.cli.look import compare, evaluate, play, show, worlds
from maviper.cli.make import compile_verb, edit, extract, import_verb, train
from maviper.cli.options import Verbs
from maviper.cli.prove import check, diff, repair, replay
from maviper.cli.start import demo, guide, reproduce
from maviper.cli.verify import verify

CHAPTERS = {
    "Start here": (demo, guide),
    "Make a team": (worlds, extract, import_verb, edit),
    "Look and measure": (show, play, evaluate, compare),
    "Compile": (compile_verb,),
    "Verify": (verify, check, replay, repair, diff),
}
MORE = (train, reproduce)  # not on the first screen
EXIT_CODES = """\b
Exit codes:
  0   done, and everything asked was proved
  1   a claim is violated, a threshold missed, or a certificate refused
  2   usage, configuration or input error
  3   inconclusive: VACUOUS, UNKNOWN or SKIPPED
  4   generated code disagrees with the profile
  5   a package, a compiler, room for the output or its reader is missing
  70  a bug in maviper
  130 interrupted
When several apply, 70 > 4 > 1 > 3. Only `demo` expects a violation: it exits
with 0 when every step gave the expected outcome.

More commands: train (an expert), reproduce (the paper's experiments).
PROFILE is a file of a team's trees, as extract, import and demo write it."""
NAMES = {chapter: [str(command.name) for command in commands] for chapter, commands in CHAPTERS.items()}


@click.group(cls=Verbs, chapters=NAMES, example="maviper demo -o demo", epilog=EXIT_CODES)
@click.version_option(package_name="maviper")
@click.option("-q", "--quiet", is_flag=True, help="Print results and errors only, with any command.")
@click.option("-v", "--verbose", is_flag=True, help="Print all of a report, and the traceback of an error.")
@click.option("--json", "as_json", is_flag=True, help="Print the result as JSON, and nothing else.")
@click.pass_context
def cli(context: click.Context, quiet: bool, verbose: bool, as_json: bool) -> None:
    """Extract small decision trees from multi-agent experts, compile them exactly, and verify the team."""
    context.obj = {"quiet": quiet, "verbose": verbose, "json": as_json}


for command in (*(command for commands in CHAPTERS.values() for command in commands), *MORE):
    cli.add_command(command)


def run(arguments: list[str]) -> int:
    """Runs the command line inside a program; returns the exit code."""
    verbose = bool({"-v", "--verbose"} & set(arguments))
    return exits.run_command(lambda: cli.main(args=arguments, prog_name="maviper", standalone_mode=False), verbose)
