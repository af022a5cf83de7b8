"""Experts of a user's own: what they do wrongly is told as theirs, in three lines, with the place."""

import sys
from pathlib import Path

import numpy as np
import pytest

import maviper
from codegen.errors import ExitCode, InputError, UnknownNameError
from maviper.cli import main
from maviper.experts.finding import find_expert
from tests.benchmarks import doorway

EXPERT = """
import numpy as np
from maviper.worlds import find

class Mine:
    {members}
    def __init__(self):
        self.world = find("physical-deception")
        self.agents = self.world.agents

    def act(self, agents, observations, state):
        batch = len(observations[0])
        {act}

    def q(self, agent, observations, state, joint, given):
        {q}

def make():
    {make}
"""
GOOD = {
    "members": 'hash, card, centralized = "", {}, True',
    "act": "return np.stack([(observations[agent][:, 0] > 0) + 1 for agent in agents], axis=1)",
    "q": "return np.zeros((len(given), len(joint)))",
    "make": "return Mine()",
}
UNMEASURED = ("--critic", "none")


@pytest.fixture
def extract(tmp_path, monkeypatch, capsys):
    """Extracts from an expert that differs from a good one as told; (exit code, standard error)."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", [*sys.path])

    def run(*options, into="p.json", **parts):
        sys.modules.pop("somebody", None)
        (tmp_path / "somebody.py").write_text(EXPERT.format(**{**GOOD, **parts}))
        small = ("--iterations", "1", "--rollouts", "3", "--set", "selection_episodes=3", "--refinement-episodes", "0")
        code = main.run(["-q", "extract", "somebody:make", *small, *options, "-o", into])
        assert Path(into if into.endswith(".json") else f"{into}/profile.json").exists() == (code == ExitCode.DONE)
        said = capsys.readouterr()
        run.out = [line for line in said.out.splitlines() if line]
        return code, said.err

    yield run
    sys.modules.pop("somebody", None)


ACTS = {
    "floats": (
        "return np.zeros((batch, len(agents)))",
        "returns floats, not numbers of actions",
        "logits.argmax(axis=1)",
    ),
    "truth values": ("return np.zeros((batch, len(agents)), bool)", "returns truth values", "whole numbers"),
    "texts": ("return np.full((batch, len(agents)), 'left')", "returns texts", "whole numbers"),
    "None": ("return None", "returns objects", "whole numbers"),
    "one row": ("return np.zeros(len(agents), int)", "returns shape (3,)", "[batch, len(agents)]"),
    "one column": ("return np.zeros((batch, 1), int)", "returns shape", "np.stack"),
    "turned": ("return np.zeros((len(agents), batch), int)", "returns shape (3, ", "np.stack"),
    "too many": (
        "return np.full((batch, len(agents)), 7)",
        "returns action 7 for adversary_0, which has 5",
        "0 to 4: stay",
    ),
    "negative": ("return np.full((batch, len(agents)), -1)", "returns action -1", "0 to 4"),
    "ragged": ("return [[0], [0, 1]]", "", "fix it there"),
    "raises": ("raise KeyError('speed')", "act of your expert raised KeyError: 'speed'", "fix it there"),
    "exits": ("import sys; sys.exit('enough')", "act of your expert raised SystemExit: enough", "fix it there"),
    "unfinished": ("raise NotImplementedError", "act of your expert raised NotImplementedError", "fix it there"),
}


@pytest.mark.parametrize("case", ACTS)
def test_what_act_does_wrongly(extract, case):
    act, says, advice = ACTS[case]
    code, told = extract(*UNMEASURED, act=act)
    assert code == ExitCode.INPUT, told
    assert says in told and advice in told and "somebody:make" in told
    assert "bug in maviper" not in told and "Traceback" not in told and "environment" not in told
    if "raise" in act or "exit" in act:
        assert "somebody.py:13, in act" in told


QS = {
    "no critic": ("raise NotImplementedError('none')", "your expert has no critic", "--critic none"),
    "raises": ("return 1 / 0", "q of your expert raised ZeroDivisionError", "fix it there"),
    "one row": ("return np.zeros(len(joint))", "q of your expert returns shape", "--critic none"),
    "NaN": ("return np.full((len(given), len(joint)), np.nan)", "floats that are not finite", "--critic none"),
    "None": ("return None", "q of your expert returns shape ()", "--critic none"),
}


@pytest.mark.parametrize("case", QS)
def test_what_q_does_wrongly(extract, case):
    q, says, advice = QS[case]
    code, told = extract(q=q)
    assert code == ExitCode.INPUT and says in told and advice in told and "Traceback" not in told, told
    assert extract(*UNMEASURED, q=q)[0] == ExitCode.DONE


def test_a_run_that_q_ends_before_it_has_a_tree_leaves_its_folder_free(extract):
    """What is advised, --critic none, is another run. One that has a tree stays."""
    without = {"q": "raise NotImplementedError('none')"}
    assert extract(into="run", **without)[0] == ExitCode.INPUT and not Path("run").exists()
    Path("run").mkdir()
    Path("run/mine.txt").write_text("kept")
    assert extract(into="run", **without)[0] == ExitCode.INPUT
    assert extract(*UNMEASURED, into="run", **without)[0] == ExitCode.DONE and Path("run/mine.txt").exists()
    several = ("--seeds", "2")
    assert extract(*several, into="two", **without)[0] == ExitCode.INPUT
    assert extract(*UNMEASURED, *several, into="two", **without)[0] == ExitCode.DONE
    late = "self.told = getattr(self, 'told', 0) + 1; return np.zeros((len(given), len(joint) if self.told < 9 else 1))"
    code, told = extract("--iterations", "3", into="late", q=late)
    assert code == ExitCode.INPUT and "returns shape" in told and Path("late/config.json").exists(), told


MADE = {
    "raises": ({"make": "raise OSError(2, 'no weights')"}, "make raised FileNotFoundError"),
    "nothing": ({"make": "return None"}, "it lacks world, agents, act"),
    "a world's name": (
        {"make": "mine = Mine(); mine.world = 'physical-deception'; return mine"},
        "is a str, not a world",
    ),
    "no agents": ({"make": "mine = Mine(); mine.agents = None; return mine"}, "are not those of its world"),
    "other agents": ({"make": "mine = Mine(); mine.agents = ('a', 'b'); return mine"}, "are not those of its world"),
}


@pytest.mark.parametrize("case", MADE)
def test_what_is_no_expert(extract, case):
    parts, says = MADE[case]
    code, told = extract(*UNMEASURED, **parts)
    assert code == ExitCode.INPUT and says in told and "Traceback" not in told, told


def test_a_good_expert_needs_no_description_and_may_print(extract):
    code, told = extract(members="pass", act="print('thinking'); " + GOOD["act"])
    assert code == ExitCode.DONE and "thinking" in told
    assert extract.out == []


def test_an_action_of_who_has_ended_means_nothing(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "ended.py").write_text(EXPERT.format(**{**GOOD, "act": "return np.full((batch, len(agents)), 9)"}))
    monkeypatch.syspath_prepend(tmp_path)
    expert, world = find_expert("ended:make")
    start = world.start_from_seeds([0, 1])
    seen = world.observe(start)
    with pytest.raises(InputError, match="returns action 9"):
        expert.act(range(3), seen, start)
    monkeypatch.setattr(type(world), "alive", lambda self, state: np.zeros((len(state), 3), bool))
    assert (expert.act(range(3), seen, start) == 0).all()
    sys.modules.pop("ended", None)


def test_a_function_of_other_arguments_is_no_expert(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", [*sys.path])
    Path("turned.py").write_text("def one(observations):\n    return observations[:, 0]\n")
    for given in ("turned:one", lambda observations: observations[:, 0]):
        with pytest.raises(InputError, match=r"an expert takes agent and observations; \w+ takes \(observations\)"):
            find_expert(given, world=doorway.make)


@pytest.mark.parametrize("name", ["tug", "tug.policy"])
def test_who_names_no_expert_is_told_how_a_function_is_named(name):
    with pytest.raises(UnknownNameError, match="a function of your own is named module:function") as caught:
        find_expert(name)
    assert "maviper worlds list" in caught.value.next_step


def test_an_environment_in_place_of_what_makes_it_is_told():
    with pytest.raises(InputError, match="world is a name or a function, not") as caught:
        maviper.extract(doorway.act, world=doorway.make())
    assert caught.value.next_step == "give the function that makes it: world=make, not world=make()"
