"""Claims of world files: their tables, and their words."""

from dataclasses import replace
from fractions import Fraction as F

import pytest

from codegen.errors import InputError
from tests.support.system_cases import policy, team
from tests.support.systems import CART
from verify.claims.formula import FALSE, TRUE, Acts, And, Not, Or, below, holds
from verify.systems.claims import Pattern, SystemClaim
from verify.systems.files import statement_of
from verify.systems.properties import claims_in, claims_of, ensure_claims, spell_claim
from verify.systems.system import Affine, HalfSpace

PROFILE = team(policy("cart", ["place"], ["stay", "left", "right"], 0))
ALL = """
[[property]]
label = "near"
name = "stays_in"
region = { box = { x = [-2, 2] }, where = ["x + 1[s]*v < 3/2"] }

[[property]]
name = "avoids"
steps = 5
region = [{ box = { x = [3, 4] } }, { where = ["v >= 2"] }]

[[property]]
name = "reaches"
region = { box = { x = 1 } }

[[property]]
name = "reaches_and_stays"
by = 4
region = { box = { v = [0, 1] } }

[[property]]
formula = "x > 1/2 implies not acts(cart) == right"
"""


@pytest.mark.parametrize(
    ("region", "said"),
    [
        ("{ box = { x = [0.5, 20] } }", "of the ranges with x in [0.5, 20] (of the ranges [0.5, 10])"),
        ("{ box = { x = [-20, 20], v = 1 } }", "of the ranges with x in [-20, 20] (of the ranges [-10, 10]) and v = 1"),
        ("{ box = { x = [11, 20] } }", "of the ranges with x in [11, 20] (no state of the ranges)"),
        ("{ box = { x = [-10, 10] } }", "of the ranges with x in [-10, 10]"),
        ('{ where = ["x >= 1/2"] }', "of the ranges with x >= 1/2"),
        ("{}", "of the ranges with any state"),
        ("[]", "of the ranges"),
        (
            "[{ box = { x = 1 } }, { box = { v = [0, 6] } }]",
            "of the ranges with x = 1 or v in [0, 6] (of the ranges [0, 5])",
        ),
    ],
)
def test_a_claim_about_decisions_says_that_it_is_about_states_of_the_ranges(region, said):
    text = f'{CART}[[property]]\nformula = "not acts(cart) == right"\nregion = {region}\n'
    [claim] = claims_of(statement_of(text, "f"), PROFILE, "f")
    assert claim.sentence == f"in every state {said}, the agents decide as claimed"


def test_claims_of_every_kind():
    statement = statement_of(CART + ALL, "f")
    near, far, there, slow, acts = claims_of(statement, PROFILE, "f")
    assert [claim.pattern for claim in (near, far, there, slow, acts)] == [
        Pattern.STAYS_IN,
        Pattern.AVOIDS,
        Pattern.REACHES,
        Pattern.REACHES_AND_STAYS,
        Pattern.DECIDES,
    ]
    assert [claim.steps for claim in (near, far, there, slow, acts)] == [10, 5, 10, 10, 0] and slow.by == 4
    assert near.sentence == "every episode of 10 steps stays in x in [-2, 2] and x + 1[s]*v < 3/2"
    assert len(far.regions) == 2 and far.region == "x in [3, 4] or v >= 2"
    for x, v, inside in ((F(2), F(0), False), (F(1), F(0), True), (F(1), F(1, 2), False), (F(-3), F(0), False)):
        assert holds(near.inside, {"x": x, "v": v}, {}) is inside
    assert holds(there.inside, {"x": F(1)}, {}) and not holds(there.inside, {"x": F(9, 10)}, {})
    assert not holds(acts.formula, {"x": F(1), "v": F(0)}, {"cart": 2})
    assert holds(acts.formula, {"x": F(1), "v": F(0)}, {"cart": 1})
    assert claims_in(ALL, statement, PROFILE, "g") == (near, far, there, slow, acts)


def test_a_property_without_a_name_is_told_all_names():
    with pytest.raises(InputError, match=r"names: decides, .*, always, robust$"):
        claims_in("[[property]]\n", statement_of(CART, "f"), PROFILE, "g")


@pytest.mark.parametrize(
    ("text", "what"),
    [
        ("", "no claim in the file"),
        ("[[property]]\n", "needs a name or a formula"),
        ('[[property]]\nname = "stay_in"\n', "unknown claim 'stay_in'"),
        ('[[property]]\nname = "stays_in"\n', "needs a region"),
        ('[[property]]\nname = "stays_in"\nregion = { box = { w = 1 } }\n', "unknown variable 'w'"),
        ('[[property]]\nname = "stays_in"\nregion = { where = ["x"] }\n', "not a comparison"),
        ('[[property]]\nname = "stays_in"\nregion = { where = ["x <= v"] }\n', "units do not fit"),
        ('[[property]]\nname = "stays_in"\nregion = { where = ["x*x <= 1"] }\n', "not an affine form"),
        ('[[property]]\nname = "stays_in"\nregion = { where = ["x != 1"] }\n', "not a comparison"),
        ('[[property]]\nname = "stays_in"\nregion = 3\n', "not a list"),
        ('[[property]]\nname = "stays_in"\nregion = { box = { x = 1 } }\nsteps = 0\n', "not a whole number"),
        ('[[property]]\nname = "stays_in"\nregion = { box = { x = 1 } }\nby = 3\n', "stays_in has no by"),
        ('[[property]]\nname = "reaches_and_stays"\nregion = { box = { x = 1 } }\n', "needs the step"),
        ('[[property]]\nname = "reaches_and_stays"\nregion = { box = { x = 1 } }\nby = 11\n', "from 1 to 10"),
        ('[[property]]\nname = "stays_in"\nregion = { box = { x = 1 } }\nassuming = []\n', "stays_in has no assuming"),
        (
            '[[property]]\nname = "always"\nregion = { box = { x = 1 } }\ninvariant = { box = { x = [2, 1] } }\n',
            "above",
        ),
        ('[[property]]\nname = "stays_in"\nformula = "x > 0"\n', "stays_in has no formula"),
        ('[[property]]\nformula = "x > 0"\nsteps = 3\n', "decides has no steps"),
        ('[[property]]\nformula = "acts(cart) == up"\n', "unknown action of cart 'up'"),
        ('[[property]]\nformula = "acts(car) == left"\n', "unknown agent 'car'"),
        ('[[property]]\nformula = "x >"\n', "ends too early"),
        ("[[property]]\nspeed = 3\n", "unknown key 'speed'"),
        ("[[proberty]]\n", "unknown key 'proberty'"),
        ("property = 3\n", "no claim in the file"),
    ],
)
def test_bad_properties(text, what):
    with pytest.raises(InputError) as raised:
        claims_in(text, statement_of(CART, "f"), PROFILE, "g")
    assert what in raised.value.what and raised.value.where.startswith("g")


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (CART.replace("steps = 10", "steps = 5000"), "from 1 to 1000"),
        (CART[: CART.index("[dynamics.next]")], "does not say how the state moves"),
    ],
)
def test_episodes_that_nothing_can_be_claimed_of(text, said):
    """Told when the file is read, not only when it is asked about; a claim may name fewer steps."""
    stays = '[[property]]\nname = "stays_in"\nregion = { box = { x = 1 } }\n'
    with pytest.raises(InputError, match=said):
        ensure_claims(statement_of(text + stays, "f"), "f")
    if "dynamics" in text:
        assert ensure_claims(statement_of(text + stays + "steps = 20\n", "f"), "f") == 1


def test_faults_have_their_lines_and_all_are_told():
    """In a world file and in a property file; a text over several lines is shown with the line of its fault."""
    wrong = '[[property]]\nname = "stays_in"\nregion = { where = ["x <= 1",\n "x <= v"] }\n'
    wrong += '[[property]]\nformula = "x > y"\n[[property]]\nformula = "true"\n'
    lines = len(CART.splitlines())
    with pytest.raises(InputError) as raised:
        ensure_claims(statement_of(CART + wrong, "f"), "f")
    assert raised.value.what == "2 of 3 claims cannot be read"
    assert f"f, line {lines + 3}: property 1, region.where 2, column 6" in raised.value.where
    assert f"f, line {lines + 6}: property 2, formula, column 5" in raised.value.where and "^" in raised.value.where
    with pytest.raises(InputError) as raised:
        claims_in(wrong, statement_of(CART, "f"), PROFILE, "g")
    assert "g, line 6: property 2, formula, column 5" in raised.value.where
    with pytest.raises(InputError) as raised:
        statement_of(CART.replace("dt*v", "dt*w"), "f")
    line = 1 + CART.splitlines().index('x = "x + dt*v"')
    assert raised.value.where.startswith(f"f, line {line}: dynamics.next.x, column 8\n  x + dt*w\n")


def test_claims_for_ever():
    """What is assumed and what is proposed are regions like any other; a late claim is looked into for longer."""
    always = '[[property]]\nname = "always"\nregion = { box = { x = [-1, 1] } }\n'
    more = 'by = 30\nassuming = [{ box = { v = [-1, 1] } }, { box = { v = 2 } }]\ninvariant = { where = ["x <= 1"] }\n'
    plain, late = claims_in(always + always + more, statement_of(CART, "f"), PROFILE, "g")
    assert (plain.by, plain.steps, plain.assuming, plain.invariant) == (0, 200, (), ())
    assert (late.by, late.steps, len(late.assuming), len(late.invariant)) == (30, 230, 2, 1)
    assert late.sentence.endswith("from then on always, as long as it stays in v in [-1, 1] or v = 2")
    assert "stays in x in [-1, 1] for ever" in plain.sentence


def interval(low, high):
    x = Affine.of({"x": F(1)}, F(-high))
    return (HalfSpace(x), HalfSpace(Affine.of({"x": F(-1)}, F(low))))


NEAR, FAR = interval(-1, 1), interval(5, 6)


@pytest.mark.parametrize(
    ("steps", "by", "regions"), [(-1, 0, (NEAR,)), (2, 3, (NEAR,)), (1_001, 0, (NEAR,)), (2, 0, ())]
)
def test_what_means_nothing_is_refused(steps, by, regions):
    with pytest.raises(InputError):
        SystemClaim(Pattern.REACHES_AND_STAYS, regions, steps, by).ensure()


def test_words_name_the_regions_and_the_steps():
    claim = SystemClaim(Pattern.REACHES_AND_STAYS, (NEAR,), 30, by=20, region="near")
    assert claim.sentence == "every episode is in near from step 20 to step 30"


def test_words_that_are_made_from_the_data_alone():
    near = (HalfSpace(Affine.of({"x": F(-2), "v": F(1)}, F(-1)), strict=True), HalfSpace(Affine.of({}, F(-1))))
    claim = SystemClaim(Pattern.AVOIDS, (near, ()), 30, region="far")
    assert spell_claim(claim, {}, {}) == "every episode of 30 steps avoids v - 2*x < 1 and 0 <= 1 or any state"
    denied = Not(Acts("cart", 1))
    formula = And((below({"x": F(1, 3), "v": F(-1)}, F(1, 2)), Or((denied, TRUE)), FALSE))
    decides = SystemClaim(Pattern.DECIDES, formula=formula)
    said = "(v - 1/3*x >= -0.5 and (not acts(cart) == go or true) and false)"
    actions, ranges = {"cart": ["rest", "go"]}, {"w": (F(0), F(1)), "x": (F(-1), F(1)), "v": (F(1, 3), F(5))}
    assert spell_claim(decides, actions, {}) == f"in every state of the ranges, {said}"
    assert (
        spell_claim(decides, actions, ranges) == f"in every state of the ranges (x in [-1, 1], v in [1/3, 5]), {said}"
    )
    far = replace(decides, formula=TRUE, regions=((HalfSpace(Affine.of({"x": F(1)}, F(-9))),),))
    assert spell_claim(far, actions, ranges) == "in every state of the ranges (x in [-1, 1]) with x <= 9, true"
