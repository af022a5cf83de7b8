"""Sums, products and quotients of intervals hold the exact ones of all their ends, at the ends of the floats too.

Intervals of functions, sums and products hold what mpmath says to 30 digits, and exact fractions.

Programs compute what is written on their tapes: the floats of a plain evaluation, whatever is computed together.
"""

from fractions import Fraction as F
from itertools import product

import numpy as np
import pytest

from tests.support.flows import CASES, case
from verify.checker.covers.rounding import Factor
from verify.checker.flows import intervals
from verify.checker.flows.intervals import Program, Spans, Tape
from verify.checker.flows.series import AROUND, ON_THE_WAY, FlowReading, Stepping, StepPrograms, centre_of, error_name
from verify.language.units import PURE
from verify.systems.parsing import Names, expression_of
from verify.systems.system import Flow

ENDS = [0.0, 1.0, 3.0, 0.1, 2.0**-1074, 3e-320, 2.0**-1022, 1.5e-160, 7e150, 1.7e308]
FACTORS = (F(1), F(-1), F(1, 3), F(-7, 5), F(2) ** 40)


def random_spans(seed, count=300):
    """Intervals with ends of all sizes, points and zeros among them."""
    random = np.random.default_rng(seed)
    ends = (
        random.choice([-1.0, 1.0], (2, count)) * random.choice(ENDS, (2, count)) * random.choice([1.0, 0.7], (2, count))
    )
    ends[1, ::5], ends[:, ::7], ends[0, 1::9] = ends[0, ::5], 0.0, 0.0
    return Spans(ends.min(axis=0), ends.max(axis=0))


def misses(found, exact):
    """How many finite intervals do not hold all exact numbers of theirs; those that are not finite say nothing."""
    finite = intervals.finite(found).tolist()
    bounds = zip(found.low.tolist(), found.high.tolist(), strict=True)
    return sum(
        known and not all(F(low) <= each <= F(high) for each in sure)
        for known, (low, high), sure in zip(finite, bounds, exact, strict=True)
    )


def ends_of(span):
    return [(F(low), F(high)) for low, high in zip(span.low.tolist(), span.high.tolist(), strict=True)]


def missed(seed=0):
    """How often one of the operations misses an exact result."""
    one, other = random_spans(seed), random_spans(seed + 1)
    pairs = list(zip(ends_of(one), ends_of(other), strict=True))
    with np.errstate(all="ignore"):
        count = misses(intervals.plus(one, other), [[a + b for a, b in product(*pair)] for pair in pairs])
        count += misses(intervals.minus(one, other), [[a - b for a, b in product(*pair)] for pair in pairs])
        count += misses(intervals.times(one, other), [[a * b for a, b in product(*pair)] for pair in pairs])
        squares = [[a * a for a in ends] + [F(0)] * (ends[0] <= 0 <= ends[1]) for ends in ends_of(one)]
        count += misses(intervals.square(one), squares)
        sure = [[1 / a for a in ends] if 0 not in ends else [] for ends in ends_of(one)]
        count += misses(intervals.inverse(one), sure)
        for factor in FACTORS:
            found = intervals.scale_spans(one, Factor(factor))
            count += misses(found, [[factor * a for a in ends] for ends in ends_of(one)])
    return count


def test_operations_hold_the_exact_results():
    assert not any(map(missed, (0, 7)))


def test_what_is_exactly_zero_stays_so():
    nothing, wide = Spans(np.zeros(1), np.zeros(1)), Spans(np.array([-np.inf]), np.array([1e300]))
    with np.errstate(all="ignore"):
        found = intervals.times(nothing, wide)
    assert found.low[0] == found.high[0] == 0.0


@pytest.mark.parametrize("fault", ["lower", "sum_down"])
def test_a_planted_fault_is_caught(fault, monkeypatch):
    faults = {"lower": lambda values: values, "sum_down": lambda one, other: one + other}
    monkeypatch.setattr(intervals, fault, faults[fault])
    assert missed()


mpmath = pytest.importorskip("mpmath")
N = 400


def points(random, scale):
    """Floats of all sizes up to a scale, with those next to multiples of pi / 2 among them."""
    some = random.standard_normal(N) * 10.0 ** random.uniform(-12, np.log10(scale), N)
    turns = np.rint(random.uniform(-0.6, 0.6, N) * min(scale, 1e6))
    edges = turns * (np.pi / 2) + random.choice([-1e-13, 0.0, 1e-13, 1e-9], N)
    return np.clip(np.concatenate([some, edges, [0.0, scale, -scale]]), -scale, scale)


KNOWN = {
    "sin": (lambda span: intervals.waves(span)[0], 1e6),
    "cos": (lambda span: intervals.waves(span)[1], 1e6),
    "exp": (intervals.exponential, 600.0),
    "sqrt": (intervals.root, 1e9),
}


@pytest.mark.parametrize("name", KNOWN)
def test_points_and_widths_hold_the_function(name):
    function, scale = KNOWN[name]
    random = np.random.default_rng(0)
    x = np.abs(points(random, scale)) if name == "sqrt" else points(random, scale)
    wide = np.minimum(x + 10.0 ** random.uniform(-10, 1, len(x)), scale)
    narrow, found = function(Spans(x, x)), function(Spans(x, wide))
    with mpmath.workdps(40):
        for place, number in enumerate(x):
            exact = getattr(mpmath, name)(mpmath.mpf(number))
            assert narrow.low[place] <= exact <= narrow.high[place], (name, number)
            assert narrow.high[place] - narrow.low[place] <= 1e-13 * max(1.0, abs(narrow.high[place]))
            for share in (0.0, 0.31, 1.0):
                inner = number + share * (wide[place] - number)
                value = getattr(mpmath, name)(mpmath.mpf(min(max(inner, number), wide[place])))
                assert found.low[place] <= value <= found.high[place], (name, number, wide[place])


@pytest.fixture(autouse=True)
def _quietly():
    with np.errstate(all="ignore"):  # as sweeps do: what overflows is not finite
        yield


def test_what_is_not_defined_is_no_number():
    one = np.ones(1)
    for span in (
        intervals.inverse(Spans(-one, one)),
        intervals.root(Spans(-one, one)),
        intervals.exponential(Spans(one, 1e4 * one)),
        intervals.waves(Spans(one, 1e7 * one))[0],
    ):
        assert not intervals.finite(span).any()


NAMES = Names({"x": PURE, "y": PURE, "u": PURE})
EVERYTHING = {"x": "exp(-y)*u + tan(0.2*x) - pi/8", "y": "sqrt(x + 2)/(3 + cos(y)) - x**3 + 0.1*y*sin(y)"}


def plain(tape, wanted, given, count):
    """Each operation alone, in the order in which it was written."""
    found = []
    for does, reads, name, number in tape.operations:
        read = [found[place] for place in reads]
        match does:
            case "given":
                found.append(given[name])
            case "exact":
                found.append(intervals.exact(number, count))
            case "pi":
                found.append(intervals.half_turns(count))
            case "scale":
                found.append(intervals.scale_spans(*read, intervals.Factor(number)))
            case "sin" | "cos":
                found.append(intervals.waves(*read)[does == "cos"])
            case "exp":
                found.append(intervals.exponential(*read))
            case "sqrt":
                found.append(intervals.root(*read))
            case _:
                found.append(getattr(intervals, does)(*read))
    nothing = Spans(np.zeros(count), np.zeros(count))
    rows = [nothing if place is None else found[place] for place in wanted]
    return Spans(*(np.stack([row[side] for row in rows]) for side in (0, 1)))


def flow_of(name):
    if name == "everything":
        return Flow(F(1, 5), {key: expression_of(text, NAMES, "").value for key, text in EVERYTHING.items()}, {})
    return case(*CASES[name])[0].flow


@pytest.mark.parametrize("at_once", [1, 2_000, intervals.AT_ONCE])
@pytest.mark.parametrize("name", [*CASES, "everything"])
def test_programs_compute_what_a_plain_evaluation_does(name, at_once, monkeypatch):
    written = []

    class Seen(Program):
        def __init__(self, tape, wanted):
            super().__init__(tape, wanted)
            written.append((self, tape, wanted))

    monkeypatch.setattr(intervals, "AT_ONCE", at_once)
    monkeypatch.setattr("verify.checker.flows.series.Program", Seen)
    flow, random, count = flow_of(name), np.random.default_rng(0), 7
    names = list(flow.rates)
    programs = StepPrograms(FlowReading(flow, names), Stepping(4, F(1, 7)), names[:1])
    assert programs.rates is not programs.rate_slopes and programs.step(2) is programs.step(2)
    inputs = {"u", *(one for values in flow.held.values() for one in values)}
    given = {}
    marks = ("", AROUND, ON_THE_WAY, centre_of(0), centre_of(1))
    starts = [mark + name for mark in marks for name in names]
    for one in [*starts, *inputs, error_name(names[0])]:
        low = random.uniform(-0.5, 0.7, count)
        given[one] = Spans(low, low + random.choice([0.0, 0.1, 2.0], count))
    assert len(written) == 3
    for program, tape, wanted in written:
        with np.errstate(all="ignore"):
            found, sure = program.run(given, count), plain(tape, wanted, given, count)
        assert all((np.isnan(a) & np.isnan(b) | (a == b)).all() for a, b in zip(found, sure, strict=True))


def test_what_is_written_twice_is_computed_once():
    tape = Tape()
    x, y = tape.write("given", name="x"), tape.write("given", name="y")
    assert tape.times(x, y) == tape.times(x, y) != tape.plus(x, y)
    assert tape.scale(x, F(1)) == x and tape.scale(x, F(2)) != tape.scale(x, F(3))
    one, zero = Spans(np.ones(1), np.ones(1)), Spans(np.zeros(1), np.zeros(1))
    found = Program(tape, [tape.plus(x, x), None]).run({"x": one, "y": zero}, 1)
    assert found.low.tolist() == found.high.tolist() == [[2.0], [0.0]]
