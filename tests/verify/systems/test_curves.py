"""Formulas with products and functions: what they follow from, what follows from them, and that forgeries are found."""

from dataclasses import replace
from fractions import Fraction as F

import numpy as np
import pytest

from codegen.errors import InputError
from verify.checker.reading import RejectedError
from verify.checker.systems.enclosures import ensure_curves
from verify.claims.formula import holds
from verify.systems.files import statement_of
from verify.systems.properties import _ClaimReader
from verify.systems.system import Affine

WORLD = """
name = "leaning"
[constants]
far = "0.3 m"
[variables]
x = { unit = "m", range = [-1, 1] }
v = { unit = "m/s", range = [-2, 2] }
mode = { modes = ["low", "high"] }
[agents.cart.features]
x = "x"
[agents.cart.actions]
left = {}
right = {}
[start]
box = { x = 0, v = 0, mode = 'low' }
"""
FORMULAS = {
    "x*v > 0.1": lambda x, v, m, a: x * v > 0.1,
    "x*v >= 0.1 and x > 0 implies acts(cart) == right": lambda x, v, m, a: not (x * v >= 0.1 and x > 0) or a,
    "not (x*v < 0.2 or mode == high) or v**2 <= 1": lambda x, v, m, a: not (x * v < 0.2 or m) or v * v <= 1,
    "2*x*v - x**2/(3 + v) != x": lambda x, v, m, a: 2 * x * v - x * x / (3 + v) != x,
    "exp(-x/1[m])*v < 1[m/s] + v": lambda x, v, m, a: np.exp(-x) * v < 1 + v,
    "sqrt(x + 1) == v": lambda x, v, m, a: np.sqrt(x + 1) == v,
    "x*far < far*far": lambda x, v, m, a: x < 0.3,
    "0.5[m]*x < x*x": lambda x, v, m, a: 0.5 * x < x * x,
}


def claim(formula, more=""):
    statement = statement_of(f'{WORLD}\n[[property]]\nformula = "{formula}"\n{more}', "f")
    return _ClaimReader.of_file(statement).read(statement.properties, statement.place)[0], statement


@pytest.mark.parametrize("formula", FORMULAS)
def test_one_formula_implies_it_and_one_follows_from_it(formula):
    found, _ = claim(formula, "cuts = { x = 6, v = 7 }" if "x*v" in formula or "exp" in formula else "")
    random, open_ = np.random.default_rng(0), 0
    for x, v in [*(random.uniform(-1, 1, (40, 2)) * (1, 2)).tolist(), [1.0, -2.0], [-1.0, 2.0], [0.0, 0.0]]:
        for m, a in ((0, 0), (1, 1)):
            state = {"x": F(x), "v": F(v), "mode": F(m)}
            true = FORMULAS[formula](x, v, m, a)
            stronger = holds(found.formula, state, {"cart": a})
            weaker = stronger if found.curved is None else holds(found.curved.weaker.formula, state, {"cart": a})
            assert stronger <= true <= weaker, (x, v)
            open_ += stronger < weaker
    assert open_ <= (86 if "=" in formula and ">" not in formula else 30)
    assert (found.curved is None) == (formula == "x*far < far*far")


def test_enclosures_are_shown_and_forged_ones_are_not():
    found, statement = claim("x*v > 0.1 and sqrt(x + 2) < 0.9", "cuts = { x = 6, v = 5 }")
    ranges = {one.name: one.range for one in statement.system.variables}
    known = found.curved.enclosures
    assert ensure_curves(known, ranges) == 36
    first = known[0]
    for forged in (
        (replaced(first, error=tuple(end / 2 for end in first.error)), *known[1:]),
        (replaced(first, form=first.form.plus(Affine.of({}, F(1, 2)))), *known[1:]),
        (replaced(first, curve=known[1].curve), *known[1:]),
        (replaced(first, cell={"x": (F(-1), F(-9, 10)), "v": (F(-2), F(-1))}), *known[1:]),
        known[1:],
        known[:-1],
    ):
        with pytest.raises(RejectedError):
            ensure_curves(forged, ranges)


def replaced(enclosure, **changes):
    return enclosure._replace(**changes)


@pytest.mark.parametrize(
    ("formula", "more", "words"),
    [
        ("x*v > 0.1", "cuts = { x = 100, v = 100 }", "10,000 cells"),
        ("x*v > 0.1", "cuts = { mode = 2 }", "unknown variable of a product or function 'mode'"),
        ("x > 0.1", "cuts = { x = 2 }", "unknown variable of a product or function 'x'"),
        ("1/x > 0.1", "", "a denominator may be 0"),
        ("sqrt(x) > 0.1", "", "sqrt of what may be below 0"),
        ("x*mode > 0.1", "", "mode is a mode, and no number"),
        ("x*v > 0.1[m]", "", "units do not fit"),
        ("x' > 0.1", "", "x' is no next value that is known here"),
        ("x*y > 0.1", "", "unknown name 'y'"),
    ],
)
def test_what_is_refused(formula, more, words):
    with pytest.raises(InputError, match=words):
        claim(formula, more)


def test_the_words_of_a_claim_are_those_of_the_file():
    found, _ = claim("x*v > 0.1", 'label = "far"')
    assert found.written == found.curved.weaker.written == "x*v > 0.1" and found.curved.weaker.label == "far"
    assert replace(found, label="") == found


def test_a_formula_that_enclosures_alone_decide_has_them_shown():
    found, statement = claim("not (sqrt(x + 2) < 0.9)")
    assert found.curved.enclosures and found.formula == found.curved.weaker.formula
    assert ensure_curves(found.curved.enclosures, {one.name: one.range for one in statement.system.variables})
