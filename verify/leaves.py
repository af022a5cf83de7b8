"""Which leaves some world state reaches.

Does: asks for each leaf of each agent: a sampled state that reaches it, else the solver; lists the dead ones as data.
Assumes: features have meanings; a leaf counts as reached only by a float64 state that the reference takes there.
Does not: change trees. Who drops dead leaves must ask about every state that the agents can meet, not the start box.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from codegen import ir
from codegen.ir import AgentPolicy, PolicyProfile
from codegen.observe import observe
from verify.encode import reaching
from verify.shares import SAMPLE_SEED, SAMPLES
from verify.solve import DEFAULT_BUDGET, Answer, ask
from verify.spec import Region, Verdict
from verify.world import Point, inside, nearest, observed, point_of, sample, verifiable

SLACKS = tuple(Fraction(1, 2**power) for power in (4, 7, 10, 20, 40))  # room inside the leaf's cell, for a witness
MOST_TRIED = 5  # sampled states of a leaf that are looked at exactly


@dataclass(frozen=True)
class LeafFinding:
    """PROVED: reached in `witness`. VIOLATED: no world state reaches it. UNKNOWN: the budget ended, or only a
    real-valued state reaches it.
    """

    agent: str
    leaf: int
    action: str
    verdict: Verdict
    witness: Point | None = None
    reason: str = ""


def dead_leaves(profile: PolicyProfile, region: Region, budget: int = DEFAULT_BUDGET) -> dict[str, list[int]]:
    """Agent -> the leaves that no world state of `region` reaches, as proved; leaves left open are not among them.

    `budget`: solver resource units a query. InputError for features that lack meanings. An empty region reaches
    nothing, and so lists every leaf.
    """
    teams = dict.fromkeys(policy.team for policy in profile.agents)
    found = [finding for team in teams for finding in leaf_findings(profile, team, region, budget)[0]]
    return {
        policy.agent: [one.leaf for one in found if one.agent == policy.agent and one.verdict is Verdict.VIOLATED]
        for policy in profile.agents
    }


def leaf_findings(
    profile: PolicyProfile, team: str, region: Region, budget: int = DEFAULT_BUDGET
) -> tuple[list[LeafFinding], int]:
    """What became of every leaf of a team's agents, in the trees' order, and the solver's resources spent."""
    policies = verifiable(profile, team)
    coordinates, goals = sample(region, profile.world, SAMPLES, SAMPLE_SEED)
    findings, spent = [], 0
    for policy in policies:
        reached = ir.apply(policy.tree, observe(policy.features, coordinates, profile.world))
        for leaf in map(int, ir.leaves(policy.tree)):
            rows = np.flatnonzero(reached == leaf)[:MOST_TRIED]
            tried = (point_of(region, profile.world, coordinates[row], int(goals[row])) for row in rows)
            witness = next((point for point in tried if _reaches(profile, policy, leaf, region, point)), None)
            verdict, reason = Verdict.PROVED, ""
            if witness is None:
                verdict, witness, reason, more = _asked(profile, policy, leaf, region, budget)
                spent += more
            named = policy.actions[int(policy.tree.action[leaf])].name
            findings.append(LeafFinding(policy.agent, leaf, named, verdict, witness, reason))
    return findings, spent


def _asked(
    profile: PolicyProfile, policy: AgentPolicy, leaf: int, region: Region, budget: int
) -> tuple[Verdict, Point | None, str, int]:
    """Verdict, witness, reason and resources of one leaf, by the solver."""
    spent, reasons = 0, []
    for goal in region.goals or ("",):
        exact = ask(reaching(profile, policy.agent, leaf, region, goal), budget)
        spent += exact.resources
        if exact.holds is False:
            continue
        if exact.holds is None:
            reasons.append(f"goal {goal or 'none'}: {exact.reason} after {exact.resources} resource units")
            continue
        for answer in _answers(profile, policy.agent, leaf, region, goal, budget, exact):
            spent += 0 if answer is exact else answer.resources
            point = None if answer.model is None else nearest(answer.model, region, goal)
            if point is not None and _reaches(profile, policy, leaf, region, point):
                return Verdict.PROVED, point, "", spent
        reasons.append("only a real-valued world state was found to reach it")
    if reasons:
        return Verdict.UNKNOWN, None, "; ".join(reasons), spent
    return Verdict.VIOLATED, None, "", spent


def _answers(
    profile: PolicyProfile, agent: str, leaf: int, region: Region, goal: str, budget: int, exact: Answer
) -> Iterator[Answer]:
    """The model at hand, then models with room around them."""
    yield exact
    for slack in SLACKS:
        yield ask(reaching(profile, agent, leaf, region, goal, slack), budget)


def _reaches(profile: PolicyProfile, policy: AgentPolicy, leaf: int, region: Region, point: Point) -> bool:
    return inside(region, point) and int(ir.apply(policy.tree, observed(profile, policy, point))[0]) == leaf
