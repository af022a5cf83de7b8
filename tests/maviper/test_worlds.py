"""The batched simulator against the reference environment, bit for bit."""

import numpy as np
import pytest

from codegen.errors import UnknownNameError
from maviper.worlds import PhysicalDeception, find
from maviper.worlds.particle import WorldState, placed
from maviper.worlds.physical_deception import ADVERSARIES, DEFENDERS


@pytest.mark.parametrize("n_defenders", [1, 2, 3, 4])
def test_whole_random_episodes_are_equal_to_mpe2_bit_for_bit(n_defenders):
    world = PhysicalDeception(n_defenders)
    env = world.reference_env()
    episodes = 40
    rng = np.random.default_rng(n_defenders)
    actions = rng.integers(5, size=(world.spec.episode_steps, episodes, len(world.agents)))
    state = world.start_from_seeds(range(episodes))
    observations, rewards, positions = [world.observe(state)], [], []
    for acted in actions:
        state = world.step(state, acted)
        observations.append(world.observe(state))
        rewards.append(world.rewards(state))
        positions.append(state.position)
    for seed in range(episodes):
        seen, _ = env.reset(seed=seed)
        for step, acted in enumerate(actions[:, seed]):
            for index, agent in enumerate(world.agents):
                assert observations[step][index][seed].tobytes() == seen[agent].tobytes()
            seen, reward, _, truncated, _ = env.step(dict(zip(world.agents, acted.tolist(), strict=True)))
            raw = env.aec_env.unwrapped.world
            for index, entity in enumerate(raw.agents + raw.landmarks):
                assert positions[step][seed, index].tobytes() == entity.state.p_pos.tobytes()
            for index, agent in enumerate(world.agents):
                assert rewards[step][seed, index] == reward[agent]
        assert all(truncated.values())


def test_distances_are_those_of_the_reference(world):
    """The reference's benchmark data are squared distances; success compares the same numbers with 0.1."""
    env = world.reference_env()
    state = world.start_from_seeds(range(200))
    for seed in range(200):
        env.reset(seed=seed)
        raw, scenario = env.aec_env.unwrapped.world, env.aec_env.unwrapped.scenario
        adversary = scenario.benchmark_data(raw.agents[0], raw)
        position = state.position[None, seed : seed + 1]
        goal = state.goal[seed : seed + 1]
        assert world.success(position, goal, float(np.nextafter(adversary, 9)))[ADVERSARIES][0]
        assert not world.success(position, goal, float(adversary))[ADVERSARIES][0]


def test_defenders_need_a_target_each_at_the_same_step(world):
    position = np.zeros((2, 1, 5, 2))
    position[..., 3, 0], position[..., 4, 0] = 1.0, -1.0  # landmarks
    position[0, 0, 1, 0] = position[1, 0, 2, 0] = 1.0  # one defender at a time, at the same landmark
    position[0, 0, 2, 0] = position[1, 0, 1, 0] = 1.0
    goal = np.array([0])
    assert not world.success(position, goal, 0.1)[DEFENDERS][0]
    position[1, 0, 1, 0] = -1.0
    assert world.success(position, goal, 0.1)[DEFENDERS][0]
    assert not world.success(position[:1], goal, 0.1)[DEFENDERS][0]


def test_one_position_may_not_serve_two_targets(world):
    position = np.zeros((1, 1, 5, 2))
    position[..., 2, 0] = 9.0
    assert not world.success(position, np.array([0]), 0.1)[DEFENDERS][0]


def test_a_state_can_be_placed_in_the_reference(world):
    rng = np.random.default_rng(3)
    env = world.reference_env()
    env.reset(seed=0)
    for _ in range(50):
        state = WorldState(rng.normal(size=(1, 5, 2)), rng.normal(size=(1, 3, 2)), rng.integers(2, size=1))
        placed(env, state)
        acted = rng.integers(5, size=(1, 3))
        for index, agent in enumerate(world.agents):
            assert env.aec_env.unwrapped.observe(agent).tobytes() == world.observe(state)[index][0].tobytes()
        env.reset(seed=0)
        placed(env, state)
        seen, *_ = env.step(dict(zip(world.agents, acted[0].tolist(), strict=True)))
        following = world.observe(world.step(state, acted))
        for index, agent in enumerate(world.agents):
            assert seen[agent].tobytes() == following[index][0].tobytes()


def test_features_stay_in_their_ranges(world):
    """Everybody runs one way for a whole episode."""
    state = world.start(100, np.random.default_rng(0))
    acted = np.repeat(np.array([[1, 2, 3]]), 100, axis=0)
    for _ in range(world.spec.episode_steps):
        state = world.step(state, acted)
    for features, seen in zip(world.features, world.observe(state), strict=True):
        assert (seen >= [feature.low for feature in features]).all()
        assert (seen <= [feature.high for feature in features]).all()


def test_thousands_of_games_at_once(world):
    state = world.start(5_000, np.random.default_rng(0))
    one_by_one = [
        WorldState(state.position[k : k + 1], state.velocity[k : k + 1], state.goal[k : k + 1]) for k in range(5)
    ]
    acted = np.random.default_rng(1).integers(5, size=(5_000, 3))
    stepped = world.step(state, acted)
    for k, single in enumerate(one_by_one):
        assert world.step(single, acted[k : k + 1]).position.tobytes() == stepped.position[k : k + 1].tobytes()


def test_unknown_world():
    with pytest.raises(UnknownNameError, match="did you mean 'physical-deception'"):
        find("physical-decepton")
