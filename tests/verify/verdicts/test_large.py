"""Large questions end within their budgets: the small form of tests/benchmarks/large.py."""

import pytest

from tests.benchmarks.large import full
from verify.claims.catalogue import find_property
from verify.question import from_start
from verify.result import Verdict
from verify.solver import encode
from verify.solver.encode import query
from verify.solver.solve import decide
from verify.states.shares import measure
from verify.verdicts.decisions import by_zones, verdict, verify

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
