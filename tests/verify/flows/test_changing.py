"""Episodes whose periods and delays change from sample to sample break claims that no even ones break."""

import csv
import json
from fractions import Fraction as F
from itertools import product

import numpy as np
import pytest

from codegen.errors import ExitCode
from maviper.cli.main import run as command
from tests.support.flows import case
from tests.support.stated import profile, verify
from tests.support.system_cases import policy, team
from verify.claims.region import UNBOUNDED
from verify.flows.decide import decide
from verify.flows.episodes import FlowCourse, FlowPlay, replay_course
from verify.question import Question
from verify.result import Verdict
from verify.subjects import ClosedLoop

DRIVING = """
name = "driving"
steps = 3
[variables]
x = { unit = "m", range = [-9, 9] }
[agents.car.features]
x = "x"
[agents.car.actions]
back = { v = "-1 m/s" }
go = { v = "1 m/s" }
[start]
box = { x = 0 }
[dynamics]
SAID
[dynamics.flow]
x = "car.v"
"""
TURNING_BACK = team(policy("car", ["x"], ["back", "go"], ((0, 0.9), 1, 0)))
CLAIM = """
[[property]]
name = "stays_in"
region = { box = { x = [LOW, HIGH] } }
"""
CASES = {  # what is said, bounds of x, and what breaks them: errors, periods, ways
    # a short period ends before 0.9, and a long one beyond 1.9 if the car goes on; even ones turn back, or get to 1.6
    "jitter": ('period = { length = "1 s", jitter = 0.2 }', "-9", "1.9", [{}], [F(-1, 5), F(1, 5)], [0]),
    # 0, 1, 0, 1 where all is seen at once, 0, 1, 2, 1 where all is late; seen at once and then late: 0, 1, 0, -1
    "delay": ('period = { length = "1 s", delay = [0, 1] }', "-0.5", "9", [{}], [F(0)], [0, 0, 1]),
    # slow and then fast, as with jitter
    "error": (
        'period = "1 s"\nerror = { x = "0.2 m/s" }',
        "-9",
        "1.9",
        [{"x": F(-1, 5)}, {"x": F(1, 5)}],
        [F(0)],
        [0],
    ),
}


def asked(name):
    said, low, high, *_ = CASES[name]
    claim = CLAIM.replace("LOW", low).replace("HIGH", high)
    system, agents, claim = case(DRIVING.replace("SAID", said), TURNING_BACK, claim)
    return Question(ClosedLoop(agents, system), claim, UNBOUNDED)


@pytest.mark.parametrize("name", CASES)
def test_what_only_changing_samples_break_is_violated(name):
    question, (_, _, _, errors, longer, ways) = asked(name), CASES[name]
    agents, system, claim = question.profile, question.subject.system, question.claim
    known = FlowCourse({one.name: F(0) for one in system.variables}, errors, longer, ways)
    assert replay_course(agents, system, claim, known) is not None
    for even in product(errors, {*longer, F(0)}, range(len(system.flow.seen))):
        course = FlowCourse(known.start, *([each] for each in even))
        assert replay_course(agents, system, claim, course) is None
    found = decide(question)
    again = found.counterexample
    assert found.verdict is Verdict.VIOLATED
    assert len(again.longer) + len(again.ways) > 2 or again.errors[0] != again.errors[1]
    course = FlowCourse(again.start, again.errors or [{}], again.longer, again.ways)
    assert replay_course(agents, system, claim, course) == again


@pytest.mark.parametrize("name", CASES)
def test_a_file_carries_the_sequence_and_is_replayed(name, tmp_path, capsys):
    said, out = CASES[name], tmp_path / "out"
    claim = CLAIM.replace("LOW", said[1]).replace("HIGH", said[2])
    (tmp_path / "profile.json").write_text(profile(TURNING_BACK.agents[0]))
    (tmp_path / "world.toml").write_text(DRIVING.replace("SAID", said[0]) + claim)
    assert verify(tmp_path, "-o", str(out), world="world.toml") == ExitCode.VIOLATED
    (path,) = out.glob("counterexample-*.json")
    replay = ["replay", str(path), "--profile", str(out / "profile.json")]
    assert command(replay) == ExitCode.VIOLATED
    document = json.loads(path.read_text())
    key = {"jitter": "longer", "delay": "way", "error": "errors"}[name]
    assert isinstance(document[key], list)
    rows = list(csv.DictReader(path.with_suffix(".csv").read_text().splitlines()))
    longer = [F(each) for each in document["longer"]] if key == "longer" else [F(0)]
    assert rows[1]["time_s"] == str(float(1 + longer[0])) and len(rows) == document["step"] + 1
    beyond = {"longer": "1", "way": 7, "errors": {"x": "1"}}[key]
    for wrong in ([], document[key][:1], [beyond]):
        path.write_text(json.dumps({**document, key: wrong}))
        assert command(replay) != ExitCode.VIOLATED
    capsys.readouterr()


def test_samples_stay_alternate_or_are_drawn_anew():
    question = asked("jitter")
    play = FlowPlay(question.profile, question.subject.system, question.claim)
    drawn = np.array([play._draw_sample(np.arange(-1, 9), period)[0] for period in range(6)]).T
    assert (drawn[0] == 0).all() and (np.ptp(drawn[1:4], axis=1) == 0).all()
    assert (drawn[4:7, 1:] == -drawn[4:7, :-1]).all() and set(np.abs(drawn[4:].ravel()).tolist()) == {0.2}
    assert not (drawn[7:, 1:] == -drawn[7:, :-1]).all(axis=1).any()
