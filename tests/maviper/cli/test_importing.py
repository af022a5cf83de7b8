"""The command import: it writes a profile that the other commands take, or says why not."""

import pytest

from codegen.errors import ExitCode
from maviper.cli import main
from maviper.files.profiles import load

TEXT = "def act(speed, gap):\n    if gap < 0.5 and speed > 0.1:\n        return 'brake'\n    return 'go'\n"


@pytest.fixture
def place(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "policy.py").write_text(TEXT)
    return tmp_path


def test_an_imported_profile_is_shown_and_compiled(place, capsys):
    assert main.run(["import", "policy.py", "-o", "profile.json", "--world", "road"]) == 0
    said = capsys.readouterr().err
    assert "if/else Python: 3 leaves, 2 features, 2 actions" in said and "no difference" in said
    assert main.run(["show", "profile.json"]) == 0
    assert "speed > 0.1" in capsys.readouterr().out
    assert main.run(["compile", "profile.json", "--target", "json", "-o", "code"]) == ExitCode.DONE
    assert (place / "code" / "road.json").exists()


@pytest.mark.parametrize(
    ("words", "said"),
    [([], "Python's floats"), (["--arrays", "float32"], "float32 arrays"), (["--arrays", "float64"], "float64 arrays")],
)
def test_the_numbers_that_the_file_is_given_are_said(place, capsys, words, said):
    assert main.run(["import", "policy.py", *words, "-o", "profile.json"]) == 0
    line = next(each for each in capsys.readouterr().err.splitlines() if each.startswith("given"))
    assert said in line


def test_a_team_and_its_names(place, capsys):
    words = ["--agents", "a=policy.py, b=policy.py", "--features", "v=speed,d=gap", "--actions", "go,brake"]
    assert main.run(["import", *words, "-o", "profile.json"]) == 0
    profile = load("profile.json")
    assert [policy.agent for policy in profile.agents] == ["a", "b"]
    assert [feature.name for feature in profile.agents[0].features] == ["v", "d"]
    said = capsys.readouterr().err
    assert "0 v <- speed, 1 d <- gap" in said and "0 go, 1 brake" in said


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ([], "give a file, or --agents"),
        (["policy.py", "--agents", "a=policy.py"], "give a file, or --agents"),
        (["--agents", "a"], "give agent=file"),
        (["--agents", "a=policy.py,a=policy.py"], "an agent appears twice"),
        (["policy.py", "--features", "one"], "the source names its features itself: speed, gap"),
        (["policy.txt"], "cannot read the file"),
    ],
)
def test_what_cannot_be_imported(place, capsys, words, said):
    assert main.run(["import", *words, "-o", "profile.json"]) == ExitCode.INPUT
    assert said in capsys.readouterr().err and not (place / "profile.json").exists()
