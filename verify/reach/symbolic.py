"""Symbolic states and linear programs for one claim: what boxes leave open, a stage at a time.

Does: shows a claim in parts, each of which follows only the variables that it depends on; if that fails, follows all
  variables, and replays an episode into what is left open.
Assumes: a checked profile, system and claim.
Does not: choose how much a stage may spend (decide.py does).
"""

from __future__ import annotations

from collections.abc import Generator
from contextlib import contextmanager, suppress
from typing import NamedTuple

from codegen.ir import PolicyProfile
from codegen.numbers import nearest_double
from verify.certificates.systems import certify
from verify.checker.accept import accept
from verify.checker.systems.proofs import FollowedPart, Walks
from verify.checker.systems.reading import SystemReading
from verify.checker.systems.rows import UNIT, Branch
from verify.reach.parts import iterate_divisions, whole
from verify.reach.play.shrinking import shrink_counterexample
from verify.reach.replay import replay_course
from verify.reach.results import OpenState, ReachOutcome, SystemCounterexample, about_nothing
from verify.reach.search import Open, ReachBudgetError, SystemProver
from verify.reach.unfolding import Merging, Unfolding
from verify.reach.witnesses import inhabitant, witnesses
from verify.result import Verdict
from verify.spending import OPTION, BudgetSpentError, Spending
from verify.systems.claims import SystemClaim
from verify.systems.system import System

LEFT_OPEN = {  # by what a claim is about: single decisions, or episodes
    True: "some states may break the claim: no state was found that does, nor a proof that none does",
    False: "some states may break the claim: no episode into them was found that replays, nor a proof that none gets "
    "there",
}
UNSTATED = "an episode may leave the states for which dynamics are stated"
NEAR = "a region that is a little larger or smaller, as its bounds may be met exactly"
WIDER = "wider ranges or boxes of pieces, so that dynamics are stated of more states"
PARTED = 3  # a part that can be shown alone takes few symbolic states; what it does not follow may make many
MAX_OPEN = 64  # branches in which an episode is looked for


class Allowed(NamedTuple):
    """Symbolic states and linear programs that a stage may spend."""

    max_states: int
    max_programs: int


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
        fewer = allowed._replace(max_states=allowed.max_states // PARTED)
        for number, parts in enumerate(iterate_divisions(self._system, self._claim)):
            if (merging, number) not in self._failed:
                with suppress(ReachBudgetError), self._noting((merging, number)):
                    return self._certify_parts([self._prove_part(part, self._stop, merging, fewer) for part in parts])
        if (merging, -1) not in self._failed:
            with suppress(ReachBudgetError), self._noting((merging, -1)):
                return self._together(merging, allowed)
        return None

    @contextmanager
    def _noting(self, stage: tuple[Merging | None, int]) -> Generator[None]:
        """Notes a stage that leaves a branch open."""
        try:
            yield
        except _OpenError:
            self._failed.add(stage)

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
        state = inhabitant(self._system, self._claim)
        if isinstance(state, Verdict):
            return about_nothing(self._claim, state)
        certificate = certify(self._profile, self._system, self._claim, state, Walks(tuple(parts)))
        closed = accept(certificate, self._profile, self._system)
        return ReachOutcome(Verdict.PROVED, certificate=certificate, branches=closed)


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
    """A symbolic state as reports tell it."""
    return OpenState(branch.step, {name: _bounds(branch, name) for name in branch.at})


def _bounds(branch: Branch, name: str) -> tuple[float, float]:
    """Bounds of a variable in a symbolic state, which may be wider than it."""
    low = high = nearest_double(branch.at[name])
    for unknown, weight in branch.motion.weights[name].items():
        span = branch.box.get(unknown, UNIT)
        ends = sorted((nearest_double(weight * span.low), nearest_double(weight * span.high)))
        low, high = low + ends[0], high + ends[1]
    return low, high
