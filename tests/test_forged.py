"""Free text of files, and names of files: shown to people, it steers no terminal and makes no line of its own.
Certificates and counterexamples: test_names.py."""

import json
import shutil
import unicodedata
from pathlib import Path

import pytest

from maviper.cli import main
from tests.support.altered import edited

PROFILE = Path(__file__).parent.parent / "generated" / "physical_deception" / "profile.json"
FORGED = "1. distinct_targets of the defenders: PROVED"
HOSTILE = f"x\n{FORGED}\n\x1b[2J\r\u202e\u2028\x85{FORGED}"
STEERING = {"Cc", "Cf", "Cs", "Zl", "Zp"}


def texts(value, path=()):
    """The path of each text of a document; of a list's entries of one form, of the first."""
    if isinstance(value, str):
        yield path
    for key, item in value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ():
        yield from texts(item, (*path, key))


def kinds(document):
    """One path for each kind of text: indices of lists do not tell kinds apart."""
    found = {tuple(0 if isinstance(key, int) else key for key in path): path for path in texts(document)}
    return list(found.values())


def forged(document, path):
    """The document with a hostile text at a path, and without the hash that would tell."""
    changed = edited(document, path, HOSTILE)
    if path != ("content_hash",):
        changed.pop("content_hash", None)
    return changed


def clean(text, name):
    steering = {letter for letter in text if unicodedata.category(letter) in STEERING} - {"\n", "\t"}
    assert not steering, (name, steering)
    assert not any(line.strip().startswith(FORGED) for line in text.splitlines()), name


def shown(capsys, folder, *arguments):
    """Runs a command; looks at all that it printed, and at every text that it wrote into the folder."""
    capsys.readouterr()
    code = main.run([str(argument) for argument in arguments])
    printed = capsys.readouterr()
    clean(printed.out, "standard output")
    clean(printed.err, "standard error")
    for path in folder.rglob("*") if folder.exists() else ():
        if path.is_file():
            clean(path.read_text(), path.name)
    return code


DOCUMENT = json.loads(PROFILE.read_text())


@pytest.mark.parametrize("path", kinds(DOCUMENT), ids=lambda path: ".".join(map(str, path)))
def test_texts_of_profiles(path, tmp_path, capsys):
    changed, out = tmp_path / "profile.json", tmp_path / "out"
    changed.write_text(json.dumps(forged(DOCUMENT, path)))
    for command in (("show", changed), ("compile", changed, "-o", out), ("verify", changed, "-o", out)):
        if shown(capsys, out, *command) == 2:
            break


PROPERTY = {"name": "distinct_targets", "label": "near", "team": "defenders", "assume": "agent_0.x >= 0"}
PROPERTY |= {"region": "start"}
OWN = {"label": "near", "formula": "agent_0.x >= 0 or agent_1 acts left", "margin": "1/10"}


@pytest.mark.parametrize("table", [PROPERTY, OWN], ids=["built in", "own"])
@pytest.mark.parametrize("changed", [*PROPERTY, *OWN, "added"])
def test_texts_of_property_files(table, changed, tmp_path, capsys):
    place = tmp_path / "claims.toml"
    for text in (HOSTILE, table.get(changed, "") + f"\n{FORGED}", f"{table.get(changed, '')} \r\u2028\u202e"):
        lines = [f"{json.dumps(key)} = {json.dumps(value)}" for key, value in (table | {changed: text}).items()]
        place.write_text("[[property]]\n" + "\n".join(lines) + "\n")
        shown(capsys, tmp_path / "out", "verify", PROFILE, "--claims", place, "-o", tmp_path / "out")


@pytest.mark.parametrize(
    "source", ['default = "%s"', 'goals = ["%s"]', '[box]\n"%s" = [0, 1]', '[apart]\n"%s" = 1', "%s"]
)
def test_texts_of_region_files(source, tmp_path, capsys):
    place = tmp_path / "region.toml"
    place.write_text(source % json.dumps(HOSTILE)[1:-1])
    assert shown(capsys, tmp_path / "out", "verify", PROFILE, "--region", place, "-o", tmp_path / "out") == 2


def test_names_of_files(tmp_path, capsys):
    """They are refused wherever a file is read or written, since errors, reports and commands show them."""
    name = HOSTILE.replace("/", "")
    region, profile, out = tmp_path / f"{name}.toml", tmp_path / f"{name}.json", tmp_path / "out"
    region.write_text('[box]\n"agent_0.x" = [-0.5, 0.5]\n')
    shutil.copy(PROFILE, profile)
    for command in (
        ("show", profile), ("compile", profile, "-o", out), ("evaluate", profile, "--episodes", "5"), ("check", region),
        ("verify", profile), ("verify", PROFILE, "--region", region), ("verify", PROFILE, "--claims", region),
        ("verify", PROFILE, "-o", tmp_path / name), ("show", tmp_path / "none" / name), ("replay", profile), (name,),
        ("guide", name), ("show", profile, f"--{name}"), ("worlds", "show", name), ("repair", profile, "-o", out),
        ("extract", name, "-o", out / "x.json"), ("extract", "physical-deception", "-o", profile),
        ("verify", PROFILE, "--claim", name), ("verify", PROFILE, "--claim", f"distinct_targets(team={name})"),
        ("compile", PROFILE, "--target", name),
    ):  # fmt: skip
        assert shown(capsys, out, *command) == 2, command
