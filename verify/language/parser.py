"""The grammar: tokens, and a tree of every text that states a formula, a condition or an expression.

Does: cuts a text into numbers, names, units and signs; levels of operators, parentheses, calls, units of numbers, lists
  of actions.
Assumes: ASCII; a name with a dash stands in single quotes, and one quote behind a name is part of it. What names and
  trees mean is read by verify.claims.written and verify.systems.parsing.
Does not: run anything that a text holds.

    text      = value                               lowest level first; `implies` and `**` group to the right
    value     = value "implies" value | value "or" value | value "and" value | "not" value
              | value ("<" | "<=" | ">" | ">=" | "==" | "!=") value        chains, as in 0 <= x < 1
              | value [ "not" ] "in" "[" name { "," name } "]"
              | value ("+" | "-") value | value ("*" | "/") value | ("-" | "+") value | value "**" value
              | number [ "[" unit "]" ] | name | "|" value "|" | "(" value ")"
              | name "(" value { "," value } [ "," ] ")"
"""

import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from enum import IntEnum
from typing import NamedTuple, TypeAlias

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


class Level(IntEnum):
    """The binding strength of an operator, from loose to tight."""

    IMPLIES, OR, AND, NOT, RELATION, SUM, PRODUCT, SIGN, POWER = range(1, 10)


RELATIONS = ("<=", ">=", "==", "!=", "<", ">")
ACTS, BARS = "acts", "|"
LEVELS = {
    "implies": Level.IMPLIES,
    "or": Level.OR,
    "and": Level.AND,
    **dict.fromkeys((*RELATIONS, "in", "not"), Level.RELATION),
    **dict.fromkeys("+-", Level.SUM),
    **dict.fromkeys("*/", Level.PRODUCT),
    "**": Level.POWER,
}
NO_VALUES = ("and", "or", "not", "in")
MAY_BEGIN = "a number, a name, a call, -, (, | or not may stand here"
MAY_FOLLOW = "an operator may stand here (+ - * / ** < <= > >= == != in and or implies), or the end"


class Limits(NamedTuple):
    """The maximum length of a text, and the maximum depth of its parentheses."""

    characters: int
    depth: int


class NumberNode(NamedTuple):
    """A number as it is written, and its unit."""

    token: Token
    unit: str | None = None


class NameNode(NamedTuple):
    """A name; what it means shows in what stands beside it."""

    token: Token


class CallNode(NamedTuple):
    """A function of arguments; `|x|` is one called `|`."""

    token: Token
    arguments: tuple["Node", ...]


class Prefixed(NamedTuple):
    """Signs, or `not`, before a value; `token` is the first of them."""

    token: Token
    signs: tuple[str, ...]
    value: "Node"


class Joined(NamedTuple):
    """Values of one level with the operators between them: the first, and each other with its operator."""

    token: Token
    level: Level
    first: "Node"
    rest: tuple[tuple[Token, "Node"], ...]


class Listed(NamedTuple):
    """`value in [a, b]`, or `not in`; `token` is that of the value."""

    token: Token
    value: "Node"
    denied: bool
    names: tuple[Token, ...]


Node: TypeAlias = NumberNode | NameNode | CallNode | Prefixed | Joined | Listed


def parse(source: Source, limits: Limits) -> Node:
    """The tree of a text. InputError that shows the first fault, and what may stand there."""
    try:
        return _Parser(source, limits).whole()
    except RecursionError:
        raise source.wrong("nested too deep", 0, "split the text") from None


class _Parser:
    def __init__(self, source: Source, limits: Limits) -> None:
        self._source, self._most = source, limits.depth
        self._tokens, self._next, self._depth = tokens(source, limits.characters), 0, 0

    # --- tokens

    @property
    def _here(self) -> Token:
        return self._tokens[self._next]

    @property
    def _after(self) -> str:
        """The text of the token after the next one."""
        return self._tokens[self._next + 1].text if self._here.kind != "end" else ""

    def _take(self) -> Token:
        token = self._here
        self._next += token.kind != "end"
        return token

    def _is(self, *texts: str) -> bool:
        return self._here.kind in ("name", "mark") and self._here.text in texts

    def _need(self, text: str, after: str) -> None:
        if not self._is(text):
            what = f"expected {text!r} {after}, not {self._here.text or 'the end'!r}"
            raise self._source.wrong(what, self._here.place, HINTS.get(self._here.text, f"{text} may stand here"))
        self._take()

    def _level(self) -> int:
        """Returns the binding strength of the operator that comes next; 0 for none."""
        if self._here.kind not in ("name", "mark") or (self._here.text == "not" and self._after != "in"):
            return 0
        return LEVELS.get(self._here.text, 0)

    # --- values; few calls per level, as Python's own stack is short

    def whole(self) -> Node:
        """The tree of the whole text."""
        self._deeper()
        tree = self._value(Level.IMPLIES)
        if self._here.kind != "end":
            what = f"cannot go on with {self._here.text!r}"
            raise self._source.wrong(what, self._here.place, HINTS.get(self._here.text, MAY_FOLLOW))
        return tree

    def _deeper(self) -> None:
        self._depth += 1
        if self._depth > self._most:
            what = f"nested deeper than {self._most} levels"
            raise self._source.wrong(what, self._here.place, "split the text")

    def _value(self, least: int) -> Node:
        """A value whose operators bind at least so tightly."""
        value = self._operand(least)
        while (level := self._level()) >= least:
            if self._is("in", "not"):
                denied = self._take().text == "not"
                if denied:
                    self._take()
                self._need("[", "after in")
                names = [self._take()]
                while self._is(","):
                    self._take()
                    names.append(self._take())
                self._need("]", "after the actions")
                value = Listed(value.token, value, denied, tuple(names))
                continue
            right = level in (Level.IMPLIES, Level.POWER)  # grouped from there
            rest: list[tuple[Token, Node]] = []
            while self._level() == level and not self._is("in", "not") and not (right and rest):
                sign = self._take()
                if right:
                    self._deeper()
                if level == Level.RELATION and self._is_action(rest[-1][1] if rest else value):
                    rest.append((sign, NameNode(self._take())))
                else:
                    rest.append((sign, self._value(min(level, Level.SIGN) if right else level + 1)))
                self._depth -= right
            value = Joined(value.token, Level(level), value, tuple(rest))
        return value

    def _is_action(self, left: Node) -> bool:
        """Returns True if an action is named next: beside `acts(agent)` any name is that of an action."""
        return (
            isinstance(left, CallNode) and left.token.text == ACTS and self._here.kind == "name" and self._after != "("
        )

    def _operand(self, least: int) -> Node:
        token = self._here
        if self._is("not") and least <= Level.NOT and self._after not in (",", ")"):
            return Prefixed(token, self._signs("not"), self._value(Level.RELATION))
        if self._is("+", "-"):
            return Prefixed(token, self._signs("+", "-"), self._value(Level.POWER))
        self._take()
        if token.text in ("(", BARS) and token.kind == "mark":
            self._deeper()
            operand = self._value(Level.IMPLIES if token.text == "(" else Level.SUM)
            self._need(*((")", "after the parenthesis") if token.text == "(" else (BARS, "after the absolute value")))
            self._depth -= 1
            operand = CallNode(token, (operand,)) if token.text == BARS else operand
        elif token.kind == "number":
            operand = NumberNode(token)
        elif token.kind == "name" and (token.text not in NO_VALUES or self._is(",", ")")):
            operand = NameNode(token)
        else:
            what = f"cannot begin with {token.text!r} here" if token.text else "the text ends too early"
            raise self._source.wrong(what, token.place, HINTS.get(token.text, MAY_BEGIN))
        if isinstance(operand, NameNode) and self._is("("):  # the arguments of a function; a comma may end them
            self._take()
            self._deeper()
            arguments: list[Node] = []
            while not (arguments and self._is(")")):
                arguments.append(self._value(Level.IMPLIES))
                if not self._is(","):
                    break
                self._take()
            self._depth -= 1
            self._need(")", f"after the arguments of {operand.token.text}")
            return CallNode(operand.token, tuple(arguments))
        return self._parse_unit(operand.token) if isinstance(operand, NumberNode) and self._is("[") else operand

    def _signs(self, *texts: str) -> tuple[str, ...]:
        signs: list[str] = []
        while self._is(*texts):
            signs.append(self._take().text)
        return tuple(signs)

    def _parse_unit(self, number: Token) -> Node:
        """A number with the unit behind it."""
        begins = self._take().place + 1
        while not self._is("]") and self._here.kind != "end":
            self._take()
        unit = self._source.text[begins : self._here.place].strip()
        self._need("]", "after the unit")
        while unit.startswith("(") and unit.endswith(")"):
            unit = unit[1:-1].strip()
        if not unit:
            raise self._source.wrong("a unit is missing", begins, "write it as in 0.1[m/s]")
        return NumberNode(number, unit)
