"""The command `maviper check`: accepted, refused, unreadable, about another policy."""

import json

import pytest

from codegen import policy_json
from maviper import cli
from tests.teams import STAY, team, towards, tree
from tests.test_golden import small_profile
from verify import certificate

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
