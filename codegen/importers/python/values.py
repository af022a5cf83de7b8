"""What an expression of Python may be, beside Python's own numbers, texts, lists, dictionaries and members of Enums.

Does: names the kinds of values that the reader adds; gives each number of the observation that is read (`x[0]`,
  `x["speed"]`, `x.speed`, a parameter) a place, and says which features there are.
Assumes: what depends on no feature stands for itself.
Does not: compute with them, or know which features decide anything.
"""

import ast
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from inspect import Signature
from typing import Any

from codegen.errors import InputError, escape_text
from codegen.importers.reading import MAX_FEATURES
from codegen.importers.symbolic.feature import Step, Test
from codegen.importers.symbolic.paths import Described

MAX_ITEMS = 1 << 16  # of a list, a text or a dictionary
TEST_ADVICE = "compare one feature with a number; give a sum or a difference as a feature of its own"
STATED = "write what it computes with comparisons and numbers; importing.md lists what is read"
ONE = "give each feature one name or place: of one list or object, or as a parameter of its own"
WORDS = {
    "Part": "the observation", "Extreme": "the least or the largest of several features",
    "NoneType": "None", "str": "a text", "dict": "a dictionary", "Instance": "an object", "Stream": "an iterator",
    "EnumType": "an Enum", "Array": "an array",
    "Feature": "a feature", "Test": "a condition", "Condition": "a condition",
}  # fmt: skip


class Refused(InputError):
    """Something cannot be read. Whoever evaluates the node says where it is."""

    def __init__(self, what: str, advice: str, where: str = "") -> None:
        super().__init__(what, where, advice)


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


CONDITIONS = (Test, Condition)


@dataclass(frozen=True)
class Extreme:
    """The least or the largest of several features and numbers."""

    least: bool
    parts: tuple[Any, ...]


class Array(list[Any]):
    """A row of an array of NumPy: it is looked up in, gone through and returned, and nothing else."""


class Stream(list[Any]):
    """The items of an iterator. It is used where it is made: by a loop, or as the argument of what takes it apart."""


@dataclass
class Scope:
    """Names and what they stand for, in a function, a class or the file; what cannot be read, for its error."""

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
        """The scope that a function, a lambda or a comprehension that stands here sees."""
        return self.parent if self.of_class and self.parent else self


@dataclass(eq=False)
class Function:
    """A function or lambda of the file."""

    name: str
    node: ast.FunctionDef | ast.Lambda
    scope: Scope  # where it stands
    signature: Signature
    kind: str = ""  # "", "staticmethod", "classmethod" or "property"
    local: frozenset[str] = frozenset()  # names that it assigns


@dataclass(eq=False)
class Class:
    """A class of the file that is no Enum."""

    name: str
    members: dict[str, Any]
    fields: tuple[str, ...] = ()  # of a dataclass or named tuple, in their order


@dataclass(eq=False)
class Instance:
    """An object of a class of the file."""

    kind: Class
    attributes: dict[str, Any] = field(default_factory=dict[str, Any])


@dataclass(frozen=True)
class Bound:
    """A function of Python's, or a method of an object: `call` takes machine, arguments, named ones."""

    name: str
    call: Callable[..., Any]


FACTORY = "default_factory"  # the name of a default of a field that is made anew for each object


@dataclass(frozen=True)
class Module:
    """A module that is known: math, numpy and so on."""

    name: str
    members: Mapping[str, Any]


def words_of(value: Any) -> str:
    """Returns the kind of a value, in words."""
    return WORDS.get(type(value).__name__, f"a {type(value).__name__.lower()}")


# --- the observation


@dataclass
class Inputs:
    """The inputs that a function reads: one parameter that holds all numbers, or a parameter for each."""

    parameters: tuple[str, ...]
    width: int = 0  # how many numbers a sole parameter holds; 0: nobody says
    names: tuple[str, ...] = ()  # of all of them
    places: dict[tuple[int | str, ...], int] = field(default_factory=dict[tuple[int | str, ...], int])
    inner: type | None = None  # int or str: what the numbers of a sole parameter are looked up by
    n_read: int = 0  # numbers up to the last one that is looked at

    def number(self, part: Part) -> int:
        """The place of a part that is used as a number."""
        if len(part.path) == 1 and self.inner:
            raise Refused(f"{text_of_path(part.path)} is used as a number and as a list of numbers", ONE)
        return self.places.setdefault(part.path, len(self.places))

    def count_names(self, names: Sequence[str]) -> None:
        """Takes the number of names for that of features, and the names for theirs if there is one for each."""
        if self.width and self.width != len(names):
            raise Refused(f"{len(names)} names for {self.width} features", "give each feature a name: a, b = x")
        self.width = len(names)
        features = tuple(f"x{place}" if name == "_" else name for place, name in enumerate(names))
        if all(names) and len(set(features)) == len(features):
            self.names = self.names or features

    def enter(self, part: Part, key: int | str) -> Part:
        """The number that stands at a key."""
        path = (*part.path, key)
        if len(path) > 2 or len(self.parameters) > 1:
            raise Refused(f"{text_of_path(path)} is looked up within one of several things that are given", ONE)
        if part.path in self.places:
            raise Refused(f"{text_of_path(part.path)} is used as a number and as a list of numbers", ONE)
        self.inner = self.inner or type(key)
        if self.inner is not type(key):
            raise Refused(f"{text_of_path(part.path)} is read by numbers and by names", "use one of both everywhere")
        if isinstance(key, int):
            if key < 0 and not self.width:
                what = (
                    f"{text_of_path(path)} counts from the end, and the file does not say how many features there are"
                )
                raise Refused(what, "count from the front, or name all features: --features a,b,c")
            key = key + self.width if key < 0 else key
            if not 0 <= key < (self.width or MAX_FEATURES):
                raise Refused(f"{text_of_path(path)} is beyond the observation", f"it has {self.width} numbers")
            self.n_read = max(self.n_read, key + 1)
        return Part((*part.path, key), part.steps)

    def describe_inputs(self, plain: Described) -> Described:
        """The description with the features and their order."""
        several, last = len(self.parameters) > 1, [path[-1] for path in self.places]
        if several or self.parameters in self.places:
            places = [self.parameters.index(str(each)) for each in last]
            return replace(plain, places=places, features=self.parameters, n_features=len(self.parameters))
        if self.inner is not str:
            places = [int(each) for each in last]
            return replace(plain, places=places, features=self.names, n_features=self.width, n_read=self.n_read)
        features = list(dict.fromkeys([*self.names, *map(str, last)]))
        return replace(plain, places=[features.index(str(each)) for each in last], features=features, keyed=True)

    def shape_parameters(self, described: Described) -> dict[str, Any]:
        """Returns what each parameter is given: the place of a feature, "row" for all, places by name."""
        shapes: dict[str, Any] = {name: place for place, name in enumerate(self.parameters)}
        if len(shapes) == 1 and self.parameters not in self.places:
            keys = [path[1] for path in self.places]
            by_name = dict(zip(keys, described.places, strict=True))
            shapes = {self.parameters[0]: by_name if self.inner is str else "row"}
        return shapes


def text_of_path(path: Sequence[int | str]) -> str:
    """A path as Python."""
    return escape_text(str(path[0])) + "".join(f"[{escape_text(repr(key))}]" for key in path[1:])
