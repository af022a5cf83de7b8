"""An hour of a signal, and its proof, in one picture: `python city.py FILE` writes it as SVG.

Does: draws the greens of each approach by the expert and by its tree with guards, in the minutes around the expert's
  longest red; of each approach that has any its longest red of the hour, beside the bounds of claim and certificate.
Assumes: hour/, as `hour.py` and `repaired.py` write it, whose certificates the checker accepts.
Does not: simulate.
"""

import json
import sys
from collections.abc import Collection, Iterator, Mapping
from pathlib import Path
from typing import Any

from picture import MAX_RED, STEP, longest, write

PLACE = Path(__file__).parent / "hour"
WIDE, HIGH, LEFT, ACROSS, ROW = 720, 924, 180, 520, 29  # of the picture; where axes begin, and how wide they are; a row
SHOWN, MOST = 600, 300  # seconds: of greens, and of reds
GREEN, RED, CLAIM, PROVED = "#2f9e5f", "#f4d3d0", "#b3261e", "#1d5c3a"
PLAYERS = {"expert": "#b5651d", "tree": "#8a5a9e", "guarded": "#2a6f97"}
WORDS = {"expert": "expert", "tree": "its tree", "guarded": "its tree with guards"}
SMALL = ' font-size="18" stroke="white" stroke-width="4" paint-order="stroke"'
BOLD, GREY = ' font-weight="bold"', ' fill="#555"'
ARROWS = {"left": "M9 20V9H2M6 5L2 9L6 13", "straight": "M9 20V2M5 6L9 2L13 6", "right": "M9 20V9H16M12 5L16 9L12 13"}
Hour = Mapping[str, Any]


def spans(phases: str, served: Collection[int], green: bool) -> Iterator[tuple[int, int]]:
    """When an approach has green, or has not, as (from, to) in seconds. A step that switches to it is clearance."""
    on = [phase in served for phase in map(int, phases)]
    shown = [now and before for now, before in zip(on, [on[0], *on], strict=False)]
    begun = 0
    for k, (now, after) in enumerate(zip(shown, [*shown[1:], not shown[-1]], strict=True)):
        if now != after:
            if now is green:
                yield begun * STEP, (k + 1) * STEP
            begun = k + 1


def longest_red(phases: str, served: Collection[int]) -> tuple[int, int]:
    """The longest time without green, and when it begins, in seconds."""
    return max(((end - begin, begin) for begin, end in spans(phases, served, green=False)), default=(0, 0))


def label(approach: str, turns: Collection[str], y: float) -> Iterator[str]:
    """Where an approach comes from, and arrows for where it may go."""
    yield write(20, y + 18, approach.partition("_")[0])
    for k, turn in enumerate(turns):
        place = f'transform="translate({110 + 26 * k},{y:g})"'
        yield f'<path d="{ARROWS[turn]}" {place} fill="none" stroke="#333" stroke-width="2.5"/>'


def greens(hour: Hour, player: str, begin: int, y: float) -> Iterator[str]:
    """A row for each approach."""
    shown = hour[player]["phases"][begin // STEP : (begin + SHOWN) // STEP]
    for k, (approach, told) in enumerate(hour["approaches"].items()):
        at, scale = y + ROW * k, ACROSS / SHOWN
        yield from label(approach, told["turns"], at)
        yield f'<rect x="{LEFT}" y="{at:g}" width="{ACROSS}" height="22" fill="{RED}"/>'
        for low, high in spans(shown, told["phases"], green=True):
            place = f'x="{LEFT + low * scale:.5g}" y="{at:g}" width="{(high - low) * scale:.5g}"'
            yield f'<rect {place} height="22" fill="{GREEN}"/>'


def reds(hour: Hour, bounds: Mapping[str, tuple[int, str, str]], y: float) -> Iterator[str]:
    """The longest reds of the hour, and where nobody can wait any more."""
    scale, at, rows = ACROSS / MOST, y, list[str]()
    for approach, told in hour["approaches"].items():
        found = {player: longest_red(hour[player]["phases"], told["phases"])[0] for player in PLAYERS}
        if any(found.values()):
            rows += label(approach, told["turns"], at + 22)
            for player, red in found.items():
                rows.append(
                    f'<rect x="{LEFT}" y="{at:g}" width="{red * scale:.5g}" height="20" fill="{PLAYERS[player]}"/>'
                )
                rows.append(write(LEFT + red * scale + 6, at + 17, f"{red} s", SMALL))
                at += 23
            at += 10
    for words, (seconds, colour, side) in bounds.items():
        x = LEFT + seconds * scale
        yield f'<path d="M{x:g} {y - 8:g}V{at:g}" stroke="{colour}" stroke-width="3" stroke-dasharray="8 4"/>'
        yield write(x, at + 18, f"{words} {seconds} s", f' fill="{colour}" text-anchor="{side}"')
    yield from rows


def draw() -> str:
    """The picture."""
    hour: Hour = json.loads((PLACE / "hour.json").read_text(encoding="utf-8"))
    network, approaches = hour["network"], hour["approaches"]
    proved = longest(PLACE / f"{network}-signal_0-2.json")
    reds_of = {name: longest_red(hour["expert"]["phases"], told["phases"]) for name, told in approaches.items()}
    worst = max(reds_of, key=lambda name: reds_of[name][0])
    red, since = reds_of[worst]
    begin = min(max(0, (since + red // 2 - SHOWN // 2) // 60 * 60), len(hour["expert"]["phases"]) * STEP - SHOWN)
    delays = {player: f"{hour[player]['delay']:.1f} s of delay a trip" for player in PLAYERS}
    stood = {player: hour[player]["stood"][worst] for player in PLAYERS}
    above, between = 128, ROW * len(approaches)
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDE} {HIGH}" font-family="sans-serif" font-size="20">',
        f'<rect width="{WIDE}" height="{HIGH}" fill="white"/>',
        write(20, 42, "Nobody waits for ever", ' font-size="32" font-weight="bold"'),
        write(
            20, 74, f"A signal of {network.rstrip('0123456789').title()} in SUMO: {SHOWN // 60} minutes, green and red"
        ),
        write(20, above - 14, f"The expert, green for most cars: {delays['expert']}", BOLD),
        *greens(hour, "expert", begin, above),
        write(20, above + between + 32, f"Its tree with guards: {delays['guarded']}", BOLD),
        *greens(hour, "guarded", begin, above + between + 46),
    ]
    y = above + 2 * between + 46
    for seconds in range(0, SHOWN + 1, 120):
        x = LEFT + seconds * ACROSS / SHOWN
        lines.append(write(x, y + 18, f"{(begin + seconds) // 60}", f' text-anchor="middle"{GREY}'))
    lines.append(write(20, y + 18, "minute", GREY))
    lines.append(write(20, y + 66, "Longest red of the hour, and what is proved for ever", BOLD))
    x = LEFT
    for player, words in WORDS.items():
        lines.append(f'<rect x="{x:g}" y="{y + 80}" width="18" height="18" fill="{PLAYERS[player]}"/>')
        lines.append(write(x + 25, y + 96, words))
        x += 45 + 11 * len(words)
    bounds = {"proved:": (proved, PROVED, "end"), "claimed:": (MAX_RED, CLAIM, "start")}
    lines += reds(hour, bounds, y + 118)
    place = worst.partition("_")[0]
    told = f"From the {place} a car stood {stood['expert']} s by the expert, {stood['tree']} s by its tree,"
    lines.append(write(20, HIGH - 46, told))
    lines.append(write(20, HIGH - 20, f"{stood['guarded']} s with guards. Proved: whatever the traffic does."))
    return "\n".join([*lines, "</svg>", ""])


if __name__ == "__main__":
    Path(sys.argv[1]).write_text(draw(), encoding="utf-8")
