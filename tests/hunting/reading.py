"""The judge's reading of a profile file: what agents observe in world states, and to which leaves that leads them.

Does: reads the JSON of a profile; observations and leaves for batches of states, in machine or exact arithmetic.
Assumes: a profile file as `maviper extract` writes it; finite positions.
Does not: import anything of ours. What it knows stands in the file's own words and in the definitions of claims.

A batch of states is a mapping from coordinates ("agent_0.x", "goal.y") to arrays [batch]: float64, or objects that are
exact fractions. The goal's coordinates are those of a landmark.
"""

import json
import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[Any]
At = Mapping[str, Array]
MACHINE, REAL = "machine", "real"
TERM = re.compile(r"([+-]?)\s*([A-Za-z][\w-]*\.v?[xy])")


@dataclass(frozen=True)
class Feature:
    """What one number of an observation measures: a signed sum of coordinates, or a function of it."""

    name: str
    terms: tuple[tuple[int, str], ...]
    function: str

    @property
    def measurable(self) -> bool:
        """Whether it may be off: not what is constant, or says that two things are equal."""
        return bool(self.terms) and self.function != "zero"


@dataclass(frozen=True)
class Agent:
    """One agent's tree as arrays over its nodes, what it observes, and where its actions push."""

    name: str
    team: str
    features: tuple[Feature, ...]
    actions: tuple[str, ...]
    effects: Array  # [actions, 2]
    feature: Array  # [nodes]; -1 at leaves
    threshold: Array  # [nodes] of the type that the agent observes and compares: float32 or float64
    left: Array
    right: Array
    action: Array

    @cached_property
    def thresholds(self) -> Array:
        """The thresholds exactly, [nodes]."""
        return fractions(self.threshold.astype(float))

    @cached_property
    def tested(self) -> list[int]:
        """The features that some node tests."""
        return sorted({int(number) for number in self.feature if number >= 0})

    @cached_property
    def depth(self) -> int:
        """Splits on the longest path."""
        levels = np.zeros(len(self.feature), dtype=int)
        for node in np.flatnonzero(self.feature >= 0):
            levels[self.left[node]] = levels[self.right[node]] = levels[node] + 1
        return int(levels.max())


@dataclass(frozen=True)
class Profile:
    """A world and the agents in it."""

    world: Mapping[str, Any]
    agents: tuple[Agent, ...]

    def agent(self, name: str) -> Agent:
        return next(agent for agent in self.agents if agent.name == name)

    def team(self, team: str) -> list[Agent]:
        """The agents of a team; none for a team that there is not."""
        return [agent for agent in self.agents if agent.team == team]

    @cached_property
    def landmarks(self) -> list[str]:
        return [entity["name"] for entity in self.world["landmarks"]]

    @cached_property
    def movers(self) -> list[str]:
        """The names of all that moves."""
        return [entity["name"] for entity in self.world["agents"]]


def fractions(numbers: Any) -> Array:
    """Numbers as exact fractions; of equal ones, as errors mostly are, one is made."""
    values, places = np.unique(np.asarray(numbers), return_inverse=True)
    found = np.empty(len(values), dtype=object)
    found[:] = list(map(Fraction, values.tolist()))
    return found[places].reshape(np.shape(numbers))


def read(text: str) -> Profile:
    """The profile in a file's text."""
    document = json.loads(text)
    return Profile(document["world"], tuple(map(_agent, document["agents"])))


def _agent(document: Mapping[str, Any]) -> Agent:
    features = tuple(feature_of(one["name"], one["meaning"]) for one in document["features"])
    names, actions = [one.name for one in features], [one["name"] for one in document["actions"]]
    nodes, double = document["tree"], document.get("numbers", "float32") == "float64"

    def column(key: str, none: Any, made: Any) -> Array:
        return np.array([made(node[key]) if key in node else none for node in nodes])

    return Agent(
        document["agent"],
        document["team"],
        features,
        tuple(actions),
        np.array([one["effect"] for one in document["actions"]], dtype=float),
        column("feature", -1, names.index),
        column("threshold", 0.0, float) if double else column("float32", 0.0, float.fromhex).astype(np.float32),
        column("left", -1, int),
        column("right", -1, int),
        column("action", -1, actions.index),
    )


def feature_of(name: str, meaning: str) -> Feature:
    found = re.fullmatch(r"(?:(\w+)\()?(.*?)\)?", meaning)
    assert found, meaning
    terms = tuple((-1 if sign == "-" else 1, term) for sign, term in TERM.findall(found[2]))
    return Feature(name, terms, found[1] or "")


# --- what is observed


def summed(feature: Feature, at: At) -> Array:
    """The feature's sum, operation by operation as the environment does it (exact for fractions)."""
    (weight, name), *rest = feature.terms
    total = at[name] if weight > 0 else -at[name]
    for weight, name in rest:
        total = total + at[name] if weight > 0 else total - at[name]
    return total


def _sum_exactly(feature: Feature, at: At, error: Array, rounded: bool) -> Array:
    """The feature's sum with its error as fractions, or each rounded once to float64. All are counted in a unit that
    divides them: whole numbers are added in a tenth of the time that fractions take.
    """
    parts = {**{name: at[name] for _, name in feature.terms}, "": error}
    ratios = {name: [one.as_integer_ratio() for one in values.tolist()] for name, values in parts.items()}
    units = math.lcm(*{under for rows in ratios.values() for _, under in rows})
    whole = {name: np.array([n * (units // under) for n, under in rows], object) for name, rows in ratios.items()}
    total = summed(feature, whole) + whole[""]
    return (total / units).astype(float) if rounded else np.array([Fraction(one, units) for one in total], object)


def function_of(function: str, total: Array) -> Array:
    """The function of a sum."""
    if function == "positive":
        return (total > 0).astype(int)
    if function == "zero":
        return (total == 0).astype(int)
    return (total > 0).astype(int) - (total < 0).astype(int) if function == "sign" else total


def measured(feature: Feature, at: At, semantics: str, kind: Any, error: Any = None) -> Array:
    """What an agent observes, [batch]: of type `kind` in machine arithmetic, where states are float64 numbers.

    `error`: exact, added to the exact sum; then float64, the function and the type follow.
    """
    if not feature.terms:
        return np.zeros(len(next(iter(at.values()))), dtype=kind)
    total = summed(feature, at)
    if error is not None and feature.measurable:
        total = _sum_exactly(feature, at, error, semantics == MACHINE)
    seen = function_of(feature.function, total)
    return seen.astype(kind) if semantics == MACHINE else seen


def paths(agent: Agent, at: At, semantics: str, errors: Mapping[str, Any] | None = None) -> Array:
    """The nodes on each state's way to its leaf, [depth + 1, batch]; the leaf is repeated.

    Real arithmetic on float64 numbers is rounded, and so only a hint.
    """
    some = next(iter(at.values()))
    count, kind = len(some), agent.threshold.dtype if semantics == MACHINE else some.dtype
    seen = np.zeros((len(agent.features), count), dtype=kind)
    for number in agent.tested:
        feature = agent.features[number]
        error = None if errors is None else errors.get(f"{agent.name}:{feature.name}")
        seen[number] = measured(feature, at, semantics, kind, error)
    limits = agent.thresholds if kind.kind == "O" else agent.threshold
    node, rows, found = np.zeros(count, dtype=int), np.arange(count), []
    for _ in range(agent.depth + 1):
        found.append(node)
        inner = agent.feature[node] >= 0
        left = (seen[agent.feature[node], rows] <= limits[node]).astype(bool)
        node = np.where(inner, np.where(left, agent.left[node], agent.right[node]), node)
    return np.array(found)


def leaves(agent: Agent, at: At, semantics: str, errors: Mapping[str, Any] | None = None) -> Array:
    """The leaf of each state, [batch]."""
    return paths(agent, at, semantics, errors)[-1]


def acting(
    agents: Sequence[Agent], at: At, semantics: str, errors: Mapping[str, Any] | None = None
) -> dict[str, Array]:
    """Agent -> its action in each state, [batch]."""
    return {agent.name: agent.action[leaves(agent, at, semantics, errors)] for agent in agents}
