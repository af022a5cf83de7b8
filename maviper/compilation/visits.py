"""States that episodes of a stated system visit, step by step, by the rules as they are written, in float64.

Does: plays a few episodes from drawn starts, always the same ones.
Assumes: a checked file and a profile of its agents.
Does not: say anything of a proof: by these states a monitor is arranged so that it is fast where it will be asked.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

import numpy as np

from codegen.errors import InputError
from codegen.ir import Float64, PolicyProfile
from maviper.worlds.stated.systems import Floats, Moving, draw_rule, start
from verify.systems.observing import choose_actions
from verify.systems.statement import Statement

EPISODES = 64
SEED = 0


def list_visits(statement: Statement, profile: PolicyProfile, steps: int, names: Sequence[str]) -> list[Float64]:
    """The states [n, names] at each step, from 0 to `steps`, of episodes that last so long."""
    moving, rng = Moving(statement), np.random.default_rng(SEED)
    visits: list[list[list[float]]] = [[] for _ in range(steps + 1)]
    for _ in range(EPISODES):
        try:
            state: Floats = start(statement, rng)
            for step, visited in enumerate(visits):
                visited.append([state[name] for name in names])
                if step < steps:
                    state = _move(statement, profile, moving, state, rng)
        except (InputError, LookupError, ArithmeticError, ValueError):  # thin starts; states that no rule moves
            continue
    return [np.array(visited, dtype=np.float64).reshape(-1, len(names)) for visited in visits]


def _move(
    statement: Statement, profile: PolicyProfile, moving: Moving, state: Floats, rng: np.random.Generator
) -> Floats:
    """The next state, with errors that the file states."""
    actions = choose_actions(statement.system, profile, {name: Fraction(number) for name, number in state.items()})
    joint = {policy.agent: policy.actions[actions[policy.agent]].name for policy in profile.agents}
    rule = draw_rule(moving.find_rules(state), rng)
    after = rule.move_state(state, joint)
    for name, (low, high) in rule.error.items():
        after[name] += rng.uniform(low, high)
    return after
