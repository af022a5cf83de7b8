"""What Z3 is asked and answers: exact models, budgets that repeat, texts that mean the same to any solver."""

import itertools
import re
from fractions import Fraction as F

import pytest
import z3

from tests.support.small import small_profile
from tests.support.teams import STAY, team, towards, tree
from tests.support.zone_cases import stated
from verify.claims.formula import And, Linear, Or, holds
from verify.claims.region_files import start_region
from verify.solver import encode
from verify.solver.solve import Answer, ask, ask_bits, false_facts, smt_lib, solver_name

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
