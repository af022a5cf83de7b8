"""Linear programs about a symbolic state: which rows contradict each other, and exact points of it.

Does: the least value of a direction with the rows that hold it there; whole-number multipliers that show the same
  exactly; a point in the middle, and exact starts and errors near it.
Assumes: HiGHS, whose floating-point answers are proposals only. It prints its banner at most once per process, when the
  first solver is made (from 1.16 on); standard output belongs to results.
Does not: decide. What it proposes is checked by `Branch.is_contradicted`, or replayed.
"""

from __future__ import annotations

import os
from collections.abc import Collection, Generator, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from math import lcm

import highspy
import numpy as np

from codegen.ir import Float64, Int32, PolicyProfile
from verify.certificates.systems import certify
from verify.checker.accept import accept
from verify.checker.systems.proofs import SystemProof
from verify.checker.systems.reading import UNIT, Branch, Direction, Row, SystemReading
from verify.reach.replay import Course, is_start
from verify.reach.results import ReachOutcome, about_nothing
from verify.result import Verdict
from verify.systems.claims import SystemClaim
from verify.systems.system import System

STDOUT = 1


def solver() -> highspy.Highs:
    """A solver that prints nothing, on one thread, with a seed."""
    made = highspy.Highs()
    made.silent()
    for option, value in (("presolve", "off"), ("threads", 1), ("random_seed", 0)):
        made.setOptionValue(option, value)
    return made


@contextmanager
def _without_stdout() -> Generator[None]:
    """Sends what the process writes to its standard output nowhere, Python's own buffered text aside."""
    try:
        before = os.dup(STDOUT)
    except OSError:  # there is none
        yield
        return
    nowhere = os.open(os.devnull, os.O_WRONLY)
    try:
        os.dup2(nowhere, STDOUT)
        yield
    finally:
        os.dup2(before, STDOUT)
        os.close(before)
        os.close(nowhere)


with _without_stdout():  # no option is read before the banner; an import happens once, whatever the threads
    highspy.Highs()


TOLERANCE = 1e-9
SCALES = (1, 2, 3, 5, 12, *(1 << power for power in (5, 8, 11, 16, 24, 44)))
Equation = tuple[Mapping[int, Fraction], Fraction]  # weights of unknowns, and the value of the sum
Used = list[tuple[int, int]]  # (place of a row on its branch, multiplier)


@dataclass(frozen=True)
class Least:
    """The least value of a row's sum on the rows of a branch, per 2**bits; `point` is None where they contradict."""

    value: float
    places: Sequence[int]
    duals: Float64  # of these rows
    point: dict[int, float] | None


@dataclass(frozen=True)
class Middle:
    """A point of a branch, and how far it is from the ends of rows, as a share of their widths; below 0: no point."""

    slack: float
    point: dict[int, float]
    places: Sequence[int]
    duals: Float64  # of these rows


class Programs:
    """One solver, which is given one small program after the other."""

    def __init__(self) -> None:
        self.solved = 0
        self._solver = solver()

    def least(self, branch: Branch, row: Row, without: Collection[int] = ()) -> Least:
        """The least value of the sum that a row bounds from above; `without`: rows of the branch that are left out."""
        places = [place for place in find_related(branch, row.direction) if place not in without]
        unknowns = _unknowns([branch.rows[place].direction for place in places] + [row.direction])
        cost = _dense(row, _columns(unknowns))
        matrix, most = _table([branch.rows[place] for place in places], unknowns)
        low, high = _box(branch, unknowns)
        point, duals, value = self._solve(cost, matrix, most, low, high)
        return Least(value, places, duals, None if point is None else dict(zip(unknowns, point.tolist(), strict=True)))

    def middle(self, branch: Branch) -> Middle:
        """A point of a branch as far from all its rows and open bounds as can be."""
        places = _tightest(branch, range(len(branch.rows)))
        rows = [branch.rows[place] for place in places]
        unknowns = sorted({*_unknowns([row.direction for row in rows]), *branch.box})
        low, high = _box(branch, unknowns)
        matrix, most = _table(rows, unknowns)
        ends, width = _open_ends(branch, unknowns)
        table = np.vstack([matrix, ends])
        sizes = np.concatenate([np.abs(matrix).sum(axis=1) / 2, np.abs(ends) @ (high - low) / 2])
        cost = np.zeros(len(unknowns) + 1)
        cost[-1] = -1
        point, duals, value = self._solve(
            cost,
            np.hstack([table, sizes[:, None]]),
            np.concatenate([most, width]),
            np.append(low, -highspy.kHighsInf),
            np.append(high, 1.0),
        )
        if point is None:
            return Middle(0.0, {}, places, np.zeros(len(places)))
        return Middle(-value, dict(zip(unknowns, point[:-1].tolist(), strict=True)), places, duals[: len(places)])

    def _solve(
        self, cost: Float64, matrix: Float64, most: Float64, low: Float64, high: Float64
    ) -> tuple[Float64 | None, Float64, float]:
        """Least cost for matrix x <= most, low <= x <= high: (x, or None without one; multipliers; cost)."""
        self.solved += 1
        solver, columns = self._solver, np.arange(len(cost), dtype=np.int32)
        solver.clearModel()
        solver.addVars(len(cost), low, high)
        solver.changeColsCost(len(cost), columns, cost)
        rows, filled = np.nonzero(matrix)
        starts = np.searchsorted(rows, np.arange(len(most))).astype(np.int32)
        below = np.full(len(most), -highspy.kHighsInf)
        solver.addRows(len(most), below, most, len(rows), starts, filled.astype(np.int32), matrix[rows, filled])
        solver.run()
        status = solver.getModelStatus()
        solution = solver.getSolution()
        if status != highspy.HighsModelStatus.kOptimal:
            return None, np.zeros(len(most)), 0.0
        return np.array(solution.col_value), -np.array(solution.row_dual), float(solver.getObjectiveValue())


def multipliers(branch: Branch, aside: Row | None, solved: Least | Middle) -> tuple[int, Used] | None:
    """(times of a row beside the branch, 0 without one; multipliers of its own rows) that show exactly that no state of
    the branch meets them all: the duals as small whole numbers, or the exact solution of the equations that they solve.
    """
    used = [(place, dual) for place, dual in zip(solved.places, solved.duals.tolist(), strict=True) if dual > TOLERANCE]
    if aside is None:
        top = max((dual for _, dual in used), default=1.0)
        used = [(place, dual / top) for place, dual in used]
    for scale in SCALES:
        shown = _check_multipliers(branch, aside, scale, [(place, round(dual * scale)) for place, dual in used])
        if shown is not None:
            return shown

    # multipliers with which rows cancel in all unknowns that the point has within their bounds
    rows = ([] if aside is None else [aside]) + [branch.rows[place] for place, _ in used]
    inner = list[int]()
    for unknown, value in (solved.point or {}).items():
        span = branch.box.get(unknown, UNIT)
        if float(span.low) + TOLERANCE < value < float(span.high) - TOLERANCE:
            inner.append(unknown)
    weights = [dict(row.direction.weights) for row in rows]
    scales = [Fraction(1 if row.upper else -1, 1 << row.direction.bits) for row in rows]
    equations = [
        [each.get(unknown, 0) * scale for each, scale in zip(weights, scales, strict=True)] for unknown in inner
    ]
    solution = kernel(equations, len(rows))
    if solution is None:
        return None
    common = lcm(*(number.denominator for number in solution))
    whole = [int(number * common) for number in solution]
    if min(whole) < 0:
        return None
    times, factors = (whole[0], whole[1:]) if aside is not None else (0, whole)
    places = [place for place, _ in used]
    return _check_multipliers(branch, aside, times, list(zip(places, factors, strict=True)))


def _check_multipliers(branch: Branch, aside: Row | None, scale: int, used: Used) -> tuple[int, Used] | None:
    used = [(place, times) for place, times in used if times > 0]
    beside = [] if aside is None else [(aside, scale)]
    if branch.is_contradicted([*beside, *((branch.rows[place], times) for place, times in used)]):
        return (0 if aside is None else scale), used
    return None


def kernel(equations: Sequence[Sequence[Fraction]], count: int) -> list[Fraction] | None:
    """The solution of homogeneous equations in `count` numbers whose first number that is not 0 is 1; None where there
    is no such solution but 0, or more than one.
    """
    asked = [({at: number for at, number in enumerate(each) if number}, Fraction(0)) for each in equations]
    solved = _eliminate(asked)
    if solved is None or len(solved) != count - 1:
        return None
    solution = _put_back(solved, dict.fromkeys(range(count), Fraction(1)))
    first = next(number for _, number in sorted(solution.items()) if number)
    return [solution[at] / first for at in range(count)]


def solve_equations(equations: Sequence[Equation], near: Mapping[int, Fraction]) -> dict[int, Fraction] | None:
    """Exact values of unknowns, close to those given, with which each sum has its value; None where there are none."""
    solved = _eliminate(equations)
    return None if solved is None else _put_back(solved, near)


def _eliminate(equations: Sequence[Equation]) -> list[tuple[int, Equation]] | None:
    """Equations that mean the same, none of which names the unknowns that those before it are about; None where they
    contradict.
    """
    rows, solved = list(equations), list[tuple[int, Equation]]()
    while rows:
        weights, value = rows.pop()
        if not weights:
            if value:
                return None
            continue
        pivot, lead = max(weights.items(), key=lambda one: abs(one[1]))
        weights, value = {unknown: weight / lead for unknown, weight in weights.items()}, value / lead
        solved.append((pivot, (weights, value)))
        rows = [_without(row, pivot, weights, value) for row in rows]
    return solved


def _put_back(solved: Sequence[tuple[int, Equation]], near: Mapping[int, Fraction]) -> dict[int, Fraction]:
    """The values that eliminated unknowns have where all others have those given."""
    values = dict(near)
    for pivot, (weights, value) in reversed(solved):
        values[pivot] = value - sum(
            (weight * values[other] for other, weight in weights.items() if other != pivot), Fraction(0)
        )
    return values


def _without(row: Equation, pivot: int, weights: Mapping[int, Fraction], value: Fraction) -> Equation:
    """An equation from which a multiple of another one is taken, so that the pivot goes."""
    times, left = row[0].get(pivot, Fraction(0)), dict(row[0])
    for name, weight in weights.items() if times else ():
        left[name] = left.get(name, Fraction(0)) - times * weight
    return {name: weight for name, weight in left.items() if weight}, row[1] - times * value


def gap(row: Row, point: Mapping[int, float]) -> float:
    """Returns how far a point is from the end of a row, per 2**bits."""
    unknowns, weights = floats(row.direction)
    total = sum(weight * point[unknown] for unknown, weight in zip(unknowns.tolist(), weights.tolist(), strict=True))
    return total - scale_number(row.end, row.direction)


def find_related(branch: Branch, direction: Direction) -> list[int]:
    """The rows of a branch that may bound a direction: those that share unknowns with it, or with such rows."""
    mask, left, places = direction.mask, list(range(len(branch.rows))), list[int]()
    while True:
        near = [place for place in left if branch.rows[place].direction.mask & mask]
        if not near:
            return _tightest(branch, sorted(places))
        places += near
        for place in near:
            mask |= branch.rows[place].direction.mask
        left = [place for place in left if place not in near]


def _tightest(branch: Branch, places: Sequence[int]) -> list[int]:
    """The places without rows that another one of the same direction implies."""
    best: dict[tuple[int, bool], int] = {}
    for place in places:
        row = branch.rows[place]
        key = id(row.direction), row.upper
        if key in best:
            before = branch.rows[best[key]]
            closer = (before.end < row.end) == row.upper
            if closer if before.end != row.end else before.strict or not row.strict:
                continue
        best[key] = place
    return sorted(best.values())


def _open_ends(branch: Branch, unknowns: Sequence[int]) -> tuple[Float64, Float64]:
    """The open bounds of unknowns as rows."""
    rows, ends = list[Float64](), list[float]()
    for place, unknown in enumerate(unknowns):
        span = branch.box.get(unknown, UNIT)
        for is_open, sign, end in ((span.low_open, -1.0, span.low), (span.high_open, 1.0, span.high)):
            if is_open:
                rows.append(sign * np.eye(len(unknowns))[place])
                ends.append(sign * float(end))
    return np.array(rows).reshape(len(rows), len(unknowns)), np.array(ends)


def _unknowns(directions: Sequence[Direction]) -> list[int]:
    return sorted({unknown for direction in directions for unknown, _ in direction.weights})


@lru_cache(maxsize=1 << 14)
def floats(direction: Direction) -> tuple[Int32, Float64]:
    """(the unknowns of a direction, its multiples per 2**bits)."""
    unknowns = np.array([unknown for unknown, _ in direction.weights], dtype=np.int32)
    return unknowns, np.array([scale_number(weight, direction) for _, weight in direction.weights])


def _dense(row: Row, columns: Int32) -> Float64:
    """The weights of a row that is at most its end, per 2**bits. `columns`: the column of each unknown."""
    unknowns, weights = floats(row.direction)
    dense = np.zeros(int(columns.max(initial=-1)) + 1)
    dense[columns[unknowns]] = weights
    return dense if row.upper else -dense


def _columns(unknowns: Sequence[int]) -> Int32:
    """The place of each unknown, [largest unknown + 1]; -1 for those that are not among them."""
    places = np.full(max(unknowns, default=-1) + 1, -1, dtype=np.int32)
    places[unknowns] = np.arange(len(unknowns), dtype=np.int32)
    return places


def scale_number(number: int | Fraction, direction: Direction) -> float:
    """A number per 2**bits of a direction, as a float."""
    return number.numerator / (number.denominator << direction.bits)


def end_of(row: Row) -> float:
    """The end of a row that is at most it, per 2**bits."""
    return scale_number(row.end if row.upper else -row.end, row.direction)


def _table(rows: Sequence[Row], unknowns: Sequence[int]) -> tuple[Float64, Float64]:
    columns = _columns(unknowns)
    weights = np.array([_dense(row, columns) for row in rows]).reshape(len(rows), len(unknowns))
    return weights, np.array([end_of(row) for row in rows])


def _box(branch: Branch, unknowns: Sequence[int]) -> tuple[Float64, Float64]:
    spans = [branch.box.get(unknown, UNIT) for unknown in unknowns]
    return np.array([float(span.low) for span in spans]), np.array([float(span.high) for span in spans])


BITS = (4, 8, 14, 24, 40)  # of rounded starts
NEAR = 1e-7
Exactly = Mapping[int, Fraction]  # by unknown


def witnesses(system: System, branch: Branch, start: Branch) -> Iterator[Course]:
    """Courses to a branch, those with short numbers first. `start`: the symbolic state that it came from."""
    middle = Programs().middle(branch)
    for bits in BITS:
        yield _course(system, branch, start, _round_point(branch, middle.point, bits), bits)
    near = _round_point(branch, middle.point, BITS[-1])
    rows = [row for row in branch.rows if abs(gap(row, middle.point)) < NEAR]
    equations = [({at: Fraction(weight) for at, weight in row.direction.weights}, row.end) for row in rows]
    on_rows = solve_equations(equations, near)  # it meets the rows next to which the middle lies, where these have one
    within, corner = dict(near), dict(near)
    for unknown, (low, low_open, high, high_open) in branch.box.items():  # off open bounds closer than floats tell
        if (low_open and near[unknown] == low) or (high_open and near[unknown] == high):
            within[unknown] = (low + high) / 2
    for direction, upper, _, _ in branch.rows[-1:]:  # where unknowns meet the last row best, however little they weigh
        for unknown, weight in direction.weights:
            low, _, high, _ = branch.box.get(unknown, UNIT)
            corner[unknown] = low if (weight > 0) == upper else high
    for exact in (on_rows, near, within, corner):
        if exact is not None:
            yield _course(system, branch, start, exact, None)


def inhabitant(system: System, claim: SystemClaim) -> Mapping[str, Fraction] | Verdict:
    """A state that a claim is about; VACUOUS where there is none, UNKNOWN where none was found."""
    reading = SystemReading(system, [one.name for one in system.variables])
    answer = Verdict.VACUOUS
    stated = [(*system.start, *region) for region in claim.assuming] or [system.start]
    for polytope in (claim.regions or ((),)) if claim.about_decisions else stated:
        branch = reading.start(polytope)
        if branch is None:
            continue
        middle = Programs().middle(branch)
        if middle.slack < 0 and multipliers(branch, None, middle) is not None:
            continue
        for course in witnesses(system, branch, branch):
            if is_start(system, claim, course.start):
                return course.start
        answer = Verdict.UNKNOWN
    return answer


def prove(profile: PolicyProfile, system: System, claim: SystemClaim, proof: SystemProof) -> ReachOutcome:
    """The answer by a proof, where the claim is about something. RejectedError where the checker refuses it."""
    state = inhabitant(system, claim)
    if isinstance(state, Verdict):
        return about_nothing(claim, state)
    made = certify(profile, system, claim, state, proof)
    return ReachOutcome(Verdict.PROVED, certificate=made, branches=accept(made, profile, system))


def _round_point(branch: Branch, point: Mapping[int, float], bits: int) -> Exactly:
    """A point with short numbers, each within its bounds. What the point says nothing about is in the middle."""
    rounded: dict[int, Fraction] = {}
    for unknown in range(len(branch.motion.unknowns)):
        low, _, high, _ = branch.box.get(unknown, UNIT)
        value = Fraction(point[unknown]) if unknown in point else (low + high) / 2
        rounded[unknown] = min(max(_short(value, bits), low), high)
    return rounded


def _short(number: Fraction, bits: int) -> Fraction:
    return Fraction(round(number * (1 << bits)), 1 << bits)


def _course(system: System, branch: Branch, start: Branch, exact: Exactly, bits: int | None) -> Course:
    """The course that values of the unknowns stand for. `bits`: of the start, where that may be rounded. A mode that
    nothing fixes lies in the middle of its numbers, next to which there is one.
    """
    modes = {one.name for one in system.variables if one.modes}
    places = {key: number for number, key in enumerate(branch.motion.unknowns)}
    values: dict[str, Fraction] = {}
    for name, least in start.at.items():
        width = sum(start.motion.weights[name].values(), Fraction(0))
        value = least + width * exact.get(places.get((-1, name), -1), Fraction(0))
        if name in modes:
            value = Fraction(round(value))
        values[name] = value if bits is None else min(max(_short(value, bits + 8), least), least + width)
    errors: list[dict[str, Fraction]] = []
    for step, number in enumerate(branch.pieces):
        stated, error = system.pieces[number].error, dict[str, Fraction]()
        for name, (low, high) in stated.items():
            share = exact.get(places.get((step, name), -1), Fraction(0))
            error[name] = low + (high - low) * share
        errors.append(error)
    return Course(values, errors, branch.pieces)
