"""A budget of leaves: the splits of scikit-learn's best-first growth, no leaf spent on splits that decide nothing."""

import numpy as np
import pytest
from sklearn.tree import DecisionTreeClassifier

from codegen import ir
from codegen.lowering.deploy import deploy_tree
from maviper.evaluation import held_out
from maviper.experts.finding import find_expert
from maviper.extraction.algorithms import extract
from maviper.extraction.growth.best_first import BestFirstTree, gini
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


def test_without_votes_there_is_a_budget_of_leaves():
    assert Settings.of({"max_leaves": 5, "least_right": "0"}).leaves == 5
