"""A budget of leaves: the splits of scikit-learn's best-first growth, no leaf spent on splits that decide nothing."""

import numpy as np
import pytest
from sklearn.tree import DecisionTreeClassifier

from codegen import ir
from codegen.errors import InputError
from codegen.lowering.deploy import deploy_tree
from maviper.evaluation import held_out
from maviper.experts.finding import find_expert
from maviper.extraction.algorithms import extract
from maviper.extraction.growth.best_first import BestFirstTree, gini, thrift
from maviper.extraction.growth.joint import Bins
from maviper.extraction.settings import Settings


def points(seed=0, n=600, n_features=4, n_actions=3):
    rng = np.random.default_rng(seed)
    obs = rng.normal(size=(n, n_features)).astype(np.float32)
    labels = (obs[:, 0] > 0).astype(int) + (obs[:, 1] * obs[:, 2] > 0.3)
    return obs, np.where(rng.random(n) < 0.1, rng.integers(n_actions, size=n), labels), rng.integers(1, 4, size=n)


def grown(obs, labels, counts):
    bins = Bins.of(obs, len(obs) + 1)
    vectors = np.zeros((len(obs), 3))
    vectors[np.arange(len(obs)), labels] = counts
    return BestFirstTree(bins.codes(obs), vectors, bins, 30, gini)


@pytest.mark.parametrize("leaves", [2, 3, 5, 9, 16])
def test_labels_are_split_as_scikit_learn_splits_them(leaves):
    obs, labels, counts = points(leaves)
    theirs = DecisionTreeClassifier(max_leaf_nodes=leaves, random_state=0).fit(obs, labels, sample_weight=counts)
    ours = grown(obs, labels, counts).grow_to(leaves)
    assert len(ir.leaves(deploy_tree(ours))) == theirs.get_n_leaves()
    found = ours.action[ir.apply(ours, obs)]
    assert np.array_equal(found, theirs.predict(obs))


def test_leaves_that_would_be_merged_are_not_counted():
    obs, labels, counts = points(7)
    plain, merged = grown(obs, labels, counts).grow_to(8), grown(obs, labels, counts).deciding(8)
    assert len(ir.leaves(deploy_tree(merged))) == 8

    def right(tree):
        return counts[tree.action[ir.apply(tree, obs)] == labels].sum()

    assert right(merged) >= right(plain)
    one = grown(obs, np.zeros_like(labels), counts).deciding(8)
    assert len(one.feature) == 1


def cost(tree, obs, regrets):
    return regrets[np.arange(len(obs)), tree.action[ir.apply(tree, obs)]].sum()


def by_regret(obs, regrets, depth):
    bins = Bins.of(obs, len(obs) + 1)
    return BestFirstTree(bins.codes(obs), -regrets, bins, depth, thrift).deciding(2**depth)


@pytest.mark.parametrize("seed", range(12))
def test_a_split_by_regret_is_the_one_after_which_the_best_actions_cost_least(seed):
    """Against every threshold of every feature, with regrets in quarters, whose sums are exact."""
    rng = np.random.default_rng(seed)
    n, n_actions = int(rng.integers(4, 30)), int(rng.integers(2, 5))
    obs = rng.normal(size=(n, 3)).astype(np.float32)
    regrets = rng.integers(0, 40, size=(n, n_actions)) / 4
    regrets[np.arange(n), rng.integers(n_actions, size=n)] = 0.0
    costs = [regrets.sum(axis=0).min()]
    for column in obs.T:
        for threshold in np.sort(column)[:-1]:
            left = column <= threshold
            costs.append(regrets[left].sum(axis=0).min() + regrets[~left].sum(axis=0).min())
    tree = by_regret(obs, regrets, 1)
    assert cost(tree, obs, regrets) == min(costs)
    deeper = [cost(by_regret(obs, regrets, depth), obs, regrets) for depth in (1, 2, 3)]
    assert deeper == sorted(deeper, reverse=True)


def test_one_dear_state_decides_where_many_cheap_ones_would():
    """Labels differ in eight cheap states along one feature, and in one dear state along another."""
    obs = np.array([[place % 2, place == 8] for place in range(9)], np.float32)
    labels = obs[:, 0].astype(int)
    labels[8] = 2
    regrets = np.ones((9, 3)) - np.eye(3)[labels]
    regrets[8, :2] = 50.0
    assert cost(by_regret(obs, regrets, 1), obs, regrets) == 4.0
    assert by_regret(obs, regrets, 1).feature[0] == 1
    by_label = grown(obs, labels, np.ones(9, int)).grow_to(2)
    assert by_label.feature[0] == 0 and cost(by_label, obs, regrets) == 50.0


def test_a_split_that_saves_nothing_yet_is_taken_for_those_below_it():
    """Either sign alone leaves one action best on both sides; both signs together cost nothing."""
    obs = np.array([[x, y] for x in (-1, 1) for y in (-1, 1)], np.float32)
    regrets = np.array([[0.0, 1.0], [5.0, 0.0], [4.0, 0.0], [0.0, 1.5]])
    one, two = (by_regret(obs, regrets, depth) for depth in (1, 2))
    assert len(one.feature) == 1 and cost(one, obs, regrets) == 2.5 == regrets.sum(axis=0).min()
    assert cost(two, obs, regrets) == 0.0


@pytest.mark.parametrize(("preset", "algorithm"), [("default", "viper"), ("paper", "iviper"), ("default", "imitation")])
def test_algorithms_without_votes_keep_to_it(preset, algorithm, monkeypatch):
    monkeypatch.setattr(held_out, "EVALUATION_EPISODES", 10)
    expert, world = find_expert("coordination")
    agent = world.agents[0] if algorithm == "viper" else ""
    given = {"iterations": 2, "rollouts": 20, "selection_episodes": 5, "max_depth": 9, "max_leaves": 5}
    settings = Settings.of({"algorithm": algorithm, "preset": preset, "agent": agent, **given}, world)
    found = extract(world, expert, settings)
    assert all(1 < len(ir.leaves(policy.tree)) <= 5 for policy in found.agents)
    assert found.provenance.training["max_leaves"] == 5


def test_votes_have_no_budget_of_leaves():
    with pytest.raises(InputError, match="vote"):
        Settings.of({"max_leaves": 5})
    assert Settings.of({"max_leaves": 5, "least_right": "0"}).leaves == 5
