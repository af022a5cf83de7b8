"""What the leaves of a program return, as labels of actions.

Does: orders labels, numbers ascending and texts as the source names them; takes the largest of scores.
Assumes: values of one kind: numbers, texts, or lists of numbers.
Does not: choose the names of actions (names.py).

Of a list of numbers, if the user says that it holds a score for each action, the largest counts, and the first of equal
ones, as numpy's argmax.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias, cast

from codegen.errors import InputError

Value: TypeAlias = int | float | str | tuple[int | float, ...]  # what is returned; a tuple: a list of numbers


@dataclass(frozen=True)
class Labels:
    """The labels of the actions, and the place of each value."""

    labels: tuple[Any, ...]
    places: Mapping[Value, int]
    called: Mapping[Any, str]  # what the source calls some of them

    def place(self, value: Value) -> int:
        """The place of a value, -1 for one that no leaf returns."""
        return self.places.get(value, -1)


def labels_of(
    values: Sequence[Value], order: Sequence[Value], called: Mapping[Value, str], where: str, *, scores: bool
) -> Labels:
    """The labels of a program's values. `order`: as the source names them; `called`: names for values; `scores`:
    whether the user says that lists are scores.

    InputError for values of several kinds, and for lists that are no scores, such as a motor's two speeds.
    """
    kinds = {tuple if isinstance(each, tuple) else str if isinstance(each, str) else float for each in values}
    if len(kinds) > 1:
        raise InputError("numbers, texts and lists are returned side by side", where, "return one kind of label")
    if kinds == {tuple} and not scores:
        length = len(cast(tuple[Any, ...], values[0]))
        what = f"a list of {length} number{'s' * (length > 1)} is returned, which may be an action of several numbers"
        advice = "say --scores if it holds a score for each action, or --outputs with a name for each number"
        raise InputError(what, where, advice)
    if kinds == {tuple}:
        return _scores([each for each in values if isinstance(each, tuple)], where)
    first = {value: place for place, value in reversed(list(enumerate(order)))}
    # numbers are of one kind here, which the annotation cannot say
    chosen: list[Any] = sorted(values, key=first.__getitem__) if kinds == {str} else sorted(values)  # pyright: ignore
    return Labels(tuple(chosen), {each: place for place, each in enumerate(chosen)}, called)


def _scores(lists: Sequence[tuple[Any, ...]], where: str) -> Labels:
    lengths = {len(each) for each in lists}
    if len(lengths) > 1 or min(lengths) <= 1:
        what = f"lists of {' and '.join(map(str, sorted(lengths)))} numbers are returned"
        raise InputError(what, where, "return one score for each of two or more actions, or a single number")
    return Labels(tuple(range(lengths.pop())), {each: each.index(max(each)) for each in lists}, {})
