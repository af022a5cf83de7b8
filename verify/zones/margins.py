"""Up to which margin a proved claim holds: searches of one question that differ in the weights of a few bounds.

Does: answers whether the claim is proved with a larger margin; remembers from which margin on an open branch stays
  open, so that most margins need no search.
Assumes: a claim that a margin only hardens; margins on a grid of steps from the claim's own one.
Does not: state formulas for each margin: which bounds move with it is read off two margins that nothing else equals.
"""

from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction
from math import lcm

from verify.question import DecisionQuestion
from verify.zones.engine import Tests, ZoneQuery
from verify.zones.search import BudgetError
from verify.zones.tables import EPSILON, BeyondZonesError, Bound, Problem, Table, infinite

LONE = Fraction(1, 2**61 - 1), Fraction(2, 2**61 - 1)  # added to a margin, they make bounds that no other one equals


class Room:
    """The margins of a question in `step`s from its own: which are proved, as far as that is known."""

    def __init__(self, question: DecisionQuestion, step: Fraction, steps: int) -> None:
        """BeyondZonesError when the question is not about difference bounds, or a margin does not only harden it."""
        tests = Tests.of(question)
        self._start, self._step, self._ends = question.claim.margin, step, steps
        self._goals = [_Goal(question, goal, tests, step, steps) for goal in question.goals]
        self._proved, self._failed = 0, steps + 1  # steps: proved up to here, not proved from here on

    def is_proved_at(self, margin: Fraction) -> bool:
        """Returns True if the claim is proved with a margin of the grid; not where the budget of nodes ended first."""
        wanted = int((margin - self._start) / self._step)
        while self._proved < wanted < self._failed:
            # just below what fails: if that is proved, so is everything below it
            for steps in dict.fromkeys((self._failed - 1, wanted)):
                if self._proved < steps < self._failed and not self._settle_margin(steps) and steps == wanted:
                    return False
        return wanted <= self._proved

    def _settle_margin(self, steps: int) -> bool:
        """Asks at a margin; whether that was decided within the budget."""
        try:
            failed = [first for each in self._goals if (first := each.fails_from(steps)) is not None]
        except BudgetError:
            return False
        if failed:
            self._failed = min(failed)
        else:
            self._proved = steps
        return True


class _Goal:
    """One goal's question, for all margins: the same bounds, some of which move with the margin."""

    def __init__(self, question: DecisionQuestion, goal: str | None, tests: Tests, step: Fraction, steps: int) -> None:
        first, second = (question.with_margin(question.claim.margin + extra) for extra in LONE)
        self._query = ZoneQuery(first, goal, tests)
        bounds = self._query.bounds
        others = Table(second.profile, second.formula_for(goal), second.region, goal).numbers
        rates = [_rate(bound, other) for bound, other in zip(bounds, others, strict=False)]
        rates += [Fraction(0)] * (len(bounds) - len(rates))  # sides of splits, which no margin moves
        own = [bound.most - rate * LONE[0] for bound, rate in zip(bounds, rates, strict=True)]
        scale = EPSILON * lcm(*(most.denominator for most in own), *((rate * step).denominator for rate in rates))
        self._weights = [int(most * scale) - bound.strict for bound, most in zip(bounds, own, strict=True)]
        self._moves = [int(rate * step * scale) for rate in rates]
        sizes = self._query.problem.sizes
        self._problem = replace(
            self._query.problem, scale=scale, infinite=infinite(sizes, [*self._weights, *self._move_weights(steps)])
        )

    def fails_from(self, steps: int) -> int | None:
        """None where the claim is proved at a margin; else at how many steps the branch found first is open."""
        query = self._query.replace_problem(self._at(steps))
        if query.answer()[1] is None:
            return None
        low, high = 0, steps  # the claim is proved at 0
        while high - low > 1:
            middle = (low + high) // 2
            low, high = (low, middle) if _consistent(self._at(middle), query.open) else (middle, high)
        return high

    def _at(self, steps: int) -> Problem:
        return replace(self._problem, weights=self._move_weights(steps))

    def _move_weights(self, steps: int) -> list[int]:
        return [weight + steps * move for weight, move in zip(self._weights, self._moves, strict=True)]


def _rate(bound: Bound, other: Bound) -> Fraction:
    """By how much a bound moves with the margin."""
    rate = (other.most - bound.most) / (LONE[1] - LONE[0])
    if (bound.upper, bound.lower, bound.strict) != (other.upper, other.lower, other.strict) or rate < 0:
        raise BeyondZonesError("the margin does more than loosen the denied claim's bounds")
    return rate


def _consistent(asked: Problem, numbers: Sequence[int]) -> bool:
    """Returns True if the numbered bounds can hold together: no cycle of them has a negative sum."""
    edges = [(asked.edges[number], asked.weights[number]) for number in set(numbers)]
    least: dict[tuple[int, int], int] = {}  # an upper bound of each node, from a start where all are 0
    for _ in range(sum(asked.sizes) + 1):
        settled = True
        for (component, upper, lower), weight in edges:
            reached = least.get((component, lower), 0) + weight
            if reached < least.get((component, upper), 0):
                least[component, upper], settled = reached, False
        if settled:
            return True
    return False
