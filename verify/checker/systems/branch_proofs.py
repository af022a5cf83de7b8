"""Proofs about stated systems by branches: every branch of a fixed search is closed by a sum of inequalities.

Does: the search that README.md specifies; the answers that a proof gives in it, each checked; whether a certificate of
  any form asks something of a profile and a system, and one of this form is accepted.
Assumes: a profile and a system that were read and checked; proofs of the form that README.md specifies, made by anyone.
Does not: prove, read (proofs.py) or write (verify/certificates). It knows no linear program and no engine; whoever
  makes a proof answers the same search.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator
from enum import IntEnum

from codegen.errors import InputError, escape_text
from codegen.ir import ROOT, PolicyProfile
from codegen.policy_json import content_hash
from verify.checker.certificate import REMAKE, ensure_about, numbers
from verify.checker.reading import RejectedError
from verify.checker.systems.cases import ensure_cases, has_cases, hull_of
from verify.checker.systems.proofs import FollowedPart, Hull, SystemCertificate, Walks
from verify.checker.systems.reading import (
    Branch,
    Choices,
    Condition,
    Decision,
    Effect,
    Every,
    Inequality,
    Row,
    Split,
    SystemReading,
    alternatives,
    decisions,
    sides_of,
)
from verify.claims.formula import (
    FALSE,
    TRUE,
    Acts,
    Formula,
    agents,
    atoms,
    below,
    conjunction,
    coordinates,
    disjunction,
    holds,
    negate,
    substitute_actions,
)
from verify.systems import documents
from verify.systems.claims import SystemClaim, SystemPremise, atom
from verify.systems.system import State, System, Variable, box_of, ensure_in_steps

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
            used = list[tuple[Row, int]]()
            if answer != SideAnswer.NEITHER:
                used.append((row if answer == SideAnswer.NOT_THIS else row.opposite(), self._times()))
            self._ensure_empty(branch, used)
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
            what = f"the rows at step {branch.step} do not contradict"
            raise RejectedError(f"after {self.closed} closed branches: {what}")
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
    return 1 if claim.about_decisions else len(alternatives(claim.violation_at(claim.steps)))


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
            parts = alternatives(self.claim.violation_at(step))
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


BITS = 7 * 1_000  # of the largest number in a proof


def check_certificate(certificate: SystemCertificate, proof: Walks, profile: PolicyProfile, system: System) -> int:
    """Checks a certificate with this proof; the number of branches that its proofs close by sums of rows.

    InputError when it is about another profile or system, or names what they do not have; RejectedError when a proof is
    missing or does not hold.
    """
    if not certificate.claim.about_decisions:
        ensure_in_steps(system, "this form of certificate")
    named = {name for part in proof.parts for name in part.followed}
    hulls = [hull for part in proof.parts for hull in part.hulls]
    named |= {name for hull in hulls for half in hull.region for name, _ in half.form.terms}
    ensure_asked(certificate, named, profile, system)
    asked = set(range(ways(certificate.claim) + needs_stated(certificate.claim, system)))
    missing = asked.difference(*(part.shows for part in proof.parts))
    if missing:
        raise RejectedError(f"no part shows that the claim is not broken in the ways {sorted(missing)}")
    closed = 0
    for number, part in enumerate(proof.parts):
        ensure_closed(system, part)
        try:
            closed += close_branches(profile, system, certificate.claim, part, part.proof)
        except RejectedError as error:
            raise RejectedError(f"part {number}: {error}") from None
    return closed


def close_branches(
    profile: PolicyProfile, system: System, claim: SystemClaim, part: FollowedPart, walked: bytes
) -> int:
    """Checks the proof of a part; counts the branches that it closes. RejectedError where it does not hold."""
    proof = Proof(numbers(walked, BITS))
    SystemQuestions(profile, system, claim, part, proof).run()
    proof.ensure_read()
    return proof.closed


def ensure_asked(
    certificate: SystemCertificate, named: set[str], profile: PolicyProfile, system: System, ever: bool = False
) -> None:
    """That a certificate asks something of this profile and system. `named`: variables that its proof names; `ever`:
    whether it can show what holds at all steps, and nothing else.

    InputError when it is about others, or names what they do not have; RejectedError where its claim is about nothing.
    """
    ensure_about(certificate.header.profile, content_hash(profile), "profile")
    ensure_about(certificate.header.system, documents.content_hash(system), "system")
    _ensure_known(certificate, named, profile, system)
    certificate.claim.ensure()
    if certificate.claim.says.ever != ever:
        raise RejectedError("the claim is about all steps, or this form of certificate is about nothing else")
    if not _is_state(certificate.claim, certificate.header.inhabitant, system):
        raise RejectedError("its inhabitant is not a state that the claim is about, so the claim may be vacuous")
    for premise in certificate.claim.premises:
        _check_premise(premise, certificate.claim, profile, system)
    if certificate.claim.at_samples is not None and system.flow is None:
        raise RejectedError("the claim is about continuous time, and the system moves in steps")
    moving = certificate.claim.steps or certificate.claim.says.ever
    if moving and not system.pieces and system.flow is None and not certificate.claim.about_decisions:
        raise RejectedError("the system states no dynamics, so nothing is known of its episodes")
    ensure_cases(system)
    if any(low > high for piece in system.pieces for low, high in piece.error.values()):
        raise RejectedError("an error of the system has its low end above its high end, so there is none")


def needs_stated(claim: SystemClaim, system: System) -> bool:
    """Returns True if an episode may leave what is stated: then it is to be shown that none does."""
    return not claim.about_decisions and claim.steps > 0 and all(piece.where for piece in system.pieces)


def depends_on(system: System) -> dict[str, frozenset[str]]:
    """The variables that the next value of each variable is made of."""
    sources: dict[str, set[str]] = {one.name: set() for one in system.variables}
    for piece in system.pieces:
        for forms in (piece.move, *piece.effect.values()):
            for name, form in forms.items():
                sources[name] |= {read for read, _ in form.terms}
    return {name: frozenset(read) for name, read in sources.items()}


def acting(system: System) -> set[str]:
    """The agents of a system. One without a tree may do anything, of which no proof speaks."""
    return {*system.features, *(agent for piece in system.pieces for agent, _ in piece.effect)}


def _ensure_known(certificate: SystemCertificate, named: set[str], profile: PolicyProfile, system: System) -> None:
    """InputError where a certificate speaks of what its profile and system do not have."""
    claim, names = certificate.claim, {one.name for one in system.variables}
    used = {name for region in claim.regions + claim.assuming for half in region for name, _ in half.form.terms}
    stated = [claim.formula, *(premise.formula for premise in claim.premises)]
    used |= named.union(*map(coordinates, stated))
    speaking = frozenset[str]().union(*map(agents, stated))
    strange = sorted(used - names) + sorted(speaking - {policy.agent for policy in profile.agents})
    silent = sorted(acting(system) - {policy.agent for policy in profile.agents})
    if silent:
        raise InputError(
            "the profile has no tree for agents that move the system", ", ".join(map(escape_text, silent)), REMAKE
        )
    if not strange:
        counts = {policy.agent: len(policy.actions) for policy in profile.agents}
        said = {(part.agent, part.action) for part in atoms(claim.formula) if isinstance(part, Acts)}
        strange = [f"action {action} of {who}" for who, action in sorted(said) if not 0 <= action < counts[who]]
    states = [certificate.header.inhabitant, *(premise.state for premise in claim.premises)]
    if strange or any(set(state) != names for state in states):
        what = "the certificate names what the profile and the system do not have"
        raise InputError(what, ", ".join(map(escape_text, strange)) or "$.inhabitant", REMAKE)


def _is_state(claim: SystemClaim, state: State, system: System) -> bool:
    if not all(one.range[0] <= state[one.name] <= one.range[1] for one in system.variables):
        return False
    if any(one.modes and state[one.name].denominator != 1 for one in system.variables):
        return False
    if claim.about_decisions:
        return not claim.regions or holds(claim.inside, state, {})
    return all(half.holds(state) for half in system.start) and holds(claim.spoken_of, state, {})


def _check_premise(premise: SystemPremise, claim: SystemClaim, profile: PolicyProfile, system: System) -> None:
    """RejectedError where the state of a left side is none that the claim is about, or does not meet the left side."""
    state, actions = premise.state, dict[str, int]()
    if not claim.about_decisions or not _is_state(claim, state, system):
        raise RejectedError("the state of a left side is not one that the claim is about")
    for agent in agents(premise.formula):
        policy, node = profile.policy(agent), ROOT
        sides = sides_of(system, policy)
        while node in sides:
            node = int((policy.tree.left if holds(sides[node], state, {}) else policy.tree.right)[node])
        actions[agent] = int(policy.tree.action[node])
    if not holds(premise.formula, state, actions):
        raise RejectedError("the state of a left side does not meet it")


def ensure_closed(system: System, part: FollowedPart) -> None:
    """RejectedError where a variable that is followed depends on one that is not."""
    depends = depends_on(system)
    for name in part.followed:
        unknown = depends[name] - set(part.followed)
        if unknown:
            raise RejectedError(f"{name} is followed, but not {', '.join(sorted(unknown))}, on which it depends")
