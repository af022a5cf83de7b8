"""Bounds of claims, close to the extreme that a judge has sampled.

Does: a bound within 2 % of the extreme, beyond it, short of it, or short of it by less than any rounding; one that the
  extreme breaks.
Assumes: exact extremes: what a sum comes to in a state that the judge knows. More than the bound breaks a claim.
Does not: sample.
"""

import math
from fractions import Fraction

NEAR = Fraction(2, 100)  # of the sampled extreme
BEYOND, BRINK = 0.55, 0.15  # the shares of claims that lie beyond it, and short of it by less than a rounding
LEAST = Fraction(1, 1 << 10)  # of an extreme whose hundredth part says something
DIGITS = 40  # of bounds, in binary, behind the point
PLACES = 25  # of a decimal: what is less than one in its last place is less than any rounding of an extreme


def place_bound(rng, reached, brink=BRINK):
    """The claim's `bound`, one that is `false`, and whether it is `close`. `reached`: None where nothing was, and any
    bound will do; `brink`: the share of bounds that are short by less than a rounding.
    """
    extreme = Fraction(-1) if reached is None else reached
    near, way = max(abs(extreme), LEAST) * NEAR, rng.random()
    bound = below(extreme) if way < brink else inwards(extreme, near if way < brink + BEYOND else -near)
    close = reached is not None and abs(bound - reached) <= abs(reached) * NEAR
    return {"bound": bound, "false": inwards(extreme, -near), "close": close}


def says_much(reached):
    """Whether an extreme is one whose hundredth part says something."""
    return reached is not None and abs(reached) >= LEAST


def below(extreme):
    """A decimal below an extreme, but not by as much as a rounding."""
    return Fraction(math.ceil(extreme * 10**PLACES) - 1, 10**PLACES)


def inwards(extreme, off):
    """A number of few digits, off an extreme by as much or a little less."""
    bound = (extreme + off) * 2**DIGITS
    return Fraction(math.floor(bound) if off > 0 else math.ceil(bound), 2**DIGITS)


class Bounded:
    """A case whose claims bound a sum. `searched` finds the most that a judge knows; `drawn`: claims at most, until
    that says something.
    """

    drawn, brink, asked = 20, BRINK, 0

    def near(self, rng, *given):
        """A claim with a bound close to the most that was searched."""
        for _ in range(self.drawn):
            claim = self.searched(self.unbounded(rng, *given), rng)
            if says_much(claim["reached"]):
                break
        return claim | place_bound(rng, claim["reached"], self.brink)

    def violated(self, claim):
        """Whether what reaches most breaks it, in exact numbers."""
        return claim["reached"] is not None and claim["reached"] > claim["bound"]
