"""A team acts in the environment that it was extracted from, is saved, printed, drawn; functions are taken as such."""

import csv
import io
import sys
from types import SimpleNamespace

import gymnasium
import numpy as np
import pytest
from gymnasium.spaces import Box, Dict, Discrete
from mpe2 import simple_spread_v3
from pettingzoo import ParallelEnv

import maviper
from codegen.errors import ExitCode, InputError, UnknownNameError
from maviper.cli import main
from tests.benchmarks import doorway
from tests.support.latex import typeset

SMALL = {"iterations": 1, "rollouts": 2, "selection_episodes": 2, "held_out": 2, "max_depth": 2}


class Counted(ParallelEnv):
    """Two agents whose observations, actions and ends are as told: actions counted from 3, in a shaped Box, masked."""

    metadata = {"name": "counted_v0"}  # noqa: RUF012 - as PettingZoo has it

    def __init__(self, kind):
        self.possible_agents, self.kind, self.max_cycles = [0, "b 1"], kind, 6
        row = Box(-1, 1, (2,), np.float64)
        masked = Dict({"observation": row, "action_mask": Box(0, 1, (3,), np.int8)})
        self.seen = masked if kind == "masked" else row
        self.does = Box(-2, 2, (2, 2), np.float64) if kind == "shaped" else Discrete(3, start=3 * (kind == "counted"))

    def observation_space(self, agent):
        return self.seen

    def action_space(self, agent):
        return self.does

    def _observe(self, agent):
        row = self.rng.uniform(-1, 1, 2)
        self.mask = np.array([1, 0, 1] if row[0] > 0 else [0, 1, 1], np.int8)
        return {"observation": row, "action_mask": self.mask} if self.kind == "masked" else row

    def reset(self, seed=None, options=None):
        self.rng, self.agents, self.steps = np.random.default_rng(seed), list(self.possible_agents), 0
        return {agent: self._observe(agent) for agent in self.agents}, {agent: {} for agent in self.agents}

    def step(self, actions):
        assert set(actions) == set(self.agents)
        for agent, action in actions.items():
            assert self.does.contains(action), (agent, action)
        self.steps += 1
        ended = {agent: agent == 0 and self.steps == 3 for agent in actions}
        cut = dict.fromkeys(actions, self.steps == 6)
        seen = {agent: self._observe(agent) for agent in actions}
        paid = {agent: float(np.sum(action)) for agent, action in actions.items()}
        self.agents = [agent for agent in self.agents if not ended[agent] and not cut[agent]]
        return seen, paid, ended, cut, {agent: {} for agent in actions}


def counted():
    return Counted("counted")


def shaped():
    return Counted("shaped")


def masked():
    return Counted("masked")


def signs(agent, rows):
    """Actions by the sign of the first feature, counted from 3."""
    return 3 + 2 * (rows[:, 0] > 0)


def four(agent, rows):
    return np.repeat(np.sign(rows[:, :1]), 4, axis=1)


def lawful(agent, rows):
    return np.where(rows[:, 0] > 0, 0, 1)


def uphill(agent, rows):
    return (rows[:, 0] > 0).astype(int)


def by_angle(agent, rows):
    return (rows[:, 2] + rows[:, 3] > 0).astype(int)


ENVIRONMENTS = {  # expert, world of the extraction, the environment as its user holds it
    "agents that leave": (doorway.act, doorway.make, doorway.make),
    "actions from 3": (signs, counted, counted),
    "a shaped Box of float64": (four, shaped, shaped),
    "masks": (lawful, "tests.maviper.test_team:masked,wrap=flatten", masked),
    "mpe2": (uphill, "mpe2.simple_spread_v3:parallel_env", simple_spread_v3.parallel_env),
    "gymnasium": (by_angle, "gymnasium:CartPole-v1", lambda: gymnasium.make("CartPole-v1")),
}


@pytest.mark.parametrize("name", ENVIRONMENTS)
def test_a_team_acts_as_the_environment_takes_it(name, tmp_path):
    expert, world, make = ENVIRONMENTS[name]
    env, team = make(), maviper.extract(expert, world=world, **SMALL)
    loaded = maviper.load(team.save(tmp_path / "team.json"), world)
    seen, _ = env.reset(seed=1)
    if isinstance(env, gymnasium.Env):
        action = team.act(seen)
        assert env.action_space.contains(action) and action == loaded.act(seen)
        return
    steps, legal = 0, True
    while env.agents:
        actions = team.act(seen, agents=env.agents)
        assert list(actions) == env.agents and repr(loaded.act(seen, agents=env.agents)) == repr(actions)
        for agent, action in actions.items():
            assert env.action_space(agent).contains(action), (agent, action)
            legal &= name != "masks" or bool(seen[agent]["action_mask"][action])
        seen, *_ = env.step(actions)
        steps += 1
    assert steps > 2 and legal


def test_a_team_that_nobody_gave_a_world_acts_by_its_own_file(tmp_path):
    team = maviper.extract(signs, world=counted, **SMALL)
    alone = maviper.load(team.save(tmp_path / "team.json"))
    env = counted()
    seen, _ = env.reset(seed=5)
    assert alone.act(seen) == team.act(seen) and set(alone.act(seen).values()) <= {3, 4, 5}
    rows = np.random.default_rng(0).uniform(-1, 1, (50, 2)).astype(np.float32)
    acted = alone["b_1"].act(rows)
    assert acted.dtype == np.int64 and acted.shape == (50,) and (acted + 3 == signs("b 1", rows)).mean() > 0.5
    with pytest.raises(InputError, match="b_1 observes 2 numbers, and 3 are given"):
        alone.act({"b 1": np.zeros(3)})
    with pytest.raises(InputError, match="observes a dictionary"):
        alone.act({"b 1": {"x": 1}})
    with pytest.raises(InputError, match="b_1 is said to observe cannot be read: ValueError"):
        alone.act({"b 1": [[1], [1, 2]]})
    with pytest.raises(InputError, match="observations of 2 agents are a list"):
        alone.act([0.0, 0.0])
    with pytest.raises(InputError, match=r'add world="tests.maviper.test_team:counted"'):
        maviper.evaluate(alone, episodes=1)


@pytest.mark.parametrize(("answer", "said"), [(2, "returns action 2"), (6, "action 6"), (np.uint8(0), "action 0")])
def test_an_experts_wrong_action_is_told_as_the_environment_counts(answer, said):
    with pytest.raises(InputError, match=said) as error:
        maviper.extract(lambda agent, rows: np.full(len(rows), answer), world=counted, **SMALL)
    assert error.value.next_step.startswith("its actions are 3 to 5: ")


def test_a_policy_gives_numbers_as_rows():
    team = maviper.extract(four, world=shaped, **SMALL)
    given = team["b_1"].act(np.zeros((5, 2)))
    assert given.shape == (5, 4) and given.dtype == np.float64


def test_a_team_is_a_mapping(profile):
    team = maviper.Team.of(profile)
    assert list(team) == [policy.agent for policy in team.agents] and len(team) == len(team.agents)
    assert dict(team)["agent_0"] is team["agent_0"] is team.policy("agent_0") and "agent_0" in team
    assert team.get("nobody") is None and "nobody" not in team and team == team and team != maviper.Team.of(profile)
    with pytest.raises(UnknownNameError, match="did you mean 'agent_"):
        team["agent_O"]


def test_what_is_shown_is_short_and_drawn(profile):
    team = maviper.Team.of(profile)
    assert repr(team).startswith("Team('physical-deception': adversary_0 ") and len(repr(team)) < 200
    assert "<svg" in team._repr_html_() and team.to_svg().startswith("<svg")
    assert team.to_text().count("->") == sum(map(_leaves, profile.agents))
    for each in (team.agents[0], team.agents[0].tree, profile, maviper.evaluate(team, episodes=2)):
        assert len(repr(each)) < 500


def _leaves(policy):
    return int((policy.tree.feature < 0).sum())


def test_latex_is_a_forest_for_each_agent(profile, tmp_path):
    text = maviper.Team.of(profile).to_latex()
    assert text.count(r"\begin{forest}") == len(profile.agents) == text.count(r"\end{forest}")
    assert text.count("leaf, ") + text.count("leaf]") == sum(map(_leaves, profile.agents))
    assert r"landmark\_0" in text and "landmark_0" not in text
    typeset(text, "forest", tmp_path)


def test_answers_are_rows(profile, tmp_path):
    team = maviper.Team.of(profile)
    measured = maviper.evaluate(team, episodes=20, against=["random", team])
    reached = measured["defenders", "success"]
    assert reached.interval[0] <= reached.value <= reached.interval[1] and reached.ratio is not None
    assert measured["defenders", "success r=0.1", "team"].value <= 1
    for names, what in ((("defender", "success"), "team"), (("defenders", "sucess"), "measure")):
        with pytest.raises(UnknownNameError, match=f"unknown {what}"):
            measured[names]
    text = measured.to_csv(tmp_path / "measured.csv")
    rows = list(csv.DictReader(io.StringIO(text)))
    assert (tmp_path / "measured.csv").read_text() == text and len(rows) == len(measured.rows)
    assert "<table>" in measured._repr_html_()


@pytest.mark.solver
def test_a_verdict_is_four_lines(profile):
    found = maviper.verify(maviper.Team.of(profile), maviper.claims.DistinctTargets("defenders"))
    assert found.verdict == "VIOLATED" and not found.proved and len(repr(found).splitlines()) == 4
    assert (
        repr(found).startswith("VIOLATED: distinct_targets of the defenders\nregion start") and len(repr(found)) < 500
    )
    assert found.rows[0]["claim"] == "distinct_targets" and len(repr(found.evidence)) < 500


def test_a_string_is_one_target_and_code_is_written(profile, tmp_path):
    compiled = maviper.compile(profile, "python")
    folder = compiled.write(tmp_path / "code")
    assert {each.name for each in folder.iterdir()} == set(compiled.files)
    assert any(name.endswith(".py") for name in compiled.files) and len(repr(compiled)) < 500


def test_every_verb_takes_a_path(profile, tmp_path):
    path = maviper.Team.of(profile).save(tmp_path / "team.json")
    assert maviper.compile(path, "json").files.keys() == maviper.compile(str(path), ["json"]).files.keys()
    assert maviper.diff(path, profile, agents=["agent_0"]).verdict == "PROVED"
    assert maviper.evaluate(path, episodes=3).rows == maviper.evaluate(maviper.load(path), episodes=3).rows


def test_one_number_is_changed_on_purpose(profile, tmp_path):
    team = maviper.Team.of(profile)
    node = int(np.flatnonzero(team["agent_0"].tree.feature >= 0)[1])
    edited = maviper.load(team.with_threshold("agent_0", node, 0.3).save(tmp_path / "edited.json"))
    threshold = edited["agent_0"].tree.threshold[node]
    above = float(np.nextafter(threshold, np.float32(1)))
    assert float(threshold) <= 0.3 < above and threshold.dtype == np.float32
    told = edited.provenance.training
    assert told[f"agent_0/{node} by hand"].endswith(f" to {threshold}") and not edited.provenance.evaluation
    assert edited["agent_1"].grown is not None and not edited["agent_0"].tree.visits.size
    assert maviper.compile(edited, ["c", "python"]).complete
    twice = edited.with_threshold("agent_0", node, 0.5).provenance.training
    assert twice["profile before edit"] == told["profile before edit"]
    leaf = int(np.flatnonzero(team["agent_0"].tree.feature < 0)[0])
    for where, value, words in ((leaf, 0.3, "is a leaf"), (99, 0.3, "has no node 99"), (node, np.inf, "no finite")):
        with pytest.raises(InputError, match=words):
            team.with_threshold("agent_0", where, value)


def test_the_command_changes_the_same_number(profile, tmp_path):
    team = maviper.Team.of(profile)
    node = int(np.flatnonzero(team["agent_0"].tree.feature >= 0)[1])
    path, wanted = team.save(tmp_path / "team.json"), team.with_threshold("agent_0", node, 0.3)
    assert main.run(["-q", "edit", str(path), f"agent_0/{node}=0.3"]) == 0
    assert path.read_text() == wanted.save(tmp_path / "wanted.json").read_text()
    for change in ("agent_0=0.3", "agent_9/0=0.3", f"agent_0/{node}=x", f"agent_0/{node}=nan"):
        assert main.run(["-q", "edit", str(path), change]) == ExitCode.INPUT
    assert path.read_text() == (tmp_path / "wanted.json").read_text()


def test_errors_of_python_speak_python(profile):
    for ask, words in (
        (lambda: maviper.verify(profile, max_cells=7), "max_cells has no effect without where=True"),
        (
            lambda: maviper.extract("physical-deception", max_episodes=9, iterations=1),
            "max_episodes already determines",
        ),
        (lambda: maviper.verify(profile, maviper.claims.Reaches), "Reaches is a class of claims"),
        (lambda: maviper.extract(doorway.act), "does not say which world it plays"),
        (lambda: maviper.extract(None, world=doorway.make), "NoneType is not an expert"),
        (lambda: maviper.compile(5, "c"), "int is no team"),
        (lambda: maviper.compile(profile, "C"), "unknown target 'C'"),
        (lambda: maviper.Team.of(profile).with_threshold("agent_0", 0, "0.3"), "'0.3' is no finite float32"),
        (lambda: maviper.Team.of(profile).with_threshold("agent_0", 0, 1e300), "1e\\+300 is no finite float32"),
        (lambda: maviper.Team.of(profile).with_threshold("agent_0", "0", 0.3), "has no node '0'"),
    ):
        with pytest.raises(InputError, match=words) as error:
            ask()
        assert "--" not in str(error.value)
    with pytest.raises(UnknownNameError, match="did you mean 'c'"):
        maviper.compile(profile, "C")


def test_who_asks_is_told_of_progress(profile, capsys):
    """Stages and their numbers are those of the commands; otherwise nothing is said."""
    told = []

    def note(stage, done, total, words):
        assert 0 <= done <= total and isinstance(words, str)
        told.append(stage)

    def stages():
        found, told[:] = dict.fromkeys(told), []
        return list(found)

    team = maviper.extract(doorway.act, world=doorway.make, **SMALL, progress=note)
    assert stages()[0] == "extracting"
    maviper.evaluate(team, world=doorway.make, episodes=3, progress=note)
    assert stages() == ["playing"]
    maviper.verify(profile, progress=note)
    assert stages() == ["deciding"]
    maviper.repair(profile, progress=note)
    maviper.diff(profile, profile, progress=note)
    maviper.exploit(profile, "defenders", episodes=20, refinement_episodes=0, progress=note)
    assert stages() == ["repairing", "comparing", "answering"]
    few = {"algorithms": ["imitation"], "depths": [2], "seeds": 1, "max_episodes": 20}
    maviper.compare(doorway.act, world=doorway.make, **few, progress=note)
    assert stages() == ["cells"]
    maviper.evaluate(team, world=doorway.make, episodes=3)
    assert capsys.readouterr() == ("", "")
    maviper.evaluate(team, world=doorway.make, episodes=3, progress=True)
    assert "playing     3/3  episodes" in capsys.readouterr().err


def test_torch_answers_few_rows_with_one_thread(monkeypatch):
    asked, threads = [], [8]
    torch = SimpleNamespace(get_num_threads=lambda: threads[0], set_num_threads=lambda n: threads.__setitem__(0, n))
    monkeypatch.setitem(sys.modules, "torch", torch)

    def watched(agent, rows):
        asked.append(threads[0])
        return doorway.act(agent, rows)

    maviper.evaluate(watched, world=doorway.make, episodes=2)
    assert set(asked) == {1} and threads == [8]


def test_an_experts_function_that_answers_in_another_shape_is_told():
    with pytest.raises(InputError, match=r"returns shape \(\d+, 3\) for \d+ observations of left"):
        maviper.extract(lambda agent, rows: np.zeros((len(rows), 3)), world=doorway.make, **SMALL)


def test_the_package_says_what_it_has():
    assert maviper.__version__ == "0.3.0"
    assert {"Team", "answers", "claims", "errors", "profiles", "load"} <= set(dir(maviper))
    assert not {"TYPE_CHECKING", "flags", "siblings", "annotations", "importing"} & set(dir(maviper))
