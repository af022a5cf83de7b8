"""All paths of a program, one after the other, as a tree.

Does: `holds` answers a test that a program asks, and comes back later for the other answer; tests that earlier ones
  decide are no split, so that every leaf can be reached.
Assumes: a program that does the same again where it gets the same answers.
Does not: evaluate anything of a program.

A program is followed from its start, or from the last state that it marked, with the answers given since. So a front
end is an ordinary interpreter: it forks by calling `holds`, and needs no copy of itself.
"""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from codegen.errors import InputError
from codegen.importers.reading import SUMS
from codegen.importers.symbolic.affine import Sums
from codegen.importers.symbolic.feature import LAST, Feature, Test, Turns, number, pieces, turns_of
from codegen.ir import MAX_DEPTH, NO_ACTION, NO_CHILD, NO_FEATURE, Bool, Floats, GrownTree

MAX_NODES = 1 << 19
MAX_STEPS = 5_000_000  # of following paths, which a program of many variables multiplies
MAX_COMPUTED = 256  # steps from an input to what is compared: each test of it searches through all of them
MAX_CHAIN = 4  # turns of a test that are asked one after the other; of more, the middle one first
MAX_CALLS = 40  # functions of the program within one another
OUTSIDE: Any = object()  # what a path gives that the program rules out by an assertion
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

    def __init__(self, where: str, numbers: str, sums: Sums | None = None) -> None:
        self.where, self.numbers, self.steps = where, numbers, 0
        self.rows, self.values = list[list[float]](), dict[Any, int]()
        self.known: _Known = {}  # how earlier answers narrow the observation
        self.outside = list[_Known]()  # what is known on paths that the program rules out
        self._sums = sums or Sums(numbers)
        self._turns, self._pieces = dict[str, Turns](), dict[str, list[tuple[int, int, bool]]]()
        self._open = [_Open(None, (), {}, NO_CHILD, 0)]
        self._answers, self._given = tuple[bool, ...](), list[bool]()  # to be given again; that were given
        self._parent, self._depth = NO_CHILD, 0
        self._mark: tuple[Any, _Known] = (None, {})
        self._other: _Known | None = None  # known where the last test has the other answer, which decides it

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

    @property
    def asked(self) -> bool:
        """True if a test was open since the last mark."""
        return bool(self._given)

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
        key, last, feature = test.key, LAST[numbers], test.feature.place
        turns = self._turns.get(key)
        if len(test.feature.steps) > MAX_COMPUTED:
            what = f"a number is compared that is computed in more than {MAX_COMPUTED} steps"
            raise self.make_error(what, "compare it with fewer steps of arithmetic in between")
        if turns is None:
            turns = self._turns[key] = turns_of(test, numbers)
        while True:
            low, high = self._within(feature, last)
            inner = [turn for turn in turns.turns if low <= turn.place < high]
            if not inner:
                holds = turns.first ^ (sum(turn.place < low for turn in turns.turns) % 2 == 1)
                self.nan &= high < last or turns.nan == holds
                return holds
            at = inner[-1] if len(inner) <= MAX_CHAIN else inner[len(inner) // 2]
            left = self._fork(feature, at.threshold)
            right = {**self.known, feature: (at.place + 1, high)}
            self.known = {**self.known, feature: (low, at.place)} if left else right
            if len(inner) == 1:
                self._other = right
                self.nan &= high < last or turns.nan != (turns.first ^ (turns.turns.index(at) % 2 == 1))

    def _fork(self, feature: int, threshold: float) -> bool:
        """One of the two answers to a test that is open."""
        if len(self._given) < len(self._answers):
            answer = self._answers[len(self._given)]
        else:
            if self._depth == MAX_DEPTH:
                raise self.make_error(f"the tree is deeper than {MAX_DEPTH} splits", "simplify it first")
            answer, parent = True, self._add_node([feature, threshold, NO_CHILD, NO_CHILD, NO_ACTION])
            self._open.append(
                _Open(self._mark[0], (*self._given, False), self._mark[1], ~parent, self._depth + 1)  # ~: its right
            )
            self._parent, self._depth = parent, self._depth + 1
        self._given.append(answer)
        return answer

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
        within = [(max(low, first), min(high, last)) for low, high, _ in self._pieces[feature.key]]
        ends = {end for low, high in within if low <= high for end in (low, high)}
        return min(feature.value(number(end, numbers)) for end in ends)

    def _within(self, feature: int, last: int) -> tuple[int, int]:
        return self.known.get(feature, (-last, last))

    def tree(self) -> GrownTree:
        """The tree, without splits whose sides decide alike, or of which one side is ruled out."""
        tree = without_alike(GrownTree(*np.array(self.rows, dtype=np.float64).T))
        if tree.feature[0] == NO_FEATURE and tree.action[0] == NO_ACTION:
            raise self.make_error("every observation is ruled out by an assertion", "mend the assertion")
        return tree

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
