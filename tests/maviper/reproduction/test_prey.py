"""Prey by return from the committed records: the manual's tables, and the identity between return, touches and fine."""

import re
from collections import defaultdict
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from tests.benchmarks import compact, prey

PAGES = Path(__file__).parents[3] / "maviper" / "manual"
MANUAL = PAGES / "reproduce.md"
REGISTERS = ("published", "more-experts", "learner-experts", "learner-more-experts")
QUANTILES = (12.706205, 4.302653, 3.182446, 2.776445, 2.570582, 2.446912, 2.364624, 2.306004, 2.262157)
T = dict(enumerate(QUANTILES, 2))  # Student's t at .975, by the number of units
NAMES = {"maviper": "MAVIPER", "iviper": "IVIPER", "imitation": "Imitation", "fitted-q": "Fitted Q"}


def section():
    text = MANUAL.read_text()
    return text[text.index("### Prey by return") :].partition("\n### ")[0]


@pytest.fixture(scope="module")
def found():
    return {name: prey.rows_of(prey.RECORDS / name) for name in prey.NAMES[:2]}


def test_the_manual_has_the_records_numbers(found):
    said = " ".join(section().split())
    rows = [[cell.strip() for cell in line.split("|")[1:-1]] for line in section().splitlines()]
    for name, (levels, _) in found.items():
        expert = name.partition("-")[0].upper()
        for row in levels:
            cells = [f"{row['touches']:.2f}", f"{row['fine']:.2f}", f"{100 * row['inside']:.0f} %"]
            cells += [f"{row['touches inside']:.2f}", f"{row['return']:.2f}"]
            assert [expert, NAMES[row["algorithm"]], *cells] in rows
    for name, other in (("maddpg-predator-prey", "iviper"), ("mappo-predator-prey", "imitation")):
        (row,) = [each for each in found[name][1] if each["other"] == other]
        value, low, high, seeds = row["return"]
        assert f"{value:.2f} [{low:.2f}, {high:.2f}]" in said and low > 0 and seeds == 30


@cache
def rows_of(name):
    return prey.rows_of(prey.RECORDS / name)


def compared(name, kind, depth, ours, other):
    """The row of one comparison."""
    asked = {"expert": kind, "depth": depth, "algorithm": ours, "other": other}
    (row,) = [each for each in rows_of(name)[1] if asked.items() <= each.items()]
    return row


@cache
def by_hand(name):
    """(kind, preset, depth, algorithm) -> expert -> seed -> numbers, from the names of cells and their episodes."""
    found = defaultdict(lambda: defaultdict(dict))
    for cell, document in compact.unpacked(prey.RECORDS / name / compact.FILE)["cells"].items():
        game, expert, preset, algorithm, depth, seed, _ = cell.split(".")
        if game == "predator-prey":
            trees, paid = document["values"]["joint:prey"], document["values"]["expert"]["prey return"]["mean"]
            numbers = {"touches": -trees["prey touches"]["mean"], "return": trees["prey return"]["mean"]}
            numbers["ratio"] = 2 - numbers["return"] / paid  # an expert's prey are never paid anything
            numbers["touches inside"] = -trees["prey touches inside"].get("mean", np.nan)
            key = expert.partition("-")[0], preset, int(depth[6:]), algorithm
            found[key][expert][int(seed[5:])] = numbers
    return found


@pytest.mark.parametrize("name", REGISTERS)
def test_differences_of_registers_are_those_by_hand(name):
    """Over the means of experts, or over the seeds of a lone one."""
    cells = by_hand(name)
    for row in rows_of(name)[1]:
        ours, theirs = (cells[row["expert"], row["preset"], row["depth"], row[who]] for who in ("algorithm", "other"))
        for measure in set(prey.SIGNS) & set(row):
            by_expert = [[ours[e][seed][measure] - theirs[e][seed][measure] for seed in ours[e]] for e in ours]
            units = by_expert[0] if len(ours) == 1 else [sum(each) / len(each) for each in by_expert]
            units = [each for each in units if np.isfinite(each)]
            value, low, high, count = row[measure]
            assert count == len(units) and value == pytest.approx(np.mean(units), abs=1e-9)
            half = T[count] * np.std(units, ddof=1) / count**0.5
            assert (high - value, value - low) == pytest.approx((half, half), rel=1e-5)
    counts = {row["return"][3] for row in rows_of(name)[1]}
    assert counts == {dict(zip(REGISTERS, (10, 5, 2, 8), strict=True))[name]}


@pytest.mark.parametrize(
    ("kind", "depth", "other", "lead"),
    [
        ("maddpg", 6, "imitation", (-1.767, -2.912, -0.621)),
        ("mappo", 6, "imitation", (-1.932, -2.754, -1.111)),
        ("maddpg", 4, "maviper", (-1.778, -3.507, -0.049)),
        ("maddpg", 2, "imitation", (1.110, 0.255, 1.964)),
    ],
)
def test_prey_of_best_responses_lead_by_what_an_auditor_found(kind, depth, other, lead):
    row = compared("learner-more-experts", kind, depth, "best-response", other)
    assert row["ratio"][:3] == pytest.approx(lead, abs=1e-3)


def bare(text):
    """Numbers as the manual has them, without a zero before the point."""
    return re.sub(r"(?<!\d)0\.", ".", text)


def lead_of(numbers):
    return bare("{:.3f} [{:.3f}, {:.3f}]".format(*numbers[:3]))


def test_the_manual_has_the_prey_of_best_responses():
    text = (PAGES / "extraction.md").read_text()
    said = text[text.index("By return, prey of best responses are behind") :].partition("    python -m ")[0]
    rows = [[cell.strip() for cell in line.split("|")[1:-1]] for line in said.splitlines()]
    ratios, name = defaultdict(dict), "learner-more-experts"
    for level in rows_of(name)[0]:
        ratios[level["expert"], level["depth"]][level["algorithm"]] = level
    assert len(ratios) == 6
    for (kind, depth), of in ratios.items():
        others = ("maviper", "iviper", "imitation")
        best = max(others, key=lambda other, of=of: of[other]["ratio"])
        lead = compared(name, kind, depth, "best-response", best)["ratio"]
        numbers = [bare(f"{of[each]['ratio']:.3f}") for each in ("best-response", *others)]
        assert lead[0] < 0 and [f"{kind.upper()}, {depth}", *numbers, lead_of(lead)] in rows
    words = " ".join(said.split())
    for kind in ("maddpg", "mappo"):
        row, of = compared(name, kind, 6, "best-response", "imitation"), ratios[kind, 6]
        assert row["ratio"][2] < 0 < row["touches"][1] and row["touches inside"][1] < 0 < row["touches inside"][2]
        assert f"by {lead_of(row['touches'])}" in words
        assert f"{of['best-response']['fine']:.1f} beside {of['imitation']['fine']:.1f}" in words
    assert f"by {lead_of(compared(name, 'maddpg', 2, 'best-response', 'imitation')['ratio'])}" in words
    for other in ("maviper", "iviper"):
        assert ratios["mappo", 6][other]["ratio"] < ratios["mappo", 6]["best-response"]["ratio"]


def test_a_record_is_named_or_a_path(monkeypatch, capsys):
    for record in ("more-experts", str(prey.RECORDS / "more-experts")):
        monkeypatch.setattr("sys.argv", ["prey", record])
        prey.main()
        text = capsys.readouterr().out
        assert text.startswith("more-experts: prey, all trees")
        assert "maddpg paper, depth 4, maviper-every-round less iviper: return +21.055 [+11.212, +30.898] of 5" in text


def test_the_order_by_touches_is_that_of_the_fine_reversed(found):
    for levels, _ in found.values():
        by_touches = [row["algorithm"] for row in sorted(levels, key=lambda row: row["touches"])]
        assert by_touches == [row["algorithm"] for row in sorted(levels, key=lambda row: -row["fine"])]


def test_no_fine_is_negative():
    """So a return is nothing but touches and fines."""
    for of in prey.by_cell(prey.RECORDS / "mappo-predator-prey").values():
        for cell in of.values():
            assert prey.told(cell)["fine"] > -1e-9 and 0 <= prey.told(cell)["inside"] <= 1


def test_differences_leave_out_seeds_without_a_number():
    ours = {
        seed: {"return": -1.0 - seed, "touches": 1.0, "touches inside": np.nan if seed else 1.0} for seed in range(3)
    }
    theirs = {seed: {"return": -2.0 - seed, "touches": 1.5, "touches inside": 2.0} for seed in range(3)}
    row = prey.differences(ours, theirs)
    assert row["return"][0] == 1 and row["touches"][0] == 0.5 and "touches inside" not in row
