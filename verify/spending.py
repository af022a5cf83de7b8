"""What a search may spend, whatever it tries: one budget, counted in boxes.

Does: adds up boxes, symbolic states, linear programs and steps of play; says what is left, and tells progress.
Assumes: costs that do not depend on the machine.
Does not: measure time.

A box takes about a microsecond. All else counts as the boxes that take as long, measured on small systems. So one limit
says when a search stops, whatever it was trying, and how far it is.
"""

from __future__ import annotations

from dataclasses import dataclass

from codegen.wording import format_count
from verify.progress import tell
from verify.unanswered import SpentError

OPTION = "--max-boxes"
FORM, STATE, PROGRAM = 10, 100, 400  # boxes that an affine form, a symbolic state and a linear program take as long as


class BudgetSpentError(SpentError):
    """The whole budget is spent."""


@dataclass
class Spending:
    """The amount spent so far, of at most so many boxes."""

    most: int
    boxes: int = 0
    played: int = 0  # states of random episodes; each counts as a box
    states: int = 0  # symbolic ones
    programs: int = 0

    @property
    def total(self) -> int:
        """All of it, in boxes."""
        return self.boxes + self.played + STATE * self.states + PROGRAM * self.programs

    @property
    def left(self) -> int:
        """The boxes that may still be spent."""
        return max(self.most - self.total, 0)

    def ensure_left(self, boxes: int = 1) -> None:
        """BudgetSpentError where less than that is left."""
        if self.left < boxes:
            raise BudgetSpentError(OPTION)

    def take(self, boxes: int) -> None:
        """Adds boxes, and tells how far the search is."""
        self.boxes += boxes
        self.tell()

    def tell(self, words: str = "") -> None:
        """Tells how far the search is, in boxes of the budget."""
        tell(min(self.total, self.most), self.most, f"boxes of the budget{words}")

    @property
    def words(self) -> str:
        """Words for what was spent on what, as reports say it."""
        kinds = (
            (self.boxes, "box"),
            (self.played, "played state"),
            (self.states, "symbolic state"),
            (self.programs, "linear program"),
        )
        some = [format_count(*kind) for kind in kinds if kind[0]] or [format_count(0, "box")]
        return some[0] if len(some) == 1 else f"{', '.join(some[:-1])} and {some[-1]}"
