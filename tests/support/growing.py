"""Teams of trees grown from arrays, without a world."""

from maviper.extraction.growth.exact import CartTree
from maviper.extraction.growth.joint import grow_jointly


def train_joint_trees(observations, labels, counts, n_actions, max_depth, seeds, least_right=None, alive=None):
    """TrainJointTrees with every threshold tried; arguments by agent, `labels` and `alive` [n, n_agents]."""
    team = [
        CartTree(obs, labels[:, agent], counts[agent], n_actions[agent], max_depth, seeds[agent])
        for agent, obs in enumerate(observations)
    ]
    return grow_jointly(team, max_depth, len(team) - 1 if least_right is None else least_right, alive)
