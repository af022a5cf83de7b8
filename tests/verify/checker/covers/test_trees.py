"""Leaves that boxes meet, looked up: every state of a box stays with the action that the tree takes there."""

from fractions import Fraction as F
from math import inf, nan

import numpy as np
import pytest

from tests.support.covers import tie
from tests.support.system_cases import form, policy, team
from tests.verify.reach.random_systems import nested, some
from verify.checker.covers import boxes, trees
from verify.checker.covers.boxes import FEW, BoxList, half_line
from verify.checker.covers.trees import LeafWays, TreeCuts, WayDown
from verify.checker.reading import RejectedError
from verify.checker.systems.reading import goes_left
from verify.claims.formula import Linear, Or
from verify.systems.system import Feature, Measure, System, Variable

COLUMNS = {"x": 0, "y": 1}
VARIABLES = tuple(Variable(name, "1", (F(-9), F(9))) for name in COLUMNS)
FEATURES = (
    Feature(form(x=1)),
    Feature(form(F(1, 2), y=-1)),
    Feature(form(x=F(-1, 3))),
    Feature(form(y=1), Measure.SIGN),
    Feature(form(x=1), Measure.EQUALS),
    Feature(form(F(1, 4), y=1), Measure.CLIP, (F(-1), F(1))),
    Feature(form(x=1, y=F(1, 2))),
)
ACTIONS = ["a", "b", "c", "d"]
EDGES = [-2.0, -1.5, -0.5, 0.0, 0.1, 0.5, 1.0, 1.5, float(tie(0.5)), float(np.float32(0.1))]
NUMBERS = sorted({each for end in EDGES for each in (end, np.nextafter(end, inf), np.nextafter(end, -inf))})


def tree(random, several=True):
    """A random tree, as the checker cuts boxes by it and as nested tests."""
    names = [f"f{number}" for number in range(len(FEATURES) - (not several))]
    drawn = nested(random, 5, len(names), len(ACTIONS))
    system = System("tests", VARIABLES, {"p": dict(zip(names, FEATURES, strict=False))}, (), (), 1)
    (one,) = team(policy("p", names, ACTIONS, drawn)).agents
    return TreeCuts(system, one, COLUMNS), one


def holds(formula, state):
    if isinstance(formula, Linear):
        value = sum((weight * state[name] for weight, name in formula.terms), F(0))
        return value < formula.bound or (value == formula.bound and not formula.strict)
    return (any if isinstance(formula, Or) else all)(holds(part, state) for part in formula.parts)


def action(one, state):
    """What is done in a state, in exact numbers."""
    node = 0
    while one.tree.feature[node] >= 0:
        feature = FEATURES[int(one.tree.feature[node])]
        left = holds(goes_left(feature, float(one.tree.threshold[node]), one.numbers), state)
        node = int((one.tree.left if left else one.tree.right)[node])
    return int(one.tree.action[node])


def drawn_boxes(random, count):
    """Boxes whose bounds are ends of tests or floats beside them."""
    ends = np.sort(random.choice(NUMBERS, size=(count, 2, 2)), axis=1)
    return BoxList.of(ends[:, 0], ends[:, 1], np.arange(count) % 3, np.zeros(count, dtype=np.int64))


def lost(random, count, chosen):
    """States of boxes that are in no box of what is chosen there."""
    cuts, one = chosen
    listed = drawn_boxes(random, count)
    found, missed = cuts.split_at_tests(listed), []
    for number in random.integers(count, size=12):
        low, high = listed.low[number], listed.high[number]
        shares = [some(random, [F(0), F(1), F(1, 2), F(1, 3)]) for _ in COLUMNS]
        state = {name: F(low[at]) + shares[at] * (F(high[at]) - F(low[at])) for name, at in COLUMNS.items()}
        there = (found.part == listed.part[number]) & (found.joint == action(one, state))
        held = any(
            all(F(a) <= value <= F(b) for a, b, value in zip(*ends, state.values(), strict=True))
            for ends in zip(found.low[there], found.high[there], strict=True)
        )
        missed += [] if held else [(state, action(one, state))]
    return missed


def attacked(seeds):
    """States that are lost, where every other tree's leaves are looked up, however few they are."""
    missed = []
    for seed in seeds:
        random = np.random.default_rng([33, seed])
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(trees, "COMPARED", trees.COMPARED * (seed % 2))
            missed += lost(random, int(some(random, [1, 5, 2 * FEW])), tree(random, several=seed % 3 == 0))
    return missed


def test_no_state_is_lost_where_all_hashes_are_alike(monkeypatch):
    """Who knows the factors could have boxes of two leaves share a hash: these are told apart all the same."""
    monkeypatch.setattr(boxes, "multipliers", lambda count: np.zeros(count, dtype=np.int64))
    assert not attacked(range(60))


def test_no_state_is_lost():
    assert not attacked(range(60))


@pytest.mark.slow
def test_no_state_of_thousands_is_lost():
    assert not attacked(range(1_000, 4_000))


FAULTS = [
    (trees.LeafWays, "_pairs", lambda f: lambda self, *of: tuple(each[1:] for each in f(self, *of))),
    (trees, "_column", lambda f: lambda last: f(last - 0.25)),
    (trees.LeafWays, "_pairs", lambda f: lambda self, columns, least, most: f(self, columns, least + 1.0, most)),
    (trees, "_join_nested", lambda f: lambda bounds, at_end, kinds, unit: (np.arange(1), bounds[:1])),
]


@pytest.mark.parametrize("number", range(len(FAULTS)))
def test_planted_faults_lose_states(number, monkeypatch):
    owner, name, change = FAULTS[number]
    monkeypatch.setattr(owner, name, change(getattr(owner, name)))
    assert attacked(range(60))


# --- forgeries: bounds that mean nothing, or nothing that is met


def ways(*ends):
    """Ways that go on where x is at most an end, and where it is not."""
    begun, found = WayDown.begin(4, 0), []
    for number, (end, strict) in enumerate(ends):
        line = half_line(Linear(((F(1), "x"),), F(end), strict), COLUMNS)
        found += [begun.on([line], 2 * number), begun.on([line.opposite], 2 * number + 1)]
    return found


def met(low, high, *ends):
    """The nodes that a box [low, high] of x meets."""
    box = BoxList.of(*(np.array([[each, 0.0]]) for each in (low, high)), np.zeros(1, np.int64), np.zeros(1, np.int64))
    return sorted(LeafWays(ways(*ends)).split_at_leaves(box)[1].tolist())


def test_bounds_that_are_no_numbers_are_refused():
    for low, high in ((nan, 1.0), (0.0, nan), (nan, nan)):
        with pytest.raises(RejectedError, match="finite"):
            met(low, high, (0, False))
