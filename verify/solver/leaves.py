"""Which leaves some world state reaches.

Does: asks for each leaf of each agent: a sampled state that reaches it, else the solver; lists the dead ones as data.
Assumes: features have meanings; a leaf counts as reached only by a state that the referee takes there: a float64 state,
  in real arithmetic also a rational one.
Does not: change trees. Who drops dead leaves must ask about every state that the agents can meet, not the start region.
"""

from dataclasses import dataclass
from fractions import Fraction
from itertools import chain

import numpy as np

from codegen import ir
from codegen.ir import AgentPolicy, PolicyProfile
from verify.claims.region import Region
from verify.claims.wording import AliveLeaves
from verify.kinds import REAL
from verify.question import Budgets, DecisionQuestion, Question
from verify.result import Verdict
from verify.solver.encode import Query, reaching
from verify.solver.solve import ask, pin_model
from verify.spending import tell_of_goal
from verify.states.shares import SAMPLE_SEED, SAMPLES
from verify.states.state import State, exact_point, find_leaves, inside, leaf_at, nearest, sample, state_at
from verify.subjects import Game

SLACKS = tuple(Fraction(1, 2**power) for power in (4, 7, 10, 20, 40))  # room inside the leaf's cell, for a witness
ONLY_REAL = "only a real-valued world state was found to reach it"
ONLY_ROUNDED = "rounding within sums may take a world state there; no float64 state was found that reaches it"
MAX_TRIED = 5  # sampled states of a leaf that are looked at exactly


@dataclass(frozen=True)
class LeafFinding:
    """PROVED: reached in `witness`. VIOLATED: no world state reaches it. UNKNOWN: the budget ended, or only a
    real-valued state reaches it, which is enough in real arithmetic.
    """

    agent: str
    leaf: int
    action: str
    verdict: Verdict
    witness: State | None = None
    reason: str = ""


def dead_leaves(profile: PolicyProfile, region: Region, budget: int = Budgets().solver_units) -> dict[str, list[int]]:
    """Agent -> the leaves that no world state of `region` reaches, as proved; leaves left open are not among them.

    `budget`: solver resource units per query. InputError for features that lack meanings. An empty region reaches
    nothing, and so lists every leaf.
    """
    teams = dict.fromkeys(policy.team for policy in profile.agents)
    asked = (Question(Game(profile), AliveLeaves(team), region, budgets=Budgets(budget)) for team in teams)
    findings = [finding for question in asked for finding in leaf_findings(question)[0]]
    return {
        policy.agent: [one.leaf for one in findings if one.agent == policy.agent and one.verdict is Verdict.VIOLATED]
        for policy in profile.agents
    }


def leaf_findings(question: DecisionQuestion) -> tuple[list[LeafFinding], int]:
    """Returns what became of every leaf of the team's agents, in the trees' order, and the solver's resources spent."""
    team, region, world = question.team, question.region, question.profile.world
    coordinates, goals = sample(region, world, SAMPLES, SAMPLE_SEED)
    findings, spent = list[LeafFinding](), 0
    for policy in team:
        leaves_reached = find_leaves(policy, coordinates, world, question.semantics)
        for leaf in map(int, ir.leaves(policy.tree)):
            rows = np.flatnonzero(leaves_reached == leaf)[:MAX_TRIED]
            tried = (state_at(region, world, coordinates[row], int(goals[row])) for row in rows)
            witness = next((state for state in tried if _reaches(question, policy, leaf, state)), None)
            verdict, reason = Verdict.PROVED, ""
            if witness is None:
                verdict, witness, reason, more = _ask_leaf(question, policy, leaf)
                spent += more
            named = policy.actions[int(policy.tree.action[leaf])].name
            findings.append(LeafFinding(policy.agent, leaf, named, verdict, witness, reason))
    return findings, spent


def _ask_leaf(question: DecisionQuestion, policy: AgentPolicy, leaf: int) -> tuple[Verdict, State | None, str, int]:
    """Verdict, witness, reason and resources of one leaf, by the solver."""
    spent, reasons = 0, list[str]()
    region, semantics, budget = question.region, question.semantics, question.budgets.solver_units
    for goal in question.goals:

        def build_query(slack: Fraction = Fraction(0), goal: str | None = goal) -> Query:
            return reaching(policy, leaf, region, goal, slack, semantics)

        exact = ask(build_query(), budget)
        spent += exact.resources
        if exact.holds is False:
            continue
        if exact.holds is None:
            after = f"{exact.reason} after {exact.resources:,} resource units; {question.budgets.hint()}"
            reasons.append(tell_of_goal(goal, after))
            continue
        for answer in chain([exact], (ask(build_query(slack), budget) for slack in SLACKS)):
            spent += 0 if answer is exact else answer.resources
            state = None if answer.model is None else nearest(answer.model, region, goal)
            if state is not None and _reaches(question, policy, leaf, state):
                return Verdict.PROVED, state, "", spent
        if semantics == REAL and exact.model is not None:
            model, more = pin_model(build_query(), region, exact.model, budget)
            state = exact_point(model, region, goal)
            if not _reaches(question, policy, leaf, state):
                raise AssertionError(f"the referee does not confirm that {state} reaches leaf {leaf}")
            return Verdict.PROVED, state, "", spent + more
        reasons.append(ONLY_REAL if build_query().exact else ONLY_ROUNDED)
    if reasons:
        return Verdict.UNKNOWN, None, "; ".join(reasons), spent
    return Verdict.VIOLATED, None, "", spent


def _reaches(question: DecisionQuestion, policy: AgentPolicy, leaf: int, state: State) -> bool:
    return inside(question.region, state) and leaf_at(question.profile, policy, state, question.semantics) == leaf
