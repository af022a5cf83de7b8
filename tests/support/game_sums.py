"""Teams of deception with random trees that test sums."""

import itertools
from dataclasses import replace
from fractions import Fraction

import numpy as np

from codegen import ir
from codegen.sums import DOUBLE_SUMS
from maviper.files.profiles import load
from tests.support.generated import FOLDER
from tests.support.giving import tamed
from tests.support.summed import policy
from verify.claims.region import Region
from verify.claims.region_files import start_region


def team(seed, arithmetic=DOUBLE_SUMS, levels=3):
    """The shipped team of deception, with random trees that test sums of what the agents observe."""
    plain = load(FOLDER / "profile.json")
    rng = np.random.default_rng(seed)
    policies = []
    for place, each in enumerate(plain.agents):
        seeds = itertools.count(seed * 1_000 + place, 10)
        trees = (tamed(policy(at, arithmetic, levels=levels, n_features=len(each.features))) for at in seeds)
        drawn = next(one for one in trees if one.tree.sums)
        kept = {name: getattr(drawn.tree, name) for name in ("numbers", "arithmetic", "sums", "vectors", "gives")}
        actions = np.where(drawn.tree.action >= 0, rng.integers(0, len(each.actions), len(drawn.tree.action)), -1)
        arrays = (drawn.tree.feature, drawn.tree.threshold, drawn.tree.left, drawn.tree.right, actions)
        policies.append(replace(each, tree=ir.Tree(*arrays, **kept), grown=None))
    return replace(plain, agents=tuple(policies), region=None)


def draw_region(profile, seed):
    """A random box of the start region, wide or narrow."""
    whole, rng = start_region(profile.world), np.random.default_rng(seed)
    box = {}
    for name, (low, high) in whole.box.items():
        half = Fraction(float(2.0 ** rng.uniform(-6, 0)))
        middle = Fraction(float(rng.uniform(-1, 1)))
        box[name] = max(low, middle - half), min(high, middle + half)
    goals = whole.goals[: int(rng.integers(1, len(whole.goals) + 1))]
    return Region(box, goals, name="drawn.toml")
