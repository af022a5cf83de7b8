"""generated/worlds/: systems that files state, with experts, extracted trees, certificates and counterexamples."""

import json
import re
import sys
from pathlib import Path

import pytest

from codegen.errors import ExitCode
from maviper.cli.main import run as command
from maviper.files.profiles import load
from maviper.verification.ask import VerifyOptions
from maviper.verification.run import verify_world
from maviper.worlds.stated.certified import ensure_plays
from maviper.worlds.stated.deviation import deviation
from maviper.worlds.stated.systems import read
from tests.maviper.page.browsers import overhang
from verify.checker.systems import enclosures
from verify.reports import systems as report
from verify.result import Verdict
from verify.systems.files import statement_of

PLACE = Path(__file__).parent.parent / "generated" / "worlds"
TEXT = (PLACE / "README.md").read_text()
VERDICTS = dict(re.findall(r"^\| `(\w+)` .*\| (PROVED|VIOLATED|UNKNOWN) *\|$", TEXT, re.MULTILINE))


AGAIN = [1.0903961658477783, 1.4916634559631348, 0.0, 0.0, 0.0]  # thresholds of `right` in today's corridor


def profile_of(name):
    return PLACE / f"{name.removesuffix('_wide')}.json"


def test_the_table_has_every_world():
    assert sorted(VERDICTS) == sorted(path.stem for path in PLACE.glob("*.toml"))
    assert sorted(VERDICTS) == sorted(
        path.name
        for path in PLACE.iterdir()
        if path.is_dir() and path.name[0] != "_" and path.name not in ("flows", "vcas")
    )


@pytest.mark.parametrize("name", VERDICTS)
def test_what_was_written_is_what_the_table_says(name):
    told = json.loads((PLACE / name / "report.json").read_text())
    assert {each["verdict"] for each in told["results"]} == {VERDICTS[name]}
    assert (PLACE / name / "world.toml").read_bytes() == (PLACE / f"{name}.toml").read_bytes()
    assert (PLACE / name / "profile.json").read_bytes() == profile_of(name).read_bytes()


@pytest.fixture(scope="module", autouse=True)
def _bounds_shown_once():
    """Trees and several certificates are of one world: a bound of it that was shown is not shown again in this file."""
    ensure_within, shown = enclosures._ensure_within, set()

    def ensure_once(expression, form, box, allowed, where):
        asked = expression, form, tuple(sorted(box.items())), allowed
        if asked not in shown:
            ensure_within(expression, form, box, allowed, where)
            shown.add(asked)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(enclosures, "_ensure_within", ensure_once)
        yield


@pytest.mark.parametrize("name", VERDICTS)
def test_trees_play_in_their_worlds(name):
    statement = read(PLACE / f"{name}.toml")
    ensure_plays(load(profile_of(name)), statement)
    assert enclosures.ensure_enclosed(statement) >= 0


@pytest.mark.parametrize("path", sorted(PLACE.glob("*/certificate-*.json")), ids=lambda path: path.parent.name)
def test_certificates_are_accepted(path, capsys):
    assert command(["check", str(path)]) == ExitCode.DONE
    assert "of the stated dynamics" in capsys.readouterr().out


@pytest.mark.parametrize("path", sorted(PLACE.glob("*/counterexample-*.json")), ids=lambda path: path.parent.name)
def test_counterexamples_replay(path):
    assert command(["replay", str(path)]) == ExitCode.VIOLATED


@pytest.mark.parametrize("name", VERDICTS)
def test_reports_are_those_of_their_facts(name):
    told = json.loads((PLACE / name / "report.json").read_text())
    for kind, made in (("json", report.as_json), ("txt", report.as_text), ("html", report.as_html)):
        assert (PLACE / name / f"report.{kind}").read_text() == made(told)
    assert (PLACE / name / "report.html").stat().st_size < 60_000


def test_no_report_is_wider_than_a_phone(tmp_path):
    pages = [PLACE / name / "report.html" for name in VERDICTS]
    assert overhang(pages, tmp_path, 400) == [0] * len(pages)


QUICK = ["pendulum", "corridor", "crossing", "pendulum_wide", pytest.param("quadrotor", marks=pytest.mark.slow)]


@pytest.mark.parametrize("name", QUICK)
def test_the_quick_ones_are_decided_again(name, golden):
    done = verify_world(load(profile_of(name)), VerifyOptions(world=PLACE / f"{name}.toml"))
    assert {result.verdict for result in done.results} == {Verdict(VERDICTS[name])}
    assert set(done.files) == {path.name for path in (PLACE / name).iterdir()}
    golden(f"generated/worlds/{name}", done.files)


@pytest.mark.parametrize("name", ["mountain_car", "cart_pole", "pendulum_v1"])
def test_statements_of_gymnasium_step_as_it_does(name, monkeypatch):
    """Step by step, from all over the ranges; a rule that integrates otherwise is far off."""
    monkeypatch.syspath_prepend(str(PLACE))
    text = (PLACE / f"{name}.toml").read_text()
    found = deviation(statement_of(text, name), 300)
    assert found.steps > 200 and found.placed and not found.beyond
    assert max(abs(end) for ends in found.off.values() for end in ends) < 1e-14
    if name == "pendulum_v1":  # the old speed moves the angle
        other = text.replace("angle + 0.05[s]*after", "angle + 0.05[s]*spin")
        assert deviation(statement_of(other, name), 100).beyond > 90
    sys.modules.pop("experts", None)


@pytest.mark.slow
def test_trees_are_extracted_again(tmp_path, monkeypatch):
    """The commands of README.md, for the world that takes least: other trees than the committed ones, also proved."""
    monkeypatch.chdir(PLACE)
    monkeypatch.syspath_prepend(str(PLACE))
    line = (
        re.search(r"maviper extract experts:\$world (.*?) -o", TEXT, re.S)[1].replace("$depth", "2").replace("\\", "")
    )
    assert command(["extract", "experts:corridor", *line.split(), "-o", str(tmp_path / "again.json")]) == ExitCode.DONE
    sys.modules.pop("experts", None)
    assert load(tmp_path / "again.json").agents[1].tree.threshold.tolist() == AGAIN
    assert command(["verify", str(tmp_path / "again.json"), "--system", "corridor.toml"]) == ExitCode.DONE


def test_certificates_of_the_first_form_are_read(capsys):
    """One that linear programs found, before boxes did."""
    path = Path(__file__).parent / "golden" / "system_certificate_1" / "certificate-1-stays_in.json"
    assert json.loads(path.read_text())["certificate"] == "maviper-system-certificate-1"
    assert command(["check", str(path)]) == ExitCode.DONE
    assert "branches closed" in capsys.readouterr().out
