"""Pieces of rules: together they cover the rules' boxes, and in each the stated motion lies within form and error."""

from dataclasses import replace
from fractions import Fraction as F

import numpy as np
import pytest

from codegen.errors import InputError
from tests.support.systems import CART
from verify.spending import listening
from verify.systems import enclosures
from verify.systems.files import statement_of
from verify.systems.system import Variable

HEAD = CART[: CART.index("[dynamics.next]")]
PLAIN = '[dynamics]\nnext = { x = "x + dt*v", v = "v + dt*cart.a" }\n'
CURVED = (
    '[dynamics]\nnext = { x = "x + dt*v*sin(0.3[1/m]*x)", v = "v + dt*cart.a*cos(0.1[1/m]*x)" }\n'
    "cuts = { x = 5, v = 2 }\nerror = { v = [0, 0.25] }\n"
)
NEAR = 1e-9


def stated(dynamics, head=HEAD):
    found = statement_of(head + dynamics, "f")
    return found, {variable.name: variable.range for variable in found.system.variables}


def within(box, at):
    return all(low <= at[name] <= high for name, (low, high) in box.items())


def test_cells_are_parts_of_the_ranges_that_meet_at_borders_only():
    found, ranges = stated(CURVED)
    (rule,) = found.rules
    assert enclosures.list_curved(rule) == ("v", "x") and enclosures.count(rule) == 10
    cells = list(enclosures.cells(rule, ranges))
    assert len(cells) == 10 == len({tuple(sorted(cell.items())) for cell in cells})
    volume = sum((x[1] - x[0]) * (v[1] - v[0]) for x, v in ((cell["x"], cell["v"]) for cell in cells))
    (a, b), (c, d) = ranges["x"], ranges["v"]
    assert volume == (b - a) * (d - c)
    rng = np.random.default_rng(0)
    for x, v in rng.uniform([float(a), float(c)], [float(b), float(d)], (200, 2)).tolist():
        assert sum(within(cell, {"x": F(x), "v": F(v)}) for cell in cells) == 1
    assert sum(within(cell, {"x": a + (b - a) / 5, "v": F(0)}) for cell in cells) == 4, "a corner of four cells"


def test_a_box_of_a_piece_is_cut_within_the_ranges():
    text = CURVED.replace("[dynamics]", "[dynamics]\n").split("cuts")[0]
    piece = (
        "[[dynamics.piece]]\nwhere = { x = [-30, 0] }\ncuts = { x = 2 }\n[[dynamics.piece]]\nwhere = { x = [0, 10] }\n"
    )
    found, ranges = stated(text + piece)
    assert [cell["x"] for cell in enclosures.cells(found.rules[0], ranges)] == [(-10, -5), (-5, 0)]
    assert [piece.where["x"] for piece in found.system.pieces] == [(-10, -5), (-5, 0), (0, 10)]


def test_what_would_be_too_many_pieces_is_refused_before_any_is_made():
    found, _ = stated(CURVED)
    (rule,) = found.rules
    many = replace(rule, cuts={"x": 1_000, "v": 5})
    told = []
    with listening(lambda *given: told.append(given)), pytest.raises(InputError, match="more than 4096 pieces"):
        enclosures.pieces([many], found.system.variables, "f")
    assert not told
    with listening(lambda *given: told.append(given)):
        assert enclosures.pieces([rule], found.system.variables, "f") == found.system.pieces
    assert [done for done, *_ in told] == sorted(done for done, *_ in told) and told[-1][:2] == (10, 10)


def test_errors_of_actions_are_those_of_the_widest():
    """One of them is chosen in a step, so their enclosures do not add up, but join the user's and the motion's."""
    found, _ = stated(CURVED, HEAD.replace('push = "1/2 m/s^2"', 'push = "1/8 m/s^2"'))
    (rule,) = found.rules
    variables = tuple(Variable(v.name, v.unit, v.range) for v in found.system.variables)
    alone = {
        action: enclosures.pieces([replace(rule, effect={key: each}, error={})], variables, "f")
        for key, each in rule.effect.items()
        for action in [key[1]]
    }
    for number, piece in enumerate(found.system.pieces):
        ends = [made[number].error.get("v", (F(0), F(0))) for made in alone.values()]
        low, high = min(0, *(end[0] for end in ends)), max(0, *(end[1] for end in ends))
        assert piece.error["v"] == (low, high + F(1, 4))
