"""Tests of sums by alternating optimisation: found where they are the truth, never worse than where they began."""

import numpy as np
import pytest

from codegen import ir, policy_json, profiles
from codegen.ir import OutputSpec
from codegen.lowering.deploy import SummedTree
from maviper.evaluation import held_out
from maviper.experts.finding import find_expert
from maviper.extraction.algorithms import extract
from maviper.extraction.growth import sums
from maviper.extraction.growth.best_first import BestFirstTree, ConstantLeaves, LinearLeaves, gini, grow_tree
from maviper.extraction.growth.joint import Bins
from maviper.extraction.growth.sums import Labels, Numbers, optimise_tests
from maviper.extraction.settings import Settings

SPAN = (OutputSpec("force", "N", -1.0, 1.0),)


def points(seed, n=1_500):
    rng = np.random.default_rng(seed)
    obs = rng.normal(size=(n, 5)).astype(np.float32)
    return obs, obs[:, 0] + 0.5 * obs[:, 1] - 0.25 * obs[:, 3], rng.integers(1, 3, size=n)


def of_labels(obs, labels, counts, leaves):
    bins = Bins.of(obs)
    vectors = np.zeros((len(obs), 3))
    vectors[np.arange(len(obs)), labels] = counts
    return BestFirstTree(bins.codes(obs), vectors, bins, 8, gini).deciding(leaves)


def wrong(tree, obs, labels, counts):
    return counts[tree.action[ir.apply(tree, obs)] != labels].sum()


@pytest.mark.parametrize("seed", [0, 1])
def test_the_sum_that_decides_is_found(seed):
    obs, score, counts = points(seed)
    labels = np.where(score > 0.1, 2, 0)
    before = of_labels(obs, labels, counts, 4)
    after = optimise_tests(before, obs, Labels(labels, counts, 3))
    assert isinstance(after, SummedTree)
    assert wrong(after, obs, labels, counts) <= 0.01 * counts.sum() < 0.1 * counts.sum()
    assert wrong(before, obs, labels, counts) > 0.05 * counts.sum()
    named = [weights / weights[0] for weights in after.tests if weights[0]]
    assert any(np.allclose(weights, [1, 0.5, 0, -0.25, 0], atol=0.1) for weights in named), after.tests
    assert all(np.count_nonzero(weights) <= 4 for weights in after.tests)


@pytest.mark.parametrize("seed", range(6))
def test_a_tree_never_loses_more_than_before(seed):
    obs, score, counts = points(seed, 400)
    rng = np.random.default_rng(seed)
    labels = np.where(rng.random(len(obs)) < 0.2, rng.integers(3, size=len(obs)), np.digitize(score, [-0.4, 0.4]))
    before = of_labels(obs, labels, counts, 6)
    after = optimise_tests(before, obs, Labels(labels, counts, 3))
    price = sums.TERM * float((counts * (labels != np.bincount(labels, counts).argmax())).sum())
    terms = sum(1 for each in before.feature if each >= 0)
    assert wrong(after, obs, labels, counts) <= wrong(before, obs, labels, counts) + price * terms + 1e-9
    assert len(ir.leaves(after)) <= 6


@pytest.mark.parametrize("kind", [ConstantLeaves, LinearLeaves])
def test_numbers_that_change_along_a_sum(kind):
    obs, score, counts = points(3)
    labels = np.where(score > 0, 0.5 + 0.1 * obs[:, 2], -0.5).astype(np.float32)[:, None]
    leaves, bins = kind(obs, labels, SPAN), Bins.of(obs)
    before = grow_tree(leaves, counts, bins.codes(obs), bins, 6, 3)
    answers = Numbers(leaves, counts)
    after = optimise_tests(before, obs, answers)

    def lost(tree):
        leaf = tree.action[ir.apply(tree, obs)]
        off = np.array([leaves.off(each) for each in tree.given])
        return (off[leaf, np.arange(len(obs))] * counts).sum()

    assert lost(after) < 0.4 * lost(before) and len(after.tests)
    named = [weights for weights in after.tests if np.count_nonzero(weights) > 1]
    assert any(abs(weights[1] / weights[0] - 0.5) < 0.1 for weights in named if weights[0])


def test_one_sided_splits_go_and_swapped_sides_are_found():
    obs = np.linspace(-1, 1, 50, dtype=np.float32)[:, None]
    labels = np.where(obs[:, 0] > 0.3, 0, 1)
    counts = np.ones(50, dtype=np.int64)
    # everything goes left at the root; the split below it is the wrong way round for its leaves
    tree = ir.GrownTree(
        np.array([0, 0, -1, -1, -1]), np.array([5.0, 0.0, 0, 0, 0]), np.array([1, 2, -1, -1, -1]),
        np.array([4, 3, -1, -1, -1]), np.array([-1, -1, 0, 1, 1]),
    )  # fmt: skip
    after = optimise_tests(tree, obs, Labels(labels, counts, 2))
    assert wrong(after, obs, labels, counts) == 0 and len(after.feature) == 3 and not isinstance(after, SummedTree)


def test_extraction_by_sums_ends_with_a_profile(monkeypatch):
    monkeypatch.setattr(held_out, "EVALUATION_EPISODES", 8)
    expert, world = find_expert("cooperative-navigation,agents=2", critic="none")
    given = {"iterations": 2, "rollouts": 10, "selection_episodes": 2, "max_depth": 2, "splits": "sums"}
    profile = extract(world, expert, Settings.of(given, world))
    assert any(policy.tree.sums for policy in profile.agents)
    assert policy_json.dumps(profiles.loads(policy_json.dumps(profile))) == policy_json.dumps(profile)
    assert profile.provenance.training["splits"] == "sums"
