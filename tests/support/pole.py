"""A profile without meanings: an agent that turns at an angle and a speed, by strict tests."""

from fractions import Fraction

import numpy as np

from codegen.ir import ActionSpec, AgentPolicy, EntitySpec, FeatureSpec, PolicyProfile, Provenance, Tree, WorldSpec
from verify.claims.terms import last_of


def pole(numbers, end=0.0):
    """Left where the angle is below an end, else right where the speed is not below it, else none."""
    below = last_of(Fraction(end), numbers, below=True)
    nodes = [(0, below, 1, 2, -1), (-1, 0, -1, -1, 0), (1, below, 3, 4, -1), (-1, 0, -1, -1, 2), (-1, 0, -1, -1, 1)]
    features = tuple(FeatureSpec(name, "none", -1e9, 1e9, None) for name in ("angle", "speed"))
    actions = tuple(ActionSpec(name, None) for name in ("left", "right", "none"))
    policy = AgentPolicy("pole", "team", features, actions, Tree(*np.array(nodes).T, numbers=numbers))
    world = WorldSpec("cart", "somebody's", (EntitySpec("pole", 0.0, 0.0, None, False),), (), (), 0.0, 0.0, 0.0, 0.0, 1)
    return PolicyProfile(world, (policy,), Provenance("imported", "", 0, "", "test"))
