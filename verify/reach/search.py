"""Finds the answers of a proof about a stated system, by linear programs and points that are known to be there.

Does: answers each question of the checker's search, and writes the answers down as a proof.
Assumes: linear programs whose answers are proposals; an emptiness counts once the checker's own arithmetic confirms it.
Does not: decide what to follow, or play counterexamples.

A side of a question that a known point lies on has states, so no program is asked about it. Points are proposals too:
to hold a side open is always sound, it only makes the search longer.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from codegen.ir import Float64
from verify.certificates.proofs import encode_numbers
from verify.checker.systems.rows import Branch, Row
from verify.checker.systems.walk import Answers, SideAnswer
from verify.reach.programs import TOLERANCE, Least, Programs, Used, end_of, find_related, floats, multipliers
from verify.spending import PROGRAM, STATE
from verify.unanswered import SpentError

POINTS = 64
MAX_OVER = 2_000  # programs that one symbolic state may take once its stage has none: most end with fewer
TOLD = 256  # questions from one word about progress to the next
MAX_TRIALS = 3  # of programs, for one row that can hold at its end only
Open = Callable[[Branch, bool], None]
OnProgress = Callable[[int], None]  # the step that is looked at


class ReachBudgetError(SpentError):
    """A prover's allowance is spent, with a symbolic state at hand; `all_spent`: it was the whole budget."""

    def __init__(self, branch: Branch, all_spent: bool = False) -> None:
        super().__init__("all" if all_spent else "what a stage is allowed")
        self.branch, self.all_spent = branch, all_spent


class BranchKnown:
    """The facts known of one branch: points of it, and the least values of directions."""

    def __init__(self, branch: Branch, points: Float64) -> None:
        self.branch = branch
        self.points = points  # [count, unknowns]
        self.rows = len(branch.rows)
        self.box = branch.box
        self.least: dict[tuple[int, bool], Least] = {}


class SystemProver(Answers):
    """The answers of a proof that is being made, with so many symbolic states and linear programs at most. `open_`:
    called with what is left open; `on_progress`: now and then, with the step that is looked at; `left`: of the whole
    budget, in boxes (None: no end).
    """

    def __init__(
        self,
        max_states: int,
        max_programs: int,
        open_: Open,
        on_progress: OnProgress = lambda step: None,
        left: int | None = None,
    ) -> None:
        self.numbers: list[int] = []
        self.programs = Programs()
        self.states = 0
        self._open = open_
        self._max_states, self._max_programs = max_states, max_programs
        self._on_progress, self._left = on_progress, left
        self._random = np.random.default_rng(0)
        self._asked = 0

    @property
    def proof(self) -> bytes:
        """The answers so far."""
        return encode_numbers(self.numbers)

    def visit(self, branch: Branch) -> None:
        """Counts; ReachBudgetError."""
        self._ensure_left(branch)
        if self.states >= self._max_states or self.programs.solved > self._max_programs:
            raise ReachBudgetError(branch)
        self.states += 1
        self._on_progress(branch.step)

    def _ensure_left(self, branch: Branch) -> None:
        """ReachBudgetError where nothing is left of the whole budget."""
        if self._left is not None and STATE * self.states + PROGRAM * self.programs.solved >= self._left:
            raise ReachBudgetError(branch, all_spent=True)

    def hull(self, branch: Branch) -> int | None:
        """None: whoever made this puts symbolic states into hulls."""
        return None

    def asks_fulfilled(self, branch: Branch) -> bool:
        """Always: states that fulfil the claim need not be followed."""
        self.numbers.append(1)
        return True

    def leave_open(self, branch: Branch, stated: bool) -> None:
        """Tells whoever made this."""
        self._open(branch, stated)

    def side(self, branch: Branch, row: Row) -> SideAnswer:
        """Tells which sides have states, and what shows that one has none."""
        self._ensure_left(branch)
        if self.programs.solved > self._max_programs + MAX_OVER:
            raise ReachBudgetError(branch)
        self._asked += 1
        if not self._asked % TOLD:
            self._on_progress(branch.step)
        if not find_related(branch, row.direction):  # then bounds tell all
            self.numbers.append(SideAnswer.BOTH)
            return SideAnswer.BOTH
        known = self._recall_branch(branch)
        this, other = _meets_row(known.points, row), _meets_row(known.points, row.opposite())
        for met, asked, answer in ((this, row, SideAnswer.NOT_THIS), (other, row.opposite(), SideAnswer.ALL_THIS)):
            if not met:
                shown = self._refute_row(branch, known, asked)
                if shown is not None:
                    return self._write_answer(answer, *shown)
                if not self._nonempty(branch, known):
                    empty = multipliers(branch, None, self.programs.middle(branch))
                    if empty is not None:
                        return self._write_answer(SideAnswer.NEITHER, *empty)
        self.numbers.append(SideAnswer.BOTH)
        return SideAnswer.BOTH

    def _nonempty(self, branch: Branch, known: BranchKnown) -> bool:
        return all(least.point is not None for least in known.least.values())

    def _write_answer(self, answer: SideAnswer, times: int, used: Used) -> SideAnswer:
        self.numbers.append(answer)
        if answer != SideAnswer.NEITHER:
            self.numbers.append(times)
        self.numbers.append(len(used))
        before = -1
        for place, factor in sorted(used):
            self.numbers += [place - before - 1, factor]
            before = place
        return answer

    def _refute_row(self, branch: Branch, known: BranchKnown, row: Row) -> tuple[int, Used] | None:
        """Multipliers that show that a row holds nowhere; None where none are found."""
        key = id(row.direction), row.upper
        least = known.least.get(key)
        if least is None:
            least = known.least[key] = self.programs.least(branch, row)
            if least.point is not None:
                known.points = np.vstack([known.points, self._fill_point(branch, known, least.point)])
        left_out: set[int] = set()
        for _ in range(MAX_TRIALS):
            if least.point is None or least.value < end_of(row) - TOLERANCE:
                return None
            shown = multipliers(branch, row, least)
            used = [place for place, dual in zip(least.places, least.duals, strict=True) if dual > TOLERANCE]
            if shown is not None or not used:
                return shown
            # rows that are nearly alike stand in for each other: some by less than a float can tell fall short
            left_out |= set(used)
            least = self.programs.least(branch, row, left_out)
        return None

    def _fill_point(self, branch: Branch, known: BranchKnown, point: dict[int, float]) -> Float64:
        """A point as a row, the other unknowns as in a point that is known."""
        if len(known.points):
            filled = known.points[0].copy()
        else:
            filled = np.full(len(branch.motion.unknowns), 0.5)
            for unknown, value in self.programs.middle(branch).point.items():
                filled[unknown] = value
        for unknown, value in point.items():
            filled[unknown] = value
        return filled[None, :]

    def _recall_branch(self, branch: Branch) -> BranchKnown:
        """Returns the facts known of a branch: at first, those of the branch that it came from."""
        note = branch.note
        if isinstance(note, BranchKnown) and note.branch is branch:
            return note
        points = note.points if isinstance(note, BranchKnown) else np.zeros((0, 0))
        first = note.rows if isinstance(note, BranchKnown) else 0
        box = note.box if isinstance(note, BranchKnown) else None
        points = self._widen_points(points, len(branch.motion.unknowns), isinstance(note, BranchKnown))
        if box is not branch.box:
            for unknown, span in branch.box.items():
                points = points[(points[:, unknown] >= float(span.low)) & (points[:, unknown] <= float(span.high))]
        for row in branch.rows[first:]:
            points = points[_values(points, row) <= end_of(row) + TOLERANCE]
        known = BranchKnown(branch, points[:POINTS])
        branch.note = known
        return known

    def _widen_points(self, points: Float64, unknowns: int, some: bool) -> Float64:
        """Points with as many unknowns as there are now; the new ones anywhere, half of them at a bound."""
        count, more = (len(points) if some else POINTS), unknowns - points.shape[1]
        if more <= 0:
            return points
        fresh = self._random.random((count, more))
        fresh[::2] = np.round(fresh[::2])
        return np.hstack([points.reshape(count, points.shape[1]), fresh])


def _values(points: Float64, row: Row) -> Float64:
    """The sum of a row that is at most its end, at each point."""
    unknowns, weights = floats(row.direction)
    total = points[:, unknowns] @ weights
    return total if row.upper else -total


def _meets_row(points: Float64, row: Row) -> bool:
    """Returns True if some point meets a row clearly."""
    return bool(len(points) and (_values(points, row) < end_of(row) - TOLERANCE).any())
