"""How a source of Python is called: what each of its parameters is given of an observation.

Does: turns paths of keys (`x[0]`, `x["speed"]`, `x.car.gap`, a parameter) into shapes that the process fills.
Assumes: paths as a reader hands them over, each with the place of its number in an observation.
Does not: know how the reader came by them.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, TypeAlias

Path: TypeAlias = tuple[int | str, ...]  # of keys, from a parameter on
MAX_LIST = 1 << 12


@dataclass(frozen=True, kw_only=True)
class Called:
    """How a source is called, as the reader takes it. A shape is the place of a number in an observation, "row" for
    all of it, a list of shapes, shapes by name, or None for what decides nothing.
    """

    source: str  # its bytes, each as the character of that number
    where: str
    entry: str  # a name of the file
    method: str = ""  # of the entry; "": the entry itself
    made: bool = True  # whether a class is called for an object first
    given: Sequence[Any] = ()  # the shapes of what is given by place
    named: Mapping[str, Any] = field(default_factory=dict[str, Any])  # ... and by name
    forms: Sequence[str] = ("floats",)  # "floats", "float64", "float32"
    scores: bool = False  # whether a list that is returned holds a score for each action


def shape_parameters(parameters: Sequence[str], paths: Mapping[Path, int]) -> dict[str, Any]:
    """What each parameter is given. `paths`: what the source reads, and its place in an observation."""
    every = all(len(path) == 1 for path in paths)
    if len(parameters) > 1 and every:
        return {name: paths.get((name,), place) for place, name in enumerate(parameters)}
    return {name: _shape_path((name,), paths, alone=len(parameters) == 1) for name in parameters}


def _shape_path(path: Path, paths: Mapping[Path, int], *, alone: bool) -> Any:
    if path in paths:
        return paths[path]
    below = {each[len(path)]: None for each in paths if each[: len(path)] == path}
    indices = [key for key in below if isinstance(key, int)]
    if alone and len(indices) == len(below) and all(len(each) == 2 for each in paths):
        return "row"
    inner = {key: _shape_path((*path, key), paths, alone=False) for key in below}
    if indices:
        return [inner.get(place) for place in range(min(max(indices) + 1, MAX_LIST))]
    return inner or None
