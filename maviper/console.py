"""What a person sees while a command runs: labelled lines and one live line a stage, on standard error.

Does: prints, with what would steer a terminal escaped; a stage redraws its line on a terminal and prints a plain line
  every few seconds elsewhere.
Assumes: standard output belongs to results.
Does not: decide anything.
"""

import math
import os
import re
import shutil
import sys
import textwrap
import time
from bisect import bisect_left
from collections.abc import Callable, Generator, Iterable, Mapping, Sequence
from contextlib import AbstractContextManager, ExitStack, contextmanager
from functools import cached_property
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any, TextIO

import click

from codegen.wording import align_columns, visible

if TYPE_CHECKING:
    from rich.console import Console as RichConsole
    from rich.progress import Progress

LABEL_WIDTH = 12
LEAST_WIDTH = 20  # of the texts beside labels, on a narrower terminal too
PLAIN_SECONDS = 10.0  # between plain lines of a stage
FIRST_SECONDS = 2.0  # ... and before the first
FORCING = {"FORCE_COLOR", "TTY_COMPATIBLE"}  # by which rich takes for a terminal what is none
NUMBERS = re.compile(r"[\d.,]+")  # in the words of what is counted
ENOUGH = 4  # steps whose pace tells that of later ones
COLOURS = {  # of labels, on a terminal that has colours
    "PROVED": "green",
    "accepted": "green",
    "VIOLATED": "red",
    "unexpected": "red",
    "UNKNOWN": "yellow",
    "VACUOUS": "yellow",
}


OnStage = Callable[[str, float, int, str], None]  # the stage, how much is done, of how much, and words


def duration(seconds: float) -> str:
    """Formats a duration as a person says it: seconds up to two minutes, then minutes, then hours."""
    if seconds < 120:
        return f"{seconds:.0f} s"
    minutes = round(seconds / 60)
    return f"{minutes // 60} h {minutes % 60:02d} min" if minutes >= 60 else f"{minutes} min"


def format_rate(rate: float) -> str:
    """Formats a number of steps a second, without an exponent."""
    return f"{rate:,.0f}/s" if rate >= 10 else f"{rate:.2g}/s"


def find_width(stream: "TextIO | None") -> int | None:
    """The columns of a stream's terminal; None for what is no terminal."""
    if stream is None or not stream.isatty():
        return None
    return max(shutil.get_terminal_size().columns, LABEL_WIDTH + LEAST_WIDTH)


def wrap(line: str, width: int | None, indent: int) -> str:
    """A line in lines of words, those after the first one indented."""
    if width is None or len(line) <= width:
        return line
    return textwrap.fill(line, width, subsequent_indent=" " * indent, break_long_words=False, break_on_hyphens=False)


def tabulate(table: Sequence[Sequence[str]], named: int = 1) -> list[str]:
    """A table as lines for standard output, its first row the head. On a terminal that is too narrow it is several,
    each with the first `named` columns, or, where that is shorter, each row is a list: a line for each other cell.
    """
    lines, width = align_columns(table), find_width(sys.stdout)
    if width is None or max(map(len, lines)) <= width:
        return lines
    head, *rows = table
    room = max(map(len, head[named:]))
    listed = [
        line
        for row in rows
        for line in (
            ", ".join(filter(None, row[:named])),
            *(
                f"  {name:<{room}}  {cell}".rstrip()
                for name, cell in zip(head[named:], row[named:], strict=True)
                if cell
            ),
        )
    ]
    parts = _split_columns(table, named, width)
    return parts if parts and len(parts) < len(listed) else listed


def _split_columns(table: Sequence[Sequence[str]], named: int, width: int) -> list[str]:
    """The lines of tables that fit, each with the first `named` columns and some of the others; [] where one cannot."""
    lines, rest = list[str](), range(named, len(table[0]))
    while rest:
        wider = [
            align_columns([[*row[:named], *row[rest[0] : end]] for row in table])
            for end in range(rest[0] + 1, rest[-1] + 2)
        ]
        fitting = [each for each in wider if max(map(len, each)) <= width]
        if not fitting:
            return []
        lines += [*[""][: len(lines)], *fitting[-1]]
        rest = rest[len(fitting) :]
    return lines


def say(text: str) -> None:
    """A result on standard output, line by line as a terminal may see it: long ones are broken between words."""
    width = find_width(sys.stdout)
    for line in map(visible, text.split("\n")):
        click.echo(wrap(line, width, len(line) - len(line.lstrip()) + 4))


class Console:
    """Prints to standard error; `quiet` keeps everything back but errors. `of`: whose lines these are, where several
    print at the same time: plain lines that begin with it. `lines`: False for stages alone, on a terminal, while they
    last. `on_stage`: told of each step of a stage. `json`: prints a result that is asked for as JSON.
    """

    def __init__(
        self,
        quiet: bool = False,
        of: str = "",
        lines: bool = True,
        on_stage: "OnStage | None" = None,
        json: "Callable[[Mapping[str, Any]], None] | None" = None,
    ) -> None:
        self.quiet, self.of, self.lines, self.on_stage, self.json = quiet, of, lines, on_stage, json

    @staticmethod
    def showing(progress: "bool | OnStage") -> "Console":
        """The console of a call from Python: as that of a command, quiet, or quiet but for what `progress` is told."""
        return Console(quiet=progress is not True, on_stage=progress if callable(progress) else None)

    @property
    def draws(self) -> bool:
        """Whether stages are drawn: on a terminal, and in notebooks that have widgets."""
        if find_width(sys.stderr) is None and "IPython" not in sys.modules and not FORCING & os.environ.keys():
            return False  # rich would say so too, after an import that takes a while
        return self.rich.is_terminal or (self.rich.is_jupyter and find_spec("ipywidgets") is not None)

    @cached_property
    def rich(self) -> "RichConsole":
        """The console that draws on a terminal; imported only where it is asked for, as that takes a while."""
        from rich.console import Console as RichConsole

        return RichConsole(stderr=True, quiet=self.quiet, highlight=False)

    def line(self, label: str, text: str = "") -> None:
        """One line: a label in its column, then the text. On a terminal, long ones are broken between words."""
        if self.of:
            label, text = self.of, f"{label} {text}"
        if not self.quiet and self.lines:
            print(self._lay_out(label, text, sys.stderr), file=sys.stderr, flush=True)

    def result(self, label: str, text: str = "") -> None:
        """One line of a result, on standard output, also where the console is quiet; beside JSON, as any other line."""
        if self.json:
            self.line(label, text)
        elif sys.stdout is not None:
            print(self._lay_out(label, text, sys.stdout), flush=True)

    def give(self, document: Mapping[str, Any], lines: Iterable[str] = ()) -> None:
        """The result of a command on standard output: the document where JSON is asked for, else the lines."""
        if self.json:
            self.json(document)
        elif text := "\n".join(lines):
            say(text)

    def _lay_out(self, label: str, text: str, stream: TextIO) -> str:
        """A label in its column, then the text: on a terminal in lines of words, each below the text."""
        said, width = visible(f"{label:<{LABEL_WIDTH - 1}} {text}".rstrip()), find_width(stream)
        return said if width is None else self._colour_label(wrap(said, width, LABEL_WIDTH), label)

    def _colour_label(self, line: str, label: str) -> str:
        if label not in COLOURS or self.rich.no_color or self.rich.is_dumb_terminal:
            return line
        return click.style(line[: len(label)], fg=COLOURS[label], bold=True) + line[len(label) :]

    @contextmanager
    def busy(self, label: str, text: str) -> Generator[None]:
        """On a terminal, a line that moves while something without steps goes on; it is gone afterwards."""
        if self.quiet or self.of or not sys.stderr.isatty():
            yield
            return
        with self.rich.status(f"{label:<{LABEL_WIDTH - 2}}{text}"):
            yield

    @contextmanager
    def following(self, label: str) -> Generator[Callable[[int, int, str], None]]:
        """A stage whose live line appears once something is told of it: how much is done, of at most, and words. Where
        something else is counted from now on, its rate and time left are of that alone.
        """
        with ExitStack() as stack:
            lines: list[LiveLine] = []
            counted = (0, 0, "")

            def listener(done: int, most: int, words: str) -> None:
                nonlocal counted
                before, counted = counted, (done, most, NUMBERS.sub("", words))
                if not lines:
                    lines.append(stack.enter_context(self.live(label, most)))
                elif done < before[0] or (most != before[1] and counted[2] != before[2]):
                    lines[0].begin_again(done)
                lines[0].total = most
                lines[0].update(done, words)

            yield listener

    @contextmanager
    def live(self, label: str, total: int, begun: int = 0) -> Generator["LiveLine"]:
        """A stage with a live line. `begun`: how much was done before it began."""
        if self.quiet or self.of or not self.draws:
            yield LiveLine(self, label, total, begun)
            return
        from rich.progress import MofNCompleteColumn, Progress, TextColumn
        from rich.table import Column

        fixed = Column(no_wrap=True)
        columns = (
            TextColumn(f"{label:<{LABEL_WIDTH - 1}}", table_column=fixed),
            MofNCompleteColumn(table_column=fixed),
            TextColumn("{task.fields[left]}", table_column=fixed),
            TextColumn("{task.description}", table_column=Column(no_wrap=True, overflow="ellipsis", ratio=1)),
        )
        with Progress(*columns, console=self.rich, expand=True, transient=True, redirect_stdout=False) as progress:
            yield LiveLine(self, label, total, begun, progress)


@contextmanager
def telling(
    progress: "bool | OnStage", doing: str, once: str, listening: Callable[[Any], AbstractContextManager[Any]]
) -> Generator[None]:
    """Tells `progress` of the searches within as one stage, at its end of one `once`: they may be too short to say how
    far they are. `listening`: within it a listener hears of them.
    """
    with Console.showing(progress).following(doing) as listener, listening(listener):
        yield
        listener(1, 1, once)


current: Console | None = None  # that of the command that runs, for those who cannot be handed one


class LiveLine:
    """Done/total, what the stage says of itself, rate and time left."""

    def __init__(
        self, console: Console, label: str, total: int, begun: int = 0, progress: "Progress | None" = None
    ) -> None:
        self.console, self.label, self.total, self.begun, self.progress = console, label, total, begun, progress
        self.task = progress.add_task("", total=total, completed=begun, left="") if progress else None
        self.started = self.printed = time.monotonic()
        self.said = False
        self._whole: list[tuple[int, float]] = []  # steps that were done, and when

    def begin_again(self, done: int) -> None:
        """Counts something else from now on, of which so much is done."""
        self.begun, self.started, self._whole = done, time.monotonic(), []

    @property
    def elapsed(self) -> float:
        """Seconds since the stage began."""
        return max(time.monotonic() - self.started, 1e-9)

    def update(self, done: float, text: str, left: float | None = None) -> None:
        """Shows that `done` of the total are done. `left`: seconds, where steps are too unlike for the mean to tell."""
        whole = math.floor(done)
        if whole > (self._whole[-1][0] if self._whole else self.begun):
            self._whole.append((whole, time.monotonic()))
        self.show(done, text, self.ahead(done) if left is None else left)

    def ahead(self, done: float) -> float | None:
        """Seconds left, by the later half of the whole steps where these are enough, since steps may grow. Shares of a
        step tell only while there is no whole one: they need not be shares of its time.
        """
        if not self._whole:
            rate = (done - self.begun) / self.elapsed
            return max(self.total - done, 0) / rate if rate > 0 else None
        last, at = self._whole[-1]
        half = bisect_left(self._whole, (self.begun + last) / 2, key=lambda mark: mark[0])
        first, since = self._whole[half] if half + ENOUGH < len(self._whole) else (self.begun, self.started)
        pace = (at - since) / (last - first)
        return max((self.total - last) * pace - (time.monotonic() - at), (self.total - last - 1) * pace, 0)

    def show(self, done: float, text: str, left: float | None) -> None:
        """Draws the line, or prints it if the last one is old enough."""
        if self.console.on_stage is not None:
            self.console.on_stage(self.label, done, self.total, text)
        now, rate = time.monotonic(), (done - self.begun) / self.elapsed
        ahead = "" if left is None else f"{duration(left)} left"
        if self.progress is not None and self.task is not None:
            # the rate first: on a narrow terminal the end of the line is cut
            shown = f"{format_rate(rate)}  {text}"
            self.progress.update(self.task, completed=done, total=self.total, description=shown, left=ahead)
        elif (
            now - self.printed >= (PLAIN_SECONDS if self.said else min(FIRST_SECONDS, PLAIN_SECONDS))
            or done >= self.total
        ):
            self.printed, self.said = now, True
            self.console.line(self.label, f"{_count(done)}/{self.total}  {text}  {format_rate(rate)}  {ahead}")


def _count(done: float) -> str:
    """Steps that are done; of one under way its share, to a tenth that is done."""
    return str(done) if isinstance(done, int) else f"{math.floor(done * 10) / 10:.1f}"
