"""Files of other programs: their kind is recognised, teams are put together, everything else is refused."""

import pickle

import pytest
from sklearn.tree import DecisionTreeClassifier

import maviper
from codegen.errors import InputError
from codegen.policy_json import dumps
from tests.support.small import small_profile

ONE = "def act(x):\n    return 1 if x[0] > 0.5 else 0\n"
TWO = "def near(x):\n    return 1 if x[0] > 0.5 else 0\n\ndef far(x):\n    return 0 if x[1] > 0.5 else 1\n"


@pytest.fixture
def files(tmp_path):
    (tmp_path / "one.py").write_text(ONE)
    (tmp_path / "two.py").write_text(TWO)
    return tmp_path


def test_a_file_of_one_function_is_one_agent(files):
    profile = maviper.from_file(files / "one.py", feature_names=["speed"], action_names=["stay", "go"], name="mine")
    assert [policy.agent for policy in profile.agents] == ["act"] and profile.world.name == "mine"
    assert profile.agents[0].features[0].name == "speed" and profile.agents[0].actions[1].name == "go"


def test_files_make_a_team(files):
    assert [policy.agent for policy in maviper.from_file(files / "two.py").agents] == ["near", "far"]
    profile = maviper.from_file({"far": files / "two.py", "other": str(files / "one.py")})
    assert [(policy.agent, len(policy.features)) for policy in profile.agents] == [("far", 2), ("other", 1)]
    assert {entity.name for entity in profile.world.agents} == {"far", "other"}
    with pytest.raises(InputError, match="2 trees, none of them named 'b'"):
        maviper.from_file({"b": files / "two.py"})
    with pytest.raises(InputError, match="nothing or too much"):
        maviper.from_file({})


def test_a_pickle_is_not_opened(files):
    mark = files / "mark"

    class Hostile:
        def __reduce__(self):
            return (mark.touch, ())

    for name in ("tree.pkl", "tree.joblib", "tree.py", "tree"):
        (files / name).write_bytes(pickle.dumps(Hostile()))
        with pytest.raises(InputError, match="a pickle"):
            maviper.from_file(files / name)
    (files / "tree.pkl").write_bytes(pickle.dumps(DecisionTreeClassifier(), protocol=0))
    with pytest.raises(InputError, match="a pickle"):
        maviper.from_file(files / "tree.pkl")
    assert not mark.exists()


def test_other_files_are_told_apart(files):
    (files / "profile.json").write_text(dumps(small_profile()))
    with pytest.raises(InputError, match="a policy profile, not a tree of another program"):
        maviper.from_file(files / "profile.json")
    (files / "notes.txt").write_text("a <= b")
    with pytest.raises(InputError, match="not a file that trees can be read from") as caught:
        maviper.from_file(files / "notes.txt")
    assert "if/else Python (.py)" in caught.value.next_step
    with pytest.raises(InputError, match="cannot read"):
        maviper.from_file(files / "none.py")
    with pytest.raises(InputError, match="not an ONNX model"):
        (files / "model.onnx").write_bytes(b"\x08no")
        maviper.from_file(files / "model.onnx")


def test_a_binary_file_of_xgboost_is_told_from_others(files):
    for name, content in (("model.ubj", b"{L" + bytes(7) + b"\x07learner{L"), ("model.bin", b"binf\x00\x00")):
        (files / name).write_bytes(content)
        with pytest.raises(InputError, match="XGBoost in binary form") as caught:
            maviper.from_file(files / name)
        assert 'save_model("model.json")' in str(caught.value)


@pytest.mark.parametrize(
    ("name", "text", "what", "call"),
    [
        ("dump.txt", "booster[0]:\n0:[f0<0.5] yes=1,no=2,missing=1\n", "a dump of XGBoost", "save_model"),
        ("dump.json", '[\n  { "nodeid": 0, "depth": 0, "split": "f0"}]', "a dump of XGBoost", "save_model"),
        ("tree.txt", "|--- feature_0 <= 0.50\n|   |--- class: 0\n", "export_text", "from_sklearn"),
        ("tree.dot", "digraph Tree {\nnode [shape=box] ;\n", "a drawing in dot", "from_sklearn"),
        ("tree.pmml", '<?xml version="1.0"?>\n<PMML version="4.4">', "PMML", "from_sklearn"),
    ],
)
def test_forms_that_round_or_leave_out_are_refused_with_the_call_to_use(files, name, text, what, call):
    (files / name).write_text(text)
    with pytest.raises(InputError, match=what) as caught:
        maviper.from_file(files / name)
    assert call in caught.value.next_step
