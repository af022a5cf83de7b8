"""Random questions about decisions: a team, a claim, a region and an arithmetic, for judge and verifier.

Does: draws a question from its seed; writes its claim and region as a property file, as a user would.
Assumes: teams as teams.py makes them.
Does not: decide. What holds is for the judge to say.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

import numpy as np

from codegen import ir, policy_json
from tests.hunting import claims, regions, teams
from tests.hunting.places import Case
from tests.hunting.reading import MACHINE, REAL, read
from tests.support.strategies import with_trees
from tests.support.teams import nested
from verify.claims.files import read_properties
from verify.claims.region import Region
from verify.question import Budgets, DecisionQuestion, Question
from verify.subjects import Game

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
    claim = claims.drawn(rng, profile, team)
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
    source = claims.property_file(claim, regions.table(region))
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
