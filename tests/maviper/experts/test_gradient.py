"""Trees that a team learns by reward (tests/benchmarks/gradient.py): the profile decides as the actors in training."""

import numpy as np
import pytest

from codegen import ir
from codegen.lowering.deploy import deploy_tree
from maviper.worlds import find

pytestmark = pytest.mark.train
torch = pytest.importorskip("torch")
gradient = pytest.importorskip("tests.benchmarks.gradient")


def test_a_profile_decides_as_the_actor_does_on_thresholds_too():
    generator, rng = torch.Generator().manual_seed(3), np.random.default_rng(3)
    actor = gradient.Trees(3, [4, 2], 5, generator)
    x = rng.normal(size=(2, 400, 4)).astype(np.float32)
    x[1, :, 2:] = 0.0
    thresholds = actor.read()[1].detach().numpy()
    x[:, :200, :2] = rng.choice(thresholds.ravel(), (2, 200, 2))
    logits = actor(torch.from_numpy(x)).detach().numpy()
    for agent, tree in enumerate(actor.grown([5, 3])):
        policy = deploy_tree(tree)
        wanted = np.argmax(logits[agent, :, : (5, 3)[agent]], axis=1)
        assert set(tree.feature[tree.feature >= 0]) <= set(range((4, 2)[agent]))
        assert (decided(policy, x[agent]) == wanted).all() and len(set(wanted)) > 1


def decided(tree, rows):
    """What a tree says of each row, walked node by node."""
    actions = []
    for row in rows:
        node = ir.ROOT
        while tree.feature[node] >= 0:
            left = row[tree.feature[node]] <= tree.threshold[node]
            node = int((tree.left if left else tree.right)[node])
        actions.append(int(tree.action[node]))
    return np.array(actions)


def test_two_equal_leaves_are_one_and_others_stay():
    tree = gradient.tree_of([0, 1, 1], [0.0, 0.5, -0.5], [2, 2, 1, 2])
    assert tree.feature.tolist() == [0, -1, 1, -1, -1] and tree.action.tolist() == [-1, 2, -1, 1, 2]
    assert gradient.tree_of([0], [0.0], [4, 4]).action.tolist() == [4]


def test_tests_and_leaves_all_get_a_gradient():
    actor = gradient.Trees(2, [3], 4, torch.Generator().manual_seed(0))
    x = torch.rand(1, 500, 3, generator=torch.Generator().manual_seed(1)) * 2 - 1
    loss = -actor(x).log_softmax(dim=2)[0, :, 1].mean()
    assert all(part.abs().sum() > 0 for part in torch.autograd.grad(loss, actor.parameters))


def test_a_short_training_gives_the_same_trees_again():
    world, given = find("physical-deception"), {"steps": 12_800, "games": 128}
    one, two = (gradient.trained(world, 2, 5, given) for _ in range(2))
    for ours, theirs in zip(one.agents, two.agents, strict=True):
        assert (ours.tree.threshold == theirs.tree.threshold).all() and len(ours.tree.feature) <= 7
    assert one.provenance.training["steps"] == 12_800
