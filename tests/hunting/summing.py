"""The judge of games whose teams test sums: what they observe, do and where they go, from a profile's file alone.

Does: observations of float64 states, with errors; decisions; the most that a claim's form comes to where an agent
  takes an action; episodes in mpe2, and how far apart agents and landmarks get in them.
Assumes: physical deception with two defenders.
Does not: import anything of ours.
"""

from fractions import Fraction
from itertools import permutations

import numpy as np

from tests.hunting.giving import Agent
from tests.hunting.playing import environment_of
from tests.hunting.reading import MACHINE, feature_of, fractions, measured

GOAL = "landmark_0"
TEAM = ("agent_0", "agent_1")
OWN = {"agent_0": "landmark_1", "agent_1": "landmark_0"}  # the landmarks of a claim that names them


class Team:
    """The agents of a file."""

    def __init__(self, document):
        self.agents = {each["agent"]: Agent(each) for each in document["agents"]}
        self.effects = {
            each["agent"]: {one["name"]: one["effect"] for one in each["actions"]} for each in document["agents"]
        }
        self.features = {
            each["agent"]: [feature_of(one["name"], one["meaning"]) for one in each["features"]]
            for each in document["agents"]
        }
        self.force = {each["name"]: each["force"] for each in document["world"]["agents"]}
        self.entities = [each["name"] for key in ("agents", "landmarks") for each in document["world"][key]]

    def acts(self, agent, at, errors=None):
        """What an agent does in states, name -> [batch]. `errors`: feature -> exact numbers [batch]."""
        known = {**at, **{f"goal.{axis}": at[f"{GOAL}.{axis}"] for axis in "xy"}}
        reader = self.agents[agent]
        columns = [
            measured(each, known, MACHINE, reader.seen, None if errors is None else errors.get(each.name))
            for each in self.features[agent]
        ]
        return reader.acts(np.stack(columns, axis=1))

    def most(self, agent, action, terms, states, errors):
        """The row of the state in which a sum of coordinates is largest of those where the agent takes an action; None
        without.
        """
        acting = self.acts(agent, states, errors) == action
        if not acting.any():
            return None
        value = sum(weight * states[name] for weight, name in terms)
        return int(np.argmax(np.where(acting, value, -np.inf)))

    def total(self, claim, start, errors):
        """The sum of a claim about decisions in a state of floats, exactly; None where its agent acts otherwise."""
        at = {name: np.array([float(value)]) for name, value in start.items()}
        off = {name: fractions(np.array([float(value)])) for name, value in errors.items() if value}
        if self.acts(claim["agent"], at, off)[0] != claim["action"]:
            return None
        return sum(weight * Fraction(start[name]) for weight, name in claim["terms"])

    def episode(self, start, steps):
        """Where all are after each step of mpe2."""
        world = environment_of("mpe2.simple_adversary_v3", 3, 2, 0).world
        bodies = dict(zip(self.entities, world.agents + world.landmarks, strict=True))
        for name, body in bodies.items():
            body.state.p_pos = np.array([float(start[f"{name}.{axis}"]) for axis in "xy"])
            body.state.p_vel = np.zeros(2)
        seen = []
        for step in range(steps + 1):
            at = {f"{name}.{axis}": body.state.p_pos[n] for name, body in bodies.items() for n, axis in enumerate("xy")}
            seen.append({name: float(value) for name, value in at.items()})
            if step < steps:
                rows = {name: np.array([value]) for name, value in seen[-1].items()}
                for name, agent in zip(self.agents, world.agents, strict=True):
                    agent.action.u = np.array(self.effects[name][self.acts(name, rows)[0]]) * self.force[name]
                    agent.action.c = np.zeros(2)
                world.step()
        return seen

    def farthest(self, start, steps):
        """How far from the origin the defenders get, exactly."""
        return max(
            abs(Fraction(at[f"{agent}.{axis}"])) for at in self.episode(start, steps) for agent in TEAM for axis in "xy"
        )

    def nearest(self, start, steps):
        """How near to one another the defenders get, exactly."""
        return min(_between(at, *TEAM) for at in self.episode(start, steps))

    def closest(self, agent, mark, start, steps):
        """How near to a landmark an agent gets, exactly."""
        return min(_between(at, agent, mark) for at in self.episode(start, steps))

    def matched(self, start, steps):
        """How near to a landmark of its own each defender is in the end, at the best matching: the farthest of them."""
        at = self.episode(start, steps)[-1]
        return min(
            max(_between(at, agent, mark) for agent, mark in zip(TEAM, marks, strict=True))
            for marks in permutations(OWN.values())
        )


def _between(at, one, other):
    return max(abs(Fraction(at[f"{one}.{axis}"]) - Fraction(at[f"{other}.{axis}"])) for axis in "xy")
