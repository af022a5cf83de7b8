"""Trees that remember their last action: from extraction to play, code and claims."""

from dataclasses import replace

import gymnasium
import numpy as np
import pytest
from gymnasium.spaces import Box, Discrete

import maviper
from codegen import ir
from codegen.errors import InputError
from codegen.lowering.deploy import deploy_tree
from codegen.memory import step_memory
from maviper import worlds
from maviper.episodes.trees import agent_policies, reopen_tree
from maviper.evaluation.players import find_player
from maviper.worlds import checking
from maviper.worlds.remembering import LAST_ACTION, SINCE_CHANGE, Remembering, split_memory

QUICK = {"max_depth": 2, "iterations": 2, "rollouts": 10, "held_out": 10, "selection_episodes": 10}
STEPS = 12


class Blink(gymnasium.Env):
    """A lamp that shall change in every step. It sees how many steps have gone."""

    observation_space = Box(np.float32([0]), np.float32([STEPS]), dtype=np.float32)
    action_space = Discrete(2)
    max_cycles = STEPS

    def reset(self, seed=None, options=None):
        super().reset(seed=seed)
        self.gone, self.on = 0, 0
        return np.array([0], np.float32), {}

    def step(self, action):
        changed, self.on, self.gone = int(action) != self.on, int(action), self.gone + 1
        return np.array([self.gone], np.float32), float(changed), False, self.gone == STEPS, {}


def blink():
    return Blink()


def alternate(agent, rows):
    return 1 - rows[:, 0].astype(int) % 2


@pytest.fixture(scope="module")
def lamp():
    return maviper.extract(alternate, world=blink, features=LAST_ACTION, **QUICK)


def drive(team):
    env, acted = blink(), []
    seen, over = env.reset()[0], False
    team.reset()
    while not over:
        acted.append(int(team.act(seen)))
        seen, _, _, over, _ = env.step(acted[-1])
    return acted


def test_memory_solves_what_no_small_tree_can_without_it(lamp):
    returned = lamp.provenance.evaluation["agent return"]
    without = maviper.extract(alternate, world=blink, **QUICK).provenance.evaluation["agent return"]
    assert returned == STEPS > without
    (policy,) = lamp.agents
    assert [each.name for each in policy.memory] == [LAST_ACTION]
    assert lamp.world.options == {}


def test_a_team_remembers_until_it_is_reset_also_from_a_file(lamp, tmp_path):
    again = maviper.load(lamp.save(tmp_path / "lamp.json"))
    assert drive(lamp) == drive(lamp) == drive(again) == [1, 0] * (STEPS // 2)
    measured = maviper.evaluate(again, world=blink, episodes=5, expert=alternate)
    assert measured["agent", "return"].value == STEPS
    assert maviper.extract(alternate, world=blink, features=LAST_ACTION, **QUICK).to_text() == lamp.to_text()


def test_code_remembers_as_the_team_does(lamp):
    made = maviper.compile(lamp, ["python", "c"])
    module = {}
    exec(next(text for name, text in made.files.items() if name.endswith(".py")), module)
    machine = next(each for name, each in module.items() if name.startswith("Machine_"))()
    assert [machine.step([gone]) for gone in range(STEPS)] == drive(lamp)
    assert "_step(" in next(text for name, text in made.files.items() if name.endswith(".h"))


HEATER = """name = "heater"
steps = 60
[variables]
t = { unit = "K", range = [0, 40] }
heating = { modes = ["off", "on"] }
[agents.heater]
reward = "1"
[agents.heater.features]
t = "t"
last_action = "heating == on"
[agents.heater.actions]
off = { power = 0 }
on = { power = 1 }
[start]
box = { t = [10, 30], heating = "off" }
[dynamics.next]
heating = "acts(heater)"
t = "0.95*t + 0.5[K] + heater.power*1[K]"
[[claim]]
formula = "heater.last_action >= 1 and t < 20 implies acts(heater) == on"
[[claim]]
formula = "heater.last_action <= 0 and t < 20 implies acts(heater) == on"
"""


def keep(agent, rows):
    temperature, on = rows.T
    return np.where(on > 0.5, temperature < 21.0, temperature < 19.0).astype(int)


def test_what_a_world_shows_as_last_action_is_remembered_instead_and_claims_name_it(tmp_path):
    file = tmp_path / "heater.toml"
    file.write_text(HEATER)
    team = maviper.extract(keep, world=f"system:{file}", features=LAST_ACTION, **QUICK)
    assert [each.name for each in team["heater"].features] == ["t", LAST_ACTION]
    assert team["heater"].features[-1].initial == 0
    found = maviper.verify_system(team, file)
    assert [str(each.verdict) for each in found] == ["PROVED", "VIOLATED"]
    env, alone = team._world.reference_env(), maviper.load(team.save(tmp_path / "heater.json"))
    seen, _ = env.reset(seed=1)
    actions = []
    while env.agents:
        acted = team.act(seen, agents=env.agents)
        assert alone.act({"heater": seen["heater"][:1]}) == acted
        actions.append(acted["heater"])
        seen, *_ = env.step(acted)
    assert set(actions) == {0, 1}


def test_another_last_action_is_refused(tmp_path):
    file = tmp_path / "heater.toml"
    file.write_text(HEATER.replace("heating == on", "heating == off"))
    with pytest.raises(InputError, match="observes a last_action of 1, and its last action has place 0"):
        maviper.extract(keep, world=f"system:{file}", features=LAST_ACTION, **QUICK)


def test_agents_of_a_game_remember():
    asked = QUICK | {"algorithm": "imitation", "critic": "none", "iterations": 1, "refinement_episodes": 0}
    team = maviper.extract("cooperative-navigation", features=f"signs+{LAST_ACTION}", **asked)
    world = worlds.find(f"cooperative-navigation,features=signs+{LAST_ACTION}")
    assert isinstance(world, Remembering)
    assert all(policy.features == seen for policy, seen in zip(team.agents, world.features, strict=True))
    _, played = find_player(team, "SUBJECT", None)
    assert played.name == world.name
    measured = maviper.evaluate(team, episodes=10)
    assert measured.trees
    # others play beside it as they are
    plain = maviper.extract("cooperative-navigation", features="signs", **asked)
    mixed = maviper.evaluate(team, episodes=10, replaced=[("agent_0", plain)])
    assert mixed.rows
    with pytest.raises(InputError, match="agents of the profile remember something"):
        maviper.evaluate(plain, episodes=10, replaced=[("agent_0", team)])


def test_trees_that_answer_one_another_take_actions():
    """Q is asked of the actions that are taken, whatever changes memory."""
    asked = {"max_leaves": 4, "iterations": 2, "rollouts": 2, "held_out": 5, "refinement_episodes": 0}
    team = maviper.extract("physical-deception", features=LAST_ACTION, algorithm="rgmdt", **asked)
    assert all(policy.memory for policy in team.agents)


def test_a_profile_whose_leaf_forgets_plays_no_world(lamp):
    (policy,) = lamp.agents
    action = policy.tree.action.copy()
    action[action >= 2] -= 2
    forgetting = replace(policy, tree=replace(policy.tree, action=action), grown=None)
    with pytest.raises(InputError, match="plays another world"):
        maviper.evaluate(replace(lamp, agents=(forgetting,)), world=blink, episodes=5)


def test_a_last_action_is_kept_where_an_agent_does_not_act():
    world = worlds.find(f"coordination,features={LAST_ACTION}")
    state = world.step(world.start_from_seeds([0, 1]), np.array([[1, 2, 0], [0, 1, 2]]))
    for each in (state, world.step(state, np.zeros((2, 3), int))):  # nobody acts after the decision
        assert [rows[:, -1].tolist() for rows in world.observe(each)] == [[1, 0], [2, 1], [0, 2]]
    joined = type(state).concatenate([state[np.array([1])], state])
    assert world.observe(joined)[0][:, -1].tolist() == [0, 1, 0]


def test_names_with_memory():
    assert split_memory("a,features=velocity+last_action,b=1") == ("a,b=1,features=velocity", LAST_ACTION)
    assert split_memory("a,features=velocity") == ("a,features=velocity", "")
    name = "physical-deception,features=last_action"
    assert worlds.find(name).name == name
    assert not [each for each in checking.check(f"{name}") if each.mark is checking.Mark.WRONG]


def test_what_cannot_remember_is_refused():
    with pytest.raises(InputError, match="where agents give numbers"):
        worlds.find("physical-deception,continuous=1,features=last_action")
    with pytest.raises(InputError, match="the place of a last action is none"):
        maviper.extract(alternate, world=blink, features=LAST_ACTION, splits="sums", **QUICK)


PERIOD, ROUNDS = 3, 8


class Signal(Blink):
    """A lamp that shall change in every third step. It sees how many steps have gone."""

    observation_space = Box(np.float32([0]), np.float32([PERIOD * ROUNDS]), dtype=np.float32)
    max_cycles = PERIOD * ROUNDS

    def step(self, action):
        right, self.gone = float(action == (self.gone + 1) // PERIOD % 2), self.gone + 1
        return np.array([self.gone], np.float32), right, False, self.gone == self.max_cycles, {}


def signal():
    return Signal()


def by_steps(agent, rows):
    return (rows[:, 0].astype(int) + 1) // PERIOD % 2


@pytest.fixture(scope="module")
def timed():
    return maviper.extract(by_steps, world=signal, features=f"{SINCE_CHANGE}:5", **QUICK)


def walk(team):
    team.reset()
    return [int(team.act(np.array([gone], np.float32))) for gone in range(PERIOD * ROUNDS)]


def test_steps_since_a_change_are_remembered_as_well(timed, tmp_path):
    (policy,) = timed.agents
    assert [(each.name, each.high) for each in policy.memory] == [(LAST_ACTION, 1), (SINCE_CHANGE, 5)]
    assert timed.provenance.evaluation["agent return"] == PERIOD * ROUNDS
    right = [(gone + 1) // PERIOD % 2 for gone in range(PERIOD * ROUNDS)]
    again = maviper.load(timed.save(tmp_path / "timed.json"))
    assert walk(timed) == walk(timed) == walk(again) == right
    assert maviper.evaluate(again, world=signal, episodes=5, expert=by_steps)["agent", "return"].value == len(right)
    made = maviper.compile(timed, ["python", "c"])
    module = {}
    exec(next(text for name, text in made.files.items() if name.endswith(".py")), module)
    machine = next(each for name, each in module.items() if name.startswith("Machine_"))()
    assert [machine.step([gone]) for gone in range(PERIOD * ROUNDS)] == right


def test_a_leaf_that_does_not_know_whether_it_repeats_asks():
    """Every tree that is deployed remembers as the world does, wherever its tests leave the last action open."""
    world = worlds.find(f"cooperative-navigation,features={SINCE_CHANGE}:3")
    count, last = len(world.actions[0]), len(world.features[0]) - 2
    rng, features = np.random.default_rng(0), [0, last, last + 1]
    for _ in range(20):
        feature = np.array([rng.choice(features), rng.choice(features), -1, -1, -1])
        line = np.array([rng.integers(0, 4) + 0.5, rng.integers(0, 4) + 0.5, 0, 0, 0])
        action = np.array([-1, -1, *rng.integers(0, count, 3)])
        children = np.array([1, 2, -1, -1, -1]), np.array([4, 3, -1, -1, -1])
        grown = ir.GrownTree(feature, line, *children, action)
        deployed = world.deploy(0, grown)
        (policy,) = agent_policies(world, [grown], [0])
        assert world.remembers_alike(policy)
        rows = rng.uniform(-2, 2, (400, len(world.features[0]))).astype(np.float32)
        rows[:, last], rows[:, last + 1] = rng.integers(0, count, 400), rng.integers(0, 4, 400)
        acts = deploy_tree(grown).action[ir.apply(deploy_tree(grown), rows)]
        chosen, after = step_memory(policy, rows[:, last:].astype(int), rows[:, :last])
        repeats = acts == rows[:, last]
        assert (chosen == acts).all()
        assert (after == np.stack([acts, np.where(repeats, np.minimum(rows[:, -1] + 1, 3), 0)], axis=1)).all()
        assert len(world.deploy(0, reopen_tree(policy)).action) == len(deployed.action)


def test_claims_name_the_steps(tmp_path):
    file = tmp_path / "heater.toml"
    formula = "heater.time_since_change <= {} or acts(heater) == on or heater.last_action <= 0 or t > 30"
    claims = "".join(f'[[claim]]\nformula = "{formula.format(most)}"\n' for most in (4, 3))
    file.write_text(HEATER.partition("[[claim]]")[0] + claims)
    team = maviper.extract(keep, world=f"system:{file}", features=f"{SINCE_CHANGE}:4", **QUICK)
    assert [each.name for each in team["heater"].features] == ["t", LAST_ACTION, SINCE_CHANGE]
    found = maviper.verify_system(team, file)
    assert [str(each.verdict) for each in found] == ["PROVED", "VIOLATED"]


def test_other_steps_than_those_that_are_remembered_are_refused(tmp_path):
    file = tmp_path / "heater.toml"
    file.write_text(HEATER.replace('last_action = "', 'time_since_change = "0*t"\nlast_action = "'))
    with pytest.raises(InputError, match="observes a time_since_change of 0, and it repeats for 1"):
        maviper.extract(lambda agent, rows: keep(agent, rows[:, [0, 2]]), world=f"system:{file}", features=SINCE_CHANGE)


def test_bounds_of_steps():
    for wrong in ("0", "x", "-1", "1.5", "1000001", ""):
        with pytest.raises(InputError, match="names no feature with a bound"):
            worlds.find(f"physical-deception,features={SINCE_CHANGE}:{wrong}")
    with pytest.raises(InputError, match="names no feature with a bound"):
        worlds.find(f"physical-deception,features={LAST_ACTION}:3")
    name = f"physical-deception,features=goal+{SINCE_CHANGE}"
    assert worlds.find(name).name == name and worlds.find(name).bound == 60
    assert split_memory(f"a,features={SINCE_CHANGE}:7+velocity+{LAST_ACTION}") == (
        "a,features=velocity",
        f"{SINCE_CHANGE}:7",
    )
