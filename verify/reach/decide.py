"""Decides claims about a team in a stated system: PROVED with a certificate, VIOLATED with an episode, or UNKNOWN.

Does: the order in which counterexamples and proofs are looked for.
Assumes: a checked profile; a system whose names, units and shapes were checked.
Does not: read or write files.

First random episodes are played, then boxes are tried that cover all episodes. Then the claim is shown in parts, each
of which follows only the variables that it depends on. If that fails, all variables are followed: then what a branch
leaves open is an episode, which is replayed.
"""

from __future__ import annotations

from collections.abc import Generator, Iterable, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import NamedTuple

from codegen.errors import InputError, UnknownNameError
from codegen.floats import nearest_double
from codegen.ir import PolicyProfile
from codegen.policy_json import content_hash
from verify.boxes.covering import Search
from verify.certificates.proofs import encode_numbers
from verify.checker.covers.certificates import CoverCertificate
from verify.checker.covers.certificates import accepted as accepted_cover
from verify.checker.reading import RejectedError
from verify.checker.systems.certificates import SystemCertificate, accepted, acting
from verify.checker.systems.reading import SystemReading
from verify.checker.systems.rows import UNIT, Branch
from verify.checker.systems.walk import FollowedPart
from verify.claims.formula import agents
from verify.progress import tell
from verify.question import Budgets, Question
from verify.reach.forever.lasting import lasting
from verify.reach.formwise import formwise
from verify.reach.parts import divided, whole
from verify.reach.replay import Course, replayed
from verify.reach.results import NO_STATE, ROOM, OpenState, ReachOutcome, SystemCounterexample
from verify.reach.samples import courses
from verify.reach.search import Open, ReachBudgetError, SystemProver
from verify.reach.unfolding import Merging, Unfolding
from verify.reach.witnesses import inhabitant, starts, witnesses
from verify.result import Verdict
from verify.subjects import ClosedLoop
from verify.systems import documents
from verify.systems.claims import SystemClaim
from verify.systems.system import System, ensure_in_steps
from verify.unanswered import SpentError

LEFT_OPEN = (
    "some states may break the claim: no episode into them was found that replays, nor a proof that none gets there"
)
UNSTATED = "an episode may leave the states for which dynamics are stated"
NEAR = "a region that is a little larger or smaller, as its bounds may be met exactly"
WIDER = "wider ranges or boxes of pieces, so that dynamics are stated of more states"
STAGES = (  # how symbolic states are merged, and the symbolic states and linear programs that are tried at first
    (None, 50_000, 2_000),  # without errors bounds settle most questions
    (Merging(16, 1), 20_000, 30_000),
    (Merging(64, 4), 20_000, 30_000),
    (Merging(256, 16), 40_000, 30_000),
)
GROWTH = 4  # of what is tried, once no stage had enough
PARTED = 3  # a part that can be shown alone takes few symbolic states; what it does not follow may make many
FIRST_SAMPLES = 256  # episodes that are played before anything is proved
MAX_OPEN = 64  # branches in which an episode is looked for


class Allowed(NamedTuple):
    """Symbolic states and linear programs that may be spent."""

    max_states: int
    max_programs: int


def decide(question: Question[SystemClaim]) -> ReachOutcome:
    """The answer to a question. InputError for agents or features that the system does not state."""
    assert isinstance(question.subject, ClosedLoop)
    profile, system = question.profile, question.subject.system
    ensure_stated(profile, system)
    return _Decision(profile, system, question.claim, question.budgets).outcome()


def ensure_stated(profile: PolicyProfile, system: System) -> None:
    """UnknownNameError for agents or features that the system does not state; InputError for one without a tree."""
    where = f"system {system.name}"
    for policy in profile.agents:
        if policy.agent not in system.features:
            raise UnknownNameError("agent", policy.agent, system.features, where)
        for feature in policy.features:
            known = system.features[policy.agent]
            if feature.name not in known:
                raise UnknownNameError("feature", feature.name, known, f"{where}, agent {policy.agent}")
    silent = sorted(acting(system) - {policy.agent for policy in profile.agents})
    if silent:
        what = f"the profile has no tree for {', '.join(silent)}"
        raise InputError(what, where, "name the profile of all agents that move the system")


class _OpenError(Exception):
    """A branch of a part is left open."""


class ReachSpentError(SpentError):
    """The whole budget is spent with a symbolic state at hand; `option` sets what ended first, `limit` is its value."""

    def __init__(self, branch: Branch, option: str, limit: int) -> None:
        super().__init__(option)
        self.branch, self.option, self.limit = branch, option, limit


@dataclass
class _Spent:
    states: int = 0
    programs: int = 0
    boxes: int = 0


class _Decision:
    """The answer to one claim."""

    def __init__(self, profile: PolicyProfile, system: System, claim: SystemClaim, budget: Budgets) -> None:
        claim.ensure()
        strange = agents(claim.formula) - {policy.agent for policy in profile.agents}
        if strange:
            raise UnknownNameError("agent", min(strange), [policy.agent for policy in profile.agents], claim.shown)
        if not claim.about_decisions:
            ensure_in_steps(system, "the engine of steps")
        if claim.steps and not claim.about_decisions and not system.pieces:
            what = f"system {system.name} states no dynamics, so nothing can be said of episodes"
            raise InputError(what, f"claim {claim.shown}", "state how it moves, or claim something about decisions")
        self.profile, self.system, self.claim, self.budget = profile, system, claim, budget
        self.spent = _Spent()
        self.found: SystemCounterexample | None = None
        self.open: list[tuple[Branch, bool]] = []

    def outcome(self) -> ReachOutcome:
        """The verdict with its evidence and cost."""
        outcome = self._outcome()
        return replace(outcome, states=self.spent.states, programs=self.spent.programs, boxes=self.spent.boxes)

    def _outcome(self) -> ReachOutcome:
        if self.claim.says.ever:
            return self._for_ever()
        outcome = self._played(min(self.budget.samples, FIRST_SAMPLES)) or self._covered()
        outcome = outcome or (self._played(self.budget.samples) if self.budget.samples > FIRST_SAMPLES else None)
        if outcome is not None:
            return outcome
        try:
            return self._searched()
        except ReachSpentError as error:
            spent = f"{self.spent.states:,} symbolic states and {self.spent.programs:,} linear programs"
            said = f"stopped after {spent} without a proof: {error.option} is {error.limit:,}"
            return self._unknown(said, error.branch, f"a larger {error.option} than {error.limit:,}")

    def _for_ever(self) -> ReachOutcome:
        outcome = self._played(min(self.budget.samples, FIRST_SAMPLES))
        outcome = outcome or lasting(self.profile, self.system, self.claim, self.budget.max_boxes)
        self.spent.boxes = outcome.boxes
        again = outcome.verdict is Verdict.UNKNOWN and self.budget.samples > FIRST_SAMPLES
        return (self._played(self.budget.samples) if again else None) or outcome

    def _played(self, count: int) -> ReachOutcome | None:
        """VIOLATED where one of so many random episodes breaks the claim."""
        return self._broken(courses(self.profile, self.system, self.claim, count)) if count else None

    def _broken(self, candidates: Iterable[Course]) -> ReachOutcome | None:
        """VIOLATED by the first course that breaks the claim in exact numbers."""
        for course in candidates:
            found = replayed(self.profile, self.system, self.claim, course)
            if found is not None:
                return ReachOutcome(Verdict.VIOLATED, counterexample=found)
        return None

    def _covered(self) -> ReachOutcome | None:
        """PROVED where boxes that the checker accepts cover all episodes; VIOLATED by a start of a part left open."""
        if self.claim.about_decisions or not self.budget.max_boxes:
            return None
        by_forms = formwise(self.profile, self.system, self.claim)
        search = Search(self.profile, self.system, self.claim, self.budget.max_boxes, by_forms)
        hashes = content_hash(self.profile), documents.content_hash(self.system)
        state: Mapping[str, Fraction] | Verdict | None = None
        try:
            for found in search.coverings():
                state = state or inhabitant(self.system, self.claim)
                if isinstance(state, Verdict):
                    return ReachOutcome(state, NO_STATE[state], helps=(ROOM,))
                cuts = encode_numbers(found.cuts)
                cover = CoverCertificate(*hashes, self.claim, state, found.widths, cuts, found.forms)
                with suppress(RejectedError):  # razor-thin: the checker rounds outward
                    return ReachOutcome(
                        Verdict.PROVED, certificate=cover, branches=accepted_cover(cover, self.profile, self.system)
                    )
            return self._broken(starts(self.system, search.open[:MAX_OPEN]))
        finally:
            self.spent.boxes = search.spent

    def _searched(self) -> ReachOutcome:
        """The answer of the first stage that has one. ReachSpentError.

        The stages and what each is allowed do not depend on the budget, which only says when to stop. So whatever a
        budget answers, a larger one answers too, after the same work.
        """
        failed: set[tuple[Merging | None, int]] = set()  # what leaves something open does so again
        growth = 1
        while True:
            for merging, states, programs in STAGES:
                allowed = Allowed(states * growth, programs * growth)
                fewer = allowed._replace(max_states=allowed.max_states // PARTED)
                for number, parts in enumerate(divided(self.system, self.claim)):
                    if (merging, number) not in failed:
                        with suppress(ReachBudgetError), self._noting(failed, (merging, number)):
                            return self._proved([self._shown(part, self._stop, merging, fewer) for part in parts])
                if (merging, -1) not in failed:
                    with suppress(ReachBudgetError), self._noting(failed, (merging, -1)):
                        return self._together(merging, allowed)
            growth *= GROWTH

    @contextmanager
    def _noting(self, failed: set[tuple[Merging | None, int]], stage: tuple[Merging | None, int]) -> Generator[None]:
        """Notes a stage that leaves a branch open."""
        try:
            yield
        except _OpenError:
            failed.add(stage)

    def _together(self, merging: Merging | None, allowed: Allowed) -> ReachOutcome:
        """The answer when all variables are followed. BudgetError; _OpenError where hulls leave something open."""
        self.open.clear()
        try:
            open_ = self._try if merging is None else self._stop
            part = self._shown(whole(self.system, self.claim), open_, merging, allowed)
        except _OpenError:
            if self.found is None:
                raise
            return ReachOutcome(Verdict.VIOLATED, counterexample=self.found)
        if self.open:
            branch, stated = self.open[0]
            return self._unknown(LEFT_OPEN, branch, NEAR) if stated else self._unknown(UNSTATED, branch, WIDER)
        return self._proved([part])

    def _shown(self, part: FollowedPart, open_: Open, merging: Merging | None, allowed: Allowed) -> FollowedPart:
        """A part with its proof, for what a stage is allowed of what is left. ReachBudgetError where the stage has
        spent that, ReachSpentError where all is spent; what `open_` raises.
        """
        left = Allowed(self.budget.max_states - self.spent.states, self.budget.max_programs - self.spent.programs)

        def on_progress(step: int) -> None:
            states, programs = self.spent.states + prover.states, self.spent.programs + prover.programs.solved
            words = f"symbolic states, {programs:,} of {self.budget.max_programs:,} linear programs"
            tell(states, self.budget.max_states, f"{words}, at step {step:,} of {self.claim.steps:,}")

        limits = min(allowed.max_states, left.max_states), min(allowed.max_programs, left.max_programs)
        prover = SystemProver(*limits, open_, on_progress)
        try:
            return Unfolding(self.profile, self.system, self.claim, part, prover).run(merging)
        except ReachBudgetError as error:
            ended = left.max_programs if error.programs else left.max_states
            if ended > (allowed.max_programs if error.programs else allowed.max_states):
                raise
            limit = self.budget.max_programs if error.programs else self.budget.max_states
            raise ReachSpentError(error.branch, "--max-programs" if error.programs else "--max-states", limit) from None
        finally:
            self.spent.states += prover.states
            self.spent.programs += prover.programs.solved

    def _stop(self, branch: Branch, stated: bool) -> None:
        raise _OpenError

    def _try(self, branch: Branch, stated: bool) -> None:
        """Looks for an episode in a branch that is left open; _OpenError once there is one."""
        self.open.append((branch, stated))
        start = self._start()
        for course in witnesses(self.system, branch, start) if len(self.open) < MAX_OPEN and start else ():
            self.found = replayed(self.profile, self.system, self.claim, course)
            if self.found is not None:
                raise _OpenError

    def _start(self) -> Branch | None:
        reading = SystemReading(self.system, [one.name for one in self.system.variables])
        return reading.start(() if self.claim.about_decisions else self.system.start)

    def _unknown(self, reason: str, branch: Branch, first: str) -> ReachOutcome:
        """No answer, with what is left open and what may help."""
        system, claim = self.system, self.claim
        helps = [first, "a smaller region" if claim.about_decisions else "a smaller start region"]
        helps += ["fewer steps"] if claim.steps > 1 else []
        if not claim.about_decisions and any(piece.error for piece in system.pieces):
            helps.append("smaller errors, or more `cuts` where rules are not affine")
        left = OpenState(branch.step, {name: _bounds(branch, name) for name in branch.at})
        return ReachOutcome(Verdict.UNKNOWN, reason, left, tuple(helps))

    def _proved(self, parts: list[FollowedPart]) -> ReachOutcome:
        state = inhabitant(self.system, self.claim)
        if isinstance(state, Verdict):
            return ReachOutcome(state, NO_STATE[state], helps=(ROOM,))
        hashes = content_hash(self.profile), documents.content_hash(self.system)
        found = SystemCertificate(*hashes, self.claim, state, tuple(parts))
        closed = accepted(found, self.profile, self.system)
        return ReachOutcome(Verdict.PROVED, certificate=found, branches=closed)


def _bounds(branch: Branch, name: str) -> tuple[float, float]:
    """Bounds of a variable in a symbolic state, which may be wider than it."""
    low = high = nearest_double(branch.at[name])
    for unknown, weight in branch.motion.weights[name].items():
        span = branch.box.get(unknown, UNIT)
        ends = sorted((nearest_double(weight * span.low), nearest_double(weight * span.high)))
        low, high = low + ends[0], high + ends[1]
    return low, high
