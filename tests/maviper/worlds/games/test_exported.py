"""Our games as PettingZoo environments: PettingZoo's own tests, our own numbers, and other people's learner."""

import copy
import re
import warnings
from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from gymnasium.spaces import Discrete
from pettingzoo import ParallelEnv

from codegen.errors import InputError, UnknownNameError
from maviper import manual
from maviper.worlds import find, find_built_in, parallel_env
from maviper.worlds.games.exported import WorldEnv
from maviper.worlds.games.physical_deception import PhysicalDeception
from maviper.worlds.outside.making import import_maker
from maviper.worlds.outside.pettingzoo import PettingZooWorld
from maviper.worlds.outside.sources import parse_source
from maviper.worlds.seeds import TRAINING

with warnings.catch_warnings():
    warnings.simplefilter("ignore", DeprecationWarning)  # it makes games of its own in the old way
    from pettingzoo.test import parallel_api_test, parallel_seed_test

NAMES = [
    "physical-deception", "physical-deception,velocity=1", "physical-deception,defenders=3,features=goal+differences",
    "cooperative-navigation", "cooperative-navigation,agents=1", "cooperative-navigation,agents=6,features=signs",
    "predator-prey", "predator-prey,observation=released,prey=1", "predator-prey,observation=mpe2,obstacles=0",
]  # fmt: skip
SEEDS = (0, 7, 2**29 + 5, 2**40)


def acted(env, actions):
    return dict(zip(env.possible_agents, actions.tolist(), strict=True))


def mean_return(env, act, seed):
    """An episode's summed rewards, the mean over agents. `act`: observations -> actions."""
    seen, _ = env.reset(seed=seed)
    total = 0.0
    while env.agents:
        seen, rewards, *_ = env.step(act(seen))
        total += float(np.mean(list(rewards.values())))
    return total


def starts(env, count):
    """What is seen first in so many episodes without seeds."""
    return [b"".join(seen.tobytes() for seen in env.reset()[0].values()) for _ in range(count)]


@pytest.mark.parametrize("name", NAMES)
def test_pettingzoo_finds_nothing_wrong(name):
    parallel_api_test(parallel_env(name), num_cycles=60)
    parallel_seed_test(lambda: parallel_env(name), num_cycles=60)


@pytest.mark.parametrize("name", NAMES)
def test_an_episode_is_that_of_the_batched_simulator_bit_for_bit(name):
    world, env = find(name), parallel_env(name)
    steps = world.spec.episode_steps
    actions = np.random.default_rng(0).integers(5, size=(steps, len(SEEDS), len(world.agents)))
    batch = [world.start_from_seeds(SEEDS)]
    for each in actions:
        batch.append(world.step(batch[-1], each))
    for game, seed in enumerate(SEEDS):
        seen, _ = env.reset(seed=seed)
        for step in range(steps + 1):
            for agent, wanted in zip(world.agents, world.observe(batch[step]), strict=True):
                assert seen[agent].dtype == np.float32 and seen[agent].tobytes() == wanted[game].tobytes()
                assert seen[agent] in env.observation_space(agent)
            if step == steps:
                break
            assert env.agents == list(world.agents)
            seen, rewards, ended, cut, _ = env.step(acted(env, actions[step, game]))
            assert list(rewards.values()) == world.rewards(batch[step + 1])[game].tolist()
            assert not any(ended.values()) and set(cut.values()) == {step + 1 == steps}
        assert env.agents == []


def test_it_is_the_reference_environment_to_whoever_plays_it():
    ours, theirs = parallel_env("physical-deception"), find_built_in("physical-deception").reference_env()
    rng = np.random.default_rng(1)
    seen, wanted = ours.reset(seed=3), theirs.reset(seed=3)
    assert ours.possible_agents == theirs.possible_agents and seen[1] == wanted[1]
    assert all(ours.observation_space(a) == theirs.observation_space(a) for a in ours.possible_agents)
    assert all(ours.action_space(a) == theirs.action_space(a) for a in ours.possible_agents)
    while theirs.agents:
        actions = acted(ours, rng.integers(5, size=3))
        mine, others = ours.step(actions), theirs.step(actions)
        vectors, expected = ({agent: vector.tobytes() for agent, vector in each[0].items()} for each in (mine, others))
        assert vectors == expected and mine[1:] == others[1:] and ours.agents == theirs.agents


def test_what_it_says_about_itself():
    env = parallel_env("predator-prey,observation=paper,prey=1")
    assert isinstance(env, ParallelEnv) and env.unwrapped is env and env.render_mode is None
    assert env.metadata == {"name": "predator-prey,prey=1", "render_modes": ["rgb_array"], "render_fps": 10}
    assert env.possible_agents == ["adversary_0", "adversary_1", "agent_0"] and env.agents == []
    assert env.max_cycles == 25 and env.teams == {"predators": ["adversary_0", "adversary_1"], "prey": ["agent_0"]}
    for agent, features in env.features.items():
        box = env.observation_space(agent)
        assert box.dtype == np.float32 and box.shape == (len(features),) and box is env.observation_space(agent)
        assert env.action_space(agent) == Discrete(5) and env.action_space(agent) is env.action_space(agent)
        bounded = [feature.unit == "sign" for feature in features]
        assert box.bounded_below.tolist() == box.bounded_above.tolist() == bounded and any(bounded)
        assert set(box.low[bounded]) == {-1} and set(box.high[bounded]) == {1}


def test_starts_without_a_seed_follow_from_the_last_seed_and_differ():
    one, other = parallel_env("physical-deception"), parallel_env("physical-deception")
    copied = copy.deepcopy(one)
    assert len({*starts(one, 3), *starts(copied, 3), *starts(other, 3)}) == 9
    one.reset(seed=5), other.reset(seed=5)
    found = starts(one, 3)
    assert found == starts(other, 3) and len(set(found)) == 3
    assert TRAINING[0] <= one._seed < TRAINING[1], "held-out episodes are not learned from"


def test_observations_and_infos_are_the_receivers_own():
    env = parallel_env("cooperative-navigation")
    seen, infos = env.reset(seed=0)
    kept = {agent: vector.copy() for agent, vector in seen.items()}
    infos["agent_0"]["mine"] = 1
    _, _, _, _, later = env.step(dict.fromkeys(env.agents, 1))
    assert all(np.array_equal(seen[agent], kept[agent]) for agent in seen) and later["agent_0"] == {}


def test_a_longer_episode_may_be_asked_for():
    env = parallel_env("physical-deception")
    env.max_cycles = 30
    env.reset(seed=0)
    steps = 0
    while env.agents:
        env.step(dict.fromkeys(env.agents, np.int64(2)))
        steps += 1
    assert steps == 30


class Leaving(PhysicalDeception):
    """Deception in which the adversary ends by itself after its first step, and agent_0 is taken out."""

    def alive(self, state):
        stays = super().alive(state)
        stays[:, :2] &= (state.velocity == 0).all(axis=(1, 2))[:, None]
        return stays

    def terminated(self, state):
        ended = super().terminated(state)
        ended[:, 0] = ~self.alive(state)[:, 0]
        return ended


def test_agents_that_leave_early_do_not_come_back():
    env = WorldEnv(Leaving())
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        env.reset(seed=0)
        _, rewards, ended, cut, _ = env.step(dict.fromkeys(env.agents, 1))
        assert [ended[agent] for agent in env.possible_agents] == [True, False, False]
        assert [cut[agent] for agent in env.possible_agents] == [False, True, False] and len(rewards) == 3
        assert env.agents == ["agent_1"]
        seen, *_ = env.step({"agent_1": 2})
        assert list(seen) == ["agent_1"]


@pytest.mark.parametrize("name", ["physical-decepton", "predator-prey,pray=1", "predator-prey,prey=99", ""])
def test_an_unknown_name_is_told_as_everywhere(name):
    with pytest.raises(InputError) as wanted:
        find(name)
    with pytest.raises(InputError) as found:
        parallel_env(name)
    assert str(found.value) == str(wanted.value) and type(found.value) is type(wanted.value)


def test_wrong_uses_are_told():
    with pytest.raises(UnknownNameError, match="render mode"):
        parallel_env("physical-deception", "human")
    env = parallel_env("physical-deception", "rgb_array")
    for early in (lambda: env.step({}), env.render):
        with pytest.raises(InputError, match="reset first"):
            early()
    env.reset(seed=0)
    right = dict.fromkeys(env.agents, 0)
    for wrong in ({**right, "agent_1": 5}, {**right, "agent_1": -1}, {**right, "agent_1": 0.5}, {"agent_0": 0}):
        with pytest.raises(InputError, match="from 0 to 4"):
            env.step(wrong)


def test_pictures_show_the_state():
    def pictures(seed):
        env = parallel_env("physical-deception", "rgb_array")
        env.reset(seed=seed)
        found = [env.render()]
        for _ in range(3):
            env.step(dict.fromkeys(env.agents, 1))
        found.append(env.render())
        env.close()
        return found

    first, later = pictures(1)
    assert first.dtype == np.uint8 and first.ndim == 3 and first.shape[2] == 3 and not np.array_equal(first, later)
    assert all(np.array_equal(a, b) for a, b in zip(pictures(1), (first, later), strict=True))
    assert parallel_env("physical-deception").render() is None


# --- and in again


@pytest.mark.parametrize("options", ["", ",defenders=3,velocity=1", ",game=predator-prey,obstacles=1"])
def test_our_own_environment_is_read_as_a_users(options):
    text = f"tests.support.environments:ours{options}"
    world = PettingZooWorld(import_maker(parse_source(text)), text, games=1)
    ours = world.reference_env().world
    assert world.agents == ours.agents and world.teams == ours.teams and world.length_known
    assert world.spec.episode_steps == ours.spec.episode_steps
    unsaid = [[replace(feature, meaning=None) for feature in features] for features in ours.features]
    assert [[replace(feature, meaning=None) for feature in features] for features in world.features] == unsaid
    actions = np.random.default_rng(0).integers(5, size=(ours.spec.episode_steps, 1, len(ours.agents)))
    mine, theirs = ours.start_from_seeds([11]), world.start_from_seeds([11])
    for each in actions:
        for seen, wanted in zip(world.observe(theirs), ours.observe(mine), strict=True):
            assert seen.tobytes() == np.ascontiguousarray(wanted).tobytes()
        mine, theirs = ours.step(mine, each), world.step(theirs, each)
        assert np.array_equal(world.rewards(theirs), ours.rewards(mine))
    assert not world.alive(theirs).any() and not world.terminated(theirs).any()
    world.close()


# --- other people's learner


@pytest.mark.train
def test_the_pages_learner_plays_better_than_at_random(request):
    """Parameters shared by all agents, PPO of stable-baselines3 through SuperSuit; about 20 s of one core."""
    for package in ("stable_baselines3", "supersuit"):
        pytest.importorskip(package, reason="the extra maviper[interop] is not installed")
    import torch

    threads = torch.get_num_threads()
    torch.set_num_threads(1)  # nets this small wait for each other's threads longer than they compute
    request.addfinalizer(partial(torch.set_num_threads, threads))
    (source,) = re.findall(r"```python\n(import supersuit\n.*?)```", manual.page("environments"), flags=re.S)
    made = {}
    exec(source, made)
    learner, env, rng = made["learner"], made["env"], np.random.default_rng(0)

    def learned(seen):
        chosen, _ = learner.predict(np.stack(list(seen.values())), deterministic=True)
        return dict(zip(seen, chosen, strict=True))

    def at_random(seen):
        return {agent: int(rng.integers(5)) for agent in seen}

    gains = [mean_return(env, learned, seed) - mean_return(env, at_random, seed) for seed in range(100)]
    assert np.mean(gains) > 3 * np.std(gains) / len(gains) ** 0.5, np.mean(gains)
