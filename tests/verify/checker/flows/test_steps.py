"""Steps hold solutions of mpmath to 30 digits, wholly; their series are those that mpmath finds."""

from fractions import Fraction as F

import numpy as np
import pytest

from tests.support.flows import CASES, case, coefficients
from tests.support.stated_play import value
from verify.checker.flows.intervals import Spans
from verify.checker.flows.series import FlowReading
from verify.checker.flows.steps import FlowStep, Stepping, build_frames
from verify.checker.reading import RejectedError
from verify.language.units import PURE
from verify.systems.expressions import Call, Name, Number, Product, Quotient
from verify.systems.parsing import Names, expression_of
from verify.systems.system import Flow

mpmath = pytest.importorskip("mpmath")
X, NAMES = Name("x"), Names({"x": PURE, "y": PURE})
ALL = {  # every function of files
    name: expression_of(text, NAMES, "").value
    for name, text in (("x", "exp(-y) + tan(0.2*x) - pi/8"), ("y", "sqrt(x + 2)/(3 + cos(y))"))
}


def exactly(number):
    """A fraction as mpmath has it."""
    return mpmath.mpf(number.numerator) / number.denominator


def solved(flow, start, seconds, held):
    """The state after some seconds, to 30 digits."""
    names = list(flow.rates)
    with mpmath.workdps(34):
        known = {name: exactly(given) for name, given in held.items()}

        def slope(_, state):
            at = known | dict(zip(names, state, strict=True))
            return [value(flow.rates[name], at, mpmath, exactly) for name in names]

        end = exactly(seconds)
        return mpmath.odefun(slope, 0, [mpmath.mpf(value) for value in start], tol=mpmath.mpf(10) ** -30)(end)


def some_flow(name):
    if name == "all":
        return Flow(F(1, 5), ALL, {("a", "b"): {}}), (np.zeros(2), np.array([0.3, 0.2])), {}
    system, _, _ = case(*CASES[name])
    low, high = np.full(len(system.variables), 0.7), np.full(len(system.variables), 0.8)
    return system.flow, (low, high), next(iter(system.flow.held.values()))


def escaping(name, count, seed, order=4, step=FlowStep):
    """How many of some solutions leave the box after two steps, and the box's width."""
    flow, (low, high), held = some_flow(name)
    names, random = list(flow.rates), np.random.default_rng(seed)
    how = Stepping(order, flow.period / 2)
    stepping = step(FlowReading(flow, names), [(F(0), F(0))] * len(names), how)
    box = Spans(low[None], high[None])
    inputs = {name: Spans(*([np.array([float(value)])] * 2)) for name, value in held.items()}
    frames, begun = (build_frames(box),), box
    for _ in range(2):
        moved = stepping.move_sets(box, frames, inputs)
        assert moved.shown.all()
        box, frames = moved.box, moved.frames
    bad = 0
    for number in range(count):
        share = np.round(random.random(len(low))) if number % 2 else random.random(len(low))
        start = begun.low[0] + share * (begun.high[0] - begun.low[0])
        end = solved(flow, start, flow.period, {name: F(float(value)) for name, value in held.items()})
        bad += not all(box.low[0, place] <= value <= box.high[0, place] for place, value in enumerate(end))
    return bad, float((box.high - box.low).max())


@pytest.mark.parametrize("name", [*CASES, "all"])
def test_no_solution_leaves_the_box(name):
    bad, width = escaping(name, {"mixed": 1, "all": 2}.get(name, 4), 0)
    assert not bad and width < 0.5


@pytest.mark.parametrize(
    "count", [pytest.param(6, marks=pytest.mark.slow), pytest.param(125, marks=pytest.mark.nightly)]
)
@pytest.mark.parametrize("name", [*CASES, "all"])
@pytest.mark.parametrize("order", [1, 4])
def test_a_thousand_solutions_stay(name, order, count):
    assert escaping(name, count, 1, order)[0] == 0


def test_points_stay_nearly_points():
    """The matrix exponential of a turn, with bounds: cos and sin of half a second."""
    system, _, _ = case(*CASES["turning"])
    reading = FlowReading(system.flow, ["x", "y"])
    step = FlowStep(reading, [(F(0), F(0))] * 2, Stepping(16, F(1, 2)))
    point = np.array([[1.0, 0.0]])
    zero = {"one.u": Spans(np.zeros(1), np.zeros(1))}
    found = step.move_sets(Spans(point, point), (build_frames(Spans(point, point)),), zero).box
    with mpmath.workdps(30):
        for place, exact in enumerate((mpmath.cos(0.5), -mpmath.sin(0.5))):
            assert found.low[0, place] <= exact <= found.high[0, place]
    assert (found.high - found.low).max() < 1e-14


def test_coefficients_are_those_of_mpmath():
    flow, (low, _), _ = some_flow("all")
    found = coefficients(flow, low, 5)
    with mpmath.workdps(50):
        known = {"x": mpmath.mpf(0), "y": mpmath.mpf(0)}
        first = [value(ALL[name], known, mpmath, exactly) for name in "xy"]
        end = solved(flow, low, F(1, 100), {})
        for place in (0, 1):
            series = found[place]
            assert series[1][0] <= first[place] <= series[1][1]
            total = sum(low * 0.01**k for k, (low, _) in enumerate(series))
            assert abs(total - float(end[place])) < 1e-13


def test_what_divides_by_zero_or_grows_too_fast_is_not_shown():
    for rate, low in ((Product(X, X), 1.5), (Quotient(Number(F(1)), X), -0.5)):  # 2 / (1 - 2 t) has no value at 0.5
        reading, box = FlowReading(Flow(F(1), {"x": rate}, {}), ["x"]), Spans(np.array([[low]]), np.array([[2.0]]))
        step = FlowStep(reading, [(F(0), F(0))], Stepping(4, F(1)))
        with np.errstate(all="ignore"):
            assert not step.move_sets(box, (build_frames(box),), {}).shown.any()


def test_what_is_not_known_is_refused():
    for call in (Call("gamma", X), Call("clip", X, (F(0), F(1)))):
        with pytest.raises(RejectedError, match="does not know"):
            FlowReading(Flow(F(1), {"x": call}, {}), ["x"])


def test_what_turns_as_it_drives_is_enclosed():
    """Two inputs move two variables evenly, and these move a third: its box must not run after theirs."""
    x, y = Product(Name("v"), Call("cos", Name("h"))), Number(F(1))
    flow = Flow(F(1, 5), {"x": x, "v": y, "h": y}, {("a", "b"): {}})
    point = np.array([[-0.8, -1.8, 1.4]])
    box = Spans(point, point)
    step = FlowStep(FlowReading(flow, ["x", "v", "h"]), [(F(0), F(0))] * 3, Stepping(4, F(1, 5)))
    assert step.move_sets(box, (build_frames(box),), {}).shown.all()
