"""Gaussian actors: what they draw and how likely that is, what their experts give, trainings that repeat and resume."""

from dataclasses import replace

import numpy as np
import pytest

from codegen.errors import InputError
from maviper.experts import network
from maviper.experts.cards import Request
from maviper.experts.network import give_numbers
from maviper.worlds import find

DECEPTION = "physical-deception,continuous=1"
TINY = {"games": 128, "checkpoint_steps": 6_400, "steps": 19_200, "hidden": 16}
FILES = ("expert.safetensors", "metrics.jsonl", "config.json", "learning_curve.svg")


@pytest.fixture
def quick(monkeypatch):
    """Fewer episodes a judgement."""
    from maviper.experts.training import train

    monkeypatch.setattr(train, "CHECKPOINT_EPISODES", 50)
    monkeypatch.setattr(train, "FINAL_EPISODES", 50)


def test_an_expert_gives_numbers_within_its_bounds():
    world, rng = find(DECEPTION, giving=True), np.random.default_rng(1)
    tensors = {
        name: rng.normal(size=shape).astype(np.float32) for name, shape in network.shapes(world, 8, "actor").items()
    }
    expert = network.build_expert(world, tensors, {"world": world.name})
    seen = world.observe(world.start_from_seeds(range(40)))
    given = expert.act(range(3), seen)
    assert given.shape == (40, 3, 5) and given.dtype == np.float32
    assert 0.0 <= given.min() < 0.2 and 0.8 < given.max() <= 1.0
    one = [each[:1] for each in seen]
    assert np.array_equal(expert.act([2], one)[0, 0], given[0, 2])
    assert np.array_equal(give_numbers(expert.logits(1, seen[1]), *expert.bounds[1]), given[:, 1])
    with pytest.raises(InputError, match="no critic"):
        expert.q(0, seen, None, np.zeros((1, 3), int), np.zeros((40, 3), int))


def test_minus_one_is_the_low_bound_and_one_the_high():
    low, high = np.array([-2.0, 0.0]), np.array([2.0, 1.0])
    parts = np.array([[-1.0, -1.0], [1.0, 1.0], [0.0, 0.5], [-3.0, 9.0]])
    assert give_numbers(parts, low, high).tolist() == [[-2.0, 0.0], [2.0, 1.0], [0.0, 0.75], [-2.0, 1.0]]


@pytest.mark.train
@pytest.mark.parametrize("shared", [0, 1])
def test_draws_are_as_likely_as_torch_says(shared):
    import torch

    from maviper.experts.training.mappo import Mappo, Settings

    world = find("cooperative-navigation,agents=2,continuous=1", giving=True)
    trainer = Mappo(world, Settings(**TINY, shared=shared), "cpu")
    with torch.no_grad():
        trainer.head.spread.parameters[0] += torch.linspace(-1, 1, 5)
    seen = trainer.joint.tensor(world.observe(world.start_from_seeds(range(2_000))))
    with torch.no_grad():
        means = trainer.actor(trainer.joint.views(seen))
        drawn = trainer.head.draw(means, seen)
        likely, entropy = trainer.head.log_probabilities(means, seen, torch.from_numpy(drawn.swapaxes(0, 1)))
    deviations = 0.6 * torch.linspace(-1, 1, 5).exp()
    normal = torch.distributions.Normal(means, deviations)
    assert torch.allclose(likely, normal.log_prob(torch.from_numpy(drawn)).sum(dim=2), atol=1e-4)
    assert torch.allclose(entropy, normal.entropy().sum(dim=2), atol=1e-4)
    assert np.allclose((drawn - means.numpy()).std(axis=(0, 1)), deviations, rtol=0.05)
    given = trainer.head.hand_over(drawn)
    assert given.shape == (2_000, 2, 5) and given.min() == 0.0 and given.max() == 1.0


@pytest.mark.train
def test_outputs_that_an_agent_has_not_count_for_nothing():
    """Of two agents one gives two numbers, the other one: likelihood and entropy are those of what each has."""
    import math

    import torch

    from maviper.experts.training.mappo import Mappo, Settings
    from maviper.experts.training.nets import Numbers

    world = find("cooperative-navigation,agents=2,continuous=1", giving=True)
    world.outputs = world.outputs[0][:2], world.outputs[1][:1]
    trainer = Mappo(world, Settings(**TINY), "cpu")
    assert isinstance(trainer.head, Numbers)
    means, drawn = torch.zeros(2, 3, 2), torch.ones(3, 2, 2)
    likely, entropy = trainer.head.log_probabilities(means, torch.zeros(3, 1), drawn)
    alone = float(torch.distributions.Normal(0.0, 0.6).log_prob(torch.tensor(1.0)))
    assert likely[:, 0].tolist() == pytest.approx([2 * alone, alone])
    one = math.log(0.6) + math.log(2 * math.pi * math.e) / 2
    assert entropy[:, 0].tolist() == pytest.approx([2 * one, one])
    assert trainer.head.hand_over(np.ones((2, 3, 2), np.float32))[:, 1].tolist() == [[1.0, 0.0]] * 3


@pytest.mark.train
@pytest.mark.parametrize("more", [{}, {"past": 0.25}, {"shared": 1}])
def test_a_training_repeats_resumes_and_makes_an_expert(tmp_path, more, quick):
    from maviper.experts.training.train import train

    world = find("cooperative-navigation,agents=2,continuous=1" if "shared" in more else DECEPTION, giving=True)
    asked = Request("mappo", overrides={**TINY, "minibatch": 1_600, "seed": 3, **more})
    card = train(world, tmp_path / "whole", asked)
    assert card["networks"] == "actor" and "critic" not in card["played"]

    class Killed(Exception):
        pass

    def kill(checkpoint, total):
        if checkpoint.steps == 6_400:
            raise Killed

    with pytest.raises(Killed):
        train(world, tmp_path / "cut", asked, kill)
    train(world, tmp_path / "cut", asked, resume=True)
    for file in FILES:
        assert (tmp_path / "cut" / file).read_bytes() == (tmp_path / "whole" / file).read_bytes(), file
    expert, played = network.load(str(tmp_path / "whole"))
    assert played.name == world.name and expert.bounds
    first, last = (
        train(world, tmp_path / f"{seed}", replace(asked, overrides={**asked.overrides, "seed": seed}))
        for seed in (3, 4)
    )
    assert first["score"] == card["score"] != last["score"]


@pytest.mark.train
def test_it_learns_by_reward_alone(tmp_path, quick):
    """Enough steps that one agent finds its one target: it comes nearer than at first."""
    from maviper.experts.training.train import train

    world = find("cooperative-navigation,agents=1,continuous=1", giving=True)
    sizes = {"games": 256, "steps": 128_000, "hidden": 32, "checkpoint_steps": 64_000, "minibatch": 1_600}
    shown = []
    train(
        world,
        tmp_path,
        Request("mappo", overrides={**sizes, "seed": 0}),
        lambda checkpoint, total: shown.append(checkpoint),
    )
    assert shown[-1].measured["agents"].value < 0.5 < shown[0].measured["agents"].value + 0.3


@pytest.mark.train
@pytest.mark.parametrize(
    ("asked", "said"),
    [
        (Request("maddpg"), "--algorithm maddpg is for numbered actions"),
        (Request(recipe="clone"), "--recipe clone is for numbered actions"),
        (Request(against=("physical-deception",)), "--against is for numbered actions"),
        (Request(overrides={"scripted": 0.5}), "scripts choose among numbered actions"),
    ],
)
def test_what_needs_numbered_actions_is_refused(tmp_path, asked, said):
    from maviper.experts.training.train import train

    with pytest.raises(InputError, match=said):
        train(find(DECEPTION, giving=True), tmp_path, asked)
