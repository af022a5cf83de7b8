"""Trees as players.

Does: deploys grown trees as policies, seats policies among other controllers.
Assumes: trees in the world's order of agents.
Does not: play.
"""

from collections.abc import Sequence

from codegen import ir
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
