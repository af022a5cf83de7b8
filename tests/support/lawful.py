"""What several tests use of `maviper.extraction.test_lawful`."""

import numpy as np

LINES = [(0, 1, 2), (3, 4, 5), (6, 7, 8), (0, 3, 6), (1, 4, 7), (2, 5, 8), (0, 4, 8), (2, 4, 6)]


class Player:
    """Wins, blocks, or takes a corner, whether that is free or not: its Q knows what else there is."""

    hash, card, centralized = "", {"algorithm": "by hand"}, False

    def __init__(self, world):
        self.world, self.agents = world, world.agents

    def worth(self, obs):
        own, other = obs[:, 0:18:2], obs[:, 1:18:2]
        found = np.tile(np.array([3, 1, 3, 1, 4, 1, 3, 1, 3.0]), (len(obs), 1))
        for line in LINES:
            for cell in line:
                rest = [each for each in line if each != cell]
                found[:, cell] += 100 * own[:, rest].all(axis=1) + 10 * other[:, rest].all(axis=1)
        return found

    def act(self, agents, observations, state):
        return np.stack([self.worth(observations[agent]).argmax(axis=1) for agent in agents], axis=1)

    def q(self, agent, observations, state, joint, given):
        return self.worth(observations[agent])[:, joint[:, agent]]
