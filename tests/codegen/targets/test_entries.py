"""What stands beside decisions in every language: world states, input checks, constants, tables, types."""

import re
import shutil
import subprocess
import sys
from dataclasses import replace
from enum import IntEnum

import numpy as np
import pytest

from codegen.agreement import readback, selfcheck
from codegen.targets import emit
from codegen.world import RegionSpec
from maviper.worlds import find
from tests.support.games import NAMES, random_profile

pytestmark = pytest.mark.usefixtures("few_completions", "unoptimised")
FEW = 200
STATE = {  # the manual's example: landmark_0 is the goal
    "agent_0.x": 0.5, "agent_0.y": 1.0, "agent_1.y": -0.88, "landmark_0.y": 1.0, "landmark_1.x": 1.0,
    "landmark_1.y": -1.0, "goal.y": 1.0,
}  # fmt: skip


@pytest.fixture(scope="module")
def team():
    """A team that observes sums, signs and truths, and is meant for a region with every kind of bound."""
    profile = random_profile("physical-deception,features=coasting+ahead", depth=3)
    box = {"agent_0.x": ("-0.5", "1/3"), "agent_0.y": ("-2", "2")}
    differences = {"agent_0.x - landmark_0.x": ("-0.75", "0.75")}
    return replace(profile, region=RegionSpec(profile.world.goals, box, differences, {"agent_1 - landmark_1": "0.1"}))


def differing(profile, target, ending, old, new):
    """The targets that differ once a text of the code is another."""
    files = emit(profile, [target])
    (name,) = [each for each in files if each.endswith(ending)]
    assert old in files[name], old
    report = selfcheck.check_files(profile, files | {name: files[name].replace(old, new, 1)}, random=FEW)
    return {item.target for item in report.agreements if item.differences}


@pytest.mark.parametrize(
    ("target", "ending", "tool"),
    [("python", ".py", sys.executable), ("javascript", ".mjs", "node"), ("rust", ".rs", "rustc")],
)
def test_every_language_has_what_c_has(target, ending, tool, team):
    if shutil.which(tool) is None:
        pytest.skip(f"{tool} is not installed")
    report = selfcheck.check_files(team, emit(team, [target]), random=FEW).ensure()
    found = {item.target.removeprefix(f"{target} ") for item in report.agreements}
    assert found >= {"constants", "observe", "world", "team from world states"}
    assert found >= {"range input check", "region input check"} and not report.skipped


PYTHON, JAVASCRIPT = ("python", ".py"), ("javascript", ".mjs")


@pytest.mark.parametrize(
    ("where", "old", "new", "caught"),
    [
        (PYTHON, 'array("f", values).tolist()', "list(values)", "observe"),
        (PYTHON, "w[10] - w[2]", "w[2] - w[10]", "observe"),
        (PYTHON, "DT = 0.1", "DT = 0.10000000000000002", "constants"),
        (PYTHON, "DOWN = 3", "DOWN = 4", "constants"),
        (PYTHON, "goal.x - agent_0.x", "goal.x - agent_1.x", "constants"),
        (PYTHON, "(0.0, -1.0), (0.0, 1.0)", "(0.0, 1.0), (0.0, -1.0)", "constants"),
        (PYTHON, "low <= value <= high", "low < value <= high", "range input check"),
        (PYTHON, "isfinite(value)", "value == value", "range input check"),
        (PYTHON, "-0.5 <= w[2]", "-0.5 < w[2]", "region input check"),
        (PYTHON, "[act_world_adversary_0(w), act_", "[act_world_agent_0(w), act_", "team from world states"),
        (PYTHON, '_numbers("a world state has", 18, w)', "(list(w) + [0.0] * 18)[:18]", "world input check"),
        (JAVASCRIPT, "return Float32Array.of(", "return Array.of(", "observe"),
        (JAVASCRIPT, "const DAMPING = 0.25", "const DAMPING = 0.75", "constants"),
        (JAVASCRIPT, "Math.fround(x[place]) >= low", "x[place] > low", "range input check"),
        (JAVASCRIPT, '  "agent_0": act_agent_0_rows', '  "agent_0": act_agent_1_rows', "rows"),
    ],
)
def test_a_wrong_entry_is_caught(where, old, new, caught, team):
    if where is JAVASCRIPT and shutil.which("node") is None:
        pytest.skip("node is not installed")
    assert f"{where[0]} {caught}" in differing(team, *where, old, new)


@pytest.mark.parametrize(
    ("name", "old", "new"),
    [
        ("predator-prey", "1.0 if value > 0 else", "1.0 if value >= 0 else"),
        ("predator-prey,observation=released,predators=3", "> 0 else 0.0", ">= 0 else 0.0"),
    ],
)
def test_a_wrong_function_of_a_sum_is_caught(name, old, new):
    assert "python observe" in differing(random_profile(name, depth=3), *PYTHON, old, new)


@pytest.mark.compile
@pytest.mark.usefixtures("unoptimised")
def test_a_wrong_entry_of_c_is_caught(team):
    c = ("c", ".h")
    assert "c constants" in differing(team, *c, "_FORCE 5.0", "_FORCE 4.0")
    assert "c observe" in differing(team, *c, "_W_GOAL_X], -w[", "_W_GOAL_Y], -w[")
    used = differing(team, *c, "x[0] =", "x[0] = 0.0f * (float)PHYSICAL_DECEPTION_DT;\n    x[0] =")
    assert "c structure" in used, "a number that the code uses is not read by the structural proof"


def test_a_state_is_observed_as_the_manual_says(team):
    module = readback.load_python(emit(team, ["python"])["physical_deception.py"])
    state = [STATE.get(name, 0.0) for name in module["COORDINATES"]]
    seen = dict(zip(module["FEATURES"]["agent_0"], module["observe_agent_0"](state), strict=True))
    wanted = {"goal_dx": -0.5, "goal_dy": 0.0, "landmark_1_dx": 0.5, "landmark_1_dy": -2.0, "adversary_0_dx": -0.5}
    assert {name: seen[name] for name in wanted} == wanted
    assert seen["agent_1_dy"] == float(np.float32(-1.88)) != -1.88, "rounded to float32"
    assert module["act_team"](state) == [act(state) for act in module["ACT_WORLD"].values()]
    assert module["act_world_agent_0"](np.array(state)) == module["act_agent_0"](module["observe_agent_0"](state))
    with pytest.raises(ValueError, match=r"^a world state has 18 numbers, given 17$"):
        module["act_team"](state[1:])
    with pytest.raises(TypeError, match=r"^a world state is of numbers, not of str"):
        module["observe_agent_0"](["0.5", *state[1:]])


def test_actions_have_names(team):
    module = readback.load_python(emit(team, ["python"])["physical_deception.py"])
    actions = module["Action_agent_0"]
    assert issubclass(actions, IntEnum) and [each.name.lower() for each in actions] == [*module["ACTIONS"]["agent_0"]]
    world = find("physical-deception")
    assert module["EFFECTS"]["agent_0"][actions.LEFT] == (-1.0, 0.0) and module["DT"] == world.spec.dt
    assert module["FORCE"]["agent_0"] == world.spec.agents[1].force


def test_the_header_says_what_it_reads():
    (header,) = emit(random_profile(NAMES[1]), ["c"]).values()
    assert "_W_AGENT_0_VX = " in header and "_DT 0.1\n" in header and "_DAMPING 0.25\n" in header
    (header,) = emit(random_profile("physical-deception"), ["c"]).values()
    lines = {found[1]: found[0] for found in re.finditer(r"^    \w+_W_(\w+) = .*$", header, re.MULTILINE)}
    assert lines["GOAL_X"].endswith("/* read by agent_0, agent_1 */")
    assert lines["ADVERSARY_0_VX"].endswith("/* not read */")


@pytest.mark.slow
@pytest.mark.parametrize("tool", ["pyright", "mypy"])
def test_the_module_has_types_that_strict_checkers_accept(tool, team, tmp_path):
    file = tmp_path / "physical_deception.py"
    file.write_text("# pyright: strict\n" + emit(team, ["python"])["physical_deception.py"])
    options = {"pyright": ["--pythonpath", sys.executable], "mypy": ["--strict", "--cache-dir", str(tmp_path / "kept")]}
    command = [sys.executable, "-m", tool, *options[tool], file.name]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    file.write_text(file.read_text() + '\nact_agent_0("x", 1)\n')
    assert subprocess.run(command, cwd=tmp_path, capture_output=True, check=False).returncode != 0
