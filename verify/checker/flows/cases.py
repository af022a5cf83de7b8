"""Modes and cases of a flow, by the checker's own reading: modes stay modes, and some case holds every state.

Does: shows both from the system alone; cuts sets by the cases that hold them at a sample.
Assumes: systems/cases.py shows that boxes with conditions leave out nothing within the bounds that they share.
Does not: move sets.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from fractions import Fraction

import numpy as np

from codegen.ir import Bool
from verify.checker.covers.boxes import BoxList
from verify.checker.covers.cuts import RegionCut, linear
from verify.checker.reading import RejectedError
from verify.checker.systems.cases import ensure_complete, ensure_starts, hull_of, is_mode_value, tests_of
from verify.systems.expressions import Expression, Name, Number
from verify.systems.system import Flow, Piece, System, Variable

STILL = Number(Fraction(0))


class FlowCases:
    """The cases of a flow and the states in each. RejectedError where modes may be left, or cases leave gaps."""

    def __init__(self, system: System, columns: Mapping[str, int]) -> None:
        assert system.flow is not None
        modes = {one.name: one for one in system.variables if one.modes}
        for one in modes.values():
            if one.name not in system.flow.kept:  # what is kept starts as what it keeps
                ensure_starts(one, system.start)
            _ensure_stays(one, modes, system.flow)
        of = replace(system, pieces=tuple(case.piece for case in system.flow.cases))
        self._cuts = [RegionCut(list(map(linear, tests_of(piece))), columns) for piece in of.pieces]
        self._stated: RegionCut | None = None
        if self._cuts:
            ensure_complete(of, modes)
            self._stated = RegionCut(list(map(linear, tests_of(Piece(hull_of(of), {})))), columns)

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


def _ensure_stays(mode: Variable, modes: Mapping[str, Variable], flow: Flow) -> None:
    for each in flow.each:
        if each.rates[mode.name] != STILL or mode.name in each.error:
            raise RejectedError(f"the mode {mode.name} moves between samples")
        if not _is_set(each.jumps.get(mode.name, Name(mode.name)), mode, modes, flow):
            raise RejectedError(f"{mode.name} may become what is none of its modes")


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
