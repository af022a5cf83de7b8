"""What the search for covers finds is what the checker accepts; budgets end it, and do not change what it finds."""

from contextlib import suppress
from fractions import Fraction as F
from pathlib import Path

import numpy as np
import pytest

from maviper.files.profiles import find_profile as loaded
from maviper.worlds.stated.systems import read
from tests.support.covers import question, shown
from tests.support.exact_play import refuted
from tests.support.system_cases import (
    box,
    collision,
    corridor,
    double_integrator,
    form,
    passing,
    policy,
    stays,
    switching,
    team,
)
from verify.checker.certificate import numbers
from verify.checker.covers.boxes import Parts
from verify.checker.covers.images import BoxMotion
from verify.checker.systems.proofs import Cover
from verify.reach.covering import Search, estimate_ranges
from verify.spending import BudgetSpentError, Spending
from verify.systems.claims import Pattern, SystemClaim
from verify.systems.properties import claims_of
from verify.systems.system import Feature, Piece, System, Variable

WORLDS = Path(__file__).parents[3] / "generated" / "worlds"
ENOUGH = 1_000_000


def cells(found, system):
    columns = {one.name: column for column, one in enumerate(system.variables)}
    return list(numbers(found.cuts)), {columns[name]: float(width) for name, width in found.cells.items()}


def coverings(system, profile, claim, most=ENOUGH):
    """What covers one claim, until the budget ends."""
    search = Search(profile, system, claim, Spending(most))
    with suppress(BudgetSpentError):
        yield from (found for found in search.iterate_covers() if isinstance(found, Cover))


def first(system, profile, claim, most=ENOUGH):
    return next(coverings(system, profile, claim, most), None)


@pytest.mark.parametrize("name", ["cart_pole", "corridor", "crossing", "mountain_car", "pendulum", "quadrotor"])
def test_the_worlds(name):
    """Claims that linear programs took minutes for."""
    statement, profile = read(WORLDS / f"{name}.toml"), loaded(WORLDS / name / "profile.json", beside=WORLDS / name)
    for claim in claims_of(statement, profile, name):
        if not claim.about_decisions:
            found = first(statement.system, profile, claim)
            assert found is not None
            assert shown((statement.system, profile, claim), cells(found, statement.system))


def test_by_hand():
    integrator = double_integrator(axes=2)
    avoids = SystemClaim(Pattern.AVOIDS, (collision(F(1, 5)),), 15)
    for system, profile, claim in (
        (integrator, switching(2), stays(integrator, 30, x=(F(-1), F(1)), y=(F(-1), F(1)))),
        (corridor(), passing(), avoids),
    ):
        found = first(system, profile, claim)
        assert found is not None and shown((system, profile, claim), cells(found, system))


def test_ranges_of_long_episodes():
    """Points stay points: what rounding outward adds would grow from step to step."""
    system = read(WORLDS / "pendulum.toml").system
    profile = loaded(WORLDS / "pendulum" / "profile.json", beside=WORLDS / "pendulum")
    start = Parts(system).whole
    ranges = estimate_ranges(BoxMotion(profile, system), start, 128, 300)
    assert ranges[[one.name for one in system.variables].index("angle")] < 0.2


def test_false_claims_are_left_open():
    tried = 0
    for seed in range(40):
        random = np.random.default_rng([9, seed])
        asked = question(random)
        if refuted(random, asked, 30):
            assert not any(shown(asked, cells(found, asked[0])) for found in coverings(*asked, 20_000))
            tried += 1
    assert tried >= 10


def test_budgets():
    """A larger one finds what a smaller one found; the smallest finds nothing."""
    system, profile = double_integrator(axes=2), switching(2)
    claim = stays(system, 30, x=(F(-1), F(1)), y=(F(-1), F(1)))
    assert first(system, profile, claim, 1) is None
    found = [first(system, profile, claim, most) for most in (100_000, ENOUGH)]
    assert found[0] == found[1] is not None


@pytest.mark.parametrize(
    "factor", [F(10) ** 200, F(10) ** -400, F(10) ** 400, -(F(10) ** 30)], ids=["far", "tiny", "huge", "wide"]
)
def test_numbers_that_floats_do_not_hold(factor):
    """They are left open, without a warning, where a float does not do."""
    seen, move = form(x=factor), {"x": form(x=factor)}
    x = Variable("x", "1", (F(-9), F(9)))
    system = System("far", (x,), {"a": {"f": Feature(seen)}}, box(x=(-1, 1)), (Piece({}, move),), 4)
    profile = team(policy("a", ["f"], ["go"], ((0, 0.0), 0, 0)))
    for claim in (stays(system, 4, x=(F(-2), F(2))), SystemClaim(Pattern.REACHES, (box(x=(3, 4)),), 4)):
        for found in coverings(system, profile, claim, 20_000):
            assert not shown((system, profile, claim), cells(found, system)) or abs(factor) < 1
