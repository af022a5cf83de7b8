"""The algorithms beside MAVIPER, presets, and the two ways of searching splits."""

from itertools import product

import numpy as np
import pytest

from codegen import ir, policy_json, profiles
from codegen.errors import InputError, UnknownNameError
from maviper.episodes.play import points, rollout
from maviper.evaluation import held_out
from maviper.experts.expert import AS_GIVEN, Measured, labels
from maviper.experts.scripted import build_script
from maviper.extraction import baselines, released
from maviper.extraction.algorithms import extract
from maviper.extraction.dataset import Dataset
from maviper.extraction.extraction import Running
from maviper.extraction.growth.exact import CartTree
from maviper.extraction.growth.joint import (
    BINS,
    Bins,
    HistogramTree,
    best_splits,
    grow_jointly,
    project_trees,
)
from maviper.extraction.growth.weights import SAMPLED_JOINT, iviper_weights, joint_actions, maviper_weights
from maviper.extraction.journal import Journal, unpack_trees
from maviper.extraction.selection import KINDS
from maviper.extraction.settings import (
    ALGORITHMS,
    EXACT,
    FITTED_Q,
    HISTOGRAM,
    IMITATION,
    IVIPER,
    PRESETS,
    VIPER,
    Settings,
)
from maviper.worlds import find
from tests.support.tiers import first_of

SMALL = {"iterations": 3, "rollouts": 8, "selection_episodes": 20, "max_depth": 3, "refinement": 0}
TINY = {"iterations": 2, "rollouts": 4, "selection_episodes": 8}  # where an extraction is compared with itself


@pytest.fixture(autouse=True)
def quick(monkeypatch):
    monkeypatch.setattr(held_out, "EVALUATION_EPISODES", 50)
    monkeypatch.setattr(released, "WARM_UP", 20)


def small(algorithm, **more):
    return Settings.of({"algorithm": algorithm, **SMALL, **more})


ALL = [(algorithm, preset) for algorithm, preset in product(ALGORITHMS, PRESETS) if algorithm != VIPER]


REPEATED = sorted((each for each in ALL if each != (FITTED_Q, "released")), key=lambda each: each[1] != "default")


@pytest.mark.parametrize(("algorithm", "preset"), first_of(len(ALGORITHMS), REPEATED))
def test_every_algorithm_gives_a_profile_that_repeats(algorithm, preset, world, expert):
    found = extract(world, expert, small(algorithm, preset=preset, **TINY))
    assert [policy.agent for policy in found.agents] == list(world.agents)
    assert found.provenance.algorithm == algorithm and found.provenance.preset == preset
    assert found.provenance.training["splits"] == PRESETS[preset]["splits"]
    if algorithm != FITTED_Q:  # its trees of actions lie over one another
        assert all(ir.depth(policy.tree).max() <= 3 for policy in found.agents)
    text = policy_json.dumps(found)
    assert policy_json.dumps(profiles.loads(text)) == text
    assert policy_json.dumps(extract(world, expert, small(algorithm, preset=preset, **TINY))) == text


@pytest.mark.parametrize("name", ["cooperative-navigation", "predator-prey"])
@pytest.mark.parametrize("algorithm", first_of(1, ["maviper", "iviper", IMITATION, FITTED_Q]))
def test_every_game(name, algorithm):
    world = find(name)
    expert = Measured(world, build_script(world), horizon=2)
    found = extract(world, expert, small(algorithm, iterations=1, rollouts=2, selection_episodes=4))
    assert len(found.agents) == len(world.agents)
    assert found.provenance.training["expert_algorithm"] == "scripted"


def test_viper_needs_an_agent(world, expert):
    with pytest.raises(InputError, match="VIPER extracts one agent"):
        extract(world, expert, small(VIPER))
    with pytest.raises(UnknownNameError, match="did you mean 'agent_1'"):
        extract(world, expert, small(VIPER, agent="agnt_1"))


def test_ivipers_weight_is_v_minus_the_worst_own_action(world, expert):
    state = world.start(10, np.random.default_rng(0))
    observations = world.observe(state)
    wanted = labels(expert, observations, state)
    for agent in range(3):
        joint = np.full((5, 3), AS_GIVEN)
        joint[:, agent] = np.arange(5)
        q = expert.q(agent, observations, state, joint, wanted)
        found = iviper_weights(world, expert, observations, state, wanted, agent)
        assert found == pytest.approx(q[np.arange(10), wanted[:, agent]] - q.min(axis=1))


def test_a_cooperative_game_averages_over_all_others():
    """Navigation, written out: E over both others' actions of Q at the expert's minus the least Q over own actions."""
    from maviper.experts import network

    world = find("cooperative-navigation")
    expert = network.load("cooperative-navigation")[0]
    state = world.start(4, np.random.default_rng(0))
    observations = world.observe(state)
    wanted = labels(expert, observations, state)
    found = maviper_weights(world, expert, observations, state, wanted)
    for row, agent in product(range(4), range(3)):
        total, others = 0.0, [other for other in range(3) if other != agent]
        for theirs in product(range(5), repeat=2):
            joint = np.empty((5, 3), dtype=int)
            joint[:, agent], joint[:, others] = np.arange(5), theirs
            one = [seen[row : row + 1] for seen in observations]
            q = expert.q(agent, one, state[row : row + 1], joint, wanted[row : row + 1])[0]
            total += q[wanted[row, agent]] - q.min()
        assert found[row, agent] == pytest.approx(total / 25, rel=1e-9)


def test_the_released_weight_in_a_cooperative_game_has_nobody_to_average_over():
    """All others are of the team: Q at the experts' joint action less the least Q of any joint action."""
    from maviper.experts import network

    world = find("cooperative-navigation")
    expert = network.load("cooperative-navigation")[0]
    state = world.start(4, np.random.default_rng(0))
    observations = world.observe(state)
    wanted = labels(expert, observations, state)
    found = released.weights(world, expert, small("maviper", preset="released"), observations, state, wanted)
    for agent in range(3):
        q = expert.q(agent, observations, state, np.array(list(product(range(5), repeat=3))), wanted)
        best = expert.q(agent, observations, state, np.full((1, 3), AS_GIVEN), wanted)[:, 0]
        assert found[:, agent] == pytest.approx(best - q.min(axis=1))


def test_many_agents_are_sampled():
    world = find("cooperative-navigation,agents=24")
    joint = joint_actions(world, 3, [other for other in range(24) if other != 3])
    assert joint.shape == (5 * SAMPLED_JOINT, 24) and (joint >= 0).all()
    others = np.delete(joint, 3, axis=1).reshape(5, SAMPLED_JOINT, 23)
    assert (others == others[0]).all() and (joint[:, 3].reshape(5, -1) == np.arange(5)[:, None]).all()


@pytest.mark.parametrize("agents", [5, 7])
def test_where_play_measures_q_each_state_gets_one_row_of_a_latin_square(agents, monkeypatch):
    """No state is left out or asked twice, each of the others takes each action equally often, and own actions vary."""
    world = find(f"cooperative-navigation,agents={agents}")
    expert = Measured.for_world(world, build_script(world))
    state = world.start(23, np.random.default_rng(0))
    observations = world.observe(state)
    wanted = labels(expert, observations, state)
    asked = []

    def q(self, agent, observations, state, joint, given):
        assert agent == 2 and joint.shape == (5, agents) and (joint[:, 2] == np.arange(5)).all()
        assert (np.delete(joint, 2, axis=1) == AS_GIVEN).all()
        asked.append((state.position[:, 0, 0], np.delete(given, 2, axis=1)))
        return np.tile([0.0, 1.0, 2.0, 3.0, 4.0], (len(given), 1))

    monkeypatch.setattr(Measured, "q", q)
    found = maviper_weights(world, expert, observations, state, wanted, [2])
    assert (found[:, 0] == wanted[:, 2]).all()  # Q of the expert's action less the least, 0
    assert sorted(np.concatenate([rows for rows, _ in asked])) == sorted(state.position[:, 0, 0])
    square, counts = np.unique(np.concatenate([theirs for _, theirs in asked]), axis=0, return_counts=True)
    assert (np.sort(square, axis=0) == np.arange(5)[:, None]).all() and set(counts) <= {4, 5}


# --- histograms


def some_points(seed, n=400, n_features=4, n_distinct=30):
    rng = np.random.default_rng(seed)
    obs = rng.integers(n_distinct, size=(n, n_features)).astype(np.float32) / 7
    labels = (obs[:, 0] > obs[:, 1]) * 2 + (obs[:, 2] + rng.normal(size=n) > 2)
    return obs, labels.astype(np.int64), rng.integers(3, size=n)


@pytest.mark.parametrize("few", [0, 100], ids=["histogram", "sorted"])
@pytest.mark.parametrize("seed", range(12))
def test_splits_are_those_of_the_definition_to_the_last_bit(seed, few, monkeypatch):
    """Slot by slot and cut by cut, in plain integers up to one division: also ties, and counts as large as allowed."""
    monkeypatch.setattr("maviper.extraction.growth.joint.FEW", few)
    rng = np.random.default_rng(seed)
    n, n_slots, n_actions = 60, 3, 4
    codes = rng.integers((4, 40, 256)[seed % 3], size=(5, n)).astype(np.int32)
    labels, slot = rng.integers(n_actions, size=n), rng.integers(n_slots, size=n)
    counts = rng.integers(3 if seed % 2 else 2**26 // n, size=n)
    found = best_splits(codes, labels, counts.astype(float), slot, n_slots, n_actions)
    for k in range(n_slots):
        best, at = -np.inf, None
        for feature, cut in product(range(5), range(BINS - 1)):
            left = (slot == k) & (codes[feature] <= cut)
            right = (slot == k) & (codes[feature] > cut)
            parts = [[int(counts[part & (labels == a)].sum()) for a in range(n_actions)] for part in (left, right)]
            if min(map(sum, parts)) > 0:
                purity = sum(sum(count * count for count in part) / sum(part) for part in parts)
                best, at = (purity, (feature, cut)) if purity > best else (best, at)
        assert found.found[k] and (found.feature[k], found.code[k]) == at
        assert found.totals[k].tolist() == [counts[(slot == k) & (labels == a)].sum() for a in range(n_actions)]


@pytest.mark.parametrize("seed", range(8))
@pytest.mark.parametrize("depth", [1, 3])
def test_projected_trees_fit_each_leaf_on_its_own(seed, depth):
    """All slots in one pass give what one slot at a time gives; slot -1 and empty slots say nothing."""
    obs, wanted, counts = some_points(seed)
    codes, rng = Bins.of(obs).codes(obs), np.random.default_rng(seed)
    slot = rng.integers(-1, 4, size=len(obs))
    counts = np.where(slot == 3, 0, counts).astype(float)
    together = project_trees(codes, wanted, counts, slot, 4, 4, depth)
    assert (together[(slot == -1) | (slot == 3)] == -1).all()
    for k in range(3):
        here = np.flatnonzero(slot == k)
        alone = project_trees(codes[:, here], wanted[here], counts[here], np.zeros(len(here), np.int64), 1, 4, depth)
        assert (together[here] == alone).all() and (alone >= 0).all()


def two_members(splits, observations, wanted, max_depth):
    """Members of a team before they grow, each point once in the data of each."""
    ones = np.ones(len(wanted), dtype=np.int64)
    n_actions = int(wanted.max()) + 1
    if splits == EXACT:
        return [CartTree(obs, wanted[:, k], ones, n_actions, max_depth, 0) for k, obs in enumerate(observations)]
    team = []
    for place, obs in enumerate(observations):
        bins = Bins.of(obs)
        label = np.ascontiguousarray(wanted[:, place])
        team.append(HistogramTree(bins, bins.codes(obs), label, ones, n_actions, max_depth))
    return team


@pytest.mark.parametrize("splits", [EXACT, HISTOGRAM])
@pytest.mark.parametrize("depth", [1, 2, 3])
def test_a_finished_member_votes_by_the_tree_that_comes_out(splits, depth):
    """What it is said to do in a point is what its tree does there."""
    for seed in range(4):
        obs, wanted, _ = some_points(seed)
        members = two_members(splits, [obs, obs[:, ::-1].copy()], np.stack([wanted, wanted], axis=1), depth)
        trees = grow_jointly(members, depth, 1)
        for member, tree, seen in zip(members, trees, (obs, obs[:, ::-1]), strict=True):
            acts_right = tree.action[ir.apply(tree, np.ascontiguousarray(seen))] == wanted
            assert (member.check_predictions() == acts_right).all() and not acts_right.all()


@pytest.mark.parametrize(("splits", "threshold"), [(EXACT, 15.0), (HISTOGRAM, 10.5)])
def test_points_that_a_finished_member_gets_wrong_are_no_longer_learned_from(splits, threshold):
    """By hand, depth 1, both must be right. The first one's labels need two splits, so its tree is wrong in the last
    eight points. Without these nothing of the second's data lies between 10 and 20; with them there is up to 18.
    """
    first = np.repeat([0, 1, 0], [12, 10, 8])
    place = np.concatenate([np.arange(11), np.arange(20, 31), np.arange(11, 19)])
    wanted = np.stack([first, place >= 19], axis=1).astype(np.int64)
    seen = [column.astype(np.float32)[:, None] for column in (np.arange(30), place)]
    kept = []
    trees = grow_jointly(two_members(splits, seen, wanted, 1), 1, 2, kept=kept)
    assert kept == [22 / 30, 22 / 30]
    assert trees[0].action[1:].tolist() == [0, 1] and trees[0].threshold[0] == 11.5
    assert trees[1].threshold[0] == threshold, "19 where the last eight points count"


def test_many_values_are_cut_evenly_by_rank_and_between_values():
    rng = np.random.default_rng(0)
    obs = rng.normal(size=(20_000, 2)).astype(np.float32)
    obs[:, 1] = np.round(obs[:, 1], 1)
    bins = Bins.of(obs)
    assert len(bins.edges[0]) == BINS - 1 and len(bins.edges[1]) == len(np.unique(obs[:, 1])) - 1
    assert all((np.diff(edges) > 0).all() for edges in bins.edges)
    share = np.bincount(bins.codes(obs)[0], minlength=BINS) / len(obs)
    assert share.max() < 1.2 / BINS
    for column, edges, codes in zip(obs.T, bins.edges, bins.codes(obs), strict=True):
        assert not np.isin(edges, column.astype(np.float64)).any()
        assert (codes == (column[:, None] > edges[None]).sum(axis=1)).all()


def test_bins_depend_on_how_many_points_there_are_alone(world, expert):
    """So that a run that goes on has the bins that it would have had; they are kept while points are few more."""
    from maviper.extraction.growth.growing import Growth

    episodes = rollout(world, [expert] * 3, range(40))[0]
    observations, state = points(episodes)
    wanted = labels(expert, observations, state)

    def grow(growth, n):
        ones = [np.ones(n, dtype=np.int64)] * 3
        data = Dataset(tuple(seen[:n] for seen in observations), wanted[:n], np.ones((n, 3)), np.ones((n, 3), bool))
        return growth.team([1, 2], data, ones, [0] * 3, 1)

    growth = Growth(world, small("maviper"))
    grow(growth, 600)
    first = growth._bins[1][0]
    grow(growth, 610)
    assert growth._bins[1][0] is first and growth._bins[1][2].shape[1] == 610
    assert (growth._bins[1][2] == first.codes(observations[1][:610])).all()
    later = grow(growth, 990)
    assert growth._bins[1][0] is not first
    for ours, theirs in zip(later, grow(Growth(world, small("maviper")), 990), strict=True):
        assert ours.threshold.tobytes() == theirs.threshold.tobytes() and (ours.feature == theirs.feature).all()


# --- votes


@pytest.mark.parametrize(
    ("asked", "votes"),
    [("N-1", [0, 1, 2, 3]), ("N", [1, 2, 3, 4]), ("N-2", [0, 0, 1, 2]), ("0", [0] * 4), ("2", [1, 2, 2, 2]),
     ("0.5", [1, 1, 2, 2]), (".75", [1, 2, 3, 3]), ("0.1", [1, 1, 1, 1]), ("1.0", [1, 2, 3, 4])],
)  # fmt: skip
def test_how_many_right_predictions_a_point_needs(asked, votes):
    settings = Settings.of({"least_right": asked})
    assert [settings.votes_of(team) for team in (1, 2, 3, 4)] == votes


@pytest.mark.parametrize("splits", [EXACT, HISTOGRAM])
def test_no_right_prediction_needed_is_the_ablation_without_prediction(splits, world, clone):
    """Of the clone: so small a run of the shipped expert grows the same trees either way."""

    def thresholds(algorithm, **more):
        found = extract(world, clone, small(algorithm, preset="paper", splits=splits, **more))
        return [policy.grown.threshold.tolist() for policy in found.agents]

    usual = thresholds("maviper")
    assert thresholds("maviper", least_right="0") == thresholds("maviper-no-prediction") != usual
    assert thresholds("maviper", least_right="N") != usual == thresholds("maviper", least_right="N-1")


def test_metrics_tell_how_far_the_team_is_right_together(world, expert, tmp_path, monkeypatch):
    """Counted again, point by point, from the rollouts and trees that the run folder keeps."""
    journal, lines = Journal(tmp_path), []
    extract(world, expert, small("maviper", preset="paper"), Running(lambda step: lines.append(step.line)), journal)
    observations, labelled = [[], [], []], []
    for step, line in enumerate(lines):
        met = journal.load_or_collect(f"{step:04d}-rollouts", pytest.fail).data
        labelled += met.labels.tolist()
        for mine, seen in zip(observations, met.observations, strict=True):
            mine += seen.tolist()
        arrays = journal.arrays(f"{step:04d}-trees", pytest.fail)
        trees = unpack_trees({name: array for name, array in arrays.items() if "." in name})

        def act(tree, row):
            node = 0
            while tree.feature[node] >= 0:
                node = tree.left[node] if row[tree.feature[node]] <= tree.threshold[node] else tree.right[node]
            return tree.action[node]

        right = [
            [act(trees[agent], row) == label[agent] for row, label in zip(observations[agent], labelled, strict=True)]
            for agent in range(3)
        ]
        both = sum(one and other for one, other in zip(*right[1:], strict=True)) / len(labelled)
        apart = sum(right[1]) * sum(right[2]) / len(labelled) ** 2
        assert line["joint accuracy defenders"] == pytest.approx(both)
        assert line["product of accuracies defenders"] == pytest.approx(apart)
        alone = sum(right[0]) / len(labelled)
        assert line["joint accuracy adversaries"] == line["product of accuracies adversaries"] == pytest.approx(alone)
        assert line["kept adversaries"] == 1 and 0.3 < line["kept defenders"] < 1


# --- fitted Q


@pytest.mark.parametrize("share", [0.0, 0.5])
def test_fitted_q_may_explore_while_it_collects(share, world, expert):
    """A uniform action is the expert's one time in five."""
    settings = small(FITTED_Q, explore=share, rollouts=40)
    (played,) = baselines.collect_episodes(world, expert, settings)
    observations, state = points(played)
    other = (played.actions.reshape(-1, 3) != labels(expert, observations, state)).mean()
    assert other == pytest.approx(share * 4 / 5, abs=0.02)
    again = baselines.collect_episodes(world, expert, settings)[0].actions
    assert (again == played.actions).all()
    with pytest.raises(InputError, match="only fitted-q explores"):
        small("maviper", explore=0.1)


def test_the_tree_of_actions_is_the_argmax_of_the_tree_of_q():
    """In every bin of every feature, over random trees of Q."""
    from sklearn.tree import DecisionTreeRegressor

    rng = np.random.default_rng(0)
    n_features, n_actions = 3, 4
    centres = np.concatenate([[-1.125], baselines.EDGES + 0.125])
    everywhere = np.array(list(product(range(10), repeat=n_features)))
    for depth in (1, 2, 4):
        seen = rng.integers(10, size=(600, n_features))
        acted = rng.integers(n_actions, size=600)
        inputs = np.concatenate([seen, np.eye(n_actions)[acted]], axis=1)
        target = np.sin(seen @ rng.normal(size=n_features)) * (acted + 1) + rng.normal(size=600)
        tree = DecisionTreeRegressor(max_depth=depth, random_state=0).fit(inputs, target)
        actions = baselines.greedy(tree.tree_, n_features, n_actions)
        one_hot = [np.tile(np.eye(n_actions)[k], (len(everywhere), 1)) for k in range(n_actions)]
        q = [tree.predict(np.concatenate([everywhere, each], axis=1)) for each in one_hot]
        found = actions.action[ir.apply(actions, centres[everywhere].astype(np.float32))]
        assert (found == np.argmax(q, axis=0)).all()
        for place in everywhere[::37]:  # the lower ends of bins belong to them
            at = np.where(place > 0, baselines.EDGES[np.maximum(place - 1, 0)], -9.0).astype(np.float32)
            row = np.flatnonzero((everywhere == place).all(axis=1))
            assert actions.action[ir.apply(actions, at[None])][0] == found[row][0]


# --- settings


def test_presets_and_protocols():
    assert Settings.of({}).splits == HISTOGRAM and Settings.of({"preset": "paper"}).splits == HISTOGRAM
    assert Settings.of({"preset": "paper", "splits": EXACT}).splits == EXACT
    assert Settings.of({"preset": "released"}).splits == EXACT
    assert Settings.of({"algorithm": IVIPER}).iterations == 50
    imitation = Settings.of({"algorithm": IMITATION})
    assert imitation.iterations * imitation.rollouts * 25 == 100_000
    assert Settings.of({"algorithm": FITTED_Q}).rollouts * 25 == 30_000


@pytest.mark.parametrize(
    ("name", "iterations", "rollouts"),
    [("physical-deception", 50, 50), ("cooperative-navigation,agents=2", 100, 50), ("predator-prey", 100, 100)],
)
def test_ivipers_counts_are_those_of_the_papers_table(name, iterations, rollouts):
    for algorithm in (IVIPER, VIPER):
        found = Settings.of({"preset": "paper", "algorithm": algorithm}, find(name))
        assert (found.iterations, found.rollouts) == (iterations, rollouts)
    own = Settings.of({"preset": "paper", "algorithm": IVIPER, "iterations": 7, "rollouts": 9}, find(name))
    assert (own.iterations, own.rollouts) == (7, 9)
    joint = Settings.of({"preset": "paper"}, find(name))
    assert (joint.iterations, joint.rollouts) == (100, 50)


@pytest.mark.parametrize(
    ("algorithm", "asked", "stops"),
    [("maviper", {}, False), (IVIPER, {}, False), (VIPER, {}, False), ("maviper", {"patience": 10}, True)],
)
def test_in_the_papers_protocol_nothing_stops_early_that_was_not_asked_to(algorithm, asked, stops, world, expert):
    agent = "agent_0" if algorithm == VIPER else ""
    sizes = {"iterations": 16, "rollouts": 1, "selection_episodes": 4, "max_depth": 1, "agent": agent}
    found = extract(world, expert, Settings.of({"preset": "paper", "algorithm": algorithm, **sizes, **asked}, world))
    assert (found.provenance.training["stopped_after"] < 16) == stops


@pytest.mark.parametrize(("asked", "best"), [("", 2), ("D", 2), ("D + collisions", 1), ("collisions", 1)])
def test_the_papers_navigation_is_judged_by_distance(asked, best, monkeypatch):
    """The second round is nearer, the first one collides less."""
    world = find("cooperative-navigation,agents=2")
    expert = Measured(world, build_script(world), horizon=2)
    distance, collisions = iter([0.9, 0.8]), iter([0.1, 0.3])

    def played(self, trees):
        near, hit = np.full(4, next(distance)), np.full(4, next(collisions))
        rows = {"D + collisions": near + hit, "D": near, "collisions": hit}
        return {measure: rows[measure.name] for measure in world.measures if measure.name in rows}

    monkeypatch.setattr(KINDS["uniform"], "_play_candidate", played)
    sizes = {"iterations": 2, "rollouts": 1, "selection_episodes": 4, "max_depth": 1}
    found = extract(world, expert, Settings.of({"preset": "paper", **sizes, "measure": asked}, world)).provenance
    assert found.training["best_iteration"] == best
    assert found.training["measure"] == (asked or "D")
    assert {"agents D", "agents D + collisions"} <= set(found.evaluation), "each is measured in the end"


def test_a_measure_that_no_team_has(world, expert):
    with pytest.raises(UnknownNameError, match="did you mean 'success"):
        extract(world, expert, small("maviper", measure="success r=.1"))
    tight = extract(world, expert, small("maviper", measure="success r=0.1"))
    assert tight.provenance.training["measure"] == "success r=0.1" and world.primary("defenders").name.endswith("0.316")
