"""Claims as formulas over world coordinates and actions: what engines, referee and shares all read.

Does: the data of a formula, negation pushed to its atoms, substitution of actions, whether one holds at an exact point;
  reads formulas from the plain data of files.
Assumes: coordinates by name, exact numbers.
Does not: know properties (decisions.py), or decide anything.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import Any, NamedTuple, TypeAlias

from codegen.ir import GOAL
from verify.exact import read_number


class Linear(NamedTuple):
    """A sum of weight * coordinate is at most `bound`, or below it when `strict`."""

    terms: tuple[tuple[Fraction, str], ...]
    bound: Fraction
    strict: bool = False

    def __hash__(self) -> int:
        # names and a numerator tell atoms apart; to hash a fraction takes a modular inverse
        return hash((*[name for _, name in self.terms], self.bound.numerator, self.strict))


@dataclass(frozen=True)
class Acts:
    """The agent takes the action of that number."""

    agent: str
    action: int


@dataclass(frozen=True)
class Goal:
    """The landmark of that name is the goal."""

    landmark: str


@dataclass(frozen=True)
class _Joined:
    """Parts, and what is asked about them again and again, which is found once."""

    parts: tuple[Formula, ...]

    def __hash__(self) -> int:
        return self._hash

    @cached_property
    def _hash(self) -> int:
        return hash((type(self) is And, self.parts))

    @cached_property
    def agents(self) -> frozenset[str]:
        """The agents named in its parts; see the function `agents`."""
        return _NONE.union(*map(agents, self.parts))

    @cached_property
    def names_goal(self) -> bool:
        """True if a part names the goal; see the function `names_goal`."""
        return any(map(names_goal, self.parts))


class And(_Joined):
    """All parts hold; without parts it is true."""


class Or(_Joined):
    """Some part holds; without parts it is false."""


@dataclass(frozen=True)
class Not:
    """The part does not hold."""

    part: Formula


class Condition(NamedTuple):
    """The left side of an implication, which says nothing where it never holds."""

    words: str
    formula: Formula


Formula: TypeAlias = Linear | Acts | Goal | And | Or | Not
_NONE: frozenset[str] = frozenset()
_OF_GOAL = f"{GOAL}."
TRUE, FALSE = And(()), Or(())


def below(terms: Mapping[str, Fraction | int], bound: Fraction | int, strict: bool = False) -> Formula:
    """The atom `sum <= bound`; TRUE or FALSE where no term is left."""
    kept = tuple((_exact(weight), name) for name, weight in terms.items() if weight)
    if kept:
        return Linear(kept, _exact(bound), strict)
    return TRUE if bound > 0 or (bound == 0 and not strict) else FALSE


def _exact(number: Fraction | int) -> Fraction:
    return number if isinstance(number, Fraction) else Fraction(number)


def conjunction(*parts: Formula) -> Formula:
    """And, flat and without needless parts."""
    flat = [inner for part in parts for inner in (part.parts if isinstance(part, And) else (part,))]
    if any(isinstance(part, Or) and not part.parts for part in flat):
        return FALSE
    unique = tuple(dict.fromkeys(flat))
    return unique[0] if len(unique) == 1 else And(unique)


def disjunction(*parts: Formula) -> Formula:
    """Or, flat and without needless parts."""
    flat = [inner for part in parts for inner in (part.parts if isinstance(part, Or) else (part,))]
    if any(isinstance(part, And) and not part.parts for part in flat):
        return TRUE
    unique = tuple(dict.fromkeys(flat))
    return unique[0] if len(unique) == 1 else Or(unique)


def negate(formula: Formula) -> Formula:
    """Not the formula, with negations only before `Acts` and `Goal`."""
    if isinstance(formula, Linear):
        terms = tuple((-weight, name) for weight, name in formula.terms)
        return Linear(terms, -formula.bound, not formula.strict)
    if isinstance(formula, And):
        return disjunction(*map(negate, formula.parts))
    if isinstance(formula, Or):
        return conjunction(*map(negate, formula.parts))
    return normal(formula.part) if isinstance(formula, Not) else Not(formula)


def normal(formula: Formula) -> Formula:
    """The same formula, with negations only before `Acts` and `Goal`."""
    if isinstance(formula, And):
        return conjunction(*map(normal, formula.parts))
    if isinstance(formula, Or):
        return disjunction(*map(normal, formula.parts))
    return negate(formula.part) if isinstance(formula, Not) else formula


def substitute_actions(formula: Formula, actions: Mapping[str, int]) -> Formula:
    """The formula once the named agents have chosen: their `Acts` become true or false."""
    if isinstance(formula, Acts) and formula.agent in actions:
        return TRUE if actions[formula.agent] == formula.action else FALSE
    if isinstance(formula, (And, Or)):
        joined, settled = (conjunction, FALSE) if isinstance(formula, And) else (disjunction, TRUE)
        parts: list[Formula] = []
        for part in formula.parts:
            parts.append(substitute_actions(part, actions))
            if parts[-1] == settled:  # else each leaf of one agent would be asked about all leaves of others
                return settled
        return joined(*parts)
    if isinstance(formula, Not):
        part = substitute_actions(formula.part, actions)
        return FALSE if part == TRUE else TRUE if part == FALSE else Not(part)
    return formula


def for_goal(formula: Formula, goal: str | None) -> Formula:
    """The formula in worlds whose goal is the landmark `goal` (None: without goal): `Goal` becomes true or false, the
    goal's coordinates become the landmark's. A formula that does not name the goal stays as it is.
    """
    if not names_goal(formula):
        return formula
    if isinstance(formula, Goal):
        return TRUE if formula.landmark == goal else FALSE
    if isinstance(formula, Linear):
        if goal is None:
            return formula
        terms: dict[str, Fraction] = {}
        for weight, name in formula.terms:
            named = f"{goal}.{name.removeprefix(_OF_GOAL)}" if name.startswith(_OF_GOAL) else name
            terms[named] = terms.get(named, Fraction(0)) + weight
        return below(terms, formula.bound, formula.strict)
    if isinstance(formula, And):
        return conjunction(*(for_goal(part, goal) for part in formula.parts))
    if isinstance(formula, Or):
        return disjunction(*(for_goal(part, goal) for part in formula.parts))
    if isinstance(formula, Not):
        part = for_goal(formula.part, goal)
        return FALSE if part == TRUE else TRUE if part == FALSE else Not(part)
    return formula


def names_goal(formula: Formula) -> bool:
    """Returns True if the formula may say another thing for another goal: it asks which one it is, or where."""
    if isinstance(formula, (And, Or)):
        return formula.names_goal
    if isinstance(formula, Linear):
        return any(name.startswith(_OF_GOAL) for _, name in formula.terms)
    return names_goal(formula.part) if isinstance(formula, Not) else isinstance(formula, Goal)


def atoms(formula: Formula) -> Iterator[Linear | Acts | Goal]:
    """The parts of the formula that have no parts."""
    if isinstance(formula, (And, Or)):
        for part in formula.parts:
            yield from atoms(part)
    elif isinstance(formula, Not):
        yield from atoms(formula.part)
    else:
        yield formula


def agents(formula: Formula) -> frozenset[str]:
    """The agents whose actions the formula speaks of."""
    if isinstance(formula, Acts):
        return frozenset({formula.agent})
    if isinstance(formula, (And, Or)):
        return formula.agents
    return agents(formula.part) if isinstance(formula, Not) else _NONE


def conjuncts(formula: Formula) -> tuple[Formula, ...]:
    """Formulas that all hold exactly where the formula does: its conjuncts, those about the same agents in one."""
    if not isinstance(formula, And):
        return (formula,)
    about: dict[frozenset[str], list[Formula]] = {}
    for part in formula.parts:
        about.setdefault(agents(part), []).append(part)
    return tuple(parts[0] if len(parts) == 1 else And(tuple(parts)) for parts in about.values())


def coordinates(formula: Formula) -> frozenset[str]:
    """The coordinates that the formula speaks of."""
    if isinstance(formula, Linear):
        return frozenset(name for _, name in formula.terms)
    if isinstance(formula, (And, Or)):
        return _NONE.union(*map(coordinates, formula.parts))
    return coordinates(formula.part) if isinstance(formula, Not) else frozenset()


def holds(formula: Formula, at: Mapping[str, Fraction], actions: Mapping[str, int]) -> bool:
    """Returns True if the formula is true at an exact point, with the chosen actions; `for_goal` was applied before."""
    if isinstance(formula, Linear):
        total = sum((weight * at[name] for weight, name in formula.terms), Fraction(0))
        return total < formula.bound or (total == formula.bound and not formula.strict)
    if isinstance(formula, Acts):
        return actions[formula.agent] == formula.action
    assert not isinstance(formula, Goal), formula
    if isinstance(formula, And):
        return all(holds(part, at, actions) for part in formula.parts)
    if isinstance(formula, Or):
        return any(holds(part, at, actions) for part in formula.parts)
    return not holds(formula.part, at, actions)


DEEPEST = 100  # levels of a formula


def read_formula(document: Mapping[str, Any], depth: int = 0) -> Formula:
    """The formula in plain data. ValueError for anything else."""
    if depth > DEEPEST:
        raise ValueError(f"$.formula: nested deeper than {DEEPEST}")
    match document:
        case {"sum": [*terms], **bound} if len(bound) == 1 and set(bound) <= {"most", "below"}:
            kept = tuple((read_number(weight), str(name)) for weight, name in terms)
            ((kind, value),) = bound.items()
            return Linear(kept, read_number(value), kind == "below")
        case {"agent": str(agent), "takes": int(action)} if len(document) == 2:
            return Acts(agent, action)
        case {"goal": str(landmark)} if len(document) == 1:
            return Goal(landmark)
        case {"not": part} if len(document) == 1:
            return Not(read_formula(part, depth + 1))
        case {"all": [*parts]} if len(document) == 1:
            return And(tuple(read_formula(part, depth + 1) for part in parts))
        case {"any": [*parts]} if len(document) == 1:
            return Or(tuple(read_formula(part, depth + 1) for part in parts))
        case _:
            raise ValueError(f"$.formula: {str(document)[:80]}")
