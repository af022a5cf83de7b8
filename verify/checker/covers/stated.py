"""Of which states dynamics are stated.

Does: a box all of whose states lie in some piece; which sets may reach beyond it.
Assumes: a system that is well formed.
Does not: move anything.
"""

from __future__ import annotations

from fractions import Fraction

import numpy as np

from codegen.ir import Bool, Float64
from verify.checker.covers.rounding import ceiling, floor
from verify.checker.reading import RejectedError
from verify.checker.systems.cases import has_cases, hull_of
from verify.systems.claims import SystemClaim
from verify.systems.system import Box, System, find_gap


class StatedStates:
    """The states for which a system says how they move, where a claim needs that. RejectedError for gaps in it."""

    def __init__(self, system: System, claim: SystemClaim) -> None:
        self._columns = {one.name: column for column, one in enumerate(system.variables)}
        self._bounds = self._bound_pieces(system) if claim.steps or claim.says.ever else None

    @property
    def limited(self) -> bool:
        """True if there are states of which nothing is stated."""
        return self._bounds is not None

    def _bound_pieces(self, system: System) -> tuple[Float64, Float64] | None:
        """Bounds of a box all of whose states lie in a piece; None where some piece holds all states."""
        wheres = [piece.where for piece in system.pieces]
        if not all(wheres):
            return None
        bounds: dict[str, tuple[Fraction, Fraction]] = {}
        for where in wheres:
            for name, (low, high) in where.items():
                least, most = bounds.get(name, (low, high))
                bounds[name] = min(least, low), max(most, high)
        if has_cases(system):  # cases.py shows that they leave no gap
            bounds = dict(hull_of(system))
        else:
            whole: Box = bounds
            if any(low >= high for low, high in bounds.values()) or find_gap(whole, wheres) is not None:
                raise RejectedError("the pieces leave gaps between them")
        low = np.full(len(self._columns), -np.inf)
        high = np.full(len(self._columns), np.inf)
        for name, (least, most) in bounds.items():
            low[self._columns[name]], high[self._columns[name]] = ceiling(least), floor(most)
        return low, high

    def beyond(self, low: Float64, high: Float64) -> Bool:
        """Returns True for each set, by bounds [n, variables], that may hold states of which nothing is stated, [n]."""
        if self._bounds is None:
            return np.zeros(len(low), dtype=np.bool_)
        least, most = self._bounds
        return np.asarray(~((low >= least) & (high <= most)).all(axis=1), dtype=np.bool_)
