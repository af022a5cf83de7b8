"""`maviper robust` of an agent that gives numbers: how far they change where its observations are off."""

import csv
import json
from dataclasses import replace
from functools import partial

import pytest

import maviper
from codegen.policy_json import dumps
from tests.support import summed
from tests.support.observations import robust
from tests.support.verifying import run

CART = "def cart(x, v):\n    if x < -0.5:\n        return 2.0\n    return -1.0 * x - 0.25 * v\n"


@pytest.fixture
def place(tmp_path, monkeypatch):
    """A folder with a profile and two observations, one near the threshold."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "cart.py").write_text(CART)
    profile = maviper.from_file("cart.py", arrays="float64", output_names=("push",))
    (tmp_path / "cart.json").write_text(dumps(profile))
    (tmp_path / "seen.csv").write_text("v,x\n0,0\n0.1,-0.499\n")
    return tmp_path


def test_the_table_is_printed(place, capsys):
    code, out, err = run(capsys, *robust("cart.json", "seen.csv", error="0.01"))
    first, second = csv.DictReader(out.splitlines())
    assert code == 0 and (first["row"], first["output"], first["exact"]) == ("1", "push", "yes")
    assert float(first["change"]) == pytest.approx(0.0125) and second["most"] == "2.0"
    assert "cart, 2 observations: push changes by at most 1.526\n" in err  # 2 - (0.499 - 0.025)


def test_features_may_err_apart_and_a_limit_is_checked(place, capsys):
    asked = partial(robust, "cart.json", "seen.csv", "--json", error="v = 1/10")
    code, out, _ = run(capsys, *asked(most="0.0251"))
    document = json.loads(out)
    assert code == 0 and document["errors"] == {"x": "0", "v": "0.1"}
    assert document["largest"] == pytest.approx(0.025)
    assert document["changes"][1]["lowest"] == pytest.approx([-0.499, 0.2])
    assert run(capsys, *asked(most="0.0249"))[0] == 1


SUMS = """
def agent(x, v):
    if x + v < 1:
        return 0.0
    return 5.0 if v - x > 1.5 else 1.0
"""


def test_a_bound_alone_breaks_no_limit(place, capsys):
    """From v - x = -0.25 an error of 0.625 in each leads to 1 and, with x + v above 1, not to 1.5."""
    (place / "cart.py").write_text(SUMS)
    (place / "cart.json").write_text(dumps(maviper.from_file("cart.py", arrays="float64", output_names=("push",))))
    (place / "seen.csv").write_text("x,v\n0.5,0.25\n")
    near = robust("cart.json", "seen.csv", error="0.625", most="2")
    assert run(capsys, *near)[0] == 0
    far = partial(robust, "cart.json", "seen.csv", error="0.9")  # 1.55 is reached where x + v is 0.75 alone
    code, out, err = run(capsys, *far(most="2"))
    assert code == 3 and out.splitlines()[1] == "1,push,0.0,0.0,5.0,5.0,no" and "some are bounds" in err
    assert run(capsys, *far(most="0.5"))[0] == 1 and run(capsys, *far(most="5"))[0] == 0


def test_a_run_replaces_its_table(place, capsys):
    for error in ("0.1", "0.2"):
        assert run(capsys, *robust("cart.json", "seen.csv", "-o", "out", error=error))[0] == 0
    assert [path.name for path in (place / "out").iterdir()] == ["changes.csv"]
    assert (place / "out" / "changes.csv").read_text().startswith("row,output,value,least,most,change,exact\n1,push,")


@pytest.mark.parametrize(
    ("parameters", "said"),
    [
        ({}, "write --error 0.01, or --error x=0.01"),
        ({"error": "y=0.1"}, "unknown feature 'y'"),
        ({"error": "x=0.1,x=0.2"}, "x is given twice"),
        ({"error": "-0.1"}, "the error of x is below 0"),
        ({"error": "v=much"}, "not a number"),
        ({"error": "0.1", "certify": True}, "leave it out; `maviper verify` proves"),
        ({"error": "0.1", "least": "1"}, "write most=NUMBER"),
        ({"error": "0.1", "most": "-1"}, "so this cannot hold"),
    ],
)
def test_what_is_refused(place, parameters, said, capsys):
    code, _, err = run(capsys, *robust("cart.json", "seen.csv", **parameters))
    assert code == 2 and said in err


@pytest.mark.parametrize("parameters", [{"error": "0.1"}, {"most": "0.1"}])
def test_agents_that_act_take_no_errors(place, parameters, capsys):
    (place / "cart.py").write_text("def cart(x, v):\n    return 1 if x < 0 else 0\n")
    (place / "cart.json").write_text(dumps(maviper.from_file("cart.py")))
    code, _, err = run(capsys, *robust("cart.json", "seen.csv", **parameters))
    assert code == 2 and "gives numbers" in err.replace("give numbers", "gives numbers")


def test_many_outputs_have_a_row_each(place):
    profile = summed.every(2, levels=2)["outputs, float64"]
    outputs = tuple(replace(each, unit="N") for each in profile.agents[0].outputs)
    profile = replace(profile, agents=(replace(profile.agents[0], outputs=outputs),))
    (place / "rows.json").write_text(json.dumps([[0.0] * len(profile.agents[0].features)] * 3))
    table = maviper.robust(profile, "rows.json", error="0.001")
    assert [row["output"] for row in table.rows] == [each.name for each in outputs] * 3
    assert " N" in table.line and table.largest >= table.largest_seen
