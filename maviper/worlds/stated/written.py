"""Episodes by the rules of a world file as they are written, in float64, sines and products included.

Does: plays near the states of an episode of the enclosures, or along a course of the rules.
Assumes: a checked file and a profile of its agents.
Does not: judge episodes, or choose where they start. Each operation of a rule rounds.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction

from codegen.ir import PolicyProfile
from maviper.worlds.stated.systems import AnyRule, Floats, Moving
from verify.reach.replay import Course, piece_of
from verify.systems.observing import choose_actions
from verify.systems.statement import Statement
from verify.systems.system import ensure_in_steps

State = Mapping[str, Fraction]
# the step, the rules that hold, the state and the joint action -> the next state
Move = Callable[[int, Sequence[AnyRule], Floats, Mapping[str, str]], Floats]


class WrittenPlay:
    """Plays episodes of at most so many steps. InputError for a system in continuous time."""

    def __init__(self, statement: Statement, profile: PolicyProfile, steps: int) -> None:
        ensure_in_steps(statement.system, "the search for episodes by rules")
        self._system, self._profile, self._steps = statement.system, profile, steps
        self._moving = Moving(statement)

    def keep_near(self, near: Sequence[State]) -> list[State]:
        """The states of the episode that keeps to others as closely as the errors that the file states allow, as far as
        something is stated. The start is exact, what follows is float64.
        """

        def move(step: int, rules: Sequence[AnyRule], state: Floats, joint: Mapping[str, str]) -> Floats:
            ahead = near[step + 1] if step + 1 < len(near) else None
            rule = rules[0] if ahead is None else _nearest(rules, state, joint, ahead)
            after = rule.move_state(state, joint)
            if ahead is None:
                return after
            off = {name: float(ahead[name]) - after[name] for name in rule.error}
            return _with_errors(rule, after, off)

        return self._play(near[0], move)

    def follow(self, course: Course) -> list[State]:
        """The states of an episode whose rules and errors are given, as far as something is stated."""

        def move(step: int, rules: Sequence[AnyRule], state: Floats, joint: Mapping[str, str]) -> Floats:
            told = self._moving.rule(course.pieces[step]) if step < len(course.pieces) else rules[0]
            rule = told if told in rules else rules[0]  # on a border, rounding may choose otherwise
            off = {name: float(number) for given in course.errors[step : step + 1] for name, number in given.items()}
            return _with_errors(rule, rule.move_state(state, joint), off)

        return self._play(course.start, move)

    def _play(self, begun: State, move: Move) -> list[State]:
        exact, played = begun, list[State]()
        try:
            for step in range(self._steps + 1):
                played.append(exact)
                state = {name: float(number) for name, number in exact.items()}
                rules = self._moving.find_rules(state)
                if piece_of(self._system, exact) is None or not rules:
                    break
                state = move(step, rules, state, self._joint(exact))
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


def _with_errors(rule: AnyRule, after: Floats, errors: Mapping[str, float]) -> Floats:
    """The next state with errors, each cut to what the file states."""
    shifted = dict(after)
    for name, (low, high) in rule.error.items():
        shifted[name] += min(max(errors.get(name, 0.0), low), high)
    return shifted
