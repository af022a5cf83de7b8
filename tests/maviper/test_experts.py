"""Experts: the shipped one is good and honest about itself; files are refused with the fault; training works."""

import json

import numpy as np
import pytest

from codegen.errors import InputError, MissingToolError, UnknownNameError
from maviper.evaluate import metrics
from maviper.experts import store
from maviper.experts.network import AS_GIVEN
from maviper.worlds.physical_deception import ADVERSARIES, DEFENDERS


def test_the_shipped_expert_is_worth_imitating(world, expert):
    """On episodes that neither training nor its card used."""
    success = metrics.success(world, expert.policies(), range(9_000_000, 9_004_000))[0]
    assert success[DEFENDERS].interval[0] >= 0.85
    assert success[ADVERSARIES].interval[0] >= 0.50


def test_its_card_says_what_made_it_and_what_was_measured(world, expert):
    card = expert.card
    assert card["command"].startswith("maviper train physical-deception --seed ")
    assert {"python", "torch", "numpy", "mpe2", "maviper"} <= set(card["versions"])
    first, episodes = card["measured"]["first_episode_seed"], card["measured"]["episodes"]
    success = metrics.success(world, expert.policies(), range(first, first + episodes))
    for squared, table in zip(world.squared_radii, success, strict=True):
        for team, won in table.items():
            assert card["measured"][f"{team} success r={squared**0.5:.3g}"][0] == won.value


def q_directly(expert, agent, observations, joint):
    """The critic written out: one row, one-hot actions, float64."""
    one_hot = np.concatenate([np.eye(n)[action] for n, action in zip(expert.n_actions, joint, strict=True)])
    x = np.concatenate([*[row.astype(np.float64) for row in observations], one_hot])
    for layer in (1, 2, 3):
        name = f"{expert.agents[agent]}.critic.{layer}"
        x = x @ expert.tensors[f"{name}.weight"].astype(np.float64) + expert.tensors[f"{name}.bias"]
        x = np.maximum(x, 0) if layer < 3 else x
    return x[0]


def test_split_first_layer_gives_the_same_q(world, expert):
    state = world.start(20, np.random.default_rng(0))
    observations = world.observe(state)
    given = np.random.default_rng(1).integers(5, size=(20, 3))
    joint = np.array([[0, AS_GIVEN, 3], [4, AS_GIVEN, 1]])
    for agent in range(3):
        found = expert.q(agent, observations, joint, given)
        for row in range(20):
            for column, asked in enumerate(joint):
                actions = [given[row, k] if action == AS_GIVEN else action for k, action in enumerate(asked)]
                wanted = q_directly(expert, agent, [seen[row] for seen in observations], actions)
                assert found[row, column] == pytest.approx(wanted, rel=1e-9)


def test_files_are_equal_each_time_and_read_back(expert):
    data = store.encode(expert.tensors, expert.card)
    assert data == store.encode(dict(reversed(expert.tensors.items())), expert.card)
    again = store.decode(data, "x")
    assert all((again.tensors[name] == tensor).all() for name, tensor in expert.tensors.items())


def test_bad_expert_files_are_refused(expert, tmp_path):
    data = store.encode(expert.tensors, expert.card)
    for bad in (b"", b"\x80\x04pickle", data[:100], data[:-5], b"\xff" * 64, b"{}" * 100):
        with pytest.raises(InputError, match="not an expert file"):
            store.decode(bad, "x")
    with pytest.raises(InputError, match="sound expert"):
        store.decode(store.encode(expert.tensors, {**expert.card, "hidden": 32}), "x")
    broken = {**expert.tensors, "agent_0.actor.1.bias": np.full(64, np.nan, np.float32)}
    with pytest.raises(InputError, match=r"agent_0.actor.1.bias"):
        store.decode(store.encode(broken, expert.card), "x")
    with pytest.raises(UnknownNameError, match="physical-deception"):
        store.decode(store.encode(expert.tensors, {**expert.card, "world": "physical-decption"}), "x")
    with pytest.raises(UnknownNameError, match="did you mean 'physical-deception'"):
        store.load("physical-decption")
    with pytest.raises(InputError, match="cannot read"):
        store.load(str(tmp_path / "none.safetensors"))


def test_a_run_folder_is_an_expert(expert, tmp_path):
    (tmp_path / "expert.safetensors").write_bytes(store.encode(expert.tensors, expert.card))
    assert store.load(str(tmp_path))[0].card == expert.card


def test_training_without_torch_says_what_to_install(world, tmp_path, monkeypatch):
    import sys

    from maviper.experts.train import train

    monkeypatch.setitem(sys.modules, "torch", None)
    with pytest.raises(MissingToolError, match=r"maviper\[train\]"):
        train(world, tmp_path, {}, lambda checkpoint, total: None)


@pytest.mark.train
@pytest.mark.slow
def test_training_learns_and_repeats(world, tmp_path):
    """A small training: success rises, the folder is complete, the same seed gives the same bytes."""
    from maviper.experts.train import train

    settings = {"steps": 60_000, "games": 256, "steps_per_update": 200, "checkpoint_steps": 12_800, "seed": 3}
    seen = []
    card = train(world, tmp_path / "a", settings, lambda checkpoint, total: seen.append(checkpoint))
    assert len(seen) >= 4 and max(checkpoint.score for checkpoint in seen) > 0.05
    loaded, _ = store.load(str(tmp_path / "a"))
    assert loaded.card == card
    lines = [json.loads(line) for line in (tmp_path / "a" / "metrics.jsonl").read_text().splitlines()]
    assert [line["steps"] for line in lines] == [checkpoint.steps for checkpoint in seen]
    train(world, tmp_path / "b", settings, lambda checkpoint, total: None)
    for name in ("expert.safetensors", "metrics.jsonl", "config.json"):
        assert (tmp_path / "a" / name).read_bytes() == (tmp_path / "b" / name).read_bytes()


@pytest.mark.train
def test_numpy_and_torch_networks_agree(world):
    import torch

    from maviper.experts.maddpg import Learner, Settings

    learner = Learner(world, Settings(buffer=1_000))
    expert = store.decode(store.encode(learner.tensors(), {"world": world.name, "hidden": 64}), "x")
    observations = world.observe(world.start(64, np.random.default_rng(0)))
    acted = np.random.default_rng(1).integers(5, size=(64, 3))
    joint = learner._joint(observations)
    with torch.no_grad():
        logits = learner.actor(learner._views(joint)).numpy()
        q = learner.critic(learner._critic_input(joint, learner._one_hot(torch.from_numpy(acted)))).numpy()[..., 0]
    for agent in range(3):
        assert (expert.act(agent, observations[agent]) == logits[agent].argmax(axis=1)).all()
        asked = expert.q(agent, observations, np.full((1, 3), AS_GIVEN), acted)[:, 0]
        assert asked == pytest.approx(q[agent], rel=1e-4, abs=1e-5)
