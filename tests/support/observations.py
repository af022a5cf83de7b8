"""Profiles without meanings, and an account of their claims by enumeration of all cells, in numpy alone."""

import json
from dataclasses import replace
from itertools import pairwise, product

import numpy as np

from codegen import ir
from codegen.dynamics import motionless
from codegen.profiles import ensure
from tests.support.brute import end_of
from tests.support.teams import tree
from tests.support.zone_cases import random_tree
from verify.claims.observed import View, over

ACTIONS = ("left", "stay", "right")
NAMES = ("angle", "spin", "place", "speed")


def blind(trees, features=None, span=2.0, teams=None):
    """A profile of these trees, by agent, whose features have no meanings. `features`: agent -> names."""
    agents = []
    for agent, grown in trees.items():
        names = NAMES[: 1 + int(max(grown.feature.max(), 0))] if features is None else features[agent]
        specs = tuple(ir.FeatureSpec(name, "none", -span, span, None) for name in names)
        actions = tuple(ir.ActionSpec(name, None) for name in ACTIONS)
        agents.append(ir.AgentPolicy(agent, (teams or {}).get(agent, "team"), specs, actions, grown))
    world = motionless("imported", "", list(trees))
    return ensure(ir.PolicyProfile(world, tuple(agents), ir.Provenance("hand-made", "none", 0, "", "tests")))


def blind_tree(rng, n_features, max_depth=3):
    return random_tree(rng, n_features, max_depth, n_actions=len(ACTIONS))


def doubled(tree, rng):
    """The tree with float64 numbers: some thresholds a float64 number or two beside where they were."""
    off = {each: int(rng.integers(-2, 3)) for each in np.unique(tree.threshold).tolist()}
    beside = [each + off[each] * 2.0**-52 for each in tree.threshold.tolist()]
    columns = (tree.feature, np.where(tree.feature < 0, 0.0, beside), tree.left, tree.right, tree.action)
    return ir.Tree(*columns, numbers="float64")


def breaks(trees, feature):
    """The ties of a feature's thresholds, over (tree, number of the feature in it) pairs: the ends of what
    goes left, float64 numbers.
    """
    found = [
        float(end_of(t, tree.numbers)[0])
        for tree, own in trees
        for f, t in zip(tree.feature, tree.threshold, strict=True)
        if f == own == feature
    ]
    return sorted(set(found))


def representatives(cuts, low, high):
    """A number of each cell that cuts make of [low, high]: the cuts, the ends, and one between each two."""
    inner = sorted({low, high, *(cut for cut in cuts if low <= cut <= high)})
    return sorted({*inner, *((a + b) / 2 for a, b in pairwise(inner))})


def cells(tree, n_features, low, high, more):
    """An observation of each cell that a tree's tests and more cuts (feature -> numbers) make of [low, high]."""
    lines = [[*breaks([(tree, feature)], feature), *more.get(feature, ())] for feature in range(n_features)]
    return product(*(representatives(line, low, high) for line in lines))


def robust(profile, observations, *options, **parameters):
    """The words that ask `robust` of a profile over a file of observations."""
    said = {"observations": str(observations), **parameters}
    stated = ", ".join(f"{name}={json.dumps(value)}" for name, value in said.items())
    return ["verify", str(profile), "--claim", f"robust({stated})", *map(str, options)]


def far(threshold, action):
    """A profile that speaks of two variables without a range."""
    whole = over(blind({"car": tree((0, threshold, 1, 2), 0, action)}, {"car": ["gap"]}, ir.MAX_LENGTH), View())
    return ensure(replace(whole, world=replace(whole.world, options={})))
