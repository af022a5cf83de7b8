"""Two small games of two agents, in which every term of why a team falls behind is known.

`relay`: agent 1 sets a bit, then agent 0 has to say it. `either`: one decision, worth 1 unless both are wrong.
"""

from dataclasses import dataclass

import numpy as np

from codegen.dynamics import motionless
from codegen.ir import ActionSpec, FeatureSpec
from maviper.worlds.world import Measure, World

TENTHS = 10  # what both observe first is uniform over so many numbers
RELAY, EITHER = "relay", "either"


@dataclass(frozen=True)
class Bits:
    """Games: what was drawn, the bit, how many steps were taken, and what the last one was worth."""

    drawn: np.ndarray
    bit: np.ndarray
    taken: np.ndarray
    worth: np.ndarray

    def __len__(self):
        return len(self.drawn)

    def __getitem__(self, rows):
        return Bits(self.drawn[rows], self.bit[rows], self.taken[rows], self.worth[rows])


class TwoBits(World):
    """See the module. `measures`: the reward's sum, as `worth`, and as a cost."""

    def __init__(self, game):
        self.game, names = game, ("agent_0", "agent_1")
        self.spec = motionless(f"bits-{game}", "", names, 2 if game == RELAY else 1)
        self.teams = {"agents": names}
        seen = FeatureSpec("drawn", "none", 0.0, TENTHS - 1.0, None), FeatureSpec("bit", "none", 0.0, 1.0, None)
        self.features = (seen, seen)
        self.actions = ((ActionSpec("zero", None), ActionSpec("one", None)),) * 2
        self.measures = (Measure("agents", "worth"), Measure("agents", "cost", lower_is_better=True))

    def start(self, n, rng):
        return self._at(rng.integers(TENTHS, size=n))

    def start_from_seeds(self, seeds):
        return self._at(np.asarray(seeds) % TENTHS)

    @staticmethod
    def _at(drawn):
        zeros = np.zeros(len(drawn), dtype=np.int64)
        return Bits(drawn, zeros, zeros, zeros.astype(float))

    def step(self, state, actions):
        if self.game == EITHER:
            return Bits(state.drawn, state.bit, state.taken + 1, 1.0 - actions.all(axis=1))
        said = np.where(state.taken == 1, actions[:, 0] == state.bit, 0).astype(float)
        return Bits(state.drawn, np.where(state.taken == 0, actions[:, 1], state.bit), state.taken + 1, said)

    def observe(self, state):
        seen = np.stack([state.drawn, state.bit], axis=1).astype(np.float32)
        return seen, seen

    def rewards(self, state):
        return np.repeat(state.worth[:, None], 2, axis=1)

    def values(self, states):
        worth = np.sum([state.worth for state in states], axis=0)
        return np.stack([worth, -worth])

    def reference_env(self):
        raise NotImplementedError
