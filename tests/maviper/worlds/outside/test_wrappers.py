"""AEC environments, dictionaries and masks as worlds, against what the libraries' own environments say."""

import gymnasium
import numpy as np
import pytest
from pettingzoo.classic.tictactoe import tictactoe

from codegen.errors import InputError
from maviper.episodes.play import rollout
from maviper.evaluation.crossplay import Uniform
from maviper.extraction.exploiting import Facing
from maviper.worlds import find
from maviper.worlds.outside.pettingzoo import PettingZooWorld
from maviper.worlds.outside.sources import parse_source
from maviper.worlds.outside.spaces import as_numbers, names_of, vector, vector_space
from maviper.worlds.outside.wrappers import Flattened
from maviper.worlds.seeds import fold_seed
from tests.support.environments import Line

LINE = "tests.support.environments:early"
TICTACTOE = "pettingzoo.classic.tictactoe.tictactoe:env,wrap=flatten+turns"


def test_tictactoe_is_played_as_pettingzoo_plays_it():
    """Move by move, in PettingZoo's own order of turns; observations flattened as Gymnasium flattens them."""
    world = find(TICTACTOE)
    names = [feature.name for feature in world.features[0]]
    assert names[:3] == ["observation_0_0_0", "observation_0_0_1", "observation_0_1_0"]
    assert names[18:20] == ["legal_action_0", "legal_action_1"] and len(names) == 27
    assert [action.legal_if for action in world.actions[0]] == names[18:]
    (played,) = rollout(world, [Uniform(world, [7])] * 2, [7])
    theirs = tictactoe.env()
    theirs.reset(seed=7)
    over = False
    for step, acted in enumerate(played.actions[:, 0]):
        assert not over
        mover = theirs.possible_agents.index(theirs.agent_selection)
        assert played.alive[step, 0].tolist() == [mover == 0, mover == 1]
        for place, agent in enumerate(theirs.possible_agents):
            seen = theirs.observe(agent)
            wanted = np.concatenate([seen["observation"].ravel(), seen["action_mask"]])
            assert np.array_equal(played.observations[place][step, 0], wanted)
        theirs.step(int(acted[mover]))
        over = any(theirs.terminations.values())
    assert over
    assert played.returns[:, 0].tolist() == [theirs._cumulative_rewards[each] for each in theirs.possible_agents]
    world.close()


def test_one_team_or_rivals():
    assert dict(find(TICTACTOE).teams) == {"player": ("player_1", "player_2")}
    assert dict(find(f"{TICTACTOE}+rivals").teams) == {"player_1": ("player_1",), "player_2": ("player_2",)}


class FirstFree:
    """Everybody takes the first free cell, so that the first player has three in a row with the seventh move."""

    def act(self, agents, observations, state):
        return np.stack([observations[agent][:, 18:].argmax(axis=1) for agent in agents], axis=1)


def test_an_episode_goes_on_while_a_frozen_opponent_has_the_turn():
    world = find(f"{TICTACTOE}+rivals,max_steps=9")
    game = Facing(world, "player_1", [FirstFree()] * 2, "")
    (played,), (whole,) = (rollout(each, [FirstFree()] * len(each.agents), [3]) for each in (game, world))
    assert len(whole.actions) == 7 and np.array_equal(played.actions[:, :, 0], whole.actions[:, :, 1])
    assert np.array_equal(played.returns[0], whole.returns[1])
    assert world.playing(whole.states[0]).all() and not world.playing(whole.states[-1]).any()
    world.close()


def test_those_who_may_act_at_once_do():
    world = find("pettingzoo.classic.rps.rps:env,wrap=parallel+flatten,max_cycles=4")
    assert world.spec.episode_steps == 4
    assert [feature.name for feature in world.features[0]] == ["is_0", "is_1", "is_2", "is_3"]
    state = world.start_from_seeds([0])
    state = world.step(state, np.array([[0, 1]]))  # paper beats rock
    assert world.alive(state).all() and world.rewards(state).tolist() == [[-1.0, 1.0]]
    assert world.observe(state)[0].tolist() == [[0, 1, 0, 0]]
    world.close()


def test_masks_in_infos_are_observed():
    """Taxi says in `info` which moves change anything."""
    world = find("gymnasium:Taxi-v4,wrap=masks")
    state = world.start_from_seeds([3])
    env = gymnasium.make("Taxi-v4")
    _, info = env.reset(seed=fold_seed(3))
    assert len(world.features[0]) == 506
    for _ in range(20):
        obs = world.observe(state)[0]
        assert obs[0, 500:].tolist() == info["action_mask"].tolist()
        action = int(np.flatnonzero(info["action_mask"])[-1])
        state = world.step(state, np.array([[action]]))
        *_, info = env.step(action)


def masked(mask):
    """A line whose agents are told this mask."""
    env = Line(goal=3)
    seen, _ = env.reset(seed=0)
    env.reset = lambda seed=None, options=None: (seen, {each: {"action_mask": mask} for each in env.possible_agents})
    return Flattened(env, True, parse_source("tests.support.environments:early,wrap=masks"))


@pytest.mark.parametrize("mask", [[1, 0, 1], np.array([True, False, True]), np.array([[1.0], [-0.0], [1.0]])])
def test_masks_are_zeros_and_ones(mask):
    seen, _ = masked(mask).reset()
    assert seen["runner_1"].dtype == np.float32 and seen["runner_1"].tolist()[3:] == [1, 0, 1]


@pytest.mark.parametrize("mask", [["no", "yes", "no"], [0, -np.inf, 0], [np.nan, 1, 0], [2, 0, 1], [None] * 3])
def test_what_is_no_mask_is_refused(mask):
    with pytest.raises(InputError, match="'s action_mask is"):
        masked(mask).reset()


def test_agents_that_die_take_no_part_and_the_others_go_on():
    """Knights, archers and zombies: a knight can be eaten while the archers play on."""
    game = "pettingzoo.butterfly.knights_archers_zombies.knights_archers_zombies:parallel_env"
    world = find(f"{game},max_cycles=400,wrap=flatten")
    assert len(world.features[0]) == 27 * 5 and world.features[0][5].name == "feature_1_0"
    eaten = 0
    for seed in range(4):
        state, alive = world.start_from_seeds([seed]), []
        while world.alive(state).any() and len(alive) < 400:
            alive.append(world.alive(state)[0])
            state = world.step(state, np.zeros((1, 4), int))
            assert not world.rewards(state)[0, ~alive[-1]].any()
        counts = np.sum(alive, axis=1)
        assert counts[0] == 4 and (np.diff(counts) <= 0).all()
        eaten += 0 < counts[-1] < 4
    assert eaten  # the environment's zombies do not follow from its seed alone
    world.close()


@pytest.mark.parametrize(
    ("space", "names"),
    [
        (
            gymnasium.spaces.Dict({"speed": gymnasium.spaces.Box(-1, 1, (1,)), "seat": gymnasium.spaces.Discrete(2)}),
            ["seat_is_0", "seat_is_1", "speed"],
        ),
        (
            gymnasium.spaces.Tuple((gymnasium.spaces.MultiBinary(2), gymnasium.spaces.Box(0, 1, (2,)))),
            ["part_0_0", "part_0_1", "part_1_0", "part_1_1"],
        ),
        (gymnasium.spaces.MultiDiscrete([2, 3]), ["0_is_0", "0_is_1", "1_is_0", "1_is_1", "1_is_2"]),
        (
            gymnasium.spaces.Dict({"arm": gymnasium.spaces.Dict({"x y": gymnasium.spaces.Box(0, 1, (2,))})}),
            ["arm_x_y_0", "arm_x_y_1"],
        ),
    ],
)
def test_every_number_of_a_flattened_space_has_a_name_of_its_own(space, names):
    found = [name for name, _ in names_of(space)]
    assert found == [name if name[0].isalpha() else f"feature_{name}" for name in names]
    assert len(found) == gymnasium.spaces.flatten_space(space).shape[0]


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("pettingzoo.classic.tictactoe.tictactoe:env", ["AEC", "wrap=turns", "turn_based_aec_to_parallel"]),
        (
            "pettingzoo.classic.tictactoe.tictactoe:env,wrap=parallel+flatten",
            ["is_parallelizable", "wrap=turns+flatten"],
        ),
        ("pettingzoo.classic.rps.rps:env", ["wrap=parallel", "aec_to_parallel"]),
        ("pettingzoo.classic.tictactoe.tictactoe:env,wrap=turns", ["is a Dict, not a Box", "wrap=flatten"]),
        ("pettingzoo.classic.tictactoe.tictactoe:env,wrap=turn", ["unknown wrapper 'turn'", "did you mean 'turns'"]),
        ("pettingzoo.classic.rps.rps:env,wrap=parallel+masks", ["no action_mask of 3 numbers in its infos"]),
        ("gymnasium:Blackjack-v1", ["Tuple", "wrap=numbers", "wrap=flatten", "FlattenObservation"]),
        ("gymnasium:Pendulum-v1", ["continuous actions", "TransformAction", "mygame:make", "extract"]),
        ("tests.support.environments:walker,shows=parts", ["Dict", "FlattenObservation"]),
        ("tests.support.environments:walker,shows=picture", ["4,800 numbers"]),
        ("gymnasium:CartPol-v1", ["did you mean CartPole-v1"]),
        ("gymnasium:CartPole-v9", ["`v1`"]),
        ("gymnasium:PongNoFrameskip-v4", ["pip install ale-py", "gymnasium:ale_py:PongNoFrameskip-v4"]),
        ("gymnasium:MiniGrid-Empty-5x5-v0", ["minigrid"]),
        ("gymnasium:no_such_package:Thing-v0", ["no_such_package"]),
        ("gymnasium:__import__('os')", ["not a Gymnasium id"]),
        ("gymnasium:CartPole-v1,colour=3", ["colour"]),
        ("tests.support.environments:walker,shows=words,wrap=numbers", ["are a Text", "numbers in a row"]),
        ("gymnasium:CartPole-v1,wrap=masks", ["no action_mask of 2 numbers"]),
        ("tests.support.environments:walker,shows=picture,wrap=flatten", ["4,800 numbers"]),
        ("tests.support.environments:walker,shows=words,wrap=flatten", ["are a Text", "numbers in a row"]),
    ],
)
def test_what_is_refused_and_the_way_out(name, said):
    with pytest.raises(InputError) as caught:
        find(name).start_from_seeds([0])
    assert all(part in str(caught.value) for part in said), str(caught.value)


def test_single_agents_with_tuples_and_dictionaries_are_flattened():
    world = find("gymnasium:Blackjack-v1,wrap=flatten,max_steps=20")
    assert [world.features[0][place].name for place in (0, 32, 43)] == ["part_0_is_0", "part_1_is_0", "part_2_is_0"]
    assert find("tests.support.environments:walker,shows=parts,wrap=flatten").features[0][0].name == "x"


def test_whole_numbers_are_shown_as_they_are():
    world = find("gymnasium:Blackjack-v1,wrap=numbers,max_steps=20")
    (features,) = world.features
    assert [(each.name, each.low, each.high) for each in features] == [
        ("player_sum", 0, 31),
        ("dealer_card", 0, 10),
        ("usable_ace", 0, 1),
    ]
    assert [action.name for action in world.actions[0]] == ["stick", "hit"]
    flat = find("gymnasium:Blackjack-v1,wrap=flatten,max_steps=20")
    for seed in range(20):
        (seen,), (places,) = (each.observe(each.start_from_seeds([seed])) for each in (world, flat))
        assert seen[0].tolist() == [places[0, :32].argmax(), places[0, 32:43].argmax(), places[0, 43:].argmax()]


@pytest.mark.parametrize(
    ("space", "seen", "numbers"),
    [
        (gymnasium.spaces.Discrete(5, start=-2), -1, [-1]),
        (
            gymnasium.spaces.MultiDiscrete([[2, 3], [4, 5]], start=[[0, 1], [0, -3]]),
            np.array([[1, 3], [2, -3]]),
            [1, 3, 2, -3],
        ),
        (
            gymnasium.spaces.Dict({"seat": gymnasium.spaces.Discrete(9), "at": gymnasium.spaces.Box(-1, 1, (2,))}),
            {"seat": 7, "at": np.array([0.5, 0.25], np.float32)},
            [0.5, 0.25, 7],
        ),
    ],
)
def test_so_are_those_of_any_space(space, seen, numbers):
    whole = as_numbers(space, "mygame")
    assert vector(whole, seen).tolist() == numbers and len(names_of(whole)) == len(numbers)
    box = vector_space(whole)
    assert (box.low <= numbers).all() and (numbers <= box.high).all()


def test_whole_numbers_that_float32_does_not_tell_apart_are_refused():
    with pytest.raises(InputError, match="16,777,216"):
        as_numbers(gymnasium.spaces.Discrete(2**25), "mygame")


def test_what_an_environment_says_of_legal_actions_is_not_lost():
    """Its features are flattened, and the one that it names goes on to say whether the second action is legal."""
    env = Line(goal=3)
    env.legal = {"runner_1": ["", "feature_0", ""]}
    world = PettingZooWorld(lambda: Flattened(env, False, parse_source(LINE)), LINE, 1)
    assert world.mask(1) == (None, 0, None) and world.mask(0) is None
    assert len(world.features[1]) == 3
