"""Counterexamples over the steps: what is drawn and tabled is what the facts say, and no more; modes by their names."""

import csv

import pytest

from verify.reports.courses import draw_courses, in_modes, moment, runs, table, tables, within
from verify.reports.systems import lines

VARIABLES = [{"name": "x", "unit": "m"}, {"name": "v", "unit": "1"}]


def told(name, values, box, steps=4, by=0, more=()):
    """The facts of a result with a counterexample in which v stays 0."""
    return {
        "kind": "decisions" if name == "decides" else "episodes",
        "name": name,
        "steps": steps,
        "by": by,
        "regions": [{"box": box, "conditions": list(more)}],
        "counterexample": {
            "file": "counterexample-1.json",
            "step": len(values) - 1,
            "start": {"v": "0", "x": str(values[0])},
            "start_float64": {"v": 0.0, "x": values[0]},
            "states": {"v": [0.0] * len(values), "x": values},
            "actions": {"cart": ["left"] * 3 + ["stay"]},
            "errors": [{"x": "-1/8"}, {"x": "1/10", "v": "0"}],
        },
    }


def plot(*given, **more):
    return draw_courses(told(*given, **more), VARIABLES)["counterexample"]["plots"][0]


def test_actions_in_a_row():
    assert runs(["left", "left", "stay", "left"]) == "left 2x, stay, left"
    assert runs([]) == ""


@pytest.mark.parametrize(
    ("name", "values", "inside"),
    [("stays_in", [0.0, 0.5, 1.25], False), ("stays_in", [0.0, -1.01], False), ("avoids", [3.0, 2.0, 0.9], True)],
)
def test_the_last_state_lies_in_its_band_as_the_claim_says(name, values, inside):
    made = plot(name, values, {"x": ["-1", "1"]})
    (band,), ((_, y),) = made["bands"], made["end"]
    assert made["name"] == "x" and made["unit"] == "m"
    assert (band["y"] <= y <= band["y"] + band["height"]) is inside
    assert len(made["lines"][0].split()) == len(values) == len(made["dots"]) + 1
    assert band["x"] == made["left"] and band["x"] + band["width"] == pytest.approx(made["right"])


def test_a_region_counts_from_its_step_on():
    made = plot("reaches_and_stays", [3.0, 2.0, 1.5], {"x": ["-1", "1"]}, steps=4, by=2)
    assert made["steps"] == 4
    middle = (made["left"] + made["right"]) / 2
    assert made["bands"][0]["x"] == made["end"][0][0] == pytest.approx(middle)


def test_a_bound_that_is_far_away_is_not_drawn_and_one_side_may_be_open():
    made = plot("stays_in", [0.0, 0.5, 1.25], {"x": ["-1e9", "1"]})
    assert [label["text"] for label in made["labels"]] == ["1"]
    half = plot("stays_in", [0.0, 0.5, 1.25], {"x": [None, "1"]})
    assert half == {**made, "beyond": False} and made["beyond"]


def test_a_start_alone_is_drawn():
    made = plot("stays_in", [2.0], {"x": ["-1", "1"]})
    assert made["dots"] == [] and made["end"][0][0] == made["left"]


def test_random_episodes_of_a_proof_are_drawn_inside_its_band():
    """Only from shortly before the step from which the claim counts."""
    proved = told("reaches_and_stays", [0.0], {"x": ["-1", "1"]}, steps=12, by=10)
    del proved["counterexample"]
    runs = [[5.0] * 6 + [0.5] * 7, [-5.0] * 6 + [-0.25] * 7]
    found = draw_courses({**proved, "approach": {"played": {"x": runs}}}, VARIABLES)
    (made,) = found["plots"]
    (band,) = made["bands"]
    assert made["first"] == "step 6" and made["steps"] == 12 and not made["dots"] and not made["end"]
    assert [len(line.split()) for line in made["lines"]] == [7, 7] and "Bands" in found["legend"]
    heights = [float(point.split(",")[1]) for line in made["lines"] for point in line.split()]
    assert all(band["y"] <= height <= band["y"] + band["height"] for height in heights)


def test_what_is_not_drawn_is_said():
    result = draw_courses(told("stays_in", [0.0, 2.0], {"x": ["-1", "1"]}, more=["x + v <= 2"]), VARIABLES)
    found = result["counterexample"]
    assert "Not drawn: x + v <= 2." in found["legend"]
    assert found["errs"] == "x up to 0.125" and found["last"] == {"v": 0.0, "x": 2.0}
    many = [{"name": f"y{number}", "unit": "1"} for number in range(14)]
    wide = told("avoids", [0.0, 2.0], {"y13": ["0", "1"]})
    wide["counterexample"]["states"] = {each["name"]: [0.0, 1.0] for each in many}
    found = draw_courses(wide, many)["counterexample"]
    assert [each["name"] for each in found["plots"]][:2] == ["y13", "y0"] and found["not_drawn"] == ["y11", "y12"]


def test_a_state_of_single_decisions_has_no_course():
    found = draw_courses(told("decides", [0.0], {}), VARIABLES)["counterexample"]
    assert "plots" not in found and found["runs"] == {"cart": "left 3x, stay"}


MODES = {"heat": ["off", "low", "high"]}
SWITCHED = {
    "file": "counterexample-1-stays_in.json",
    "step": 1,
    "start": {"x": "1/10", "heat": "0"},
    "start_float64": {"x": 0.1, "heat": 0.0},
    "states": {"x": [0.1, 3.1], "heat": [0.0, 2.0]},
    "actions": {"a": ["high"]},
    "errors": [],
}
TOLD = {
    "kind": "episodes", "name": "stays_in", "regions": [], "by": 0, "steps": 12, "modes": MODES,
    "counterexample": SWITCHED, "sentence": "it stays", "formula": "", "reason": "", "verdict": "VIOLATED",
    "shuffled_control": "VIOLATED",
}  # fmt: skip
OF_MODES = [{"name": "x", "unit": "K"}, {"name": "heat", "unit": "1", "modes": MODES["heat"]}]


def test_modes_have_their_names():
    assert in_modes({"x": 0.1, "heat": 2.0}, TOLD) == {"heat": "high"} and in_modes({"heat": 2.0}, {}) == {}
    ready = draw_courses(TOLD, OF_MODES)["counterexample"]
    assert ready["began"] == {"x": 0.1, "heat": "off"} and ready["last"] == {"x": 3.1, "heat": "high"}
    assert ready["start"] == {"x": "1/10"} and ready["begun_in"] == {"heat": "off"}
    told = lines(TOLD)
    assert "from x 0.1, heat off" in told and "at step 1: x 3.1, heat high" in told


def test_bounds_of_modes_have_their_names():
    open_ = {"step": 2, "bounds": {"x": [0.5, "above 1.79e308"], "heat": [0.9, 2.0]}}
    assert within({"open": open_, "modes": MODES}) == ["x in [0.5, above 1.79e308]", "heat in [low, high]"]
    assert within({"open": open_})[1] == "heat in [0.9, 2]" and within({}) == []


EPISODE = {
    "file": "counterexample-1-stays_in.json",
    "step": 2,
    "states": {"x": [0.1, 1 / 3, "above 1.79e308"], "v": [0.0, -0.0, 5e-324]},
    "actions": {"car": ["left", "right, slowly"]},
}


def test_a_row_for_each_state_with_numbers_that_read_back_exactly():
    rows = list(csv.reader(table(EPISODE, "1/50").splitlines()))
    assert rows[0] == ["step", "time_s", "x", "v", "car.action"]
    assert [row[:2] for row in rows[1:]] == [["0", "0.0"], ["1", "0.02"], ["2", "0.04"]]
    assert [float(row[2]) for row in rows[1:3]] == EPISODE["states"]["x"][:2] and rows[3][2] == "above 1.79e308"
    assert [float(row[3]).hex() for row in rows[1:]] == [value.hex() for value in EPISODE["states"]["v"]]
    assert [row[4] for row in rows[1:]] == ["left", "right, slowly", ""]


def test_without_a_stated_step_there_is_no_time():
    assert table(EPISODE, None).splitlines()[0] == "step,x,v,car.action"
    assert moment(12, None) == "step 12" and moment(12, "1/50") == "step 12 (0.24 s)"


def test_only_episodes_have_tables():
    results = [{}, {"counterexample": {**EPISODE, "step": 0}}, {"counterexample": EPISODE}]
    assert list(tables({"dt": None, "results": results})) == ["counterexample-1-stays_in.csv"]
