"""World files, and the values in them."""

from fractions import Fraction as F

import pytest

from codegen.errors import InputError
from tests.support.systems import CART, CURVED
from verify.language.units import unit_of
from verify.systems import values
from verify.systems.files import statement_of
from verify.systems.system import Affine, Feature, Measure
from verify.toml_places import parse


def system_of(text, name):
    return statement_of(text, name).system


def changed(old, new, text=CART):
    assert text.count(old) == 1, text.count(old)
    return text.replace(old, new)


MATRICES = (
    CART[: CART.index("[dynamics.next]")]
    + """
[dynamics]
A = [[1, 0.2], [0, 1]]
[dynamics.B.cart]
left = [0, -0.1]
right = [0, "1/10"]
"""
)
PIECES = (
    CART[: CART.index("[dynamics.next]")]
    + """
[[dynamics.piece]]
where = { x = [-10, 0] }
next = { x = "x + dt*v", v = "v" }
[[dynamics.piece]]
where = { x = [0, 10] }
next = { x = "x + dt*v", v = "0.5*v" }
error = { v = [-0.1, 0.3] }
"""
)


def test_a_file_states_variables_features_start_and_motion():
    system = system_of(CART, "cart.toml")
    assert [(each.name, each.unit, each.range) for each in system.variables] == [
        ("x", "m", (-10, 10)),
        ("v", "m/s", (-5, 5)),
    ]
    assert system.features["cart"] == {
        "place": Feature(Affine.of({"x": F(1)})),
        "ahead": Feature(Affine.of({"x": F(1), "v": F(1)})),
        "side": Feature(Affine.of({"x": F(1)}, F(-1, 10)), Measure.SIGN),
        "moving": Feature(Affine.of({"v": F(1)}), Measure.POSITIVE),
        "near": Feature(Affine.of({"x": F(1)}), Measure.CLIP, (F(-1), F(1))),
    }
    inside, outside = {"x": F(1), "v": F(0)}, {"x": F(1), "v": F(1, 10**9)}
    assert all(half.holds(inside) for half in system.start) and not all(half.holds(outside) for half in system.start)
    assert system.steps == 10 and system.name == "cart"


def test_a_step_is_exact():
    piece = system_of(CART, "cart.toml").pieces[0]
    state = {"x": F(1, 3), "v": F(1, 7)}
    assert piece.step(state, {"cart": "left"}, {}) == {"x": F(1, 3) + F(1, 35), "v": F(1, 7) - F(1, 10)}
    assert piece.step(state, {"cart": "stay"}, {}) == {"x": F(1, 3) + F(1, 35), "v": F(1, 7)}
    assert piece.step(state, {"cart": "right"}, {})["v"] == F(1, 7) + F(1, 10)


def test_matrices_say_the_same_as_expressions():
    one, other = (system_of(text, "cart.toml").pieces[0] for text in (CART, MATRICES))
    assert one.move == other.move
    state = {"x": F(5), "v": F(-2)}
    for action in ("stay", "left", "right"):
        assert one.step(state, {"cart": action}, {}) == other.step(state, {"cart": action}, {})


def test_decimals_are_read_as_written():
    text = changed('"x + dt*v"', '"0.1*x + 0.3*x + 1e-3*x + dt*v"')
    assert dict(system_of(text, "f").pieces[0].move["x"].terms)["x"] == F(401, 1000)
    assert system_of(changed("x = [-1, 1]", "x = [-0.1, 0.3]"), "f").start[1].form.constant == F(-3, 10)


def test_pieces_have_boxes_and_errors():
    first, second = system_of(PIECES, "f").pieces
    assert first.where == {"x": (-10, 0)} and second.where == {"x": (0, 10)}
    assert first.error == {} and second.error == {"v": (F(-1, 10), F(3, 10))}


def test_names_with_dots_and_agents_that_share_variables():
    text = CART.replace('x = { unit = "m"', '"cart.x" = { unit = "m"').replace("x = [-1, 1]", "cart.x = [-1, 1]")
    text = (
        text.replace('"x', '"cart.x')
        .replace("n(x", "n(cart.x")
        .replace("p(x", "p(cart.x")
        .replace("\nx = ", "\ncart.x = ")
    )
    assert system_of(text, "f").variables[0].name == "cart.x"
    shared = system_of(CURVED, "f").pieces[0]
    assert {agent for agent, _ in shared.effect} == {"one", "two"}


def test_a_world_without_dynamics():
    system = system_of(CART[: CART.index("[dynamics.next]")], "f")
    assert system.pieces == () and system.steps == 0


@pytest.mark.parametrize(
    ("text", "what", "where"),
    [
        # units that do not fit
        (changed('"x + dt*v"', '"x + v"'), "units do not fit: m and m/s", "dynamics.next.x, column 3"),
        (changed('"x + dt*v"', '"x + 0.2*v"'), "units do not fit: m and m/s", "dynamics.next.x"),
        (changed('"x + dt*v"', '"v"'), "units do not fit: the unit is m/s, and m is needed", "dynamics.next.x"),
        (changed('"-0.5 m/s^2"', '"-0.5 m/s"'), "units do not fit: m/s^2, and m/s in another action", "right.a"),
        (changed("x + 1[s]*v", "x + v"), "units do not fit", "features.ahead"),
        (changed('unit = "m/s"', 'unit = "m//s"'), "cannot read the unit", "variables.v"),
        (changed("x = [-1, 1]", 'x = ["-1 s", 1]'), "units do not fit: the unit is s, and m is needed", "box.x"),
        (MATRICES.replace("0.2]", '"0.2 m"]'), "units do not fit", "dynamics.A 1, v"),
        # names
        (changed('place = "x"', 'place = "y"'), "unknown name 'y'", "features.place"),
        (changed('"v + dt*cart.a"', '"v + dt*cart.b"'), "unknown name 'cart.b'", "next.v"),
        (changed("[dynamics.next]", "[dynamics.nxet]"), "unknown key 'nxet'", "dynamics"),
        (changed("steps = 10", "steps = 10\nspeed = 3"), "unknown key 'speed'", "f"),
        (changed("x = [-1, 1], v", "x = [-1, 1], w = 0, v"), "unknown variable 'w'", "start.box"),
        (changed("v = { unit", "lambda = { unit"), "not a name: 'lambda'", "variables.lambda"),
        (changed("v = { unit", "goal = { unit"), "'goal' is the place of a game's goal", "variables.goal"),
        (changed("v = { unit", "X = { unit"), "another variable is 'X' but for its case", "variables.X"),
        (changed("v = { unit", "push = { unit"), "'push' is a constant too", "variables.push"),
        (changed("stay = {}", '"s tay" = {}'), "not a name", "actions.s tay"),
        (MATRICES.replace("left = [", "lefd = ["), "unknown action 'lefd'", "B.cart"),
        (MATRICES.replace("B.cart", "B.card"), "unknown agent 'card'", "B"),
        # shapes
        (MATRICES.replace("[0, 1]]", "[0, 1, 0]]"), "a row of 3, and there are 2 variables", "dynamics.A 2"),
        (MATRICES.replace("[[1, 0.2], [0, 1]]", "[[1, 0.2]]"), "A has 1 row, and there are 2 variables", "A"),
        (MATRICES.replace("[0, -0.1]", "[0]"), "a list of 1, where 2 are needed", "B.cart.left"),
        (MATRICES.replace("A =", "c = [1]\nA ="), "a list of 1, where 2 are needed", "dynamics.c"),
        (MATRICES.replace("A =", 'next = { x = "x", v = "v" }\nA ='), "both next and A", "dynamics"),
        # pieces
        (PIECES.replace("[0, 10]", "[-1, 10]"), "pieces 1 and 2 overlap", "dynamics"),
        (PIECES.replace("[0, 10]", "[1, 10]"), "pieces leave a gap: x in [0, 1]", "dynamics"),
        (PIECES.replace("[-10, 0]", "[-9, 0]"), "pieces leave a gap: x in [-10, -9]", "dynamics"),
        # errors
        (CART + "[dynamics.error]\nv = -0.1\n", "the error -1/10 is below 0", "error.v"),
        (CART + "[dynamics.error]\nv = [1, -1]\n", "the lower bound 1 is above the upper one -1", "error.v"),
        (CART + "[dynamics.error]\nw = 0\n", "unknown variable 'w'", "error"),
        # the start
        (changed("x = [-1, 1]", "x = [1, -1]"), "the lower bound 1 is above", "box.x"),
        (changed("v = [0, 0] }", 'v = [0, 0] }\nwhere = ["x > 1"]'), "the start region is empty", "start"),
        (changed("v = [0, 0] }", 'v = [0, 1] }\nwhere = ["x + 1[s]*v < -1", "v >= 0"]'), "region is empty", "start"),
        (changed(", v = [0, 0]", ""), "the start says nothing of v", "start.box"),
        (changed("x = [-1, 1]", "x = [-11, 1]"), "the start lies outside the range", "box.x"),
        # motion
        (changed('v = "v + dt*cart.a"', ""), "nothing says how v moves", "dynamics.next"),
        (changed("dt*cart.a", "dt*cart.a/(1[1/m]*x)"), "a denominator may be 0", "dynamics"),
        (changed("dt*cart.a", "dt*cart.a/sin(1[1/m]*x)"), "a denominator may be 0", "dynamics.next.v: x in [-10, 10]"),
        (CART + "[dynamics.cuts]\nx = 0\n", "not a whole number from 1 to", "cuts.x"),
        (changed("steps = 10", ""), "not a whole number", "steps"),
        # features and agents
        (changed('place = "x"', 'place = "x*x"'), "not a feature", "features.place"),
        (changed('place = "x"', 'place = "sign(sin(1[1/m]*x))"'), "not a feature", "features.place"),
        (changed('place = "x"', 'place = "clip(x, 1, -1)"'), "the bounds of clip", "features.place"),
        (CART[: CART.index("[agents.cart.actions]")], "an agent has no actions", "agents.cart.actions"),
        ("", "0 variables", "variables"),
        # numbers and texts
        (changed("range = [-10, 10]", "range = [-inf, 10]"), "not a number", "variables.x"),
        (changed("range = [-10, 10]", "range = [nan, 10]"), "not a number", "variables.x"),
        (changed("range = [-10, 10]", 'range = ["1/0", 10]'), "not a number", "variables.x"),
        (changed("range = [-10, 10]", "range = [-10]"), "a list of 1, where 2 are needed", "variables.x"),
        (changed('"x + dt*v"', '"x + 1e999*dt*v"'), "numbers may be at most", "next.x"),
        (changed('"x + dt*v"', '"x +"'), "ends too early", "next.x, column 4"),
        (changed('"x + dt*v"', '"x^2"'), "cannot go on with '^'", "next.x, column 2"),
        (changed('"x + dt*v"', '"__import__(os)"'), "unknown function", "next.x"),
        (changed('"x + dt*v"', '"' + "(" * 300 + "x" + ")" * 300 + '"'), "", "next.x"),
        (changed('"x + dt*v"', '"' + "x+" * 900 + 'x"'), "nested deeper", "next.x"),
        ("name = ", "not a readable file", "f:"),
    ],
)
def test_bad_input(text, what, where):
    with pytest.raises(InputError) as raised:
        statement_of(text, "f")
    assert what in raised.value.what and where in raised.value.where, (raised.value.what, raised.value.where)
    assert raised.value.next_step or "numbers may be" in raised.value.what


def test_an_expression_may_not_grow_without_end():
    lets = "\n".join(f'a{k + 1} = "a{k} + a{k}"' for k in range(60))
    text = CART.replace("[dynamics.next]", f'[dynamics.let]\na0 = "x"\n{lets}\n[dynamics.next]')
    with pytest.raises(InputError, match="more than 20000 parts"):
        statement_of(text, "f")


@pytest.mark.parametrize(
    ("first", "said"),
    [("2", "too large or too fine"), ("1/2", "too large or too fine"), ("1[1/m]*x", "multiplied more than 64 times")],
)
def test_powers_of_powers_are_refused(first, said):
    lets = "\n".join(f'a{k + 1} = "a{k}**8"' for k in range(60))
    text = CART.replace("[dynamics.next]", f'[dynamics.let]\na0 = "{first}"\n{lets}\n[dynamics.next]')
    with pytest.raises(InputError, match=said):
        statement_of(text, "f")


def test_an_input_that_every_action_leaves_at_0_is_known():
    text = changed('right = { a = "push" }', 'right = { a = "0 m/s^2" }')
    (piece,) = system_of(changed('left = { a = "-0.5 m/s^2" }', "left = { a = 0 }", text), "f").pieces
    assert piece.step({"x": F(1), "v": F(1)}, {"cart": "right"}, {}) == {"x": F(6, 5), "v": F(1)}


DOCUMENT, PLACE = parse('a = 1\n[table]\nx = "2"\n', "f", "no TOML", "")
NAMES = statement_of(CART, "f").names
METRE = unit_of("m", PLACE)


@pytest.mark.parametrize(
    ("given", "number", "unit"),
    [
        (3, F(3), None),
        ("9.8 m/s^2", F(49, 5), "m/s^2"),
        ("1/3", F(1, 3), None),
        ("-1e-3 m", F(-1, 1000), "m"),
        (".5 kg", F(1, 2), "kg"),
        ("2/4  m", F(1, 2), "m"),
        ("0.1", F(1, 10), None),
    ],
)
def test_a_quantity_is_an_exact_number_and_a_unit(given, number, unit):
    assert values.quantity(given, PLACE) == (number, None if unit is None else unit_of(unit, PLACE))


@pytest.mark.parametrize("given", ["", "m", "1 2", "1//3", "one", "1/0", "inf", "nan", True, None, [1], "1\n m", "--1"])
def test_what_is_no_quantity_is_refused(given):
    with pytest.raises(InputError) as raised:
        values.quantity(given, PLACE / "a")
    assert "f, line 1" in str(raised.value.where)


def test_a_unit_that_is_a_name_too_may_have_been_meant_as_a_product():
    assert values.as_typed("0.5*x", NAMES, PLACE).unit == METRE
    assert values.as_typed("0.5 m", NAMES, PLACE).unit == METRE
    with pytest.raises(InputError, match="is a unit, and the file has what is named so too"):
        values.as_typed("0.5 x", NAMES, PLACE)


@pytest.mark.parametrize("dotted", [False, True])
@pytest.mark.parametrize(
    "name", ["", "1a", "a.b.c", "_x", "lambda", "cart.if", "sin", "A" * 65, "é", "a b", "a.", ".a"]
)
def test_what_is_no_name(name, dotted):
    with pytest.raises(InputError, match="not a name"):
        values.as_name(name, PLACE, dotted)
    with pytest.raises(InputError, match=r"not a name: 'a\.b'"):
        values.as_name("a.b", PLACE)


def test_a_name_with_a_dot_may_be_written_as_two_tables():
    nested = {"cart": {"x": "m", "v": "m/s"}, "pole.angle": "rad", "y": {"unit": "m"}, "z": {"range": [0, 1]}}
    assert values.flat(nested, PLACE) == {
        "cart.x": "m",
        "cart.v": "m/s",
        "pole.angle": "rad",
        "y": {"unit": "m"},
        "z": {"range": [0, 1]},
    }
    with pytest.raises(InputError, match=r"'cart\.x' stands twice"):
        values.flat({"cart": {"x": 1}, "cart.x": 2}, PLACE)
