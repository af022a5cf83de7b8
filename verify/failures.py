"""World states in which a claim fails, many of them; and whether it does in each of many.

Does: the referee's judgement of many world states at once; draws states of a region until enough violate the claim.
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
from verify.formula import Batch, for_goal, holds, negated, normal
from verify.noise import together, ways
from verify.properties import Property, formula
from verify.shares import SAMPLES, violating
from verify.spec import Region
from verify.world import Point, chosen, inside, observed, point_of, sample

MOST, DRAWS = 1_000, 10  # states, and batches of SAMPLES that are drawn for them at most
FIRST_SEED = 1_007  # of the batches; none of them is the one that shares are measured with
JUDGED = 4  # states that are judged for each that is wanted, at most
MOST_WAYS = 256  # ways to err together that are tried in a world state


def failures(profile: PolicyProfile, claim: Property, region: Region, most: int = MOST) -> list[Point]:
    """At most `most` world states of a region, uniform among those where the claim fails, in the order of the draw.

    Where the claim allows errors, each state comes with errors that make it fail. Fewer where float64 takes many more
    states for failures than are (JUDGED): in regions that lie within a rounding of a boundary.
    """
    found: list[Point] = []
    left = JUDGED * most
    for draw in range(DRAWS):
        coordinates, goals = sample(region, profile.world, SAMPLES, FIRST_SEED + draw)
        rows = np.flatnonzero(violating(profile, claim, coordinates))
        while rows.size and left and len(found) < most:
            wanted, rows = np.split(rows, [min(left, most - len(found))])
            left -= len(wanted)
            points = [point_of(region, profile.world, coordinates[row], int(goals[row])) for row in wanted]
            found += _failing(profile, claim, [point for point in points if inside(region, point)])
        if not left or len(found) == most:
            break
    return found


def fails(profile: PolicyProfile, claim: Property, points: Sequence[Point]) -> Bool:
    """What `verify.world.violates` says of each world state, [n]."""
    coordinates = _coordinates(profile, points)
    actions: dict[str, Int32] = {}
    for policy in profile.team(claim.team):
        seen = observe(policy.features, coordinates, profile.world)
        for row, point in enumerate(points):
            if point.errors:
                seen[row] = observed(profile, policy, point)[0]
        actions[policy.agent] = act(policy, seen)
    return _judged(profile, claim, coordinates, [point.goal for point in points], actions)


def _coordinates(profile: PolicyProfile, points: Sequence[Point]) -> Float64:
    n_coordinates = len(profile.world.coordinates())
    return np.concatenate([np.zeros((0, n_coordinates)), *(point.coordinates(profile) for point in points)])


def _failing(profile: PolicyProfile, claim: Property, points: Sequence[Point]) -> Iterator[Point]:
    """Those of the world states in which the claim fails, with errors where it allows them."""
    if not claim.eps:
        yield from (points[row] for row in np.flatnonzero(fails(profile, claim, points)).tolist())
        return
    coordinates, team = _coordinates(profile, points), profile.team(claim.team)
    tries = list(_mistakes(profile, claim, points, coordinates))
    rows = np.array([row for row, _, _ in tries], dtype=np.int64)
    joint = np.array([acts for _, acts, _ in tries], dtype=np.int32).reshape(-1, len(team))
    actions = {policy.agent: column for policy, column in zip(team, joint.T, strict=True)}
    wrong = _judged(profile, claim, coordinates[rows], [points[row].goal for row in rows.tolist()], actions)
    known: set[int] = set()
    for row, _, errors in (tries[place] for place in np.flatnonzero(wrong).tolist()):
        if row not in known:
            known.add(row)
            yield replace(points[row], errors=errors)


def _mistakes(
    profile: PolicyProfile, claim: Property, points: Sequence[Point], coordinates: Float64
) -> Iterator[tuple[int, tuple[int, ...], dict[str, float]]]:
    """(row, actions of the team, errors that cause them), of each state the actions without errors first."""
    team, world = profile.team(claim.team), profile.world
    usual = [chosen(policy, coordinates, world) for policy in team]
    each = [ways(policy, coordinates, world, claim.eps) for policy in team]
    for row, point in enumerate(points):
        options: list[dict[int, dict[str, float]]] = []
        for policy, acts, errors in zip(team, usual, each, strict=True):
            found: dict[int, dict[str, float]] = {int(acts[row]): {}}
            for way in filter(None, errors[row]):
                action = int(act(policy, observed(profile, policy, replace(point, errors=way)))[0])
                found.setdefault(action, way)
            options.append(found)
        for joint in islice(product(*options), MOST_WAYS):
            yield row, joint, together(found[action] for found, action in zip(options, joint, strict=True))


def _judged(
    profile: PolicyProfile,
    claim: Property,
    coordinates: Float64,
    goals: Sequence[str],
    actions: Mapping[str, Int32],
) -> Bool:
    """Where the claim fails with these actions (agent -> [n]), exactly, [n]."""
    stated, names, of_goal = formula(profile, claim), profile.world.coordinates(), np.array(goals, dtype=object)
    wrong = np.zeros(len(coordinates), dtype=bool)
    for goal in dict.fromkeys(goals):
        rows, asked = np.flatnonzero(of_goal == goal), for_goal(stated, goal)
        columns = dict(zip(names, coordinates[rows].T, strict=True))
        taken = {agent: column[rows] for agent, column in actions.items()}
        states = Batch(columns, len(rows), doubting=True)
        wrong[rows] = ~states.holds(normal(asked), taken)
        unsure = states.holds(normal(asked), taken) & states.holds(negated(asked), taken)
        for row in rows[unsure]:
            at = {name: Fraction(value) for name, value in zip(names, coordinates[row].tolist(), strict=True)}
            wrong[row] = not holds(asked, at, {agent: int(column[row]) for agent, column in actions.items()})
    return wrong
