"""The options of verify that say what is asked.

Does: adds the table of options, and those that the command alone has: several claims, files, stated systems.
Assumes: `maviper.verification.ask.VerifyOptions` has a field for each.
Does not: check values beyond their form.
"""

from typing import Any

import click

from codegen.errors import ExitCode
from maviper.cli.options import PATH, REGION, option, options_of
from maviper.options import SystemOptions, VerifyOptions
from maviper.options.verification import QUESTION


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
    options_of(SystemOptions, "run_reference"),
    REGION,
)


def add_verify_options(command: Any) -> Any:
    """Adds all of them to a command."""
    of_systems = options_of(SystemOptions, "max_boxes")
    for each in reversed((*QUESTION_OPTIONS, options_of(VerifyOptions), of_systems)):
        command = each(command)
    return command
