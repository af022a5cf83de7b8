"""Whole episodes as one query to Z3, unrolled over all steps: a second opinion on claims about episodes."""

from fractions import Fraction

import z3

from codegen import ir
from verify.solver.terms import half_line
from verify.states.episodes import find_matchings


def number(value):
    return z3.RealVal(f"{value.numerator}/{value.denominator}")


def unrolled(profile, claim, region, goal, limit=0):
    """Whether an episode from `region` violates the claim, by one query over all steps; None after `limit` ms.

    Positions and velocities of each step are variables; trees are nested conditions on positions, over the reals.
    Agents of other teams stand still.
    """
    solver = z3.SolverFor("QF_LRA")
    if limit:
        solver.set("timeout", limit)
    world = profile.world
    entities = [entity.name for entity in world.agents + world.landmarks]
    place = {f"{name}.{axis}": z3.Real(f"{name}.{axis}") for name in entities for axis in "xy"}
    for name, variable in place.items():
        low, high = region.box[name]
        solver.add(variable >= number(low), variable <= number(high))
    speed = {f"{entity.name}.{axis}": number(Fraction(0)) for entity in world.agents for axis in "xy"}
    team, forces = profile.team(claim.team), {entity.name: Fraction(entity.force) for entity in world.agents}
    course = [place]
    dt, kept = Fraction(world.dt), 1 - Fraction(world.damping)
    for step in range(claim.steps):
        following, faster = dict(place), dict(speed)
        for policy in team:
            pushes = _pushes(policy, place, goal)
            for axis, push in zip("xy", pushes, strict=True):
                name = f"{policy.agent}.{axis}"
                following[name], faster[name] = z3.Reals(f"{name}@{step + 1} {name}'@{step + 1}")
                solver.add(following[name] == place[name] + number(dt) * speed[name])
                solver.add(faster[name] == number(kept) * speed[name] + number(dt * forces[policy.agent]) * push)
        place, speed = following, faster
        course.append(place)
    steps = course if claim.name == "reaches" else course[-1:]
    landmarks = [landmark.name for landmark in world.landmarks]
    ways = [
        z3.And(
            *(
                z3.Or(*(_at(now, policy.agent, landmarks[own], claim.radius) for now in steps))
                for policy, own in zip(team, matching, strict=True)
            )
        )
        for matching in find_matchings(profile, claim)
    ]
    solver.add(z3.Not(z3.Or(*ways)))
    answer = solver.check()
    return None if answer == z3.unknown else answer == z3.sat


def _at(place, agent, landmark, radius):
    gaps = [place[f"{agent}.{axis}"] - place[f"{landmark}.{axis}"] for axis in "xy"]
    return z3.And(*(side for gap in gaps for side in (gap <= number(radius), gap >= number(-radius))))


def _pushes(policy, place, goal):
    """The direction that a tree chooses, per axis, as nested conditions."""
    tree, found = policy.tree, {}
    at = {**place, **{f"goal.{axis}": place[f"{goal}.{axis}"] for axis in "xy"}}
    for node in reversed(range(len(tree.feature))):
        if tree.feature[node] == ir.NO_FEATURE:
            effect = policy.actions[tree.action[node]].effect
            found[node] = [number(Fraction(part)) for part in effect]
            continue
        terms = policy.features[tree.feature[node]].meaning.terms
        measured = z3.Sum(*(weight * at[name] for weight, name in terms))
        line = half_line(float(tree.threshold[node]), True)
        below = measured < number(line.end) if line.strict else measured <= number(line.end)
        sides = zip(found[int(tree.left[node])], found[int(tree.right[node])], strict=True)
        found[node] = [z3.If(below, left, right) for left, right in sides]
    return found[ir.ROOT]
