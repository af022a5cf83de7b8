"""Pieces and what all of them share: name by name a piece's own tables come first, and nothing shared is lost."""

from fractions import Fraction as F

import pytest

from codegen.errors import InputError
from tests.support.systems import CART
from verify.systems.files import statement_of

HEAD = CART[: CART.index("[dynamics.next]")]
LEFT, RIGHT = "where = { x = [-10, 0] }", "where = { x = [0, 10] }"
NEXT = 'next = { x = "x + dt*v", v = "v + dt*cart.a" }'


def rules(shared, own, other="", head=HEAD):
    """The rules of a file with tables of all pieces, and of two pieces."""
    text = f"{head}\n[dynamics]\n{shared}\n[[dynamics.piece]]\n{LEFT}\n{own}\n[[dynamics.piece]]\n{RIGHT}\n{other}\n"
    return statement_of(text, "f").rules


ERROR = {"v": (F(-1, 10), F(1, 10))}
WIDE = {"x": (F(-1), F(1))}


@pytest.mark.parametrize(
    ("shared", "own", "left", "right"),
    [
        ("cuts = { v = 3 }", "", {"v": 3}, {"v": 3}),
        ("cuts = { v = 3 }", "cuts = { x = 2 }", {"v": 3, "x": 2}, {"v": 3}),
        ("cuts = { v = 3 }", "cuts = { v = 2 }", {"v": 2}, {"v": 3}),
        ("", "cuts = { v = 2 }", {"v": 2}, {}),
        ("", "", {}, {}),
        ("error = { v = 0.1 }", "", ERROR, ERROR),
        ("", "error = { v = 0.1 }", ERROR, {}),
        ("error = { v = 0.1 }", "error = { x = 1 }", ERROR | WIDE, ERROR),
        ("error = { v = 0.1 }", "error = { v = [0, 0.2] }", {"v": (F(0), F(1, 5))}, ERROR),
        ("error = { v = 0.1, x = 1 }", "error = { v = 0 }", WIDE, ERROR | WIDE),
        ("error = { v = 0.1 }", "error = {}", ERROR, ERROR),
    ],
)
def test_errors_and_cuts(shared, own, left, right):
    assert [{**rule.error, **rule.cuts} for rule in rules(f"{NEXT}\n{shared}", own)] == [left, right]


def test_the_next_values_that_a_piece_leaves_out_are_those_of_all():
    shared = 'next = { x = "x", v = "v + dt*cart.a" }'
    left, right = rules(shared, 'next = { v = "0.5*v" }')
    assert left.move["x"] == right.move["x"] and left.move["v"] != right.move["v"]
    assert not left.effect and right.effect
    with pytest.raises(InputError, match="nothing says how x moves"):
        rules('next = { v = "v" }', 'next = { x = "x" }')


def test_names_for_parts_of_expressions_hold_in_what_all_share():
    shared = 'let = { drag = "0.1*v", drop = "2*drag" }\nnext = { x = "x + dt*v", v = "v - drop" }'
    left, right = rules(shared, 'let = { drag = "0.2*v" }')
    assert left.move != right.move
    left, right = rules(shared, 'let = { lift = "0.2*v" }\nnext = { v = "v - drop + lift" }')
    assert left.move["x"] == right.move["x"] and left.move["v"] != right.move["v"]


def test_effects_of_actions_by_matrices():
    shared = "A = [[1, 0.2], [0, 1]]\nB = { cart = { left = [0, -0.1], right = [0, 0.1] } }"
    left, right = rules(shared, "B = { cart = { left = [0, -0.5] } }")
    assert left.effect["cart", "right"] == right.effect["cart", "right"]
    assert left.effect["cart", "left"] != right.effect["cart", "left"]
    left, right = rules(shared, "A = [[1, 0.1], [0, 1]]")
    assert left.effect == right.effect and left.move["x"] != right.move["x"]
    left, right = rules(f"{shared}\nc = [0, 1]", "c = [1, 0]")
    assert left.move != right.move and left.effect == right.effect


def test_expressions_and_matrices_do_not_mix():
    with pytest.raises(InputError, match="both next and A"):
        rules("A = [[1, 0.2], [0, 1]]", NEXT)
    with pytest.raises(InputError, match="both next and B"):
        rules(f"{NEXT}\n", "B = { cart = { left = [0, -0.5] } }")


# --- a name that is written twice


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('dt = "0.2 s"\n\n[constants]', 'dt = "0.2 s"\n\n[constants]\ndt = "0.1 s"', "'dt' is stated twice"),
        ("box = { x = [-1, 1]", 'box = { "a.b" = 1, a = { b = 2 }, x = [-1, 1]', "'a.b' stands twice in one table"),
        ("[variables]", '[variables]\n"a.b" = { range = [0, 1] }\na.b = { range = [0, 2] }', "'a.b' stands twice"),
        ("[dynamics.next]", '[dynamics.error]\n"a.b" = 1\na.b = 2\n[dynamics.next]', "'a.b' stands twice"),
        ("[dynamics.next]", '[dynamics.next]\n"a.b" = "x"\na.b = "v"', "'a.b' stands twice"),
    ],
)
def test_no_value_replaces_another_of_the_same_name(old, new, said):
    assert CART.count(old) == 1
    with pytest.raises(InputError) as raised:
        statement_of(CART.replace(old, new), "f")
    assert said in raised.value.what
