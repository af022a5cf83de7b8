"""Best responses: labels that know the mates' trees, and a round of its own for each member of a team."""

from dataclasses import replace
from itertools import product

import numpy as np
import pytest

from codegen import policy_json
from maviper.cli import main
from maviper.episodes.play import points, rollout
from maviper.evaluation import held_out
from maviper.experts.finding import find_expert
from maviper.extraction.algorithms import extract
from maviper.extraction.arena import MATCHED, halving_by_member
from maviper.extraction.dataset import Dataset
from maviper.extraction.growth import weights
from maviper.extraction.growth.weights import LEAST_GAIN, Replies
from maviper.extraction.journal import Journal
from maviper.extraction.settings import BEST_RESPONSE, OUR_RUNGS, PARTS, Settings
from tests.support.coordination import best_of_three, worth

SMALL = {"iterations": 3, "rollouts": 12, "selection_episodes": 40, "max_depth": 2, "refinement": 0, "patience": 9}


@pytest.fixture(autouse=True)
def quick(monkeypatch):
    monkeypatch.setattr(held_out, "EVALUATION_EPISODES", 10)


def settings_of(world, **given):
    return Settings.of({**SMALL, "algorithm": BEST_RESPONSE, **given}, world)


def met(world, expert, episodes=60):
    """Points of expert episodes, and their states."""
    (played,) = rollout(world, [expert] * len(world.agents), range(episodes))
    observations, state = points(played)
    labels = expert.act(range(len(world.agents)), observations, state)
    ones = np.ones(labels.shape)
    return Dataset(observations, labels, ones, ones.astype(bool)), state


# --- labels


@pytest.mark.parametrize("game", ["coordination,rule=penalty", "coordination,rule=climbing", "cooperative-navigation"])
def test_labels_are_the_best_replies_by_q_less_what_it_also_promises_beside_experts(game):
    expert, world = find_expert(game)
    data, state = met(world, expert)
    acting, rng = data.labels.copy(), np.random.default_rng(1)
    changed = rng.random(len(data)) < 0.5
    acting[changed, 1:] = rng.integers(3, size=(int(changed.sum()), acting.shape[1] - 1))
    reply = Replies(world, expert, 0).to(acting, data, state)
    labels = reply.labels
    replied = 0
    for row in range(0, len(data), 3):
        seen, usual = [each[row : row + 1] for each in data.observations], data.labels[row, 0]
        beside, among = (q_of(expert, world, seen, state[np.array([row])], each[row]) for each in (acting, data.labels))
        gains = beside - beside[usual] - np.maximum(0, among - among[usual])
        least = LEAST_GAIN * (beside.max() - beside.min())
        wanted = int(gains.argmax()) if gains.max() > least else usual
        replied += wanted != usual
        assert labels[row] == wanted
        assert reply.worth[row] == pytest.approx(max(0.0, gains[wanted] - gains.min()))
    assert replied and (labels[~changed] == data.labels[~changed, 0]).all()


def q_of(expert, world, seen, state, acting):
    """Q of each action of the first agent in one state, beside what the others do."""
    joint = np.tile(acting, (len(world.actions[0]), 1))
    joint[:, 0] = np.arange(len(joint))
    return expert.q(0, seen, state, joint, acting[None])[0]


def test_no_error_of_q_that_mates_have_no_part_in_changes_a_label():
    """A critic whose values of an agent's actions are noise, and the same whatever the others do."""
    expert, world = find_expert("physical-deception")
    data, state = met(world, expert)
    noise, rng = np.random.default_rng(0).normal(size=(len(data), 5)), np.random.default_rng(1)
    acting = rng.integers(5, size=data.labels.shape)
    acting[:, 0] = data.labels[:, 0]
    for part in (0.0, 1.0):  # of the others' actions in what Q says of them alone
        replies = Replies(world, expert, 1)
        replies.expert = Additive(noise, part)
        numbered = replace(data, observations=(np.arange(len(data))[:, None], *data.observations[1:]))
        assert (replies.to(acting, numbered, state).labels == data.labels[:, 1]).all()


class Additive:
    """A critic without interaction: noise for each own action, and something for the others'."""

    def __init__(self, noise, part):
        self.noise, self.part = noise, part

    def q(self, agent, observations, state, joint, given):
        return self.noise[observations[0][:, 0]] + self.part * given[:, [2]]


def test_an_illegal_action_is_no_reply_and_counts_in_no_worth(monkeypatch):
    expert, world = find_expert("physical-deception")
    data, state = met(world, expert)
    acting = np.random.default_rng(1).integers(5, size=data.labels.shape)
    free = Replies(world, expert, 1).to(acting, data, state)
    legal = np.ones((len(data), 5), dtype=bool)
    legal[np.arange(len(data)), free.labels] = free.labels == data.labels[:, 1]
    monkeypatch.setattr(weights, "legal_actions", lambda *given: legal)
    reply = Replies(world, expert, 1).to(acting, data, state)
    rows = np.arange(len(data))
    assert legal[rows, reply.labels].all() and (reply.labels != free.labels).any()
    assert (reply.worth <= free.worth + 1e-9).all() and (reply.worth >= 0).all()


def test_q_is_asked_again_only_where_a_mate_acts_otherwise():
    expert, world = find_expert("physical-deception")
    data, state = met(world, expert)
    kept, rng, asked = Replies(world, expert, 1), np.random.default_rng(0), []

    class Counting:
        def q(self, agent, observations, state, joint, given):
            asked.append(len(given))
            return expert.q(agent, observations, state, joint, given)

    kept.expert = Counting()
    for size, change in ((800, 0), (1_200, 30), (1_500, 0)):
        part, acting = data.before(len(data) - size), data.labels[:size].copy()
        acting[:change, 2] = rng.integers(5, size=change)
        acting[:, 1] = rng.integers(5, size=size)  # what the agent itself does is not looked at
        asked.clear()
        reply = kept.to(acting, part, state[:size])
        fresh = Replies(world, expert, 1).to(acting, part, state[:size])
        assert (reply.labels == fresh.labels).all() and reply.worth == pytest.approx(fresh.worth)
        assert sum(asked) <= {800: 800, 1_200: 430, 1_500: 300}[size]


def test_replies_close_the_gap_that_joint_rollouts_leave_in_one_shot_games():
    """All or nothing: each rung on its own, averaged over tables, by the known best team of small trees."""
    gaps = dict.fromkeys(OUR_RUNGS, 0.0)
    for table, rung in product(range(4), OUR_RUNGS):
        expert, world = find_expert(f"coordination,kinds=2,agents=3,payoff=100,table={table}")
        settings = settings_of(world, iterations=5, rollouts=60, selection_episodes=100, seed=table, **OUR_RUNGS[rung])
        profile = extract(world, expert, settings)
        gaps[rung] += (best_of_three(world, 2) - worth(world, profile.agents)) / 4
    assert gaps["best-response"] < 0.7 * gaps["joint-selection"]


# --- the round of each member


def test_members_take_arms_of_different_rounds_where_these_are_best():
    rng, best, spent = np.random.default_rng(0), (3, 8, 5), []

    def scores(teams, episodes):
        spent.append(len(teams) * episodes)
        right = (teams == best).mean(axis=1)
        return right[:, None] + 0.3 * rng.normal(size=(len(teams), episodes))

    warm = [np.zeros(4)] * 12
    orders = halving_by_member(scores, warm, 3, 2_400, np.random.default_rng(1))
    assert [order[0] for order in orders] == list(best)
    assert all(len(set(order)) == len(order) == 4 for order in orders)
    assert sum(spent) <= 2_400 + 2 * 12 * MATCHED


def test_few_rounds_race_as_teams_at_once():
    def scores(teams, episodes):
        return np.repeat((teams == (1, 0)).all(axis=1)[:, None].astype(float), episodes, axis=1)

    assert halving_by_member(scores, [np.zeros(0)] * 2, 2, 64, np.random.default_rng(0)) == [[1, 0], [0, 1]]
    assert halving_by_member(lambda teams, n: np.zeros((len(teams), n)), [np.zeros(0)], 2, 9, None) == [[0], [0]]


# --- whole extractions


@pytest.fixture(scope="module")
def deception():
    return find_expert("physical-deception@maddpg")


def test_a_run_goes_on_to_the_same_bytes(deception, tmp_path):
    expert, world = deception
    texts = []
    for _ in range(2):
        profile = extract(world, expert, settings_of(world), journal=Journal(tmp_path))
        texts.append(policy_json.dumps(profile))
        for step in sorted(tmp_path.rglob("*.safetensors"))[len(texts) :: 2]:
            step.unlink()
    assert texts[0] == texts[1] == policy_json.dumps(extract(world, expert, settings_of(world)))
    told = profile.provenance.training
    assert {"best_iteration_adversaries", "best_iteration_agent_0", "best_iteration_agent_1"} <= set(told)
    assert profile.provenance.algorithm == BEST_RESPONSE and not set(PARTS) & set(told)


def test_an_expert_without_q_cannot_be_asked_for_replies(capsys, tmp_path):
    asked = ["--algorithm", "best-response", "--critic", "none", "-o", str(tmp_path / "p.json")]
    assert main.run(["extract", "physical-deception", *asked]) == 2
    assert "choose --critic learned or measured, or --set labels=expert" in capsys.readouterr().err
