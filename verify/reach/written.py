"""Episodes by the rules of a world file as they are written, known so narrowly that they surely break a claim.

Does: follows a start with given rules and errors, or near given states; says whether the episode surely breaks a claim.
Assumes: the checker's readings of rules (checker/systems/enclosures.py) and of trees (checker/systems/reading.py).
Does not: look for starts.

What sums, products, quotients and powers make of exact numbers is exact while it has few digits, and so is the bound
of a `clip` that is surely passed. Any other number lies in a range of whole multiples of 2^-128.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from functools import reduce
from math import isqrt
from typing import TypeAlias

from codegen.ir import NO_FEATURE, ROOT, AgentPolicy, PolicyProfile
from verify.checker.covers.boxes import linear
from verify.checker.reading import RejectedError
from verify.checker.systems.enclosures import ONE, Range, enclose, exactly, minus, plus, times
from verify.checker.systems.reading import sides_of
from verify.claims.formula import And, Formula, Linear, Not, Or, conjunction
from verify.reach.replay import Course
from verify.reach.results import Values
from verify.systems.claims import SystemClaim
from verify.systems.enclosures import domain
from verify.systems.expressions import (
    Call,
    Expression,
    Name,
    Number,
    Power,
    Product,
    Quotient,
    Sum,
    total,
)
from verify.systems.statement import Statement
from verify.systems.system import State, box_of, ensure_in_steps

MAX_BITS = 4_096  # of a number that is kept exact
AT_0 = {"sin": Fraction(0), "cos": Fraction(1), "tan": Fraction(0), "exp": Fraction(1)}
Known: TypeAlias = Mapping[str, "Fraction | Range"]
Ways: TypeAlias = Mapping[int, Known]  # by rule, the next state but for an error
# the step and where each rule leads -> the rule that is taken, and its errors
Choose: TypeAlias = Callable[[int, Ways], tuple[int, Values]]


class WrittenReplay:
    """Episodes of one claim. InputError for a system in continuous time."""

    def __init__(self, statement: Statement, profile: PolicyProfile, claim: SystemClaim) -> None:
        ensure_in_steps(statement.system, "the replay of rules")
        self._rules, self._profile, self._claim = statement.rules, profile, claim
        self._sides = {policy.agent: sides_of(statement.system, policy) for policy in profile.agents}
        ranges = {one.name: one.range for one in statement.system.variables}
        stated = [(*box_of(domain(rule, ranges)), *rule.when) for rule in statement.rules]
        self._held = [conjunction(*map(linear, halves)) for halves in stated]
        self._moves: dict[tuple[int, tuple[str, ...]], dict[str, Expression]] = {}

    def follow(self, course: Course) -> list[State] | None:
        """The episode whose rules and errors are given, each cut to what the file states: the middles of its states up
        to one that surely breaks the claim. None where none surely does.
        """

        def choose(step: int, ways: Ways) -> tuple[int, Values]:
            told = course.pieces[step] if step < len(course.pieces) else -1
            errors: Values = course.errors[step] if step < len(course.errors) else {}
            return told if told in ways else next(iter(ways)), errors

        return self._play(course.start, choose, len(course.pieces) or self._claim.steps)

    def keep_near(self, near: Sequence[State]) -> list[State] | None:
        """Plays, like `follow`, the episode that keeps to given states as closely as its errors allow."""

        def choose(step: int, ways: Ways) -> tuple[int, Values]:
            if step + 1 >= len(near):
                return next(iter(ways)), {}
            off = {
                number: {name: near[step + 1][name] - middle for name, middle in _middles(way).items()}
                for number, way in ways.items()
            }
            nearest = min(off, key=lambda number: max(map(abs, off[number].values())))
            return nearest, off[nearest]

        return self._play(near[0], choose, self._claim.steps)

    def _play(self, start: State, choose: Choose, last: int) -> list[State] | None:
        """The middles of the states up to one, at step `last` or before, that surely breaks the claim."""
        claim, state, middles = self._claim, dict[str, Fraction | Range](start), [start]
        for step in range(last + 1):
            if _truth(claim.violation_at(step), state):
                return middles
            chosen = [_take(policy, self._sides[policy.agent], state) for policy in self._profile.agents]
            joint = tuple(each for each in chosen if each is not None)
            if step == last or len(joint) < len(chosen) or _truth(claim.fulfilment_at(step), state) is not False:
                return None
            held = [number for number, condition in enumerate(self._held) if _truth(condition, state)]
            try:
                ways = {number: self._move(number, joint, state) for number in held}
            except RejectedError:  # a part of a rule may not be defined, or is beyond all use
                return None
            if not ways:
                return None
            number, errors = choose(step, ways)
            state = dict(ways[number])
            for name, (low, high) in self._rules[number].error.items():
                error, each = min(max(errors.get(name, Fraction(0)), low), high), state[name]
                state[name] = each + error if isinstance(each, Fraction) else plus(each, exactly(error))
            middles.append(_middles(state))
        return None

    def _move(self, number: int, joint: tuple[str, ...], state: Known) -> dict[str, Fraction | Range]:
        if (number, joint) not in self._moves:
            choices = list(zip((policy.agent for policy in self._profile.agents), joint, strict=True))
            effects = [self._rules[number].effect.get(choice, {}) for choice in choices]
            self._moves[number, joint] = {
                name: total([move, *(effect[name] for effect in effects if name in effect)])
                for name, move in self._rules[number].move.items()
            }
        after, box = (
            dict[str, Fraction | Range](),
            {n: exactly(at) if isinstance(at, Fraction) else at for n, at in state.items()},
        )
        for name, expression in self._moves[number, joint].items():
            exact = _exact(expression, state, box)
            after[name] = enclose(expression, box) if exact is None else exact
        return after


def _exact(expression: Expression, state: Known, box: Mapping[str, Range]) -> Fraction | None:
    """The value of an expression, where it is exact and of few digits; None where it is not known to be. `box`: the
    state as ranges. RejectedError where a part may not be defined.
    """
    value = _exact_of(expression, state, box)
    return value if value is None or value.numerator.bit_length() + value.denominator.bit_length() <= MAX_BITS else None


def _exact_of(expression: Expression, state: Known, box: Mapping[str, Range]) -> Fraction | None:
    match expression:
        case Number(value):
            return value
        case Name(name):
            known = state[name]
            return known if isinstance(known, Fraction) else None
        case Power(base, exponent):
            under = _exact(base, state, box)
            return None if under is None else under**exponent
        case Call(_, argument, (low, high)):
            inner = _exact(argument, state, box)
            if inner is not None:
                return min(max(inner, low), high)
            around = enclose(argument, box)
            return high if around.low >= exactly(high).high else low if around.high <= exactly(low).low else None
        case Call(function, argument, _):
            inner = _exact(argument, state, box)
            if inner is None or (function == "sqrt" and inner < 0):
                return None
            if function == "sqrt":  # exact of squares
                root = Fraction(isqrt(inner.numerator), isqrt(inner.denominator))
                return root if root**2 == inner else None
            return AT_0.get(function) if inner == 0 else None
        case Sum(left, right) | Product(left, right) | Quotient(left, right):
            one, other = (_exact(part, state, box) for part in (left, right))
            if one is None or other is None:
                return None
            if isinstance(expression, Quotient):
                return one / other if other else None
            return one + other if isinstance(expression, Sum) else one * other
        case _:
            return None


def _take(policy: AgentPolicy, sides: Mapping[int, Formula], state: Known) -> str | None:
    tree, node = policy.tree, ROOT
    while tree.feature[node] != NO_FEATURE:
        left = _truth(sides[node], state)
        if left is None:
            return None
        node = int((tree.left if left else tree.right)[node])
    return policy.actions[int(tree.action[node])].name


def _truth(formula: Formula, state: Known) -> bool | None:
    """Returns True if a formula holds in all states of ranges, False if in none; None where it is not known."""
    if isinstance(formula, Linear):
        exact, ranges = Fraction(0), list[Range]()  # of the sum of multiples, which is exact where its numbers are
        for weight, name in formula.terms:
            each = state[name]
            if isinstance(each, Fraction):
                exact += weight * each
            else:
                ranges.append(times(exactly(weight), each))
        if not ranges:
            return exact < formula.bound if formula.strict else exact <= formula.bound
        added = reduce(plus, ranges, exactly(exact))
        below = minus(exactly(formula.bound), added)
        if below.low > 0 or (below.low == 0 and not formula.strict):
            return True
        return False if below.high < 0 or (below.high == 0 and formula.strict) else None
    if isinstance(formula, Not):
        inner = _truth(formula.part, state)
        return None if inner is None else not inner
    assert isinstance(formula, (And, Or)), formula
    told, decides = [_truth(part, state) for part in formula.parts], isinstance(formula, Or)
    if decides in told:
        return decides
    return None if None in told else not decides


def _middles(state: Known) -> dict[str, Fraction]:
    return {
        name: each if isinstance(each, Fraction) else Fraction(each.low + each.high, 2 * ONE)
        for name, each in state.items()
    }
