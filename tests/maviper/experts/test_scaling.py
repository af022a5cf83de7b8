"""Scaled observations: the first layer is stored for plain ones, and networks say the same."""

import numpy as np
import pytest

from maviper.experts import cards, network
from maviper.experts.cards import Request
from maviper.experts.expert import AS_GIVEN
from maviper.worlds import find

nets = pytest.importorskip("maviper.experts.training.nets", reason="the extra maviper[train]", exc_type=ImportError)
LEAST_POINTS, LEAST_SHARE, Scale = nets.LEAST_POINTS, nets.LEAST_SHARE, nets.Scale
measure_scale = nets.measure_scale

NAMES = ("physical-deception", "predator-prey,observation=mpe2")


def test_a_folded_layer_says_of_plain_observations_what_it_said_of_scaled_ones():
    """Exactly, where every number is a small multiple of a power of two; rows of actions stay."""
    rng = np.random.default_rng(0)
    scale = Scale(rng.integers(-3, 4, size=6) / 2, 2.0 ** rng.integers(-3, 3, size=6))
    weight, bias = (rng.integers(-8, 9, size=size).astype(np.float32) / 4 for size in ((5, 7), (7,)))
    columns, plain = (4, 1, 2), rng.integers(-8, 9, size=(50, 5)).astype(np.float32) / 8
    scaled = plain.copy()
    scaled[:, :3] = (plain[:, :3] - scale.mean[[4, 1, 2]]) / scale.deviation[[4, 1, 2]]
    folded = scale.fold(weight, bias, columns)
    assert (plain @ folded[0] + folded[1] == scaled @ weight + bias).all()
    assert (folded[0][3:] == weight[3:]).all() and (folded[0][:3] != weight[:3]).any()
    back = scale.unfold(*folded, columns)
    assert (back[0] == weight).all() and (back[1] == bias).all()
    assert all(part.dtype == np.float32 for part in (*folded, *back))


@pytest.mark.parametrize("name", NAMES)
def test_the_scale_is_that_of_random_play_and_of_a_team_where_it_shares_a_network(name):
    world = find(name)
    alone, shared, again = (measure_scale(world, 250, 3, each) for each in (False, True, False))
    assert (alone.mean == again.mean).all() and (alone.deviation == again.deviation).all()
    assert (measure_scale(world, 250, 4, False).mean != alone.mean).any()
    state = world.start(4_000, np.random.default_rng(0))
    start = np.concatenate(world.observe(state), axis=1)
    assert start.shape[1:] == alone.mean.shape == shared.mean.shape and LEAST_POINTS <= 250 * 25
    first = [0, *np.cumsum([len(each) for each in world.features])]
    for team, members in world.teams.items():
        mine = [slice(first[at], first[at + 1]) for at in world.members(team)]
        assert len({tuple(shared.mean[place]) for place in mine}) == 1
        means = [alone.mean[place] for place in mine]
        assert np.allclose(shared.mean[mine[0]], np.mean(means, axis=0)), members
    assert ((start - alone.mean) / alone.deviation).std(axis=0).max() < 3
    assert (alone.deviation > 0).all()


def test_what_does_not_change_is_moved_and_what_hardly_changes_is_hardly_stretched(monkeypatch):
    world = find("cooperative-navigation,agents=2")
    wide = sum(len(each) for each in world.features)
    points = np.zeros((5_000, wide))
    points[:, 0], points[0, 1], points[:, 2] = 3.0, 5.0, np.arange(5_000) % 2
    monkeypatch.setattr("maviper.experts.training.nets._play_at_random", lambda *given: [points])
    scale = measure_scale(world, 8, 0, False)
    assert scale.mean[0] == 3.0 and scale.deviation[0] == LEAST_SHARE * 3.0
    assert scale.deviation[1] == 0.5 and scale.deviation[2] == 0.5 == scale.mean[2]
    assert (scale.deviation[3:] == 1.0).all() and not scale.mean[3:].any()


@pytest.mark.train
@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("algorithm", ["mappo", "maddpg", "vdn"])
def test_stored_networks_say_of_plain_observations_what_is_trained_on_scaled_ones(name, algorithm):
    from maviper.experts.training import mappo, off_policy

    of = {"mappo": (mappo.Mappo, mappo.Settings), "maddpg": (off_policy.Maddpg, off_policy.MaddpgSettings)}
    trainer_of, settings_of = of.get(algorithm, (off_policy.Vdn, off_policy.VdnSettings))
    more = {"buffer": 100} if algorithm != "mappo" else {"shared": 1}
    world = find(name)
    trainer = trainer_of(world, settings_of(scaled=1, seed=2, hidden=16, games=200, **more), "cpu")
    joint, kind = trainer.joint, "value" if algorithm == "vdn" else "actor"
    observations = world.observe(world.start(64, np.random.default_rng(0)))
    seen = joint.tensor(observations)
    views = joint.views(seen).numpy()
    for agent, plain in enumerate(observations):
        columns = list(joint.columns[agent])
        wanted = (plain - joint.scale.mean[columns]) / joint.scale.deviation[columns]
        assert views[agent, :, : len(columns)] == pytest.approx(wanted, abs=1e-5)
        assert not views[agent, :, len(columns) :].any()
    tensors = trainer.tensors()
    expert = network.build_expert(world, tensors, {"world": name})
    said = trainer.nets[kind](joint.views(seen)).detach().numpy()
    for agent, choices in enumerate(joint.choices):
        logits = expert.logits(agent, observations[agent])
        assert logits == pytest.approx(said[agent, :, :choices], rel=1e-3, abs=1e-6)
    if algorithm == "maddpg":
        n_agents = len(world.agents)
        acted = np.random.default_rng(1).integers(5, size=(64, n_agents))
        one_hot = joint.one_hot(joint.teams.new_tensor(acted))
        q = trainer.nets["critic"](joint.critic_input(seen, one_hot)).detach().numpy()[..., 0]
        for agent in range(n_agents):
            asked = expert.q(agent, observations, None, np.full((1, n_agents), AS_GIVEN), acted)[:, 0]
            assert asked == pytest.approx(q[agent], rel=1e-3, abs=1e-5)
    if algorithm != "mappo":  # whose agents share networks here, so that nothing begins with them
        trainer.begin(expert)
        softened = 0.1 if algorithm == "maddpg" else 1.0
        begun = trainer.nets[kind](joint.views(seen)).detach().numpy()
        assert begun == pytest.approx(softened * said, rel=1e-2, abs=1e-6)


@pytest.mark.train
def test_a_critic_is_fitted_to_actors_that_are_stored_for_plain_observations():
    from maviper.experts.training.off_policy import CriticFit, CriticSettings

    expert, world = network.load("physical-deception")
    actors = {name: tensor for name, tensor in expert.tensors.items() if ".actor." in name}
    settings = [CriticSettings(games=128, steps=3_200, scaled=each) for each in (0, 1)]
    plain, scaled = (CriticFit(world, actors, each, "cpu") for each in settings)
    seen = plain.joint.tensor(world.observe(world.start(500, np.random.default_rng(0))))
    assert scaled.joint.scale is not None and (plain._greedy(seen) == scaled._greedy(seen)).all()


@pytest.mark.train
def test_cards_say_it_and_those_without_are_as_they_were():
    from maviper.experts.training.train import settings_of

    world = find("physical-deception")
    for given in ({}, {"scaled": 0}, {"scaled": 1}):
        asked = Request("mappo", overrides=given).complete()
        settings = cards.config(world, asked, settings_of(world, asked), "")["settings"]
        assert ("scaled" in settings) == bool(given.get("scaled"))
