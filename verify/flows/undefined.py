"""Which derivatives may not be defined where episodes go, for an answer that no enclosure was shown.

Does: bounds each derivative over the last sets that were followed, and a little beyond.
Assumes: parts of the start that a search left open.
Does not: prove: an episode need not get where a derivative is not defined.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from verify.checker.covers.parts import StartBox
from verify.checker.covers.rounding import ceiling, floor
from verify.checker.flows.programs import Stepping, StepPrograms
from verify.checker.flows.series import FlowReading
from verify.checker.flows.spans import Spans, finite, hull
from verify.checker.flows.sweep import FlowSweep, Plan, SeenStep
from verify.checker.reading import RejectedError
from verify.systems.system import System

MOST = 10_000  # sets that are followed for this
BEYOND = 1.0  # of its width, by which a set is looked at further


def find_undefined(system: System, sweep: FlowSweep, parts: Sequence[StartBox], plan: Plan) -> list[str]:
    """The variables whose derivatives may not be defined over a part, or over what was followed of it last."""
    assert system.flow is not None
    names = [one.name for one in system.variables]
    once = Stepping(1, system.flow.period)
    rates = [StepPrograms(FlowReading(each, names), once, ()).rates for each in system.flow.each]
    ends: dict[str, list[float]] = {}
    for values in system.flow.held.values():
        for name, value in values.items():
            ends.setdefault(name, []).extend((floor(value), ceiling(value)))
    seen = [Spans(np.array([part.low]), np.array([part.high])) for part in parts]

    def see(told: SeenStep) -> None:
        if told.tube.low.size:
            seen[len(parts) :] = [hull(told.tube, told.after)]

    sweep.watch, sweep.most = see, sweep.spent + MOST
    try:
        sweep.follow(parts, plan)
    except RejectedError:
        pass
    finally:
        sweep.watch = None
    undefined_names: dict[str, None] = {}
    for span in seen:
        by = BEYOND * (span.high - span.low)
        wide = Spans(span.low - by, span.high + by)
        held = {name: Spans(*(np.full(len(by), end) for end in (min(of), max(of)))) for name, of in ends.items()}
        given = held | {name: wide.at((slice(None), column)) for column, name in enumerate(names)}
        with np.errstate(all="ignore"):
            defined = [finite(each.run(given, len(by))) for each in rates]
        for row in defined:
            undefined_names |= {name: None for place, name in enumerate(names) if not row[place].all()}
    return list(undefined_names)
