"""The search for the answer to one claim: what budgets end, what is said of no answer, small counterexamples."""

from fractions import Fraction as F
from pathlib import Path

import pytest

from maviper.files.profiles import find_profile
from maviper.worlds.stated.systems import read
from tests.support.system_cases import box, form, policy, stays, team
from verify.claims.formula import Acts, negate
from verify.claims.region import UNBOUNDED
from verify.progress import listening
from verify.question import Budgets, Question
from verify.reach import decide as deciding
from verify.reach import replay
from verify.reach.decide import ClaimSearch, decide
from verify.reach.replay import Course, replay_course
from verify.result import Verdict
from verify.subjects import ClosedLoop
from verify.systems.claims import Pattern, SystemClaim
from verify.systems.properties import claims_of
from verify.systems.system import Feature, Piece, System, Variable

WORLDS = Path(__file__).parents[3] / "generated" / "worlds"
NAMES = [
    "cart_pole",
    "corridor",
    "crossing",
    "mountain_car",
    "pendulum",
    "pendulum_wide",
    "quadrotor",
    "quadrotor_wide",
]


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


@pytest.mark.parametrize("name", ["corridor", "crossing", "pendulum", "pendulum_wide", "quadrotor", "quadrotor_wide"])
def test_a_larger_budget_takes_no_longer_to_what_a_smaller_one_answered(name, monkeypatch):
    """But for what is found at its end, by a few episodes beyond the budget."""
    last = ClaimSearch._play_last
    monkeypatch.setattr(ClaimSearch, "_play_last", lambda search: None)
    _ensure_monotone(name, (10, 1_000, 30_000, 300_000, 3_000_000))
    monkeypatch.setattr(ClaimSearch, "_play_last", last)
    _ensure_monotone(name, (0, 10, 300_000), verdicts=True)


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_budgets_of_all_sizes(name, monkeypatch):
    _ensure_monotone(name, [4**power for power in range(0, 14, 2)], verdicts=True)
    monkeypatch.setattr(ClaimSearch, "_play_last", lambda search: None)
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
        assert each.reason.startswith("stopped after ") and each.reason.endswith("--max-boxes is 50")
        assert "a larger --max-boxes than 50" in each.helps
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
    monkeypatch.setattr(deciding, "inhabitant", lambda *given: verdict)
    system, profile = drifting()
    moving = stays(system, 1, x=(-9, 9))
    still = SystemClaim(Pattern.DECIDES, (box(x=(0, 1)),), formula=Acts("a", 0))
    for claim, words in ((moving, "start"), (still, "state")):
        (found,) = map(decide, asked(profile, system, [claim], samples=0))
        assert found.verdict is verdict and words in found.reason and found.helps
        assert ("episode" in found.reason) == (claim is moving)


# --- counterexamples


def drifting(error=F(0)):
    """x grows by 1/8 and something each step."""
    variables = (Variable("x", "1", (F(-9), F(9))),)
    errors = {"x": (-error, error)} if error else {}
    piece = Piece({}, {"x": form(F(1, 8), x=1)}, {}, errors)
    system = System("drift", variables, {"a": {"f": Feature(form(x=1))}}, box(x=(0, 1)), (piece,), 8)
    return system, team(policy("a", ["f"], ["go"], 0))


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
