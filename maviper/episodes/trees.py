"""Trees as players.

Does: deploys grown trees as policies, seats policies among other controllers.
Assumes: trees in the world's order of agents.
Does not: play.
"""

from collections.abc import Sequence

import numpy as np

from codegen import ir
from codegen.errors import InputError
from codegen.ir import GrownTree
from codegen.lowering.deploy import SummedTree, deploy_tree
from maviper.episodes.play import Controller, tree_policies
from maviper.worlds import World


def agent_policies(
    world: World, grown: Sequence[GrownTree], agents: Sequence[int] | None = None
) -> tuple[ir.AgentPolicy, ...]:
    """The grown trees of some agents (None: of all) as deployed policies."""
    policies: list[ir.AgentPolicy] = []
    for agent, tree in zip(range(len(world.agents)) if agents is None else agents, grown, strict=True):
        name = world.agents[agent]
        kept = None if isinstance(tree, SummedTree) else tree
        given = (world.features[agent], world.actions[agent], deploy_tree(tree), kept)
        outputs = world.outputs[agent] if world.outputs else ()
        policies.append(ir.AgentPolicy(name, world.team_of(name), *given, outputs=outputs))
    return tuple(policies)


def among(world: World, policies: Sequence[ir.AgentPolicy], others: Sequence[Controller]) -> list[Controller]:
    """A controller for each agent: its tree, or `others` where it has none."""
    trees = {policy.agent: policy for policy in policies}
    if len(trees) == len(world.agents):
        return [tree_policies([trees[agent] for agent in world.agents])] * len(world.agents)
    # a controller is asked by the agent's place, so the one tree stands in every place
    return [
        tree_policies([trees[agent]] * len(world.agents)) if agent in trees else other
        for agent, other in zip(world.agents, others, strict=True)
    ]


def reopen_tree(policy: ir.AgentPolicy) -> GrownTree:
    """A policy's deployed tree as one that can be changed; deployed again, it is the same. InputError where its sums
    are no double sums of different features, as imported ones may be.
    """
    tree = policy.tree
    arrays = tree.feature, tree.threshold.astype(np.float64), tree.left, tree.right, tree.action
    if not tree.sums and not tree.vectors:
        return GrownTree(*arrays)
    n_features = len(policy.features)
    tests = np.zeros((len(tree.sums), n_features + 1))
    given = np.zeros((len(tree.vectors), len(policy.outputs), n_features + 1))
    sums = [*tree.sums, *(each for vector in tree.vectors for each in vector)]
    for row, each in zip([*tests, *given.reshape(-1, n_features + 1)], sums, strict=True):
        for weight, feature in each.terms:
            row[feature] = weight  # CONSTANT is the last place
    grown = SummedTree(*arrays, tests[:, :-1].astype(np.float32), given)
    again = deploy_tree(grown)
    if (again.sums, again.vectors, again.arithmetic) != (tree.sums, tree.vectors, tree.arithmetic):
        what, advice = "its sums cannot be changed", "extract the tree anew, with double sums of different features"
        raise InputError(what, policy.agent, advice)
    return grown
