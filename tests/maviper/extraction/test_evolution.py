"""Refinement of the numbers in trees: many of them at once, moves of their numbers, and runs that go on."""

from dataclasses import replace

import numpy as np
import pytest

from codegen import ir, policy_json, profiles
from codegen.deciding import size
from codegen.ir import NO_ACTION, NO_CHILD, NO_FEATURE, AgentPolicy, FeatureSpec, GrownTree, OutputSpec
from codegen.lowering.deploy import SummedTree, deploy_tree
from maviper.episodes.trees import agent_policies
from maviper.evaluation import held_out
from maviper.experts.finding import find_expert
from maviper.extraction import refine
from maviper.extraction.algorithms import extract
from maviper.extraction.arena import Arena, SummedStack, reaching
from maviper.extraction.extraction import Extraction
from maviper.extraction.growth.sums import with_own_sums
from maviper.extraction.journal import Journal
from maviper.extraction.refine import Moves
from maviper.extraction.settings import Settings
from maviper.worlds import World


def write_trees(world: World, brake: float = 0.2) -> list[GrownTree]:
    """Four leaves an agent: agent k steers along the longer axis to landmark k, less `brake` seconds of velocity."""
    left, right, down, up = range(1, 5)
    trees: list[GrownTree] = []
    for agent, features in enumerate(world.features):
        names = [feature.name for feature in features]
        tests = np.zeros((2, len(names)), np.float32)
        for axis, signs in (("x", (1.0, 1.0)), ("y", (1.0, -1.0))):
            tests[:, names.index(f"landmark_{agent}_d{axis}")] = signs
            tests[:, names.index(f"v{axis}")] = np.multiply(signs, -brake)
        feature = np.array([len(names), len(names) + 1, len(names) + 1, *[NO_FEATURE] * 4])
        action = np.array([NO_ACTION] * 3 + [left, down, up, right])
        one, other = np.array([1, 3, 5, *[NO_CHILD] * 4]), np.array([2, 4, 6, *[NO_CHILD] * 4])
        trees.append(SummedTree(feature, np.zeros(7), one, other, action, tests, np.zeros((0, 0, len(names) + 1))))
    return trees


EXPERT = "tests.support.steering:pulling"
SPANS = (OutputSpec("one", "N", -4.0, 4.0), OutputSpec("two", "N", None, 1.0))
FEATURES = tuple(FeatureSpec(f"feature_{k}", "none", -9, 9, None) for k in range(4))


def random_tree(rng):
    """A tree of up to seven leaves that may test three sums, and gives two."""
    feature, threshold, left, right, leaves = [-1], [0.0], [-1], [-1], [0]
    for _ in range(int(rng.integers(0, 7))):
        node = leaves.pop(int(rng.integers(len(leaves))))
        feature[node], threshold[node] = int(rng.integers(7)), float(rng.normal())
        left[node], right[node] = len(feature), len(feature) + 1
        leaves += [left[node], right[node]]
        feature, threshold = [*feature, -1, -1], [*threshold, 0.0, 0.0]
        left, right = [*left, -1, -1], [*right, -1, -1]
    action = np.full(len(feature), -1)
    action[leaves] = np.arange(len(leaves))
    tests = (rng.normal(size=(3, 4)) * (rng.random((3, 4)) < 0.6)).astype(np.float32)
    tests[:, 0] = 1
    given = rng.normal(size=(len(leaves), 2, 5)) * (rng.random((len(leaves), 2, 5)) < 0.6)
    return SummedTree(*map(np.array, (feature, threshold, left, right)), action, tests, given)


def observations(rng, n=200):
    obs = rng.normal(size=(n, 4)).astype(np.float32)
    for odd, share in ((-0.0, 0.1), (np.inf, 0.03), (np.nan, 0.03)):
        obs[rng.random(obs.shape) < share] = odd
    return obs


def policy_of(tree, outputs=SPANS):
    return AgentPolicy("one", "ones", FEATURES, (), deploy_tree(tree), outputs=outputs)


@pytest.mark.filterwarnings("ignore::RuntimeWarning")  # of infinities
@pytest.mark.parametrize("seed", range(4))
def test_a_stack_gives_the_bits_of_the_reference(seed):
    rng = np.random.default_rng(seed)
    policies, obs = [policy_of(random_tree(rng)) for _ in range(9)], observations(rng)
    which = np.arange(len(obs)) % len(policies)
    given = SummedStack.of(policies).act(which, obs)
    for place, policy in enumerate(policies):
        expected = ir.outputs(policy, obs[which == place])
        here = given[which == place]
        assert (np.isnan(expected) == np.isnan(here)).all()
        told = ~np.isnan(expected)
        assert (expected[told].view(np.uint32) == here[told].view(np.uint32)).all()


@pytest.mark.parametrize("seed", range(3))
def test_numbers_move_by_parts_of_ranges_and_a_tree_keeps_its_size(seed):
    rng = np.random.default_rng(seed)
    tree, obs = random_tree(rng), rng.normal(size=(500, 4)).astype(np.float32)
    given = np.where(tree.given == 0, 0.0, tree.given + 9)
    given[..., -1] = tree.given[..., -1] + 9  # no sum ends at 0
    tree = replace(tree, given=given)
    moves, policy = Moves.of(tree, obs, np.array([8.0, 1.0])), policy_of(tree)
    assert moves.size == len(tree.feature) + tree.given.size
    still = moves.apply(tree, np.zeros(moves.size))
    assert (still.given == tree.given).all() and (still.threshold == tree.threshold).all()
    direction = rng.standard_normal(moves.size)
    moved = moves.apply(tree, direction)
    assert size(policy_of(moved)) == size(policy)
    assert ((moved.given[..., :-1] == 0) == (tree.given[..., :-1] == 0)).all()
    split = tree.feature != ir.NO_FEATURE
    assert (moved.threshold[~split] == 0).all()
    leaf = tree.action[ir.apply(deploy_tree_nodes(tree), wide(tree, obs))]
    lined = np.column_stack([obs.astype(np.float64), np.ones(len(obs))])
    apart = np.einsum("nok,nk->no", (moved.given - tree.given)[leaf], lined)
    for vector in np.unique(leaf):
        far = np.sqrt(np.square(apart[leaf == vector]).mean(axis=0)) / np.array([8.0, 1.0])
        assert (far < 4 * refine.SPREAD).all() and (far > 0).all()
    unmet = np.setdiff1d(tree.action[~split], leaf)
    assert (moved.given[unmet] == tree.given[unmet]).all()


@pytest.mark.parametrize("seed", range(3))
def test_weights_of_sums_move_where_leaves_take_actions(seed):
    rng = np.random.default_rng(seed)
    tree, obs = replace(random_tree(rng), given=np.zeros((0, 0, 5))), rng.normal(size=(500, 4)).astype(np.float32)
    own, unit = with_own_sums(tree, 4), np.array([1.0, 100.0, 1.0, 1.0])  # units change what weights are worth
    assert len(own.tests) == (tree.feature >= 4).sum()
    moves, direction = Moves.of(own, obs, np.zeros(0)), rng.standard_normal(99)
    still = moves.apply(own, np.zeros(moves.size))
    assert (still.tests == own.tests).all() and (still.threshold == own.threshold).all()
    moved = moves.apply(own, direction[: moves.size])
    assert moved.tests.dtype == np.float32 and ((moved.tests == 0) == (own.tests == 0)).all()
    assert moved.tests.shape == own.tests.shape
    met = reaching(own, wide(own, obs))
    for node in np.flatnonzero(own.feature >= 4):
        before, after = own.tests[own.feature[node] - 4], moved.tests[own.feature[node] - 4]
        if node not in met:
            assert (before == after).all() and own.threshold[node] == moved.threshold[node]
            continue
        here = obs[met[node]].astype(np.float64)
        apart = here @ (after - before) - (moved.threshold[node] - own.threshold[node])
        assert 0 < np.sqrt(np.square(apart).mean()) < 5 * refine.TEST_SPREAD * (here @ before).std()
    threshold = np.where(own.feature == 1, unit[1] * own.threshold, own.threshold)
    scaled = replace(own, tests=(own.tests / unit).astype(np.float32), threshold=threshold)
    other = Moves.of(scaled, (obs * unit).astype(np.float32), np.zeros(0))
    assert np.allclose(other.tests * unit, moves.tests, rtol=0.05)  # rows at a threshold


def test_refinement_finds_weights_that_pay(monkeypatch):
    expert, world = find_expert("cooperative-navigation,agents=2@fixed-roles", critic="none")
    world = world.judge_by("D")
    wrong = [with_own_sums(tree, len(world.features[0])) for tree in write_trees(world, brake=-0.1)]
    arena, trees = Arena(world, expert, [0, 1], range(10**15, 10**15 + 10_000)), wrong
    monkeypatch.setattr(refine, "DRIFT", 1.0)
    for number in range(8):
        trees = refine.drift_tests(arena, trees, number / 8, np.random.default_rng(number))[0]
    assert arena.played == 8 * refine.drift_cost()
    kept, _ = refine.judge(arena, wrong, trees)
    assert kept is trees
    assert [size(one) for one in agent_policies(world, trees)] == [size(one) for one in agent_policies(world, wrong)]
    assert refine.judge(arena, trees, wrong)[0] is trees


def wide(tree, obs):
    return np.concatenate([obs, obs @ tree.tests.T], axis=1)


def deploy_tree_nodes(tree):
    """The tree over its sums as features, its nodes where they are."""
    return ir.GrownTree(tree.feature, tree.threshold, tree.left, tree.right, tree.action)


SMALL = {"iterations": 1, "rollouts": 4, "selection_episodes": 4, "max_leaves": 3, "max_depth": 4}


@pytest.fixture
def quick(monkeypatch):
    monkeypatch.setattr(held_out, "EVALUATION_EPISODES", 6)
    for name, value in (("PAIRS", 4), ("PLAYED", 3), ("RACED", 6), ("JUDGED", 16)):
        monkeypatch.setattr(refine, name, value)


def test_a_refined_run_goes_on_to_the_same_bytes(quick, tmp_path):
    expert, world = find_expert(EXPERT, giving=True)
    cost = 2 * refine.evolving_cost() + refine.judging_cost()
    settings = Settings.of({**SMALL, "refinement": cost + 1}, world)
    refined = policy_json.dumps(extract(world, expert, settings, journal=Journal(tmp_path)))
    steps = sorted(path.name for path in tmp_path.glob("refine-*"))
    assert steps == [f"refine-0-{number:04d}.safetensors" for number in range(3)]
    for step in steps[1:]:
        (tmp_path / step).unlink()
    assert policy_json.dumps(extract(world, expert, settings, journal=Journal(tmp_path))) == refined
    assert profiles.loads(refined).provenance.training["refinement_episodes"] == cost
    world.close()


def test_rounds_grow_with_the_episodes_and_never_cost_more():
    small, last = refine.evolving_cost(), refine.judging_cost()
    assert [refine.round_scale(40 * small * times) for times in (0, 1, 3, 4, 8, 9, 100)] == [1, 1, 1, 2, 2, 3, 10]
    for episodes in (last, last + small, 4_000, 60_000, 200_000, 3_000_000):
        scale = refine.round_scale(episodes)
        steps = refine.count_steps(episodes, refine.evolving_cost(scale))
        assert max(0, steps - 1) * refine.evolving_cost(scale) + (steps > 0) * last <= episodes


def test_refinement_finds_numbers_that_pay_and_keeps_no_others(quick, monkeypatch):
    expert, world = find_expert(EXPERT, giving=True)
    still, worse = ([_tree(len(outputs), value) for outputs in world.outputs] for value in (0.0, -1.0))
    asked = Extraction(world, expert, Settings(refinement=5 * refine.evolving_cost() + refine.judging_cost()))
    trees, facts = refine.refine_trees(asked, [0, 1], [[tree] for tree in still])
    assert facts["refinement_episodes"] == asked.settings.refinement
    arena = Arena(world, expert, [0, 1], range(10**15, 10**15 + 1_000))
    before, after = arena.scores([still, trees], 16).mean(axis=1)
    assert after > 0.9 * before  # both are negative
    assert [size(one) for one in agent_policies(world, trees)] == [size(one) for one in agent_policies(world, still)]
    assert refine.judge(arena, still, worse)[0] is still and refine.judge(arena, worse, still)[0] is still
    assert refine.judge(arena, still, still)[0] is still  # no gain, no error
    world.close()


def _tree(n_outputs, value):
    """On either side of a goal the same constants."""
    arrays = [np.array(each) for each in ([2, -1, -1], [0.0, 0, 0], [1, -1, -1], [2, -1, -1], [-1, 0, 1])]
    given = np.zeros((2, n_outputs, 3))
    given[..., -1] = value
    return SummedTree(*arrays, np.array([[1, -1]], np.float32), given)
