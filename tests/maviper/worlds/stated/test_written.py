"""Rules as they are written: what breaks a claim only by the error of enclosures is no counterexample."""

from fractions import Fraction as F

import numpy as np
import pytest

from maviper.verification.ask import VerifyOptions
from maviper.verification.run import verify_world
from tests.support.system_cases import box, policy, stays, team
from verify.reach.play import Play, Starts, random_starts
from verify.reach.replay import Course
from verify.reach.written import WrittenReplay
from verify.result import Verdict
from verify.systems.claims import Pattern, SystemClaim
from verify.systems.files import statement_of
from verify.verdicts.systems import ENCLOSED

SINE = """
name = "sine"
steps = 1
[variables]
x = { range = [-2, 2] }
[agents.a.features]
f = "x"
[agents.a.actions]
go = {}
[start]
box = { x = [0, 1] }
[dynamics.next]
x = "sin(x)"
[[property]]
name = "reaches_and_stays"
by = 1
region = { where = ["x <= 0.85"] }
"""
GOES = team(policy("a", ["f"], ["go"], 0))


@pytest.mark.parametrize(
    ("old", "new", "verdict"),
    [
        ("", "", Verdict.UNKNOWN),  # sin 1 = 0.8415, and one piece encloses it by 0.42
        ("[dynamics.next]", "[dynamics.cuts]\nx = 16\n[dynamics.next]", Verdict.PROVED),
        ("0.85", "0.84", Verdict.VIOLATED),
        ("[dynamics.next]", "[dynamics.error]\nx = 0.01\n[dynamics.next]", Verdict.VIOLATED),
        ("[dynamics.next]", "[dynamics.error]\nx = 0.008\n[dynamics.next]", Verdict.UNKNOWN),
    ],
)
def test_verdicts_are_of_the_rules_and_the_stated_errors(tmp_path, old, new, verdict):
    (tmp_path / "sine.toml").write_text(SINE.replace(old, new) if old else SINE)
    (result,) = verify_world(GOES, VerifyOptions(world=tmp_path / "sine.toml")).results
    assert result.verdict is verdict
    assert (result.reason == ENCLOSED) == (verdict is Verdict.UNKNOWN)
    if verdict is Verdict.VIOLATED:
        last = result.counterexample.states[-1]["x"]
        assert F("0.84") < last < F("0.8515")


def test_an_episode_ends_where_nothing_is_stated():
    grows = statement_of(SINE.replace("sin(x)", "x + 2*x*x").replace("steps = 1\n", "steps = 40\n"), "f")
    start = [{"x": F(1)}]
    assert WrittenReplay(grows, GOES, stays(grows.system, 40, x=(-4, 2))).keep_near(start) == [{"x": 1}, {"x": 3}]
    assert WrittenReplay(grows, GOES, stays(grows.system, 40, x=(-4, 4))).keep_near(start) is None


def test_starts_that_are_no_float64_stay_as_they_are(tmp_path):
    """A start of a tenth is the only one there is; the nearest float64 lies above it."""
    text = SINE.replace("[0, 1] }", '["1/10", "1/10"] }').replace("0.85", "0.09")
    (tmp_path / "sine.toml").write_text(text)
    (result,) = verify_world(GOES, VerifyOptions(world=tmp_path / "sine.toml")).results
    assert result.verdict is Verdict.VIOLATED and result.counterexample.start == {"x": F(1, 10)}
    assert abs(result.counterexample.states[-1]["x"] - F("0.0998334166")) < F(1, 10**9)


def test_a_counterexample_of_few_starts_is_found(tmp_path):
    """The next state is at most .9 but where x is within .001 of .618, which 256 random starts miss."""
    rule = 'x = "1 / (1 + 100000 * (x - 0.618)**2)"'
    text = SINE.replace('x = "sin(x)"', rule).replace("0.85", "0.9")
    (tmp_path / "sine.toml").write_text(text)
    (result,) = verify_world(GOES, VerifyOptions(world=tmp_path / "sine.toml")).results
    assert result.verdict is Verdict.VIOLATED
    assert abs(result.counterexample.start["x"] - F("0.618")) < F("0.0011")


def test_rules_in_batches_move_as_they_do_one_by_one():
    """Two rules that `max` tells apart, errors, and an effect with a `clip`: a course is followed to its states."""
    text = SINE.replace("steps = 1", "steps = 5").replace("[-2, 2]", "[-4, 4]")
    text = text.replace("go = {}", "go = { push = 0.1 }").replace(
        "[dynamics.next]",
        """[dynamics.error]
x = 0.01
[dynamics.next]""",
    )
    statement = statement_of(text.replace("sin(x)", "max(sin(3*x), x*x - 1) + a.push*clip(x, 0, 1)"), "f")
    play = Play(GOES, statement.system, statement.rules)
    start = {"x": np.linspace(-1.5, 1.5, 50)}
    states = [state["x"] for _, state, going in play.walk(start, np.random.default_rng(0), 5) if going.all()]
    assert len(states) == 6
    claim = SystemClaim(Pattern.REACHES, (box(x=(9, 10)),), 5)
    for place in range(50):
        again = WrittenReplay(statement, GOES, claim).follow(play.course(start, place))
        assert np.allclose([float(state["x"]) for state in again], [each[place] for each in states], rtol=1e-12)


PEAK = """
name = "peak"
steps = 6
[variables]
x = { range = [-4, 4] }
y = { range = [-1, 1] }
p = { range = [-1, 1] }
[agents.a.features]
f = "x"
[agents.a.actions]
go = {}
[start]
box = { x = 0.1, y = [-1, 1], p = 0.1 }
[dynamics.let]
noise = "choice(0, 0.3, 1)"
[dynamics.cuts]
y = 8
[dynamics.error]
x = 0.1
[dynamics.next]
x = "RULE"
y = "y"
p = "p + 0.5"
[[property]]
name = "stays_in"
region = REGION
"""
RARE = "1/(1 + 4000*(y - 0.318)**2)"


@pytest.mark.parametrize(
    ("rule", "region", "verdict"),
    [
        (RARE, "{ box = { x = [-4, 1] } }", Verdict.VIOLATED),  # x starts at a tenth, which is no float64
        (RARE, "[{ box = { p = [-10, 2.5] } }, { box = { x = [-4, 0.9] } }]", Verdict.VIOLATED),  # p beyond its range
        ("sin(3*y)/4 + noise", "{ box = { x = [-4, 1.2] } }", Verdict.VIOLATED),  # by the last of three choices
        ("0.2*y*y", "{ box = { x = [-4, 0.3] } }", Verdict.UNKNOWN),  # true: x is .3 at most, and rounds to more
        ("sin(3*y)**2 + cos(3*y)**2", "{ box = { x = [-4, 1.1] } }", Verdict.UNKNOWN),  # true: the sum is 1
        ("0.2*y*y", "{ box = { x = [-4, 0.299] } }", Verdict.VIOLATED),
    ],
)
def test_drawn_episodes_meet_starts_ranges_choices_and_roundings(tmp_path, rule, region, verdict):
    text = PEAK.replace("RULE", rule).replace("REGION", region)
    (tmp_path / "peak.toml").write_text(text if "noise" in rule else text.replace('noise = "choice(0, 0.3, 1)"', ""))
    (result,) = verify_world(GOES, VerifyOptions(world=tmp_path / "peak.toml")).results
    assert result.verdict is verdict
    if verdict is Verdict.VIOLATED:
        assert result.counterexample.start["x"] == F(1, 10)


SATURATING = """
name = "saturating"
steps = 14
[variables]
x = { range = X }
t = { range = [-10, 50] }
[agents.a.features]
f = "x"
[agents.a.actions]
go = {}
[start]
box = START
[dynamics.cuts]
x = 16
[dynamics.next]
x = "RULE"
t = "THEN"
[[property]]
name = "stays_in"
region = { where = ["CLAIM"] }
"""


@pytest.mark.parametrize(
    ("variable", "start", "rule", "then", "claim"),
    [
        ("[0, 0.6]", "{ x = [0.1, 0.2], t = 0 }", "clip(x + 0.1*x*x + 0.1, 0, 0.6)", "t + 1", "x - 0.05*t >= 0"),
        ("[0, 0.6]", "{ x = [0.1, 0.2], t = 0 }", "min(x + 0.1*x*x + 0.1, 0.6)", "t + 1", "x - 0.05*t >= 0"),
        ("[0, 0.9]", "{ x = [0.1, 0.2], t = 0 }", "clip(x + 0.3 - 0.1*sqrt(x), 0, 0.9)", "t + x", "t <= 5"),
        ("[0, 1]", "{ x = 0, t = [1, 2] }", "exp(-x)", "t + 1", "t <= 5"),
        ("[0, 1]", "{ x = 1, t = [1, 2] }", "sqrt(x)", "t + 1", "t <= 5"),
        ("[0, 1]", "{ x = 0, t = [1, 2] }", "1 - cos(x)", "t + 1", "t <= 5"),
    ],
)
def test_states_at_the_ends_of_their_ranges_are_followed(tmp_path, variable, start, rule, then, claim):
    """.6 and .9 are no multiples of 2^-128, and a root or an exponential there has to be exact."""
    text = SATURATING.replace("X", variable).replace("START", start).replace("RULE", rule)
    (tmp_path / "world.toml").write_text(text.replace("THEN", then).replace("CLAIM", claim))
    (result,) = verify_world(GOES, VerifyOptions(world=tmp_path / "world.toml")).results
    assert result.verdict is Verdict.VIOLATED


def test_where_conditions_leave_few_starts_more_are_drawn():
    thin = SINE.replace("box = { x = [0, 1] }", 'box = { x = [0, 1], y = [0, 1] }\nwhere = ["x + 0.99 <= y"]')
    thin = thin.replace("x = { range = [-2, 2] }", "x = { range = [-2, 2] }\ny = { range = [-2, 2] }")
    system = statement_of(thin.replace('x = "sin(x)"', 'x = "sin(x)"\ny = "y"'), "f").system
    start = random_starts(system, stays(system, 1, x=(-1, 1)), Starts(4_096), np.random.default_rng(0))
    assert 256 <= len(start["x"]) <= 4_096 and (start["x"] + 0.99 <= start["y"]).all()


def test_a_thin_start_region_is_searched_where_it_lies(tmp_path):
    """Of numbers drawn at once hardly any meet the conditions but at corners."""
    text = PEAK.replace("RULE", "1/(1 + 400*(y - 0.318)**2)").replace("REGION", "{ box = { x = [-4, 0.95] } }")
    text = text.replace(
        "box = { x = 0.1, y = [-1, 1], p = 0.1 }",
        """box = { x = [-1, 1], y = [-1, 1], p = [-1, 1] }
where = ["x - y <= 0.02", "y - x <= 0.02", "y - p <= 0.02", "p - y <= 0.02"]""",
    )
    text = (
        text.replace("x = 0.1\n", "x = 0\n")
        .replace('noise = "choice(0, 0.3, 1)"', "")
        .replace("steps = 6", "steps = 1")
    )
    (tmp_path / "peak.toml").write_text(text)
    (result,) = verify_world(GOES, VerifyOptions(world=tmp_path / "peak.toml")).results
    assert result.verdict is Verdict.VIOLATED


def test_chaos_is_followed_by_its_rule_and_not_by_floats():
    """After 58 steps from a tenth, x is .33972; float64 comes to .08811."""
    chaos = statement_of(SINE.replace("sin(x)", "4*x*(1 - x)").replace("steps = 1", "steps = 58"), "f")
    course = Course({"x": F(1, 10)})

    def play(low, high):
        claim = SystemClaim(Pattern.REACHES_AND_STAYS, (box(x=(low, high)),), 58, by=58)
        return WrittenReplay(chaos, GOES, claim).follow(course)

    assert play(F("0.2"), 2) is None
    assert float(play(-2, F("0.2"))[-1]["x"]) == pytest.approx(0.3397167186459309, abs=1e-15)
