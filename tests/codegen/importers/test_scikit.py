"""Trees of others: the same decisions at every boundary, or an error that says why not."""

import warnings

import numpy as np
import pytest
from sklearn.base import clone
from sklearn.decomposition import PCA
from sklearn.ensemble import ExtraTreesClassifier, HistGradientBoostingClassifier, RandomForestClassifier
from sklearn.feature_selection import SelectKBest, VarianceThreshold
from sklearn.model_selection import GridSearchCV
from sklearn.pipeline import make_pipeline
from sklearn.preprocessing import (
    Binarizer,
    FunctionTransformer,
    MaxAbsScaler,
    MinMaxScaler,
    Normalizer,
    PolynomialFeatures,
    QuantileTransformer,
    RobustScaler,
    StandardScaler,
)
from sklearn.tree import DecisionTreeClassifier

from codegen import ir, policy_json, profiles
from codegen.agreement import probes
from codegen.errors import DisagreementError, InputError
from codegen.importers.names import clean_names
from codegen.importers.scikit import from_sklearn


def fitted(seed=0, n_features=4, depth=5, classes=("wait", "go", "turn")):
    rng = np.random.default_rng(seed)
    x = rng.normal(size=(600, n_features)).astype(np.float32)
    y = np.array(classes)[((x[:, 0] > x[:, 1]).astype(int) + (x[:, 2] > 0.3)) % len(classes)]
    return DecisionTreeClassifier(max_depth=depth, random_state=seed).fit(x, y), x


def boundary(policy):
    rng = np.random.default_rng(0)
    return np.concatenate(
        [probes.boundary(policy.tree, policy.features, rng), rng.normal(size=(500, len(policy.features)))]
    )


@pytest.mark.parametrize("seed", range(5))
def test_a_classifier_decides_as_before(seed):
    classifier, _ = fitted(seed)
    profile = from_sklearn(classifier)
    (policy,) = profile.agents
    rows = boundary(policy).astype(np.float32)
    rows = rows[np.isfinite(rows).all(axis=1)]
    names = np.array([action.name for action in policy.actions])
    assert (names[ir.act(policy, rows)] == classifier.predict(rows)).all()
    assert [action.name for action in policy.actions] == sorted(["wait", "go", "turn"])
    assert policy_json.dumps(profiles.loads(policy_json.dumps(profile))) == policy_json.dumps(profile)


def test_names_come_from_a_data_frame():
    classifier, _ = fitted()
    classifier.feature_names_in_ = np.array(["a", "b", "3rd", "-"])
    assert [f.name for f in from_sklearn(classifier).agents[0].features] == ["a", "b", "x_3rd", "x"]


def test_what_is_no_single_tree_is_refused():
    with pytest.raises(InputError, match="not a fitted"):
        from_sklearn(DecisionTreeClassifier())
    with pytest.raises(InputError, match="not a fitted"):
        from_sklearn(object())
    x, rng = np.zeros((4, 2)), np.random.default_rng(0)
    with pytest.raises(InputError, match="2 outputs"):
        from_sklearn(DecisionTreeClassifier().fit(x, rng.integers(2, size=(4, 2))))
    with pytest.raises(InputError, match="3 feature names for 4"):
        from_sklearn(fitted()[0], ["a", "b", "c"])
    for names in (["a"], [], ["a", "b"]):
        with pytest.raises(InputError, match="the source names its actions itself: go, turn, wait"):
            from_sklearn(fitted()[0], action_names=names)


class Contrary(DecisionTreeClassifier):
    def predict(self, x):
        return super().predict(-x)


class Validating(DecisionTreeClassifier):
    def _validate_X_predict(self, X, check_input):
        return -super()._validate_X_predict(X, check_input)


class Classes(DecisionTreeClassifier):
    @property
    def classes_(self):
        return self.named[::-1] if isinstance(self.named, np.ndarray) else self.named

    @classes_.setter
    def classes_(self, given):
        self.named = given


class Looking(DecisionTreeClassifier):
    def __getattribute__(self, name):
        return super().__getattribute__(name)


class Mixed:
    def predict(self, x):
        return DecisionTreeClassifier.predict(self, -x)


class Before(Mixed, DecisionTreeClassifier):
    pass


class Fitted(DecisionTreeClassifier):
    """Fits in its own way, which the tree shows, and says more of itself."""

    def fit(self, x, y):
        return super().fit(-x, y)

    def depth(self):
        return self.get_depth()


class Lookalike:
    """No tree of scikit-learn."""

    def __init__(self, tree):
        self.tree_, self.classes_ = tree.tree_, tree.classes_

    def predict(self, x):
        return x


def test_a_subclass_that_replaces_what_prediction_uses_is_refused():
    x = np.random.default_rng(0).normal(size=(50, 3))
    y = x[:, 0] > 0
    for kind in (Contrary, Validating, Classes, Looking, Before):
        with pytest.raises(InputError, match="does not predict as scikit-learn's own: it replaces"):
            from_sklearn(kind().fit(x, y))
    with pytest.raises(InputError, match="does not predict as"):
        from_sklearn(Lookalike(DecisionTreeClassifier().fit(x, y)))
    changed = RandomForestClassifier(1).fit(x, y)
    changed.estimators_[0]._validate_X_predict = None
    forest = RandomForestClassifier(1).fit(x, y)
    forest.predict_proba = lambda rows: rows
    searched = GridSearchCV(DecisionTreeClassifier(), {"max_depth": [2]}).fit(x, y)
    searched.best_estimator_.apply = print
    single = DecisionTreeClassifier().fit(x, y)
    single.predict = lambda rows: rows
    for model in (changed, forest, searched, single):
        with pytest.raises(InputError, match="does not predict as"):
            from_sklearn(model)
    own = Fitted().fit(x, y)
    policy = from_sklearn(own).agents[0]
    assert ir.act(policy, x.astype(np.float32)).tolist() == own.predict(x.astype(np.float32)).tolist()


@pytest.mark.parametrize("scaler", [StandardScaler(), MinMaxScaler(), RobustScaler(), MaxAbsScaler()], ids=str)
def test_a_scaler_that_was_fitted_on_missing_values_alone_is_refused_in_words(scaler):
    x = np.random.default_rng(0).normal(size=(50, 3))
    y = x[:, 0] > 0
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        model = make_pipeline(scaler, DecisionTreeClassifier(max_depth=2)).fit(x, y)
        model[0].fit(np.where([True, True, False], x, np.nan))
    with pytest.raises(InputError, match=r"not finite|not understood") as caught:
        from_sklearn(model)
    assert caught.value.next_step


def test_what_was_learned_from_missing_values_is_refused_where_it_shows():
    rng = np.random.default_rng(0)
    x = rng.normal(size=(300, 3))
    y = x[:, 0] > 0
    x[rng.random(x.shape) < 0.3] = np.nan
    x[y, 1] = np.nan
    only = np.where(y, np.nan, 0.0)[:, None]  # a threshold of infinity: missing or not
    for classifier in (DecisionTreeClassifier().fit(x, y), DecisionTreeClassifier().fit(only, y)):
        with pytest.raises(InputError, match="fitted on missing values") as caught:
            from_sklearn(classifier)
        assert caught.value.where.startswith("node ")


@pytest.mark.parametrize(
    "settings",
    [
        {"class_weight": "balanced"},
        {"criterion": "entropy", "splitter": "random"},
        {"monotonic_cst": [1, -1, 0, 0]},
        {"ccp_alpha": 0.01},
    ],
    ids=str,
)
@pytest.mark.parametrize("labels", [[0, 1], [9, -2], ["b", "a"], [False, True]], ids=str)
def test_however_it_was_fitted(settings, labels):
    rng = np.random.default_rng(0)
    x = rng.normal(size=(400, 4)).astype(np.float32)
    y = np.array(labels)[(x[:, 0] + 0.5 * rng.normal(size=400) > x[:, 1]).astype(int)]
    weights = rng.random(400) * (rng.random(400) > 0.3)
    classifier = DecisionTreeClassifier(max_depth=6, random_state=0, **settings).fit(x, y, sample_weight=weights)
    (policy,) = from_sklearn(classifier).agents
    rows = boundary(policy).astype(np.float32)
    rows = rows[np.isfinite(rows).all(axis=1)]
    assert (classifier.classes_[ir.act(policy, rows)] == classifier.predict(rows)).all()
    assert {*ir.act(policy, rows)} == {0, 1}


def named(labels, **given):
    x = np.arange(3.0 * len(labels))[:, None]
    profile = from_sklearn(DecisionTreeClassifier().fit(x, np.repeat(np.array(labels), 3)), **given)
    return [action.name for action in profile.agents[0].actions]


@pytest.mark.parametrize(
    ("labels", "names"),
    [
        ([5, -2, 9], ["action_minus_2", "action_5", "action_9"]),
        ([-1, 0, 1], ["action_minus_1", "action_0", "action_1"]),
        ([-10, 1], ["action_minus_10", "action_1"]),
        ([-1.0, 1.0], ["action_minus_1_0", "action_1_0"]),
        ([False, True], ["False", "True"]),
        (["wait", "go left", "-go"], ["go", "go_left", "wait"]),
        (["turn -1", "turn 1"], ["turn_minus_1", "turn_1"]),
        (["\N{MINUS SIGN}1", "+1", "-.5", "-5"], ["action_1", "action_minus__5", "action_minus_5", "action_minus_1"]),
        (
            ["r\N{LATIN SMALL LETTER U WITH DIAERESIS}ckw\N{LATIN SMALL LETTER A WITH DIAERESIS}rts", "b-2"],
            ["b_2", "ruckwarts"],
        ),
        ([b"up", b"down"], ["down", "up"]),
    ],
    ids=str,
)
def test_labels_keep_their_order_their_sign_and_their_text(labels, names):
    assert named(labels) == names and all(ir.NAME.fullmatch(name) for name in names)


@pytest.mark.parametrize(
    "labels", [["go", "Go"], ["1", "action 1"], ["a b", "a_b"], ["x" * 80 + "1", "x" * 80 + "2"], ["-", "?"]], ids=str
)
def test_labels_whose_names_collide_are_numbered_unless_the_user_gives_names(labels):
    classifier = DecisionTreeClassifier().fit([[0.0], [1.0]], labels)
    actions = from_sklearn(classifier).agents[0].actions
    assert len({each.name.lower() for each in actions}) == 2 and all(ir.NAME.fullmatch(each.name) for each in actions)
    assert [each.label for each in actions] == sorted(labels)
    renamed = [f"{new}={old}" for new, old in zip("pq", labels, strict=True)]
    assert sorted(named(labels, action_names=renamed)) == ["p", "q"]
    with pytest.raises(InputError, match="become the same action name, a_b"):
        named(labels, action_names=[f"a-b={labels[0]}", f"a b={labels[1]}"])


def test_labels_that_steer_a_terminal_are_refused_with_what_to_do():
    with pytest.raises(InputError, match=r"a label holds control characters: a\\x07b") as caught:
        named(["a\x07b", "c"])
    assert "source" in caught.value.next_step


@pytest.mark.parametrize("given", [["if", "IF", "i f", "", "ß"], ["x" * 90, "x" * 91], ["1", "_1", "1", "-1"]])
def test_cleaned_names_are_legal_and_different(given):
    found = clean_names(given, "x")
    assert all(ir.NAME.fullmatch(name) for name in found)
    assert len({name.lower() for name in found}) == len(given)


def same(model, x):
    """The imported tree decides as the model at its thresholds; the replay of the import is not asked."""
    (policy,) = from_sklearn(model).agents
    rows = np.concatenate([boundary(policy).clip(-1e30, 1e30).astype(np.float32), x])
    rows = rows[np.isfinite(rows).all(axis=1)]
    names = [action.name for action in policy.actions]
    assert [names[each] for each in ir.act(policy, rows)] == model.predict(rows).tolist()
    return policy


STEPS = [
    [StandardScaler()], [StandardScaler(with_mean=False)], [StandardScaler(with_std=False)], [MinMaxScaler()],
    [MinMaxScaler((-3, 7), clip=True)], [MaxAbsScaler()], [RobustScaler()], [Binarizer(threshold=0.3)],
    [SelectKBest(k=2)], [VarianceThreshold(), StandardScaler()], ["passthrough", SelectKBest(k=3), MinMaxScaler()],
    [StandardScaler(), Binarizer(), SelectKBest(k=2)],
]  # fmt: skip


@pytest.mark.parametrize("before", STEPS, ids=str)
@pytest.mark.parametrize("scale", [1.0, 1e-3, 3e4])
def test_known_steps_are_folded_into_the_thresholds(before, scale):
    _, x = fitted()
    x, y = x * np.float32(scale) + np.float32(scale / 3), np.array(["go", "stay"])[(x[:, 0] > x[:, 1]).astype(int)]
    same(clone(make_pipeline(*before, DecisionTreeClassifier(max_depth=5))).fit(x, y), x)


@pytest.mark.parametrize(
    "step",
    [PCA(2), Normalizer(), PolynomialFeatures(2), QuantileTransformer(n_quantiles=9), FunctionTransformer(np.negative)],
)
def test_other_steps_are_refused_by_name(step):
    _, x = fitted()
    model = make_pipeline(StandardScaler(), step, DecisionTreeClassifier(max_depth=3)).fit(x, x[:, 0] > 0)
    with pytest.raises(InputError, match=f"the step '{type(step).__name__.lower()}' before the tree"):
        from_sklearn(model)


def test_searches_and_forests_of_one_come_in():
    _, x = fitted()
    y = np.array(["go", "stay"])[(x[:, 0] > x[:, 1]).astype(int)]
    pipeline = make_pipeline(StandardScaler(), DecisionTreeClassifier(max_depth=3))
    same(GridSearchCV(pipeline, {"decisiontreeclassifier__max_depth": [2, 3]}, cv=2).fit(x, y), x)
    same(RandomForestClassifier(1, max_depth=4, random_state=0).fit(x, y), x)
    same(make_pipeline(MinMaxScaler(), ExtraTreesClassifier(1, max_depth=4, random_state=0)).fit(x, y), x)
    with pytest.raises(InputError, match="no best estimator"):
        from_sklearn(GridSearchCV(pipeline, {}))


@pytest.mark.parametrize("seed", range(4))
def test_small_forests_come_in_as_one_tree(seed):
    """With ties among classes: two trees with pure leaves give both of two classes one half."""
    _, x = fitted(seed)
    y = np.array(["go", "stay", "turn"])[(x[:, 0] > x[:, 1]).astype(int) + (x[:, 2] > 0.5)]
    for count, depth in ((2, None), (3, 3), (5, 2)):
        for kind in (RandomForestClassifier, ExtraTreesClassifier):
            same(kind(count, max_depth=depth, max_leaf_nodes=12, random_state=seed).fit(x, y), x)
    same(make_pipeline(StandardScaler(), RandomForestClassifier(3, max_depth=3, random_state=seed)).fit(x, y), x)


def test_forests_that_are_large_or_add_in_any_order_are_refused():
    _, x = fitted()
    for model, what in (
        (RandomForestClassifier(40, random_state=0), "more than 4,096 leaves"),
        (RandomForestClassifier(2, max_depth=2, n_jobs=2), "added in any order"),
    ):
        with pytest.raises(InputError, match=what) as caught:
            from_sklearn(model.fit(x, x[:, 0] > x[:, 1]))
        assert caught.value.next_step


def test_what_a_model_does_with_missing_values_is_said():
    """scikit-learn predicts for NaN whatever a tree was fitted on: at each split it goes to the bigger side."""
    nan = np.nan
    rows = [[nan, 0], [nan, 0], [1, 0], [2, 1], [nan, 1]]
    left = from_sklearn(DecisionTreeClassifier(random_state=0).fit(rows, [0, 0, 0, 1, 1]))
    told = left.provenance.training
    assert told["agent_0 notes"] == "NaN: scikit-learn sends it left at 1 of 1 splits"
    assert told["agent_0 NaN"] == "goes right, whatever the origin does"
    right = from_sklearn(DecisionTreeClassifier().fit([[0], [1], [2]], [0, 1, 1])).provenance.training
    assert right["agent_0 NaN"] == "decided as in the origin" and "agent_0 notes" not in right


def test_a_model_that_tells_doubles_apart_is_not_taken_for_one_of_float32(monkeypatch):
    x = 1.7e9 + np.arange(100.0)[:, None]
    model = HistGradientBoostingClassifier(max_iter=1).fit(x, np.arange(100) > 49)
    (policy,) = from_sklearn(model).agents
    assert policy.numbers == "float64" and (ir.act(policy, x) == model.predict(x)).all()
    single = DecisionTreeClassifier().fit([[0.0], [0.5]], [0, 1])
    told = single.predict
    monkeypatch.setattr(DecisionTreeClassifier, "predict", lambda _, rows: told(rows) ^ (rows[:, 0] > 0.25))
    with pytest.raises(DisagreementError, match="tells doubles apart"):
        from_sklearn(single)
