"""generated/verdicts/: what is proved of a team of each game, and what is not; the navigation team that is proved."""

import json
import re
import subprocess
import sys
from pathlib import Path

import pytest

from codegen import ir
from codegen.policy_json import content_hash
from maviper import load
from maviper.cli import main
from maviper.files import runs

GENERATED = Path(__file__).parent.parent / "generated"
VERDICTS, NAVIGATION = GENERATED / "verdicts", GENERATED / "proved_navigation"
WORLDS = ("physical_deception", "cooperative_navigation", "predator_prey")
MAX_DEPTH = 6
MAX_BYTES = 2**24

pytestmark = pytest.mark.solver


def stated(world):
    """The command that a verdict folder's property file names, and the profile in it."""
    words = next(
        line.split()[2:]
        for line in (VERDICTS / world / "properties.toml").read_text().splitlines()
        if line.startswith("#     maviper verify")
    )
    return words, VERDICTS / world / words[1]


@pytest.mark.slow
@pytest.mark.parametrize("world", WORLDS)
def test_asking_again_gives_the_same_bytes(world, tmp_path, monkeypatch):
    words, _ = stated(world)
    monkeypatch.chdir(VERDICTS / world)
    assert words[-2:] == ["-o", "."]
    assert main.run([*words[:-1], str(tmp_path)]) == 1  # some claims are violated
    given = {"properties.toml", "extracted.json", *(path.name for path in (VERDICTS / world).glob("region*.toml"))}
    kept = {path.name.removesuffix(runs.PACKED): path for path in (VERDICTS / world).iterdir() if path.is_file()}
    made = kept.keys() - given
    assert made == {path.name for path in tmp_path.iterdir() if not path.name.startswith(("states-", "play.", "."))}
    for name in made:
        assert (tmp_path / name).read_bytes() == runs.read_unpacked(kept[name], MAX_BYTES), name


@pytest.mark.parametrize("world", WORLDS)
@pytest.mark.usefixtures("kept_libraries")
def test_certificates_are_accepted_and_counterexamples_replayed(world, capsys):
    folder = VERDICTS / world
    certificates, counterexamples = sorted(folder.glob("certificate-*")), sorted(folder.glob("counterexample-*"))
    assert certificates and counterexamples
    for path in certificates:
        assert main.run(["check", str(path)]) == 0
    for path in counterexamples:
        assert main.run(["replay", str(path)]) == 1


@pytest.mark.parametrize("world", WORLDS)
def test_every_game_has_proved_and_refuted_claims_whose_controls_are_refuted(world):
    report = json.loads((VERDICTS / world / "report.json").read_text())
    verdicts = [result["verdict"] for result in report["results"]]
    assert {"PROVED", "VIOLATED"} <= set(verdicts)
    for result in report["results"]:
        if result["property"] not in ("alive_leaves", "keeps_apart"):  # far apart even shuffled trees touch nobody
            assert result["shuffled_control"] == "VIOLATED", result["label"]


def test_the_table_says_what_the_reports_say():
    told = {
        (row[0], row[1]): row[2]
        for line in (VERDICTS / "README.md").read_text().splitlines()
        if (row := [cell.strip(" `*") for cell in line.strip("|").split("|")])[0] in WORLDS
    }
    found = {}
    for world in WORLDS:
        report = json.loads((VERDICTS / world / "report.json").read_text())
        found |= {(world, result["label"]): result["verdict"] for result in report["results"]}
    assert told == found


def test_the_ready_tests_fail_while_the_claims_do():
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", str(VERDICTS / "predator_prey")],
        capture_output=True,
        text=True,
        cwd=GENERATED.parent,
    )
    counted = re.search(r"(\d+) failed", done.stdout)
    assert counted, done.stdout
    assert int(counted[1]) == len(list((VERDICTS / "predator_prey").glob("counterexample-*")))


def test_the_navigation_team_is_small_and_made_from_the_extracted_one():
    profile = load(NAVIGATION / "profile.json")
    assert max(int(ir.depth(policy.tree).max()) for policy in profile.agents) <= MAX_DEPTH
    cost = json.loads((NAVIGATION / "repair.json").read_text())
    assert cost["profile"] == content_hash(profile)
    assert cost["profile_before"] == content_hash(load(NAVIGATION / "extracted.json"))
    assert main.run(["check", str(NAVIGATION / "certificate-1-distinct_targets.json")]) == 0
