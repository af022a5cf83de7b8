"""Claims about many agents that are conjunctions of claims about few: asked one by one, proved by one certificate."""

from fractions import Fraction
from itertools import combinations

import pytest

from codegen.profiles import ensure
from tests.support.altered import altered, read_game
from tests.support.teams import LEFT, STAY, UP, team_in, tree
from tests.support.zone_cases import with_long_bounds
from verify.certificates.games import to_json
from verify.checker.decisions import FORM, PARTED, check_certificate
from verify.checker.reading import RejectedError
from verify.claims.formula import TRUE, Acts, And, Linear, Not, Or, agents, conjuncts
from verify.claims.wording import OwnFormula
from verify.question import from_start
from verify.result import Verdict
from verify.solver.encode import query
from verify.solver.solve import ask, decide
from verify.verdicts.decisions import by_zones, verify
from verify.zones import engine
from verify.zones.search import SLOWER

COUNT = 5


@pytest.fixture(scope="module")
def crowd():
    """Agents that go left or stay by their first feature; the last one also goes up."""
    trees = [tree((0, 0.25, 1, 2), LEFT, STAY)] * (COUNT - 1) + [tree((0, 0.25, 1, 2), LEFT, UP)]
    return ensure(team_in(f"cooperative-navigation,agents={COUNT}", trees))


def never_both(profile, action):
    names = [policy.agent for policy in profile.agents]
    pairs = [Or((Not(Acts(a, action)), Not(Acts(b, action)))) for a, b in combinations(names, 2)]
    return from_start(profile, OwnFormula(profile.agents[0].team, statement=And(tuple(pairs))))


def test_a_proof_in_parts_is_accepted_and_no_part_may_be_missing(crowd):
    question = never_both(crowd, UP)
    assert len(question.parts) == COUNT * (COUNT - 1) // 2
    found = by_zones(question)
    made = found.certificate
    assert found.opinion.verdict is Verdict.PROVED and made is not None and made.header.certificate == PARTED
    read = read_game(to_json(made))
    assert read == made and check_certificate(read, crowd) == found.branches
    whole = made.proof.proofs[""]
    for wrong in (whole[:-1], whole + b"\0", whole[len(whole) // 2 :], b""):
        with pytest.raises(RejectedError):
            check_certificate(altered(made, proofs={"": wrong}), crowd)
    with pytest.raises(RejectedError):
        check_certificate(altered(made, certificate=FORM), crowd)


@pytest.mark.solver
def test_a_part_that_fails_between_floats_does_not_end_the_others(crowd):
    """The first pair fails only where no float64 lies, the second one in many states, though not near those."""
    one, third = Fraction(1), Fraction(1, 3)
    first, second, third_agent, fourth = [policy.agent for policy in crowd.agents[:4]]
    beside = Linear(((-one, f"{first}.x"),), -third - Fraction(1, 2**70))
    sliver = Or((Not(Acts(first, LEFT)), Not(Acts(second, LEFT)), Linear(((one, f"{first}.x"),), third), beside))
    edge = Linear(((one, f"{third_agent}.x"),), Fraction(9, 10))
    often = Or((Not(Acts(third_agent, LEFT)), Not(Acts(fourth, LEFT)), edge))
    question = from_start(crowd, OwnFormula(crowd.agents[0].team, statement=And((sliver, often))))
    assert len(question.parts) == 2 and decide(question).part.claim == question.parts[0].claim
    found = verify(question, {})
    assert found.verdict is Verdict.VIOLATED
    position = found.evidence.counterexample.state.position
    assert position[f"{third_agent}.x"] > Fraction(9, 10) and isinstance(position[f"{first}.x"], float)
    alone = from_start(crowd, OwnFormula(crowd.agents[0].team, statement=sliver))
    assert verify(alone, {}).verdict is Verdict.UNKNOWN


@pytest.mark.solver
@pytest.mark.parametrize("action", [STAY, LEFT, UP])
def test_parts_give_the_verdict_of_the_whole(crowd, action, monkeypatch):
    question = never_both(crowd, action)
    found, second = engine.decide(question), decide(question)
    monkeypatch.setattr(type(question), "parts", property(lambda self: (self,)))
    whole = never_both(crowd, action)
    assert found.verdict is second.verdict is engine.decide(whole).verdict is decide(whole).verdict
    assert found.verdict is (Verdict.PROVED if action == UP else Verdict.VIOLATED)


@pytest.mark.parametrize("price", [1, SLOWER])
def test_the_parts_of_a_goal_share_its_search_nodes(crowd, price):
    """Also in a region with bounds of hundreds of digits, in which each node takes more of the budget."""
    question = never_both(crowd, UP)
    if price > 1:
        question = question.within(with_long_bounds(question.region))
    needed = engine.decide(question).nodes
    assert engine.decide(question.spending(max_nodes=needed * price)).verdict is Verdict.PROVED
    found = engine.decide(question.spending(max_nodes=needed * price - 1))
    assert found.verdict is Verdict.UNKNOWN and found.nodes == needed - 1
    assert found.reason == f"not decided within {needed - 1:,} search nodes; a larger --effort may answer"


@pytest.mark.solver
def test_the_parts_of_a_goal_share_its_solver_units(crowd):
    question = never_both(crowd, UP)
    whole = decide(question)
    found = decide(question.spending(solver_units=whole.resources // 2))
    assert found.verdict is Verdict.UNKNOWN and found.resources < whole.resources
    assert f"of {len(question.parts)} parts; a larger --effort may answer" in found.reason


@pytest.mark.solver
def test_a_goal_says_how_many_of_its_parts_were_answered(crowd):
    """A budget that the first answer uses up, and one that ends within the second."""
    question = never_both(crowd, UP)
    first = ask(query(question.parts[0], None)).resources
    for budget in (first, first + 1):
        reason = decide(question.spending(solver_units=budget)).reason
        assert f"resource units and 1 of {len(question.parts)} parts" in reason, reason


def test_conjuncts_hold_together_exactly_where_the_formula_does(crowd):
    question = never_both(crowd, UP)
    parts = conjuncts(question.formula)
    assert {agents(part) for part in parts} == {frozenset(pair) for pair in combinations(agents(question.formula), 2)}
    joined = conjuncts(And((Acts("a", 1), Acts("b", 1), Acts("a", 2), TRUE)))
    assert joined == (And((Acts("a", 1), Acts("a", 2))), Acts("b", 1), TRUE)
    assert conjuncts(Or((Acts("a", 1), Acts("b", 1)))) == (Or((Acts("a", 1), Acts("b", 1))),)


def test_claims_about_few_agents_are_asked_as_they_are(crowd, profile):
    for asked in (never_both(profile, UP), never_both(crowd, UP).about(OwnFormula("agents", statement=Acts("a", 1)))):
        assert asked.parts == (asked,)
