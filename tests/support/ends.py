"""A relay whose runners leave, with an expert that keeps what it was asked; teams of trees grown from arrays."""

import numpy as np

from maviper.experts.expert import AS_GIVEN
from maviper.extraction.growth.exact import CartTree
from maviper.extraction.growth.joint import grow_jointly
from maviper.worlds.outside.making import import_maker
from maviper.worlds.outside.pettingzoo import PettingZooWorld
from maviper.worlds.outside.sources import parse_source

PLACE, TIME, OVER = range(3)  # what everybody observes in tests.support.environments.Relay
LEFT = 2  # what the expert does for those who have left, and for nobody else


def world_of(text):
    text = f"tests.support.environments:{text}"
    return PettingZooWorld(import_maker(parse_source(text)), text, 1)


class Expert:
    """Acts by its place; likes its own action best, and everybody's action LEFT. Keeps what it was asked."""

    card: dict = {}  # noqa: RUF012
    hash = ""
    centralized = True

    def __init__(self, world):
        self.agents, self.asked = world.agents, []

    def act(self, agents, observations, state):
        seen = [observations[agent] for agent in agents]
        return np.stack([np.where(each[:, OVER] > 0, LEFT, each[:, PLACE] > 0) for each in seen], axis=1)

    def q(self, agent, observations, state, joint, given):
        self.asked.append((agent, [seen.copy() for seen in observations], joint.copy()))
        acted = np.where(joint[None] == AS_GIVEN, given[:, None], joint[None])  # [batch, n_joint, n_agents]
        own, wanted = acted[..., agent], self.act([agent], observations, state)
        return (own == wanted) * (1.0 + observations[agent][:, [PLACE]] ** 2) * (1 + (acted == LEFT).sum(axis=2))


def train_joint_trees(observations, labels, counts, n_actions, max_depth, seeds, least_right=None, alive=None):
    """TrainJointTrees with every threshold tried; arguments by agent, `labels` and `alive` [n, n_agents]."""
    team = [
        CartTree(obs, labels[:, agent], counts[agent], n_actions[agent], max_depth, seeds[agent])
        for agent, obs in enumerate(observations)
    ]
    return grow_jointly(team, max_depth, len(team) - 1 if least_right is None else least_right, alive)
