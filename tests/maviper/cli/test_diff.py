"""The command diff: exit codes, what it says and writes, and that `maviper check` accepts the proof."""

import json
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

from codegen import ir
from codegen.errors import ExitCode
from codegen.policy_json import dumps
from maviper.cli.main import run as command
from maviper.page.page import compared_page_of
from maviper.verification.diff import compare_profiles, request
from tests.maviper.page.browsers import in_chromium, in_node
from tests.support.pages import STATE, starts
from verify.result import Verdict

pytestmark = pytest.mark.solver


def with_other_leaf(profile, agent="agent_0"):
    """The profile with the same action at every leaf of an agent but one."""
    policy = profile.policy(agent)
    action = policy.tree.action.copy()
    leaf = ir.leaves(policy.tree)[0]
    action[leaf] = (action[leaf] + 1) % len(policy.actions)
    agents = tuple(
        replace(one, tree=replace(one.tree, action=action), grown=None) if one.agent == agent else one
        for one in profile.agents
    )
    return replace(profile, agents=agents)


@pytest.fixture(scope="module")
def files(profile, tmp_path_factory):
    """Paths of a profile, a twin with another seed, and one with another leaf."""
    folder = tmp_path_factory.mktemp("diff")
    twin = replace(profile, provenance=replace(profile.provenance, seed=profile.provenance.seed + 1))
    found = {"first": profile, "twin": twin, "other": with_other_leaf(profile)}
    for name, one in found.items():
        (folder / f"{name}.json").write_text(dumps(one))
    return {name: str(folder / f"{name}.json") for name in found}


def test_equal_policies_are_proved_equal_and_the_proof_is_accepted(files, tmp_path, capsys):
    out = tmp_path / "same"
    assert command(["diff", files["first"], files["twin"], "-o", str(out)]) == ExitCode.DONE
    said = capsys.readouterr().err
    assert said.count("alike ") == 3 and "different" not in said
    assert {path.name for path in out.iterdir()} == {
        ".maviper.json", "against.json", "certificate.json", "difference.json", "play.html", "profile.json",
    }  # fmt: skip
    assert command(["check", str(out / "certificate.json")]) == ExitCode.DONE
    assert "adversary_0, agent_0, agent_1 act as in the second profile in region start" in capsys.readouterr().out
    (out / "against.json").unlink()
    assert command(["check", str(out / "certificate.json"), "--against", files["twin"]]) == ExitCode.DONE
    assert command(["check", str(out / "certificate.json"), "--against", files["other"]]) == ExitCode.INPUT
    assert "--against" in capsys.readouterr().err
    proof = (out / "certificate.json").read_text()
    assert command(["check", str(out / "certificate.json"), "--against", str(out / "nobody.json")]) == ExitCode.INPUT
    assert json.loads(proof)["property"] is None


def test_a_certificate_about_one_profile_takes_no_second(files, capsys):
    path = "generated/proved_defenders/certificate-1-distinct_targets.json"
    assert command(["check", path, "--against", files["first"]]) == ExitCode.INPUT
    assert "about one profile" in capsys.readouterr().err


def test_a_difference_is_told_with_shares_zones_and_examples(files, tmp_path, capsys, profile):
    asked = ["diff", files["first"], files["other"], "--json", "-o", str(tmp_path / "out")]
    assert command(asked) == ExitCode.VIOLATED
    streams = capsys.readouterr()
    facts = json.loads(streams.out)
    assert facts == json.loads((tmp_path / "out" / "difference.json").read_text())
    (one,) = [each for each in facts["agents"] if each["verdict"] == "VIOLATED"]
    assert one["agent"] == "agent_0" and one["complete"] and one["found"] >= len(one["zones"]) > 0
    assert facts["share"]["least"] == facts["share"]["most"] == one["share"]["most"] > 0
    assert abs(facts["uniform"]["share"] - facts["share"]["most"]) < 0.01
    assert facts["met"]["samples"] == 100_000 and all(zone["example"] for zone in one["zones"])
    assert {goal for zone in one["zones"] for goal in zone["goals"]} == set(profile.world.goals)
    assert "different   agent_0:" in streams.err and "exactly" in streams.err and "states met" in streams.err
    assert "e-38" not in streams.err  # what a rule tests against 0 is told so
    assert facts["certificate"]["checker"] == "accepted"  # of the others
    assert command([*asked[:3], "--agent", "agent_1"]) == ExitCode.DONE
    assert command([*asked[:3], "--set", "max_nodes=1"]) == ExitCode.INCONCLUSIVE
    assert "a larger --effort" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("more", "said"),
    [
        (["--agent", "agent_9"], "agent_9"),
        (["--set", "max_nodes=0"], "--set max_nodes"),
        (["--set", "max_cells=0"], "--set max_cells"),
        (["--set", "semantics=other"], "machine or real"),
        (["--region", "nowhere.toml"], "nowhere.toml"),
    ],
)
def test_what_cannot_be_asked_is_said(files, more, said, capsys):
    assert command(["diff", files["first"], files["twin"], *more]) == ExitCode.INPUT
    assert said in capsys.readouterr().err


def test_real_arithmetic_is_said(files, tmp_path, capsys):
    asked = ["diff", files["first"], files["other"], "--agent", "agent_0", "--agent", "agent_1"]
    assert command([*asked, "--set", "semantics=real", "-o", str(tmp_path)]) == ExitCode.VIOLATED
    assert "alike in the whole region in real arithmetic" in (tmp_path / "play.html").read_text()
    said = capsys.readouterr().err
    assert "of region start in real arithmetic, exactly" in said
    assert "the same action in every state of region start in real arithmetic" in said
    assert command(asked) == ExitCode.VIOLATED and "real arithmetic" not in capsys.readouterr().err


def test_bounds_of_a_share_that_are_the_same_float_are_not_exact(profile):
    found = compare_profiles(profile, with_other_leaf(profile), "start", request())
    (place,) = (place for place, one in enumerate(found.found.agents) if one.verdict is Verdict.VIOLATED)
    one = found.found.agents[place]
    failing = (replace(one.failing[0], complete=False), *one.failing[1:])
    share = replace(one.share, least=one.share.region - Fraction(1, 10**30))
    agents = list(found.found.agents)
    agents[place] = replace(one, failing=failing, share=share)
    said = dict(replace(found, found=replace(found.found, agents=tuple(agents))).lines)["different"]
    assert "exactly" not in said and said.startswith(f"{one.agent}: between ")


def test_different_agents_are_an_error_that_says_what_to_do(files, profile, tmp_path, capsys):
    alone = tmp_path / "alone.json"
    alone.write_text(dumps(replace(profile, agents=profile.agents[:2])))
    assert command(["diff", files["first"], str(alone)]) == ExitCode.INPUT
    assert "--agent NAME" in capsys.readouterr().err
    assert command(["diff", files["first"], str(alone), "--agent", "agent_0"]) == ExitCode.DONE


@pytest.mark.parametrize("run", [in_node, in_chromium])
def test_the_page_says_where_the_trees_differ(run, profile, world, tmp_path):
    second = with_other_leaf(profile)
    html = compared_page_of(compare_profiles(profile, second, "start", request()))
    given = list(starts(world, 500))
    script = STATE + "const at = stateIn(game); return given.map((one) => judges.map((judge) => judge(at(...one))));"
    told = np.array(run(html, script, given, tmp_path))
    states = world.start_from_seeds(range(500))
    seen = world.observe(states)
    alike = np.array(
        [
            ir.act(first, rows) == ir.act(other, rows)
            for first, other, rows in zip(profile.agents, second.agents, seen, strict=True)
        ]
    )
    assert (told == np.array([alike.all(axis=0), *alike]).T).all() and not alike.all()
    assert len(html.encode()) < 300_000 and "http://" not in html.replace("http://www.w3.org/2000/svg", "")


RULE = """
def act(temperature, humidity):
    if temperature < 18.5:
        return "heat"
    if temperature > {} and humidity > 60:
        return "cool"
    return "off"
"""


def test_imported_controllers_are_compared_over_all_that_they_may_observe(tmp_path, capsys):
    decide = []
    for name, number in (("a", 24.0), ("b", 24.5)):
        (tmp_path / f"{name}.py").write_text(RULE.format(number))
        assert command(["import", str(tmp_path / f"{name}.py"), "-o", str(tmp_path / f"{name}.json")]) == 0
        exec(RULE.format(number), known := {})
        decide.append(known["act"])
    first, second = (str(tmp_path / f"{name}.json") for name in "ab")
    assert command(["diff", first, first]) == 0
    capsys.readouterr()
    assert command(["diff", first, second, "--json"]) == ExitCode.VIOLATED
    (agent,) = json.loads(capsys.readouterr().out)["agents"]
    (zone,) = agent["zones"]
    assert zone["words"] == ["60 < humidity", "24 < temperature <= 24.5"] and agent["complete"]
    assert [each(**zone["example"]["position"]) for each in decide] == zone["actions"] == ["cool", "off"]
    (tmp_path / "room.toml").write_text("[box]\ntemperature = [-40, 60]\nhumidity = [0, 100]\n")
    assert command(["diff", first, second, "--region", str(tmp_path / "room.toml")]) == ExitCode.VIOLATED
    assert "act: 0.2 % of region" in capsys.readouterr().err  # .5 of 100 degrees, 40 of 100 %


def test_imported_controllers_of_other_names_are_told_the_way_out(tmp_path, capsys):
    for name in ("act", "decide"):
        (tmp_path / f"{name}.py").write_text(RULE.format(24.0).replace("act", name))
        assert command(["import", str(tmp_path / f"{name}.py"), "-o", str(tmp_path / f"{name}.json")]) == 0
    files = [str(tmp_path / "act.json"), str(tmp_path / "decide.json")]
    assert command(["diff", *files]) == ExitCode.INPUT
    assert "maviper import --agents act=FILE" in capsys.readouterr().err
    assert command(["import", "--agents", f"act={tmp_path / 'decide.py'}", "-o", files[1]]) == 0
    assert command(["diff", *files]) == 0
