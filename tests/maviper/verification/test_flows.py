"""`maviper verify --system` about continuous time: verdicts, files, checks and replays."""

import csv
import json

import pytest

from codegen.errors import ExitCode
from maviper.cli.main import run as command
from tests.support.flows import BRAKING, LOWERED, PENDULUM
from tests.support.stated import profile, verify


@pytest.fixture
def pendulum(tmp_path):
    (tmp_path / "profile.json").write_text(profile(BRAKING.agents[0]))
    (tmp_path / "world.toml").write_text(PENDULUM + LOWERED + LOWERED.replace("[0, 1]", "[0, 0.6]"))
    return tmp_path


def test_verdicts_files_checks_and_replays(pendulum, capsys):
    out = pendulum / "report"
    assert verify(pendulum, "-o", str(out), "--json", world="world.toml") == ExitCode.VIOLATED
    told = json.loads(capsys.readouterr().out)
    assert [each["verdict"] for each in told["results"]] == ["PROVED", "VIOLATED"]
    assert told["of"] == "of the stated flow, with actions held for 0.05 s, exactly" and told["dt"] == "0.05"
    assert told["results"][0]["engines"][0]["engine"] == "flows" and "held until the next" in told["semantics"]
    assert any("for a proof about continuous time" in line for line in told["trusted"])
    assert "hold all states at all times" in (out / "report.txt").read_text()
    rows = list(csv.DictReader((out / "counterexample-2-reaches_and_stays.csv").read_text().splitlines()))
    assert rows[-1]["time_s"] == "0.5" and float(rows[-1]["angle"]) > 0.6
    certificate, broken = out / "certificate-1-reaches_and_stays.json", out / "counterexample-2-reaches_and_stays.json"
    assert command(["check", str(certificate)]) == ExitCode.DONE
    assert "at all times" in capsys.readouterr().out
    assert command(["replay", str(broken), "--profile", str(out / "profile.json")]) == ExitCode.VIOLATED
    assert "in enclosures of the flow that is stated" in capsys.readouterr().err
    _refused_about_another_world(out, certificate, broken, capsys)


def _refused_about_another_world(out, certificate, broken, capsys):
    world = out / "world.toml"
    world.write_text(world.read_text().replace("2[1/s^2]*sin", "2.1[1/s^2]*sin"))
    assert command(["check", str(certificate)]) == ExitCode.INPUT
    assert "another system" in capsys.readouterr().err
    command(["replay", str(broken), "--profile", str(out / "profile.json")])
    assert "not the one that the counterexample was made from" in capsys.readouterr().err
