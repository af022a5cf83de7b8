"""Stated systems as data: forms, half spaces and steps in exact numbers."""

from fractions import Fraction as F

from verify.systems.system import Affine, HalfSpace, Piece


def test_a_form_adds_multiples_and_drops_what_is_zero():
    form = Affine.of({"x": F(2), "v": F(1, 10), "w": F(0)}, F(-1))
    assert form.terms == (("v", F(1, 10)), ("x", F(2)))
    assert form.at({"x": F(3), "v": F(5), "w": F(7)}) == F(11, 2)
    assert form.plus(Affine.of({"x": F(1)}), F(-2)) == Affine.of({"v": F(1, 10)}, F(-1))
    assert form.plus(form, F(-1)) == Affine()


def test_a_half_space_holds_its_edge_unless_it_is_strict():
    for strict in (False, True):
        half = HalfSpace(Affine.of({"x": F(1)}, F(-2)), strict)
        assert [half.holds({"x": x}) for x in (F(1), F(2), F(3))] == [True, not strict, False]


def test_a_step_adds_effects_and_errors():
    piece = Piece(
        where={},
        move={"x": Affine.of({"x": F(1), "v": F(1, 5)}), "v": Affine.of({"v": F(1)})},
        effect={("a", "push"): {"v": Affine.of({"x": F(-1)}, F(1, 2))}, ("b", "push"): {"v": Affine((), F(1))}},
    )
    state = {"x": F(1), "v": F(10)}
    assert piece.step(state, {"a": "push", "b": "rest"}, {}) == {"x": F(3), "v": F(19, 2)}
    assert piece.step(state, {"a": "push", "b": "push"}, {"v": F(1, 7)}) == {"x": F(3), "v": F(21, 2) + F(1, 7)}
