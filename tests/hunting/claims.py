"""Random claims about decisions, as plain data, and as text of a property file.

Does: draws claims of every kind with their parameters; writes formulas in the users' language.
Assumes: formulas as meaning.py has them.
Does not: say what they mean (meaning.py, for the judge; verify/claims, for the verifier).
"""

from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import Any

import numpy as np

from codegen.ir import PolicyProfile

NAMES = {  # and how often, of a thousand
    "distinct_targets": 320, "own_target": 270, "no_double": 90, "steady": 110, "formula": 185, "aligned": 8,
    "assignment": 7, "alive_leaves": 10,
}  # fmt: skip
STEADY_OF = ("distinct_targets", "own_target", "no_double")
LENGTHS = (Fraction(1, 10), Fraction(1, 5), Fraction(1, 8), Fraction(3, 20), Fraction(1, 20))
READS = {
    "distinct_targets": ("margin", "radius"),
    "own_target": ("margin", "radius", "landmarks"),
    "no_double": ("margin",),
    "aligned": ("margin", "radius", "kappa"),
    "assignment": ("margin", "radius"),
    "alive_leaves": (),
    "formula": ("margin", "radius"),
}


def drawn(rng: np.random.Generator, profile: PolicyProfile, team: str) -> dict[str, Any]:
    """A claim about a team."""
    agents, marks = [one.agent for one in profile.team(team)], [mark.name for mark in profile.world.landmarks]
    weights = np.array(list(NAMES.values()), dtype=float)
    name = str(rng.choice(list(NAMES), p=weights / weights.sum()))
    if (name == "no_double" and len(agents) < 2) or (name == "assignment" and len(agents) != 2):
        name = "own_target"
    claim: dict[str, Any] = {"name": name, "team": team, "eps": Fraction(0), "of": "", "assume": None, "landmarks": ()}
    claim["margin"] = Fraction(0) if rng.random() < 0.8 else Fraction(int(rng.integers(1, 5)), 40)
    claim["radius"] = LENGTHS[int(rng.integers(len(LENGTHS)))]
    claim["kappa"] = Fraction(int(rng.integers(0, 5)), 4)
    if name == "steady":
        claim["of"] = str(rng.choice(STEADY_OF[: 3 if len(agents) > 1 else 2]))
        claim["eps"] = Fraction(int(rng.choice([1, 5, 10, 20])), 1000)
    if (claim["of"] or name) == "own_target" and rng.random() < 0.3:
        claim["landmarks"] = tuple(map(str, rng.permutation(marks)[: len(agents)]))
    if name == "formula":
        claim["formula"] = formula(rng, profile, agents, marks)
        claim["mixed"] = _mixed(claim["formula"])
    if name != "alive_leaves" and rng.random() < 0.15:
        claim["assume"] = assumption(rng, agents, marks, profile.world.goals)
    return claim


def formula(rng: np.random.Generator, profile: PolicyProfile, agents: Sequence[str], marks: Sequence[str]) -> Any:
    """A formula that roles fulfil, or nearly, or one of any kind."""
    place = int(rng.integers(len(agents)))
    agent, mark = agents[place], marks[place % len(marks)] if rng.random() < 0.7 else str(rng.choice(marks))
    length = Fraction(int(rng.integers(1, 9)), 20)
    kind = int(rng.integers(7))
    if kind == 0:
        return ("implies", (">", ("distance", agent, mark), length), ("closes", agent, mark))
    if kind == 1:
        return ("engaged", agent, mark, Fraction(int(rng.integers(0, 2)), 40))
    if kind == 2:
        name, side = [("left", ">="), ("right", "<=")][int(rng.integers(2))]
        bound = ("-", f"{mark}.x", length) if side == ">=" else ("+", f"{mark}.x", length)
        return ("implies", ("acts", agent, name), (side, f"{agent}.x", bound))
    if kind == 3:
        parts = [("closes", one, other) for one, other in zip(agents, marks, strict=False)]
        parts += [("at", one, other, Fraction(1, 10)) for one, other in zip(agents, marks, strict=False)]
        return ("or", *parts)
    if kind == 4:
        gap = ("abs", ("-", f"{agent}.y", f"{mark}.y"))
        return ("not", ("and", ("acts", agent, "stay"), (">", gap, length)))
    if kind == 5 and profile.world.goals:
        return ("implies", ("goal", mark), ("engaged", agent, mark))
    least = ("max", ("-", f"{agent}.x", f"{mark}.x"), ("-", f"{agent}.y", f"{mark}.y"))
    return ("implies", ("<", least, ("*", Fraction(1, 2), length)), ("not", ("acts", agent, "down")))


def assumption(rng: np.random.Generator, agents: Sequence[str], marks: Sequence[str], goals: Sequence[str]) -> Any:
    """Something about the state alone."""
    agent, mark, length = str(rng.choice(agents)), str(rng.choice(marks)), Fraction(int(rng.integers(1, 13)), 10)
    kind = int(rng.integers(5))
    if kind == 0:
        return ("<=", ("distance", agent, mark), length)
    if kind == 1 and goals:
        return ("goal", mark)
    if kind == 2:
        return (">=", ("-", f"{agent}.x", f"{mark}.x"), Fraction(int(rng.integers(-8, 9)), 8))
    if kind == 3 and len(agents) > 1:
        return ("!=", f"{agents[0]}.y", f"{agents[1]}.y")
    return ("or", (">", f"{agent}.y", Fraction(0)), ("==", f"{mark}.x", Fraction(1, 4)))


def _mixed(node: Any) -> bool:
    """Whether a formula compares other things than differences of two coordinates on one axis with constants."""
    return isinstance(node, tuple) and (node[0] in ("max", "min") or any(map(_mixed, node[1:])))


# --- as text


def text(node: Any) -> str:
    """A formula in the users' language."""
    if isinstance(node, str):
        return node
    if isinstance(node, Fraction):
        return f"({node})"
    kind, *parts = node
    if kind in ("and", "or"):
        return "(" + f" {kind} ".join(map(text, parts)) + ")"
    if kind == "not":
        return f"(not {text(parts[0])})"
    if kind == "implies":
        return f"({text(parts[0])} implies {text(parts[1])})"
    if kind == "acts":
        return f"(acts({parts[0]}) == {parts[1]})"
    if kind == "goal":
        return f"(goal == {parts[0]})"
    if kind in ("closes", "at", "engaged", "distance", "abs", "max", "min"):
        return f"{kind}({', '.join(map(text, parts))})"
    return f"({text(parts[0])} {kind} {text(parts[1])})"


def property_file(claim: Mapping[str, Any], region: str) -> str:
    """The claim and its region as a property file."""
    lines = ["[[property]]", f'team = "{claim["team"]}"', f"region = {region}"]
    name = claim["name"]
    read = READS[claim["of"] or name]
    if name == "formula":
        lines.append(f'formula = "{text(claim["formula"])}"')
    else:
        lines.append(f'name = "{name}"')
    if name == "steady":
        lines += [f'of = "{claim["of"]}"', f'eps = "{claim["eps"]}"']
    lines += [f'{key} = "{claim[key]}"' for key in ("margin", "radius", "kappa") if key in read]
    if claim["landmarks"]:
        lines.append("landmarks = [" + ", ".join(f'"{mark}"' for mark in claim["landmarks"]) + "]")
    if claim["assume"]:
        lines.append(f'assume = "{text(claim["assume"])}"')
    return "\n".join(lines) + "\n"
