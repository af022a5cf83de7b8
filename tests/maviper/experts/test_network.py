"""Greedy actions of networks: single precision answers only where double precision would answer the same."""

from dataclasses import replace

import numpy as np
import pytest

from codegen.paths import LEGAL
from maviper.experts import network
from maviper.experts.network import ACTOR
from maviper.worlds import find

ROWS = 700


def random_expert(seed, hidden=16, scale=1.0):
    world, rng = find("physical-deception"), np.random.default_rng(seed)
    tensors = {
        name: (scale * rng.normal(size=shape)).astype(np.float32)
        for name, shape in network.shapes(world, hidden, ACTOR).items()
    }
    return network.build_expert(world, tensors, {})


def observations(expert, seed, size=1.0):
    inputs = len(expert.tensors["agent_0.actor.1.weight"])
    return (size * np.random.default_rng(seed).normal(size=(ROWS, inputs))).astype(np.float32)


def act(expert, agent, obs):
    return expert.act([agent], [obs] * 3)[:, 0]


def in_double(expert, agent, obs):
    return np.argmax(expert.logits(agent, obs), axis=1)


@pytest.mark.parametrize("size", [1e-30, 1e-3, 1.0, 1e6, 1e25, 5e37])
@pytest.mark.parametrize("scale", [1e-2, 1.0, 30.0])
def test_the_error_of_single_precision_is_within_its_bound(size, scale):
    expert = random_expert(3, scale=scale)
    obs = observations(expert, 4, size)
    with np.errstate(over="ignore", invalid="ignore"):
        off = np.abs(expert._logits(1, obs, expert.tensors) - expert.logits(1, obs)).max(axis=1)
    doubt = expert._doubt(1, obs)
    assert doubt == np.inf if np.isnan(off).any() else (2 * off <= doubt).all()
    assert doubt < np.inf or size * scale > 1e24
    assert (act(expert, 1, obs) == in_double(expert, 1, obs)).all()


def nearly_tied(expert, agent):
    """Two actions whose logits differ in the last bits of single precision, or not at all."""
    net = f"{expert.agents[agent]}.{ACTOR}.3"
    weight, bias = (expert.tensors[f"{net}.{part}"].copy() for part in ("weight", "bias"))
    weight[:, 3] = np.nextafter(weight[:, 1], np.float32(9), where=weight[:, 2] > 0, out=weight[:, 1].copy())
    weight[:, 4], bias[3:] = weight[:, 1], bias[1]
    bias[1:] += 50
    return replace(expert, tensors={**expert.tensors, f"{net}.weight": weight, f"{net}.bias": bias})


def test_what_single_precision_cannot_tell_double_precision_decides(monkeypatch):
    expert = nearly_tied(random_expert(5), 2)
    obs = observations(expert, 6)
    wanted = in_double(expert, 2, obs)
    assert len(set(wanted)) > 1 and (act(expert, 2, obs) == wanted).all()
    monkeypatch.setattr(expert.__class__, "_doubt", lambda self, agent, rows: -1.0)
    assert (act(expert, 2, obs) != wanted).any(), "float32 alone decides otherwise"


def test_numbers_that_are_none_are_decided_in_double():
    expert = random_expert(7)
    obs = observations(expert, 8)
    obs[5], obs[9, 0], obs[11, 1] = np.nan, np.inf, -np.inf
    with np.errstate(invalid="ignore"):
        assert (act(expert, 1, obs) == in_double(expert, 1, obs)).all()


def test_illegal_actions_never_lead():
    """An action whose flag is not above .5 is none, and where none is legal the first stands for them."""
    expert = replace(random_expert(10), masks=((0, 1, 2, 0, None),) * 3)
    obs = observations(expert, 11)
    logits = expert.logits(1, obs)
    flags = obs[:, [0, 1, 2, 0]] > LEGAL
    allowed = np.where(np.column_stack([flags, np.ones(ROWS, bool)]), logits, -np.inf)
    wanted = np.argmax(allowed, axis=1)
    assert (wanted != np.argmax(logits, axis=1)).any() and (act(expert, 1, obs) == wanted).all()
    never = replace(expert, masks=((0,) * 5,) * 3)
    assert (act(never, 1, -np.abs(obs)) == 0).all()
