"""Next values in formulas: what rules make of a state stands in their place, with the worst of all errors."""

import re
from fractions import Fraction as F
from itertools import product

import numpy as np
import pytest

from codegen.errors import InputError
from tests.support.system_cases import policy, team
from verify.claims.formula import coordinates, holds
from verify.claims.region import UNBOUNDED
from verify.question import Budgets, Question
from verify.reach.decide import decide
from verify.result import Verdict
from verify.subjects import ClosedLoop
from verify.systems.files import statement_of
from verify.systems.properties import claims_of

WORLD = """
name = "sled"
steps = 5

[variables]
x = { unit = "m", range = [-2, 2] }
v = { unit = "m/s", range = [-1, 1] }

[agents.a]
team = "sleds"
[agents.a.features]
place = "x"
[agents.a.actions]
left = { push = "-1/2 m/s" }
right = { push = "1/2 m/s" }

[start]
box = { x = [-1, 1], v = [0, 0] }
RULES

[[property]]
formula = "FORMULA"
"""
AFFINE = """
[dynamics.next]
x = "x + 0.5[s]*v"
v = "0.5*v + a.push"
[dynamics.error]
v = [-0.125, 0.25]
"""
CASES = """
[[dynamics.piece]]
when = "x < 0[m]"
next = { x = "x + 0.5[s]*v", v = "0.5*v + a.push" }
[[dynamics.piece]]
when = "otherwise"
next = { x = "x", v = "choice(-1[m/s], 0.5[m/s])" }
"""
CURVED = """
[dynamics.next]
x = "x + 0.25[s^2/m]*v*v"
v = "0.5*v + a.push"
[dynamics.cuts]
v = 4
"""
PROFILE = team(policy("a", ["place"], ["left", "right"], ((0, 0.0), 1, 0)))


def claim_of(rules, formula):
    text = WORLD.replace("RULES", rules).replace("FORMULA", formula)
    statement = statement_of(text, "sled.toml")
    (claim,) = claims_of(statement, PROFILE, "sled.toml")
    return statement.system, claim


def answered(rules, formula):
    system, claim = claim_of(rules, formula)
    asked = Question(ClosedLoop(PROFILE, system), claim, UNBOUNDED, budgets=Budgets(samples=256))
    return decide(asked).verdict


NEAR = "x' <= x + 0.5[m] and x' >= x - 0.5[m]"
KNOWN = [
    (AFFINE, NEAR, Verdict.PROVED),
    (AFFINE, "x' <= x + 0.49[m]", Verdict.VIOLATED),
    (AFFINE, "x >= 0.1[m] implies v' <= 0.25[m/s]", Verdict.PROVED),  # left: 0.5 - 0.5 + 0.25
    (AFFINE, "x >= 0.1[m] implies v' <= 0.24[m/s]", Verdict.VIOLATED),
    (AFFINE, "acts(a) == left implies v' <= 0.5*v - 0.25[m/s]", Verdict.PROVED),
    (AFFINE, "acts(a) == left implies v' < 0.5*v - 0.25[m/s]", Verdict.VIOLATED),
    (AFFINE, "|x'| <= 3[m] and not v' > 2[m/s]", Verdict.PROVED),
    (CASES, "x >= 0[m] implies x' == x", Verdict.PROVED),
    (CASES, "x' == x", Verdict.VIOLATED),
    (CASES, "x >= 0[m] implies v' <= -1[m/s]", Verdict.VIOLATED),  # the other choice
    (CASES, "x >= 0[m] implies v' <= 0.5[m/s]", Verdict.PROVED),
    (CURVED, "x' >= x - 0.1[m] and x' <= x + 0.35[m]", Verdict.PROVED),
    (
        CURVED,
        'x*v >= 1[m^2/s] and v >= 0[m/s] implies x\' >= 0.5[m]"\ncuts = { x = 4, v = 4 }\nlabel = "',
        Verdict.PROVED,
    ),
]


@pytest.mark.parametrize(("rules", "formula", "known"), KNOWN, ids=[str(number) for number in range(len(KNOWN))])
def test_known_answers(rules, formula, known):
    _, claim = claim_of(rules, formula)
    assert claim.written == formula.partition('"')[0]
    assert not any(name.endswith("'") for name in coordinates(claim.formula))
    assert answered(rules, formula) is known


def judged(written, state, after, action):
    """A formula of this file, by Python: an evaluator of its own."""
    text = re.sub(r"\[[^\]]*\]", "", written).replace("|x'|", "abs(x')")
    text = re.sub(r"acts\(a\) == (\w+)", rf"('{action}' == '\1')", text)
    if " implies " in text:
        text = "not ({}) or ({})".format(*text.split(" implies ", 1))
    text = text.replace("x'", "nx").replace("v'", "nv")
    text = re.sub(r"\d+\.\d+", lambda number: f"F('{number[0]}')", text)
    return eval(text, {"F": F, "abs": abs}, {**state, "nx": after["x"], "nv": after["v"]})


@pytest.mark.parametrize("rules", [AFFINE, CASES], ids=["affine", "cases"])
def test_formulas_say_what_steps_do(rules):
    """In states at random and on borders: the formula that is proved holds just where it does after every step."""
    rng = np.random.default_rng(5)
    formulas = [formula for own, formula, _ in KNOWN if own == rules] + ["x' > 0[m] or v' < 0[m/s]", "not x' == 1[m]"]
    for written in formulas:
        system, claim = claim_of(rules, written)
        for _ in range(30):
            x, v = (F(int(rng.integers(-8, 9)), 4), F(int(rng.integers(-4, 5)), 4))
            state = {"x": x, "v": v}
            for number, action in enumerate(("left", "right")):
                ends = [
                    piece.step(state, {"a": action}, dict(zip(piece.error, error, strict=True)))
                    for piece in system.pieces
                    if piece.holds(state)
                    for error in product(*piece.error.values())
                ]
                told = [judged(written, state, after, action) for after in ends]
                surely = holds(claim.formula, state, {"a": number})
                weaker = claim.formula if claim.curved is None else claim.curved.weaker.formula
                assert holds(weaker, state, {"a": number}) == all(told)
                assert surely == all(told) or (not surely and " or " in written)


@pytest.mark.parametrize(
    ("formula", "said"),
    [
        ("x'*v <= 1", "linear"), ("y' <= 1", "is no next value"), ("x'' <= 1", "cannot"),
        ("v' <= 1[m]", "units do not fit"),
    ],
)  # fmt: skip
def test_what_is_refused(formula, said):
    with pytest.raises(InputError, match=said):
        claim_of(AFFINE, formula)


def test_regions_and_rules_have_no_next_values():
    """They say what is claimed instead, and products in regions how lines stand for them."""
    text = WORLD.replace("RULES", AFFINE).replace(
        'formula = "FORMULA"', 'name = "stays_in"\nregion = { where = ["W"] }'
    )
    for where, said in (("x' <= 1", "next value"), ("x*v <= 1", "lines bound a product")):
        with pytest.raises(InputError) as refused:
            claims_of(statement_of(text.replace("W", where), "sled.toml"), PROFILE, "sled.toml")
        assert said in refused.value.next_step
    with pytest.raises(InputError, match="cannot read"):
        statement_of(WORLD.replace("RULES", AFFINE.replace("0.5*v", "0.5*v'")), "sled.toml")
