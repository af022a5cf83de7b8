"""Views: what their variables are called, what may be shared, and what a copy of an agent observes."""

from dataclasses import replace
from fractions import Fraction

import pytest

from codegen.errors import InputError, UnknownNameError
from codegen.profiles import ensure
from tests.support.observations import blind
from tests.support.small import small_profile
from tests.support.teams import tree
from verify.claims.observed import Raised, View, over, view_from
from verify.claims.region import Region
from verify.claims.region_files import everywhere
from verify.claims.views import ALL, Viewed, carry_region, select_features
from verify.claims.wording import view_document

SPLIT = tree((0, 0.5, 1, 2), 0, 2)
PAIR = blind({"a": SPLIT, "b": SPLIT}, {"a": ("angle", "spin"), "b": ("angle", "place")})


def names(profile):
    return [variable.name for variable in profile.world.variables]


def test_one_agent_names_its_features_alone():
    assert names(over(blind({"a": SPLIT}), View())) == ["angle"]


def test_several_agents_have_their_own_but_what_they_share():
    assert names(over(PAIR, View())) == ["a.angle", "a.spin", "b.angle", "b.place"]
    assert names(over(PAIR, View(("angle",)))) == ["angle", "a.spin", "b.place"]
    assert select_features(PAIR, (ALL,)) == ("angle",)


def test_a_view_is_a_sound_profile_with_the_ranges_of_features():
    found = ensure(over(PAIR, View(("angle",))))
    assert everywhere(found).box["angle"] == (Fraction(-2), Fraction(2))
    assert found.world.coordinates() == tuple(names(found)) and not found.world.agents


def test_a_particle_game_has_a_view_too():
    found = ensure(over(small_profile(), View()))
    assert "agent_0.goal_dx" in names(found) or any(name.startswith("agent_0.") for name in names(found))
    assert everywhere(found).goals == ()


def test_a_copy_shares_all_but_one():
    found = over(PAIR, View((), Raised("a", "spin")))
    assert names(found) == ["a.angle", "a.spin", "b.angle", "b.place", "a_raised.spin"]
    assert [str(one.meaning) for one in found.policy("a_raised").features] == ["a.angle", "a_raised.spin"]
    ensure(found)


def test_a_copy_keeps_the_bounds_of_the_region():
    viewed = Viewed(PAIR, View((), Raised("a", "spin")))
    box = everywhere(over(PAIR, View())).box | {"a.spin": (Fraction(0), Fraction(1))}
    bounds = (Fraction(-1), Fraction(0))
    found = carry_region(Region(box, (), (("a.angle", "a.spin", bounds),)), viewed)
    assert found.box["a_raised.spin"] == (0, 1)
    assert found.differences == (("a.angle", "a.spin", bounds), ("a.angle", "a_raised.spin", bounds))


def unlike(unit="none", high=2.0):
    a, b = PAIR.agents
    return replace(PAIR, agents=(a, replace(b, features=(replace(b.features[0], unit=unit, high=high), b.features[1]))))


@pytest.mark.parametrize("profile", [unlike(unit="rad"), unlike(high=1.0)])
def test_what_is_shared_has_one_range_and_unit(profile):
    with pytest.raises(InputError, match="unlike ranges or units"):
        over(profile, View(("angle",)))
    over(profile, View())


def test_wrong_names_are_told():
    with pytest.raises(UnknownNameError, match="unknown feature 'angel'"):
        select_features(PAIR, ("angel",))
    with pytest.raises(InputError, match="only one agent observes spin"):
        over(PAIR, View(("spin",)))
    with pytest.raises(UnknownNameError, match="agent"):
        over(PAIR, View((), Raised("c", "spin")))
    with pytest.raises(UnknownNameError, match="feature"):
        over(PAIR, View((), Raised("a", "place")))
    taken = blind({"a": SPLIT, "a_raised": SPLIT})
    with pytest.raises(InputError, match="cannot be called a_raised"):
        over(taken, View((), Raised("a", "angle")))


@pytest.mark.parametrize("view", [View(), View(("angle",)), View((), Raised("a", "spin"))])
def test_documents_come_back(view):
    assert view_from(view_document(view)) == view


@pytest.mark.parametrize(
    "document", [{}, {"shared": []}, {"shared": [], "raised": ["a"]}, {"shared": [], "raised": [], "x": []}]
)
def test_other_documents_are_refused(document):
    with pytest.raises(ValueError, match="view"):
        view_from(document)
