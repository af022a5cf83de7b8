"""Repair: hand-made teams that violate become proved teams, and nothing else about them changes."""

from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

from codegen import ir
from codegen.boxes import upwards
from codegen.errors import InputError
from codegen.lowering.passes import difference, graft_parts
from codegen.observe import observe
from codegen.policy_json import dumps
from maviper import load
from tests.support.teams import DOWN, LEFT, RIGHT, STAY, UP, team, towards, tree
from tests.support.zone_cases import navigation, random_tree, stated
from verify.checker.decisions import check_certificate
from verify.claims.catalogue import find_property
from verify.claims.decisions import DistinctTargets, NoDouble, formula
from verify.claims.region import Region
from verify.claims.region_files import everywhere, start_region
from verify.question import Budgets, Question, shuffle_leaves
from verify.repair import repair
from verify.result import Verdict
from verify.states.state import sample
from verify.subjects import Game
from verify.verdicts.decisions import verify
from verify.zones import engine

pytestmark = [pytest.mark.solver, pytest.mark.usefixtures("few_states_throughout")]
ROOT = Path(__file__).parents[2]
ASTRAY = replace(towards(1, 1), action=np.array([-1, LEFT, -1, -1, UP, UP, RIGHT]))  # goes up where it should go down


@pytest.fixture(scope="module")
def profile():
    """The committed trees: learned, and not extracted anew."""
    return load(ROOT / "generated" / "physical_deception" / "extracted" / "profile.json")


@pytest.fixture
def claim(profile):
    return find_property("distinct_targets", profile)


def proved(profile, claim, region):
    """Both engines say so, and the checker accepts the certificate."""
    result = verify(Question(Game(profile), claim, region), {})
    assert {opinion.verdict for opinion in result.evidence.opinions} == {Verdict.PROVED}
    assert result.evidence.certificate is not None and check_certificate(result.evidence.certificate, profile) > 0
    return result


def unchanged(before, found, region):
    """Every state that reaches no guarded leaf keeps its actions: proved for all observations, and by sampling."""
    states, _ = sample(region, before.world, 20_000, 3)
    for old, new in zip(before.agents, found.profile.agents, strict=True):
        aside = {one.node for one in found.guards if one.agent == old.agent}
        assert difference(old.tree, new.tree, len(old.features), aside) is None
        rows = observe(old.features, states, before.world, old.numbers)
        below = [leaf for leaf in ir.leaves(old.tree) if aside & set(upwards(old.tree, int(leaf)))]
        kept = ~np.isin(ir.apply(old.tree, rows), below)
        assert (ir.act(old, rows)[kept] == ir.act(new, rows)[kept]).all()
        assert new.tree is old.tree or new.grown is None


def test_one_wrong_leaf_costs_one_guard_and_no_more(profile, claim):
    wrong = team(profile, towards(0, 0), ASTRAY)
    region = start_region(wrong.world)
    assert verify(Question(Game(wrong), claim, region), {}).verdict is Verdict.VIOLATED
    found = repair(Question(Game(wrong), claim, region))
    assert found.ended and [(one.agent, one.node, one.landmark) for one in found.guards] == [
        ("agent_1", 4, "landmark_1")
    ]
    guard = found.guards[0].tree
    assert guard.action.tolist() == [-1, DOWN, UP] and -0.1 < guard.threshold[0] < 0, "up is right where it is near"
    proved(found.profile, claim, region)
    unchanged(wrong, found, region)


@pytest.mark.parametrize(
    "pair",
    [
        (towards(0, 0), towards(0, 1)),
        (tree(STAY), tree(STAY)),
        (tree((8, 0.0, 1, 2), LEFT, RIGHT), tree((0, 0.3, 1, 2), UP, DOWN)),
        (towards(1, 0), tree((9, -0.25, 1, 2), UP, STAY)),
    ],
    ids=["same target", "standing still", "no landmark seen", "half a role"],
)
def test_teams_that_violate_are_repaired_in_the_whole_start_region(profile, claim, pair):
    wrong = team(profile, *pair)
    region = start_region(wrong.world)
    found = repair(Question(Game(wrong), claim, region))
    assert found.ended and found.guards and found.rounds and len(set(found.roles.values())) == 2
    assert proved(found.profile, claim, region).evidence.control.verdict is Verdict.VIOLATED
    unchanged(wrong, found, region)


def test_learned_trees_are_repaired_and_so_are_their_shuffled_ones(profile, claim):
    region = start_region(profile.world)
    for before in (profile, shuffle_leaves(profile, claim.team)):
        found = repair(Question(Game(before), claim, region))
        assert found.ended and found.guards
        proved(found.profile, claim, region)
        unchanged(before, found, region)
        assert found.profile.policy("adversary_0") is before.policy("adversary_0")


def test_random_trees_are_repaired_for_every_radius_and_margin(profile):
    rng = np.random.default_rng(0)
    region = start_region(profile.world)
    for margin, radius in ((0, Fraction(1, 10)), (Fraction(1, 40), Fraction(1, 10)), (0, Fraction(1, 100)), (0, 1)):
        claim = DistinctTargets("defenders", margin=Fraction(margin), radius=Fraction(radius))
        wrong = team(profile, random_tree(rng, 10, 4), random_tree(rng, 10, 3))
        found = repair(Question(Game(wrong), claim, region))
        assert found.ended, (margin, radius, found.reason)
        proved(found.profile, claim, region)
        unchanged(wrong, found, region)


def test_three_agents_share_three_landmarks():
    before, claim = navigation(np.random.default_rng(4), 3)
    claim, region = DistinctTargets(claim.team, claim.margin, claim.radius), everywhere(before)
    found = repair(Question(Game(before), claim, region))
    assert found.ended and sorted(found.roles.values()) == ["landmark_0", "landmark_1", "landmark_2"]
    assert engine.decide(stated(found.profile, formula(before, claim), region)).verdict is Verdict.PROVED
    unchanged(before, found, region)


@pytest.mark.smoke
def test_what_is_proved_stays_as_it_is(profile, claim):
    roles = team(profile, towards(0, 0), towards(1, 1))
    found = repair(Question(Game(roles), claim, start_region(roles.world)))
    assert found.ended and not found.guards and not found.rounds
    assert dumps(found.profile) == dumps(roles)


def test_the_landmarks_of_own_target_are_the_roles(profile):
    swapped = find_property("own_target", profile, landmarks=("landmark_1", "landmark_0"))
    roles = team(profile, towards(0, 0), towards(1, 1))
    found = repair(Question(Game(roles), swapped, start_region(roles.world)))
    assert found.ended and found.roles == {"agent_0": "landmark_1", "agent_1": "landmark_0"}
    proved(found.profile, swapped, start_region(roles.world))


def test_a_smaller_region_needs_fewer_guards(profile, claim):
    still = team(profile, tree(STAY), towards(1, 1))
    start = start_region(still.world)
    apart = {"agent_0.x": (Fraction(1, 2), Fraction(1)), "landmark_0.x": (Fraction(-1), Fraction(0))}
    left = Region({**start.box, **apart}, start.goals)
    found = repair(Question(Game(still), claim, left))
    assert found.profile.policy("agent_0").tree.action.tolist() == [LEFT]
    proved(found.profile, claim, left)
    assert verify(Question(Game(found.profile), claim, start), {}).verdict is Verdict.VIOLATED


def test_regions_too_thin_or_empty_to_sample(profile, claim):
    still, start = team(profile, tree(STAY), towards(1, 1)), start_region(profile.world)
    thin = replace(start, differences=(("agent_0.x", "landmark_0.x", (Fraction(1, 2), Fraction(1, 2))),))
    found = repair(Question(Game(still), claim, thin))
    assert found.ended and found.profile.policy("agent_0").tree.action.tolist() == [LEFT]
    proved(found.profile, claim, thin)
    empty = replace(start, differences=(("agent_0.x", "landmark_0.x", (Fraction(5), Fraction(6))),))
    found = repair(Question(Game(still), claim, empty))
    assert not found.ended and found.reason == "the region holds no world state"


def test_guards_stay_within_the_depth_where_they_can(profile, claim):
    still = team(profile, tree(STAY), tree(STAY))
    region = start_region(still.world)
    assert repair(Question(Game(still), claim, region)).depth > 3
    found = repair(Question(Game(still), claim, region), max_depth=3)
    assert found.ended and found.depth == 3
    proved(found.profile, claim, region)
    tight = repair(Question(Game(still), claim, region), max_depth=1)
    assert tight.ended and tight.depth > 1, "within the depth where it can be, else deeper"


def test_where_a_leafs_guard_is_too_deep_a_split_above_it_is_replaced(profile, claim):
    """Trees of depth 4 with leaves that need three tests: never deeper than 6, and what is not below stays."""
    rng, region, splits = np.random.default_rng(3), start_region(profile.world), 0
    for _ in range(2):
        wrong = team(profile, random_tree(rng, 10, 4), random_tree(rng, 10, 4))
        free = repair(Question(Game(wrong), claim, region))
        found = repair(Question(Game(wrong), claim, region), max_depth=6)
        assert free.ended and found.ended and found.depth <= 6
        proved(found.profile, claim, region)
        unchanged(wrong, found, region)
        splits += sum(wrong.policy(one.agent).tree.feature[one.node] != ir.NO_FEATURE for one in found.guards)
    assert splits, "some guard stands for a split"


def test_visited_states_decide_what_is_cheap(profile, claim):
    wrong = team(profile, towards(0, 0), towards(0, 1))
    region = start_region(wrong.world)
    states, _ = sample(region, wrong.world, 5_000, 1)
    free, told = repair(Question(Game(wrong), claim, region)), repair(Question(Game(wrong), claim, region), states[:0])
    assert dumps(free.profile) == dumps(told.profile), "no states are as good as none"
    found = repair(Question(Game(wrong), claim, region), states)
    assert found.ended and 0 < found.price < 2


@pytest.mark.parametrize("changes", [{"radius": Fraction(0)}, {"margin": Fraction(1, 5)}])
def test_what_no_guard_can_keep_is_refused_with_the_leaf(profile, claim, changes):
    found = repair(
        Question(Game(team(profile, tree(STAY), tree(STAY))), replace(claim, **changes), start_region(profile.world))
    )
    assert not found.ended and "no guard keeps agent_" in found.reason and "leaf 0" in found.reason


def test_a_spent_budget_is_no_repair(profile, claim):
    found = repair(Question(Game(profile), claim, start_region(profile.world), budgets=Budgets(max_nodes=3)))
    assert not found.ended and "search nodes" in found.reason


def test_claims_and_teams_beyond_it_are_input_errors(profile, claim):
    region = start_region(profile.world)
    with pytest.raises(InputError, match="cannot be repaired"):
        repair(Question(Game(profile), NoDouble("defenders"), region))
    policy = profile.policy("agent_1")
    blind = tuple(
        replace(one, name="a", meaning=profile.policy("agent_0").features[0].meaning) for one in policy.features
    )
    agents = tuple(replace(one, features=blind) if one is policy else one for one in profile.agents)
    with pytest.raises(InputError, match="agent_1 does not observe its offset to landmark_0"):
        repair(Question(Game(replace(profile, agents=agents)), claim, region))


def test_claims_beside_one_another_are_kept_by_the_same_guards(profile):
    """Guards for the wide claim alone do not keep the narrow one in its own region."""
    start = start_region(profile.world)
    right = {"landmark_0.x": (Fraction(1, 2), Fraction(1)), "agent_0.x": (Fraction(-1), Fraction(0))}
    wide = find_property("own_target", profile, radius=Fraction(1, 2))
    narrow = find_property("own_target", profile, radius=Fraction(1, 30), margin=Fraction(1, 40))
    wrong = team(profile, random_tree(np.random.default_rng(0), 10, 2), towards(1, 1))
    asked = [Question(Game(wrong), wide, start), Question(Game(wrong), narrow, Region(start.box | right, start.goals))]
    alone = repair(asked[0])
    assert alone.ended and engine.decide(asked[1].of(alone.profile)).verdict is Verdict.VIOLATED
    found = repair(asked[0], beside=asked[1:])
    assert found.ended
    for each in asked:
        proved(found.profile, each.claim, each.region)
    unchanged(wrong, found, start)


def test_claims_that_fix_different_landmarks_are_refused(profile):
    region = start_region(profile.world)
    asked = [
        Question(Game(profile), find_property("own_target", profile, landmarks=marks), region)
        for marks in (("landmark_0", "landmark_1"), ("landmark_1", "landmark_0"))
    ]
    with pytest.raises(InputError, match="ask for different landmarks"):
        repair(asked[0], beside=asked[1:])


def test_a_repair_that_breaks_something_else_gives_way_to_the_next(profile, claim):
    question = Question(Game(team(profile, tree(STAY), tree(STAY))), claim, start_region(profile.world))
    first = repair(question)
    second = repair(question, broken=lambda after: "no" if dumps(after) == dumps(first.profile) else "")
    assert second.ended and second.roles != first.roles and first.price <= second.price
    none = repair(question, broken=lambda after: "something else breaks")
    assert not none.ended and none.reason == "something else breaks" and none.guards


def test_leaves_and_splits_are_grafted_upon():
    with pytest.raises(KeyError):
        graft_parts(ASTRAY, {len(ASTRAY.feature): tree(STAY)})
    assert graft_parts(ASTRAY, {0: tree(STAY)}).action.tolist() == [STAY]
    whole = graft_parts(tree(STAY), {0: ASTRAY})
    assert difference(whole, ASTRAY, 10) is None and (whole.feature == ASTRAY.feature).all()
