"""The judge of agents that test sums and give numbers: what a profile's file makes them give, and how far it goes.

Does: sums in three arithmetics, outputs and actions of many observations at once; the most that an objective reaches in
  a box, by sampling and climbing; whether a claim fails in one state, in exact numbers.
Assumes: a profile as JSON has it. Observations in a box are float64 numbers, which agents may round.
Does not: import anything of ours, or choose claims (outputs.py).

A claim is that `terms`, multiples of outputs and of variables, are at most a bound together, wherever `when`, an agent
and its action, holds; `off` says of which agent's copy an output is, which observes each feature plus an error.
"""

from fractions import Fraction
from functools import partial

import numpy as np

WIDE, NARROW = np.float64, np.float32
CLIMBS, AROUND = (0.2, 0.05, 0.01, 0.002), 16  # parts of a range by which the best states are moved, each so often
GRID = 2.0**-16  # sums of two such numbers are float32 numbers, so that no error is rounded twice


class Agent:
    """An agent of a profile's file."""

    def __init__(self, agent):
        self.name, self.nodes = agent["agent"], agent["tree"]
        self.features = [each["name"] for each in agent["features"]]
        self.outputs = [each["name"] for each in agent.get("outputs", [])]
        self.bounds = [(each["low"], each["high"]) for each in agent.get("outputs", [])]
        self.actions = [each["name"] if isinstance(each, dict) else each for each in agent["actions"]]
        arithmetic = agent.get("arithmetic", "")  # "": there are no sums
        self.seen = WIDE if "float64" in (arithmetic, agent.get("numbers")) else NARROW
        self.sums = NARROW if arithmetic == "float32 steps" else WIDE
        self.gives = NARROW if agent.get("gives") == "float32" else WIDE

    def value(self, terms, rows):
        """A sum of observations [n, features], added from left to right."""
        total = None
        for weight, name in terms:
            if name is None:
                term = np.full(len(rows), weight, self.sums)
            else:
                term = self.sums(weight) * rows[:, self.features.index(name)].astype(self.sums)
            total = term if total is None else total + term
        return total

    def leaves(self, rows):
        """The leaf of each observation, by its place in the file."""
        place = np.zeros(len(rows), int)
        for number, node in enumerate(self.nodes):  # children come after parents
            here = np.flatnonzero(place == number)
            if "left" not in node or not len(here):
                continue
            if "sum" in node:
                tested, threshold = self.value(node["sum"], rows[here]), self.sums(node["threshold"])
            else:
                tested = rows[here, self.features.index(node["feature"])]
                threshold = float.fromhex(node["float32"]) if "float32" in node else node["threshold"]
            place[here] = np.where(tested <= threshold, node["left"], node["right"])
        return place

    def given(self, rows):
        """What it gives of each observation, [n, outputs]."""
        rows = rows.astype(self.seen)
        leaf, found = self.leaves(rows), np.empty((len(rows), len(self.outputs)), self.gives)
        for number in np.unique(leaf):
            here = leaf == number
            for column, (low, high) in enumerate(self.bounds):
                y = self.value(self.nodes[number]["outputs"][column], rows[here])
                y = y if low is None else np.where(y < low, self.sums(low), y)
                found[here, column] = y if high is None else np.where(y > high, self.sums(high), y)
        return found

    def acts(self, rows):
        """The name of what it does of each observation."""
        return np.array([node.get("action", "") for node in self.nodes])[self.leaves(rows.astype(self.seen))]


class States:
    """States of a box: a variable for each feature, which all agents see alike, and an error for each."""

    def __init__(self, document, box, off):
        self.agents = {each["agent"]: Agent(each) for each in document["agents"]}
        self.low, self.high = (np.array([ends[side] for ends in box.values()]) for side in (0, 1))
        self.names, self.off = list(box), off

    def drawn(self, rng, count):
        """[count, variables] and the errors, of the grid; half of the numbers lie at an end of their range."""
        return (
            self._numbers(rng, count, self.low, self.high),
            self._numbers(rng, count, np.full_like(self.low, -self.off), np.full_like(self.low, self.off)),
        )

    def _numbers(self, rng, count, low, high):
        inside = rng.uniform(low, high, (count, len(low)))
        ends = np.where(rng.random(inside.shape) < 0.5, low, high)
        return self._gridded(np.where(rng.random(inside.shape) < 0.4, ends, inside), low, high)

    @staticmethod
    def _gridded(numbers, low, high):
        return np.clip(np.round(numbers / GRID) * GRID, np.ceil(low / GRID) * GRID, np.floor(high / GRID) * GRID)

    def _near(self, rng, states, size):
        """States beside others: some of their numbers are moved by up to a part of the range."""
        found = []
        for numbers, low, high in ((states[0], self.low, self.high), (states[1], -self.off, self.off)):
            low, high = np.broadcast_to(low, numbers.shape[1:]), np.broadcast_to(high, numbers.shape[1:])
            moved = numbers + rng.normal(0, size, numbers.shape) * (high - low) * (rng.random(numbers.shape) < 0.5)
            found.append(self._gridded(moved, low, high))
        return tuple(found)

    def objective(self, claim, states):
        """What the terms of a claim are together in each state, in float64; -inf where it says nothing."""
        total = np.zeros(len(states[0]))
        for weight, kind, agent, name in claim["terms"]:
            total = total + weight * self._term(kind, agent, name, states)
        if claim.get("size"):
            total = np.abs(total)
        if claim["when"] is not None:
            agent, action = claim["when"]
            total = np.where(self.agents[agent].acts(states[0]) == action, total, -np.inf)
        return total

    def _term(self, kind, agent, name, states):
        if kind == "variable":
            return states[0][:, self.names.index(name)]
        one = self.agents[agent]
        rows = states[0] + states[1] if kind == "off" else states[0]
        return one.given(rows)[:, one.outputs.index(name)].astype(WIDE)

    def most(self, claim, rng, count):
        """The states in which the terms reach most, of those that are tried, best first."""
        drawn = self.drawn(rng, count)
        return climb(drawn, partial(self.objective, claim), partial(self._near, rng), 32)


def climb(states, value, near, best):
    """So many states of which a value is largest, best first. `states`: arrays side by side, a row each; `value`: of
    all rows; `near`: rows beside others, for how large a part of their range they are moved by.
    """

    def sort(states):
        order = np.argsort(-value(states), kind="stable")[:best]
        return [each[order] for each in states]

    for size in CLIMBS:
        kept = sort(states)
        moved = near([np.repeat(each, AROUND, axis=0) for each in kept], size)
        states = [np.concatenate(pair) for pair in zip(kept, moved, strict=True)]
    return sort(states)


def nearest(exact, numbers):
    """The float nearest to a number, ties to even."""
    if numbers is WIDE:
        return float(exact)
    near = NARROW(float(exact))
    beside = [np.nextafter(near, NARROW(-np.inf)), near, np.nextafter(near, NARROW(np.inf))]
    return float(min(beside, key=lambda each: (abs(Fraction(float(each)) - exact), int(each.view(np.uint32)) & 1)))


def exactly(states, claim, state, errors):
    """What the terms of a claim are together in a state of exact numbers; None where it says nothing there."""

    def rows(agent, erring):
        numbers = [state[name] + (errors[name] if erring else 0) for name in agent.features]
        return np.array([[nearest(number, agent.seen) for number in numbers]])

    if claim["when"] is not None:
        agent = states.agents[claim["when"][0]]
        if agent.acts(rows(agent, False))[0] != claim["when"][1]:
            return None
    total = Fraction(0)
    for weight, kind, name, of in claim["terms"]:
        if kind == "variable":
            total += weight * state[of]
        else:
            agent = states.agents[name]
            total += weight * Fraction(float(agent.given(rows(agent, kind == "off"))[0, agent.outputs.index(of)]))
    return abs(total) if claim.get("size") else total
