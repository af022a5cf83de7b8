"""What an expression of Python may be, beside Python's own numbers, texts, lists and dictionaries.

Does: names the kinds of values that the reader adds, with what each needs to know.
Assumes: lists, tuples, dictionaries, sets and constants stand for themselves.
Does not: compute with them.
"""

import ast
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

from codegen.errors import InputError, escape_text
from codegen.importers.symbolic.feature import Step


class Refused(InputError):
    """Something cannot be read. Whoever evaluates the node says where it is; `hard`: no line is skipped for it."""

    def __init__(self, what: str, advice: str, *, hard: bool = False) -> None:
        super().__init__(what, "", advice)
        self.hard = hard


@dataclass(frozen=True)
class Symbol:
    """A name that the file uses and does not define, such as an action of the caller's. It may be returned only."""

    name: str


@dataclass(frozen=True)
class Unread:
    """What a name of the file stands for after a line that is not read. Looking it up is an error."""

    what: str
    advice: str
    line: int


@dataclass(frozen=True)
class Part:
    """The observation, or what stands at a path of keys in it; `steps`: the conversions of each of its numbers."""

    path: tuple[int | str, ...]
    steps: tuple[Step, ...] = ()
    array: bool = False  # whether it was made an array of NumPy


@dataclass(frozen=True)
class Condition:
    """A truth value that is decided where it is needed: whether all (or any) of its parts hold, or whether not."""

    every: bool
    parts: tuple[Any, ...]
    wanted: bool = True
    plain: bool | None = None  # whether it is Python's own True or False, as of `not`; None: as its parts are


@dataclass(frozen=True)
class Extreme:
    """The least or the largest of several features and numbers."""

    least: bool
    parts: tuple[Any, ...]


class Array(list[Any]):
    """A row of an array of NumPy: it is looked up in, gone through and returned, and nothing else."""


@dataclass(frozen=True, eq=False)
class Stream:
    """An iterator, which is used where it is made: a loop, or the argument of a function that takes it apart."""

    items: Iterable[Any]


@dataclass
class Scope:
    """Names and what they stand for, in a function, a class or the file."""

    names: dict[str, Any]
    parent: "Scope | None" = None
    local: frozenset[str] = frozenset()  # names that the function assigns somewhere
    of_class: bool = False  # whose names its functions do not see

    def __iter__(self) -> "Iterator[Scope]":
        scope: Scope | None = self
        while scope is not None:
            yield scope
            scope = scope.parent

    @property
    def outer(self) -> "Scope":
        """What a function, a lambda or a comprehension that stands here sees."""
        return self.parent if self.of_class and self.parent else self


@dataclass(eq=False)
class Function:
    """A function or lambda of the file."""

    name: str
    node: ast.FunctionDef | ast.Lambda
    scope: Scope  # where it stands
    defaults: Mapping[str, Any]
    kind: str = ""  # "", "static", "class" or "property"
    local: frozenset[str] = frozenset()  # names that it assigns


@dataclass(eq=False)
class Class:
    """A class of the file. Only an Enum has a base that matters."""

    name: str
    members: dict[str, Any]
    enum: bool = False  # its members are constants
    mixed: type | None = None  # ... and compare as their values do, which are of this type
    fields: tuple[str, ...] = ()  # of a dataclass or named tuple, in their order
    typed: bool = False  # a TypedDict, which only annotates

    @property
    def constants(self) -> "list[Member]":
        """The members of an Enum, without second names."""
        return list(dict.fromkeys(each for each in self.members.values() if isinstance(each, Member)))


@dataclass(eq=False)
class Instance:
    """An object of a class of the file."""

    kind: Class
    attributes: dict[str, Any] = field(default_factory=dict[str, Any])


@dataclass(frozen=True, eq=False)
class Member:
    """A member of an Enum, equal to what Python says it is equal to."""

    kind: Class
    name: str
    value: Any

    def __eq__(self, other: object) -> bool:
        if self.kind.mixed is None:
            return self is other
        return bool(self.value == (other.value if isinstance(other, Member) and other.kind.mixed else other))

    def __hash__(self) -> int:
        return hash(self.name if self.kind.mixed is None else self.value)


@dataclass(frozen=True)
class Bound:
    """A function of Python's, or a method of an object: `call` takes machine, node, arguments, named ones."""

    name: str
    call: Callable[..., Any]


@dataclass(frozen=True)
class Factory:
    """The default of a field that is made anew for each object."""

    make: Any


@dataclass(frozen=True)
class Module:
    """A module that is known: math, numpy and so on."""

    name: str
    members: Mapping[str, Any]


AUTO = Symbol("auto()")  # a member of an Enum that has no value of its own


def words_of(value: Any) -> str:
    """What kind of value it is, in words."""
    if isinstance(value, Symbol):
        return f"the name {escape_text(value.name)!r}, which the file does not define,"
    words = {
        "Part": "the observation", "Extreme": "the least or the largest of several features",
        "NoneType": "None", "str": "a text", "dict": "a dictionary",
        "Instance": "an object", "Stream": "an iterator", "Array": "an array", "Feature": "a feature",
        "Test": "a condition", "Condition": "a condition", "Member": "a member of an Enum",
    }  # fmt: skip
    return words.get(type(value).__name__, f"a {type(value).__name__.lower()}")
