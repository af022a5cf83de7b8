"""The command `maviper check`: accepted, refused, unreadable, about another policy."""

import json
from dataclasses import replace

import pytest

from codegen import policy_json
from maviper import cli
from tests.courses import arriving
from tests.teams import STAY, team, towards, tree
from tests.test_golden import small_profile
from verify import certificate, episode_certificate

pytestmark = pytest.mark.solver


@pytest.fixture(scope="module")
def proved(tmp_path_factory):
    """A folder with a profile of fixed roles, and what `maviper verify -o` wrote about it."""
    place = tmp_path_factory.mktemp("claim")
    roles = team(small_profile(), towards(0, 0), towards(1, 1))
    (place / "profile.json").write_text(policy_json.dumps(roles))
    arguments = ["verify", str(place / "profile.json"), "--property", "distinct_targets", "--property", "own_target"]
    assert cli.run([*arguments, "-o", str(place)]) == 0
    return place


def test_what_verify_writes_is_accepted(proved, capsys):
    for name in ("certificate-1-distinct_targets.json", "certificate-2-own_target.json"):
        assert cli.run(["check", str(proved / name)]) == 0
        said = capsys.readouterr().out
        assert said.startswith("accepted") and said.count("\n") == 1 and "region start" in said
    report = json.loads((proved / "report.json").read_text())
    for result in report["results"]:
        assert [opinion["verdict"] for opinion in result["engines"]] == ["PROVED", "PROVED"]
        assert result["certificate"]["checker"] == "accepted" and result["certificate"]["branches"] > 10
    assert "independent checker accepted" in (proved / "report.txt").read_text()
    assert "independent checker accepted" in (proved / "report.html").read_text()


def test_a_proof_that_does_not_hold_is_refused_with_1(proved, tmp_path, capsys):
    made = certificate.from_json((proved / "certificate-1-distinct_targets.json").read_text())
    proofs = {goal: proof.replace(b"\x02", b"\x01") for goal, proof in made.proofs.items()}
    forged = tmp_path / "forged.json"
    forged.write_text(certificate.to_json(certificate.Certificate(**{**vars(made), "proofs": proofs})))
    assert cli.run(["check", str(forged), "--profile", str(proved / "profile.json")]) == 1
    said = capsys.readouterr().err
    assert said.startswith("error: the certificate is refused\n") and "goal landmark_0" in said and str(forged) in said


def test_another_policy_is_an_input_error(proved, tmp_path, capsys):
    other = tmp_path / "profile.json"
    other.write_text(policy_json.dumps(team(small_profile(), tree(STAY), towards(1, 1))))
    name = str(proved / "certificate-1-distinct_targets.json")
    assert cli.run(["check", name, "--profile", str(other)]) == 2
    assert "another policy" in capsys.readouterr().err


def test_no_certificate_without_a_proof(tmp_path):
    still = team(small_profile(), tree(STAY), tree(STAY))
    (tmp_path / "profile.json").write_text(policy_json.dumps(still))
    assert cli.run(["verify", str(tmp_path / "profile.json"), "-o", str(tmp_path / "out")]) == 1
    assert not list((tmp_path / "out").glob("certificate*"))


@pytest.fixture(scope="module")
def arrived(tmp_path_factory):
    """A folder with a profile that arrives, and what `maviper verify -o` wrote about its episodes."""
    place = tmp_path_factory.mktemp("episodes")
    (place / "profile.json").write_text(policy_json.dumps(team(small_profile(), arriving(0), arriving(1))))
    arguments = ["verify", str(place / "profile.json"), "--property", "own_target", "--property", "reaches"]
    assert cli.run([*arguments, "-o", str(place)]) == 1  # own_target fails
    return place


def test_a_proof_about_episodes_is_accepted_and_says_what_it_proves(arrived, capsys):
    name = arrived / "certificate-2-reaches.json"
    assert cli.run(["check", str(name)]) == 0
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
    made = episode_certificate.from_json((arrived / "certificate-2-reaches.json").read_text())
    sooner = replace(made, claim=replace(made.claim, steps=10))
    forged = tmp_path / "forged.json"
    forged.write_text(episode_certificate.to_json(sooner))
    assert cli.run(["check", str(forged), "--profile", str(arrived / "profile.json")]) == 1
    assert capsys.readouterr().err.startswith("error: the certificate is refused\n")
    other = tmp_path / "profile.json"
    other.write_text(policy_json.dumps(team(small_profile(), tree(STAY), towards(1, 1))))
    assert cli.run(["check", str(arrived / "certificate-2-reaches.json"), "--profile", str(other)]) == 2
    assert "another policy" in capsys.readouterr().err


def test_a_proof_without_a_certificate_says_so(arrived, tmp_path, monkeypatch):
    monkeypatch.setattr("verify.episode_certificate.made.__defaults__", (100,))
    arguments = ["verify", str(arrived / "profile.json"), "--property", "reaches", "-o", str(tmp_path)]
    assert cli.run(arguments) == 0
    assert not list(tmp_path.glob("certificate*"))
    assert "no certificate: its proof takes more than" in (tmp_path / "report.txt").read_text()


@pytest.mark.parametrize("start", ["", '{"certificate":"maviper-episode-certificate-1","region":'])
def test_texts_of_endless_depth_are_input_errors(arrived, tmp_path, capsys, start):
    (tmp_path / "deep.json").write_text(start + '{"a":' * 100_000)
    assert cli.run(["check", str(tmp_path / "deep.json"), "--profile", str(arrived / "profile.json")]) == 2
    assert capsys.readouterr().err.startswith("error: ")


def test_regions_state_nothing_that_is_not_read(arrived, tmp_path, capsys):
    document = json.loads((arrived / "certificate-2-reaches.json").read_text())
    del document["content_hash"]
    document["region"]["assume"] = "nobody moves"
    document["content_hash"] = certificate.body_hash(document)
    (tmp_path / "edited.json").write_text(json.dumps(document))
    assert cli.run(["check", str(tmp_path / "edited.json"), "--profile", str(arrived / "profile.json")]) == 2
    assert "assume" in capsys.readouterr().err
