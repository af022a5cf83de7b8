"""A signal in one picture: `python picture.py FILE` writes what its tree does, and what is proved of it, as SVG.

Does: draws the rules of a tree in `proofs/`; the reds of a road in traffic that never ends, of the tree and of the same
  one with clocks that stand still; the bound of the claim, and the longest red that its certificate leaves.
Assumes: that certificate was checked (`maviper check`).
Does not: simulate vehicles: there are so many in every approach at each decision.
"""

import sys
from collections.abc import Iterator, Sequence
from html import escape
from math import floor
from pathlib import Path

import numpy as np

import maviper
from codegen.ir import AgentPolicy
from verify.checker.certificate import numbers
from verify.checker.systems.proofs import from_json

NETWORK, AGENT, PLACE, ROAD, PHASE = "cologne3", "signal_0", "360082", "south", 2  # the phase that serves the road
STEP, MIN_GREEN, MAX_RED, SHOWN, VEHICLES = 5, 10, 120, 240, 9  # seconds, and vehicles in each approach
COLOURS = ("#2a6f97", "#8a5a9e", "#b5651d", "#557a46")  # of phases
PROOFS = Path(__file__).parent / "proofs"
WIDE, HIGH, LEFT, TOP, SCALE = 1000, 470, 600, 120, 1.25  # of the picture; where axes begin; points a second
Line = tuple[int, str, str]  # indent, words, action


def spell(feature: str, threshold: float) -> str:
    """A test in words, where it goes right."""
    name, _, kind = feature.rpartition("_")
    if name == "red":
        return f"phase {kind} has been red for more than {threshold:.4g} s"
    if name == "on":
        return f"while phase {kind} is on"
    return f"somebody stands in {name}" if kind == "halting" else f"more than {floor(threshold)} vehicles in {name}"


def rules(policy: AgentPolicy, node: int = 0, indent: int = 0) -> Iterator[Line]:
    """The tree as a list: the first line that is met says what it does."""
    tree = policy.tree
    if tree.feature[node] < 0:
        yield indent, "else", policy.actions[int(tree.action[node])].name
        return
    left, right = int(tree.left[node]), int(tree.right[node])
    said = spell(policy.features[int(tree.feature[node])].name, float(tree.threshold[node]))
    if tree.feature[right] < 0:
        yield indent, said, policy.actions[int(tree.action[right])].name
    else:
        yield indent, said, ""
        yield from rules(policy, right, indent + 1)
    yield from rules(policy, left, indent)


def reds(policy: AgentPolicy, clocks: bool) -> list[int]:
    """Seconds since the phase of the road was on, every STEP seconds. Without `clocks` the tree sees reds of 0."""
    names = [each.name for each in policy.features]
    on, green, red, seen = 0, 0, dict.fromkeys(range(3), 0), list[int]()
    for _ in range(SHOWN // STEP + 1):
        seen.append(red[PHASE])
        if green >= MIN_GREEN:
            told = {f"on_{on}": 1, "green": green, **{f"red_{k}": clocks * time for k, time in red.items()}}
            row = [told.get(name, VEHICLES if name.endswith(("cars", "halting", "ahead")) else 0) for name in names]
            action = policy.actions[int(policy.act([np.array(row, np.float32)])[0])].name
            after = int(action.removeprefix("green_"))
        else:
            after = on
        on, green = after, green + STEP if after == on else 0
        red = {k: 0 if k == on else time + STEP for k, time in red.items()}
    return seen


def longest(path: Path) -> int:
    """The longest red by the cells of a certificate, in seconds, with the step that gives green."""
    (part,) = from_json(path.read_bytes(), path.name).proof.parts
    heads = iter(numbers(part.cells))  # of each variable its first cell, zigzag, and how many there are
    spans = {name: (next(heads), next(heads)) for name in part.widths}
    return max(STEP * (low // 2 + count) for name, (low, count) in spans.items() if name.startswith("red"))


def write(x: float, y: float, words: str, more: str = "") -> str:
    """A line of text."""
    return f'<text x="{x:g}" y="{y:g}"{more}>{escape(words)}</text>'


def curve(values: Sequence[int], colour: str, more: str = "") -> str:
    """Reds over time."""
    points = " ".join(f"{LEFT + SCALE * STEP * k:g},{high(value):g}" for k, value in enumerate(values))
    return f'<polyline points="{points}" fill="none" stroke="{colour}" stroke-width="2.5"{more}/>'


def high(seconds: float) -> float:
    """Where a red is drawn."""
    return TOP + SCALE * (SHOWN - seconds)


def draw() -> str:
    """The picture."""
    policy, proved = maviper.load(PROOFS / f"{NETWORK}.json")[AGENT], longest(PROOFS / f"{NETWORK}-{AGENT}-2.json")
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDE} {HIGH}" font-family="sans-serif" font-size="14">',
        f'<rect width="{WIDE}" height="{HIGH}" fill="white"/>',
        write(
            30, 40, f"Green again within {proved} s, whatever the traffic does", ' font-size="24" font-weight="bold"'
        ),
        write(
            30,
            64,
            f"Signal {PLACE} of Cologne. Proved of its tree, for any number of vehicles at any time, for ever.",
        ),
        write(30, 98, "What the tree does: the first line that is met", ' font-weight="bold"'),
        write(LEFT, 98, f"How long {ROAD} has red, in traffic that never ends", ' font-weight="bold"'),
    ]
    for k, (indent, words, action) in enumerate(rules(policy)):
        y, phase = TOP + 17 * k, action.removeprefix("green_")
        lines.append(write(30 + 18 * indent, y, words))
        if action:
            lines.append(f'<rect x="430" y="{y - 12}" width="80" height="15" rx="7" fill="{COLOURS[int(phase)]}"/>')
            lines.append(write(470, y, f"phase {phase}", ' fill="white" font-size="12" text-anchor="middle"'))
    right = LEFT + SCALE * SHOWN
    for seconds in range(0, SHOWN + 1, 60):
        lines.append(f'<path d="M{LEFT},{high(seconds):g}H{right:g}" stroke="#ddd"/>')
        lines.append(write(LEFT - 8, high(seconds) + 5, f"{seconds} s", ' text-anchor="end"'))
        lines.append(write(LEFT + SCALE * seconds, high(0) + 20, f"{seconds}", ' text-anchor="middle"'))
    lines.append(write((LEFT + right) / 2, high(0) + 40, "seconds", ' text-anchor="middle"'))
    for seconds, colour, words, down in ((MAX_RED, "#c1121f", "claimed", 16), (proved, "#2d6a4f", "certified", -6)):
        lines.append(f'<path d="M{LEFT},{high(seconds):g}H{right:g}" stroke="{colour}" stroke-dasharray="7 4"/>')
        told = f' fill="{colour}" text-anchor="end"'
        lines.append(write(right, high(seconds) + down, f"{words}: at most {seconds} s", told))
    lines.append(curve(reds(policy, clocks=False), "#c1121f"))
    lines.append(write(LEFT + 195, high(222), "without clocks", ' fill="#c1121f" text-anchor="end"'))
    lines.append(curve(reds(policy, clocks=True), "#2d6a4f"))
    return "\n".join([*lines, "</svg>", ""])


if __name__ == "__main__":
    Path(sys.argv[1]).write_text(draw(), encoding="utf-8")
