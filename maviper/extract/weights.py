"""Resampling weights: how much it matters in a state that an agent acts as its expert does.

Does: the paper's MAVIPER weight for teams, from the expert's centralized critics.
Assumes: few enough joint actions of the opponents to enumerate them.
Does not: sample joint actions.
"""

from itertools import product
from typing import Any

import numpy as np

from codegen.ir import Float32, Float64
from maviper.experts.expert import AS_GIVEN, Expert
from maviper.worlds import World
from maviper.worlds.world import Int

STATES_AT_ONCE = 1024  # bounds the memory: states x joint actions x hidden units


def maviper_weights(
    world: World, expert: Expert, observations: tuple[Float32, ...], state: Any, labels: Int
) -> Float64:
    """The MAVIPER weight of every point for every agent, [n, n_agents] (paper, section MAVIPER, mixed settings).

    For agent i of team Z: the mean over all joint actions of the agents outside Z, uniform, of
    Q_i(x, expert's a_i) - min over a_i of Q_i(x, a_i), team-mates at their expert actions.
    """
    weights = np.empty((len(labels), len(world.agents)))
    for agent, name in enumerate(world.agents):
        team = world.members(world.team_of(name))
        n_actions = [len(choices) for choices in world.actions]
        averaged = expert.centralized  # a value network's Q_i does not depend on what others do
        choices = [
            range(n) if other == agent or (averaged and other not in team) else (AS_GIVEN,)
            for other, n in enumerate(n_actions)
        ]
        joint = np.array(list(product(*choices)))
        own = joint[:, agent]
        for low in range(0, len(labels), STATES_AT_ONCE):
            rows = slice(low, low + STATES_AT_ONCE)
            q = expert.q(agent, [seen[rows] for seen in observations], state[rows], joint, labels[rows])
            # [n_actions of the agent, states, joint actions of the opponents]
            by_own = np.stack([q[:, own == action] for action in range(n_actions[agent])])
            chosen = by_own[labels[rows, agent], np.arange(by_own.shape[1])]
            weights[rows, agent] = (chosen - by_own.min(axis=0)).mean(axis=1)
    return weights
