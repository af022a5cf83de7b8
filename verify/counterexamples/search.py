"""Counterexamples that a person can read: found inside their cells, shrunk to few digits, explained, replayed.

Does: turns a solver's model into a world state that the referee confirms, and tells both trees' paths.
Assumes: the question was satisfiable; stronger questions (with slack) may be asked.
Does not: call a state that is no float64 state a counterexample, but in real arithmetic.

In real arithmetic float64 states in which the claim fails in the deployed arithmetic too come first, then other float64
states, then rational ones.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import chain, combinations

import numpy as np

from codegen.ir import WorldSpec
from codegen.rows import Shown
from verify.claims.formula import agents
from verify.kinds import MACHINE, REAL
from verify.question import DecisionQuestion
from verify.solver.encode import in_both, query, there
from verify.solver.solve import Answer, ask, pin_model
from verify.states.noise import mistaken
from verify.states.real import Value, value_of
from verify.states.shares import SAMPLE_SEED, SAMPLES, draw_states
from verify.states.state import (
    Deployed,
    Replay,
    State,
    Step,
    confirm_actions,
    error_name,
    exact_point,
    find_engaged,
    inside,
    leaf_at,
    leaves_at,
    measurements,
    nearest,
    observe_state,
    path,
    shortfall,
    state_at,
    violates,
)

SLACKS = tuple(Fraction(1, 2**power) for power in (3, 4, 5, 7, 10, 20, 40))
SPACED_SLACKS = 3  # so many of the slacks are first tried with all entities SPACE apart, which reads better
MAX_SPACED = 100  # pairs of entities; to keep more of them apart takes a solver minutes
TRIED = 2  # so many are asked before the weakest of these; if it fails, the others would
SPACE = Fraction(1, 5)
MAX_REFEREED = 50  # sampled violations that the referee looks at, at most
MAX_PLACES = 12  # decimal places that shrinking tries before it keeps all digits
ROOM = 0.1  # shrinking keeps entities at least so far apart, and claims failing by so much, or as much as they were


@dataclass(frozen=True)
class AgentView:
    """One agent of the team in a counterexample: what it does, and why.

    For example:

        maviper.verify(team).counterexample.agents[0].action
    """

    agent: str
    action: str
    leaf: int
    path: tuple[Step, ...]
    engaged_with: tuple[str, ...]  #: landmarks
    errors: tuple[tuple[str, Value], ...] = ()  #: feature -> by how much it is off


@dataclass(frozen=True, repr=False)
class Counterexample(Shown):
    """A world state in which the claim fails, confirmed by the referee.

    For example:

        maviper.verify(team).counterexample.state.position["agent_0.x"]
    """

    state: State
    agents: tuple[AgentView, ...]
    replayed: tuple[str, ...]  #: names of what reproduced the same actions
    says: str  #: what judged it and who replayed it, in words
    deployed: Deployed | None = None  #: of real arithmetic; None where the state is no float64 state


class Stronger:
    """The answers to stronger questions about a goal, each asked once; all together take a query's resource units."""

    def __init__(self, question: DecisionQuestion, goal: str | None) -> None:
        self._goal, self._left, self._known = goal, question.budgets.solver_units, dict[int, Answer]()
        world, region = question.profile.world, question.region
        entities = [entity.name for entity in world.agents + world.landmarks]
        pairs = tuple((a, b, SPACE) for a, b in combinations(entities, 2))
        spaced = question.within(replace(region, apart=region.apart + pairs))
        first = SLACKS[:SPACED_SLACKS] if len(pairs) <= MAX_SPACED else ()
        self._asking = [*((spaced, slack) for slack in first), *((question, slack) for slack in SLACKS)]

    def answers(self) -> Iterator[tuple[Answer, int]]:
        """The answers, the most comfortable first, with the resource units spent since the one before."""
        weakest = len(self._asking) - len(SLACKS) + SPACED_SLACKS - 1  # nowhere: then none before it can be met either
        for place in range(len(self._asking)):
            before = self._left
            nowhere = TRIED <= place <= weakest and self._ask(weakest).holds is False
            if nowhere or self._left <= 0:
                continue
            yield self._ask(place), before - self._left

    def _ask(self, place: int) -> Answer:
        if place not in self._known:
            stronger, slack = self._asking[place]
            answer = self._known[place] = ask(query(stronger, self._goal, slack), self._left)
            self._left -= answer.resources
        return self._known[place]


def confirm_point(
    question: DecisionQuestion, goal: str | None, answer: Answer | None, stronger: Stronger | None = None
) -> tuple[State | None, int]:
    """A shrunk point that violates the claim; None when only a real-valued model exists, of the deployed arithmetic.

    Tries answers to stronger questions, and, where there is an answer to this one, its model and sampled states.
    Returns the point and the resource units spent on stronger questions.
    """
    real = question.semantics == REAL
    wanted = [question.by(semantics) for semantics in ((REAL, MACHINE) if real else (MACHINE,))]
    spent, others = 0, list[State]()
    for state, resources in _candidates(question, goal, answer, stronger or Stronger(question, goal)):
        spent += resources
        if state is not None and _stands(wanted, state):
            return shrink(wanted, state), spent
        others += [] if state is None else [state]
    if not real or answer is None:
        return None, spent
    # the exact model itself is among these, and float64 states go before it
    ordered = sorted(others, key=lambda state: not state.floats)
    state = next(state for state in ordered if _stands([question], state))
    return shrink([question], state), spent


def _candidates(
    question: DecisionQuestion, goal: str | None, answer: Answer | None, stronger: Stronger
) -> Iterator[tuple[State | None, int]]:
    """Points that may violate the claim, with the resource units that each took."""
    for inner, spent in stronger.answers():
        yield _nearest(question, inner, goal), spent
    if answer is None:
        return
    yield _nearest(question, answer, goal), 0
    if question.semantics == REAL and answer.model is not None:
        # where the claim fails in the deployed arithmetic too, if it does anywhere
        units = question.budgets.solver_units
        exact = ask(in_both(question, goal), units)
        if exact.model is None:
            yield None, exact.resources
        else:
            for one in chain([exact], (ask(in_both(question, goal, slack), units) for slack in SLACKS)):
                yield _nearest(question, one, goal), one.resources
            pinned, spent = pin_model(in_both(question, goal), question.region, exact.model, units)
            yield exact_point(pinned, question.region, goal), spent
        yield _simplify_model(question, goal, answer.model)
    for state in violating_samples(question.for_one_goal(goal)):
        yield state, 0


def _simplify_model(question: DecisionQuestion, goal: str | None, model: Mapping[str, Fraction]) -> tuple[State, int]:
    """An exact model of real arithmetic as a point with as few digits as solver queries find, and what they took.

    AssertionError when the referee does not confirm it: then an engine is wrong.
    """
    profile, claim, region = question.profile, question.claim, question.region
    state = exact_point(model, region, goal)
    if claim.eps and not violates(question, state):
        state = mistaken(question, state) or state
    exact = {name: Fraction(value) for name, value in (*state.position.items(), *state.errors.items())}
    acting = agents(question.formula)
    leaves = {agent: leaf for agent, leaf in leaves_at(profile, claim.team, state, REAL).items() if agent in acting}
    units = question.budgets.solver_units
    pinned, spent = pin_model(there(question, goal, leaves), region, exact, units)
    for each in (state, exact_point(pinned, region, goal)):
        if not _stands([question], each):
            raise AssertionError(f"{claim.name}: the referee does not confirm {each}")
    return exact_point(pinned, region, goal), spent


def violating_samples(question: DecisionQuestion, count: int = SAMPLES) -> Iterator[State]:
    """The sampled world states of the violating fraction, of the same draw, that the referee confirms."""
    region, world = question.region, question.profile.world
    coordinates, goals, fails = draw_states(question, SAMPLE_SEED, count)
    for row in np.flatnonzero(fails)[:MAX_REFEREED]:
        state = state_at(region, world, coordinates[row], int(goals[row]))
        if question.claim.eps:
            state = mistaken(question, state) or state
        if _stands([question], state):
            yield state


def near(question: DecisionQuestion, goal: str | None, model: Mapping[str, Fraction]) -> State | None:
    """A shrunk float64 point beside an exact one that violates the claim in the deployed arithmetic, with errors where
    the claim allows them; None when the nearest one does not.
    """
    deployed = question.by(MACHINE)
    state = nearest(dict(model), question.region, goal, Fraction(0))
    if question.claim.eps:
        state = mistaken(deployed, state) or state
    return shrink([deployed], state) if _stands([deployed], state) else None


def _nearest(question: DecisionQuestion, answer: Answer, goal: str | None) -> State | None:
    return None if answer.model is None else nearest(answer.model, question.region, goal, question.claim.eps)


def _stands(questions: Sequence[DecisionQuestion], state: State) -> bool:
    """Returns True if the claim fails at a point of the region, by each of one question's arithmetics."""
    asked = questions[0]
    if any(abs(Fraction(error)) > asked.claim.eps for error in state.errors.values()):
        return False
    if not state.floats and any(question.semantics == MACHINE for question in questions):
        return False
    return inside(asked.region, state) and all(violates(question, state) for question in questions)


def shrink(
    questions: Sequence[DecisionQuestion], state: State, keeps: Callable[[State], bool] = lambda state: True
) -> State:
    """The same violation with as few decimals as possible, and hardly less clear. `keeps`: what else must stay;
    `questions`: one question in each arithmetic in which the claim fails, the one asked about first.
    """
    asked = questions[0]
    least = min(ROOM, shortfall(asked, state))

    def stands(candidate: State) -> bool:
        fails = _stands(questions, candidate) and keeps(candidate)
        return fails and shortfall(asked, candidate) >= least

    return simplest(asked.profile.world, state, stands)


def simplest(world: WorldSpec, state: State, stands: Callable[[State], bool]) -> State:
    """The point with as few decimals as still stand, first for all positions together, then one by one."""
    entities = [entity.name for entity in world.agents + world.landmarks]
    room = {(a, b): min(ROOM, _apart(state, a, b)) for a, b in combinations(entities, 2)}

    def holds(position: Mapping[str, Value], errors: Mapping[str, Value]) -> bool:
        candidate = State(position, state.goal, errors)
        if any(_apart(candidate, a, b) < least for (a, b), least in room.items()):
            return False
        return stands(candidate)

    position, errors = dict(state.position), dict(state.errors)
    for places in range(MAX_PLACES):
        rounded: dict[str, Value] = {name: round(value, places) + 0.0 for name, value in position.items()}
        if holds(rounded, errors):
            position = rounded
            break
    _round_values(position, lambda: holds(position, errors))
    _round_values(errors, lambda: holds(position, errors))
    return State(position, state.goal, {name: error for name, error in errors.items() if error})


def _round_values(values: dict[str, Value], holds: Callable[[], bool]) -> None:
    """Rounds each value in place to the fewest decimals with which what `holds` asks stays true."""
    for name, value in values.items():
        for places in range(MAX_PLACES):
            simpler = round(value, places) + 0.0
            if simpler == value:
                break
            values[name] = simpler
            if holds():
                break
            values[name] = value


def _apart(state: State, a: str, b: str) -> float:
    return float(max(abs(state.position[f"{a}.{axis}"] - state.position[f"{b}.{axis}"]) for axis in "xy"))


def explain(question: DecisionQuestion, state: State, replays: Mapping[str, Replay]) -> Counterexample:
    """The counterexample with its paths, after every replay acted like the reference.

    DisagreementError when one of them acts differently: then there is a bug, and no verdict.
    """
    profile, claim, semantics = question.profile, question.claim, question.semantics
    did = confirm_actions(profile, question.formula, claim.team, state, replays, semantics)
    engaged = find_engaged(profile, claim, state, did.actions)
    views: list[AgentView] = []
    for policy in profile.team(claim.team):
        leaf = leaf_at(profile, policy, state, semantics)
        seen: Sequence[Value] = (
            list(map(value_of, measurements(profile, policy, state)))
            if semantics == REAL
            else observe_state(profile, policy, state)[0].tolist()
        )
        errors = [(one.name, state.errors.get(error_name(policy.agent, one.name), 0.0)) for one in policy.features]
        named = policy.actions[did.actions[policy.agent]].name
        wrong = tuple((name, error) for name, error in errors if error)
        views.append(AgentView(policy.agent, named, leaf, path(policy, seen), engaged[policy.agent], wrong))
    return Counterexample(state, tuple(views), did.by, did.says, did.deployed)
