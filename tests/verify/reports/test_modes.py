"""States of modes in reports: by their names, in words, in bounds and in what templates place."""

from verify.reports.courses import draw_courses, in_modes, within
from verify.reports.systems import lines

MODES = {"heat": ["off", "low", "high"]}
FOUND = {
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
    "counterexample": FOUND, "sentence": "it stays", "formula": "", "reason": "", "verdict": "VIOLATED",
    "shuffled_control": "VIOLATED",
}  # fmt: skip
VARIABLES = [{"name": "x", "unit": "K"}, {"name": "heat", "unit": "1", "modes": MODES["heat"]}]


def test_modes_have_their_names():
    assert in_modes({"x": 0.1, "heat": 2.0}, TOLD) == {"heat": "high"} and in_modes({"heat": 2.0}, {}) == {}
    ready = draw_courses(TOLD, VARIABLES)["counterexample"]
    assert ready["began"] == {"x": 0.1, "heat": "off"} and ready["last"] == {"x": 3.1, "heat": "high"}
    assert ready["start"] == {"x": "1/10"} and ready["begun_in"] == {"heat": "off"}
    told = lines(TOLD)
    assert "from x 0.1, heat off" in told and "at step 1: x 3.1, heat high" in told


def test_bounds_of_modes_have_their_names():
    open_ = {"step": 2, "bounds": {"x": [0.5, "above 1.79e308"], "heat": [0.9, 2.0]}}
    assert within({"open": open_, "modes": MODES}) == ["x in [0.5, above 1.79e308]", "heat in [low, high]"]
    assert within({"open": open_})[1] == "heat in [0.9, 2]" and within({}) == []
