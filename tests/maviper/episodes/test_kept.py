"""Observations that are written where they stay are those that were seen, however many steps there are."""

import numpy as np
import pytest

from maviper.episodes.play import STEPS_AT_ONCE, _Kept, play, tree_policies


@pytest.mark.parametrize("steps", [1, STEPS_AT_ONCE - 1, STEPS_AT_ONCE, STEPS_AT_ONCE + 1, 2 * STEPS_AT_ONCE])
@pytest.mark.parametrize("most", [1, STEPS_AT_ONCE, 10**9])
def test_steps_come_back_in_their_order(steps, most):
    seen = [(np.full((3, 2), step, np.float32), np.full((3, 1), -step, np.float32)) for step in range(steps)]
    kept = _Kept(most)
    for each in seen:
        kept.add(each)
    for agent, rows in enumerate(kept.concatenate()):
        assert rows.dtype == np.float32 and (rows == np.stack([each[agent] for each in seen])).all()


def test_without_observations_the_episodes_are_the_same(world, profile):
    start = world.start_from_seeds(range(5))
    controllers = [tree_policies(profile.agents)] * len(profile.agents)
    kept, bare = play(world, controllers, start), play(world, controllers, start, keep=False)
    assert bare.observations == () and len(kept.observations) == len(profile.agents)
    assert (bare.actions == kept.actions).all() and (bare.returns == kept.returns).all()
    seen = [world.observe(state) for state in kept.states[:-1]]
    for agent, rows in enumerate(kept.observations):
        assert (rows == np.stack([each[agent] for each in seen])).all()
