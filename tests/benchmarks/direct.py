"""distinct_targets as one query, written with z3's API directly: the yardstick of the verifier's benchmark.

    python -m tests.benchmarks.direct PROFILE TEAM

It is written the way z3's own users do: a Real for each coordinate, nested If for each tree, one solver; and as a
process it imports nothing of ours. Thresholds are then compared as real numbers. Asked beside our engines, it gets the
exact ends of the machine's half lines, so that its answer is comparable with theirs.
"""

import json
import sys
from collections.abc import Callable
from fractions import Fraction
from itertools import permutations
from pathlib import Path
from typing import Any

import z3

RADIUS = "1/10"
LEFT, RIGHT, DOWN, UP = 1, 2, 3, 4
Line = tuple[Fraction, bool]  # the end of what goes left, and whether it is left out
Ends = Callable[[float], Line]


def as_real(threshold: float) -> Line:
    """A threshold between real numbers."""
    return Fraction(threshold), False


def built(profile: dict[str, Any], team: str, ends: Ends = as_real) -> z3.Solver:
    """The solver with the whole question about the start region [-1, 1]: sat where the claim fails. `profile`: as in
    its file.
    """
    world = profile["world"]
    marks = [mark["name"] for mark in world["landmarks"]]
    entities = [*(agent["name"] for agent in world["agents"]), *marks]
    at = {f"{name}.{axis}": z3.Real(f"{name}.{axis}") for name in [*entities, "goal"] for axis in "xy"}
    solver = z3.Solver()
    for name in entities:
        solver.add(*(bound for axis in "xy" for bound in (at[f"{name}.{axis}"] >= -1, at[f"{name}.{axis}"] <= 1)))
    if world["goals"]:
        same = [(at["goal.x"] == at[f"{mark}.x"], at["goal.y"] == at[f"{mark}.y"]) for mark in marks]
        solver.add(z3.Or(*(z3.And(*both) for both in same)))
    chosen = {one["agent"]: _action(one, 0, at, ends) for one in profile["agents"] if one["team"] == team}

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


def decided(profile: dict[str, Any], team: str, ends: Ends = as_real) -> bool:
    """Whether the claim holds."""
    return built(profile, team, ends).check() == z3.unsat


def _action(policy: dict[str, Any], node: int, at: dict[str, z3.ArithRef], ends: Ends) -> z3.ArithRef:
    split = policy["tree"][node]
    if "action" in split:
        return z3.IntVal([action["name"] for action in policy["actions"]].index(split["action"]))
    meaning = next(feature["meaning"] for feature in policy["features"] if feature["name"] == split["feature"])
    measured = sum(-at[name[1:]] if name.startswith("-") else at[name] for name in meaning.replace("- ", "-").split())
    last, strict = ends(split["threshold"])
    left, right = (_action(policy, split[side], at, ends) for side in ("left", "right"))
    return z3.If(measured < z3.RealVal(str(last)) if strict else measured <= z3.RealVal(str(last)), left, right)


if __name__ == "__main__":
    print("PROVED" if decided(json.loads(Path(sys.argv[1]).read_text()), sys.argv[2]) else "VIOLATED")
