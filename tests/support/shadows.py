"""Monitors for noisy numbers as functions: their twin, which follows episodes by a few lines of its own."""

from fractions import Fraction
from itertools import product

import numpy as np

from tests.support.monitors import TrackTwin, asked_of


class ShadowTwin(TrackTwin):
    """What a monitor for numbers that are off by `noise` must say. `last` is the state of the proof's episode."""

    def __init__(self, profile, start):
        self.near = 2.0 * start.noise
        super().__init__(profile, start)

    def reached(self, w):
        """As in the other twin: the nearest state, if it is near."""
        at = self.after(w) if self.at else self.begun(w)
        return None if at is None or not (np.abs(w - at) <= self.near).all() else at

    def begun(self, w):
        """The start of the region that is next to a state, at rest, with its goal at a landmark."""
        found = w.copy()
        for name, ends in self.proved.region.box.items():
            found[self.names.index(name)] = np.clip(found[self.names.index(name)], *map(float, map(Fraction, ends)))
        found[[at for at, name in enumerate(self.names) if ".v" in name]] = 0.0
        goal, marks = ([self.names.index(f"{name}.{axis}") for axis in "xy"] for name in ("goal", "landmark_0"))
        for name in self.proved.region.goals:
            marks = [self.names.index(f"{name}.{axis}") for axis in "xy"]
            if (np.abs(w[goal] - found[marks]) <= self.near).all():
                found[goal] = found[marks]
                return found if self.starts(found) else None
        return None

    def after(self, w):
        """The state of a way on that is near, if one is: of those who are not followed, any action counts."""
        ways = [
            [act] if policy.agent in self.proved.followed else range(len(policy.actions))
            for policy, act in zip(self.profile.agents, self.acts, strict=True)
        ]
        found = [self.moved(self.last, way) for way in product(*ways)]
        return next((at for at in found if (np.abs(w - at) <= self.near).all()), None)


def asked_of_shadows(profile, start, count, seed):
    """Noisy starts and what follows from them, pushes, sensors that fail: w, fresh, dt, start, actions."""

    def disturbed(rng, w, begins):
        size = len(w)
        w = w + rng.uniform(-1.0, 1.0, size) * start.noise * rng.choice([0.0, 1.0, 1.9, 2.3], p=[0.2, 0.6, 0.18, 0.02])
        if rng.random() < 0.02:
            w[rng.integers(size)] += rng.choice([3.0 * start.noise, 1.5, np.nan, np.inf])
        return w

    return asked_of(ShadowTwin(profile, start), profile, start, count, seed, disturbed)
