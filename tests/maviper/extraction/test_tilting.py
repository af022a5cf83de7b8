"""Refinement of trees that test sums: other sums at a split, in trees that stay what they are elsewhere."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from codegen import ir
from codegen.errors import InputError
from codegen.ir import CONSTANT, NO_FEATURE, GrownTree, Sum
from codegen.lowering.deploy import SummedTree, deploy_tree
from codegen.profiles import check
from maviper.episodes.trees import reopen_tree
from maviper.evaluation import held_out
from maviper.experts.finding import find_expert
from maviper.extraction import refine
from maviper.extraction.algorithms import extract
from maviper.extraction.arena import merge_leaves, with_leaf
from maviper.extraction.growth.sums import DIGITS, TERMS, as_summed, columns_of, tilt_tests, with_sum
from maviper.extraction.settings import Settings

N = 5  # features


def summed():
    """x3 <= 0 at the root; on its left x0 - x1 <= 0.5; a sum that nobody tests stands before that one."""
    feature, threshold = np.array([3, 6, -1, -1, -1]), np.array([0.0, 0.5, 0, 0, 0])
    left, right, action = np.array([1, 3, -1, -1, -1]), np.array([2, 4, -1, -1, -1]), np.array([-1, -1, 0, 1, 2])
    tests = np.array([[0, 0, 1, 0, 1], [1, -1, 0, 0, 0]], np.float32)
    return SummedTree(feature, threshold, left, right, action, tests, np.zeros((0, 0, N + 1)))


def rows(n=400):
    return np.random.default_rng(0).normal(size=(n, N)).astype(np.float32)


def decide(tree, obs):
    deployed = deploy_tree(tree)
    return deployed.action[ir.apply(deployed, obs)]


def test_sums_that_nobody_tests_are_left_out():
    tree, obs = summed(), rows()
    kept = as_summed(tree, N)
    assert kept.tests.tolist() == [[1, -1, 0, 0, 0]] and kept.feature.tolist() == [3, 5, -1, -1, -1]
    assert np.array_equal(decide(kept, obs), decide(tree, obs)) and set(decide(kept, obs).tolist()) == {0, 1, 2}
    assert np.array_equal(columns_of(kept, obs)[:, N], obs[:, 0].astype(np.float64) - obs[:, 1])
    plain = as_summed(
        GrownTree(*(getattr(tree, name)[2:3] for name in ("feature", "threshold", "left", "right", "action"))), N
    )
    assert plain.tests.shape == (0, N) and decide(plain, obs).tolist() == [0] * len(obs)


@pytest.mark.parametrize("node", [0, 1])
def test_another_sum_changes_one_split_and_keeps_how_many_pass(node):
    tree, obs = as_summed(summed(), N), rows()
    tested = columns_of(tree, obs)
    here = tested if node == 0 else tested[tested[:, 3] <= 0]
    goes = (here[:, tree.feature[node]] <= tree.threshold[node]).mean()
    rng, several = np.random.default_rng(1), 0
    for _ in range(20):
        for changed in tilt_tests(tree, node, here, rng):
            other = 1 - node
            assert changed.threshold[other] == tree.threshold[other] and len(changed.tests) <= 2
            column = int(changed.feature[node])
            weights = np.eye(N)[column] if column < N else changed.tests[column - N].astype(np.float64)
            assert np.abs(weights).max() == 1 and 1 <= np.count_nonzero(weights) <= TERMS
            assert np.allclose(weights, np.round(weights, DIGITS), atol=1e-7)
            several += np.count_nonzero(weights) > 1
            assert (here[:, :N] @ weights <= changed.threshold[node]).mean() == pytest.approx(goes, abs=0.01)
            assert np.array_equal(changed.action, tree.action)
            assert isinstance(merge_leaves(with_leaf(changed, 1, 2)), SummedTree)
    assert several > 20


def test_a_deployed_tree_can_be_changed_again_unless_its_sums_have_constants():
    deployed = deploy_tree(summed())
    policy = SimpleNamespace(agent="agent_0", tree=deployed, features=range(N), outputs=(), memory=())
    again = reopen_tree(policy)
    assert isinstance(again, SummedTree) and again.tests.tolist() == [[1, -1, 0, 0, 0]]
    assert np.array_equal(decide(again, rows()), deployed.action[ir.apply(deployed, rows())])
    policy.tree = replace(deployed, sums=(Sum((*deployed.sums[0].terms, (0.5, CONSTANT))),))
    with pytest.raises(InputError, match="agent_0"):
        reopen_tree(policy)


def test_a_sum_of_one_feature_is_that_feature():
    alone = with_sum(as_summed(summed(), N), 1, np.array([0, 0, 1.0, 0, 0]), 0.25)
    assert alone.feature.tolist() == [3, 2, NO_FEATURE, NO_FEATURE, NO_FEATURE] and not len(alone.tests)
    negative = with_sum(alone, 1, np.array([0, 0, -1.0, 0, 0]), 0.25)
    assert negative.feature[1] == N and negative.tests.tolist() == [[0, 0, -1, 0, 0]]


@pytest.mark.parametrize("splits", ["sums", "differences"])
def test_a_team_with_sums_is_refined_and_stays_sound(monkeypatch, splits):
    monkeypatch.setattr(held_out, "EVALUATION_EPISODES", 10)
    expert, world = find_expert("cooperative-navigation,agents=2@fixed-roles", critic="none")
    monkeypatch.setattr(refine, "FIRST", 8)
    monkeypatch.setattr(refine, "LAST", 16)
    for name, value in (("DRIFT_PAIRS", 4), ("DRIFT_PLAYED", 20), ("JUDGED", 16)):
        monkeypatch.setattr(refine, name, value)
    given = {"splits": splits, "max_leaves": 6, "max_depth": 5, "iterations": 1, "rollouts": 8, "selection_episodes": 8}
    given |= {"least_right": "0", "weights": "equal", "measure": "D"}
    plain = extract(world, expert, Settings.of(given, world))
    rounds = 3 * (2 if splits == "sums" else 1)  # half of the episodes move weights, where sums are asked for
    refined = Settings.of({**given, "refinement": rounds * refine.round_cost()}, world)
    profile = extract(world, expert, refined)
    assert not check(profile) and int(profile.provenance.training["refinement_episodes"]) > 0
    assert all(len(ir.leaves(policy.tree)) <= 6 for policy in profile.agents)
    assert any(
        not np.array_equal(one.tree.threshold, other.tree.threshold)
        for one, other in zip(plain.agents, profile.agents, strict=True)
    )
    again = extract(world, expert, refined)
    for one, other in zip(profile.agents, again.agents, strict=True):
        assert one.tree.threshold.tobytes() == other.tree.threshold.tobytes() and one.tree.sums == other.tree.sums
