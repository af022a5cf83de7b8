"""The directive `commands`: what `maviper COMMAND --help` prints of every command that it shows, from click.

Does: makes a section of each command, with its text, its options by heading, and its example.
Assumes: the commands' own classes, which have headings and examples; any command of click has the rest.
Does not: know a command by name.
"""

import inspect
from collections.abc import Iterator

import click
from docutils import nodes
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective

from maviper.cli.main import cli


class Commands(SphinxDirective):
    """A section for each command of maviper."""

    def run(self) -> list[nodes.Node]:
        """Returns the sections, in the order of the help."""
        return self.parse_text_to_nodes("\n".join(tell("maviper", cli)), allow_section_headings=True)


def tell(path: str, command: click.Command) -> Iterator[str]:
    """The lines of a command's section, and of those below it."""
    context, sections = click.Context(command, info_name=path), dict[str, list[click.Option]]()
    usage = " ".join([path, *command.collect_usage_pieces(context)])
    yield from (path, "=" * len(path), "", f".. program:: {path}", "", *code(usage), *paragraphs(command.help))
    for option in command.params:
        if isinstance(option, click.Option) and not option.hidden:
            sections.setdefault(getattr(option, "section", "Options"), []).append(option)
    for heading, options in sections.items():
        yield from (f".. rubric:: {heading}", "")
        for names, text in filter(None, (option.get_help_record(context) for option in options)):
            yield from (f".. option:: {names}", "", *(f"   {line}" for line in paragraphs(text)))
    if example := getattr(command, "example", ""):
        yield from (".. rubric:: Example", "", *code(example))
    yield from paragraphs(command.epilog)
    for name, below in getattr(command, "commands", {}).items():
        if not below.hidden:
            yield from tell(f"{path} {name}", below)


def code(text: str) -> tuple[str, ...]:
    """Lines that stay as they are."""
    return "::", "", *(f"    {line}" for line in text.splitlines()), ""


def paragraphs(text: str | None) -> Iterator[str]:
    """The lines of a help text; a paragraph that begins with \\b stays as it is."""
    for each in inspect.cleandoc(text or "").split("\n\n"):
        yield from code(each[2:]) if each.startswith("\b\n") else (each.replace("@", r"\@"), "")


def setup(app: Sphinx) -> None:
    """Registers the directive."""
    app.add_directive("commands", Commands)
