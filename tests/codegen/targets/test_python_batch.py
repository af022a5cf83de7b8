"""The batch function of the Python module: any number of rows, in any layout, decide as the tree does."""

from dataclasses import replace
from itertools import product

import numpy as np
import pytest

from codegen import ir
from codegen.agreement import probes, readback
from codegen.dynamics import motionless
from codegen.floats import below_zero
from codegen.lowering.deploy import deploy_tree
from codegen.lowering.lower import lower
from codegen.lowering.model import TILED
from codegen.profiles import ensure
from codegen.targets import emit
from tests.support.chains import chain
from tests.support.games import random_tree

BLOCK, TILE = 65_536, 256  # rows of the emitted code


def specs(n_features):
    return tuple(ir.FeatureSpec(f"x{k}", "none", -1.0, 1.0, None) for k in range(n_features))


def full_tree(n_features, n_actions, depth, rng):
    return deploy_tree(random_tree(specs(n_features), n_actions, rng, depth))


def batch_of(tree, n_features, n_actions=5):
    """The policy of one agent, whether its columns are copied in tiles, and its batch function."""
    profile = profile_of(tree, n_features, n_actions)
    module = readback.load_python(emit(profile, ["python"])["synthetic.py"])
    return profile.agents[0], lower(profile).agents[0].tiled, module["act_agent_0_batch"]


def profile_of(tree, n_features, n_actions=5):
    actions = tuple(ir.ActionSpec(f"a{k}", None) for k in range(n_actions))
    policy = ir.AgentPolicy("agent_0", "team", specs(n_features), actions, tree)
    world = motionless("synthetic", "", ["agent_0"], 1, {})
    return ensure(ir.PolicyProfile(world, (policy,), ir.Provenance("test", "none", 0, "", "test")))


WALKING = 7  # levels
COPIED = [0, 1, TILE - 1, TILE, TILE + 1, BLOCK, BLOCK + 3 * TILE + 5]


@pytest.mark.parametrize(
    ("n_features", "levels", "rows"),
    [
        *product([TILED - 1, TILED, 18], [5], COPIED),
        *product([18], [WALKING], [0, 1, 8_192, 8_193, 20_000]),
    ],
)
def test_any_number_of_rows(n_features, levels, rows):
    rng = np.random.default_rng(rows)
    policy, tiled, batch = batch_of(full_tree(n_features, 5, levels, rng), n_features)
    assert tiled == (n_features >= TILED and levels != WALKING)
    x = rng.uniform(-1, 1, (rows, n_features)).astype(np.float32)
    x = np.where(rng.random(x.shape) < 0.3, rng.choice(probes.SPECIAL["float32"], x.shape), x)
    found = batch(x)
    assert found.dtype == np.int64
    np.testing.assert_array_equal(found, ir.act(policy, x))


@pytest.mark.parametrize("numbers", ["float32", "float64"])
def test_a_walk_meets_every_threshold(numbers):
    rng = np.random.default_rng(6)
    tree = full_tree(3, 5, 7, rng)
    tree = replace(tree, threshold=tree.threshold.astype(numbers))
    policy, _, batch = batch_of(tree, 3)
    x = np.repeat(tree.threshold[tree.feature >= 0], 3).reshape(-1, 3)
    near = np.concatenate([x, np.nextafter(x, np.inf, dtype=numbers), np.nextafter(x, -np.inf, dtype=numbers)])
    np.testing.assert_array_equal(batch(near), ir.act(policy, near))


def test_what_asks_below_zero_does_not_walk():
    tree = full_tree(3, 5, 7, np.random.default_rng(7))
    threshold = tree.threshold.copy()
    threshold[ir.ROOT] = below_zero("float32")
    for each, walks in ((tree, True), (replace(tree, threshold=threshold), False)):
        assert lower(profile_of(each, 3)).agents[0].walks == walks


@pytest.mark.parametrize(("n_features", "depth"), [(TILED - 1, 5), (18, 5), (18, 7)])
def test_any_layout(n_features, depth):
    rng = np.random.default_rng(3)
    policy, _, batch = batch_of(full_tree(n_features, 5, depth, rng), n_features)
    x = rng.uniform(-1, 1, (1_000, n_features)).astype(np.float32)
    wide = np.zeros((2_000, 2 * n_features), dtype=np.float32)
    wide[::2, ::2] = x
    near = probes.doubles(policy.tree, policy.features, rng)
    for given in (np.asfortranarray(x), wide[::2, ::2], x[::-1], x.astype(np.float64), x[:300].tolist(), near):
        np.testing.assert_array_equal(batch(given), ir.act(policy, np.asarray(given, dtype=np.float32)))
    before = x.copy()
    batch(x)
    np.testing.assert_array_equal(x, before)


def test_more_actions_than_a_byte_holds():
    rng = np.random.default_rng(4)
    policy, _, batch = batch_of(full_tree(9, 700, 8, rng), 9, 700)
    x = rng.uniform(-1, 1, (5_000, 9)).astype(np.float32)
    np.testing.assert_array_equal(batch(x), ir.act(policy, x))
    assert batch(x).max() > 255


def test_the_deepest_tree():
    policy, _, batch = batch_of(chain(ir.MAX_DEPTH), 1)
    x = np.linspace(-1.1, 1.1, 3_000, dtype=np.float32)[:, None]
    np.testing.assert_array_equal(batch(x), ir.act(policy, x))
