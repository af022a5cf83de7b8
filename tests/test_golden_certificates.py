"""Every certificate ever written is accepted for ever: one of each form, as it was written on its day."""

import json
from pathlib import Path

import pytest

from codegen.errors import InputError
from maviper.cli import main
from tests.support.altered import read_game, sealed
from verify.checker.systems.proofs import from_json

FOLDER = Path(__file__).parent / "golden" / "certificates"
FORMS = [f"{about}certificate-{number}" for about in ("", "episode-", "system-") for number in (1, 2, 3, 4)]


def test_there_is_one_of_each_form():
    assert sorted(place.name for place in FOLDER.iterdir()) == sorted(FORMS)


@pytest.mark.parametrize("form", FORMS)
def test_certificates_of_each_form_are_accepted(form, capsys):
    file = FOLDER / form / "certificate.json"
    assert json.loads(file.read_text())["certificate"] == f"maviper-{form}"
    assert main.run(["check", str(file)]) == 0
    assert capsys.readouterr().out.startswith("accepted")


@pytest.mark.parametrize("form", FORMS)
def test_changed_certificates_of_each_form_are_refused(form, tmp_path, capsys):
    """An edited file is refused, and one of another form is not taken for this one."""
    folder = FOLDER / form
    text = (folder / "certificate.json").read_text()
    for wrong in (
        text.replace('"inhabitant": {', '"inhabitant": {"nobody": "0",', 1),
        text.replace("-certificate-", "-certificate-9"),
    ):
        (tmp_path / "certificate.json").write_text(wrong)
        world = ["--system", str(folder / "world.toml")] if (folder / "world.toml").exists() else []
        given = ["check", str(tmp_path / "certificate.json"), "--profile", str(folder / "profile.json"), *world]
        assert main.run(given) == 2
        assert "error: " in capsys.readouterr().err


LEVELS = {"all": []}
for _ in range(300):
    LEVELS = {"not": LEVELS}
# by form, what its own members may not be: members of members, or others in their place
ODD = {
    "certificate-1": [
        {"region": {"box": {"agent_0.x": ["low", "high"]}}}, {"semantics": "roughly"}, {"formula": LEVELS},
        {"property": {"name": "always_right"}}, {"property": {"colour": "red"}}, {"proofs": {"landmark_0": ["!!!!"]}},
    ],
    "certificate-2": [{"formula": ["maybe"]}],
    "certificate-3": [{"premises": [{}]}, {"premises": "none"}],
    "certificate-4": [{"premises": [{}]}, {"semantics": ""}],
    "episode-certificate-1": [{"steps": "soon"}, {"radius": "far"}, {"parts": [{}]}],
    "episode-certificate-2": [{"parts": [{}]}, {"landmarks": None}],
    "episode-certificate-3": [{"parts": ["?"]}, {"property": "keeps_apart"}],
    "episode-certificate-4": [{"steps": "never"}, {"edges": {"agent_0.x": "1"}}, {"team": 3}],
    "system-certificate-1": [{"claim": {"kind": "decided"}}, {"claim": {"name": "otherwise"}}],
    "system-certificate-2": [
        {"sets": "clouds"}, {"claim": {"kind": "decides", "name": "decides"}}, {"cells": {"x": "1/0"}}, {"cuts": ["?"]},
    ],
    "system-certificate-3": [{"order": "4"}, {"at_samples": None}, {"cuts": ["?"]}, {"claim": {"name": "otherwise"}}],
    "system-certificate-4": [{"claim": {"kind": "stays_in", "name": "stays_in"}}, {"parts": [{}]}],
}  # fmt: skip
MEMBERS = "not a certificate|does not hold what it should|another version"
NUMBERS = ("wide", "1/0", "1" * 5_000, "1e999999999")


@pytest.mark.parametrize("form", FORMS)
def test_damaged_texts_of_each_form_are_told(form):
    """Texts that are cut or edited, with members that are missing, too many or odd: where, and what to do next."""
    text, read = (FOLDER / form / "certificate.json").read_text(), from_json if "system" in form else read_game
    body = json.loads(text)
    assert read(text, "claim.json").header.certificate == body["certificate"]
    stated, name = body.pop("content_hash"), next(iter(body["inhabitant"]))
    damaged = [("truncated", text[: len(text) // 2]), ("not a certificate", '{"agents": []}')]
    damaged.append(("edited", json.dumps(body | {"content_hash": stated[::-1]})))
    damaged.append(("another version|not a certificate", sealed(body | {"certificate": "maviper-certificate-99"})))
    damaged += [(MEMBERS, sealed({key: value for key, value in body.items() if key != less})) for less in body]
    damaged.append(("not a certificate", sealed(body | {"more": 1})))
    numbers = [body | {"inhabitant": body["inhabitant"] | {name: number}} for number in NUMBERS]
    damaged += [("does not hold what it should", sealed(odd)) for odd in numbers]
    for odd in ODD[form]:
        parts = {key: body[key] | each if isinstance(each, dict) else each for key, each in odd.items()}
        damaged.append((MEMBERS, sealed(body | parts)))
    deep = '{"not": ' * 9_000 + '{"all": []}' + "}" * 9_000
    damaged += [("certificate", text.replace('"formula": {', f'"formula": {deep}, "old": {{', 1))] * ("formula" in body)
    for what, wrong in damaged:
        with pytest.raises(InputError, match=what) as raised:
            read(wrong, "claim.json")
        assert "claim.json" in raised.value.where and raised.value.next_step, wrong[:200]
