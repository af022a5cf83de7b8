"""The command `maviper check`: accepted, refused, unreadable, about another policy."""

import json
import re
from dataclasses import replace
from pathlib import Path

import pytest

from codegen import policy_json
from maviper.cli import main
from maviper.files import runs
from maviper.verification.files.certificates import check_file
from tests.support.altered import altered, read_game, resealed, sealed
from tests.support.episode_cases import arriving
from tests.support.small import small_profile
from tests.support.teams import STAY, team, towards, tree
from verify.certificates.games import to_json
from verify.checker.certificate import MAX_BYTES

pytestmark = [pytest.mark.solver, pytest.mark.usefixtures("few_states_throughout")]
ROOT = Path(__file__).parents[4]


@pytest.fixture(scope="module")
def proved(tmp_path_factory):
    """A folder with a profile of fixed roles, and what `maviper verify -o` wrote about it."""
    place = tmp_path_factory.mktemp("claim")
    roles = team(small_profile(), towards(0, 0), towards(1, 1))
    (place / "profile.json").write_text(policy_json.dumps(roles))
    arguments = ["verify", str(place / "profile.json"), "--claim", "distinct_targets", "--claim", "own_target"]
    assert main.run([*arguments, "-o", str(place)]) == 0
    return place


def test_what_verify_writes_is_accepted(proved, capsys):
    for name in ("certificate-1-distinct_targets.json", "certificate-2-own_target.json"):
        assert main.run(["check", str(proved / name)]) == 0
        said = capsys.readouterr().out
        assert said.startswith("accepted") and said.count("\n") == 1 and "region start" in said
    report = json.loads((proved / "report.json").read_text())
    for result in report["results"]:
        assert [opinion["verdict"] for opinion in result["engines"]] == ["PROVED", "PROVED"]
        assert result["certificate"]["checker"] == "accepted" and result["certificate"]["branches"] > 10
    assert "independent checker accepted" in (proved / "report.txt").read_text()
    assert "independent checker accepted" in (proved / "report.html").read_text()


def test_a_check_tells_how_far_it_is(proved, arrived, monkeypatch, capsys):
    monkeypatch.setattr("maviper.verification.files.systems.STEP", 20)
    monkeypatch.setattr("maviper.console.PLAIN_SECONDS", 0.0)
    for path in (proved / "certificate-1-distinct_targets.json", arrived / "certificate-2-reaches.json"):
        assert main.run(["check", str(path)]) == 0
        said = capsys.readouterr()
        assert re.search(r"^checking +40/\d{2,}  bytes of proof read", said.err, re.MULTILINE)
        assert main.run(["-q", "check", str(path)]) == 0 and capsys.readouterr() == (said.out, "")


def test_a_proof_that_does_not_hold_is_refused_with_1(proved, tmp_path, capsys):
    made = read_game((proved / "certificate-1-distinct_targets.json").read_text())
    proofs = {goal: proof.replace(b"\x02", b"\x01") for goal, proof in made.proof.proofs.items()}
    forged = tmp_path / "forged.json"
    forged.write_text(to_json(altered(made, proofs=proofs)))
    assert main.run(["-q", "check", str(forged), "--profile", str(proved / "profile.json")]) == 1
    said = capsys.readouterr().err
    assert said.startswith("error: the certificate is refused\n") and "goal landmark_0" in said and str(forged) in said


def test_another_policy_is_an_input_error(proved, tmp_path, capsys):
    other = tmp_path / "profile.json"
    other.write_text(policy_json.dumps(team(small_profile(), tree(STAY), towards(1, 1))))
    name = str(proved / "certificate-1-distinct_targets.json")
    assert main.run(["check", name, "--profile", str(other)]) == 2
    assert "another profile" in capsys.readouterr().err


def test_no_certificate_without_a_proof(tmp_path):
    still = team(small_profile(), tree(STAY), tree(STAY))
    (tmp_path / "profile.json").write_text(policy_json.dumps(still))
    assert main.run(["verify", str(tmp_path / "profile.json"), "-o", str(tmp_path / "out")]) == 1
    assert not list((tmp_path / "out").glob("certificate*"))


@pytest.fixture(scope="module")
def arrived(tmp_path_factory):
    """A folder with a profile that arrives, and what `maviper verify -o` wrote about its episodes."""
    place = tmp_path_factory.mktemp("episodes")
    (place / "profile.json").write_text(policy_json.dumps(team(small_profile(), arriving(0), arriving(1))))
    arguments = ["verify", str(place / "profile.json"), "--claim", "own_target", "--claim", "reaches"]
    assert main.run([*arguments, "-o", str(place)]) == 1  # own_target fails
    return place


def test_a_proof_about_episodes_is_accepted_and_says_what_it_proves(arrived, capsys):
    name = arrived / "certificate-2-reaches.json"
    assert main.run(["check", str(name)]) == 0
    said = capsys.readouterr().out
    assert said.startswith(
        "accepted  reaches of the defenders at landmark_0 landmark_1, steps 25, radius 0.4, from rest in"
    )
    assert "whatever all others do" in said and said.count("\n") == 1
    result = json.loads((arrived / "report.json").read_text())["results"][1]
    assert result["certificate"]["checker"] == "accepted" and result["certificate"]["branches"] > 1_000
    for page in ("report.txt", "report.html"):
        assert "independent checker accepted" in (arrived / page).read_text()


def test_a_forged_proof_about_episodes_is_refused(arrived, tmp_path, capsys):
    made = read_game((arrived / "certificate-2-reaches.json").read_text())
    sooner = altered(made, claim=replace(made.claim, steps=10))
    forged = tmp_path / "forged.json"
    forged.write_text(to_json(sooner))
    assert main.run(["-q", "check", str(forged), "--profile", str(arrived / "profile.json")]) == 1
    assert capsys.readouterr().err.startswith("error: the certificate is refused\n")
    other = tmp_path / "profile.json"
    other.write_text(policy_json.dumps(team(small_profile(), tree(STAY), towards(1, 1))))
    assert main.run(["check", str(arrived / "certificate-2-reaches.json"), "--profile", str(other)]) == 2
    assert "another profile" in capsys.readouterr().err


def test_a_proof_without_a_certificate_says_so(arrived, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr("verify.episodes.certificates.build_certificate.__defaults__", (100,))
    arguments = ["verify", str(arrived / "profile.json"), "--claim", "reaches", "-o", str(tmp_path)]
    assert main.run(arguments) == 0
    assert not list(tmp_path.glob("certificate*"))
    said = "one reading, no certificate: its proof takes more than"
    assert said in (tmp_path / "report.txt").read_text() and said in (tmp_path / "report.html").read_text()
    assert said in capsys.readouterr().out


@pytest.mark.parametrize("start", ["", '{"certificate":"maviper-episode-certificate-1","region":'])
def test_texts_of_endless_depth_are_input_errors(arrived, tmp_path, capsys, start):
    (tmp_path / "deep.json").write_text(start + '{"a":' * 100_000)
    assert main.run(["-q", "check", str(tmp_path / "deep.json"), "--profile", str(arrived / "profile.json")]) == 2
    assert capsys.readouterr().err.startswith("error: ")


def test_a_formula_about_nobody_is_told_as_that(proved, tmp_path, capsys):
    (tmp_path / "p.toml").write_text('[[property]]\nformula = "agent_0.x <= 1"\n')
    asked = ["verify", str(proved / "profile.json"), "--claims", str(tmp_path / "p.toml")]
    assert main.run(["-q", *asked, "-o", str(tmp_path)]) == 0
    arguments = ["check", str(tmp_path / "certificate-1-formula.json"), "--profile", str(proved / "profile.json")]
    assert main.run(arguments) == 0
    assert "a formula that speaks of no agent's actions in region start" in capsys.readouterr().out


@pytest.mark.parametrize("name", ["start", "start\u200b", "everywhere"])
def test_a_region_is_the_start_region_by_its_bounds_alone(proved, arrived, tmp_path, capsys, name):
    def narrower(document):
        document["region"]["name"] = name
        document["region"]["box"]["agent_0.x"] = ["-1", "1/2"]

    def renamed(document):
        document["region"]["name"] = name

    narrow = [*(["verify", str(proved / "profile.json"), "--region"]), str(tmp_path / "narrow.toml")]
    (tmp_path / "narrow.toml").write_text('[box]\n"agent_0.x" = [-1, 0.5]\n')
    assert main.run(["-q", *narrow, "-o", str(tmp_path)]) == 0
    capsys.readouterr()
    kinds = (
        (tmp_path / "certificate-1-distinct_targets.json", renamed, "the region ("),
        (proved / "certificate-1-distinct_targets.json", renamed, "region start"),
        (arrived / "certificate-2-reaches.json", renamed, "region start"),
    )
    for path, change, said in kinds:
        beside = arrived if path.parent == arrived else proved
        (tmp_path / "named.json").write_text(resealed(path.read_text(), change))
        assert main.run(["check", str(tmp_path / "named.json"), "--profile", str(beside / "profile.json")]) == 0
        out = capsys.readouterr().out
        assert said in out and (said == "region start") == ("start" in out)
    read = read_game(resealed((proved / "certificate-1-distinct_targets.json").read_text(), narrower))
    assert read.header.region.name == "" and read.header.region.said == name
    read = read_game(resealed((arrived / "certificate-2-reaches.json").read_text(), narrower))
    assert read.header.region.name == "" and read.header.region.said == name


def test_certificates_read_back_to_the_same_bytes():
    rooms = ("arch", "differences", "worlds")  # whose certificates have other forms
    stated = {path for room in rooms for path in ROOT.glob(f"generated/{room}/**/*.json*")}
    found = sorted(set(ROOT.glob("generated/**/certificate-*.json*")) - stated)
    assert len(found) > 5 and any(path.suffix == runs.PACKED for path in found)
    for path in found:
        data = runs.read_unpacked(path, MAX_BYTES)
        assert to_json(read_game(data)).encode() == data


def test_regions_state_nothing_that_is_not_read(arrived, tmp_path, capsys):
    document = json.loads((arrived / "certificate-2-reaches.json").read_text())
    document["region"]["assume"] = "nobody moves"
    (tmp_path / "edited.json").write_text(sealed(document))
    assert main.run(["check", str(tmp_path / "edited.json"), "--profile", str(arrived / "profile.json")]) == 2
    assert "assume" in capsys.readouterr().err


@pytest.mark.parametrize("name", ["certificate-2-decides.json", "episodes/certificate-1-stays_in.json"])
def test_a_proof_about_a_game_is_checked_beside_the_games_own_claims(name, capsys):
    """The property file beside it is about the game, and not about the system that its world file states."""
    folder = ROOT / "generated" / "differences"
    assert main.run(["check", str(folder / name), "--profile", str(folder / "profile.json")]) == 0
    assert "(in the file: " in capsys.readouterr().out


def test_a_label_is_what_the_world_file_says(tmp_path):
    """A certificate with another label proves the same, and nobody is told what it calls itself."""
    folder = ROOT / "generated" / "differences"
    document = json.loads((folder / "certificate-2-decides.json").read_text())
    document["claim"]["label"] = "nobody ever crashes"
    (tmp_path / "edited.json").write_text(sealed(document))
    subject = check_file(tmp_path / "edited.json", folder / "profile.json", world=folder / "world.toml").subject
    assert subject.startswith("decides (in the file: 'below the landmarks, nobody moves down, region of property 2')")
    assert "crashes" not in subject
