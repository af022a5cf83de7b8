"""What `verify` and `check` say of claims over observations, where two agents have features of the same names."""

import json
from dataclasses import replace

import numpy as np
import pytest

from codegen import ir
from codegen.policy_json import dumps
from tests.support.observations import blind
from tests.support.verifying import run

pytestmark = pytest.mark.solver
FEATURES = ("feature_0", "feature_1")
CLAIMS = """
[[claim]]
label = "off when high"
formula = "pump_a.feature_0 > 0.5 implies acts(pump_a) == left"

[[claim]]
label = "alike"
formula = "acts(pump_a) == acts(pump_b)"

[[claim]]
label = "on when high"
formula = "pump_a.feature_0 > 0.5 implies acts(pump_a) == stay"
"""


@pytest.fixture
def pumps(tmp_path):
    """Two agents of team pump with the same tree, seen in [-1, 1] of [-2, 2], and claims about them."""
    nodes = [(0, 0.25, 1, 2, -1), (-1, 0, -1, -1, 0), (-1, 0, -1, -1, 1)]
    tree = ir.Tree(*np.array(nodes).T, numbers="float32")
    names = ("pump_a", "pump_b")
    profile = blind(dict.fromkeys(names, tree), dict.fromkeys(names, FEATURES), teams=dict.fromkeys(names, "pump"))
    seen = ((-1.0, -0.5, 0.5, 1.0),) * len(FEATURES)
    agents = tuple(replace(policy, seen=seen) for policy in profile.agents)
    (tmp_path / "pumps.json").write_text(dumps(replace(profile, agents=agents)))
    (tmp_path / "claims.toml").write_text(CLAIMS)
    return tmp_path


def said(capsys, pumps, formula, *options):
    """The end of `verify` for one formula."""
    (pumps / "one.toml").write_text(f'[[claim]]\nformula = "{formula}"\n')
    return run(capsys, "verify", pumps / "pumps.json", "--claims", pumps / "one.toml", *options)


def test_who_does_what_stands_under_the_claim_that_fails(pumps, capsys):
    code, out, _ = run(capsys, "verify", pumps / "pumps.json", "--claims", pumps / "claims.toml")
    assert code == 1
    lines = [line.split(maxsplit=1) for line in out.splitlines()]
    assert [line[0] for line in lines] == ["VIOLATED", "pump_a", "at", "VIOLATED", "PROVED", "next"]
    assert out.splitlines()[1].strip() == "pump_a takes stay"
    assert out.splitlines()[2].strip() == "at pump_a.feature_0 1"
    assert "(25 % of the stated ranges)" not in out and "6.25 % of the stated ranges" in out
    assert "start region" not in out


def test_features_of_one_name_that_differ_are_pointed_at(pumps, capsys):
    alike = "acts(pump_a) == acts(pump_b)"
    code, out, _ = said(capsys, pumps, alike)
    assert code == 1 and "if agents observe feature_0 alike, ask with --shared feature_0" in out
    code, out, _ = said(capsys, pumps, alike, "--shared", "feature_0")
    assert code == 0 and "--shared" not in out
    _, out, _ = said(capsys, pumps, "pump_a.feature_0 > 0.5 implies acts(pump_a) == left")
    assert "VIOLATED" in out and "--shared" not in out


def test_a_shared_feature_is_named_without_its_agent(pumps, capsys):
    code, _, err = said(capsys, pumps, "pump_a.feature_0 > 0", "--shared", "feature_0")
    assert code == 2 and "write feature_0: it is shared" in err and "did you mean" not in err
    region = pumps / "box.toml"
    region.write_text('[box]\n"pump_b.feature_0" = [0, 1]\n')
    code, _, err = said(capsys, pumps, "feature_0 > 0", "--shared", "feature_0", "--region", region)
    assert code == 2 and "write feature_0: it is shared" in err


def test_regions_of_observations_are_named(pumps, capsys):
    code, _, err = said(capsys, pumps, "pump_a.feature_0 > 0", "--region", "nowhere")
    assert code == 2 and "write start, seen, ranges, or the file's name" in err
    _, out, _ = run(capsys, "verify", "--help")
    assert all(f"`{name}`" in out for name in ("start", "seen", "ranges"))
    _, out, _ = said(capsys, pumps, "pump_a.feature_0 <= 2", "--region", "ranges")
    assert "(100 % of the stated ranges)" in out


def test_reports_speak_of_observations_and_of_what_the_formula_reads(pumps, capsys):
    claim = "pump_a.feature_0 > 1.5 implies acts(pump_a) == stay"
    code, out, _ = said(capsys, pumps, claim, "--where", "-o", pumps / "out")
    assert code == 3 and "no observation of the region meets the condition" in out
    (result,) = json.loads((pumps / "out" / "report.json").read_text())["results"]
    assert result["parameters"] == {} and "world state" not in (pumps / "out" / "report.txt").read_text()
    assert result["claim"] == "in every observation of the region, the formula holds for the actions of the pump"
    _, out, _ = said(capsys, pumps, claim, "--verdict-only")
    assert "no observation of the region meets the condition" in out


def test_check_names_the_region_of_a_formula(pumps, capsys):
    claim = "pump_a.feature_0 > 0.5 implies acts(pump_a) == stay"
    beside = ("--profile", pumps / "pumps.json")
    assert said(capsys, pumps, claim, "-o", pumps / "out")[0] == 0
    code, out, _ = run(capsys, "check", pumps / "out" / "certificate-1-formula.json", *beside)
    assert code == 0 and "in the region (pump_a.feature_0 in [-1, 1], " in out
    assert "without a name" not in out and "of its own" not in out


def test_the_report_says_what_one_can_do_on_a_page_without_an_arena(pumps, capsys):
    code, _, _ = run(capsys, "verify", pumps / "pumps.json", "--claims", pumps / "claims.toml", "-o", pumps / "out")
    report = (pumps / "out" / "report.html").read_text()
    assert code == 1 and "Play this team</a>: change what an agent observes, and see what its tree does." in report
