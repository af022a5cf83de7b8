"""Whether a claim also fails elsewhere than where its counterexample takes the team: the other ways to fail.

Does: asks for a violating world state of the region in which some agent of the team reaches another leaf.
Assumes: a counterexample that the referee confirmed; the deployed arithmetic.
Does not: count ways to fail, or call a real-valued state one of them when no float64 state near it replays.

A way to fail is what every agent of the team decides by: its leaf. "The only one" means that every violating world
state of the region takes each agent to the very leaf that it reaches in the counterexample, whatever the goal is;
around the counterexample there are still other such states (explanation.py says how far).
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from enum import Enum
from fractions import Fraction
from typing import Any

from codegen import ir
from codegen.ir import PolicyProfile
from verify.counterexample import SLACKS, shrink, violating_samples
from verify.encode import elsewhere, there
from verify.properties import Property
from verify.solve import Answer, ask
from verify.spec import Region
from verify.world import Point, inside, nearest, observed, violates

ONLY_REAL = "a real-valued world state fails in other leaves; no float64 state beside it was found to"


class Unique(Enum):
    """Whether a way to fail is the only one; the values are the words that files use."""

    ONLY = "the only one"  # proved
    OTHERS = "not the only one"  # another one was replayed
    OPEN = "not decided"


@dataclass(frozen=True)
class Uniqueness:
    """Whether a counterexample's leaves are the only way to fail, and what was found."""

    answer: Unique
    goals: tuple[str, ...] = ()  # ONLY: the goals for which the claim can fail there ("" without goals)
    open_goals: tuple[str, ...] = ()  # ONLY: goals for which the budget ended before this was known
    other: Point | None = None  # OTHERS: a world state that fails in other leaves
    leaves: tuple[tuple[str, int], ...] = ()  # OTHERS: agent -> its leaf there
    reason: str = ""  # OPEN
    resources: int = 0  # of the solver

    def __str__(self) -> str:
        if self.answer is Unique.OTHERS and self.other is not None:
            leaves = ", ".join(f"{agent} in leaf {leaf}" for agent, leaf in self.leaves)
            goal = f", goal {self.other.goal}" if self.other.goal else ""
            return f"not the only one: the claim also fails with {leaves}{goal}"
        if self.answer is Unique.ONLY:
            goals = ", ".join(goal for goal in self.goals if goal)
            where = f", with goal {goals}" if goals else ""
            missing = f" (not decided for goal {', '.join(self.open_goals)})" if self.open_goals else ""
            return f"the only one: wherever the claim fails, the team is in these leaves{where} (proved){missing}"
        return f"not decided whether it is the only one: {self.reason}"

    def document(self) -> dict[str, Any]:
        """The finding as plain data."""
        other = None
        if self.other is not None:
            position, errors = dict(self.other.position), dict(self.other.errors)
            other = {"goal": self.other.goal, "position": position, "errors": errors, "leaves": dict(self.leaves)}
        return {
            "answer": self.answer.value,
            "says": str(self),
            "goals": list(self.goals),
            "goals_not_decided": list(self.open_goals),
            "other": other,
            "reason": self.reason,
            "resources": self.resources,
        }


def taken(profile: PolicyProfile, team: str, point: Point) -> dict[str, int]:
    """Agent -> the leaf that it reaches in a world state."""
    return {
        policy.agent: int(ir.apply(policy.tree, observed(profile, policy, point))[0]) for policy in profile.team(team)
    }


def unique(profile: PolicyProfile, claim: Property, region: Region, point: Point, budget: int) -> Uniqueness:
    """Whether the leaves that the team reaches at `point` are the only ones in which the claim fails in the region.

    Looks at sampled violations first. `budget`: solver resource units a query.
    """
    leaves = taken(profile, claim.team, point)
    for candidate in violating_samples(profile, claim, region):
        if taken(profile, claim.team, candidate) != leaves:
            return _others(profile, claim, region, candidate, 0)
    spent, reasons = 0, list[str]()
    for goal in region.goals or ("",):
        for answer, slack in _answers(profile, claim, region, goal, leaves, budget):
            spent += answer.resources
            candidate = None if answer.model is None else nearest(answer.model, region, goal, claim.eps)
            if candidate is not None and _fails_elsewhere(profile, claim, region, candidate, leaves):
                return _others(profile, claim, region, candidate, spent)
            if not slack and answer.holds is None:
                reasons.append(f"goal {goal or 'none'}: {answer.reason} after {answer.resources} resource units")
            if not slack and answer.holds:
                reasons.append(ONLY_REAL)
    if reasons:
        return Uniqueness(Unique.OPEN, reason="; ".join(dict.fromkeys(reasons)), resources=spent)
    found, missing = [point.goal], list[str]()
    for goal in region.goals or ("",):
        if goal != point.goal:
            answer = ask(there(profile, claim, region, goal, leaves), budget)
            spent += answer.resources
            found += [goal] if answer.holds else []
            missing += [goal] if answer.holds is None else []
    return Uniqueness(Unique.ONLY, goals=tuple(found), open_goals=tuple(missing), resources=spent)


def _answers(
    profile: PolicyProfile, claim: Property, region: Region, goal: str, leaves: Mapping[str, int], budget: int
) -> Iterator[tuple[Answer, Fraction]]:
    """The exact answer, and when there is a real-valued state answers with room around them, each with its slack."""
    exact = ask(elsewhere(profile, claim, region, goal, leaves), budget)
    yield exact, Fraction(0)
    if exact.holds:
        for slack in SLACKS:
            yield ask(elsewhere(profile, claim, region, goal, leaves, slack), budget), slack


def _fails_elsewhere(
    profile: PolicyProfile, claim: Property, region: Region, point: Point, leaves: Mapping[str, int]
) -> bool:
    fails = inside(region, point) and violates(profile, claim, point)
    within = all(abs(Fraction(error)) <= claim.eps for error in point.errors.values())
    return fails and within and taken(profile, claim.team, point) != leaves


def _others(profile: PolicyProfile, claim: Property, region: Region, point: Point, spent: int) -> Uniqueness:
    leaves = taken(profile, claim.team, point)
    simpler = shrink(profile, claim, region, point, lambda one: taken(profile, claim.team, one) == leaves)
    return Uniqueness(Unique.OTHERS, other=simpler, leaves=tuple(leaves.items()), resources=spent)
