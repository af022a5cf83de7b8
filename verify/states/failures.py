"""World states in which a claim fails, many of them; and whether it does in each of many.

Does: the referee's judgement of many world states at once, in the deployed arithmetic; draws states of a region until
  enough violate the claim.
Assumes: a claim about single decisions; states at rest where the region bounds no velocities.
Does not: search for rare states (the engines do); what it finds is a sample of the region.

Float64 judges, with bounds of its own error; exact arithmetic is asked only about the states that are left open. So the
judgement is exact.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from itertools import islice, product

import numpy as np

from codegen.ir import Bool, Float64, Int32, PolicyProfile, act
from codegen.observe import observe
from verify.claims.formula import holds, negate, normal
from verify.claims.values import Batch
from verify.question import DecisionQuestion
from verify.semantics import MACHINE
from verify.states.noise import together, ways
from verify.states.real import Value
from verify.states.shares import SAMPLES, violating
from verify.states.state import State, choose_actions, inside, observe_state, sample, state_at

MAX_NUMBER, DRAWS = 1_000, 10  # states, and batches of SAMPLES that are drawn for them at most
FIRST_SEED = 1_007  # of the batches; none of them is the one that shares are measured with
JUDGED = 4  # states that are judged for each that is wanted, at most
MAX_WAYS = 256  # ways to err together that are tried in a world state


def failures(question: DecisionQuestion, most: int = MAX_NUMBER) -> list[State]:
    """At most `most` world states of the region, uniform among those where the claim fails, in the order of the draw.

    Where the claim allows errors, each state comes with errors that make it fail. Fewer where float64 takes many more
    states for failures than are (JUDGED): in regions that lie within a rounding of a boundary.
    """
    question, profile, region = question.by(MACHINE), question.profile, question.region
    failing: list[State] = []
    left = JUDGED * most
    for draw in range(DRAWS):
        coordinates, goals = sample(region, profile.world, SAMPLES, FIRST_SEED + draw)
        rows = np.flatnonzero(violating(question, coordinates))
        while rows.size and left and len(failing) < most:
            wanted, rows = np.split(rows, [min(left, most - len(failing))])
            left -= len(wanted)
            states = [state_at(region, profile.world, coordinates[row], int(goals[row])) for row in wanted]
            failing += _failing(question, [state for state in states if inside(region, state)])
        if not left or len(failing) == most:
            break
    return failing


def fails(question: DecisionQuestion, states: Sequence[State]) -> Bool:
    """Returns what `verify.states.state.violates` says of each world state in the deployed arithmetic, [n]."""
    profile = question.profile
    coordinates = _coordinates(profile, states)
    actions: dict[str, Int32] = {}
    for policy in profile.team(question.claim.team):
        seen = observe(policy.features, coordinates, profile.world, policy.numbers)
        for row, state in enumerate(states):
            if state.errors:
                seen[row] = observe_state(profile, policy, state)[0]
        actions[policy.agent] = act(policy, seen)
    return _judge_actions(question, coordinates, [state.goal for state in states], actions)


def _coordinates(profile: PolicyProfile, states: Sequence[State]) -> Float64:
    n_coordinates = len(profile.world.coordinates())
    return np.concatenate([np.zeros((0, n_coordinates)), *(state.coordinates(profile) for state in states)])


def _failing(question: DecisionQuestion, states: Sequence[State]) -> Iterator[State]:
    """Those of the world states in which the claim fails, with errors where it allows them."""
    profile = question.profile
    if not question.claim.eps:
        yield from (states[row] for row in np.flatnonzero(fails(question, states)).tolist())
        return
    coordinates, team = _coordinates(profile, states), profile.team(question.claim.team)
    tries = list(_mistakes(question, states, coordinates))
    rows = np.array([row for row, _, _ in tries], dtype=np.int64)
    joint = np.array([acts for _, acts, _ in tries], dtype=np.int32).reshape(-1, len(team))
    actions = {policy.agent: column for policy, column in zip(team, joint.T, strict=True)}
    wrong = _judge_actions(question, coordinates[rows], [states[row].goal for row, _, _ in tries], actions)
    known: set[int] = set()
    for row, _, errors in (tries[place] for place in np.flatnonzero(wrong).tolist()):
        if row not in known:
            known.add(row)
            yield replace(states[row], errors=errors)


def _mistakes(
    question: DecisionQuestion, states: Sequence[State], coordinates: Float64
) -> Iterator[tuple[int, tuple[int, ...], dict[str, Value]]]:
    """(row, actions of the team, errors that cause them), of each state the actions without errors first."""
    profile, eps = question.profile, question.claim.eps
    team, world = profile.team(question.claim.team), profile.world
    usual = [choose_actions(policy, coordinates, world) for policy in team]
    each = [ways(policy, coordinates, world, eps) for policy in team]
    for row, state in enumerate(states):
        options: list[dict[int, dict[str, float]]] = []
        for policy, acts, errors in zip(team, usual, each, strict=True):
            causes: dict[int, dict[str, float]] = {int(acts[row]): {}}
            for way in filter(None, errors[row]):
                action = int(act(policy, observe_state(profile, policy, replace(state, errors=way)))[0])
                causes.setdefault(action, way)
            options.append(causes)
        for joint in islice(product(*options), MAX_WAYS):
            yield row, joint, together(causes[action] for causes, action in zip(options, joint, strict=True))


def _judge_actions(
    question: DecisionQuestion,
    coordinates: Float64,
    goals: Sequence[str | None],
    actions: Mapping[str, Int32],
) -> Bool:
    """Where the claim fails with these actions (agent -> [n]), exactly, [n]."""
    names, of_goal = question.profile.world.coordinates(), np.array(goals, dtype=object)
    wrong = np.zeros(len(coordinates), dtype=bool)
    for goal in dict.fromkeys(goals):
        rows, asked = np.flatnonzero(of_goal == goal), question.formula_for(goal)
        columns = dict(zip(names, coordinates[rows].T, strict=True))
        taken = {agent: column[rows] for agent, column in actions.items()}
        doubtful = Batch(columns, len(rows), doubting=True)
        wrong[rows] = ~doubtful.holds(normal(asked), taken)
        unsure = doubtful.holds(normal(asked), taken) & doubtful.holds(negate(asked), taken)
        for row in rows[unsure]:
            at = {name: Fraction(value) for name, value in zip(names, coordinates[row].tolist(), strict=True)}
            wrong[row] = not holds(asked, at, {agent: int(column[row]) for agent, column in actions.items()})
    return wrong
