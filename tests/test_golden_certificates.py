"""Every certificate ever written is accepted for ever: one of each form, as it was written on its day."""

import json
from pathlib import Path

import pytest

from maviper.cli import main

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
