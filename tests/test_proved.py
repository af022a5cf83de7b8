"""generated/proved_defenders/: a team that plays nearly as well as the network, proved in the whole start region; and
teams that are repaired or extracted again.
"""

import json
from dataclasses import replace
from pathlib import Path

import pytest

from codegen import ir
from codegen.policy_json import content_hash, dumps
from maviper import load
from maviper.cli import main
from maviper.episodes import measures
from maviper.episodes.play import tree_policies
from maviper.worlds.games.physical_deception import DEFENDERS
from tests.support.altered import read_game
from verify.checker.decisions import check_certificate
from verify.claims.region_files import everywhere

GENERATED = Path(__file__).parent.parent / "generated"
FOLDER = GENERATED / "proved_defenders"
CERTIFICATE = FOLDER / "certificate-1-distinct_targets.json"
MAX_DEPTH, LEAST_SUCCESS = 6, 0.98
FRESH = range(
    measures.MEASUREMENT_SEEDS + 500_000, measures.MEASUREMENT_SEEDS + 510_000
)  # no command measures on these

pytestmark = pytest.mark.solver


@pytest.fixture(scope="module")
def proved():
    return load(FOLDER / "profile.json")


def test_the_certificate_is_about_these_trees_in_the_whole_start_region(proved, capsys):
    found = read_game(CERTIFICATE.read_bytes())
    assert check_certificate(found, proved) > 0
    named, header = found.claim.property, found.header
    assert named.name == "distinct_targets" and named.team == DEFENDERS
    assert (named.margin, named.radius * 10, header.semantics) == (0, 1, "machine")
    assert header.region == everywhere(proved) and set(header.region.goals) == {"landmark_0", "landmark_1"}
    assert main.run(["check", str(CERTIFICATE)]) == 0
    assert capsys.readouterr().out.startswith("accepted")


def test_the_trees_are_small_and_play_as_well_as_they_are_said_to(proved, world, expert):
    assert max(int(ir.depth(policy.tree).max()) for policy in proved.team(DEFENDERS)) <= MAX_DEPTH
    lineup = [tree_policies(proved.agents) if policy.team == DEFENDERS else expert for policy in proved.agents]
    measure = world.primary(DEFENDERS)
    assert measure.name == "success r=0.316"
    low, high = measures.evaluate(world, lineup, FRESH)[measure].interval
    assert low >= LEAST_SUCCESS
    told = next(
        row for row in json.loads((FOLDER / "repair.json").read_text())["measures"] if "0.316" in row["measure"]
    )
    assert told["episodes"] == 10_000 and low <= told["after"]["high"] and told["after"]["low"] <= high


def test_the_evidence_names_the_profiles(proved, expert):
    cost, report = (json.loads((FOLDER / name).read_text()) for name in ("repair.json", "report.json"))
    assert cost["profile"] == report["profile"] == content_hash(proved)
    before = content_hash(load(FOLDER / "extracted.json"))
    assert cost["profile_before"] == proved.provenance.training["profile before repair"] == before
    assert proved.provenance.expert == expert.hash
    (result,) = report["results"]
    assert [opinion["verdict"] for opinion in result["engines"]] == ["PROVED", "PROVED"]


@pytest.mark.parametrize(
    ("place", "episodes"),
    [("proved_defenders", "10000"), pytest.param("proved_navigation", "2000", marks=pytest.mark.slow)],
)
def test_repairing_an_extracted_team_again_gives_the_same_bytes(place, episodes, tmp_path, capsys):
    folder = GENERATED / place
    made = ["repair", str(folder / "extracted.json"), "--max-depth", "6", "--episodes", episodes, "-o", str(tmp_path)]
    assert main.run(made) == 0
    names = {path.name for path in folder.iterdir()} - {"README.md", "extracted.json"}
    assert names == {path.name for path in tmp_path.iterdir()} - {".maviper.json"}
    for name in names:
        assert (tmp_path / name).read_bytes() == (folder / name).read_bytes(), name
    assert folder != FOLDER or "3 guards, agent_0 for" in capsys.readouterr().err


@pytest.mark.nightly
@pytest.mark.timeout(1_800)
@pytest.mark.parametrize(
    ("world", "place"),
    [
        ("physical-deception", "proved_defenders"),
        ("cooperative-navigation", "proved_navigation"),
        ("predator-prey", "verdicts/predator_prey"),
    ],
)
def test_extracting_again_gives_the_same_bytes(world, place, tmp_path):
    assert main.run(["extract", world, "--seed", "0", "-o", str(tmp_path / "extracted.json")]) == 0
    again, committed = load(tmp_path / "extracted.json"), load(GENERATED / place / "extracted.json")
    made = replace(again.provenance, tool=committed.provenance.tool)  # whichever version made the committed one
    assert dumps(replace(again, provenance=made)) == dumps(committed)


@pytest.mark.compile
def test_the_proved_trees_compile_with_every_check(proved):
    from maviper.compilation.compile import compile_profile

    compiled = compile_profile(proved)
    assert compiled.complete, compiled.report.skipped
