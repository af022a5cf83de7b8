"""`maviper verify --semantics real` as users call it: rational counterexamples in reports, files, replays, lessons."""

import json
from fractions import Fraction

import numpy as np
import pytest

import maviper
from codegen import policy_json
from codegen.errors import InputError
from maviper.cli import main
from maviper.verification.files.states import read_failing
from maviper.worlds import find
from tests.support.ready_tests import outcomes
from tests.support.teams import RIGHT, STAY, UP, team, towards, tree
from tests.support.verifying import ensure_told, run
from verify.claims.region_files import read_region
from verify.kinds import REAL
from verify.question import from_start
from verify.states.state import violates

pytestmark = [pytest.mark.solver, pytest.mark.usefixtures("few_states_throughout")]
T = Fraction(float(np.float32(0.3)))
NAMED = "counterexample-1-distinct_targets.json"
STATES = "states-1-distinct_targets.json"
THIRD = '[difference]\n"agent_0.x - agent_1.x" = ["1/3", "1/3"]\n'
# between the threshold and where the machine turns the first agent stays on paper only
SLIVER = f"""goals = ["landmark_0"]
default = [0, 0]
[box]
"landmark_0.x" = ["{T + Fraction(1, 2**40)}", "{T + Fraction(1, 2**30)}"]
"landmark_1.x" = [1, 1]
"landmark_1.y" = [1, 1]
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory, profile):
    """Questions in real arithmetic: where no float64 state is, where only real arithmetic fails, and where both do."""
    found = tmp_path_factory.mktemp("real")
    same = team(profile, towards(0, 0), towards(0, 1))
    (found / "same.json").write_text(policy_json.dumps(same))
    (found / "roles.json").write_text(policy_json.dumps(team(profile, towards(0, 0), towards(1, 1))))
    paper = team(profile, tree((2, float(T), 1, 2), RIGHT, STAY), tree(UP))
    (found / "paper.json").write_text(policy_json.dumps(paper))
    (found / "third.toml").write_text(THIRD)
    (found / "sliver.toml").write_text(SLIVER)
    for policy, region, out in (
        ("same", "third.toml", "third"),
        ("paper", "sliver.toml", "sliver"),
        ("same", "", "both"),
    ):
        words = ["--region", str(found / region)] if region else []
        asked = [
            "-q",
            "verify",
            str(found / f"{policy}.json"),
            *words,
            "--set",
            "semantics=real",
            "-o",
            str(found / out),
        ]
        assert main.run(asked) == 1
    return found


def shown(folder):
    document = json.loads((folder / NAMED).read_text())
    (result,) = json.loads((folder / "report.json").read_text())["results"]
    assert document["position"] == result["counterexample"]["position"] and document["semantics"] == "real"
    assert document["counterexample"] == "maviper-counterexample-2"
    assert document["deployed"] == result["counterexample"]["deployed"]
    return document, result, [(folder / f"report.{form}").read_text() for form in ("txt", "html")]


def test_a_rational_state_is_written_exactly_and_not_said_to_be_replayed(folder, capsys):
    document, result, texts = shown(folder / "third")
    position = {name: Fraction(value) for name, value in document["position"].items()}
    assert position["agent_0.x"] - position["agent_1.x"] == Fraction(1, 3)
    written = [value for value in document["position"].values() if isinstance(value, str)]
    assert written and all("/" in value for value in written) and document["deployed"] is None
    assert result["verdict"] == "VIOLATED" and result["counterexample"]["replayed_by"] == []
    for text in texts:
        assert written[0] in text and "not replayed: the state is no float64 state" in text
        assert "which was replayed" not in text and "replayed by" not in text and "it can be replayed" not in text
    asked = ["verify", folder / "same.json", "--region", folder / "third.toml", "--set", "semantics=real"]
    assert "judged in exact arithmetic; not replayed" in run(capsys, *asked)[1]
    _, _, err = run(capsys, *asked, "-v")
    assert "judged in exact arithmetic; not replayed" in err and written[0] in err and "replayed by" not in err


def test_it_is_replayed_in_exact_arithmetic(folder, capsys):
    code, out, err = run(capsys, "replay", folder / "third" / NAMED)
    assert code == 1 and "in exact arithmetic; not replayed" in err and "VIOLATED" in out
    found = maviper.replay(folder / "third" / NAMED, folder / "same.json")
    assert found.violated and found.actions == found.before and found.by == () and found.same_policy
    code, out, err = run(capsys, "replay", folder / "third" / NAMED, "--profile", folder / "roles.json")
    assert code == 0 and "holds" in out and "not the one" in err


def test_its_ready_test_fails_until_the_policy_is_mended(folder, tmp_path):
    files = [folder / "third" / name for name in (NAMED, "test_counterexample_1_distinct_targets.py")]
    found = outcomes(tmp_path, files, [folder / "same.json", folder / "roles.json"])
    assert found == {"same": "FAILED", "roles": "PASSED"}


def test_where_the_deployed_arithmetic_differs_it_is_said(folder, capsys):
    document, result, texts = shown(folder / "sliver")
    assert all(isinstance(value, float) for value in document["position"].values())
    assert document["deployed"]["actions"]["agent_0"] == "right" and document["actions"]["agent_0"] == "stay"
    assert not document["deployed"]["violated"] and result["counterexample"]["replayed_by"] == []
    said = "the deployed arithmetic differs: agent_0 takes right, and the claim holds there"
    for text in texts:
        assert said in text and "which was replayed" not in text and "replayed by" not in text
    code, _, err = run(capsys, "replay", folder / "sliver" / NAMED, "--profile", folder / "paper.json")
    assert code == 1 and said in err
    assert not (folder / "sliver" / STATES).exists(), "no state fails in the deployed arithmetic"


def test_where_both_fail_it_is_replayed(folder, capsys):
    document, result, texts = shown(folder / "both")
    assert document["deployed"] == {"actions": document["actions"], "violated": True}
    by = ["reference", "mpe2.simple_adversary_v3"]
    assert set(by) <= set(result["counterexample"]["replayed_by"])
    for text in texts:
        assert "judged in exact arithmetic, replayed by reference" in text
    code, _, err = run(capsys, "replay", folder / "both" / NAMED, "--profile", folder / "same.json")
    assert code == 1 and "judged      in exact arithmetic, replayed by reference" in err


def test_what_is_learned_fails_in_the_deployed_arithmetic(folder):
    world = find("physical-deception")
    (found,), skipped = read_failing([folder / "both"], world)
    same = maviper.load(folder / "same.json")
    assert (
        not skipped
        and len(found.states) > 100
        and all(violates(from_start(same, found.claim), state) for state in found.states)
    )
    assert all(violates(from_start(same, found.claim, REAL), state) for state in found.states)
    for out in ("third", "sliver"):
        with pytest.raises(InputError, match="real arithmetic"):
            read_failing([folder / out], world)
        with pytest.raises(InputError, match="real arithmetic only") as caught:
            read_failing([folder / out / NAMED], world)
        assert "--set semantics=real" in caught.value.next_step
    (found,), skipped = read_failing([folder / "both", folder / "third"], world)
    assert len(skipped) == 1 and "real arithmetic only" in skipped[0]


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"counterexample": "maviper-counterexample-1"}, "not a counterexample"),
        ({"counterexample": "maviper-counterexample-3"}, "another version"),
        ({"semantics": "machine"}, "not a counterexample"),
        ({"semantics": "unreal"}, "not a counterexample"),
        ({"semantics": None}, "not a counterexample"),
        ({"deployed": "holds"}, "not a counterexample"),
        ({"position/agent_0.x": "far"}, "not a counterexample"),
        ({"position/agent_0.x": "1/0"}, "not a counterexample"),
        ({"position/agent_0.x": "1/3 "}, "not a counterexample"),
        ({"position/agent_0.x": "9" * 4000}, "not a counterexample"),
        ({"position/agent_0.x": "1" * 5000}, "not a counterexample"),
        ({"position/agent_0.x": None}, "not a counterexample"),
        ({"position/agent_0.x": 1e300}, "not a counterexample"),
        ({"position/agent_7.x": "1/3"}, "another world"),
        ({"errors/agent_0:smell": "1/3"}, "another world"),
        ({"errors/agent_0:goal_dx": "-9999999999"}, "not a counterexample"),
        ({"actions/agent_7": "up"}, "another world"),
    ],
)
def test_a_damaged_file_is_told(folder, tmp_path, change, said):
    ensure_told(folder / "third" / NAMED, folder / "same.json", tmp_path, change, said)


def test_a_file_of_the_deployed_arithmetic_holds_no_fractions(folder, tmp_path):
    document = json.loads((folder / "third" / NAMED).read_text()) | {"counterexample": "maviper-counterexample-1"}
    (tmp_path / "old.json").write_text(
        json.dumps({k: v for k, v in document.items() if k not in ("semantics", "deployed")})
    )
    with pytest.raises(InputError, match="not a counterexample"):
        maviper.replay(tmp_path / "old.json", folder / "same.json")


def test_errors_of_features_are_rational_too(folder, tmp_path, capsys):
    """Everything settled at thirds, and errors that must be exact."""
    out = tmp_path / "steady"
    options = ["--claim", "steady(eps=1/4, of=own_target)", "--set", "semantics=real"]
    assert run(capsys, "verify", folder / "roles.json", *options, "--region", folder / "third.toml", "-o", out)[0] == 1
    name = "counterexample-1-steady.json"
    found = maviper.replay(out / name, folder / "roles.json")
    assert found.violated and found.by == ()
    document = json.loads((out / name).read_text())
    assert document["errors"] and all(abs(Fraction(value)) <= Fraction(1, 4) for value in document["errors"].values())


def test_leaves_are_asked_about_in_real_arithmetic(folder, tmp_path, capsys):
    asked = ["verify", folder / "paper.json", "--claim", "alive_leaves", "--region", folder / "sliver.toml"]
    for semantics, dead in (("machine", "agent_0 leaf 2"), ("real", "agent_0 leaf 1")):
        code, out, _ = run(
            capsys, *asked, "--set", f"semantics={semantics}", "--smt", tmp_path / semantics, "-o", tmp_path / "out"
        )
        assert code == 1 and f"dead: {dead}" in out and ("real arithmetic" in out) == (semantics == "real")
        report = json.loads((tmp_path / "out" / "report.json").read_text())["results"][0]
        assert report["semantics"] == semantics
        page = (tmp_path / "out" / "report.html").read_text()
        assert ("<th>arithmetic</th><td>real</td>" in page) == (semantics == "real")
        position = next(leaf["state"]["position"] for leaf in report["leaves"] if leaf["verdict"] == "PROVED")
        region = read_region(SLIVER, find("physical-deception").spec, "sliver")
        assert set(position) == set(region.box)
    name = "01-alive_leaves-agent_0-1-landmark_0.smt2"
    machine, real = ((tmp_path / semantics / name).read_text() for semantics in ("machine", "real"))
    assert "machine arithmetic" in machine and "real arithmetic" in real
    assert machine.splitlines()[3:] != real.splitlines()[3:]


def test_where_it_fails_is_asked_in_real_arithmetic(folder, capsys):
    """All of the sliver on paper, nothing of it as deployed."""
    asked = ["verify", folder / "paper.json", "--region", folder / "sliver.toml", "--where"]
    assert "everywhere" in run(capsys, *asked, "-v")[1]
    code, out, _ = run(capsys, *asked, "--set", "semantics=real", "--json")
    assert code == 1
    (result,) = json.loads(out)["results"]
    assert result["where"]["exact"]["fraction"] == "1" and result["where"]["zones"] >= 1
    assert result["violating"]["share"] == 1
