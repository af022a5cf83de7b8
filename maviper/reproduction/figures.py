"""Figures of the report: lines over depth, dots with intervals, and heat maps, laid out for SVG templates.

Does: scales, ticks, marks and labels; one colour and one shape for each algorithm, so that colour alone says nothing.
Assumes: few series of few points; finite numbers (others are left out).
Does not: know where numbers come from.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from codegen.lowering.render import render

WIDTH, LEFT, RIGHT, TOP, PLOT = 400, 44, 388, 30, 190
ROW, SIDE, INSET = 24, 30, 12
LEGEND_COLUMNS, LEGEND_ROW = 2, 18
APART = 7.0  # between the series at one x, so that intervals can be told apart
MAX_TICKS = 6
CUT = 4  # half the width of the arrowhead on an interval that goes on beyond the frame


@dataclass(frozen=True)
class Mark:
    """The mark of an algorithm: Okabe and Ito's colours, lighter on a dark page, and a shape around the origin."""

    index: int
    light: str
    dark: str
    shape: str


_LOOKS = {
    "maviper": ("#0072b2", "#5ab4f0", "M-4,-4h8v8h-8z"),
    "iviper": ("#d55e00", "#ff9d52", "M0,-5l5,9h-10z"),
    "imitation": ("#00805f", "#3fcfa3", "M-4.5,0a4.5,4.5 0 1 0 9,0a4.5,4.5 0 1 0 -9,0z"),
    "fitted-q": ("#a8508a", "#e69ac8", "M0,-6l6,6l-6,6l-6,-6z"),
    "maviper-no-prediction": ("#8a6d00", "#e6c84a", "M-5,-3l3,-3l2,3l2,-3l3,3l-3,3l3,3l-3,3l-2,-3l-2,3l-3,-3l3,-3z"),
    "maviper-iviper-resampling": ("#2b7fa6", "#8fd0f0", "M0,5l5,-9h-10z"),
    "expert": ("#444f5a", "#c3ccd4", "M-1.5,-6h3v4.5h4.5v3h-4.5v4.5h-3v-4.5h-4.5v-3h4.5z"),
    "": ("#6b4aa0", "#c2a7f0", "M-6,-2h12v4h-12z"),
}
MARKS = {name: Mark(index, *look) for index, (name, look) in enumerate(_LOOKS.items())}
NAMES = {
    "maviper": "MAVIPER",
    "iviper": "IVIPER",
    "imitation": "Imitation DT",
    "fitted-q": "Fitted Q",
    "fitted-q-exploring": "Fitted Q, exploring",
    "expert": "expert",
    "maviper-no-prediction": "no prediction",
    "maviper-iviper-resampling": "IVIPER resampling",
    "viper": "VIPER",
    "rgmdt": "RGMDT, after the description",
}


def name_algorithm(algorithm: str) -> str:
    """An algorithm's name for people."""
    return NAMES.get(algorithm, algorithm)


def mark(algorithm: str) -> Mark:
    """Returns the mark of an algorithm, the same in every figure."""
    return MARKS.get(algorithm, MARKS[""])


@dataclass(frozen=True)
class Point:
    """A number with its interval; of a line at `x`, of dots without."""

    value: float
    low: float
    high: float
    x: float = 0.0

    @property
    def finite(self) -> bool:
        """True if it can be drawn."""
        return math.isfinite(self.value)

    @property
    def ends(self) -> tuple[float, ...]:
        """The ends of its interval, where it has one."""
        return (self.low, self.high) if math.isfinite(self.low) and math.isfinite(self.high) else ()

    @property
    def told(self) -> str:
        """In words."""
        low, high = self.ends or (math.nan, math.nan)
        return f"{self.value:z.3f} [{low:z.3f}, {high:z.3f}]" if self.ends else f"{self.value:z.3f}"


def lines(
    title: str,
    x_label: str,
    series: Mapping[str, list[Point]],
    reference: float | None = 1.0,
    looks: Mapping[str, Mark] = MARKS,
    to_scale: bool = False,
    bands: bool = False,
) -> str:
    """Series by algorithm over a few values of x; a dashed line at `reference`, where the expert is. `looks`: of series
    that are no algorithms. `to_scale`: both axes are; that of the values need not begin at 0. `bands`: of many values
    of x, each with an interval; few of them are marked.
    """
    shown = {name: [point for point in points if point.finite] for name, points in series.items()}
    shown = {name: points for name, points in shown.items() if points}
    xs = sorted({point.x for points in shown.values() for point in points})
    bottom = TOP + PLOT
    low, high, steps = _scale([*_reach(shown), *([] if reference is None else [reference])], not to_scale)
    rows = -(-len(shown) // LEGEND_COLUMNS)
    first, last, ticks = (
        _scale(xs or [1.0]) if to_scale else (0.0, 1.0, xs if len(xs) <= MAX_TICKS else [xs[0], xs[-1]])
    )

    def down(value: float) -> float:
        return round(bottom - PLOT * (min(max(value, low), high) - low) / (high - low), 2)

    def across(x: float) -> float:
        room = RIGHT - LEFT - 2 * INSET
        return LEFT + INSET + room * (x - first) / (last - first) if to_scale else _across(x, xs)

    drawn: list[dict[str, Any]] = []
    for place, (name, points) in enumerate(shown.items()):
        apart = APART * (place - (len(shown) - 1) / 2) if len(xs) <= MAX_TICKS and not to_scale else 0.0
        at = [round(across(point.x) + apart, 2) for point in points]
        ends = [[down(end) for end in point.ends] or [None, None] for point in points]
        placed = [
            {
                "x": x,
                "y": down(point.value),
                "low": None if bands else end[0],
                "high": end[1],
                "cut": [
                    f"M{x - CUT},{edge + way * CUT} L{x},{edge} L{x + CUT},{edge + way * CUT}"
                    for edge, way, beyond in (
                        (bottom, -1, min(point.ends, default=low) < low),
                        (TOP, 1, max(point.ends, default=high) > high),
                    )
                    if beyond
                ],
                "told": f"{name_algorithm(name)}: {point.told}",
            }
            for x, point, end in zip(at, points, ends, strict=True)
        ]
        path = "M" + " L".join(f"{each['x']},{each['y']}" for each in placed)
        lower, upper = zip(*ends, strict=True)
        corners = zip([*at, *reversed(at)], [*upper, *reversed(lower)], strict=True)
        band = "M" + " L".join(f"{x},{y}" for x, y in corners) + " Z" if bands else ""
        marked = placed[:: len(placed) // MAX_TICKS + 1] if bands else placed
        drawn.append({"mark": looks.get(name) or mark(name), "points": marked, "path": path, "band": band})
    figure = {
        "title": title,
        "x_label": x_label,
        "width": WIDTH,
        "height": bottom + 48 + LEGEND_ROW * rows,
        "left": LEFT,
        "right": RIGHT,
        "top": TOP,
        "bottom": bottom,
        "y_ticks": [{"at": down(step), "text": f"{step:g}"} for step in steps],
        "x_ticks": [{"at": round(across(x), 2), "text": f"{x:g}"} for x in ticks],
        "reference": None if reference is None else down(reference),
        "series": drawn,
        "legend": [_place_legend(name, k, bottom, looks) for k, name in enumerate(shown)],
    }
    return render("reproduction/lines.svg.j2", figure=figure, marks=tuple(MARKS.values()))


def _place_legend(name: str, place: int, bottom: int, looks: Mapping[str, Mark]) -> dict[str, Any]:
    """A series' mark and name below the plot."""
    x, y = 16 + (place % LEGEND_COLUMNS) * 190, bottom + 52 + LEGEND_ROW * (place // LEGEND_COLUMNS)
    return {"mark": looks.get(name) or mark(name), "text": name_algorithm(name), "x": x, "y": y}


def dots(title: str, x_label: str, rows: Sequence[tuple[str, str, Point]]) -> str:
    """A row for each number: label, algorithm, the number with its interval."""
    shown = [(label, name, point) for label, name, point in rows if point.finite]
    low, high, steps = _scale(_reach({str(k): [point] for k, (_, _, point) in enumerate(shown)}))
    left = 150

    def right(value: float) -> float:
        return round(left + (RIGHT - left) * (min(max(value, low), high) - low) / (high - low), 2)

    placed: list[dict[str, Any]] = []
    for k, (label, name, point) in enumerate(shown):
        ends = [right(end) for end in point.ends] or [None, None]
        where = {"x": right(point.value), "y": TOP + ROW * k + ROW // 2, "low": ends[0], "high": ends[1]}
        placed.append({**where, "label": label, "mark": mark(name), "told": f"{label}: {point.told}"})
    bottom = TOP + ROW * len(shown)
    ticks = [{"at": right(step), "text": f"{step:g}"} for step in steps]
    box = {"width": WIDTH, "height": bottom + 40, "left": left, "right": RIGHT, "top": TOP, "bottom": bottom}
    figure = {**box, "title": title, "x_label": x_label, "rows": placed, "x_ticks": ticks}
    return render("reproduction/dots.svg.j2", figure=figure, marks=tuple(MARKS.values()))


def heat(title: str, rows: Sequence[str], columns: Sequence[str], values: Sequence[Sequence[float]]) -> str:
    """A map of numbers from 0 to 1, each written into its cell. `values`: [rows][columns]."""
    top, left = TOP + 78, 84
    cells = [
        {
            "x": left + SIDE * place,
            "y": top + SIDE * line,
            "opacity": round(0.85 * min(max(value, 0.0), 1.0), 3),
            "strong": value > 0.6,
            "text": f"{value:.2f}".removeprefix("0"),
            "told": f"{rows[line]}, {columns[place]}: {value:.3f}",
        }
        for line, numbers in enumerate(values)
        for place, value in enumerate(numbers)
    ]
    figure = {
        "title": title,
        "width": max(WIDTH, left + SIDE * len(columns) + 40),
        "height": top + SIDE * len(rows) + 12,
        "side": SIDE,
        "half": SIDE // 2,
        "cells": cells,
        "columns": [{"x": left + SIDE * k + 18, "y": top - 6, "text": name} for k, name in enumerate(columns)],
        "rows": [{"x": left - 8, "y": top + SIDE * k + 19, "text": name} for k, name in enumerate(rows)],
    }
    return render("reproduction/heat.svg.j2", figure=figure, marks=tuple(MARKS.values()))


# --- scales


def _reach(series: dict[str, list[Point]]) -> list[float]:
    """All that a scale should show; intervals no further than twice the range of the numbers themselves."""
    values = [point.value for points in series.values() for point in points]
    if not values:
        return [0.0, 1.0]
    room = max(max(values) - min(values), 0.2 * max(map(abs, values)), 1e-9)
    ends = [end for points in series.values() for point in points for end in point.ends]
    return [*values, *(min(max(end, min(values) - room), max(values) + room) for end in ends)]


def _scale(values: Sequence[float], from_zero: bool = True) -> tuple[float, float, list[float]]:
    """The ends of an axis that holds all values, `from_zero` also 0, and its ticks."""
    held = [*values, 0.0] if from_zero else values
    low, high = min(held), max(held)
    reach = (high - low) or 1.0
    size = 10.0 ** math.floor(math.log10(reach / MAX_TICKS))
    step = next(size * part for part in (1, 2, 5, 10) if reach / (size * part) <= MAX_TICKS)  # a round number
    first, last = math.floor(low / step + 1e-9), math.ceil(high / step - 1e-9)
    last = max(last, first + 1)
    return first * step, last * step, [round(k * step, 10) for k in range(first, last + 1)]


def _across(x: float, xs: Sequence[float]) -> float:
    """Few values of x lie evenly, many to scale."""
    if len(xs) == 1:
        return (LEFT + RIGHT) / 2
    if len(xs) <= MAX_TICKS:
        return LEFT + 40 + (RIGHT - LEFT - 80) * xs.index(x) / (len(xs) - 1)
    return LEFT + 10 + (RIGHT - LEFT - 20) * (x - xs[0]) / (xs[-1] - xs[0])
