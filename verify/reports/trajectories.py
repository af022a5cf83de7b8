"""Trajectories of counterexamples in stated systems, as tables that other programs read.

Does: writes a CSV of each episode: step, time where the file states `dt`, variables, actions.
Assumes: facts of systems.py; numbers are the nearest float64, in their shortest decimals.
Does not: draw (courses.py); hold exact numbers, which are in the counterexample's own file.
"""

import csv
import io
from collections.abc import Mapping
from fractions import Fraction
from typing import Any

from codegen.floats import nearest_double
from codegen.lowering.render import brief


def tables(told: Mapping[str, Any]) -> dict[str, str]:
    """File name -> CSV, for each episode of a report."""
    found = ((result.get("counterexample"), result) for result in told["results"])
    return {table_name(each["file"]): table(each, told["dt"]) for each, _ in found if each and each["step"]}


def table_name(file: str) -> str:
    """The table beside a counterexample's file."""
    return f"{file.removesuffix('.json')}.csv"


def table(found: Mapping[str, Any], dt: str | None) -> str:
    """One episode: a row for each state, with the actions that are taken in it."""
    states, actions, file = found["states"], found["actions"], io.StringIO()
    choices = found.get("choices", {})
    rows = csv.writer(file, lineterminator="\n")
    rows.writerow(["step", *(["time_s"] if dt else []), *states, *(f"{agent}.action" for agent in actions), *choices])
    broken = found.get("seconds")  # of a flow: when its last state is
    for step, values in enumerate(zip(*states.values(), strict=True)):
        taken = [each[step] if step < len(each) else "" for each in (*actions.values(), *choices.values())]
        time = (
            nearest_double(Fraction(broken)) if broken and step == found["step"] else seconds(step, dt) if dt else 0.0
        )
        rows.writerow([step, *([time] if dt else []), *values, *taken])
    return file.getvalue()


def seconds(step: int, dt: str) -> float:
    """When a step begins. `dt`: an exact number of seconds."""
    return nearest_double(step * Fraction(dt))


def moment(step: int, dt: str | None) -> str:
    """A step in words, with its time where that is known: `step 12 (0.24 s)`."""
    return f"step {step} ({brief(seconds(step, dt))} s)" if dt else f"step {step}"
