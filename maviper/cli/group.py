"""How commands read and show themselves: groups of commands, sections of options, examples, renamed options.

Does: click's classes with a help that is read at one glance; suggests the closest command for a wrong one.
Assumes: the first sentence of a command's help fits on one line beside its name; a test checks it.
Does not: know any command.
"""

import inspect
from collections.abc import Mapping, Sequence
from typing import Any

import click

from codegen.errors import escape_text, steers, suggestion

MAX_COLUMN = 30  # of names beside their texts; a longer name stands on a line of its own


class Option(click.Option):
    """An option that stands under the heading `section` in the help of its command."""

    def __init__(self, *names: Any, section: str = "Options", **settings: Any) -> None:
        super().__init__(*names, **settings)
        self.section = section


class Verb(click.Command):
    """A command with an example, sections of options, and options that had another name before."""

    def __init__(self, *names: Any, example: str = "", renamed: Mapping[str, str] | None = None, **more: Any) -> None:
        # of each command, not of the group: click keeps the help option of whoever asks first, with or without a parent
        super().__init__(*names, **{"context_settings": {"help_option_names": ["-h", "--help"]}, **more})
        self.example, self.renamed = example, dict(renamed or {})

    @property
    def one_line(self) -> str:
        """The first sentence of the help."""
        paragraph = inspect.cleandoc(self.help or "").split("\n\n")[0]
        return " ".join(paragraph.split()).split(". ")[0].split(": ")[0].rstrip(".")

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """As click's, with the old names of options, each of which is answered by its new name in a line. A word that
        holds what nobody sees, such as the end of a line, is refused: errors, reports and commands show it.
        """
        for word in args:
            if steers(word):
                ctx.fail(f"an argument holds an invisible character: {escape_text(word)}")
        end = args.index("--") if "--" in args else len(args)
        return super().parse_args(ctx, [self._today(ctx, word) for word in args[:end]] + args[end:])

    def _today(self, ctx: click.Context, word: str) -> str:
        name, separator, value = word.partition("=")
        if name not in self.renamed:
            return word
        if not (ctx.obj and ctx.obj["quiet"]):
            click.echo(f"{name} is now {self.renamed[name]}", err=True)
        return f"{self.renamed[name]}{separator}{value}"

    def format_options(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """The options under their headings, in the order in which headings first appear; --help is the last one."""
        sections: dict[str, list[tuple[str, str]]] = {}
        for parameter in self.get_params(ctx):
            record = parameter.get_help_record(ctx) if isinstance(parameter, click.Option) else None
            if record is not None:
                sections.setdefault(getattr(parameter, "section", "Options"), []).append(record)
        general = sections.pop("Options", [])
        wide = [len(name) for records in (general, *sections.values()) for name, _ in records]
        width = max((each for each in wide if each <= MAX_COLUMN), default=0)
        for heading, records in (*sections.items(), *([("Options", general)] if general else [])):
            with formatter.section(heading):
                formatter.write_dl([(f"{name:<{width}}", text) for name, text in records])

    def format_epilog(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """The example, then what else stands at the end."""
        if self.example:
            with formatter.section("Example"):
                for line in self.example.splitlines():
                    formatter.write(f"{'':>{formatter.current_indent}}{line}\n")
        super().format_epilog(ctx, formatter)


class Verbs(Verb, click.Group):
    """A group that shows each command in one whole line and suggests the closest one."""

    def __init__(self, *names: Any, chapters: Mapping[str, Sequence[str]] | None = None, **more: Any) -> None:
        super().__init__(*names, **more)
        self.chapters = dict(chapters or {})

    def resolve_command(self, ctx: click.Context, args: list[str]) -> Any:
        """As click's, with a suggestion."""
        if args and self.get_command(ctx, args[0]) is None and not args[0].startswith("-"):
            ctx.fail(f"unknown command '{escape_text(args[0])}'; {suggestion(args[0], self.list_commands(ctx))}")
        return super().resolve_command(ctx, args)

    def format_options(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """The commands, then the options."""
        self.format_commands(ctx, formatter)
        super().format_options(ctx, formatter)

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """The commands by chapter; without chapters in one list."""
        known = {name: command for name, command in self.commands.items() if isinstance(command, Verb)}
        width = max(map(len, known), default=0)
        for chapter, names in (self.chapters or {"Commands": self.list_commands(ctx)}).items():
            with formatter.section(chapter):
                formatter.write_dl([(f"{name:<{width}}", known[name].one_line) for name in names])
