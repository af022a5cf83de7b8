"""Samples of a region: how often a claim could fail there, how often it does, and states in which it does.

Does: conflict share, contested share and violating fraction by uniform sampling, with 95 % intervals; the region's own
  share of the start region; says why there is no share of a range that nobody stated; the referee's judgement of many
  world states at once, in the deployed arithmetic; draws states of a region until enough violate the claim.
Assumes: a profile and a claim about it; for states, a claim about single decisions, at rest where the region bounds no
  velocities.
Does not: prove anything: the solver's verdict stands on its own; search for rare states (the engines do).
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import lru_cache
from itertools import chain, islice, product

import numpy as np

from codegen.errors import InputError
from codegen.intervals import Share, percent
from codegen.ir import GOAL, MAX_LENGTH, NO_FEATURE, AgentPolicy, Bool, Float64, Int32, PolicyProfile, act
from codegen.observe import observe
from verify.claims.decisions import DecisionClaim, closes, engages
from verify.claims.formula import (
    TRUE,
    And,
    Formula,
    Linear,
    Or,
    agents,
    disjunction,
    holds,
    negate,
    normal,
    substitute_actions,
)
from verify.claims.formula import coordinates as spoken_of
from verify.claims.region import Interval, Region
from verify.claims.region_files import everywhere
from verify.kinds import MACHINE
from verify.question import DecisionQuestion
from verify.states import noise
from verify.states.noise import together, ways
from verify.states.real import Value
from verify.states.state import State, batch, choose_actions, inside, observe_state, sample, state_at
from verify.states.values import Batch, preventable

SAMPLES = 100_000
SAMPLE_SEED = 7
MAX_JOINT_ACTIONS = 1_000
MAX_NAMED = 3  # coordinates without a range that are named
MAX_WAYS = 64  # to meet an assumption, that are drawn from
MAX_HELD = 1_000  # answers about one agent that are kept: a hundred megabytes of them


@dataclass(frozen=True)
class Shares:
    """The shares of a region that matter for a claim."""

    conflict: Share | None  # some joint action would violate the claim, of a claim about landmarks one in which every
    # agent closes on one; None: there are too many joint actions to try
    contested: Share | None  # two agents, both inside the landmarks' rectangle; None for other team sizes
    violating: Share | None  # the team as it is violates the claim, with some errors where the claim allows them
    changing: Share | None = None  # errors can change some agent's action; None for claims without errors
    unmeasured: str = ""  # why nothing is measured, and what to state; all shares are None then


def measure(question: DecisionQuestion, seed: int, count: int = SAMPLES) -> Shares:
    """The shares of the region, from at most `count` uniform world states at rest that meet the assumption."""
    claim, world = question.claim, question.profile.world
    if reason := explain_unstated(question):
        return Shares(None, None, None, unmeasured=reason)
    coordinates, _, fails = draw_states(question, seed, count)
    if claim.assume != TRUE:
        met = batch(coordinates, world).holds(claim.assume, {})
        coordinates, fails = coordinates[met], fails[met]
    n = len(coordinates)
    conflicting = conflicts(question, coordinates)
    contested = _is_contested(question, coordinates) if about_landmarks(question.profile, question.formula) else None
    changing = noise.changeable(question, coordinates) if claim.eps else None

    def share(found: Bool | None) -> Share | None:
        return None if found is None else Share(int(found.sum()), n)

    return Shares(share(conflicting), share(contested), share(fails), share(changing))


def explain_unstated(question: DecisionQuestion) -> str:
    """Why a share of the region would mean nothing, and what to state: a coordinate that the claim or the team's trees
    read has no range but that of every number. "" where all have one.
    """
    profile, region = question.profile, question.region
    read = {*spoken_of(question.formula), *spoken_of(question.claim.assume)}
    read |= {name for a, b, _ in region.differences for name in (a, b)}
    for policy in profile.team(question.claim.team):
        tested = set(map(int, policy.tree.feature)) - {NO_FEATURE}
        meanings = [policy.features[place].meaning for place in tested]
        read |= {name for meaning in meanings if meaning for _, name in meaning.terms}
    names = [name for name in find_unbounded(region) if name in read]
    if not names:
        return ""
    more = f" and {len(names) - MAX_NAMED} more" if len(names) > MAX_NAMED else ""
    has, them = ("has", "it") if len(names) == 1 else ("have", "them")
    return f"{', '.join(names[:MAX_NAMED])}{more} {has} no stated range; bound {them} in a region file (--region)"


def find_unbounded(region: Region) -> list[str]:
    """The coordinates of a region that have no range but that of every number."""
    return [name for name, (low, high) in region.box.items() if max(-low, high) >= MAX_LENGTH]


def of_start(profile: PolicyProfile, region: Region) -> dict[str, float | bool] | None:
    """The region's share of the start region, by volume, as plain data. None where there is no start region, or where
    some variable has no range to speak of.

    Exact for a box; else the share of what its box has in common with the start region, times the sampled share of that
    which keeps differences and distances.
    """
    try:
        start = everywhere(profile)
    except InputError:  # no damping bounds the velocities
        return None
    if find_unbounded(start):
        return None
    share = Fraction(1)
    if start.goals:
        share *= Fraction(len(set(region.goals) & set(start.goals)), len(start.goals))
    common = dict(region.box)
    for name, whole in start.box.items():
        mine = region.box.get(name, whole)
        low, high = common[name] = max(mine[0], whole[0]), min(mine[1], whole[1])
        if low > high:
            share = Fraction(0)
        elif whole[0] < whole[1]:  # of a single number all or nothing
            share *= (high - low) / (whole[1] - whole[0])
    if not share or not (region.differences or region.apart):
        return {"share": float(share), "low": float(share), "high": float(share), "exact": True}
    within, _ = sample(replace(region, box=common), profile.world, SAMPLES, SAMPLE_SEED)
    kept = Share(len(within), SAMPLES)
    sampled = zip(("share", "low", "high"), (kept.value, *kept.interval), strict=True)
    return {**{name: round(float(share) * part, 12) for name, part in sampled}, "exact": False}


def extent_words(share: Mapping[str, float | bool], whole: str) -> str:
    """The document of `of_start` in words."""
    return f"{'' if share['exact'] else 'about '}{percent(share['share'])} of {whole}"


@lru_cache(maxsize=2)  # the verdict, its shares and its counterexample look at the same draw
def draw_states(question: DecisionQuestion, seed: int, count: int) -> tuple[Float64, Int32, Bool]:
    """Uniform world states at rest: coordinates, places of their goals, and where the claim is violated, [count]."""
    region, world, assume = question.region, question.profile.world, question.claim.assume
    coordinates, goals = sample(region, world, count, seed)
    if assume != TRUE and not batch(coordinates, world).holds(assume, {}).any():
        boxes = _bound_assumption(assume, region)
        drawn = [sample(replace(region, box=box), world, count // len(boxes), seed) for box in boxes]
        if drawn:
            coordinates, goals = (np.concatenate(parts) for parts in zip(*drawn, strict=True))
    return coordinates, goals, violating(question, coordinates)


def _bound_assumption(assume: Formula, region: Region) -> list[Mapping[str, Interval]]:
    """Boxes of the region around the states that an assumption allows, one for each of its first ways: so that what a
    uniform state never meets is drawn, such as one mode of several.
    """
    boxes: list[Mapping[str, Interval]] = []
    for way in _list_ways(normal(assume)):
        box = dict(region.box)
        for part in way:
            if isinstance(part, Linear) and len(part.terms) == 1 and part.terms[0][1] in box:
                ((weight, name),), (low, high) = part.terms, box[part.terms[0][1]]
                end = part.bound / weight
                box[name] = (low, min(high, end)) if weight > 0 else (max(low, end), high)
        if all(low <= high for low, high in box.values()):
            boxes.append(box)
    return boxes


def _list_ways(formula: Formula) -> list[tuple[Formula, ...]]:
    """The ways in which a formula may be true, each as parts that hold together, at most MAX_WAYS."""
    if isinstance(formula, Or):
        return list(islice(chain.from_iterable(map(_list_ways, formula.parts)), MAX_WAYS))
    if isinstance(formula, And):
        ways = product(*map(_list_ways, formula.parts))
        return [tuple(chain.from_iterable(way)) for way in islice(ways, MAX_WAYS)]
    return [(formula,)]


def violating(question: DecisionQuestion, coordinates: Float64) -> Bool:
    """Where the team's own actions violate the claim, with some errors where it allows them, [batch]."""
    if question.claim.eps:
        return noise.violable(question, coordinates)
    profile, team = question.profile, question.profile.team(question.claim.team)
    actions = {policy.agent: choose_actions(policy, coordinates, profile.world, question.semantics) for policy in team}
    return ~batch(coordinates, profile.world).holds(question.formula, actions)


def about_landmarks(profile: PolicyProfile, stated: Formula) -> bool:
    """Returns True if a formula speaks of places of landmarks."""
    marks = {*(landmark.name for landmark in profile.world.landmarks), GOAL}
    return any(name.rpartition(".")[0] in marks for name in spoken_of(stated))


def conflicts(question: DecisionQuestion, coordinates: Float64) -> Bool | None:
    """Where some joint action violates the claim, [batch]; of claims about landmarks, one in which every agent closes
    on at least one of them.

    None when a part of the claim speaks of too many joint actions to try them all.
    """
    profile, claim, stated = question.profile, question.claim, question.formula
    team = {policy.agent: policy for policy in profile.team(claim.team)}
    states = batch(coordinates, profile.world)
    aimed = about_landmarks(profile, stated)
    willing = {
        agent: [
            states.holds(_willing(profile, policy, action, claim) if aimed else TRUE, {})
            for action in range(len(policy.actions))
        ]
        for agent, policy in team.items()
    }
    held = _Held(states)
    violating = np.zeros(len(coordinates), dtype=bool)
    moving = np.logical_and.reduce([np.logical_or.reduce(each) for each in willing.values()])
    for part in stated.parts if isinstance(stated, And) else (stated,):
        speaking = agents(part)
        acting = [agent for agent in team if agent in speaking]
        if math.prod(len(willing[agent]) for agent in acting) > MAX_JOINT_ACTIONS:
            if not claim.any_matching or claim.assume != TRUE:
                return None
            return _unmatchable(question, states, willing)
        for joint in product(*(range(len(willing[agent])) for agent in acting)):
            chosen_by = dict(zip(acting, joint, strict=True))
            possible = np.logical_and.reduce([moving, *(willing[agent][chosen_by[agent]] for agent in acting)])
            violating |= possible & ~held(part, chosen_by)
    return violating


class _Held:
    """Where formulas are true given joint actions: what speaks of one agent is evaluated once for each of its actions,
    as claims about pairs of agents ask it again for every pair.
    """

    def __init__(self, states: Batch) -> None:
        self._states = states
        self._split: dict[int, list[tuple[Formula, str | None]]] = {}  # by identity; the claim keeps its parts
        self._whole: dict[tuple[int, ...], Formula] = {}
        self._known: dict[tuple[int, int], Bool] = {}

    def __call__(self, part: Formula, actions: Mapping[str, int]) -> Bool:
        """Where the part of a claim is true, [batch]."""
        if id(part) not in self._split:
            self._split[id(part)] = self._by_agent(part)
        ways = [self._of_one(each, agent, actions) for each, agent in self._split[id(part)]]
        return np.asarray((np.logical_and if isinstance(part, And) else np.logical_or).reduce(ways))

    def _by_agent(self, part: Formula) -> list[tuple[Formula, str | None]]:
        """The parts of a formula: what speaks of one agent alone together, with its name, and the others."""
        if not isinstance(part, (And, Or)):
            return [(part, None)]
        own: dict[str | None, list[Formula]] = {}
        for each in part.parts:
            acting = agents(each)
            own.setdefault(min(acting) if len(acting) == 1 else None, []).append(each)
        return [
            (self._whole.setdefault(tuple(map(id, of_one)), type(part)(tuple(of_one))), agent)
            for agent, of_one in own.items()
        ]

    def _of_one(self, part: Formula, agent: str | None, actions: Mapping[str, int]) -> Bool:
        if agent is None:
            return self._states.holds(substitute_actions(part, actions), {})
        key = id(part), actions[agent]
        if key not in self._known:
            if len(self._known) == MAX_HELD:
                self._known.clear()
            self._known[key] = self._states.holds(substitute_actions(part, actions), {})
        return self._known[key]


def _unmatchable(question: DecisionQuestion, states: Batch, willing: Mapping[str, Sequence[Bool]]) -> Bool:
    """Where willing actions can leave no matching of the team to the landmarks, by Hall's theorem."""
    marks = [landmark.name for landmark in question.profile.world.landmarks]

    def relate_marks(policy: AgentPolicy, action: int) -> Bool:
        own = [substitute_actions(engages(policy, mark, question.claim), {policy.agent: action}) for mark in marks]
        return np.stack([states.holds(each, {}) for each in own], axis=1)

    choices = [
        [(allowed, relate_marks(policy, action)) for action, allowed in enumerate(willing[policy.agent])]
        for policy in question.profile.team(question.claim.team)
    ]
    return preventable(choices, len(marks))


def _willing(profile: PolicyProfile, policy: AgentPolicy, action: int, claim: DecisionClaim) -> Formula:
    """The action closes on some landmark; without landmarks, any."""
    if not profile.world.landmarks:
        return TRUE
    return disjunction(*(closes(policy, action, mark.name, claim.margin) for mark in profile.world.landmarks))


def _is_contested(question: DecisionQuestion, coordinates: Float64) -> Bool | None:
    """Two agents, both inside the landmarks' rectangle."""
    profile = question.profile
    team, landmarks = profile.team(question.claim.team), profile.world.landmarks
    if len(team) != 2 or len(landmarks) != 2:
        return None
    at = dict(zip(profile.world.coordinates(), coordinates.T, strict=True))
    inside = np.ones(len(coordinates), dtype=bool)
    for policy, axis in product(team, "xy"):
        # inside: on each axis the two landmarks do not lie on the same side of the agent
        first, second = (at[f"{mark.name}.{axis}"] - at[f"{policy.agent}.{axis}"] for mark in landmarks)
        inside &= first * second <= 0
    return inside


MAX_NUMBER, DRAWS = 1_000, 10  # states, and batches of SAMPLES that are drawn for them at most
FIRST_SEED = 1_007  # of the batches; none of them is the one that shares are measured with
JUDGED = 4  # states that are judged for each that is wanted, at most
MAX_ERRORS = 256  # ways to err together that are tried in a world state


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
    # row, actions of the team, errors that cause them: of each state the actions without errors first
    tries: list[tuple[int, tuple[int, ...], dict[str, Value]]] = []
    usual = [choose_actions(policy, coordinates, profile.world) for policy in team]
    each = [ways(policy, coordinates, profile.world, question.claim.eps) for policy in team]
    for row, state in enumerate(states):
        options: list[dict[int, dict[str, float]]] = []
        for policy, acts, errors in zip(team, usual, each, strict=True):
            causes: dict[int, dict[str, float]] = {int(acts[row]): {}}
            for way in filter(None, errors[row]):
                action = int(act(policy, observe_state(profile, policy, replace(state, errors=way)))[0])
                causes.setdefault(action, way)
            options.append(causes)
        for taken in islice(product(*options), MAX_ERRORS):
            caused = together(causes[action] for causes, action in zip(options, taken, strict=True))
            tries.append((row, taken, caused))
    rows = np.array([row for row, _, _ in tries], dtype=np.int64)
    joint = np.array([acts for _, acts, _ in tries], dtype=np.int32).reshape(-1, len(team))
    actions = {policy.agent: column for policy, column in zip(team, joint.T, strict=True)}
    wrong = _judge_actions(question, coordinates[rows], [states[row].goal for row, _, _ in tries], actions)
    known: set[int] = set()
    for row, _, errors in (tries[place] for place in np.flatnonzero(wrong).tolist()):
        if row not in known:
            known.add(row)
            yield replace(states[row], errors=errors)


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
