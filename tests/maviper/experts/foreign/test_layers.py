"""Networks of others in numpy: the same numbers as torch's own, the right weights, and refusals where nothing fits."""

from itertools import pairwise

import numpy as np
import pytest

from codegen.errors import InputError, UnknownNameError
from maviper.experts.expert import AS_GIVEN
from maviper.experts.finding import critic_of
from maviper.experts.foreign.layers import ACTIVATIONS, LOGITS, LayersExpert, Linear, Normalization, Q
from maviper.extraction.growth.weights import iviper_weights
from maviper.worlds import find

TORCH = {"elu": "ELU", "leakyrelu": "LeakyReLU", "relu": "ReLU", "sigmoid": "Sigmoid", "tanh": "Tanh"}


@pytest.fixture(scope="module")
def world():
    return find("gymnasium:CartPole-v1")


def network(rng, sizes=(4, 8, 2)):
    made = [(rng.normal(size=(b, a)), rng.normal(size=b)) for a, b in pairwise(sizes)]
    return [Linear(weight.astype(np.float32), bias.astype(np.float32)) for weight, bias in made]


@pytest.mark.train
@pytest.mark.parametrize("name", ACTIVATIONS)
def test_values_are_torchs(world, name):
    torch = pytest.importorskip("torch")
    rng = np.random.default_rng(3)
    layers = network(rng, (4, 9, 7, 2))
    expert = LayersExpert(world, layers, name, Q)
    obs = rng.normal(size=(500, 4)).astype(np.float32) * 3
    found = torch.from_numpy(obs)
    for place, (weight, bias) in enumerate(layers):
        found = getattr(torch.nn, TORCH[name])()(found) if place else found
        found = torch.nn.functional.linear(found, torch.from_numpy(weight), torch.from_numpy(bias))
    assert np.allclose(expert.values(obs), found.numpy(), rtol=1e-4, atol=1e-4)
    assert np.array_equal(expert.act([0], [obs])[:, 0], found.numpy().argmax(axis=1))


def test_logits_weigh_states_as_viper_does(world):
    """The greatest log-probability minus the least, by hand."""
    rng = np.random.default_rng(4)
    expert = LayersExpert(world, network(rng), "tanh", LOGITS)
    assert critic_of(expert) == "log-probabilities"
    state = world.start_from_seeds(range(6))
    (obs,) = world.observe(state)
    acted = expert.act([0], [obs])
    values = expert.values(obs)
    assert np.allclose(np.exp(values).sum(axis=1), 1)
    weights = iviper_weights(world, expert, (obs,), state, acted, 0)
    assert np.allclose(weights, values.max(axis=1) - values.min(axis=1)) and (weights > 0).all()


def test_q_answers_with_the_agents_own_action(world):
    rng = np.random.default_rng(5)
    expert = LayersExpert(world, network(rng), "relu", Q)
    assert critic_of(expert) == "learned"
    obs, given = rng.normal(size=(3, 4)).astype(np.float32), np.array([[0], [1], [1]])
    found = expert.q(0, [obs], None, np.array([[1], [AS_GIVEN]]), given)
    values = expert.values(obs)
    assert np.array_equal(found, np.stack([values[:, 1], values[np.arange(3), given[:, 0]]], axis=1))


def test_normalisation_is_that_of_vecnormalize():
    mean, var = np.array([1.0, -2.0]), np.array([4.0, 1e-6])
    found = Normalization(mean, var, clip=3.0)(np.array([[2.0, -2.0], [100.0, -1.0]], np.float32))
    assert found.dtype == np.float32 and found.tolist() == [[0.5, 0.0], [3.0, 3.0]]


@pytest.mark.parametrize(
    ("mean", "var", "clip"),
    [([1, 2], [1], 10), ([np.nan], [1], 10), ([1], [-1], 10), ([1], [1], 0), ([[1]], [[1]], 10)],
)
def test_statistics_that_are_none_are_refused(mean, var, clip):
    with pytest.raises(InputError):
        Normalization(np.array(mean, float), np.array(var, float), clip)


def test_what_does_not_fit_is_refused(world):
    rng = np.random.default_rng(6)
    with pytest.raises(InputError, match="6 inputs and 3 outputs"):
        LayersExpert(world, network(rng, (6, 5, 3)), "relu")
    first, second = network(rng)
    with pytest.raises(InputError, match="follow"):
        LayersExpert(world, [first, Linear(second.weight[:, :5], second.bias)], "relu")
    with pytest.raises(InputError, match="finite"):
        LayersExpert(world, [first, Linear(second.weight * np.float32(np.inf), second.bias)], "relu")
    with pytest.raises(UnknownNameError, match="relu"):
        LayersExpert(world, [first, second], "rellu")
    with pytest.raises(InputError, match="of 3 numbers, not 4"):
        LayersExpert(world, [first, second], "relu", normalization=Normalization(np.zeros(3), np.ones(3)))
