"""The command `maviper repair`: what it writes, says and refuses; by the claims of a world file what holds then is told
by a search of our own.
"""

import json
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

import maviper
from codegen import policy_json
from codegen.dynamics import motionless
from codegen.errors import InputError
from codegen.policy_json import content_hash, dumps
from codegen.profiles import loads
from maviper import load
from maviper.answers import Guarded
from maviper.cli import main
from tests.support.small import small_profile
from tests.support.system_cases import policy
from tests.support.system_cases import team as team_of
from tests.support.systems import TANK
from tests.support.teams import DOWN, STAY, UP, team, towards, tree

pytestmark = pytest.mark.solver


def written(place, profile):
    place.mkdir(exist_ok=True)
    path = place / "team.json"
    path.write_text(policy_json.dumps(profile))
    return path


def repaired(folder, profile, *more):
    return main.run(["repair", str(written(folder, profile)), *more, "-o", str(folder / "out")])


@pytest.fixture(scope="module")
def before():
    return team(small_profile(), towards(0, 0), tree((5, 0.4, 1, 2), DOWN, UP))


def test_profile_certificate_report_and_costs_are_written(before, tmp_path, capsys):
    out = tmp_path / "out"
    assert repaired(tmp_path, before, "--max-depth", "4", "--episodes", "50") == 0
    said = "".join(capsys.readouterr())
    assert "agent_0 for landmark_" in said and "PROVED" in said
    assert main.run(["check", str(out / "certificate-1-distinct_targets.json")]) == 0
    after, cost = load(out / "profile.json"), json.loads((out / "repair.json").read_text())
    assert after.provenance.training["profile before repair"] == cost["profile_before"] == content_hash(before)
    assert after.provenance.training["repair"] == "distinct_targets of the defenders, region start"
    assert not after.provenance.evaluation, "measures of the trees before say nothing about these"
    assert cost["profile"] == content_hash(after) and cost["opponents"] == "the profile's own trees"
    assert cost["trees"]["agent_1"]["before"] == {"leaves": 2, "depth": 1}
    region = cost["changed"]["region"]
    assert region["low"] - 0.01 < float(Fraction(region["exact"].strip('"'))) < region["high"] + 0.01
    assert 0 < region["share"] < 0.5 and cost["changed"]["met"]["samples"] == 50 * 25
    assert {row["episodes"] for row in cost["measures"]} == {50}
    for row in cost["measures"]:
        assert abs(row["after"]["value"] - row["before"]["value"] - row["difference"]["value"]) < 3e-6
    assert "--max-depth 4" in cost["command"]
    assert (out / "report.html").exists()


def test_a_team_that_is_proved_is_written_as_it_is(tmp_path, capsys):
    roles = team(small_profile(), towards(0, 0), towards(1, 1))
    assert repaired(tmp_path, roles, "--episodes", "10") == 0
    assert "nothing: no state of the region violates" in capsys.readouterr().err
    assert (tmp_path / "out" / "profile.json").read_text() == policy_json.dumps(roles)


def test_no_repair_exits_with_3_and_writes_nothing(before, tmp_path, capsys):
    still = team(before, tree(STAY), tree(STAY))
    assert repaired(tmp_path, still, "--claim", "distinct_targets(radius=0)") == 3
    assert "no guard keeps agent_" in capsys.readouterr().err and not (tmp_path / "out").exists()


def test_a_repair_beyond_the_depth_exits_with_1(before, tmp_path, capsys):
    assert repaired(tmp_path, before, "--max-depth", "1", "--episodes", "10") == 1
    said = "".join(capsys.readouterr())
    assert "too deep" in said and "more than the 1 asked for" in said and "PROVED" in said


def test_a_world_that_cannot_be_played_is_repaired_without_measures(before, tmp_path):
    strange = replace(before, world=replace(before.world, name="elsewhere"))
    region = tmp_path / "near.toml"
    region.write_text('goals = ["landmark_0"]\n')
    out = tmp_path / "out"
    assert repaired(tmp_path, strange, "--claim", "own_target", "--region", str(region)) in (0, 3)
    cost = json.loads((out / "repair.json").read_text())
    assert cost["changed"]["met"] is None and cost["measures"] == [] and "no built-in game has" in cost["opponents"]
    assert cost["property"] == "own_target" and (out / "near.toml").exists()
    assert loads((out / "profile.json").read_text()).world.name == "elsewhere"


@pytest.mark.parametrize(
    "wrong, what",
    [
        (["--episodes", "0"], "the number of episodes"),
        (["--max-depth", "0"], "the depth must be"),
        (["--claim", "no_double"], "no_double cannot be repaired"),
        (["--claim", "distinct_target"], "distinct_targets"),
        (["--landmarks", "landmark_0,landmark_1"], "--landmarks"),
    ],
)
def test_wrong_options_are_input_errors(before, tmp_path, capsys, wrong, what):
    assert repaired(tmp_path, before, *wrong) == 2
    assert what in capsys.readouterr().err


FILE = """[[claim]]
name = "distinct_targets"
[[claim]]
name = "own_target"
radius = "1/5"
region = { box = { "agent_0.y" = [-1, -0.5], "landmark_0.y" = [0.5, 1] } }
[[claim]]
label = "OTHER"
formula = "FORMULA"
"""


def test_all_claims_of_a_file_are_proved(before, tmp_path, capsys):
    file, out = tmp_path / "claims.toml", tmp_path / "out"
    away = "not (agent_0.y < -0.9 and landmark_0.y > 0.9) or not acts(agent_0) == down"
    file.write_text(FILE.replace("FORMULA", away).replace("OTHER", "not away"))
    assert repaired(tmp_path, before, "--claim", str(file), "--episodes", "10") == 0
    assert "PROVED      not away" in "".join(capsys.readouterr())
    assert len(list(out.glob("certificate-*.json"))) == 3
    for certificate in out.glob("certificate-*.json"):
        assert main.run(["check", str(certificate)]) == 0
    told = json.loads((out / "repair.json").read_text())
    assert [each["property"] for each in told["claims"]] == ["distinct_targets", "own_target", "formula"]
    assert f"--claim {file.name} --region start" in told["command"]
    after = load(out / "profile.json")
    assert after.provenance.training["repair"] == "the claims of claims.toml"
    assert [str(each.verdict) for each in maviper.verify_file(after, file)] == ["PROVED"] * 3


@pytest.mark.parametrize(
    "formula, told",
    [
        ("not acts(agent_1) == up", "is VIOLATED without guards and VIOLATED with them; only distinct_targets and"),
        ("not acts(agent_1) == right", "OTHER is PROVED without guards and VIOLATED with them"),
    ],
)
def test_a_repair_that_breaks_another_claim_of_its_file_is_none(before, tmp_path, capsys, formula, told):
    file = tmp_path / "claims.toml"
    file.write_text(FILE.replace("FORMULA", formula))
    assert repaired(tmp_path, before, "--claim", str(file), "--episodes", "10") == 3
    assert told in capsys.readouterr().err and not (tmp_path / "out").exists()


def test_what_a_file_of_claims_cannot_have_repaired_is_refused(before, tmp_path):
    file = tmp_path / "claims.toml"
    file.write_text('[[claim]]\nname = "no_double"\n')
    with pytest.raises(InputError, match="no_double cannot be repaired"):
        maviper.repair(before, file)
    with pytest.raises(InputError, match="radius has no effect with a file of claims"):
        maviper.repair(before, file, radius=0.2)


def test_one_episode_bounds_nothing_and_is_written(before, tmp_path):
    assert repaired(tmp_path, before, "--episodes", "1") == 0
    cost = json.loads((tmp_path / "out" / "repair.json").read_text())
    assert all(one["difference"]["low"] is None for one in cost["measures"])


WORLD = TANK + '[[claim]]\nname = "always"\nregion = { box = { level = [2, 8] } }\n'
KEEP, DRAIN, FILL = range(3)


def valve(tree):
    own = policy("valve", ["gap"], ["keep", "drain", "fill"], tree)
    return replace(team_of(own), world=motionless("stated", "", ("valve",), 10, {}))


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
