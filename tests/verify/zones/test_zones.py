"""The zone engine: against Z3, against exact evaluation at rational points, and against known verdicts."""

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

from codegen import ir
from codegen.errors import InputError
from tests.support.steady_zones import agree
from tests.support.teams import RIGHT, STAY, UP, team, team_in, towards, tree
from tests.support.zone_cases import (
    NAVIGATION,
    deception,
    navigation,
    near_roles,
    noisy,
    random_region,
    random_tree,
    stated,
    switching,
)
from verify.certificates.proofs import varint
from verify.checker.certificate import numbers
from verify.claims.catalogue import find_property
from verify.claims.decisions import DistinctTargets, formula
from verify.claims.formula import Linear
from verify.claims.region import Region
from verify.claims.region_files import start_region
from verify.claims.wording import BUILT_IN
from verify.kinds import MACHINE, REAL
from verify.question import Question, from_start, shuffle_leaves
from verify.result import Verdict
from verify.solver.solve import decide
from verify.states.state import State, violates
from verify.subjects import Game
from verify.zones import engine as zones

pytestmark = pytest.mark.solver


def with_errors(rng, profile):
    """Three agents whose features of one coordinate are rounded twice, as errors are added to them."""
    trio, claim = navigation(rng, 3)
    return trio, BUILT_IN[claim.name]("agents", radius=claim.radius, eps=Fraction(1, 10))


BOTH = {Verdict.PROVED, Verdict.VIOLATED}
RANDOM = [  # (who is drawn, arithmetic, questions of a seed, how often about the start region, verdicts met, seeds)
    (lambda rng, _: deception(rng, 4), MACHINE, 12, 0.0, {Verdict.VIOLATED}, 9),
    (lambda rng, _: deception(rng, 4), REAL, 12, 0.0, {Verdict.VIOLATED}, 9),
    (near_roles, MACHINE, 8, 0.5, BOTH, 6),
    (lambda rng, _: navigation(rng, 3), MACHINE, 4, 0.0, set(), 4),
    (noisy, MACHINE, 16, 0.4, BOTH, 6),
    (noisy, REAL, 10, 0.0, set(), 3),
    (with_errors, MACHINE, 4, 0.0, set(), 3),
]


@pytest.mark.parametrize(("kind", "seed"), [(kind, seed) for kind, row in enumerate(RANDOM) for seed in range(row[-1])])
def test_random_questions(profile, kind, seed):
    """Every meaning, sharp thresholds, dead leaves; roles that are fixed, or switch at adjacent floats; regions with
    equalities, differences and distances.
    """
    draw, semantics, count, started, met, _ = RANDOM[kind]
    rng, found = np.random.default_rng([seed, kind]), set()
    for _ in range(count):
        asked, claim = draw(rng, profile)
        region = start_region(asked.world) if rng.random() < started else random_region(rng, asked)
        found.add(agree(asked, claim, region, semantics, seed))
    assert met <= found


@pytest.mark.parametrize(("threshold", "semantics"), [(0.1, MACHINE), (-0.3, MACHINE), (0.1, REAL)])
def test_roles_that_switch_at_adjacent_floats(profile, threshold, semantics):
    """Proved for the machine; over the reals the gap between the two thresholds is a violation, and real."""
    pair = team(profile, *switching(threshold))
    claim = formula(pair, find_property("distinct_targets", pair))
    found = zones.decide(stated(pair, claim, start_region(pair.world), semantics))
    assert found.verdict is (Verdict.PROVED if semantics == MACHINE else Verdict.VIOLATED)


@pytest.mark.parametrize("name", ["distinct_targets", "own_target"])
def test_fixed_roles_are_proved_leaf_by_leaf(profile, name):
    """A claim that leaves settle has a proof linear in the leaves."""
    roles = team(profile, towards(0, 0), towards(1, 1))
    claim = formula(roles, find_property(name, roles))
    found = zones.decide(stated(roles, claim, start_region(roles.world)))
    leaves = sum(len(ir.leaves(roles.policy(agent).tree)) for agent in ("agent_0", "agent_1"))
    assert found.verdict is Verdict.PROVED
    assert all(len(proof) <= 20 * leaves for proof in found.proofs.values())


def test_unused_lemmas_are_left_out(profile):
    """Agent 1 closes on both landmarks wherever it is; one of the two is needed."""
    box = start_region(profile.world).box | {"agent_1.y": (Fraction(-2), Fraction(-2))}
    roles = team(profile, towards(0, 0), tree(UP))
    claim = formula(roles, find_property("distinct_targets", roles))
    found = zones.decide(stated(roles, claim, Region(box, ("landmark_0",))))
    own = zones.decide(stated(roles, formula(roles, find_property("own_target", roles)), Region(box, ("landmark_0",))))
    assert found.proofs["landmark_0"][-5:] == own.proofs["landmark_0"][-5:]
    assert len(found.proofs["landmark_0"]) == len(own.proofs["landmark_0"])


@pytest.mark.smoke
def test_shuffled_teams_are_refuted(profile):
    roles = team(profile, towards(0, 0), towards(1, 1))
    claim = find_property("distinct_targets", roles)
    for seed in range(5):
        control = shuffle_leaves(roles, claim.team, seed)
        found = zones.decide(stated(control, formula(control, claim), start_region(roles.world)))
        assert found.verdict is Verdict.VIOLATED


def test_points_have_room_where_there_is_some(profile):
    """The float64 neighbour of the exact point violates the claim too."""
    same = team(profile, towards(0, 0), towards(0, 1))
    claim = find_property("distinct_targets", same)
    found = zones.decide(stated(same, formula(same, claim), start_region(same.world)))
    near = State({name: float(value) for name, value in found.state.items()}, found.goal)
    assert violates(from_start(same, claim), near)


def test_the_budget_counts_nodes_and_the_same_question_costs_the_same(profile):
    claim = formula(profile, find_property("distinct_targets", profile))
    region = start_region(profile.world)
    full = zones.decide(stated(profile, claim, region))
    assert full.nodes == zones.decide(stated(profile, claim, region)).nodes > 10
    short = zones.decide(stated(profile, claim, region, budget=5))
    assert short.verdict is Verdict.UNKNOWN and "5 search nodes" in short.reason and short.nodes == 10


def test_one_goal_may_be_asked_alone(profile):
    claim = formula(profile, find_property("own_target", profile))
    roles = team(profile, towards(0, 0), towards(1, 1))
    found = zones.decide(stated(roles, claim, start_region(profile.world), goals=("landmark_1",)))
    assert set(found.proofs) == {"landmark_1"}


@pytest.mark.smoke
def test_a_strict_cycle_of_sum_zero_is_empty(profile):
    """x below y and y at most x; and the same cycle without a strict bound is not."""
    one = Fraction(1)
    still = team(profile, tree(STAY), tree(STAY))
    gap = ((one, "agent_0.x"), (-one, "agent_1.x"))
    region = replace(start_region(profile.world), differences=(("agent_0.x", "agent_1.x", (Fraction(0), Fraction(0))),))
    for strict, verdict in ((True, Verdict.VIOLATED), (False, Verdict.PROVED)):
        claim = Linear(gap, Fraction(0), strict)  # its denial is a - b >= 0, or > 0
        assert zones.decide(stated(still, claim, region)).verdict is verdict


def test_inequalities_beyond_difference_bounds_are_told(profile):
    for name in ("aligned", "assignment"):
        with pytest.raises(zones.BeyondZonesError):
            zones.decide(stated(profile, formula(profile, find_property(name, profile)), start_region(profile.world)))


def test_coordinates_that_the_region_does_not_bound_are_refused():
    names = [feature.name for feature in NAVIGATION.features[0]]
    fast = tree((names.index("vx"), 0.0, 1, 2), RIGHT, UP)
    profile = team_in(NAVIGATION, [fast] * 3)
    with pytest.raises(InputError, match=r"agent_0\.vx, which regions cannot bound"):
        zones.decide(stated(profile, formula(profile, DistinctTargets("agents")), start_region(NAVIGATION.spec)))


@pytest.mark.parametrize("number", [0, 1, 127, 128, 300, 2**21, 2**62])
def test_numbers_of_a_proof_come_back(number):
    assert list(numbers(varint(number) + varint(5))) == [number, 5]


def test_deep_trees_do_not_meet_the_recursion_limit(profile):
    rng = np.random.default_rng(3)
    nodes = []  # goes right at each split: split, left leaf, split, left leaf, ...
    for level in range(ir.MAX_DEPTH):
        place = 2 * level
        nodes += [(2, float(np.float32(-1 + level / 40)), place + 1, place + 2), level % 5]
    pair = team(profile, tree(*nodes, STAY), random_tree(rng, 10, 2))
    claim, region = find_property("distinct_targets", pair), start_region(pair.world)
    found = zones.decide(stated(pair, formula(pair, claim), region))
    assert found.verdict is decide(Question(Game(pair), claim, region)).verdict
