"""Claims about stated systems as data: what breaks and fulfils them at each step, and what is refused."""

from dataclasses import replace
from fractions import Fraction as F

import pytest

from codegen.errors import InputError
from verify.claims.formula import FALSE, TRUE, Acts, And, Not, Or, below, holds
from verify.systems.claims import Pattern, SystemClaim
from verify.systems.properties import spell_claim
from verify.systems.system import Affine, HalfSpace


def interval(low, high):
    x = Affine.of({"x": F(1)}, F(-high))
    return (HalfSpace(x), HalfSpace(Affine.of({"x": F(-1)}, F(low))))


NEAR, FAR = interval(-1, 1), interval(5, 6)


def breaks(claim, step, x):
    return holds(claim.violation_at(step), {"x": F(x)}, {})


def test_stays_in_asks_every_state():
    claim = SystemClaim(Pattern.STAYS_IN, (NEAR, FAR), 3)
    for step in range(4):
        assert [breaks(claim, step, x) for x in (-2, -1, 1, 2, 5, 6, 7)] == [
            True,
            False,
            False,
            True,
            False,
            False,
            True,
        ]
        assert claim.fulfilment_at(step) == FALSE


def test_avoids_is_broken_in_any_region():
    claim = SystemClaim(Pattern.AVOIDS, (NEAR, FAR), 3)
    assert [breaks(claim, 2, x) for x in (-2, -1, 1, 2, 5, 6, 7)] == [False, True, True, False, True, True, False]


def test_reaches_is_broken_at_the_last_state_only():
    claim = SystemClaim(Pattern.REACHES, (NEAR,), 3)
    assert claim.violation_at(2) == FALSE and breaks(claim, 3, 2) and not breaks(claim, 3, 0)
    assert holds(claim.fulfilment_at(2), {"x": F(0)}, {}) and claim.fulfilment_at(3) == FALSE


def test_reaches_and_stays_asks_from_a_step_on():
    claim = SystemClaim(Pattern.REACHES_AND_STAYS, (NEAR,), 3, by=2)
    assert claim.violation_at(1) == FALSE and breaks(claim, 2, 2) and breaks(claim, 3, 2)


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
