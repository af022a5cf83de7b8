"""Enclosures: the values of what is not affine lie within them, and they are not much wider than need be."""

from fractions import Fraction as F

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from codegen.errors import InputError
from tests.support.systems import CURVED, MOUNTAIN
from verify.spending import listening
from verify.systems.enclosures import Enclosing
from verify.systems.files import statement_of
from verify.systems.observing import function
from verify.systems.parsing import Names, expression_of

NAMES = Names({"x": (), "y": ()})
TEXTS = (
    "sin(x)",
    "cos(3*x)",
    "x**2",
    "x**5 - y**3",
    "x*y",
    "x*y*(x - y)",
    "1/(3 + x)",
    "clip(x, -0.5, 0.25)",
    "sin(x)*cos(y) - 0.1*x**2",
    "(sin(x) - cos(x)*y)/(2 + y**2)",
    "x/(1 + clip(y, 0, 1))",
    "sin(12*x)",
    "cos(25 + 0.1*x)",
)
END = st.fractions(-1, 1, max_denominator=50)


@pytest.mark.parametrize("text", TEXTS)
@given(ends=st.tuples(END, END, END, END))
def test_values_lie_in_the_enclosure(text, ends):
    """By sampling, corners among the samples: no proof, but it knows nothing of the method."""
    box = {"x": (min(ends[:2]), max(ends[:2])), "y": (min(ends[2:]), max(ends[2:]))}
    expression = expression_of(text, NAMES, "").value
    form, ends = Enclosing(box).of(expression, "")
    low, high = (float(end) for end in ends)
    constant, factors = float(form.constant), [(float(factor), name) for name, factor in form.terms]
    for x in np.linspace(*map(float, box["x"]), 7):
        for y in np.linspace(*map(float, box["y"]), 5):
            state = {"x": float(x), "y": float(y)}
            off = function(expression)(state) - constant - sum(factor * state[name] for factor, name in factors)
            assert low - 1e-12 <= off <= high + 1e-12


def test_what_may_be_undefined_is_refused():
    for text in ("1/x", "1/(x - y)", "y/sin(x)", "sin(40*x)"):
        with pytest.raises(InputError, match=r"a denominator may be 0|sin of more than"):
            Enclosing({"x": (F(-1), F(1)), "y": (F(0), F(1))}).of(expression_of(text, NAMES, "").value, "f")


def test_ranges_are_cut_into_as_many_parts_as_asked():
    pieces = statement_of(MOUNTAIN, "f").system.pieces
    assert len(pieces) == 10 and pieces[0].where["position"] == (F(-11, 10), F(-937, 1000))
    assert max(float(piece.error["velocity"][1]) for piece in pieces) < 0.0025 * (3 * 0.163) ** 2 / 16 * 1.1
    assert len(statement_of(CURVED, "f").system.pieces) == 6
    with pytest.raises(InputError, match="more than 4096 pieces"):
        statement_of(CURVED.replace("x = 3\ny = 2", "x = 100\ny = 100"), "f")


@pytest.mark.timeout(300)  # seconds, where it took minutes
def test_many_pieces_are_made_while_somebody_waits():
    """256 enclosures, of which those over the same range share what is known; it says how far it is."""
    text = CURVED.replace("x = 3\ny = 2", "x = 16\ny = 16")
    told = []
    with listening(lambda *given: told.append(given)):
        assert len(statement_of(text, "f").system.pieces) == 256
    assert told[0] == (1, 256, "pieces made from rules") and told[-1][0] == 256
