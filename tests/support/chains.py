"""What several tests use of `codegen.targets.test_targets`."""

from dataclasses import replace

import numpy as np

from codegen import ir


def chain(n):
    """A tree that tests one feature again and again, ever lower."""
    feature = [0] * n + [-1] * (n + 1)
    left = [*range(1, n + 1)] + [-1] * (n + 1)
    right = [2 * n - node for node in range(n)] + [-1] * (n + 1)
    action = [-1] * n + [node % 5 for node in range(n + 1)]
    threshold = np.concatenate([np.linspace(1, -1, n), np.zeros(n + 1)])
    return ir.Tree(feature, threshold, left, right, action)


def renamed(profile, *names):
    """The first agents, under other names."""
    agents = tuple(replace(policy, agent=name) for policy, name in zip(profile.agents, names, strict=False))
    world = profile.world
    entities = tuple(replace(entity, name=name) for entity, name in zip(world.agents, names, strict=False))
    return replace(profile, world=replace(world, agents=entities), agents=agents)
