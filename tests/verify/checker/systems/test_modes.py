"""Modes, cases and choices: all readings say the same, and a fault planted in any of them is noticed."""

from contextlib import nullcontext, suppress
from dataclasses import replace
from fractions import Fraction as F
from functools import cache
from itertools import combinations_with_replacement, product

import numpy as np
import pytest

from tests.support.system_cases import box, form, policy, team
from tests.support.system_guards import SEARCHED, answer, judged, opinion
from tests.verify.reach import random_modes
from verify.checker.covers import images
from verify.checker.covers import trees as cover_trees
from verify.checker.covers.sweep import BoxSweep
from verify.checker.reading import RejectedError
from verify.checker.systems import branch_proofs, cases, reading
from verify.checker.systems.branch_proofs import SystemQuestions
from verify.claims.formula import Acts, Linear, Or, conjunction
from verify.reach import replay
from verify.reach.replay import Course
from verify.result import Verdict
from verify.solver import terms, unrolled
from verify.systems import observing
from verify.systems.claims import Pattern, SystemClaim
from verify.systems.system import Feature, HalfSpace, Measure, Piece, System, Variable

pytestmark = pytest.mark.solver
QUESTIONS = 30
PLAYED_TOO = replace(SEARCHED, samples=4_096, covers=True)


def lamp(threshold=0.5, **more):
    """A lamp that goes on from off, and a number that falls while it is on: the agent sees whether it is on."""
    number, lit = Variable("x", "1", (F(-8), F(8))), Variable("m", "1", (F(0), F(2)), random_modes.MODES)
    on = {("a", "go"): {"m": form(2)}, ("a", "rest"): {"m": form(0)}}
    still = (HalfSpace(form(0, x=1), True),)
    pieces = (
        Piece({"m": (F(0), F(2)), "x": (F(-8), F(8))}, {"x": form(0, x=1), "m": form()}, on, {}, still),
        Piece(
            {"m": (F(0), F(2)), "x": (F(-8), F(8))},
            {"x": form(-1, x=1), "m": form()},
            on,
            {},
            (HalfSpace(form(0, x=-1)),),
        ),
    )
    features = {"a": {"f": Feature(form(-2, m=1), Measure.EQUALS)}}
    stated = {"start": box(x=(0, 0), m=(0, 0)), "pieces": pieces} | more
    system = System("lamp", (number, lit), features, stated["start"], stated["pieces"], 3)
    return system, team(policy("a", ["f"], ["go", "rest"], ((0, threshold), 0, 1)))


def fast():
    """A lamp that is fast, and is asked whether it is slow: it stays on."""
    system, profile = lamp(start=box(x=(0, 0), m=(2, 2)))
    asked_slow = replace(system, features={"a": {"f": Feature(form(-1, m=1), Measure.EQUALS)}})
    return asked_slow, profile, SystemClaim(Pattern.AVOIDS, (random_modes.at(0),), 1)


def by_hand():
    """Questions whose answers hang on what a mode or a condition is."""
    system, profile = lamp()
    on, slow = random_modes.at(2), random_modes.at(1)
    apart = Or(
        (
            *(
                conjunction(*(Linear(((h.form.terms[0][1], "m"),), -h.form.constant) for h in random_modes.at(n)))
                for n in range(3)
            ),
        )
    )
    return [
        fast(),
        (system, profile, SystemClaim(Pattern.AVOIDS, (on,), 1)),
        (system, profile, SystemClaim(Pattern.AVOIDS, (slow,), 3)),
        (system, profile, SystemClaim(Pattern.AVOIDS, (box(x=(-2, -2)),), 2)),
        (system, profile, SystemClaim(Pattern.STAYS_IN, (box(x=(-1, 0)),), 3)),
        (system, profile, SystemClaim(Pattern.DECIDES, formula=apart)),
        (system, profile, SystemClaim(Pattern.DECIDES, (on,), formula=Acts("a", 1))),
        (system, profile, SystemClaim(Pattern.DECIDES, (slow,), formula=Acts("a", 1))),
    ]


@cache
def asked():
    questions = [*by_hand(), *(random_modes.case(np.random.default_rng(seed)) for seed in range(QUESTIONS))]
    return [(question, answer(question, PLAYED_TOO)) for question in questions]


@cache
def opinions():
    return [opinion(question) for question, _ in asked()]


def covered(question):
    """Whether boxes around whole starts show a claim."""
    system, profile, claim = question
    with suppress(RejectedError):
        return BoxSweep(profile, system, claim).run([0]) > 0
    return False


@cache
def covers():
    return [covered(question) for question, _ in asked()]


def test_all_readings_say_the_same():
    verdicts = [verdict for _, verdict in asked()]
    assert verdicts.count(Verdict.PROVED) > 10 and verdicts.count(Verdict.VIOLATED) > 12 and None not in verdicts
    assert opinions() == verdicts
    assert [answer(question, SEARCHED) for question, _ in asked()] == verdicts
    shown = [verdict for (question, verdict), found in zip(asked(), covers(), strict=True) if found]
    assert set(shown) == {Verdict.PROVED} and len(shown) > 8


# --- planted faults


def plainly(f):
    """Equality taken for a sign."""
    return lambda feature, *given: f(
        replace(feature, measure=Measure.SIGN) if feature.measure is Measure.EQUALS else feature, *given
    )


def unconditioned(f):
    """Pieces without their conditions."""
    return lambda piece, *given: f(replace(piece, when=()), *given)


def below_alone(f):
    """Of a test with two sides the first."""

    def planted(reading, side, left, right):
        return f(reading, side.parts[0] if isinstance(side, Or) and side.parts else side, left, right)

    return planted


def without_when(init):
    def planted(self, profile, system, *given):
        init(self, profile, replace(system, pieces=tuple(replace(piece, when=()) for piece in system.pieces)), *given)

    return planted


def one_side(f):
    return lambda tests, *to: f(tests[:1], *to)


def with_when(when):
    """Pieces with other conditions."""

    def plant(init):
        def planted(self, system, *given):
            pieces = (replace(piece, when=when(piece)) for piece in system.pieces)
            init(self, replace(system, pieces=tuple(pieces)), *given)

        return planted

    return plant


def first_way(piece):
    return piece.when or (HalfSpace(form(1)),)


SEARCH, COVER, SOLVER, JUDGED = "search", "cover", "solver", "judged"
FAULTS = [
    (SEARCH, reading, "goes_left", plainly),
    (SEARCH, reading, "_build_split", below_alone),
    (SEARCH, branch_proofs, "_is_mode", lambda f: lambda variable: conjunction()),
    (SEARCH, SystemQuestions, "__init__", without_when),
    (COVER, cover_trees, "_sides", one_side),
    (COVER, images.BoxPieces, "__init__", with_when(lambda piece: ())),
    (COVER, images.BoxPieces, "__init__", with_when(first_way)),
    (SOLVER, unrolled, "_goes_left", plainly),
    (SOLVER, unrolled, "_is_mode", lambda f: lambda value, count: terms.constant(True)),
    (SOLVER, unrolled, "_in_box", unconditioned),
    (JUDGED, observing, "measure_feature", plainly),
    (JUDGED, Piece, "holds", unconditioned),
    (JUDGED, replay, "piece_of", lambda f: lambda system, state, wanted=None: f(system, state)),
]  # fmt: skip


def episodes():
    """Questions with a course, and whether it keeps the claim, or is no episode of the system."""
    system, profile = lamp()
    lit_at_0 = SystemClaim(Pattern.AVOIDS, ((*box(x=(0, 0)), *random_modes.at(2)),), 1)
    ways = tuple(replace(system.pieces[1], when=(), move={"x": form(-n, x=1), "m": form()}) for n in (1, 2))
    chosen = replace(system, pieces=ways)
    falls = SystemClaim(Pattern.AVOIDS, (box(x=(-2, -2)),), 1)
    start = {"x": F(0), "m": F(0)}
    return [
        ((system, profile, lit_at_0), Course(start, pieces=(0,)), True),  # that piece does not hold the start
        (fast(), Course({"x": F(0), "m": F(2)}), True),
        ((chosen, profile, falls), Course(start), True),
        ((chosen, profile, falls), Course(start, pieces=(1,)), False),
    ]


def noticed(guard):
    """Whether some question is answered otherwise; the first one that is, is enough."""
    if guard == SEARCH:
        return any(answer(question, SEARCHED) is not verdict for question, verdict in asked())
    if guard == COVER:
        return any(covered(question) is not shown for (question, _), shown in zip(asked(), covers(), strict=True))
    if guard == SOLVER:
        return any(opinion(question) is not said for (question, _), said in zip(asked(), opinions(), strict=True))
    return any(judged(*question, course) != kept for question, course, kept in episodes())


@pytest.mark.parametrize("fault", FAULTS, ids=[f"{fault[2]} {number}" for number, fault in enumerate(FAULTS)])
def test_the_fault_is_noticed(fault, monkeypatch):
    guard, owner, attribute, change = fault
    covers(), opinions()
    monkeypatch.setattr(owner, attribute, change(getattr(owner, attribute)))
    assert noticed(guard)


def test_episodes_are_judged_as_they_are():
    assert not noticed(JUDGED)


def test_an_episode_starts_in_a_mode():
    system, profile = lamp(start=box(x=(0, 0), m=(0, 2)))
    claim = SystemClaim(Pattern.AVOIDS, (box(x=(0, 0)),), 0)
    assert not judged(system, profile, claim, Course({"x": F(0), "m": F(1)}))
    assert judged(system, profile, claim, Course({"x": F(0), "m": F(1, 2)}))


# --- what the checker shows of a system by itself


def told(**more):
    """What the checker says of a lamp; "" where it sees nothing wrong."""
    try:
        cases.ensure_cases(lamp(**more)[0])
    except RejectedError as error:
        return str(error)
    return ""


def changed(**more):
    return {"pieces": tuple(replace(piece, **more) for piece in lamp()[0].pieces)}


def test_modes_are_kept_and_cases_leave_out_nothing():
    assert told() == ""
    one, other = lamp()[0].pieces
    assert told(pieces=(other, one, one)) == ""  # some state twice, which is followed twice
    assert "no piece is seen to hold" in told(pieces=(one,))
    strict = replace(other, when=(HalfSpace(form(0, x=-1), True),))
    assert "x near 0" in told(pieces=(one, strict))
    assert "m near 1" in told(
        pieces=tuple(
            replace(piece, where={**piece.where, "m": (F(mode), F(mode))}) for piece in (one, other) for mode in (0, 2)
        )
    )
    assert "do not bound" in told(**changed(where={"m": (F(0), F(2))}))
    assert "start in one mode" in told(start=box(x=(0, 0), m=(0, 1)))
    assert "start in one mode" in told(start=box(x=(0, 0), m=(F(1, 2), F(1, 2))))
    assert "start in one mode" in told(start=box(x=(0, 0)))
    assert "none of its modes" in told(**changed(effect={("a", "go"): {"m": form(3)}, ("a", "rest"): {}}))
    assert "none of its modes" in told(**changed(move={"x": form(x=1), "m": form(F(1, 2))}, effect={}))
    assert "none of its modes" in told(**changed(move={"x": form(x=1), "m": form(1, m=1)}, effect={}))
    assert "none of its modes" in told(**changed(move={"x": form(x=1), "m": form(x=1)}, effect={}))
    assert "has an error" in told(**changed(error={"m": (F(0), F(1))}))
    assert told(**changed(move={"x": form(x=1), "m": form(m=1)}, effect={})) == ""


def test_a_counter_stays_among_its_modes_wherever_its_piece_holds():
    counted, accepted = Variable("m", "1", (F(0), F(3)), ("0", "1", "2", "3")), 0
    halves = [F(n, 2) for n in range(-2, 9)]
    for low, high in combinations_with_replacement(halves, 2):
        for added, seen in product(halves, ({"m": (low, high)}, {"x": (F(0), F(3))})):
            moved = Piece({"x": (F(0), F(3)), **seen}, {"x": form(x=1)}, {("a", "go"): {"m": form(added, m=1)}})
            after = {F(n) + added for n in range(4) if moved.holds({"x": F(0), "m": F(n)})}
            with suppress(RejectedError) if added else nullcontext():  # what is kept is accepted in any box
                cases._ensure_stays(counted, moved, {"m": counted}, "piece")
                assert after <= {*range(4)}, (low, high, added, seen)
                accepted += 1
    assert accepted > 10


def test_sums_of_variables_are_cut_where_cases_cut_them():
    one, other = lamp()[0].pieces
    low, high = (HalfSpace(form(-1, x=1, m=1), True),), (HalfSpace(form(1, x=-1, m=-1)),)
    assert told(pieces=(replace(one, when=low), replace(other, when=high))) == ""
    assert "x + m near 1" in told(
        pieces=(replace(one, when=low), replace(other, when=(replace(high[0], strict=True),)))
    ).replace("m + x", "x + m")


def test_a_system_with_a_gap_has_no_certificate():
    """The search itself finds nothing wrong: it takes for stated what lies within the bounds of all boxes."""
    system, profile = lamp()
    claim = SystemClaim(Pattern.STAYS_IN, (box(x=(-8, 8)),), 3)
    assert answer((system, profile, claim), SEARCHED) is Verdict.PROVED
    holed = replace(system, pieces=system.pieces[:1])
    assert answer((holed, profile, claim), SEARCHED) is not Verdict.PROVED
    assert answer((holed, profile, claim), PLAYED_TOO) is not Verdict.PROVED
