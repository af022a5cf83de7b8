"""Training where actions may be illegal and agents take turns, against PettingZoo's own TicTacToe."""

import numpy as np
import pytest

from codegen.paths import illegal_leaves
from maviper.cli import main
from maviper.episodes.play import rollout
from maviper.evaluation import held_out
from maviper.experts import network
from maviper.experts.cards import Request
from maviper.experts.finding import Unweighted
from maviper.extraction.algorithms import extract
from maviper.extraction.settings import Settings
from maviper.worlds import find
from maviper.worlds.world import World, legal_in

TICTACTOE = "pettingzoo.classic.tictactoe.tictactoe:env,wrap=turns+flatten+rivals,max_steps=9"
SMALL = {"games": 32, "hidden": 16, "minibatch": 64, "steps": 288}


@pytest.fixture(scope="module")
def tictactoe():
    found = find(TICTACTOE)
    yield found
    found.close()


def test_a_network_takes_its_best_legal_action(tictactoe):
    """The last bias wants cell 4, then cell 0, whatever is observed."""
    tensors = {name: np.zeros(shape, np.float32) for name, shape in network.shapes(tictactoe, 4, "actor").items()}
    for agent in tictactoe.agents:
        tensors[f"{agent}.actor.3.bias"][[0, 4]] = 1, 2
    expert = network.build_expert(tictactoe, tensors, {})
    (played,) = rollout(tictactoe, [expert] * 2, [0])
    turns = played.alive[:, 0].argmax(axis=1)
    assert turns[:3].tolist() == [0, 1, 0]
    assert [int(played.actions[step, 0, turns[step]]) for step in range(3)] == [4, 0, 1]


@pytest.mark.train
def test_learners_never_play_an_illegal_action_and_their_loss_knows_none(tictactoe):
    """PettingZoo's board asserts that moves are legal: one illegal action would be an InputError."""
    import torch

    from maviper.experts.training.mappo import Mappo, Settings

    trainer = Mappo(tictactoe, Settings(**SMALL, past=0.25), "cpu")
    with torch.no_grad():  # illegal actions are what the networks want most
        trainer.actor.parameters[-1][..., 4] = 50.0
    trainer.advance()
    played = trainer._collect()
    seen = played.seen[:-1].flatten(0, 1)
    acted = torch.from_numpy(played.acted).flatten(0, 1)
    logits = trainer.actor(trainer.joint.views(seen))
    barred = trainer.joint.mask_actions(seen)
    for agent, features in enumerate(tictactoe.features):
        own = trainer.joint.views(seen)[agent][:, : len(features)].numpy()
        legal = legal_in(tictactoe.mask(agent), own)
        turn = played.acting[..., agent].ravel()
        assert legal[turn].any(axis=1).all() and (barred[agent].numpy()[turn] == 0).tolist() == legal[turn].tolist()
        assert legal[turn, acted[turn, agent].numpy()].all()
    chances = (logits + barred).softmax(dim=2)
    assert (chances[barred < 0] == 0).all()
    chosen, entropy = trainer._log_probabilities(seen, acted)
    turns = torch.from_numpy(played.acting).permute(2, 0, 1).flatten(1)
    (slope,) = torch.autograd.grad((chosen + entropy)[turns].sum(), trainer.actor.parameters[-1:])
    assert torch.isfinite(slope).all() and torch.isfinite(entropy).all()


@pytest.mark.train
def test_what_is_paid_while_an_agent_waits_counts_for_its_move_before(tictactoe):
    """One game: the agent moves, waits, moves, waits, and wins with the opponent's last move."""
    import torch

    from maviper.experts.training.mappo import Mappo, Settings

    trainer = Mappo(tictactoe, Settings(**SMALL, gamma=0.9, trace=0.5), "cpu")
    rewards = torch.tensor([[[0.0], [0.0], [0.0], [1.0]]])
    playing, goes_on = torch.ones(1, 4, 1), torch.tensor([[[1.0], [1.0], [1.0], [0.0]]])
    found = trainer._advantages(rewards, torch.zeros(1, 5, 1), playing, goes_on)
    assert found.flatten().tolist() == pytest.approx([0.45**3, 0.45**2, 0.45, 1.0])


@pytest.mark.train
def test_the_critic_is_asked_of_legal_actions_and_plays_no_longer_than_the_training(tictactoe, tmp_path, monkeypatch):
    from maviper.experts.training import off_policy, train

    monkeypatch.setattr(train, "FINAL_EPISODES", 20)
    monkeypatch.setattr(train, "CHECKPOINT_EPISODES", 20)
    monkeypatch.setattr(held_out, "EVALUATION_EPISODES", 8)
    monkeypatch.setattr(off_policy, "USUAL_STEPS", 10 * off_policy.CriticSettings.updates)
    drawn = []
    monkeypatch.setattr(type(tictactoe), "draw_actions", lambda *given: drawn.append(1) or World.draw_actions(*given))
    card = train.train(tictactoe, tmp_path, Request(overrides={**SMALL, "checkpoint_steps": 288}))
    assert drawn and 288 <= card["played"]["critic"] <= 288 + 9 * 32
    expert, _ = network.load(str(tmp_path), tictactoe)
    for one in (expert, Unweighted(expert)):
        given = {"algorithm": "maviper", "iterations": 1, "rollouts": 6, "selection_episodes": 6, "max_depth": 2}
        profile = extract(tictactoe, one, Settings.of(given, tictactoe))
        assert not any([*illegal_leaves(policy.tree, tictactoe.mask(k))] for k, policy in enumerate(profile.agents))


@pytest.mark.train
def test_the_command_trains_and_says_what_takes_no_heed_of_masks(tmp_path, capsys):
    assert main.run(["train", TICTACTOE, "--recipe", "paper", "-o", str(tmp_path / "x")]) == 2
    assert "maddpg takes no heed of illegal actions" in capsys.readouterr().err
