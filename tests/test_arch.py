"""generated/arch/: plants of ARCH-COMP in continuous time, with trees and certificates."""

import json
import re
from pathlib import Path

import pytest

from codegen.errors import ExitCode
from maviper.cli.main import run as command
from verify.systems.files import statement_of

PLACE = Path(__file__).parent.parent / "generated" / "arch"
STARTS = {  # as they are specified
    "pendulum": {"angle": ("1", "1.175"), "spin": ("0", "0.2")},
    "nav": {"x1": ("2.9", "3.1"), "x2": ("2.9", "3.1"), "x3": ("0", "0"), "x4": ("0", "0")},
    "acc": {
        "lead.p": ("90", "110"),
        "lead.v": ("32", "32.2"),
        "lead.g": ("0", "0"),
        "ego.p": ("10", "11"),
        "ego.v": ("30", "30.2"),
        "ego.g": ("0", "0"),
    },
}
HORIZONS = {"pendulum": ("0.05", 20), "nav": ("0.2", 30), "acc": ("0.1", 50)}


@pytest.mark.parametrize("name", STARTS)
def test_all_is_proved_from_the_specified_starts(name):
    told = json.loads((PLACE / name / "report.json").read_text())
    assert {each["verdict"] for each in told["results"]} == {"PROVED"}
    assert {key: tuple(ends) for key, ends in told["start"]["box"].items()} == STARTS[name]
    assert not told["start"]["conditions"] and (told["dt"], told["steps"]) == HORIZONS[name]
    assert (PLACE / name / "world.toml").read_text() == (PLACE / f"{name}.toml").read_text()
    assert (PLACE / name / "profile.json").read_text() == (PLACE / f"{name}.json").read_text()
    assert statement_of((PLACE / f"{name}.toml").read_text(), name).system.flow is not None


@pytest.mark.parametrize("name", ["pendulum", "nav", pytest.param("acc", marks=pytest.mark.slow)])
def test_the_checker_accepts_every_certificate(name):
    found = sorted((PLACE / name).glob("certificate-*.json"))
    assert len(found) == len(json.loads((PLACE / name / "report.json").read_text())["results"])
    for path in found:
        assert command(["check", str(path)]) == ExitCode.DONE


def test_the_readme_names_every_plant_and_what_the_controls_say():
    text = (PLACE / "README.md").read_text()
    rows = re.findall(r"^\| (Single Pendulum|NAV|ACC) .*\| PROVED +\|", text, re.MULTILINE)
    assert len(rows) == len(STARTS)
    weak = {
        name: [each["shuffled_control"] for each in json.loads((PLACE / name / "report.json").read_text())["results"]]
        for name in STARTS
    }
    assert weak == {"pendulum": ["VIOLATED"], "nav": ["VIOLATED", "PROVED"], "acc": ["PROVED"]}
