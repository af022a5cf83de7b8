"""The judge: whether a claim about decisions fails somewhere in a region, by looking.

Does: a refutation of a claim where one is found, confirmed in exact arithmetic; whether the region was looked through
  entirely; whether something could go wrong in it; whether a given state is a violation.
Assumes: a question as `places.Case`.
Does not: import anything of ours, or prove, but where `Look.whole`.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np

from tests.hunting.meaning import Scene, Truth, formula, holds, left_sides, related
from tests.hunting.places import Case, cells, described, enumerable, inner, sampled, scaled
from tests.hunting.reading import MACHINE, REAL, Array, acting, fractions, leaves, measured

MAX_CONFIRMED = 20  # states that are looked at exactly, where float64 numbers leave open whether they violate
MAX_CLEAR = 3
ROUNDINGS = 48  # of an exact state that are tried
ERROR_ROWS = 40
JOINT_ACTIONS = 10  # tried in each state, where it is asked whether something could go wrong


@dataclass(frozen=True)
class Violation:
    """A state in which the claim fails, exactly, with the errors of features that lead to it, by "agent:feature"."""

    state: Mapping[str, Any]
    goal: str | None
    errors: Mapping[str, Any]


@dataclass(frozen=True)
class Look:
    """What was found in a region."""

    violation: Violation | None
    whole: bool  # every state of the region is like one that was looked at
    conflict: bool  # in some state other actions, each closing on a landmark, would violate the claim


def look(case: Case, seed: int) -> Look:
    """Looks for a violation, at most at a few thousand states."""
    rng = np.random.default_rng([seed, 1])
    whole, conflict, violation = True, False, None
    for goal in case.goals:
        listed = cells(case, goal) if enumerable(case) else None
        whole &= listed is not None
        states = sampled(case, goal, rng) if listed is None else listed
        if listed is None and case.semantics == REAL:
            states = states[rng.permutation(len(states))[:200]]
        if not len(states):
            continue
        conflict = conflict or _conflicting(case, states, goal, rng)
        found = violating(case, states, goal, rng)
        violation = violation or found
    return Look(violation, whole, conflict)


def violates(case: Case, state: Mapping[str, Any], goal: str | None, errors: Mapping[str, Any] | None = None) -> bool:
    """Whether a state lies in the region and violates the claim, exactly; `errors` included, which are within eps."""
    if any(abs(Fraction(error)) > case.eps for error in (errors or {}).values()):
        return False
    values = [state[name] for name in case.names]
    if case.semantics == MACHINE and not all(isinstance(value, float) for value in values):
        return False
    columns = np.array([values], dtype=float if case.semantics == MACHINE else object)
    made = {name: fractions([error]) for name, error in (errors or {}).items()}
    return bool(_exactly(case, columns, goal, made)[0])


def violates_beside(case: Case, state: Mapping[str, Any], goal: str | None, seed: int) -> bool:
    """Whether a float64 state beside an exact one violates the claim, of those with each coordinate rounded either way
    that were tried.
    """
    rng = np.random.default_rng([seed, 3])
    pairs = [sorted(inner(Fraction(state[name]), Fraction(state[name]))) for name in case.names]
    sides = rng.integers(0, 2, (ROUNDINGS, len(pairs)))
    states = np.take_along_axis(np.array(pairs).T, sides, axis=0)
    return bool(_exactly(case, states[: ROUNDINGS // 8], goal).any() or _exactly(case, states, goal).any())


def within(case: Case, state: Mapping[str, Any], goal: str | None) -> bool:
    """Whether a state lies in the region, exactly."""
    values = np.array([[state[name] for name in case.names]], dtype=object)
    return goal in case.goals and bool(_within(case, fractions(values), goal)[0])


def inhabited(case: Case, seed: int) -> bool:
    """Whether some state was found that lies in the region and meets the assumption, exactly."""
    rng = np.random.default_rng([seed, 5])
    for goal in case.goals:
        states = sampled(case, goal, rng)
        states = states[_within(case, states, goal)] if len(states) else states
        if len(states):
            scene, assume = _scene(case, states, goal, {}), case.claim["assume"]
            if assume is None or formula(assume, scene, case.claim).surely.any():
                return True
    return False


def idle(case: Case, seed: int) -> bool:
    """Whether some left side of an implication of the claim was met in no state that was looked at, with the team's
    actions and where the assumption holds.
    """
    rng, assume = np.random.default_rng([seed, 7]), case.claim["assume"]
    conditions = left_sides(case.claim["formula"]) if case.claim["name"] == "formula" else []
    for condition in conditions:
        met = False
        for goal in case.goals:
            states = sampled(case, goal, rng)
            states = states[_within(case, states, goal)] if len(states) else states
            if not len(states) or met:
                continue
            seen = states if case.semantics == MACHINE else fractions(states)
            scene = _scene(case, states, goal, acting(case.team, case.at(seen, goal), case.semantics, None))
            both = formula(("and", condition, assume) if assume else condition, scene, case.claim)
            met = bool(both.surely.any())
        if not met:
            return True
    return False


def reached(case: Case, seed: int) -> set[tuple[str, int]]:
    """The leaves, (agent, leaf), to which some state of the region was found to lead."""
    rng, found = np.random.default_rng([seed, 6]), set()
    for goal in case.goals:
        states = sampled(case, goal, rng)
        states = states[_within(case, states, goal)] if len(states) else states
        at = case.at(states if case.semantics == MACHINE else fractions(states), goal) if len(states) else {}
        for agent in case.team if at else ():
            found |= {(agent.name, int(leaf)) for leaf in leaves(agent, at, case.semantics)}
    return found


def leaves_at(case: Case, state: Mapping[str, Any], goal: str | None, errors: Mapping[str, Any]) -> dict[str, int]:
    """Agent of the team -> its leaf in one state."""
    kind = float if case.semantics == MACHINE else object
    values = np.array([[state[name] for name in case.names]], dtype=kind)
    at = case.at(values if kind is float else fractions(values), goal)
    made = {name: fractions([error]) for name, error in errors.items()} or None
    return {agent.name: int(leaves(agent, at, case.semantics, made)[0]) for agent in case.team}


def _exactly(case: Case, states: Array, goal: str | None, errors: Mapping[str, Array] | None = None) -> Array:
    """Which states lie in the region and violate the claim, in exact arithmetic."""
    seen = states if case.semantics == MACHINE else fractions(states)
    actions = acting(case.team, case.at(seen, goal), case.semantics, errors or None)
    bad = ~holds(case.claim, _scene(case, states, goal, actions)).surely
    return _within(case, states, goal) & bad


def _scene(case: Case, states: Array, goal: str | None, actions: Mapping[str, Array]) -> Scene:
    """States exactly."""
    exact, scale = scaled(states, case.denominator)
    return Scene(case.profile, case.at(exact, goal), goal, actions, scale)


def _within(case: Case, states: Array, goal: str | None) -> Array:
    """Which states lie in the region, exactly."""
    return case.boxed(states) & related(case.region, _scene(case, states, goal, {})).surely


def violating(case: Case, states: Array, goal: str | None, rng: np.random.Generator) -> Violation | None:
    if case.eps:
        states = states[rng.permutation(len(states))[:ERROR_ROWS]]
        errors = _errors(case, states, goal, rng)
        bad = np.flatnonzero(_exactly(case, states, goal, errors))
        return _found(case, states, goal, errors, int(bad[0])) if len(bad) else None
    if states.dtype == object:
        bad = np.flatnonzero(_exactly(case, states, goal))
        return _found(case, states, goal, {}, int(bad[0])) if len(bad) else None
    # which states lie in the region, and where the claim holds, by float64 numbers
    at = case.at(states, goal)
    scene = Scene(case.profile, at, goal, acting(case.team, at, case.semantics))
    boxed = case.boxed(states)
    within, kept = Truth(boxed, boxed) & related(case.region, scene), holds(case.claim, scene)
    clear = np.flatnonzero(within.surely & ~kept.possibly)[:MAX_CLEAR]
    open_rows = rng.permutation(np.flatnonzero(within.possibly & ~kept.surely & (within.surely <= kept.possibly)))
    if case.semantics == REAL:  # float64 numbers only hint at what exact ones decide
        open_rows = np.concatenate([open_rows[:MAX_CONFIRMED], rng.permutation(len(states))[:MAX_CONFIRMED]])
    for rows in (clear, open_rows[: 2 * MAX_CONFIRMED]):
        bad = np.flatnonzero(_exactly(case, states[rows], goal)) if len(rows) else []
        if len(bad):
            return _found(case, states[rows], goal, {}, int(bad[0]))
    return None


def _found(case: Case, states: Array, goal: str | None, errors: Mapping[str, Array], row: int) -> Violation:
    made = {name: error[row] for name, error in errors.items() if error[row]}
    return Violation(described(states[row].tolist(), case.names), goal, made)


def _errors(case: Case, states: Array, goal: str | None, rng: np.random.Generator) -> dict[str, Array]:
    """Errors of features that bring tests to where they turn, within eps, "agent:feature" -> [batch]."""
    at, most, found = case.at(states, goal), float(case.eps), {}
    most = most if Fraction(most) <= case.eps else float(np.nextafter(most, 0))
    for agent in case.team:
        for number in agent.tested:
            feature = agent.features[number]
            if not feature.measurable:
                continue
            limits = agent.threshold[agent.feature == number].astype(float)
            limit = rng.choice([0.0] if feature.function else limits, len(states))
            seen = (
                measured(feature, at, MACHINE, agent.threshold.dtype) if not feature.function else np.zeros(len(states))
            )
            wanted = np.clip(np.nextafter(limit - seen, rng.choice([-9.0, 9.0], len(states))), -most, most)
            kinds = rng.integers(0, 4, len(states))
            made = np.choose(kinds, [wanted, np.full(len(states), most), np.full(len(states), -most), 0.0 * wanted])
            found[f"{agent.name}:{feature.name}"] = fractions(made)
    return found


def _conflicting(case: Case, states: Array, goal: str | None, rng: np.random.Generator) -> bool:
    """Whether other actions, each closing on some landmark, would violate the claim in one of the states."""
    states = states[rng.permutation(len(states))[:80]].astype(float)
    at, team = case.at(states, goal), case.team
    for _ in range(JOINT_ACTIONS):
        others = {agent.name: rng.integers(0, len(agent.actions), len(states)) for agent in team}
        scene = Scene(case.profile, at, goal, others)
        bad = related(case.region, scene).possibly & ~holds(case.claim, scene).possibly
        for agent in team:
            closing = [scene.closes(agent.name, mark, case.claim.get("margin", 0)) for mark in case.profile.landmarks]
            bad &= np.logical_or.reduce([one.possibly for one in closing]) if closing else True
        if bad.any():
            return True
    return False
