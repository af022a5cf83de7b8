"""sin, cos, tan, exp, sqrt and pi in all readings: each holds what mpmath says to 30 digits, on hard points too.

The engine's lines, the checker's whole numbers and the floats of flows are readings of their own. Planted faults in the
checker's one are found by the same test.
"""

import math
import random
from fractions import Fraction as F

import pytest

from codegen.errors import InputError
from tests.support.systems import with_piece
from verify.checker.flows.intervals import half_turns
from verify.checker.reading import RejectedError
from verify.checker.systems import enclosures
from verify.checker.systems.enclosures import FUNCTIONS, ONE, Range, UnboundedError, ensure_enclosed
from verify.language.units import PURE, unit_of
from verify.systems.enclosures import LINES, PI, UndefinedError, _root
from verify.systems.files import statement_of
from verify.systems.observing import function
from verify.systems.parsing import Names, expression_of

mpmath = pytest.importorskip("mpmath")
ALL = ("sin", "cos", "tan", "exp", "sqrt")
ENGINE = {**LINES, "sqrt": _root}
N = 30
BENT = """
name = "bent"
steps = 3
[variables]
h = { unit = "m", range = [0, 1] }
g = { unit = "m", range = [0, 1] }
a = { unit = "deg", range = [-60, 60] }
[agents.one.features]
h = "h"
[agents.one.actions]
on = { u = "0.01 m" }
off = {}
[start]
box = { h = [0.4, 0.5], g = 0.5, a = 0 }
[dynamics.next]
h = "h - 0.1[m^0.5]*sqrt(h) + one.u"
g = "g + 0.05[m^0.5]*(sqrt(max(h - g, 0[m])) - sqrt(max(g - h, 0[m])))"
a = "0.5*a + 1[deg]*(tan(a) - pi/8*exp(-h/1[m]))"
[dynamics.cuts]
h = 3
g = 2
a = 3
"""


def points(name, count):
    """Numbers near poles, extrema and 0, and of all sizes that are known."""
    draw = random.Random(name)
    found = [F(draw.uniform(-8, 8)) for _ in range(count)]
    found += [F(draw.choice([-1, 1]) * 10.0 ** draw.uniform(-20, 1)) for _ in range(count)]
    turns = [F(math.pi) * draw.randint(-9, 9) / 2 for _ in range(count)]
    found += [turn + draw.choice([-1, 1]) * F(10.0 ** draw.uniform(-12, -1)) for turn in turns]
    found += [F(0), F(31), F(-31), F(1, 2**200), F(1, 3)]
    return [abs(each) for each in found] if name == "sqrt" else found


def exactly(name, x):
    return getattr(mpmath, name)(mpmath.mpf(x.numerator) / x.denominator)


def number(x):
    return mpmath.mpf(x.numerator) / x.denominator


def inner(low, high):
    """Numbers of a range: ends, a middle, and where a wave turns."""
    turns = [F(math.pi) * k / 2 for k in range(-20, 21)]
    return [low, high, (low + high) / 2, (3 * low + high) / 4, *(turn for turn in turns if low <= turn <= high)]


def ensure_lines(name, count=N):
    """The engine's line is as far off as it says, at points within."""
    draw, met = random.Random(f"{name} lines"), 0
    for low in points(name, count):
        high = low + F(draw.choice([0.0, 10.0 ** draw.uniform(-9, 0.3)]))
        try:
            slope, (least, most) = ENGINE[name](low, high)
        except UndefinedError:
            continue
        met += 1
        for x in inner(low, high):
            left = exactly(name, x) - number(slope * x)
            assert number(least) <= left <= number(most), (name, float(low), float(high), float(x))
    assert met > count


def ensure_ranges(name, count=N):
    """The checker's bounds of values and slopes hold both at points within; at single points they are narrow."""
    draw, met = random.Random(f"{name} ranges"), 0
    for low in points(name, count):
        for width in (0.0, 10.0 ** draw.uniform(-12, 0.3)):
            high = low + F(width)
            span = Range(*(int((end * ONE).__floor__()) for end in (low, high)))
            try:
                found, slope = FUNCTIONS[name](span)
            except UnboundedError:
                continue
            met += 1
            for x in (F(end, ONE) for end in (span.low, span.high, (span.low + span.high) // 2)):
                exact = exactly(name, x)
                assert found.low <= exact * ONE <= found.high, (name, float(low), width, float(x))
                if slope is not None:
                    steep = {
                        "sin": mpmath.cos(number(x)),
                        "cos": -mpmath.sin(number(x)),
                        "tan": 1 + exact**2,
                        "exp": exact,
                        "sqrt": 1 / (2 * exact) if exact else mpmath.inf,
                    }[name]
                    assert slope.low <= steep * ONE <= slope.high, (name, float(low), width, float(x))
            if not width and abs(exact) < 2**40:
                assert found.high - found.low < 2**64 * (1 + exact**2), (name, float(low))
    assert met > count


def ensure_pi():
    with mpmath.workdps(60):
        found = enclosures.pi.__wrapped__()
        assert found.low < mpmath.pi * ONE < found.high and found.high - found.low < 2**16
        assert number(PI[0]) < mpmath.pi < number(PI[1])
        floats = half_turns(2)
        assert (number(F(floats.low[1])) < mpmath.pi < number(F(floats.high[1]))) and len(floats.low) == 2


def ensure_readings():
    for cached in (enclosures.waves_at, enclosures.exp_at):
        cached.cache_clear()
    with mpmath.workdps(60):
        for name in ALL:
            ensure_ranges(name, 12)
    ensure_pi()


@pytest.mark.parametrize("name", ALL)
def test_lines_and_ranges_hold_the_functions(name):
    with mpmath.workdps(60):
        ensure_lines(name)
        ensure_ranges(name)


def test_pi_lies_in_all_its_readings():
    ensure_pi()


@pytest.mark.slow
@pytest.mark.parametrize("name", ALL)
def test_a_thousand_points(name):
    with mpmath.workdps(60):
        ensure_lines(name, 300)
        ensure_ranges(name, 300)


FAULTS = {
    "a series that ends early": ("_series", lambda old: lambda *of: Range(*[old(*of).low >> 40 << 40] * 2)),
    "a root from above only": ("isqrt", lambda old: lambda of: old(of) + 1),
    "arctan without what is lost": ("_arctan", lambda old: lambda n: Range(*[sum(old(n)) // 2] * 2)),
    "waves of the middle": ("_near", lambda old: lambda of, off: of),
    "reciprocals the other way round": ("inverse", lambda old: lambda of: (Range(*old(of)[0][::-1]), old(of)[1])),
    "slopes with the other sign": ("_negative", lambda old: lambda of: of),
    "squares without their sign": ("power", lambda old: lambda of, n: Range(old(of, n).low, old(of, n).low)),
    "products rounded to one side": ("times", lambda old: lambda a, b: Range(old(a, b).low, old(a, b).high - 1)),
    "roots of twice the number": ("scale_range", lambda old: lambda of, n: old(of, n) if n != 2 else of),
}


@pytest.mark.parametrize("name", FAULTS)
def test_planted_faults_are_found(name, monkeypatch):
    attribute, change = FAULTS[name]
    monkeypatch.setattr(enclosures, attribute, change(getattr(enclosures, attribute)))
    enclosures.pi.cache_clear()
    with pytest.raises((AssertionError, RecursionError)):
        ensure_readings()
    for cached in (enclosures.waves_at, enclosures.exp_at, enclosures.pi):
        cached.cache_clear()


def test_without_a_fault_nothing_is_found():
    ensure_readings()


# --- in files


def test_enclosures_of_a_file_are_shown_and_forged_ones_are_not():
    """Roots down to 0, where they are steep, among them."""
    statement = statement_of(BENT, "f")
    assert ensure_enclosed(statement) >= 3 * len(statement.system.pieces)
    draw = random.Random(0)
    for place in draw.sample(range(len(statement.system.pieces)), 1):
        piece = statement.system.pieces[place]
        for name in ("h", "a"):
            error = {**piece.error, name: tuple(end / 2 for end in piece.error[name])}
            with pytest.raises(RejectedError, match=r"its error (is exceeded|was not shown)"):
                ensure_enclosed(with_piece(statement, place, error=error))


NAMES = Names({"x": PURE, "h": unit_of("m", ""), "a": unit_of("deg", ""), "k": unit_of("m^0.5/s", "")})


@pytest.mark.parametrize(
    ("text", "unit", "number"),
    [
        ("sqrt(h)", "m^0.5", 1.5),
        ("k*sqrt(h)", "m/s", 4.5),
        ("sqrt(h*h)", "m", 2.25),
        ("sqrt(2)", None, math.sqrt(2)),
        ("tan(a)", "1", math.tan(math.pi / 6)),
        ("sin(a) + cos(x)", "1", 0.5 + math.cos(0.5)),
        ("pi/180[deg]*a", "1", math.pi / 6),
        ("exp(-x)", "1", math.exp(-0.5)),
        ("max(x, 1, 0.2)", "1", 1.0),
        ("min(x, 1, 2*x)", "1", 0.5),
        ("abs(-h)", "m", 2.25),
    ],
)
def test_units_and_values(text, unit, number):
    found = expression_of(text, NAMES, "here")
    assert found.unit == (None if unit is None else unit_of(unit, ""))
    assert function(found.value)({"x": 0.5, "h": 2.25, "a": 30.0, "k": 3.0}) == pytest.approx(number, abs=1e-12)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("exp(h)", "units do not fit: exp of m"),
        ("exp(a)", "units do not fit: exp of deg"),
        ("tan(h)", "units do not fit: tan of m"),
        ("a + pi", "units do not fit: deg and 1"),
        ("sqrt(x, 2)", "sqrt has other arguments"),
        ("sqr(x)", "unknown function 'sqr'"),
    ],
)
def test_what_is_refused(text, words):
    with pytest.raises(InputError, match=words):
        expression_of(text, NAMES, "here")


@pytest.mark.parametrize(
    ("rule", "words"),
    [
        ("sqrt(h - 0.1[m])*1[m^0.5]", "sqrt of what may be below 0"),
        ("h*tan(2*a)", "tan may have a pole"),
        ("h*exp(40*h/1[m])", "exp of more than 32"),
        ("h*tan(99*h/1[m])", "tan of more than 32"),
        ("h/tan(a)", "a denominator may be 0"),
    ],
)
def test_what_is_not_defined_everywhere_is_refused_with_its_line(rule, words):
    text = BENT.replace("h - 0.1[m^0.5]*sqrt(h) + one.u", rule)
    line = next(number for number, each in enumerate(text.split("\n"), 1) if rule in each)
    with pytest.raises(InputError, match=words) as raised:
        statement_of(text, "f")
    assert str(raised.value.where).startswith(f"f, line {line}: dynamics.next.h: ")


def test_pi_is_a_name_like_others_where_a_file_says_so():
    own = Names({"pi": unit_of("m", "")})
    assert expression_of("pi", own, "here").unit == unit_of("m", "")
