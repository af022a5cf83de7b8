"""What no answer says of its budget: the numbers that were spent, and an option that the verb has."""

import re

import pytest

from codegen import policy_json
from maviper.cli import main
from maviper.verification.repair import repair_profile, request
from tests.support.strategies import with_trees
from tests.support.teams import LEFT, RIGHT, team, towards, tree
from verify.claims.catalogue import find_claim
from verify.claims.region_files import everywhere
from verify.claims.wording import AliveLeaves
from verify.question import Budgets, Question
from verify.repair import repair
from verify.result import Verdict
from verify.solver import encode, solve
from verify.subjects import Game

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
