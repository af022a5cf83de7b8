"""What environments say about themselves in a form of their own, or of a size of their own, is refused in words."""

import pytest
from gymnasium.spaces import Box, Dict, Discrete, MultiDiscrete, Tuple

from codegen.errors import InputError
from maviper.worlds.outside.pettingzoo import PettingZooWorld
from maviper.worlds.outside.processes import Copy
from maviper.worlds.outside.spaces import ensure_small
from tests.support.environments import Line

LINE = "tests.support.environments:early"


def world_of(n_actions=3, **said):
    """The world of a line whose environment has these attributes."""

    def made():
        env = Line(goal=3)
        env.action_space = lambda agent: Discrete(n_actions)
        for name, value in said.items():
            setattr(env, name, value)
        return env

    return PettingZooWorld(made, LINE, 1)


@pytest.mark.parametrize("names", [["go"], ["a", "b", "c", "d"], "abc", 5, [1, 2, 3], [None] * 3, []])
def test_action_names_are_one_text_for_each_action(names):
    with pytest.raises(InputError, match="action names of runner_1 are not 3 texts"):
        world_of(action_names={"runner_1": names})


@pytest.mark.parametrize("said", ["text", 5, ["a", "b"], lambda: None])
def test_attributes_that_mean_something_else_say_nothing(said):
    world = world_of(action_names=said, features=said, teams=said, legal=said)
    assert [action.name for action in world.actions[1]] == ["action_0", "action_1", "action_2"]
    assert world.features[1][0].name == "feature_0" and len(world.start_from_seeds([0])) == 1


def test_features_of_an_agent_are_specs():
    with pytest.raises(InputError, match="are not 3 FeatureSpecs"):
        world_of(features={"runner_1": 5})


@pytest.mark.parametrize("legal", [5, "ab", [1, 2, 3], {"a": 1}])
def test_what_makes_actions_legal_is_named_by_texts(legal):
    with pytest.raises(InputError, match="`legal` does not name features for the actions of runner_1"):
        world_of(legal={"runner_1": legal})


def test_actions_may_be_legal_always_or_by_a_feature_without_a_name_of_its_own():
    world = world_of(legal={"runner_1": ["", "feature_0", ""]})
    assert world.mask(1) == Copy(world.reference_env(), world.source).masks[1] == (None, 0, None)
    assert len(world.start_from_seeds([0])) == 1


def test_so_many_actions_are_no_choices():
    with pytest.raises(InputError, match="1,000,000,000,000 actions, of at most 65,536"):
        world_of(n_actions=10**12)


@pytest.mark.parametrize(
    ("space", "size"),
    [
        (Discrete(10**15), 10**15),
        (Dict({"a": Tuple((Discrete(10**15), Box(-1, 1, (2, 2)))), "b": MultiDiscrete([2, 3])}), 10**15 + 9),
    ],
)
def test_the_size_of_an_observation_is_known_before_anything_of_that_size_is_made(space, size):
    with pytest.raises(InputError, match=f"an observation has {size:,} numbers"):
        ensure_small(space, "here")
    ensure_small(Box(-1, 1, (3,)), "here")
