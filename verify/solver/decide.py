"""The bare decision of a claim by Z3.

Does: asks goal by goal; says whether the claim is about any world state at all.
Assumes: claims about single decisions.
Does not: confirm counterexamples or compare engines.
"""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

from verify.claims.formula import TRUE
from verify.question import Case, DecisionQuestion
from verify.result import Verdict
from verify.solver.budget import beyond_any
from verify.solver.encode import Query, query, region_only
from verify.solver.solve import Answer, ask
from verify.unanswered import tell_of_goal


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
            open_reasons.append(_open(question, goal, answer, used, answered[goal]))
    if open_reasons:
        hint = "smaller trees may be decided" if beyond else question.budgets.hint()
        return SolverDecision(Verdict.UNKNOWN, spent, reason=f"{'; '.join(open_reasons)}; {hint}")
    return SolverDecision(Verdict.PROVED, spent)


def _open(question: DecisionQuestion, goal: str | None, answer: Answer, spent: int, answered: int) -> str:
    """Why there is no answer for a goal, whose parts share its budget. `answered`: how many of the parts were."""
    parts = len(question.parts)
    after = f" and {answered} of {parts} parts" if parts > 1 else ""
    return tell_of_goal(goal, f"{answer.reason or 'the budget ended'} after {spent:,} resource units{after}")


def about_nothing(question: DecisionQuestion) -> tuple[str, int]:
    """Why the claim speaks of no world state, or "" if it does; and the resources spent."""
    anything = ask(region_only(question.region), question.budgets.solver_units)
    if anything.holds is False:
        return "the region holds no world state", anything.resources
    if question.claim.assume == TRUE:
        return "", anything.resources
    met = _meeting(question)
    spent = anything.resources + sum(answer.resources for answer in met)
    if all(answer.holds is False for answer in met):
        return "no world state of the region meets the assumption", spent
    return "", spent


def _meeting(question: DecisionQuestion) -> list[Answer]:
    """For each goal, whether some world state of the region meets the assumption."""
    region, assume, units = question.region, question.claim.assume, question.budgets.solver_units
    return [ask(region_only(region, assume, goal), units) for goal in question.goals]
