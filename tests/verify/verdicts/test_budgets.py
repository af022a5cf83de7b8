"""What no answer says of its budget: the numbers that were spent, and an option that the verb has."""

import re

import pytest

from codegen import policy_json
from maviper.cli import main
from maviper.verification.repair import repair_profile, request
from tests.benchmarks.large import full
from tests.support.strategies import with_trees
from tests.support.teams import LEFT, RIGHT, team, towards, tree
from verify.claims.catalogue import find_claim, find_property
from verify.claims.region_files import everywhere
from verify.claims.wording import AliveLeaves
from verify.question import Budgets, Question, from_start
from verify.repair import repair
from verify.result import Verdict
from verify.solver import encode, solve
from verify.solver.encode import query
from verify.solver.solve import decide
from verify.states.shares import measure
from verify.subjects import Game
from verify.verdicts.decisions import by_zones, verdict, verify

pytestmark = pytest.mark.solver


def asked(profile, name="distinct_targets", **limits):
    return Question(Game(profile), find_claim(name, profile), everywhere(profile), budgets=Budgets(**limits))


@pytest.fixture
def crossed(profile):
    return team(profile, towards(0, 0), towards(1, 1))


def test_the_solver_says_how_much_was_spent_and_what_helps(crossed):
    found = solve.decide(asked(crossed, solver_units=1))
    assert found.verdict is Verdict.UNKNOWN
    assert re.search(r"after [\d,]+ resource units; a larger --effort may answer$", found.reason)


def test_a_query_that_a_larger_budget_would_write_says_so(crossed, monkeypatch):
    monkeypatch.setattr(encode, "FEW_TESTS", 1)
    found = solve.decide(asked(crossed, solver_units=64))
    assert "is not asked" in found.reason and found.reason.endswith("a larger --effort may answer")
    monkeypatch.setattr(encode, "MAX_TESTS", 1)
    assert solve.decide(asked(crossed, solver_units=64)).reason.endswith("smaller trees may be decided")


def test_a_leaf_that_is_left_open_says_what_helps(profile):
    """The second leaf is so thin that no sampled state reaches it."""
    thin = with_trees({"agent_0": tree((2, 0.0, 1, 2), LEFT, (2, 1e-9, 3, 4), RIGHT, LEFT)}, profile)
    question = Question(Game(thin), AliveLeaves("defenders"), everywhere(thin), budgets=Budgets(1))
    reasons = [one.reason for one in solve.leaf_findings(question)[0] if one.reason]
    assert reasons and all(one.endswith("resource units; a larger --effort may answer") for one in reasons)


def test_a_comparison_names_its_option(crossed, profile, tmp_path, capsys):
    other = team(profile, towards(1, 0), towards(1, 1))
    for name, one in (("a", crossed), ("b", other)):
        (tmp_path / name).write_text(policy_json.dumps(one))
    main.run(["diff", str(tmp_path / "a"), str(tmp_path / "b"), "--set", "max_nodes=1"])
    told = capsys.readouterr().err
    assert "a larger --effort" in told


def test_a_repair_names_no_option_that_it_does_not_have(profile):
    wrong = team(profile, towards(0, 0), towards(0, 1))
    found = repair(asked(wrong, max_nodes=1, option=""), None)
    assert found.reason.endswith("smaller trees or a smaller region may be decided")
    found = repair_profile(wrong, "distinct_targets", "start", request("distinct_targets", {"episodes": 1}))
    assert "--effort" not in found.repair.reason


FEW = 20_000  # solver units, which buy 400 search nodes


@pytest.fixture(scope="module")
def question():
    crowd = full("cooperative-navigation,agents=8", 4, "agents")
    return from_start(crowd, find_property("no_double", crowd))


@pytest.mark.solver
def test_pairs_of_eight_agents_are_answered_within_the_budget(question):
    small = question.spending(solver_units=FEW)
    found, second = by_zones(small).opinion, decide(small)
    assert {found.verdict, second.verdict} <= {Verdict.VIOLATED, Verdict.UNKNOWN}
    assert found.spent <= FEW // 50
    assert by_zones(question).opinion.verdict is Verdict.VIOLATED


def test_shares_of_claims_about_pairs(question):
    assert measure(question, 0, 500).conflict.value > 0.1


@pytest.mark.solver
def test_queries_beyond_the_budget_are_not_written(monkeypatch):
    """The zones' verdict stands; Z3 says what its query would have taken, and exports are whole whatever their size."""
    pair = full("physical-deception", 4, "defenders")
    asked = from_start(pair, find_property("distinct_targets", pair))
    tests = 4 * (2**4 - 1)  # two agents, each engaged or not with two landmarks
    before = verdict(asked)
    monkeypatch.setattr(encode, "MAX_TESTS", tests)
    assert query(asked, "landmark_0").constraints and decide(asked).verdict is Verdict.VIOLATED
    monkeypatch.setattr(encode, "MAX_TESTS", tests - 1)
    second = decide(asked)
    assert second.verdict is Verdict.UNKNOWN and f"a query with {tests} tests of trees" in second.reason
    assert second.reason.endswith("; smaller trees may be decided")
    assert verdict(asked) == before == (Verdict.VIOLATED, "")
    found = verify(asked, {})
    assert found.evidence.counterexample is not None and found.evidence.control.verdict is Verdict.VIOLATED
    assert query(asked, "landmark_0", however_large=True).constraints
