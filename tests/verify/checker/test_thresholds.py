"""Machine thresholds of the zone engine: against the roundings and the solver's encoder, at each tie."""

import ast
import math
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from codegen import ir
from codegen.errors import InputError
from codegen.floats import FLOAT32, FLOAT64, below_zero
from codegen.observe import observe
from maviper.worlds import find
from tests.faults import sharp_pairs
from tests.support.meanings import meanings
from tests.support.strategies import FLOAT32 as SINGLES
from verify.checker import thresholds
from verify.checker.thresholds import find_double_end, find_twice_rounded_end, sides
from verify.claims import formula
from verify.kinds import MACHINE, REAL
from verify.solver import encode

WORLD = find("physical-deception").spec
NORMAL = SINGLES.filter(lambda value: value == 0 or abs(value) >= 2.0**-126)
EDGES = [
    0.0,
    -0.0,
    1.0,
    -1.0,
    0.5,
    -2.0,
    0.1,
    -0.7,
    2.0**-126,
    -(2.0**-126),
    2.0**127,
    -(2.0**127),
    3.4028234663852886e38,
]


def spec(meaning):
    return ir.FeatureSpec("f", "none", -2.0, 2.0, meaning)


@given(st.one_of(NORMAL, st.sampled_from(EDGES)))
def test_the_two_implementations_agree(threshold):
    threshold = float(np.float32(threshold))
    for ours, theirs in ((find_double_end, encode.last_double), (find_twice_rounded_end, encode.half_line)):
        end = ours(threshold, FLOAT32)
        assert (end.value(), end.strict) == tuple(theirs(threshold, True))


@given(st.integers(-140, 120), st.integers(-2, 2), st.sampled_from([-1.0, 1.0]))
def test_they_agree_around_powers_of_two(power, steps, sign):
    threshold = np.float32(sign * 2.0**power)
    for _ in range(abs(steps)):
        threshold = np.nextafter(threshold, np.float32(math.copysign(math.inf, steps)))
    assume(np.isfinite(threshold) and (threshold == 0 or abs(threshold) >= 2.0**-126))
    end = find_twice_rounded_end(float(threshold), FLOAT32)
    assert (end.value(), end.strict) == tuple(encode.half_line(float(threshold), True))
    end = find_double_end(float(threshold), FLOAT32)
    assert (end.value(), end.strict) == tuple(encode.last_double(float(threshold), True))


def test_no_code_is_shared():
    tree = ast.parse(Path(thresholds.__file__).read_text())
    modules = {node.module for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)}
    assert "verify.solver.encode" not in modules and "z3" not in modules


def left_of(meaning, threshold, position):
    """What the machine does: observe, round, compare."""
    names = WORLD.coordinates()
    row = np.array([[position.get(name, 0.0) for name in names]])
    return bool(observe((spec(meaning),), row, WORLD, FLOAT32)[0, 0] <= np.float32(threshold))


@pytest.mark.parametrize(
    "threshold",
    [0.1, float(np.nextafter(np.float32(0.1), np.float32(1))), 0.0, below_zero(FLOAT32), -0.7, 0.5, -1.0, 1.0],
)
@pytest.mark.parametrize("kind", range(14))
def test_sides_are_what_the_machine_does_at_and_beside_every_tie(kind, threshold):
    meaning = meanings("agent_0")[kind]
    left, right = sides(spec(meaning), float(np.float32(threshold)), FLOAT32)
    seen = set()
    for end, base in sharp_pairs(float(np.float32(threshold))):
        for first, second in ((end, base), (base, end), (base, base)):
            names = [name for _, name in meaning.terms]
            position = dict(zip(names, (first, second), strict=False))
            if len(names) == 1:
                position = {names[0]: end * meaning.terms[0][0]}
            at = {name: Fraction(position.get(name, 0.0)) for name in WORLD.coordinates()}
            machine = left_of(meaning, threshold, position)
            assert formula.holds(left, at, {}) == machine
            assert formula.holds(right, at, {}) != machine
            seen.add(machine)
    constant = not meaning.terms or (meaning.function and not -1 <= threshold < 1)
    assert len(seen) == 2 or constant or meaning.function


def test_real_semantics_takes_the_threshold_as_it_is():
    meaning = meanings("agent_0")[1]
    threshold = float(np.float32(0.1))
    left, _ = sides(spec(meaning), threshold, FLOAT32, REAL)
    assert left.bound == Fraction(threshold) and not left.strict
    assert sides(spec(meaning), threshold, FLOAT32, MACHINE)[0].bound != left.bound


def test_sums_of_three_and_features_without_meaning_are_refused():
    three = ir.Meaning(((1, "agent_0.x"), (-1, "agent_1.x"), (1, "goal.x")))
    for meaning in (three, None):
        with pytest.raises(InputError, match="not a coordinate or a difference"):
            sides(spec(meaning), 0.0, FLOAT32)


DOUBLES = st.floats(-(2.0**1000), 2.0**1000, allow_subnormal=False) | st.sampled_from(
    [0.0, 2.0**-1022, -(2.0**-1022), 1.0, -1.0, 0.1, -(2.0**-3), 2.0**53, -(2.0**53), math.nextafter(1.0, 0.0)]
)


@given(DOUBLES, st.floats(-(2.0**1000), 2.0**1000), st.integers(-3, 3))
def test_float64_agents_round_once_or_not_at_all(threshold, b, steps):
    """Beside each threshold, in exact arithmetic and by both readings: a coordinate, and a difference of two."""
    near = threshold
    for _ in range(abs(steps)):
        near = math.nextafter(near, math.inf if steps > 0 else -math.inf)
    end, line = find_double_end(threshold, FLOAT64), encode.last_double(threshold, False)
    assert (end.value(), end.strict) == tuple(line) == (Fraction(threshold), False)
    end, line = find_twice_rounded_end(threshold, FLOAT64), encode.half_line(threshold, False)
    assert (end.value(), end.strict) == tuple(line)
    for a in (near + b, math.nextafter(near + b, math.inf), math.nextafter(near + b, -math.inf)):
        exact = Fraction(a) - Fraction(b)
        within = exact < line.end if line.strict else exact <= line.end
        assert within == (a - b <= threshold)


@pytest.mark.parametrize("terms", [((1.0, "agent_0.x"),), ((1.0, "goal.x"), (-1.0, "agent_0.x"))])
def test_sides_of_float64_agents_are_what_machines_do(terms):
    rng, meaning, names = np.random.default_rng(0), ir.Meaning(terms), WORLD.coordinates()
    for threshold in [0.1, -0.3, 0.0, below_zero(FLOAT64), 1.0, *rng.uniform(-2, 2, 20)]:
        left, right = sides(spec(meaning), threshold, FLOAT64)
        for _ in range(20):
            row = rng.uniform(-2, 2, (1, len(names)))
            places = {name: names.index(name) for _, name in meaning.terms}
            other = row[0, places["agent_0.x"]] if len(places) > 1 else 0.0
            first = next(iter(places))
            row[0, places[first]] = rng.choice(
                [threshold + other, np.nextafter(threshold + other, rng.choice([-9, 9]))]
            )
            seen = observe((spec(meaning),), row, WORLD, FLOAT64)
            assert seen.dtype == np.float64
            exact = {name: Fraction(row[0, place]) for name, place in places.items()}
            assert bool(seen[0, 0] <= threshold) == worth_true(left, exact) != worth_true(right, exact)


def worth_true(linear, at):
    total = sum(weight * at[name] for weight, name in linear.terms)
    return total < linear.bound if linear.strict else total <= linear.bound
