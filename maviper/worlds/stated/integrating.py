"""The referee of flows: scipy integrates the derivatives of a file, from states all over the ranges.

Does: compares the motion in play with scipy's over random periods.
Assumes: a checked file.
Does not: prove.
"""

from __future__ import annotations

import numpy as np

from codegen.wording import format_count
from maviper.worlds.findings import Finding, Mark
from maviper.worlds.stated.flowing import flow_rules
from maviper.worlds.stated.systems import start
from verify.systems.statement import Statement
from verify.systems.system import Variable

PERIODS, SEED = 200, 0
NEAR = 1e-3  # beside the size of a state, of which play may be off
ADVICE = "a shorter period, or slower motion: play integrates a period in 8 parts"
UNDEFINED = "narrow the ranges: over them a derivative must be defined"


def check_integration(statement: Statement) -> Finding:
    """Measures how far play is from scipy's integration, over periods from starts and from anywhere in the ranges."""
    flow, rng = statement.system.flow, np.random.default_rng(SEED)
    assert flow is not None
    rules, worst, least = flow_rules(flow), dict.fromkeys(flow.rates, 0.0), 0.0
    for number in range(PERIODS):
        anywhere = {each.name: _within(each, rng) for each in statement.system.variables}
        state = start(statement, rng) if number % 2 else anywhere
        rule = next((each for each in rules if each.holds(state)), rules[0])
        chosen = {agent.name: str(rng.choice(list(agent.actions))) for agent in statement.agents}
        try:
            longer = float(rng.uniform(*rule.jitter)) if any(rule.jitter) else 0.0
            after = rule.move_state(state, chosen, longer)
            ends = rule.integrate_states(state, chosen, np.array([rule.period + longer]))[-1].tolist()
            exact = dict(zip(state, ends, strict=True))
        except (ArithmeticError, ValueError) as error:
            where = ", ".join(f"{name} = {value:.6g}" for name, value in state.items())
            return Finding(Mark.WRONG, f"flow: a derivative is not defined from {where}: {error}", UNDEFINED)
        for name, value in exact.items():
            worst[name] = max(worst[name], abs(after[name] - value))
            least = max(least, abs(after[name] - value) / (1 + abs(value)))
    off = ", ".join(f"{name} {value:.2g}" for name, value in worst.items() if name not in flow.kept)
    said = f"integration: {format_count(PERIODS, 'period')} by scipy, of which play is off by at most {off}"
    return Finding(Mark.OK, said) if least <= NEAR else Finding(Mark.MISSING, said, ADVICE)


def _within(variable: Variable, rng: np.random.Generator) -> float:
    """A value of a variable from its range, of a mode a whole number."""
    low, high = float(variable.range[0]), float(variable.range[1])
    return float(rng.integers(int(low), int(high) + 1)) if variable.modes else float(rng.uniform(low, high))
