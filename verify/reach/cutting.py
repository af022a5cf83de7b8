"""Parts of a start or of a region, cut in half again and again.

Does: the tree of cuts, and its numbers in the order in which the checker reads them.
Assumes: boxes as the checker has them, whose own rule cuts them.
Does not: choose what is cut.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

from verify.checker.covers.parts import StartBox, halves


@dataclass
class CutPart:
    """A part, with its two halves once it is cut."""

    box: StartBox
    depth: int = 0
    column: int = -1
    halves: list[CutPart] = field(default_factory=list["CutPart"])

    def cut(self, column: int) -> list[CutPart]:
        """Its halves."""
        self.column = column
        self.halves = [CutPart(half, self.depth + 1) for half in halves(self.box, column)]
        return self.halves

    def cuts(self) -> Iterator[int]:
        """All cuts in it, in the order in which the checker reads them."""
        pending: list[CutPart] = [self]
        while pending:
            part = pending.pop()
            yield part.column + 1
            pending += reversed(part.halves)
