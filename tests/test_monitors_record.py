"""The record of monitors: over a million pushed states each, no word that does not hold."""

import json

import pytest

from tests.benchmarks import monitor as benchmark

ROWS = {row["proof"]: row for row in benchmark.read_record()}
# monitors of episodes, for which no noise is stated
EXACT = {*benchmark.EPISODES, benchmark.SUMS_FOLLOWED}
ALARMS = 0.05


def test_every_monitor_of_a_committed_proof_is_there_as_it_is():
    assert list(ROWS) == list(benchmark.rows())
    assert {name: row["certificate"] for name, row in ROWS.items()} == {
        name: benchmark.certificate_of(name) for name in benchmark.rows()
    }


def test_over_a_million_states_each_no_word_fails_and_the_control_does():
    for name, row in ROWS.items():
        assert row["states"] >= 1_000_000 and row["fails_while_vouched"] == 0 < row["control_fails"], name
        assert row["refused"] == 0 < row["calm"] and row["vouched"] > 0.03, name
        assert name in EXACT or row["false_alarms"] <= ALARMS, name


def test_the_page_shows_the_rows():
    page = (benchmark.RECORD / "README.md").read_text()
    assert page == benchmark.page_of(list(ROWS.values()))
    assert len(page.splitlines()) > len(ROWS)


@pytest.mark.slow
@pytest.mark.compile
def test_a_recorded_row_is_found_again(monkeypatch, tmp_path):
    name = "worlds/crossing/certificate-1-stays_in"
    monkeypatch.setattr(benchmark, "RECORD", tmp_path)
    benchmark.record_rows(benchmark.STATES, name, new=True)
    assert json.loads((tmp_path / "table.json").read_text()) == [ROWS[name]]
    benchmark.record_rows(benchmark.STATES, name, new=True)  # nothing is missing: it is not measured again
    assert benchmark.read_record() == [ROWS[name]]
