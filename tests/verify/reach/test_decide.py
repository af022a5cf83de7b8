"""Verdicts about stated systems: the same as those of direct queries, each with evidence that holds on its own.

The search for the answer to one claim: what budgets end, what is said of no answer, small counterexamples.
"""

import inspect
import sys
from collections import Counter
from dataclasses import replace
from fractions import Fraction as F
from pathlib import Path

import numpy as np
import pytest

from codegen.errors import InputError, UnknownNameError
from codegen.floats import FLOAT64, NUMBERS
from maviper.files.profiles import find_profile
from maviper.worlds.stated.systems import read
from tests.support.altered import altered
from tests.support.system_cases import (
    box,
    decided,
    double_integrator,
    form,
    policy,
    possible,
    stays,
    switching,
    team,
)
from tests.verify.reach import random_systems
from verify.certificates.systems import to_json
from verify.checker.accept import accept
from verify.checker.reading import RejectedError
from verify.checker.systems import cases
from verify.checker.systems.proofs import from_json
from verify.claims.formula import FALSE, Acts, Not, Or, holds, negate
from verify.claims.region import UNBOUNDED
from verify.question import Budgets, Question
from verify.reach import decide as deciding
from verify.reach import programs, replay
from verify.reach.decide import ClaimSearch, decide
from verify.reach.replay import Course, replay_course
from verify.reports.systems import facts, lines
from verify.result import Verdict
from verify.solver import unrolled
from verify.spending import listening
from verify.subjects import ClosedLoop
from verify.systems.claims import Pattern, SystemClaim
from verify.systems.documents import content_hash
from verify.systems.observing import choose_actions
from verify.systems.properties import claims_of
from verify.systems.system import Feature, HalfSpace, Piece, System, Variable
from verify.verdicts.systems import verify_system


def on_a_line(name, start, piece, steps):
    """A system of one variable, x, that agent a observes."""
    x = Variable("x", "1", (F(-9), F(9)))
    return System(name, (x,), {"a": {"f": Feature(form(x=1))}}, box(x=start), (piece,), steps)


PLAYED, SEARCHED = Budgets(covers=False), Budgets(covers=False, samples=0)
COVERED = Budgets(samples=0)  # boxes first


def expected(system, profile, claim):
    """The verdict that direct queries give."""
    anything = SystemClaim(Pattern.AVOIDS, ((),), 0)
    if not possible(unrolled.encode_claim(profile, system, anything)[0]):
        return Verdict.VACUOUS
    broken, left = unrolled.encode_claim(profile, system, claim)
    if possible(broken):
        return Verdict.VIOLATED
    return Verdict.UNKNOWN if possible(left) else Verdict.PROVED


def ensure_evidence(system, profile, claim, result):
    """Certificates survive their text and the checker; counterexamples are episodes of the system that break it."""
    if result.verdict is Verdict.PROVED:
        text = to_json(result.certificate)
        assert from_json(text) == result.certificate and to_json(from_json(text)) == text
        accept(from_json(text), profile, system)
    if result.verdict is Verdict.VIOLATED and not claim.about_decisions:
        ensure_episode(system, profile, claim, result.counterexample)


def ensure_episode(system, profile, claim, found):
    assert all(half.holds(found.start) for half in system.start)
    told = zip(found.states, found.states[1:], found.actions, found.errors, found.pieces, strict=False)
    for state, after, actions, errors, number in told:
        piece = system.pieces[number]
        assert all(low <= state[name] <= high for name, (low, high) in piece.where.items())
        assert all(piece.error[name][0] <= value <= piece.error[name][1] for name, value in errors.items())
        numbers = choose_actions(system, profile, state)
        assert actions == {one.agent: one.actions[numbers[one.agent]].name for one in profile.agents}
        assert piece.step(state, actions, errors) == after
    assert len(found.states) == found.step + 1 and holds(claim.violation_at(found.step), found.states[-1], {})
    assert not any(holds(claim.fulfilment_at(step), state, {}) for step, state in enumerate(found.states))


@pytest.mark.solver
@pytest.mark.slow
@pytest.mark.parametrize(
    ("budget", "seeds"),
    [(PLAYED, range(150)), (SEARCHED, range(150, 350)), (COVERED, range(350, 500))],
    ids=["played", "searched", "covered"],
)
def test_verdicts_are_those_of_direct_queries(budget, seeds):
    met = Counter()
    for seed in seeds:
        system, profile, claim = random_systems.case(np.random.default_rng(seed))
        (result,) = decided(profile, system, [claim], budget)
        assert result.verdict is expected(system, profile, claim), (seed, result)
        ensure_evidence(system, profile, claim, result)
        met[claim.pattern, result.verdict] += 1
    assert all(met[kind, verdict] >= 3 for kind in KINDS for verdict in (Verdict.PROVED, Verdict.VIOLATED)), met
    assert sum(met[kind, Verdict.UNKNOWN] for kind in KINDS) >= 1


@pytest.mark.solver
def test_agents_may_compare_float64():
    """The same team with the decimals themselves for thresholds, which float32 only comes near."""
    written = {np.float32(text): np.float64(text) for text in ("0.1", str(1 / 3))}
    met = Counter()
    for seed in range(40):
        system, profile, claim = random_systems.case(np.random.default_rng(seed))
        policies = []
        for one in profile.agents:
            thresholds = [written.get(threshold, np.float64(threshold)) for threshold in one.tree.threshold]
            policies.append(replace(one, tree=replace(one.tree, threshold=thresholds, numbers=FLOAT64)))
        profile = replace(profile, agents=tuple(policies))
        (result,) = decided(profile, system, [claim], PLAYED)
        assert result.verdict is expected(system, profile, claim), (seed, result)
        ensure_evidence(system, profile, claim, result)
        met[result.verdict] += 1
    assert met[Verdict.PROVED] >= 5 and met[Verdict.VIOLATED] >= 5, met


KINDS = [kind for kind in Pattern if kind not in (Pattern.DECIDES, Pattern.ALWAYS)]


@pytest.mark.solver
def test_claims_about_decisions_are_those_of_direct_queries():
    met = Counter()
    for seed in range(120):
        random = np.random.default_rng(seed)
        system, profile, _ = random_systems.case(random)
        names = [one.name for one in system.variables]
        acts = [Acts(one.agent, int(random.integers(len(one.actions)))) for one in profile.agents]
        atoms = SystemClaim(Pattern.AVOIDS, (random_systems.polytope(random, names),)).inside
        formula = Or((negate(atoms), *acts)) if random.random() < 0.5 else Or((Not(acts[0]), negate(atoms)))
        regions = tuple(random_systems.polytope(random, names) for _ in range(int(random.integers(0, 3))))
        claim = SystemClaim(Pattern.DECIDES, regions, formula=formula)
        (result,) = decided(profile, system, [claim], PLAYED if seed % 2 else SEARCHED)
        nothing = replace(claim, formula=FALSE)
        some, fails = (possible(unrolled.encode_claim(profile, system, asked)[0]) for asked in (nothing, claim))
        want = Verdict.VIOLATED if fails else Verdict.PROVED if some else Verdict.VACUOUS
        assert result.verdict is want, (seed, result)
        ensure_evidence(system, profile, claim, result)
        if fails:
            found = result.counterexample.start
            assert not holds(formula, found, choose_actions(system, profile, found))
        met[want] += 1
    assert met[Verdict.PROVED] > 20 and met[Verdict.VIOLATED] > 20


def test_merging_proves_what_takes_too_many_symbolic_states_otherwise():
    system, profile = double_integrator(axes=1, error=F(1, 1000)), switching(axes=1)
    claim = stays(system, 25, x=(-1, 1))
    (result,) = decided(profile, system, [claim])
    assert result.verdict is Verdict.PROVED and result.certificate.proof.parts[0].hulls
    ensure_evidence(system, profile, claim, result)


def test_an_unstable_system_ends_with_its_budget():
    variables = (Variable("x", "1", (F(-9), F(9))), Variable("y", "1", (F(-9), F(9))))
    move = {"x": form(x=3, y=1), "y": form(x=-1, y=3)}
    effect = {("a", "up"): {"x": form(1)}, ("a", "down"): {"y": form(-1)}}
    features = {"a": {"f": Feature(form(x=1, y=-1)), "g": Feature(form(x=1, y=2))}}
    start = box(x=(-1, 1), y=(-1, 1))
    system = System("spiral", variables, features, start, (Piece({}, move, effect, {"x": (F(-1), F(1))}),), 40)
    profile = team(policy("a", ["f", "g"], ["up", "down"], ((0, 0.0), ((1, 0.0), 0, 1), ((1, 1.0), 1, 0))))
    claim, budgets = stays(system, 40, x=(-(10**30), 10**30)), Budgets(covers=False, max_boxes=230_000)
    (result,) = decided(profile, system, [claim], budgets)
    assert result.verdict is Verdict.UNKNOWN
    assert "symbolic states" in result.reason and "the budget is 230,000 boxes" in result.reason
    assert 0 < result.open.step < 40 and result.open.bounds.keys() == {"x", "y"}
    assert all(low < high for low, high in result.open.bounds.values())
    said = " ".join(result.helps)
    assert "--effort" in said and "fewer steps" in said and "errors" in said


@pytest.mark.parametrize("numbers", NUMBERS)
def test_states_beyond_float64_are_judged_and_told(numbers):
    """From 1 the state is a million times itself each step: after 52 steps no float64 is near it."""
    system = on_a_line("grows", (1, 1), Piece({}, {"x": form(x=10**6)}, {}), 60)
    known = policy("a", ["f"], ["go", "rest"], ((0, 0.0), 0, 1))
    threshold = known.tree.threshold.astype(numbers)
    profile = team(replace(known, tree=replace(known.tree, threshold=threshold, numbers=numbers)))
    claim = SystemClaim(Pattern.REACHES, (box(x=(0, 0)),), 60)
    (broken,) = decided(profile, system, [claim])
    assert broken.verdict is Verdict.VIOLATED and broken.counterexample.states[-1]["x"] == 10**360
    assert set(broken.counterexample.actions[-1].values()) == {"rest"}
    question = Question(ClosedLoop(profile, system), claim, UNBOUNDED)
    assert "x above 1.79e308" in "".join(lines(facts(verify_system(question), 1)))
    (kept,) = decided(profile, system, [SystemClaim(Pattern.AVOIDS, (box(x=(-1, 0)),), 60)])
    assert kept.verdict is Verdict.PROVED


TINY = F(1, 10**30)


@pytest.mark.parametrize(
    ("start", "error", "bound"),
    [
        ((F(0), 1 + TINY), F(0), F(1)),  # the upper end alone is above 1
        ((F(0), F(1)), TINY, 1 + TINY / 2),  # it, and an error that no float adds to it
        ((F(0), F(1)), TINY, 1 + TINY - TINY**2),  # with an error at its bound
    ],
)
def test_what_no_float_tells_apart_is_found(start, error, bound):
    piece = Piece({}, {"x": form(x=1)}, {("a", "rest"): {"x": form()}}, {"x": (-error, error)} if error else {})
    system = on_a_line("tiny", start, piece, 1)
    profile = team(policy("a", ["f"], ["rest"], 0))
    (broken,) = decided(profile, system, [stays(system, 1, x=(-1, bound))])
    assert broken.verdict is Verdict.VIOLATED and broken.counterexample.states[-1]["x"] > bound
    (kept,) = decided(profile, system, [stays(system, 1, x=(-1, start[1] + error))])
    assert kept.verdict is Verdict.PROVED


@pytest.mark.smoke
def test_an_episode_that_leaves_what_is_stated_is_not_judged():
    system = on_a_line("drift", (0, 0), Piece({"x": (F(-1), F(1))}, {"x": form(1, x=1)}, {}), 3)
    profile = team(policy("a", ["f"], ["go"], 0))
    claim = SystemClaim(Pattern.AVOIDS, (box(x=(5, 6)),), 3)
    (result,) = decided(profile, system, [claim])
    assert result.verdict is Verdict.UNKNOWN and "stated" in result.reason
    assert result.open.bounds == {"x": (2.0, 2.0)} and "wider ranges" in result.helps[0]
    assert not any("error" in each or "effort" in each for each in result.helps)
    (short,) = decided(profile, system, [replace(claim, steps=2)])
    assert short.verdict is Verdict.PROVED


@pytest.mark.smoke
def test_an_empty_start_is_vacuous():
    system, profile = double_integrator(axes=1), switching(axes=1)
    empty = replace(system, start=(*system.start, HalfSpace(form(2, x=1, vx=1))))
    (result,) = decided(profile, empty, [stays(system, 3, x=(-1, 1))])
    assert result.verdict is Verdict.VACUOUS and result.certificate is None


def test_what_the_system_does_not_state_is_refused():
    system, profile = double_integrator(axes=1), switching(axes=1)
    claim = stays(system, 3, x=(-1, 1))
    with pytest.raises(UnknownNameError):
        decided(profile, replace(system, features={"drone": {}}), [claim])
    with pytest.raises(UnknownNameError):
        decided(profile, replace(system, features={}), [claim])
    with pytest.raises(InputError):
        decided(profile, replace(system, pieces=()), [claim])


def test_what_moves_a_system_is_never_left_out():
    """An agent without a tree is none that rests, and an error that no number meets is none."""
    system, profile = double_integrator(axes=1), switching(axes=1)
    claim = stays(system, 3, x=(-1, 1))
    (alone,) = decided(profile, system, [claim])
    assert alone.verdict is Verdict.PROVED
    (piece,) = system.pieces
    pushed = replace(piece, effect={**piece.effect, ("wind", "blows"): {"x": form(5)}})
    with pytest.raises(InputError, match="no tree for wind"):
        decided(profile, replace(system, pieces=(pushed,)), [claim])
    backwards = replace(system, pieces=(replace(piece, error={"x": (F(1), F(-1))}),))
    with pytest.raises(RejectedError, match="low end"):
        accept(altered(alone.certificate, system=content_hash(backwards)), profile, backwards)
    windy = replace(system, pieces=(pushed,))
    forged = altered(alone.certificate, system=content_hash(windy))
    with pytest.raises(InputError, match="no tree for agents"):
        accept(forged, profile, windy)


def test_a_region_may_have_more_conditions_than_the_stack_has_frames():
    system, profile = double_integrator(axes=1), switching(axes=1)
    many = tuple(HalfSpace(form(-4, x=1, vx=F(1, number))) for number in range(1, 201))
    claim = SystemClaim(Pattern.AVOIDS, ((*many, *box(x=(-9, -8))),), 1)
    limit = sys.getrecursionlimit()
    sys.setrecursionlimit(len(inspect.stack()) + 150)
    try:
        (result,) = decided(profile, system, [claim], SEARCHED)
    finally:
        sys.setrecursionlimit(limit)
    assert result.verdict is Verdict.PROVED


WORLDS = Path(__file__).parents[3] / "generated" / "worlds"
BRIEF = ["corridor", "crossing", "pendulum", "pendulum_wide", "quadrotor", "quadrotor_wide"]


def asked(profile, system, claims, **budgets):
    subject = ClosedLoop(profile, system)
    return [Question(subject, claim, UNBOUNDED, budgets=Budgets(**budgets)) for claim in claims]


def answers(questions):
    """Of all claims, with what was spent on each."""
    found = map(decide, questions)
    return [(outcome.verdict, outcome.boxes, outcome.states, outcome.programs) for outcome in found]


def world(name):
    statement = read(WORLDS / f"{name}.toml")
    profile = find_profile(WORLDS / f"{name.removesuffix('_wide')}.json", beside=WORLDS)
    return profile, statement.system, claims_of(statement, profile, name)


@pytest.mark.parametrize("name", BRIEF)
def test_a_larger_budget_takes_no_longer_to_what_a_smaller_one_answered(name, monkeypatch):
    """But for what is found at its end, by a few episodes beyond the budget."""
    last = ClaimSearch.break_claim
    monkeypatch.setattr(ClaimSearch, "break_claim", lambda search: None)
    _ensure_monotone(name, (10, 1_000, 30_000, 300_000, 3_000_000))
    monkeypatch.setattr(ClaimSearch, "break_claim", last)
    _ensure_monotone(name, (0, 10, 300_000), verdicts=True)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["cart_pole", "mountain_car", *BRIEF])
def test_budgets_of_all_sizes(name, monkeypatch):
    _ensure_monotone(name, [4**power for power in range(0, 14, 2)], verdicts=True)
    monkeypatch.setattr(ClaimSearch, "break_claim", lambda search: None)
    _ensure_monotone(name, [4**power for power in range(14)])


def _ensure_monotone(name, budgets, *, verdicts=False):
    """`verdicts`: that these stay, whatever it took."""
    profile, system, claims = world(name)
    before = []
    for most in budgets:
        now = answers(asked(profile, system, claims, max_boxes=most))
        for old, new in zip(before, now, strict=False):
            if old[0] is not Verdict.UNKNOWN:
                assert (new[0] is old[0]) if verdicts else new == old
        before = now
    assert verdicts or all(verdict is not Verdict.UNKNOWN for verdict, *_ in before)


def test_an_end_names_the_option_and_what_was_spent():
    profile, system, claims = world("quadrotor")
    told = []
    with listening(lambda *given: told.append(given)):
        found = list(map(decide, asked(profile, system, claims, max_boxes=50)))
    for each in found:
        assert each.verdict is Verdict.UNKNOWN
        assert each.reason.startswith("stopped after ") and each.reason.endswith("the budget is 50 boxes")
        assert "a larger --effort" in each.helps
    assert all(most == 50 and 0 <= done <= 50 for done, most, words in told if words.startswith("boxes of the budget"))


@pytest.mark.parametrize("most", [0, 1, 100])
def test_a_claim_that_is_plainly_false_is_violated_however_little_may_be_spent(most):
    """By a few episodes, or states, at the end. Where none may be played, nothing is said."""
    system, profile = drifting()
    claims = [
        stays(system, 8, x=(-1, 1)),
        SystemClaim(Pattern.ALWAYS, (box(x=(-1, 1)),), 8),
        SystemClaim(Pattern.DECIDES, (box(x=(0, 1)),), formula=negate(Acts("a", 0))),
    ]
    for claim, found in zip(claims, map(decide, asked(profile, system, claims, max_boxes=most)), strict=True):
        assert found.verdict is Verdict.VIOLATED and (found.counterexample.step == 0) == claim.about_decisions
    silent = map(decide, asked(profile, system, claims, max_boxes=most, samples=0))
    assert {each.verdict for each in silent} == {Verdict.UNKNOWN}


@pytest.mark.parametrize("spent", [False, True])
def test_what_is_said_of_no_answer_fits_what_the_claim_is_about(spent, monkeypatch):
    """Of single decisions nothing is said of episodes, starts and steps."""
    monkeypatch.setattr(deciding, "witnesses", lambda *given: iter(()))
    system, profile = drifting()
    about = {
        "episodes": stays(system, 8, x=(-1, 1)),
        "decisions": SystemClaim(Pattern.DECIDES, (box(x=(0, 1)),), formula=negate(Acts("a", 0))),
    }
    for kind, claim in about.items():
        budgets = {"max_boxes": 0 if spent else 10**6, "samples": 0, "covers": False}
        (found,) = map(decide, asked(profile, system, [claim], **budgets))
        words = " ".join((found.reason, *found.helps))
        assert found.verdict is Verdict.UNKNOWN and ("stopped after" in words) == spent and found.helps
        assert any(word in words for word in ("episode", "start", "step")) == (kind == "episodes"), words


@pytest.mark.parametrize("empty", [True, False])
def test_a_claim_about_nothing_says_of_what(empty, monkeypatch):
    verdict = Verdict.VACUOUS if empty else Verdict.UNKNOWN
    monkeypatch.setattr(programs, "inhabitant", lambda *given: verdict)
    system, profile = drifting()
    moving = stays(system, 1, x=(-9, 9))
    still = SystemClaim(Pattern.DECIDES, (box(x=(0, 1)),), formula=Acts("a", 0))
    for claim, words in ((moving, "start"), (still, "state")):
        (found,) = map(decide, asked(profile, system, [claim], samples=0))
        assert found.verdict is verdict and words in found.reason and found.helps
        assert ("episode" in found.reason) == (claim is moving)


def test_a_proof_that_the_checker_cannot_go_through_is_no_answer(monkeypatch):
    """It may not enumerate the cells of what pieces test, here the two sides of 0."""
    system, profile = drifting()
    (piece,) = system.pieces
    halves = [replace(piece, where={"x": (F(-9), F(9))}, when=(HalfSpace(form(x=sign), sign > 0),)) for sign in (1, -1)]
    for most, verdict in ((cases.MAX_CELLS, Verdict.PROVED), (0, Verdict.UNKNOWN)):
        monkeypatch.setattr(cases, "MAX_CELLS", most)
        split = replace(system, pieces=tuple(halves))
        (found,) = map(decide, asked(profile, split, [stays(split, 1, x=(-9, 9))], samples=0, covers=False))
        assert found.verdict is verdict and ("test too much" in found.reason) == (not most), found.reason


# --- counterexamples


def drifting(error=F(0)):
    """x grows by 1/8 and something each step."""
    piece = Piece({}, {"x": form(F(1, 8), x=1)}, {}, {"x": (-error, error)} if error else {})
    return on_a_line("drift", (0, 1), piece, 8), team(policy("a", ["f"], ["go"], 0))


@pytest.mark.smoke
@pytest.mark.parametrize("error", [F(0), F(1, 100)])
def test_counterexamples_are_short(error):
    """The start has the fewest digits that do; an error makes them a step shorter."""
    system, profile = drifting(error)
    (found,) = [decide(each) for each in asked(profile, system, [stays(system, 8, x=(-1, F(15, 8)))])]
    assert found.verdict is Verdict.VIOLATED
    assert found.counterexample.start["x"] == 1 and found.counterexample.step == (7 if error else 8)


def test_shrinking_takes_no_more_steps():
    system, profile = drifting()
    claim = stays(system, 8, x=(-1, F(3, 2)))
    long = replay_course(profile, system, claim, Course({"x": F(98765432109, 100000000000)}))
    found = replay.shrink_counterexample(profile, system, claim, long)
    assert found.step <= long.step and found.start["x"] == 1
    thin = replay_course(profile, system, stays(system, 0, x=(F(1, 3), 1)), Course({"x": F(33, 100)}))
    assert replay.shrink_counterexample(profile, system, stays(system, 0, x=(F(1, 3), 1)), thin).start["x"] == 0


def test_a_thin_violation_is_found_in_what_boxes_leave_open():
    """Random play of the whole start hits one start in 10^4; the sweep cuts down to it."""
    system, profile = drifting()
    claim = stays(system, 8, x=(-1, 2 - F(1, 10_000)))
    (question,) = asked(profile, system, [claim])
    found = decide(question)
    assert found.verdict is Verdict.VIOLATED and not found.states
    assert found.counterexample.step == 8
