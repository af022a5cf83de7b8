"""The origin of a tree that is a program: its tree, the sums that it tests, and what its leaves give.

Does: follows a program for its tree; orders labels, numbers ascending and texts as the source names them; takes the
  largest of scores, and of equal ones the first, as numpy's argmax.
Assumes: a front end that interprets its language, with `Growth` to ask where a feature decides.
Does not: know the language, choose the names of actions (names.py), or answer for the program: who asks it does.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any, TypeAlias, cast

import numpy as np

from codegen.errors import InputError
from codegen.floats import FLOAT32, FLOAT64
from codegen.importers.reading import SUMS, Facts, Origin
from codegen.importers.symbolic.affine import Affine, Bounds, Given, Sums, Terms
from codegen.importers.symbolic.paths import Growth, Run
from codegen.ir import CONSTANT, Bool, Floats, GrownTree, Sum
from codegen.sums import FLOAT32_STEPS, FLOAT64_SUMS

Value: TypeAlias = int | float | str | tuple[int | float, ...]  # what is returned; a tuple: a list of numbers


@dataclass(frozen=True, kw_only=True)
class Described(Facts):
    """The facts that a front end knows of a program once all its paths were followed."""

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
    origin = origin_of_tree(grown, list(growth.values), said, where, sums)
    if not growth.outside:
        return origin
    columns = np.array(said.places, dtype=np.int64)

    def takes(rows: Floats) -> Bool:
        return growth.is_inside([*rows[:, columns].T.astype(np.float64)])

    return replace(origin, takes=takes)


def origin_of_tree(
    grown: GrownTree, values: Sequence[Any], said: Described, where: str, sums: Sums | None = None
) -> Origin:
    """The origin of a tree, whose actions are places of `values`; who answers for it is not said yet."""
    vectors = _vectors_of(values, where, sums)
    bounds = _bounds([one.vector for one in vectors], where)
    labels, order = _labels_of(values, said, where) if not vectors else ((), list(range(len(vectors))))
    named = not vectors and not isinstance(values[0], tuple)
    # Python's max(0.0, nan) is 0.0
    nan = all(each.cut.value(np.nan) != each.cut.value(np.nan) for one in vectors for each in one.vector if each.cut)
    facts: dict[str, Any] = {each.name: getattr(said, each.name) for each in fields(Facts)}
    facts |= {"features": (*said.features,), "called": said.called if named else {}}
    facts["nan"] = said.nan and nan and not said.finite
    origin = Origin(**facts, grown=grown, labels=labels, bounds=bounds)
    tests = tuple(each.terms for each in sums.known) if sums else ()
    given = [[each.terms for each in one.vector] for one in vectors]
    return renumber(with_sums(origin, tests, given, sums.arithmetic if sums else ""), said.places, order)


def _vectors_of(values: Sequence[Any], where: str, sums: Sums | None) -> list[Given]:
    """Returns what is given, in forms, also where it is constant on a path; nothing where labels are returned."""
    if not any(isinstance(each, Given) for each in values):
        return []
    vectors = [each if isinstance(each, Given) else _build_given(each, where, sums) for each in values]
    lengths = {len(each.vector) for each in vectors}
    if len(lengths) > 1:
        what = f"lists of {' and '.join(map(str, sorted(lengths)))} numbers are returned"
        raise InputError(what, where, "return the same numbers on every path")
    if not all(each.signed for one in vectors for each in one.vector):
        what = "a negated sum is returned, whose zero has another sign than its terms"
        raise InputError(what, where, "turn the signs of its terms instead")
    return vectors


def _build_given(value: Any, where: str, sums: Sums | None) -> Given:
    """Constant numbers, where those of other paths depend on features."""
    parts = cast("tuple[Any, ...]", value) if isinstance(value, tuple) else (value,)
    if sums is None or any(isinstance(each, str | bool) for each in parts):
        what = "numbers that depend on features and labels are returned side by side"
        raise InputError(what, where, "return numbers on every path")
    return Given([sums.represent(each, lambda what, advice: InputError(what, where, advice)) for each in parts])


def _bounds(vectors: Sequence[Sequence[Affine]], where: str) -> tuple[Bounds, ...]:
    """Returns the bounds that cut each output; () where none do. InputError where one is cut in some branches only."""
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


def _labels_of(values: Sequence[Value], said: Described, where: str) -> tuple[tuple[Any, ...], list[int]]:
    """The labels of a program's values, and the place among them of each value.

    InputError for values of several kinds, and for lists that are no scores, such as a motor's two speeds.
    """
    kinds = {tuple if isinstance(each, tuple) else str if isinstance(each, str) else float for each in values}
    if len(kinds) > 1:
        raise InputError("numbers, texts and lists are returned side by side", where, "return one kind of label")
    if kinds == {tuple}:
        return _scores(cast("Sequence[tuple[Any, ...]]", values), said, where)
    first: Mapping[Value, int] = {each: at for at, each in reversed(list(enumerate([*said.order, *values])))}
    # numbers are of one kind here, which the annotation cannot say
    chosen: list[Any] = sorted(values, key=first.__getitem__) if kinds == {str} else sorted(values)  # pyright: ignore
    places = {each: place for place, each in enumerate(chosen)}
    return tuple(chosen), [places[each] for each in values]


def _scores(lists: Sequence[tuple[Any, ...]], said: Described, where: str) -> tuple[tuple[Any, ...], list[int]]:
    """The places of scores as labels, and that of the largest of each list."""
    if not said.scores:
        length = len(lists[0])
        what = f"a list of {length} number{'s' * (length > 1)} is returned, which may be an action of several numbers"
        advice = "say --scores if it holds a score for each action, or --outputs with a name for each number"
        raise InputError(what, where, advice)
    lengths = {len(each) for each in lists}
    if len(lengths) > 1 or min(lengths) <= 1:
        what = f"lists of {' and '.join(map(str, sorted(lengths)))} numbers are returned"
        raise InputError(what, where, "return one score for each of two or more actions, or a single number")
    return tuple(range(lengths.pop())), [each.index(max(each)) for each in lists]


# --- sums


def with_sums(
    origin: Origin,
    tests: Sequence[Terms],
    vectors: Sequence[Sequence[Terms]],
    arithmetic: str = "",
) -> Origin:
    """The origin with the sums that its tree tests, and what its leaves give; itself where there is none of both.

    `arithmetic`: default that of the origin's numbers.
    """
    named = [int(each) - SUMS for each in dict.fromkeys(origin.grown.feature[origin.grown.feature >= SUMS].tolist())]
    if not named and not vectors:
        return origin
    order = {SUMS + old: SUMS + new for new, old in enumerate(named)}
    feature = [order.get(each, each) for each in origin.grown.feature.tolist()]
    return replace(
        origin,
        grown=replace(origin.grown, feature=np.array(feature)),
        arithmetic=arithmetic or (FLOAT32_STEPS if origin.numbers == FLOAT32 else FLOAT64_SUMS),
        sums=tuple(Sum(tests[each]) for each in named),
        vectors=tuple(tuple(map(Sum, vector)) for vector in vectors),
    )


def renumber(origin: Origin, features: Sequence[int], actions: Sequence[int]) -> Origin:
    """The origin with other numbers for its features and actions. `features`, `actions`: the new number of each."""
    grown, columns, order = origin.grown, np.array([*features, -1], np.int32), np.array([*actions], np.int32)
    fixed = (grown.feature < 0) | (grown.feature >= SUMS)
    grown = replace(
        grown,
        feature=np.where(fixed, grown.feature, columns[np.where(fixed, -1, grown.feature)]),
        action=np.where(grown.action < 0, grown.action, order[grown.action]),
    )

    def place(each: Sum) -> Sum:
        return Sum(tuple((weight, CONSTANT if at == CONSTANT else int(columns[at])) for weight, at in each.terms))

    vectors = tuple(tuple(map(place, vector)) for vector in origin.vectors)
    return replace(origin, grown=grown, sums=tuple(map(place, origin.sums)), vectors=vectors)


def rounds(origin: Origin) -> bool:
    """Returns True if its answers depend on how sums are rounded. Of a difference of two features, the sign does not;
    nor does a feature that is given as it is.
    """
    zero = {0.0, math.nextafter(0.0, -math.inf), -float(np.finfo(np.float32).smallest_subnormal)}
    for place, each in enumerate(origin.sums):
        asked = origin.grown.threshold[origin.grown.feature == SUMS + place].tolist()
        if len(each.terms) > 2 or not _plain(each) or not {*asked} <= zero:
            return True
    given = [each for vector in origin.vectors for each in vector if any(place != CONSTANT for _, place in each.terms)]
    return any(len(each.terms) > 1 or not _plain(each) for each in given)


def _plain(each: Sum) -> bool:
    return all(abs(weight) == 1 and place != CONSTANT for weight, place in each.terms)
