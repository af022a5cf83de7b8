"""The checker's own reading of a stated system: symbolic states, conditions on them as rows, trees as decisions.

Does: sums over unknowns with bounds and rows, and what contradicts these; formulas over variables as conditions on
  those that are followed; the start; symbolic states after a step; the exact side of a split, and a tree as a decision
  between effects, of which what cannot be known is left open.
Assumes: claims/formula.py, thresholds.py and systems/system.py; belongs to what must be right for a certificate to mean
  something.
Does not: search.

An unknown lies in [0, 1]: how far a start variable is between its bounds, or the error of a variable in a step. A
symbolic state is, for each variable that is followed, a sum of multiples of unknowns (its motion) and a number.

Of variables that are not followed nothing is known. A condition that names one is taken to hold, so a claim is shown of
more states than there are.

A feature is the exact value of what it measures, rounded once to what the agent compares. Rounding never changes an
order, so a side of a split is a half line of the exact value, whose end thresholds.py gives.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from fractions import Fraction
from math import gcd, lcm
from typing import NamedTuple

from codegen.errors import UnknownNameError
from codegen.ir import NO_FEATURE, ROOT, AgentPolicy, splits
from verify.checker.reading import RejectedError
from verify.checker.thresholds import find_real_end
from verify.claims.formula import FALSE, TRUE, And, Formula, Linear, Or, below, disjunction
from verify.systems.claims import atom
from verify.systems.system import FREE, Affine, Feature, Interval, Measure, Piece, Polytope, System, bounds_of

Weights = Mapping[int, Fraction]  # by unknown
Terms = tuple[tuple[Fraction, str], ...]  # weight, variable


class Span(NamedTuple):
    """Bounds of a number, each of which it may not be allowed to meet."""

    low: Fraction
    low_open: bool
    high: Fraction
    high_open: bool


UNIT = Span(Fraction(0), False, Fraction(1), False)


class Direction:
    """A sum of multiples of unknowns: whole numbers without a common divisor, the first of them above 0."""

    def __init__(self, weights: tuple[tuple[int, int], ...]) -> None:
        self.weights = weights  # (unknown, multiple), by unknown
        self.bits = max(abs(weight) for _, weight in weights).bit_length()  # multipliers are per 2**bits
        self.low = Fraction(sum(min(weight, 0) for _, weight in weights))
        self.high = Fraction(sum(max(weight, 0) for _, weight in weights))
        self.mask = sum(1 << unknown for unknown, _ in weights)  # the set of its unknowns
        self.alone = weights[0][0] if len(weights) == 1 else None  # the unknown, where there is one only


class Row(NamedTuple):
    """A direction is at most `end`, or with `upper` False at least; below or above it where `strict`."""

    direction: Direction
    upper: bool
    end: Fraction
    strict: bool

    def opposite(self) -> Row:
        """Returns the row that holds where this one does not."""
        return Row(self.direction, not self.upper, self.end, not self.strict)


class VariableSum:
    """A sum of multiples of followed variables; one object for equal sums."""

    def __init__(self, terms: Terms) -> None:
        self.terms = terms


class Motion:
    """The dependence of the followed variables on the unknowns after some steps; one object for equal dependence."""

    def __init__(self, weights: Mapping[str, Weights], unknowns: tuple[tuple[int, str], ...]) -> None:
        self.weights = weights
        self.unknowns = unknowns  # (number of the step, variable) of each error; of start variables the step is -1
        self.directions: dict[VariableSum, tuple[Direction | None, Fraction]] = {}
        self.later: dict[int, Motion] = {}  # by kind of step


class Branch:
    """A symbolic state: all states that some values of the unknowns within `box` and all `rows` lead to."""

    def __init__(self, step: int, motion: Motion, at: Mapping[str, Fraction]) -> None:
        self.step = step
        self.motion = motion
        self.at = at  # the number that is added, by variable
        self.added: dict[VariableSum, Fraction] = {}  # the same for sums of variables, as far as they were asked about
        self.box: Mapping[int, Span] = {}  # of unknowns that are bounded more narrowly than by [0, 1]
        self.rows: tuple[Row, ...] = ()
        self.pieces: tuple[int, ...] = ()  # that moved it
        self.note: object = None  # whoever answers questions may keep something here

    def copy(self) -> Branch:
        """The same again."""
        other = Branch(self.step, self.motion, self.at)
        other.box, other.rows, other.pieces, other.note = self.box, self.rows, self.pieces, self.note
        other.added = self.added
        return other

    def with_row(self, row: Row) -> Branch:
        """Those of its states for which a row holds."""
        other, alone = self.copy(), row.direction.alone
        if alone is None:
            other.rows = (*self.rows, row)
        else:
            other.box = {**self.box, alone: _narrow_span(self.box.get(alone, UNIT), row)}
        return other

    def span(self, direction: Direction) -> Span:
        """Bounds of a direction by the box, and by the rows of that direction."""
        span = self._by_box(direction)
        for row in self.rows:
            if row.direction is direction:
                span = _narrow_span(span, row)
        return span

    def _by_box(self, direction: Direction) -> Span:
        if not self.box:
            return Span(direction.low, False, direction.high, False)
        if direction.alone is not None:  # its multiple is 1
            return self.box.get(direction.alone, UNIT)
        low, high = direction.low, direction.high
        low_open = high_open = False
        for unknown, weight in direction.weights:
            span = self.box.get(unknown)
            if span is not None:
                small, large = (span[:2], span[2:]) if weight > 0 else (span[2:], span[:2])
                low, high = low + weight * small[0], high + weight * large[0]
                low, high = low - min(weight, 0), high - max(weight, 0)
                low_open, high_open = low_open or small[1], high_open or large[1]
        return Span(low, low_open, high, high_open)

    def decide_row(self, row: Row) -> bool | None:
        """Returns whether a row holds for all its states or for none, as far as bounds tell; None where they do not."""
        low, low_open, high, high_open = self.span(row.direction)
        if not row.upper:
            low, low_open, high, high_open = -high, high_open, -low, low_open
        end = row.end if row.upper else -row.end
        if high < end or (high == end and (high_open or not row.strict)):
            return True
        return False if low > end or (low == end and (low_open or row.strict)) else None

    def is_contradicted(self, used: Iterable[tuple[Row, int]]) -> bool:
        """Returns True if rows, each times a number above 0 per 2**bits of its direction, sum to beyond all bounds."""
        used = list(used)
        most = max((row.direction.bits for row, _ in used), default=0)
        weights: dict[int, int] = {}
        total, strict = Fraction(0), False
        for row, times in used:
            factor = times << (most - row.direction.bits)
            factor = factor if row.upper else -factor
            for unknown, weight in row.direction.weights:
                weights[unknown] = weights.get(unknown, 0) + factor * weight
            total -= factor * row.end
            strict = strict or row.strict
        whole = 0  # the least of those unknowns that the box does not narrow
        for unknown, weight in weights.items():
            span = self.box.get(unknown)
            if span is None:
                whole += min(weight, 0)
            elif weight:
                end, is_open = span[:2] if weight > 0 else span[2:]
                total, strict = total + weight * end, strict or is_open
        return total + whole > 0 or (total + whole == 0 and strict)


def _narrow_span(span: Span, row: Row) -> Span:
    """The bounds of a direction once a row of that direction holds."""
    low, low_open, high, high_open = span
    if row.upper:
        high_open = row.strict if row.end < high else high_open or (row.strict and row.end == high)
        return Span(low, low_open, min(high, row.end), high_open)
    low_open = row.strict if row.end > low else low_open or (row.strict and row.end == low)
    return Span(max(low, row.end), low_open, high, high_open)


EXACT: Interval = (Fraction(0), Fraction(0))
LeapKey = tuple[tuple[str, tuple[tuple[str, Fraction], ...], Fraction, Fraction], ...]  # variable, its form, its error


class Inequality(NamedTuple):
    """A sum of variables is at most a number, or below it."""

    sum: VariableSum
    most: Fraction
    strict: bool


class Every(NamedTuple):
    """All parts hold; without parts it is true."""

    parts: tuple[Condition, ...]


class Some(NamedTuple):
    """Some part holds; without parts it is false."""

    parts: tuple[Condition, ...]


Condition = Inequality | Every | Some  # on states, by their followed variables
ALWAYS = Every(())


class SystemReading:
    """Symbolic states of a system of which some variables are `followed`; nothing is known of the others."""

    def __init__(self, system: System, followed: Iterable[str]) -> None:
        names = frozenset(followed)
        self.system = system
        self.order = tuple(one.name for one in system.variables if one.name in names)
        self._directions: dict[tuple[tuple[int, int], ...], Direction] = {}
        self._sums: dict[Terms, VariableSum] = {}
        self._conditions: dict[Formula, Condition] = {}
        self._leaps: dict[tuple[int, tuple[Effect, ...]], Leap] = {}
        self._kinds: dict[LeapKey, int] = {}

    def sum(self, terms: Terms) -> VariableSum:
        """The one object of a sum."""
        return self._sums.setdefault(terms, VariableSum(terms))

    def condition(self, formula: Formula) -> Condition:
        """A formula without actions and negations; what speaks of variables that are not followed is taken to hold."""
        condition = self._conditions.get(formula)
        if condition is None:
            if isinstance(formula, And | Or):
                parts = tuple(map(self.condition, formula.parts))
                condition = Every(parts) if isinstance(formula, And) else Some(parts)
            elif not isinstance(formula, Linear):
                raise ValueError(f"not an inequality: {type(formula).__name__}")
            elif all(name in self.order for _, name in formula.terms):
                condition = Inequality(self.sum(formula.terms), formula.bound, formula.strict)
            else:
                condition = ALWAYS
            self._conditions[formula] = condition
        return condition

    def start(self, region: Polytope) -> Branch | None:
        """The states within the ranges of the variables and a polytope; None where bounds tell that there are none."""
        return self._states(0, region, {one.name: one.range for one in self.system.variables})

    def hull(self, step: int, region: Polytope) -> Branch | None:
        """The states of a polytope at a step; None where bounds tell that there are none. RejectedError where it does
        not bound each followed variable on its own.
        """
        return self._states(step, region, dict[str, Interval]())

    def _states(self, step: int, region: Polytope, ranges: Mapping[str, Interval]) -> Branch | None:
        bounds = bounds_of(region, {name: ranges.get(name, FREE) for name in self.order})
        unbounded = [name for name, ends in bounds.items() if not set(FREE).isdisjoint(ends)]
        if unbounded:
            raise RejectedError(f"a hull does not bound {unbounded[0]}")
        if any(low > high for low, high in bounds.values()):
            return None
        loose = [name for name in self.order if bounds[name][0] < bounds[name][1]]
        weights: dict[str, Weights] = {name: {} for name in self.order}
        for unknown, name in enumerate(loose):
            weights[name] = {unknown: bounds[name][1] - bounds[name][0]}
        motion = Motion(weights, tuple((-1, name) for name in loose))
        branch: Branch | None = Branch(step, motion, {name: bounds[name][0] for name in self.order})
        for half in region:
            branch = None if branch is None else self._assume_condition(branch, self.condition(atom(half)))
        return branch

    def _assume_condition(self, branch: Branch, condition: Condition) -> Branch | None:
        """The states of a branch for which what is known to hold of it holds."""
        if not isinstance(condition, Inequality):
            return None if isinstance(condition, Some) else branch
        row = self.row(branch, condition)
        settled = row if isinstance(row, bool) else branch.decide_row(row)
        if settled is None and isinstance(row, Row):
            return branch.with_row(row)
        return branch if settled else None

    def row(self, branch: Branch, asked: Inequality) -> Row | bool:
        """An inequality as a row of a branch; true or false where no unknown is in it."""
        direction, scale = self.direction(branch.motion, asked.sum)
        added = branch.added.get(asked.sum)
        if added is None:
            added = sum((weight * branch.at[name] for weight, name in asked.sum.terms), Fraction(0))
            branch.added[asked.sum] = added
        end = asked.most - added
        if direction is None:
            return end > 0 or (end == 0 and not asked.strict)
        return Row(direction, scale > 0, end / scale, asked.strict)

    def direction(self, motion: Motion, asked: VariableSum) -> tuple[Direction | None, Fraction]:
        """A sum of variables as a multiple of a direction, but for a number; None where no unknown is in it."""
        multiple = motion.directions.get(asked)
        if multiple is None:
            weights: dict[int, Fraction] = {}
            for weight, name in asked.terms:
                _add(weights, motion.weights[name], weight)
            multiple = None, Fraction(1)
            if weights:
                common = lcm(*(weight.denominator for weight in weights.values()))
                whole = [(unknown, int(weight * common)) for unknown, weight in sorted(weights.items())]
                divisor = gcd(*(weight for _, weight in whole)) * (1 if whole[0][1] > 0 else -1)
                key = tuple((unknown, weight // divisor) for unknown, weight in whole)
                multiple = self._directions.setdefault(key, Direction(key)), Fraction(divisor, common)
            motion.directions[asked] = multiple
        return multiple

    def move_branch(self, branch: Branch, number: int, effects: tuple[Effect, ...]) -> Branch:
        """The symbolic state after a step by the piece of that number, in which each agent's action has an effect."""
        key = number, effects
        leap = self._leaps.get(key)
        if leap is None:
            piece = self.system.pieces[number]
            leap = Leap({name: _total(name, piece, effects, number) for name in self.order}, piece)
            motion_of = tuple((name, form.terms, *leap.errors[name]) for name, form in leap.forms.items())
            leap.kind = self._kinds.setdefault(motion_of, len(self._kinds))
            self._leaps[key] = leap
        motion = branch.motion.later.get(leap.kind)
        if motion is None:
            motion = branch.motion.later[leap.kind] = leap.after(branch)
        after = branch.copy()
        after.added = {}
        after.at = {name: form.at(branch.at) + leap.least[name] for name, form in leap.forms.items()}
        after.step, after.motion, after.pieces = branch.step + 1, motion, (*branch.pieces, number)
        return after


class Effect:
    """An action's effect on the followed variables, in each piece: forms that are added; one object for equal ones."""

    def __init__(self, by_piece: tuple[Mapping[str, Affine], ...], number: int) -> None:
        self.by_piece = by_piece
        self.number = number  # the least of the actions that have it


class Leap:
    """The motion of the followed variables by a piece and a joint action."""

    def __init__(self, forms: Mapping[str, Affine], piece: Piece) -> None:
        self.forms = forms
        self.errors = {name: piece.error.get(name, EXACT) for name in forms}
        self.least = {name: low for name, (low, _) in self.errors.items()}
        self.kind = 0  # the same for leaps with the same motion

    def after(self, branch: Branch) -> Motion:
        """The motion after it."""
        before, weights = branch.motion, dict[str, Weights]()
        unknowns = list(before.unknowns)
        for name, form in self.forms.items():
            by_unknown: dict[int, Fraction] = {}
            for read, factor in form.terms:
                _add(by_unknown, before.weights[read], factor)
            low, high = self.errors[name]
            if low < high:
                by_unknown[len(unknowns)] = high - low
                unknowns.append((branch.step, name))
            weights[name] = by_unknown
        return Motion(weights, tuple(unknowns))


def _total(name: str, piece: Piece, effects: Sequence[Effect], number: int) -> Affine:
    """The next value of a variable, as a form of the values before, but for its error."""
    form = piece.move.get(name, Affine())
    for effect in effects:
        form = form.plus(effect.by_piece[number].get(name, Affine()))
    return form


def _add(weights: dict[int, Fraction], more: Weights, times: Fraction) -> None:
    for unknown, weight in more.items():
        total = weights.get(unknown, Fraction(0)) + times * weight
        if total:
            weights[unknown] = total
        else:
            weights.pop(unknown, None)


Choices = frozenset[Effect]


class Split(NamedTuple):
    """A test of followed variables."""

    left_if: Inequality
    left: Decision
    right: Decision


Decision = Split | Choices  # at a leaf, the effects of which each may be taken


def goes_left(feature: Feature, threshold: float, numbers: str) -> Formula:
    """Where a split on a feature goes left, for an agent that compares such numbers: an inequality, one of two that
    exclude each other, always or never.
    """
    terms = dict(feature.form.terms)
    if feature.measure in (Measure.SIGN, Measure.POSITIVE):
        least = -1 if feature.measure is Measure.SIGN else 0
        if threshold < least or threshold >= 1:
            return TRUE if threshold >= 1 else FALSE
        return below(terms, -feature.form.constant, threshold < 0)
    if feature.measure is Measure.EQUALS:
        if threshold < 0 or threshold >= 1:
            return TRUE if threshold >= 1 else FALSE
        beyond = {name: -factor for name, factor in terms.items()}
        constant = feature.form.constant
        return disjunction(below(terms, -constant, True), below(beyond, constant, True))
    end = find_real_end(threshold, numbers)
    most, strict = end.value(), end.strict
    if feature.measure is Measure.CLIP and feature.bounds is not None:
        low, high = (bound < most or (bound == most and not strict) for bound in feature.bounds)
        if high or not low:
            return TRUE if high else FALSE
    return below(terms, most - feature.form.constant, strict)


def alternatives(formula: Formula) -> tuple[Formula, ...]:
    """The formulas of which one has to hold."""
    return formula.parts if isinstance(formula, Or) else (formula,)


def decisions(
    system: System, reading: SystemReading, policies: Sequence[AgentPolicy], by_action: bool
) -> list[Decision]:
    """The tree of each policy. `by_action`: actions are told apart, not what they do."""
    return [_decision(system, reading, policy, by_action) for policy in policies]


def _decision(system: System, reading: SystemReading, policy: AgentPolicy, by_action: bool) -> Decision:
    sides = sides_of(system, policy)
    alone = [Effect((), number) for number in range(len(policy.actions))]
    effects = alone if by_action else _effects(system, reading, policy)
    tree, built = policy.tree, dict[int, Decision]()
    for node in reversed(range(len(tree.feature))):  # children stand behind their parents
        if tree.feature[node] == NO_FEATURE:
            built[node] = frozenset({effects[int(tree.action[node])]})
        else:
            left, right = built[int(tree.left[node])], built[int(tree.right[node])]
            built[node] = _build_split(reading, sides[node], left, right)
    return built[ROOT]


def sides_of(system: System, policy: AgentPolicy) -> dict[int, Formula]:
    """Where each split of a tree goes left."""
    features = system.features.get(policy.agent)
    if features is None:
        raise UnknownNameError("agent", policy.agent, system.features, f"system {system.name}")
    sides: dict[int, Formula] = {}
    for node in splits(policy.tree):
        name = policy.features[int(policy.tree.feature[node])].name
        if name not in features:
            raise UnknownNameError("feature", name, features, f"system {system.name}, agent {policy.agent}")
        sides[node] = goes_left(features[name], float(policy.tree.threshold[node]), policy.numbers)
    return sides


def _effects(system: System, reading: SystemReading, policy: AgentPolicy) -> list[Effect]:
    """Returns the effect of each action on the followed variables; one object for equal effects."""
    distinct: dict[object, Effect] = {}
    effects: list[Effect] = []
    for number, action in enumerate(policy.actions):
        stated = [piece.effect.get((policy.agent, action.name), {}) for piece in system.pieces]
        by_piece = tuple(
            {name: forms[name] for name in reading.order if forms.get(name, Affine()) != Affine()} for forms in stated
        )
        key = tuple(tuple((name, form.terms, form.constant) for name, form in each.items()) for each in by_piece)
        effects.append(distinct.setdefault(key, Effect(by_piece, number)))
    return effects


def _build_split(reading: SystemReading, side: Formula, left: Decision, right: Decision) -> Decision:
    """A split that goes left where a formula holds; either side, where nothing is known of the test."""
    if side in (TRUE, FALSE):
        return left if side == TRUE else right
    if isinstance(side, Or):
        for part in reversed(side.parts):
            right = _build_split(reading, part, left, right)
        return right
    condition = reading.condition(side)
    if not isinstance(condition, Inequality):
        return either(left, right)
    return left if left == right else Split(condition, left, right)


def either(first: Decision, second: Decision) -> Decision:
    """One of two decisions, it is not known which."""
    if isinstance(first, Split):
        left = either(first.left, prune_decision(second, first.left_if, True))
        right = either(first.right, prune_decision(second, first.left_if, False))
        return left if left == right else Split(first.left_if, left, right)
    if isinstance(second, Split):
        return either(second, first)
    return first | second


def prune_decision(decision: Decision, known: Inequality, holds: bool) -> Decision:
    """A decision where it is known whether an inequality holds."""
    if not isinstance(decision, Split):
        return decision
    asked = decision.left_if
    if asked.sum is known.sum:
        order = (asked.most, not asked.strict), (known.most, not known.strict)
        if holds and order[0] >= order[1]:
            return prune_decision(decision.left, known, holds)
        if not holds and order[0] <= order[1]:
            return prune_decision(decision.right, known, holds)
    left, right = prune_decision(decision.left, known, holds), prune_decision(decision.right, known, holds)
    return left if left == right else Split(asked, left, right)
