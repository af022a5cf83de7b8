"""generated/arch/: plants of ARCH-COMP in continuous time, with trees and certificates."""

import json
import re
from pathlib import Path

import numpy as np
import pytest

from codegen.errors import ExitCode
from codegen.ir import act
from maviper.cli.main import run as command
from maviper.files.profiles import load
from verify.systems.files import statement_of

PLACE = Path(__file__).parent.parent / "generated" / "arch"
STARTS = {  # as they are specified
    "pendulum": {"angle": ("1", "1.175"), "spin": ("0", "0.2")},
    "nav": {"x1": ("2.9", "3.1"), "x2": ("2.9", "3.1"), "x3": ("0", "0"), "x4": ("0", "0")},
    "acc": {
        "lead.p": ("90", "110"), "lead.v": ("32", "32.2"), "lead.g": ("0", "0"),
        "ego.p": ("10", "11"), "ego.v": ("30", "30.2"), "ego.g": ("0", "0"),
    },
    "tora_remain": {"x1": ("0.6", "0.7"), "x2": ("-0.7", "-0.6"), "x3": ("-0.4", "-0.3"), "x4": ("0.5", "0.6")},
    "tora_reach": {"x1": ("-0.77", "-0.75"), "x2": ("-0.45", "-0.43"), "x3": ("0.51", "0.54"), "x4": ("-0.3", "-0.28")},
    "unicycle": {"x1": ("9.5", "9.55"), "x2": ("-4.5", "-4.45"), "x3": ("2.1", "2.11"), "x4": ("1.5", "1.51")},
    "docking": {"x1": ("70", "106"), "x2": ("70", "106"), "x3": ("-0.28", "0.28"), "x4": ("-0.28", "0.28")},
    "attitude": {
        "x1": ("-0.45", "-0.44"), "x2": ("-0.55", "-0.54"), "x3": ("0.65", "0.66"),
        "x4": ("-0.75", "-0.74"), "x5": ("0.85", "0.86"), "x6": ("-0.65", "-0.64"),
    },
    "double_pendulum_less": dict.fromkeys(("th1", "th2", "w1", "w2"), ("1", "1.3")),
    "double_pendulum_more": dict.fromkeys(("th1", "th2", "w1", "w2"), ("1", "1.3")),
    "airplane": {f"x{number}": ("0", "1") if 4 <= number <= 9 else ("0", "0") for number in range(1, 13)},
    "quad": {f"x{number}": ("-0.4", "0.4") if number <= 6 else ("0", "0") for number in range(1, 13)},
    "cart_pole": {
        "x1": ("-0.1", "0.1"), "x2": ("-0.05", "0.05"), "x3": ("-0.1", "0.1"), "x4": ("-0.05", "0.05"), "u": ("0", "0"),
    },
}  # fmt: skip
HORIZONS = {
    "pendulum": ("0.05", 20), "nav": ("0.2", 30), "acc": ("0.1", 50), "tora_remain": ("1", 20),
    "tora_reach": ("0.5", 10), "unicycle": ("0.2", 50), "docking": ("1", 40), "attitude": ("0.1", 30),
    "double_pendulum_less": ("0.05", 20), "double_pendulum_more": ("0.02", 20), "airplane": ("0.1", 20),
    "quad": ("0.1", 50), "cart_pole": ("0.02", 500),
}  # fmt: skip
RULES = {"double_pendulum_less": "double_pendulum", "double_pendulum_more": "double_pendulum"}
EXTRACTED = ("pendulum", "nav", "acc", "docking", "tora_reach")
QUICK = ("pendulum", "nav", "tora_reach")  # to check
WEAK = {  # verdicts about shuffled trees other than VIOLATED
    "nav": ["VIOLATED", "UNKNOWN"],
    "acc": ["UNKNOWN"],
    "tora_reach": ["PROVED"],
    "attitude": ["UNKNOWN"],
    "cart_pole": ["UNKNOWN"],
}


@pytest.mark.parametrize("name", STARTS)
def test_all_is_proved_from_the_specified_starts(name):
    told = json.loads((PLACE / name / "report.json").read_text())
    assert {each["verdict"] for each in told["results"]} == {"PROVED"}
    assert {key: tuple(ends) for key, ends in told["start"]["box"].items()} == STARTS[name]
    assert not told["start"]["conditions"] and (told["dt"], told["steps"]) == HORIZONS[name]
    assert (PLACE / name / "world.toml").read_text() == (PLACE / f"{name}.toml").read_text()
    assert (PLACE / name / "profile.json").read_text() == (PLACE / f"{name}.json").read_text()
    assert statement_of((PLACE / f"{name}.toml").read_text(), name).system.flow is not None


@pytest.mark.parametrize("name", [x if x in QUICK else pytest.param(x, marks=pytest.mark.slow) for x in STARTS])
def test_the_checker_accepts_every_certificate(name):
    found = sorted((PLACE / name).glob("certificate-*.json"))
    assert len(found) == len(json.loads((PLACE / name / "report.json").read_text())["results"])
    for path in found:
        assert command(["check", str(path)]) == ExitCode.DONE


def test_the_readme_names_every_plant_and_what_the_controls_say():
    text = (PLACE / "README.md").read_text()
    rows = re.findall(r"^\| [\w ]+ \| .* \| PROVED +\| +[\d.]+ \| +[\d.]+ \|", text, re.MULTILINE)
    assert len(rows) == len(STARTS)
    for name in STARTS:
        told = json.loads((PLACE / name / "report.json").read_text())["results"]
        assert [each["shuffled_control"] for each in told] == WEAK.get(name, ["VIOLATED"])


@pytest.mark.parametrize("name", STARTS)
def test_a_rule_is_the_tree_that_was_imported(name):
    """Decisions of a rule and of its profile are the same over random observations, from a seed."""
    path = PLACE / "rules" / f"{RULES.get(name, name)}.py"
    if not path.exists():
        assert name in EXTRACTED
        return
    profile = load(PLACE / f"{name}.json")
    functions: dict[str, object] = {}
    exec(path.read_text(), functions)
    rng = np.random.default_rng(0)
    for policy in profile.agents:
        observations = rng.normal(0, 1, (500, len(policy.features)))
        taken = [policy.actions[number].name for number in act(policy, observations)]
        assert taken == [functions[policy.agent](row) for row in observations.tolist()]


def test_the_tubes_are_small_and_shown():
    drawing = (PLACE / "tubes.svg").read_text()
    assert len(drawing.encode()) < 40_000 and "](tubes.svg)" in (PLACE / "README.md").read_text()
    assert all(f"{name}: " in drawing for name in ("pendulum", "tora_reach", "unicycle"))
