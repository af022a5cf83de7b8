"""Trees of others as agents of a game: numbers stay, names are tied, what does not fit is refused."""

from dataclasses import replace

import numpy as np
import pytest

import maviper
from codegen.errors import ExitCode, InputError, UnknownNameError
from codegen.ir import act, outputs
from codegen.policy_json import dumps
from codegen.targets import emit
from maviper.importing import games
from maviper.page.page import contents_of, page
from maviper.worlds import find
from maviper.worlds.matching import not_ours, plays
from tests.support.verifying import run

CAR = "gymnasium:MountainCar-v0"
NUMBERS = "def car(obs):\n    position, velocity = obs\n    if velocity < 0:\n        return 0\n    return 2\n"
TEXTS = "def car({}):\n    if {} < 0:\n        return 'left'\n    return 'right'\n"


@pytest.fixture
def bring(tmp_path):
    """Imports a text into a game."""

    def brought(source, world=CAR, **said):
        (tmp_path / "car.py").write_text(source)
        return maviper.from_file(tmp_path / "car.py", name=world, **said)

    return brought


def test_numbers_of_actions_stay_and_the_game_is_played(bring, tmp_path, capsys):
    profile = bring(NUMBERS)
    (policy,) = profile.agents
    world = find(CAR)
    assert plays(profile, world) and profile.world == world.spec and policy.numbers == "float32"
    assert [each.name for each in policy.features] == ["position", "velocity"]
    assert act(policy, np.array([[0, -0.1], [0, 0], [0, 0.1]])).tolist() == [0, 2, 2]
    (tmp_path / "car.json").write_text(dumps(profile))
    file = str(tmp_path / "car.json")
    code, out, _ = run(capsys, "evaluate", file, "--world", CAR, "--episodes", "3")
    assert code == ExitCode.DONE and "-1" in out
    code, _, err = run(capsys, "evaluate", file)
    assert code == ExitCode.INPUT and f"add --world {CAR}" in err


def test_features_are_tied_by_name_or_by_place(bring):
    by_name = bring("def car(velocity, position):\n    if velocity < 0:\n        return 0\n    return 2\n")
    by_place = bring("def car(x):\n    if x[1] < 0:\n        return 0\n    return 2\n")
    keyed = bring("def car(obs):\n    if obs['velocity'] < 0:\n        return 0\n    return 2\n")
    rows = np.array([[0.5, -0.1], [-0.5, 0.1], [-0.5, -0.1], [0.5, 0.0]])
    for profile in (by_name, by_place, keyed):
        assert act(profile.agents[0], rows).tolist() == [0, 2, 0, 2]
        assert [each.name for each in profile.agents[0].features] == ["position", "velocity"]
    note = "features are tied by name: the source has them in the order velocity, position"
    assert by_name.provenance.training["agent notes"] == note
    unpacked = bring(NUMBERS.replace("position, velocity", "velocity, position"))
    assert unpacked.provenance.training["agent notes"] == note
    for profile in (by_place, keyed, bring(NUMBERS)):
        assert "agent notes" not in profile.provenance.training


def test_names_that_a_user_ties(bring):
    said = {"feature_names": ["velocity=speed"], "action_names": ["accelerate_left=left", "accelerate_right=right"]}
    (policy,) = bring(TEXTS.format("position, speed", "speed"), **said).agents
    assert act(policy, np.array([[1, -0.1], [-1, 0.1]])).tolist() == [0, 2]
    assert [each.name for each in policy.actions] == ["accelerate_left", "coast", "accelerate_right"]


@pytest.mark.parametrize(
    ("source", "said", "message"),
    [
        (TEXTS.format("position, speed", "speed"), {}, "unknown feature 'speed'"),
        (TEXTS.format("position, velocity", "velocity"), {}, "the source returns left"),
        ("def car(x):\n    return 3 if x[0] < 0 else 0\n", {}, "the source returns 3"),
        ("def car(x):\n    return -1 if x[0] < 0 else 0\n", {}, "the source returns -1"),
        ("def car(x):\n    return 1 if x[4] < 0 else 0\n", {}, "reads feature 4"),
        ("def car(a, b, c):\n    return 1 if b < 0 else 0\n", {}, "3 features"),
        (NUMBERS, {"feature_names": ["a"]}, "1 feature"),
        (NUMBERS, {"action_names": ["a", "b"]}, "2 actions"),
        (NUMBERS, {"feature_names": ["velocity", "position"]}, "feature 0 of agent is position in this world"),
        (NUMBERS, {"action_names": ["coast", "left", "right"]}, "calls it coast"),
        (
            TEXTS.format("position, velocity", "velocity"),
            {"action_names": ["coast=left", "coast=right"]},
            "same action",
        ),
    ],
)
def test_what_does_not_fit_is_refused(bring, source, said, message):
    with pytest.raises((InputError, UnknownNameError), match=message):
        bring(source, **said)


def test_a_name_of_the_world_for_something_else_is_another_world(bring):
    """By name a proof would take one action, by place the game another one."""
    profile = bring(NUMBERS, action_names=["left", "none", "right"])
    world = find(CAR)
    assert plays(profile, world)
    (policy,) = profile.agents
    for kind, names in (("actions", ["coast", "none", "right"]), ("features", ["velocity", "position"])):
        own = tuple(replace(each, name=name) for each, name in zip(getattr(policy, kind), names, strict=True))
        assert not plays(replace(profile, agents=(replace(policy, **{kind: own}),)), world)


def test_each_agent_has_a_tree(tmp_path):
    (tmp_path / "both.py").write_text("".join(f"def {name}(x):\n    return 1 if x[0] < 0 else 0\n" for name in "ab"))
    with pytest.raises(UnknownNameError, match="unknown agent 'a'"):
        maviper.from_file(tmp_path / "both.py", name="physical-deception")
    one = tmp_path / "one.py"
    one.write_text("def f(x):\n    return 1 if x[0] < 0 else 0\n")
    world = find("physical-deception")
    with pytest.raises(InputError, match="has no tree"):
        maviper.from_file({world.agents[0]: one}, name="physical-deception")
    profile = maviper.from_file(dict.fromkeys(world.agents, one), name="physical-deception")
    assert plays(profile, world) and not not_ours(profile.world)


def test_a_game_that_is_not_ours_is_no_failed_check(bring, tmp_path, capsys):
    (tmp_path / "car.json").write_text(dumps(bring(NUMBERS)))
    code, _, err = run(capsys, "compile", str(tmp_path / "car.json"), "--target", "python", "-o", str(tmp_path / "out"))
    assert code == ExitCode.DONE
    assert f"episodes    not replayed: only built-in games can be replayed, and {CAR} is not one" in err


def test_what_needs_rules_or_landmarks_says_so(bring, tmp_path, capsys):
    """A game that is played by code can be asked about observations only; a world file also as `system:FILE`."""
    (tmp_path / "car.json").write_text(dumps(bring(NUMBERS)))
    file = str(tmp_path / "car.json")
    code, _, err = run(capsys, "verify", file, "--system", CAR)
    assert code == ExitCode.INPUT and "states no rules that a proof could use" in err and "leave --system out" in err
    code, _, err = run(capsys, "verify", file, "--system", f"system:{tmp_path / 'nowhere.toml'}")
    assert code == ExitCode.INPUT and f"{tmp_path / 'nowhere.toml'}: No such file" in err and "system:" not in err
    code, _, err = run(capsys, "repair", file, "-o", str(tmp_path / "mended"))
    assert code == ExitCode.INPUT and "change the file that it came from" in err


def test_zones_that_end_at_zero_say_zero(bring, tmp_path, capsys):
    """Not half of the smallest float32, where the last number below 0 ends."""
    for name, threshold in (("zero", "0"), ("low", "-0.01")):
        text = NUMBERS.replace("< 0", f"< {threshold}")
        (tmp_path / f"{name}.json").write_text(dumps(bring(text)))
    code, _, err = run(capsys, "diff", str(tmp_path / "zero.json"), str(tmp_path / "low.json"))
    assert code == ExitCode.VIOLATED and "velocity < 0\n" in err and "e-4" not in err, err


SWING = """
import numpy as np
def swing(x):
    if x[0] > 0.9:
        return {}
    return 2.0 if x[2] - 0.5 * x[1] > 0 else -2.0
"""
ALONE = "import numpy as np\ndef car(x):\n    return {}\n"
PENDULUM = "gymnasium:Pendulum-v1"


def test_numbers_that_a_tree_gives_are_the_worlds_outputs(bring, monkeypatch):
    """With the names, the unit and the bounds of the world; an episode of it is on the page."""
    monkeypatch.setattr(games, "EPISODES", 2)
    world = find(PENDULUM, giving=True)
    for cut in ("np.clip(-12.0 * x[1] - 2.5 * x[2], -2.0, 2.0)", "np.clip(-12.0 * x[1] - 2.5 * x[2], -3.0, 2.0)"):
        profile = bring(SWING.format(cut), PENDULUM, arrays="float32")
        (policy,) = profile.agents
        assert plays(profile, world) and policy.outputs == world.outputs[0]
        assert [(each.name, each.unit, each.low, each.high) for each in policy.outputs] == [
            ("torque", "N m", -2.0, 2.0)
        ]
        assert outputs(policy, [[1.0, 0.5, 0.0], [1.0, -0.125, 0.0], [0.0, 0.0, -1.0]]).tolist() == [[-2], [1.5], [-2]]
    html = page(profile, contents_of(profile, (), played=world))
    assert "The recorded episode, of seed 4000000, took 200 steps" in html and "gives 1 number (torque in N m)" in html


@pytest.mark.parametrize(
    ("source", "world", "message"),
    [
        (ALONE.format("np.clip(-12.0 * x[1], -1.0, 1.0)"), PENDULUM, r"cuts torque to \[-1.0, 1.0\]"),
        (ALONE.format("x[1] - x[0]"), CAR, "gives numbers, and the world takes actions"),
        ("def car(x):\n    return [x[0], x[1]]\n", PENDULUM, "2 outputs for agent"),
        (NUMBERS.replace("obs\n", "obs[:2]\n", 1), PENDULUM, "takes actions, and gives no numbers"),
    ],
)
def test_numbers_that_do_not_fit_are_refused(bring, source, world, message):
    with pytest.raises(InputError, match=message) as caught:
        bring(source, world, arrays="float32")
    assert caught.value.next_step


CARDS = """
def dealer_beater(obs):
    player, dealer, usable = obs
    if usable:
        return 1 if player <= 17 else 0
    return 1 if player <= 11 or (player <= 16 and dealer >= 7) else 0
"""


def test_a_tree_of_whole_numbers_plays_cards(bring):
    (policy,) = bring(CARDS, "gymnasium:Blackjack-v1,wrap=numbers,max_steps=20").agents
    assert [each.name for each in policy.features] == ["player_sum", "dealer_card", "usable_ace"]
    assert [each.name for each in policy.actions] == ["stick", "hit"]
    assert act(policy, [[17, 7, 1], [17, 7, 0], [16, 7, 0], [16, 6, 0], [11, 6, 0]]).tolist() == [1, 0, 1, 0, 1]


def test_where_each_value_is_a_feature_the_way_out_is_named(bring):
    with pytest.raises(InputError, match=r"3 features for agent, who has 45") as caught:
        bring(CARDS, "gymnasium:Blackjack-v1,wrap=flatten,max_steps=20")
    assert "and 15 more" in caught.value.next_step and "wrap=numbers shows" in caught.value.next_step


COUNTING = """
import gymnasium
import numpy as np

class Walk(gymnasium.Env):
    observation_space = gymnasium.spaces.Box(-9, 9, (1,))

    def __init__(self, first=1):
        self.action_space = gymnasium.spaces.Discrete(3, start=first)

    def reset(self, seed=None, options=None):
        super().reset(seed=seed)
        self.x, self.time = 0.5, 0
        return np.array([self.x], np.float32), {}

    def step(self, action):
        assert self.action_space.contains(action), action
        self.x, self.time = self.x + 0.25 * (action - self.action_space.start - 1), self.time + 1
        return np.array([self.x], np.float32), self.x, False, self.time == 4, {}

def make(first=1):
    return Walk(first)

class Named:
    # counts actions from 0, and calls the first one action_1

    metadata, possible_agents = {"name": "named"}, ["car"]
    action_names = {"car": ["action_1", "action_2", "action_3"]}

    def __init__(self):
        self.env, self.agents = Walk(0), []

    def observation_space(self, agent):
        return self.env.observation_space

    def action_space(self, agent):
        return self.env.action_space

    def reset(self, seed=None, options=None):
        self.agents = ["car"]
        return tuple({"car": each} for each in self.env.reset(seed=seed))

    def step(self, actions):
        seen = self.env.step(actions["car"])
        self.agents = [] if seen[3] else self.agents
        return tuple({"car": each} for each in seen)

def named():
    import pettingzoo
    return type("Car", (Named, pettingzoo.ParallelEnv), {})()
"""


@pytest.mark.parametrize(("first", "down", "stay"), [(1, 1, 2), (-1, -1, 0), (-1, 0, 1), (0, 0, 1)])
def test_numbers_are_those_that_the_environment_counts(bring, tmp_path, monkeypatch, first, down, stay):
    """Of actions that are counted from 1, what returns 1 is the first: by its place it would be the second."""
    (tmp_path / "counting.py").write_text(COUNTING)
    monkeypatch.chdir(tmp_path)
    name = f"counting:make,first={first}"
    source = f"def car(x):\n    return {down} if x[0] > 0.1 else {stay}\n"
    (policy,) = bring(source, name).agents
    assert act(policy, np.array([[1.0], [0.0]])).tolist() == [down - first, stay - first]
    assert [each.name for each in policy.actions] == [f"action_{first + k}".replace("-", "minus_") for k in range(3)]
    (renamed,) = bring(source, name, action_names=["a", "b", "c"]).agents
    assert act(renamed, np.array([[1.0], [0.0]])).tolist() == [down - first, stay - first]
    with pytest.raises(InputError, match=f"the source returns {first + 3}, which is no action"):
        bring(f"def car(x):\n    return {first + 3} if x[0] > 0.1 else {stay}\n", name)


@pytest.mark.parametrize("wrap", ["", ",wrap=flatten"])
@pytest.mark.parametrize("first", [1, -1])
def test_names_of_a_source_are_kept_whatever_the_environment_counts_from(bring, tmp_path, monkeypatch, first, wrap):
    (tmp_path / "counting.py").write_text(COUNTING)
    monkeypatch.chdir(tmp_path)
    source = f"from enum import IntEnum\n\nclass Go(IntEnum):\n    DOWN = {first}\n    UP = {first + 2}\n\n"
    source += "def car(x):\n    return Go.DOWN if x[0] > 0.1 else Go.UP\n"
    name = f"counting:make,first={first}{wrap}"
    profile = bring(source, name)
    (policy,) = profile.agents
    assert [each.name for each in policy.actions] == ["DOWN", f"action_{first + 1}", "UP"]
    assert act(policy, np.array([[1.0], [0.0]])).tolist() == [0, 2] and plays(profile, find(name))


def test_a_profile_from_before_the_actions_had_their_numbers_is_of_another_version(
    bring, tmp_path, monkeypatch, capsys
):
    (tmp_path / "counting.py").write_text(COUNTING)
    monkeypatch.chdir(tmp_path)
    profile = bring("def car(x):\n    return 1 if x[0] > 0.1 else 2\n", "counting:make")
    (policy,) = profile.agents
    before = tuple(replace(each, name=f"action_{k}") for k, each in enumerate(policy.actions))
    old = replace(profile, agents=(replace(policy, actions=before),))
    (tmp_path / "old.json").write_text(dumps(old))
    code, _, err = run(capsys, "evaluate", "old.json", "--world", "counting:make", "--episodes", "1")
    assert code == ExitCode.INPUT and "old.json: counting:make in another version" in err


def test_onnx_of_ours_gives_places_of_actions(bring, tmp_path, monkeypatch):
    """Whatever the environment counts from: 0 is the first action, as in all generated code."""
    pytest.importorskip("onnxruntime", reason="onnxruntime is not installed")
    (tmp_path / "counting.py").write_text(COUNTING)
    monkeypatch.chdir(tmp_path)
    profile = bring("def car(x):\n    return -1 if x[0] > 0.1 else 0\n", "counting:make,first=-1")
    (model,) = emit(profile, ["onnx"]).values()
    (tmp_path / "car.onnx").write_bytes(model)
    again = maviper.from_file(tmp_path / "car.onnx", name="counting:make,first=-1")
    rows = np.array([[1.0], [0.0]])
    assert act(again.agents[0], rows).tolist() == act(profile.agents[0], rows).tolist() == [0, 1]
    assert again.agents[0].actions == profile.agents[0].actions


def test_onnx_of_ours_from_a_tree_without_a_game_gives_its_numbers(tmp_path, monkeypatch):
    """Without a game, an action has the number that the tree returned: there is no other place."""
    pytest.importorskip("onnxruntime", reason="onnxruntime is not installed")
    (tmp_path / "counting.py").write_text(COUNTING)
    (tmp_path / "car.py").write_text("def car(x):\n    return 1 if x[0] > 0.1 else 2\n")
    monkeypatch.chdir(tmp_path)
    (model,) = emit(maviper.from_file(tmp_path / "car.py", arrays="float32"), ["onnx"]).values()
    (tmp_path / "car.onnx").write_bytes(model)
    (policy,) = maviper.from_file(tmp_path / "car.onnx", name="counting:make").agents
    assert act(policy, np.array([[1.0], [0.0]])).tolist() == [0, 1]


def test_numbers_in_names_of_actions_are_no_count(bring, tmp_path, monkeypatch):
    """An environment that counts from 0 is given 0 and 1, whatever number is in the names that it has for them."""
    (tmp_path / "counting.py").write_text(COUNTING)
    monkeypatch.chdir(tmp_path)
    (policy,) = bring("def car(x):\n    return 1 if x[0] > 0.1 else 0\n", "counting:named").agents
    assert act(policy, np.array([[1.0], [0.0]])).tolist() == [1, 0]
    assert [each.name for each in policy.actions] == ["action_1", "action_2", "action_3"]
