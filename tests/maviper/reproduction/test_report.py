"""The report: all parts, the same bytes for the same table, and every number computed again without maviper."""

import json
import re
import shutil
import subprocess
import sys
import xml.etree.ElementTree as ET
from pathlib import Path

import pytest

from codegen.errors import InputError
from maviper.reproduction import report
from maviper.reproduction.cells.table import COLUMNS, read_table
from tests.maviper.reproduction import tables
from tests.maviper.reproduction.tables import DECEPTION, NAVIGATION, Maker

PROFILE = Path(__file__).parents[3] / "generated" / "physical_deception" / "profile.json"
PARTS = ("joint", "individual", "robustness", "ablation", "features", "trees", "exploitability", "reward")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """The default tier of two games, and the report on it."""
    found = tables.whole(tmp_path_factory.mktemp("report"), (DECEPTION, NAVIGATION), seeds=5)
    report.write_report(found)
    return found


def page(folder):
    return (folder / report.PAGE).read_text(encoding="utf-8")


def part(folder, name):
    """The HTML of one part."""
    return re.search(rf'<h2 id="{name}">.*?(?=<h2|\Z)', page(folder), re.DOTALL)[0]


def recomputed(folder):
    command = [sys.executable, "-I", str(folder / report.SCRIPT)]
    return subprocess.run(command, capture_output=True, text=True, check=False, cwd=folder.parent)


def test_all_parts_are_there(folder):
    assert re.findall(r'<h2 id="([a-z]+)">', page(folder)) == ["claims", *PARTS]
    figures = {path.stem for path in (folder / report.FIGURES).glob("*.svg")}
    assert "joint-physical-deception-mappo-defenders-success-r-0-316" in figures
    assert "joint-physical-deception-mappo-defenders-success-r-0-1" in figures
    assert "features-maviper-impurity-mappo" in figures and len(figures) >= 25
    assert page(folder).count("<svg") == len(figures)


def test_what_was_not_run_names_the_command(folder):
    text = part(folder, "trees")
    assert "not run: maviper reproduce" in text and "--depths 2" in text and "<figure" not in text
    assert "predator-prey with" not in page(folder)  # nobody has cells of it, and nothing is said of it


def test_the_page_stands_alone(folder):
    text = page(folder).replace('xmlns="http://www.w3.org/2000/svg"', "")
    assert not re.search(r"https?://|<script|<link|<img|@import|url\(", text)
    assert str(folder) not in text and not re.search(r"\b20\d\d-\d\d-\d\d\b", text)
    for path in (folder / report.FIGURES).glob("*.svg"):
        ET.parse(path)


def test_published_numbers_stand_in_the_same_cell(folder):
    text = part(folder, "robustness")
    assert re.search(r"<td>0\.\d\d \[0\.\d\d, 0\.\d\d\] \| 0\.77 \(0\.01\)</td>", text)  # Table 1, MAVIPER's defenders
    assert re.search(r"<td>0\.\d\d \[0\.\d\d, 0\.\d\d\] \| 0\.93</td>", text)  # Table 4, experts against MAVIPER
    assert "2.40 for fitted Q" in text


def test_ratios_have_the_absolute_values_beside_them(folder):
    rows = re.findall(r"<tr>(.*?)</tr>", part(folder, "joint"))
    row = next(row for row in rows if "defenders success r=0.316" in row and "<td>4</td><td>MAVIPER" in row)
    ratio, trees, expert = (float(cell.split()[0]) for cell in re.findall(r"<td>(.*?)</td>", row)[3:])
    assert ratio == pytest.approx(0.85, abs=0.03) and expert == pytest.approx(0.9, abs=0.02)
    assert trees / expert == pytest.approx(ratio, abs=0.005)


def test_the_summary_has_a_line_for_each_claim(folder):
    lines = (folder / report.SUMMARY).read_text(encoding="utf-8").splitlines()
    told = json.loads((folder / report.CLAIMS).read_text())
    of_claims = [line for line in lines[2:-1] if not line.startswith(" ")]
    assert max(map(len, lines)) <= report.WIDTH
    for claim, line in zip(told["claims"], of_claims, strict=True):
        assert claim["verdict"] in line and claim["id"] in line
    after = lines[lines.index(next(line for line in of_claims if " joint-defenders" in line)) + 1]
    assert after.strip().startswith("by depth: 2 AGREES (")


def test_equal_tables_give_equal_bytes(folder, tmp_path):
    again = tmp_path / "again"
    shutil.copytree(folder, again)
    (again / report.FIGURES / "old.svg").write_text("of an earlier report")
    report.write_report(again)

    def files(place):
        return {path.relative_to(place): path.read_bytes() for path in place.rglob("*") if path.is_file()}

    assert files(folder) == files(again)


def test_every_number_is_computed_again_without_maviper(folder):
    found = recomputed(folder)
    assert found.returncode == 0, found.stdout[-2000:] + found.stderr
    told = json.loads((folder / report.NUMBERS).read_text())
    verdicts = [each for each in json.loads((folder / report.CLAIMS).read_text())["claims"] if each["test"] != "number"]
    said = f"{len(told)} numbers and {len(verdicts)} verdicts computed again, 0 come out otherwise"
    assert found.stdout.strip() == said and len(told) > 300 and len(verdicts) > 30
    script = (folder / report.SCRIPT).read_text()
    assert len([line for line in script.splitlines() if line]) <= 100 and "import maviper" not in script
    assert set(re.findall(r"^import (.*)$", script, re.MULTILINE)) == {
        "csv, functools, json, lzma, pathlib, sys",
        "numpy as np",
    }


def test_what_was_changed_is_found(folder, tmp_path):
    again = tmp_path / "again"
    shutil.copytree(folder, again)
    (cell,) = {
        row.cell
        for row in read_table(again).cells(kind="extraction", algorithm="maviper", depth=4, seed=1)
        if row.game == DECEPTION
    }
    path = again / "cells" / cell / "episodes.csv"
    lines = path.read_text().splitlines(keepends=True)
    head, _, value = lines[1].rpartition(",")
    path.write_text("".join([lines[0], f"{head},{float(value) + 0.5}\n", *lines[2:]]))
    found = recomputed(again)
    assert found.returncode == 1 and "joint/maviper/physical-deception" in found.stdout


def test_trees_are_drawn_where_their_profile_is(tmp_path):
    maker = Maker(tmp_path, seeds=1)
    maker.expert(NAVIGATION)
    cell = maker.extraction(NAVIGATION, "maviper", 2, 0)
    maker.write()
    place = tmp_path / "cells" / cell
    shutil.copy(PROFILE, place / "profile.json")
    report.write_report(tmp_path)
    assert part(tmp_path, "trees").count("<svg") == 3
    (place / "profile.json").write_text("{}")
    report.write_report(tmp_path)
    assert "<svg" not in part(tmp_path, "trees") and 'class="missing"' in part(tmp_path, "trees")


def test_commands_name_the_experts_of_the_report(tmp_path):
    maker = Maker(tmp_path, seeds=1)
    for label in ("maddpg", "mine"):
        maker.expert(DECEPTION, label)
        maker.extraction(DECEPTION, "maviper", 4, 0, label)
    maker.write()
    report.write_report(tmp_path)
    commands = re.findall(r"maviper reproduce -o FOLDER[^<]*", page(tmp_path))
    assert len(commands) > 20 and all("--experts" in command for command in commands)
    assert "maviper reproduce -o FOLDER --depths 4 --experts maddpg,mine=EXPERT" in part(tmp_path, "ablation")


def test_a_ratio_to_nothing_is_no_number(tmp_path):
    """An expert that never succeeds at the small radius: the values stay, the ratios are left out."""
    maker = Maker(tmp_path, strength=dict.fromkeys(tables.FOUR, 0.5), seeds=5)
    real = maker.values
    maker.values = lambda measure, *rest: (
        0.0 * real(measure, *rest) if "r=0.1" in measure.name else real(measure, *rest)
    )
    tables.filled(maker, (DECEPTION,), (4,), ("mappo",))
    report.write_report(tmp_path)
    assert "defenders-success-r-0-1" not in " ".join(path.name for path in (tmp_path / "figures").glob("joint-*"))
    assert "<td>defenders success r=0.1</td><td>4</td><td>MAVIPER</td><td>–</td>" in part(tmp_path, "joint")
    found = recomputed(tmp_path)
    assert found.returncode == 0 and not found.stderr, found.stdout + found.stderr


def test_labels_are_text_wherever_they_stand(tmp_path):
    label = '<b>&"x'
    maker = Maker(tmp_path, seeds=1)
    maker.expert(DECEPTION, label)
    maker.extraction(DECEPTION, "maviper", 4, 0, label)
    maker.write()
    report.write_report(tmp_path)
    assert "<b>" not in page(tmp_path) and "&lt;b&gt;" in page(tmp_path)
    for path in (tmp_path / report.FIGURES).glob("*.svg"):
        ET.parse(path)


def test_an_empty_table_is_reported_as_one(tmp_path):
    (tmp_path / "cells.csv").write_text(",".join(COLUMNS) + "\n")
    lines = report.write_report(tmp_path)
    assert lines[0].startswith("0 of 0 claims agree") and page(tmp_path).count("not run") >= len(PARTS)


@pytest.mark.parametrize(
    ("name", "old", "new", "fault"),
    [
        ("cells.csv", "higher_is_better", "higher", "lacks columns"),
        ("cells.csv", ",extraction,", ",extracted,", "extracted"),
        ("cells.csv", ",paper,maviper,4,", ",paper,maviper,four,", "four"),
        ("cells/*/episodes.csv", "lineup,measure", "measure,lineup", "lacks columns"),
        ("cells/*/episodes.csv", "3000001", "3000001,3", "twice"),
        ("cells/*/episodes.csv", "3000001", "three", "damaged"),
        ("cells/*/facts.json", "{", "[", "no JSON object"),
    ],
)
def test_a_damaged_table_is_refused(tmp_path, name, old, new, fault):
    maker = Maker(tmp_path, seeds=1)
    maker.expert(DECEPTION)
    maker.extraction(DECEPTION, "maviper", 4, 0)
    maker.write()
    for path in tmp_path.glob(name):
        path.write_text(path.read_text().replace(old, new))
    with pytest.raises(InputError, match=fault):
        report.write_report(tmp_path)
