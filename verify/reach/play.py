"""Starts and errors that may break claims: played in float64, many at a time.

Does: plays random episodes of a stated system, with starts and errors at bounds among them, by its pieces or by rules
  as they are written; the courses that break claims. Starts lie anywhere, or in boxes that were left open. Finds the
  piece that holds each state of a batch.
Assumes: nothing of what it finds is believed before it is replayed exactly; bounds are their nearest float64.
Does not: replay.

The bounds of all boxes cut the range of each variable into cells, and all states of a cell lie in the same boxes. So
boxes are compared once with each cell that a state lies in, and not with every state.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction
from itertools import accumulate
from typing import Any, NamedTuple

import numpy as np

from codegen.ir import AgentPolicy, Bool, Float64, Int64, PolicyProfile, act
from codegen.numbers import nearest_double
from verify.checker.systems.reading import SystemReading
from verify.reach.replay import Course
from verify.spending import tell
from verify.states.values import Batch
from verify.systems.claims import SystemClaim
from verify.systems.expressions import Expression
from verify.systems.observing import ARRAYS, function
from verify.systems.statement import Rule
from verify.systems.system import Affine, Feature, FlowCase, Interval, Measure, Piece, System

MAX_COURSES = 16
MAX_NUMBERED = 1 << 31  # cells: of more, those are numbered anew that some state lies in
ENOUGH, REDRAWS = 256, 24  # starts that meet all conditions; how often more are drawn until there are so many
Planes = dict[str, Float64]  # variable -> [batch]


class Starts(NamedTuple):
    """The number of episodes that start, and the boxes they start in, bounds [n, variables]; None: anywhere."""

    episodes: int
    boxes: tuple[Float64, Float64] | None = None


def courses(
    profile: PolicyProfile, system: System, claim: SystemClaim, starts: Starts, rules: Sequence[Rule] = ()
) -> Iterator[Course]:
    """Courses that break a claim in float64, at most MAX_COURSES, the short ones first. `rules`: those that move the
    state, in place of the system's pieces; then a course numbers rules, and its errors are theirs.
    """
    random = np.random.default_rng(0)
    start = random_starts(system, claim, starts, random)
    if start is None:
        return
    with np.errstate(all="ignore"):  # a state beyond float64 is a proposal like any other
        count, found = len(next(iter(start.values()))), 0
        if claim.about_decisions:
            actions = {policy.agent: act(policy, observe_planes(system, policy, start)) for policy in profile.agents}
            broken = ~Batch(start, count).holds(claim.formula, actions)
            for place in np.flatnonzero(broken)[:MAX_COURSES]:
                yield Course({name: Fraction(float(values[place])) for name, values in start.items()})
            return
        play = Play(profile, system, rules)
        for step, state, going in play.walk(start, random, claim.steps):
            batch = Batch(state, count)
            broken = going & batch.holds(claim.violation_at(step), {})
            for place in np.flatnonzero(broken)[: MAX_COURSES - found]:
                found += 1
                yield play.course(start, int(place))
            if found == MAX_COURSES:
                return
            going &= ~broken & ~batch.holds(claim.fulfilment_at(step), {})


def random_starts(system: System, claim: SystemClaim, starts: Starts, random: np.random.Generator) -> Planes | None:
    """Random starts, half of the numbers at a bound in half of them; None where none was found. Where conditions leave
    few of those that are drawn, more are.
    """
    still, count = claim.about_decisions, starts.episodes
    polytope = () if still else system.start
    reading = SystemReading(system, [one.name for one in system.variables])
    branch = reading.start(polytope)
    if branch is None:
        return None

    def draw() -> Planes:
        planes: Planes = {}
        columns = {one.name: column for column, one in enumerate(system.variables)}
        for name in reading.order:
            where = random.random(count)
            rounded = random.random(count) < np.where(np.arange(count) % 2, 0.5, 0.0)
            where = np.where(rounded, np.round(where), where)
            if starts.boxes is None:
                width = sum(map(float, branch.motion.weights[name].values()))
                planes[name] = float(branch.at[name]) + width * where
            else:
                low, high = (ends[np.arange(count) % len(ends), columns[name]] for ends in starts.boxes)
                planes[name] = np.where(where == 1, high, low + (high - low) * where)  # a bound is met exactly
        kept = np.ones(count, dtype=np.bool_)
        for half in polytope:
            kept &= value(half.form, planes) <= 0
        if still and claim.regions:
            kept &= Batch(planes, count).holds(claim.inside, {})
        return {name: values[kept] for name, values in planes.items()}

    drawn = draw()
    for _ in range(REDRAWS):
        if len(next(iter(drawn.values()))) >= min(count, ENOUGH):
            break
        more = draw()
        drawn = {name: np.concatenate([values, more[name]])[:count] for name, values in drawn.items()}
    return drawn if len(next(iter(drawn.values()))) else None


class Play:
    """Episodes, a batch at a time."""

    def __init__(self, profile: PolicyProfile, system: System, rules: Sequence[Rule] = ()) -> None:
        """`rules`: as in `courses`."""
        self.profile, self.system = profile, system
        self._moving = rules or system.pieces
        self._boxes = Boxes(system)
        self._cases = Cases(self._moving) if rules or has_cases(system) else None
        self._errors: list[Planes] = []
        self._pieces: list[Int64] = []

    def walk(self, start: Planes, random: np.random.Generator, steps: int) -> Iterator[tuple[int, Planes, Bool]]:
        """Each step with the states and which episodes go on: whoever asks may end some of them."""
        state, count = start, len(next(iter(start.values())))
        alive = np.ones(count, dtype=np.bool_)
        extreme = random.random(count)
        for step in range(steps + 1):
            tell(step, steps, f"steps of {count:,} random episodes")
            yield step, state, alive
            if step < steps and alive.any():
                state, moved = self._step(state, count, extreme, random)
                alive &= moved

    def _step(self, state: Planes, count: int, extreme: Float64, random: np.random.Generator) -> tuple[Planes, Bool]:
        """The next states, and which of them are stated."""
        after = {name: np.zeros(count) for name in state}
        errors = {name: np.zeros(count) for name in state}
        actions = {
            policy.agent: act(policy, observe_planes(self.system, policy, state)) for policy in self.profile.agents
        }
        if self._cases is None:  # the number of what moves each state; -1 where nothing is stated
            piece_of = self._boxes.holding(state, count)
        else:
            piece_of = self._cases.holding(state, count, _shares(extreme, random))
            if self._moving is not self.system.pieces:  # a rule without a box holds where no piece does
                piece_of = np.where(self._boxes.holding(state, count) < 0, -1, piece_of)
        # each piece draws from its own place in the stream, in order, whether a state lies in it or not: so what is
        # played does not depend on where other episodes are
        bits = random.bit_generator
        assert isinstance(bits, np.random.PCG64)
        drawn = [0, *accumulate(count * len(piece.move) for piece in self._moving)]
        ahead, held = 0, np.unique(piece_of[piece_of >= 0])  # `ahead`: the first piece that has not drawn
        for number in map(int, held):
            bits.advance(drawn[number] - drawn[ahead])
            ahead = number + 1
            piece, here = self._moving[number], np.flatnonzero(piece_of == number)
            stated = {name: values[here] for name, values in state.items()}
            for name, form in piece.move.items():
                error = _errors(piece.error.get(name), extreme, random)[here]
                errors[name][here] = error
                after[name][here] = value(form, stated) + error
            for policy in self.profile.agents:
                for action, spec in enumerate(policy.actions):
                    effect = piece.effect.get((policy.agent, spec.name), {})
                    if not effect:
                        continue
                    taken = here[actions[policy.agent][here] == action]
                    acted = {name: values[taken] for name, values in state.items()}
                    for name, form in effect.items():
                        after[name][taken] += value(form, acted)
        bits.advance(drawn[-1] - drawn[ahead])
        self._errors.append(errors)
        self._pieces.append(piece_of)
        return after, piece_of >= 0

    def course(self, start: Planes, place: int) -> Course:
        """Returns the course of an episode so far."""

        def exactly(planes: Planes) -> Mapping[str, Fraction]:
            return {name: Fraction(float(values[place])) for name, values in planes.items()}

        return Course(exactly(start), list(map(exactly, self._errors)), [int(each[place]) for each in self._pieces])


def _errors(bounds: Interval | None, extreme: Float64, random: np.random.Generator) -> Float64:
    """Errors of a step: for a third always the lower bound, for a third always the upper one, else anywhere."""
    low, high = map(float, bounds or (0, 0))
    return low + (high - low) * _shares(extreme, random)


def _shares(extreme: Float64, random: np.random.Generator) -> Float64:
    """Numbers of a step in [0, 1]: for a third of the episodes always 0, for a third always 1, else anywhere."""
    return np.where(extreme < 1 / 3, 0.0, np.where(extreme < 2 / 3, 1.0, random.random(len(extreme))))


def observe_planes(system: System, policy: AgentPolicy, state: Planes) -> Float64:
    """Observations of an agent, [batch, n_features], not rounded."""
    features = system.features[policy.agent]
    columns = [_measure_feature(features[feature.name], state) for feature in policy.features]
    return (
        np.stack(np.broadcast_arrays(*columns), axis=1) if columns else np.zeros((len(next(iter(state.values()))), 0))
    )


def _measure_feature(feature: Feature, state: Planes) -> Float64:
    values = value(feature.form, state)
    if feature.measure is Measure.SIGN:
        return np.sign(values)
    if feature.measure is Measure.POSITIVE:
        return np.asarray(values > 0, dtype=np.float64)
    if feature.measure is Measure.EQUALS:
        return np.asarray(values == 0, dtype=np.float64)
    if feature.measure is Measure.CLIP and feature.bounds is not None:
        return np.clip(values, float(feature.bounds[0]), float(feature.bounds[1]))
    return values


def value(form: Affine | Expression, state: Mapping[str, Float64]) -> Float64:
    """Evaluates a form, or an expression, in states, [batch]."""
    if not isinstance(form, Affine):
        return np.broadcast_to(function(form, ARRAYS)(state), len(next(iter(state.values()))))
    total: Any = nearest_double(form.constant)
    for name, factor in form.terms:
        total = total + nearest_double(factor) * state[name]
    return total if form.terms else np.full(len(next(iter(state.values()))), total)


class Boxes:
    """The boxes of a system's pieces, and the cells that were asked for."""

    def __init__(self, system: System) -> None:
        boxes = [
            {name: (float(low), float(high)) for name, (low, high) in piece.where.items()} for piece in system.pieces
        ]
        self._count = len(boxes)
        self._ends: dict[str, Float64] = {}  # of each variable that a box bounds
        for name in dict.fromkeys(name for box in boxes for name in box):
            self._ends[name] = np.unique(np.array([box[name] for box in boxes if name in box]))
        free = [(0, 2 * len(ends)) for ends in self._ends.values()]
        spans = np.array(
            [
                [
                    self._cells(name, np.array(box[name])).tolist() if name in box else span
                    for name, span in zip(self._ends, free, strict=True)
                ]
                for box in boxes
            ],
            dtype=np.int64,
        ).reshape(self._count, len(self._ends), 2)
        self._low, self._high = spans[:, :, 0], spans[:, :, 1]  # [pieces, variables]
        self._known: dict[bytes, int] = {}

    def holding(self, state: Mapping[str, Float64], count: int) -> Int64:
        """The number of the first piece that holds each of `count` states, [count]; -1 where none does."""
        cells = np.zeros((count, len(self._ends)), dtype=np.int64)
        which, most = np.zeros(count, dtype=np.int64), 1  # number of each state's cell, of so many
        for column, (name, ends) in enumerate(self._ends.items()):
            cells[:, column] = self._cells(name, state[name])
            which, most = which * (2 * len(ends) + 1) + cells[:, column], most * (2 * len(ends) + 1)
            if most > MAX_NUMBERED:
                which, most = np.unique(which, return_inverse=True)[1].reshape(count), count
        _, examples, which = np.unique(which, return_index=True, return_inverse=True)
        return np.array([self._first(cells[place]) for place in examples], dtype=np.int64)[which.reshape(count)]

    def _cells(self, name: str, values: Float64) -> Int64:
        """Twice the number of ends below a value, and one more on an end."""
        ends = self._ends[name]
        return np.searchsorted(ends, values, "left") + np.searchsorted(ends, values, "right")

    def _first(self, cell: Int64) -> int:
        key = cell.tobytes()
        if key not in self._known:
            holds = ((self._low <= cell) & (cell <= self._high)).all(axis=1)
            self._known[key] = int(holds.argmax()) if holds.any() else -1
        return self._known[key]


def has_cases(system: System) -> bool:
    """Returns True if pieces have conditions, or several pieces hold the same states."""
    return any(piece.when or piece.choice for piece in system.pieces)


class Cases:
    """The cases of pieces, or rules: each with the numbers of those that share its box and conditions."""

    def __init__(self, pieces: Sequence[Piece | Rule]) -> None:
        cases: dict[object, list[int]] = {}
        for number, piece in enumerate(pieces):
            cases.setdefault((tuple(sorted(piece.where.items())), piece.when), []).append(number)
        self._cases = [(pieces[numbers[0]], np.array(numbers, dtype=np.int64)) for numbers in cases.values()]

    def holding(self, state: Mapping[str, Float64], count: int, which: Float64) -> Int64:
        """The number of a piece that holds each of `count` states, [count]; -1 where none does. `which`: in [0, 1], the
        place of the piece among those of its case.
        """
        holder = np.full(count, -1, dtype=np.int64)
        for piece, numbers in self._cases:
            here = (holder < 0) & holds_states(piece, state, count)
            place = np.minimum((which * len(numbers)).astype(np.int64), len(numbers) - 1)
            holder[here] = numbers[place[here]]
        return holder


def holds_states(piece: Piece | Rule | FlowCase, state: Mapping[str, Float64], count: int) -> Bool:
    """Returns which of `count` states a box and conditions hold, [count]."""
    inside = np.ones(count, dtype=np.bool_)
    for name, (low, high) in piece.where.items():
        inside &= (state[name] >= nearest_double(low)) & (state[name] <= nearest_double(high))
    for half in piece.when:
        total = value(half.form, state)
        inside &= total < 0 if half.strict else total <= 0
    return inside
