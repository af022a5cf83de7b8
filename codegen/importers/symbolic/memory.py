"""What a program remembers between its decisions: whole numbers, read as inputs within a range that is found.

Does: has a program followed until no path leaves the ranges: what is set widens one by that, what is added to by more
  and more, and the program's own tests narrow it again; says what a path makes of each memory, and asks where that
  turns: it is kept, set, or a constant is added.
Assumes: the first inputs of the program are its memories.
Does not: know a language, or read what a memory begins with.
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from codegen.errors import InputError
from codegen.importers.reading import Remembered
from codegen.importers.symbolic.feature import Feature, Test
from codegen.importers.symbolic.paths import Growth
from codegen.ir import Update
from codegen.memory import MAX_VALUE

WIDER = (16, 256, 4_096, 1 << 16, MAX_VALUE)  # by how much a range grows that is added to
MAX_RUNS, MAX_MEMORIES, MAX_ASKED = 300, 16, 4_096
FINITE = "stop it at a constant, such as if (n < 100) n++, and set it to whole numbers only"
# functions that make it as it begins
RESETS = re.compile(r"(?:\w*_)?(?:init|reset|clear)(?:_\w*)?|(?:init|reset)[A-Z]\w*|\w*(?:Init|Reset)(?:[A-Z_]\w*)?")
MAX_MEMBERS = 63  # the last place of values that are listed


class RemembersError(RuntimeError):
    """The decision reads or sets what outlives it: what has that name in the source."""


@dataclass
class Memory:
    """One thing that is remembered. `widest`: what its type holds; `low` to `high`: its range so far."""

    name: str
    initial: int
    widest: tuple[int, int]

    def __post_init__(self) -> None:
        self.low = self.high = self.initial
        self.found = (self.initial, self.initial)  # values after the paths of this run
        self.rising = self.falling = False  # whether additions have made it leave its range
        self.steps = 0  # in WIDER

    def note(self, low: int, high: int, added: int = 0) -> None:
        """A path adds something to values from `low` to `high`."""
        self.rising |= added > 0 and high == self.high
        self.falling |= added < 0 and low == self.low
        self.found = min(self.found[0], low + added), max(self.found[1], high + added)


class Memories:
    """All of a program, in the order of its inputs."""

    def __init__(self, known: Sequence[Memory], where: str) -> None:
        self.known, self._where, self._runs = tuple(known), where, 0
        if len(known) > MAX_MEMORIES:
            what = f"{len(known)} numbers are remembered, of at most {MAX_MEMORIES}"
            raise InputError(what, where, "give some of them as features")

    def list_ranges(self) -> tuple[Remembered, ...]:
        """What is known of each now."""
        return tuple(Remembered(each.name, each.low, each.high, each.initial) for each in self.known)

    def explain_error(self, error: InputError) -> InputError:
        """The error, which may come of a range that has grown."""
        for each in [one for one in self.known if one.steps][:1]:
            what = f"{each.name} is counted without an end, or where it is used: {error.what}"
            return InputError(what, error.where, FINITE)
        return error

    def settle(self, paths: Growth, after: Sequence[Feature | int | None]) -> tuple[Update, ...]:
        """What a path makes of each: a number, a feature that is computed of itself, or None where nothing sets it."""
        updates = [self._settle_one(paths, place, value) for place, value in enumerate(after)]
        return tuple(each for each in updates if each is not None)

    def _settle_one(self, paths: Growth, place: int, value: Feature | int | None) -> Update | None:
        memory = self.known[place]
        added = 0 if value is None else None if isinstance(value, int) else _added(value)
        while True:
            low, high = paths.whole_ends(place)
            if added == 0:
                return None
            if added is not None:
                memory.note(low, high, added)
                return Update(memory.name, adds=True, value=added)
            if isinstance(value, int) or low == high:
                number = value if isinstance(value, int) else _whole(value, low, self._where)
                memory.note(number, number)
                return None if low == high == number else Update(memory.name, adds=False, value=number)
            # the last number up to which the computation sets a constant, or adds one
            if high - low > MAX_ASKED:
                what = f"{memory.name} is computed of itself, with {high - low:,} values"
                raise InputError(what, self._where, FINITE)
            told = [_whole(value, at, self._where) for at in range(low, high + 1)]
            alike = [[told[0] + k * more for k in range(len(told))] for more in (0, 1)]
            turns = (next((k for k, each in enumerate(told) if each != line[k]), len(told)) for line in alike)
            turn = low + max(turns) - 1
            if turn < high:
                paths.holds(Test(Feature(place), "<=", turn))
                continue
            first, second = (_whole(value, at, self._where) for at in (low, low + 1))
            value, added = (first, None) if first == second else (value, first - low)

    def widen(self) -> bool:
        """Makes ranges that paths have left wider, and those that are too wide narrower; False: all are as they were
        followed. InputError where one has no end, or too many runs change them.
        """
        self._runs, changed = self._runs + 1, False
        for each in self.known:
            low, high = min(each.low, each.found[0]), max(each.high, each.found[1])
            if (each.rising or each.falling) and (low, high) != (each.low, each.high):
                if low < each.widest[0] or high > each.widest[1] or each.steps == len(WIDER):
                    raise InputError(f"{each.name} is counted without an end", self._where, FINITE)
                more, each.steps = WIDER[each.steps], each.steps + 1
                low = max(each.widest[0], each.initial - more) if each.falling else low
                high = min(each.widest[1], each.initial + more) if each.rising else high
            changed |= (low, high) != (each.low, each.high)
            each.low, each.high = low, high
        if not changed:
            for each in self.known:
                changed |= each.found != (each.low, each.high)
                each.low, each.high = each.found
        for each in self.known:
            each.found, each.rising, each.falling = (each.initial, each.initial), False, False
        if changed and self._runs >= MAX_RUNS:
            raise InputError("what is remembered takes too many values", self._where, FINITE)
        return changed


def _added(value: Feature) -> int | None:
    """The whole number that steps add; None: they do something else."""
    total = 0
    for step in value.steps:
        if step.key.startswith("whole "):
            continue
        if step.form is None or step.form[0] not in ("+", "-") or step.form[1] != int(step.form[1]):
            return None
        total += int(step.form[1]) if step.form[0] == "+" else -int(step.form[1])
    return total


def _whole(value: Any, at: int, where: str) -> int:
    """What a feature computes of a whole number."""
    number = value.value(float(at))
    if number != int(number):
        raise InputError(f"what is remembered may be {number}", where, FINITE)
    return int(number)
