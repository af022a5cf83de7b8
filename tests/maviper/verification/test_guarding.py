"""Repair by the claims of a world file: what holds then, told by a search of our own, and what is refused."""

import json
from dataclasses import replace

import numpy as np
import pytest

import maviper
from codegen.dynamics import motionless
from codegen.errors import InputError
from codegen.policy_json import dumps
from maviper.answers import Guarded
from maviper.cli import main
from tests.support.system_cases import policy, team

WORLD = """
name = "tank"
steps = 20
[variables]
level = { unit = "m", range = [-100, 100] }
[agents.valve.features]
gap = "10[m] - level"
[agents.valve.actions]
keep = { flow = 0 }
drain = { flow = -1 }
fill = { flow = 1 }
[start]
box = { level = [4, 6] }
[dynamics.next]
level = "level + valve.flow*1[m]"
[[claim]]
name = "always"
region = { box = { level = [2, 8] } }
"""
KEEP, DRAIN, FILL = range(3)


def valve(tree):
    own = policy("valve", ["gap"], ["keep", "drain", "fill"], tree)
    return replace(team(own), world=motionless("stated", "", ("valve",), 10, {}))


def repair(before, world):
    done = maviper.repair(before, world)
    assert isinstance(done, Guarded)
    return done


@pytest.fixture
def world(tmp_path):
    path = tmp_path / "tank.toml"
    path.write_text(WORLD)
    return path


@pytest.mark.parametrize(
    ("tree", "guards"),
    [(FILL, [("gap", False, 5.0, "drain")]), (DRAIN, [("gap", True, 5.0, "fill")]), (((0, 3.5), DRAIN, KEEP), [])],
)
def test_a_level_stays_within_its_bounds(world, tree, guards):
    before = valve(tree)
    done = repair(before, world)
    assert done.after is not None
    assert [guard[1:] for guard in done.guards] == guards and not done.reason
    for start in range(40, 61):
        level = start / 10
        for _ in range(50):
            (action,) = done.after.policy("valve").act([np.array([10 - level], np.float32)])
            level += {KEEP: 0, DRAIN: -1, FILL: 1}[int(action)]
            assert 2 <= level <= 8
    if not guards:
        assert dumps(done.after) == dumps(before)


def test_what_is_written_is_accepted_and_says_what_changed(world, tmp_path, capsys):
    profile, out = tmp_path / "valve.json", tmp_path / "out"
    profile.write_text(dumps(valve(FILL)))
    asked = ["repair", str(profile), "--claim", str(world), "-o", str(out)]
    assert main.run(asked) == 0
    assert "valve: gap <= 5 -> drain" in capsys.readouterr().err
    told = json.loads((out / "repair.json").read_text())
    assert told["guards"][0]["action"] == "drain" and told["trees"]["valve"]["after"] == {"leaves": 2, "depth": 1}
    after = maviper.load(out / "profile.json")
    assert after.provenance.training["profile before repair"] == told["profile_before"]
    assert main.run(["check", str(out / "certificate-1-always.json")]) == 0
    assert main.run(["repair", str(out / "profile.json"), "--claim", str(world), "-o", str(tmp_path / "again")]) == 0
    assert "each claim holds as it is" in capsys.readouterr().err
    assert (tmp_path / "again" / "profile.json").read_text() == (out / "profile.json").read_text()
    assert main.run([*asked, "--max-depth", "3"]) == 2
    assert "--max-depth has no effect with a world file" in capsys.readouterr().err
    (tmp_path / "claims.toml").write_text('[[claim]]\nname = "distinct_targets"\n')
    with pytest.raises(InputError, match="a repair takes no file of claims"):
        maviper.repair(after, tmp_path / "claims.toml")


def test_where_no_guard_helps_nothing_is_written(world, tmp_path, capsys):
    profile, out = tmp_path / "valve.json", tmp_path / "out"
    profile.write_text(dumps(valve(FILL)))
    world.write_text(WORLD.replace('"level + valve', '"level + 2[m] + valve'))
    assert main.run(["repair", str(profile), "--claim", str(world), "-o", str(out)]) == 3
    assert "no guard of level is early enough" in capsys.readouterr().err and not out.exists()
    world.write_text(WORLD.replace('gap = "10[m] - level"', 'gap = "sign(level)"'))
    assert "no action moves level back" in repair(valve(FILL), world).reason
    world.write_text(WORLD.replace("always", "avoids").replace("[2, 8]", "[7, 8]"))
    assert "no bound of its region" in repair(valve(FILL), world).reason


def test_what_a_world_file_does_not_read_is_refused(world):
    with pytest.raises(InputError, match="region has no effect"):
        maviper.repair(valve(FILL), world, "region.toml")
    with pytest.raises(InputError, match="radius has no effect"):
        maviper.repair(valve(FILL), world, radius=0.2)
