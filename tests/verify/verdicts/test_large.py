"""Large questions end within their budgets: the small form of tests/benchmarks/large.py."""

import pytest

from tests.benchmarks.large import full
from verify.claims.catalogue import find_property
from verify.claims.region import Verdict
from verify.question import from_start
from verify.solver.decide import decide
from verify.states.shares import measure
from verify.verdicts.opinions import by_zones

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
