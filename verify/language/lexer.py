"""The words of the language: numbers, names and marks, each with its place, and errors that show the text.

Does: cuts a text into tokens; marks the column of a fault; knows what to write instead of what other languages write.
  Between tokens stand spaces, tabs and ends of lines; every other control character is refused.
Assumes: ASCII; a name with a dash stands in single quotes. One quote behind a name is part of it.
Does not: know what names mean.
"""

import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import NamedTuple

from codegen.errors import InputError, UnknownNameError, escape_text

BLANKS = " \t\n"
HINTS = {
    "=>": "write implies",
    "=": "write == for equality",
    "&": "write and",
    "!": "write not, or != for inequality",
    ">": "write >= or implies",
    "^": "write ** for powers",
    '"': "write names without quotes, or 'in-these' where a name has a dash",
    "{": "write a list of actions as [left, stay]",
}
PRIME = "'"  # behind a name: the next value of a variable
NEXT = "only formulas about a system in steps name the next value of a number: claim episodes, by stays_in or avoids"
AROUND = 60  # characters shown on either side of a fault
_TOKEN = re.compile(
    r"""[ \t\n]*(?:(?P<number>0[xXoObB][0-9a-fA-F_]+|(?:\d[\d_]*(?:\.[\d_]*)?|\.\d[\d_]*)(?:[eE][+-]?\d[\d_]*)?)
        |(?P<name>'[ -&(-~]{1,64}'(?:\.[A-Za-z_][A-Za-z0-9_]*)?|[A-Za-z_][A-Za-z0-9_]*(?:\.[A-Za-z_][A-Za-z0-9_]*)?'?)
        |(?P<mark>\*\*|<=|>=|==|!=|[-+*/()\[\],|<>^%]))""",
    re.VERBOSE | re.ASCII,
)


class Token(NamedTuple):
    """A piece of the text, and where it begins."""

    kind: str  # number, name, mark or end
    text: str
    place: int


@dataclass(frozen=True)
class Source:
    """A text that somebody wrote, and words for an offset in it."""

    text: str
    where: Callable[[int], str]

    def wrong(self, what: str, place: int, advice: str = "") -> InputError:
        """An error that shows the text, with a mark under the column of an offset."""
        return InputError(what, self._show_place(place), advice)

    def unknown(self, kind: str, token: Token, known: Iterable[str]) -> InputError:
        """An error about a name that does not exist, likewise."""
        if token.text.endswith(PRIME):
            return self.wrong(f"{token.text} is no next value that is known here", token.place, NEXT)
        return UnknownNameError(kind, token.text, known, self._show_place(token.place))

    def _show_place(self, place: int) -> str:
        start, end = self.text.rfind("\n", 0, place) + 1, self.text.find("\n", place)
        first, last = max(start, place - AROUND), min(end if end >= 0 else len(self.text), place + AROUND)
        before = ("..." if first > start else "") + escape_text(self.text[first:place])
        # what reads like a line of a report is not shown as one
        edge = "| " if re.match(r"\s*(\d+\.|[A-Z]{3})", self.text[first:last]) else ""
        line, mark = f"{edge}{before}{escape_text(self.text[place:last])}", f"{edge}{' ' * len(before)}^"
        return f"{self.where(place)}\n  {line}\n  {mark}"


def tokens(source: Source, most: int) -> list[Token]:
    """The tokens of a text of at most `most` characters, with one of kind "end" after them. InputError with the place
    of what cannot be read.
    """
    text = source.text
    if len(text) > most:
        raise source.wrong(f"a text may have at most {most} characters", 0, "split it")
    read, place, end = list[Token](), 0, len(text.rstrip(BLANKS))
    while place < end:
        match = _TOKEN.match(text, place)
        if match is None:
            start = place + len(text[place:]) - len(text[place:].lstrip(BLANKS))
            sign = text[start]
            advice = HINTS.get(text[start : start + 2], HINTS.get(sign, "see `maviper guide claims`"))
            raise source.wrong(f"cannot read {sign!r}", start, advice)
        kind = match.lastgroup or ""
        quoted = match[kind].startswith("'")
        read.append(Token(kind, match[kind].replace("'", "") if quoted else match[kind], match.start(kind)))
        place = match.end()
    return [*read, Token("end", "", end)]
