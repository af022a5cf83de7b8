"""What happens at the samples of a flow: modes and cases, by the checker's own reading, jitter and late observations.

Does: shows from the system alone that modes stay modes, and that some case holds every state; cuts sets by the cases
  that hold them; states a flow whose periods vary as one whose derivatives have a factor; sends sets down trees for
  each delay.
Assumes: systems/cases.py shows that boxes with conditions leave out nothing within the bounds that they share. Jitter
  by which a period stays longer than 0; variables that keep earlier values, as systems/system.py says.
Does not: move sets or ask claims.

If x' = f(x) + w for h seconds, then y(s) = x(p s) solves y' = p f(y) + p w for h / p seconds. So a period of any length
between T + a and T + b is a period of length T with one pace p in [1 + a/T, 1 + b/T], which stays for that period. It
goes through the same states. The pace is an input that is held, and p w lies in the hull of its products at the ends.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from fractions import Fraction

import numpy as np

from codegen.ir import AgentPolicy, Bool
from verify.checker.covers.boxes import BoxList, RegionCut, join_by_cell, together
from verify.checker.covers.trees import TreeCuts
from verify.checker.reading import RejectedError
from verify.checker.systems.cases import ensure_complete, ensure_starts, hull_of, is_mode_value, tests_of
from verify.systems.expressions import Expression, Name, Number, Product
from verify.systems.system import Flow, Interval, Piece, System, Variable

STILL = Number(Fraction(0))


class FlowCases:
    """The cases of a flow and the states in each. RejectedError where modes may be left, or cases leave gaps."""

    def __init__(self, system: System, columns: Mapping[str, int]) -> None:
        assert system.flow is not None
        modes = {one.name: one for one in system.variables if one.modes}
        for one in modes.values():
            if one.name not in system.flow.kept:  # what is kept starts as what it keeps
                ensure_starts(one, system.start)
            for each in system.flow.each:
                if each.rates[one.name] != STILL or one.name in each.error:
                    raise RejectedError(f"the mode {one.name} moves between samples")
                if not _is_set(each.jumps.get(one.name, Name(one.name)), one, modes, system.flow):
                    raise RejectedError(f"{one.name} may become what is none of its modes")
        of = replace(system, pieces=tuple(case.piece for case in system.flow.cases))
        self._cuts = [RegionCut(tests_of(piece), columns) for piece in of.pieces]
        self._stated: RegionCut | None = None
        if self._cuts:
            ensure_complete(of, modes)
            self._stated = RegionCut(tests_of(Piece(hull_of(of), {})), columns)

    def beyond(self, boxes: BoxList) -> Bool:
        """Returns True for each box that may hold states that no case holds; each box has its own number for a part."""
        found = np.zeros(boxes.size, dtype=np.bool_)
        if self._stated is not None:
            found[self._stated.outside(boxes).part] = True
        return found

    def within(self, boxes: BoxList) -> list[BoxList]:
        """For each case the boxes around the states that it may hold; all of them where there are no cases."""
        return [cut.within(boxes) for cut in self._cuts] if self._cuts else [boxes]

    def surely(self, boxes: BoxList) -> list[int]:
        """The cases that hold every state of all boxes."""
        return [k for k, cut in enumerate(self._cuts) if not cut.outside(boxes).size] if self._cuts else [0]


def _is_set(value: Expression, mode: Variable, modes: Mapping[str, Variable], flow: Flow) -> bool:
    """Returns True if a jump sets a mode to one of its values."""
    match value:
        case Number(number):
            return is_mode_value(number, mode)
        case Name(name) if name in modes:
            return len(modes[name].modes) <= len(mode.modes)
        case Name(name):
            inputs = [values[name] for values in flow.held.values() if name in values]
            return bool(inputs) and all(is_mode_value(number, mode) for number in inputs)
        case _:
            return False


PACE = "pace of the period"  # an input; no text can write it


def pace_of(flow: Flow) -> Interval:
    """Between which numbers the pace lies."""
    low, high = flow.jitter
    return 1 + low / flow.period, 1 + high / flow.period


def pace_flow(flow: Flow) -> Flow:
    """The flow with all periods of one length, at a pace; itself where there is no jitter."""
    if not any(flow.jitter):
        return flow
    products = {name: [pace * end for pace in pace_of(flow) for end in error] for name, error in flow.error.items()}
    errors = {name: (min(ends), max(ends)) for name, ends in products.items()}
    return replace(flow, rates={name: Product(Name(PACE), rate) for name, rate in flow.rates.items()}, error=errors)


class LateTrees:
    """The tree of one agent, once for each way in which its observations may be late."""

    def __init__(self, system: System, policy: AgentPolicy, columns: Mapping[str, int]) -> None:
        assert system.flow is not None
        seen = [{name: columns[each.get(name, name)] for name in columns} for each in system.flow.seen]
        self.ways = [TreeCuts(system, policy, each) for each in seen]

    def split_at_tests(self, boxes: BoxList) -> BoxList:
        """The boxes by what the agent may do, whichever way it is."""
        if len(self.ways) == 1:
            return self.ways[0].split_at_tests(boxes)
        parts = together([tree.split_at_tests(boxes) for tree in self.ways])
        return join_by_cell(parts, parts.joint[:, None])
