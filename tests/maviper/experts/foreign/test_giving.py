"""Experts that give numbers: the library's own to rounding; refused where they mean something else."""

import json
from itertools import pairwise

import numpy as np
import pytest

from codegen.errors import InputError
from maviper.experts import from_sb3
from maviper.experts.finding import find_expert
from maviper.experts.foreign.layers import LayersExpert, Linear
from maviper.worlds import find
from tests.support.zips import changed, data_of

PENDULUM = "gymnasium:Pendulum-v1"
KINDS = {
    "PPO": {"n_steps": 64, "batch_size": 64, "n_epochs": 1},
    "A2C": {"use_sde": True},
    "SAC": {"learning_starts": 20},
    "TD3": {"learning_starts": 20},
    "DDPG": {"learning_starts": 20},
}


@pytest.fixture(scope="module")
def world():
    return find(PENDULUM, giving=True)


def observations(count=3_000):
    rng = np.random.default_rng(5)
    angle = rng.uniform(-np.pi, np.pi, count)
    return np.column_stack([np.cos(angle), np.sin(angle), rng.uniform(-8, 8, count)]).astype(np.float32)


def layers(*sizes, scale=1.0):
    rng = np.random.default_rng(0)
    return [
        Linear(*(scale * rng.normal(size=shape).astype(np.float32) for shape in ((after, before), (after,))))
        for before, after in pairwise(sizes)
    ]


def test_means_are_clipped_and_squashed_ones_spread_over_the_bounds(world):
    obs, net = observations(), layers(3, 8, 1)
    hidden = np.tanh(obs @ net[0].weight.T + net[0].bias)
    plain = (hidden @ net[1].weight.T + net[1].bias)[:, None]
    means = LayersExpert(world, net, "tanh", "means").act([0], [obs])
    assert means.shape == (len(obs), 1, 1) and means.dtype == np.float32
    assert np.allclose(means, np.clip(plain, -2, 2), atol=1e-5) and (np.abs(means) == 2).any()
    squashed = LayersExpert(world, net, "tanh", "squashed")
    assert np.allclose(squashed.act([0], [obs]), 2 * np.tanh(plain), atol=1e-5) and squashed.critic == "none"


def test_outputs_and_world_must_agree(world):
    with pytest.raises(InputError, match="outputs=means or squashed"):
        LayersExpert(world, layers(3, 1), "tanh", "logits")
    with pytest.raises(InputError, match="gives 1"):
        LayersExpert(world, layers(3, 2), "tanh", "means")
    with pytest.raises(InputError, match="agents have actions"):
        LayersExpert(find("gymnasium:CartPole-v1"), layers(4, 2), "tanh", "squashed")
    with pytest.raises(InputError, match="there is no end of actions to play"):
        find_expert("tests.support.steering:pulling", critic="measured", giving=True)
    with pytest.raises(InputError, match="continuous actions"):
        find_expert("tests.support.steering:pulling")


# --- the library's own


@pytest.fixture(scope="module")
def models(tmp_path_factory):
    """A model of each kind, trained for a moment, and its zip."""
    sb3, torch = pytest.importorskip("stable_baselines3"), pytest.importorskip("torch")
    torch.set_num_threads(1)
    folder, found = tmp_path_factory.mktemp("sb3"), {}
    for kind, settings in KINDS.items():
        own = {"policy_kwargs": {"net_arch": [16, 16]}, **settings}
        learner = getattr(sb3, kind)("MlpPolicy", "Pendulum-v1", seed=1, device="cpu", **own)
        learner.learn(80)
        learner.save(folder / f"{kind}.zip")
        found[kind] = learner, folder / f"{kind}.zip"
    return found


@pytest.mark.interop
@pytest.mark.train
@pytest.mark.parametrize("kind", KINDS)
def test_numbers_are_the_librarys_to_rounding(kind, models, world):
    learner, file = models[kind]
    expert, obs = from_sb3(file, world), observations()
    theirs, _ = learner.predict(obs, deterministic=True)
    found = expert.act([0], [obs])[:, 0]
    assert np.abs(found - theirs).max() < 2e-6 < theirs.std()
    assert expert.card["algorithm"].startswith(kind) and expert.critic == "none"


@pytest.mark.interop
@pytest.mark.train
def test_a_file_of_other_bounds_or_another_world_is_refused(models, tmp_path, world):
    file = models["SAC"][1]
    data = data_of(file)
    with pytest.raises(InputError, match="a Box, and the world's agents choose"):
        from_sb3(file, find("gymnasium:CartPole-v1"))
    for end, said in (("low", "[-1.]"), ("high", "[2. 2.]"), ("high", "unknown")):
        other = data | {"action_space": data["action_space"] | {end: said}}
        with pytest.raises(InputError, match=f"have {end}"):
            from_sb3(changed(file, tmp_path / "other.zip", data=json.dumps(other)), world)
    with pytest.raises(InputError, match="use_sde"):
        sde = data | {"policy_kwargs": data["policy_kwargs"] | {"use_sde": True}}
        from_sb3(changed(file, tmp_path / "sde.zip", data=json.dumps(sde)), world)
    with pytest.raises(InputError, match="squash_output"):
        squash = data | {"policy_kwargs": data["policy_kwargs"] | {"squash_output": True}}
        from_sb3(changed(file, tmp_path / "squash.zip", data=json.dumps(squash)), world)
