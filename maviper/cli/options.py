"""What the commands share: how they read and show themselves, and options that several of them have.

Does: click's classes with a help that is read at one glance: groups of commands, sections of options, examples;
  suggests the closest command for a wrong one; readers of options' values, the console of a call.
Assumes: the group has put its flags into the context; the first sentence of a command's help fits on one line beside
  its name; a test checks it.
Does not: know any command, or import anything heavy before a command needs it.
"""

import inspect
import os
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from fractions import Fraction
from functools import partial
from pathlib import Path
from typing import Any, cast

import click

from codegen.errors import InputError, escape_text, steers, suggestion
from maviper.options.table import Option as Table
from maviper.options.table import split_setting, table_of
from maviper.options.verbs import QUESTION
from maviper.options.verbs import RARER as MORE

MAX_COLUMN = 30  # of names beside their texts; a longer name stands on a line of its own


GENERAL = {"-q": "quiet", "--quiet": "quiet", "-v": "verbose", "--verbose": "verbose", "--json": "json"}


class Option(click.Option):
    """An option that stands under the heading `section` in the help of its command."""

    def __init__(self, *names: Any, section: str = "Options", **settings: Any) -> None:
        super().__init__(*names, **settings)
        self.section = section


class Verb(click.Command):
    """A command with an example and sections of options. `settings` are options that are hidden and given by --set."""

    def __init__(self, *names: Any, example: str = "", settings: Sequence[str] = (), **more: Any) -> None:
        # of each command, not of the group: click keeps the help option of whoever asks first, with or without a parent
        super().__init__(*names, **{"context_settings": {"help_option_names": ["-h", "--help"]}, **more})
        self.example, self.settings = example, {name: f"--{name.replace('_', '-')}" for name in settings}
        for parameter in self.params:
            if isinstance(parameter, click.Option) and parameter.name in self.settings:
                parameter.hidden = True

    @property
    def one_line(self) -> str:
        """The first sentence of the help."""
        paragraph = inspect.cleandoc(self.help or "").split("\n\n")[0]
        return " ".join(paragraph.split()).split(". ")[0].split(": ")[0].rstrip(".")

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """As click's. A word that holds what nobody sees, such as the end of a line, is refused: errors, reports and
        commands show it.
        """
        for word in args:
            if steers(word):
                ctx.fail(f"an argument holds an invisible character: {escape_text(word)}")
        end = args.index("--") if "--" in args else len(args)
        said: dict[str, bool] = {} if ctx.obj is None else ctx.obj
        if ctx.parent is not None:
            said |= {GENERAL[word]: True for word in args[:end] if word in GENERAL}
            args = [word for word in args[:end] if word not in GENERAL] + args[end:]
            end = args.index("--") if "--" in args else len(args)
        return super().parse_args(ctx, [*self._spread_settings(ctx, args[:end]), *args[end:]])

    def invoke(self, ctx: click.Context) -> Any:
        """Runs the command with its console."""
        if not isinstance(self, click.Group):
            ctx.params["console"] = console_of(ctx)
        return super().invoke(ctx)

    def _spread_settings(self, ctx: click.Context, words: Iterable[str]) -> Iterator[str]:
        """The words, each `--set NAME=VALUE` as the hidden option of that name. `--set help` lists them, and ends."""
        words = iter(words)
        for word in words:
            flag, equals, value = word.partition("=")
            if flag != "--set" or not self.settings:
                yield word
                continue
            written = value if equals else next(words, "")
            if written.partition("=")[0] == "help":
                self._list_settings()
                ctx.exit()
            name, given = split_setting(written, [*self.settings])
            yield from (self.settings[name], given)

    def _list_settings(self) -> None:
        """Prints the name, values, default and text of each setting."""
        known = {each.name: each for each in self.params if isinstance(each, click.Option)}
        for name in self.settings:
            one = known[name]
            usual = "the algorithm's" if one.default in (None, "") else one.default
            told = "" if "(default" in (one.help or "") else f" (default: {usual})"
            click.echo(f"{name:<20}{one.metavar or one.type.name.upper()}\n    {one.help}{told}")

    def format_options(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """The options under their headings, in the order in which headings first appear; rarer ones are last."""
        sections: dict[str, list[tuple[str, str]]] = {}
        for parameter in self.get_params(ctx):
            record = parameter.get_help_record(ctx) if isinstance(parameter, click.Option) else None
            if record is not None and ("--help" not in parameter.opts or isinstance(self, click.Group)):
                sections.setdefault(getattr(parameter, "section", "Options"), []).append(record)
        last = [(heading, sections.pop(heading)) for heading in (MORE, "Options") if heading in sections]
        wide = [len(name) for _, records in (*sections.items(), *last) for name, _ in records]
        width = max((each for each in wide if each <= MAX_COLUMN), default=0)
        for heading, records in (*sections.items(), *last):
            with formatter.section(heading):
                formatter.write_dl([(f"{name:<{width}}", text) for name, text in records])

    def format_epilog(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """The example, then what else stands at the end."""
        if self.example:
            with formatter.section("Example"):
                for line in self.example.splitlines():
                    formatter.write(f"{'':>{formatter.current_indent}}{line}\n")
        if ctx.parent is not None and not isinstance(self, click.Group):
            formatter.write("\nAlso -q, -v, --json and -h: see `maviper --help`.\n")
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


FILES = {  # what names of files end in: a folder of such a name is nearly always a mistake
    *(".c", ".cpp", ".csv", ".h", ".hpp", ".htm", ".html", ".js", ".json", ".md", ".mjs", ".npz", ".onnx", ".pdf"),
    *(".png", ".pt", ".pth", ".py", ".rs", ".safetensors", ".smt2", ".svg", ".toml", ".txt", ".yaml", ".yml", ".zip"),
}


class FolderPath(click.Path):
    """The path of an output folder. InputError for a name that a file would have, unless such a folder is there."""

    def __init__(self, *files: str) -> None:
        """`files`: endings of names that stand for files of the command's own."""
        super().__init__(path_type=Path)
        self._files = files

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """The path, checked."""
        if not str(value):
            flag = param.opts[0] if param else "-o"
            raise InputError(f"{flag} names no folder", "an empty name", f"write {flag} . for this folder")
        path = cast("Path", super().convert(value, param, ctx))
        if path.suffix.lower() in FILES - {*self._files} and not os.path.isdir(path):  # noqa: PTH112 - also too long
            flag = param.opts[0] if param else "-o"
            what = f"{flag} names a folder here, and {path.suffix} is what names of files end in"
            ours = f", or a file that ends in {' or '.join(self._files)}" if self._files else ""
            raise InputError(what, str(path), f"choose a folder: {flag} {path.with_suffix('')}{ours}")
        return path


PATH, FOLDER = click.Path(path_type=Path), FolderPath()
PROFILE = click.argument("profile", type=PATH)
RESULTS = "Results"


def option(*names: str, **settings: Any) -> Callable[[Any], Any]:
    """An option, with the heading under which the help shows it as `section`."""
    return click.option(*names, cls=Option, **settings)


def fraction(_context: click.Context, parameter: click.Parameter, value: str | None) -> Fraction | None:
    """Reads an exact number: a decimal, or a fraction such as 1/40."""
    from verify.decimals import exact

    return None if value is None else exact(value, f"--{parameter.name}")


def names(_context: click.Context, _parameter: click.Parameter, value: str | None) -> tuple[str, ...] | None:
    """Reads names with commas in between."""
    return None if value is None else tuple(name.strip() for name in value.split(","))


def numbers(_context: click.Context, parameter: click.Parameter, value: str | None) -> tuple[int, ...] | None:
    """Reads whole numbers with commas in between."""
    try:
        return None if value is None else tuple(int(word) for word in value.split(","))
    except ValueError:
        raise InputError(f"'{value}' is no list of numbers", f"--{parameter.name}", "write 2,4,6") from None


def _number_or_word(
    words: Sequence[str], _context: click.Context, parameter: click.Parameter, value: str | None
) -> int | str | None:
    """Reads a whole number, or one of some words."""
    if value is None or value in words:
        return value
    try:
        return int(value)
    except ValueError:
        advice = f"write 25, or {' or '.join(words)}"
        raise InputError(f"'{escape_text(value)[:40]}' is no whole number", f"--{parameter.name}", advice) from None


def options_of(asked: type, *names: str) -> Callable[[Any], Any]:
    """The options of a verb's table: those of these names, or all."""

    def add(command: Any) -> Any:
        for name in reversed(names or tuple(table_of(asked))):
            command = _option_of(table_of(asked)[name])(command)
        return command

    return add


def _option_of(asked: Table) -> Callable[[Any], Any]:
    """An option of a table. Its default is shown where it says more than that nothing was given."""
    about: dict[str, Any] = {"section": asked.section, "help": asked.help, "metavar": asked.form or None}
    if asked.base is bool:
        return option(
            asked.flag, asked.name, is_flag=True, flag_value=not asked.default, default=asked.default, **about
        )
    default = (",".join(map(str, asked.default or ())) or None) if asked.commas else asked.default or None
    default = asked.default if asked.base in (int, float) and not asked.commas else default
    exact = asked.base is Fraction
    kind = PATH if asked.base is Path else str if asked.commas or exact else asked.base
    kind = click.Choice(asked.choices) if asked.choices else str if asked.words else kind
    reader = (numbers if asked.base is int else names) if asked.commas else fraction if exact else None
    reader = partial(_number_or_word, asked.words) if asked.words else reader
    about |= {"type": kind, "multiple": asked.several and not asked.commas, "callback": reader}
    return option(asked.flag, asked.name, default=default, show_default=default is not None, **about)


SETTING = option(
    "--set",
    multiple=True,
    expose_value=False,
    metavar="NAME=VALUE",
    section=MORE,
    help="A rarer setting (--set help lists them).",
)


def output(text: str, kind: click.Path = FOLDER) -> Callable[[Any], Any]:
    """The option -o, which must be given."""
    return option("-o", "--output", type=kind, required=True, help=text, section=RESULTS)


_region = partial(option, "--region", default="start", show_default=True, metavar="REGION", section=QUESTION)
REGION = _region(help="`start` (where episodes start), or a region file (TOML).")
OBSERVED_REGION = _region(
    help="`start` (where episodes start), or a region file (TOML); of observations also `seen` (what episodes showed; "
    "`start` means it there) and `ranges` (all that features may be).",
)


def console_of(context: click.Context) -> Any:
    """The console, quiet where --quiet was given. While the command runs, it is `maviper.console.current`."""
    from maviper import console

    said: Mapping[str, bool] = context.obj or {}
    console.current = console.Console(said.get("quiet", False), json=say_json if said.get("json") else None)
    context.call_on_close(lambda: setattr(console, "current", None))
    return console.current


def say_json(document: Mapping[str, Any]) -> None:
    """A result on standard output, as JSON."""
    from codegen.policy_json import layout

    click.echo(layout(document))
