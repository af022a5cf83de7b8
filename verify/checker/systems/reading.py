"""The checker's own reading of episodes of a stated system: conditions on states as rows, and how states move.

Does: formulas over variables as conditions on those that are followed; the start; symbolic states after a step.
Assumes: claims/formula.py and systems/system.py; belongs to what must be right for a certificate to mean something.
Does not: search.

Of variables that are not followed nothing is known. A condition that names one is taken to hold, so a claim is shown of
more states than there are.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from fractions import Fraction
from math import gcd, lcm
from typing import NamedTuple

from verify.checker.reading import RejectedError
from verify.checker.systems.rows import Branch, Direction, Motion, Row, Terms, VariableSum, Weights
from verify.claims.formula import And, Formula, Linear, Or
from verify.systems.claims import atom
from verify.systems.system import Affine, Interval, Piece, Polytope, System

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
            condition = self._conditions[formula] = self._condition(formula)
        return condition

    def _condition(self, formula: Formula) -> Condition:
        if isinstance(formula, And):
            return Every(tuple(map(self.condition, formula.parts)))
        if isinstance(formula, Or):
            return Some(tuple(map(self.condition, formula.parts)))
        if not isinstance(formula, Linear):
            raise ValueError(f"not an inequality: {type(formula).__name__}")
        known = all(name in self.order for _, name in formula.terms)
        return Inequality(self.sum(formula.terms), formula.bound, formula.strict) if known else ALWAYS

    def start(self, region: Polytope) -> Branch | None:
        """The states within the ranges of the variables and a polytope; None where bounds tell that there are none."""
        return self._states(0, region, {one.name: one.range for one in self.system.variables})

    def hull(self, step: int, region: Polytope) -> Branch | None:
        """The states of a polytope at a step; None where bounds tell that there are none. RejectedError where it does
        not bound each followed variable on its own.
        """
        return self._states(step, region, dict[str, Interval]())

    def _states(self, step: int, region: Polytope, ranges: Mapping[str, Interval]) -> Branch | None:
        bounds = {name: _bounds(name, region, ranges) for name in self.order}
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
            multiple = motion.directions[asked] = self._primitive(sorted(weights.items()))
        return multiple

    def _primitive(self, weights: Sequence[tuple[int, Fraction]]) -> tuple[Direction | None, Fraction]:
        if not weights:
            return None, Fraction(1)
        common = lcm(*(weight.denominator for _, weight in weights))
        whole = [(unknown, int(weight * common)) for unknown, weight in weights]
        divisor = gcd(*(weight for _, weight in whole)) * (1 if whole[0][1] > 0 else -1)
        key = tuple((unknown, weight // divisor) for unknown, weight in whole)
        return self._directions.setdefault(key, Direction(key)), Fraction(divisor, common)

    def move_branch(self, branch: Branch, number: int, effects: tuple[Effect, ...]) -> Branch:
        """The symbolic state after a step by the piece of that number, in which each agent's action has an effect."""
        key = number, effects
        leap = self._leaps.get(key)
        if leap is None:
            piece = self.system.pieces[number]
            leap = Leap({name: _total(name, piece, effects, number) for name in self.order}, piece)
            leap.kind = self._kinds.setdefault(leap.key(), len(self._kinds))
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

    def key(self) -> LeapKey:
        """Returns a key of what the motion after it is made of."""
        return tuple((name, form.terms, *self.errors[name]) for name, form in self.forms.items())

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


def _bounds(name: str, region: Polytope, ranges: Mapping[str, Interval]) -> Interval:
    """Bounds of a variable: its range, and what a polytope says of it alone. They may be wider than the polytope."""
    lower, upper = ([bound] for bound in ranges[name]) if name in ranges else (list[Fraction](), list[Fraction]())
    for half in region:
        if [each for each, _ in half.form.terms] == [name]:
            factor = half.form.terms[0][1]
            (upper if factor > 0 else lower).append(-half.form.constant / factor)
    if not lower or not upper:
        raise RejectedError(f"a hull does not bound {name}")
    return max(lower), min(upper)


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
