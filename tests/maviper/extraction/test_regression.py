"""Leaves that give numbers: constants as scikit-learn has them, sums as a plain ridge has them; whole extractions."""

import numpy as np
import pytest
from sklearn.tree import DecisionTreeRegressor

from codegen import ir, policy_json, profiles
from codegen.errors import InputError
from codegen.ir import OutputSpec
from codegen.lowering.deploy import SummedTree, deploy_tree
from maviper.cli import main
from maviper.episodes.trees import agent_policies
from maviper.evaluation import held_out
from maviper.experts.finding import find_expert
from maviper.extraction.algorithms import extract
from maviper.extraction.growth import best_first
from maviper.extraction.growth.best_first import RIDGE, ConstantLeaves, LinearLeaves, grow_tree
from maviper.extraction.growth.joint import Bins
from maviper.extraction.journal import Journal, pack_trees, unpack_trees
from maviper.extraction.settings import Settings

SPANS = (OutputSpec("one", "N", -4.0, 4.0), OutputSpec("two", "N", 0.0, 1.0))
EXPERT = "tests.support.steering:pulling"


def points(seed=0, n=500):
    rng = np.random.default_rng(seed)
    obs = rng.normal(size=(n, 3)).astype(np.float32)
    one = np.where(obs[:, 0] > 0, 2 * obs[:, 1], -1) + 0.1 * rng.normal(size=n)
    two = 1 / (1 + np.exp(-obs[:, 2]))
    return obs, np.clip(np.column_stack([one, two]), [-4, 0], [4, 1]).astype(np.float32), rng.integers(1, 4, size=n)


def values(tree, obs):
    """By the sums of the grown tree, before they are clipped."""
    leaf = tree.action[ir.apply(tree, obs)]
    wide = np.column_stack([obs.astype(np.float64), np.ones(len(obs))])
    return np.einsum("nok,nk->no", tree.given[leaf], wide)


@pytest.mark.parametrize("leaves", [2, 5, 16])
def test_constants_are_those_of_scikit_learn(leaves):
    obs, labels, counts = points(leaves)
    bins = Bins.of(obs, len(obs) + 1)
    ours = grow_tree(ConstantLeaves(obs, labels, SPANS), counts, bins.codes(obs), bins, 30, leaves)
    scale = np.array([8.0, 1.0])
    theirs = DecisionTreeRegressor(max_leaf_nodes=leaves, random_state=0).fit(obs, labels / scale, counts)
    assert len(ours.given) == theirs.get_n_leaves() == leaves
    assert np.allclose(values(ours, obs), theirs.predict(obs) * scale, atol=1e-6)


def test_linear_leaves_are_ridge_regressions_of_their_points():
    obs, labels, counts = points(1)
    bins = Bins.of(obs)
    wide = (OutputSpec("one", "N", -9.0, 9.0), OutputSpec("two", "N", -1.0, 2.0))  # no label is at a bound
    tree = grow_tree(LinearLeaves(obs, labels, wide), counts, bins.codes(obs), bins, 6, 4)
    assert len(tree.given) == 4 and tree.feature[0] == 0 and abs(tree.threshold[0]) < 0.1
    scaled = (obs - obs.mean(axis=0)) / obs.std(axis=0)
    leaf = tree.action[ir.apply(tree, obs)]
    for place in range(4):
        rows = leaf == place
        x, y, w = np.column_stack([scaled[rows], np.ones(rows.sum())]), labels[rows], counts[rows]
        ridge = RIDGE * w.sum() * np.diag([1.0, 1.0, 1.0, 0.0])
        wanted = x @ np.linalg.solve((x.T * w) @ x + ridge, (x.T * w) @ y)
        assert np.allclose(values(tree, obs[rows]), wanted, atol=1e-5)
    right = obs[:, 0] > 0.1  # where the first output is twice the second feature, and noise
    assert np.abs(values(tree, obs)[right, 0] - 2 * obs[right, 1]).mean() < 0.15


def test_numbers_beyond_a_bound_are_as_good_as_the_bound():
    """A steep line that is cut at both ends is learned as it is, where a plain regression would flatten it."""
    rng = np.random.default_rng(4)
    obs = rng.uniform(-2, 2, (800, 3)).astype(np.float32)
    labels = np.clip(np.column_stack([12 * obs[:, 0] - 4 * obs[:, 1], 0.5 + obs[:, 2]]), [-4, 0], [4, 1])
    leaves = LinearLeaves(obs, labels.astype(np.float32), SPANS)
    given = leaves.fit_leaf(np.arange(800), np.ones(800, np.int64))
    assert leaves.off(given).mean() < 1e-3
    assert abs(given[0, 0] - 12) < 1.5 and abs(given[1, 2] - 1) < 0.1
    plain = np.linalg.lstsq(np.column_stack([obs, np.ones(800)]), labels, rcond=None)[0].T
    assert leaves.off(plain).mean() > 0.01


def test_a_tree_of_numbers_gives_the_same_when_deployed_and_when_written():
    obs, labels, counts = points(2)
    wide = np.column_stack([obs.astype(np.float64), obs[:, 0].astype(np.float64) - obs[:, 2]])
    bins = Bins.of(wide)
    plain = grow_tree(LinearLeaves(obs, labels, SPANS), counts, bins.codes(wide), bins, 6, 8)
    tree = best_first.testing(plain, [(0, 2)], 3)
    assert isinstance(tree, SummedTree)
    kept = unpack_trees(pack_trees([tree]))[0]
    assert isinstance(kept, SummedTree) and np.array_equal(kept.given, tree.given)
    features = tuple(ir.FeatureSpec(name, "m", -9, 9, None) for name in "abc")
    policy = ir.AgentPolicy("agent", "team", features, (), deploy_tree(kept), outputs=SPANS)
    found = ir.outputs(policy, obs)
    assert np.allclose(found, np.clip(values(tree, obs), [-4, 0], [4, 1]), atol=1e-6)
    assert len(tree.tests) == 0 or tree.tests[0].tolist() == [1, 0, -1]


@pytest.fixture(autouse=True)
def _few(monkeypatch):
    monkeypatch.setattr(held_out, "EVALUATION_EPISODES", 8)


FEW = {"iterations": 3, "rollouts": 12, "selection_episodes": 4, "max_leaves": 6, "max_depth": 6}


def test_extraction_ends_with_a_profile_of_numbers_and_goes_on_to_the_same(tmp_path):
    expert, world = find_expert(EXPERT, giving=True)
    settings = Settings.of({**FEW, "leaf": "linear", "splits": "differences"}, world)
    profile = extract(world, expert, settings, journal=Journal(tmp_path))
    again = extract(world, expert, settings, journal=Journal(tmp_path))
    assert policy_json.dumps(profile) == policy_json.dumps(again)
    assert policy_json.dumps(profiles.loads(policy_json.dumps(profile))) == policy_json.dumps(profile)
    reached = profile.provenance.evaluation
    assert float(reached["tug return"]) > 1.25 * float(reached["tug expert return"])  # both are negative
    light = profile.policy("tug_1")
    assert [each.name for each in light.outputs] == ["output_0", "output_1"]
    # the light depends on which side of the goal a tug is, which one difference tells
    assert light.tree.feature[0] == 2 and light.tree.sums[0].terms == ((1.0, 0), (-1.0, 1))
    assert profile.provenance.training["weights"] == "equal" and profile.provenance.training["leaf"] == "linear"
    world.close()


def test_a_tree_of_differences_decides_as_its_deployed_form():
    _, world = find_expert("cooperative-navigation,agents=2")
    rng = np.random.default_rng(3)
    n = len(world.features[0])
    tests = np.zeros((1, n))
    tests[0, :2] = 1, -1
    tree = SummedTree(
        np.array([n, -1, -1]), np.array([0.25, 0, 0]), np.array([1, -1, -1]), np.array([2, -1, -1]),
        np.array([-1, 3, 4]), tests, np.zeros((0, 0, n + 1)),
    )  # fmt: skip
    (policy,) = agent_policies(world, [tree], [0])
    obs = rng.normal(size=(200, n)).astype(np.float32)
    obs[0, :2] = 0.5, 0.25
    assert np.array_equal(ir.act(policy, obs), np.where(obs[:, 0].astype(float) - obs[:, 1] <= 0.25, 3, 4))


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        ({"algorithm": "fitted-q"}, "--algorithm cannot be used with continuous actions"),
        ({"algorithm": "rgmdt"}, "--algorithm"),
        ({"preset": "released", "algorithm": "imitation"}, "released"),
        ({"weights": "own"}, "--set weights"),
        ({"least_right": "N"}, "--set least_right"),
        ({"refinement": 500}, "--refinement-episodes"),
        ({"share": "team"}, "tug_0 and tug_1 cannot share a tree"),
    ],
)
def test_what_needs_numbered_actions_is_refused(asked, said):
    expert, world = find_expert(EXPERT, giving=True)
    with pytest.raises(InputError, match=said):
        extract(world, expert, Settings.of(asked, world))


def test_the_command_extracts_evaluates_and_compiles_them(tmp_path, capsys, few_observations):
    few = ["--iterations", "2", "--rollouts", "4", "--set", "selection_episodes=2", "--max-leaves", "3"]
    few += ["--leaves", "linear"]
    file = str(tmp_path / "tugs.json")
    assert main.run(["extract", EXPERT, *few, "-o", file]) == 0
    asked = ["evaluate", file, "--world", "tests.support.steering:tugs", "--expert", EXPERT, "--episodes", "6"]
    assert main.run(asked) == 0
    told = capsys.readouterr().out
    assert "numbers" in told and "fidelity" in told
    assert main.run(["show", file]) == 0 and "speed = " in capsys.readouterr().out
    assert main.run(["compile", file, "--target", "python", "-o", str(tmp_path / "code")]) == 0
    assert main.run(["extract", "cooperative-navigation", "--leaves", "linear", "-o", file]) == 2
    assert "these are numbered" in capsys.readouterr().err
