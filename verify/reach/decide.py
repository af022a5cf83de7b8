"""Decides a claim about a team in a stated system: PROVED with a certificate, VIOLATED with an episode, or UNKNOWN.

Does: asks whether a claim can be decided; the order of work. Boxes that cover all episodes come first; episodes are
  played in what these leave open; then come stages of symbolic states and linear programs: in parts, each of which
  follows only the variables that it depends on, then with all variables and an episode replayed into what is left open.
Assumes: a checked profile; a system whose names, units and shapes were checked.
Does not: read or write files, or know other claims: an answer and its budget are those of one claim.

The order does not depend on the budget, which only says when to stop. So whatever a budget answers, a larger one
answers too, after the same work. Where a claim has no answer at the end, episodes are played beyond the budget: what
these break, a larger budget answers by them or before, and may take longer. A part may fail although the claim holds,
as it knows nothing of the variables not followed.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from dataclasses import replace
from typing import TypeAlias

import numpy as np

from codegen.errors import InputError, UnknownNameError
from codegen.ir import PolicyProfile
from codegen.numbers import nearest_double
from verify.checker.reading import RejectedError, TooMuchError
from verify.checker.systems.branch_proofs import acting, needs_stated, ways
from verify.checker.systems.proofs import Cover, FollowedPart, Walks
from verify.checker.systems.reading import UNIT, Branch, SystemReading
from verify.claims.formula import FALSE, Or, agents, coordinates
from verify.question import Budgets, Question
from verify.reach.covering import Search, close_names
from verify.reach.play import Starts, courses
from verify.reach.programs import prove, witnesses
from verify.reach.replay import replay_course, shrink_counterexample
from verify.reach.results import OpenState, ReachOutcome, SystemCounterexample
from verify.reach.search import Merging, Open, ReachBudgetError, SystemProver, Unfolding
from verify.reach.unbounded import lasting
from verify.result import Verdict
from verify.spending import OPTION, BudgetSpentError, Spending
from verify.subjects import ClosedLoop
from verify.systems.claims import SystemClaim
from verify.systems.system import System, ensure_in_steps


def whole(system: System, claim: SystemClaim) -> FollowedPart:
    """All in one part, which follows every variable."""
    shows = range(ways(claim) + needs_stated(claim, system))
    return FollowedPart(tuple(one.name for one in system.variables), tuple(shows), (), b"")


def iterate_divisions(system: System, claim: SystemClaim) -> Iterator[list[FollowedPart]]:
    """Divisions worth trying, the finest one first: by the variables that the ways to break the claim speak of, and all
    that these depend on; then by those that features join with them too.
    """
    if claim.about_decisions:
        return
    broken = claim.violation_at(claim.steps)
    about = [coordinates(broken)] * ways(claim)
    if isinstance(broken, Or) and claim.fulfilment_at(0) == FALSE:
        about = [coordinates(part) for part in broken.parts]
    if needs_stated(claim, system):
        tested = {name for piece in system.pieces for half in piece.when for name, _ in half.form.terms}
        about.append(frozenset(name for piece in system.pieces for name in piece.where) | tested)
    known = [feature for features in system.features.values() for feature in features.values()]
    before = list[FollowedPart]()
    for joined in ([], [{name for name, _ in feature.form.terms} for feature in known]):
        groups: dict[tuple[str, ...], list[int]] = {}
        for way, names in enumerate(about):
            closed = close_names(system, names, joined)
            groups.setdefault(tuple(one.name for one in system.variables if one.name in closed), []).append(way)
        parts = [FollowedPart(followed, tuple(shows), (), b"") for followed, shows in groups.items()]
        if parts != before and all(len(part.followed) < len(system.variables) for part in parts):
            yield parts
        before = parts


LEFT_OPEN = {  # by what a claim is about: single decisions, or episodes
    True: "some states may break the claim: no state was found that does, nor a proof that none does",
    False: "some states may break the claim: no episode into them was found that replays, nor a proof that none gets "
    "there",
}
UNSTATED = "an episode may leave the states for which dynamics are stated"
NEAR = "a region that is a little larger or smaller, as its bounds may be met exactly"
WIDER = "wider ranges or boxes of pieces, so that dynamics are stated of more states"
FEWER_TESTS = "a policy that tests fewer sums"
PARTED = 3  # a part that can be shown alone takes few symbolic states; what it does not follow may make many
MAX_OPEN = 64  # branches in which an episode is looked for
Allowed: TypeAlias = tuple[int, int]  # symbolic states and linear programs that a stage may spend


class _OpenError(Exception):
    """A branch of a part is left open."""


class SymbolicSearch:
    """The search for one claim, with what it shares of a budget. `open`: the state at hand when it last stopped."""

    def __init__(self, profile: PolicyProfile, system: System, claim: SystemClaim, spending: Spending) -> None:
        self._profile, self._system, self._claim, self._spending = profile, system, claim, spending
        self._failed: set[tuple[Merging | None, int]] = set()  # what leaves something open does so again
        self._found: SystemCounterexample | None = None
        self._left: list[tuple[Branch, bool]] = []
        self.open: OpenState | None = None

    def try_stage(self, merging: Merging | None, allowed: Allowed) -> ReachOutcome | None:
        """The answer of one stage; None where it has none. BudgetSpentError."""
        fewer = allowed[0] // PARTED, allowed[1]
        divisions = list(iterate_divisions(self._system, self._claim))
        for number in (*range(len(divisions)), -1):
            if (merging, number) in self._failed:
                continue
            try:
                if number < 0:
                    return self._together(merging, allowed)
                parts = [self._prove_part(part, self._stop, merging, fewer) for part in divisions[number]]
                return self._certify_parts(parts)
            except ReachBudgetError:
                continue
            except _OpenError:
                self._failed.add((merging, number))
        return None

    def _together(self, merging: Merging | None, allowed: Allowed) -> ReachOutcome:
        """The answer when all variables are followed. ReachBudgetError; _OpenError where hulls leave something open."""
        self._left.clear()
        try:
            open_ = self._try if merging is None else self._stop
            part = self._prove_part(whole(self._system, self._claim), open_, merging, allowed)
        except _OpenError:
            if self._found is None:
                raise
            counterexample = shrink_counterexample(self._profile, self._system, self._claim, self._found)
            return ReachOutcome(Verdict.VIOLATED, counterexample=counterexample)
        if self._left:
            branch, stated = self._left[0]
            reason, first = (LEFT_OPEN[self._claim.about_decisions], NEAR) if stated else (UNSTATED, WIDER)
            return ReachOutcome(Verdict.UNKNOWN, reason, open_state(branch), helping(self._system, self._claim, first))
        return self._certify_parts([part])

    def _prove_part(self, part: FollowedPart, open_: Open, merging: Merging | None, allowed: Allowed) -> FollowedPart:
        """A part with its proof, for what a stage is allowed of what is left. ReachBudgetError where the stage has
        spent that, BudgetSpentError where all is spent; what `open_` raises.
        """
        spending = self._spending
        states, programs = spending.states, spending.programs

        def count_spent() -> None:
            spending.states, spending.programs = states + prover.states, programs + prover.programs.solved

        def on_progress(step: int) -> None:
            count_spent()
            spending.tell(f", at step {step:,} of {self._claim.steps:,}")

        prover = SystemProver(*allowed, open_, on_progress, spending.left)
        try:
            return Unfolding(self._profile, self._system, self._claim, part, prover).run(merging)
        except ReachBudgetError as error:
            self.open = open_state(error.branch)
            if not error.all_spent:
                raise
            raise BudgetSpentError(OPTION) from None
        finally:
            count_spent()

    def prove_again(self, part: FollowedPart) -> FollowedPart:
        """A part with another proof. RejectedError where there is none; BudgetSpentError."""
        for merging, allowed in STAGES:
            with suppress(ReachBudgetError, _OpenError):
                unproved = FollowedPart(part.followed, part.shows, (), b"")
                return self._prove_part(unproved, self._stop, merging, allowed)
        raise RejectedError("a part of the claim is not shown")

    def _stop(self, branch: Branch, stated: bool) -> None:
        raise _OpenError

    def _try(self, branch: Branch, stated: bool) -> None:
        """Looks for an episode in a branch that is left open; _OpenError once there is one."""
        self._left.append((branch, stated))
        start = start_of(self._system, self._claim)
        for course in witnesses(self._system, branch, start) if len(self._left) < MAX_OPEN and start else ():
            self._found = replay_course(self._profile, self._system, self._claim, course)
            if self._found is not None:
                raise _OpenError

    def _certify_parts(self, parts: list[FollowedPart]) -> ReachOutcome:
        """PROVED where the checker accepts the parts; UNKNOWN where it cannot look through so much."""
        try:
            return prove(self._profile, self._system, self._claim, Walks(tuple(parts)))
        except TooMuchError as error:
            reason = f"a proof was found, and no checker goes through it: {error}"
            return ReachOutcome(Verdict.UNKNOWN, reason, helps=helping(self._system, self._claim, FEWER_TESTS))


def helping(system: System, claim: SystemClaim, first: str) -> tuple[str, ...]:
    """Lists what may help where a claim has no answer."""
    helps = [first, "a smaller region" if claim.about_decisions else "a smaller start region"]
    helps += ["fewer steps"] if claim.steps > 1 else []
    if not claim.about_decisions and any(piece.error for piece in system.pieces):
        helps.append("smaller errors, or more `cuts` where rules are not affine")
    return tuple(helps)


def start_of(system: System, claim: SystemClaim) -> Branch | None:
    """All states that a claim is first about, as one symbolic state; None where there are none."""
    reading = SystemReading(system, [one.name for one in system.variables])
    return reading.start(() if claim.about_decisions else system.start)


def open_state(branch: Branch) -> OpenState:
    """A symbolic state as reports tell it. Its bounds may be wider than it."""
    bounds = dict[str, tuple[float, float]]()
    for name, at in branch.at.items():
        low = high = nearest_double(at)
        for unknown, weight in branch.motion.weights[name].items():
            span = branch.box.get(unknown, UNIT)
            ends = sorted((nearest_double(weight * span.low), nearest_double(weight * span.high)))
            low, high = low + ends[0], high + ends[1]
        bounds[name] = low, high
    return OpenState(branch.step, bounds)


STAGES = (  # how symbolic states are merged, and the symbolic states and linear programs that are tried at first
    (None, (50_000, 2_000)),  # without errors bounds settle most questions
    (Merging(16, 1), (20_000, 30_000)),
    (Merging(64, 4), (20_000, 30_000)),
    (Merging(256, 16), (40_000, 30_000)),
)
GROWTH = 4  # of what is tried, once no stage had enough
FIRST_SAMPLES = 256  # episodes that are played before anything is proved, where no boxes are tried
LASTING = 2_000_000  # boxes for an invariant


def decide(question: Question[SystemClaim]) -> ReachOutcome:
    """The answer to a question. InputError for agents or features that the system does not state."""
    return _search_for(question).decide()


def decide_control(question: Question[SystemClaim]) -> ReachOutcome:
    """The same about shuffled leaves, which mostly break a claim at once: episodes are played before all else, and none
    is made short, which nobody reads.
    """
    found = _search_for(question).break_claim(shortly=False)
    return found or _search_for(question, unbroken=True).decide()


def _search_for(question: Question[SystemClaim], unbroken: bool = False) -> ClaimSearch:
    assert isinstance(question.subject, ClosedLoop)
    profile, system, claim = question.profile, question.subject.system, question.claim
    ensure_stated(profile, system)
    claim.ensure()
    strange = agents(claim.formula) - {policy.agent for policy in profile.agents}
    if strange:
        raise UnknownNameError("agent", min(strange), [policy.agent for policy in profile.agents], claim.shown)
    if not claim.about_decisions:
        ensure_in_steps(system, "the engine of steps")
    if claim.steps and not claim.about_decisions and not system.pieces:
        what = f"system {system.name} states no dynamics, so nothing can be said of episodes"
        raise InputError(what, f"claim {claim.shown}", "state how it moves, or claim something about decisions")
    return ClaimSearch(profile, system, claim, question.budgets, unbroken)


class ClaimSearch:
    """The search for the answer to one claim. `spending`: what it spent so far; `unbroken`: all samples were played
    before, and none breaks the claim.
    """

    def __init__(
        self, profile: PolicyProfile, system: System, claim: SystemClaim, budgets: Budgets, unbroken: bool = False
    ) -> None:
        self.profile, self.system, self.claim, self.budgets = profile, system, claim, budgets
        self._unbroken = unbroken
        self.spending = Spending(budgets.max_boxes)
        self._open: OpenState | None = None

    def decide(self) -> ReachOutcome:
        """The answer, with what was spent on it."""
        try:
            outcome = self._run_stages()
        except BudgetSpentError:
            outcome = self.break_claim() or self._report_spent()
        spent = self.spending
        counts = {"states": spent.states, "programs": spent.programs, "boxes": outcome.boxes or spent.boxes}
        return replace(outcome, **counts)

    def _run_stages(self) -> ReachOutcome:
        """All work. BudgetSpentError."""
        says, covered = self.claim.says, self.budgets.covers
        first = Starts(min(self.budgets.samples, FIRST_SAMPLES))
        if says.ever:
            return self._play(first) or self._for_ever()
        if covered and not says.still:
            return self._try_covers() or self._symbolic()
        found = self._play(first)
        if found is None and self.budgets.samples > FIRST_SAMPLES:
            found = self._play(Starts(self.budgets.samples))
        return found or self._symbolic()

    def _try_covers(self) -> ReachOutcome | None:
        """PROVED where boxes that the checker accepts cover all episodes; VIOLATED where one of some episodes from the
        parts left open breaks the claim.
        """
        names = [one.name for one in self.system.variables]
        for cover in Search(self.profile, self.system, self.claim, self.spending).iterate_covers():
            if isinstance(cover, Cover):
                with suppress(RejectedError):  # a razor-thin one is refused, as the checker rounds outward
                    return prove(self.profile, self.system, self.claim, cover)
                continue
            parts, played = cover
            ends = zip(names, parts[0].low.tolist(), parts[0].high.tolist(), strict=True)
            self._open = OpenState(0, {name: (least, most) for name, least, most in ends})
            some: list[int] = np.linspace(0, len(parts) - 1, min(len(parts), played)).astype(np.int64).tolist()
            boxes = np.array([parts[at].low for at in some]), np.array([parts[at].high for at in some])
            found = self._play(Starts(min(played, self.budgets.samples), boxes))
            if found is not None:
                return found
        return None

    def break_claim(self, shortly: bool = True) -> ReachOutcome | None:
        """Plays all samples, like `_play`, where there would be no answer: whatever is left of the budget, so that a
        claim that is plainly false is VIOLATED with any.
        """
        return None if self._unbroken else self._play(Starts(self.budgets.samples), True, shortly)

    def _play(self, at: Starts, whatever_is_left: bool = False, shortly: bool = True) -> ReachOutcome | None:
        """VIOLATED where one of so many random episodes breaks the claim. `shortly`: told with few digits."""
        if not at.episodes:
            return None
        states = at.episodes * (1 + self.claim.steps)
        if not whatever_is_left:
            self.spending.ensure_left(states)
        self.spending.played += states
        for course in courses(self.profile, self.system, self.claim, at):
            found = replay_course(self.profile, self.system, self.claim, course)
            if found is not None:
                if shortly:
                    found = shrink_counterexample(self.profile, self.system, self.claim, found)
                return ReachOutcome(Verdict.VIOLATED, counterexample=found)
        return None

    def _for_ever(self) -> ReachOutcome:
        outcome = lasting(self.profile, self.system, self.claim, min(self.spending.left, LASTING))
        with suppress(BudgetSpentError):  # the outcome says more than that: which state leaves, and where it goes
            self.spending.states += outcome.states
            self.spending.programs += outcome.programs
            self.spending.take(outcome.boxes)
        return (self.break_claim() if outcome.verdict is Verdict.UNKNOWN else None) or outcome

    def _symbolic(self) -> ReachOutcome:
        """Stages, until one has an answer. BudgetSpentError."""
        search, growth = SymbolicSearch(self.profile, self.system, self.claim, self.spending), 1
        while True:
            for merging, (states, programs) in STAGES:
                try:
                    outcome = search.try_stage(merging, (states * growth, programs * growth))
                finally:
                    self._open = search.open or self._open
                if outcome is not None:
                    return (self.break_claim() if outcome.verdict is Verdict.UNKNOWN else None) or outcome
            growth *= GROWTH

    def _report_spent(self) -> ReachOutcome:
        """No answer, since all is spent."""
        start = start_of(self.system, self.claim) if self._open is None else None
        left = open_state(start) if start is not None else self._open
        spent, most = self.spending, self.spending.most
        said = f"stopped after {spent.words} without a proof: the budget is {most:,} boxes"
        more = f"a larger {OPTION}"
        return ReachOutcome(Verdict.UNKNOWN, said, left, helping(self.system, self.claim, more))


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
