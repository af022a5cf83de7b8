"""Is this combination of leaves the only one that violates the claim?

Does: asks for a violating world state of the region in which some agent of the team reaches another leaf.
Assumes: a counterexample that the referee confirmed, in the same arithmetic.
Does not: count ways to fail, or call a state that is no float64 state one of them, but in real arithmetic.

A way to fail is what every agent of the team decides by: its leaf. "The only one" means that every violating world
state of the region takes each agent to the very leaf that it reaches in the counterexample, whatever the goal is;
around the counterexample there are still other such states (explanation.py says how far).
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from enum import Enum
from fractions import Fraction
from itertools import chain
from typing import Any

from verify.claims.region import goal_text
from verify.counterexamples.search import SLACKS, shrink, violating_samples
from verify.kinds import REAL
from verify.question import DecisionQuestion
from verify.solver.encode import Query, elsewhere, there
from verify.solver.solve import Answer, ask, pin_model
from verify.spending import tell_of_goal
from verify.states.real import write_values
from verify.states.state import State, exact_point, inside, leaves_at, nearest, violates

ONLY_REAL = "a real-valued world state fails in other leaves; no float64 state near it was found that does"
ONLY_ROUNDED = "rounding within sums may make it fail in other leaves; no float64 state was found in which it does"


class Unique(Enum):
    """The answers to whether a way to fail is the only one; the values are the words that files use."""

    ONLY = "the only one"  # proved
    OTHERS = "not the only one"  # another one was replayed
    OPEN = "not decided"


@dataclass(frozen=True)
class Uniqueness:
    """The answer to whether a counterexample's leaves are the only way to fail, and what was found."""

    answer: Unique
    goals: tuple[str | None, ...] = ()  # ONLY: those for which the claim can fail there (None without goals)
    open_goals: tuple[str | None, ...] = ()  # ONLY: goals for which this was not settled
    other: State | None = None  # OTHERS: a world state that fails in other leaves
    leaves: tuple[tuple[str, int], ...] = ()  # OTHERS: agent -> its leaf there
    reason: str = ""  # OPEN
    resources: int = 0  # of the solver

    def __str__(self) -> str:
        if self.answer is Unique.OTHERS and self.other is not None:
            leaves = ", ".join(f"{agent} in leaf {leaf}" for agent, leaf in self.leaves)
            goal = f", goal {self.other.goal}" if self.other.goal is not None else ""
            return f"other counterexamples exist, e.g. {leaves}{goal}"
        if self.answer is Unique.ONLY:
            goals = ", ".join(goal for goal in self.goals if goal is not None)
            where = f", with goal {goals}" if goals else ""
            missing = f" (not decided for goal {', '.join(map(goal_text, self.open_goals))})" if self.open_goals else ""
            return f"the only one: wherever the claim fails, the team is in these leaves{where} (proved){missing}"
        return f"not decided whether it is the only one: {self.reason}"

    def document(self) -> dict[str, Any]:
        """The finding as plain data."""
        other = None
        if self.other is not None:
            position, errors = write_values(self.other.position), write_values(self.other.errors)
            other = {
                "goal": goal_text(self.other.goal),
                "position": position,
                "errors": errors,
                "leaves": dict(self.leaves),
            }
        return {
            "answer": self.answer.value,
            "says": str(self),
            "goals": list(map(goal_text, self.goals)),
            "goals_not_decided": list(map(goal_text, self.open_goals)),
            "other": other,
            "reason": self.reason,
            "resources": self.resources,
        }


def unique(question: DecisionQuestion, state: State) -> Uniqueness:
    """Decides whether the claim fails in the region only in the leaves that the team reaches in a state.

    Looks at sampled violations first.
    """
    search = _Search(question, leaves_at(question.profile, question.claim.team, state, question.semantics))
    for candidate in violating_samples(question):
        if search.find_leaves(candidate) != search.leaves:
            return search.others(candidate)
    reasons, region, eps = list[str](), question.region, question.claim.eps
    for goal in question.goals:
        exact = search.exactly(goal)
        for answer in chain([exact], search.stronger(goal) if exact.holds else ()):
            candidate = None if answer.model is None else nearest(answer.model, region, goal, eps)
            if candidate is not None and search.fails_elsewhere(candidate):
                return search.others(candidate)
        if exact.model is not None and question.semantics == REAL:
            return search.others(search.simplify_model(goal, exact.model))
        if exact.holds is None:
            reasons.append(tell_of_goal(goal, f"{exact.reason} after {exact.resources:,} resource units"))
        if exact.holds:
            reasons.append(ONLY_REAL if search.exact else ONLY_ROUNDED)
    if reasons:
        return Uniqueness(Unique.OPEN, reason="; ".join(dict.fromkeys(reasons)), resources=search.spent)
    return search.only(state.goal)


@dataclass
class _Search:
    """The search for a state that fails in other leaves than these, and the solver's resources spent on it."""

    question: DecisionQuestion
    leaves: Mapping[str, int]
    spent: int = 0
    exact: bool = True  # as of all its queries

    def _ask(self, query: Query) -> Answer:
        self.exact = self.exact and query.exact
        answer = ask(query, self.question.budgets.solver_units)
        self.spent += answer.resources
        return answer

    def exactly(self, goal: str | None) -> Answer:
        """Asks whether the claim fails in other leaves in some real-valued state."""
        return self._ask(elsewhere(self.question, goal, self.leaves))

    def stronger(self, goal: str | None) -> Iterator[Answer]:
        """Answers with room around them."""
        for slack in SLACKS:
            yield self._ask(elsewhere(self.question, goal, self.leaves, slack))

    def simplify_model(self, goal: str | None, model: Mapping[str, Fraction]) -> State:
        """An exact model of real arithmetic as a point with few digits. AssertionError when the referee refuses it."""
        asked, units = self.question, self.question.budgets.solver_units
        pinned, spent = pin_model(elsewhere(asked, goal, self.leaves), asked.region, model, units)
        self.spent += spent
        state = exact_point(pinned, asked.region, goal)
        if not self.fails_elsewhere(state):
            raise AssertionError(f"{asked.claim.name}: the referee does not confirm that {state} fails elsewhere")
        return state

    def find_leaves(self, state: State) -> dict[str, int]:
        """Agent -> the leaf that it reaches."""
        return leaves_at(self.question.profile, self.question.claim.team, state, self.question.semantics)

    def fails_elsewhere(self, state: State) -> bool:
        """The referee's word."""
        fails = inside(self.question.region, state) and violates(self.question, state)
        within = all(abs(Fraction(error)) <= self.question.claim.eps for error in state.errors.values())
        return fails and within and self.find_leaves(state) != self.leaves

    def others(self, state: State) -> Uniqueness:
        """The finding that a state fails elsewhere."""
        leaves = self.find_leaves(state)
        simpler = shrink([self.question], state, lambda one: self.find_leaves(one) == leaves)
        return Uniqueness(Unique.OTHERS, other=simpler, leaves=tuple(leaves.items()), resources=self.spent)

    def only(self, goal: str | None) -> Uniqueness:
        """The finding that none does. `goal`: of the counterexample."""
        goals, missing = [goal], list[str | None]()
        for other in self.question.goals:
            if other != goal:
                answer = self._ask(there(self.question, other, self.leaves))
                certain = answer.holds is False or (answer.holds and self.exact)
                goals += [other] if answer.holds and certain else []
                missing += [] if certain else [other]
        return Uniqueness(Unique.ONLY, goals=tuple(goals), open_goals=tuple(missing), resources=self.spent)
