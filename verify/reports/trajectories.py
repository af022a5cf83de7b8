"""Trajectories in stated systems: counterexamples as tables that other programs read, and closest approaches in words.

Does: collects what is told of a counterexample; writes a CSV of each episode: step, time where the file states `dt`,
  variables, actions; words what came nearest.
Assumes: facts of systems.py; numbers of tables are the nearest float64, in their shortest decimals.
Does not: draw (courses.py).
"""

from __future__ import annotations

import csv
import io
from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from math import isfinite
from typing import TYPE_CHECKING, Any

from codegen.floats import rational_literal
from codegen.lowering.render import brief
from codegen.numbers import nearest_double
from codegen.wording import format_count
from verify.claims.formula import holds
from verify.decimals import plain
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
