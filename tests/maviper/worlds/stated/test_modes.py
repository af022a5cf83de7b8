"""Modes and choices in play: what is drawn, what is observed, and what a report and a replay say of a choice."""

import json
from dataclasses import replace

from codegen.errors import ExitCode
from codegen.ir import EntitySpec
from codegen.policy_json import dumps
from maviper.cli.main import run as command
from maviper.worlds.stated.environment import StatedEnv
from tests.support.system_cases import policy, team
from tests.support.systems import CASES, HEATER, read

CLAIM = '\n[[property]]\nlabel = "warm"\nname = "stays_in"\nregion = { box = { x = [-4, 4] } }\n'


def test_play_draws_choices_and_observes_modes():
    env = StatedEnv(read(HEATER + CASES), "heater")
    space = env.observation_space("a")
    assert space.low.tolist() == [-50, 0, 0] and space.high.tolist() == [50, 1, 2]
    steps = set()
    for seed in range(6):
        (seen,) = env.reset(seed)[0].values()
        assert seen[1:].tolist() == [0, 0]
        while env.agents:
            before = env.state["x"]
            observed, *_ = env.step({"a": 0})
            steps.add(round(env.state["x"] - before, 9))
            assert observed["a"][1:].tolist() == [0, 0]
    assert steps == {-1, 1}
    env.reset(0)
    observed, *_ = env.step({"a": 1})
    assert observed["a"][1:].tolist() == [1, 2] and env.state["heat"] == 2


def test_a_counterexample_says_what_was_chosen_and_replays(tmp_path, capsys):
    world, profile, report = (tmp_path / name for name in ("heater.toml", "heater.json", "report"))
    world.write_text(HEATER + CASES + CLAIM)
    cools = team(policy("a", ["x", "high", "number"], ["off", "high"], 0))
    agent = EntitySpec("a", 0.0, 0.0, None, False)
    cools = replace(cools, world=replace(cools.world, agents=(agent,)))
    profile.write_text(dumps(cools))
    assert command(["verify", str(profile), "--system", str(world), "-o", str(report)]) == ExitCode.VIOLATED
    assert "choice of noise: " in capsys.readouterr().out
    told = json.loads((report / "report.json").read_text())
    (found,) = (each["counterexample"] for each in told["results"])
    assert set(found["choices"]["noise"]) <= {"-1[K]", "1[K]"} and len(found["choices"]["noise"]) == found["step"]
    assert [each["modes"] for each in told["variables"] if "modes" in each] == [["off", "low", "high"]]
    assert "choice of noise" in (report / "report.html").read_text()
    assert "off, low, high" in (report / "report.txt").read_text()
    assert (report / "counterexample-1-stays_in.csv").read_text().splitlines()[0] == "step,x,heat,a.action,noise"
    assert command(["replay", str(report / "counterexample-1-stays_in.json")]) == ExitCode.VIOLATED
