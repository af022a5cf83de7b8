"""Agents that give numbers: played as the environment plays them, drawn within bounds, refused where actions count."""

import gymnasium
import numpy as np
import pytest

from codegen.errors import InputError
from maviper.cli import main
from maviper.episodes.measures import likeness
from maviper.episodes.play import Policies, rollout
from maviper.evaluation.crossplay import Uniform
from maviper.worlds import find
from maviper.worlds.checking import check, usable
from maviper.worlds.outside.spaces import random_actions, taking
from maviper.worlds.seeds import fold_seed

PENDULUM, TUGS = "gymnasium:Pendulum-v1", "tests.support.steering:tugs"


def torque(seen):
    return np.clip(-4 * seen[:, 1:2] - seen[:, 2:], -2, 2).astype(np.float32)


def test_pendulum_is_played_as_gymnasium_plays_it():
    world = find(PENDULUM, giving=True)
    ((output,),) = world.outputs
    assert (output.name, output.unit, output.low, output.high) == ("torque", "N m", -2, 2)
    assert [feature.name for feature in world.features[0]] == ["cos_angle", "sin_angle", "angular_velocity"]
    seeds = range(2_000_000_000_000_000, 2_000_000_000_000_003)
    (episodes,) = rollout(world, [Policies([torque])], seeds)
    env = gymnasium.make("Pendulum-v1")
    for seed, found in zip(seeds, episodes.returns[0], strict=True):
        (seen, _), total, over = env.reset(seed=fold_seed(seed)), 0.0, False
        while not over:
            seen, reward, ended, cut, _ = env.step(torque(seen[None])[0])
            total, over = total + float(reward), ended or cut
        assert total == found
    assert episodes.actions.shape == (200, 3, 1, 1) and episodes.actions.dtype == np.float32


def test_agents_may_give_as_many_numbers_as_they_like():
    world = find(TUGS, giving=True)
    assert [[each.name for each in row] for row in world.outputs] == [["speed"], ["output_0", "output_1"]]
    assert world.acting_shape == (2, 2) and world.outputs[1][1].high == 3

    def still(width):
        return lambda seen: np.zeros((len(seen), width), np.float32)

    seeds = range(world.games)
    (played,) = rollout(world, [Policies([still(1), still(2)])] * 2, seeds)
    assert played.actions.shape[2:] == (2, 2) and not played.actions.any()
    (chance,) = rollout(world, [Uniform(world).start_episodes(seeds)] * 2, seeds)
    drawn = chance.actions.reshape(-1, 2, 2)
    assert (drawn[:, 0, 1] == 0).all() and (drawn[:, 1] <= [1, 3]).all() and (drawn[:, 1] >= [-1, 0]).all()
    assert drawn[:, 1, 1].max() > 2 and drawn[:, 0, 0].min() < -0.5
    world.close()


def test_environments_take_arrays_of_their_own_shape_within_bounds():
    box = gymnasium.spaces.Box(-1, 1, (2, 2), np.float64)
    taken = taking(box)([2.0, 0.5, -3.0, 0.0, 7.0])
    assert taken.dtype == np.float64 and taken.tolist() == [[1.0, 0.5], [-1.0, 0.0]]
    assert taking(gymnasium.spaces.Discrete(3))(2.0) == 2


def test_an_environment_is_checked_with_numbers_that_trees_can_give():
    box = gymnasium.spaces.Box(0, 0.1, (2,), np.float64)
    drawn = np.array(random_actions([box, gymnasium.spaces.Box(-1, 3, (2,))], np.random.default_rng(0), 50))
    assert drawn.shape == (50, 2, 2) and (drawn == drawn.astype(np.float32)).all()
    assert (drawn[:, 0] <= np.float32(0.1)).all() and (drawn[:, 1] >= -1).all() and drawn[:, 1].max() > 2


def test_commands_show_and_check_them(capsys):
    assert main.run(["worlds", "show", PENDULUM]) == 0
    assert "gives torque     N m [-2, 2]" in capsys.readouterr().out
    for name in (PENDULUM, TUGS):
        findings = check(name)
        assert usable(findings) and any("actions: numbers within bounds" in str(each) for each in findings)


@pytest.mark.parametrize(
    ("name", "said"), [("mixed", "some agents give numbers, others choose"), ("boundless", "without finite bounds")]
)
def test_spaces_that_no_tree_can_act_in_are_refused(name, said):
    with pytest.raises(InputError, match=said):
        find(f"tests.support.steering:{name}", giving=True)


@pytest.mark.parametrize(
    "command",
    [
        ["train", PENDULUM, "--algorithm", "maddpg", "-o", "run"],
        ["verify", "--new", PENDULUM],
    ],
)
def test_commands_that_need_numbered_actions_say_so(command, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main.run(command) == 2
    assert "numbered" in capsys.readouterr().err


def test_a_tree_of_actions_is_refused_in_a_game_of_numbers(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "tree.py").write_text("def act(x):\n    return 0 if x[0] <= 0.5 else 1\n")
    assert main.run(["import", "tree.py", "--world", PENDULUM, "-o", "tree.json"]) == 2
    assert "takes actions, and gives no numbers" in capsys.readouterr().err


def test_likeness_is_nearness_in_parts_of_the_range():
    outputs = find(TUGS, giving=True).outputs[1]
    acted, wanted = np.float32([[0, 1], [1, 3], [-1, 0]]), np.float32([[0, 1], [0, 3], [1, 3]])
    assert likeness(outputs, acted, wanted).tolist() == [1.0, 0.75, 0.0]
    assert likeness((), np.array([1, 2]), np.array([1, 0])).tolist() == [1.0, 0.0]
