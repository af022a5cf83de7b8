"""Drawings of a report, ready for its page: corners of marks and places of names.

Does: adds to the marks of each counterexample's picture the numbers that the page writes; places labels beside marks.
Assumes: facts of a report (report.py, episodes.py), with pictures in picture coordinates.
Does not: change the facts, which are also the JSON report.
"""

from collections.abc import Mapping
from typing import Any, TypeAlias

LANDMARK, DOT = 7, 4  # half the sides of the squares that stand for a landmark, alone and within its region
VIEW = 300.0  # side of a picture
MARK = 9.0  # half the side of what an agent or landmark covers, picture units
TALL = 6  # half the height of a label
LETTER = 5.6  # width of a letter of a label
Rectangle: TypeAlias = tuple[float, float, float, float]  # left, top, right, bottom
MIDDLE = 3.5  # from the middle of a label to its base line


def draw_picture(result: Mapping[str, Any]) -> dict[str, Any]:
    """A result with what its picture needs beside the facts."""
    counterexample = result.get("counterexample")
    if not counterexample:
        return dict(result)
    ready = dict(counterexample)
    if picture := counterexample.get("picture"):  # over observations nothing has a place
        ready["picture"] = {**picture, **(_courses(picture) if "courses" in picture else _state(picture))}
    return {**result, "counterexample": ready}


def _courses(picture: Mapping[str, Any]) -> dict[str, Any]:
    marks = [{**mark, "label": mark["name"]} for mark in (*picture["landmarks"], *picture["courses"])]
    taken = [around(mark["x"], mark["y"], DOT) for mark in marks]
    meetings: list[dict[str, Any]] = []
    for meeting in picture["meetings"]:
        (x, y), says = meeting["to"], meeting["says"]
        taken.append(around(x, y, LANDMARK))
        label_x, label_y = label_place({"x": x, "y": y, "label": says}, taken)
        meetings.append({**meeting, "label_x": label_x, "label_y": label_y + MIDDLE})
    placed = [(mark, label_place(mark, taken)) for mark in marks]
    labels = [{"x": x, "y": y + MIDDLE, "text": mark["label"]} for mark, (x, y) in placed]
    landmarks = [
        {**mark, "arrived": _square(mark, mark["half"]), "dot": _square(mark, DOT)} for mark in picture["landmarks"]
    ]
    return {"landmarks": landmarks, "labels": labels, "meetings": meetings}


def _state(picture: Mapping[str, Any]) -> dict[str, Any]:
    landmarks = [{**mark, "square": _square(mark, LANDMARK)} for mark in picture["landmarks"]]
    marks = (*picture["landmarks"], *picture["agents"])
    labels = [{"x": mark["label_x"], "y": mark["label_y"] + MIDDLE, "text": mark["label"]} for mark in marks]
    return {"landmarks": landmarks, "labels": labels}


def _square(mark: Mapping[str, Any], half: float) -> dict[str, float]:
    return {"left": mark["x"] - half, "top": mark["y"] - half, "side": 2 * half}


def around(x: float, y: float, half: float) -> Rectangle:
    """The square around a place: left, top, right, bottom."""
    return x - half, y - half, x + half, y + half


def label_place(mark: Mapping[str, Any], taken: list[Rectangle]) -> tuple[float, float]:
    """Centre of a label beside its mark where it covers nothing, if there is such a place; takes that place."""
    half = len(mark["label"]) * LETTER / 2
    side = half + MARK + 2
    boxes: list[Rectangle] = []
    for dx, dy in ((0, -16), (0, 17), (side, 0), (-side, 0), (side, -13), (-side, 13), (0, -29), (0, 30)):
        x = min(max(mark["x"] + dx, half), VIEW - half)
        y = min(max(mark["y"] + dy, TALL), VIEW - TALL)
        boxes.append((x - half, y - TALL, x + half, y + TALL))
    box = min(boxes, key=lambda each: sum(_overlap(each, other) for other in taken))
    taken.append(box)
    return round((box[0] + box[2]) / 2, 2), round((box[1] + box[3]) / 2, 2)


def _overlap(a: tuple[float, ...], b: tuple[float, ...]) -> float:
    """Area that two rectangles (left, top, right, bottom) share."""
    return max(0.0, min(a[2], b[2]) - max(a[0], b[0])) * max(0.0, min(a[3], b[3]) - max(a[1], b[1]))
