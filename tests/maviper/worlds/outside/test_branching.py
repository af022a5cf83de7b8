"""Q measured in somebody else's environment: the returns of gymnasium's own play, from any state; or refused."""

import gymnasium
import numpy as np
import pytest

from codegen.errors import InputError
from maviper.episodes.play import Policies, points, rollout
from maviper.experts.expert import FAR, FAR_GAMMA, Measured
from maviper.worlds import find
from maviper.worlds.seeds import fold_seed


def lean(seen):
    return (seen[:, 2] + seen[:, 3] > 0).astype(int)


def returned(seed, acted, first):
    """By gymnasium alone: the discounted rewards after some actions, then `first`, then the controller's."""
    env = gymnasium.make("CartPole-v1")
    env.reset(seed=int(fold_seed(seed)))
    for action in acted:
        env.step(int(action))
    total, action = 0.0, first
    for step in range(FAR):
        seen, reward, ended, cut, _ = env.step(int(action))
        total += FAR_GAMMA**step * reward
        if ended or cut:
            break
        action = lean(np.float32(seen)[None])[0]
    return total


def test_measured_q_is_what_gymnasium_pays():
    world, controller = find("gymnasium:CartPole-v1"), Policies([lean])
    expert = Measured.for_world(world, controller)
    clumsy = Policies([lambda seen: np.ones(len(seen), int)])
    (episodes,) = rollout(world, [clumsy], [5, 6, 7])
    observations, state = points(episodes)
    alive = episodes.alive.reshape(-1)
    chosen = np.flatnonzero(alive)[[0, -14, -8, -5, -2]]
    found = expert.q(0, [seen[chosen] for seen in observations], state[chosen], np.array([[0], [1]]), np.zeros((5, 1)))
    for row, values in zip(chosen, found, strict=True):
        step, game = divmod(row, 3)
        for action in (0, 1):
            assert values[action] == pytest.approx(returned(5 + game, [1] * step, action), rel=1e-12)
    assert len(np.unique(found)) > 3
    again = expert.q(0, [seen[chosen] for seen in observations], state[chosen], np.array([[0], [1]]), np.zeros((5, 1)))
    assert np.array_equal(found, again)  # nothing was used up


def test_what_cannot_be_copied_is_refused():
    with pytest.raises(InputError, match="measured"):
        Measured(find("tests.support.environments:early"), Policies([lean] * 2))


@pytest.mark.interop
@pytest.mark.filterwarnings("ignore:builtin type")
def test_a_simulator_in_c_is_refused():
    pytest.importorskip("Box2D")
    with pytest.raises(InputError, match="cannot be copied"):
        Measured.for_world(find("gymnasium:LunarLander-v3"), Policies([lean]))
