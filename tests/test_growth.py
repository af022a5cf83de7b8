"""The table of the manual on how proofs grow has the boxes that its command counts."""

import re
from pathlib import Path

import pytest

from tests.benchmarks.growth import ROWS, USUAL, WORDS, swept

PAGE = Path(__file__).parent.parent / "maviper" / "manual" / "systems.md"


def told(name):
    cells = re.search(rf"^\| {re.escape(WORDS[name])} +\|([^|]*)\|([^|]*)\|", PAGE.read_text(), re.MULTILINE)
    return [[each.strip().replace(",", "") for each in re.split(r", ", cell)] for cell in cells.groups()]


@pytest.mark.slow
@pytest.mark.parametrize("name", ROWS)
def test_boxes_are_those_of_the_table(name):
    values, boxes = told(name)
    assert [float(each) for each in values] == [2 * each if name == "axes" else float(each) for each in ROWS[name]]
    assert [int(each) for each in boxes] == [swept(**{**USUAL, name: value})[0] for value in ROWS[name]]
