"""Faults planted in the checker of flows are caught: trajectories leave its sets, or a false claim is shown."""

from dataclasses import replace
from fractions import Fraction as F
from math import factorial

import numpy as np
import pytest

from tests.support.flows import (
    CASES,
    EXACTLY,
    NEAR,
    SIDES,
    case,
    coefficients,
    outside,
    starts_of,
    trajectories,
    watched,
)
from tests.support.system_cases import box
from verify.checker.covers.boxes import Regions
from verify.checker.flows import intervals, series, steps, sweep
from verify.checker.flows.intervals import Spans
from verify.checker.flows.series import StepPrograms
from verify.checker.flows.steps import FlowStep
from verify.checker.flows.sweep import FlowSweep, Plan
from verify.checker.reading import RejectedError
from verify.systems.claims import Pattern
from verify.systems.expressions import Name, Number, Power, Product
from verify.systems.system import Flow


def escapes(name, plan=None, errors=False):
    """Whether some trajectory leaves the sets of a sweep."""
    plan, (system, profile, claim) = plan or Plan((0,), 4, 1), case(*CASES[name])
    wide = replace(claim, regions=(box(**{one.name: (-99, 99) for one in system.variables}),))
    seen = watched(FlowSweep(profile, system, wide), plan)
    starts = starts_of(system, 40, np.random.default_rng(0))
    ends = np.array([[float(end) for end in system.flow.error.get(one.name, (0, 0))] for one in system.variables])
    off = np.broadcast_to(ends[:, 1], starts.shape) if errors else None
    return outside(seen, trajectories(system, profile, starts, plan.steps, off), 0) > 1e-9


def leaves_tubes(name):
    """Whether some trajectory leaves the tubes of a sweep."""
    plan, (system, profile, claim) = Plan((0,), 4, 1), case(*CASES[name])
    seen = watched(FlowSweep(profile, system, claim), plan)
    states = trajectories(system, profile, starts_of(system, 40, np.random.default_rng(0)), 4)
    return any(outside(seen, states[:, part::4], 1) > 1e-9 for part in range(4))


def shows(plan=None, **changes):
    """Whether a claim about the pendulum is shown."""
    system, profile, claim = case(*CASES["pendulum"])
    try:
        return FlowSweep(profile, system, replace(claim, **changes)).run(plan or Plan((0,), 4, 1)) > 0
    except RejectedError:
        return False


def narrow():
    return shows(regions=(box(angle=(0, F(6, 10))),))


def never():
    return shows(pattern=Pattern.REACHES, by=0, regions=(box(angle=(2, 3)),))


def forbidden():
    return shows(pattern=Pattern.AVOIDS, by=0, regions=(box(angle=(F(7, 10), F(72, 100))),))


def between():
    """x = cos t at whole turns, where it is 1, and between them, where it is not."""
    system, profile, claim = case(EXACTLY, SIDES, NEAR.replace("[-2, 2]", "[0.9, 1.1]"))
    try:
        return FlowSweep(profile, system, claim).run(Plan((0,), 6, 40)) > 0
    except RejectedError:
        return False


FRAMED = steps._move_frame


def without_rest(frame, box, landed, slopes):
    found = FRAMED(frame, box, landed, slopes)
    return found._replace(rest=np.zeros_like(found.rest))


def straight(matrix, rest, more):
    return np.broadcast_to(np.eye(matrix.shape[1]), matrix.shape), rest + more


def at_the_middle(box, frames):
    return Spans(box.middle, box.middle)


def no_remainder(self, tape):
    return [None] * len(LEFT_OUT(self, tape))


def no_errors(self, count):
    zero = np.zeros((count, len(self._bounds[0])))
    return Spans(zero, zero)


def only_the_start(self, box, held):
    return box, np.ones(len(box.low), dtype=np.bool_)


def first_half(frame, of, low, high):
    return RENAMED(frame, of, low, 0.5 * low + 0.5 * high)


def first_side(trees, boxes):
    found = DECIDED(trees, boxes)
    _, first = np.unique(found.part, return_index=True)
    return found.take(first)


def squares_of_starts(write, read, own, number, k):
    return SQUARE(write, read, own, number, k) if k == 0 else None


def first_factor(*factors):
    return FACTOR(*factors[:1] * len(factors))


def sine_twice(span):
    return WAVES(span)[0], WAVES(span)[0]


RENAMED, DECIDED = steps._rescale_frame, sweep.split_by_trees
LEFT_OUT = StepPrograms._write_remainder
SQUARE, FACTOR, WAVES = series._square, intervals.Factor, intervals.waves
FAULTS = {
    "what the series leaves out": (
        StepPrograms,
        "_write_remainder",
        no_remainder,
        lambda: escapes("turning", Plan((0,), 2, 1)),
    ),
    "what frames leave out": (steps, "_move_frame", without_rest, lambda: escapes("pendulum")),
    "rests that are not turned": (steps, "orthogonalise_rest", straight, lambda: not _turned()),
    "slopes of the middle": (steps, "_around", at_the_middle, lambda: escapes("pendulum")),
    "errors of derivatives": (FlowStep, "_errors_of", no_errors, lambda: escapes("turning", errors=True)),
    "a tube that is the start": (FlowStep, "_stay", only_the_start, lambda: leaves_tubes("pendulum")),
    "frames cut too far": (steps, "_rescale_frame", first_half, lambda: escapes("pendulum")),
    "one side of a split": (sweep, "split_by_trees", first_side, lambda: escapes("pendulum")),
    "coefficients of squares": (series, "_square", squares_of_starts, lambda: not _squares()),
    "multiples by another's factor": (intervals, "Factor", first_factor, lambda: not _grows()),
    "sin for cos": (intervals, "waves", sine_twice, lambda: escapes("mixed")),
    "sin without its extremes": (
        intervals,
        "_meets",
        lambda span, place: np.zeros_like(span.low, dtype=np.bool_),
        lambda: not _holds_extremes(),
    ),
    "claims at samples only": (FlowSweep, "_may_break", lambda self, sets, **_: np.zeros(sets.size, np.bool_), between),
    "nothing beyond a region": (Regions, "outside", lambda self, boxes: boxes.take(slice(0, 0)), narrow),
    "nothing in a region": (Regions, "within", lambda self, boxes: boxes.take(slice(0, 0)), forbidden),
    "what never gets there": (FlowSweep, "_leave", lambda *_: None, never),
    "another action": (FlowSweep, "_of_joint", lambda self, joint: OF_JOINT(self, 0), lambda: escapes("pendulum")),
    "sums rounded to nearest": (
        intervals,
        "plus",
        lambda a, b: Spans(a.low + b.low, a.high + b.high),
        lambda: _inexact(),
    ),
}
OF_JOINT = FlowSweep._of_joint


def _squares():
    """x' = x**2 from 1 is 1 / (1 - t), whose coefficients are all 1."""
    flow = Flow(F(1), {"x": Power(Name("x"), 2)}, {})
    return all(low <= 1 <= high for low, high in coefficients(flow, [1.0], 4)[0])


def _grows():
    """x' = 2 x and y' = 3 y: the coefficients of exp."""
    rates = {name: Product(Number(F(factor)), Name(name)) for name, factor in (("x", 2), ("y", 3))}
    found = coefficients(Flow(F(1), rates, {}), [1.0, 1.0], 3)
    exact = [[F(factor**k, factorial(k)) for k in range(4)] for factor in (2, 3)]
    return all(
        low <= sure <= high
        for of, at in zip(found, exact, strict=True)
        for (low, high), sure in zip(of, at, strict=True)
    )


def _turned():
    """Whether bounds of turned rests hold them; numpy solves for these."""
    random = np.random.default_rng(0)
    matrix, rest, more = random.normal(size=(300, 3, 3)), random.random((300, 3)), random.random((300, 3))
    rest[:9], more[9:18] = 0.0, 0.0
    turned, bounds = steps.orthogonalise_rest(matrix, rest, more)
    signs = random.choice([-1.0, 1.0], (2, 300, 3))
    ends = np.einsum("nij,nj->ni", matrix, signs[0] * rest) + signs[1] * more
    found = np.linalg.solve(turned, ends[:, :, None])[:, :, 0]
    return (np.abs(found) <= bounds * (1 + 1e-12) + 1e-300).all()


def _holds_extremes():
    found, _ = intervals.waves(Spans(np.array([1.0]), np.array([2.0])))
    return found.high[0] == 1.0


def _inexact():
    one = Spans(np.array([1.0]), np.array([1.0]))
    tiny = Spans(np.array([1e-30]), np.array([1e-30]))
    found = intervals.plus(one, tiny)
    return not F(found.low[0]) <= 1 + F(1e-30) <= F(found.high[0])


@pytest.mark.parametrize("name", FAULTS)
def test_a_planted_fault_is_caught(name, monkeypatch):
    owner, attribute, fault, caught = FAULTS[name]
    assert not caught()
    if owner is series:
        monkeypatch.setitem(series._NEXT, "square", fault)
    monkeypatch.setattr(owner, attribute, fault)
    assert caught()
