"""What the commands share.

Does: the option for results, the console of a call.
Assumes: the group has put its flags into the context.
Does not: import anything heavy before a command needs it.
"""

from pathlib import Path
from typing import Any

import click

OUTPUT = click.option("-o", "--output", type=click.Path(path_type=Path), required=True, help="Where results go.")


def console_of(context: click.Context) -> Any:
    """The console, quiet where --quiet was given."""
    from maviper.console import Console

    return Console(context.obj["quiet"])
