"""Figures: what is drawn is what was given, and nothing is told by colour alone."""

import math
import xml.etree.ElementTree as ET

import pytest

from maviper.reproduction import figures
from maviper.reproduction.figures import MARKS, Point

SVG = "{http://www.w3.org/2000/svg}"
NAN = float("nan")


def titles(text):
    return [each.text for each in ET.fromstring(text).iter(f"{SVG}title")]


def test_each_algorithm_has_a_colour_and_a_shape_of_its_own():
    for looks in (lambda m: m.light, lambda m: m.dark, lambda m: m.shape):
        assert len({looks(mark) for mark in MARKS.values()}) == len(MARKS)


@pytest.mark.parametrize(("paper", "ink"), [("#ffffff", "light"), ("#12171c", "dark")])
def test_marks_are_seen_on_the_page(paper, ink):
    """WCAG asks for a contrast of 3 for what is not text."""
    for mark in MARKS.values():
        assert contrast(getattr(mark, ink), paper) >= 3


def contrast(one, other):
    def light(colour):
        parts = [int(colour[k : k + 2], 16) / 255 for k in (1, 3, 5)]
        linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in parts]
        return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]

    low, high = sorted((light(one), light(other)))
    return (high + 0.05) / (low + 0.05)


def test_lines_say_every_number_and_leave_out_what_is_none():
    series = {"maviper": [Point(0.8, 0.7, 0.9, 2), Point(NAN, NAN, NAN, 4)], "iviper": [Point(0.5, NAN, NAN, 2)]}
    text = figures.lines("a < b & c", "depth", series)
    assert titles(text) == ["a < b & c", "MAVIPER: 0.800 [0.700, 0.900]", "IVIPER: 0.500"]
    assert "NaN" not in text and "nan" not in text.replace("dominant", "")


def test_numbers_lie_where_the_axis_says():
    text = figures.lines("t", "depth", {"maviper": [Point(0.5, 0.25, 0.75, 2)]}, reference=1.0)
    root = ET.fromstring(text)
    ticks = {
        each.text: float(each.get("y"))
        for each in root.iter(f"{SVG}text")
        if each.get("text-anchor") == "end" and each.text[0].isdigit()
    }
    (place,) = (
        {each.get("transform") for each in root.iter(f"{SVG}path") if "l" not in each.get("class")}
        - {None}
        - {each.get("transform") for each in root.findall(f"{SVG}path")}
    )
    y = float(place.removesuffix(")").partition(",")[2])
    share = (ticks["0"] - y) / (ticks["0"] - ticks["1"])
    assert share == pytest.approx(0.5, abs=0.01)


def test_marks_lie_at_their_own_numbers_and_cut_intervals_say_so():
    series = {
        "maviper": [Point(0.5, 0.4, 0.6, 7), Point(0.7, -50.0, 50.0, 13)],
        "iviper": [Point(0.6, 0.5, 0.7, 7), Point(0.6, 0.5, 0.7, 13)],
    }
    root = ET.fromstring(figures.lines("t", "leaves", series, None, to_scale=True))
    labels = [each for each in root.iter(f"{SVG}text") if each.get("text-anchor") == "middle"]
    ticks = {float(each.text): float(each.get("x")) for each in labels}
    first, last = min(ticks), max(ticks)
    for points in ([each for each in root.iter(f"{SVG}g") if each.find(f"{SVG}title") is not None],):
        for leaves, group in zip([7, 13, 7, 13], points, strict=True):
            x = float(group.findall(f"{SVG}path")[-1].get("transform").removeprefix("translate(").partition(",")[0])
            place = ticks[first] + (ticks[last] - ticks[first]) * (leaves - first) / (last - first)
            assert x == pytest.approx(place, abs=0.02)
    assert [len(each.findall(f"{SVG}path")) for each in points] == [2, 4, 2, 2]  # two arrowheads


def test_long_intervals_do_not_hide_the_numbers():
    low, high, ticks = figures._scale(figures._reach({"a": [Point(1.0, -50.0, 50.0), Point(2.0, 1.9, 2.1)]}))
    assert low <= 0 and 2 < high <= 4 and len(ticks) <= 9


@pytest.mark.parametrize("reach", [1e-6, 0.3, 1.0, 7.0, 12345.0])
def test_ticks_are_few_and_round(reach):
    low, high, ticks = figures._scale([reach])
    assert low == 0 and high >= reach * (1 - 1e-9) and 2 <= len(ticks) <= 8
    step = ticks[1] - ticks[0]
    assert step / 10 ** math.floor(math.log10(step) + 1e-9) == pytest.approx(
        round(step / 10 ** math.floor(math.log10(step) + 1e-9))
    )


def test_dots_and_heat_maps_say_every_number():
    rows = [
        ("a", "maviper", Point(0.2, 0.1, 0.3)),
        ("b", "", Point(NAN, NAN, NAN)),
        ("c", "vote-N", Point(0.0, NAN, NAN)),
    ]
    assert titles(figures.dots("t", "x", rows)) == ["t", "a: 0.200 [0.100, 0.300]", "c: 0.000"]
    text = figures.heat("t", ["one"], ["f", "g"], [[0.25, 1.0]])
    assert titles(text) == ["t", "one, f: 0.250", "one, g: 1.000"]
    assert [each.text for each in ET.fromstring(text).iter(f"{SVG}text")][-2:] == [".25", "1.00"]
