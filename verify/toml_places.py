"""TOML texts as plain data, and the line on which each of their values stands.

Does: parses, decimals as the texts that they are; words for a place, with its line, where an error asks for them.
Assumes: a place is asked for once, by an error: finding its line parses the text several times.
Does not: know what a file is about. tomllib tells no lines, and tomlkit, which keeps them, moves a table that stands
  behind others of its kind.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from codegen.errors import InputError, escape_text

MAX_READS = 300  # of one text, for one line
BEGINS = re.compile(r"\s*(\[.*\]\s*(#.*)?$|[^\s\[#].*=)")  # lines with which a statement may begin; some rows of lists
Key = str | int  # of a table, or from 0 of a list


@dataclass(frozen=True)
class Place:
    """A value of a TOML file, by the keys that lead to it. As a text: the file, the line and the keys."""

    name: str  # of the file
    source: str
    keys: tuple[Key, ...] = ()
    within: str = ""  # further words

    def __truediv__(self, key: Key) -> Place:
        """The place of a value of this table or list."""
        return Place(self.name, self.source, (*self.keys, key))

    def saying(self, words: str) -> Place:
        """The place with further words."""
        return Place(self.name, self.source, self.keys, words)

    @property
    def words(self) -> str:
        """The keys in words, lists counted from 1: `property 2, region.where 1`."""
        words = ""
        for before, key in zip(("", *self.keys), self.keys, strict=False):
            joint = ", " if isinstance(before, int) else "." if words else ""
            shown = key if isinstance(key, int) or key.isprintable() else escape_text(key)
            words += f" {key + 1}" if isinstance(key, int) else f"{joint}{shown}"
        return words

    def of_offset(self, text: str, offset: int) -> str:
        """Words for an offset in a text that stands here."""
        before = text[:offset]
        column = offset - (before.rfind("\n") + 1) + 1
        return self._describe_place(before.count("\n") if "\n" in text else 0, text, f", column {column}")

    def __str__(self) -> str:
        return self._describe_place(0, "", f", {self.within}" if self.within else "")

    def _describe_place(self, down: int, text: str, more: str) -> str:
        span = _span(self.source, self.keys)
        line = ""
        if span is not None:
            begins = "\n".join(_lines(self.source)[span[0] : span[1]]).partition(text)[0] if "\n" in text else ""
            line = f", line {span[0] + 1 + begins.count(chr(10)) + down}"
        return f"{self.name}{line}: {self.words}{more}".removesuffix(": ")


def parse(source: str, name: str, what: str, advice: str) -> tuple[dict[str, Any], Place]:
    """The document of a TOML text and its place. InputError, saying `what`, for a text that is none."""
    try:
        return _parse_source(source), Place(name, source)
    except (ValueError, RecursionError) as error:
        raise InputError(what, f"{name}: {error}"[:200], advice) from None


def _parse_source(source: str) -> dict[str, Any]:
    return tomllib.loads(source, parse_float=str)


def _lines(source: str) -> list[str]:
    return source.replace("\r\n", "\n").split("\n")


def _span(source: str, keys: tuple[Key, ...]) -> tuple[int, int] | None:
    """The lines that state a value, from 0, up to the next statement. None for a text that has nothing of it, or in
    which they are not found soon.
    """
    lines = _lines(source)
    counts = sorted({0, *(count for count, line in enumerate(lines) if BEGINS.match(line)), len(lines)})
    whole = _parse_source(source)
    while keys and not _holds(whole, keys):
        keys = keys[:-1]
    if not keys:
        return None
    reads = 0

    def says(count: int) -> bool | None:
        """Returns True if the first lines state the value; None where they break off within a statement."""
        nonlocal reads
        reads += 1
        try:
            return _holds(_parse_source("\n".join(lines[:count]) + "\n"), keys)
        except ValueError:
            return None

    low, high = 0, len(counts) - 1  # the value is stated between
    while high - low > 1 and reads < MAX_READS:
        middle = (low + high) // 2
        steps = (*range(middle, high), *range(middle - 1, low, -1))
        told = ((step, said) for step in steps if reads < MAX_READS and (said := says(counts[step])) is not None)
        step, said = next(told, (0, None))
        if said is None:
            break
        low, high = (low, step) if said else (step, high)
    return (counts[low], counts[high]) if reads < MAX_READS else None


def _holds(document: Mapping[str, Any], keys: tuple[Key, ...]) -> bool:
    """Returns True if keys lead to a value. A key with a dot may be written as two."""
    at: Any = document
    for key in keys:
        try:
            at = at[key]
        except (LookupError, TypeError):
            first, _, second = str(key).partition(".")
            try:
                at = at[first][second]
            except (LookupError, TypeError):
                return False
    return True
