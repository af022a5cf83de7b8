"""With `--json` standard output is one JSON value and nothing else, whatever the libraries below print."""

import json
import subprocess
import sys
from pathlib import Path

import click
import pytest

from codegen import policy_json
from maviper.cli import main
from tests.support.observations import far
from tests.support.stated import BRAKES, PROPERTIES, profile
from tests.support.systems import CART
from tests.support.verifying import every_command


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    folder = tmp_path_factory.mktemp("json")
    (folder / "cart.json").write_text(profile(BRAKES))
    (folder / "cart.toml").write_text(CART + PROPERTIES)
    (folder / "a.json").write_text(policy_json.dumps(far(30.0, 1)))
    (folder / "b.json").write_text(policy_json.dumps(far(40.0, 1)))
    (folder / "seen.csv").write_text("gap\n35\n")
    (folder / "rules.py").write_text("def cart(x):\n    return 'left' if x[0] > 0.5 else 'right'\n")
    return folder


TEAM = Path(__file__).parents[3] / "generated" / "physical_deception" / "profile.json"
FEW = "--set selection_episodes=4 --refinement-episodes 0 --max-depth 2 --held-out 4 --iterations 1 --rollouts 2"
MARKED = {"train": pytest.mark.train}
ASKED = {  # every command
    "demo": "demo -o demo --json",
    "guide": "guide claims --json",
    "show": f"show {TEAM} --json",
    "play": f"play {TEAM} -o page.html --json",
    "train": "train cooperative-navigation -o run --steps 25600 --json",
    "reproduce": "reproduce --plan -o reproduced --json",
    "worlds new": "worlds new new.toml --json",
    "extract": f"extract physical-deception -o small.json --critic none {FEW} --json",
    "import": "import rules.py -o rules.json --json",
    "edit": f"edit {TEAM} agent_0/0=0.3 -o edited.json --json",
    "evaluate": f"evaluate {TEAM} --episodes 4 --json",
    "compare": "compare physical-deception --algorithms imitation --depths 2 --max-episodes 40 -o many --json",
    "compile": f"compile {TEAM} --target python,json -o code --json",
    "verify": "verify a.json --observations --claim alive_leaves --json",
    "check": f"check {TEAM.parent}/certificate-1-distinct_targets.json --json",
    "replay": f"replay {TEAM.parent}/extracted/counterexample-1-distinct_targets.json --json",
    "repair": f"repair {TEAM.parent}/extracted/profile.json --episodes 4 -o fixed --json",
    "diff": "diff a.json b.json --json",
    "evaluate --exploit": f"evaluate {TEAM} --exploit defenders --set refinement_episodes=0 --episodes 4 --json",
    "verify robust": "verify a.json --claim robust(observations=seen.csv) --json",
    "verify --list": "verify --list --json",
    "worlds list": "worlds list --json",
    "worlds show": "worlds show physical-deception --json",
    "worlds check": "worlds check physical-deception --json",
}


def test_every_command_is_asked():
    assert {*ASKED} >= {" ".join(path) for path, command in every_command() if not isinstance(command, click.Group)}


@pytest.mark.parametrize(
    "asked", [pytest.param(line, id=name, marks=MARKED.get(name, ())) for name, line in ASKED.items()]
)
def test_every_result_is_json_alone(asked, place, monkeypatch, capsys):
    monkeypatch.chdir(place)
    monkeypatch.setattr("webbrowser.open", lambda _: True)
    assert main.run(asked.split()) in (0, 1, 3)
    assert json.loads(capsys.readouterr().out)


@pytest.mark.parametrize(
    "asked",
    [
        "verify cart.json --system cart.toml --json",
        "verify cart.json --system cart.toml --json --verdict-only",
        "verify a.json --observations --claim alive_leaves --json",
        "diff a.json b.json --json",
        "verify a.json --claim robust(observations=seen.csv) --json",
    ],
)
def test_standard_output_is_json_alone(asked, place):
    """A process of its own: some libraries write past Python, and only once."""
    command = [sys.executable, "-m", "maviper", *asked.split()]
    done = subprocess.run(command, cwd=place, capture_output=True, text=True, timeout=120)
    assert done.returncode in (0, 1, 3), done.stderr
    assert json.loads(done.stdout)
