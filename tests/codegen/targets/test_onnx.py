"""ONNX: models that decide as the reference under two runtimes, and come back as the same tree."""

import sys
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings

from codegen import ir
from codegen.agreement import probes, readback, selfcheck
from codegen.errors import InputError, MissingToolError
from codegen.importers.onnx import model as importer
from codegen.targets import emit
from tests.support import summed
from tests.support.chains import chain
from tests.support.strategies import profiles
from tests.support.teams import tree

FEW = 1_000

onnx = pytest.importorskip("onnx", reason="onnx is not installed")
pytest.importorskip("onnxruntime", reason="onnxruntime is not installed")


def with_tree(profile, one, n_actions=5):
    """The profile with the same tree for each agent, and that many actions."""
    agents = (replace(policy, tree=one, actions=policy.actions[:n_actions], grown=None) for policy in profile.agents)
    return replace(profile, agents=tuple(agents))


BOTH = ("onnx", "onnx-old")  # TreeEnsemble, and the deprecated operators


def agrees(profile):
    report = selfcheck.check_files(profile, emit(profile, BOTH), random=FEW).ensure()
    assert not report.skipped
    assert {item.target for item in report.agreements} == {*BOTH, *(f"{target} one by one" for target in BOTH)}
    assert {item.agent for item in report.agreements} == {policy.agent for policy in profile.agents}


@settings(max_examples=5)
@given(profiles())
def test_random_profiles_agree(profile):
    agrees(profile)


@pytest.mark.parametrize("n_actions", [1, 2, 3, 5])
def test_few_classes_and_leaves_that_name_one_only(n_actions, profile):
    """Where runtimes take an ensemble for a binary one and answer another class."""
    for low, high in {(0, 0), (0, n_actions - 1), (n_actions - 1, 0), (n_actions - 1, n_actions - 1)}:
        agrees(with_tree(profile, tree((3, 0.1, 1, 2), low, high), n_actions))
        agrees(with_tree(profile, tree(high), n_actions))


@pytest.mark.parametrize("threshold", [0.0, -0.0, 1e-45, -1e-45, 1e-38, 3.4028234663852886e38, -3.4028234663852886e38])
def test_thresholds_at_the_ends_of_the_format(threshold, profile):
    agrees(with_tree(profile, tree((0, threshold, 1, 2), 1, 2)))


def test_a_chain_of_a_thousand_splits(profile):
    agrees(with_tree(profile, chain(1_000)))


@settings(max_examples=5)
@given(profiles())
def test_another_runtime_and_the_importer_decide_alike(profile):
    from onnx.reference import ReferenceEvaluator

    files = emit(profile, BOTH)
    for policy in profile.agents:
        old, new = (files[f"physical_deception_{policy.agent}{ending}.onnx"] for ending in (".old", ""))
        rng = np.random.default_rng(0)
        rows = probes.boundary(policy.tree, policy.features, rng)
        rows = np.concatenate([rows, probes.special(policy.features, rng)])
        for model in (old, new):
            back = importer.from_onnx(model).agents[0]
            taken = [int(each.name.removeprefix("action_")) for each in back.actions]
            assert len(back.features) == len(policy.features) and len(back.actions) <= len(policy.actions)
            assert (np.array(taken)[ir.act(back, rows)] == ir.act(policy, rows)).all()
        few = rows[:: max(1, len(rows) // 300)]
        for model in (old, new):
            (said,) = ReferenceEvaluator(onnx.load_model_from_string(model)).run(["action"], {"x": few})
            assert said.dtype == np.int64 and (said == ir.act(policy, few)).all()


@pytest.mark.parametrize(("ending", "version", "form"), [("", 5, 10), (".old", 1, 7)])
def test_the_model_says_what_it_is(ending, version, form, profile):
    files = emit(profile, BOTH)
    assert files == emit(profile, BOTH)
    made = onnx.load_model_from_string(files[f"physical_deception_agent_0{ending}.onnx"])
    assert [(each.domain, each.version) for each in made.opset_import] == [("", 13), ("ai.onnx.ml", version)]
    assert made.ir_version == form and not made.doc_string and not made.graph.doc_string
    facts = {each.key: each.value for each in made.metadata_props}
    assert facts["features"].split(",") == [feature.name for feature in profile.policy("agent_0").features]
    assert facts["actions"].split(",") == [action.name for action in profile.policy("agent_0").actions]
    assert made.graph.input[0].type.tensor_type.shape.dim[1].dim_value == 10


@pytest.mark.parametrize("wrong", [np.zeros((2, 9), np.float32), np.zeros((2, 11), np.float32), np.zeros((2, 10))])
def test_a_runtime_refuses_another_width_or_type(wrong, profile):
    with pytest.raises(Exception, match=r"(?i)invalid dimensions|unexpected input data type"):
        readback.onnx_act(emit(profile, ["onnx"])["physical_deception_agent_0.onnx"], "agent_0", wrong)


def planted(change):
    """A change of the attributes of the ensemble's node, by name, as a change of the file."""

    def changed(content):
        made = onnx.load_model_from_string(content)
        change({each.name: each for each in made.graph.node[0].attribute})
        return made.SerializeToString()

    return changed


def next_threshold(at):
    at["nodes_values"].floats[0] = float(np.nextafter(np.float32(at["nodes_values"].floats[0]), np.float32(9)))


def swapped_children(at):
    true, false = at["nodes_truenodeids"].ints, at["nodes_falsenodeids"].ints
    true[0], false[0] = false[0], true[0]


def tensor(at, name, value):
    """Another first number of a tensor."""
    values = onnx.numpy_helper.to_array(at[name].t).copy()
    values[0] = value
    at[name].t.CopyFrom(onnx.numpy_helper.from_array(values))


IN_BOTH = {
    "a NaN goes left": lambda at: at["nodes_missing_value_tracks_true"].ints.__setitem__(0, 1),
    "swapped children": swapped_children,
    "another feature": lambda at: at["nodes_featureids"].ints.__setitem__(0, at["nodes_featureids"].ints[0] ^ 1),
}
FAULTS = {
    "onnx-old": IN_BOTH | {
        "< for <=": lambda at: at["nodes_modes"].strings.__setitem__(0, b"BRANCH_LT"),
        "the next float": next_threshold,
        "another label": lambda at: at["classlabels_int64s"].ints.__setitem__(1, 7),
    },
    "onnx": IN_BOTH | {
        "< for <=": lambda at: tensor(at, "nodes_modes", 1),
        "the next float": lambda at: tensor(at, "nodes_splits", np.nextafter(np.float32(0.1), np.float32(9))),
        "another leaf": lambda at: tensor(at, "leaf_weights", 4),
    },
}  # fmt: skip


@pytest.mark.parametrize(("target", "name"), [(target, name) for target in FAULTS for name in FAULTS[target]])
def test_planted_faults_are_caught(target, name, profile):
    profile = with_tree(profile, tree((0, 0.1, 1, 2), 1, 2))
    files = {file: planted(FAULTS[target][name])(content) for file, content in emit(profile, [target]).items()}
    found = selfcheck.check_files(profile, files, random=FEW).agreements
    assert len(found) == 6 and all(item.differences for item in found if item.target == target)


def test_sums_have_the_bits_of_the_reference():
    agrees(summed.together(1, levels=2))


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(2, 12))
def test_other_sums(seed):
    agrees(summed.together(seed))


def test_a_bound_that_onnxruntime_would_lose_is_refused():
    profile = summed.every(1)["outputs, double sums"]
    (policy,) = profile.agents
    outputs = (replace(policy.outputs[0], low=-0.0), *policy.outputs[1:])
    with pytest.raises(InputError, match=r"a bound of agent_0 is -0\.0, for which onnxruntime's Where gives 0\.0"):
        emit(summed.profile(replace(policy, outputs=outputs)), ["onnx"])


@pytest.mark.parametrize("place", [0, -1], ids=["weights", "bounds"])
def test_faults_in_sums_are_caught(place):
    profile = summed.every(1, levels=2)["outputs, float32 steps"]
    ((name, content),) = emit(profile, ["onnx"]).items()
    made = onnx.load_model_from_string(content)
    numbers = [each for each in made.graph.initializer if each.data_type == onnx.TensorProto.FLOAT and each.dims]
    one = numbers[place]
    one.CopyFrom(onnx.numpy_helper.from_array(onnx.numpy_helper.to_array(one) - 1, one.name))
    found = selfcheck.check_files(profile, {name: made.SerializeToString()}, random=FEW).agreements
    assert any(item.differences for item in found)


def test_missing_packages_are_said(profile, monkeypatch):
    files = emit(profile, ["onnx"])
    monkeypatch.setitem(sys.modules, "onnxruntime", None)
    report = selfcheck.check_files(profile, files, random=FEW)
    assert report.skipped == ("onnx: onnxruntime is not installed",) and not report.agreements
    monkeypatch.setitem(sys.modules, "onnx", None)
    with pytest.raises(MissingToolError, match="needs the package onnx"):
        emit(profile, ["onnx"])
    with pytest.raises(MissingToolError, match="onnxruntime"):
        readback.onnx_act(b"", "agent_0", np.zeros((1, 10), dtype=np.float32))


REFUSED = {
    "no whole number": lambda at: tensor(at, "leaf_weights", 0.5),
    "sends missing values to the left": IN_BOTH["a NaN goes left"],
    "compares otherwise than by <= and <": lambda at: tensor(at, "nodes_modes", 2),
    "has no finite threshold": lambda at: tensor(at, "nodes_splits", np.inf),
    "several trees or targets": lambda at: at["tree_roots"].ints.append(0),
    "do not form a tree": lambda at: at["nodes_truenodeids"].ints.__setitem__(0, 1),
}


@pytest.mark.parametrize("said", REFUSED)
def test_other_tree_ensembles_are_refused(said, profile):
    (content,) = emit(summed.profile(with_tree(profile, tree((0, 0.1, 1, 2), 1, 2)).agents[0]), ["onnx"]).values()
    with pytest.raises(InputError, match=said):
        importer.from_onnx(planted(REFUSED[said])(content))
