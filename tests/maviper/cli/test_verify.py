"""The command verify: verdicts alone, and what is left of a command that is interrupted."""

import json
import signal
import time
from pathlib import Path
from xml.etree import ElementTree

import pytest

from codegen.agreement import compiled
from codegen.errors import ExitCode
from codegen.policy_json import dumps
from maviper.cli.main import run as command
from maviper.cli.results import write_junit
from maviper.verification import run as verification
from tests.support import stated
from tests.support.systems import CART
from verify.result import Verdict
from verify.verdicts import decisions

EXTRACTED = Path(__file__).parents[3] / "generated" / "physical_deception" / "extracted" / "profile.json"
TWO = ("--claim", "distinct_targets", "--claim", "no_double")


@pytest.fixture(scope="module")
def profile_file(profile, tmp_path_factory):
    path = tmp_path_factory.mktemp("verify") / "profile.json"
    path.write_text(dumps(profile))
    return str(path)


@pytest.mark.solver
@pytest.mark.smoke
def test_verdicts_alone_are_those_of_the_report(capsys, profile_file):
    code = command(["verify", profile_file, *TWO, "--json"])
    full = json.loads(capsys.readouterr().out)["results"]
    assert command(["verify", profile_file, *TWO, "--verdict-only", "--json"]) == code
    alone = json.loads(capsys.readouterr().out)["results"]
    assert [(one["property"], one["verdict"]) for one in alone] == [(one["property"], one["verdict"]) for one in full]
    assert command(["verify", profile_file, *TWO, "--verdict-only"]) == code
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in lines] == [one["verdict"] for one in full]


def test_verdicts_alone_make_no_header_where_no_contact_asks_for_a_replay(capsys, monkeypatch, profile_file):
    made = []
    header = compiled.emit_model
    monkeypatch.setattr(compiled, "emit_model", lambda *asked: made.append(asked) or header(*asked))
    episodes = ("--claim", "reaches", "--claim", "covers(steps=2)")
    command(["verify", profile_file, *episodes, *TWO, "--verdict-only"])
    assert capsys.readouterr().out.count("\n") == 4 and not made


@pytest.mark.parametrize("other", [("--where",), ("-o", "report")])
def test_what_verdicts_alone_cannot_have_is_refused(capsys, profile_file, other):
    assert command(["verify", profile_file, "--verdict-only", *other]) == ExitCode.INPUT
    assert "--verdict-only" in capsys.readouterr().err


@pytest.mark.solver
def test_an_interrupted_command_keeps_the_verdicts_that_it_has(capsys, profile_file, tmp_path, monkeypatch):
    whole, asked = decisions.verify, []

    def verify(question, *more):
        asked.append(question)
        if len(asked) == 2:
            raise KeyboardInterrupt
        return whole(question, *more)

    monkeypatch.setattr(decisions, "verify", verify)
    code = command(["verify", profile_file, *TWO, "-o", str(tmp_path)])
    said = capsys.readouterr().err
    assert code == ExitCode.INTERRUPTED and "1 of 2 claims decided" in said
    kept = json.loads((tmp_path / "report.json").read_text())["results"]
    assert [one["property"] for one in kept] == ["distinct_targets"]


@pytest.fixture
def worlds(tmp_path, profile_file):
    (tmp_path / "cart.json").write_text(stated.profile(stated.BRAKES))
    (tmp_path / "cart.toml").write_text(CART + stated.PROPERTIES)
    world = [str(tmp_path / "cart.json"), "--system", str(tmp_path / "cart.toml")]
    return {"world": world, "game": [profile_file, *TWO, "--where"]}


@pytest.mark.parametrize("about", ["world", pytest.param("game", marks=pytest.mark.slow)])
def test_claims_at_the_same_time_give_the_same_bytes(tmp_path, capsys, worlds, about):
    asked = worlds[about]
    code, said, files = told_of(asked, tmp_path / "one", capsys)
    assert told_of([*asked, "--jobs", "2"], tmp_path / "two", capsys) == (code, said, files) and len(files) > 4


@pytest.mark.slow
def test_verdicts_alone_at_the_same_time(capsys, worlds):
    code = command(["verify", *worlds["world"], "--verdict-only"])
    alone = capsys.readouterr().out
    assert command(["verify", *worlds["world"], "--verdict-only", "--jobs", "2"]) == code
    assert capsys.readouterr().out == alone and alone.count("\n") == 3


def test_no_jobs_are_refused(capsys, profile_file):
    assert command(["verify", profile_file, "--jobs", "0"]) == ExitCode.INPUT
    assert "--jobs must be at least 1, given 0" in capsys.readouterr().err


def told_of(asked, folder, capsys):
    code = command(["verify", *asked, "-o", str(folder)])
    said = capsys.readouterr().out.replace(str(folder), "FOLDER")
    return code, said, {path.name: path.read_bytes() for path in folder.iterdir() if not path.name.startswith(".")}


def slow(number, *more):
    time.sleep(600 * number)
    return answer(number, *more)


answer = verification._answer


@pytest.mark.slow
def test_claims_at_the_same_time_end_with_the_time(capsys, monkeypatch, profile_file):
    """What is known by then is told, and no process is waited for."""
    monkeypatch.setattr(verification, "_answer", slow)
    signal.signal(signal.SIGINT, signal.default_int_handler)
    assert command(["verify", profile_file, *TWO, "--jobs", "2", "--max-seconds", "20"]) == ExitCode.VIOLATED
    said = capsys.readouterr().out
    assert said.startswith("VIOLATED    distinct_targets") and "\nUNKNOWN     no_double" in said


def test_verdicts_are_the_result(tmp_path, capsys):
    """On standard output, quiet or not: a line a claim, the first failure, the report and what comes next."""
    for quiet in ((), ("-q",)):
        code = command(["verify", *quiet, str(EXTRACTED), "--claim", "alive_leaves", *TWO, "-o", str(tmp_path / "out")])
        lines = capsys.readouterr().out.splitlines()
        assert code == ExitCode.VIOLATED and len(lines) == 6
        assert [line.split()[0] for line in lines[:4]] == ["PROVED", "VIOLATED", "agent_0", "VIOLATED"]
        assert lines[2].strip().startswith("agent_0 goes") and lines[4].startswith("report      ")
        assert lines[5].startswith("next        maviper replay ") and "counterexample-2-" in lines[5]


@pytest.mark.parametrize("more", [[], ["--verdict-only"]])
def test_junit_is_read_by_another_parser(tmp_path, more):
    from junitparser import JUnitXml

    file = tmp_path / "verdicts.xml"
    asked = ["--claim", "alive_leaves", "--claim", "distinct_targets", *more, "--junit", str(file)]
    assert command(["-q", "verify", str(EXTRACTED), *asked]) == ExitCode.VIOLATED
    (suite,) = JUnitXml.fromfile(str(file))
    assert (suite.tests, suite.failures, suite.errors, suite.skipped) == (2, 1, 0, 0)
    assert [(case.name.split()[0], len(case.result)) for case in suite] == [
        ("alive_leaves", 0),
        ("distinct_targets", 1),
    ]


def test_what_is_not_decided_does_not_pass_in_junit():
    told = [("a", Verdict.PROVED, ""), ("b", Verdict.UNKNOWN, "a budget"), ("c", Verdict.VACUOUS, "")]
    suite = ElementTree.fromstring(write_junit("team", told))
    assert [[(each.tag, each.get("message")) for each in case] for case in suite] == [
        [],
        [("error", "UNKNOWN: a budget")],
        [("error", "VACUOUS")],
    ]
    assert suite.get("errors") == "2" and suite.get("skipped") == "0"


def test_after_max_seconds_open_claims_are_unknown(profile_file, capsys, monkeypatch):
    def wait(*_):
        while True:  # until it is interrupted
            time.sleep(0.01)

    monkeypatch.setattr(verification, "one_by_one", wait)
    signal.signal(signal.SIGINT, signal.default_int_handler)  # a command that was interrupted left its own
    assert command(["verify", profile_file, *TWO, "--max-seconds", "0.2"]) == ExitCode.INCONCLUSIVE
    assert capsys.readouterr().out.count("no answer within 0.2 s (--max-seconds)") == 2
