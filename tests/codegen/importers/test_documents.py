"""dtControl's and treelite's JSON: no difference from the program that wrote the file."""

import json
import math

import numpy as np
import pytest
from sklearn.ensemble import RandomForestClassifier, RandomForestRegressor

from codegen import ir
from codegen.agreement import probes
from codegen.agreement.entries import same
from codegen.errors import InputError
from codegen.importers import replay
from codegen.importers.boosted import from_treelite
from codegen.importers.nodes import from_dtcontrol
from codegen.importers.origin import Names, profile_of
from codegen.importers.reading import Said
from tests.codegen.importers.origins import asked, data, decided

pytestmark = pytest.mark.interop
SEEDS = pytest.mark.parametrize("seed", range(20))


@SEEDS
def test_dtcontrols_own_files_decide_as_its_trees(seed):
    pytest.importorskip("dtcontrol", reason="dtcontrol is not installed")
    from dtcontrol.dataset.single_output_dataset import SingleOutputDataset
    from dtcontrol.decision_tree.decision_tree import DecisionTree
    from dtcontrol.decision_tree.impurity.entropy import Entropy
    from dtcontrol.decision_tree.splitting.axis_aligned import AxisAlignedSplittingStrategy

    rng = np.random.default_rng(seed)
    dataset = SingleOutputDataset("controller.csv")  # filled here: its reader of files needs an old pandas
    dataset.x = rng.normal(size=(25, 3)).round(2)
    dataset.y = rng.integers(1, 5, size=(25, 1))
    dataset.index_to_actual = {1: -0.5, 2: 0.0, 3: 0.5, 4: 1.25}
    dataset.x_metadata |= {"variables": ["x_0", "x_1", "x_2"], "categorical": []}
    dataset.y_metadata |= {"categorical": [], "category_names": {}}
    tree = DecisionTree([AxisAlignedSplittingStrategy()], Entropy(), "tree")
    tree.fit(dataset)
    text = tree.toJSON(dataset.x_metadata, dataset.y_metadata)
    origins = from_dtcontrol(text.encode(), "default.json")
    policy, rows = asked(origins)
    rows = np.random.default_rng(0).permutation(rows)[:500]
    said = tree.root.predict(np.pad(rows.astype(np.float64), ((0, 0), (0, 3 - rows.shape[1]))))
    assert [float(each) for each in decided(origins, policy, rows)] == [float(each) for each in said]


@SEEDS
def test_treelites_json_decides_as_treelite(seed):
    treelite = pytest.importorskip("treelite", reason="treelite is not installed")
    x, y = data(seed, classes=2 + seed % 2)
    y = y if seed % 2 else y > 0
    forest = RandomForestClassifier(1, bootstrap=False, max_depth=2 + seed % 6, random_state=seed).fit(x, y)
    model = treelite.sklearn.import_model(forest)
    origins = from_treelite(model.dump_as_json().encode(), "tree.json")
    policy, rows = asked(origins)
    said = treelite.gtil.predict(model, rows).reshape(len(rows), -1).argmax(axis=1)
    assert decided(origins, policy, rows) == said.tolist()


# --- by hand


def leaf(*labels):
    return {"actual_label": list(labels), "children": [], "split": None}


def split(var, number, left, right, **more):
    given = {"lhs": {"coeff": 1, "var": var}, "op": "<=", "rhs": number} | more
    return {
        "actual_label": None,
        "children": [left | {"edge_label": "true"}, right | {"edge_label": "false"}],
        "split": given,
    }


def dtcontrol(document):
    return from_dtcontrol(json.dumps(document).encode(), "default.json")


def test_names_and_labels_of_dtcontrol():
    origins = dtcontrol(split("speed", 0.1, leaf("go left"), split("gap", 2, leaf("-1.5"), leaf("go left"))))
    policy, rows = asked(origins)
    assert [feature.name for feature in policy.features] == ["speed", "gap"]
    assert [action.name for action in policy.actions] == ["go_left", "action_minus_1_5"] and len(rows)


@pytest.mark.parametrize(
    ("document", "said"),
    [
        (split(0, 1, leaf("a", "b"), leaf("c")), "a leaf permits 2 actions"),
        (split(0, 1, leaf("a"), leaf()), "a leaf permits 0 actions"),
        (split(0, 1, leaf("a"), leaf("b"), lhs={"coeff": 2, "var": 0}), "neither of one feature nor linear"),
        (split(0, "", leaf("a"), leaf("b"), op="multi"), "neither of one feature nor linear"),
        (split(0, "no", leaf("a"), leaf("b")), "a node is not understood"),
        (split(0, float("nan"), leaf("a"), leaf("b")), "a test is not understood"),
        (split(-1, 1, leaf("a"), leaf("b")), "a test is not understood"),
        (split(0, 1, leaf("a"), split("x", 1, leaf("a"), leaf("b"))), "features have names and numbers"),
        ({"actual_label": None, "children": [], "split": {}}, "a node is not understood"),
    ],
)
def test_other_trees_of_dtcontrol_are_refused(document, said):
    with pytest.raises(InputError, match=said):
        dtcontrol(document)


def test_what_is_no_tree_is_refused():
    for content in (b"{", b"[]", b"[" * 100_000, b"\xff", b'{"actual_label": 1}'):
        with pytest.raises(InputError):
            from_dtcontrol(content, "default.json")
        with pytest.raises(InputError):
            from_treelite(content, "tree.json")


def treelite_model(nodes, **more):
    given = {
        "num_feature": 2, "task_type": "kMultiClf", "num_target": 1, "postprocessor": "softmax",
        "base_scores": [0.0, 0.0], "trees": [{"nodes": nodes}],
    }  # fmt: skip
    return json.dumps(given | more).encode()


def split_node(place, left, right, **more):
    given = {
        "node_id": place, "split_feature_id": 1, "default_left": False, "node_type": "numerical_test_node",
        "comparison_op": "<", "threshold": 0.1, "left_child": left, "right_child": right,
    }  # fmt: skip
    return given | more


LEAVES = [{"node_id": 1, "leaf_value": [1.0, 0.0]}, {"node_id": 2, "leaf_value": [0.0, 1.0]}]


@pytest.mark.parametrize("sign", ["<", "<=", ">", ">="])
@pytest.mark.parametrize("left", [True, False])
def test_signs_and_sides_of_nan(sign, left):
    (origin,) = from_treelite(
        treelite_model([split_node(0, 1, 2, comparison_op=sign, default_left=left), *LEAVES]), "t"
    ).values()
    policy, rows = asked({"a": origin}, finite=False)
    assert decided({"a": origin}, policy, rows) == [
        int(not {"<": x < 0.1, "<=": x <= 0.1, ">": x > 0.1, ">=": x >= 0.1}[sign]) for x in rows[:, 1].astype(float)
    ]
    assert origin.nan == (left == (sign in (">", ">=")))


@pytest.mark.parametrize(
    ("nodes", "more", "said"),
    [
        ([split_node(0, 0, 0), *LEAVES], {}, "deeper than 64"),
        ([split_node(0, 1, 5), *LEAVES], {}, "not treelite's JSON"),
        ([split_node(0, 1, 2, node_type="categorical_test_node"), *LEAVES], {}, "a node is not understood"),
        ([split_node(0, 1, 2, comparison_op="=="), *LEAVES], {}, "a test is not understood"),
        ([split_node(0, 1, 2, split_feature_id=7), *LEAVES], {}, "tests feature 7, there are 2"),
        ([split_node(0, 1, 2), *LEAVES], {"postprocessor": "exponential"}, "the link is not understood"),
        ([split_node(0, 1, 2), *LEAVES], {"base_scores": [0.0, 1.0]}, "the link is not understood"),
        ([split_node(0, 1, 2), *LEAVES], {"num_target": 2}, "2 targets"),
        ([split_node(0, 1, 2, threshold=10**400), *LEAVES], {}, "not treelite's JSON"),
        ([{"node_id": 0, "leaf_value": [1.0, math.nan]}], {}, "a leaf's scores are"),
        (
            [{"node_id": 0, "leaf_value": math.nan}],
            {"task_type": "kRegressor", "postprocessor": "identity"},
            "a leaf's number is nan",
        ),
        (
            [{"node_id": 0, "leaf_value": math.nan}],
            {"task_type": "kBinaryClf", "postprocessor": "sigmoid"},
            "too close to call",
        ),
        ([split_node(0, 1, 2), *LEAVES], {"trees": [1, 2]}, "2 trees"),
    ],
)
def test_other_models_of_treelite_are_refused(nodes, more, said):
    with pytest.raises(InputError, match=said):
        from_treelite(treelite_model(nodes, **more), "tree.json")


@pytest.mark.parametrize("numbers", ["float64", "float32"])
def test_treelite_says_what_it_compares(numbers):
    nodes = [split_node(0, 1, 2), *LEAVES]
    (origin,) = from_treelite(treelite_model(nodes, threshold_type=numbers), "t.json").values()
    assert origin.numbers == numbers
    with pytest.raises(InputError, match="type of thresholds"):
        from_treelite(treelite_model(nodes, threshold_type="int8"), "t.json")


# --- linear predicates and sets of actions


def linear(rng, depth=0):
    """A random tree of dtControl's form with linear predicates over four features, as nested JSON."""
    if depth == 3 or (depth > 0 and rng.random() < 0.25):
        labels = [str(each) for each in rng.permutation(["left", "stay", "right", "up"])[: rng.integers(1, 4)]]
        return leaf(*labels)
    places = rng.permutation(4)[: rng.integers(1, 4)].tolist()
    weights = [float(rng.choice([1.0, -1.0, 0.5, round(float(rng.normal()), 6), float(rng.normal())])) for _ in places]
    products = [{"coeff": weight, "var": f"x_{place}"} for weight, place in zip(weights, places, strict=True)]
    shift = float(rng.choice([0.0, 0.25, -1.0, float(rng.normal())]))
    left, right = linear(rng, depth + 1), linear(rng, depth + 1)
    return split(0, 0, left, right, lhs=[*products, {"intercept": shift}])


def permitted(node, row):
    """The labels that a tree permits, its predicates added as dtControl's C adds them."""
    while node["split"] is not None:
        *products, last = node["split"]["lhs"]
        total = None
        for each in products:
            term = each["coeff"] * row[int(each["var"][2:])]
            total = term if total is None else total + term
        node = node["children"][0 if total + last["intercept"] <= 0 else 1]
    return node["actual_label"]


PREFER = ("right", "up", "left", "stay")


@pytest.mark.parametrize("count", [6, pytest.param(1_000, marks=pytest.mark.slow)])
def test_linear_predicates_and_preferred_actions(count):
    for seed in range(count):
        rng = np.random.default_rng(seed)
        tree = linear(rng)
        origins = from_dtcontrol(json.dumps(tree).encode(), "default.json", Said(prefer=PREFER))
        (policy,) = profile_of(origins, Names(), None).agents
        rows = replay.observations(policy, nan=False, finite=True)
        if policy.tree.arithmetic:
            rows = np.concatenate([rows, probes.ties(policy, rng), rng.normal(size=(50, len(policy.features)))])
        rows = rows[rng.permutation(len(rows))[:200]]
        rows = rows[np.isfinite(rows).all(axis=1)]
        wide = np.pad(rows, ((0, 0), (0, 4 - rows.shape[1])))
        wanted = [min(permitted(tree, row), key=PREFER.index) for row in wide.tolist()]
        assert [policy.actions[each].name for each in ir.act(policy, rows)] == wanted, seed


def test_what_leaves_permit_is_kept_by_leaf():
    tree = split(0, 0.5, leaf("left", "up"), leaf("up"))
    origins = from_dtcontrol(json.dumps(tree).encode(), "default.json", Said(prefer=("left",)))
    profile = profile_of(origins, Names())
    assert profile.provenance.training["agent_0 permits"] == "leaf 1: left | up"
    assert [action.name for action in profile.agents[0].actions] == ["left", "up"]
    for prefer in ((), ("down",)):
        with pytest.raises(InputError, match="a leaf permits 2 actions: left, up") as caught:
            from_dtcontrol(json.dumps(tree).encode(), "default.json", Said(prefer=prefer))
        assert "--prefer" in caught.value.next_step


@pytest.mark.parametrize(
    "side",
    [
        [{"intercept": 1.0}],
        [{"coeff": 1.0, "var": 0}],
        [{"coeff": 1.0, "var": 0}, {"coeff": 2.0, "var": 0}, {"intercept": 1.0}],
        [{"coeff": 0.0, "var": 0}, {"intercept": 1.0}],
        [],
    ],
)
def test_damaged_linear_predicates_are_refused(side):
    with pytest.raises(InputError):
        dtcontrol(split(0, 0, leaf("a"), leaf("b"), lhs=side))


@pytest.mark.parametrize("count", [3, pytest.param(300, marks=pytest.mark.slow)])
def test_treelites_regressors(count):
    treelite = pytest.importorskip("treelite", reason="treelite is not installed")
    for seed in range(count):
        x, _ = data(seed)
        settings = {"bootstrap": False, "max_depth": 3 + seed % 8, "random_state": seed}
        forest = RandomForestRegressor(1, **settings).fit(x[:200], x[:200, 0] * 3 - x[:200, 1])
        model = treelite.sklearn.import_model(forest)
        origins = from_treelite(model.dump_as_json().encode(), "tree.json")
        (policy,) = profile_of(origins, Names()).agents
        rows = replay.observations(policy, nan=False, finite=True)[:300]
        said = treelite.gtil.predict(model, rows).ravel()
        if policy.outputs:
            assert same(ir.outputs(policy, rows)[:, 0], said).all(), seed
        else:
            assert [float(each) for each in decided(origins, policy, rows)] == said.tolist(), seed
