"""The command verify: verdicts alone, and what is left of a command that is interrupted."""

import json

import pytest

from codegen.agreement import compiled
from codegen.errors import ExitCode
from codegen.policy_json import dumps
from maviper.cli.main import run as command
from verify.verdicts import decisions

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
