"""The released code's preset: its formulas written out slowly, its leaves, its growth, its selection."""

from itertools import product
from types import SimpleNamespace

import numpy as np
import pytest

from codegen import ir
from maviper.cli import main
from maviper.episodes import measures
from maviper.evaluation import held_out
from maviper.experts.expert import Measured, labels
from maviper.experts.scripted import build_script
from maviper.extraction import released
from maviper.extraction.algorithms import extract
from maviper.extraction.extraction import QUIETLY, Extraction
from maviper.extraction.released import _Growing, best_split, grow_team
from maviper.extraction.selection import ByReturn, Selection
from maviper.extraction.settings import IVIPER_RESAMPLING, Settings
from maviper.worlds import Measure, find


@pytest.fixture
def some(world, expert):
    state = world.start(6, np.random.default_rng(3))
    observations = world.observe(state)
    return observations, state, labels(expert, observations, state)


def q_of(expert, agent, some, row, joint):
    observations, state, wanted = some
    one = [seen[row : row + 1] for seen in observations]
    return expert.q(agent, one, state[row : row + 1], np.array([joint]), wanted[row : row + 1])[0, 0]


def test_the_weight_is_the_released_formula(world, expert, some):
    """Mean over opponents of Q(team at expert actions) less the minimum over joint team actions of that mean."""
    observations, state, wanted = some
    found = released.weights(world, expert, Settings.of({"preset": "released"}), observations, state, wanted)
    for row, agent in product(range(6), range(3)):
        team = [0] if agent == 0 else [1, 2]
        others = [other for other in range(3) if other not in team]

        def averaged(ours, row=row, agent=agent, team=team, others=others):
            values = []
            for theirs in product(range(5), repeat=len(others)):
                joint = np.empty(3, dtype=int)
                joint[team], joint[others] = ours, theirs
                values.append(q_of(expert, agent, some, row, joint))
            return np.mean(values)

        worst = min(averaged(ours) for ours in product(range(5), repeat=len(team)))
        assert found[row, agent] == pytest.approx(max(0, averaged(wanted[row, team]) - worst), rel=1e-9)


def test_ivipers_resampling_leaves_earlier_agents_at_their_last_action(world, expert, some):
    observations, state, wanted = some
    settings = Settings.of({"preset": "released", "algorithm": IVIPER_RESAMPLING})
    found = released.weights(world, expert, settings, observations, state, wanted)
    for row in range(6):
        q = [q_of(expert, 1, some, row, [4, own, wanted[row, 2]]) for own in range(5)]
        assert found[row, 1] == pytest.approx(max(q) - min(q), rel=1e-9)


def test_a_leaf_without_a_majority_stays():
    obs = np.array([[0.0]] * 10 + [[1.0]] * 10, dtype=np.float32)
    acted = np.array([3] * 6 + [4] * 4 + [1] * 4 + [2] * 3 + [3] * 3)
    tree = released.one_hot_tree(obs, acted, np.ones(20, dtype=int), 5, 1)
    assert tree.action[ir.apply(tree, np.array([[0.0], [1.0]], dtype=np.float32))].tolist() == [3, released.STAY]
    exactly_half = released.one_hot_tree(obs[:8], np.array([1] * 4 + [2] * 4), np.ones(8, dtype=int), 5, 1)
    assert exactly_half.action.tolist() == [released.STAY]
    weighed = released.one_hot_tree(obs, acted, np.where(acted == 1, 9, 1), 5, 1)
    assert weighed.action[ir.apply(weighed, np.array([[1.0]], dtype=np.float32))].tolist() == [1]
    mended = released.one_hot_tree(obs, acted, np.ones(20, dtype=int), 5, 1, stays=False)
    assert mended.action[ir.apply(mended, np.array([[0.0], [1.0]], dtype=np.float32))].tolist() == [3, 1]


@pytest.mark.parametrize("seed", range(10))
def test_the_split_is_the_best_of_all(seed):
    rng = np.random.default_rng(seed)
    obs = rng.integers(6, size=(40, 3)).astype(np.float32) / 4
    acted, counts = rng.integers(3, size=40), rng.integers(1, 4, size=40)

    def impurity(part):
        shares = np.bincount(acted[part], counts[part], 3)
        return shares.sum() - np.square(shares).sum() / shares.sum() if shares.sum() else 0.0

    feature, threshold = best_split(obs, acted, counts, 3)
    best = []
    for index in range(3):
        values = np.unique(obs[:, index])
        for cut in (values[1:] + values[:-1]) / 2:
            left = obs[:, index] < cut
            best.append((round(impurity(left) + impurity(~left), 9), index, float(cut)))
    assert (feature, threshold) == min(best)[1:]
    assert best_split(obs, np.ones(40, dtype=int), counts, 3) is None, "a pure node is not split"


def test_less_goes_left():
    obs = np.array([[0.0], [1.0], [0.0], [1.0]], dtype=np.float32)
    acted, everybody = np.array([[0], [1], [0], [1]]), np.ones((4, 1), dtype=bool)
    (tree,) = grow_team([obs], acted, [np.ones(4, dtype=int)], [2], 1, rng(), predicts=False, alive=everybody)
    at = np.array([[0.5], [np.nextafter(np.float32(0.5), np.float32(0))]], dtype=np.float32)
    assert tree.action[ir.apply(tree, at)].tolist() == [1, 0]


def rng():
    return np.random.default_rng(0)


def test_a_node_is_made_of_the_kept_points_or_of_all():
    obs = np.arange(8, dtype=np.float32)[:, None]
    acted = np.array([0, 0, 0, 0, 0, 1, 1, 1])
    growing = _Growing(obs, acted, np.ones(8, dtype=int), 2, 2, 0)
    keep = np.arange(8) >= 5
    assert growing.make_node(np.arange(8), 0, keep).rows.tolist() == [5, 6, 7]
    assert growing.make_node(np.arange(8), 0, keep).action == 1
    assert growing.make_node(np.arange(4), 1, keep).rows.tolist() == [0, 1, 2, 3]
    assert growing.make_node(np.arange(8), 2, keep).projected is None, "there is nothing left to project at full depth"


def test_votes_of_more_than_half_keep_a_point():
    """A team of two: both must be right. The second sees nothing, so it is right where its majority is: the first
    one's split lies midway between the points that are left.
    """
    obs = np.arange(40, dtype=np.float32)[:, None]
    first = (np.arange(40) >= 20).astype(int)
    noise = np.random.default_rng(1).integers(2, size=40)
    given = ([obs, np.zeros((40, 1), dtype=np.float32)], np.stack([first, noise], axis=1))
    ones = [np.ones(40, dtype=int)] * 2
    kept = np.flatnonzero(noise == np.bincount(noise).argmax())
    middle = (kept[kept < 20].max() + kept[kept >= 20].min()) / 2
    assert middle != 19.5
    for predicts, cut in ((True, middle), (False, 19.5)):
        trees = grow_team(*given, ones, [2, 2], 1, rng(), predicts=predicts, alive=np.ones((40, 2), dtype=bool))
        assert trees[0].threshold[0] == np.nextafter(cut, -1) and len(trees[1].feature) == 1


def test_each_teams_best_is_that_of_the_highest_return(world, expert, monkeypatch):
    settings = Settings.of({"preset": "released", "selection_episodes": 2})
    selection = Selection(Extraction(world, expert, settings), range(3), QUIETLY)
    returns = {"adversaries": iter([1, 3, 2]), "defenders": iter([5, 2, 9])}

    def played(self, trees):
        (team,) = self.teams
        share = {"adversaries": np.array([0.0, 1.0]), "defenders": np.array([1.0, 1.0])}[team]
        return {world.primary(team): share, Measure(team, measures.RETURN): np.array([next(returns[team])])}

    monkeypatch.setattr(ByReturn, "_play_candidate", played)
    trees = [[ir.GrownTree([-1], [0.0], [-1], [-1], [k])] * 3 for k in range(3)]
    assert not any(selection.offer(each) for each in trees), "nothing stops early"
    assert [mine[0].action[0] for mine in selection.choose_trees()] == [1, 2, 2]
    assert selection.facts == {"stopped_after": 3, "best_iteration_adversaries": 2, "best_iteration_defenders": 3}


def test_imitations_points_are_starts(world, expert):
    """The first 25 steps of one episode, then start states: at rest, all within the start region."""
    settings = Settings.of({"preset": "released", "algorithm": "imitation", "rollouts": 3})
    arrays = released._starts(world, expert, settings, 0)
    assert len(arrays["labels"]) == 75 and arrays["observations.001"].shape == (75, 10)
    later = released._starts(world, expert, settings, 1)
    assert len(later["labels"]) == 75 and np.abs(later["observations.000"]).max() <= 2
    first = measures.ROLLOUT_SEEDS
    start = world.observe(world.start_from_seeds([first]))
    assert (arrays["observations.000"][0] == start[0][0]).all()


def test_without_restarts_imitations_points_are_whole_episodes(world, expert):
    settings = Settings.of({"preset": "released", "algorithm": "imitation", "rollouts": 3, "undo": "restarts"})
    arrays = released._episodes(world, expert, settings, 1)
    starts = world.observe(world.start_from_seeds(settings.rollout_episodes(1)))
    seen = arrays["observations.000"].reshape(25, 3, -1)
    assert (seen[0] == starts[0]).all() and len(arrays["labels"]) == 75
    assert (np.diff(seen, axis=0) != 0).any(axis=(0, 2)).all(), "agents move within an episode"


def share_of_stay(world, expert, undo):
    """How often IVIPER's trees stand still in its own small extraction."""
    small = {"iterations": 1, "rollouts": 4, "selection_episodes": 4, "max_depth": 2}
    settings = Settings.of({"preset": "released", "algorithm": "iviper", "undo": undo, **small})
    agents = extract(world, expert, settings).agents
    leaves = [policy.tree.action[policy.tree.feature < 0] for policy in agents]
    return float(np.mean(np.concatenate(leaves) == released.STAY))


def test_each_accident_is_undone_alone(world, expert, monkeypatch):
    monkeypatch.setattr(held_out, "EVALUATION_EPISODES", 4)
    monkeypatch.setattr(released, "WARM_UP", 10)
    assert share_of_stay(world, expert, "") > share_of_stay(world, expert, "leaves")
    small = {"iterations": 2, "rollouts": 3, "selection_episodes": 4, "max_depth": 1}
    told = {}
    for undo in ("", "warm-up"):
        settings = Settings.of({"preset": "released", **small, "undo": undo})
        told[undo] = extract(world, expert, settings).provenance.training
    assert "undo" not in told[""] and told["warm-up"]["undo"] == "warm-up"
    assert (told[""]["points"], told["warm-up"]["points"]) == (25 * (10 + 6), 25 * (3 + 6))
    assert told[""]["stopped_after"] == 2 and told[""]["selection"] == "return"


def test_no_episode_is_for_two_purposes():
    settings = Settings.of({"preset": "released"})
    last = settings.rollout_episodes(settings.iterations - 1, released.WARM_UP)
    assert settings.rollout_episodes(0, released.WARM_UP).start == measures.ROLLOUT_SEEDS + released.WARM_UP
    assert last.stop <= measures.ROLLOUT_SEEDS + 100_000


@pytest.mark.parametrize("algorithm", [pytest.param("maviper", marks=pytest.mark.slow), "iviper", "imitation"])
def test_loops_stop_where_the_selection_says_so(world, expert, monkeypatch, algorithm):
    """The second candidate is enough."""
    given = {"algorithm": algorithm, "iterations": 3, "rollouts": 1, "max_depth": 1}
    settings, loop = Settings.of({"preset": "released", **given}), released.rounds
    loop = released.imitation if algorithm == "imitation" else loop
    monkeypatch.setattr(released, "WARM_UP", 1)
    offered: list[object] = []
    selection = SimpleNamespace(
        note_rollouts=lambda *_: None, offer=lambda tree: offered.append(tree) or len(offered) > 1
    )
    loop(Extraction(world, expert, settings), [0] if algorithm == "iviper" else range(3), selection)
    assert len(offered) == 2


@pytest.mark.parametrize("algorithm", ["maviper", "maviper-no-prediction"])
def test_a_team_whose_joint_actions_cannot_be_tried_is_refused_at_once(algorithm, tmp_path, capsys):
    """5^6 in every state of 500 episodes; before, nothing came back. No run folder is begun."""
    place = tmp_path / "run"
    given = ["cooperative-navigation,agents=6", "--critic", "measured", "--preset", "released", "-o", str(place)]
    assert main.run(["extract", *given, "--algorithm", algorithm]) == 2
    said = capsys.readouterr().err
    assert "joint actions" in said and "--preset paper" in said and not place.exists()


@pytest.mark.parametrize("algorithm", ["iviper", "maviper-iviper-resampling", "imitation"])
def test_algorithms_that_weigh_own_actions_only_take_teams_of_any_size(algorithm, monkeypatch):
    monkeypatch.setattr(held_out, "EVALUATION_EPISODES", 2)
    monkeypatch.setattr(released, "WARM_UP", 1)
    world = find("cooperative-navigation,agents=6")
    sizes = {"iterations": 1, "rollouts": 1, "selection_episodes": 2, "max_depth": 1}
    settings = Settings.of({"preset": "released", "algorithm": algorithm, **sizes})
    assert len(extract(world, Measured(world, build_script(world), horizon=1), settings).agents) == 6
