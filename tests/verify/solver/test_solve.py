"""What Z3 is asked and answers: exact models, budgets that repeat, texts that mean the same to any solver; leaves that
no world state reaches are proved dead, others are reached by a state that the reference takes there.
"""

import itertools
import re
from fractions import Fraction
from fractions import Fraction as F

import numpy as np
import pytest
import z3

from codegen import ir
from codegen.errors import InputError
from tests.support.small import small_profile
from tests.support.teams import DOWN, LEFT, RIGHT, STAY, UP, team, towards, tree
from tests.support.zone_cases import stated
from verify.claims.catalogue import find_property
from verify.claims.formula import And, Linear, Or, holds
from verify.claims.region import Region
from verify.claims.region_files import start_region
from verify.claims.wording import AliveLeaves
from verify.question import Budgets, Question
from verify.result import Verdict
from verify.solver import encode
from verify.solver.solve import Answer, ask, ask_bits, dead_leaves, false_facts, leaf_findings, smt_lib, solver_name
from verify.states.state import inside, observe_state
from verify.subjects import Game
from verify.verdicts.decisions import verify

pytestmark = pytest.mark.solver
PROFILE = team(small_profile(), towards(0, 0), tree(STAY))
NAMES = ("agent_0.x", "agent_1.x", "landmark_0.x")


def line(*weights, bound, strict=False):
    terms = tuple((F(weight), name) for weight, name in zip(weights, NAMES, strict=True) if weight)
    return Linear(terms, F(bound), strict)


def query(formula):
    """The constraints of a state of the start region in which a formula does not hold."""
    region = start_region(PROFILE.world)
    return encode.query(stated(PROFILE, formula, region), region.goals[0])


@pytest.mark.parametrize(
    "formula",
    [
        line(1, 1, 1, bound=F(5, 2)),
        line(1, 1, 1, bound=3),
        line(1, 1, 1, bound=3, strict=True),
        And((line(1, 0, 0, bound=1), line(-3, 1, 0, bound=F(1, 3)))),
        Or((line(1, 0, 0, bound=F(-1, 3)), line(-1, 0, 0, bound=F(1, 3)))),
        Or((line(1, 0, 0, bound=F(-1, 3), strict=True), line(-1, 0, 0, bound=F(1, 3), strict=True))),
    ],
)
def test_a_model_fails_the_formula_exactly_and_without_one_no_corner_does(formula):
    """Linear claims over a box fail, if anywhere, at a corner or where one of their sums meets its bound."""
    found = ask(query(formula))
    tried = [F(n, 9) for n in range(-9, 10)]
    fails = [
        at for at in itertools.product(tried, repeat=3) if not holds(formula, dict(zip(NAMES, at, strict=True)), {})
    ]
    assert found.holds == bool(fails)
    if found.holds:
        assert all(type(value) is F for value in found.model.values())
        assert not holds(formula, found.model, {})
        assert all(low <= found.model[name] <= high for name, (low, high) in start_region(PROFILE.world).box.items())
    else:
        assert found.model is None


def test_the_same_question_takes_the_same_work_and_a_smaller_budget_ends():
    asked = query(
        And((line(1, -1, 0, bound=F(1, 2)), Or((line(0, 1, -1, bound=F(1, 7)), line(1, 0, 0, bound=F(1, 9))))))
    )
    first, again = ask(asked), ask(asked)
    assert first == again and first.resources > 0
    spent = ask(asked, 1)
    assert spent.holds is None and spent.model is None and spent.reason


def test_what_was_not_written_is_not_asked():
    asked = query(line(1, 0, 0, bound=0))
    assert ask(asked._replace(beyond="too many nodes")) == Answer(None, None, 0, "too many nodes")


@pytest.mark.parametrize("bound", [F(5, 2), F(3)])
def test_the_text_says_to_any_solver_what_the_question_says(bound):
    asked = query(line(1, 1, 1, bound=bound))
    text = smt_lib(asked)
    assert text == smt_lib(asked)
    solver = z3.Solver()
    solver.from_string(text)
    assert (solver.check() == z3.sat) == ask(asked).holds


def test_joints_of_fewer_than_two_parts_are_left_out_of_texts():
    """SMT-LIB has no conjunction, disjunction or sum of one part, nor of none."""
    asked, x = query(line(1, 0, 0, bound=0)), z3.Real("extra")
    odd = [z3.And([z3.Or([z3.Sum([x]) <= 2])]), z3.And([]), z3.Not(z3.Or([]))]
    text = smt_lib(asked._replace(constraints=[*asked.constraints, *odd]))
    terms = re.findall(r"\((?:and|or|\+)((?: (?:\([^()]*\)|[^() ]+))*)\)", text)
    assert all(len(re.findall(r"\([^()]*\)|[^() ]+", term)) > 1 for term in terms)
    assert not re.search(r"\((?:and|or|\+)\)", text)
    solver = z3.Solver()
    solver.from_string(text)
    assert (solver.check() == z3.sat) == ask(asked).holds


def test_bits_are_answered_as_unsigned_numbers_and_zero_where_they_do_not_matter():
    text = "(declare-const a (_ BitVec 8)) (declare-const b (_ BitVec 8)) (declare-const c (_ BitVec 4))"
    found = ask_bits(f"{text} (assert (= (bvmul a #x03) #xff)) (assert (bvugt b #xfe))", ["a", "b", "c"])
    assert found.holds and found.model == {"a": 0x55, "b": 0xFF, "c": 0}
    none = ask_bits(f"{text} (assert (= (bvmul a #x02) #x01))", ["a"])
    assert none.holds is False and none.model is None


def test_facts_that_do_not_hold_are_named_by_their_places():
    definitions = "(define-fun twice ((x Int)) Int (* 2 x))\n"
    facts = ["(= (twice 2) 4)", "(= (twice 3) 5)", "true", "(< (twice 1) 2)"]
    assert false_facts(definitions, facts) == [1, 3] and false_facts(definitions, []) == []


def test_the_solver_says_its_version():
    assert solver_name() == f"Z3 {z3.get_version_string()}"


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
