"""Exact starts and errors within a symbolic state.

Does: candidates for the course of an episode to a branch that is left open; a state of the region of a claim.
Assumes: whoever asks replays them, so that a candidate may be wrong.
Does not: replay.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from fractions import Fraction

from verify.checker.systems.reading import SystemReading
from verify.checker.systems.rows import UNIT, Branch, Row
from verify.reach.programs import Middle, Programs, gap, multipliers, solve_equations
from verify.reach.replay import Course, is_start
from verify.result import Verdict
from verify.systems.claims import SystemClaim
from verify.systems.system import System

BITS = (4, 8, 14, 24, 40)  # of rounded starts
NEAR = 1e-7
Exactly = Mapping[int, Fraction]  # by unknown


def witnesses(system: System, branch: Branch, start: Branch) -> Iterator[Course]:
    """Courses to a branch, those with short numbers first. `start`: the symbolic state that it came from."""
    middle = Programs().middle(branch)
    for bits in BITS:
        yield _course(system, branch, start, _round_point(branch, middle.point, bits), bits)
    near = _round_point(branch, middle.point, BITS[-1])
    for exact in (_on_rows(branch, middle), near, _within(branch, near), _corner(branch, near)):
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


def _round_point(branch: Branch, point: Mapping[int, float], bits: int) -> Exactly:
    """A point with short numbers, each within its bounds. What the point says nothing about is in the middle."""
    rounded: dict[int, Fraction] = {}
    for unknown in range(len(branch.motion.unknowns)):
        low, _, high, _ = branch.box.get(unknown, UNIT)
        value = Fraction(point[unknown]) if unknown in point else (low + high) / 2
        rounded[unknown] = min(max(_short(value, bits), low), high)
    return rounded


def _within(branch: Branch, point: Exactly) -> Exactly:
    """A point with unknowns off their open bounds: in the middle, where these lie closer than floats tell."""
    inner = dict(point)
    for unknown, (low, low_open, high, high_open) in branch.box.items():
        if (low_open and inner[unknown] == low) or (high_open and inner[unknown] == high):
            inner[unknown] = (low + high) / 2
    return inner


def _corner(branch: Branch, point: Exactly) -> Exactly:
    """A point with each unknown of the last row at the bound where it meets that row best, however little it weighs."""
    corner = dict(point)
    for direction, upper, _, _ in branch.rows[-1:]:
        for unknown, weight in direction.weights:
            low, _, high, _ = branch.box.get(unknown, UNIT)
            corner[unknown] = low if (weight > 0) == upper else high
    return corner


def _short(number: Fraction, bits: int) -> Fraction:
    return Fraction(round(number * (1 << bits)), 1 << bits)


def _on_rows(branch: Branch, middle: Middle) -> Exactly | None:
    """A point that meets the rows next to which a point lies exactly, where these have one."""
    rounded = dict(_round_point(branch, middle.point, BITS[-1]))
    rows = [row for row in branch.rows if abs(gap(row, middle.point)) < NEAR]
    return solve_equations([(_exactly(row), row.end) for row in rows], rounded)


def _exactly(row: Row) -> dict[int, Fraction]:
    return {unknown: Fraction(weight) for unknown, weight in row.direction.weights}


def _course(system: System, branch: Branch, start: Branch, exact: Exactly, bits: int | None) -> Course:
    """The course that values of the unknowns stand for. `bits`: of the start, where that may be rounded."""
    places = {key: number for number, key in enumerate(branch.motion.unknowns)}
    values: dict[str, Fraction] = {}
    for name, least in start.at.items():
        width = sum(start.motion.weights[name].values(), Fraction(0))
        value = least + width * exact.get(places.get((-1, name), -1), Fraction(0))
        values[name] = value if bits is None else min(max(_short(value, bits + 8), least), least + width)
    errors: list[dict[str, Fraction]] = []
    for step, number in enumerate(branch.pieces):
        stated, error = system.pieces[number].error, dict[str, Fraction]()
        for name, (low, high) in stated.items():
            share = exact.get(places.get((step, name), -1), Fraction(0))
            error[name] = low + (high - low) * share
        errors.append(error)
    return Course(values, errors, branch.pieces)
