"""Shares of a region: the conflict share against trying every joint action, and teams with too many of these."""

from dataclasses import replace
from fractions import Fraction
from itertools import product

import numpy as np
import pytest

from codegen.errors import InputError
from codegen.intervals import percent
from maviper.worlds import find
from tests.support.observations import blind
from tests.support.teams import tree
from tests.support.zone_cases import navigation
from verify.claims.catalogue import find_property
from verify.claims.decisions import formula, matchings
from verify.claims.files import read_properties
from verify.claims.formula import holds, substitute_actions
from verify.claims.observed import View
from verify.claims.region_files import everywhere
from verify.claims.views import Viewed
from verify.question import Question, from_start
from verify.states import shares
from verify.states.shares import SAMPLE_SEED, conflicts, extent_words, of_start
from verify.states.state import sample
from verify.states.values import has_matching, preventable
from verify.subjects import Game

POINTS = 60
NAMED = {"distinct_targets": {}, "own_target": {}, "no_double": {}, "steady": {"of": "distinct_targets"}}
OF_ALL = """
[[property]]
name = "formula"
formula = "acts(agent_0) == stay or acts(agent_1) == stay or acts(agent_2) == stay or agent_0.x >= 0"
"""


@pytest.fixture(scope="module")
def team():
    return navigation(np.random.default_rng(3), 3)[0]


def tried(profile, claim, row):
    """Whether some joint action, every agent closing on a landmark, violates the claim, by the exact referee."""
    at = dict(zip(profile.world.coordinates(), map(Fraction, map(float, row)), strict=True))
    members, stated = profile.team(claim.team), formula(profile, claim)
    marks = [landmark.name for landmark in profile.world.landmarks]

    def closing(policy, action):
        ux, uy = map(Fraction, policy.actions[action].effect)
        x, y = (at[f"{policy.agent}.{axis}"] for axis in "xy")
        return any(ux * (at[f"{k}.x"] - x) + uy * (at[f"{k}.y"] - y) > claim.margin for k in marks)

    for joint in product(*(range(len(policy.actions)) for policy in members)):
        chosen = {policy.agent: action for policy, action in zip(members, joint, strict=True)}
        if all(map(closing, members, joint)) and not holds(substitute_actions(stated, chosen), at, {}):
            return True
    return False


@pytest.mark.parametrize("name", NAMED)
@pytest.mark.parametrize("most", [1_000, 5], ids=["enumerated", "decomposed"])
def test_conflicts_are_those_of_some_joint_action(team, name, most, monkeypatch):
    claim = find_property(name, team, **NAMED[name])
    coordinates, _ = sample(everywhere(team), team.world, POINTS, SAMPLE_SEED)
    monkeypatch.setattr(shares, "MAX_JOINT_ACTIONS", most)
    found = conflicts(from_start(team, claim), coordinates)
    if most == 5 and name == "no_double":  # a part of it speaks of two agents
        assert found is None
        return
    wanted = [tried(team, claim, row) for row in coordinates]
    assert list(found) == wanted and 0 < sum(wanted) < POINTS


def test_a_formula_about_too_many_joint_actions_has_no_conflict_share(team, monkeypatch):
    monkeypatch.setattr(shares, "MAX_JOINT_ACTIONS", 100)
    ((claim, region, _),) = read_properties(OF_ALL.replace('name = "formula"', 'team = "agents"'), team, "f.toml", None)
    assert shares.measure(Question(Game(team), claim, region), SAMPLE_SEED, 1_000).conflict is None


def test_preventable_is_what_trying_all_choices_finds():
    rng = np.random.default_rng(5)
    choices = [[(rng.random(400) < 0.7, rng.random((400, 3)) < 0.5) for _ in range(3)] for _ in range(3)]
    wanted = np.zeros(400, dtype=bool)
    for joint in product(*choices):
        allowed = np.logical_and.reduce([one for one, _ in joint])
        wanted |= allowed & ~has_matching(np.stack([related for _, related in joint], axis=1))
    assert (preventable(choices, 3) == wanted).all() and 0 < wanted.sum() < 400


def test_the_share_of_the_start_region_counts_only_what_lies_in_it(profile):
    start = everywhere(profile)
    wide = {name: (3 * low, 3 * high) for name, (low, high) in start.box.items()}
    near = replace(start, box=wide, differences=(("agent_0.x", "agent_1.x", (Fraction(-1), Fraction(1))),))
    found = of_start(profile, near)
    assert not found["exact"] and found["low"] < 0.75 < found["high"]  # of a square of side 2, less two triangles
    outside = replace(near, box=wide | {"agent_0.x": (Fraction(2), Fraction(3))})
    assert of_start(profile, outside) == {"share": 0.0, "low": 0.0, "high": 0.0, "exact": True}


@pytest.mark.smoke
def test_less_than_all_is_never_called_100_percent(profile):
    start = everywhere(profile)
    smaller = replace(start, box=start.box | {"agent_0.x": (Fraction(-1), Fraction(9998, 10_000))})
    assert percent(of_start(profile, smaller)["share"]) == "99.99 %"
    assert [percent(share) for share in (0, 0.123456, 0.9994, 0.9996, 1 - 1e-9, 1)] == [
        "0 %", "12.3 %", "99.9 %", "99.96 %", "99.9999999 %", "100 %",
    ]  # fmt: skip
    assert percent(9_999, 10_000) == "99.99 %" and percent(7, 7) == "100 %"
    kept = of_start(profile, replace(start, apart=(("agent_0", "agent_1", Fraction(1, 10_000)),)))
    assert kept["share"] == 1 and extent_words(kept, "it") == "about 100 % of it"


def test_more_agents_than_matchings_can_be_listed_for_are_refused():
    assert len(matchings(6, 6)) == 720 and len(matchings(2, 3)) == 6
    with pytest.raises(InputError, match=r"12 agents and 12 landmarks have 479,001,600 matchings") as raised:
        matchings(12, 12)
    assert "own_target" in raised.value.next_step
    assert len(find("cooperative-navigation,agents=12").agents) == 12


def test_what_a_uniform_state_never_meets_is_drawn():
    """Phases of a signal are 0 or 1: no uniform number is, and nothing was measured."""
    signal = blind({"a": tree((0, 0.5, 1, 2), 0, 1)}, {"a": ["red", "green", "queue"]})
    modes = "(red == 1 and green == 0 or red == 0 and green == 1) and queue >= 1"
    file = f'[[property]]\nformula = "queue > 1.5 implies acts(a) == left"\nassume = "{modes}"\n'
    viewed = Viewed(signal, View())
    (stated,) = read_properties(file, viewed.profile, "file", lambda name: pytest.fail(name))
    subject = Game(viewed.profile, viewed=viewed)
    found = shares.measure(Question(subject, stated.claim, stated.region), SAMPLE_SEED, 4_000)
    assert found.conflict.count == found.violating.count >= 1_000
    assert 0.4 < found.conflict.value < 0.6 and 0.2 < found.violating.value < 0.3
