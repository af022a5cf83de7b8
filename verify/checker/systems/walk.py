"""Walks proofs about stated systems: every branch of a fixed search is closed by a sum of inequalities.

Does: the search that README.md specifies; the answers that a proof gives in it, each checked.
Assumes: proofs of the form that README.md specifies, made by anyone.
Does not: prove. It knows no linear program and no engine; whoever makes a proof answers the same search.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator
from enum import IntEnum
from fractions import Fraction

from codegen.ir import PolicyProfile
from verify.checker.reading import RejectedError
from verify.checker.systems.cases import has_cases, hull_of
from verify.checker.systems.proofs import FollowedPart, Hull
from verify.checker.systems.reading import Condition, Effect, Every, Inequality, SystemReading
from verify.checker.systems.rows import Branch, Row
from verify.checker.systems.trees import Choices, Decision, Split, decisions
from verify.claims.formula import (
    FALSE,
    TRUE,
    Formula,
    Or,
    agents,
    below,
    conjunction,
    disjunction,
    negate,
    substitute_actions,
)
from verify.systems.claims import SystemClaim, atom
from verify.systems.system import Affine, Box, HalfSpace, Polytope, System, Variable

Decided = tuple[Branch, tuple[Effect, ...]]


class SideAnswer(IntEnum):
    """The side of a question that has states of a branch."""

    BOTH = 0  # or it is not known
    NOT_THIS = 1  # none for which the inequality holds
    ALL_THIS = 2  # none for which its opposite holds
    NEITHER = 3  # none at all


class Answers(ABC):
    """The source of the answers to a search's questions."""

    @abstractmethod
    def visit(self, branch: Branch) -> None:
        """Called with each symbolic state, before anything is asked of it."""

    @abstractmethod
    def side(self, branch: Branch, row: Row) -> SideAnswer:
        """Returns whether a row, or its opposite, has states of a branch."""

    @abstractmethod
    def hull(self, branch: Branch) -> int | None:
        """The number of the hull that a branch lies in, with which the search goes on instead; None for no hull."""

    @abstractmethod
    def asks_fulfilled(self, branch: Branch) -> bool:
        """Returns True if the states of a branch that fulfil the claim are told apart from the others."""

    @abstractmethod
    def leave_open(self, branch: Branch, stated: bool) -> None:
        """Called with states that break the claim, or for which nothing is stated. Raises where that is a failure."""


class Proof(Answers):
    """The answers of a proof. RejectedError for one that does not hold."""

    def __init__(self, numbers: Iterator[int]) -> None:
        self._numbers = numbers
        self.closed = 0

    def side(self, branch: Branch, row: Row) -> SideAnswer:
        """Reads the answer from the proof, with a sum of rows that shows it."""
        answer = self._number()
        if answer > SideAnswer.NEITHER:
            raise RejectedError(f"after {self.closed} closed branches: {answer} is no answer")
        if answer != SideAnswer.BOTH:
            aside = (
                []
                if answer == SideAnswer.NEITHER
                else [(row if answer == SideAnswer.NOT_THIS else row.opposite(), self._times())]
            )
            self._ensure_empty(branch, aside)
        return SideAnswer(answer)

    def visit(self, branch: Branch) -> None:
        """Nothing is read."""

    def hull(self, branch: Branch) -> int | None:
        """Reads the hull from the proof."""
        number = self._number()
        return number - 1 if number else None

    def asks_fulfilled(self, branch: Branch) -> bool:
        """Reads the answer from the proof."""
        return self._number() > 0

    def leave_open(self, branch: Branch, stated: bool) -> None:
        """A proof leaves nothing open: RejectedError."""
        raise RejectedError(f"after {self.closed} closed branches one is left open at step {branch.step}")

    def ensure_read(self) -> None:
        """RejectedError unless the proof ends here."""
        if next(self._numbers, None) is not None:
            raise RejectedError("the proof goes on after its end")

    def _ensure_empty(self, branch: Branch, used: list[tuple[Row, int]]) -> None:
        place = -1
        for _ in range(self._number()):
            place += 1 + self._number()
            if place >= len(branch.rows):
                raise RejectedError(f"after {self.closed} closed branches: the branch has no row {place}")
            used.append((branch.rows[place], self._times()))
        if not branch.is_contradicted(used):
            raise RejectedError(
                f"after {self.closed} closed branches: the rows at step {branch.step} do not contradict"
            )
        self.closed += 1

    def _times(self) -> int:
        times = self._number()
        if not times:
            raise RejectedError(f"after {self.closed} closed branches: a row is taken 0 times")
        return times

    def _number(self) -> int:
        number = next(self._numbers, None)
        if number is None:
            raise RejectedError("the proof ends too early")
        return number


def ways(claim: SystemClaim) -> int:
    """In how many ways a state may break the claim: the parts of which one has to hold. The number of leaving what is
    stated comes after them.
    """
    return 1 if claim.about_decisions else len(_parts(claim.violation_at(claim.steps)))


def _parts(formula: Formula) -> tuple[Formula, ...]:
    return formula.parts if isinstance(formula, Or) else (formula,)


class SystemQuestions:
    """The questions about some parts of a claim, in their fixed order."""

    def __init__(
        self, profile: PolicyProfile, system: System, claim: SystemClaim, part: FollowedPart, answers: Answers
    ) -> None:
        self.claim, self.answers, self.system = claim, answers, system
        self.reading = SystemReading(system, part.followed)
        self.hulls = part.hulls
        self._conditions: dict[int, Condition] = {}
        self._shows = part.shows
        self.policies = profile.agents
        if claim.about_decisions:
            speaking = agents(claim.formula)
            self.policies = tuple(policy for policy in profile.agents if policy.agent in speaking)
        self.decisions = decisions(system, self.reading, self.policies, claim.about_decisions)
        held = [conjunction(*map(atom, (*box_of(piece.where), *piece.when))) for piece in system.pieces]
        self._pieces = [self.reading.condition(each) for each in held]
        stated = conjunction(*map(atom, box_of(hull_of(system)))) if has_cases(system) else disjunction(*held)
        unstated = negate(stated) if ways(claim) in part.shows else FALSE
        self._unstated = self.reading.condition(unstated)
        self.visited = 0

    def run(self) -> None:
        """Asks everything: from the start, then from each hull."""
        for root in self.roots():
            pending = [root]
            while pending:
                branch = pending.pop()
                self.answers.visit(branch)
                number = self.answers.hull(branch) if self.hulls and branch is not root else None
                if number is None:
                    pending += reversed(self.follow_branch(branch))
                else:
                    self.ensure_within(branch, number)

    def roots(self) -> Iterator[Branch]:
        """The start, and each hull, as symbolic states; without those that bounds show to be empty."""
        start = self.reading.start(() if self.claim.about_decisions else self.system.start)
        yield from (root for root in (start, *map(self.root, self.hulls)) if root is not None)

    def root(self, hull: Hull) -> Branch | None:
        """A hull as a symbolic state; None where bounds show that it is empty."""
        return self.reading.hull(hull.step, hull.region)

    def follow_branch(self, branch: Branch) -> list[Branch]:
        """The symbolic states after a step from one, once all is asked of it."""
        return list(self._decide(branch) if self.claim.about_decisions else self._follow(branch))

    def ensure_within(self, branch: Branch, number: int) -> None:
        """Asks that a branch lies in a hull of its step."""
        if number >= len(self.hulls) or self.hulls[number].step != branch.step:
            raise RejectedError(f"there is no hull {number} at step {branch.step}")
        for half in self.hulls[number].region:
            self._exclude(branch, self.reading.condition(negate(atom(half))))

    def _decide(self, start: Branch) -> Iterator[Branch]:
        denied, inside = negate(self.claim.formula), self.claim.inside if self.claim.regions else TRUE
        modes = conjunction(*(_is_mode(one) for one in self.system.variables if one.modes))
        for branch in self._within(start, self.reading.condition(conjunction(modes, inside))):
            for decided, effects in self._iterate_choices(branch, 0):
                actions = {one.agent: effect.number for one, effect in zip(self.policies, effects, strict=True)}
                self._exclude(decided, self.reading.condition(substitute_actions(denied, actions)))
        yield from ()

    def _follow(self, branch: Branch) -> Iterator[Branch]:
        """The symbolic states after a step from one, where the claim is neither broken nor fulfilled in it."""
        self._exclude(branch, self._build_exclusion(branch.step))
        if branch.step < self.claim.steps:
            for left in self._iterate_unfulfilled(branch):
                self._exclude(left, self._unstated, stated=False)
                for number, box in enumerate(self._pieces):
                    for here in self._within(left, box):
                        for decided, effects in self._iterate_choices(here, 0):
                            yield self.reading.move_branch(decided, number, effects)

    def _build_exclusion(self, step: int) -> Condition:
        """Returns the condition that must be excluded at a step."""
        if step not in self._conditions:
            parts = _parts(self.claim.violation_at(step))
            shown = [parts[way] for way in self._shows if way < len(parts)]
            self._conditions[step] = self.reading.condition(disjunction(*shown))
        return self._conditions[step]

    def _exclude(self, branch: Branch, condition: Condition, stated: bool = True) -> None:
        for left in self._within(branch, condition):
            self.answers.leave_open(left, stated)

    def _iterate_unfulfilled(self, branch: Branch) -> Iterator[Branch]:
        fulfilled = self.claim.fulfilment_at(branch.step)
        if fulfilled is FALSE or not self.answers.asks_fulfilled(branch):
            yield branch
        else:
            yield from self._within(branch, self.reading.condition(negate(fulfilled)))

    def _iterate_choices(self, branch: Branch, agent: int, before: tuple[Effect, ...] = ()) -> Iterator[Decided]:
        """The joint effects that the agents choose from one on, with the states in which they do."""
        if agent == len(self.decisions):
            yield branch, before
            return
        for here, choices in self._leaves(branch, self.decisions[agent]):
            for effect in sorted(choices, key=lambda one: one.number):
                yield from self._iterate_choices(here, agent + 1, (*before, effect))

    def _leaves(self, branch: Branch, decision: Decision) -> Iterator[tuple[Branch, Choices]]:
        if not isinstance(decision, Split):
            yield branch, decision
            return
        left, right = self._sides(branch, decision.left_if)
        if left is not None:
            yield from self._leaves(left, decision.left)
        if right is not None:
            yield from self._leaves(right, decision.right)

    def _within(self, branch: Branch, condition: Condition) -> Iterator[Branch]:
        """The states of a branch for which a condition holds, without what would be in two of the branches given."""
        if isinstance(condition, Inequality):
            inside, _ = self._sides(branch, condition)
            if inside is not None:
                yield inside
        elif isinstance(condition, Every):
            yield from self._within_all(branch, condition.parts)
        else:
            yield from self._within_some(branch, condition.parts)

    def _within_all(self, branch: Branch, parts: tuple[Condition, ...]) -> Iterator[Branch]:
        waiting = [iter((branch,))]  # for each of the first conditions, the branches in which all of them hold
        while waiting:
            inside = next(waiting[-1], None)
            if inside is None:
                waiting.pop()
            elif len(waiting) > len(parts):
                yield inside
            else:
                waiting.append(iter(self._within(inside, parts[len(waiting) - 1])))

    def _within_some(self, branch: Branch, parts: tuple[Condition, ...]) -> Iterator[Branch]:
        for part in parts:
            if isinstance(part, Inequality):
                inside, outside = self._sides(branch, part)
                if inside is not None:
                    yield inside
                if outside is None:
                    return
                branch = outside
            else:
                yield from self._within(branch, part)

    def _sides(self, branch: Branch, asked: Inequality) -> tuple[Branch | None, Branch | None]:
        """The states of a branch for which an inequality holds, and those for which it does not."""
        row = self.reading.row(branch, asked)
        settled = row if isinstance(row, bool) else branch.decide_row(row)
        if settled is not None or isinstance(row, bool):
            return (branch, None) if settled else (None, branch)
        match self.answers.side(branch, row):
            case SideAnswer.BOTH:
                return branch.with_row(row), branch.with_row(row.opposite())
            case SideAnswer.NOT_THIS:
                return None, branch
            case SideAnswer.ALL_THIS:
                return branch, None
            case SideAnswer.NEITHER:
                return None, None


def _is_mode(variable: Variable) -> Formula:
    """That a variable has the value of one of its modes."""
    name = variable.name
    values = [(below({name: 1}, n), below({name: -1}, -n)) for n in range(len(variable.modes))]
    return disjunction(*(conjunction(*ends) for ends in values))


def box_of(box: Box) -> Polytope:
    """A box as half spaces."""
    halves: list[HalfSpace] = []
    for name, (low, high) in box.items():
        halves += [
            HalfSpace(Affine.of({name: Fraction(-1)}, low)),
            HalfSpace(Affine.of({name: Fraction(1)}, -high)),
        ]
    return tuple(halves)
