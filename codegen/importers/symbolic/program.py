"""The origin of a tree that is a program: its tree, and the labels or numbers that its leaves give.

Does: follows a program for its tree; orders labels, numbers ascending and texts as the source names them; takes the
  largest of scores, and of equal ones the first, as numpy's argmax.
Assumes: a front end that interprets its language, with `Paths` to ask where a feature decides.
Does not: know the language, or choose the names of actions (names.py).
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any, TypeAlias, cast

import numpy as np

from codegen.errors import InputError
from codegen.floats import FLOAT64
from codegen.importers.reading import SUMS, Facts, Origin
from codegen.importers.summed import with_sums
from codegen.importers.symbolic.affine import Affine, Bounds, Given, Sums
from codegen.importers.symbolic.paths import Growth, Run
from codegen.importers.symbolic.replay import replay_program
from codegen.ir import Bool, Floats, GrownTree

Value: TypeAlias = int | float | str | tuple[int | float, ...]  # what is returned; a tuple: a list of numbers


@dataclass(frozen=True, kw_only=True)
class Described(Facts):
    """What a front end knows of a program once all its paths were followed."""

    places: Sequence[int] = ()  # the place among the features of each input that tests name
    order: Sequence[Value] = ()  # texts as the source names them
    scores: bool = False  # whether the user says that lists are scores


def origin_of(
    run: Run, where: str, describe: Callable[[], Described], numbers: str = FLOAT64, sums: Sums | None = None
) -> Origin:
    """The origin of a program that compares `numbers`. `describe` is asked after the program was followed.

    InputError for everything that the front end refuses, and for values of several kinds.
    """
    growth = Growth(where, numbers, sums)
    with np.errstate(all="ignore"):
        growth.follow(run)
    grown = growth.tree()
    said = replace(describe(), numbers=numbers, nan=growth.nan and not growth.outside)
    origin = origin_of_tree(grown, list(growth.values), run, said, where, sums)
    if not growth.outside:
        return origin
    columns = np.array(said.places, dtype=np.int64)

    def takes(rows: Floats) -> Bool:
        return growth.is_inside([*rows[:, columns].T.astype(np.float64)])

    return replace(origin, takes=takes)


def origin_of_tree(
    grown: GrownTree, values: Sequence[Any], run: Run, said: Described, where: str, sums: Sums | None
) -> Origin:
    """The origin of a tree, whose actions are places of `values`, and of the program that replays it."""
    given = Values(values, said, where, sums)
    places = np.array([*said.places, -1], dtype=np.int32)  # the last one: no feature
    columns = np.array(said.places, dtype=np.int64)
    single, computed = grown.feature < SUMS, sums.numbers if sums else said.numbers

    said = replace(said, features=(*said.features,), nan=said.nan and given.nan, called=given.labels.called)
    facts: dict[str, Any] = {each.name: getattr(said, each.name) for each in fields(Facts)}
    origin = Origin(
        **facts,
        grown=replace(
            grown,
            feature=np.where(single, places[np.where(single, grown.feature, -1)], grown.feature),
            action=np.where(grown.action < 0, grown.action, given.place[grown.action]),
        ),
        labels=given.labels.labels,
        act=lambda rows: replay_program(run, where, rows[:, columns], sums, given, computed),
        bounds=given.bounds,
    )
    tests = tuple(each.terms for each in sums.known) if sums else ()
    return with_sums(origin, tests, given.vectors, said.places, sums.arithmetic if sums else "")


class Values:
    """What the paths of a program return: labels of actions, or vectors of forms."""

    def __init__(self, values: Sequence[Any], said: Described, where: str, sums: Sums | None) -> None:
        self._sums = sums
        if any(isinstance(each, Given) for each in values):
            values = [self.build_given(each, where) for each in values]
        vectors = [each for each in values if isinstance(each, Given)]
        lengths = {len(each.vector) for each in vectors}
        if len(lengths) > 1:
            what = f"lists of {' and '.join(map(str, sorted(lengths)))} numbers are returned"
            raise InputError(what, where, "return the same numbers on every path")
        for each in (one for vector in vectors for one in vector.vector):
            if not each.signed:
                what = "a negated sum is returned, whose zero has another sign than its terms"
                raise InputError(what, where, "turn the signs of its terms instead")
        self.vectors = tuple(tuple(each.terms for each in one.vector) for one in vectors)
        self.bounds = _bounds([one.vector for one in vectors], where)
        cuts = [each.cut for one in vectors for each in one.vector if each.cut]
        self.nan = all(cut.value(np.nan) != cut.value(np.nan) for cut in cuts)  # Python's max(0.0, nan) is 0.0
        self.labels = Labels((), {}, {})
        if vectors:
            self.place = np.arange(len(vectors), dtype=np.int32)
            return
        self.labels = labels_of(values, [*said.order, *values], said.called, where, scores=said.scores)
        self.place = np.array([self.labels.place(value) for value in values], dtype=np.int32)

    def build_given(self, value: Any, where: str = "") -> Given:
        """What a path gives; also of constant numbers, where others depend on features."""
        if isinstance(value, Given):
            return value
        parts = cast("tuple[Any, ...]", value) if isinstance(value, tuple) else (value,)
        if self._sums is None or any(isinstance(each, str | bool) for each in parts):
            what = "numbers that depend on features and labels are returned side by side"
            raise InputError(what, where, "return numbers on every path")
        sums = self._sums
        return Given([sums.represent(each, lambda what, advice: InputError(what, where, advice)) for each in parts])


def _bounds(vectors: Sequence[Sequence[Affine]], where: str) -> tuple[Bounds, ...]:
    """What each output is cut to; () where nothing is. InputError where one is cut in some branches only."""
    bounds: list[Bounds] = []
    for forms in zip(*vectors, strict=True):
        known = {(None, None) if each.cut is None else each.cut.bounds for each in forms if each.cut or not each.alone}
        low, high = known.pop() if known else (None, None)
        fixed = [each.terms[0][0] for each in forms if each.alone and each.cut is None]
        if known or any((low is not None and each < low) or (high is not None and each > high) for each in fixed):
            what = "a number is cut to bounds on some paths, and elsewhere to others or to none"
            raise InputError(what, where, "cut it in the same way on every path, or test the sum: if u > 2: return 2")
        bounds.append((low, high))
    return tuple(bounds) if any(each != (None, None) for each in bounds) else ()


# --- labels


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
