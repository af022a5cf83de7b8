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
from maviper.reproduction.verdicts import AGREES, DIFFERS, NOT_DECIDED, SUPPORTS
from tests.benchmarks import compact
from tests.benchmarks.record import OLD_TABLE, recorded, rows
from tests.maviper.reproduction import tables
from tests.maviper.reproduction.tables import DECEPTION, NAVIGATION
from tests.support.tiers import first_of

ROOT = Path(__file__).parents[3]
RECORDS = ROOT / "generated" / "reproduction"
REPORT = (RECORDS / "README.md").read_text()
COMMITTED = sorted(RECORDS.glob("*/claims.json"))
FAMILIES = ("maddpg", "mappo")  # of the default tier
MORE = ("maddpg-deception", "maddpg-predator-prey", "mappo-predator-prey")  # seeds; a family, then a game


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
    (tmp_path / OLD_TABLE).write_text("of an earlier form")
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
    assert {f"{name}.csv" for name in cells} == {path.name for path in (folder / "episodes").iterdir()}
    for name, cell in cells.items():
        data = (folder / "episodes" / f"{name}.csv").read_bytes()
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
    assert (place / report.PAGE).exists() == (place.name in FAMILIES)  # a second look is judged on some seeds alone
    if place.name in FAMILIES:
        page = (place / report.PAGE).read_text()
        assert f"<strong>{counts}.</strong>" in page and page.count(".x{stroke:currentColor") == 1
    assert (place / compact.FILE).exists() and not (place / OLD_TABLE).exists()


def decided(*names):
    return {each["id"] for name in names for each in claims(name) if each["verdict"] in (AGREES, DIFFERS)}


def test_twenty_claims_are_decided():
    assert {path.parent.name for path in COMMITTED} == {*FAMILIES, *MORE}
    assert len(decided(*FAMILIES)) >= 20
    for name in FAMILIES:
        assert len(decided(name, *(place for place in MORE if place.startswith(f"{name}-")))) >= 20


@pytest.mark.parametrize("path", COMMITTED, ids=lambda path: path.parent.name)
def test_summaries_say_what_the_claims_of_a_record_say(path):
    lines = path.with_name("summary.txt").read_text(encoding="utf-8").splitlines()
    for each in claims(path.parent.name):
        notes = "; ".join(text for text in (each["reason"], *each["notes"]) if text)
        assert report.summarise_claim(each["verdict"], each["main"], each["id"], notes or each["says"]) in lines


# --- what the README says of them


def claims(name):
    return json.loads((RECORDS / name / "claims.json").read_text())["claims"]


def compared(name, statistics, label):
    """The comparisons with that beginning in claims about those statistics."""
    rows = [row for claim in claims(name) if claim["statistic"] in statistics for row in claim["comparisons"]]
    return [row for row in rows if row["label"].startswith(label)]


def seeds(name):
    return {row["seed"] for row in rows(RECORDS / name) if row["kind"] == "extraction" and row["depth"] == "4"}


def rollouts(name, game, algorithm):
    """Rollout episodes of a whole extraction of depth 4, median, as the report's table says."""
    page = re.sub(r"<svg.*?</svg>", "", (RECORDS / name / "report.html").read_text(), flags=re.DOTALL)
    table = page[page.index(f"{game}, expert {name}: whole extractions") :]
    words = re.sub(r"<[^>]+>", " ", table)
    return int(re.search(rf"\s{algorithm}\s+(\d+)\s", words)[1])


def test_readme_and_report_say_how_many_fewer_episodes_maviper_played():
    readme = " ".join((ROOT / "README.md").read_text().split())
    shares = []
    for game in ("physical-deception", "cooperative-navigation", "predator-prey"):
        ours, theirs = ([rollouts(name, game, word) for name in FAMILIES] for word in ("MAVIPER", "IVIPER"))
        assert theirs[0] == theirs[1]
        shares += [each / mine for each, mine in zip(theirs, ours, strict=True)]
        words = f"{ours[0]:,} / {ours[1]:,}", f"{theirs[0]:,}", f"{shares[-2]:.0f} / {shares[-1]:.0f} times"
        assert re.search(r"\| +".join(re.escape(word) + " *" for word in words), REPORT)
    assert f"with {min(shares):.0f} to {max(shares):.0f} times fewer episodes" in readme


def test_the_report_takes_the_later_record_of_exploitability():
    lead, *_ = compared("maddpg-deception", ["exploitability"], "maviper less iviper, physical-deception defenders")
    assert lead["label"].endswith("depth 4")
    shown = f"{lead['value']:.3f} [{lead['low']:.3f}, {lead['high']:.3f}]".replace("0.", ".")
    assert shown in " ".join(REPORT.split())


def test_the_readmes_sentences_are_what_the_records_found():
    said = " ".join((ROOT / "README.md").read_text().split())
    repeats = register.read().repeats
    told = {word: [] for word in (AGREES, DIFFERS, NOT_DECIDED)}
    for name in FAMILIES:
        words = [claim["verdict"] for claim in claims(name) if claim["id"] not in repeats]
        assert len(words) - sum(words.count(word) for word in told) == 3 and len(words) == 72
        told = {word: [*counts, words.count(word)] for word, counts in told.items()}
    few, more, open_ = ([min(each), max(each)] for each in told.values())
    counts = "of 72 claims of the paper {} to {} agree, {} to {} differ and {} to {} are open"
    assert counts.format(*few, *more, *open_) in said
    ceilings = [claim for claim in claims("mappo") if claim["verdict"] == DIFFERS and claim["id"] not in repeats]
    ceilings = [claim for claim in ceilings if all(each["untestable"] for each in contradicting(claim))]
    report_text = " ".join(REPORT.split())
    assert "of MAPPO's 25, four are contradicted only where" in report_text and len(ceilings) == 4
    for name, label in (("maddpg-deception", "defenders success r=0.316"), ("mappo", "agents D")):
        (lead,) = compared(name, ["joint"], f"maviper less iviper, {label}, depth 4")
        assert lead["word"] == "better" and f"by {interval(lead['value'], lead['low'], lead['high'])}" in report_text
    assert len(list(seeds("maddpg-deception"))) == 52 and "`maddpg-deception/` has 52 seeds" in report_text
    for name, label in (("maddpg", "agents D"), ("mappo", "defenders success")):
        exchanged = compared(name, ["joint", "robustness"], f"maviper less iviper, {label}")
        assert len(exchanged) >= 3 and all(row["word"] != "better" for row in exchanged)
    for name in (*FAMILIES, *MORE):
        rows = compared(name, ["joint"], "maviper less iviper")
        low = [row for row in rows if row["label"].endswith("depth 2")]
        assert bool(low) == ("predator-prey" not in name) and all(row["word"] != "better" for row in low)
    (deep,) = compared("maddpg-deception", ["joint"], "maviper less iviper, defenders success r=0.316, depth 6")
    assert deep["word"] not in ("better", "not run")
    for name in (*FAMILIES, *(place for place in MORE if "predator-prey" in place)):
        for team in ("predators", "prey"):
            rows = compared(name, ["joint", "robustness"], f"maviper less iviper, {team}")
            assert rows and all(row["word"] != "better" for row in rows)


def contradicting(claim):
    """The comparisons of a claim that differs, whose word is another than its own."""
    words = (*SUPPORTS[claim["test"]], "not decided", "not run")
    return [each for each in claim["comparisons"] if each["word"] not in words]


def interval(value, low, high):
    return f"{value:.3f} [{low:.3f}, {high:.3f}]".replace("0.", ".")


def test_readme_and_report_say_what_the_registered_claims_came_to():
    """The six primary claims, and the absolute values beside them."""
    said = " ".join((ROOT / "README.md").read_text().split())
    tables = (RECORDS / "published" / "tables.txt").read_text()
    primary = tables[tables.index("family primary\n") :].split("\n\n")[0].splitlines()[1:]
    assert len(primary) == 6
    for line in primary:
        name, _, told = line.strip().partition(", ")
        expert, lead, word, how_large = re.fullmatch(
            r"(\w+), depth 4: (\S+ \[\S+ \S+\])  ([A-Z ]+); ([A-Z ]+) against \S+", told
        ).groups()
        lead = interval(*map(float, re.findall(r"[-+]\d\.\d+", lead)))
        row = rf"\| {name.split('-')[1]}, .*\| {expert.upper()} +\| {re.escape(lead)} +\| {word} +\| {how_large} +\|"
        assert len(re.findall(row, REPORT)) >= 1, line
        if name.startswith(("rounds", "released")) and (name, expert) != ("rounds-deception-mappo", "mappo"):
            assert lead in said, line
    parts = (RECORDS / "factorial" / "tables.txt").read_text()
    joint = re.search(r"  rollouts, maddpg, depth 4: (\S+) \[(\S+), (\S+)\]  BETTER", parts)
    whole = re.search(r"  all-four, maddpg, depth 4: (\S+) \[", parts)
    assert f"{interval(*map(float, joint.groups()))} of {float(whole[1]):.3f}".replace(" 0.", " .") in said
    for game, label, row in (
        ("physical-deception maddpg", "defenders success r=0.316", "deception, MADDPG | success"),
        ("cooperative-navigation mappo", "agents D", "navigation, MAPPO | distance left (lower)"),
        ("physical-deception mappo", "defenders success r=0.316", "deception, MAPPO | success"),
        ("cooperative-navigation maddpg", "agents D", "navigation, MADDPG | distance left (lower)"),
    ):
        found = rf"{game} paper {{}} depth 4: {label}, (\S+) of (\S+),"
        ours, theirs = (re.search(found.format(name), tables) for name in ("maviper-every-round", "iviper"))
        shown = (f"{float(number):.2f}".removeprefix("0") for number in (ours[2], theirs[1], ours[1]))
        assert f"| {' | '.join((row, *shown))} |" in re.sub(r" +\|", " |", said)


@pytest.mark.parametrize("path", first_of(2, sorted(RECORDS.glob("*/recompute.py"))), ids=lambda path: path.parent.name)
def test_committed_cells_give_the_recorded_numbers_and_verdicts(path):
    """Records that were made before cells were kept lack the facts of two comparisons, of attention."""
    assert path.read_bytes() == sorted(RECORDS.glob("*/recompute.py"))[0].read_bytes()
    said = computed_again(path.parent)
    assert f" and {len(judged(path.parent))} verdicts computed again, 0 come out otherwise" in said
    earlier = "2 comparisons stand as the report has them" in said
    assert earlier == ("were left out" in path.with_name("README.md").read_text())


@pytest.mark.parametrize("name", MORE)
def test_more_seeds_are_the_same_cells_and_more(name):
    def told(name):
        kept = (row for row in rows(RECORDS / name) if row["measure"] != compact.INSIDE)  # of new records alone
        return {tuple(row.values())[:-1]: row["cell"] for row in kept}  # without CPU seconds

    first, second = told(name.partition("-")[0]), told(name)
    both = set(first.values()) & set(second.values())
    assert len(both) > 50
    assert {row for row, cell in first.items() if cell in both} == {row for row, cell in second.items() if cell in both}
