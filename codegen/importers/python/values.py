"""What an expression of Python may be, beside Python's own numbers, texts, lists, dictionaries and members of Enums.

Does: names the kinds of values that the reader adds, with what each needs to know.
Assumes: what depends on no feature stands for itself.
Does not: compute with them.
"""

import ast
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

from codegen.errors import InputError
from codegen.importers.symbolic.feature import Step


class Refused(InputError):
    """Something cannot be read. Whoever evaluates the node says where it is; `hard`: no line is skipped for it."""

    def __init__(self, what: str, advice: str, *, hard: bool = False) -> None:
        super().__init__(what, "", advice)
        self.hard = hard


@dataclass(frozen=True)
class Unread:
    """What a name stands for that comes from elsewhere, or from a line that is not read. Looking it up is an error."""

    what: str
    advice: str
    line: int = 0  # 0: the error is where the name is looked up


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


@dataclass(frozen=True)
class Extreme:
    """The least or the largest of several features and numbers."""

    least: bool
    parts: tuple[Any, ...]


class Array(list[Any]):
    """A row of an array of NumPy: it is looked up in, gone through and returned, and nothing else."""


class Stream(list[Any]):
    """What an iterator gives. It is used where it is made: by a loop, or as the argument of what takes it apart."""


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
    kind: str = ""  # "", "staticmethod", "classmethod" or "property"
    local: frozenset[str] = frozenset()  # names that it assigns


@dataclass(eq=False)
class Class:
    """A class of the file that is no Enum."""

    name: str
    members: dict[str, Any]
    fields: tuple[str, ...] = ()  # of a dataclass or named tuple, in their order
    made: bool = True  # whether objects of it can be made; not of a TypedDict, which only annotates


@dataclass(eq=False)
class Instance:
    """An object of a class of the file."""

    kind: Class
    attributes: dict[str, Any] = field(default_factory=dict[str, Any])


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


WORDS = {
    "Part": "the observation", "Extreme": "the least or the largest of several features",
    "NoneType": "None", "str": "a text", "dict": "a dictionary", "Instance": "an object", "Stream": "an iterator",
    "Array": "an array", "Feature": "a feature", "Test": "a condition", "Condition": "a condition",
}  # fmt: skip


def words_of(value: Any) -> str:
    """What kind of value it is, in words."""
    return WORDS.get(type(value).__name__, f"a {type(value).__name__.lower()}")
