"""Random questions about decisions: a team, a claim, a region and an arithmetic, for judge and verifier.

Does: draws a question from its seed; writes its claim and region as a property file, as a user would.
Assumes: teams as teams.py makes them.
Does not: decide. What holds is for the judge to say.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

import numpy as np

from codegen import ir, policy_json
from codegen.ir import PolicyProfile
from tests.hunting import regions, teams
from tests.hunting.places import Case
from tests.hunting.reading import MACHINE, REAL, read
from tests.support.strategies import with_trees
from tests.support.teams import nested
from verify.claims.files import read_properties
from verify.claims.region import Region
from verify.question import Budgets, DecisionQuestion, Question
from verify.subjects import Game

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


def claim_of(rng: np.random.Generator, profile: PolicyProfile, team: str) -> dict[str, Any]:
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


NODES, UNITS = 200_000, 10_000_000  # what a question may cost; few reach it


@dataclass(frozen=True)
class Asked:
    """A question from its seed, both ways."""

    seed: int
    case: Case  # for the judge
    question: DecisionQuestion  # for the verifier
    source: str  # the property file
    twin: ir.PolicyProfile  # the same team before it was changed, or itself

    @property
    def depth(self) -> int:
        """Of the team's deepest tree."""
        return max(agent.depth for agent in self.case.team)


def team_of(rng: np.random.Generator, profile: ir.PolicyProfile, claim: Mapping[str, Any]) -> Any:
    """(profile, twin): a team with trees of some kind, and the team before a last change."""
    policies, marks = profile.team(claim["team"]), [mark.name for mark in profile.world.landmarks]
    eps, radius = claim["eps"], claim["radius"]
    low, high = float(claim["margin"] + eps) + 0.001, float(radius - eps) - 0.001
    room = (low, high) if low < high else (0.01, 0.05)
    if rng.random() < 0.04:  # a test at the radius itself, which machine arithmetic rounds
        room = (float(radius), float(radius))
    kind, trees = rng.random(), dict[str, ir.Tree]()
    if kind < 0.14:
        trees = {one.agent: nested(teams.wild(rng, one, int(rng.integers(3, 6)))) for one in policies}
    elif kind < 0.34 and len(policies) == 2 and profile.world.goals:
        nodes = teams.switching(rng, policies, marks, room)
        trees = {one.agent: nested(node) for one, node in zip(policies, nodes, strict=True)}
    else:
        order = rng.permutation(len(marks)) if rng.random() < 0.3 else np.arange(len(marks))
        for number, one in enumerate(policies):
            extra = int(rng.choice([0, 1, 1, 2]))
            trees[one.agent] = nested(teams.role(rng, one, marks[order[number]], extra, room))
    whole = with_trees(trees, profile)
    if kind < 0.14 or rng.random() < 0.78:
        return whole, whole
    one = policies[int(rng.integers(len(policies)))]
    wrong = teams.changed(rng, trees[one.agent], len(one.actions))
    return with_trees({one.agent: wrong}, whole), whole


def drawn(seed: int, doubled: bool = False) -> Asked:
    """The question of a seed. `doubled`: some agents compare float64."""
    rng = np.random.default_rng([seed, 0])
    names, weights = list(teams.WORLDS), np.array(list(teams.WORLDS.values()), dtype=float)
    world = str(rng.choice(names, p=weights / weights.sum()))
    profile = teams.bare(world)
    team = teams.TEAMS[world.split(",")[0]]
    claim = claim_of(rng, profile, team)
    semantics = REAL if rng.random() < 0.12 else MACHINE
    made, twin = team_of(rng, profile, claim)
    if doubled:
        made, twin = teams.doubled(np.random.default_rng([seed, 64]), made, twin)
    if rng.random() < (0.3 if semantics == REAL else 0.02) and (found := regions.sliver(rng, made, team)):
        region, agent, action = found
        claim |= {"name": "formula", "of": "", "eps": Fraction(0), "assume": None, "landmarks": (), "mixed": False}
        claim["formula"] = ("not", ("acts", agent, action))
        return asked(seed, made, twin, claim, region, semantics)
    region = regions.drawn(rng, made, team, 0.3 if semantics == REAL else 0.06)
    return asked(seed, made, twin, claim, region, semantics)


def asked(
    seed: int,
    profile: ir.PolicyProfile,
    twin: ir.PolicyProfile,
    claim: Mapping[str, Any],
    region: Mapping[str, Any],
    semantics: str,
) -> Asked:
    """A question from its parts. The verifier reads the claim and the region from a property file."""
    case = Case(read(policy_json.dumps(profile)), claim, region, semantics)
    source = property_file(claim, regions.table(region))
    (stated,) = read_properties(source, profile, "hunt", _no_file)
    question = Question(
        Game(profile), stated.claim, stated.region, semantics, Budgets(solver_units=UNITS, max_nodes=NODES)
    )
    return Asked(seed, case, question, source, twin)


def of_twin(asked_: Asked) -> Asked:
    """The question about the team before its last change."""
    return replace(asked_, question=asked_.question.of(asked_.twin))


def _no_file(name: str) -> Region:
    raise LookupError(name)
