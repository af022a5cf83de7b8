"""distinct_targets as one query, written with z3's API directly: the yardstick of the verifier's benchmark.

It is written the way z3's own users do: a Real for each coordinate, nested If for each tree, one solver. Thresholds are
the exact ends of the machine's half lines, so its answer is comparable with ours.
"""

from itertools import permutations

import z3

from codegen.ir import ROOT, AgentPolicy, PolicyProfile
from verify.solver.encode import half_line

RADIUS = "1/10"
LEFT, RIGHT, DOWN, UP = 1, 2, 3, 4


def built(profile: PolicyProfile, team: str) -> z3.Solver:
    """The solver with the whole question about the start region [-1, 1]: sat where the claim fails."""
    world = profile.world
    at = {name: z3.Real(name) for name in world.coordinates() if not name.endswith((".vx", ".vy"))}
    solver, marks = z3.Solver(), [mark.name for mark in world.landmarks]
    for name, variable in at.items():
        if not name.startswith("goal."):
            solver.add(variable >= -1, variable <= 1)
    if world.goals:
        same = [(at["goal.x"] == at[f"{mark}.x"], at["goal.y"] == at[f"{mark}.y"]) for mark in marks]
        solver.add(z3.Or(*(z3.And(*both) for both in same)))
    chosen = {policy.agent: _action(policy, ROOT, at) for policy in profile.team(team)}

    def engaged(agent: str, mark: str) -> z3.BoolRef:
        dx, dy = at[f"{mark}.x"] - at[f"{agent}.x"], at[f"{mark}.y"] - at[f"{agent}.y"]
        moves = {LEFT: dx < 0, RIGHT: dx > 0, DOWN: dy < 0, UP: dy > 0}
        radius = z3.RealVal(RADIUS)
        near = z3.And(dx <= radius, dx >= -radius, dy <= radius, dy >= -radius)
        return z3.Or(near, *(z3.And(chosen[agent] == action, closes) for action, closes in moves.items()))

    matched = [
        z3.And(*(engaged(agent, mark) for agent, mark in zip(chosen, own, strict=True)))
        for own in permutations(marks, len(chosen))
    ]
    solver.add(z3.Not(z3.Or(*matched)))
    return solver


def decided(profile: PolicyProfile, team: str) -> bool:
    """Whether the claim holds."""
    return built(profile, team).check() == z3.unsat


def _action(policy: AgentPolicy, node: int, at: dict[str, z3.ArithRef]) -> z3.ArithRef:
    tree = policy.tree
    if tree.feature[node] < 0:
        return z3.IntVal(int(tree.action[node]))
    meaning = policy.features[int(tree.feature[node])].meaning
    measured = sum(at[name] if weight > 0 else -at[name] for weight, name in meaning.terms)
    line = half_line(float(tree.threshold[node]), True)
    end = z3.RealVal(str(line.end))
    left, right = (_action(policy, int(side[node]), at) for side in (tree.left, tree.right))
    return z3.If(measured < end if line.strict else measured <= end, left, right)
