"""How much room a proof has: the largest closing margin, or error of features, up to which a claim stays proved.

Does: bisects over a grid of decimals, asking the decision procedure a bounded number of questions; of margins it asks
  the zones, and Z3 where the claim is beyond them.
Assumes: the claim only gets harder: with its margin, as every claim does that asks for engagement; with larger errors.
Does not: guess: a question that is not answered counts as not proved, so what is found is a lower bound.
"""

from collections.abc import Callable
from fractions import Fraction

from verify.question import DecisionQuestion
from verify.result import Margin, Verdict
from verify.solver.decide import decide
from verify.zones.engine import BeyondZonesError
from verify.zones.margins import Room

STEP = Fraction(1, 1000)  # the grid, in the world's length unit
MAX_QUESTIONS = 12
WIDEST = Fraction(2)  # beyond the sides of the start regions nothing is ahead


def room(question: DecisionQuestion) -> Margin | None:
    """Up to which margin a proved claim holds; None for claims that a margin does not make harder."""
    if not question.claim.hardens:
        return None

    def by_solver(margin: Fraction) -> bool:
        return decide(question.with_margin(margin)).verdict is Verdict.PROVED

    start = question.claim.margin
    try:
        proved_at = Room(question, STEP, steps_from(start)).is_proved_at
    except BeyondZonesError:
        proved_at = by_solver
    return largest_margin(proved_at, start)


def steps_from(start: Fraction) -> int:
    """Returns the maximum number of steps of the grid to ask about."""
    return max(0, int((WIDEST - start) / STEP))


def largest_margin(proved_at: Callable[[Fraction], bool], start: Fraction) -> Margin:
    """The largest margin (or error) of the grid found proved from `start` (which is) on, by bisection.

    `proved_at`: whether the claim is proved with a margin (or error).
    """
    steps = steps_from(start)
    if not steps:
        return Margin(start, None, 0)
    if proved_at(start + steps * STEP):
        return Margin(start + steps * STEP, None, 1)
    low, high, asked = 0, steps, 1
    while high - low > 1 and asked < MAX_QUESTIONS:
        middle = (low + high) // 2
        asked += 1
        if proved_at(start + middle * STEP):
            low = middle
        else:
            high = middle
    return Margin(start + low * STEP, start + high * STEP, asked)
