"""Proof maintenance: what an earlier certificate still shows after a change, and that no answer hangs on it."""

import json
import shutil
from dataclasses import replace
from pathlib import Path

import pytest

import maviper
from codegen.dynamics import motionless
from codegen.errors import ExitCode, InputError
from codegen.policy_json import dumps
from maviper.cli.main import run
from tests.support.system_cases import policy, team
from tests.support.systems import TANK
from verify.reach.renewal import AFRESH

GENERATED = Path(__file__).parents[3] / "generated"
FLOWS = TANK.replace("flow = -1", "flow = -3").replace("flow = 1", "flow = 3")
CLAIMS = """
[[claim]]
label = "for ever"
name = "always"
region = { box = { level = [1, 9] } }
[[claim]]
label = "for 12 steps"
name = "stays_in"
steps = 12
region = { box = { level = [1, 9] } }
"""
WORLD = FLOWS + CLAIMS
KEEP, DRAIN, FILL = range(3)
WHOLE = "the earlier proof holds as it was"


def valve(drains=3.5, fills=7.0, spoils=1.5, low=FILL):
    """Drains a full tank and fills an empty one; the fullest are filled, which no episode from the start comes to."""
    tree = ((0, drains), ((0, spoils), FILL, DRAIN), ((0, fills), KEEP, low))
    own = policy("valve", ["gap"], ["keep", "drain", "fill"], tree)
    return replace(team(own), world=motionless("stated", "", ("valve",), 10, {}))


def verify(folder, profile, name, *more):
    (folder / f"{name}.json").write_text(dumps(profile))
    asked = ["verify", folder / f"{name}.json", "--system", folder / "tank.toml", "-o", folder / name, *more]
    code = run([*map(str, asked)])
    told = json.loads((folder / name / "report.json").read_text()) if (folder / name).exists() else {}
    return code, {each["label"]: each for each in told.get("results", [])}


@pytest.fixture(scope="module")
def once(tmp_path_factory):
    folder = tmp_path_factory.mktemp("since")
    (folder / "tank.toml").write_text(WORLD)
    code, results = verify(folder, valve(), "before")
    assert code == ExitCode.DONE and not any("reused" in each for each in results.values())
    return folder


@pytest.fixture
def proved(once, tmp_path):
    return shutil.copytree(once, tmp_path / "room")


def test_what_holds_as_it_was_is_kept_and_the_whole_is_checked_alone(proved, capsys):
    changed = valve(spoils=1.0)  # of states that no episode comes to
    code, results = verify(proved, changed, "after", "--since", proved / "before")
    said = capsys.readouterr().out
    assert code == ExitCode.DONE and said.count(WHOLE) == 2
    assert all(each["reused"].startswith(WHOLE) for each in results.values()), results
    assert results["for ever"]["reused"].endswith("(17 cells), so nothing was proved again")
    for name in ("certificate-1-always.json", "certificate-2-stays_in.json"):
        assert run(["check", str(proved / "after" / name)]) == ExitCode.DONE
    before, after = ((proved / name / "certificate-1-always.json").read_text() for name in ("before", "after"))
    assert json.loads(before)["parts"] == json.loads(after)["parts"] and before != after
    assert WHOLE in (proved / "after" / "report.txt").read_text()
    assert f">{WHOLE.capitalize()}" in (proved / "after" / "report.html").read_text()


def test_cells_that_are_new_are_proved_beside_those_that_hold(proved, capsys):
    one = proved / "before" / "certificate-1-always.json"
    code, results = verify(proved, valve(drains=4.5), "after", "--since", one)
    assert code == ExitCode.DONE and results["for ever"]["reused"] == "17 of 22 cells hold as they were; 5 proved again"
    assert "reused" not in results["for 12 steps"]  # of which nothing was given
    assert run(["check", str(proved / "after" / "certificate-1-always.json")]) == ExitCode.DONE


@pytest.mark.parametrize("changed", [{"spoils": 4.5, "drains": 5.0}, {"drains": 9.0, "fills": 9.5}])
def test_a_broken_claim_is_answered_as_if_there_were_no_certificate(proved, changed):
    code, results = verify(proved, valve(**changed), "after", "--since", proved / "before")
    again, fresh = verify(proved, valve(**changed), "fresh")
    assert code == again == ExitCode.VIOLATED and results == fresh


def test_numbers_of_the_claim_and_of_the_world_may_change(proved):
    world = WORLD.replace("[1, 9]", "[1.5, 8]").replace("[4, 6]", "[4.25, 5.75]")
    (proved / "tank.toml").write_text(world)
    found = maviper.verify_system(valve(), proved / "tank.toml", since=proved / "before")
    assert [each.verdict for each in found] == ["PROVED", "PROVED"]
    assert all(each.evidence.reused.startswith(WHOLE) for each in found)


def test_earlier_cells_from_which_the_claim_breaks_now_are_left(proved):
    """No episode comes to them any more, so the claim holds; but they are no part of a proof."""
    verify(proved, valve(drains=4.5), "wider")
    code, results = verify(proved, valve(low=DRAIN), "after", "--since", proved / "wider")
    assert code == ExitCode.DONE and results["for ever"]["reused"] == AFRESH
    assert run(["check", str(proved / "after" / "certificate-1-always.json")]) == ExitCode.DONE


@pytest.mark.parametrize(
    ("change", "fault"),
    [
        (('"for ever"', '"never"'), "the certificate is about always (in the file: 'for ever'), and this is not asked"),
        (('"tank"', '"pool"'), "the certificate is about tank, and the world file is pool"),
    ],
)
def test_a_certificate_of_something_else_is_refused(proved, change, fault):
    other = proved / "other.toml"
    other.write_text(WORLD.replace(*change))
    with pytest.raises(InputError, match=fault.replace("(", r"\(").replace(")", r"\)")):
        maviper.verify_system(valve(), other, since=proved / "before" / "certificate-1-always.json")


def test_a_damaged_certificate_is_refused(proved):
    path = proved / "before" / "certificate-1-always.json"
    path.write_text(path.read_text().replace('"steps"', '"paces"', 1))
    with pytest.raises(InputError, match=path.name):
        maviper.verify_system(valve(), proved / "tank.toml", since=path)
    with pytest.raises(InputError, match="holds no certificate"):
        maviper.verify_system(valve(), proved / "tank.toml", since=proved)


def test_it_is_about_world_files(proved, capsys):
    (proved / "game.json").write_text(dumps(valve()))
    assert run(["verify", str(proved / "game.json"), "--since", str(proved)]) == ExitCode.INPUT
    said = capsys.readouterr().err
    assert "--since has no effect without --system" in said and "of a game all is proved again" in said
    of_game = GENERATED / "physical_deception" / "certificate-1-distinct_targets.json"
    with pytest.raises(InputError, match="a certificate, not a certificate about a stated system"):
        maviper.verify_system(valve(), proved / "tank.toml", since=of_game)
