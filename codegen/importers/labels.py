"""The actions that returned values stand for: their order, and the place of a value among them.

Does: sorts numbers; keeps texts in the order in which the source names them; takes a list of numbers for scores.
Assumes: the values that the leaves of a program return.
Does not: make names (names.py).

Of a list of numbers, one score for each action, the largest counts, and the first of equal ones, as numpy's argmax.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from codegen.errors import InputError
from codegen.importers.rules import Value


@dataclass(frozen=True)
class Labels:
    """The labels of the actions, and the place of each value."""

    labels: tuple[Any, ...]
    places: Mapping[Value, int]

    def place(self, value: Value) -> int:
        """The place of a value, -1 for one that no leaf returns."""
        return self.places.get(value, -1)


def labels_of(values: Sequence[Value], order: Sequence[Value], called: Mapping[Value, str], where: str) -> Labels:
    """The labels of a program's values. `order`: as the source names them; `called`: names for values.

    InputError for values of several kinds, and for lists that are no scores.
    """
    kinds = {tuple if isinstance(each, tuple) else str if isinstance(each, str) else float for each in values}
    if len(kinds) > 1:
        raise InputError("numbers, texts and lists are returned side by side", where, "return one kind of label")
    if kinds == {tuple}:
        return _scores([each for each in values if isinstance(each, tuple)], where)
    first = {value: place for place, value in reversed(list(enumerate(order)))}
    # numbers are of one kind here, which the annotation cannot say
    chosen: list[Any] = sorted(values, key=first.__getitem__) if kinds == {str} else sorted(values)  # pyright: ignore
    return Labels(tuple(called.get(each, each) for each in chosen), {each: place for place, each in enumerate(chosen)})


def _scores(lists: Sequence[tuple[Any, ...]], where: str) -> Labels:
    lengths = {len(each) for each in lists}
    if len(lengths) > 1 or min(lengths) <= 1:
        what = f"lists of {' and '.join(map(str, sorted(lengths)))} numbers are returned"
        raise InputError(what, where, "return one score for each of two or more actions, or a single number")
    return Labels(tuple(range(lengths.pop())), {each: each.index(max(each)) for each in lists})
