"""mpe2's continuous actions in our games: bit for bit mpe2's own, refused where actions are numbered."""

import numpy as np
import pytest

from codegen import policy_json, profiles
from codegen.errors import InputError
from maviper.cli import main
from maviper.evaluation import held_out
from maviper.experts import network
from maviper.extraction.algorithms import extract
from maviper.extraction.settings import Settings
from maviper.worlds import find, parallel_env
from maviper.worlds.matching import matching_world

DECEPTION = "physical-deception,continuous=1"
GAMES = (DECEPTION, "physical-deception,defenders=3,continuous=1", "cooperative-navigation,continuous=1")


@pytest.mark.parametrize("name", GAMES)
def test_episodes_are_mpe2s_bit_for_bit(name):
    world, rng = find(name, giving=True), np.random.default_rng(0)
    env, ours = world.reference_env(), parallel_env(name)
    for seed in range(2):
        seen, _ = env.reset(seed=seed)
        ours.reset(seed=seed)
        state = world.start_from_seeds([seed])
        for _ in range(world.spec.episode_steps):
            given = rng.random((1, *world.acting_shape)).astype(np.float32)
            acted = {agent: given[0, place] for place, agent in enumerate(world.agents)}
            seen, paid, _, _, _ = env.step(acted)
            mine, mine_paid, _, _, _ = ours.step(acted)
            state = world.step(state, given, exact=True)
            for place, agent in enumerate(world.agents):
                assert np.array_equal(world.observe(state)[place][0], seen[agent])
                assert mine[agent].tobytes() == seen[agent].tobytes()
                assert world.rewards(state)[0, place] == paid[agent] == mine_paid[agent]
    space = ours.action_space(world.agents[0])
    assert space == env.action_space(world.agents[0])


def test_the_difference_of_two_numbers_is_what_pushes():
    """Without either of the two, or with the first number, nothing changes but what they say."""
    world = find(DECEPTION, giving=True)
    state = world.start_from_seeds([1] * 4)
    given = np.zeros((4, 3, 5), np.float32)
    given[1, :, 0] = 1.0  # stay
    given[2, :, 1:3] = 0.75  # left and right
    given[3, :, 4] = 0.5  # up
    after = world.step(state, given)
    assert (after.velocity[:3] == 0).all()
    assert (after.velocity[3] == [[0.0, 0.25]] * 3).all()


def test_its_spec_states_no_motion_and_its_name_finds_it_again():
    world = find(DECEPTION, giving=True)
    assert (world.spec.dt, world.spec.damping) == (0.0, 0.0) and world.name == DECEPTION
    assert [output.name for output in world.outputs[0]] == ["stay", "left", "right", "down", "up"]
    assert find("physical-deception,continuous=0").spec == find("physical-deception").spec


@pytest.mark.parametrize(
    ("name", "giving", "said"),
    [
        (DECEPTION, False, "continuous actions(.|\\n)*leave continuous=1 out"),
        (f"{DECEPTION},physics=released", True, "by mpe2's physics alone"),
        ("physical-deception,continuous=2", True, "from 0 to 1"),
    ],
)
def test_what_there_is_not(name, giving, said):
    with pytest.raises(InputError, match=said):
        find(name, giving=giving)


def test_a_game_outside_its_box_is_refused():
    env = parallel_env(DECEPTION)
    env.reset(seed=0)
    with pytest.raises(InputError, match="give it numbers within its Box"):
        env.step({agent: np.full(5, 2.0, np.float32) for agent in env.agents})


def test_the_other_physics_are_an_environment_too():
    """Its spec states no motion, which pictures once divided by."""
    assert parallel_env("physical-deception,physics=released").metadata["render_fps"] == 10


@pytest.fixture(scope="module")
def profile():
    """Trees of networks that nobody trained."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(held_out, "EVALUATION_EPISODES", 8)
        world, rng = find(DECEPTION, giving=True), np.random.default_rng(0)
        shapes = network.shapes(world, 8, "actor").items()
        tensors = {name: rng.normal(size=shape).astype(np.float32) / shape[0] ** 0.5 for name, shape in shapes}
        expert = network.build_expert(world, tensors, {"world": world.name})
        small = {"iterations": 1, "rollouts": 4, "selection_episodes": 4, "max_leaves": 4, "max_depth": 3}
        return extract(world, expert, Settings.of(small, world))


@pytest.mark.slow
def test_a_profile_is_evaluated_and_compiled_by_its_own_world(profile, tmp_path, capsys, few_observations):
    again = profiles.loads(policy_json.dumps(profile))
    world = matching_world(again)
    assert world is not None and world.name == DECEPTION
    place = tmp_path / "trees.json"
    place.write_text(policy_json.dumps(profile))
    assert main.run(["evaluate", str(place), "--episodes", "20"]) == 0
    assert "defenders" in capsys.readouterr().out
    assert main.run(["compile", str(place), "-o", str(tmp_path / "code"), "--target", "c,json"]) == 0
    captured = capsys.readouterr()
    assert "0 differ" in captured.out + captured.err and "episodes driven by c" in captured.out + captured.err


@pytest.mark.parametrize(
    "command", [["verify"], ["evaluate", "--exploit", "defenders"], ["extract", "physical-deception"]]
)
def test_commands_that_need_numbered_actions_refuse_it(profile, tmp_path, capsys, command):
    place = tmp_path / "trees.json"
    place.write_text(policy_json.dumps(profile))
    verb, *rest = command
    asked = [verb, DECEPTION, "-o", str(tmp_path / "x.json")] if verb == "extract" else [verb, str(place), *rest]
    assert main.run(asked) == 2
    assert "numbers" in capsys.readouterr().err


def test_its_worlds_commands(capsys):
    assert main.run(["worlds", "check", DECEPTION]) == 0
    assert "numbers within bounds, 5, 5, 5" in capsys.readouterr().out
    assert main.run(["worlds", "show", DECEPTION]) == 0
    assert "gives right" in capsys.readouterr().out
