"""The directive `commands`: every command with its text, its options by section and its example, from click.

Does: writes what `--help` shows, as sections with anchors; leaves out what is hidden.
Assumes: the commands' own classes, which have sections and examples; any command of click has the rest.
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
        """The sections, parsed where the directive stands."""
        text = "\n".join(line for path, command in walk(cli, "maviper") for line in tell(path, command))
        return self.parse_text_to_nodes(text, allow_section_headings=True)


def walk(command: click.Command, path: str) -> Iterator[tuple[str, click.Command]]:
    """A command and those below it, in the order of the help, with the words that name them."""
    yield path, command
    if isinstance(command, click.Group):
        below = [name for names in getattr(command, "chapters", {}).values() for name in names]
        for name in below or command.list_commands(click.Context(command)):
            if not command.commands[name].hidden:
                yield from walk(command.commands[name], f"{path} {name}")


def tell(path: str, command: click.Command) -> Iterator[str]:
    """The lines of a command's section."""
    context = click.Context(command, info_name=path)
    yield from (path, "=" * len(path), "", f".. program:: {path}", "")
    yield from ("::", "", f"    {' '.join([path, *command.collect_usage_pieces(context)])}", "")
    for paragraph in inspect.cleandoc(command.help or "").split("\n\n"):
        kept = paragraph.startswith("\b\n")  # lines that click leaves as they are
        yield from (*(f"| {line}" for line in paragraph.splitlines()[1:]), "") if kept else (paragraph, "")
    sections: dict[str, list[tuple[str, str]]] = {}
    for parameter in command.get_params(context):
        if record := parameter.get_help_record(context) if isinstance(parameter, click.Option) else None:
            sections.setdefault(getattr(parameter, "section", "Options"), []).append(record)
    for heading, records in sections.items():
        yield from (f".. rubric:: {heading}", "")
        for names, text in records:
            yield from (f".. option:: {names}", "", f"   {text}", "")
    if example := getattr(command, "example", ""):
        yield from (".. rubric:: Example", "", "::", "", *(f"    {line}" for line in example.splitlines()), "")
    if command.epilog:
        yield from ("::", "", *(f"    {line}" for line in command.epilog.removeprefix("\b\n").splitlines()), "")


def setup(app: Sphinx) -> None:
    """Registers the directive."""
    app.add_directive("commands", Commands)
