"""Affine forms against episodes in exact numbers: what they show holds, and they show what boxes cannot."""

from dataclasses import replace
from fractions import Fraction as F
from itertools import pairwise

import numpy as np
import pytest

from tests.support import covers
from tests.support.covers import CASES, PLAIN, after, claimed, line, question, shown
from tests.support.system_cases import box, form, policy, stays, team
from tests.verify.reach import random_modes
from verify.checker.covers import forms, sweep
from verify.checker.covers.boxes import BoxList
from verify.systems.claims import Pattern, SystemClaim
from verify.systems.system import Feature, Piece, System, Variable

HALVES = ((1, 0, 1, 0, 0), {})


def attacked(seeds, episodes):
    """How many claims were shown by forms, and how many refuted."""

    def asking(random, seed):
        return question(random) if seed % 3 else random_modes.case(random)

    met = covers.attacked(11, seeds, episodes, 2, asking, forms=True)
    return [sum(count for outcome, count in met.items() if outcome[at]) for at in (1, 2)]


@pytest.mark.parametrize(
    ("first", "questions", "episodes"),
    [
        (0, 20, 40),
        pytest.param(0, 60, 40, marks=pytest.mark.slow),
        pytest.param(100_000, 300, 60, marks=pytest.mark.slow),
        pytest.param(100_000, 3_000, 60, marks=pytest.mark.nightly),
    ],
)
def test_what_is_shown_is_true(first, questions, episodes):
    proved, broken = attacked(range(first, first + questions), episodes)
    assert proved >= questions / 8 and (broken >= questions / 8 or first), (proved, broken)


@pytest.mark.parametrize(("asked", "claim", "holds"), [each[1:] for each in CASES], ids=[each[0] for each in CASES])
def test_single_numbers(asked, claim, holds):
    """Forms are a little wider than boxes, so what holds by a single number they leave open."""
    assert holds or not any(shown((*asked, claim), cells, forms=True) for cells in (PLAIN, HALVES))


NEARLY = F(1, 10**9)


def test_by_a_little_more():
    doubled = line((-1, 1), -5.0, move={"x": form(x=2)})
    assert shown((*doubled, claimed("stays_in", 1, x=(-2 - NEARLY, 2 + NEARLY))), PLAIN, forms=True)
    assert shown((*doubled, claimed("avoids", 1, x=(2 + NEARLY, 3))), PLAIN, forms=True)
    once = line((0, 0), 0.5)
    assert shown((*once, claimed("reaches", 1, x=(1 - NEARLY, 2))), PLAIN, forms=True)
    assert shown((*once, claimed("reaches_and_stays", 3, 1, x=(1 - NEARLY, 2))), PLAIN, forms=True)
    erring = line((0, 0), -5.0, error={"x": (F(-1), F(1, 2))})
    assert shown((*erring, claimed("stays_in", 2, x=(-2 - NEARLY, 1 + NEARLY))), PLAIN, forms=True)


def turning(error=F(0), pieces=1):
    """A point that turns about 0 by 3-4-5 triangles, in some pieces along x that all do the same."""
    move = {"x": form(x=F(4, 5), y=F(-3, 5)), "y": form(x=F(3, 5), y=F(4, 5))}
    errors = {"x": (-error, error)} if error else {}
    ends = [-4 + F(8 * number, pieces) for number in range(pieces + 1)]
    wheres = [{"x": each} for each in pairwise(ends)] if pieces > 1 else [{}]
    variables = tuple(Variable(name, "1", (F(-4), F(4))) for name in "xy")
    system = System(
        "turning",
        variables,
        {"a": {"x": Feature(form(x=1))}},
        box(x=(1, F(11, 10)), y=(0, F(1, 10))),
        tuple(Piece(where, move, {}, errors) for where in wheres),
        100,
    )
    return system, team(policy("a", ["x"], ["rest", "same"], ((0, 0.25), 0, 1)))


@pytest.mark.parametrize(
    ("error", "pieces", "wide"), [(F(0), 1, F(23, 20)), (F(1, 1000), 1, F(3, 2)), (F(1, 1000), 5, 2)]
)
def test_rotations_do_not_wrap(error, pieces, wide):
    """Boxes grow by a factor of 7/5 a step, however the start is cut."""
    system, profile = turning(error, pieces)
    claim = stays(system, 60, x=(-wide, wide))
    assert shown((system, profile, claim), PLAIN, forms=True)
    assert not shown((system, profile, claim), PLAIN)
    assert not shown((system, profile, stays(system, 60, x=(-wide, F(11, 10)))), PLAIN, forms=True)


def test_pieces_that_differ():
    """A form across a border goes by one piece, with room for the other: or is cut, where that takes much room."""
    for step in (F(1, 10_000), F(1, 2)):
        parts = [({"x": (F(-9), F(0))}, form(-step, x=1)), ({"x": (F(0), F(9))}, form(step, x=1))]
        pieces = tuple(Piece(where, {"x": move}, {}, {"x": (F(-1, 1000), F(1, 1000))}) for where, move in parts)
        system = System("split", (Variable("x", "1", (F(-9), F(9))),), {"a": {}}, box(x=(-1, 1)), pieces, 4)
        profile = team(policy("a", [], ["rest"], 0))
        most = 1 + 4 * step + F(4, 1000)
        assert shown((system, profile, stays(system, 4, x=(-most - F(1, 100), most + F(1, 100)))), PLAIN, forms=True)
        assert not shown((system, profile, stays(system, 4, x=(-most + step, most + step))), PLAIN, forms=True)
        assert not shown((system, profile, stays(system, 4, x=(-most - step, most - step))), PLAIN, forms=True)


def test_both_sides_of_a_test():
    half = line((0, 1), 0.5)  # to [1, 3/2], or stays in [1/2, 1]
    for bad in ((F(501, 1000), 2), (0, F(1499, 1000))):
        assert not shown((*half, claimed("reaches_and_stays", 1, 1, x=bad)), PLAIN, forms=True)
        assert not shown((*half, claimed("reaches_and_stays", 1, 1, x=bad)), HALVES, forms=True)
    assert shown((*half, claimed("reaches_and_stays", 1, 1, x=(F(49, 100), F(151, 100)))), PLAIN, forms=True)


def test_a_part_of_which_nothing_is_stated():
    system, profile = line((0, 1), -5.0, where={"x": (F(-1), F(1, 2))})
    assert not shown((system, profile, claimed("stays_in", 1, x=(-1, 3))), PLAIN, forms=True)


def test_errors_add_up():
    """No step but the first two knows that it errs where a form loses columns."""
    system, profile = line((0, 0), -5.0, error={"x": (F(0), F(1, 100))})
    claim = SystemClaim(Pattern.STAYS_IN, (box(x=(F(-1, 10), F(8, 10))),), 90)
    assert not shown((system, profile, claim), PLAIN, forms=True)
    assert shown((system, profile, replace(claim, steps=79)), PLAIN, forms=True)


# --- planted faults


def narrower(found):
    return found._replace(radius=found.radius * 0, columns=found.columns * 0.999)


FAULTS = [
    (sweep.FormSweep, "_ask_claim", lambda f: lambda self, listed, step: listed),
    (sweep.FormSweep, "_leave", lambda f: lambda *given: None),
    (sweep.StatedStates, "beyond", lambda f: lambda self, low, high: np.zeros(len(low), dtype=np.bool_)),
    (sweep, "of_boxes", after(narrower)),
    (forms.FormTree, "_below", lambda f: lambda self, listed, node: _first(f(self, listed, node))),
    (forms, "end_of", lambda f: lambda bound, strict: f(bound + F(1, 8), strict)),
    (forms, "opposite", lambda f: lambda inequality: inequality),
    (forms.FormRegion, "within", lambda f: lambda self, listed: listed.take(slice(0, 0))),
    (forms.FormRegion, "outside", lambda f: lambda self, listed: listed.take(slice(0, 0))),
    (forms, "choices_of", lambda f: lambda joint, policies: f(1, policies)),
    (forms.FormPieces, "_find_pairs", lambda f: lambda *given: _alone(f(*given))),
    (forms.FormPieces, "_room", lambda f: lambda self, joint, pairs, low, high: _only(self, joint, pairs)),
    (forms.FormPieces, "_cut_and_moved", lambda f: lambda *given: f(*given).take(slice(0, 0))),
    (forms, "_with_error", lambda f: lambda low, high: (0.5 * low + 0.5 * high, 0 * low)),
    (forms.Moves, "of", after(lambda found: found._replace(columns=found.columns[:, :-1]))),
    (forms.Moves, "of", after(lambda found: found._replace(middle=found.middle + 0.125))),
    (sweep, "with_fewer_columns", lambda f: lambda listed, most: listed._replace(columns=listed.columns[:, :3])),
    (forms, "narrow_forms", lambda f: lambda listed, of, most: f(listed, of, most - 0.25)),
    (forms.Sums, "_reach", property(lambda self: self.rest)),
]


def _first(found):
    listed, node = found
    return listed.take(slice(0, 1)), node[:1]


def _alone(pairs):
    one = pairs.piece == pairs.first
    return forms._Pairs(*(each[one] for each in pairs))


def _only(pieces, joint, pairs):
    known = pieces._of(joint, pairs.first)
    return known.low, known.high


def wrong():
    try:
        for _, asked, claim, holds in CASES:
            test_single_numbers(asked, claim, holds)
        test_by_a_little_more()
        test_pieces_that_differ()
        test_both_sides_of_a_test()
        test_a_part_of_which_nothing_is_stated()
        test_errors_add_up()
        test_rotations_do_not_wrap(F(1, 1000), 5, 2)
        attacked(range(30), 20)
    except (AssertionError, ValueError, IndexError):
        return True
    return False


def test_nothing_is_wrong():
    assert not wrong()


@pytest.mark.parametrize("number", range(len(FAULTS)))
def test_planted_faults_are_caught(number, monkeypatch):
    owner, name, change = FAULTS[number]
    monkeypatch.setattr(owner, name, change if isinstance(change, property) else change(getattr(owner, name)))
    assert wrong()


# --- the arithmetic, against exact numbers


def test_images_and_cuts_hold_exact_points():
    """Points of forms, cut and moved in exact numbers, lie in what forms become."""
    random = np.random.default_rng(3)
    for _ in range(30):
        d, k = int(random.integers(1, 4)), int(random.integers(1, 5))
        scale = 10.0 ** random.integers(-8, 8, size=d)
        some = forms.FormList(
            random.normal(size=(1, d)) * scale,
            random.normal(size=(1, k, d)) * scale,
            np.abs(random.normal(size=(1, d))) * scale * 1e-3,
            np.zeros(1, dtype=np.int64),
            np.zeros(1, dtype=np.int64),
        )
        exact = [[F(int(random.integers(-30, 31)), int(random.integers(1, 9))) for _ in range(d)] for _ in range(d + 1)]
        weights = np.array([forms.weight(each) for each in exact[d]])
        matrix = np.array([[forms.weight(each) for each in row] for row in exact[:d]])[None]
        zero = np.zeros((1, d))
        moved = forms.Moves(matrix, zero, zero, np.zeros(0, dtype=np.int64)).of(some)
        low, high = moved.bounds()
        of = forms.sums(some, weights)
        most = float(of.value[0] + random.uniform(-0.9, 0.9) * (of.high - of.value)[0])
        cut = forms.narrow_forms(some, of, most)
        cut_low, cut_high = cut.bounds()
        for _ in range(10):
            signs = [F(int(random.integers(-8, 9)), 8) for _ in range(k)]
            rest = [F(float(random.choice([-1, 1])) * float(some.radius[0, i])) for i in range(d)]
            point = [
                F(float(some.middle[0, i]))
                + sum((z * F(float(some.columns[0, j, i])) for j, z in enumerate(signs)), F(0))
                + rest[i]
                for i in range(d)
            ]
            after_ = [sum((a * x for a, x in zip(row, point, strict=True)), F(0)) for row in exact[:d]]
            value = sum((a * x for a, x in zip(exact[d], point, strict=True)), F(0))
            assert F(float(of.low[0])) <= value <= F(float(of.high[0]))
            assert all(F(float(low[0, i])) <= after_[i] <= F(float(high[0, i])) for i in range(d))
            if value <= F(most):
                assert all(F(float(cut_low[0, i])) <= point[i] <= F(float(cut_high[0, i])) for i in range(d))


def test_what_is_exact_and_what_is_not():
    """A copied number stays as it is; a term that its sum does not feel is no copy."""
    point, part = np.array([[1.0, 2.0]]), np.zeros(1, int)
    some = forms.of_boxes(BoxList.of(point, point, part, part))
    zero, none = np.zeros((1, 2)), np.zeros(0, dtype=np.int64)
    for tiny in (0.0, 2.0**-100, forms.LEAST):
        matrix = np.array([[[1.0, tiny], [0.0, 0.0]]])
        moved = forms.Moves(matrix, np.array([[0.0, 3.0]]), zero, none).of(some)
        (low, least), (high, most) = (end[0] for end in moved.bounds())
        assert (low == high == 1.0) == (tiny == 0.0) and least == most == 3.0
        of = forms.sums(some, np.array([1.0, tiny]))
        assert (of.low[0] == of.high[0] == 1.0) == (tiny == 0.0)
        assert tiny == 0.0 or of.high[0] > 1.0


def test_numbers_beyond_this_arithmetic_are_refused():
    for factor in (F(10) ** 300, F(1, 10**300)):
        far = line((0, 1), -5.0, move={"x": form(x=factor)})
        assert not shown((*far, claimed("avoids", 3, x=(-2, -1))), PLAIN, forms=True)


def test_fewer_columns_hold_more():
    random = np.random.default_rng(4)
    some = forms.FormList(
        np.zeros((5, 3)), random.normal(size=(5, 40, 3)), np.zeros((5, 3)), np.arange(5), np.zeros(5, dtype=np.int64)
    )
    few = forms.with_fewer_columns(some, 12)
    assert few.columns.shape[1] <= 12
    for weights in random.normal(size=(20, 3)):
        assert (forms.sums(few, weights).high >= forms.sums(some, weights).high * (1 - 1e-12)).all()
