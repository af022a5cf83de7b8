"""Many states judged at once: the referee's word on every one, boundaries and errors included; few are left to it."""

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

from tests.support.teams import team, towards, tree
from tests.support.zone_cases import deception, navigation, noisy, random_region
from verify.claims.catalogue import find_property
from verify.claims.formula import Linear, below, holds, negate
from verify.claims.region_files import everywhere
from verify.claims.wording import OwnFormula
from verify.question import Question, from_start
from verify.states import noise, shares
from verify.states import state as world
from verify.states.state import inside, violates
from verify.states.values import Batch
from verify.subjects import Game


def spoiled(rng, state):
    """The point with some coordinates moved onto others, or by a radius or a rounding beside them."""
    position = dict(state.position)
    names = [name for name in position if name.endswith((".x", ".y"))]
    for name in rng.choice(names, 3, replace=False):
        other = rng.choice([one for one in names if one[-1] == name[-1]])
        value = position[str(other)] + rng.choice([0.0, 0.1, -0.1, 0.05, 0.25])
        position[str(name)] = float(np.nextafter(value, rng.choice([-2.0, 0.0, 2.0])))
    return replace(state, position=position)


def drawn(rng, profile, n):
    region = everywhere(profile)
    coordinates, goals = world.sample(region, profile.world, n, int(rng.integers(1 << 30)))
    rows = zip(coordinates, goals, strict=True)
    states = [world.state_at(region, profile.world, row, int(goal)) for row, goal in rows]
    return [spoiled(rng, state) if rng.random() < 0.7 else state for state in states]


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("kind", [deception, navigation])
def test_what_is_said_of_many_states_is_the_referees_word(seed, kind):
    rng = np.random.default_rng([seed, 41])
    for _ in range(4):
        profile, claim = kind(rng, 3)
        states = drawn(rng, profile, 25)
        errors = [f"{policy.agent}:{spec.name}" for policy in profile.agents for spec in policy.features]
        states += [replace(state, errors={str(rng.choice(errors)): float(rng.uniform(-1, 1))}) for state in states]
        found = shares.fails(from_start(profile, claim), states)
        assert found.tolist() == [violates(from_start(profile, claim), state) for state in states]


def test_states_in_doubt_are_left_to_exact_arithmetic():
    """The sum of three tenths is above 0.3 in float64; each side of a boundary is doubted, beyond it nothing is."""
    atom = below({"a": 1, "b": 1, "c": 1}, Fraction(3, 10))
    columns = {"a": np.array([0.1, 0.1, 0.1, 1e300]), "b": np.array([0.1, 0.1 + 1e-15, 0.1 - 1e-15, -1e300])}
    columns["c"] = np.array([0.1, 0.1, 0.1, 0.0])
    assert isinstance(atom, Linear)
    for asked in (atom, negate(atom)):
        possible = Batch(columns, 4, doubting=True).holds(asked, {})
        for row in range(4):
            exact = {name: Fraction(float(column[row])) for name, column in columns.items()}
            assert possible[row] or not holds(asked, exact, {})
    both = [Batch(columns, 4, doubting=True).holds(asked, {}) for asked in (atom, negate(atom))]
    assert np.logical_and(*both).tolist() == [True, False, False, True]


def test_hardly_a_state_is_left_to_exact_arithmetic(profile, monkeypatch):
    same = team(profile, towards(0, 0), towards(0, 1))
    asked = []
    monkeypatch.setattr(shares, "holds", lambda *given: asked.append(given) or holds(*given))
    for claim in (find_property("distinct_targets", same), find_property("steady", same, eps=Fraction(1, 10))):
        states = shares.failures(Question(Game(same), claim, everywhere(same)))
        assert len(states) == shares.MAX_NUMBER and len(asked) < 10
        for state in states[::10]:
            assert violates(from_start(same, claim), state) and inside(everywhere(same), state)


@pytest.mark.parametrize("seed", range(4))
def test_states_come_with_errors_within_eps(profile, seed):
    rng = np.random.default_rng([seed, 42])
    for _ in range(2):
        pair, claim = noisy(rng, profile)
        claim, region = replace(claim, eps=Fraction(1, 10)), random_region(rng, pair)
        for state in shares.failures(Question(Game(pair), claim, region), 30):
            assert inside(region, state) and violates(from_start(pair, claim), state)
            assert all(abs(Fraction(error)) <= claim.eps for error in state.errors.values())


def test_errors_do_not_pass_eps_where_its_float_does(profile):
    """A tenth as a float64 number is above a tenth."""
    same = team(profile, tree((2, 0.1, 1, 2), 1, 2), tree(1))
    coordinates = np.zeros((2, len(same.world.coordinates())))
    eps = Fraction(float(np.float32(0.1))) - Fraction(1, 2**80)
    for most in (eps, Fraction(1, 10)):
        for of_state in noise.ways(same.policy("agent_0"), coordinates, same.world, most):
            assert all(abs(Fraction(error)) <= most for way in of_state for error in way.values())


def test_where_float64_is_wrong_everywhere_the_search_ends(profile, monkeypatch):
    """1 + 0.6875 u + 0.6875 u is rounded twice, up to 1 + 2 u, its exact value once, to 1 + u."""
    same, little = team(profile, towards(0, 0), towards(1, 1)), Fraction(11, 2**56)
    values = {"agent_0.x": Fraction(1), "agent_1.x": little, "landmark_0.x": little}
    claim = OwnFormula("defenders", statement=below(dict.fromkeys(values, 1), 1 + 2 * little))
    start = everywhere(same)
    region = replace(start, box=start.box | {name: (value, value) for name, value in values.items()})
    assert shares.violating(Question(Game(same), claim, region), world.sample(region, same.world, 100, 0)[0]).all()
    judged = []
    right = shares.fails
    monkeypatch.setattr(shares, "fails", lambda *given: judged.append(len(given[1])) or right(*given))
    assert shares.failures(Question(Game(same), claim, region), 20) == []
    assert 20 <= sum(judged) <= 20 * shares.JUDGED


def test_no_states_are_none(profile):
    same = team(profile, towards(0, 0), towards(1, 1))
    claim = find_property("own_target", same)
    assert shares.fails(from_start(same, claim), []).tolist() == []
    assert shares.failures(Question(Game(same), claim, everywhere(same)), 0) == []
    empty = replace(everywhere(same), apart=(("agent_0", "agent_1", Fraction(3)),))
    assert shares.failures(Question(Game(same), claim, empty)) == []
