"""How much of a region's starts surely fail, and surely hold: the cells of whole episodes, measured exactly.

Does: follows agents from all starts of a region at once, in cells that have no point in common, and adds up the volumes
  of those in which every start fails, or holds, whatever is rounded.
Assumes: questions and limits of answers (guaranteed.py).
Does not: follow starts nearer to an edge than roundings reach, or go on beyond its budgets: such starts are in neither
  sum.

A cell is as in episodes/proof.py: for each axis a closed matrix of exact bounds. Each answer to a test that has moved
is allowed SLACK less than it says, where proofs allow it SLACK more: the deployed arithmetic gives it for sure. Answers
so narrowed exclude one another, hence so do the cells. Cells without volume are dropped.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import NamedTuple, TypeAlias

from verify.checker.episodes.reading import (
    ARRIVED,
    CLAIM,
    Gap,
    Node,
    Now,
    Place,
    Side,
)
from verify.checker.reading import LONGEST
from verify.episodes.proof import find_used_nodes
from verify.episodes.zones import MAX_STARTS
from verify.extent.guaranteed import GuaranteedEpisode
from verify.progress import tell
from verify.unanswered import BeyondError
from verify.zones.volume import FacesError, Volumes

Matrix: TypeAlias = list[list[int]]
Cell: TypeAlias = tuple[Matrix, Matrix]
ANSWERS, FACES = "answers", "faces"
FLAT = "the region has no volume"
Answers: TypeAlias = "int | list[tuple[Side, Answers]] | None"  # one for all, the sides that are possible, or none


def _sides(node: tuple[Side, ...] | Gap) -> tuple[Side, ...]:
    """The answers of a question; nobody is asked how far apart the starts of two are where none can push another."""
    assert not isinstance(node, Gap), node
    return node


def _answers(answers: Answers) -> set[int]:
    """All answers below a question."""
    if answers is None or isinstance(answers, int):
        return set() if answers is None else {answers}
    return set[int]().union(*(_answers(below) for _, below in answers))


@dataclass(frozen=True)
class Measured:
    """Shares of the starts, by volume; what is in neither is not known."""

    fails: Fraction
    holds: Fraction
    looked: int  # answers
    spent: str = ""  # the budget that ended: of ANSWERS, of FACES


class NoShareError(BeyondError):
    """Why a region's starts have no shares."""


class _SpentError(Exception):
    """The budget of answers has ended."""


class _Pending(NamedTuple):
    """A cell on its way: in which pass, and at which question."""

    cell: Cell
    number: int
    place: Place


class Following:
    """Agents followed in passes, one after the other: who fails in one pass fails, who holds in all of them holds."""

    def __init__(self, passes: Sequence[GuaranteedEpisode], limit: int, faces: int) -> None:
        """`limit`: of answers looked at; `faces`: as of `Volumes`. NoShareError for a region in too many parts."""
        self._passes, self._limit, self.looked, self._volumes = passes, limit, 0, Volumes(faces)
        assert len({one.unit for one in passes}) == 1
        names, nodes = (
            passes[0].names,
            sorted(set[int]().union(*(find_used_nodes(one.region, one.questions, one.nodes) for one in passes))),
        )
        own = [[0, *(node for node in nodes if names[node].endswith(axis))] for axis in (".x", ".y")]
        self._at = {node: (axis, place) for axis, nodes in enumerate(own) for place, node in enumerate(nodes)}
        self._known: dict[tuple[int, ...], int] = {}
        self._fixed = [[[True] * len(nodes) for _ in nodes] for nodes in own]  # pairs at a constant distance
        self._starts = self._split_starts([len(nodes) for nodes in own])
        # the nodes that are at no constant distance from one before them
        self._free = [[p for p, row in enumerate(fixed) if not any(row[:p])] for fixed in self._fixed]

    def measure_shares(self) -> Measured:
        """The shares of the region's starts. NoShareError for a region without volume."""
        sums, whole, spent = [0, 0], 0, ""
        try:
            whole = sum(map(self._volume, self._starts))
            if not whole:
                raise NoShareError(FLAT)
            for answer, cell in self._ends():
                sums[answer] += self._volume(cell)
        except _SpentError:
            spent = ANSWERS
        except FacesError:
            spent = FACES
        fails, holds = (Fraction(part, whole or 1) for part in sums)
        assert fails + holds <= 1, "cells have points in common"
        return Measured(fails, holds, self.looked, spent)

    def _split_starts(self, sizes: Sequence[int]) -> list[Cell]:
        """The starts of the region as cells that have no point in common."""
        episode = self._passes[0]
        first, second = ([[0 if p == q else episode.far for q in range(n)] for p in range(n)] for n in sizes)
        cells, node = list[Cell]([(first, second)]), episode.region
        while not isinstance(node, int) and len(sides := _sides(node)) == 1:  # bounds come before choices
            cells = [cut for cell in cells for cut in self._parts(cell, sides)]
            node = sides[0].child
        if cells:
            self._fixed = [[[a + b == 0 for a, b in zip(row, column, strict=True)]
                            for row, column in zip(matrix, zip(*matrix, strict=True), strict=True)]
                           for matrix in cells[0]]  # fmt: skip
        while not isinstance(node, int):
            sides = _sides(node)
            cells = [cut for cell in cells for cut in self._parts(cell, sides)]
            node = sides[0].child
            if len(cells) > MAX_STARTS:
                raise NoShareError(f"the region falls into more than {MAX_STARTS} parts")
        return cells

    def _parts(self, cell: Cell, node: Sequence[Side]) -> Iterator[Cell]:
        """The parts of a cell that the choices of a region leave: of each what none of the earlier ones has."""
        left: Cell | None = cell
        for side in node:
            upper, lower, most, _ = self._passes[0].limits(side, self._passes[0].start)
            part = left and self._cut(left, upper, lower, most)
            if part is not None:
                yield part
            left = left and self._cut(left, lower, upper, -most - 1)

    def _ends(self) -> Iterator[tuple[int, Cell]]:
        """The cells in which every start fails (AWAY), or holds (ARRIVED)."""
        work = [_Pending(cell, 0, self._passes[0].first()) for cell in self._starts]
        while work:
            tell(self.looked, self._limit, "answers looked at for the share of starts that fail")
            if self.looked > self._limit:
                raise _SpentError
            cell, number, (stage, node, chosen, now) = work.pop()
            episode = self._passes[number]
            for part, answer in self._iterate_answers(cell, self._look(cell, node, now, episode), now, episode):
                ended = stage == CLAIM and (answer == ARRIVED or now.step == episode.steps)
                if not ended:
                    work.append(_Pending(part, number, episode.onward(stage, answer, chosen, now)))
                elif answer == ARRIVED and number + 1 < len(self._passes):
                    work.append(_Pending(part, number + 1, self._passes[number + 1].first()))
                else:
                    yield answer, part

    def _look(self, cell: Cell, node: Node, now: Now, episode: GuaranteedEpisode) -> Answers:
        """The answers below a question that are possible for some start, whatever is rounded. One for all stands for
        the question only where its sides leave out no start: a side alone is one of several bounds, as of x = 0.
        """
        if isinstance(node, int):
            return node
        branches: list[tuple[Side, Answers]] = []
        sides = _sides(node)
        for side in sides:
            upper, lower, most, room = episode.limits(side, now)
            cut = self._cut(cell, upper, lower, most + room)
            below = None if cut is None else self._look(cut, side.child, now, episode)
            if below is not None:
                branches.append((side, below))
        answers = _answers(branches)
        return answers.pop() if len(answers) == 1 < len(sides) else branches or None

    def _iterate_answers(
        self, cell: Cell, answers: Answers, now: Now, episode: GuaranteedEpisode
    ) -> Iterator[tuple[Cell, int]]:
        """The parts of a cell that give one answer for sure."""
        if isinstance(answers, int):
            yield cell, answers
            return
        for side, below in answers or ():
            upper, lower, most, room = episode.limits(side, now)
            cut = self._cut(cell, upper, lower, most - room)
            if cut is not None:
                yield from self._iterate_answers(cut, below, now, episode)

    def _cut(self, cell: Cell, upper: int, lower: int, most: int) -> Cell | None:
        """The part of a cell with upper - lower <= most; None where that has no volume. Coordinates that no question
        speaks of bound nothing.
        """
        self.looked += 1
        if upper == lower:
            return cell if most >= 0 else None
        if (upper and upper not in self._at) or (lower and lower not in self._at):
            return cell
        axis = self._at[upper or lower][0]
        p, q = self._at[upper][1], self._at[lower][1]
        matrix = cell[axis]
        if most >= matrix[p][q]:
            return cell
        thickness = most + matrix[q][p]
        if thickness < 0 or (not thickness and not self._fixed[axis][p][q]):
            return None
        onward = [most + far for far in matrix[q]]
        cut = [
            row if row[p] + most >= row[q] else [min(a, row[p] + b) for a, b in zip(row, onward, strict=True)]
            for row in matrix
        ]
        return (cut, cell[1]) if axis == 0 else (cell[0], cut)

    def _volume(self, cell: Cell) -> int:
        """The volume in the coordinates that are not fixed, times a constant."""
        total = 1
        for matrix, free in zip(cell, self._free, strict=True):
            # without strictness, as bounds are LONGEST apart
            cells = tuple(-(-matrix[p][q] // LONGEST) for p in free for q in free)
            if cells not in self._known:
                self._known[cells] = self._volumes.measure(cells, len(free))
            total *= self._known[cells]
        return total
