"""Pieces of many states at once: the same as one state after the other; random play that does not depend on others."""

from fractions import Fraction as F

import numpy as np

from tests.support.system_cases import decided, double_integrator, form, stays, switching
from tests.verify.reach import random_systems
from verify.question import Budgets
from verify.reach import play
from verify.reach.play import Boxes
from verify.result import Verdict
from verify.spending import PROGRAM, listening
from verify.systems.system import Piece, System, Variable


def first_holding(system, state):
    for number, piece in enumerate(system.pieces):
        if all(float(low) <= state[name] <= float(high) for name, (low, high) in piece.where.items()):
            return number
    return -1


def test_states_lie_in_the_first_piece_whose_box_holds_them():
    """On bounds, on corners, outside, at no number, and where a box leaves a variable free."""
    variables = tuple(Variable(name, "", (F(-9), F(9))) for name in "xyz")
    boxes = [
        {"x": (F(0), F(1)), "y": (F(0), F(1, 3))},
        {"x": (F(0), F(1)), "y": (F(1, 3), F(1))},
        {"x": (F(1), F(1))},
        {"y": (F(-2), F(0))},
        {"x": (F(1), F(2)), "y": (F(0), F(1))},
    ]
    for chosen in (boxes, boxes[:2], boxes[3:4], [{}], [{}, *boxes]):
        system = System("s", variables, {}, (), tuple(Piece(box, {"x": form()}) for box in chosen))
        ends = np.array([-3, -2, -0.0, 0, 1 / 3, np.nextafter(1 / 3, 1), 0.5, 1, 1.5, 2, 3, np.inf, -np.inf, np.nan])
        x, y = (each.ravel() for each in np.meshgrid(ends, ends))
        planes = {"x": x, "y": y, "z": np.zeros(len(x))}
        states = [{"x": a, "y": b} for a, b in zip(x.tolist(), y.tolist(), strict=True)]
        held = Boxes(system)
        for _ in range(2):  # known and not known before
            assert held.holding(planes, len(x)).tolist() == [first_holding(system, state) for state in states]


def test_random_play_says_how_far_it_is():
    system, profile, claim = random_systems.case(np.random.default_rng(0))
    told = []
    with listening(lambda *given: told.append(given)):
        list(play.courses(profile, system, claim, play.Starts(16)))
    assert told[0] == (0, claim.steps, "steps of 16 random episodes") and len(told) <= claim.steps + 1


def test_a_search_says_how_far_it_is_and_ends_within_its_budget():
    """Also within one symbolic state, which takes thousands of programs where there are many pieces."""
    system, profile = double_integrator(axes=1, error=F(1, 1000), steps=25), switching(axes=1)
    claim, told = stays(system, 25, x=(F(-7, 10), F(7, 10))), []
    with listening(lambda *given: told.append(given)):
        (result,) = decided(profile, system, [claim], Budgets(covers=False, max_boxes=120_000, samples=16))
    assert result.verdict is Verdict.UNKNOWN and "the budget is 120,000 boxes" in result.reason
    assert f"{result.programs:,} linear programs" in result.reason
    searched = [(done, most, words) for done, most, words in told if words.startswith("boxes of the budget")]
    assert searched == sorted(searched, key=lambda one: one[0]) and searched[-1][0] > 60_000
    assert all(done <= most == 120_000 and "at step" in words for done, most, words in searched)


def test_one_symbolic_state_cannot_spend_more_than_all():
    system, profile = double_integrator(axes=1, error=F(1, 1000), steps=25), switching(axes=1)
    claim = stays(system, 25, x=(F(-7, 10), F(7, 10)))
    (result,) = decided(profile, system, [claim], Budgets(covers=False, max_boxes=20 * PROGRAM, samples=16))
    assert result.verdict is Verdict.UNKNOWN and "the budget is 8,000 boxes" in result.reason
    assert result.programs <= 20 + 4  # a question is finished
