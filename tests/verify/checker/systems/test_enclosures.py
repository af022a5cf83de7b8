"""Enclosures are shown again by another arithmetic, and those that are too tight or beside the rule are refused."""

import math
from dataclasses import replace
from fractions import Fraction as F

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.support.systems import CART, CURVED, MOUNTAIN, with_piece
from verify.checker.reading import RejectedError
from verify.checker.systems.enclosures import ONE, ensure_enclosed, power, waves_at
from verify.checker.systems.enclosures import Range as Bounds
from verify.systems.files import statement_of
from verify.systems.system import Affine

PIECES = """
name = "two"
steps = 3
[variables]
x = { range = [-1, 1] }
[agents.one.features]
x = "x"
[agents.one.actions]
go = {}
[start]
box = { x = 0 }
[[dynamics.piece]]
where = { x = [-1, 0] }
next = { x = "x*x" }
[[dynamics.piece]]
where = { x = [0, 1] }
next = { x = "sin(x)" }
cuts = { x = 2 }
"""


@given(st.floats(-30, 30))
def test_sin_and_cos(angle):
    """Against the platform's, within their rounding; the bounds are far narrower than a double."""
    sin, cos = waves_at(int(angle * ONE))
    for bounds, known in ((sin, math.sin(angle)), (cos, math.cos(angle))):
        assert abs(bounds.low / ONE - known) < 1e-13 and 0 <= bounds.high - bounds.low < 2**60


@given(st.integers(-8, 8), st.integers(0, 8), st.integers(1, 6))
def test_powers(low, width, exponent):
    found = power(Bounds(low * ONE // 4, (low + width) * ONE // 4), exponent)
    values = [F(low + k, 4) ** exponent for k in range(width + 1)]
    assert found.low <= min(values) * ONE and max(values) * ONE <= found.high
    ends = [F(low, 4) ** exponent, F(low + width, 4) ** exponent]
    within = [*ends, F(0)] if low < 0 < low + width and exponent % 2 == 0 else ends
    assert found.low >= min(within) * ONE - 8 and found.high <= max(within) * ONE + 8


@pytest.mark.parametrize(("text", "bounds"), [(CART, 0), (MOUNTAIN, 20), (CURVED, 10), (PIECES, 3)])
def test_enclosures_are_shown(text, bounds):
    assert ensure_enclosed(statement_of(text, "f")) >= bounds


@pytest.mark.parametrize("text", [MOUNTAIN, CURVED])
def test_tighter_errors_are_refused(text):
    """The error of each piece, made narrower than the curve itself, which is about as wide as the enclosure."""
    statement = statement_of(text, "f")
    for number, piece in enumerate(statement.system.pieces):
        error = {name: (low / 2, high / 2) for name, (low, high) in piece.error.items()}
        with pytest.raises(RejectedError, match=r"its error (is exceeded|was not shown)"):
            ensure_enclosed(with_piece(statement, number, error=error))


def test_faults_in_pieces_are_caught():
    statement = statement_of(MOUNTAIN, "f")
    piece = statement.system.pieces[3]
    one = Affine.of({"position": F(1, 100)})
    faults = [
        {"move": {**piece.move, "position": piece.move["position"].plus(one)}},
        {"move": {**piece.move, "velocity": piece.move["velocity"].plus(Affine((), F(1, 1000)))}},
        {"error": {}},
        {"effect": {}},
        {"effect": {**piece.effect, ("agent", "coast"): {"velocity": Affine((), F(1, 100))}}},
        {"where": {"position": piece.where["position"]} | {"position": (F(-1), F(0))}},
        {"where": {}},
    ]
    for fault in faults:
        with pytest.raises(RejectedError):
            ensure_enclosed(with_piece(statement, 3, **fault))


def test_faults_in_exact_pieces_are_caught():
    statement = statement_of(CART, "f")
    piece = statement.system.pieces[0]
    faults = [
        {"move": {**piece.move, "x": piece.move["x"].plus(Affine((), F(1, 10**9)))}},
        {"effect": {**piece.effect, ("cart", "left"): {"v": Affine((), F(-2, 10))}}},
        {"error": {"x": (F(1, 10), F(2, 10))}},
        {"where": {"x": (F(-1), F(1))}},
    ]
    for fault in faults:
        with pytest.raises(RejectedError):
            ensure_enclosed(with_piece(statement, 0, **fault))


def test_stated_errors_are_part_of_a_piece():
    statement = statement_of(CART + "[dynamics.error]\nv = 0.1\n", "f")
    assert ensure_enclosed(statement) == 0
    with pytest.raises(RejectedError):
        ensure_enclosed(with_piece(statement, 0, error={"v": (F(-1, 20), F(1, 10))}))
    curved = statement_of(MOUNTAIN.replace("velocity = 1e-12", "velocity = 0.001"), "f")
    piece = curved.system.pieces[0]
    error = {**piece.error, "velocity": tuple(end * F(9, 10) for end in piece.error["velocity"])}
    with pytest.raises(RejectedError):
        ensure_enclosed(with_piece(curved, 0, error=error))


def test_a_piece_that_is_missing_is_noticed():
    statement = statement_of(PIECES, "f")
    for number in range(3):
        pieces = statement.system.pieces
        left = replace(statement.system, pieces=pieces[:number] + pieces[number + 1 :])
        with pytest.raises(RejectedError, match="leave out"):
            ensure_enclosed(replace(statement, system=left))


@pytest.mark.parametrize("text", ["sin(1)", "0.5*x + sin(1)*cos(2)", "1/(2 + sin(1))"])
def test_what_is_curved_without_a_variable(text):
    """sin 1 is a constant that no fraction is."""
    statement = statement_of(PIECES.replace('"sin(x)"', f'"{text}"'), "f")
    assert ensure_enclosed(statement)
    form = statement.system.pieces[-1].move["x"]
    with pytest.raises(RejectedError):
        ensure_enclosed(with_piece(statement, -1, move={"x": form.plus(Affine.of({}, F(1, 10**6)))}))


def many(moved):
    """Twelve agents with five actions each: a quarter of a billion joint actions. `moved`: what each agent moves."""
    agents = [f"a{k}" for k in range(12)]
    variables = dict.fromkeys(moved.format(agent) for agent in agents)
    lines = ["steps = 3", "[variables]", *(f"{name} = {{ range = [-1, 1] }}" for name in variables)]
    for agent in agents:
        lines += [f"[agents.{agent}.features]", f'f = "{moved.format(agent)}"', f"[agents.{agent}.actions]"]
        lines += [f"act{k} = {{ u = {k} }}" for k in range(5)]
    lines += ["[start.box]", *(f"{name} = 0" for name in variables), "[dynamics.next]"]
    for name in variables:
        acting = [agent for agent in agents if moved.format(agent) == name]
        lines.append(f'{name} = "{" + ".join([f"{name} - 0.1*{name}**2", *(f"{agent}.u" for agent in acting)])}"')
    return statement_of("\n".join(lines), "many")


@pytest.mark.parametrize("moved", ["x_{}", "x"])
def test_agents_that_act_as_the_rule_says_are_not_multiplied(moved):
    statement = many(moved)
    assert ensure_enclosed(statement) == len(statement.system.variables)
    piece = statement.system.pieces[0]
    (name, form), *_ = piece.effect["a7", "act3"].items()
    wrong = {**piece.effect, ("a7", "act3"): {name: form.plus(Affine.of({}, F(1)))}}
    with pytest.raises(RejectedError):
        ensure_enclosed(with_piece(statement, 0, effect=wrong))
