"""The scale of observations: networks learn from scaled ones, and their first layers are stored for plain ones.

Does: takes mean and deviation of every feature from random play, and folds them into a first layer, or out of it.
Assumes: networks whose first layer is linear; one scale for a whole training, the same for the same seed.
Does not: follow a policy to where it leads later, clip, or scale actions. Masks are read from plain observations.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from codegen.ir import Float32, Float64
from maviper.worlds import World

LEAST_POINTS = 5_000  # joint observations of random play, in whole batches of episodes
LEAST_SHARE = 0.1  # of a feature's largest size that its deviation is taken to be at least
DRAWS = 1_701  # beside the seed, so that the draws are not those of the training


@dataclass(frozen=True)
class Scale:
    """The numbers that scale an observation, (plain - mean) / deviation; each [n_columns]."""

    mean: Float64
    deviation: Float64

    def fold(self, weight: Float32, bias: Float32, columns: Sequence[int]) -> tuple[Float32, Float32]:
        """The first layer for plain observations, of one for scaled ones. `weight`: [n_inputs, width], of which the
        first rows are those of `columns`; `bias`: [width].
        """
        wide, count, read = weight.astype(np.float64), len(columns), list(columns)
        wide[:count] /= self.deviation[read, None]
        return wide.astype(np.float32), (bias - self.mean[read] @ wide[:count]).astype(np.float32)

    def unfold(self, weight: Float32, bias: Float32, columns: Sequence[int]) -> tuple[Float32, Float32]:
        """The first layer for scaled observations, of one for plain ones: `fold` the other way."""
        wide, count, read = weight.astype(np.float64), len(columns), list(columns)
        moved = bias + self.mean[read] @ wide[:count]
        wide[:count] *= self.deviation[read, None]
        return wide.astype(np.float32), moved.astype(np.float32)


def measure_scale(world: World, games: int, seed: int, shared: bool) -> Scale:
    """The scale of joint observations, side by side as agents are. `games`: played in parallel; `shared`: team-mates
    have one, since they have one network. A feature that does not change is moved, not stretched.
    """
    rng = np.random.default_rng([DRAWS, seed])
    points = np.concatenate(_play_at_random(world, games, rng)).astype(np.float64)
    mine = np.split(points, np.cumsum([len(features) for features in world.features])[:-1], axis=1)
    means, deviations = list[Float64](), list[Float64]()
    for agent, name in enumerate(world.agents):
        alike = world.members(world.team_of(name)) if shared else [agent]
        seen = np.concatenate([mine[other] for other in alike])
        least = LEAST_SHARE * np.abs(seen).max(axis=0)
        deviation = np.maximum(seen.std(axis=0), least)
        means.append(seen.mean(axis=0))
        deviations.append(np.where(deviation > 0, deviation, 1.0))
    return Scale(np.concatenate(means), np.concatenate(deviations))


def _play_at_random(world: World, games: int, rng: np.random.Generator) -> list[Any]:
    """Joint observations of whole episodes, each [n, n_columns], of games in which somebody plays."""
    met: list[Any] = []
    everybody, count = range(len(world.agents)), 0
    while count < LEAST_POINTS:
        state = world.start(games, rng)
        for _ in range(world.spec.episode_steps):
            observations, playing = world.observe(state), np.flatnonzero(world.playing(state).any(axis=1))
            if not len(playing):
                break
            met.append(np.concatenate(observations, axis=1)[playing])
            count += len(playing)
            uniform = rng.random((len(observations[0]), *world.acting_shape))
            state = world.step(state, world.draw_actions(everybody, observations, uniform))
    return met
