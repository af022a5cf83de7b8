"""The words of the claims that users write: numbers, names and marks, each with its place.

Does: cuts a text into tokens; knows what to write instead of what other languages write.
Assumes: ASCII; a name with a dash stands in single quotes.
Does not: know what names mean (parser.py).
"""

import re
from collections.abc import Callable
from typing import NamedTuple, TypeAlias

from codegen.errors import InputError

Where: TypeAlias = Callable[[int], str]  # an offset in the text -> words for an error
MAX_CHARACTERS = 10_000
HINTS = {
    "=>": "write implies",
    "=": "write == for equality",
    "&": "write and",
    "!": "write not, or != for inequality",
    ">": "write >= or implies",
    "^": "only linear arithmetic can be decided: write a * a number",
    "**": "only linear arithmetic can be decided: write a * a number",
    '"': "write names without quotes, or 'in-these' where a name has a dash",
    "{": "write a list of actions as [left, stay]",
}
_TOKEN = re.compile(
    r"""\s*(?:(?P<number>(?:\d[\d_]*\.?\d*|\.\d+)(?:[eE][+-]?\d{1,3})?)
        |(?P<name>(?:'[^'\n]{1,64}'|[A-Za-z_][A-Za-z0-9_]*)(?:\.[A-Za-z_][A-Za-z0-9_]*)?)
        |(?P<mark>\*\*|<=|>=|==|!=|[-+*/()\[\],|<>]))""",
    re.VERBOSE | re.ASCII,
)


class Token(NamedTuple):
    """A piece of the text, and where it begins."""

    kind: str  # number, name, mark or end
    text: str
    place: int


def tokens(text: str, where: Where) -> list[Token]:
    """The tokens of a text, with one of kind "end" after them. InputError with the place of what cannot be read."""
    if len(text) > MAX_CHARACTERS:
        raise InputError(f"a formula may have at most {MAX_CHARACTERS} characters", where(0), "split it")
    found, place, end = list[Token](), 0, len(text.rstrip())
    while place < end:
        match = _TOKEN.match(text, place)
        if match is None:
            start = place + len(text[place:]) - len(text[place:].lstrip())
            sign = text[start]
            advice = HINTS.get(text[start : start + 2], HINTS.get(sign, "see `maviper properties new`"))
            raise InputError(f"cannot read {sign!r}", where(start), advice)
        kind = match.lastgroup or ""
        found.append(Token(kind, match[kind].replace("'", ""), match.start(kind)))
        place = match.end()
    return [*found, Token("end", "", end)]
