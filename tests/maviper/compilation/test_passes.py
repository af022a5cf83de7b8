"""Passes from the command line: fewer leaves, fewer tests, the same decisions; a region as part of the contract."""

import json
from dataclasses import replace

import pytest
from click.testing import CliRunner

from codegen.errors import InputError, UnknownNameError
from codegen.lowering import passes
from codegen.policy_json import content_hash, dumps
from codegen.profiles import ensure, loads
from maviper.cli.main import cli
from maviper.compilation import compile
from maviper.compilation.passes import run_passes
from maviper.episodes.trees import on_policy
from maviper.worlds.matching import matching_world
from tests.support.teams import DOWN, LEFT, RIGHT, UP, average_tests, team, tree
from verify.claims.region_files import read_region
from verify.states.state import sample

pytestmark = pytest.mark.usefixtures("few_observations")
TEXT = """
goals = ["landmark_0"]
[box]
"agent_0.x" = [0.25, 1]
"landmark_0.x" = [-1, 0]
"""
# node 0: landmark_0_dx <= 0 always holds in the region above; node 4: both sides decide alike
WIDE = tree((2, 0.0, 1, 4), (3, 0.0, 2, 3), DOWN, UP, (5, 0.5, 5, 6), RIGHT, RIGHT)


@pytest.fixture
def wide(profile):
    return team(profile, WIDE, tree((8, 0.0, 1, 2), LEFT, RIGHT))


@pytest.fixture
def region(tmp_path):
    path = tmp_path / "near.toml"
    path.write_text(TEXT)
    return str(path)


def test_merging_and_reordering_keep_the_profile_and_say_what_they_did(wide):
    found = run_passes(wide, ["reorder", "merge"])
    assert [note.split(":")[0] for note in found.notes] == ["merge", "reorder"]
    assert "agent_0 4 to 3 leaves" in found.notes[0]
    assert found.profile.provenance.training["passes"] == "merge, reorder"
    assert found.profile.provenance.training["profile before passes"] == content_hash(wide)
    for old, new in zip(wide.agents, found.profile.agents, strict=True):
        assert passes.difference(old.tree, new.tree, len(old.features)) is None
    ensure(found.profile)


@pytest.mark.solver
def test_what_no_state_of_the_region_reaches_is_dropped_and_nothing_else(wide, region):
    found = run_passes(wide, ["drop", "merge"], region)
    kept = found.profile.policy("agent_0").tree
    assert kept.feature.tolist() == [3, -1, -1] and kept.action.tolist() == [-1, DOWN, UP]
    assert loads(dumps(found.profile)).region == found.profile.region
    states, _ = sample(read_region(TEXT, wide.world, "near.toml"), wide.world, 20_000, 0)
    from verify.states.state import choose_actions

    for old, new in zip(wide.agents, found.profile.agents, strict=True):
        assert (choose_actions(old, states, wide.world) == choose_actions(new, states, wide.world)).all()
    assert compile.compile_profile(found.profile).complete


@pytest.mark.solver
@pytest.mark.compile
def test_the_command_writes_the_code_of_the_smaller_trees(wide, region, tmp_path):
    (tmp_path / "wide.json").write_text(dumps(wide))
    words = ["compile", str(tmp_path / "wide.json"), "--pass", "drop,merge,reorder", "--region", region]
    ran = CliRunner().invoke(cli, [*words, "-o", str(tmp_path / "code")], standalone_mode=False)
    assert ran.return_value == 0, ran.output
    written = loads((tmp_path / "code/physical_deception.json").read_text())
    assert written.region is not None and written.region.box["agent_0.x"] == ("0.25", "1")
    header = (tmp_path / "code/physical_deception.h").read_text()
    assert "physical_deception_in_region" in header and content_hash(written) in header
    evidence = json.loads((tmp_path / "code/physical_deception.agreement.json").read_text())
    assert "c region input check" in {row["target"] for row in evidence["agreement"]}


def test_fractions_of_a_region_become_part_of_the_contract(wide, tmp_path):
    path = tmp_path / "thirds.toml"
    path.write_text('[box]\n"agent_0.x" = ["-1/3", 1]\n[apart]\n"agent_0 - agent_1" = "1/7"\n')
    spec = run_passes(wide, ["drop"], str(path)).profile.region
    assert spec is not None and spec.box["agent_0.x"] == ("-1/3", "1") and spec.apart == {"agent_0 - agent_1": "1/7"}


@pytest.mark.compile
def test_a_region_may_fix_a_coordinate(wide, tmp_path):
    """At 0, where the upper bound may be written -0."""
    path = tmp_path / "fixed.toml"
    path.write_text('[box]\n"agent_0.x" = [0, 0]\n"landmark_1.y" = [0.25, 0.25]\n')
    found = run_passes(wide, ["drop"], str(path)).profile
    assert compile.compile_profile(found).complete


def test_bad_requests_are_told(wide, tmp_path, profile):
    with pytest.raises(UnknownNameError, match="reorder"):
        run_passes(wide, ["reoder"])
    with pytest.raises(InputError, match="needs a region"):
        run_passes(wide, ["drop"])
    with pytest.raises(InputError, match="is only for the pass drop"):
        run_passes(wide, ["merge"], "start")
    empty = tmp_path / "empty.toml"
    empty.write_text('[difference]\n"agent_0.x - agent_1.x" = [3, 4]\n')
    with pytest.raises(InputError, match="contains no state"):
        run_passes(wide, ["drop"], str(empty))
    thin = tmp_path / "thin.toml"
    thin.write_text('[box]\n"agent_0.x" = ["1/3", "1/3"]\n')
    with pytest.raises(InputError, match="no double") as raised:
        run_passes(wide, ["drop"], str(thin))
    assert raised.value.where == "--region: box.agent_0.x"
    elsewhere = replace(wide, world=replace(wide.world, dt=0.2))
    with pytest.raises(InputError, match="on-policy"):
        run_passes(elsewhere, ["reorder"])


def test_reordering_the_shipped_trees_asks_fewer_tests(profile):
    world = matching_world(profile)
    seen = on_policy(profile, world).observations
    found = run_passes(profile, ["merge", "reorder"]).profile
    for old, new, rows in zip(profile.agents, found.agents, seen, strict=True):
        rows = rows.reshape(-1, rows.shape[-1])
        assert average_tests(new.tree, rows) <= average_tests(old.tree, rows)


@pytest.mark.solver
def test_a_profile_for_a_region_is_not_given_another(wide, region):
    """Trees that were cut for one region may act otherwise in a larger one."""
    once = run_passes(wide, ["drop"], region).profile
    with pytest.raises(InputError, match="already has a region"):
        run_passes(once, ["drop"], "start")
