"""What several tests use of `test_golden`."""

from codegen import ir
from codegen.lowering.deploy import deploy_tree
from codegen.profiles import ensure
from tests.support.strategies import WORLD
from tests.support.teams import LEFT, RIGHT, STAY, UP, towards, tree


def small_profile() -> ir.PolicyProfile:
    """Hand-made trees with the thresholds that are easily got wrong, and a single leaf."""
    grown = ir.GrownTree(
        feature=[0, 3, 9, -1, -1, -1, 2, -1, -1],
        threshold=[0.1, 0.0, -1 / 3, 0, 0, 0, 3.4028234663852886e38, 0, 0],
        left=[1, 3, 5, -1, -1, -1, 7, -1, -1],
        right=[2, 4, 6, -1, -1, -1, 8, -1, -1],
        action=[-1, -1, -1, LEFT, RIGHT, UP, -1, STAY, STAY],
    )
    trees = {
        "adversary_0": (tree(STAY), None),
        "agent_0": (deploy_tree(grown), grown),
        "agent_1": (towards(1, 1), None),
    }
    agents = tuple(
        ir.AgentPolicy(name, WORLD.team_of(name), features, actions, *trees[name])
        for name, features, actions in zip(WORLD.agents, WORLD.features, WORLD.actions, strict=True)
    )
    provenance = ir.Provenance("hand-made", "none", 0, "", "tests", {"depth": 3}, {"success": 0.5})
    return ensure(ir.PolicyProfile(WORLD.spec, agents, provenance))
