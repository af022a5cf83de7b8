"""Whatever a process has NumPy do at an underflow or a NaN (emlearn has it raise), every verb answers as ever; and
threads of linear algebra are as many as before.
"""

from pathlib import Path

import numpy as np
import pytest
from sklearn.pipeline import make_pipeline
from sklearn.preprocessing import StandardScaler
from sklearn.tree import DecisionTreeClassifier
from threadpoolctl import threadpool_info, threadpool_limits

import maviper
from codegen.policy_json import dumps
from codegen.process import defaults, one_thread
from maviper.worlds.outside.making import import_maker
from maviper.worlds.outside.sources import parse_source
from tests.support.small import small_profile

PYTHON = "def act(x):\n    if x[0] <= 1e-46 or x[1] < 1e300: return 1\n    return 0 if x[2] < 0 else 2\n"
C = "int act(const float *x) { if (x[0] <= 1e-45f || x[1] < 1e-320) { return 1; } return x[2] < 0 ? 0 : 2; }"
DEFAULT = {"divide": "warn", "over": "warn", "under": "ignore", "invalid": "warn"}


@pytest.fixture
def raising():
    """What emlearn sets when it is imported."""
    with np.errstate(all="raise"):
        yield


@pytest.fixture(scope="module")
def fitted():
    x = np.random.default_rng(0).normal(size=(200, 3))
    return make_pipeline(StandardScaler(), DecisionTreeClassifier(max_depth=4)).fit(x, x[:, 0] > x[:, 1])


@pytest.mark.parametrize("name", sorted({*maviper.__all__} - {"version"}))
def test_every_verb_states_its_flags(name):
    code = defaults(len).__code__
    assert getattr(maviper, name).__code__ is code


def test_flags_are_those_of_the_process_again_also_after_an_error(raising):
    def failing():
        assert np.geterr() == DEFAULT
        raise ValueError

    with pytest.raises(ValueError):
        defaults(failing)()
    assert set(np.geterr().values()) == {"raise"}


def count_threads():
    return {pool["num_threads"] for pool in threadpool_info() if pool["user_api"] == "blas"}


def test_linear_algebra_has_one_thread_in_a_call():
    @one_thread
    def failing():
        assert count_threads() == {1}
        raise ValueError

    with threadpool_limits(2, "blas"):
        with pytest.raises(ValueError):
            failing()
        assert count_threads() == {2}


def test_trees_of_others_come_in(raising, fitted, tmp_path):
    assert maviper.from_sklearn(fitted).agents and maviper.from_sklearn(fitted[1]).agents
    for name, text in (("policy.py", PYTHON), ("policy.c", C)):
        (tmp_path / name).write_text(text)
        for numbers in (None, "float32"):
            assert maviper.from_file(tmp_path / name, numbers=numbers).agents


def test_a_model_of_onnx_comes_in(raising, fitted):
    skl2onnx = pytest.importorskip("skl2onnx", reason="the extra maviper[interop] is not installed")
    model = skl2onnx.to_onnx(fitted, np.zeros((1, 3), dtype=np.float32), options={"zipmap": False})
    assert maviper.from_onnx(model.SerializeToString()).agents


def test_a_profile_is_compiled_measured_and_asked(raising, fitted, tmp_path):
    own = maviper.from_sklearn(fitted)
    for profile in (own, small_profile()):
        assert maviper.compile(profile, ["python", "json"]).files
    (tmp_path / "own.json").write_text(dumps(own))
    claim = tmp_path / "claim.toml"
    claim.write_text('[[property]]\nname = "monotone"\nagent = "agent_0"\nfeature = "x0"\n')
    assert maviper.verify_file(own, claim)


def test_trees_are_extracted_and_play(raising, tmp_path):
    path = tmp_path / "profile.json"
    profile = maviper.extract("physical-deception", path, max_episodes=60, critic="none")
    assert profile.agents and maviper.evaluate(path, episodes=20)


def test_what_an_environments_own_file_sets_ends_with_its_import(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("raising_file.py").write_text("import numpy as np\nnp.seterr(all='raise')\ndef make():\n    pass\n")
    before = np.geterr()
    import_maker(parse_source("raising_file:make"))
    assert np.geterr() == before
