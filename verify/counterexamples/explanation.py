"""Why a counterexample is one, and how far: what does not matter, what may change, by how much the claim fails.

Does: per coordinate the values that keep the violation, per agent the feature values that keep its leaf and the room of
  each test, the shortfall of the claim, and whether its leaves are the only way to fail (uniqueness.py).
Assumes: a counterexample that the referee confirmed, and its arithmetic, by the exact ends of tests
  (checker/thresholds.py); sums are linear in a coordinate.
Does not: vary several coordinates at once: each interval holds with everything else as it is.

The values of a coordinate are a union of intervals between cuts. The cut (v, 0) lies just below v and (v, 1) just above
it, so that one form covers open and closed ends.

Shortfall (`state.shortfall`): the least s such that the claim would hold, actions as they are, with every bound relaxed
by more than s. Room of a test: what its side is worth in the same sense (`values.worth`), that is by how much what the
feature measures can move before the test turns.
"""

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, TypeAlias

from codegen.ir import GOAL, AgentPolicy, FeatureSpec
from verify.checker.thresholds import AT_ONCE, find_twice_rounded_end, sides
from verify.claims.formula import (
    And,
    Formula,
    Linear,
    Not,
    Or,
    conjunction,
    for_goal,
    negate,
    normal,
    substitute_actions,
)
from verify.claims.region import Region
from verify.counterexamples.search import AgentView, Counterexample
from verify.counterexamples.uniqueness import Uniqueness, unique
from verify.kinds import MACHINE, REAL
from verify.question import DecisionQuestion
from verify.states.real import Value, value_of, write_value
from verify.states.state import State, Step, error_name, inside, leaves_at, shortfall, violates_by
from verify.states.values import worth

Cut: TypeAlias = tuple[Fraction, int]
Line: TypeAlias = tuple[tuple[Cut, Cut], ...]  # disjoint intervals in order, each from its lower to its upper cut


def line_between(low: Fraction, high: Fraction) -> Line:
    """All values from `low` to `high`, both included."""
    return (((low, 0), (high, 1)),)


def along(formula: Formula, name: str, at: Mapping[str, Fraction], within: Line) -> Line:
    """The values of coordinate `name`, of those in `within`, for which `formula` is true at the point `at`."""
    if isinstance(formula, Linear):
        weight, rest = Fraction(0), Fraction(0)
        for share, coordinate in formula.terms:
            if coordinate == name:
                weight += share
            else:
                rest += share * at[coordinate]
        if not weight:
            return within if rest < formula.bound or (rest == formula.bound and not formula.strict) else ()
        end = (formula.bound - rest) / weight
        if weight > 0:
            cut = (end, 0 if formula.strict else 1)
            return tuple((low, min(high, cut)) for low, high in within if low < cut)
        cut = (end, 1 if formula.strict else 0)
        return tuple((max(low, cut), high) for low, high in within if cut < high)
    if isinstance(formula, And):
        for part in formula.parts:
            within = along(part, name, at, within)
        return within
    if isinstance(formula, Or):
        union: list[tuple[Cut, Cut]] = []
        for low, high in sorted(interval for part in formula.parts for interval in along(part, name, at, within)):
            if union and low <= union[-1][1]:
                union[-1] = union[-1][0], max(union[-1][1], high)
            else:
                union.append((low, high))
        return tuple(union)
    assert isinstance(formula, Not), formula
    denied, remaining = along(formula.part, name, at, within), list[tuple[Cut, Cut]]()
    for low, high in within:
        for start, end in denied:
            if low <= start and end <= high:
                remaining += [(low, start)] if low < start else []
                low = end
        remaining += [(low, high)] if low < high else []
    return tuple(remaining)


def around(line: Line, value: float, *, whole: bool = False) -> tuple[float, float]:
    """The float64 numbers around `value` that lie in the set without another float64 number between: the ends, both in
    the set. `value` lies in the set. `whole`: only whole numbers count.
    """
    low = high = value
    while (piece := _interval_of(line, low)) is not None:
        low = float(math.ceil(_first(piece[0]))) if whole else _first(piece[0])
        below = _beside(low, -1, whole)
        if _interval_of(line, below) is None:
            break
        low = below  # a gap between two intervals that no float64 number lies in
    while (piece := _interval_of(line, high)) is not None:
        high = float(math.floor(_last(piece[1]))) if whole else _last(piece[1])
        above = _beside(high, 1, whole)
        if _interval_of(line, above) is None:
            break
        high = above
    return low, high


def _beside(value: float, side: int, whole: bool) -> float:
    """The next number on a side."""
    return value + side if whole else math.nextafter(value, side * math.inf)


def interval(line: Line, value: Fraction) -> tuple[Cut, Cut]:
    """The interval of the set in which `value` lies; it lies in the set."""
    return next((low, high) for low, high in line if low <= (value, 0) < high)


def beyond(line: Line, value: Fraction) -> list[Fraction]:
    """A number on either side of the interval of `value`, and outside the set; at an end that is left out, the end."""
    low, high = interval(line, value)
    place = line.index((low, high))
    below = line[place - 1][1][0] if place else low[0] - 1
    above = line[place + 1][0][0] if place + 1 < len(line) else high[0] + 1
    return [low[0] if low[1] else (below + low[0]) / 2, (high[0] + above) / 2 if high[1] else high[0]]


def _interval_of(line: Line, value: float) -> tuple[Cut, Cut] | None:
    if not math.isfinite(value):
        return None
    cut = (Fraction(value), 0)
    return next(((low, high) for low, high in line if low <= cut < high), None)


def _first(low: Cut) -> float:
    """The least float64 number above a cut."""
    value = float(low[0])
    if (Fraction(value), 0) < low:
        value = math.nextafter(value, math.inf)
    return value


def _last(high: Cut) -> float:
    """The greatest float64 number below a cut."""
    value = float(high[0])
    if (Fraction(value), 0) >= high:
        value = math.nextafter(value, -math.inf)
    return value


STAYS = "the values for which the claim still fails in the same leaves, with everything else unchanged"
DIGITS = 1e6  # of which shown ends are multiples of the inverse
LOW, HIGH = "low", "high"


@dataclass(frozen=True)
class CoordinateSpan:
    """The values of a coordinate that keep violation and leaves, all else being as it is.

    They are the float64 values between the ends, ends included; of real arithmetic all values between them.
    """

    name: str
    low: Value
    high: Value
    free: bool  # they are all that the region allows, more than one: the coordinate does not matter
    fixed: bool  # the region allows this value alone, all else being as it is
    excluded: tuple[str, ...] = ()  # of real arithmetic: those of "low" and "high" that are not among the values
    open: bool = False  # how far it may change is not determined: the ends are its value

    def document(self) -> dict[str, Any]:
        """The interval as plain data; whether a fixed coordinate matters is not known (null)."""
        matters = None if self.fixed or self.open else not self.free
        ends = {LOW: write_value(self.low), HIGH: write_value(self.high)}
        excluded = {"excluded": [*self.excluded]} if self.excluded else {}
        return {**ends, **excluded, "matters": matters, "says": str(self)}

    def __str__(self) -> str:
        if self.free:
            return "does not matter"
        if self.fixed:
            return "fixed by the region"
        if self.open:
            return "not determined: a test adds it to several others"
        if isinstance(self.low, float) and isinstance(self.high, float) and not self.excluded:
            low, high = format_ends(self.low, self.high)
        else:
            low, high = _exact_ends(Fraction(self.low), Fraction(self.high), self.excluded)
        return f"only {low}" if self.low == self.high else f"{low} to {high}"


@dataclass(frozen=True)
class Tested:
    """The observed values of one feature, low < value <= high, with which an agent's path stays the same."""

    feature: str
    low: float  # of the agent's numbers, or -infinity
    high: float  # of the agent's numbers, or infinity


@dataclass(frozen=True)
class Turn:
    """The distance of one test from turning."""

    step: Step
    over: float  # value minus threshold, as observed
    room: float  # by how much what is measured can move (length units); infinite for a constant


@dataclass(frozen=True)
class AgentRoom:
    """The features and tests that an agent's decision rests on."""

    agent: str
    tested: tuple[Tested, ...]
    untested: tuple[str, ...]  # features that do not matter to this decision
    turns: tuple[Turn, ...]

    @property
    def nearest(self) -> Turn | None:
        """The test that turns first; None when no test can."""
        able = [turn for turn in self.turns if math.isfinite(turn.room)]
        return min(able, key=lambda turn: turn.room, default=None)

    def document(self) -> dict[str, Any]:
        """The features and tests as plain data; null stands for an infinite number."""
        nearest = self.nearest
        return {
            "agent": self.agent,
            "features": {one.feature: {"above": _finite(one.low), "most": _finite(one.high)} for one in self.tested},
            "untested": list(self.untested),
            "tests": [
                {"node": turn.step.node, "test": str(turn.step), "over": turn.over, "room": _finite(turn.room)}
                for turn in self.turns
            ],
            "nearest": None if nearest is None else {"node": nearest.step.node, "room": nearest.room},
        }


@dataclass(frozen=True)
class Explanation:
    """The answers to an engineer's questions about a counterexample beside its point, its paths and its replays."""

    uniqueness: Uniqueness
    spans: tuple[CoordinateSpan, ...]
    agents: tuple[AgentRoom, ...]
    shortfall: float  # length units; infinite when no distance matters, only the actions

    @property
    def free(self) -> tuple[str, ...]:
        """The coordinates that do not matter."""
        return tuple(span.name for span in self.spans if span.free)

    def says(self) -> dict[str, str]:
        """The finding in a few short lines, by their headings."""
        by = "what the agents do, however far bounds are relaxed"
        if math.isfinite(self.shortfall):
            by = f"{self.shortfall:.3g} (with every bound relaxed by more than that, the claim holds here)"
        lines = {"unique": str(self.uniqueness), "fails by": by}
        nearest = [(room.agent, room.nearest) for room in self.agents]
        able = [(agent, turn) for agent, turn in nearest if turn is not None]
        if able:
            agent, turn = min(able, key=lambda one: one[1].room)
            lines["nearest"] = (
                f"a test of {agent} is the first to change its outcome, when moved by {turn.room:.3g}: {turn.step}"
            )
        lines["free"] = f"coordinates that do not matter when changed one at a time: {', '.join(self.free) or 'none'}"
        return lines

    def document(self) -> dict[str, Any]:
        """The finding as plain data; null stands for an infinite number."""
        return {
            "says": self.says(),
            "stays": STAYS,
            "unique": self.uniqueness.document(),
            "shortfall": _finite(self.shortfall),
            "coordinates": {span.name: span.document() for span in self.spans},
            "agents": [room.document() for room in self.agents],
        }


def format_ends(low: float, high: float) -> tuple[str, str]:
    """The ends of an interval with few digits, rounded to its inside; all digits where that leaves nothing."""
    inner = math.ceil(low * DIGITS) / DIGITS + 0.0, math.floor(high * DIGITS) / DIGITS + 0.0
    if low <= inner[0] <= inner[1] <= high:
        return f"{inner[0]:.12g}", f"{inner[1]:.12g}"
    return repr(low), repr(high)


def _exact_ends(low: Fraction, high: Fraction, excluded: Sequence[str]) -> tuple[str, str]:
    """Formats an interval of real numbers; `excluded`: those of "low" and "high" not in it. See `format_ends`."""
    scale = int(DIGITS)
    inner = math.ceil(low * scale), math.floor(high * scale)
    inner = (
        inner[0] + (LOW in excluded and inner[0] == low * scale),
        inner[1] - (HIGH in excluded and inner[1] == high * scale),
    )
    if inner[0] <= inner[1]:
        return f"{inner[0] / scale:.12g}", f"{inner[1] / scale:.12g}"
    return f"{'above ' if LOW in excluded else ''}{low}", f"{'below ' if HIGH in excluded else ''}{high}"


def _finite(number: float) -> float | None:
    return number if math.isfinite(number) else None


def explain_counterexample(question: DecisionQuestion, counterexample: Counterexample) -> Explanation:
    """Explains a confirmed counterexample.

    AssertionError when the referee does not confirm the end of an interval: that is our bug.
    """
    state, profile, semantics = counterexample.state, question.profile, question.semantics
    exact = state.exactly(profile)
    team = {policy.agent: policy for policy in profile.team(question.claim.team)}
    tests = {view.agent: _tests(team[view.agent], view, state, semantics) for view in counterexample.agents}
    actions = {
        view.agent: next(k for k, one in enumerate(team[view.agent].actions) if one.name == view.action)
        for view in counterexample.agents
    }
    stated = substitute_actions(for_goal(normal(question.formula), state.goal), actions)
    keeps = conjunction(*(test for several in tests.values() for test in several), negate(stated))
    return Explanation(
        uniqueness=unique(question, state),
        spans=_spans(question, state, keeps, _find_undetermined(question, counterexample)),
        agents=tuple(_room(team[view.agent], view, tests[view.agent], exact) for view in counterexample.agents),
        shortfall=float(shortfall(question, state)),
    )


def _tests(policy: AgentPolicy, view: AgentView, state: State, semantics: str) -> list[Formula]:
    """Returns each test on an agent's path as a formula about the world, as it fell out, errors being as they are."""
    formulas: list[Formula] = []
    for step in view.path:
        feature = next(one for one in policy.features if one.name == step.feature)
        error = Fraction(state.errors.get(error_name(policy.agent, feature.name), 0.0))
        numbers = policy.numbers
        left, right = sides(
            feature, step.threshold, numbers, REAL if _has_inexact_end(feature, semantics) else semantics
        )
        meaning = feature.meaning
        if error and meaning is not None and not meaning.function and semantics == MACHINE:
            end = find_twice_rounded_end(step.threshold, numbers)  # no float64 number any more, so rounded as a sum is
            terms = tuple((Fraction(weight), name) for weight, name in meaning.terms)
            left = Linear(terms, end.value(), end.strict)
            right = negate(left)
        side, sign = (left, -1) if step.left else (right, 1)
        if error and isinstance(side, Linear):
            side = Linear(side.terms, side.bound + sign * error, side.strict)
        formulas.append(for_goal(side, state.goal))
    return formulas


def _has_inexact_end(feature: FeatureSpec, semantics: str) -> bool:
    """Returns True if a test of the feature has no exact end: the deployed arithmetic rounds after each addition."""
    return semantics == MACHINE and feature.meaning is not None and len(feature.meaning.terms) > AT_ONCE


def _find_undetermined(question: DecisionQuestion, counterexample: Counterexample) -> set[str]:
    """The coordinates of tests without exact ends on the agents' paths, the goal's as its landmark's."""
    names = set[str]()
    for view in counterexample.agents:
        features = {one.name: one for one in question.profile.policy(view.agent).features}
        tested = [features[step.feature] for step in view.path]
        meanings = [one.meaning for one in tested if one.meaning and _has_inexact_end(one, question.semantics)]
        names |= {name for meaning in meanings for _, name in meaning.terms}
    goal = counterexample.state.goal
    return {f"{goal}{name.removeprefix(GOAL)}" if name.startswith(f"{GOAL}.") else name for name in names}


def _spans(
    question: DecisionQuestion, state: State, keeps: Formula, undetermined: Collection[str]
) -> tuple[CoordinateSpan, ...]:
    region, limits = question.region, _limits(question.region)

    def find_leaves(at: State) -> dict[str, int]:
        return leaves_at(question.profile, question.claim.team, at, question.semantics)

    leaves = find_leaves(state)

    def stands(name: str, value: Value) -> bool:
        moved = State({**state.position, name: value}, state.goal, state.errors)
        return inside(region, moved) and find_leaves(moved) == leaves and violates_by(question, moved, leaves)

    spans, exact = list[CoordinateSpan](), state.exactly(question.profile)
    for name, bounds in region.box.items():
        if name in undetermined:
            spans.append(
                CoordinateSpan(name, state.position[name], state.position[name], free=False, fixed=False, open=True)
            )
            continue
        allowed = along(limits, name, exact, line_between(*bounds))
        kept = along(keeps, name, exact, allowed)
        value = state.position[name]
        real = question.semantics == REAL
        whole = name in region.whole
        span = _real_span(name, value, allowed, kept) if real else _float_span(name, float(value), allowed, kept, whole)
        one, inner, outer = span
        if not all(stands(name, value) for value in inner) or any(stands(name, value) for value in outer):
            raise AssertionError(
                f"{question.claim.name}: the referee does not confirm {one.low!r} <= {name} <= {one.high!r}"
            )
        spans.append(one)
    return tuple(spans)


def _float_span(
    name: str, value: float, allowed: Line, kept: Line, whole: bool
) -> tuple[CoordinateSpan, Sequence[Value], Sequence[Value]]:
    """The interval of float64 values, or `whole` ones, with values that must stand and such that must not."""
    low, high = around(kept, value, whole=whole)
    fixed = around(allowed, value, whole=whole) == (low, low) and len(allowed) == 1
    outside = (_beside(low, -1, whole), _beside(high, 1, whole))
    return CoordinateSpan(name, low, high, free=kept == allowed and not fixed, fixed=fixed), (low, high), outside


def _real_span(
    name: str, value: Value, allowed: Line, kept: Line
) -> tuple[CoordinateSpan, Sequence[Value], Sequence[Value]]:
    """Returns the interval of all real values, and the values to check, like `_float_span`."""
    (low, above), (high, within) = interval(kept, Fraction(value))
    excluded = tuple(end for end, out in ((LOW, above == 1), (HIGH, within == 0)) if out)
    fixed = len(allowed) == 1 and allowed[0] == ((low, 0), (low, 1))
    span = CoordinateSpan(name, value_of(low), value_of(high), kept == allowed and not fixed, fixed, excluded)
    ends = [end for end, out in ((low, above == 1), (high, within == 0)) if not out]
    return span, [*map(value_of, ends), value_of((low + high) / 2)], [*map(value_of, beyond(kept, Fraction(value)))]


def _room(policy: AgentPolicy, view: AgentView, tests: list[Formula], exact: Mapping[str, Fraction]) -> AgentRoom:
    cell: dict[str, tuple[float, float]] = {}
    turns: list[Turn] = []
    for step, test in zip(view.path, tests, strict=True):
        low, high = cell.get(step.feature, (-math.inf, math.inf))
        cell[step.feature] = (low, min(high, step.threshold)) if step.left else (max(low, step.threshold), high)
        turns.append(Turn(step, float(Fraction(step.value) - Fraction(step.threshold)), float(worth(test, exact, {}))))
    return AgentRoom(
        agent=view.agent,
        tested=tuple(Tested(feature, *ends) for feature, ends in cell.items()),
        untested=tuple(feature.name for feature in policy.features if feature.name not in cell),
        turns=tuple(turns),
    )


def _limits(region: Region) -> Formula:
    """The region's differences and distances as a formula; the box bounds the lines themselves."""
    one = Fraction(1)
    parts: list[Formula] = []
    for a, b, (low, high) in region.differences:
        parts += [Linear(((one, a), (-one, b)), high), Linear(((-one, a), (one, b)), -low)]
    for a, b, least in region.apart:
        pairs = [(f"{a}.{axis}", f"{b}.{axis}") for axis in "xy"]
        ways = [Linear(((-sign, p), (sign, q)), -least) for p, q in pairs for sign in (one, -one)]
        parts.append(Or(tuple(ways)))
    return conjunction(*parts)
