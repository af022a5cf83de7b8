"""Tapes: operations on intervals, written down once and computed for many boxes at a time.

Does: writes operations down, each once; computes those that wait for nothing more in one go, element by element.
Assumes: spans.py and functions.py bound what they are asked.
Does not: know flows.

A program computes what is written, operation by operation, so that bounds are the floats of a plain evaluation. Only
the order is another: all sums that can be computed, then all products, and so on. Few large arrays take the place of
many small ones, with which numpy takes as long.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from fractions import Fraction
from typing import NamedTuple

import numpy as np

from codegen.ir import Float64, Int64
from verify.checker.covers.rounding import Factor
from verify.checker.flows.functions import exponential, half_turns, root, waves
from verify.checker.flows.spans import Spans, add_ends, exact, inverse, multiply_ends, of_ends, square

AT_ONCE = 1 << 18  # results that are computed together: about what a processor keeps close


class Operation(NamedTuple):
    """An operation on the results at some places of a tape; `name`: of what is given; `number`: a factor or value."""

    does: str
    reads: tuple[int, ...] = ()
    name: str = ""
    number: Fraction = Fraction(0)


class Tape:
    """Operations. Each function gives the place of a result, the same one where it was asked before."""

    def __init__(self) -> None:
        self.operations: list[Operation] = []
        self._places: dict[Operation, int] = {}

    def write(self, does: str, *reads: int, name: str = "", number: Fraction = Fraction(0)) -> int:
        """Any operation."""
        operation = Operation(does, reads, name, number)
        if operation not in self._places:
            self._places[operation] = len(self.operations)
            self.operations.append(operation)
        return self._places[operation]

    def plus(self, one: int, other: int) -> int:
        """A sum."""
        return self.write("plus", one, other)

    def times(self, one: int, other: int) -> int:
        """A product."""
        return self.write("times", one, other)

    def scale(self, one: int, factor: Fraction) -> int:
        """A multiple by an exact number other than 0."""
        assert factor
        return one if factor == 1 else self.write("scale", one, number=factor)


class _TapeGroup(NamedTuple):
    """Operations of one kind whose results go from `first` to before `last`. `reads`: of each operand, [results]."""

    first: int
    last: int
    does: Callable[..., Float64]
    reads: Sequence[Int64]


class Program:
    """Computes the results at some places of a tape; None: exactly 0."""

    def __init__(self, tape: Tape, wanted: Sequence[int | None]) -> None:
        operations, self._groups = tape.operations, list[_TapeGroup]()
        first_ones: list[tuple[int, Operation]] = []
        slots: dict[int, int] = {}
        for (_, kind), places in sorted(_sort_by_level(operations, wanted).items()):
            of, first = [operations[place] for place in places], len(slots)
            columns = zip(*(each.reads for each in of), strict=True)
            reads = [np.array([slots[place] for place in column]) for column in columns]
            slots |= {place: first + number for number, place in enumerate(places)}  # what is read has its slot before
            if reads:
                self._groups.append(_TapeGroup(first, len(slots), _does(kind, of), reads))
            else:
                first_ones += enumerate(of, first)
        self._given = [(slot, each.name) for slot, each in first_ones if each.does == "given"]
        fixed = [(slot, _number(each)) for slot, each in first_ones if each.does != "given"]
        self._fixed = np.array([slot for slot, _ in fixed], dtype=np.int64)
        self._numbers = (
            np.concatenate([span.ends for _, span in fixed], axis=1)[:, :, None] if fixed else np.zeros((2, 0, 1))
        )
        self._size, self._count = len(slots), len(wanted)
        self._filled = np.array([row for row, place in enumerate(wanted) if place is not None], dtype=np.int64)
        self._wanted = np.array([slots[place] for place in wanted if place is not None], dtype=np.int64)

    def run(self, given: Mapping[str, Spans], count: int) -> Spans:
        """The results, [wanted, count], for `count` boxes. `given`: by name, [count]."""
        results, each = np.zeros((2, self._count, count)), max(AT_ONCE // max(self._size, 1), 1)
        ends = {name: given[name].ends for _, name in self._given}
        for begin in range(0, count, each):
            some = slice(begin, min(begin + each, count))
            computed = self._run_some({name: span[:, some] for name, span in ends.items()}, some.stop - begin)
            results[:, self._filled, some] = computed[:, self._wanted]
        return of_ends(results)

    def _run_some(self, given: Mapping[str, Float64], count: int) -> Float64:
        computed = np.empty((2, self._size, count))
        for slot, name in self._given:
            computed[:, slot] = given[name]
        computed[:, self._fixed] = self._numbers
        for group in self._groups:
            computed[:, group.first : group.last] = group.does(*(computed.take(at, axis=1) for at in group.reads))
        return computed


def _sort_by_level(operations: Sequence[Operation], wanted: Iterable[int | None]) -> dict[tuple[int, str], list[int]]:
    """The places that are needed, by level and kind: each level reads levels before it."""
    needed = {place for place in wanted if place is not None}
    for place in reversed(range(len(operations))):
        if place in needed:
            needed |= set(operations[place].reads)
    levels: dict[int, int] = {}
    kinds: dict[tuple[int, str], list[int]] = {}
    for place in sorted(needed):
        operation = operations[place]
        levels[place] = 1 + max((levels[each] for each in operation.reads), default=-1)
        kind = "waves" if operation.does in WAVES else operation.does
        kinds.setdefault((levels[place], kind), []).append(place)
    return kinds


def _number(operation: Operation) -> Spans:
    """Returns the value of an operation that is the same for all boxes."""
    return half_turns(1) if operation.does == "pi" else exact(operation.number, 1)


def _does(kind: str, operations: Sequence[Operation]) -> Callable[..., Float64]:
    """Returns the function that computes a group of operations."""
    if kind == "scale":
        return _scaling([each.number for each in operations])
    return _waving(operations) if kind == "waves" else FUNCTIONS[kind]


def _scaling(factors: Sequence[Fraction]) -> Callable[[Float64], Float64]:
    """Multiples, each by a factor of its own."""
    factor, positive = Factor(*factors), np.array([each > 0 for each in factors])[:, None]

    def scale(ends: Float64) -> Float64:
        turned = ends if positive.all() else np.where(positive, ends, -ends[::-1])
        return factor.times_down(turned.transpose(0, 2, 1)).transpose(0, 2, 1)

    return scale


def _waving(operations: Sequence[Operation]) -> Callable[[Float64], Float64]:
    """sin or cos of each; both are computed once for each result that is read."""
    _, first, of = np.unique([each.reads[0] for each in operations], return_index=True, return_inverse=True)
    which = np.array([WAVES.index(each.does) for each in operations])

    def wave(ends: Float64) -> Float64:
        return _choose(which, [each.ends[:, of] for each in waves(of_ends(ends[:, first]))])

    return wave


def _choose(which: Int64, of: Sequence[Float64]) -> Float64:
    return np.where(which[:, None] == 0, *of)


def _by_spans(function: Callable[[Spans], Spans]) -> Callable[[Float64], Float64]:
    return lambda ends: function(of_ends(ends)).ends


WAVES = ("sin", "cos")
FUNCTIONS: Mapping[str, Callable[..., Float64]] = {
    "plus": add_ends,
    "times": multiply_ends,
    "square": _by_spans(square),
    "inverse": _by_spans(inverse),
    "exp": _by_spans(exponential),
    "sqrt": _by_spans(root),
}
