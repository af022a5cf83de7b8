"""Decides a claim about a team in a stated system: PROVED with a certificate, VIOLATED with an episode, or UNKNOWN.

Does: asks whether a claim can be decided; the order of work. Boxes that cover all episodes come first; episodes are
  played in what these leave open; then come stages of symbolic states and linear programs.
Assumes: a checked profile; a system whose names, units and shapes were checked.
Does not: read or write files, or know other claims: an answer and its budget are those of one claim.

The order does not depend on the budget, which only says when to stop. So whatever a budget answers, a larger one
answers too, after the same work. Where a claim has no answer at the end, episodes are played beyond the budget: what
these break, a larger budget answers by them or before, and may take longer.
"""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from dataclasses import replace
from fractions import Fraction

import numpy as np

from codegen.errors import InputError, UnknownNameError
from codegen.ir import PolicyProfile
from verify.certificates.proofs import encode_numbers
from verify.certificates.systems import certify
from verify.checker.accept import accept
from verify.checker.reading import RejectedError
from verify.checker.systems.certificates import acting
from verify.checker.systems.proofs import Cover
from verify.claims.formula import agents
from verify.question import Budgets, Question
from verify.reach.covering import Covering, OpenParts, Search
from verify.reach.forever.lasting import lasting
from verify.reach.play.samples import Starts, courses
from verify.reach.play.shrinking import shrink_counterexample
from verify.reach.replay import replay_course
from verify.reach.results import OpenState, ReachOutcome, about_nothing
from verify.reach.symbolic import Allowed, SymbolicSearch, helping, open_state, start_of
from verify.reach.unfolding import Merging
from verify.reach.witnesses import inhabitant
from verify.result import Verdict
from verify.spending import OPTION, BudgetSpentError, Spending
from verify.subjects import ClosedLoop
from verify.systems.claims import SystemClaim
from verify.systems.system import System, ensure_in_steps

STAGES = (  # how symbolic states are merged, and the symbolic states and linear programs that are tried at first
    (None, 50_000, 2_000),  # without errors bounds settle most questions
    (Merging(16, 1), 20_000, 30_000),
    (Merging(64, 4), 20_000, 30_000),
    (Merging(256, 16), 40_000, 30_000),
)
GROWTH = 4  # of what is tried, once no stage had enough
FIRST_SAMPLES = 256  # episodes that are played before anything is proved, where no boxes are tried
LASTING = 2_000_000  # boxes for an invariant


def decide(question: Question[SystemClaim]) -> ReachOutcome:
    """The answer to a question. InputError for agents or features that the system does not state."""
    assert isinstance(question.subject, ClosedLoop)
    profile, system = question.profile, question.subject.system
    ensure_stated(profile, system)
    _ensure_asked(profile, system, question.claim)
    return ClaimSearch(profile, system, question.claim, question.budgets).decide()


class ClaimSearch:
    """The search for the answer to one claim. `spending`: what it spent so far."""

    def __init__(self, profile: PolicyProfile, system: System, claim: SystemClaim, budgets: Budgets) -> None:
        self.profile, self.system, self.claim, self.budgets = profile, system, claim, budgets
        self.spending = Spending(budgets.max_boxes)
        self._open: OpenState | None = None
        self._start: Mapping[str, Fraction] | Verdict | None = None

    def decide(self) -> ReachOutcome:
        """The answer, with what was spent on it."""
        try:
            outcome = self._run_stages()
        except BudgetSpentError:
            outcome = self._play_last() or self._report_spent()
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

    # --- boxes

    def _try_covers(self) -> ReachOutcome | None:
        """PROVED where boxes that the checker accepts cover all episodes; VIOLATED by a start of a part left open."""
        for cover in Search(self.profile, self.system, self.claim, self.spending).iterate_covers():
            found = self._accept(cover) if isinstance(cover, Covering) else self._play_open(cover)
            if found is not None:
                return found
        return None

    def _accept(self, covering: Covering) -> ReachOutcome | None:
        """The answer by a cover that the checker accepts; a razor-thin one it refuses, as it rounds outward."""
        self._start = self._start or inhabitant(self.system, self.claim)
        if isinstance(self._start, Verdict):
            return about_nothing(self.claim, self._start)
        proof = Cover(covering.widths, encode_numbers(covering.cuts), "forms" if covering.forms else "boxes")
        made = certify(self.profile, self.system, self.claim, self._start, proof)
        with suppress(RejectedError):
            count = accept(made, self.profile, self.system)
            return ReachOutcome(Verdict.PROVED, certificate=made, branches=count)
        return None

    # --- episodes

    def _play_open(self, open_: OpenParts) -> ReachOutcome | None:
        """VIOLATED where one of some episodes from what is left open breaks the claim."""
        names, (parts, played) = [one.name for one in self.system.variables], open_
        ends = zip(names, parts[0].low.tolist(), parts[0].high.tolist(), strict=True)
        self._open = OpenState(0, {name: (least, most) for name, least, most in ends})
        some = [parts[at] for at in np.linspace(0, len(parts) - 1, min(len(parts), played)).astype(np.int64).tolist()]
        boxes = np.array([one.low for one in some]), np.array([one.high for one in some])
        return self._play(Starts(min(played, self.budgets.samples), boxes))

    def _play_last(self) -> ReachOutcome | None:
        """Plays all samples, like `_play`, where there would be no answer: whatever is left of the budget, so that a
        claim that is plainly false is VIOLATED with any.
        """
        return self._play(Starts(self.budgets.samples), whatever_is_left=True)

    def _play(self, at: Starts, whatever_is_left: bool = False) -> ReachOutcome | None:
        """VIOLATED where one of so many random episodes breaks the claim."""
        if not at.episodes:
            return None
        states = at.episodes * (1 + self.claim.steps)
        if not whatever_is_left:
            self.spending.ensure_left(states)
        self.spending.played += states
        for course in courses(self.profile, self.system, self.claim, at):
            found = replay_course(self.profile, self.system, self.claim, course)
            if found is not None:
                short = shrink_counterexample(self.profile, self.system, self.claim, found)
                return ReachOutcome(Verdict.VIOLATED, counterexample=short)
        return None

    # --- for ever, and symbolic states

    def _for_ever(self) -> ReachOutcome:
        outcome = lasting(self.profile, self.system, self.claim, min(self.spending.left, LASTING))
        with suppress(BudgetSpentError):  # the outcome says more than that: which state leaves, and where it goes
            self.spending.states += outcome.states
            self.spending.programs += outcome.programs
            self.spending.take(outcome.boxes)
        return (self._play_last() if outcome.verdict is Verdict.UNKNOWN else None) or outcome

    def _symbolic(self) -> ReachOutcome:
        """Stages, until one has an answer. BudgetSpentError."""
        search, growth = SymbolicSearch(self.profile, self.system, self.claim, self.spending), 1
        while True:
            for merging, states, programs in STAGES:
                try:
                    outcome = search.try_stage(merging, Allowed(states * growth, programs * growth))
                finally:
                    self._open = search.open or self._open
                if outcome is not None:
                    return (self._play_last() if outcome.verdict is Verdict.UNKNOWN else None) or outcome
            growth *= GROWTH

    def _report_spent(self) -> ReachOutcome:
        """No answer, since all is spent."""
        start = start_of(self.system, self.claim) if self._open is None else None
        left = open_state(start) if start is not None else self._open
        spent, most = self.spending, self.spending.most
        said = f"stopped after {spent.words} without a proof: {OPTION} is {most:,}"
        more = f"a larger {OPTION} than {most:,}"
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


def _ensure_asked(profile: PolicyProfile, system: System, claim: SystemClaim) -> None:
    claim.ensure()
    strange = agents(claim.formula) - {policy.agent for policy in profile.agents}
    if strange:
        raise UnknownNameError("agent", min(strange), [policy.agent for policy in profile.agents], claim.shown)
    if not claim.about_decisions:
        ensure_in_steps(system, "the engine of steps")
    if claim.steps and not claim.about_decisions and not system.pieces:
        what = f"system {system.name} states no dynamics, so nothing can be said of episodes"
        raise InputError(what, f"claim {claim.shown}", "state how it moves, or claim something about decisions")
