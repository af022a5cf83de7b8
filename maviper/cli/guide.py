"""The command guide.

Does: lists the topics of the manual, or prints the page of one.
Assumes: pages are Markdown that reads well in a terminal.
Does not: format anything.
"""

import os
import sys

import click

from codegen.errors import ExitCode
from maviper.cli.group import Verb


@click.command(cls=Verb, example="maviper guide\nmaviper guide claims")
@click.argument("topic", required=False)
def guide(topic: str | None) -> int:
    """Print a page of the manual, or the list of its topics.

    On a terminal the page opens in your pager.
    """
    from maviper import manual

    if topic is None:
        titles = manual.topics()
        width = max(map(len, titles))
        for name, title in titles.items():
            click.echo(f"{name:<{width}}  {title}")
    elif sys.stdout.isatty():
        os.dup2(sys.stdout.fileno(), 1)  # a pager writes there
        click.echo_via_pager(manual.page(topic))
    else:
        click.echo(manual.page(topic), nl=False)
    return ExitCode.DONE
