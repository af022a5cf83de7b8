"""The origin of a tree that is a program: its tree, its labels, and its replay.

Does: follows a program for its tree, and again for each observation of the replay; replays trees that files hold as
  data by the program that walks them.
Assumes: a front end (`Reading`) that interprets its language, with `Paths` to ask where a feature decides.
Does not: know the language.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any, cast

import numpy as np

from codegen.errors import InputError
from codegen.floats import FLOAT64
from codegen.importers.reading import SUMS, Facts, Origin
from codegen.importers.summed import with_sums
from codegen.importers.symbolic.affine import Affine, Bounds, Given, Sums, sum_terms
from codegen.importers.symbolic.labels import Labels, Value, labels_of
from codegen.importers.symbolic.paths import Growth, Replay, Run
from codegen.ir import Bool, Floats, GrownTree


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
    given = _Values(values, said, where, sums)
    places = np.array([*said.places, -1], dtype=np.int32)  # the last one: no feature
    columns = np.array(said.places, dtype=np.int64)
    single = grown.feature < SUMS

    def act(rows: Floats) -> Any:
        replay = Replay(where, rows[:, columns], sums)
        with np.errstate(all="ignore"):
            replay.follow(run)
        return given.answers(replay.values, replay.columns, sums.numbers if sums else said.numbers)

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
        act=act,
        bounds=given.bounds,
    )
    tests = tuple(each.terms for each in sums.known) if sums else ()
    return with_sums(origin, tests, given.vectors, said.places, sums.arithmetic if sums else "")


class _Values:
    """What the paths of a program return: labels of actions, or vectors of forms."""

    def __init__(self, values: Sequence[Any], said: Described, where: str, sums: Sums | None) -> None:
        self._sums = sums
        if any(isinstance(each, Given) for each in values):
            values = [self._build_given(each, where) for each in values]
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

    def _build_given(self, value: Any, where: str = "") -> Given:
        """What a path gives; also of constant numbers, where others depend on features."""
        if isinstance(value, Given):
            return value
        parts = cast("tuple[Any, ...]", value) if isinstance(value, tuple) else (value,)
        if self._sums is None or any(isinstance(each, str | bool) for each in parts):
            what = "numbers that depend on features and labels are returned side by side"
            raise InputError(what, where, "return numbers on every path")
        sums = self._sums
        return Given([sums.represent(each, lambda what, advice: InputError(what, where, advice)) for each in parts])

    def answers(self, values: Sequence[Any], columns: Sequence[Floats], numbers: str) -> Any:
        """The places of labels, or the numbers given, for what each observation returned."""
        if not self.vectors:
            return np.array([self.labels.place(value) for value in values], dtype=np.int32)
        outputs = np.zeros((len(values), len(self.vectors[0])))
        rows_of = dict[Any, list[int]]()
        for place, each in enumerate(values):
            rows_of.setdefault(each, []).append(place)
        for each, rows in rows_of.items():
            vector = self._build_given(each)
            for output, form in enumerate(vector.vector):
                given = [column[rows] for column in columns] or [np.zeros(len(rows))]
                outputs[rows, output] = _cut(form, sum_terms(form.terms, given, numbers), numbers)
        return outputs


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


def _cut(form: Affine, values: Floats, numbers: str) -> Floats:
    """What the program's own minima and maxima make of values."""
    if form.cut is None:
        return values
    kind, cut = np.dtype(numbers).type, form.cut
    return np.array([float(cut.value(kind(value))) for value in values], np.float64)
