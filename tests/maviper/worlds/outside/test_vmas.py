"""VMAS scenarios as worlds: number for number VMAS's own batch, each game from its seed wherever it stands."""

import sys

import numpy as np
import pytest

from codegen.errors import InputError, MissingToolError
from maviper.cli import main
from maviper.episodes.play import Policies, rollout
from maviper.evaluation import held_out
from maviper.experts.finding import Unweighted
from maviper.extraction.algorithms import extract
from maviper.extraction.settings import Settings
from maviper.worlds import find
from maviper.worlds.checking import Mark, check, usable
from maviper.worlds.matching import plays
from maviper.worlds.seeds import fold_seed
from tests.support.other_loops import Code, play_navigation

BALANCE = "vmas:balance,n_agents=2,max_steps=20"

needed = pytest.mark.skipif("not __import__('importlib').util.find_spec('vmas')", reason="the extra interop")


@needed
@pytest.mark.parametrize("giving", [False, True])
def test_games_are_those_of_vmas_itself(giving):
    """Three games of a batch against three batches of one game each, made by VMAS alone."""
    import torch
    import vmas

    world = find(f"{BALANCE},continuous_actions=True" if giving else BALANCE, giving=giving)
    seeds = [5, 2_000_000_000_000_007, 11]
    state = world.start_from_seeds(seeds)
    theirs = []
    for seed in seeds:
        env = vmas.make_env("balance", num_envs=1, continuous_actions=giving, n_agents=2)
        env.seed(fold_seed(seed))
        env.reset_at(0)
        theirs.append(env)
    rng = np.random.default_rng(0)
    for _ in range(15):
        for place, env in enumerate(theirs):
            for agent, body in enumerate(env.agents):
                assert np.array_equal(world.observe(state)[agent][place], env.scenario.observation(body)[0].numpy())
        acted = rng.uniform(-1, 1, (3, 2, 2)).astype(np.float32) if giving else rng.integers(9, size=(3, 2))
        state = world.step(state, acted)
        for place, env in enumerate(theirs):
            given = [torch.tensor(each, dtype=torch.float32).reshape(1, -1) for each in acted[place]]
            _, paid, over, _ = env.step(given)
            assert world.rewards(state)[place].tolist() == [float(each[0]) for each in paid]
            assert world.terminated(state)[place].tolist() == [bool(over[0])] * 2
    assert len({each.tobytes() for each in world.observe(state)[0]}) == 3


@needed
def test_a_game_does_not_depend_on_its_place_or_on_what_was_played_before():
    world = find(BALANCE)
    stands = Policies([lambda seen: (seen[:, 0] > 0) * 3] * 2)
    (first,) = rollout(world, [stands] * 2, range(40))
    rollout(world, [stands] * 2, range(70, 80))
    (later,) = rollout(world, [stands] * 2, [*range(100, 130), 7])
    for agent in range(2):
        assert np.array_equal(first.observations[agent][:, 7], later.observations[agent][:, 30])
    assert np.array_equal(first.returns[:, 7], later.returns[:, 30])
    assert not np.array_equal(first.returns[:, 7], first.returns[:, 8])


@needed
def test_a_game_that_is_over_pays_and_shows_nothing_more():
    """In `dropout` one agent that arrives ends its game."""
    world = find("vmas:dropout,n_agents=2,max_steps=100")
    state = world.start_from_seeds(range(24))
    ended = []
    for _ in range(100):
        towards = [_nearer(seen) for seen in world.observe(state)]
        before, state = state, world.step(state, np.stack(towards, axis=1))
        over = ~world.alive(before).any(axis=1)
        assert not world.rewards(state)[over].any()
        assert np.array_equal(world.observe(state)[0][over], world.observe(before)[0][over])
        assert (world.terminated(state) >= world.terminated(before)).all()
        ended.append(int(world.terminated(state).all(axis=1).sum()))
    assert ended[-1] > 0 and ended[0] < ended[-1]


def _nearer(seen):
    """On each of two axes 0 stays, 1 is minus and 2 is plus. Numbers 4 and 5 lead to the goal."""
    signs = [np.where(seen[:, place] > 0.02, 2, np.where(seen[:, place] < -0.02, 1, 0)) for place in (4, 5)]
    return signs[0] * 3 + signs[1]


@needed
def test_actions_are_called_by_where_they_push():
    """From rest, a step changes the velocity (numbers 2 and 3 of `dropout`) to that side."""
    world = find("vmas:dropout,n_agents=2")
    state = world.start_from_seeds([3] * 9)
    state = world.step(state, np.stack([np.arange(9), np.zeros(9, int)], axis=1))
    moved = np.sign(world.observe(state)[0][:, 2:4]).astype(int)
    ways = {(0, 0): "stay", (-1, 0): "left", (1, 0): "right", (0, -1): "down", (0, 1): "up"}
    ways |= {(x, y): f"{ways[x, 0]}_{ways[0, y]}" for x in (-1, 1) for y in (-1, 1)}
    assert [action.name for action in world.actions[0]] == [ways[tuple(each)] for each in moved.tolist()]


@needed
def test_numbers_are_forces_within_what_vmas_says():
    """From rest, to the side that the first number says. Beyond the bounds they are clipped, which VMAS asserts."""
    world = find("vmas:dropout,n_agents=2,continuous_actions=True", giving=True)
    assert [(each.name, each.low, each.high) for each in world.outputs[0]] == [("force_x", -1, 1), ("force_y", -1, 1)]
    given = np.zeros((3, 2, 2), np.float32)
    given[:, 0, 0] = [-0.5, 1.0, 7.0]
    state = world.step(world.start_from_seeds([3] * 3), given)
    speed = world.observe(state)[0][:, 2:4]
    assert speed[0, 0] < 0 < speed[1, 0] == speed[2, 0] and not speed[:, 1].any()
    turning = find("vmas:kinematic_bicycle,continuous_actions=True", giving=True)
    assert {each.name for outputs in turning.outputs for each in outputs} >= {"output_0", "output_1"}
    with pytest.raises(InputError, match="continuous actions"):
        find("vmas:dropout,n_agents=2,continuous_actions=True")


@needed
def test_only_the_newest_states_go_on_and_branching_is_refused():
    world = find(BALANCE)
    state = world.start_from_seeds([1, 2])
    world.step(state, np.zeros((2, 2), int))
    with pytest.raises(RuntimeError, match="moved on"):
        world.step(state, np.zeros((2, 2), int))
    with pytest.raises(InputError, match="Q cannot be measured"):
        world.branch()


class Centred:
    """Pushes up on the lower side: nobody's idea of good play."""

    hash, card, centralized = "", {"algorithm": "by hand"}, True

    def __init__(self, world):
        self.world, self.agents = world, world.agents

    def act(self, agents, observations, state):
        return np.stack([np.where(observations[agent][:, 1] < 0.1, 2, 0) for agent in agents], axis=1)

    def q(self, agent, observations, state, joint, given):
        raise NotImplementedError


@needed
@pytest.mark.parametrize("share", ["", "team"])
def test_trees_are_extracted_and_the_profile_plays_the_scenario(monkeypatch, share):
    monkeypatch.setattr(held_out, "EVALUATION_EPISODES", 10)
    world = find(BALANCE)
    settings = {"algorithm": "maviper", "iterations": 2, "rollouts": 8, "selection_episodes": 6, "max_depth": 2}
    profile = extract(world, Unweighted(Centred(world)), Settings.of({**settings, "share": share}, world))
    assert plays(profile, world) and profile.world.reference == "vmas:balance"
    assert all(policy.tree.visits.sum() <= 10 * 20 for policy in profile.agents)
    if share:
        one, other = (policy.tree for policy in profile.agents)
        assert np.array_equal(one.threshold, other.threshold) and np.array_equal(one.action, other.action)


@pytest.fixture
def quick(monkeypatch):
    """Few episodes, held out or of a judgement; the trainings."""
    from maviper.experts.training import train

    monkeypatch.setattr(held_out, "EVALUATION_EPISODES", 10)
    for name in ("CHECKPOINT_EPISODES", "FINAL_EPISODES"):
        monkeypatch.setattr(train, name, 100)
    return train


@needed
@pytest.mark.interop
@pytest.mark.train
def test_an_expert_that_learned_by_reward_becomes_trees_and_code(quick, tmp_path):
    """By a training far too short to be good; the code plays in VMAS's own loop."""
    from maviper.experts import network
    from maviper.experts.cards import Request

    trained = {"steps": 640, "games": 64, "minibatch": 320, "checkpoint_steps": 640}
    trees = {"max_depth": 2, "iterations": 1, "rollouts": 8, "selection_episodes": 8}
    world = find("vmas:navigation,n_agents=2,collisions=False,max_steps=10")
    quick.train(world, tmp_path, Request(overrides=trained, critic=False))
    code = Code(extract(world, Unweighted(network.load(tmp_path, world)[0]), Settings.of(trees, world)))
    play_navigation(code, games=20, steps=10)
    assert code.asked == 400 and code.different == 0


@needed
@pytest.mark.interop
@pytest.mark.train
@pytest.mark.usefixtures("quick")
def test_a_gaussian_expert_becomes_trees_whose_leaves_are_forces(tmp_path, capsys):
    """By the commands, from a training far too short to be good."""
    world = "vmas:dropout,n_agents=2,max_steps=10,continuous_actions=True"
    run, trees = tmp_path / "run", tmp_path / "t.json"
    tiny = [f"--set={each}" for each in ("games=64", "minibatch=320", "checkpoint_steps=640")]
    assert main.run(["train", world, "--steps", "640", *tiny, "-o", str(run)]) == 0
    few = ["--iterations", "1", "--rollouts", "8", "--selection-episodes", "8"]
    small = [*few, "--max-leaves", "4", "--max-depth", "3"]
    assert main.run(["extract", str(run), "--world", world, *small, "-o", str(trees)]) == 0
    assert main.run(["evaluate", str(trees), "--world", world, "--expert", str(run), "--episodes", "20"]) == 0
    assert main.run(["show", str(trees)]) == 0
    assert "force_x, cut to [-1, 1]" in capsys.readouterr().out


@needed
@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("vmas:balanse", ["unknown VMAS scenario 'balanse'", "did you mean 'balance'"]),
        ("vmas:balance,colour=3", ["no such option", "'colour': 3"]),
        ("vmas:balance,num_envs=3", ["num_envs is not a scenario's option"]),
        ("vmas:balance,max_steps=0", ["max_steps is '0'"]),
        ("vmas:balance,n_agents=0", ["make_env raised"]),
        ("vmas:balance,wrap=flatten", ["no such option"]),
    ],
)
def test_what_is_refused_and_the_way_out(name, said):
    with pytest.raises(InputError) as caught:
        find(name)
    assert all(part in str(caught.value) for part in said), str(caught.value)


def test_without_the_package_it_says_so(monkeypatch):
    monkeypatch.setitem(sys.modules, "vmas", None)
    with pytest.raises(MissingToolError, match=r"maviper\[interop\]"):
        find("vmas:balance")


@needed
def test_the_commands(capsys):
    found = check(BALANCE)
    assert usable(found) and any("anywhere in a batch" in each.what for each in found)
    numbers = check(f"{BALANCE},continuous_actions=True")
    assert usable(numbers) and any("numbers within bounds, 2, 2" in each.what for each in numbers)
    missing = [each for each in check("vmas:wheel") if each.mark is Mark.MISSING]
    assert "100 steps are taken" in missing[0].what and "vmas:wheel,max_steps=NUMBER" in missing[0].next_step
    assert main.run(["worlds", "show", BALANCE]) == 0
    assert "agent_1, team agent" in capsys.readouterr().out
