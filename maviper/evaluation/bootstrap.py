"""How often a bootstrap draws each episode.

Does: draws episodes with replacement, as many as there are, and counts them, in parts of bounded size.
Assumes: a generator whose state says which draws come next.
Does not: compute a mean or an interval.
"""

from collections.abc import Iterator

import numpy as np

from maviper.worlds.world import Int

DRAWS = 2_000  # bootstrap samples of the episodes
MAX_COUNTS = 2**22  # at once; bounds the memory


def counts(episodes: int, rng: np.random.Generator, draws: int = DRAWS) -> Iterator[Int]:
    """How often each of the episodes is in a sample, [draws, episodes] over all parts."""
    at_once = max(1, MAX_COUNTS // episodes)
    for low in range(0, draws, at_once):
        rows = min(at_once, draws - low)
        drawn = rng.integers(episodes, size=(rows, episodes)) + episodes * np.arange(rows)[:, None]
        yield np.bincount(drawn.ravel(), minlength=rows * episodes).reshape(rows, episodes)
