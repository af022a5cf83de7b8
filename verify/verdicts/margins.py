"""How much room a proof has: the largest closing margin, or error of features, up to which a claim stays proved.

Does: bisects over a grid of decimals, asking the decision procedure a bounded number of questions.
Assumes: the claim only gets harder: with its margin, as every claim does that asks for engagement; with larger errors.
Does not: guess: a question that is not answered counts as not proved, so what is found is a lower bound.
"""

from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction

STEP = Fraction(1, 1000)  # the grid, in the world's length unit
MAX_QUESTIONS = 12
WIDEST = Fraction(2)  # beyond the sides of the start regions nothing is ahead


@dataclass(frozen=True)
class Margin:
    """Proved at `proved`; not at `failed`, or None where the widest margin that is asked about is proved too."""

    proved: Fraction
    failed: Fraction | None
    questions: int


def largest_margin(proved_at: Callable[[Fraction], bool], start: Fraction) -> Margin:
    """The largest margin (or error) of the grid found proved from `start` (which is) on, by bisection.

    `proved_at`: whether the claim is proved with a margin (or error).
    """
    steps = int((WIDEST - start) / STEP)
    if steps <= 0:
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
