"""RGMDT after its description: clusters of action values under a budget of leaves, trees conditioned on one another."""

import numpy as np
import pytest

from codegen import ir, policy_json
from codegen.lowering.deploy import deploy_tree
from maviper.evaluation import held_out
from maviper.experts.finding import find_expert
from maviper.extraction.algorithms import extract
from maviper.extraction.baselines import _Points
from maviper.extraction.extraction import Extraction
from maviper.extraction.growth.best_first import BestFirstTree
from maviper.extraction.growth.joint import Bins
from maviper.extraction.settings import DESCRIBED, IMITATION, RGMDT, Settings
from tests.support.coordination import worth

GAMES = [
    "coordination,noise=5",
    "coordination,agents=4,noise=5",
    "coordination,kinds=3,payoff=50,noise=10",
    "coordination,rule=climbing,noise=5",
]


@pytest.fixture(autouse=True)
def quick(monkeypatch):
    monkeypatch.setattr(held_out, "EVALUATION_EPISODES", 10)


def small(world, **given):
    usual = {"algorithm": RGMDT, "preset": "paper", "max_depth": 2, "iterations": 4, "rollouts": 300}
    return Settings.of({**usual, **given}, world)


def loss(vectors, leaf):
    """The clustering loss, the long way: cosine distances to each leaf's centre, weighted by length."""
    total = 0.0
    for each in np.unique(leaf):
        mine = vectors[leaf == each]
        centre, length = mine.sum(axis=0), np.linalg.norm(mine, axis=1)
        cosine = mine @ centre / np.maximum(length * np.linalg.norm(centre), 1e-300)
        total += float((length * (1 - cosine)).sum())
    return total


@pytest.fixture(scope="module")
def cloud():
    rng = np.random.default_rng(3)
    obs = rng.integers(5, size=(60, 3)).astype(np.float32)
    vectors = rng.normal(size=(60, 4)) + 3 * np.eye(4)[(obs[:, 1] + (obs[:, 0] > 2)).astype(int) % 4]
    return obs, vectors - vectors.mean(axis=1, keepdims=True)


def test_the_first_split_is_the_one_that_lowers_the_loss_most(cloud):
    obs, vectors = cloud
    grown = BestFirstTree(Bins.of(obs).codes(obs), vectors, Bins.of(obs), 3).grow_to(2)
    tried = {
        (feature, cut): loss(vectors, obs[:, feature] <= cut)
        for feature in range(3)
        for cut in (np.unique(obs[:, feature])[:-1] + 0.5)
    }
    assert (grown.feature[0], grown.threshold[0]) == min(tried, key=tried.__getitem__)


def test_more_leaves_never_raise_the_loss_and_are_never_more_than_asked_for(cloud):
    obs, vectors = cloud
    losses = []
    for leaves in (1, 2, 3, 5, 8, 100):
        tree = deploy_tree(BestFirstTree(Bins.of(obs).codes(obs), vectors, Bins.of(obs), 6).grow_to(leaves))
        assert len(ir.leaves(tree)) <= leaves
        leaf = ir.apply(tree, obs)
        losses.append(loss(vectors, leaf))
        for each in ir.leaves(tree):
            assert tree.action[each] == vectors[leaf == each].sum(axis=0).argmax()
    assert losses == sorted(losses, reverse=True) and losses[-1] < losses[0] / 2
    grown = BestFirstTree(Bins.of(obs).codes(obs), vectors, Bins.of(obs), 2).grow_to(100)
    assert ir.depth(deploy_tree(grown)).max() == 2


@pytest.mark.parametrize("table", [0, 1])
@pytest.mark.parametrize("game", GAMES)
def test_it_reaches_at_least_what_uniform_trees_do(game, table):
    """Imitation DT weighs every state alike and looks at no values."""
    expert, world = find_expert(f"{game},table={table}")
    reached = {}
    for algorithm in (RGMDT, IMITATION):
        found = extract(world, expert, small(world, algorithm=algorithm))
        reached[algorithm] = worth(world, found.agents)
    assert reached[IMITATION] <= reached[RGMDT] + 1e-9


@pytest.mark.parametrize("leaves", [2, 3, 6])
def test_the_budget_of_leaves_holds(leaves):
    expert, world = find_expert("coordination,signals=4,noise=5")
    found = extract(world, expert, small(world, max_depth=4, max_leaves=leaves))
    sizes = [len(ir.leaves(policy.tree)) for policy in found.agents]
    assert max(sizes) <= leaves and sum(sizes) > len(sizes)
    assert found.provenance.training["max_leaves"] == leaves


def test_the_same_seed_gives_the_same_bytes_and_says_what_it_is():
    expert, world = find_expert("coordination,noise=10")
    one, two, other = (extract(world, expert, small(world, seed=seed)) for seed in (4, 4, 5))
    assert policy_json.dumps(one) == policy_json.dumps(two) != policy_json.dumps(other)
    assert one.provenance.algorithm == RGMDT
    assert one.provenance.training["source"] == DESCRIBED[RGMDT]
    assert "after the description" in DESCRIBED[RGMDT]
    assert "max_leaves" not in one.provenance.training


def test_values_are_those_with_the_other_agents_at_their_trees():
    """Against two constant team-mates on one convention, only that convention is worth anything: agreeing pays half."""
    expert, world = find_expert("coordination,agree=50")
    points = _Points(Extraction(world, expert, small(world)), range(3))
    points.play([expert] * 3, range(200))
    leaf = [np.array([value]) for value in (-1, 0.0, -1, -1)]
    for convention in range(world.conventions):
        same = ir.GrownTree(*leaf, np.array([convention]))
        tree = points.tree(0, {1: same, 2: same})
        assert tree.action.tolist() == [convention]
    assert len(points.tree(0, {}).feature) > 1
