"""The numbers of the observation that a function reads, and what the source calls them.

Does: gives each number that is read (`x[0]`, `x["speed"]`, `x.speed`, a parameter) a place; says at the end which
  features there are, in which order, and what Python's own function is to be given of them.
Assumes: the numbers that were read by following the whole function.
Does not: know which of them decide anything, or read a list within a list.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from codegen.errors import escape_text
from codegen.importers.python.values import Part, Refused
from codegen.importers.reading import MAX_FEATURES
from codegen.importers.symbolic.program import Described

ONE = "give each feature one name or place: of one list or object, or as a parameter of its own"


@dataclass
class Inputs:
    """What a function reads: one parameter that holds all numbers, or a parameter for each."""

    parameters: tuple[str, ...]
    width: int = 0  # how many numbers a sole parameter holds; 0: nobody says
    names: tuple[str, ...] = ()  # of all of them
    places: dict[tuple[int | str, ...], int] = field(default_factory=dict[tuple[int | str, ...], int])
    inner: type | None = None  # int or str: what the numbers of a sole parameter are looked up by
    n_read: int = 0  # numbers up to the last one that is looked at

    def number(self, part: Part) -> int:
        """The place of a part that is used as a number."""
        if len(part.path) == 1 and self.inner:
            raise Refused(f"{text_of(part.path)} is used as a number and as a list of numbers", ONE)
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
            raise Refused(f"{text_of(path)} is looked up within one of several things that are given", ONE)
        if part.path in self.places:
            raise Refused(f"{text_of(part.path)} is used as a number and as a list of numbers", ONE)
        self.inner = self.inner or type(key)
        if self.inner is not type(key):
            raise Refused(f"{text_of(part.path)} is read by numbers and by names", "use one of both everywhere")
        if isinstance(key, int):
            if key < 0 and not self.width:
                what = f"{text_of(path)} counts from the end, and the file does not say how many features there are"
                raise Refused(what, "count from the front, or name all features: --features a,b,c")
            key = key + self.width if key < 0 else key
            if not 0 <= key < (self.width or MAX_FEATURES):
                raise Refused(f"{text_of(path)} is beyond the observation", f"it has {self.width} numbers")
            self.n_read = max(self.n_read, key + 1)
        return Part((*part.path, key), part.steps)

    def describe_inputs(self, plain: Described) -> Described:
        """The description with the features and their order."""
        if len(self.parameters) > 1:
            places = [self.parameters.index(str(path[0])) for path in self.places]
            return replace(plain, places=places, features=self.parameters, n_features=len(self.parameters))
        if self.parameters in self.places:
            return replace(plain, places=[0], features=self.parameters, n_features=1)
        if self.inner is not str:
            places = [int(path[1]) for path in self.places]
            return replace(plain, places=places, features=self.names, n_features=self.width, n_read=self.n_read)
        features = list(dict.fromkeys([*self.names, *(str(path[1]) for path in self.places)]))
        places = [features.index(str(path[1])) for path in self.places]
        return replace(plain, places=places, features=features, keyed=True)

    def shape_parameters(self, described: Described) -> dict[str, Any]:
        """What each parameter is given: the place of a feature, "row" for all, places by name."""
        if len(self.parameters) != 1:
            return {name: place for place, name in enumerate(self.parameters)}
        if self.inner is str:
            shape: Any = {path[1]: place for path, place in zip(self.places, described.places, strict=True)}
        else:
            shape = 0 if self.parameters in self.places else "row"
        return {self.parameters[0]: shape}


def text_of(path: Sequence[int | str]) -> str:
    """A path as Python."""
    return escape_text(str(path[0])) + "".join(f"[{escape_text(repr(key))}]" for key in path[1:])
