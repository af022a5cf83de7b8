"""A stated system: variables, what features measure, and how the state moves, all in exact numbers; regions of states.

Does: the data of a system; half spaces, and whether a state lies in them; whether polytopes and boxes are empty, apart
  or complete.
Assumes: whoever makes one has checked names, units and shapes.
Does not: know trees or claims. It says nothing about how far the statement is from a simulator.

The state is a number for each variable. In one step, with the joint action a, a piece that holds the state gives

    next(x) = move[x](state) + the sum over agents i of effect[i, a_i][x](state) + e_x,   e_x anywhere in error[x],

for each variable x. A piece holds the states of its box that meet its further conditions `when`. Where several pieces
hold a state, each of them may be taken: on a shared border, and where a rule has a choice, which is a piece for each
value. Where none does, nothing is stated. A mode is a variable that has one of a finite set of values, whole numbers
from 0. An agent observes each of its features as the exact value of what it measures, rounded once to the nearest
number of those that it compares, float32 or float64, ties to even.

A system may have a flow instead of pieces: then the state moves in continuous time. At the start and after each period
the agents observe it, and their actions are held until the next of these samples.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from enum import Enum
from fractions import Fraction
from itertools import combinations, product
from math import inf
from types import MappingProxyType
from typing import cast

from codegen.errors import InputError
from verify.systems.expressions import Affine, Box, Expression, Interval, State

IN_STEPS = "state steps by [dynamics.next], or use `maviper verify --system`, `maviper check` and `worlds check`"


@dataclass(frozen=True)
class HalfSpace:
    """The states in which `form` is at most 0, or below 0 if `strict`."""

    form: Affine
    strict: bool = False

    def holds(self, state: State) -> bool:
        """Returns True if a state lies in the half space."""
        value = self.form.at(state)
        return value < 0 if self.strict else value <= 0


Polytope = tuple[HalfSpace, ...]  # the states that lie in all of them


class Measure(Enum):
    """The measure that a feature takes of an affine form; the values are the words of files."""

    VALUE = "value"
    SIGN = "sign"  # -1, 0 or 1
    POSITIVE = "positive"  # 1 where the form is above 0, else 0
    CLIP = "clip"  # to the bounds of the feature
    EQUALS = "equals"  # 1 where the form is 0, else 0


@dataclass(frozen=True)
class Feature:
    """The quantity that one feature of an agent measures. `bounds` are those of a clipped one."""

    form: Affine
    measure: Measure = Measure.VALUE
    bounds: Interval | None = None


@dataclass(frozen=True)
class Variable:
    """One number of the state: its unit, free text, and the range in which the statement is made.

    `modes`: the names of the values 0, 1, ... of a mode, whose range they fill; empty for a number.
    """

    name: str
    unit: str
    range: Interval
    modes: tuple[str, ...] = ()


@dataclass(frozen=True)
class Piece:
    """The motion of the state where it lies in a box and meets conditions. What is not named in `move` becomes 0, in
    `error` it is exact. `choice`: which value it takes of each choice of its rule, in the words of the file.
    """

    where: Box
    move: Mapping[str, Affine]
    effect: Mapping[tuple[str, str], Mapping[str, Affine]] = field(default_factory=lambda: MappingProxyType({}))
    error: Mapping[str, Interval] = field(default_factory=lambda: MappingProxyType({}))
    when: Polytope = ()
    choice: Mapping[str, str] = field(default_factory=lambda: MappingProxyType({}))

    def holds(self, state: State) -> bool:
        """Returns True if the piece says how a state moves."""
        inside = all(low <= state[name] <= high for name, (low, high) in self.where.items())
        return inside and all(half.holds(state) for half in self.when)

    def total(self, name: str, choices: Iterable[tuple[str, str]]) -> Affine:
        """The next value of a variable as one exact form, for the actions of some agents, without the error."""
        form = self.move.get(name, Affine())
        for choice in choices:
            added = self.effect.get(choice, {})
            form = form.plus(added[name]) if name in added else form
        return form

    def step(self, state: State, actions: Mapping[str, str], error: State) -> dict[str, Fraction]:
        """The next state, for a joint action by agents' names and an error of each variable that has one."""
        after = {name: form.at(state) + error.get(name, Fraction(0)) for name, form in self.move.items()}
        for choice in actions.items():
            for name, form in self.effect.get(choice, {}).items():
                after[name] += form.at(state)
        return after


@dataclass(frozen=True)
class Flow:
    """The motion of the state in continuous time: at each moment the derivative of variable x is `rates[x]`, over
    variables and inputs, plus an error anywhere in `error[x]`, which may change at any time. `held` are the inputs'
    values by (agent, action): between two samples, `period` seconds apart, they stay. At each sample, after actions
    were chosen, every x of `jumps` becomes `jumps[x]` of what was before.

    `jitter`: by how many seconds any one period may be longer, or shorter if below 0. `seen`: how late observations may
    be: at each sample each agent observes by any one of these, variable -> the variable that keeps what it was some
    periods ago; what is not named is observed as it is. `kept`: these variables -> those that they keep, as which they
    start.

    Where there are `cases`, the one that holds the state at a sample, before anything jumps, says how it moves until
    the next; where several hold it, any of them. `rates`, `error`, `jumps` of the flow itself are then the first one's.
    """

    period: Fraction
    rates: Mapping[str, Expression]
    held: Mapping[tuple[str, str], Mapping[str, Fraction]]
    error: Mapping[str, Interval] = field(default_factory=lambda: MappingProxyType({}))
    jumps: Mapping[str, Expression] = field(default_factory=lambda: MappingProxyType({}))
    jitter: Interval = (Fraction(0), Fraction(0))
    seen: tuple[Mapping[str, str], ...] = (MappingProxyType({}),)
    kept: Mapping[str, str] = field(default_factory=lambda: MappingProxyType({}))
    cases: tuple[FlowCase, ...] = ()

    @property
    def errors(self) -> dict[str, Interval]:
        """The least intervals around the errors of all cases."""
        zero, names = (Fraction(0), Fraction(0)), {name for each in self.each for name in each.error}
        ends = {name: [end for each in self.each for end in each.error.get(name, zero)] for name in sorted(names)}
        return {name: (min(of), max(of)) for name, of in ends.items()}

    @property
    def each(self) -> tuple[Flow, ...]:
        """The flow of each case, without cases; itself where there are none."""
        return tuple(replace(self, rates=c.rates, error=c.error, jumps=c.jumps, cases=()) for c in self.cases) or (
            self,
        )


@dataclass(frozen=True)
class FlowCase:
    """The motion of a state that at a sample lies in a box and meets conditions, as pieces have them."""

    where: Box
    when: Polytope
    rates: Mapping[str, Expression]
    error: Mapping[str, Interval]
    jumps: Mapping[str, Expression]
    choice: Mapping[str, str] = field(default_factory=lambda: MappingProxyType({}))

    @property
    def piece(self) -> Piece:
        """The states that it holds."""
        return Piece(self.where, {}, when=self.when)


@dataclass(frozen=True)
class System:
    """A user's world: `features` of each agent by name; `pieces` are empty where no dynamics are stated, or a flow."""

    name: str
    variables: tuple[Variable, ...]
    features: Mapping[str, Mapping[str, Feature]]
    start: Polytope
    pieces: tuple[Piece, ...] = ()
    steps: int = 0  # of an episode
    reference: str = ""  # the environment that the statement is about, `module:function` or `gymnasium:ID`
    flow: Flow | None = None  # steps are its periods


def ensure_in_steps(system: System, what: str) -> None:
    """InputError for a system in continuous time, of which `what` (a noun) knows nothing."""
    if system.flow is not None:
        raise InputError(f"{what} does not know continuous time", f"system {system.name}: dynamics.flow", IN_STEPS)


FREE: Interval = (
    cast("Fraction", -inf),
    cast("Fraction", inf),
)  # bounds of what nothing bounds: exact numbers lie between
MAX_INEQUALITIES = 4_000  # of one elimination


def box_of(bounds: Mapping[str, Interval]) -> Polytope:
    """The half spaces of a box."""
    halves: list[HalfSpace] = []
    for name, (low, high) in bounds.items():
        halves.append(HalfSpace(Affine.of({name: Fraction(-1)}, low)))
        halves.append(HalfSpace(Affine.of({name: Fraction(1)}, -high)))
    return tuple(halves)


def narrow(ends: Interval, factor: Fraction, end: Fraction) -> Interval:
    """Cuts an interval to what is below an end, or above it where the factor is negative; empty where they cross."""
    low, high = ends
    return (low, min(high, end)) if factor > 0 else (max(low, end), high)


def bounds_of(region: Polytope, ranges: Mapping[str, Interval]) -> dict[str, Interval]:
    """The ranges within what half spaces of one variable say, which may be wider than the polytope; empty ones cross.
    What has no range is left out.
    """
    bounds = dict(ranges)
    for half in region:
        match half.form.terms:
            case ((name, factor),) if name in bounds:
                bounds[name] = narrow(bounds[name], factor, -half.form.constant / factor)
            case _:
                pass
    return bounds


def is_empty(region: Polytope) -> bool | None:
    """Returns True if no state lies in all half spaces; None where that takes too many steps to say."""
    open_ = set(region)
    while new := _count_new(open_):
        if any(_false(half) for half in open_):
            return True
        open_ = _without(open_, min(new, key=lambda name: (new[name], name)))
        if len(open_) > MAX_INEQUALITIES:
            return None
    return any(_false(half) for half in open_)


def _false(half: HalfSpace) -> bool:
    return not half.form.terms and not half.holds({})


def _count_new(halves: set[HalfSpace]) -> dict[str, int]:
    """Counts the inequalities that eliminating each variable makes, in one go: a game has tens of variables."""
    above, below = Counter[str](), Counter[str]()
    for half in halves:
        for name, factor in half.form.terms:
            above[name] += factor.numerator > 0
            below[name] += factor.numerator < 0
    return {name: count * below[name] for name, count in above.items()}


def _without(halves: set[HalfSpace], name: str) -> set[HalfSpace]:
    """Returns the half spaces that remain once a variable is eliminated."""
    above, below = list[tuple[HalfSpace, Fraction]](), list[tuple[HalfSpace, Fraction]]()
    for half in halves:
        if factor := next((factor for each, factor in half.form.terms if each == name), None):
            (above if factor > 0 else below).append((half, factor))
    remaining = halves.difference(half for half, _ in (*above, *below))  # a set knows the hashes of what stays
    for (one, up), (other, down) in product(above, below):
        form = one.form.plus(other.form, up / -down)
        remaining.add(HalfSpace(_normalise_form(form), one.strict or other.strict))
    return remaining


def _normalise_form(form: Affine) -> Affine:
    """A positive multiple in which the first factor is 1 or -1, so that equal half spaces are equal data."""
    return Affine().plus(form, 1 / abs(form.terms[0][1])) if form.terms else form


def overlapping(boxes: Sequence[Box]) -> tuple[int, int] | None:
    """Two boxes that share more than a border, or None."""
    for (i, one), (j, other) in combinations(enumerate(boxes), 2):
        if not apart(one, other):
            return i, j
    return None


def apart(one: Box, other: Box) -> bool:
    """Tests if two boxes share at most a border. A box of no width is apart from others only where it lies outside."""
    for name in one.keys() & other.keys():
        low, high = max(one[name][0], other[name][0]), min(one[name][1], other[name][1])
        if low > high or (low == high and _is_wide(one[name]) and _is_wide(other[name])):
            return True
    return False


def _is_wide(bounds: Interval) -> bool:
    return bounds[0] < bounds[1]


def find_gap(whole: Box, boxes: Sequence[Box]) -> Box | None:
    """A box of states of `whole` that lie in none of the boxes, but for borders; None where there is none."""
    open_ = [dict(whole)]
    for box in boxes:
        open_ = [part for each in open_ for part in _less(each, box)]
    return open_[0] if open_ else None


def _less(whole: Box, box: Box) -> list[dict[str, Interval]]:
    """A box without another, as boxes."""
    rest, parts = dict(whole), list[dict[str, Interval]]()
    for name, (low, high) in box.items():
        least, most = rest[name]
        inner = max(least, low), min(most, high)
        if inner[0] > inner[1] or (inner[0] == inner[1] and least != most):
            return [dict(whole)]
        parts += [rest | {name: side} for side in ((least, inner[0]), (inner[1], most)) if side[0] < side[1]]
        rest[name] = inner
    return parts
