"""What the commands share.

Does: options that several commands have, readers of their values, the console of a call.
Assumes: the group has put its flags into the context.
Does not: import anything heavy before a command needs it.
"""

from collections.abc import Callable
from fractions import Fraction
from pathlib import Path
from typing import Any

import click

from maviper.cli.group import Option

PATH = click.Path(path_type=Path)
PROFILE = click.argument("profile", type=PATH)
QUESTION, PARAMETERS, EXTENT, BUDGETS, RESULTS = (
    "What is asked",
    "Parameters of claims",
    "Where a claim holds",
    "Budgets",
    "Results",
)


def option(*names: str, **settings: Any) -> Callable[[Any], Any]:
    """An option, with the heading under which the help shows it as `section`."""
    return click.option(*names, cls=Option, **settings)


def fraction(_context: click.Context, parameter: click.Parameter, value: str | None) -> Fraction | None:
    """Reads an exact number: a decimal, or a fraction such as 1/40."""
    from verify.claims.region import exact

    return None if value is None else exact(value, f"--{parameter.name}")


def names(_context: click.Context, _parameter: click.Parameter, value: str | None) -> tuple[str, ...] | None:
    """Reads names with commas in between."""
    return None if value is None else tuple(name.strip() for name in value.split(","))


def output(text: str = "Where results go.") -> Callable[[Any], Any]:
    """The option -o, which must be given."""
    return option("-o", "--output", type=PATH, required=True, help=text, section=RESULTS)


REGION = option(
    "--region",
    default="start",
    show_default=True,
    metavar="REGION",
    section=QUESTION,
    help="`start` (the start region) or a region file (TOML).",
)
MARGIN = option(
    "--margin",
    callback=fraction,
    metavar="NUMBER",
    section=PARAMETERS,
    help="An agent closes on a landmark when it is ahead by more than this (default: 0).",
)


def console_of(context: click.Context) -> Any:
    """The console, quiet where --quiet was given."""
    from maviper.console import Console

    return Console(context.obj["quiet"])
