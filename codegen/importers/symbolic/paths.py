"""All paths of a program, one after the other, as a tree, and the origin of that: what it tests, and what leaves give.

Does: `holds` answers a test that a program asks, and comes back later for the other answer; tests that earlier ones
  decide are no split, so that every leaf can be reached. Orders labels, numbers ascending and texts as the source names
  them; takes the largest of scores, and of equal ones the first, as numpy's argmax.
Assumes: a program that does the same again where it gets the same answers.
Does not: evaluate anything of a program, know its language, choose the names of actions (names.py), or answer for it.

A program is followed from its start, or from the last state that it marked, with the answers given since. So a front
end is an ordinary interpreter: it forks by calling `holds`, and needs no copy of itself.
"""

import math
from bisect import bisect_left
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from itertools import takewhile
from operator import itemgetter
from typing import Any, NamedTuple, TypeAlias, cast

import numpy as np

from codegen.errors import InputError
from codegen.floats import FLOAT32, FLOAT64
from codegen.importers.reading import MEMORY, SUMS, Facts, Kept, Origin, Remembered
from codegen.importers.symbolic.feature import (
    LAST,
    Affine,
    Bounds,
    Feature,
    Given,
    Sums,
    Terms,
    Test,
    Turns,
    number,
    pieces,
    turns_of,
)
from codegen.importers.symbolic.feature import place as place_of
from codegen.ir import MAX_DEPTH, NO_ACTION, NO_CHILD, NO_FEATURE, Bool, Floats, GrownTree, Sum
from codegen.sums import FLOAT32_STEPS, FLOAT64_SUMS

MAX_NODES = 1 << 19
MAX_STEPS = 5_000_000  # of following paths, which a program of many variables multiplies
MAX_COMPUTED = 256  # steps from an input to what is compared: each test of it searches through all of them
MAX_CHAIN = 4  # turns of a test that are asked one after the other; of more, the middle one first
MAX_CALLS = 40  # functions of the program within one another
OUTSIDE: Any = object()  # what a path gives that the program rules out by an assertion
IN_SUM = (
    "what is remembered is compared with a feature, or stands in a sum",
    "compare it with numbers, or let it take at most 256 values",
)
STATE_ADVICE = "a decision may depend on the observation alone; give what is remembered as a feature"
MANY_PATHS = "return in each branch, and build tables outside the function"
Run: TypeAlias = "Callable[[Any, Any], Any]"  # growth, the state to go on from or None -> what is returned
_Known: TypeAlias = dict[int, tuple[int, int]]  # feature -> first and last place that may be


class _Open(NamedTuple):
    """A path that is still to be followed."""

    state: Any  # that was marked
    answers: tuple[bool, ...]  # since then
    known: _Known  # there
    parent: int  # the split that leads on to it
    depth: int


class Growth:
    """The tree of a program: `rows`, a node each, in preorder; a leaf's action is the place of its value."""

    line = 0  # of the source, as the front end says it
    nan: bool = True  # whether a NaN goes where the program sends it

    def __init__(
        self, where: str, numbers: str, sums: Sums | None = None, ranges: Sequence[tuple[int, int]] = ()
    ) -> None:
        """`ranges`: least and most of the first inputs, whole numbers."""
        self.where, self.numbers, self.steps = where, numbers, 0
        self.rows, self.values = list[list[float]](), dict[Any, int]()
        self.known: _Known = {}  # how earlier answers narrow the observation
        self.outside = list[_Known]()  # what is known on paths that the program rules out
        self._sums = sums or Sums(numbers)
        self._turns, self._pieces = dict[str, Turns](), dict[str, list[tuple[int, int, bool]]]()
        start = {k: (place_of(ends[0], numbers), place_of(ends[1], numbers)) for k, ends in enumerate(ranges)}
        self._open = [_Open(None, (), start, NO_CHILD, 0)]
        self._answers, self._given = tuple[bool, ...](), list[bool]()  # to be given again; that were given
        self._parent, self._depth = NO_CHILD, 0
        self._mark: tuple[Any, _Known] = (None, {})
        self._other: _Known | None = None  # known where the last test has the other answer, which decides it
        self._taken = dict[int, int]()  # sums of an input twice, taken to be no NaN, with the line of a test

    def follow(self, run: Run) -> None:
        """Follows all paths. InputError for too many."""
        while self._open:
            state, self._answers, self.known, self._parent, self._depth = self._open.pop()
            self._mark, self._given = (state, self.known), []
            value = run(self, state)
            if value is OUTSIDE:
                self.outside.append(self.known)
            action = NO_ACTION if value is OUTSIDE else self.values.setdefault(value, len(self.values))
            self._add_node([NO_FEATURE, 0.0, NO_CHILD, NO_CHILD, action])

    def mark(self, state: Any) -> None:
        """The program could go on from this state, which nothing changes any more."""
        if len(self._given) >= len(self._answers):
            self._mark, self._answers, self._given = (state, self.known), (), []

    def branch(self, state: Any) -> None:
        """The other answer to the last test goes on from this state, if it was the only one since the mark."""
        if self._other is not None and self._given == [True] and not self._answers:
            last = self._open.pop()
            self._open.append(_Open(state, (), self._other, last.parent, last.depth))

    def step(self, count: int = 1) -> None:
        """Counts the work. InputError beyond its limit."""
        self.steps += count
        if self.steps > MAX_STEPS:
            raise self.make_error("the program does not end, or has too many paths", MANY_PATHS)

    def make_error(self, what: str, advice: str) -> InputError:
        """Makes an error of what is wrong at the present line."""
        return InputError(what, f"{self.where}, line {self.line}" if self.line else self.where, advice)

    def holds(self, test: Test) -> bool:
        """Returns True if a test holds on this path; where both may be, first one and then the other. It splits as
        often as the test turns within what is known.
        """
        self._other, numbers = None, self._sums.numbers_of(test.feature, self.numbers)
        last, feature = LAST[numbers], test.feature.place
        if len(test.feature.steps) > MAX_COMPUTED:
            what = f"a number is compared that is computed in more than {MAX_COMPUTED} steps"
            raise self.make_error(what, "compare it with fewer steps of arithmetic in between")
        turns = self._find_turns(test, numbers) if test.feature.steps else turns_of(test, numbers)
        while True:
            low, high = self._within(feature, last)
            begin, end = (bisect_left(turns.turns, each) for each in ((low,), (high,)))  # of those within
            if begin == end:
                holds = turns.first ^ (begin % 2 == 1)
                if high == last and turns.nan != holds:
                    self.nan = False
                    self._taken |= {feature: self.line} if feature >= SUMS and self._sums.repeats(feature) else {}
                return holds
            which = end - 1 if end - begin <= MAX_CHAIN else (begin + end) // 2
            at = turns.turns[which]
            if len(self._given) < len(self._answers):  # one of the two answers to a test that is open
                answer = self._answers[len(self._given)]
            else:
                if self._depth == MAX_DEPTH:
                    raise self.make_error(f"the tree is deeper than {MAX_DEPTH} splits", "simplify it first")
                answer, parent = True, self._add_node([feature, at.threshold, NO_CHILD, NO_CHILD, NO_ACTION])
                self._open.append(
                    _Open(self._mark[0], (*self._given, False), self._mark[1], ~parent, self._depth + 1)  # ~: its right
                )
                self._parent, self._depth = parent, self._depth + 1
            self._given.append(answer)
            right = {**self.known, feature: (at.place + 1, high)}
            self.known = {**self.known, feature: (low, at.place)} if answer else right
            if end - begin == 1:
                self._other = right
                self.nan &= high < last or turns.nan != (turns.first ^ (which % 2 == 1))

    def _find_turns(self, test: Test, numbers: str) -> Turns:
        """The turns of a test of what is computed, which takes long to search for."""
        if test.key not in self._turns:
            self._turns[test.key] = turns_of(test, numbers)
        return self._turns[test.key]

    def _add_node(self, row: list[float]) -> int:
        if len(self.rows) == MAX_NODES:
            raise self.make_error(f"the tree has more than {MAX_NODES} nodes", "simplify its conditions")
        if self.rows:
            right = self._parent < 0
            self.rows[~self._parent if right else self._parent][3 if right else 2] = len(self.rows)
        self.rows.append(row)
        return len(self.rows) - 1

    def least(self, feature: Feature) -> Any:
        """The least at the ends of the stretches on which the feature only rises or falls."""
        numbers = self._sums.numbers_of(feature, self.numbers)
        first, last = self._within(feature.place, LAST[numbers])
        if feature.key not in self._pieces:
            self._pieces[feature.key] = pieces(feature, numbers)
        known = self._pieces[feature.key]  # ascending
        within = takewhile(lambda each: each[0] <= last, known[bisect_left(known, first, key=itemgetter(1)) :])
        ends = {end for low, high, _ in within for end in (max(low, first), min(high, last))}
        return min(feature.value(number(end, numbers)) for end in ends)

    def whole_ends(self, feature: int) -> tuple[int, int]:
        """The least and most whole number that an input is on this path, which has a range."""
        low, high = (number(at, self.numbers) for at in self.known[feature])
        return math.ceil(low), math.floor(high)

    def _within(self, feature: int, last: int) -> tuple[int, int]:
        return self.known.get(feature, (-last, last))

    def tree(self) -> GrownTree:
        """The tree, without splits whose sides decide alike, or of which one side is ruled out."""
        tree = without_alike(GrownTree(*np.array(self.rows, dtype=np.float64).T))
        if tree.feature[0] == NO_FEATURE and tree.action[0] == NO_ACTION:
            raise self.make_error("every observation is ruled out by an assertion", "mend the assertion")
        return tree

    def ensure_tested(self, tree: GrownTree) -> None:
        """InputError for a sum that is taken to be no NaN, as that of one infinite input is, and that no test shows."""
        for line in [line for place, line in self._taken.items() if not (tree.feature == place).any()][:1]:
            self.line = line
            raise self.make_error("a sum is tested, and the answer is the same but for NaN", "leave the test out")

    def is_inside(self, columns: Sequence[Floats]) -> Bool:
        """Returns which observations the program does not rule out. `columns`: of its inputs; those with NaN count as
        outside, if it rules out any.
        """
        inside = np.ones(len(columns[0]) if columns else 0, dtype=np.bool_)
        for column in columns if self.outside else ():
            inside &= ~np.isnan(column)
        for known in self.outside:
            within = np.ones(len(inside), dtype=np.bool_)
            for feature, (low, high) in known.items():
                numbers = self._sums.numbers if feature >= SUMS else self.numbers
                given = self._sums.column(feature, columns) if feature >= SUMS else columns[feature]
                within &= (number(low, numbers) <= given) & (given <= number(high, numbers))
            inside &= ~within
        return inside


def ask_whole(low: int, high: int, is_at_most: Callable[[int], bool]) -> int:
    """The whole number from `low` to `high` that a path holds, which is asked by halves."""
    while low < high:
        middle = (low + high) // 2
        low, high = (low, middle) if is_at_most(middle) else (middle + 1, high)
    return low


# --- smaller trees


def without(tree: GrownTree, skip: dict[int, int]) -> GrownTree:
    """The tree without splits that all observations pass on one side; `skip`: node -> that side."""

    def follow_skips(node: int) -> int:
        while node in skip:
            node = skip[node]
        return node

    order, open_ = list[int](), [follow_skips(0)]
    while open_:
        node = open_.pop()
        order.append(node)
        if tree.feature[node] != NO_FEATURE:
            open_ += [follow_skips(int(tree.right[node])), follow_skips(int(tree.left[node]))]
    place = {node: index for index, node in enumerate(order)} | {NO_CHILD: NO_CHILD}
    left, right = ([place[follow_skips(int(side[node]))] for node in order] for side in (tree.left, tree.right))
    return GrownTree(tree.feature[order], tree.threshold[order], np.array(left), np.array(right), tree.action[order])


def without_alike(tree: GrownTree) -> GrownTree:
    """The tree without splits whose sides decide alike, or of which one side is ruled out: NO_ACTION leaves."""
    skip, kinds = dict[int, int](), dict[Any, int]()  # what decides, and its number
    kind = [NO_ACTION] * len(tree.feature)
    for node in range(len(kind) - 1, -1, -1):  # preorder: children come after their parents
        feature, action, left, right = (int(each[node]) for each in (tree.feature, tree.action, tree.left, tree.right))
        sides = kind[left], kind[right]
        if feature == NO_FEATURE:
            kind[node] = action if action == NO_ACTION else kinds.setdefault(action, len(kinds))
        elif sides[0] == sides[1] or NO_ACTION in sides:
            skip[node] = right if sides[0] == NO_ACTION else left
            kind[node] = kind[skip[node]]
        else:
            kind[node] = kinds.setdefault((feature, float(tree.threshold[node]), sides), len(kinds))
    return without(tree, skip)


# --- origins


Value: TypeAlias = int | float | str | tuple[int | float, ...]  # what is returned; a tuple: a list of numbers


@dataclass(frozen=True, kw_only=True)
class Described(Facts):
    """The facts that a front end knows of a program once all its paths were followed."""

    places: Sequence[int] = ()  # the place among the features of each input that tests name
    order: Sequence[Value] = ()  # texts as the source names them
    scores: bool = False  # whether the user says that lists are scores


def origin_of(
    run: Run,
    where: str,
    describe: Callable[[], Described],
    numbers: str = FLOAT64,
    sums: Sums | None = None,
    memory: Sequence[Remembered] = (),
) -> Origin:
    """The origin of a program that compares `numbers`. `describe` is asked after the program was followed; `memory`:
    what it remembers, the first inputs.

    InputError for everything that the front end refuses, and for values of several kinds.
    """
    growth = Growth(where, numbers, sums, [(each.low, each.high) for each in memory])
    with np.errstate(all="ignore"):
        growth.follow(run)
    grown = growth.tree()
    said = describe()
    if not said.whole:
        growth.ensure_tested(grown)
    places = [*range(MEMORY, MEMORY + len(memory)), *said.places]
    nan = growth.nan and not growth.outside
    said = replace(said, places=places, memory=tuple(memory), numbers=numbers, nan=nan)
    origin = origin_of_tree(grown, list(growth.values), said, where, sums)
    if not growth.outside:
        return origin
    columns = np.array(said.places, dtype=np.int64)
    columns[columns >= MEMORY] -= MEMORY + len(memory)  # which stand last

    def takes(rows: Floats) -> Bool:
        return growth.is_inside([*rows[:, columns].T.astype(np.float64)])

    return replace(origin, takes=takes)


def origin_of_tree(
    grown: GrownTree, values: Sequence[Any], said: Described, where: str, sums: Sums | None = None
) -> Origin:
    """The origin of a tree, whose actions are places of `values`; who answers for it is not said yet."""
    if any(isinstance(each, Kept) for each in values):
        # an action of the tree of a program that remembers is a label with what becomes of memory
        distinct: list[Any] = list(dict.fromkeys(each.label for each in values))
        if any(isinstance(each, Given) for each in distinct):
            what = "numbers that depend on features are given, and something is remembered"
            advice = "have the decision return its mode, and compute the number from that outside; or give what is "
            raise InputError(what, where, f"{advice}remembered as a feature")
        if any(place < len(said.memory) for form in (sums.known if sums else ()) for place in form.places):
            what, advice = IN_SUM
            raise InputError(what, where, advice)
        plain = origin_of_tree(replace(grown, action=grown.action * 0), distinct, said, where, sums)
        _, order = _labels_of(distinct, said, where)
        pairs = tuple((order[distinct.index(each.label)], each.updates) for each in values)
        return replace(plain, grown=replace(plain.grown, action=grown.action), pairs=pairs)
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
        known = {(None, None) if each.cut is None else each.cut.bounds for each in forms if each.cut or each.places}
        low, high = known.pop() if known else (None, None)
        fixed = [each.terms[0][0] for each in forms if not each.places and each.cut is None]
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
        lists = cast("Sequence[tuple[Any, ...]]", values)
        if not said.scores:
            n, s = len(lists[0]), "s" * (len(lists[0]) > 1)
            what = f"a list of {n} number{s} is returned, which may be an action of several numbers"
            advice = "say --scores if it holds a score for each action, or --outputs with a name for each number"
            raise InputError(what, where, advice)
        lengths = {len(each) for each in lists}
        if len(lengths) > 1 or min(lengths) <= 1:
            what = f"lists of {' and '.join(map(str, sorted(lengths)))} numbers are returned"
            raise InputError(what, where, "return one score for each of two or more actions, or a single number")
        return tuple(range(lengths.pop())), [each.index(max(each)) for each in lists]
    first: Mapping[Value, int] = {each: at for at, each in reversed(list(enumerate([*said.order, *values])))}
    # numbers are of one kind here, which the annotation cannot say
    chosen: list[Any] = sorted(values, key=first.__getitem__) if kinds == {str} else sorted(values)  # pyright: ignore
    places = {each: place for place, each in enumerate(chosen)}
    return tuple(chosen), [places[each] for each in values]


# --- sums of an origin


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
    fixed = (grown.feature < 0) | (grown.feature >= MEMORY)
    grown = replace(
        grown,
        feature=np.where(fixed, grown.feature, columns[np.where(fixed, -1, grown.feature)]),
        action=np.where(grown.action < 0, grown.action, order[grown.action]),
    )

    def place(each: Sum) -> Sum:
        return Sum(tuple((weight, place(at) if isinstance(at, Sum) else int(columns[at])) for weight, at in each.terms))

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
    given = [each for vector in origin.vectors for each in vector if each.places]
    return any(len(each.terms) > 1 or not _plain(each) for each in given)


def _plain(each: Sum) -> bool:
    return all(abs(weight) == 1 and place in each.places for weight, place in each.terms)
