"""Counterexamples of the real agents: what float64 or float32 gives, in states and in episodes of their game.

Does: plays again what breaks a claim by a world file with errors, and looks for what breaks it anywhere.
Assumes: a world file that states what agents observe, up to errors for their roundings.
Does not: decide: whatever is found breaks the claim exactly.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from enum import Enum, auto

from codegen.ir import PolicyProfile
from maviper.verification.games import playing
from maviper.verification.games.searching import iterate_anywhere, iterate_near
from maviper.verification.worlds import Started
from maviper.worlds.stated.observing import ensure_observed
from verify.reach.replay import Course, replay_course
from verify.reach.results import SystemCounterexample
from verify.reach.rounded import fails, iterate_failing, observable, truly
from verify.systems.claims import SystemClaim
from verify.systems.properties import parse_written
from verify.systems.statement import Statement
from verify.systems.system import State


class Variables(Enum):
    """The kinds of variables of a world file."""

    STATED = auto()  # what a user states
    OBSERVED = auto()  # observations: a counterexample is one of floats
    COORDINATES = auto()  # of a game: a counterexample is one of its states


@dataclass(frozen=True)
class RealAgents:
    """The agents of a profile as they compute, and the world file that proofs read of them."""

    profile: PolicyProfile  # as proofs read it
    origin: PolicyProfile  # as it was given
    statement: Statement
    variables: Variables
    started: Started | None  # of claims about episodes of a game: from where

    def confirm(self, claim: SystemClaim, counterexample: SystemCounterexample) -> SystemCounterexample | None:
        """A counterexample of the real agents. AssertionError where the reference, asked for what they give in its
        state, does not break the formula as it was written: that is our bug.
        """
        again = self._play_again(claim, counterexample)
        if again is not None and claim.about_decisions:
            said = parse_written(claim, self.statement, self.profile)
            if said is not None and not fails(self.statement, self.profile, said, again.start):
                raise AssertionError(f"the reference breaks no formula at {dict(again.start)}: {claim.written}")
        return again

    def look_anywhere(self, claim: SystemClaim) -> SystemCounterexample | None:
        """A counterexample in the game, anywhere in the claim's regions, or from anywhere in its start."""
        if not claim.about_decisions:
            return self._first_played(claim, playing.iterate_anywhere(self._game, claim))
        return self._first_broken(claim, iterate_anywhere(self.origin, self.statement, claim))

    def look_drawn(self, claim: SystemClaim) -> SystemCounterexample | None:
        """A counterexample of the real agents, wherever they break a claim about decisions."""
        written = parse_written(claim, self.statement, self.profile)
        drawn = () if written is None else iterate_failing(self.statement, self.profile, claim, written)
        known = (SystemCounterexample((state,), (), (), (), 0) for state in drawn)
        return next(filter(None, (self.confirm(claim, each) for each in known)), None)

    def _play_again(self, claim: SystemClaim, known: SystemCounterexample) -> SystemCounterexample | None:
        """A counterexample of the real agents beside another one. AssertionError where the game shows an agent other
        numbers than its file: that is our bug.
        """
        if self.variables is Variables.COORDINATES and not claim.about_decisions:
            return self._first_played(claim, playing.iterate_near(self._game, claim, known.start))
        if self.variables is Variables.COORDINATES:
            return self._first_broken(claim, iterate_near(self.origin, self.statement, claim, known.start))
        confirmed = observable if self.variables is Variables.OBSERVED else truly
        return confirmed(self.statement, self.profile, claim, known)

    def _first_broken(self, claim: SystemClaim, states: Iterable[State]) -> SystemCounterexample | None:
        """The first of some states of the game that breaks a claim."""
        for state in states:
            ensure_observed(self.origin, self.statement, state)
            again = truly(self.statement, self.profile, claim, SystemCounterexample((state,), (), (), (), 0))
            if again is not None:
                return again
        return None

    def _first_played(self, claim: SystemClaim, courses: Iterable[Course]) -> SystemCounterexample | None:
        """The first of some episodes of the game that breaks a claim."""
        for course in courses:
            again = replay_course(self.profile, self.statement.system, claim, course)
            if again is not None:
                return again
        return None

    @property
    def _game(self) -> playing.PlayedGame:
        assert self.started is not None
        return playing.PlayedGame(self.origin, self.profile, self.statement, self.started.goal)
