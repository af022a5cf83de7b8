"""Drawings of a report, ready for its page: corners of marks and places of names.

Does: adds to the marks of each counterexample's picture the numbers that the page writes; places labels beside marks;
  lays out the paths of decisions.
Assumes: facts of a report (report.py, episodes.py), with pictures in picture coordinates.
Does not: change the facts, which are also the JSON report.
"""

from collections.abc import Mapping
from typing import Any, TypeAlias

from codegen.wording import holds

LANDMARK, DOT = 7, 4  # half the sides of the squares that stand for a landmark, alone and within its region
VIEW = 300.0  # side of a picture
MARK = 9.0  # half the side of what an agent or landmark covers, picture units
TALL = 6  # half the height of a label
LETTER = 5.6  # width of a letter of a label
Rectangle: TypeAlias = tuple[float, float, float, float]  # left, top, right, bottom
MIDDLE = 3.5  # from the middle of a label to its base line
LEVEL, BOX, HALF, ASIDE = 54, 15, 84, 34  # of a path: rows, half a test's height and width, centres of what is left out
MAX_LETTERS = 27  # of a name in a test's box


def draw_picture(result: Mapping[str, Any]) -> dict[str, Any]:
    """A result with what its picture needs beside the facts."""
    counterexample = result.get("counterexample")
    if not counterexample:
        return dict(result)
    agents = [{**agent, "drawing": _path(agent)} if agent.get("path") else agent for agent in counterexample["agents"]]
    ready = {**counterexample, "agents": agents}
    if picture := counterexample.get("picture"):  # over observations nothing has a place
        ready["picture"] = {**picture, **(_courses(picture) if "courses" in picture else _state(picture))}
    return {**result, "counterexample": ready}


def _path(agent: Mapping[str, Any]) -> dict[str, Any]:
    """A decision's path down its tree: the taken way straight down, the other side of each test beside it."""
    middle, steps = VIEW / 2, agent["path"]
    tests: list[dict[str, Any]] = []
    for level, step in enumerate(steps):
        test = holds(step["threshold"]).replace("<=", "≤")
        y, side = BOX + 3 + level * LEVEL, 1 if step["left"] else -1
        name = step["feature"] if len(step["feature"]) <= MAX_LETTERS else f"{step['feature'][: MAX_LETTERS - 1]}…"
        tests.append(
            {
                "box": {"left": middle - HALF, "top": y - BOX, "width": 2 * HALF, "height": 2 * BOX},
                "lines": [
                    {"y": y - 2, "text": name},
                    {"y": y + 10, "text": test},
                ],
                "down": {"y0": y + BOX, "y1": y + LEVEL - BOX, "label_y": y + LEVEL / 2 + MIDDLE},
                "says": "yes" if step["left"] else "no",
                "test": step["test"],
                "aside": {
                    "x0": middle + side * HALF / 2,
                    "y0": y + BOX,
                    "x": middle + side * (middle - ASIDE),
                    "y": y + LEVEL / 2,
                    "text_y": y + LEVEL / 2 + BOX,
                    "text": f"{step['others']:,} {'leaf' if step['others'] == 1 else 'leaves'}",
                },
            }
        )
    end = BOX + 3 + len(steps) * LEVEL
    leaf = {"left": middle - HALF / 2, "top": end - BOX, "width": HALF, "height": 2 * BOX, "text_y": end + MIDDLE}
    return {
        "width": VIEW,
        "height": end + BOX + 3,
        "middle": middle,
        "label_x": middle + 5,
        "tests": tests,
        "leaf": leaf,
    }


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
    best: tuple[float, Rectangle] | None = None
    for dx, dy in ((0, -16), (0, 17), (side, 0), (-side, 0), (side, -13), (-side, 13), (0, -29), (0, 30)):
        x = min(max(mark["x"] + dx, half), VIEW - half)
        y = min(max(mark["y"] + dy, TALL), VIEW - TALL)
        box = (x - half, y - TALL, x + half, y + TALL)
        covered = sum(_overlap(box, other) for other in taken)
        if best is None or covered < best[0]:
            best = covered, box
    assert best is not None
    box = best[1]
    taken.append(box)
    return round((box[0] + box[2]) / 2, 2), round((box[1] + box[3]) / 2, 2)


def _overlap(a: tuple[float, ...], b: tuple[float, ...]) -> float:
    """Area that two rectangles (left, top, right, bottom) share."""
    return max(0.0, min(a[2], b[2]) - max(a[0], b[0])) * max(0.0, min(a[3], b[3]) - max(a[1], b[1]))
