"""Extraction: the paper's formulas written out slowly, joint growth, rounding, repeatability."""

import functools
import math
import time
from collections.abc import Mapping
from dataclasses import astuple, dataclass, field, replace
from itertools import pairwise, product
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from sklearn.tree import DecisionTreeClassifier

from codegen import ir, policy_json
from codegen.agreement import probes, selfcheck
from codegen.intervals import Share
from codegen.lowering.deploy import deploy_tree
from codegen.profiles import check
from maviper.episodes import measures, trees
from maviper.episodes.measures import Mean
from maviper.episodes.play import TALLY, Policies, Tally, play, points, tree_policies
from maviper.episodes.trees import ON_POLICY_EPISODES
from maviper.evaluation.held_out import EVALUATION_EPISODES, Counting, read_measure
from maviper.experts import network
from maviper.experts.expert import AS_GIVEN, labels
from maviper.experts.scripted import Scripted, build_script
from maviper.extraction.algorithms import extract
from maviper.extraction.dataset import resample
from maviper.extraction.extraction import Extraction, Running, joint_ratio
from maviper.extraction.growth import exact
from maviper.extraction.growth.exact import CartTree
from maviper.extraction.growth.weights import maviper_weights
from maviper.extraction.journal import Underway
from maviper.extraction.selection import Selection, explain_stop
from maviper.extraction.settings import Settings
from maviper.worlds import Measure, WorldState, find
from maviper.worlds.outside.pettingzoo import PettingZooWorld
from tests.support.ends import Expert as LineExpert
from tests.support.ends import train_joint_trees
from tests.support.environments import Line


@pytest.fixture(scope="module")
def state(world):
    return world.start(12, np.random.default_rng(5))


@pytest.fixture(scope="module")
def observed(world, state):
    return world.observe(state)


def test_weights_are_the_papers_formula(world, expert, observed, state):
    """E over opponents' joint actions of [Q(expert's a_i) - min over a_i Q], team-mates at expert actions."""
    wanted = labels(expert, observed, state)
    found = maviper_weights(world, expert, observed, state, wanted)
    teams = [[0], [1, 2], [1, 2]]
    for agent, team in enumerate(teams):
        opponents = [other for other in range(3) if other not in team]
        for row in range(12):
            total = 0.0
            for opposing in product(range(5), repeat=len(opponents)):
                joint = wanted[row].copy()
                joint[opponents] = opposing
                q = []
                for own in range(5):
                    joint[agent] = own
                    one = [seen[row : row + 1] for seen in observed]
                    given = np.full((1, 3), AS_GIVEN)  # every action is asked for by name
                    q.append(expert.q(agent, one, state[row : row + 1], joint[None], given)[0, 0])
                total += q[wanted[row, agent]] - min(q)
            assert found[row, agent] == pytest.approx(total / 5 ** len(opponents), rel=1e-9)
    assert (found >= 0).all()


def test_points_are_the_states_that_were_acted_on(world, expert):
    """Row by row: an observation, the state that it shows, and the action that was taken there."""
    episodes = play(world, [expert] * 3, world.start_from_seeds(range(7)))
    observations, state = points(episodes)
    assert len(state) == 7 * world.spec.episode_steps
    for seen, again in zip(observations, world.observe(state), strict=True):
        assert seen.tobytes() == again.tobytes()
    assert (labels(expert, observations, state) == episodes.actions.reshape(-1, 3)).all()
    first = WorldState.concatenate([state[:7]])
    assert first.position.tobytes() == world.start_from_seeds(range(7)).position.tobytes()


def test_resampling_draws_with_replacement_by_weight():
    rng = np.random.default_rng(0)
    weights = np.array([0.0, 1.0, 3.0])
    counts = sum(resample(weights, np.ones(3, bool), 300_000, rng) for _ in range(4_000))
    assert counts[0] == 0 and counts.sum() == 12_000
    assert counts[2] / counts.sum() == pytest.approx(0.75, abs=0.02)
    assert resample(np.zeros(4), np.ones(4, bool), 300_000, rng).sum() == 4  # all weights zero: uniform
    assert resample(np.ones(50), np.ones(50, bool), 20, rng).sum() == 20


def slow_joint_trees(observations, labels, counts, n_actions, max_depth, seeds):
    """TrainJointTrees in plain loops over points, as the text has it; scikit-learn fits to the same points once."""
    n_agents, n = len(observations), len(labels)
    trees = [{0: None} for _ in range(n_agents)]  # node -> None (leaf) or (feature, threshold, left, right)
    action = [{} for _ in range(n_agents)]

    def leaf_of(agent, point):
        node = 0
        while trees[agent][node] is not None:
            feature, threshold, left, right = trees[agent][node]
            node = left if np.float64(observations[agent][point, feature]) <= threshold else right
        return node

    @functools.cache
    def fit(agent, points, depth):
        tree, points = DecisionTreeClassifier(max_depth=depth, random_state=seeds[agent]), list(points)
        return tree.fit(observations[agent][points], labels[points, agent], sample_weight=counts[agent][points])

    def majority(agent, points):
        return int(np.argmax(np.bincount(labels[points, agent], counts[agent][points], n_actions[agent])))

    closed = [set() for _ in range(n_agents)]
    for agent in range(n_agents):
        action[agent][0] = majority(agent, [p for p in range(n) if counts[agent][p]])
    level_of = [{0: 0} for _ in range(n_agents)]
    for level in range(max_depth):
        for agent in range(n_agents):
            grown = [{point: leaf_of(j, point) for point in range(n)} for j in range(n_agents)]

            def predict(j, point, grown=grown):
                leaf = grown[j][point]
                members = [p for p in range(n) if grown[j][p] == leaf and counts[j][p]]
                remaining = max_depth - level_of[j][leaf]
                if leaf in closed[j] or not members or not remaining:
                    return action[j][leaf]
                return fit(j, tuple(members), remaining).predict(observations[j][[point]])[0]

            right = np.array([[predict(j, p) == labels[p, j] for j in range(n_agents)] for p in range(n)])
            keep = right.sum(axis=1) >= n_agents - 1
            for leaf in [node for node, split in trees[agent].items() if split is None]:
                if leaf in closed[agent] or level_of[agent][leaf] != level:
                    continue
                members = [p for p in range(n) if grown[agent][p] == leaf and counts[agent][p]]
                kept = [p for p in members if keep[p]] or members
                if not kept:
                    continue
                action[agent][leaf] = majority(agent, kept)
                stump = fit(agent, tuple(kept), 1).tree_
                if stump.node_count == 1:
                    closed[agent].add(leaf)
                    continue
                feature, threshold = int(stump.feature[0]), stump.threshold[0]
                new = max(trees[agent]) + 1
                trees[agent][leaf] = (feature, threshold, new, new + 1)
                sides = [[], []]
                for p in kept:
                    sides[0 if np.float64(observations[agent][p, feature]) <= threshold else 1].append(p)
                for side, node in enumerate((new, new + 1)):
                    trees[agent][node] = None
                    level_of[agent][node] = level + 1
                    action[agent][node] = majority(agent, sides[side])
    return trees, action


@pytest.mark.parametrize("seed", range(16))
def test_joint_growth_is_the_papers_loop(seed):
    """Caches and vectorised votes change nothing against the loop over points."""
    rng = np.random.default_rng(seed)
    n = 60 if seed < 3 else 25
    observations = [rng.normal(size=(n, 4)).astype(np.float32) for _ in range(2)]
    wanted = np.stack([(obs[:, 0] > 0).astype(int) + 2 * (obs[:, 1] > 0.3) for obs in observations], axis=1)
    noise = rng.random(wanted.shape) < 0.2
    wanted = np.where(noise, rng.integers(4, size=wanted.shape), wanted)
    counts = [rng.integers(0, 3, size=n) for _ in range(2)]
    depth = 2 + seed % 2
    found = train_joint_trees(observations, wanted, counts, [4, 4], depth, [7, 8])
    trees, action = slow_joint_trees(observations, wanted, counts, [4, 4], depth, [7, 8])
    for tree, nodes, actions in zip(found, trees, action, strict=True):
        assert len(tree.feature) == len(nodes)
        for node, split in nodes.items():
            if split is None:
                assert tree.feature[node] == ir.NO_FEATURE and tree.action[node] == actions[node]
            else:
                given = (tree.feature[node], tree.threshold[node], tree.left[node], tree.right[node])
                assert given == split


@pytest.mark.smoke
def test_joint_growth_differs_from_growth_alone():
    rng = np.random.default_rng(0)
    observations = [rng.normal(size=(300, 3)).astype(np.float32) for _ in range(2)]
    wanted = rng.integers(3, size=(300, 2))
    counts = [np.ones(300, dtype=int)] * 2
    joint = train_joint_trees(observations, wanted, counts, [3, 3], 3, [0, 1])
    alone = [train_joint_trees([observations[k]], wanted[:, [k]], [counts[k]], [3], 3, [k])[0] for k in range(2)]
    assert any(a.threshold.tobytes() != b.threshold.tobytes() for a, b in zip(joint, alone, strict=True))


def test_a_team_of_one_grows_a_plain_cart():
    """Without team-mates nothing is filtered: level by level growth is scikit-learn's tree of that depth."""
    rng = np.random.default_rng(3)
    obs = rng.normal(size=(400, 4)).astype(np.float32)
    wanted = (obs[:, 0] * obs[:, 1] > 0).astype(int) + (obs[:, 2] > 0.5)
    tree = train_joint_trees([obs], wanted[:, None], [np.ones(400, dtype=int)], [3], 4, [0])[0]
    cart = DecisionTreeClassifier(max_depth=4, random_state=0).fit(obs, wanted)
    assert (tree.action[ir.apply(tree, obs)] == cart.predict(obs)).mean() > 0.97  # ties may fall differently


def from_scikit_learn(cart):
    tree = cart.tree_
    leaf = tree.children_left == -1
    action = np.where(leaf, cart.classes_[tree.value[:, 0].argmax(axis=1)], ir.NO_ACTION)
    feature = np.where(leaf, ir.NO_FEATURE, tree.feature)
    return ir.GrownTree(feature, np.where(leaf, 0, tree.threshold), tree.children_left, tree.children_right, action)


@pytest.mark.parametrize("depth", [1, 2, 4, 6, 10])
def test_deployed_trees_decide_as_scikit_learn_on_all_boundaries(world, depth):
    """scikit-learn's own predict, on 100,000 observations and every threshold with its neighbours."""
    rng = np.random.default_rng(depth)
    features = world.features[1]
    # coarse values make thresholds that are midpoints of float32 numbers, where rounding matters
    obs = (rng.integers(-40, 40, (3_000, 10)) / np.float32(7)).astype(np.float32)
    cart = DecisionTreeClassifier(max_depth=depth, random_state=0).fit(obs, rng.integers(5, size=3_000))
    grown = from_scikit_learn(cart)
    policy = ir.AgentPolicy("agent_0", "defenders", features, world.actions[1], deploy_tree(grown), grown)
    rows = np.concatenate([probes.boundary(grown, features, rng), probes.random(features, 100_000, rng)])
    assert (ir.act(policy, rows) == cart.predict(rows)).all()
    assert selfcheck.check_grown(policy, rows).differences == 0


def test_the_numpy_trap_is_avoided():
    """A float32 column compared with a Python float is compared in float32; growth must compare in float64."""
    obs = np.array([[0.1], [0.2], [0.1], [0.2]], dtype=np.float32)
    member = CartTree(obs, np.array([0, 1, 0, 1]), np.ones(4, dtype=int), 2, 1, 0)
    member.build(np.ones(4, dtype=bool))
    tree = member.tree()
    assert tree.action[ir.apply(tree, obs)].tolist() == [0, 1, 0, 1]


def columns_of_all_kinds(rng, n):
    """Observations [n, 1 to 6]: of few values, constant, nearly alike, and such as cut points as another one does."""
    columns = rng.normal(size=(n, int(rng.integers(1, 7))))
    for place, kind in enumerate(rng.integers(6, size=columns.shape[1])):
        before, own = columns[:, place - 1], columns[:, place]
        kinds = [np.round(own * 2) / 2, np.full(n, 0.5), 0.25 + np.round(own * 3) * 4e-8, before * 2, -before, own]
        columns[:, place] = kinds[kind]
    return columns.astype(np.float32)


@pytest.mark.parametrize("seed", range(25))
def test_splits_that_are_searched_at_once_are_those_of_scikit_learn(seed, monkeypatch):
    """Teams whose leaves are all large enough, and those whose leaves are all too small, for which CART is asked."""
    rng = np.random.default_rng(seed)
    n, n_actions, depth, members = (int(rng.integers(*ends)) for ends in ((5, 600), (2, 6), (1, 6), (1, 4)))
    team = [columns_of_all_kinds(rng, n) for _ in range(members)]
    rules = [(obs[:, 0] > 0) + 2 * (obs[:, -1] > 0.3) + (rng.random(n) < 0.1) for obs in team]
    wanted, counts = np.stack(rules, axis=1) % n_actions, [rng.multinomial(n, np.full(n, 1 / n)) for _ in team]
    grown, asked, cart = [], [], exact.cart

    def ask(*given):
        asked.append(given)
        return cart(*given)

    monkeypatch.setattr(exact, "cart", ask)
    for few in (0, n + 1):
        monkeypatch.setattr(exact, "FEW", few)
        grown.append(train_joint_trees(team, wanted, counts, [n_actions] * members, depth, range(members)))
        asked.append(None)
    assert asked.index(None) < len(asked) - asked.index(None)  # CART was asked less
    for one, other in zip(*grown, strict=True):
        assert all(np.array_equal(*parts) for parts in zip(astuple(one), astuple(other), strict=True))


def test_same_seed_same_bytes_other_seed_other_trees(world, expert, profile):
    settings = Settings(max_depth=3, iterations=4, rollouts=30, selection_episodes=30)
    again = extract(world, expert, settings)
    assert policy_json.dumps(again) == policy_json.dumps(profile)
    other = extract(world, expert, Settings(max_depth=3, iterations=2, rollouts=30, selection_episodes=30, seed=1))
    assert policy_json.content_hash(other) != policy_json.content_hash(profile)


@pytest.mark.smoke
def test_provenance_names_the_expert_and_what_was_measured(profile, expert):
    provenance = profile.provenance
    assert provenance.expert == expert.hash and provenance.preset == "paper"
    assert provenance.training["iterations"] == 4
    assert 0 <= provenance.evaluation["defenders success r=0.316"] <= 1


def primaries(world, *values):
    return {world.primary(team): value for team, value in zip(world.teams, values, strict=True)}


def test_the_score_is_the_mean_ratio_over_teams(world):
    ours, theirs = (primaries(world, Share(hits, 100), Share(50, 100)) for hits in (30, 60))
    assert joint_ratio(world, ours, theirs)[0] == pytest.approx(0.75)
    nothing = primaries(world, Share(0, 100), Share(50, 100))
    score, half_width = joint_ratio(world, ours, nothing)
    assert np.isfinite(score) and np.isfinite(half_width)
    low, high = Share(50, 100).interval
    one = primaries(world, Share(100, 100), Share(50, 100))
    ends = Share(100, 100).interval
    wanted = np.hypot((ends[1] - ends[0]) / 2, (high - low) / 2 / 0.5) / 2  # of (a / 1 + b / 0.5) / 2
    assert joint_ratio(world, one, one)[1] == pytest.approx(wanted)


def test_where_lower_is_better_the_score_is_the_inverse():
    world = find("predator-prey")  # touches: predators want many, prey few
    ours, theirs = primaries(world, Mean(2, 0.1, 100), Mean(4, 0.4, 100)), primaries(world, *[Mean(1, 0.1, 100)] * 2)
    score, half_width = joint_ratio(world, ours, theirs)
    assert score == pytest.approx((2 / 1 + 1 / 4) / 2)
    # the interval of 1 / x has the width of x's over x squared
    assert half_width == pytest.approx(np.hypot(0.1 / 1, 0.4 * 1 / 4**2) / 2)
    better = primaries(world, Mean(2, 0.1, 100), Mean(0.5, 0.1, 100))
    assert joint_ratio(world, better, theirs)[0] == pytest.approx((2 + 2) / 2)
    never = primaries(world, Mean(2, 0.1, 100), Mean(0, 0, 100))  # touched in no episode: as if once in all of them
    assert joint_ratio(world, never, theirs)[0] == pytest.approx((2 + 100) / 2)
    assert np.isfinite(joint_ratio(world, never, never)).all()
    assert [measures.ratio(measure, 2, 4) for measure in theirs] == [0.5, 2]
    assert [measures.ratio(measure, 0, 4) for measure in theirs] == [0, None]
    assert [measures.ratio(measure, 2, 0) for measure in theirs] == [None, 0]


def test_a_negative_return_is_no_divisor():
    """As for a positive one, more is better, and a gain as large as the expert's return adds 1."""
    measure = Measure("all", "return")
    world = SimpleNamespace(teams={"all": ("a",)}, primary=lambda team: measure)
    for theirs, ours, wanted in ((-10, -5, 1.5), (-10, -10, 1), (-10, -25, -0.5), (-10, 10, 3), (10, 5, 0.5)):
        score, half_width = joint_ratio(world, {measure: Mean(ours, 2, 100)}, {measure: Mean(theirs, 1, 100)})
        assert score == pytest.approx(wanted) == measures.ratio(measure, ours, theirs)
        assert half_width == pytest.approx(0.2)
    assert measures.ratio(measure, -5, 0) is None
    assert np.isfinite(joint_ratio(world, {measure: Mean(-5, 2, 100)}, {measure: Mean(0, 0, 100)})).all()


class Recorder:
    """Stands in for parts of the outer loop and writes down what it is asked."""

    def __init__(self, monkeypatch, scores):
        from maviper.extraction import dagger as module

        self.scores, self.played, self.counts, self.sizes, self.opponents = list(scores), [], [], [], []
        self.grown, self.trees, self.seeds = [], {}, []
        collect, grow_teams, resample = module.collect, module.grow_teams, module.resample
        tree_policies, team_values = trees.tree_policies, measures.team_values

        def record_rollouts(world, expert, controllers, agents, seeds, *rest):
            self.played.append((controllers, list(seeds)))
            return collect(world, expert, controllers, agents, seeds, *rest)

        def record_resampling(weights, alive, most, rng):
            self.counts.append(resample(weights, alive, most, rng))
            return self.counts[-1]

        def record_growth(world, data, *rest):
            self.sizes.append(len(data))
            found = grow_teams(world, data, *rest)
            self.grown.append(found[0])
            return found

        def record_trees(policies):
            controller = tree_policies(policies)
            self.trees[id(controller)] = controller, policies
            return controller

        def scripted_values(world, ours, opponents, seeds, *teams):
            self.opponents.append((ours, opponents, list(seeds)))
            found = team_values(world, ours, opponents, seeds, *teams)
            if len(seeds) != 10:
                return found  # the final evaluation
            hits = self.scores[len(self.opponents) - 1]
            return dict.fromkeys(found, np.repeat([1.0, 0.0], [hits, 100 - hits]))

        monkeypatch.setattr(module, "collect", record_rollouts)
        monkeypatch.setattr(module, "resample", record_resampling)
        monkeypatch.setattr(module, "grow_teams", record_growth)
        monkeypatch.setattr(trees, "tree_policies", record_trees)
        monkeypatch.setattr(measures, "team_values", scripted_values)

    def trees_of(self, controllers):
        """The tree policies that a list of controllers, one per agent, plays."""
        found = []
        for agent, controller in enumerate(controllers):
            counting = isinstance(controller, Counting)
            found.append((controller.policies if counting else self.trees[id(controller)][1])[agent])
        return found


def small(**settings):
    return Settings(max_depth=2, rollouts=4, selection_episodes=10, **settings)


def same_trees(policies, grown):
    return all(
        policy.grown.threshold.tobytes() == tree.threshold.tobytes()
        for policy, tree in zip(policies, grown, strict=True)
    )


@pytest.mark.parametrize("best", [0, 1, 3])
def test_the_outer_loop_is_the_algorithm(world, expert, monkeypatch, best):
    """Experts play first, then the last trees; data aggregate; each agent has its own D_i; the best iterate returns."""
    scores = [10, 20, 15, 12]
    scores[best] = 90
    recorder = Recorder(monkeypatch, scores)
    found = extract(world, expert, small(iterations=4))
    assert found.provenance.training["best_iteration"] == best + 1
    assert same_trees(found.agents, recorder.grown[best])
    assert not same_trees(found.agents, recorder.grown[(best + 1) % 4])
    assert recorder.sizes == [100, 200, 300, 400]  # 4 episodes of 25 steps more each time
    policies = [policies for policies, _ in recorder.played]
    assert all(controller is expert for controller in policies[0]) and len(policies[0]) == 3
    for played, grown in zip(policies[1:], recorder.grown, strict=False):
        assert same_trees(recorder.trees_of(played), grown)
    seeds = [set(seeds) for _, seeds in recorder.played]
    assert all(not a & b for k, a in enumerate(seeds) for b in seeds[k + 1 :])
    drawn = recorder.counts
    assert len(drawn) == 12 and all((a != b).any() for a, b in zip(drawn[1::3], drawn[2::3], strict=True)), "shared"
    assert len(recorder.opponents) == 5  # four candidates, and the winner on held-out episodes
    for (ours, opponents, selection), grown in zip(
        recorder.opponents, [*recorder.grown, recorder.grown[best]], strict=True
    ):
        assert all(controller is expert for controller in opponents)
        assert same_trees(recorder.trees_of(ours), grown)
        assert not set(selection) & set().union(*seeds)
    selections = [selection for _, _, selection in recorder.opponents]
    assert selections[0] == selections[1] == selections[2] == selections[3], "candidates meet different episodes"
    assert not set(selections[4]) & set(selections[0])


@pytest.mark.parametrize(("patience", "stopped"), [(1, 2), (2, 3), (3, 4), (10, 6)])
def test_stopping_needs_a_gain_above_the_interval(world, expert, monkeypatch, patience, stopped):
    Recorder(monkeypatch, [50, 51, 52, 51, 50, 50])  # one more of 100 is no gain
    found = extract(world, expert, small(iterations=6, patience=patience))
    assert found.provenance.training["stopped_after"] == stopped


@pytest.mark.parametrize(("enough", "stopped"), [(0.0, 5), (0.7, 1), (0.8, 3), (0.9, 5)])
def test_an_extraction_stops_when_its_trees_are_good_enough(enough, stopped):
    """By the lower end of the best one's interval, whatever a choice says of stopping."""
    selection = Selection.__new__(Selection)
    settings = Settings(enough=enough, patience=9)
    selection.asked, selection.agents, selection.growth = (
        SimpleNamespace(settings=settings, is_over=lambda race, since: False),
        [0],
        {},
    )
    selection.running, selection.offered, selection.fidelity = Running(), 0, None
    selection._reference, selection._since_gain, selection._since = -np.inf, 0, 0.0
    ratios = [(0.75, 0.05), (0.88, 0.1), (0.86, 0.05), (0.8, 0.05), (0.9, 0.01)]
    leaf = ir.GrownTree(*(np.array([value]) for value in (ir.NO_FEATURE, 0.0, ir.NO_CHILD, ir.NO_CHILD, 0)))
    for ratio in ratios:
        choice = SimpleNamespace(agents=[0], ratio=ratio, stops=False, found={}, candidates=[[leaf]], best=0, race=0)
        choice.offer = lambda trees, reached=ratio[0]: reached
        selection.choices = [choice]
        if selection.offer([leaf]):
            break
    assert selection.offered == stopped
    told = {"patience": 9} | ({"enough": enough} if enough else {})
    assert ("--set enough" in explain_stop(told)) is bool(enough)


def test_an_extraction_ends_with_its_best_trees_when_the_time_is_over():
    limit = {"max_seconds": 1e-9, "iterations": 9, "rollouts": 2, "selection_episodes": 4, "max_depth": 2}
    expert, world = network.load("physical-deception")
    profile = extract(world, expert, Settings.of(limit, world))
    told = profile.provenance.training
    assert told["stopped_after"] == 1 and told["max_seconds"] == 1e-9 and not told.get("refinement_spent")
    assert "1e-09 s are over (--max-seconds)" in explain_stop({"patience": 9, **told})
    assert "--max-seconds" not in explain_stop({"patience": 9})


class Timed(Line):
    """Episodes of a second each, later of four, by a clock of their own."""

    now, later, max_cycles = 0.0, math.inf, 8
    teams = {"runners": ["left runner", "runner_1"]}  # noqa: RUF012

    def reset(self, seed=None, options=None):
        Timed.now += 1.0 if Timed.now < Timed.later else 4.0
        return super().reset(seed, options)


def extract_timed(monkeypatch, seconds, later=math.inf, **counts):
    monkeypatch.setattr(time, "monotonic", lambda: Timed.now)
    world = PettingZooWorld(Timed, "tests.maviper.extraction.test_extraction:Timed", games=1)
    monkeypatch.setattr(Timed, "now", 0.0)
    monkeypatch.setattr(Timed, "later", later)
    monkeypatch.setattr(TALLY, "episodes", 0)
    monkeypatch.setattr(TALLY, "seconds", 0.0)
    few = {"max_seconds": float(seconds), "iterations": 3, "selection_episodes": 4, "max_depth": 2, **counts}
    return extract(world, LineExpert(world), Settings.of(few, world))


@pytest.mark.parametrize(
    ("later", "rollouts", "held_out", "rounds", "measured"),
    [(math.inf, 200, 10, 1, 10), (30, 20, 5, 1, 4), (math.inf, 200, 200, 1, 25)],
    ids=["within the first round", "within a later round", "with held-out episodes for most of it"],
)
def test_a_round_that_has_begun_ends_when_the_time_is_over(later, rollouts, held_out, rounds, measured, monkeypatch):
    """Held-out episodes of two line-ups are given half of the time at most."""
    profile = extract_timed(monkeypatch, 100, later, rollouts=rollouts, held_out=held_out)
    told = profile.provenance.training
    most = 100 if later == math.inf else 115  # held-out episodes take longer than the first ones
    assert 90 <= Timed.now <= most and told["stopped_after"] == rounds, Timed.now
    assert profile.provenance.evaluation["episodes"] == measured


def test_a_limit_of_time_that_is_not_reached_changes_nothing(monkeypatch):
    without, within = (extract_timed(monkeypatch, limit, rollouts=6, held_out=3, iterations=2) for limit in (0, 10_000))
    assert policy_json.dumps(replace(within, provenance=without.provenance)) == policy_json.dumps(without)
    assert within.provenance.evaluation == without.provenance.evaluation and Timed.now < 1_000


@pytest.mark.parametrize(("seconds", "further", "over"), [(100, (), False), (80, (), True), (100, (400,), True)])
def test_the_time_that_measuring_takes_is_part_of_the_limit(seconds, further, over, monkeypatch):
    """3,000 held-out episodes in three batches, where the one that was played took 30 s; a race is one more."""
    expert, world = network.load("physical-deception")
    settings = Settings.of({"max_seconds": float(seconds)}, world)
    monkeypatch.setattr("maviper.extraction.extraction.TALLY", Tally(50, 30.0, 1))
    asked = Extraction(world, expert, settings, ends=time.monotonic() + seconds)
    begun = time.monotonic() - 50
    assert asked.is_over(*further, since=begun)  # as long again
    assert asked.is_over(*further) is over and not replace(asked, ends=math.inf).is_over(10**9)


def test_each_team_is_scored_against_the_others_experts(world, expert):
    """`evaluate_teams` mixes per team: defenders' trees against the expert adversary, and the other way round."""
    seeds = range(200)
    idle = Policies([lambda obs: np.zeros(len(obs), dtype=np.int64)] * 3)
    found = measures.evaluate_teams(world, [idle] * 3, [expert] * 3, seeds)
    assert tuple(found) == world.measures
    mixes = {"defenders": [expert, idle, idle], "adversaries": [idle, expert, expert]}
    tables = {team: measures.evaluate(world, mix, seeds) for team, mix in mixes.items()}
    for measure, value in found.items():
        assert value == tables[measure.team][measure]
    other = {"defenders": "adversaries", "adversaries": "defenders"}
    assert any(value != tables[other[measure.team]][measure] for measure, value in found.items())


def test_returns_are_the_summed_rewards_of_the_reference(world, expert):
    """Of a team: the mean over its agents."""
    env = world.reference_env()
    total = dict.fromkeys(world.agents, 0.0)
    episodes = play(world, [expert] * 3, world.start_from_seeds(range(5)))
    for seed in range(5):
        env.reset(seed=seed)
        for acted in episodes.actions[:, seed]:
            _, reward, *_ = env.step(dict(zip(world.agents, acted.tolist(), strict=True)))
            for agent in world.agents:
                total[agent] += reward[agent]
    assert episodes.returns.sum(axis=1) == pytest.approx(list(total.values()), abs=1e-9)
    found = {measure.label: value for measure, value in measures.evaluate(world, [expert] * 3, range(5)).items()}
    assert found["adversaries return"].value == pytest.approx(total["adversary_0"] / 5)
    assert found["defenders return"].value == pytest.approx((total["agent_0"] + total["agent_1"]) / 2 / 5)


def test_no_two_purposes_share_episodes():
    from maviper.experts.training import train
    from maviper.extraction import settings

    longest = {
        measures.CHECKPOINT_SEEDS: train.CHECKPOINT_EPISODES,
        measures.FINALIST_SEEDS: train.FINAL_EPISODES,
        measures.MEASUREMENT_SEEDS: max(train.FINAL_EPISODES, EVALUATION_EPISODES),
        measures.ON_POLICY_SEEDS: ON_POLICY_EPISODES,
        measures.ROLLOUT_SEEDS: 2**32 * settings.EPISODES_PER_SEED,
        measures.SELECTION_SEEDS: 2**32 * settings.EPISODES_PER_SEED,
    }
    starts = sorted(longest)
    assert all(start + longest[start] <= following for start, following in pairwise(starts))


# --- another game: teams of three, lower is better, a script for an expert


@dataclass(frozen=True)
class Sure:
    """A controller that finds its own action worth 1 and every other one worth 0."""

    controller: Scripted
    card: Mapping[str, Any] = field(default_factory=dict)
    hash: str = ""
    centralized: bool = True

    @property
    def agents(self):
        return self.controller.agents

    def act(self, agents, observations, state):
        return self.controller.act(agents, observations, state)

    def q(self, agent, observations, state, joint, given):
        mine = self.act([agent], observations, state)
        asked = np.where(joint[None, :, agent] == AS_GIVEN, given[:, agent, None], joint[None, :, agent])
        return (asked == mine).astype(np.float64)


@pytest.fixture(scope="module")
def spread():
    return find("cooperative-navigation")


@pytest.fixture(scope="module")
def spread_run(spread):
    """A profile and the progress of each iteration."""
    settings, progress = Settings(max_depth=4, iterations=3, rollouts=40, selection_episodes=40), []
    return extract(spread, Sure(build_script(spread)), settings, Running(progress.append)), progress


@pytest.fixture(scope="module")
def spread_profile(spread_run):
    return spread_run[0]


def test_a_game_where_lower_is_better_is_extracted(spread, spread_profile):
    assert check(spread_profile) == ()
    found = spread_profile.provenance.evaluation
    for measure in spread.measures:
        ours, theirs = read_measure(found, measure)
        assert found[f"{measure.label} low"] <= round(ours, 6) <= found[f"{measure.label} high"]
        assert np.isfinite(theirs)
    ours, theirs = read_measure(found, spread.primary("agents"))
    assert theirs < ours < 2.2, "no better than random actions"
    assert (ours, theirs) == (found["agents D + collisions"], found["agents expert D + collisions"])


def test_the_best_of_a_game_where_lower_is_better_is_the_lowest(spread, spread_run):
    profile, scores = spread_run
    values = {progress.done: progress.score for progress in scores if not isinstance(progress, Underway)}
    assert profile.provenance.training["best_iteration"] == max(values, key=values.get)
    seeds = range(measures.SELECTION_SEEDS, measures.SELECTION_SEEDS + 40)
    distance = Measure("agents", "D", lower_is_better=True)  # the paper's measure
    trees = measures.evaluate(spread, [tree_policies(profile.agents)] * 3, seeds)[distance]
    expert = measures.evaluate(spread, [build_script(spread)] * 3, seeds)[distance]
    assert max(values.values()) == pytest.approx(expert.value / trees.value)
