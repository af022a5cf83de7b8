"""The record of a reproduction: what lies in it, that it stands alone, and that the committed ones are whole."""

import csv
import hashlib
import json
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from maviper.reproduction import register, report
from maviper.reproduction.cells.table import COLUMNS
from maviper.reproduction.verdicts import AGREES, DIFFERS
from tests.benchmarks import compact
from tests.benchmarks.record import recorded, rows
from tests.maviper.reproduction import tables
from tests.maviper.reproduction.tables import DECEPTION, NAVIGATION
from tests.support.tiers import first_of

ROOT = Path(__file__).parents[3]
RECORDS = ROOT / "generated" / "reproduction"
REPORT = (RECORDS / "README.md").read_text()
COMMITTED = sorted(RECORDS.rglob("claims.json"))
WITH_SCRIPTS = [path.with_name("recompute.py") for path in COMMITTED]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Two games with their report."""
    found = tables.whole(tmp_path_factory.mktemp("finished"), (DECEPTION, NAVIGATION), (4,), seeds=5)
    report.write_report(found)
    return found


@pytest.fixture(scope="module")
def place(folder, tmp_path_factory):
    found = tmp_path_factory.mktemp("record")
    recorded(folder, found, "--experts mappo")
    return found


def contents(place):
    return {path.relative_to(place).as_posix(): path.read_bytes() for path in place.rglob("*") if path.is_file()}


def test_equal_folders_give_equal_records_without_paths_or_times(folder, place, tmp_path):
    (tmp_path / "figures").mkdir()
    (tmp_path / "figures" / "old.svg").write_text("of an earlier record")
    recorded(folder, tmp_path, "--experts mappo")
    assert contents(tmp_path) == contents(place)
    for name, data in contents(place).items():
        assert str(folder).encode() not in data, name
    assert str(folder) not in json.dumps(compact.unpacked(place / compact.FILE))


def test_a_record_says_what_the_episodes_of_each_cell_come_to(folder, place):
    """The table is that of the folder, the hash that of the file of episodes, which `sha256sum` gives too."""
    with (folder / "cells.csv").open(newline="") as file:
        table = sorted(map(tuple, map(dict.values, csv.DictReader(file))))
    ours = sorted(map(tuple, map(dict.values, rows(place))))
    at = COLUMNS.index("mean")
    assert [row[:at] + row[at + 1 :] for row in ours] == [row[:at] + row[at + 1 :] for row in table]
    assert [float(row[at]) for row in ours] == pytest.approx([float(row[at]) for row in table], rel=1e-12)
    cells = compact.unpacked(place / compact.FILE)["cells"]
    assert set(cells) == {path.name for path in (folder / "cells").iterdir()}
    for name, cell in cells.items():
        data = (folder / "cells" / name / "episodes.csv").read_bytes()
        assert cell["sha256"] == hashlib.sha256(data).hexdigest()


def computed_again(place):
    """What the record's own script says of the record's own data."""
    command = [sys.executable, "-I", str(place / "recompute.py")]
    return subprocess.run(command, capture_output=True, text=True, check=False).stdout


def test_numbers_and_verdicts_are_computed_again_from_the_record_alone(place):
    numbers, verdicts = (len(each) for each in (compact.unpacked(place / compact.FILE)["numbers"], judged(place)))
    said = f"{numbers} numbers and {verdicts} verdicts computed again, 0 come out otherwise"
    assert computed_again(place).strip() == said and numbers > 300 and verdicts > 30


def judged(place):
    claims = json.loads((place / report.CLAIMS).read_text())["claims"]
    return [claim for claim in claims if claim["test"] != register.NUMBER]


def test_a_mean_or_a_word_that_was_changed_is_noticed(place, tmp_path):
    for name in (report.SCRIPT, compact.FILE, report.CLAIMS):
        shutil.copy(place / name, tmp_path)
    told = json.loads((tmp_path / report.CLAIMS).read_text())
    claim = next(each for each in told["claims"] if each["verdict"] == AGREES)
    claim["verdict"] = DIFFERS
    (tmp_path / report.CLAIMS).write_text(json.dumps(told))
    assert f"{claim['id']}: AGREES, the report has DIFFERS" in computed_again(tmp_path)
    document = compact.unpacked(place / compact.FILE)
    wanted = {"kind": "extraction", "algorithm": "maviper", "depth": "4", "preset": "paper", "game": DECEPTION}
    cell = next(each for each in document["cells"].values() if wanted.items() <= each["about"].items())
    cell["values"]["joint:defenders"]["defenders success r=0.316"]["mean"] += 0.1
    more = {name: of for name, of in document.items() if name not in ("form", "cells")}
    (tmp_path / compact.FILE).write_bytes(compact.packed(document["cells"], **more))
    assert "joint/maviper/physical-deception" in computed_again(tmp_path)


@pytest.mark.parametrize("path", COMMITTED, ids=lambda path: path.parent.name)
def test_committed_records_are_whole(path):
    told, place = json.loads(path.read_text()), path.parent
    counts = report.counts((claim["id"], claim["verdict"]) for claim in told["claims"])
    assert told["register"] == register.read().sha256 and told["more_claims"] == register.read().more
    assert path.read_text() == report.lay_out_claims(told)
    assert (place / report.SUMMARY).read_text().splitlines()[0] == counts
    assert f"{counts}. " in (place / "README.md").read_text()
    page = (place / report.PAGE).read_text()
    assert f"<strong>{counts}.</strong>" in page and page.count(".x{stroke:currentColor") == 1
    assert (place / compact.FILE).exists()


@pytest.mark.parametrize("path", COMMITTED, ids=lambda path: path.parent.name)
def test_summaries_say_what_the_claims_of_a_record_say(path):
    lines = path.with_name("summary.txt").read_text(encoding="utf-8").splitlines()
    for each in json.loads(path.read_text())["claims"]:
        notes = "; ".join(text for text in (each["reason"], *each["notes"]) if text)
        assert report.summarise_claim(each["verdict"], each["main"], each["id"], notes or each["says"]) in lines


# --- what the README says of them


def test_the_readme_has_the_levels_of_the_records():
    """What experts and trees reach, in the units of the measures."""
    said = re.sub(r" +\|", " |", " ".join((ROOT / "README.md").read_text().split()))
    figures, levels = (RECORDS / "paper" / "figures.txt").read_text(), {}
    for game, measure, team in (
        ("deception", "success", "defenders"),
        ("navigation", "distance left (lower)", "navigation"),
    ):
        for expert in ("MADDPG", "MAPPO"):
            found = re.search(rf"  {team}, {expert}: (\S+) / (\S+) / .*, expert (\S+)\n", figures)
            levels[f"{game}, {expert} | {measure}"] = (found[3], found[2], found[1])
    for row, numbers in levels.items():
        shown = (f"{float(number):.2f}".removeprefix("0") for number in numbers)
        assert f"| {' | '.join((row, *shown))} |" in said


@pytest.mark.parametrize("path", first_of(1, WITH_SCRIPTS), ids=lambda path: path.parent.name)
def test_committed_cells_give_the_recorded_numbers_and_verdicts(path):

    assert path.read_bytes() == WITH_SCRIPTS[0].read_bytes()
    said = computed_again(path.parent)
    assert f" and {len(judged(path.parent))} verdicts computed again, 0 come out otherwise" in said
