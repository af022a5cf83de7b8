"""A world file as data: the system, who acts in it how, and the rules as they are written.

Does: what a file states beyond the system that proofs are about.
Assumes: whoever makes one has checked it (files.py).
Does not: read files or play.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction

from codegen.errors import InputError
from verify.language.units import Unit
from verify.systems.expressions import (
    Expression,
    Name,
    Number,
    Product,
    affine,
    names,
    of_affine,
    substitute,
    terms,
    total,
)
from verify.systems.lowered import Acting
from verify.systems.parsing import CASE, Names, input_of
from verify.systems.system import Box, Interval, Polytope, System, Variable
from verify.toml_places import Place

Effect = Mapping[tuple[str, str], Mapping[str, Expression]]  # (agent, action) -> variable -> what it adds


@dataclass(frozen=True)
class Agent:
    """An agent: its team, and what each of its actions sets its inputs to, `AGENT.INPUT`. `reward` is what it
    is paid on entering a state; claims and proofs do not know it.
    """

    name: str
    team: str
    actions: Mapping[str, Mapping[str, Expression]]
    reward: Expression
    outputs: tuple[str, ...] = ()  # where it gives numbers; its actions are then those of a profile (lowered.py)
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
    `next`: next values over variables and inputs, of which `move` and `effect` say what actions do.
    """

    where: Box
    move: Mapping[str, Expression]
    effect: Effect
    error: Mapping[str, Interval]
    cuts: Mapping[str, int]  # parts of a range where something is not affine
    when: Polytope
    choice: Mapping[str, str]
    place: Place = field(compare=False)
    next: Mapping[str, Expression] = field(compare=False)

    def of_actions(self, agents: Sequence[Agent]) -> Rule:
        """The rule for what actions of agents set. InputError where their effects do not add up."""
        if not self.next:
            return self
        move: dict[str, Expression] = {}
        effect: dict[tuple[str, str], dict[str, Expression]] = {}
        for name, expression in self.next.items():
            own, acted = _share_terms(expression, agents, self.place / "next" / name)
            move[name] = total(own)
            for agent in agents:
                for action, values in agent.actions.items():
                    if acted.get(agent.name):
                        added = substitute(total([*_taken(acted[agent.name], values)]), values)
                        effect.setdefault((agent.name, action), {})[name] = added
        return replace(self, move={**move, **{n: e for n, e in self.move.items() if n not in move}}, effect=effect)


def _taken(acted: Sequence[Expression], values: Mapping[str, Expression]) -> Iterator[Expression]:
    """The terms that hold where an action sets inputs: of cases that it chooses between, the one that it takes."""
    for term in acted:
        match term:
            case Product(Name(name), then) if CASE in name:
                if values[name] == Number(Fraction(1)):
                    yield then
            case _:
                yield term


def _share_terms(
    expression: Expression, agents: Sequence[Agent], where: Place
) -> tuple[list[Expression], dict[str, list[Expression]]]:
    """The terms without inputs, and those of each agent's. What is not affine goes to the one agent that has such
    terms too: together they are enclosed more tightly.
    """
    form = affine(expression)
    own: list[Expression] = []
    acted: dict[str, list[Expression]] = {}
    for term in terms(expression if form is None else of_affine(form)):
        owners = [agent.name for agent in agents if agent.inputs & names(term)]
        if len(owners) > 1:
            what = f"one term holds actions of {' and '.join(owners)}"
            raise InputError(what, where, "effects of agents must add up: write a sum of terms")
        (acted.setdefault(owners[0], []) if owners else own).append(term)
    curved = [name for name, shares in acted.items() if any(affine(term) is None for term in shares)]
    if len(curved) == 1:
        acted[curved[0]] += [term for term in own if affine(term) is None]
        own = [term for term in own if affine(term) is not None]
    return own, acted


def set_modes(agents: Sequence[Agent], variables: Sequence[Variable]) -> list[Agent]:
    """The agents, whose actions set each mode of their name too, where they say of none which one they set."""
    modes = [each for each in variables if each.modes]
    setters: list[Agent] = []
    for agent in agents:
        actions = dict(agent.actions)
        for mode in modes:
            name = input_of(agent.name, mode.name)
            if all(name in values or action in mode.modes for action, values in agent.actions.items()):
                for action in agent.actions.keys() & {*mode.modes}:
                    own = {name: Number(Fraction(mode.modes.index(action)))}
                    actions[action] = {**own, **actions[action]}
        setters.append(replace(agent, actions=actions))
    return setters


@dataclass(frozen=True)
class Statement:
    """The statements of a file. `system.pieces` are the rules, with enclosures for what is not affine."""

    system: System
    agents: tuple[Agent, ...]
    rules: tuple[Rule, ...]
    names: Names = field(compare=False)  # what regions and claims may name
    properties: Mapping[str, object] = field(compare=False)  # tables of claims
    place: Place = field(compare=False)  # of the file
    state: str  # the attribute of the reference environment that holds the variables in order
    inputs: Mapping[str, Unit] = field(compare=False)  # what actions and outputs set
    acting: Mapping[str, Acting] = field(compare=False)  # who tests sums in it, read
    observed: bool  # whether variables are features, and decimals beside them floats

    @property
    def gives(self) -> tuple[str, ...]:
        """The agents that give numbers, as long as no profile says which."""
        return tuple(each.name for each in self.agents if each.outputs and each.name not in self.acting)

    @property
    def moves(self) -> bool:
        """True if the statement says how the state moves."""
        return bool(self.rules) or self.system.flow is not None
