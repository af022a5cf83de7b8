"""Every public verb in four threads at once gives what it gives alone."""

import dataclasses
import functools
import re
import sys
import threading
import warnings
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

import maviper
from codegen import policy_json
from codegen.ir import PolicyProfile
from tests.support.tiers import first_of

ROOT = Path(__file__).parents[2] / "generated"
PROVED, VERDICTS, WORLDS = ROOT / "proved_defenders", ROOT / "verdicts" / "physical_deception", ROOT / "worlds"
THREADS = 4
SOURCE = "def guard(obs):\n    if obs[0] <= 0.25:\n        return 'left'\n    return 'right'\n"
CLAIM = '[[property]]\nname = "distinct_targets"\n'
SMALL = {"max_depth": 2, "iterations": 1, "rollouts": 4, "selection_episodes": 4, "refinement_episodes": 0}
pytestmark = pytest.mark.usefixtures("few_observations", "few_episodes", "few_states_throughout")
# each writes a run folder of its own; claims of folders: test_writing.py
NEVER_TOGETHER = {"compare", "reproduce", "train"}


@pytest.fixture(scope="module")
def verbs(tmp_path_factory):
    """Each verb with small work: name -> call."""
    place = tmp_path_factory.mktemp("threads")
    (place / "guard.py").write_text(SOURCE)
    (place / "claims.toml").write_text(CLAIM)
    (place / "rows.csv").write_text("x0\n0.1\n0.9\n")
    proved = maviper.load(PROVED / "profile.json")
    deception = maviper.load(ROOT / "physical_deception" / "profile.json")
    corridor, guard = maviper.load(WORLDS / "corridor.json"), maviper.from_file(place / "guard.py")
    counterexample = sorted(VERDICTS.glob("counterexample-*-covers.json"))[0]
    return {
        "check": lambda: maviper.check(PROVED / "certificate-1-distinct_targets.json"),
        "compile": lambda: maviper.compile(guard, ["c", "python", "json"], prove=True).files,
        "diff": lambda: maviper.diff(deception, deception).facts,
        "evaluate": lambda: maviper.evaluate(PROVED / "profile.json", episodes=20),
        "exploit": lambda: maviper.exploit(
            str(PROVED / "profile.json"), "defenders", steps=500, refinement_episodes=10, episodes=10
        ),
        "extract": lambda: policy_json.dumps(maviper.extract("physical-deception", critic="none", **SMALL)),
        "from_file": lambda: policy_json.dumps(maviper.from_file(place / "guard.py")),
        "from_onnx": onnx_tree,
        "from_sklearn": fitted_tree,
        "load": lambda: policy_json.dumps(maviper.load(PROVED / "profile.json")),
        "repair": lambda: maviper.repair(proved, episodes=5).results,
        "replay": lambda: maviper.replay(counterexample),
        "robust": lambda: maviper.robust(guard, place / "rows.csv"),
        "verify": lambda: maviper.verify(deception, "distinct_targets"),
        "verify_file": lambda: maviper.verify_file(proved, place / "claims.toml"),
        "verify_system": lambda: maviper.verify_system(corridor, WORLDS / "corridor.toml").document,
    }


@functools.cache
def fitted():
    from sklearn.tree import DecisionTreeClassifier

    return DecisionTreeClassifier().fit([[-1.0], [1.0], [3.0]], ["a", "b", "a"])


def fitted_tree():
    return policy_json.dumps(maviper.from_sklearn(fitted()))


def onnx_tree():
    pytest.importorskip("onnx")
    files = maviper.compile(maviper.from_sklearn(fitted()), ["onnx"]).files
    return policy_json.dumps(maviper.from_onnx(next(data for name, data in files.items() if name.endswith(".onnx"))))


def test_each_public_verb_is_here(verbs):
    assert verbs.keys() | NEVER_TOGETHER == {*maviper.__all__} - {"version"}


def answer(call):
    """What a verb gives, as a text without the places of objects in memory."""
    return re.sub(r" at 0x[0-9a-f]+", "", str(_spell_out(call())))


def _spell_out(found):
    """All parts of an answer, which its repr shortens."""
    if isinstance(found, PolicyProfile):
        return policy_json.dumps(found)
    if dataclasses.is_dataclass(found):
        return {each.name: _spell_out(getattr(found, each.name)) for each in dataclasses.fields(found)}
    if isinstance(found, list | tuple):
        return [_spell_out(each) for each in found]
    return {key: _spell_out(each) for key, each in found.items()} if isinstance(found, dict) else repr(found)


@pytest.fixture(scope="module")
def alone(verbs):
    """What each verb gives alone: name -> call, answered once."""
    return {name: functools.cache(functools.partial(answer, verbs[name])) for name in verbs}


def state_of_the_process():
    import numpy as np

    return sys.stdout, sys.stderr, list(warnings.filters), Path.cwd(), np.geterr()


@pytest.mark.solver
@pytest.mark.compile
def test_verbs_in_four_threads(verbs, alone):
    """Every thread asks everything, each from another verb on; nothing of the process has changed afterwards."""
    names = sorted(verbs)
    expected = {name: alone[name]() for name in names}
    before, together = state_of_the_process(), threading.Barrier(THREADS)

    def ask_everything(number):
        together.wait()
        first = number * len(names) // THREADS
        return {name: answer(verbs[name]) for name in names[first:] + names[:first]}

    with ThreadPoolExecutor(THREADS) as pool:
        for found in pool.map(ask_everything, range(THREADS)):
            for name in names:
                assert found[name] == expected[name], name
    assert state_of_the_process() == before


@pytest.mark.solver
@pytest.mark.parametrize("name", first_of(2, ["verify", "compile", "repair", "robust", "from_sklearn", "diff"]))
def test_one_verb_in_four_threads(verbs, alone, name):
    """The same verb at the same time, where Z3, the compiler's library or filters of warnings stand behind it."""
    expected, together = alone[name](), threading.Barrier(THREADS)

    def ask(_):
        together.wait()
        return answer(verbs[name])

    with ThreadPoolExecutor(THREADS) as pool:
        assert list(pool.map(ask, range(THREADS))) == [expected] * THREADS
