"""Profiles with complete trees of some depth, for pages."""

import numpy as np

from tests.support import strategies
from tests.support.teams import nested


def complete_tree(depth, n_actions):
    """A tree with a split at every place: thresholds in order, so that all leaves are reached."""
    rng = np.random.default_rng(depth)

    def grown(level, low, high):
        if level == depth:
            return int(rng.integers(n_actions))
        middle = (low + high) / 2
        return 0, middle, grown(level + 1, low, middle), grown(level + 1, middle, high)

    return nested(grown(0, -1.0, 1.0))


def with_trees(profile, depth):
    return strategies.with_trees({one.agent: complete_tree(depth, len(one.actions)) for one in profile.agents}, profile)
