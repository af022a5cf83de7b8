"""The judge of stated systems whose agents give numbers or test sums: episodes, and the most that sums reach in them.

Does: moves many states at once in float64, and single ones in exact numbers, by the same rules; looks for the states,
  starts and errors in which a sum reaches most; says what a claim's sum comes to in an exact episode.
Assumes: rules, features and claims as plain data (below); agents as giving.py reads them from the profile's file.
Does not: import anything of ours, or choose claims (driven.py).

A form is a dict from names to exact numbers; "" is its constant, `agent.u0` what an agent gives or its action sets. A
claim is that the sum `terms` is at most `bound`: in each state of a box where `when`, an agent and its action, holds
("decides"), in all states of episodes ("stays_in", "avoids"), from step `by` on ("reaches_and_stays"), in some state
("reaches").
"""

from fractions import Fraction
from functools import cached_property

import numpy as np

from tests.hunting.giving import Agent, climb, nearest

BEST = 24
EXACTLY = 8  # of the best, which are looked at in exact numbers


def total_of(form, columns):
    """The value of a form, in floats or in exact numbers, as its columns are."""
    (first, *_) = columns.values()
    number = Fraction if first.dtype == object else float
    total = np.full(len(first), number(form.get("", 0)), first.dtype)
    for name, weight in form.items():
        total = total + number(weight) * columns[name] if name else total
    return total


class Plant:
    """A stated system with its agents. `rules`, `features` (by agent), `pushes` (agent, action, input -> form),
    `errors` (name -> size), `ranges` and `start` (name -> ends) as plain data.
    """

    def __init__(self, document, plain):
        self.agents = {each["agent"]: Agent(each) for each in document["agents"]}
        self.plain = plain

    def inputs(self, columns):
        """What each agent gives, or its action sets, and its actions, in each state."""
        exact = next(iter(columns.values())).dtype == object
        found, acts = {}, {}
        for name, agent in self.agents.items():
            forms = self.plain["features"][name]
            rows = np.stack([total_of(forms[each], columns) for each in agent.features], axis=1)
            if exact:
                rows = np.array([[nearest(value, agent.seen) for value in row] for row in rows], agent.seen)
            if agent.outputs:
                given = agent.given(rows).astype(float)
                given = np.array([[Fraction(each) for each in row] for row in given.tolist()]) if exact else given
                found |= {f"{name}.{output}": given[:, place] for place, output in enumerate(agent.outputs)}
            else:
                acts[name] = agent.acts(rows)
                found |= self._set(name, acts[name], columns)
        return found, acts

    def _set(self, name, acts, columns):
        """What an agent's actions set in each state."""
        found = {}
        for action, settings in self.plain["pushes"][name].items():
            for key, form in settings.items():
                total = total_of(form, columns)
                found[f"{name}.{key}"] = np.where(acts == action, total, found.get(f"{name}.{key}", total))
        return found

    def step(self, columns, errors):
        """The states after a step. `errors`: what is added to each variable."""
        known = columns | self.inputs(columns)[0]
        return {name: total_of(form, known) + errors.get(name, 0) for name, form in self.plain["rules"].items()}

    def episodes(self, columns, errors, steps):
        """The states of episodes; `errors`: of each step."""
        states = [columns]
        for step in range(steps):
            states.append(self.step(states[-1], errors[step]))
        return states

    def reach(self, claim, columns, errors):
        """What a claim's sum comes to in each state or episode: more than the bound breaks it; -inf where it says
        nothing.
        """
        terms = claim["terms"]
        if claim["kind"] == "decides":
            inputs, acts = self.inputs(columns)
            total = total_of(terms, columns | inputs)
            if claim["when"] is None:
                return total
            agent, action = claim["when"]
            return np.where(acts[agent] == action, total, -np.inf)
        totals = [total_of(terms, each) for each in self.episodes(columns, errors, claim["steps"])]
        if claim["kind"] == "reaches":
            return np.min(totals, axis=0)
        return np.max(totals[claim["by"] :], axis=0)

    def exactly(self, claim, start, errors):
        """The same of one start in exact numbers. `errors`: of each step, by variable."""
        columns = {name: np.array([Fraction(value)], object) for name, value in start.items()}
        steps = [{name: Fraction(each) for name, each in step.items()} for step in errors]
        return self.reach(claim, columns, steps)[0]


class Searched:
    """States of a box, or starts with errors, in which a claim's sum reaches most; best first."""

    def __init__(self, plant, claim, box, rng, count):
        self.plant, self.claim, self.rng = plant, claim, rng
        self.names, self.ends = list(box), np.array([[float(end) for end in each] for each in box.values()])
        sizes = plant.plain["errors"]
        self.erring = {} if claim["kind"] == "decides" else {name: float(size) for name, size in sizes.items()}
        self.starts, self.signs = climb(self._drawn(count), self._values, self._near, BEST)

    def _drawn(self, count):
        rng, (low, high) = self.rng, self.ends.T
        inside = rng.uniform(low, high, (count, len(low)))
        starts = np.where(rng.random(inside.shape) < 0.3, np.where(rng.random(inside.shape) < 0.5, low, high), inside)
        signs = rng.choice([-1.0, 1.0], (count, self.claim["steps"], len(self.erring)))
        return starts, signs

    def _near(self, states, size):
        """States beside others, some of whose signs are turned."""
        (starts, signs), (low, high), rng = states, self.ends.T, self.rng
        moved = starts + rng.normal(0, size, starts.shape) * (high - low) * (rng.random(starts.shape) < 0.6)
        return np.clip(moved, low, high), np.where(rng.random(signs.shape) < 0.2, -signs, signs)

    def _values(self, states):
        starts, signs = states
        columns = dict(zip(self.names, starts.T, strict=True))
        errors = [
            {name: signs[:, step, place] * size for place, (name, size) in enumerate(self.erring.items())}
            for step in range(self.claim["steps"])
        ]
        with np.errstate(all="ignore"):
            return self.plant.reach(self.claim, columns, errors).astype(float)

    @cached_property
    def reached(self):
        """The most that the best reach, in exact numbers; None where the claim says nothing of them."""
        sizes, reached = self.plant.plain["errors"], []
        for start, signs in zip(self.starts[:EXACTLY].tolist(), self.signs[:EXACTLY].tolist(), strict=True):
            errors = [
                {name: Fraction(sign) * sizes[name] for name, sign in zip(self.erring, each, strict=True)}
                for each in signs
            ]
            reached.append(self.plant.exactly(self.claim, dict(zip(self.names, start, strict=True)), errors))
        most = max(reached)
        return most if isinstance(most, Fraction) else None
