"""Episodes by the rules of a world's file as they are written, in float64, sines and products included.

Does: plays from near the states of an episode of the enclosures, then from anywhere in the start region.
Assumes: a checked file and a profile of its agents.
Does not: judge episodes. Each operation of a rule rounds.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction

import numpy as np

from codegen.ir import PolicyProfile
from maviper.worlds.outside.systems import Floats, Moving, MovingRule, start
from verify.reach.replay import piece_of
from verify.systems.observing import chosen
from verify.systems.statement import Statement

EPISODES = 256
SEED = 0
State = dict[str, Fraction]  # each number is a float64


def episodes(
    statement: Statement, profile: PolicyProfile, steps: int, near: Sequence[Mapping[str, Fraction]]
) -> Iterator[list[State]]:
    """The states of episodes, each as far as something is stated. `near`: those that the first one keeps to as closely
    as the errors that the file states allow.
    """
    play, rng = _Play(statement, profile, steps), np.random.default_rng(SEED)
    yield play.states({name: float(value) for name, value in near[0].items()}, near, rng)
    for _ in range(EPISODES):
        yield play.states(start(statement, rng), (), rng)


class _Play:
    def __init__(self, statement: Statement, profile: PolicyProfile, steps: int) -> None:
        self._system, self._profile, self._steps = statement.system, profile, steps
        self._moving = Moving(statement)

    def states(self, begun: Floats, near: Sequence[Mapping[str, Fraction]], rng: np.random.Generator) -> list[State]:
        """The states of an episode."""
        state, found = begun, list[State]()
        try:
            for step in range(self._steps + 1):
                exact = {name: Fraction(number) for name, number in state.items()}
                found.append(exact)
                if piece_of(self._system, exact) is None:
                    break
                rules = self._moving.stated(state)
                after = rules[0].moved(state, self._joint(exact))
                state = _off(rules[0], after, near[step + 1] if step + 1 < len(near) else None, rng)
        except (OverflowError, ZeroDivisionError, ValueError):  # no float64 is near, or sin of such a number
            pass
        return found

    def _joint(self, state: State) -> dict[str, str]:
        actions = chosen(self._system, self._profile, state)
        return {policy.agent: policy.actions[actions[policy.agent]].name for policy in self._profile.agents}


def _off(rule: MovingRule, after: Floats, near: Mapping[str, Fraction] | None, rng: np.random.Generator) -> Floats:
    """The next state with errors that the file states: as close as they come to a state, else drawn."""
    found = dict(after)
    for name, (low, high) in rule.error.items():
        error = rng.uniform(low, high) if near is None else min(max(float(near[name]) - after[name], low), high)
        found[name] += error
    return found
