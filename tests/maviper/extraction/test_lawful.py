"""Trees completed with tests of a mask: legal for every mask, and as before wherever their own action is legal."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from codegen import ir
from codegen.errors import InputError
from codegen.lowering.deploy import deploy_tree
from codegen.paths import illegal_leaves
from maviper.episodes.play import rollout
from maviper.episodes.trees import agent_policies, among
from maviper.evaluation import held_out
from maviper.evaluation.crossplay import Uniform
from maviper.experts.finding import Unweighted, lawful_expert
from maviper.extraction import refine
from maviper.extraction.algorithms import extract
from maviper.extraction.arena import Arena
from maviper.extraction.extraction import Running
from maviper.extraction.growth.growing import Labelled, lawful
from maviper.extraction.growth.weights import iviper_weights
from maviper.extraction.journal import REFINING
from maviper.extraction.settings import Settings
from maviper.worlds import find
from maviper.worlds.world import legal_in
from tests.support.other_loops import Code, Player, play_tictactoe

ACTIONS = 4
MASK = (None, 1, 2, 3)  # the first action is always legal, feature 0 is something else
SMALL = {"iterations": 2, "rollouts": 6, "selection_episodes": 6, "max_depth": 4, "refinement": 0}
TICTACTOE = "pettingzoo.classic.tictactoe.tictactoe:env,wrap=turns+flatten"


@st.composite
def grown(draw):
    rows = []

    def grow(depth):
        place = len(rows)
        rows.append([-1, 0.0, -1, -1, draw(st.integers(0, ACTIONS - 1))])
        if depth and draw(st.booleans()):
            feature, threshold = draw(st.integers(0, 3)), draw(st.sampled_from([0.0, 0.3, 0.5, 0.9]))
            rows[place] = [feature, threshold, grow(depth - 1), grow(depth - 1), -1]
        return place

    grow(4)
    return ir.GrownTree(*np.array(rows, dtype=np.float64).T)


def everywhere():
    """All masks, beside numbers on both sides of every threshold, [n, 4]."""
    legal = np.array([[k >> bit & 1 for bit in range(3)] for k in range(8)])
    other = np.array([-0.1, 0.1, 0.4, 0.7, 1.0])
    return np.array([[place, *row] for place in other for row in legal], np.float32)


@given(grown(), st.lists(st.integers(0, ACTIONS - 1), min_size=40, max_size=40), st.booleans())
def test_completed_trees_are_legal_and_change_nothing_else(tree, labels, masked):
    obs = everywhere()
    mask = (0, 1, 2, 3) if masked else MASK
    labels = np.array(labels)
    found = lawful(tree, mask, Labelled(obs, labels))
    legal = legal_in(mask, obs)
    some = legal.any(axis=1)
    before, after = (each.action[ir.apply(each, obs)] for each in (tree, found))
    rows = np.arange(len(obs))
    assert legal[rows, after][some].all() and not list(illegal_leaves(deploy_tree(found), mask))
    if not masked:  # else the mask's own thresholds are not halves
        assert (after == before)[legal[rows, before]].all()


def test_the_second_choice_is_what_labels_name_most():
    tree = ir.GrownTree(*(np.array([value]) for value in (-1, 0.0, -1, -1, 1)))
    obs = np.array([[0, 0, 1, 1]] * 3 + [[0, 1, 1, 1]] * 5, np.float32)
    found = lawful(tree, MASK, Labelled(obs, np.array([3, 3, 2, 1, 1, 2, 2, 2])))
    asked = np.array([[0, 1, 1, 1], [0, 0, 1, 1], [0, 0, 1, 0], [0, 0, 0, 0]], np.float32)
    assert found.action[ir.apply(found, asked)].tolist() == [1, 3, 2, 0]


@pytest.fixture(scope="module")
def tictactoe():
    found = find(TICTACTOE)
    yield found
    found.close()


@pytest.mark.parametrize("algorithm", ["maviper", "iviper", "imitation"])
def test_pettingzoo_plays_the_trees_to_the_end(tictactoe, monkeypatch, algorithm):
    """TicTacToe's own board asserts that moves are legal: one illegal action would be an InputError."""
    monkeypatch.setattr(held_out, "EVALUATION_EPISODES", 6)
    settings = Settings.of({"algorithm": algorithm, **SMALL}, tictactoe)
    profile = extract(tictactoe, Player(tictactoe), settings)
    chance = Uniform(tictactoe)
    for seat in range(2):
        trees = agent_policies(tictactoe, [policy.grown for policy in profile.agents])
        assert all(np.array_equal(a.tree.action, b.tree.action) for a, b in zip(trees, profile.agents, strict=True))

        lineup = among(tictactoe, [profile.agents[seat]], [chance.start_episodes(range(tictactoe.games))] * 2)
        (played, *_) = rollout(tictactoe, lineup, range(tictactoe.games))
        assert played.alive[0].tolist() == [[True, False]] * tictactoe.games  # one has the turn
        assert set(played.returns[0]) <= {-1.0, 0.0, 1.0} and (played.returns.sum(axis=0) == 0).all()


def test_generated_code_acts_legally_in_pettingzoos_own_loop(tictactoe, monkeypatch):
    monkeypatch.setattr(held_out, "EVALUATION_EPISODES", 4)
    settings = {**SMALL, "algorithm": "iviper", "iterations": 1}
    code = Code(extract(tictactoe, Player(tictactoe), Settings.of(settings, tictactoe)))
    decisions, illegal = play_tictactoe(code, episodes=6)
    assert decisions == code.asked > 0 and illegal == code.different == 0


def test_refined_trees_are_legal_and_no_deeper_than_grown_ones(tictactoe, monkeypatch):
    monkeypatch.setattr(held_out, "EVALUATION_EPISODES", 6)
    for name, value in (("FIRST", 8), ("LAST", 16), ("MOVES", 8)):
        monkeypatch.setattr(refine, name, value)
    given_ = {**SMALL, "algorithm": "iviper", "max_depth": 2, "refinement": 4 * refine.round_cost()}
    said = []
    profile = extract(tictactoe, Player(tictactoe), Settings.of(given_, tictactoe), Running(said.append))
    assert [each.stage for each in said[-4:]] == [REFINING] * 4
    for place, policy in enumerate(profile.agents):
        mask = tictactoe.mask(place)
        assert not list(illegal_leaves(policy.tree, mask)) and ir.depth(policy.tree).max() <= 2 + 8
        ring = Arena(tictactoe, lawful_expert(Player(tictactoe), tictactoe), [place], range(100))
        ring.scores([[policy.grown]], 8)
        moves = refine.proposals(ring, [policy.grown], [[]], refine.Limits(2), np.random.default_rng(0))
        assert len(moves) > 8
        for (tree,) in moves:
            assert not list(illegal_leaves(deploy_tree(tree), mask)) and ir.depth(tree).max() <= 2 + 8


def test_an_expert_is_made_legal_by_its_q_or_refused(tictactoe):
    state = tictactoe.start_from_seeds([1])
    state = tictactoe.step(state, np.array([[4, 4]]))  # the middle is taken, and was worth most
    seen = tictactoe.observe(state)
    expert = lawful_expert(Player(tictactoe), tictactoe)
    assert Player(tictactoe).act([1], seen, state).tolist() == [[4]]
    assert expert.act([1], seen, state).tolist() == [[0]]
    assert lawful_expert(Unweighted(expert), tictactoe).expert is expert
    silent = Player(tictactoe)
    silent.q = lambda *_: (_ for _ in ()).throw(NotImplementedError())
    with pytest.raises(InputError, match="illegal actions for player_2, and has no Q"):
        lawful_expert(silent, tictactoe).act([1], seen, state)


def test_illegal_actions_weigh_nothing(tictactoe):
    """The least Q among nine actions is that of an illegal one; among legal ones it is another."""
    state = tictactoe.start_from_seeds([1])
    state = tictactoe.step(state, np.array([[1, 1]]))  # an edge: worth least of all, with the other three edges
    seen, expert = tictactoe.observe(state), Player(tictactoe)
    wanted = np.array([[4, 4]])
    worth = expert.worth(seen[1])[0]
    legal = [action for action in range(9) if action != 1]
    found = iviper_weights(tictactoe, expert, seen, state, wanted, 1)
    assert found.tolist() == [worth[4] - worth[legal].min()]
    assert iviper_weights(tictactoe, expert, seen, state, wanted, 0).tolist() == [0.0]  # not its turn


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"algorithm": "fitted-q"}, "fitted-q takes no heed"),
        ({"algorithm": "rgmdt", "max_leaves": 4}, "rgmdt takes no heed"),
        ({"algorithm": "maviper", "preset": "released"}, "authors' code takes no heed"),
        ({"algorithm": "iviper", "max_depth": 60}, "a tree may be too deep"),
    ],
)
def test_what_takes_no_heed_of_masks_is_refused(tictactoe, given, said):
    settings = Settings.of(given, tictactoe)
    with pytest.raises(InputError, match=said):
        extract(tictactoe, Player(tictactoe), settings)
