"""Programs compute what is written on their tapes: the floats of a plain evaluation, whatever is computed together."""

from fractions import Fraction as F

import numpy as np
import pytest

from tests.support.flows import CASES, case
from verify.checker.flows import functions, spans, tapes
from verify.checker.flows.programs import AROUND, ON_THE_WAY, Stepping, StepPrograms, centre_of, error_name
from verify.checker.flows.series import FlowReading
from verify.checker.flows.spans import Spans
from verify.checker.flows.tapes import Program, Tape
from verify.language.arithmetic import PURE
from verify.systems.parsing import Names, expression_of
from verify.systems.system import Flow

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
                found.append(spans.exact(number, count))
            case "pi":
                found.append(functions.half_turns(count))
            case "scale":
                found.append(spans.scale_spans(*read, tapes.Factor(number)))
            case "sin" | "cos":
                found.append(functions.waves(*read)[does == "cos"])
            case "exp":
                found.append(functions.exponential(*read))
            case "sqrt":
                found.append(functions.root(*read))
            case _:
                found.append(getattr(spans, does)(*read))
    nothing = Spans(np.zeros(count), np.zeros(count))
    rows = [nothing if place is None else found[place] for place in wanted]
    return Spans(*(np.stack([row[side] for row in rows]) for side in (0, 1)))


def flow_of(name):
    if name == "everything":
        return Flow(F(1, 5), {key: expression_of(text, NAMES, "").value for key, text in EVERYTHING.items()}, {})
    return case(*CASES[name])[0].flow


@pytest.mark.parametrize("at_once", [1, 2_000, tapes.AT_ONCE])
@pytest.mark.parametrize("name", [*CASES, "everything"])
def test_programs_compute_what_a_plain_evaluation_does(name, at_once, monkeypatch):
    written = []

    class Seen(Program):
        def __init__(self, tape, wanted):
            super().__init__(tape, wanted)
            written.append((self, tape, wanted))

    monkeypatch.setattr(tapes, "AT_ONCE", at_once)
    monkeypatch.setattr("verify.checker.flows.programs.Program", Seen)
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
