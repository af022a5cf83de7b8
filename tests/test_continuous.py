"""generated/continuous/: scores of trees of experts with continuous actions, and the manual's table of them."""

import json
import re
from pathlib import Path

import pytest

from tests.benchmarks import continuous
from tests.benchmarks.scores import keep_rows

ROOT = Path(__file__).parent.parent
RECORD = ROOT / "generated/continuous/scores.json"
ROWS = json.loads(RECORD.read_text())


@pytest.mark.parametrize("row", ROWS, ids=lambda row: f"{row['game']} {row['asked']} {row['way']}")
def test_a_score_is_that_of_its_returns(row):
    assert row["way"] in (*continuous.WAYS, *continuous.PLAIN) and row["episodes"] == continuous.EPISODES
    score = (row["return"] - row["random"]) / (row["expert"] - row["random"])
    assert score == pytest.approx(row["score"], abs=1e-3) and row["low"] <= row["score"] <= row["high"]
    assert 1 <= row["leaves"] <= row["asked"] and re.fullmatch(r"[0-9a-f]{64}", row["expert_sha256"])


def test_the_manual_has_the_table_of_the_record():
    page = (ROOT / "maviper/manual/extraction.md").read_text()
    assert "\n".join(continuous.table(RECORD)) in page


def test_rows_take_the_place_of_those_of_the_same_question(tmp_path):
    record, row = tmp_path / "deeper" / "rows.json", {**ROWS[0], "score": 0.5, "low": 0.4, "high": 0.6}
    keep_rows(record, ROWS[::-1])
    assert record.read_text() == RECORD.read_text()
    keep_rows(record, [row])
    kept = json.loads(record.read_text())
    assert len(kept) == len(ROWS) and row in kept and ROWS[0] not in kept
