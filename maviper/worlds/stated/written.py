"""Episodes by the rules of a world file as they are written, in float64, sines and products included.

Does: plays from near the states of an episode of the enclosures, then from anywhere in the start region.
Assumes: a checked file and a profile of its agents.
Does not: judge episodes. Each operation of a rule rounds.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction

import numpy as np

from codegen.ir import PolicyProfile
from maviper.worlds.stated.systems import AnyRule, Floats, Moving, box, draw_rule, start
from verify.reach.replay import piece_of
from verify.systems.observing import choose_actions
from verify.systems.statement import Statement
from verify.systems.system import ensure_in_steps

EPISODES = 256
SEED = 0
State = Mapping[str, Fraction]


def episodes(statement: Statement, profile: PolicyProfile, steps: int, near: Sequence[State]) -> Iterator[list[State]]:
    """The states of episodes, each as far as something is stated. A start is exact, what follows is float64.

    `near`: states that the first episode keeps to as closely as the errors that the file states allow.
    """
    ensure_in_steps(statement.system, "the search for episodes by rules")
    play, rng = _Play(statement, profile, steps), np.random.default_rng(SEED)
    yield play.states(near[0], near, rng)
    bounds = box(statement)
    for _ in range(EPISODES):
        begun = {name: Fraction(number) for name, number in start(statement, rng).items()}
        kept = {name: min(max(number, bounds[name][0]), bounds[name][1]) for name, number in begun.items()}
        yield play.states(kept, (), rng)


class _Play:
    def __init__(self, statement: Statement, profile: PolicyProfile, steps: int) -> None:
        self._system, self._profile, self._steps = statement.system, profile, steps
        self._moving = Moving(statement)

    def states(self, begun: State, near: Sequence[State], rng: np.random.Generator) -> list[State]:
        """The states of an episode."""
        exact, played = begun, list[State]()
        try:
            for step in range(self._steps + 1):
                played.append(exact)
                state = {name: float(number) for name, number in exact.items()}
                rules = self._moving.find_rules(state)
                if piece_of(self._system, exact) is None or not rules:
                    break
                ahead = near[step + 1] if step + 1 < len(near) else None
                joint = self._joint(exact)
                rule = draw_rule(rules, rng) if ahead is None else _nearest(rules, state, joint, ahead)
                state = _off(rule, rule.move_state(state, joint), ahead, rng)
                exact = {name: Fraction(number) for name, number in state.items()}
        except (OverflowError, ZeroDivisionError, ValueError):  # no float64 is near, or sin of such a number
            pass
        return played

    def _joint(self, state: State) -> dict[str, str]:
        actions = choose_actions(self._system, self._profile, state)
        return {policy.agent: policy.actions[actions[policy.agent]].name for policy in self._profile.agents}


def _nearest(rules: Sequence[AnyRule], state: Floats, joint: Mapping[str, str], ahead: State) -> AnyRule:
    """The rule that comes nearest to a state: of equal ones the first."""

    def off(rule: AnyRule) -> float:
        return max(abs(float(ahead[name]) - value) for name, value in rule.move_state(state, joint).items())

    return rules[0] if len(rules) == 1 else min(rules, key=off)


def _off(rule: AnyRule, after: Floats, near: Mapping[str, Fraction] | None, rng: np.random.Generator) -> Floats:
    """The next state with errors that the file states: as close as they come to a state, else drawn."""
    shifted = dict(after)
    for name, (low, high) in rule.error.items():
        error = rng.uniform(low, high) if near is None else min(max(float(near[name]) - after[name], low), high)
        shifted[name] += error
    return shifted
