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
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from enum import Enum
from fractions import Fraction

from codegen.errors import InputError
from verify.claims.formula import (
    FALSE,
    TRUE,
    Acts,
    And,
    Formula,
    Goal,
    Linear,
    Not,
    Or,
    atoms,
    below,
    conjunction,
    disjunction,
    negated,
)
from verify.claims.region import plain
from verify.systems.system import Affine, HalfSpace, Polytope

MAX_STEPS = 1_000


class SystemKind(Enum):
    """What a claim says; the values are the words of files."""

    DECIDES = "decides"
    STAYS_IN = "stays_in"
    AVOIDS = "avoids"
    REACHES = "reaches"
    REACHES_AND_STAYS = "reaches_and_stays"


WORDS = {
    SystemKind.DECIDES: "in every state {regions}, the agents decide as claimed",
    SystemKind.STAYS_IN: "every episode of {steps} steps stays in {regions}",
    SystemKind.AVOIDS: "every episode of {steps} steps avoids {regions}",
    SystemKind.REACHES: "every episode reaches {regions} within {steps} steps",
    SystemKind.REACHES_AND_STAYS: "every episode is in {regions} from step {by} to step {steps}",
}


@dataclass(frozen=True)
class SystemClaim:
    """A claim about a system and a team. `regions`: polytopes, a state need lie in one of them only."""

    name: str
    kind: SystemKind
    regions: tuple[Polytope, ...] = ()
    steps: int = 0  # of an episode
    by: int = 0  # reaches_and_stays: the first step at which the state lies in the regions
    formula: Formula = TRUE  # decides: over variables and actions
    label: str = field(default="", compare=False)  # what a user calls it
    region: str = field(default="", compare=False)  # what a user calls the regions
    written: str = field(default="", compare=False)  # decides: the formula as a user wrote it

    @property
    def shown(self) -> str:
        """The label, or else the name."""
        return self.label or self.name

    @property
    def sentence(self) -> str:
        """The claim in words."""
        usual = "of the ranges" if self.about_decisions and not self.regions else "of the region"
        called = self.region or (usual if self.about_decisions else "the region")
        return WORDS[self.kind].format(regions=called, steps=self.steps, by=self.by)

    @property
    def about_decisions(self) -> bool:
        """Whether it speaks of one state and what is decided there, not of episodes."""
        return self.kind is SystemKind.DECIDES

    @property
    def inside(self) -> Formula:
        """That a state lies in one of the regions."""
        return disjunction(*(conjunction(*map(atom, polytope)) for polytope in self.regions))

    def broken(self, step: int) -> Formula:
        """The states that the claim excludes at a step of an episode."""
        if self.kind is SystemKind.AVOIDS:
            return self.inside
        if self.kind is SystemKind.REACHES:
            return negated(self.inside) if step == self.steps else FALSE
        asked = self.kind is SystemKind.STAYS_IN or step >= self.by
        return negated(self.inside) if asked else FALSE

    def fulfilled(self, step: int) -> Formula:
        """The states of a step with which an episode fulfils the claim, whatever comes later."""
        return self.inside if self.kind is SystemKind.REACHES and step < self.steps else FALSE

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


def spelled(claim: SystemClaim, actions: Mapping[str, Sequence[str]]) -> str:
    """The claim in words that are made from its data alone, as a file's own words may say anything. `actions`: of each
    agent, by number.
    """
    regions = " or ".join(_conditions(region) for region in claim.regions)
    if not claim.about_decisions:
        return replace(claim, region=regions).sentence
    where = f"with {regions}" if regions else "of the ranges"
    return f"in every state {where}, {_formula(claim.formula, actions)}"


def _conditions(region: Polytope) -> str:
    return " and ".join(map(_condition, region)) or "any state"


def _condition(half: HalfSpace) -> str:
    """An inequality whose first factor is 1."""
    lead = half.form.terms[0][1] if half.form.terms else Fraction(1)
    form = Affine().plus(half.form, 1 / lead)
    return f"{_sum(form.terms)} {'<' if lead > 0 else '>'}{'' if half.strict else '='} {plain(-form.constant)}"


def _sum(terms: Sequence[tuple[str, Fraction]]) -> str:
    found = ""
    for name, factor in terms:
        times = name if abs(factor) == 1 else f"{plain(abs(factor))}*{name}"
        sign = "-" if factor < 0 else "+"
        found += f" {sign} {times}" if found else times if factor > 0 else f"-{times}"
    return found or "0"


def _formula(formula: Formula, actions: Mapping[str, Sequence[str]]) -> str:
    match formula:
        case Linear(terms, bound, strict):
            return _condition(HalfSpace(Affine.of({name: factor for factor, name in terms}, -bound), strict))
        case Acts(agent, action):
            return f"acts({agent}) == {actions[agent][action]}"
        case Not(part):
            return f"not {_formula(part, actions)}"
        case And(()) | Or(()):
            return "true" if isinstance(formula, And) else "false"
        case And(parts) | Or(parts):
            joined = f" {'and' if isinstance(formula, And) else 'or'} ".join(_formula(part, actions) for part in parts)
            return f"({joined})"
        case Goal(landmark):
            return f"goal == {landmark}"


def atom(half: HalfSpace) -> Formula:
    """That a state lies in a half space."""
    return below(dict(half.form.terms), -half.form.constant, half.strict)
