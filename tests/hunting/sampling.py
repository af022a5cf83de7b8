"""Random episodes of stated systems in float64, thousands at once, and those that break a claim played again exactly.

Does: starts and errors at bounds, or at eighths between them; the least and most that a sum becomes; whether some
  episode breaks a claim.
Assumes: data as stated.py has it. What breaks a claim here does so only once stated.py says so.
Does not: import anything of ours but that judge.
"""

from fractions import Fraction

import numpy as np

from tests.hunting.stated import broken, meets, played

PARTS = 8  # starts and errors are so many parts of their interval
REPLAYED = 6  # episodes that are played again exactly


class Forms:
    """Sums over the columns of states."""

    def __init__(self, names):
        self._at = {name: column for column, name in enumerate(names)}

    def total(self, form, states):
        """The value of a form in each state, [...] of [..., variables]."""
        found = np.full(states.shape[:-1], float(Fraction(form["constant"])))
        for name, weight in form["terms"].items():
            found += float(Fraction(weight)) * states[..., self._at[name]]
        for weight, names in form.get("products", ()):
            found += float(Fraction(weight)) * np.prod([states[..., self._at[name]] for name in names], axis=0)
        return found

    def meets(self, half, states):
        """Where an inequality holds."""
        if "below" in half:
            return self.total(half["below"], states) < 0
        return self.total(half["most"], states) <= 0

    def within(self, regions, states):
        """Where a state lies in one of some regions."""
        found = np.zeros(states.shape[:-1], dtype=bool)
        for region in regions:
            inside = np.ones(states.shape[:-1], dtype=bool)
            for half in region:
                inside &= self.meets(half, states)
            found |= inside
        return found

    def seen(self, feature, states):
        """What a feature measures, as float32."""
        value = self.total(feature["form"], states)
        match feature["measure"]:
            case "sign":
                value = np.sign(value)
            case "positive":
                value = np.where(value > 0, 1.0, 0.0)
            case "equals":
                value = np.where(value == 0, 1.0, 0.0)
            case "clip":
                value = np.clip(value, *(float(Fraction(each)) for each in feature["bounds"]))
        return value.astype(np.float32)


class Episodes:
    """So many random episodes. `states`: [steps + 1, count, variables]; `alive`: [steps + 1, count], whether what is
    stated says that an episode gets there.
    """

    def __init__(self, system, agents, bounds, steps, count, seed):
        self._system, self._agents, self._rng = system, agents, np.random.default_rng([seed, 7])
        self._names = [one[0] for one in system["variables"]]
        self.forms = Forms(self._names)
        self._bounds = {name: tuple(map(Fraction, bounds[name])) for name in self._names}
        edge = self._rng.random(count) < 0.5
        self._edge = edge[:, None]
        self._shares = self._shared((count, len(self._names)))
        low, high = np.array([[float(end) for end in self._bounds[name]] for name in self._names]).T
        state = low + (high - low) * self._shares / PARTS
        alive = self.forms.within([system["start"]], state)
        self._errors, self._pieces = [], []
        states, lives = [state], [alive]
        with np.errstate(all="ignore"):
            for _ in range(steps):
                state, alive = self._moved(state, alive)
                states.append(state)
                lives.append(alive)
        self.states, self.alive = np.array(states), np.array(lives)

    def _shared(self, shape):
        ends = PARTS * self._rng.integers(0, 2, shape)
        return np.where(self._edge, ends, self._rng.integers(0, PARTS + 1, shape))

    def _moved(self, state, alive):
        """One step: a piece of those that hold a state is drawn for each."""
        holds = np.array([self._holds(piece, state) for piece in self._system["pieces"]]).reshape(-1, len(state))
        keys = np.where(holds, self._rng.random(holds.shape), -1.0)
        number = keys.argmax(axis=0)
        shares = self._shared(state.shape)
        joint = {agent["agent"]: self._actions(agent, state) for agent in self._agents}
        after = np.zeros_like(state)
        for place, piece in enumerate(self._system["pieces"]):
            rows = np.flatnonzero(number == place)
            after[rows] = self._by(piece, state[rows], shares[rows], {who: did[rows] for who, did in joint.items()})
        self._pieces.append(number)
        self._errors.append(shares)
        return after, alive & holds.any(axis=0)

    def _holds(self, piece, state):
        found = np.ones(len(state), dtype=bool)
        for name, (low, high) in piece["where"].items():
            values = state[:, self._names.index(name)]
            found &= (values >= float(Fraction(low))) & (values <= float(Fraction(high)))
        for half in piece.get("when", []):
            found &= self.forms.meets(half, state)
        return found

    def _by(self, piece, state, shares, joint):
        after = np.zeros_like(state)
        for name, form in piece["move"].items():
            column = self._names.index(name)
            after[:, column] = self.forms.total(form, state)
            if name in piece["error"]:
                low, high = (float(Fraction(end)) for end in piece["error"][name])
                after[:, column] += low + (high - low) * shares[:, column] / PARTS
        for agent, chosen, forms in piece["effect"]:
            rows = np.flatnonzero(joint[agent] == chosen)
            for name, form in forms.items():
                after[rows, self._names.index(name)] += self.forms.total(form, state[rows])
        return after

    def _actions(self, agent, state):
        """The name of what an agent does in each state."""
        features = self._system["features"][agent["agent"]]
        found = np.empty(len(state), dtype=object)
        pending = [(0, np.arange(len(state)))]
        while pending:
            node, rows = pending.pop()
            if len(agent["nodes"][node]) == 1:
                found[rows] = agent["nodes"][node][0]
                continue
            name, threshold, left, right = agent["nodes"][node]
            low = self.forms.seen(features[name], state[rows]) <= threshold
            pending += [(left, rows[low]), (right, rows[~low])]
        return found

    def exactly(self, place):
        """The states of an episode in exact numbers; None where it leaves what is stated."""

        def between(low, high, share):
            return low + (high - low) * Fraction(int(share), PARTS)

        start = {
            name: between(*self._bounds[name], share)
            for name, share in zip(self._names, self._shares[place], strict=True)
        }
        if not all(meets(half, start) for half in self._system["start"]):
            return None
        return played(
            self._system,
            self._agents,
            start,
            len(self._pieces),
            lambda step, _: int(self._pieces[step][place]),
            lambda step, name, low, high: between(low, high, self._errors[step][place][self._names.index(name)]),
        )

    def breaking(self, claim):
        """Which whole episodes break a claim in float64, [count]."""
        inside, whole = self.forms.within(claim["regions"], self.states), self.alive[-1]
        match claim["name"]:
            case "avoids":
                found = inside.any(axis=0)
            case "reaches":
                found = ~inside.any(axis=0)
            case "always":
                spoken = np.ones_like(inside)
                if claim["assuming"]:
                    spoken = np.logical_and.accumulate(self.forms.within(claim["assuming"], self.states), axis=0)
                found = (spoken & ~inside)[claim["by"] :].any(axis=0)
            case name:
                found = ~inside[claim["by"] if name == "reaches_and_stays" else 0 :].all(axis=0)
        return found & whole

    def broken(self, claim):
        """Whether an episode breaks a claim in exact numbers."""
        for place in np.flatnonzero(self.breaking(claim))[:REPLAYED]:
            states = self.exactly(int(place))
            if states is not None and broken(claim, states):
                return True
        return False

    def most(self, form, first=0):
        """The largest value of a form in whole episodes, from a step on; None where there are none."""
        whole = self.alive[-1]
        if not whole.any():
            return None
        return float(self.forms.total(form, self.states[first:, whole]).max())
