"""The report of `maviper verify --system`: page, text and facts, and what it says where there is no answer."""

import json
import re
import shlex
from fractions import Fraction

import pytest

from codegen.errors import ExitCode
from maviper.cli.main import run as command
from tests.support.stated import BRAKES, CAR, DRIVES, PROPERTIES, profile, verify
from tests.support.systems import CART, MOUNTAIN
from verify.reports.systems import region_facts, sentence, upwards
from verify.systems.files import statement_of
from verify.systems.properties import ensure_claims

ERROR = "[dynamics.error]\nx = [0, 0.01]\n"
FAR = """
[[property]]
label = "never far"
name = "avoids"
region = { box = { x = [4, 5] }, where = ["x + 1[s]*v >= 9"] }
"""
NEVER = '[[property]]\nregion = { box = { x = [1, 2] } }\nformula = "acts(cart) == right"\n'


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    """A folder with a report: proved, violated, decisions proved, unknown, and decisions violated."""
    folder = tmp_path_factory.mktemp("stated")
    (folder / "profile.json").write_text(profile(BRAKES))
    (folder / "cart.toml").write_text(CART + ERROR)
    (folder / "claims.toml").write_text(PROPERTIES + FAR + NEVER)
    asked = ["--claims", str(folder / "claims.toml"), "--set", "max_boxes=100000", "-o", str(folder / "report")]
    assert verify(folder, *asked) == ExitCode.VIOLATED
    return folder / "report"


def test_nothing_is_loaded_and_every_link_leads_to_a_file(place):
    page = (place / "report.html").read_text()
    assert "<script" not in page and "src=" not in page and "http" not in page and "prefers-color-scheme: dark" in page
    links = [link for link in re.findall(r'href="([^"]+)"', page) if not link.startswith("#")]
    assert len(links) >= 4 and all((place / link).exists() for link in links)


def test_the_commands_of_the_page_run_in_its_folder(place, monkeypatch, tmp_path):
    monkeypatch.chdir(place)
    page = (place / "report.html").read_text()
    found = [shlex.split(each)[1:] for each in re.findall(r"<code>(maviper [^<]+)</code>", page)]
    codes = {"check": ExitCode.DONE, "replay": ExitCode.VIOLATED, "verify": ExitCode.VIOLATED}
    assert {words[0] for words in found} == set(codes)
    for words in found:
        more = ["-o", str(tmp_path / "again")] if words[0] == "verify" else []
        assert command([*words, *more]) == codes[words[0]]
    for path in place.iterdir():
        assert (tmp_path / "again" / path.name).read_bytes() == path.read_bytes()


def test_an_unknown_says_what_is_open_and_what_may_help(tmp_path, capsys):
    (tmp_path / "profile.json").write_text(profile(BRAKES))
    (tmp_path / "cart.toml").write_text(CART + ERROR + PROPERTIES.split("[[property]]")[1].join(["[[property]]", ""]))
    asked = ["--set", "max_boxes=1", "-o", str(tmp_path / "report")]
    assert verify(tmp_path, *asked) == ExitCode.INCONCLUSIVE
    told = json.loads((tmp_path / "report" / "report.json").read_text())["results"][0]
    assert told["open"]["bounds"].keys() == {"x", "v"}
    texts = [(tmp_path / "report" / f"report.{kind}").read_text() for kind in ("txt", "html")]
    for text in ("".join(capsys.readouterr()), *texts):
        assert "stopped after 1 box" in text and "without a proof: the budget is 1 boxes" in text
        assert re.search(rf"step {told['open']['step']} of 10", text) and re.search(r"v in \[\S+, \S+\]", text)
        assert "a larger --effort" in text and "fewer steps" in text and "smaller errors" in text


def test_verdicts_alone(tmp_path, capsys, monkeypatch):
    """On standard output, and about the statement alone: the environment is not run."""
    monkeypatch.setattr("maviper.verification.games.deviation", lambda statement: pytest.fail("it was measured"))
    (tmp_path / "profile.json").write_text(profile(DRIVES))
    (tmp_path / "cart.toml").write_text(MOUNTAIN + CAR)
    assert verify(tmp_path, "--verdict-only") == ExitCode.VIOLATED
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in lines] == ["PROVED", "VIOLATED"]
    assert all("of the stated dynamics, with a per-step error of at most" in line for line in lines)
    assert verify(tmp_path, "--verdict-only", "--json") == ExitCode.VIOLATED
    told = json.loads(capsys.readouterr().out)
    assert [each["verdict"] for each in told["results"]] == ["PROVED", "VIOLATED"] and "stated" in told["of"]
    for more in (["-o", str(tmp_path / "report")], ["--run-reference"]):
        assert verify(tmp_path, "--verdict-only", *more) == ExitCode.INPUT
        assert "--verdict-only" in capsys.readouterr().err
    assert not (tmp_path / "report").exists()


def test_a_claim_that_shuffled_leaves_fulfil_is_told_to_be_weak(tmp_path, capsys):
    """On the terminal, in the text and on the page; of one that they break nothing is said."""
    (tmp_path / "profile.json").write_text(profile(BRAKES))
    (tmp_path / "cart.toml").write_text(CART + PROPERTIES)
    verify(tmp_path, "-o", str(tmp_path / "report"))
    weak = "says little about these trees"
    texts = [(tmp_path / "report" / f"report.{kind}").read_text() for kind in ("txt", "html")]
    assert [text.count(weak) for text in ("".join(capsys.readouterr()), *texts)] == [1, 1, 1]


def test_a_folder_is_refused_before_the_environment_is_measured(tmp_path, capsys, monkeypatch):
    """Steps of an environment take seconds, which nobody waits for to hear that a file is in the way."""
    monkeypatch.setattr("maviper.verification.games.deviation", lambda statement: pytest.fail("it was measured"))
    (tmp_path / "profile.json").write_text(profile(DRIVES))
    (tmp_path / "cart.toml").write_text(MOUNTAIN + CAR)
    (tmp_path / "report").mkdir()
    (tmp_path / "report" / "world.toml").write_text("mine")
    assert verify(tmp_path, "-o", str(tmp_path / "report")) == ExitCode.INPUT
    assert "world.toml" in capsys.readouterr().err and (tmp_path / "report" / "world.toml").read_text() == "mine"


def test_errors_are_never_told_smaller_than_they_are():
    for number in (Fraction(1, 3), Fraction(2, 3), Fraction(10**12 + 1, 10**12), Fraction(1, 10**400), Fraction(0)):
        assert number <= Fraction(upwards(number)) <= number * (1 + Fraction(1, 10**5))
    assert upwards(2.220446049250313e-16, 2) == "2.3e-16" and upwards(Fraction(1, 100)) == "0.01"
    source = CART + "[dynamics.error]\nv = 0.12345678\n"
    assert sentence(statement_of(source, "cart").system).endswith("v 0.123457")


def test_a_region_in_bounds_and_conditions():
    found = region_facts(
        statement_of(CART.replace("[start]", '[start]\nwhere = ["2*x - 1[s]*v <= 1/3"]'), "cart").system.start
    )
    assert found["box"] == {"x": ["-1", "1"], "v": ["0", "0"]}
    assert found["conditions"] == ["-v + 2*x <= 1/3"]
    assert ensure_claims(statement_of(CART + FAR, "cart"), "cart") == 1
