"""The page on continuous time: its files and commands lead to proofs, as it says."""

import re
import tomllib

import pytest

from codegen.errors import ExitCode
from maviper.cli.main import run as command
from maviper.manual import page
from maviper.worlds.checking import check, new
from maviper.worlds.stated.statements import usable
from verify.systems.files import statement_of

TEXT = page("flows")
BLOCKS = {kind: re.findall(rf"```{kind}\n(.*?)```", TEXT, re.DOTALL) for kind in ("toml", "python")}
NAMES = ("thermostat", "cruise", "balance")


def written(folder):
    """The files of the page, with the one that `maviper worlds new --flow` writes."""
    new(folder / "thermostat.toml", flow=True)
    for name, text in zip(NAMES[1:], BLOCKS["toml"], strict=True):
        (folder / f"{name}.toml").write_text(text)
    for name, text in zip(NAMES, BLOCKS["python"], strict=True):
        (folder / f"{name}.py").write_text(text)


def commands(name):
    """Those that import and prove, and that check."""
    lines = re.findall(rf"^    maviper ((?:import|verify|check) .*\b{name}\b.*)$", TEXT, re.MULTILINE)
    return [line.split() for line in lines]


def test_the_files_can_be_used_and_the_page_names_each(tmp_path):
    written(tmp_path)
    for name in NAMES:
        text = (tmp_path / f"{name}.toml").read_text()
        statement = statement_of(text, name)
        assert statement.system.flow is not None and tomllib.loads(text)["name"] == name
        assert [each[0] for each in commands(name)][:2] == ["import", "verify"]
    assert usable(check(str(tmp_path / "thermostat.toml")))


@pytest.mark.parametrize("name", [NAMES[0], *(pytest.param(name, marks=pytest.mark.slow) for name in NAMES[1:])])
def test_the_commands_prove_the_claims(name, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    written(tmp_path)
    for line in commands(name):
        assert command(line) == ExitCode.DONE, line
    told = "".join(capsys.readouterr())
    claims = tomllib.loads((tmp_path / f"{name}.toml").read_text())["property"]
    assert told.count("PROVED") == len(claims) and "UNKNOWN" not in told
