"""No share of a range that nobody stated: neither printed, nor in a report, its page or its JSON."""

import json
import re
from fractions import Fraction

import pytest

from codegen import ir, policy_json
from maviper.cli import main
from maviper.evaluation import comparison
from tests.support.observations import blind, far
from tests.support.teams import tree
from verify.claims.region import Region
from verify.claims.region_files import everywhere

pytestmark = pytest.mark.solver
CAR = tree((0, 30.0, 1, 2), 0, (1, 1.0, 3, 4), 1, 2)
FILE = """
[[property]]
label = "violated"
formula = "gap < 40 implies acts(car) == left"

[[property]]
label = "proved"
formula = "gap < 20 implies acts(car) == left"

[[property]]
name = "monotone"
agent = "car"
feature = "gap"
order = ["right", "stay", "left"]
"""
SHARE = re.compile(r"\d ?%|\"(?:share|hits)\": [^n]")
RANGES = "speed = [0, 10]\ngap = [0, 100]"


def run(*arguments):
    return main.run([*map(str, arguments)])


@pytest.fixture
def asked(tmp_path):
    """A car whose features have no stated range, and claims about it."""
    (tmp_path / "car.toml").write_text(FILE)
    profile = blind({"car": CAR}, {"car": ["gap", "speed", "other"]}, ir.MAX_LENGTH)
    (tmp_path / "car.json").write_text(policy_json.dumps(profile))
    return [tmp_path / "car.json", "--claims", tmp_path / "car.toml"]


@pytest.mark.parametrize("more", [(), ("--where",), ("-v",), ("--json",)])
def test_no_share_is_told_of_a_range_that_nobody_stated(asked, more, tmp_path, capsys):
    assert run("verify", "-v", *asked, *more, "-o", tmp_path / "out") == 1
    told = "".join(capsys.readouterr())
    reports = [path.read_text() for path in (tmp_path / "out").glob("report.*")]
    zones = [path.read_text() for path in (tmp_path / "out").glob("zones-*.json")]
    assert len(reports) == 3 and len(zones) == 2 * ("--where" in more)
    why = "gap, speed have no stated range; bound them in a region file (--region)"
    for text in (told, *reports):
        body = re.sub(r"<style>.*?</style>|95 % Wilson", "", text, flags=re.DOTALL)
        assert not SHARE.findall(body), SHARE.findall(body)
        assert why in text
    assert all('"share": null' in text for text in zones)


def test_shares_are_told_once_ranges_are_stated(asked, tmp_path, capsys):
    """`other` is read by nothing, so it needs no range."""
    (tmp_path / "near.toml").write_text(f"[box]\n{RANGES}\n")
    assert run("verify", *asked, "--region", tmp_path / "near.toml", "--where") == 1
    told = capsys.readouterr().err
    assert "violating 10 % exactly" in told and "no stated range" not in told


def test_a_comparison_tells_no_share_either(tmp_path, capsys):
    for name, profile in (("a", far(30.0, 1)), ("b", far(40.0, 1))):
        (tmp_path / name).write_text(policy_json.dumps(profile))
    assert run("diff", tmp_path / "a", tmp_path / "b", "-o", tmp_path / "out") == 1
    told, facts = capsys.readouterr().err, json.loads((tmp_path / "out" / "difference.json").read_text())
    assert "somewhere in region start, no share: gap has no stated range" in told and "%" not in told
    assert facts["uniform"] is None and facts["agents"][0]["uniform"] is None
    (tmp_path / "near.toml").write_text("[box]\ngap = [0, 100]\n")
    assert run("diff", tmp_path / "a", tmp_path / "b", "--region", tmp_path / "near.toml") == 1
    assert "10 % of region" in capsys.readouterr().err


def test_the_cost_of_a_change_neither():
    before, after = far(30.0, 1), far(40.0, 1)
    whole = everywhere(before)
    cost = comparison.measure_cost(before, after, ["team"], whole, None, None, 1)
    assert cost.document()["changed"] == {"region": None, "met": None}
    near = comparison.measure_cost(
        before, after, ["team"], Region({"gap": (Fraction(0), Fraction(100))}, ()), None, None, 1
    )
    assert near.uniform is not None and round(float(near.exact), 6) == 0.1
