"""The options of verify that say what is asked.

Does: adds the table of options, and those that the command alone has: several claims, files, stated systems.
Assumes: `maviper.verification.ask.VerifyOptions` has a field for each.
Does not: check values beyond their form.
"""

from typing import Any

import click

from codegen.errors import ExitCode
from maviper.cli.options import PATH, REGION, option, options_of
from maviper.options import VerifyOptions
from maviper.options.verification import BUDGETS, QUESTION


def _list_properties(context: click.Context, _parameter: click.Parameter, asked: bool) -> None:
    if asked and not context.resilient_parsing:
        from maviper.cli.properties import print_properties

        print_properties(as_json=False)
        context.exit(ExitCode.DONE)


QUESTION_OPTIONS = (
    option(
        "--property",
        "names",
        multiple=True,
        metavar="NAME",
        section=QUESTION,
        help="A built-in property (repeatable; default: distinct_targets).",
    ),
    option("--properties", "file", type=PATH, default=None, section=QUESTION, help="A property file (TOML)."),
    option(
        "--list",
        is_flag=True,
        is_eager=True,
        expose_value=False,
        callback=_list_properties,
        section=QUESTION,
        help="List the built-in properties.",
    ),
    option(
        "--world",
        type=PATH,
        default=None,
        section=QUESTION,
        help="A world file (TOML): claims are about the system that it states, those of the file or of --properties.",
    ),
    option(
        "--run-reference",
        is_flag=True,
        section=QUESTION,
        help="With --world: also run user code (an environment) that the file names, to measure the statement.",
    ),
    REGION,
)
STATED_OPTIONS = (
    option(
        "--max-states",
        default=None,
        type=int,
        section=BUDGETS,
        help="With --world: limit on symbolic states visited per claim (default: 200000).",
    ),
    option(
        "--max-programs",
        default=None,
        type=int,
        section=BUDGETS,
        help="With --world: limit on linear programs solved per claim (default: 100000).",
    ),
)


def asked(command: Any) -> Any:
    """Adds all of them to a command."""
    for each in reversed((*QUESTION_OPTIONS, options_of(VerifyOptions), *STATED_OPTIONS)):
        command = each(command)
    return command
