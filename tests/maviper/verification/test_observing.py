"""Claims over observations: a number in a formula is what the agent compares, in the tests of trees and beside them."""

import json
import math
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import maviper
from codegen import policy_json
from codegen.floats import NUMBERS, below_zero
from maviper.verification.ask import as_compared
from tests.support.pole import pole
from tests.support.verifying import run
from verify.checker import thresholds
from verify.claims.formula import Linear, holds
from verify.claims.observed import View, over
from verify.claims.terms import last_of
from verify.kinds import SEMANTICS
from verify.result import Verdict
from verify.solver import encode
from verify.solver.terms import HalfLine

CLAIMS = {
    "angle < {end} implies acts(pole) == left": "PROVED",
    "not angle >= {end} implies acts(pole) == left": "PROVED",
    "angle >= {end} and {end} <= speed implies acts(pole) == right": "PROVED",
    "angle >= {end} and speed > {end} implies acts(pole) == right": "PROVED",
    "angle <= {end} implies acts(pole) == left": "VIOLATED",
    "angle >= {end} and speed < {end} implies acts(pole) == right": "VIOLATED",
}
ENDS = (0.0, 2.0**-126, -(2.0**-126), 0.1, float(np.float32(0.1)), 1e-300, -1e-60, 3.0)


def verdicts(capsys, folder, numbers, semantics="machine", end=0.0):
    """The verdicts on CLAIMS, as a user gets them."""
    (folder / "pole.json").write_text(policy_json.dumps(pole(numbers, end)))
    claims = [f'[[property]]\nformula = "{text.format(end=end)}"\n' for text in CLAIMS]
    (folder / "claims.toml").write_text("".join(claims))
    asked = ["--claims", str(folder / "claims.toml"), "--set", f"semantics={semantics}", "--verdict-only", "--json"]
    _, out, err = run(capsys, "verify", str(folder / "pole.json"), *asked)
    return [one["verdict"] for one in json.loads(out)["results"]] if out else err


@pytest.mark.solver
@pytest.mark.parametrize("numbers", NUMBERS)
@pytest.mark.parametrize("semantics", SEMANTICS)
@pytest.mark.parametrize("end", [0.0, 0.5])
def test_strict_tests_are_verified(tmp_path, capsys, numbers, semantics, end):
    assert verdicts(capsys, tmp_path, numbers, semantics, end) == list(CLAIMS.values())


@pytest.mark.solver
@pytest.mark.parametrize("fault", ["zones", "solver"])
def test_a_wrong_reading_of_below_zero_is_noticed(tmp_path, capsys, monkeypatch, fault):
    """One engine takes x < 0 for x <= 0: the other one contradicts it."""
    if fault == "solver":
        monkeypatch.setattr(encode, "HalfLine", lambda end, strict: HalfLine(end, strict and end != 0))
    else:
        cut = thresholds._cut
        monkeypatch.setattr(
            thresholds, "_cut", lambda terms, end, strict, *eps: cut(terms, end, strict and end != 0, *eps)
        )
    thresholds.sides.cache_clear()
    said = verdicts(capsys, tmp_path, "float64")
    thresholds.sides.cache_clear()
    assert "disagree" in said, said


@pytest.mark.parametrize("numbers", NUMBERS)
@pytest.mark.parametrize("semantics", SEMANTICS)
@given(st.sampled_from(ENDS), st.sampled_from([1, -1, 2, Fraction(-1, 3)]), st.booleans(), st.integers(-2, 2))
def test_an_inequality_means_the_same_of_each_number_that_is_compared(numbers, semantics, end, weight, strict, steps):
    atom = Linear(((Fraction(weight), "angle"),), Fraction(weight) * Fraction(end), strict)
    read = as_compared(over(pole(numbers), View()), semantics)(atom)
    number = np.dtype(numbers).type(end)
    for _ in range(abs(steps)):
        number = np.nextafter(number, number.dtype.type(math.copysign(math.inf, steps)))
    at = {"angle": Fraction(float(number)), "speed": Fraction(0)}
    assert holds(read, at, {}) == holds(atom, at, {})


@pytest.mark.parametrize("numbers", NUMBERS)
def test_the_last_number_is_the_last(numbers):
    for end in map(Fraction, ENDS):
        for below in (False, True):
            last = np.dtype(numbers).type(last_of(end, numbers, below))
            after = Fraction(float(np.nextafter(last, last.dtype.type(math.inf))))
            exact = Fraction(float(last))
            assert exact < end <= after if below else exact <= end < after
    assert last_of(Fraction(0), numbers, below=True) == below_zero(numbers)


@pytest.mark.solver
@pytest.mark.parametrize("numbers", NUMBERS)
def test_profiles_of_a_game_without_places_are_compared_over_what_was_seen(numbers):
    seen = ((-1.0, -0.5, 0.5, 1.0), (-2.0, -1.0, 1.0, 2.0))
    first, second = (
        replace(profile, agents=(replace(profile.agents[0], seen=seen),))
        for profile in (pole(numbers), pole(numbers, 0.25))
    )
    found = maviper.diff(first, second)
    assert found.verdict is Verdict.VIOLATED and found.found.certificate is None
    # below 0.25 the second turns left; the first does so below 0, and turns right or not at all beyond
    (counted,) = {share.value for share in found.counted.uniform.values()}
    assert counted == pytest.approx(0.25 / 2 + 0.75 / 2 * 0.25 / 4, abs=0.01)
    assert maviper.diff(first, first).verdict is Verdict.PROVED
    for everywhere in (maviper.diff(first, second, "ranges"), maviper.diff(pole(numbers), pole(numbers, 0.25))):
        assert everywhere.verdict is Verdict.VIOLATED
        assert "somewhere in region ranges, no share: " in everywhere.lines[0][1]
