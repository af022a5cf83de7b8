"""Counterexamples in stated systems: as plain data, as tables that other programs read, as pictures, and in words.

Does: collects what is told of a counterexample; writes a CSV of each episode: step, time where the file states `dt`,
  variables, actions; words what came nearest; lays out lines, the bounds that the claim names, and labels for the page;
  says states and bounds of modes by their names.
Assumes: facts of systems.py; numbers of tables are the nearest float64, in their shortest decimals.
Does not: change the facts, which are also the JSON report.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from itertools import groupby
from math import ceil, floor, isfinite
from typing import TYPE_CHECKING, Any

from codegen.floats import rational_literal
from codegen.lowering.render import brief
from codegen.numbers import nearest_double
from codegen.wording import format_count
from verify.claims.formula import holds
from verify.decimals import plain
from verify.reports.drawing import MIDDLE, VIEW
from verify.subjects import ClosedLoop, Subject

if TYPE_CHECKING:
    from verify.reach.results import SystemCounterexample, Values
    from verify.systems.claims import SystemClaim


def counterexample(episode: SystemCounterexample) -> dict[str, Any]:
    """An episode as plain data: exact numbers as texts; the states of all steps as float64 numbers."""
    agents = list(episode.actions[0]) if episode.actions else []
    chosen = list(dict.fromkeys(name for step in episode.choices for name in step))
    choices = {name: [step.get(name, "") for step in episode.choices] for name in chosen}
    return {
        "step": episode.step,
        "start": {name: rational_literal(value) for name, value in episode.start.items()},
        "start_float64": episode.start_as_doubles,
        "states": {name: [number(state[name]) for state in episode.states] for name in episode.start},
        "actions": {agent: [joint[agent] for joint in episode.actions] for agent in agents},
        "errors": [{name: rational_literal(value) for name, value in each.items()} for each in episode.errors],
        "pieces": list(episode.pieces),
        **({"choices": choices} if choices else {}),
        **({} if episode.seconds is None else {"seconds": plain(episode.seconds)}),
        **({"longer": _alone([rational_literal(each) for each in episode.longer])} if any(episode.longer) else {}),
        **({"way": _alone(episode.ways)} if any(episode.ways) else {}),
        **({"rank": episode.rank} if episode.rank else {}),
    }


def _alone(values: Sequence[str] | Sequence[int]) -> Any:
    """Returns one value as it is, and several, which change from period to period, as a list."""
    return values[0] if len(values) == 1 else list(values)


def tell_closely(subject: Subject, claim: SystemClaim, shown: SystemCounterexample) -> dict[str, dict[str, str]]:
    """`closely`: by variable, numbers of the state that breaks a claim which six digits tell too coarsely, since with
    those it breaks nothing. They have the digits of the nearest float64; where these break nothing either, what they
    are beside them. Nothing where six digits do.
    """
    from verify.reach.replay import Course, replay_course

    assert isinstance(subject, ClosedLoop)
    profile, system, excluded = subject.profile, subject.system, claim.violation_at(shown.step)

    def breaks(state: Values) -> bool:
        if claim.about_decisions:
            return replay_course(profile, system, claim, Course(state)) is not None
        return holds(excluded, state, {})

    closely = _tell_closely(shown.states[-1], breaks)
    return {"closely": closely} if closely else {}


def _tell_closely(state: Values, breaks: Callable[[Values], bool]) -> dict[str, str]:
    """Describes a state as closely as the function above; nothing where it breaks nothing itself."""
    if not breaks(state) or not all(isfinite(nearest_double(value)) for value in state.values()):
        return {}
    kept, told = dict(state), dict[str, str]()
    for name, value in state.items():
        texts = _texts(value)
        text, shown = next(pair for pair in texts if breaks({**kept, name: pair[1]}))
        kept[name] = shown
        told |= {} if text == texts[0][0] else {name: text}
    return told


def _texts(value: Fraction) -> list[tuple[str, Fraction]]:
    """Lists texts that may stand for a number, the shortest first, with what each says; the last says the number."""
    nearest = nearest_double(value)
    texts = [brief(nearest), repr(nearest)]
    off = value - Fraction(texts[1])
    least = nearest_double(abs(off))
    beside = f"{texts[1]} {'-' if off < 0 else '+'} {brief(least) if least else 'less than 5e-324'}"
    return [*((text, Fraction(text)) for text in texts), (beside, value)]


def number(value: Fraction | float) -> float | str:
    """The nearest float64, or in words that there is none near."""
    nearest = nearest_double(value) if isinstance(value, Fraction) else value
    return nearest if isfinite(nearest) else "above 1.79e308" if nearest > 0 else "below -1.79e308"


def tables(told: Mapping[str, Any]) -> dict[str, str]:
    """File name -> CSV, for each episode of a report."""
    pairs = ((result.get("counterexample"), result) for result in told["results"])
    return {table_name(each["file"]): table(each, told["dt"]) for each, _ in pairs if each and each["step"]}


def table_name(file: str) -> str:
    """The table beside a counterexample's file."""
    return f"{file.removesuffix('.json')}.csv"


def table(course: Mapping[str, Any], dt: str | None) -> str:
    """One episode: a row for each state, with the actions that are taken in it."""
    states, actions, file = course["states"], course["actions"], io.StringIO()
    choices = course.get("choices", {})
    rows = csv.writer(file, lineterminator="\n")
    rows.writerow(["step", *(["time_s"] if dt else []), *states, *(f"{agent}.action" for agent in actions), *choices])
    broken, begins = course.get("seconds"), _begin_steps(course, dt)  # of a flow: when its last state is
    for step, values in enumerate(zip(*states.values(), strict=True)):
        taken = [each[step] if step < len(each) else "" for each in (*actions.values(), *choices.values())]
        time = nearest_double(Fraction(broken)) if broken and step == course["step"] else begins[step] if dt else 0.0
        rows.writerow([step, *([time] if dt else []), *values, *taken])
    return file.getvalue()


def _begin_steps(course: Mapping[str, Any], dt: str | None) -> list[float]:
    """When each step begins, by the lengths of the periods before it."""
    longer, time, begins = course.get("longer", "0"), Fraction(0), list[float]()
    changing = [longer] if isinstance(longer, str) else longer
    for step in range(course["step"] + 1 if dt else 0):
        begins.append(nearest_double(time))
        time += Fraction(dt or 0) + Fraction(changing[min(step, len(changing) - 1)])
    return begins


def seconds(step: int, dt: str) -> float:
    """When a step begins. `dt`: an exact number of seconds."""
    return nearest_double(step * Fraction(dt))


def moment(step: int, dt: str | None) -> str:
    """A step in words, with its time where that is known: `step 12 (0.24 s)`."""
    return f"step {step} ({brief(seconds(step, dt))} s)" if dt else f"step {step}"


def nearness(told: Mapping[str, Any], dt: str | None) -> str:
    """Describes how near episodes come to the border of a claim, or how far beyond it the counterexample goes; "" where
    neither was measured.
    """
    near = told.get("approach")
    if near is None:
        return ""
    amount, when = f"{brief(near['gap'])} {near['unit']}".rstrip(), moment(near["step"], dt)
    if near["episodes"]:
        played = format_count(near["episodes"], "random episode")
        return f"closest approach: {amount} from {near['border']}, at {when} of {played}"
    return f"{amount} {'short of' if near['short'] else 'beyond'} {near['border']}, at {when}"


DECISIONS = "decisions"  # the kind of a claim that is not about episodes
HEIGHT = 120.0  # of a picture, picture units
LEFT, RIGHT, TOP, BOTTOM = 48.0, 48.0, 10.0, 20.0  # margins around what is plotted
MAX_DRAWN = 12  # variables
BEFORE = 4  # steps that are drawn before a claim begins to speak
MAX_DOTS = 40  # steps up to which each state is a dot
STRETCH = 10  # bounds farther away than this many times the span of the values are not drawn
LABEL = 11.0  # least distance of two labels
TOGETHER = "A state lies in a region if all of its variables do at once."
MAX_HEIGHT = 1e300  # of what is drawn: the room about it is a float64 number too
BANDS = {
    "stays_in": f"Bands: the region that the claim names. {TOGETHER}",
    "always": f"Bands: the region that the claim names. {TOGETHER}",
    "avoids": f"Bands: the region to be avoided. {TOGETHER}",
    "reaches": f"Bands: the region to be reached. {TOGETHER}",
    "reaches_and_stays": f"Bands: the region, at the steps of which the claim speaks. {TOGETHER}",
}


def draw_courses(
    result: Mapping[str, Any], variables: Sequence[Mapping[str, Any]], dt: str | None = None
) -> dict[str, Any]:
    """A result with what page and text write of its counterexample. `variables`: those of the report; `dt`: the seconds
    of a step, an exact text; None: nobody states them.
    """
    counterexample = result.get("counterexample")
    units = {each["name"]: each["unit"] for each in variables}
    if not counterexample:
        played = result.get("approach", {}).get("played", {})
        plots = [_plot(result, name, units[name], dt, [run for run in runs if run]) for name, runs in played.items()]
        return {**result, "plots": plots[:MAX_DRAWN]} | ({"legend": _legend(result)} if plots else {})
    ready = {**counterexample, "runs": list_taken(result)}
    ready["chosen"] = {name: runs(taken) for name, taken in counterexample.get("choices", {}).items()}
    named = in_modes(counterexample["start_float64"], result)
    ready |= {"began": tell_start(result) | named, "begun_in": named}
    ready["start"] = {name: value for name, value in counterexample["start"].items() if name not in named}
    if not is_still(result):
        named = [
            name for name in counterexample["states"] if any(name in region["box"] for region in result["regions"])
        ]
        rest = [*named, *(name for name in counterexample["states"] if name not in named)]
        last, states = tell_end(counterexample), counterexample["states"]
        # what no float64 is near is told in words
        shown = [name for name in rest if all(not isinstance(y, str) and abs(y) < MAX_HEIGHT for y in states[name])]
        ready |= {
            "plots": [_plot(result, name, units[name], dt, [states[name]]) for name in shown[:MAX_DRAWN]],
            "moment": moment(counterexample["step"], dt),
            "table": table_name(counterexample["file"]),
            "not_drawn": [name for name in rest if name not in shown[:MAX_DRAWN]],
            "legend": _legend(result),
            "last": last | in_modes(last, result),
            "errs": _errors(counterexample["errors"]),
        }
    return {**result, "counterexample": ready}


def tell_start(result: Mapping[str, Any]) -> dict[str, float | str]:
    """The start of a counterexample, or the state that breaks a claim about decisions, as closely as that takes."""
    counterexample = result["counterexample"]
    closely: Mapping[str, str] = counterexample.get("closely", {})
    return {**counterexample["start_float64"], **(closely if is_still(result) else {})}


def tell_end(counterexample: Mapping[str, Any]) -> dict[str, float | str]:
    """The last state of an episode, as closely as it takes to see that it breaks the claim."""
    last = {name: values[-1] for name, values in counterexample["states"].items()}
    return {**last, **counterexample.get("closely", {})}


def in_modes(state: Mapping[str, float | str], result: Mapping[str, Any]) -> dict[str, str]:
    """The modes of a state, by their names."""
    modes = result.get("modes", {})
    return {name: modes[name][round(float(value))] for name, value in state.items() if name in modes}


def within(told: Mapping[str, Any]) -> list[str]:
    """The bounds of what an answer leaves open."""
    if "open" not in told:
        return []
    bounds = told["open"]["bounds"]
    return [_between(name, each, told.get("modes", {})) for name, each in bounds.items()]


def _between(name: str, ends: Sequence[float | str], modes: Mapping[str, Sequence[str]]) -> str:
    """Bounds in words; of a mode the names between them."""
    low, high = ends
    if name in modes and not isinstance(low, str) and not isinstance(high, str):
        return f"{name} in [{', '.join(modes[name][max(ceil(low), 0) : floor(high) + 1])}]"
    return f"{name} in [{_in_few(low)}, {_in_few(high)}]"


def _in_few(number: float | str) -> str:
    return number if isinstance(number, str) else f"{number:.4g}"


def is_still(result: Mapping[str, Any]) -> bool:
    """Returns True if a result is about single decisions, in which nothing moves."""
    return result["kind"] == DECISIONS


def _legend(result: Mapping[str, Any]) -> str:
    """Describes the bands, and what of the claim they do not show."""
    regions, told = result["regions"], BANDS[result["name"]]
    conditions = [words for region in regions for words in region["conditions"]]
    told += f" The claim names {len(regions)} regions; to lie in one of them is enough." if len(regions) > 1 else ""
    return told + (f" Not drawn: {', '.join(conditions)}." if conditions else "")


def _errors(taken: Sequence[Mapping[str, str]]) -> str:
    """The largest error of each variable in an episode."""
    largest: dict[str, Fraction] = {}
    for name, value in (each for step in taken for each in step.items()):
        largest[name] = max(largest.get(name, Fraction(0)), abs(Fraction(value)))
    told = [f"{name} up to {brief(nearest_double(value))}" for name, value in largest.items() if value]
    return ", ".join(told) or "none"


def list_taken(result: Mapping[str, Any]) -> dict[str, str]:
    """By agent, the actions of a counterexample in a row, and what they make of what is remembered."""
    words, taken = result.get("updates", {}), result["counterexample"]["actions"]
    return {agent: runs([words.get(agent, {}).get(each, each) for each in row]) for agent, row in taken.items()}


def runs(actions: Sequence[str]) -> str:
    """Actions in a row, equal ones together: `left 3x, stay, right 2x`."""
    groups = ((name or "none", sum(1 for _ in same)) for name, same in groupby(actions))
    return ", ".join(name if count == 1 else f"{name} {count}x" for name, count in groups)


def _plot(
    result: Mapping[str, Any], name: str, unit: str, dt: str | None, episodes: Sequence[Sequence[float]]
) -> dict[str, Any]:
    """One variable: a line for each episode over the steps, or over time, where the claim bounds it, and labels. Of a
    claim that begins late only the steps from shortly before.
    """
    longest = max(map(len, episodes))
    last = result["steps"] if result["by"] else longest - 1
    first = max(0, min(result["by"], longest - 1) - BEFORE)
    values = [value for episode in episodes for value in episode[first:]] or [episodes[0][-1]]
    bounds = [_ends(region["box"][name]) for region in result["regions"] if name in region["box"]]
    known = {end for ends in bounds for end in ends if end is not None}
    low, high = min(values), max(values)  # with some room, and the bounds that are not far from all values
    far = STRETCH * (high - low or abs(low) or 1.0)
    near = [end for end in known if low - far <= end <= high + far]
    low, high = min([low, *near]), max([high, *near])
    room = (high - low) / 20 or abs(low) / 20 or 1.0
    low, high = low - room, high + room
    width, height = VIEW - LEFT - RIGHT, HEIGHT - TOP - BOTTOM

    def x(step: int) -> float:
        return round(LEFT + width * (step - first) / max(last - first, 1), 2)

    def y(value: float) -> float:
        return round(TOP + height * (high - min(max(value, low), high)) / (high - low), 2)

    bands = [_band(ends, x(result["by"]), x(max(last, 1)), y, (low, high)) for ends in bounds]
    inside = sorted((end for end in known if low < end < high), reverse=True)
    lines = [[(x(step), y(value)) for step, value in enumerate(each) if step >= first] for each in episodes]
    places = lines[0] if len(lines) == 1 else []
    return {
        "name": name,
        "unit": "" if unit == "1" else unit,
        "from": brief(min(values) if len(episodes) > 1 else values[0]),
        "to": brief(max(values) if len(episodes) > 1 else values[-1]),
        "width": VIEW,
        "height": HEIGHT,
        "left": LEFT,
        "right": VIEW - RIGHT,
        "floor": HEIGHT - BOTTOM,
        "ceiling": TOP,
        "bands": bands,
        "bounds": [y(end) for end in inside],
        "beyond": len(inside) < len(known),
        "labels": _apart([(y(end) + MIDDLE, f"{end:.4g}") for end in inside]),
        "ends": [{"y": y(end) + MIDDLE, "text": f"{end:.3g}"} for end in sorted({max(values), min(values)})],
        "lines": [" ".join(f"{at},{up}" for at, up in line) for line in lines],
        "dots": places[:-1] if len(places) <= MAX_DOTS else [],
        "end": places[-1:],
        "first": f"{brief(seconds(first, dt))} s" if dt else f"step {first}",
        "steps": f"{brief(seconds(last, dt))} s" if dt else last,
        "over": "time" if dt else "the steps",
    }


def _ends(written: Sequence[str | None]) -> tuple[float | None, ...]:
    return tuple(None if end is None else nearest_double(Fraction(end)) for end in written)


def _band(
    ends: tuple[float | None, ...], left: float, right: float, y: Any, shown: tuple[float, float]
) -> dict[str, float]:
    """Where a region bounds the variable: from the first step that counts to the last."""
    low, high = (given if end is None else end for end, given in zip(ends, shown, strict=True))
    return {"x": left, "y": y(high), "width": round(right - left, 2), "height": round(y(low) - y(high), 2)}


def _apart(labels: Sequence[tuple[float, str]]) -> list[dict[str, Any]]:
    """Labels from the top down, none of which covers the one before."""
    placed: list[dict[str, Any]] = []
    for y, text in labels:
        lowest = placed[-1]["y"] + LABEL if placed else y
        placed.append({"y": round(max(y, lowest), 2), "text": text})
    return placed
