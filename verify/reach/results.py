"""What the search of a stated system gives: a verdict with what it rests on and what was spent.

Does: the data of an outcome and of a counterexample.
Assumes: nothing.
Does not: decide.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from typing import TYPE_CHECKING

from codegen.rows import Shown
from verify.result import Verdict

if TYPE_CHECKING:
    from verify.checker.systems.proofs import SystemCertificate
    from verify.systems.claims import SystemClaim

Values = Mapping[str, Fraction]
NOTHING = {  # by what a claim is about: why it is about nothing, and why nothing shows that it is about something
    True: (
        "the claim is about no state: its region is empty",
        "it holds of all states, but no exact state was found to show that there is one",
        "a region whose bounds lie further apart",
    ),
    False: (
        "the claim is about no episode: no state is a start that it speaks of",
        "it holds of all episodes, but no exact start was found to show that there is one",
        "a start region whose bounds lie further apart",
    ),
}


@dataclass(frozen=True, repr=False)
class SystemCounterexample(Shown):
    """An exact episode that breaks a claim.

    For example:

        maviper.verify_system(team, "corridor.toml").results[0].counterexample.start
    """

    states: tuple[Values, ...]  #: the start first; for a claim about decisions only that
    actions: tuple[Mapping[str, str], ...]  #: the joint action in each state but the last, by names
    errors: tuple[Values, ...]  #: of each step, by variable
    pieces: tuple[int, ...]  #: which piece moved each state but the last
    step: int  #: the state that breaks the claim; of `reaches` the last one
    #: of each step: what was taken of each choice, in the words of the file
    choices: tuple[Mapping[str, str], ...] = ()
    seconds: Fraction | None = None  #: of a flow: when that is; states but the first are middles of narrow enclosures
    longer: tuple[Fraction, ...] = (Fraction(0),)  #: of a flow: seconds by which its periods are longer than stated
    ways: tuple[int, ...] = (0,)  #: of a flow: in which way each sample is late; as of `longer`, the last one stays
    rank: int = 0  #: of a flow: which of the cases that hold a state is taken, in turn

    @property
    def start(self) -> Values:
        """Its start, exact."""
        return self.states[0]

    @property
    def start_as_doubles(self) -> dict[str, float]:
        """Its start, each number as the nearest float64."""
        return {name: float(value) for name, value in self.start.items()}


@dataclass(frozen=True)
class OpenState:
    """A symbolic state, a set of states that is followed as one, of which nothing is known.

    `bounds`: of each variable, in its unit; as bounds alone tell, so the set may be smaller.
    """

    step: int
    bounds: Mapping[str, tuple[float, float]]


@dataclass(frozen=True)
class ReachOutcome:
    """The answer to a question. Of the stated system, with an error within its bounds at every step."""

    verdict: Verdict
    reason: str = ""  # why there is no answer
    open: OpenState | None = None  # what an UNKNOWN leaves open, where that is a set of states
    helps: tuple[str, ...] = ()  # what may give an answer
    certificate: SystemCertificate | None = field(default=None, repr=False)  # of what is PROVED
    branches: int = 0  # that the checker closed; of a cover its boxes
    counterexample: SystemCounterexample | None = None  # of what is VIOLATED
    states: int = 0  # symbolic states that were visited
    programs: int = 0  # linear programs that were solved
    boxes: int = 0  # that were tried, over all steps and attempts
    reused: str = ""  # how much of an earlier proof holds as it was


def about_nothing(claim: SystemClaim, verdict: Verdict) -> ReachOutcome:
    """The answer to a claim that holds, of which no state was found: VACUOUS where there is none, else UNKNOWN."""
    empty, unfound, helps = NOTHING[claim.about_decisions]
    return ReachOutcome(verdict, empty if verdict is Verdict.VACUOUS else unfound, helps=(helps,))
