"""Where results go is judged before the work: every command that writes, and every way in which its place is wrong."""

import importlib.util
import re
import shutil
from pathlib import Path

import pytest

from codegen import policy_json
from codegen.errors import ExitCode
from maviper.cli import main
from maviper.extraction import exploiting
from tests.support.observations import blind
from tests.support.teams import tree
from tests.support.verifying import every_command

ROOT = Path(__file__).parents[3]
GAME = ROOT / "generated" / "verdicts" / "physical_deception"
CLAIM = '[[property]]\nlabel = "q"\nformula = "angle < 0.25 implies acts(cart) == left"\n'
STATES = "states-1-distinct_targets.json"
FOLDERS = {  # command -> its work, its arguments, and files that another may have put there
    "compare": ("maviper.reproduction.compare.make_cells", "physical-deception", ("best.json", "cells.csv")),
    "compile": ("maviper.compilation.compile.compile_and_prove", "cart.json", ()),
    "demo": ("maviper.tour._extract_trees", "", ("profile.json", "report.html")),
    "diff": ("maviper.verification.diff.compare_profiles", "cart.json other.json", ("difference.json", "against.json")),
    "extract": ("maviper.extraction.run._find", "physical-deception", ("profile.json",)),
    "repair": ("maviper.verification.repair.repair_profile", "game.json", ("repair.json", "profile.json")),
    "reproduce": ("maviper.reproduction.run.make_cells", "--quick", ("report.html", "cells.csv", "figures")),
    "verify --claim": ("maviper.verification.robust.robust", "robust(observations=rows.csv) cart.json", ("radii.csv",)),
    "train": ("maviper.experts.training.train.train", "physical-deception", ("expert.safetensors", "config.json")),
    "verify": ("maviper.verification.run.verify_questions", "cart.json --claims claim", ("report.json",)),
}
FILES = {  # command -> its work, its arguments
    "edit": ("maviper.importing.edits.change_threshold", "cart.json cart/0=0.25"),
    "import": ("maviper.importing.trees.import_trees", "policy.py"),
    "play": ("maviper.page.document.usual_claims", "game.json"),
    "verify --new": ("maviper.verification.starters.starter", "physical-deception"),
    "show": ("maviper.evaluation.show.rules", "game.json"),
    "show --format svg": ("maviper.page.page.svg", "game.json"),
    "show --format html": ("maviper.page.document.usual_claims", "game.json"),
}
GIVEN = (  # command lines; the file in `out` is given, and its content that of the file after the colon
    ("compile", "out/watched.json:game.json --target c,json --pass merge --prefix watched -o out"),
    ("compile", "game.json --target monitor --certificate out/watched.h:game.json --prefix watched -o out"),
    ("diff", "out/difference.json:cart.json other.json -o out"),
    ("diff", "cart.json out/certificate.json:other.json -o out"),
    ("diff", "out/against.json:cart.json out/profile.json:other.json -o out"),
    ("diff", "cart.json other.json --region out/play.html:region -o out"),
    ("extract", "physical-deception --counterexamples out/profile.json:game.json -o out/profile.json"),
    ("extract", "physical-deception --counterexamples out/refit.json:game.json -o out/profile.json"),
    ("extract", f"physical-deception --counterexamples out -o out/{STATES}:game.json"),
    ("import", "out/policy.py:policy.py -o out/policy.py"),
    ("play", "game.json --certificate out/proof:game.json -o out/proof"),
    ("play", "out/game.json:game.json -o out/../out/game.json"),
    ("play", "game.json --world out/world.toml:region -o out/world.toml"),
    ("repair", "out/profile.json:game.json -o out"),
    ("repair", "out/report.html:game.json -o out"),
    ("repair", "game.json --region out/report.txt:region -o out"),
    ("verify --claim", "robust(observations=out/radii.csv:rows.csv) cart.json -o out"),
    ("verify --claim", "robust(observations=rows.csv,certify=true) out/certificate-1-robust.json:cart.json -o out"),
    ("show", "out/game.json:game.json -o out/game.json"),
    ("show --format html", "out/game.json:game.json -o out/game.json"),
    ("verify", "out/report.html:cart.json --claims claim -o out"),
    ("verify", "out/certificate-1-formula.json:cart.json --claims claim -o out"),
    ("verify", "cart.json --claims out/play.html:claim -o out"),
    ("verify", "game.json --region out/report.txt:region -o out"),
)


def run(line, *more):
    return main.run(["-q", *line.split(), *map(str, more)])


@pytest.fixture
def place(tmp_path, monkeypatch):
    """Files to give, and an empty folder `out`."""
    for name, threshold in (("cart.json", 0.0), ("other.json", 0.5)):
        cart = blind({"cart": tree((0, threshold, 1, 2), 0, 2)})
        (tmp_path / name).write_text(policy_json.dumps(cart))
    shutil.copy(GAME / "profile.json", tmp_path / "game.json")
    (tmp_path / "claim").write_text(CLAIM)
    (tmp_path / "region").write_text('[box]\n"agent_0.x" = [-0.5, 0.5]\n')
    (tmp_path / "rows.csv").write_text("angle\n0.1\n")
    (tmp_path / "policy.py").write_text("def cart(x):\n    return 1 if x[0] > 0.5 else 0\n")
    (tmp_path / "out").mkdir()
    monkeypatch.chdir(tmp_path)
    return tmp_path


def forbid(command, monkeypatch):
    """Lets a command fail once its work begins; skips what needs torch where that is missing."""
    if command == "train" and importlib.util.find_spec("torch") is None:
        pytest.skip("needs the extra maviper[train]")
    monkeypatch.setattr((FOLDERS | FILES)[command][0], lambda *_, **__: pytest.fail("the work began"))


def test_all_commands_that_write_are_asked():
    writing = {" ".join(p) for p, command in every_command() if any(each.name == "output" for each in command.params)}
    assert writing == {*FOLDERS, *(name.partition(" --")[0] for name in FILES)} - {"verify --claim"}


def fill(place, kind):
    """A place for results where there can be none, for root too."""
    if kind == "a name too long":
        return place / ("x" * 300)
    if kind == "not a file system":
        return Path("/proc/maviper")
    (place / "taken").write_text("here first")
    return place / "taken" / "deeper" if kind == "a file above" else place / "taken"


@pytest.mark.parametrize("kind", ["a file in the way", "a file above", "a name too long", "not a file system"])
@pytest.mark.parametrize("command", FOLDERS)
def test_a_folder_that_cannot_be(place, command, kind, monkeypatch):
    forbid(command, monkeypatch)
    out, before = fill(place, kind), sorted(place.rglob("*"))
    assert run(f"{command} {FOLDERS[command][1]} -o", out) == ExitCode.INPUT
    assert sorted(place.rglob("*")) == before


@pytest.mark.parametrize("kind", ["a folder in the way", "a file above", "a name too long", "not a file system"])
@pytest.mark.parametrize("command", [*FILES, "extract"])
def test_a_file_that_cannot_be(place, command, kind, monkeypatch, capsys):
    forbid(command, monkeypatch)
    out = fill(place, kind).with_suffix(".json")
    if kind == "a folder in the way":
        (out := place / "folder.json").mkdir()
    assert run(f"{command} {(FOLDERS | FILES)[command][1]} -o", out) == ExitCode.INPUT
    assert (f"-o {out}/" in capsys.readouterr().err) == (kind == "a folder in the way")


@pytest.mark.parametrize(
    ("command", "name"), [(command, name) for command, (*_, names) in FOLDERS.items() for name in names]
)
def test_a_file_of_somebody_else(place, command, name, monkeypatch):
    forbid(command, monkeypatch)
    (place / "out" / name).write_text("{}")
    assert run(f"{command} {FOLDERS[command][1]} -o out") == ExitCode.INPUT
    assert [path.name for path in (place / "out").iterdir()] == [name] and (place / "out" / name).read_text() == "{}"


@pytest.mark.parametrize(("command", "line"), GIVEN)
def test_a_file_that_was_given(place, command, line, monkeypatch, capsys):
    forbid(command, monkeypatch)
    for path, source in re.findall(r"(out/[\w.-]+):([\w.]+)", line):
        shutil.copy(place / source, place / path)
        line = line.replace(f":{source}", "")
    before = {path: path.read_bytes() for path in (place / "out").iterdir()}
    assert before and run(f"{command} {line}") == ExitCode.INPUT
    assert {path: path.read_bytes() for path in (place / "out").iterdir()} == before
    told = capsys.readouterr().err
    assert any(words in told for words in ("written over the input", "would overwrite the file", "be overwritten by"))


def test_what_stays_as_it_is_may_be_given(place, monkeypatch):
    """The profile that results lie beside, and code that is the profile."""
    began = []
    for line in (
        "verify out/profile.json --claims out/claim -o out",
        "diff out/profile.json out/against.json -o out",
        "compile out/watched.json --target json --prefix watched -o out",
        "compile out/watched.json --target c --pass merge --prefix watched -o out",
        "verify --claim robust(observations=out/changes.csv) out/certificate-1-robust.json -o out",
    ):
        command = next(each for each in sorted(FOLDERS, reverse=True) if line.startswith(each))
        for name in ("profile.json", "against.json", "watched.json", "certificate-1-robust.json"):
            shutil.copy(place / "cart.json", place / "out" / name)
        shutil.copy(place / "claim", place / "out" / "claim")
        shutil.copy(place / "rows.csv", place / "out" / "changes.csv")
        monkeypatch.setattr(FOLDERS[command][0], lambda *_, **__: began.append(1) or (_ for _ in ()).throw(KeyError))
        run(line)
    assert len(began) == 5


@pytest.mark.solver
def test_what_the_manual_says_is_replaced(place):
    """A file that `-o` names, code, and pages beside the first of the results."""
    for name in ("rules.txt", "watched.h", "report.html", "report.txt"):
        (place / "out" / name).write_text("here first")
    for line in (
        "show cart.json -o out/rules.txt",
        "compile cart.json --target c --prefix watched -o out",
        "verify cart.json --claims claim -o out",
    ):
        assert run(line) != ExitCode.INPUT
    assert not any(path.read_bytes() == b"here first" for path in (place / "out").iterdir())


def test_networks_that_cannot_be_trained_are_known_before_a_tree_is_refined(place, monkeypatch):
    """Since torch is missing, or a file is in the way of their folder."""
    monkeypatch.setattr(exploiting, "refine_responder", lambda *_: pytest.fail("the work began"))
    code = run("evaluate game.json --exploit defenders --networks", fill(place, "a file above"))
    assert code == (ExitCode.MISSING if importlib.util.find_spec("torch") is None else ExitCode.INPUT)
