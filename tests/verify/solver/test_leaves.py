"""Leaves that no world state reaches: proved dead, or reached by a state that the reference takes there."""

from fractions import Fraction

import numpy as np
import pytest

from codegen import ir
from codegen.errors import InputError
from tests.support.teams import DOWN, LEFT, RIGHT, STAY, UP, team, towards, tree
from verify.claims.catalogue import find_property
from verify.claims.region import Region
from verify.claims.region_files import start_region
from verify.claims.wording import AliveLeaves
from verify.question import Budgets, Question
from verify.result import Verdict
from verify.solver.solve import dead_leaves, leaf_findings
from verify.states.state import inside, observe_state
from verify.subjects import Game
from verify.verdicts.decisions import verify

pytestmark = pytest.mark.solver

# goal_dx (0) is landmark_0_dx (2) or landmark_1_dx (4): below -0.5 while both are above 0.5 is impossible
BOTH = tree((2, 0.5, 1, 2), LEFT, (4, 0.5, 3, 4), RIGHT, (0, -0.5, 5, 6), DOWN, UP)
DEAD = 5
SLIVER = tree((2, 0.25, 1, 2), LEFT, (2, float(np.nextafter(np.float32(0.25), np.float32(1))), 3, 4), UP, RIGHT)


@pytest.fixture
def whole(profile):
    return start_region(profile.world)


def test_a_dead_leaf_is_named_and_all_others_have_witnesses(profile, whole):
    one = team(profile, BOTH, SLIVER)
    found, _ = leaf_findings(Question(Game(one), AliveLeaves("defenders"), whole))
    assert [(f.agent, f.leaf) for f in found if f.verdict is Verdict.VIOLATED] == [("agent_0", DEAD)]
    for finding in found:
        if finding.verdict is Verdict.PROVED:  # the sliver of agent_1 too, one float32 wide
            policy = one.policy(finding.agent)
            assert inside(whole, finding.witness)
            assert int(ir.apply(policy.tree, observe_state(one, policy, finding.witness))[0]) == finding.leaf
    assert len(found) == 4 + 3


def test_dead_leaves_are_data_for_every_agent(profile, whole):
    still = team(profile, BOTH, tree(STAY))
    assert dead_leaves(still, whole) == {"adversary_0": [], "agent_0": [DEAD], "agent_1": []}
    left = Region(whole.box, whole.goals, differences=(("landmark_0.x", "agent_0.x", (Fraction(-2), Fraction(1, 2))),))
    assert dead_leaves(still, left)["agent_0"] == [3, DEAD, 6]


def test_open_leaves_are_not_dead(profile, whole):
    """A budget that answers nothing leaves leaves open."""
    still = team(profile, BOTH, tree(STAY))
    assert dead_leaves(still, whole, budget=1) == {"adversary_0": [], "agent_0": [], "agent_1": []}
    found = verify(Question(Game(still), find_property("alive_leaves", still), whole, budgets=Budgets(1)), {})
    assert found.verdict is Verdict.UNKNOWN and "resource units" in found.reason


def test_only_a_real_valued_state_leaves_a_leaf_open(profile, whole):
    """A region that no float64 state meets reaches its leaf over the reals only."""
    third = Region(dict.fromkeys(whole.box, (Fraction(1, 3), Fraction(1, 3))), ("landmark_0",))
    found, _ = leaf_findings(Question(Game(team(profile, tree(STAY), tree(STAY))), AliveLeaves("defenders"), third))
    assert {f.verdict for f in found} == {Verdict.UNKNOWN} and "real-valued" in found[0].reason


def test_the_property_says_it(profile, whole):
    claim = find_property("alive_leaves", profile)
    bad = verify(Question(Game(team(profile, BOTH, SLIVER)), claim, whole), {})
    assert bad.verdict is Verdict.VIOLATED and len(bad.evidence.leaves) == 7 and bad.evidence.counterexample is None
    assert bad.evidence.shares.conflict.count == 0 and bad.evidence.control.verdict is Verdict.SKIPPED
    good = verify(Question(Game(team(profile, towards(0, 0), SLIVER)), claim, whole), {})
    assert good.verdict is Verdict.PROVED
    none = Region(whole.box, whole.goals, apart=(("agent_0", "agent_1", Fraction(5)),))
    assert verify(Question(Game(profile), claim, none), {}).verdict is Verdict.VACUOUS


def test_leaves_agree_with_exhaustive_sampling(profile, whole):
    """No sampled state falls into a leaf that is called dead."""
    from codegen.observe import observe
    from verify.states.state import sample

    coordinates, _ = sample(whole, profile.world, 20_000, 5)
    dead = dead_leaves(profile, whole)
    for policy in profile.agents:
        reached = set(
            ir.apply(policy.tree, observe(policy.features, coordinates, profile.world, policy.numbers)).tolist()
        )
        assert not reached & set(dead[policy.agent])


def test_features_without_meaning_and_subnormal_thresholds_are_refused(profile, whole):
    with pytest.raises(InputError, match="subnormal"):
        dead_leaves(team(profile, tree((0, 1e-40, 1, 2), LEFT, RIGHT), tree(STAY)), whole)
