"""Counterexamples that a person can read: found inside their cells, shrunk to few digits, explained, replayed.

Does: turns a solver's model into a float64 world state that the referee confirms, and tells both trees' paths.
Assumes: the question was satisfiable; stronger questions (with slack) may be asked.
Does not: call a real-valued state a counterexample when no float64 state near it replays.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from fractions import Fraction

import numpy as np

from codegen import ir
from codegen.errors import DisagreementError
from codegen.ir import PolicyProfile, WorldSpec
from verify.encode import question
from verify.formula import TRUE
from verify.noise import mistaken
from verify.properties import Property, formula
from verify.shares import SAMPLE_SEED, SAMPLES, violating
from verify.solve import Answer, ask
from verify.spec import Region
from verify.world import (
    Point,
    engaged_with,
    error_name,
    inside,
    nearest,
    observed,
    point_of,
    sample,
    shortfall,
    violates,
)

SLACKS = tuple(Fraction(1, 2**power) for power in (3, 4, 5, 7, 10, 20, 40))
SPACED_SLACKS = 3  # so many of the slacks are first tried with all entities SPACE apart, which reads better
SPACE = Fraction(1, 5)
MOST_REFEREED = 50  # sampled violations that the referee looks at, at most
MOST_PLACES = 12  # decimal places that shrinking tries before it keeps all digits
ROOM = 0.1  # shrinking keeps entities at least so far apart, and claims failing by so much, or as much as they were
Replay = Callable[[Point], list[int]]  # a world state -> the team's actions


@dataclass(frozen=True)
class Step:
    """One test on a decision path: `value` of `feature` against `threshold`."""

    node: int
    feature: str
    value: float
    threshold: float
    left: bool

    def __str__(self) -> str:
        return f"{self.feature} = {self.value:.6g} {'<=' if self.left else '>'} {self.threshold:.6g}"


@dataclass(frozen=True)
class AgentView:
    """What one agent of the team does in a counterexample, and why."""

    agent: str
    action: str
    leaf: int
    path: tuple[Step, ...]
    engaged_with: tuple[str, ...]  # landmarks
    errors: tuple[tuple[str, float], ...] = ()  # feature -> by how much it is off


@dataclass(frozen=True)
class Counterexample:
    """A float64 world state in which the claim fails, confirmed by the referee and by every replay."""

    point: Point
    agents: tuple[AgentView, ...]
    replayed: tuple[str, ...]  # names of what reproduced the same actions


def confirmed(
    profile: PolicyProfile, claim: Property, region: Region, goal: str, answer: Answer, budget: int
) -> tuple[Point | None, int]:
    """A shrunk float64 point that violates the claim, or None when only the real-valued model exists.

    Tries answers to stronger questions, the model itself, then sampled states. Returns the point and the resource
    units spent on stronger questions.
    """
    spent = 0
    for where, slack in _stronger(profile, region):
        inner = ask(question(profile, claim, where, goal, slack), budget)
        spent += inner.resources
        point = _nearest(inner, region, goal, claim.eps)
        if point is not None and _stands(profile, claim, region, point):
            return shrink(profile, claim, region, point), spent
    point = _nearest(answer, region, goal, claim.eps)
    if point is not None and _stands(profile, claim, region, point):
        return shrink(profile, claim, region, point), spent
    for point in violating_samples(profile, claim, replace(region, goals=(goal,) if goal else ())):
        return shrink(profile, claim, region, point), spent
    return None, spent


def violating_samples(profile: PolicyProfile, claim: Property, region: Region) -> Iterator[Point]:
    """The sampled world states of the violating fraction, of the same draw, that the referee confirms."""
    coordinates, goals = sample(region, profile.world, SAMPLES, SAMPLE_SEED)
    for row in np.flatnonzero(violating(profile, claim, coordinates))[:MOST_REFEREED]:
        point = point_of(region, profile.world, coordinates[row], int(goals[row]))
        if claim.eps:
            point = mistaken(profile, claim, point) or point
        if _stands(profile, claim, region, point):
            yield point


def near(
    profile: PolicyProfile, claim: Property, region: Region, goal: str, model: Mapping[str, Fraction]
) -> Point | None:
    """A shrunk float64 point beside an exact one that violates the claim, with errors where the claim allows them; None
    when the nearest one does not.
    """
    point = nearest(dict(model), region, goal, Fraction(0))
    if claim.eps:
        point = mistaken(profile, claim, point) or point
    if point is not None and _stands(profile, claim, region, point):
        return shrink(profile, claim, region, point)
    return None


def _stronger(profile: PolicyProfile, region: Region) -> Iterator[tuple[Region, Fraction]]:
    """Stronger questions, the most comfortable counterexamples first."""
    entities = [entity.name for entity in profile.world.agents + profile.world.landmarks]
    pairs = tuple((a, b, SPACE) for index, a in enumerate(entities) for b in entities[index + 1 :])
    spaced = replace(region, apart=region.apart + pairs)
    yield from ((spaced, slack) for slack in SLACKS[:SPACED_SLACKS])
    yield from ((region, slack) for slack in SLACKS)


def _nearest(answer: Answer, region: Region, goal: str, eps: Fraction) -> Point | None:
    return None if answer.model is None else nearest(answer.model, region, goal, eps)


def _stands(profile: PolicyProfile, claim: Property, region: Region, point: Point) -> bool:
    if any(abs(Fraction(error)) > claim.eps for error in point.errors.values()):
        return False
    return inside(region, point) and violates(profile, claim, point)


def shrink(
    profile: PolicyProfile,
    claim: Property,
    region: Region,
    point: Point,
    keeps: Callable[[Point], bool] = lambda point: True,
) -> Point:
    """The same violation with as few decimals as possible, and hardly less clear. `keeps`: what else must stay."""
    claim = replace(claim, statement=formula(profile, claim), assume=TRUE)  # stated once, not for every candidate
    least = min(ROOM, shortfall(profile, claim, point))

    def stands(candidate: Point) -> bool:
        fails = _stands(profile, claim, region, candidate) and keeps(candidate)
        return fails and shortfall(profile, claim, candidate) >= least

    return simplest(profile.world, point, stands)


def simplest(world: WorldSpec, point: Point, stands: Callable[[Point], bool]) -> Point:
    """The point with as few decimals as still stand, first for all positions together, then one by one."""
    entities = [entity.name for entity in world.agents + world.landmarks]
    room = {(a, b): min(ROOM, _apart(point, a, b)) for index, a in enumerate(entities) for b in entities[index + 1 :]}

    def holds(position: Mapping[str, float], errors: Mapping[str, float]) -> bool:
        candidate = Point(position, point.goal, errors)
        if any(_apart(candidate, a, b) < least for (a, b), least in room.items()):
            return False
        return stands(candidate)

    position, errors = dict(point.position), dict(point.errors)
    for places in range(MOST_PLACES):
        rounded = {name: round(value, places) + 0.0 for name, value in position.items()}
        if holds(rounded, errors):
            position = rounded
            break
    _simplified(position, lambda: holds(position, errors))
    _simplified(errors, lambda: holds(position, errors))
    return Point(position, point.goal, {name: error for name, error in errors.items() if error})


def _simplified(values: dict[str, float], holds: Callable[[], bool]) -> None:
    """Rounds each value in place to the fewest decimals with which what `holds` asks stays true."""
    for name, value in values.items():
        for places in range(MOST_PLACES):
            simpler = round(value, places) + 0.0
            if simpler == value:
                break
            values[name] = simpler
            if holds():
                break
            values[name] = value


def _apart(point: Point, a: str, b: str) -> float:
    return max(abs(point.position[f"{a}.{axis}"] - point.position[f"{b}.{axis}"]) for axis in "xy")


def explain(profile: PolicyProfile, claim: Property, point: Point, replays: Mapping[str, Replay]) -> Counterexample:
    """The counterexample with its paths, after every replay gave the same actions.

    DisagreementError when one of them acts differently: then there is a bug, and no verdict.
    """
    team = profile.team(claim.team)
    seen = [observed(profile, policy, point) for policy in team]
    actions = [int(ir.act(policy, obs)[0]) for policy, obs in zip(team, seen, strict=True)]
    for name, replay in replays.items():
        found = replay(point)
        if list(found) != actions:
            raise DisagreementError(
                f"the {name} does not reproduce the counterexample",
                f"reference {actions}, {name} {list(found)}",
                "this is a bug",
            )
    engaged = engaged_with(profile, claim, point)
    views = []
    for policy, action, obs in zip(team, actions, seen, strict=True):
        leaf = int(ir.apply(policy.tree, obs)[0])
        errors = [(one.name, point.errors.get(error_name(policy.agent, one.name), 0.0)) for one in policy.features]
        named = policy.actions[action].name
        wrong = tuple((name, error) for name, error in errors if error)
        views.append(AgentView(policy.agent, named, leaf, path(policy, obs[0]), engaged[policy.agent], wrong))
    return Counterexample(point, tuple(views), ("reference", *replays))


def path(policy: ir.AgentPolicy, obs: ir.Float32) -> tuple[Step, ...]:
    """The tests that lead to the decision for one observation [n_features]."""
    tree, node, steps = policy.tree, ir.ROOT, []
    while tree.feature[node] != ir.NO_FEATURE:
        feature = int(tree.feature[node])
        left = bool(np.float32(obs[feature]) <= tree.threshold[node])
        steps.append(Step(node, policy.features[feature].name, float(obs[feature]), float(tree.threshold[node]), left))
        node = int(tree.left[node] if left else tree.right[node])
    return tuple(steps)
