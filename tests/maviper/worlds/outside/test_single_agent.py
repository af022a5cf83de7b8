"""Single-agent environments as worlds: number for number Gymnasium's own, and refused with the way out otherwise."""

import sys
import types

import gymnasium
import numpy as np
import pytest

import maviper
from codegen.errors import InputError, MissingToolError
from maviper.cli import main
from maviper.episodes.play import Policies, rollout
from maviper.evaluation.crossplay import Stage
from maviper.worlds import find
from maviper.worlds.outside.pettingzoo import GAMES_HERE
from maviper.worlds.outside.playing import Together
from maviper.worlds.outside.processes import Copy
from maviper.worlds.outside.sources import parse_source
from maviper.worlds.outside.wrappers import SingleAgent, find_registered
from maviper.worlds.seeds import fold_seed


def test_cartpole_is_played_as_gymnasium_plays_it():
    """Also beside other copies in this process: 40 episodes, of which GAMES_HERE are played at once."""
    world = find("gymnasium:CartPole-v1")
    assert world.games == GAMES_HERE < 40 and world.spec.episode_steps == 500 and world.agents == ("agent",)
    assert [feature.name for feature in world.features[0]][2:] == ["pole_angle", "pole_angular_velocity"]
    assert [action.name for action in world.actions[0]] == ["push_left", "push_right"]
    seeds = range(2_000_000_000_000_000, 2_000_000_000_000_040)
    policies = Policies([lambda seen: (seen[:, 2] + seen[:, 3] > 0).astype(int)])
    returns = np.concatenate([part.returns[0] for part in rollout(world, [policies], seeds)])
    env = gymnasium.make("CartPole-v1")
    for seed, found in zip(seeds, returns, strict=True):
        (seen, _), total, over = env.reset(seed=fold_seed(seed)), 0.0, False
        while not over:
            seen, reward, ended, cut, _ = env.step(int(np.float32(seen[2]) + np.float32(seen[3]) > 0))
            total, over = total + reward, ended or cut
        assert total == found
    assert len(set(returns)) > 1


def test_more_games_at_once_end_as_fewer():
    """In evaluation, where no data comes of them."""
    world = find("tests.support.environments:walker")
    assert world.games_measured > world.games == GAMES_HERE
    policies, seeds = Policies([lambda seen: (seen[:, 0] % 2).astype(int)]), range(140)
    fewer = np.concatenate([part.returns[0] for part in rollout(world, [policies], seeds)])
    stage = Stage(world, seeds)
    stage.play((policies,))
    assert np.array_equal(fewer, stage.values((policies,), world.measures[0])) and len(set(fewer)) > 1


@pytest.mark.parametrize("limit", [None, 7])
def test_episodes_are_cut_as_gymnasium_cuts_them(limit):
    """Its wrappers are stepped past where they are its own, and its space's answers are remembered."""
    bare, env = (gymnasium.make("CartPole-v1", max_episode_steps=limit) for _ in range(2))
    alone = SingleAgent(env, parse_source("gymnasium:CartPole-v1"))
    for seed in range(3):
        alone.reset(seed), bare.reset(seed=seed)
        for step in range(12):
            seen, *found = alone.step_alone(step // 3 % 2)
            shown, *expected = bare.step(step // 3 % 2)
            assert np.array_equal(seen, shown) and found == expected
            if expected[1] or expected[2]:
                break
        assert expected[2] is (limit is not None) and alone.agents == ([] if expected[2] else ["agent"])
    space, known = env.unwrapped.action_space, bare.unwrapped.action_space
    for given in (0, 1, 2, -1, True, 1.0, np.int64(1), np.int64(2), np.array(1), "0", None, [0]):
        assert space.contains(given) == known.contains(given)


def test_an_end_by_itself_is_told_from_a_cut():
    world = find("tests.support.environments:walker")
    state = world.start_from_seeds(range(24))
    for _ in range(6):
        state = world.step(state, np.ones((24, 1), int))  # their 0: nobody moves
    assert not world.alive(state).any()
    assert (world.terminated(state)[:, 0] == (world.observe(state)[0][:, 0] == 0)).all()
    assert set(world.terminated(state)[:, 0]) == {True, False}


@pytest.mark.parametrize(
    ("shows", "names", "high"),
    [
        ("grid", ["feature_0_0", "feature_0_1", "feature_1_0", "feature_1_1"], 9),
        ("bits", ["bit_0", "bit_1", "bit_2"], 1),
        ("place", ["is_2", "is_3", "is_4", "is_5", "is_6"], 1),
    ],
)
def test_observations_are_flattened_with_names(shows, names, high):
    world = find(f"tests.support.environments:walker,shows={shows}")
    assert [feature.name for feature in world.features[0]] == names
    assert {feature.high for feature in world.features[0]} == {high}
    env = gymnasium.spaces.utils
    raw = world.reference_env().env
    for seed in range(10):
        expected = env.flatten(raw.observation_space, raw.reset(seed=seed)[0]).astype(np.float32)
        assert np.array_equal(world.observe(world.start_from_seeds([seed]))[0][0], expected)


@pytest.mark.parametrize(
    ("name", "latest"),
    [("CartPole", "CartPole-v1"), ("gymnasium.envs.toy_text:Taxi", "gymnasium.envs.toy_text:Taxi-v4")],
)
def test_a_name_without_a_version_names_the_latest_one(name, latest):
    with pytest.raises(InputError, match=f"says no version(.|\n)*write gymnasium:{latest}$"):
        find(f"gymnasium:{name}")


def test_a_name_without_a_version_is_refused_where_its_module_was_not_imported_yet(tmp_path, monkeypatch):
    """The versions are known once Gymnasium has imported the module, which is when it makes one."""
    registers = "gymnasium.register('Late-v{}', entry_point='gymnasium.envs.toy_text.taxi:TaxiEnv')"
    (tmp_path / "latecomers.py").write_text("\n".join(["import gymnasium", registers.format(2), registers.format(10)]))
    monkeypatch.syspath_prepend(tmp_path)
    try:
        with pytest.raises(InputError, match=r"says no version(.|\n)*write gymnasium:latecomers:Late-v10$"):
            find_registered("latecomers:Late")()
    finally:
        for version in (2, 10):
            gymnasium.registry.pop(f"Late-v{version}", None)
        sys.modules.pop("latecomers", None)


@pytest.mark.filterwarnings("ignore:.*out of date")
@pytest.mark.parametrize(("name", "new"), [("LunarLander-v2", "LunarLander-v3"), ("Taxi-v3", "Taxi-v4")])
def test_a_deprecated_version_names_the_new_one(name, new):
    with pytest.raises(InputError, match=new):
        find(f"gymnasium:{name}")


def test_a_missing_package_is_missing(monkeypatch):
    def broken(*_, **__):
        raise gymnasium.error.DependencyNotInstalled("Box2D is not installed, run `pip install gymnasium[box2d]`")

    monkeypatch.setattr(gymnasium, "make", broken)
    with pytest.raises(MissingToolError, match="gymnasium\\[box2d\\]"):
        find("gymnasium:LunarLander-v3")


def test_an_environment_of_the_old_gym_is_told_apart(monkeypatch):
    old = types.ModuleType("old_games")
    kind = type("Env", (), {"__module__": "gym.core"})
    old.make = lambda: kind()
    monkeypatch.setitem(sys.modules, "old_games", old)
    with pytest.raises(InputError, match="shimmy"):
        find("old_games:make")


@pytest.mark.parametrize("name", ["CartPole-v1", "FrozenLake-v1,is_slippery=False", "CartPole-v1,max_episode_steps=7"])
def test_games_stepped_together_give_the_outcomes_of_copies(name):
    """Starts, steps, ends, cuts, what follows an end, and a second start with fewer games."""
    world = find(f"gymnasium:{name}")
    copies = [Copy(world.reference_env(), world.source) for _ in range(6)]
    together, rng, ends = Together(world.source, world.reference_env), np.random.default_rng(0), set()
    for seeds in ([0, 1, 2, 3, 4, 5], [6, 7, 8]):
        one = together.ask("reset", seeds)
        other = [copy.ask("reset", seed) for copy, seed in zip(copies, seeds, strict=False)]
        for _ in range(60):
            for place, outcome in enumerate(other):
                assert one.observations[0][place].tobytes() == outcome.observations[0].tobytes()
                rows = one.rewards, one.done, one.terminated, one.acting, one.told
                assert [row[place].tolist() for row in rows] == list(outcome[1:])
                ends.add((outcome.done[0], outcome.terminated[0]))
            before = one.observations[0].copy()
            actions = rng.integers(len(world.actions[0]), size=(len(seeds), 1)).tolist()
            last, one = one, together.ask("step", actions)
            other = [copy.ask("step", action) for copy, action in zip(copies, actions, strict=False)]
            assert np.array_equal(last.observations[0], before)  # a state stays what it was
    assert len(ends) == 2  # it goes on, and it ends by itself or is cut
    together.close()
    world.close()


def test_what_a_game_of_many_raises_is_told_of_the_environment():
    world = find("gymnasium:CartPole-v1")
    together = Together(world.source, world.reference_env)
    together.ask("reset", [0, 1])
    with pytest.raises(InputError, match="the environment's step raised AssertionError"):
        together.ask("step", [[0], [7]])
    world.close()


def push(agent, rows):
    return (rows[:, 2] + rows[:, 3] > 0).astype(int)


def stay(agent, rows):
    return np.ones(len(rows), int)


def test_what_is_told_of_a_function_and_of_episodes_that_the_game_itself_ends(tmp_path, capsys):
    """The game ends after 8 steps, states no length, and takes no `max_cycles`."""
    game, place = "tests.support.environments:Line", str(tmp_path / "team.json")
    asked = ["--world", game, "--max-episodes", "40", "--max-depth", "1"]
    assert main.run(["extract", f"{__name__}:stay", *asked, "-o", place]) == 0
    told = capsys.readouterr().err
    assert f"expert      {__name__}:stay (function) for {game}, no Q: " in told and "cut" not in told
    assert maviper.load(place).provenance.expert == f"{__name__}:stay"
    measured = maviper.evaluate(place, world=game, expert=stay, episodes=2)
    assert "another expert" not in str(measured) and "no ratios" not in str(measured)


@pytest.mark.parametrize("mode", [None, "sync", "async"])
def test_a_vector_environment_is_a_world_whose_games_are_played_as_one_alone_is(mode):
    """Given itself, or by a function; its options are those of its games."""
    games = gymnasium.make_vec("CartPole-v1", num_envs=2, vectorization_mode=mode, sutton_barto_reward=True)
    chosen = {"max_episodes": 30, "max_depth": 2, "held_out": 5}
    one = maviper.extract(push, world=lambda: gymnasium.make("CartPole-v1", sutton_barto_reward=True), **chosen)
    for world in (games, lambda: gymnasium.make_vec("CartPole-v1", 2, mode, sutton_barto_reward=True)):
        team = maviper.extract(push, world=world, **chosen)
        assert team.to_text() == one.to_text() and len(team["agent"].tree.feature) > 1
        measured = [each.provenance.evaluation for each in (team, one)]
        assert measured[0] == measured[1] and measured[0]["agent return"] <= 0  # the reward that was asked for
    games.close()


def test_vector_environments_whose_games_differ_or_are_wrapped_together_are_refused():
    unlike = gymnasium.vector.SyncVectorEnv([lambda g=g: gymnasium.make("Pendulum-v1", g=g) for g in (9.0, 10.0)])
    wrapped = gymnasium.wrappers.vector.RecordEpisodeStatistics(gymnasium.make_vec("CartPole-v1", 2))
    for games, said in ((unlike, "its games are not alike"), (wrapped, "a wrapper is around all of its games")):
        with pytest.raises(InputError, match=said):
            find(games)
    alike = gymnasium.vector.SyncVectorEnv([lambda g=g: gymnasium.make("CartPole-v1") for g in (9.0, 9.0)])
    assert find(alike).spec.episode_steps == 500
