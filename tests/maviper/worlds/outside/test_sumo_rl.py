"""sumo-rl's own environment with its default observation, by our door, in an interpreter that has it.

sumo-rl 1.4 needs PettingZoo 1.24, which the others do not, so it has an environment of its own:
`python3 -m venv E && E/bin/pip install -e '.[dev,signals]' pettingzoo==1.24.3`.
"""

import json
import os
import subprocess
import sys
from importlib import metadata
from importlib.util import find_spec

import pytest

THEIRS = """
import os
from pathlib import Path

import sumo

os.environ.setdefault("SUMO_HOME", sumo.SUMO_HOME)
import sumo_rl

PLACE = Path(sumo_rl.__file__).parent / "nets" / "RESCO" / "cologne1"


def make():
    files = {"net_file": str(PLACE / "cologne1.net.xml"), "route_file": str(PLACE / "cologne1.rou.xml")}
    return sumo_rl.parallel_env(**files, begin_time=25200, num_seconds=100, reward_fn="queue")


def act(agent, seen):
    return (seen[:, -1] > 0.5).astype(int)
"""


def lacks():
    """Why it cannot be tried here; empty where it can."""
    if find_spec("sumo_rl") is None or find_spec("libsumo") is None:
        return "the extra maviper[signals]"
    found = metadata.version("pettingzoo")
    return "" if found.startswith("1.24.") else f"sumo-rl needs PettingZoo 1.24, and {found} is here"


@pytest.mark.nightly
@pytest.mark.skipif(bool(lacks()), reason=lacks())
@pytest.mark.parametrize("door", ["libsumo", "TraCI"])
def test_its_environment_is_checked_played_and_taught_with_nothing_but_results_on_stdout(door, tmp_path):
    (tmp_path / "theirs.py").write_text(THEIRS)
    environment = {name: value for name, value in os.environ.items() if name != "LIBSUMO_AS_TRACI"}
    environment |= {"LIBSUMO_AS_TRACI": "1"} if door == "libsumo" else {}

    def run(*words):
        command = [sys.executable, "-m", "maviper", *words]
        return subprocess.run(command, cwd=tmp_path, env=environment, check=True, capture_output=True, text=True).stdout

    told = run("worlds", "check", "theirs:make")
    assert "ok       play: a random episode, all agents done after step 20" in told and "fresh copy" in told
    found = json.loads(run("evaluate", "random", "--world", "theirs:make", "--episodes", "2", "--json"))
    assert found["episodes"] == 2
    few = ("--max-episodes", "24", "--max-depth", "2")
    run("extract", "theirs:act", "--world", "theirs:make", "--critic", "none", *few, "-o", "trees.json")
    assert (tmp_path / "trees.json").exists()
