"""All paths of a program: its tree, what is left out, and limits."""

import pytest

from codegen.errors import InputError
from codegen.importers.symbolic import paths
from codegen.importers.symbolic.feature import FOLDING, Feature, Step, Test
from codegen.importers.symbolic.paths import Growth

SPEED, GAP = Feature(0), Feature(1)


def grown(run):
    growth = Growth("here", "float64")
    growth.follow(run)
    return growth


def drive(here, state):
    if here.holds(Test(GAP, "<", 10.0)):
        return "brake" if here.holds(Test(SPEED, ">", 2.0)) else "roll"
    return "go"


def test_a_program_becomes_a_tree():
    growth = grown(drive)
    tree = growth.tree()
    assert tree.feature.tolist() == [1, 0, -1, -1, -1] and tree.threshold[1] == 2.0
    assert [list(growth.values)[k] for k in tree.action.tolist() if k >= 0] == ["roll", "brake", "go"]


@pytest.mark.parametrize(("sign", "kept"), [("<", True), ("<=", True), ("==", True), ("!=", True), (">", False)])
def test_nan_is_kept_where_it_goes_right_as_in_the_program(sign, kept):
    growth = grown(lambda here, state: here.holds(Test(SPEED, sign, 1.0)))
    assert growth.nan == kept


def test_decided_tests_and_sides_that_are_alike_are_left_out():
    def run(here, state):
        here.holds(Test(GAP, "<", 3.0))  # nothing comes of it
        return 1 if here.holds(Test(SPEED, "<", 2.0)) and here.holds(Test(SPEED, "<", 5.0)) else 2

    assert grown(run).tree().feature.tolist() == [0, -1, -1]


def test_paths_that_no_float_takes_have_no_leaf():
    size = SPEED.then(Step("abs", abs, FOLDING))

    def run(here, state):
        if here.holds(Test(size, "<=", 1.0)):
            return 3 if here.holds(Test(SPEED, ">", 1.0)) else 1
        return 4 if here.holds(Test(SPEED, "==", 0.5)) else 2

    growth = grown(run)
    assert set(growth.values) == {1, 2}


def test_a_marked_state_is_gone_on_from():
    seen = []

    def run(here, state):
        start = state or 0
        seen.append(start)
        for k in range(start, 3):
            here.mark(k)
            if here.holds(Test(Feature(k), ">", 0.0)):
                return k
        return 3

    growth = grown(run)
    assert sorted(growth.values) == [0, 1, 2, 3] and seen == [0, 2, 1, 0]
    assert growth.tree().feature.tolist() == [0, 1, 2, -1, -1, -1, -1]


def test_a_mark_drops_no_answer_that_is_still_to_be_given():
    def run(here, state):
        here.mark("again")
        first = here.holds(Test(SPEED, ">", 0.0))
        return first, here.holds(Test(GAP, ">", 0.0))

    assert len(grown(run).values) == 4


def test_limits_are_said_with_a_line(monkeypatch):
    monkeypatch.setattr(paths, "MAX_STEPS", 10)

    def run(here, state):
        here.line = 7
        while True:
            here.step()

    with pytest.raises(InputError) as caught:
        grown(run)
    assert caught.value.where == "here, line 7"
    with pytest.raises(InputError, match="deeper than 64"):
        grown(lambda here, state: sum(here.holds(Test(Feature(k), ">", 0.0)) for k in range(99)))


def test_the_other_answer_of_a_sole_test_goes_on_from_a_branch():
    seen = []

    def run(here, state):
        seen.append(state)
        if state is not None:
            return state
        here.mark(None)
        holds = here.holds(Test(SPEED, ">", 1.0))
        here.branch(not holds)
        return holds

    growth = grown(run)
    assert seen == [None, True] and not growth.nan
    assert [list(growth.values)[k] for k in growth.tree().action.tolist() if k >= 0] == [False, True]


def test_a_branch_waits_for_all_tests_since_the_mark():
    def run(here, state):
        here.mark("again")
        tests = [here.holds(Test(SPEED, ">", 1.0)), here.holds(Test(GAP, "==", 1.0))]
        here.branch("never")
        assert state != "never"
        return tuple(tests)

    assert len(grown(run).values) == 4
