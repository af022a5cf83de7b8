"""Profiles of any of our games, with random trees: thresholds within the ranges, at 0 and at the ends of signs."""

from dataclasses import replace

import numpy as np

from codegen import ir
from codegen.floats import FLOAT64
from codegen.lowering.deploy import deploy_tree
from maviper.worlds import WorldState, find

NAMES = [
    "physical-deception,velocity=1",
    "cooperative-navigation",
    "cooperative-navigation,agents=2",
    "physical-deception,features=coasting+ahead",
    "predator-prey",
    "predator-prey,observation=released,predators=3",
    "predator-prey,observation=mpe2,obstacles=0,prey=1",
]


def random_tree(features, n_actions, rng, depth=5):
    """A full tree as a learner would have grown it, numbered level by level."""
    splits = 2**depth - 1
    node = np.arange(2 * splits + 1)
    split = node < splits
    feature = np.where(split, rng.integers(len(features), size=len(node)), ir.NO_FEATURE)
    low = np.array([features[k].low for k in feature])
    high = np.array([features[k].high for k in feature])
    special = rng.choice([-1.0, -0.5, 0.0, 0.5, 1.0, 0.1], size=len(node))
    threshold = np.where(rng.random(len(node)) < 0.5, special, rng.uniform(low, high))
    return ir.GrownTree(
        feature,
        np.where(split, threshold, 0),
        np.where(split, 2 * node + 1, ir.NO_CHILD),
        np.where(split, 2 * node + 2, ir.NO_CHILD),
        np.where(split, ir.NO_ACTION, rng.integers(n_actions, size=len(node))),
    )


def random_profile(name, seed=0, depth=4):
    world, rng = find(name), np.random.default_rng(seed)
    agents = []
    for agent, features, actions in zip(world.agents, world.features, world.actions, strict=True):
        grown = random_tree(features, len(actions), rng, depth)
        agents.append(ir.AgentPolicy(agent, world.team_of(agent), features, actions, deploy_tree(grown), grown))
    return ir.PolicyProfile(world.spec, tuple(agents), ir.Provenance("random", "none", seed, "", "tests"))


def doubled(profile, *agents):
    """The profile, in which the named agents, or all, compare float64 with the thresholds that were grown."""
    wanted = agents or [policy.agent for policy in profile.agents]
    policies = [
        replace(policy, tree=deploy_tree(policy.grown, FLOAT64), grown=None) if policy.agent in wanted else policy
        for policy in profile.agents
    ]
    return replace(profile, agents=tuple(policies))


def states(world, position, velocity=None, goal=None):
    """A batch of states from plain arrays; at rest and with the first goal unless said otherwise."""
    velocity = np.zeros((len(position), len(world.agents), 2)) if velocity is None else velocity
    return WorldState(position, velocity, np.zeros(len(position), dtype=np.int64) if goal is None else goal)


def crowded(world, count, seed):
    """States from far apart to crowded, at rest to faster than allowed, inside to far outside the arena."""
    rng = np.random.default_rng(seed)
    n_agents, n_entities = len(world.agents), len(world.agents) + len(world.spec.landmarks)
    position = rng.normal(size=(count, n_entities, 2)) * rng.choice([0.05, 0.2, 0.7, 2.0], size=(count, 1, 1))
    velocity = rng.normal(size=(count, n_agents, 2)) * rng.choice([0.0, 0.5, 2.0], size=(count, 1, 1))
    goals = rng.integers(max(1, len(world.spec.goals)), size=count)
    return states(world, position, velocity, goals)
