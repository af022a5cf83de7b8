"""Proves a part of a claim about a stated system step by step, by linear programs and points known to be there.

Does: answers each question of the checker's search, and writes the answers down in the order in which the checker reads
  them; puts symbolic states into hulls where they become too many: polytopes with short numbers, in the directions that
  tests, claims and steps make.
Assumes: linear programs whose answers are proposals; an emptiness counts once the checker's own arithmetic confirms it,
  and the checker asks whether hulls hold.
Does not: decide what to follow or how much to merge (decide.py), or play counterexamples.

A side of a question that a known point lies on has states, so no program is asked about it. Points are proposals too:
to hold a side open is always sound, it only makes the search longer.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from math import ceil, floor, frexp
from typing import NamedTuple

import numpy as np

from codegen.ir import Float64, PolicyProfile
from codegen.numbers import nearest_double
from verify.certificates.proofs import encode_numbers
from verify.checker.systems.branch_proofs import Answers, SideAnswer, SystemQuestions
from verify.checker.systems.proofs import FollowedPart, Hull
from verify.checker.systems.reading import Branch, Choices, Decision, Row, Split, Terms
from verify.claims.formula import Linear, atoms
from verify.reach.programs import TOLERANCE, Least, Programs, Used, end_of, find_related, floats, multipliers
from verify.spending import PROGRAM, STATE, SpentError
from verify.systems.claims import SystemClaim
from verify.systems.system import Affine, HalfSpace, Piece, System

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
                if any(least.point is None for least in known.least.values()):
                    empty = multipliers(branch, None, self.programs.middle(branch))
                    if empty is not None:
                        return self._write_answer(SideAnswer.NEITHER, *empty)
        self.numbers.append(SideAnswer.BOTH)
        return SideAnswer.BOTH

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
            if least.point is not None:  # the other unknowns as in a point that is known
                filled = known.points[0].copy() if len(known.points) else np.full(len(branch.motion.unknowns), 0.5)
                beside = {} if len(known.points) else self.programs.middle(branch).point
                for unknown, value in (beside | least.point).items():
                    filled[unknown] = value
                known.points = np.vstack([known.points, filled[None, :]])
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

    def _recall_branch(self, branch: Branch) -> BranchKnown:
        """Returns the facts known of a branch: at first, those of the branch that it came from."""
        note = branch.note
        if isinstance(note, BranchKnown) and note.branch is branch:
            return note
        points, first, box = np.zeros((POINTS, 0)), 0, None
        if isinstance(note, BranchKnown):
            points, first, box = note.points, note.rows, note.box
        more = len(branch.motion.unknowns) - points.shape[1]
        if more > 0:  # new unknowns lie anywhere, half of them at a bound
            fresh = self._random.random((len(points), more))
            fresh[::2] = np.round(fresh[::2])
            points = np.hstack([points, fresh])
        if box is not branch.box:
            for unknown, span in branch.box.items():
                points = points[(points[:, unknown] >= float(span.low)) & (points[:, unknown] <= float(span.high))]
        for row in branch.rows[first:]:
            points = points[_values(points, row) <= end_of(row) + TOLERANCE]
        known = BranchKnown(branch, points[:POINTS])
        branch.note = known
        return known


def _values(points: Float64, row: Row) -> Float64:
    """The sum of a row that is at most its end, at each point."""
    unknowns, weights = floats(row.direction)
    total = points[:, unknowns] @ weights
    return total if row.upper else -total


def _meets_row(points: Float64, row: Row) -> bool:
    """Returns True if some point meets a row clearly."""
    return bool(len(points) and (_values(points, row) < end_of(row) - TOLERANCE).any())


FINENESS = 12  # bits of a hull's width in which its bounds are given
SHORT = 32  # bits of a number that stays as it is
LEAST = 2.0**-16  # width by which what programs know nearly is widened
NEAR = Fraction(1, 10**9)
PULLED = 2  # steps over which directions are followed back
MAX_EACH = 4  # directions for each variable


class Extent(NamedTuple):
    """Between which numbers a direction lies, and whether these are exact: a program knows them nearly only."""

    low: Fraction
    high: Fraction
    exact: bool


class Hulls:
    """Hulls of symbolic states of one search."""

    def __init__(self, search: SystemQuestions, programs: Programs) -> None:
        self._search, self._programs = search, programs
        self._directions = _directions(search)
        self._stated: dict[str, list[Fraction]] = {}  # bounds of a variable by boxes of pieces
        for piece in search.system.pieces:
            for name, bounds in piece.where.items():
                self._stated.setdefault(name, []).extend(bounds)

    def group_branches(self, branches: Sequence[Branch], parts: int) -> list[list[int]]:
        """The numbers of branches that one hull is to hold: those that decide alike, each such group in `parts`."""
        search, cells = self._search, dict[object, list[int]]()
        centers: list[dict[str, Fraction]] = []
        for number, branch in enumerate(branches):
            center: dict[str, Fraction] = {}
            for name in search.reading.order:
                low, high, _ = self._extent(branch, ((Fraction(1), name),))
                center[name] = (low + high) / 2
            centers.append(center)
            # what is decided in the middle, its modes, and the pieces that may move it
            effects = [_at(decision, center) for decision in search.decisions]
            modes = [center[one.name] for one in search.system.variables if one.modes and one.name in center]
            pieces = [place for place, piece in enumerate(search.system.pieces) if _holds(piece, center)]
            cells.setdefault((*effects, *modes, *pieces), []).append(number)
        return [group for cell in cells.values() for group in _split(cell, centers, parts)]

    def hull(self, branches: Sequence[Branch]) -> Hull:
        """A polytope that holds some branches of one step."""
        halves: list[HalfSpace] = []
        for terms in self._directions:
            extents = [self._extent(branch, terms) for branch in branches]
            low, high = min(each.low for each in extents), max(each.high for each in extents)
            form = Affine.of({name: weight for weight, name in terms})
            low, high = self._bounds(form, low, high, all(each.exact for each in extents))
            halves += [
                HalfSpace(Affine.of({name: -weight for name, weight in form.terms}, low)),
                HalfSpace(Affine.of(dict(form.terms), -high)),
            ]
        return Hull(branches[0].step, tuple(halves))

    def _bounds(self, form: Affine, low: Fraction, high: Fraction, exact: bool) -> tuple[Fraction, Fraction]:
        """Short bounds of a direction: as they are, or where the system has a bound, or a little outside."""
        wide = low, high
        if low < high or not exact:  # a little outside, as multiples of a power of two
            grid = Fraction(2) ** (frexp(max(nearest_double(high - low), LEAST))[1] - FINENESS)
            wide = floor(low / grid - Fraction(1, 8)) * grid, ceil(high / grid + Fraction(1, 8)) * grid
        stated = self._stated.get(form.terms[0][0], ()) if len(form.terms) == 1 else ()
        below = [each for each in stated if wide[0] < each <= low + NEAR]
        above = [each for each in stated if high - NEAR <= each < wide[1]]
        return (
            low if exact and _is_short(low) else max(below, default=wide[0]),
            high if exact and _is_short(high) else min(above, default=wide[1]),
        )

    def _extent(self, branch: Branch, terms: Terms) -> Extent:
        reading = self._search.reading
        direction, scale = reading.direction(branch.motion, reading.sum(terms))
        constant = sum((weight * branch.at[name] for weight, name in terms), Fraction(0))
        if direction is None:
            return Extent(constant, constant, True)
        if not find_related(branch, direction):
            span = branch.span(direction)
            ends = scale * span.low, scale * span.high
            return Extent(constant + min(ends), constant + max(ends), True)
        least = self._programs.least(branch, Row(direction, True, Fraction(0), False)).value
        most = -self._programs.least(branch, Row(direction, False, Fraction(0), False)).value
        factor = scale * (1 << direction.bits)
        ends = factor * Fraction(least), factor * Fraction(most)
        return Extent(constant + min(ends), constant + max(ends), False)


def _at(decision: Decision, state: dict[str, Fraction]) -> Choices:
    """The effects of which each may be chosen in a state."""
    while isinstance(decision, Split):
        asked = decision.left_if
        total = sum((weight * state[name] for weight, name in asked.sum.terms), Fraction(0))
        left = total < asked.most or (total == asked.most and not asked.strict)
        decision = decision.left if left else decision.right
    return decision


def _holds(piece: Piece, state: dict[str, Fraction]) -> bool:
    known = [half for half in piece.when if all(name in state for name, _ in half.form.terms)]
    inside = all(low <= state[name] <= high for name, (low, high) in piece.where.items() if name in state)
    return inside and all(half.holds(state) for half in known)


def _split(group: list[int], centers: Sequence[dict[str, Fraction]], parts: int) -> list[list[int]]:
    """A group in parts of equal size, along the variable that varies most."""
    if parts <= 1 or len(group) <= 1:
        return [group]

    def varies(name: str) -> Fraction:
        values = [centers[number][name] for number in group]
        return max(values) - min(values)

    along = max(centers[group[0]], key=varies)
    ordered, half = sorted(group, key=lambda number: centers[number][along]), len(group) // 2
    return _split(ordered[:half], centers, parts // 2) + _split(ordered[half:], centers, parts // 2)


def _is_short(number: Fraction) -> bool:
    return number.denominator.bit_length() + number.numerator.bit_length() <= SHORT


def _directions(search: SystemQuestions) -> list[Terms]:
    """Each variable alone, then the sums of tests and of the claim, then what these were some steps before."""
    reading, system = search.reading, search.system
    known = [feature.form for features in system.features.values() for feature in features.values()]
    known += [
        Affine.of({name: w for w, name in one.terms}) for one in atoms(search.claim.inside) if isinstance(one, Linear)
    ]
    sums = [form for form in known if len(form.terms) > 1 and all(name in reading.order for name, _ in form.terms)]
    directions = {_primitive(Affine.of({name: Fraction(1)})): None for name in reading.order}
    directions |= {_primitive(form): None for form in sums}
    level = list(directions)
    for _ in range(PULLED):
        before: list[Affine] = []
        for terms in level:
            for piece in system.pieces:
                total = Affine()
                for weight, name in terms:
                    total = total.plus(piece.move.get(name, Affine()), weight)
                before.append(total)
        level = [_primitive(form) for form in before if form.terms]
        for terms in level:
            if len(directions) < MAX_EACH * len(reading.order):
                directions[terms] = None
    return list(directions)


def _primitive(form: Affine) -> Terms:
    """The sum without its constant, its first weight 1."""
    lead = form.terms[0][1]
    return tuple((factor / lead, name) for name, factor in form.terms)


class Merging(NamedTuple):
    """When symbolic states of a step are put into hulls: once there are more than `limit`; and into how many."""

    limit: int
    parts: int  # for each group that decides alike


@dataclass
class _Node:
    """A symbolic state with the answers that are given about it, and those that follow from it."""

    branch: Branch
    numbers: list[int] = field(default_factory=list[int])
    following: list[_Node] = field(default_factory=list["_Node"])
    hull: int | None = None


class Unfolding:
    """A proof of a part, as it is being made."""

    def __init__(
        self, profile: PolicyProfile, system: System, claim: SystemClaim, part: FollowedPart, prover: SystemProver
    ) -> None:
        self._search = SystemQuestions(profile, system, claim, part, prover)
        self._part, self._prover = part, prover
        self._hulls = Hulls(self._search, prover.programs)
        self._made: list[Hull] = []

    def run(self, merging: Merging | None) -> FollowedPart:
        """The part with its proof. BudgetError, or what the prover's `open_` raises."""
        roots = [_Node(branch) for branch in self._search.roots()]
        level = roots
        while level:
            for node in level:
                self._prover.numbers = node.numbers
                self._prover.visit(node.branch)
                node.following = [_Node(branch) for branch in self._search.follow_branch(node.branch)]
            level = [after for node in level for after in node.following]
            if merging is not None and len(level) > merging.limit:
                level = self._merge_level(level, merging.parts)
                roots += level
        # the answers about a symbolic state and all that follow from it, in the order of the checker's search
        numbers = list[int]()
        for root in roots:
            pending = [root]
            while pending:
                node = pending.pop()
                if self._made and node is not root:
                    numbers.append(0 if node.hull is None else node.hull + 1)
                numbers += node.numbers
                pending += reversed(node.following)
        return FollowedPart(self._part.followed, self._part.shows, tuple(self._made), encode_numbers(numbers))

    def _merge_level(self, level: list[_Node], parts: int) -> list[_Node]:
        """Hulls that hold all symbolic states of a step, as symbolic states."""
        roots: list[_Node] = []
        for group in self._hulls.group_branches([node.branch for node in level], parts):
            number = len(self._made)
            self._made.append(self._hulls.hull([level[place].branch for place in group]))
            self._search.hulls = tuple(self._made)
            for place in group:
                node = level[place]
                node.hull, self._prover.numbers = number, node.numbers
                self._search.ensure_within(node.branch, number)
            root = self._search.root(self._made[-1])
            assert root is not None, "a hull that holds a symbolic state is not empty"
            roots.append(_Node(root))
        return roots
