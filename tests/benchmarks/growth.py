"""How the search by boxes grows: with steps, leaves, width of the start and variables.

    python tests/benchmarks/growth.py [--plot FILE.svg] [--json]

Each row changes one number of a quadrotor with a fitted tree, and sweeps its boxes once. Boxes do not depend on the
machine. Time is of the processor, the least of three runs, told as a multiple of that of the row's smallest case; its
ratio to that of boxes says how near the search is to linear in boxes.
"""

import argparse
import json
import sys
from fractions import Fraction as F
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[2]))  # for tests.*, also when run by this path

import numpy as np

from tests.benchmarks.sweep import fitted, timed
from tests.support import system_cases as cases
from verify.checker.covers.boxes import StartBox
from verify.checker.covers.sweep import BoxSweep

USUAL = {"steps": 30, "leaves": 90, "width": F(1, 5), "axes": 3}
ROWS = {
    "steps": (5, 10, 20, 40),
    "leaves": (10, 30, 90, 270),
    "width": (F(1, 20), F(1, 10), F(1, 5), F(2, 5)),
    "axes": (1, 2, 3),
}
WORDS = {"steps": "steps", "leaves": "leaves", "width": "width of the start, m", "axes": "variables"}
ROUNDS, MOST = 3, 10**7


def swept(steps, leaves, width, axes):
    """(boxes, seconds) of one sweep."""
    system, profile = cases.double_integrator(axes=axes, half=width / 2), fitted(axes, leaves)
    claim = cases.stays(system, steps, **dict.fromkeys("xyz"[:axes], (F(-9), F(9))))
    half = float(width) / 2
    low = np.array([-half] * axes + [0.0] * axes)
    starts = [StartBox(low, -low)]
    found = [timed(lambda: BoxSweep(profile, system, claim).find_open_parts(starts, MOST)) for _ in range(ROUNDS)]
    assert not found[0][0].open.any()
    return found[0][0].sets, min(seconds for _, seconds in found)


def measured():
    """Of each row: the values, boxes, and seconds."""
    found = {}
    for name, values in ROWS.items():
        runs = [swept(**{**USUAL, name: value}) for value in values]
        shown = [2 * value if name == "axes" else float(value) for value in values]
        found[name] = (shown, [boxes for boxes, _ in runs], [seconds for _, seconds in runs])
    return found


def table(found):
    """The rows as Markdown, time as multiples of the smallest case."""
    lines = ["| what grows | from, to | boxes | time, times the smallest |", "|---|---|---|---|"]
    for name, (values, boxes, seconds) in found.items():
        told = ", ".join(f"{value:g}" for value in values)
        times = ", ".join(f"{each / seconds[0]:.1f}" for each in seconds)
        lines.append(f"| {WORDS[name]} | {told} | {', '.join(f'{each:,}' for each in boxes)} | {times} |")
    return "\n".join(lines)


def plot(found, path):
    """Time over boxes, both as multiples of the smallest case of a row, as SVG without dates."""
    import matplotlib

    matplotlib.use("svg")
    matplotlib.rcParams |= {"svg.hashsalt": "growth", "svg.fonttype": "none"}  # letters, not their outlines
    from matplotlib import pyplot

    figure, axes = pyplot.subplots(figsize=(6, 4))
    for name, (_, boxes, seconds) in found.items():
        axes.loglog(
            [each / boxes[0] for each in boxes], [each / seconds[0] for each in seconds], "o-", label=WORDS[name]
        )
    ends = axes.get_xlim()
    axes.loglog(ends, ends, "k:", label="linear in boxes")
    axes.set_xlabel("boxes, times the smallest case")
    axes.set_ylabel("time, times the smallest case")
    axes.legend()
    figure.savefig(path, metadata={"Date": None})


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--plot", type=Path, help="an SVG file to write")
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    found = measured()
    if options.plot is not None:
        plot(found, options.plot)
    if options.json:
        figures = [
            {"name": f"{name} {value:g}, {what}", "value": float(each)}
            for name, (values, boxes, seconds) in found.items()
            for what, column in (("boxes", boxes), ("s", seconds))
            for value, each in zip(values, column, strict=True)
        ]
        print(json.dumps({"figures": figures}))
    else:
        print(table(found))


if __name__ == "__main__":
    main()
