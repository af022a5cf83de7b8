"""What leaves a set that was tried as an invariant: the set of states, and where it goes.

Does: the data of that, and its words.
Assumes: bounds by variable.
Does not: look for it.
"""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction

from verify.checker.reading import RejectedError

Bounds = Mapping[str, tuple[float, float]]


class LeftError(RejectedError):
    """The checker refuses a set that leaves what is allowed. `cell` and `to`: bounds of it, and of where it goes;
    `step`: of an episode, 0 where that is any; `exact`: a state and where it goes, where these were played; `breaks`:
    it may break the claim itself; `begins`: an episode may begin outside.
    """

    def __init__(
        self,
        cell: Bounds,
        to: Bounds,
        step: int = 0,
        exact: tuple[Mapping[str, Fraction], Mapping[str, Fraction]] | None = None,
        breaks: bool = False,
        begins: bool = False,
    ) -> None:
        super().__init__("a set leaves")
        self.cell, self.to, self.step, self.exact = cell, to, step, exact
        self.breaks, self.begins = breaks, begins

    @property
    def words(self) -> str:
        """Where the set may go, or where a state of it does go."""
        if self.breaks:
            return "a state of the cell below may lie outside of the claim's region"
        if self.exact is None:
            ends = ", ".join(f"{name} in [{low:.4g}, {high:.4g}]" for name, (low, high) in self.to.items())
            return f"a state of the cell below may go to {ends}"
        state, after = (", ".join(f"{name} {float(value):.6g}" for name, value in each.items()) for each in self.exact)
        return f"{state} goes to {after}"
