"""World states in which a claim fails, many of them.

Does: draws states of a region until enough violate the claim, and keeps those that the referee confirms.
Assumes: a claim about single decisions; states at rest where the region bounds no velocities.
Does not: search for rare states (the engines do); what it finds is a sample of the region.
"""

from collections.abc import Iterator

import numpy as np

from codegen.ir import PolicyProfile
from verify.noise import mistaken
from verify.properties import Property
from verify.shares import SAMPLES, violating
from verify.spec import Region
from verify.world import Point, inside, point_of, sample, violates

MOST, DRAWS = 1_000, 10  # states, and batches of SAMPLES that are drawn for them at most
FIRST_SEED = 1_007  # of the batches; none of them is the one that shares are measured with


def failures(profile: PolicyProfile, claim: Property, region: Region, most: int = MOST) -> list[Point]:
    """At most `most` world states of a region, uniform among those where the claim fails, in the order of the draw.

    Where the claim allows errors, each state comes with errors that make it fail.
    """
    found: list[Point] = []
    for point in _candidates(profile, claim, region):
        if len(found) == most:
            break
        if inside(region, point) and violates(profile, claim, point):
            found.append(point)
    return found


def _candidates(profile: PolicyProfile, claim: Property, region: Region) -> Iterator[Point]:
    for draw in range(DRAWS):
        coordinates, goals = sample(region, profile.world, SAMPLES, FIRST_SEED + draw)
        for row in np.flatnonzero(violating(profile, claim, coordinates)):
            point = point_of(region, profile.world, coordinates[row], int(goals[row]))
            yield (mistaken(profile, claim, point) or point) if claim.eps else point
