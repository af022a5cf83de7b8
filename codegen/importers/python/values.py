"""What an expression of Python may be, beside Python's own numbers, texts, lists and dictionaries.

Does: names the kinds of values that the evaluator adds, with what each needs to know.
Assumes: lists, tuples, dictionaries, sets and constants stand for themselves.
Does not: compute with them.
"""

import ast
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

from codegen.importers.symbolic.feature import Step


@dataclass(frozen=True)
class Unread:
    """What cannot be said exactly. It is no error unless a decision needs it."""

    what: str
    advice: str
    line: int


@dataclass(frozen=True)
class Symbol:
    """A name that the file uses and does not define, such as an action of the caller's."""

    name: str


@dataclass(frozen=True)
class Part:
    """The observation, or what stands at a path of keys in it; `steps`: what was computed of each of its numbers."""

    path: tuple[int | str, ...]
    steps: tuple[Step, ...] = ()
    offset: int = 0  # of a slice
    array: bool = False  # whether it is an array of NumPy, whose arithmetic is element by element
    scaled: bool = False  # whether arithmetic was done on it as a whole


@dataclass(frozen=True)
class Length:
    """How many numbers a part of the observation has, which the file may not say."""

    part: Part


@dataclass(frozen=True)
class Condition:
    """A truth value that is decided where it is needed."""

    ask: Callable[[], bool]


@dataclass(frozen=True)
class Extreme:
    """The least or the largest of several features and numbers."""

    least: bool
    parts: tuple[Any, ...]


class Array(list[Any]):
    """A constant array of NumPy: a list whose arithmetic is element by element."""


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
    """A class of the file."""

    name: str
    bases: tuple["Class", ...]
    members: dict[str, Any]
    enum: bool = False  # its members are constants
    mixed: bool = False  # ... and compare as their values do
    fields: tuple[str, ...] = ()  # of a dataclass or named tuple, in their order
    kept: frozenset[str] = frozenset()  # attributes that methods assign, other than __init__

    @property
    def lineage(self) -> list["Class"]:
        """The class and all its bases."""
        return [self, *(each for base in self.bases for each in base.lineage)]

    def find(self, name: str) -> Any:
        """What a name stands for in the class or its bases; None: nothing."""
        return next((each.members[name] for each in self.lineage if name in each.members), None)


@dataclass(eq=False)
class Instance:
    """An object of a class of the file."""

    kind: Class
    attributes: dict[str, Any] = field(default_factory=dict[str, Any])


@dataclass(frozen=True)
class Member:
    """A member of an Enum."""

    kind: Class
    name: str
    value: Any


@dataclass(frozen=True)
class Bound:
    """A method of an object: `call` takes the machine, the node, arguments and named arguments."""

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
