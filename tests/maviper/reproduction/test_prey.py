"""Prey by return from the committed records: the manual's table, and the identity between return, touches and fine."""

from pathlib import Path

import numpy as np
import pytest

from tests.benchmarks import prey

MANUAL = Path(__file__).parents[3] / "maviper" / "manual" / "reproduce.md"
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
