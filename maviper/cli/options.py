"""What the commands share.

Does: options that several commands have, readers of their values, the console of a call.
Assumes: the group has put its flags into the context.
Does not: import anything heavy before a command needs it.
"""

import os
from collections.abc import Callable, Sequence
from fractions import Fraction
from functools import partial
from pathlib import Path
from typing import Any, cast

import click

from codegen.errors import InputError, escape_text
from maviper.cli.group import Option
from maviper.options.table import Option as Table
from maviper.options.table import table_of
from maviper.options.verification import QUESTION

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
    default = (",".join(asked.default or ()) or None) if asked.commas else asked.default or None
    default = asked.default if asked.base in (int, float) else default
    exact = asked.base is Fraction
    kind = PATH if asked.base is Path else str if asked.commas or exact else asked.base
    kind = click.Choice(asked.choices) if asked.choices else str if asked.words else kind
    reader = (numbers if asked.base is int else names) if asked.commas else fraction if exact else None
    reader = partial(_number_or_word, asked.words) if asked.words else reader
    about |= {"type": kind, "multiple": asked.several and not asked.commas, "callback": reader}
    return option(asked.flag, asked.name, default=default, show_default=default is not None, **about)


def output(text: str, kind: click.Path = FOLDER) -> Callable[[Any], Any]:
    """The option -o, which must be given."""
    return option("-o", "--output", type=kind, required=True, help=text, section=RESULTS)


REGION = option(
    "--region",
    default="start",
    show_default=True,
    metavar="REGION",
    section=QUESTION,
    help="`start` (the start region) or a region file (TOML).",
)


def console_of(context: click.Context) -> Any:
    """The console, quiet where --quiet was given."""
    from maviper.console import Console

    return Console(context.obj["quiet"])
