"""Built-in properties: their formulas say what their definitions say, for actions and states of every kind."""

from collections import Counter
from fractions import Fraction
from itertools import permutations, product

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from codegen.errors import InputError, UnknownNameError
from verify.claims.catalogue import find_property
from verify.claims.decisions import PLAIN, NoDouble, formula
from verify.claims.formula import FALSE, TRUE, And, Linear, Not, Or, below, holds, negate, normal
from verify.claims.formula import substitute_actions as once
from verify.claims.region_files import everywhere, find_observed_velocities
from verify.claims.wording import BUILT_IN, spell_decisions
from verify.states.values import Batch

TEAM = "defenders"
AGENTS = ("agent_0", "agent_1")
MARKS = ("landmark_0", "landmark_1")
EIGHTHS = st.integers(-16, 16).map(lambda n: Fraction(n, 8))
NAMES = [f"{name}.{axis}" for name in AGENTS + MARKS for axis in "xy"]
STATES = st.fixed_dictionaries(dict.fromkeys(NAMES, EIGHTHS))
ACTIONS = st.fixed_dictionaries({agent: st.integers(0, 4) for agent in AGENTS})
CLAIMS = st.sampled_from([BUILT_IN[name](TEAM, margin=margin) for name in PLAIN for margin in (0, Fraction(1, 4))])


def defined(profile, claim, at, actions):
    """The definitions, computed with numbers instead of formulas."""
    effects = {p.agent: [tuple(map(Fraction, a.effect)) for a in p.actions] for p in profile.team(TEAM)}

    def off(agent, mark):
        return [at[f"{mark}.{axis}"] - at[f"{agent}.{axis}"] for axis in "xy"]

    def ahead(agent, mark):
        return sum(u * d for u, d in zip(effects[agent][actions[agent]], off(agent, mark), strict=True))

    def sideways(agent, mark):
        (ux, uy), (dx, dy) = effects[agent][actions[agent]], off(agent, mark)
        return abs(ux * dy - uy * dx)

    def close(agent, mark):
        return ahead(agent, mark) > claim.margin

    def near(agent, mark):
        return max(map(abs, off(agent, mark))) <= claim.radius

    def busy(agent, mark):
        return close(agent, mark) or near(agent, mark)

    def straight(agent, mark):
        return near(agent, mark) or (
            close(agent, mark) and ahead(agent, mark) >= claim.parameters.get("kappa", 0) * sideways(agent, mark)
        )

    def length(match):
        return sum(sum(map(abs, off(agent, mark))) for agent, mark in zip(AGENTS, match, strict=True))

    matchings = list(permutations(MARKS))
    shortest = min(map(length, matchings))
    sole = [{mark for mark in MARKS if close(agent, mark)} for agent in AGENTS]
    return {
        "distinct_targets": any(all(map(busy, AGENTS, match)) for match in matchings),
        "own_target": all(map(busy, AGENTS, MARKS)),
        "no_double": not (len(sole[0]) == 1 and sole[0] == sole[1]),
        "aligned": any(all(map(straight, AGENTS, match)) for match in matchings),
        "assignment": any(all(map(busy, AGENTS, match)) for match in matchings if length(match) == shortest),
    }[claim.name]


@given(CLAIMS, STATES, ACTIONS)
def test_formulas_say_what_definitions_say(profile, claim, at, actions):
    stated = formula(profile, claim)
    wanted = defined(profile, claim, at, actions)
    assert holds(stated, at, actions) is wanted
    assert holds(negate(stated), at, actions) is not wanted
    assert holds(once(stated, actions), at, {}) is wanted
    columns = {name: np.array([float(value)]) for name, value in at.items()}
    chosen = {agent: np.array([action]) for agent, action in actions.items()}
    assert bool(Batch(columns, 1).holds(stated, chosen)[0]) is wanted  # eighths are exact in float64


@pytest.mark.parametrize("name", PLAIN)
def test_margin_and_radius_count_wherever_a_claim_has_them(profile, name):
    """A quarter and an eighth: landmarks lie nearer, at that and beyond, on both sides of agents in one place."""
    claim = BUILT_IN[name](TEAM, margin=Fraction(1, 4), radius=Fraction(1, 8))
    stated, told = formula(profile, claim), Counter()
    offsets = [Fraction(n, 8) for n in (-3, -2, -1, 1, 2, 3)]
    for first, second, *acting in product(offsets, offsets, range(5), range(5)):
        at = dict.fromkeys(NAMES, Fraction(0)) | {"landmark_0.x": first, "landmark_1.x": second}
        at |= {"landmark_0.y": Fraction(1, 8), "landmark_1.y": Fraction(1, 4)}
        actions = dict(zip(AGENTS, acting, strict=True))
        wanted = defined(profile, claim, at, actions)
        assert holds(stated, at, actions) is wanted, (at, actions)
        told[wanted] += 1
    assert len(told) == 2 and min(told.values()) >= 4


@pytest.mark.parametrize("kappa", [Fraction(1, 2), Fraction(2)])
def test_aligned_asks_for_so_much_ahead_beside_what_is_sideways(profile, kappa):
    """One agent is at its landmark, the other one's lies in any direction."""
    claim = BUILT_IN["aligned"](TEAM, kappa=kappa)
    stated, told = formula(profile, claim), Counter()
    offsets = [Fraction(n, 8) for n in (-4, -2, -1, 1, 2, 4)]
    for x, y, action in product(offsets, offsets, range(5)):
        at = dict.fromkeys(NAMES, Fraction(0)) | {"landmark_0.x": x, "landmark_0.y": y, "agent_1.x": Fraction(9)}
        at |= {"landmark_1.x": Fraction(9)}
        actions = dict(zip(AGENTS, (action, 0), strict=True))
        wanted = defined(profile, claim, at, actions)
        assert holds(stated, at, actions) is wanted, (at, actions)
        told[wanted] += 1
    assert len(told) == 2 and min(told.values()) >= 20


def test_formulas_simplify_and_negate():
    atom = Linear(((Fraction(1), "a.x"),), Fraction(1))
    assert below({"a.x": 0}, 0) == TRUE and below({}, 0, strict=True) == FALSE
    assert normal(Not(Not(atom))) == atom
    assert negate(And((atom, Or(())))) == TRUE
    assert negate(atom) == Linear(((Fraction(-1), "a.x"),), Fraction(-1), strict=True)


def test_landmarks_of_own_target_are_checked(profile):
    with pytest.raises(UnknownNameError, match="landmark_2"):
        find_property("own_target", profile, landmarks=("landmark_0", "landmark_2"))
    with pytest.raises(InputError, match="different landmark"):
        find_property("own_target", profile, landmarks=("landmark_0", "landmark_0"))
    assert "fixed landmark" in spell_decisions(find_property("own_target", profile))


def test_observed_velocities_are_bounded_by_what_actions_can_cause(profile):
    from maviper.worlds import find

    assert find_observed_velocities(profile) == () and all(not name.endswith("v.x") for name in everywhere(profile).box)
    spec = find("cooperative-navigation").spec
    from verify.claims.region_files import start_region

    region = start_region(spec, ("agent_0.vx",))
    terminal = Fraction(5) * Fraction(0.1) / Fraction(0.25)
    assert region.box["agent_0.vx"] == (-terminal, terminal)


def test_no_double_needs_two(profile):
    with pytest.raises(InputError, match="two or more"):
        formula(profile, NoDouble("adversaries"))
