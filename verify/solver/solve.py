"""Asking Z3, with a budget that does not depend on the machine: one query, a claim goal by goal, or each leaf.

Does: decides a question, returns an exact model or the reason why there is no answer; decides a claim, and says whether
  it is about any world state at all; settles the coordinates of a model one after another, as simply as the question
  allows; finds for each leaf a sampled state that reaches it, or else asks; lists the dead ones as data.
Assumes: budgets are Z3 resource counts, which repeat from run to run; there is no wall clock; claims are about single
  decisions. A leaf counts as reached only by a state that the referee takes there: a float64 state, in real arithmetic
  also a rational one.
Does not: confirm counterexamples, judge states (states/real.py), compare engines, or change trees. Who drops dead
  leaves must ask about every state that the agents can meet, not the start region.
"""

import math
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import chain
from typing import cast

import numpy as np
import z3

from codegen import ir
from codegen.ir import AgentPolicy, PolicyProfile
from verify.claims.formula import TRUE
from verify.claims.region import Interval, Region
from verify.claims.wording import AliveLeaves
from verify.kinds import REAL
from verify.question import Budgets, Case, DecisionQuestion, Question
from verify.result import Verdict
from verify.solver.encode import Query, beyond_any, fix_variables, query, reaching, region_only
from verify.spending import tell_of_goal
from verify.states.real import value_of
from verify.states.shares import SAMPLE_SEED, SAMPLES
from verify.states.state import State, exact_point, find_leaves, inside, leaf_at, nearest, sample, state_at
from verify.subjects import Game


@dataclass(frozen=True)
class Answer:
    """`holds` is True (satisfiable), False (not) or None (budget ended); `model` gives every position exactly."""

    holds: bool | None
    model: dict[str, Fraction] | None
    resources: int
    reason: str = ""


def solver_name() -> str:
    """The solver and its version."""
    return f"Z3 {z3.get_version_string()}"


@dataclass(frozen=True)
class BitsAnswer:
    """An answer like Answer, whose `model` gives constants of bits, as unsigned numbers."""

    holds: bool | None
    model: dict[str, int] | None
    resources: int
    reason: str = ""


def ask(query: Query, budget: int = Budgets().solver_units) -> Answer:
    """Asks whether the question's constraints can hold together; no answer where they were not written."""
    if query.beyond:
        return Answer(None, None, 0, query.beyond)
    context = z3.Context()  # a fresh one, so that earlier questions leave no trace in the search or the count
    constraints = [constraint.translate(context) for constraint in query.constraints]
    holds, model, spent, reason = _run_solver("QF_LRA", context, constraints, budget)
    if model is None:
        return Answer(holds, None, spent, reason)
    variables = {name: variable.translate(context) for name, variable in query.variables.items()}
    # the numbers in models of linear arithmetic are rationals
    values = {
        name: cast(z3.RatNumRef, model.eval(variable, model_completion=True)) for name, variable in variables.items()
    }
    exact = {name: Fraction(value.numerator_as_long(), value.denominator_as_long()) for name, value in values.items()}
    return Answer(True, exact, spent)


def ask_bits(text: str, names: Sequence[str], budget: int = Budgets().solver_units) -> BitsAnswer:
    """Asks whether the assertions of an SMT-LIB text about floats and bits can hold together; the model gives the
    constants `names`, 0 for what does not matter.
    """
    context = z3.Context()
    holds, model, spent, reason = _run_solver("QF_FPBV", context, z3.parse_smt2_string(text, ctx=context), budget)
    if model is None:
        return BitsAnswer(holds, None, spent, reason)
    values = {constant.name(): cast(z3.BitVecNumRef, model[constant]) for constant in model.decls()}
    return BitsAnswer(True, {name: values[name].as_long() if name in values else 0 for name in names}, spent)


def _run_solver(
    logic: str, context: z3.Context, constraints: Sequence[z3.BoolRef] | z3.AstVector, budget: int
) -> tuple[bool | None, z3.ModelRef | None, int, str]:
    """Satisfiable or not (None: budget ended), a model, resources spent, and why there is no answer."""
    solver = z3.SolverFor(logic, ctx=context)
    solver.set("rlimit", budget)
    solver.set("random_seed", 0)
    solver.add(*constraints)
    result = solver.check()
    statistics = solver.statistics()
    spent = int(statistics.get_key_value("rlimit count")) if "rlimit count" in statistics.keys() else 0  # noqa: SIM118
    if result == z3.unknown and "interrupted" in solver.reason_unknown():
        raise KeyboardInterrupt  # Ctrl-C during the search, which the solver catches itself
    if result == z3.unknown:
        return None, None, spent, solver.reason_unknown()
    return result == z3.sat, solver.model() if result == z3.sat else None, spent, ""


def smt_lib(query: Query) -> str:
    """The question as SMT-LIB 2, for any solver; equal questions give equal texts. Not for one that was not written."""
    assert not query.beyond, query.beyond
    context, known = z3.Context(), dict[int, tuple[z3.ExprRef, z3.ExprRef]]()
    solver = z3.SolverFor("QF_LRA", ctx=context)
    standard = [_standard(constraint.translate(context), known) for constraint in query.constraints]
    solver.add(*cast("list[z3.BoolRef]", standard))
    return solver.to_smt2()


_JOINED: dict[int, Callable[..., z3.ExprRef]] = {z3.Z3_OP_AND: z3.And, z3.Z3_OP_OR: z3.Or, z3.Z3_OP_ADD: z3.Sum}


def _standard(term: z3.ExprRef, known: dict[int, tuple[z3.ExprRef, z3.ExprRef]]) -> z3.ExprRef:
    """The term without sums, conjunctions and disjunctions of fewer than two parts, which SMT-LIB does not have.

    `known`: terms by their ids, which stay theirs while they are kept, and what became of them.
    """
    place = term.get_id()
    if place not in known:
        before, kind = term.children(), term.decl().kind()
        parts = [_standard(part, known) for part in before]
        if kind in _JOINED and len(parts) < 2:
            made = parts[0] if parts else z3.BoolVal(kind == z3.Z3_OP_AND, ctx=term.ctx)
        elif [part.get_id() for part in parts] == [part.get_id() for part in before]:
            made = term
        else:
            made = _JOINED.get(kind, term.decl())(*parts)
        known[place] = term, made
    return known[place][1]


def false_facts(definitions: str, facts: Sequence[str]) -> list[int]:
    """Lists, by place, those SMT-LIB formulas without variables that do not hold, given definitions."""
    text = definitions + "\n".join(f"(assert {fact})" for fact in facts)
    parsed = z3.parse_smt2_string(text, ctx=z3.Context())
    return [place for place in range(len(parsed)) if not z3.is_true(z3.simplify(parsed[place]))]


@dataclass(frozen=True)
class SolverDecision:
    """The solver's answer over all goals: the verdict, and for VIOLATED the goal and the model."""

    verdict: Verdict
    resources: int
    goal: str | None = None
    answer: Answer | None = None
    reason: str = ""
    part: DecisionQuestion | None = None  # of the question, that the answer is about
    exact: bool = True  # as of the query: else the answer may be no violation


def decide(question: DecisionQuestion, cases: Sequence[Case] | None = None) -> SolverDecision:
    """The bare decision, by Z3. `cases`: only these of the question's. InputError where the team cannot be asked
    about.
    """
    _ = question.team
    nothing, spent = about_nothing(question)
    if nothing:
        return SolverDecision(Verdict.VACUOUS, spent, reason=nothing)
    open_reasons, beyond = list[str](), False
    asking = question.cases if cases is None else list(cases)
    left, answered = dict.fromkeys(question.goals, question.budgets.solver_units), Counter[str | None]()
    alike: dict[int, tuple[Query, Answer]] = {}  # by part: what was asked for the goal before, where all are the same
    for place, (goal, part) in enumerate(asking):
        if left[goal] <= 0:
            continue
        if id(part) in alike:
            asked, answer = alike[id(part)]
        else:
            asked = query(part.spending(solver_units=left[goal]), goal)
            answer = ask(asked, left[goal])
        if not question.names_goal:
            alike[id(part)] = asked, answer
        spent, left[goal] = spent + answer.resources, left[goal] - answer.resources
        if answer.holds:
            return SolverDecision(Verdict.VIOLATED, spent, goal, answer, part=part, exact=asked.exact)
        answered[goal] += answer.holds is False
        cut_off = left[goal] <= 0 and any(later == goal for later, _ in asking[place + 1 :])
        beyond = beyond or (bool(asked.beyond) and beyond_any(part))
        if answer.holds is None or cut_off:
            used = question.budgets.solver_units - left[goal]
            parts = len(question.parts)  # which share the budget of a goal
            after = f"{used:,} resource units" + (f" and {answered[goal]} of {parts} parts" if parts > 1 else "")
            open_reasons.append(tell_of_goal(goal, f"{answer.reason or 'the budget ended'} after {after}"))
    if open_reasons:
        hint = "smaller trees may be decided" if beyond else question.budgets.hint()
        return SolverDecision(Verdict.UNKNOWN, spent, reason=f"{'; '.join(open_reasons)}; {hint}")
    return SolverDecision(Verdict.PROVED, spent)


def about_nothing(question: DecisionQuestion) -> tuple[str, int]:
    """Why the claim speaks of no world state, or "" if it does; and the resources spent."""
    anything = ask(region_only(question.region), question.budgets.solver_units)
    if anything.holds is False:
        return "the region holds no world state", anything.resources
    if question.claim.assume == TRUE:
        return "", anything.resources
    assume, units = question.claim.assume, question.budgets.solver_units
    met = [ask(region_only(question.region, assume, goal), units) for goal in question.goals]
    spent = anything.resources + sum(answer.resources for answer in met)
    if all(answer.holds is False for answer in met):
        return "no world state of the region meets the assumption", spent
    return "", spent


BITS = (0, 1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 44, 52)  # behind the binary point
DENOMINATORS = (10, 100, 1_000)
MAX_ASKED = 100  # questions an order


def pin_model(
    question: Query, region: Region, model: Mapping[str, Fraction], budget: int
) -> tuple[dict[str, Fraction], int]:
    """A model of the question, of float64 numbers where such a one was found, and the resource units spent.

    `budget`: solver resource units per query.
    """
    spent, tries, names = 0, list[dict[str, Fraction]](), list(region.box)
    for order in (names, names[::-1]):
        pinned, units = _in_order(order, question, region, model, budget)
        spent += units
        if all(isinstance(value_of(pinned[name]), float) for name in names):
            return pinned, spent
        tries.append(pinned)
    return tries[0], spent


def _in_order(
    order: Sequence[str], question: Query, region: Region, model: Mapping[str, Fraction], budget: int
) -> tuple[dict[str, Fraction], int]:
    """Pins a model as `pin_model` does, coordinates in this order."""
    pinned, values, spent, queries = dict(model), dict[str, Fraction](), 0, 0
    for name in order:
        for value in _simpler(pinned[name], region.box[name]):
            if queries == MAX_ASKED:
                break
            queries += 1
            answer = ask(fix_variables(question, values | {name: value}), budget)
            spent += answer.resources
            if answer.model is not None:
                pinned = answer.model
                break
        values[name] = pinned[name]
    return pinned, spent


def _simpler(value: Fraction, bounds: Interval) -> Iterator[Fraction]:
    """Numbers near a value, the simplest first, until the value itself is one."""
    low, high = bounds
    near = [value.limit_denominator(most) for most in DENOMINATORS]
    beside = (Fraction(side(value * 2**bits), 2**bits) for bits in BITS for side in (round, math.floor, math.ceil))
    for simple in dict.fromkeys([*beside, *near]):
        if simple == value:
            return
        if low <= simple <= high:
            yield simple


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
