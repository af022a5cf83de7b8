"""What a claim without curves has to do with one that has some.

Does: the data.
Assumes: whoever makes it knows that it is so (formulas.py), or shows it (verify/checker/systems/enclosures.py).
Does not: decide.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from verify.systems.claims import SystemClaim
from verify.systems.language.expressions import Expression
from verify.systems.system import Affine, Box, Interval


class CurveOverCell(NamedTuple):
    """That an expression is a form over a box, with an error within bounds."""

    curve: Expression
    cell: Box
    form: Affine
    error: Interval


@dataclass(frozen=True)
class CurvedClaim:
    """What a claim has to do with one whose formula has curves, `written` in a file: it implies that one, which implies
    `weaker`, since `enclosures` hold, over cells that fill the ranges of what they name.
    """

    weaker: SystemClaim
    enclosures: tuple[CurveOverCell, ...]
