"""Errors of features in the zone engine: against Z3, errors tried one by one, and teams with known verdicts."""

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

from codegen import ir
from codegen.floats import FLOAT32
from codegen.ir import Meaning
from tests.support.steady_zones import CLAIM, EPS, agree
from tests.support.teams import RIGHT, STAY, UP, team, towards, tree
from tests.support.zone_cases import noisy_roles, stated
from verify.checker.thresholds import sides
from verify.claims.catalogue import find_property
from verify.claims.decisions import DistinctTargets, formula
from verify.claims.formula import holds
from verify.claims.region import Region
from verify.claims.region_files import start_region
from verify.counterexamples import search
from verify.decimals import text
from verify.kinds import MACHINE
from verify.question import Budgets, Question, from_start
from verify.reports import report
from verify.result import Verdict
from verify.solver.solve import decide
from verify.states import noise
from verify.states.state import sample, violates
from verify.subjects import Game
from verify.verdicts import decisions as engine
from verify.verdicts.decisions import MAX_QUESTIONS, STEP, by_zones
from verify.zones import engine as zones
from verify.zones import tables

pytestmark = pytest.mark.solver
BUDGET = 10**9


def test_tests_of_one_feature_share_its_error(profile, monkeypatch):
    """Without that, proofs are lost: leaves that no error reaches would count."""
    rng, questions = np.random.default_rng(24), []
    for _ in range(40):
        pair, claim = noisy_roles(rng, profile)
        questions.append((pair, formula(pair, claim), start_region(pair.world), claim.eps))
    right = [zones.decide(stated(*asked, eps=eps)).verdict for *asked, eps in questions]
    monkeypatch.setattr(zones, "find_barred_sides", lambda *_: frozenset())
    apart = [zones.decide(stated(*asked, eps=eps)).verdict for *asked, eps in questions]
    assert all(other is verdict for verdict, other in zip(right, apart, strict=True) if verdict is Verdict.VIOLATED)
    assert sum(verdict is not other for verdict, other in zip(right, apart, strict=True)) > 0


def test_a_feature_read_twice_and_two_that_measure_the_same(profile):
    near = dict.fromkeys(start_region(profile.world).box, (Fraction(0), Fraction(0)))
    near |= {f"landmark_{k}.{axis}": (Fraction(1), Fraction(1)) for k in (0, 1) for axis in "xy"}
    region = Region(near | {"agent_0.x": (Fraction(-2), Fraction(2))}, ("landmark_0",))
    twice = team(profile, tree((2, 0.3, 1, 2), UP, (2, 0.15, 3, 4), STAY, UP), tree(UP))
    assert agree(twice, CLAIM, region) is Verdict.PROVED
    apart = team(profile, tree((0, 0.3, 1, 2), UP, (2, 0.15, 3, 4), STAY, UP), tree(UP))
    assert agree(apart, CLAIM, region) is Verdict.VIOLATED
    reached = noise.reachable(twice.policy("agent_0"), sample(region, twice.world, 400, 0)[0], twice.world, float(EPS))
    assert not reached[:, STAY].any(), "the shares count a leaf that no error reaches"


def test_the_least_error_that_matters_is_found_exactly(profile):
    box = dict.fromkeys(start_region(profile.world).box, (Fraction(0), Fraction(0)))
    box |= {f"landmark_{k}.{axis}": (Fraction(1), Fraction(1)) for k in (0, 1) for axis in "xy"}
    region = Region(box, ("landmark_0",))
    one = team(profile, tree((2, 0.75, 1, 2), STAY, RIGHT), tree(UP))
    # 0.75, half a float32 step and half a float64 step above it still go left
    end, little = 1 - Fraction(3, 4) - Fraction(1, 2**25) - Fraction(1, 2**54), Fraction(1, 2**200)
    verdicts = [agree(one, DistinctTargets("defenders", eps=eps), region) for eps in (end - little, end, end + little)]
    assert verdicts == [Verdict.PROVED, Verdict.VIOLATED, Verdict.VIOLATED]


@pytest.mark.parametrize("function", ["sign", "positive"])
@pytest.mark.parametrize("threshold", [-1.5, -1.0, -0.5, 0.0, 0.5, 1.0])
def test_sides_of_functions_move_where_the_sum_does(function, threshold):
    spec = ir.FeatureSpec("s", "", -1.0, 1.0, Meaning(((1, "agent_0.x"),), function))
    eps, little = Fraction(1, 4), Fraction(1, 2**80)
    for total in (-eps - little, -eps, -eps + little, Fraction(0), eps - little, eps, eps + little):
        values = set()
        for error in (-eps, -total if abs(total) <= eps else eps, eps, little - total, -little - total):
            if abs(error) <= eps:
                exact = total + error
                values.add((exact > 0) - (exact < 0) if function == "sign" else int(exact > 0))
        left, right = (holds(side, {"agent_0.x": total}, {}) for side in sides(spec, threshold, FLOAT32, MACHINE, eps))
        assert left == any(value <= threshold for value in values), (total, values)
        assert right == any(value > threshold for value in values), (total, values)


def test_one_coordinate_with_an_error_is_rounded_twice():
    spec = ir.FeatureSpec("x", "", -9.0, 9.0, Meaning(((1, "agent_0.x"),)))
    exact, off = (sides(spec, 0.5, FLOAT32, MACHINE, eps)[0] for eps in (Fraction(0), EPS))
    assert off.bound - EPS > exact.bound


def test_equalities_and_constants_have_no_errors():
    equal = ir.FeatureSpec("e", "", 0.0, 1.0, Meaning(((1, "agent_0.x"), (-1, "agent_1.x")), "zero"))
    nothing = ir.FeatureSpec("n", "", 0.0, 0.0, Meaning(()))
    for spec in (equal, nothing):
        assert sides(spec, 0.5, FLOAT32, MACHINE, EPS) == sides(spec, 0.5, FLOAT32, MACHINE)


def test_zones_alone_give_a_counterexample_with_errors(profile):
    """Their point holds no errors; those that lead to the open leaves are found for it."""
    roles = team(profile, towards(0, 0), towards(1, 1))
    claim, region = DistinctTargets("defenders", eps=Fraction(1, 4)), start_region(roles.world)
    zoned = by_zones(Question(Game(roles), claim, region, budgets=Budgets(BUDGET)))
    state = search.near(Question(Game(roles), claim, region), zoned.goal, zoned.state)
    assert state.errors and violates(from_start(roles, claim), state)
    assert all(abs(Fraction(error)) <= claim.eps for error in state.errors.values())


def test_up_to_which_errors_a_claim_holds(profile):
    """Proved there and not one step further; where it does not hold at all nothing is sought."""
    roles = team(profile, towards(0, 0), towards(1, 1))
    region = start_region(roles.world)
    claim = DistinctTargets("defenders", eps=Fraction(1, 100))
    found = engine.verify(Question(Game(roles), claim, region), {})
    room = found.evidence.steady_up_to
    assert found.verdict is Verdict.PROVED and found.evidence.certificate.header.eps == claim.eps
    assert room.failed == room.proved + STEP and claim.eps < room.proved and room.questions <= MAX_QUESTIONS
    for eps, verdict in ((room.proved, Verdict.PROVED), (room.failed, Verdict.VIOLATED)):
        assert decide(Question(Game(roles), replace(claim, eps=eps), region)).verdict is verdict
    facts = report.document(roles, [found], [""])
    assert facts["results"][0]["largest_eps"]["proved"] == text(room.proved)
    assert f"proved up to eps {text(room.proved)}, not at" in report.as_text(facts)
    assert "largest eps" in report.as_html(facts)
    off = engine.verify(Question(Game(roles), replace(claim, eps=room.failed), region), {})
    assert off.verdict is Verdict.VIOLATED and off.evidence.steady_up_to is None
    plain = engine.verify(Question(Game(roles), find_property("distinct_targets", roles), region), {})
    assert plain.evidence.steady_up_to is None
    facts = report.document(roles, [plain], [""])
    assert "largest_eps" not in facts["results"][0] and "eps" not in report.as_text(facts)


@pytest.mark.parametrize("name", ["aligned", "assignment"])
def test_what_zones_cannot_decide_is_left_to_z3(profile, name):
    claim = find_property("steady", profile, of=name)
    question = Question(Game(profile), claim, start_region(profile.world), budgets=Budgets(BUDGET))
    assert by_zones(question).opinion.verdict is Verdict.SKIPPED


def test_without_errors_nothing_is_barred(profile):
    """Ordinary questions keep their proofs: a side that tests above contradict is closed there by a cycle."""
    twice = team(profile, tree((2, 0.3, 1, 2), UP, (2, 0.15, 3, 4), STAY, UP), tree(UP))
    policy = twice.policy("agent_0")
    splits = tables.split_sides(policy, MACHINE)
    assert tables.find_barred_sides(policy, splits) == {(2, 0)}
    table = tables.Table(twice, formula(twice, find_property("own_target", twice)), start_region(twice.world), None)
    assert all(None not in sides for sides in tables.zone_tree(table, policy, splits).sides if sides[0])
