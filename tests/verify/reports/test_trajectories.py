"""Tables of trajectories hold what the facts hold, with the time of each step where the file states one."""

import csv

from verify.reports.courses import moment, table, tables

FOUND = {
    "file": "counterexample-1-stays_in.json",
    "step": 2,
    "states": {"x": [0.1, 1 / 3, "above 1.79e308"], "v": [0.0, -0.0, 5e-324]},
    "actions": {"car": ["left", "right, slowly"]},
}


def test_a_row_for_each_state_with_numbers_that_read_back_exactly():
    rows = list(csv.reader(table(FOUND, "1/50").splitlines()))
    assert rows[0] == ["step", "time_s", "x", "v", "car.action"]
    assert [row[:2] for row in rows[1:]] == [["0", "0.0"], ["1", "0.02"], ["2", "0.04"]]
    assert [float(row[2]) for row in rows[1:3]] == FOUND["states"]["x"][:2] and rows[3][2] == "above 1.79e308"
    assert [float(row[3]).hex() for row in rows[1:]] == [value.hex() for value in FOUND["states"]["v"]]
    assert [row[4] for row in rows[1:]] == ["left", "right, slowly", ""]


def test_without_a_stated_step_there_is_no_time():
    assert table(FOUND, None).splitlines()[0] == "step,x,v,car.action"
    assert moment(12, None) == "step 12" and moment(12, "1/50") == "step 12 (0.24 s)"


def test_only_episodes_have_tables():
    results = [{}, {"counterexample": {**FOUND, "step": 0}}, {"counterexample": FOUND}]
    assert list(tables({"dt": None, "results": results})) == ["counterexample-1-stays_in.csv"]
