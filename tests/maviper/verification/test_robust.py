"""The claim `robust`: the table, its certificates, and files that are no observations."""

import csv
import json
import math

import pytest

import maviper
from codegen import policy_json
from codegen.errors import ExitCode
from maviper.cli import main
from tests.support.observations import blind, robust
from tests.support.teams import tree

pytestmark = pytest.mark.solver
CART = tree((1, 0.5, 1, 4), (0, 0.25, 2, 3), 0, 2, 2)
NAMES = ("angle", "spin")


@pytest.fixture
def place(tmp_path):
    """A folder with a profile and a table of three observations."""
    (tmp_path / "profile.json").write_text(policy_json.dumps(blind({"cart": CART}, {"cart": NAMES})))
    (tmp_path / "seen.csv").write_text("spin,angle\n0,0\n0,1\n1,-2\n")
    return tmp_path


@pytest.mark.parametrize("option", [("--since", "proved"), ("--effort", "high"), ("--max-seconds", "9")])
def test_options_of_other_claims_are_refused(place, option, capsys):
    assert main.run(robust(place / "profile.json", place / "seen.csv", *option)) == ExitCode.INPUT
    assert f"{option[0]} has no effect with robust" in capsys.readouterr().err


def test_the_table_is_printed(place, capsys):
    assert main.run(robust(place / "profile.json", place / "seen.csv")) == 0
    said = capsys.readouterr()
    rows = list(csv.DictReader(said.out.splitlines()))
    assert [(row["row"], row["action"], row["other_action"]) for row in rows] == [
        ("1", "left", "right"), ("2", "right", "left"), ("3", "right", "left"),
    ]  # fmt: skip
    ties = (0.25 + 2.0**-26, 0.75 - 2.0**-26, 0.5 - 2.0**-25)
    for row, tie in zip(rows, ties, strict=True):
        assert float(row["radius"]) == pytest.approx(tie, rel=1e-9)
    assert "least 0.25, median 0.499999" in said.err  # 0.5 - 2^-25


@pytest.mark.parametrize(
    ("claims", "told"),
    [
        (["robust"], "robust needs observations"),
        (["robust(file=seen.csv)"], "robust has no parameter file"),
        (["robust(observations=seen.csv, least=much)"], "not a number"),
        (["robust(observations=seen.csv)", "alive_leaves"], "ask it alone"),
    ],
)
def test_a_claim_of_robustness_that_cannot_be_asked_is_told(place, capsys, claims, told):
    words = [word for claim in claims for word in ("--claim", claim)]
    assert main.run(["verify", str(place / "profile.json"), *words]) == ExitCode.INPUT
    assert told in capsys.readouterr().err


def test_a_radius_is_never_said_to_be_more_than_it_is(place, capsys):
    (place / "seen.csv").write_text("spin,angle\n0,0.76\n")
    assert main.run(robust(place / "profile.json", place / "seen.csv", least="0.51")) == 1
    assert "least 0.509999," in capsys.readouterr().err


def test_a_table_may_begin_with_the_mark_of_a_spreadsheet(place):
    (place / "seen.csv").write_bytes(b"\xef\xbb\xbfspin,angle\n0,0\n")
    assert main.run(robust(place / "profile.json", place / "seen.csv")) == 0


def test_radii_are_proved_and_checked(place, capsys):
    given = (place / "profile.json", place / "seen.csv")
    assert main.run(robust(*given, "-o", place / "out", certify=True)) == 0
    assert sorted(path.name for path in (place / "out").iterdir()) == [
        *(f"certificate-{row}-robust.json" for row in (1, 2, 3)), "radii.csv",
    ]  # fmt: skip
    for row in (1, 2, 3):
        name = str(place / "out" / f"certificate-{row}-robust.json")
        assert main.run(["check", name, "--profile", str(place / "profile.json")]) == 0
    assert capsys.readouterr().out.count("over observations") == 3


def test_a_radius_below_the_least_one_exits_with_1(place, capsys):
    given = (place / "profile.json", place / "seen.csv", "--json")
    assert main.run(robust(*given, least="0.2")) == 0
    assert main.run(robust(*given, least="0.3")) == 1
    assert json.loads(capsys.readouterr().out.split("}\n{")[0] + "}")["agent"] == "cart"


@pytest.mark.parametrize(
    ("options", "parameters", "said"),
    [
        ([], {"least": "0"}, "no radius is below 0, so this cannot fail"),
        ([], {"least": "-1/2"}, "no radius is below -1/2"),
        (["-o", ""], {}, "-o names no folder"),
    ],
)
def test_bounds_and_places_that_say_nothing_are_refused(place, options, parameters, said, capsys):
    """Every radius is at least 0; without a name, results would lie in whatever folder one is in."""
    before = sorted(place.iterdir())
    assert main.run(robust(place / "profile.json", place / "seen.csv", *options, **parameters)) == ExitCode.INPUT
    assert said in capsys.readouterr().err and sorted(place.iterdir()) == before


def test_lists_and_tables_in_json_are_read(place):
    (place / "seen.json").write_text('[[0, 0], {"spin": 0, "angle": 1}]')
    found = maviper.robust(place / "profile.json", place / "seen.json")
    assert found.observations == ((0.0, 0.0), (1.0, 0.0))
    assert found.least == found.radii[0].largest


def test_one_action_has_no_radius(place):
    (place / "profile.json").write_text(policy_json.dumps(blind({"cart": tree(1)}, {"cart": NAMES})))
    found = maviper.robust(place / "profile.json", place / "seen.csv", certify=True)
    assert math.isinf(found.least) and found.rows[0]["radius"] is None and len(found.certificates) == 3


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("angle,spin\n0,nan\n", "row 1: spin"),
        ("angle,spin\n0,0\n0,inf\n", "row 2: spin"),
        ("angle,spin\n0,1e10\n", "not a finite number"),
        ("angle,spin\n0,fast\n", "not a finite number"),
        ("angle,spin\n0\n", "no number for spin"),
        ("angle,spin\n0,1,2\n", "unknown feature"),
        ("angle,speed\n0,1\n", "seen.csv: first line\n  known: angle"),
        ("angle,angle\n0,1\n", "named twice"),
        ("angle,spin\n", "0 observations"),
        ("", "0 observations"),
        ("[[0, 0], [0]]", "1 numbers for 2 features"),
        ("[[0, NaN]]", "not a finite number"),
        ("[[0, true]]", "not a finite number"),
        ("[0, 0", "not a list of observations"),
    ],
)
def test_files_that_are_no_observations(place, text, said, capsys):
    (place / "seen.csv").write_text(text)
    assert main.run(robust(place / "profile.json", place / "seen.csv")) == 2
    assert said in capsys.readouterr().err


def test_of_several_agents_one_is_named(place, capsys):
    two = blind({"a": CART, "b": CART}, {"a": NAMES, "b": NAMES})
    (place / "profile.json").write_text(policy_json.dumps(two))
    given = (place / "profile.json", place / "seen.csv")
    assert main.run(robust(*given)) == 2 and "several agents" in capsys.readouterr().err
    assert main.run(robust(*given, agent="c")) == 2 and "unknown agent" in capsys.readouterr().err
    assert main.run(robust(*given, agent="b", certify=True)) == 0
