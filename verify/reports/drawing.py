"""Drawings of a report, ready for its page: corners of marks and places of names.

Does: adds to the marks of each counterexample's picture the numbers that the page writes.
Assumes: facts of a report (report.py, episodes.py), with pictures in picture coordinates.
Does not: change the facts, which are also the JSON report.
"""

from collections.abc import Mapping
from typing import Any

LANDMARK, DOT = 7, 4  # half the sides of the squares that stand for a landmark, alone and within its region
ABOVE, BELOW = 9, 16  # from a place to the base line of its name
MIDDLE = 3.5  # from the middle of a label to its base line


def drawn(result: Mapping[str, Any]) -> dict[str, Any]:
    """A result with what its picture needs beside the facts."""
    found = result.get("counterexample")
    if not found or not found.get("picture"):  # over observations nothing has a place
        return dict(result)
    picture = found["picture"]
    ready = _courses(picture) if "courses" in picture else _state(picture)
    return {**result, "counterexample": {**found, "picture": {**picture, **ready}}}


def _courses(picture: Mapping[str, Any]) -> dict[str, Any]:
    landmarks = [
        {
            **mark,
            "arrived": _square(mark, mark["half"]),
            "dot": _square(mark, DOT),
            "name_y": mark["y"] - ABOVE,
        }
        for mark in picture["landmarks"]
    ]
    courses = [{**course, "name_y": course["y"] + BELOW} for course in picture["courses"]]
    return {"landmarks": landmarks, "courses": courses}


def _state(picture: Mapping[str, Any]) -> dict[str, Any]:
    landmarks = [{**mark, "square": _square(mark, LANDMARK)} for mark in picture["landmarks"]]
    marks = (*picture["landmarks"], *picture["agents"])
    labels = [{"x": mark["label_x"], "y": mark["label_y"] + MIDDLE, "text": mark["label"]} for mark in marks]
    return {"landmarks": landmarks, "labels": labels}


def _square(mark: Mapping[str, Any], half: float) -> dict[str, float]:
    return {"left": mark["x"] - half, "top": mark["y"] - half, "side": 2 * half}
