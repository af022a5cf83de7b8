"""A world file as data: the system, who acts in it how, and the rules as they are written.

Does: what a file states beyond the system that proofs are about.
Assumes: whoever makes one has checked it (files.py).
Does not: read files or play.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field

from verify.language.arithmetic import Unit
from verify.systems.expressions import Expression
from verify.systems.lowered import Acting
from verify.systems.parsing import Names
from verify.systems.system import Box, Interval, Polytope, System
from verify.toml_places import Place


@dataclass(frozen=True)
class Agent:
    """An agent: its team, and what each of its actions sets its inputs to, `AGENT.INPUT`. `reward` is what it
    is paid on entering a state; claims and proofs do not know it.
    """

    name: str
    team: str
    actions: Mapping[str, Mapping[str, Expression]]
    reward: Expression
    outputs: tuple[
        str, ...
    ] = ()  # where it gives numbers; its actions are then those of a profile, see given/agents.py
    like: str = ""  # the agent by whose tree it acts; "": a profile has a tree of its own for it

    @property
    def inputs(self) -> frozenset[str]:
        """The names of its inputs."""
        return frozenset(name for values in self.actions.values() for name in values)


@dataclass(frozen=True)
class Rule:
    """The state's motion in a box, as it is written: the next value of a variable is its `move`, the effects of all
    agents' actions on it, and an error that the user states. `when`: further conditions of its states; `choice`: what
    is taken of each choice, in the words of the file, as all others are rules of their own. `place`: where it stands.
    """

    where: Box
    move: Mapping[str, Expression]
    effect: Mapping[tuple[str, str], Mapping[str, Expression]]  # (agent, action) -> variable -> what it adds
    error: Mapping[str, Interval]
    cuts: Mapping[str, int] = field(default_factory=dict[str, int])  # parts of a range where something is not affine
    when: Polytope = ()
    choice: Mapping[str, str] = field(default_factory=dict[str, str])
    place: Place = field(default=Place("", ""), compare=False)


@dataclass(frozen=True)
class Statement:
    """The statements of a file. `system.pieces` are the rules, with enclosures for what is not affine."""

    system: System
    agents: tuple[Agent, ...]
    rules: tuple[Rule, ...]
    names: Names = field(compare=False)  # what regions and claims may name
    properties: Mapping[str, object] = field(default_factory=dict[str, object], compare=False)  # tables of claims
    place: Place = field(default=Place("", ""), compare=False)  # of the file
    state: str = ""  # the attribute of the reference environment that holds the variables in order
    inputs: Mapping[str, Unit] = field(default_factory=dict[str, Unit], compare=False)  # what actions and outputs set
    source: str = field(default="", compare=False)  # the text of the file
    acting: Mapping[str, Acting] = field(default_factory=dict[str, Acting], compare=False)  # who tests sums in it, read
    observed: bool = False  # whether variables are features, and decimals beside them floats

    @property
    def gives(self) -> tuple[str, ...]:
        """The agents that give numbers, as long as no profile says which."""
        return tuple(each.name for each in self.agents if each.outputs and each.name not in self.acting)

    @property
    def moves(self) -> bool:
        """True if the statement says how the state moves."""
        return bool(self.rules) or self.system.flow is not None
