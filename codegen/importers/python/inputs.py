"""The numbers of the observation that a function reads, and what the source calls them.

Does: gives each path of keys (`x[0]`, `x["speed"]`, `x.car.gap`, a parameter) a place; says at the end which features
  there are, in which order.
Assumes: the paths that were read by following the whole function.
Does not: know which of them decide anything.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import TypeAlias

from codegen.errors import escape_text
from codegen.importers.python.values import Part, Refused
from codegen.importers.reading import MAX_FEATURES
from codegen.importers.symbolic.program import Described

ONE = "give each feature one name or place"
Path: TypeAlias = tuple[int | str, ...]  # of keys, from a parameter on


@dataclass
class Inputs:
    """What a function reads. Paths begin with a parameter."""

    where: str
    parameters: tuple[str, ...]
    width: int = 0  # of a sole parameter, as the user says
    places: dict[Path, int] = field(default_factory=dict[Path, int])
    widths: dict[Path, int] = field(default_factory=dict[Path, int])
    # of a container's numbers or fields
    names: dict[Path, tuple[str, ...]] = field(default_factory=dict[Path, tuple[str, ...]])
    inner: dict[Path, type] = field(default_factory=dict[Path, type])

    def number(self, path: Path) -> int:
        """The place of a path that is used as a number."""
        if path in self.inner:
            raise Refused(f"{text_of(path)} is used as a number and as a list of numbers", ONE)
        return self.places.setdefault(path, len(self.places))

    def length(self, path: Path) -> int:
        """How many numbers a container has; 0: nobody says."""
        return self.widths.get(path, self.width if len(path) == 1 == len(self.parameters) else 0)

    def count_names(self, path: Path, names: Sequence[str]) -> None:
        """Takes the number of names for that of features, and the names for theirs if there is one for each."""
        known = self.length(path)
        if known and known != len(names):
            raise Refused(f"{len(names)} names for {known} features", "give each feature a name: a, b = x")
        self.widths[path] = len(names)
        features = tuple(f"x{place}" if name == "_" else name for place, name in enumerate(names))
        if all(names) and len(set(features)) == len(features):
            self.names.setdefault(path, features)

    def enter(self, part: Part, key: int | str) -> Part:
        """What stands at a key."""
        path = part.path
        if path in self.places:
            raise Refused(f"{text_of(path)} is used as a number and as a list of numbers", ONE)
        if self.inner.setdefault(path, type(key)) is not type(key):
            what = f"{text_of(path)} is read by numbers and by names"
            raise Refused(what, "use one of both everywhere")
        if isinstance(key, int):
            n = self.length(path)
            if key < 0 and not n:
                named = text_of((*path, key))
                what = f"{named} counts from the end, and the file does not say how many features there are"
                raise Refused(what, "count from the front, or name all features: --features a,b,c")
            place = key + n if key < 0 else key
            if not 0 <= place < (n or MAX_FEATURES):
                raise Refused(f"{text_of((*path, key))} is beyond the observation", f"it has {n} numbers")
            key = place
        return Part((*path, key), part.steps)

    def describe_inputs(self, plain: Described) -> Described:
        """The description with the features and their order."""
        used = {path[0] for path in self.places}
        if len(self.parameters) > 1 and all(len(path) == 1 for path in self.places) and not self.inner:
            places = [self.parameters.index(str(path[0])) for path in self.places]
            return replace(plain, places=places, features=self.parameters, n_features=len(self.parameters), n_read=0)
        root = self.parameters[:1] if len(self.parameters) == 1 else tuple(used)[:1]
        if len(used) <= 1:
            return self._alone(root, plain)
        names = [_join_path(path) for path in self.places]
        return replace(plain, places=range(len(names)), features=names, n_read=0, keyed=True)

    def _alone(self, root: Path, plain: Described) -> Described:
        """One parameter holds everything."""
        if root in self.places:
            return replace(plain, places=[0], features=[str(root[0])], n_features=1, n_read=0)
        n, names = self.length(root), self.names.get(root, ())
        if self.inner.get(root, int) is int and all(len(path) == 2 for path in self.places):
            places = [int(path[1]) for path in self.places]
            last = max(*places, plain.n_read - 1, -1) + 1
            return replace(plain, places=places, features=names, n_features=n, n_read=last)
        known = {name: place for place, name in enumerate(names)}
        order = sorted(self.places, key=lambda path: known.get(str(path[1]), len(known)))
        joined = [_join_path(path[1:]) for path in order]
        features = [*names] if names and all(len(path) == 2 for path in order) else joined
        features = [*features, *(each for each in joined if each not in features)]
        places = [features.index(_join_path(path[1:])) for path in self.places]
        return replace(plain, places=places, features=features, n_read=0, keyed=True)


def _join_path(path: Path) -> str:
    return ".".join(map(str, path))


def text_of(path: Path) -> str:
    """A path as Python."""
    return escape_text(str(path[0])) + "".join(f"[{escape_text(repr(key))}]" for key in path[1:])
