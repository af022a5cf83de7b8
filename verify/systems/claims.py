"""Claims about a stated system: what its agents do in one state, or where its episodes go.

Does: the data of such a claim, its words, and which states of an episode break or fulfil it.
Assumes: variables, agents and actions are those of the system and the profile that are asked about.
Does not: decide. It reads no files.

An episode is a start and `steps` steps, so it has steps + 1 states, numbered from 0.

    decides             the joint action makes `formula` true, in every state within the ranges of the variables that
                        lies in one of the regions (none: in all). Nothing moves.
    stays_in            every state lies in one of the regions
    avoids              no state lies in any of the regions
    reaches             some state lies in one of the regions
    reaches_and_stays   every state from number `by` on lies in one of the regions
    always              every state from number `by` on lies in one of the regions, however long the episode is

A claim for ever may assume regions: then it speaks of an episode only while all its states so far lie in one of these.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum
from typing import ClassVar, NamedTuple

from codegen.errors import InputError
from verify.claims.formula import (
    FALSE,
    TRUE,
    Formula,
    Goal,
    atoms,
    below,
    conjunction,
    disjunction,
    negate,
)
from verify.kinds import MACHINE, Kind
from verify.systems.expressions import Affine, Box, Expression, Interval, State
from verify.systems.system import HalfSpace, Polytope

MAX_STEPS = 1_000


class Pattern(Enum):
    """The statement of a claim about its regions; the values are the words of files."""

    DECIDES = "decides"
    STAYS_IN = "stays_in"
    AVOIDS = "avoids"
    REACHES = "reaches"
    REACHES_AND_STAYS = "reaches_and_stays"
    ALWAYS = "always"


class _Says(NamedTuple):
    """The statement of a claim about the states of an episode."""

    words: str
    first: str = ""  # the parameter that is the step from which on states count; "": the start
    avoided: bool = False  # whether the regions are to be avoided
    once: bool = False  # whether one state in the regions is enough
    still: bool = False  # whether it speaks of single decisions instead
    ever: bool = False  # whether it speaks of all steps, however many; counterexamples are looked for in `steps`
    late: str = ""  # the words where `by` is above 0, if these are others


SAYS: Mapping[Pattern, _Says] = {
    Pattern.DECIDES: _Says("in every state {regions}, the agents decide as claimed", still=True),
    Pattern.STAYS_IN: _Says("every episode of {steps} steps stays in {regions}"),
    Pattern.AVOIDS: _Says("every episode of {steps} steps avoids {regions}", avoided=True),
    Pattern.REACHES: _Says("every episode reaches {regions} within {steps} steps", "steps", once=True),
    Pattern.REACHES_AND_STAYS: _Says("every episode is in {regions} from step {by} to step {steps}", "by"),
    Pattern.ALWAYS: _Says(
        "every episode stays in {regions} for ever",
        "by",
        ever=True,
        late="every episode is in {regions} by step {by}, and from then on always",
    ),
}


class Denied(NamedTuple):
    """The left side of an implication in words, and the claim that it never holds."""

    words: str
    claim: SystemClaim


class SystemPremise(NamedTuple):
    """The left side of an implication, with a state that meets it."""

    formula: Formula
    state: State


class CurveOverCell(NamedTuple):
    """An expression is a form over a box, with an error within bounds."""

    curve: Expression
    cell: Box
    form: Affine
    error: Interval


@dataclass(frozen=True)
class CurvedClaim:
    """The relation of a claim to one whose formula has curves, `written` in a file: it implies that one, which implies
    `weaker`, since `enclosures` hold, over cells that fill the ranges of what they name. Whoever makes one knows that
    (curves.py), or shows it (verify/checker/systems/enclosures.py).
    """

    weaker: SystemClaim
    enclosures: tuple[CurveOverCell, ...]


@dataclass(frozen=True)
class SystemClaim:
    """A claim about a system and all who act in it. `regions`: polytopes, a state need lie in one of them only."""

    kind: ClassVar[Kind] = Kind.SYSTEMS
    per_state: ClassVar[bool] = False  # world states are those of games
    limits: ClassVar[tuple[str, ...]] = ("max_boxes",)
    arithmetics: ClassVar[tuple[str, ...]] = (MACHINE,)
    pattern: Pattern
    regions: tuple[Polytope, ...] = ()
    steps: int = 0  # of an episode
    by: int = 0  # reaches_and_stays, always: the first step from which on the state lies in the regions
    formula: Formula = TRUE  # decides: over variables and actions
    # of a system in continuous time: whether it is about samples only; None: the system moves in steps
    at_samples: bool | None = None
    assuming: tuple[
        Polytope, ...
    ] = ()  # always: the regions that an episode lies in while the claim speaks of it; none: all
    invariant: tuple[Polytope, ...] = field(default=(), compare=False)  # always: what a user proposes; it means nothing
    assumed: str = field(default="", compare=False)  # what a user calls the regions that are assumed
    label: str = field(default="", compare=False)  # what a user calls it
    region: str = field(default="", compare=False)  # what a user calls the regions
    written: str = field(default="", compare=False)  # decides: the formula as a user wrote it
    curved: CurvedClaim | None = field(default=None, compare=False)  # decides: where the formula as written has curves
    conditions: tuple[Denied, ...] = field(default=(), compare=False)  # decides: the left sides of implications
    rounded: tuple[tuple[str, str], ...] = field(default=(), compare=False)  # numbers as written, and as they are read
    premises: tuple[SystemPremise, ...] = field(default=(), compare=False)  # decides: states that meet them

    @property
    def team(self) -> str:
        """None: it is about all agents."""
        return ""

    @property
    def name(self) -> str:
        """The name of the property."""
        return self.pattern.value

    @property
    def shown(self) -> str:
        """The label, or else the name."""
        return self.label or self.name

    @property
    def sentence(self) -> str:
        """The claim in words."""
        called = self.region or "the region"
        if self.about_decisions:
            called = f"of the ranges {self.region or 'and of the region'}" if self.regions else "of the ranges"
        times = {None: "", True: ", at samples", False: ", at all times"}[self.at_samples]
        while_in = f", as long as it stays in {self.assumed or 'what is assumed'}" if self.assuming else ""
        words = (self.by and self.says.late) or self.says.words
        return words.format(regions=called, steps=self.steps, by=self.by) + times + while_in

    @property
    def says(self) -> _Says:
        """The statement about the states of an episode."""
        return SAYS[self.pattern]

    @property
    def about_decisions(self) -> bool:
        """True if the claim speaks of one state and what is decided there, not of episodes."""
        return self.says.still

    @property
    def inside(self) -> Formula:
        """That a state lies in one of the regions."""
        return _in_one_of(self.regions)

    @property
    def spoken_of(self) -> Formula:
        """That a state lies in one of the regions that are assumed."""
        return _in_one_of(self.assuming) if self.assuming else TRUE

    def violation_at(self, step: int) -> Formula:
        """The states that the claim excludes at a step of an episode."""
        if self.says.avoided:
            return self.inside
        first = {"": 0, "steps": self.steps, "by": self.by}[self.says.first]
        outside = negate(self.inside) if step >= first else FALSE
        return conjunction(self.spoken_of, outside) if self.assuming else outside

    def fulfilment_at(self, step: int) -> Formula:
        """The states of a step with which an episode fulfils the claim, whatever comes later."""
        if self.assuming:
            return negate(self.spoken_of)
        return self.inside if self.says.once and step < self.steps else FALSE

    def ensure(self) -> None:
        """InputError for steps out of range, for a claim about episodes that names no region, and for a goal."""
        if any(isinstance(part, Goal) for part in atoms(self.formula)):
            raise InputError("a stated system has no goal", f"claim {self.shown}", "name its variables instead")
        if self.about_decisions:
            return
        if not 0 <= self.steps <= MAX_STEPS:
            raise InputError(f"an episode has 0 to {MAX_STEPS} steps, given {self.steps}", f"claim {self.shown}")
        if not 0 <= self.by <= self.steps:
            raise InputError(f"step {self.by} is no step of an episode of {self.steps}", f"claim {self.shown}")
        if not self.regions:
            raise InputError(f"{self.name} names no region", f"claim {self.shown}", "name a polytope at least")
        if self.assuming and not self.says.ever:
            raise InputError(f"{self.name} assumes nothing", f"claim {self.shown}", "only claims for ever do")


def _in_one_of(regions: tuple[Polytope, ...]) -> Formula:
    """That a state lies in one of some regions."""
    return disjunction(*(conjunction(*map(atom, polytope)) for polytope in regions))


def atom(half: HalfSpace) -> Formula:
    """That a state lies in a half space."""
    return below(dict(half.form.terms), -half.form.constant, half.strict)
