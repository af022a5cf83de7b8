"""A flow of a world file in play: one period at a time, integrated in float64.

Does: moves a state for one period with actions held, by the classical Runge-Kutta method; integrates by scipy.
Assumes: a checked file.
Does not: prove. Proofs enclose every state of a period (verify/checker/flows).
"""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction

import numpy as np

from codegen.ir import Float64
from verify.systems.observing import function
from verify.systems.system import Flow, FlowCase

PARTS = 8  # of a period in play
TOLERANCE = 1e-12  # of the referee, absolute and relative
Floats = dict[str, float]


class FlowRule:
    """The motion of one period, as one rule of a world in play. `error`: what the errors of derivatives add up to in a
    period, if they stay as they are.
    """

    def __init__(self, flow: Flow, case: FlowCase | None = None) -> None:
        self.case = () if case is None else (case.where, case.when)
        self._piece = None if case is None else case.piece
        self.period = float(flow.period)
        self.jitter = float(flow.jitter[0]), float(flow.jitter[1])
        self.error = {
            name: (self.period * float(low), self.period * float(high)) for name, (low, high) in flow.error.items()
        }
        self._jumps = {name: function(value) for name, value in flow.jumps.items()}
        self._rates = {name: function(rate) for name, rate in flow.rates.items()}
        self._held = {choice: {name: float(value) for name, value in of.items()} for choice, of in flow.held.items()}

    def holds(self, state: Mapping[str, float]) -> bool:
        """Returns True if the rule applies to a state that is this at a sample; without cases it always does."""
        return self._piece is None or self._piece.holds({name: Fraction(number) for name, number in state.items()})

    def hold_inputs(self, actions: Mapping[str, str]) -> Floats:
        """The inputs' values for a joint action by names."""
        return {name: value for choice in actions.items() for name, value in self._held[choice].items()}

    def derivative(self, state: Mapping[str, float], held: Mapping[str, float]) -> Floats:
        """The derivative of each variable."""
        known = {**state, **held}
        return {name: rate(known) for name, rate in self._rates.items()}

    def apply_jumps(self, state: Mapping[str, float], held: Mapping[str, float]) -> Floats:
        """The state at a sample after what jumps there."""
        known = {**state, **held}
        return {**state, **{name: value(known) for name, value in self._jumps.items()}}

    def move_state(self, state: Mapping[str, float], actions: Mapping[str, str], longer: float = 0.0) -> Floats:
        """The state after a period that is so many seconds longer than stated, without errors."""
        held, h = self.hold_inputs(actions), (self.period + longer) / PARTS
        now = self.apply_jumps(state, held)
        for _ in range(PARTS):
            first = self.derivative(now, held)
            second = self.derivative(_along(now, first, h / 2), held)
            third = self.derivative(_along(now, second, h / 2), held)
            last = self.derivative(_along(now, third, h), held)
            now = {x: now[x] + h / 6 * (first[x] + 2 * second[x] + 2 * third[x] + last[x]) for x in now}
        return now

    def integrate_states(self, state: Mapping[str, float], actions: Mapping[str, str], times: Float64) -> Float64:
        """The states at some times of a period, in order, [times, variables], by scipy's DOP853."""
        from scipy.integrate import solve_ivp  # half a second, which proofs and checks need not wait

        held, names = self.hold_inputs(actions), list(state)

        def rate(_: float, numbers: Float64) -> Float64:
            rates = self.derivative(dict(zip(names, numbers.tolist(), strict=True)), held)
            return np.array([rates[name] for name in names])

        begun, span = np.array(list(self.apply_jumps(state, held).values())), (0.0, float(times[-1]))
        solution = solve_ivp(rate, span, begun, "DOP853", t_eval=times, rtol=TOLERANCE, atol=TOLERANCE)
        if not solution.success:
            raise ArithmeticError(f"it grows beyond all bounds within {span[1]:g} s")
        return np.asarray(solution.y.T)


def flow_rules(flow: Flow) -> list[FlowRule]:
    """The rules of a flow in play: one for each of its cases."""
    if not flow.cases:
        return [FlowRule(flow)]
    return [FlowRule(own, case) for own, case in zip(flow.each, flow.cases, strict=True)]


def _along(state: Mapping[str, float], rate: Mapping[str, float], time: float) -> Floats:
    return {name: value + time * rate[name] for name, value in state.items()}
