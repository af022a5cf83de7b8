"""Contact forces between the entities of a world, operation by operation as in mpe2.

Does: says who may push whom, and how strongly.
Assumes: a checked world spec.
Does not: move anything.
"""

from itertools import combinations

import numpy as np
import numpy.typing as npt

from codegen.ir import Float64, WorldSpec

COINCIDENT = 1e-150  # centres so near to one another count as one place


NEGLIGIBLE_MARGINS = 40  # so far apart the simulator leaves a push out: it is below 1e-17


def push(world: WorldSpec, dx: Float64, dy: Float64, touching: float) -> tuple[npt.NDArray[np.int64], Float64]:
    """The contact force on the first of two entities that touch at a distance. `dx`, `dy`: [batch] its gaps from the
    other.

    Returns the rows in which there is one worth adding, and the force [2, rows], operation by operation as in mpe2.
    """
    reach = touching + NEGLIGIBLE_MARGINS * world.contact_margin
    squared = dx * dx + dy * dy
    near = np.flatnonzero((squared < reach * reach) & (squared > 0))
    distance = np.sqrt(squared[near])
    overlap = np.logaddexp(0, -(distance - touching) / world.contact_margin) * world.contact_margin
    force = [world.contact_force * gap / distance * overlap for gap in (dx[near], dy[near])]
    return near, np.array(force).reshape(2, len(near))


def partners(world: WorldSpec) -> list[tuple[int, int, float]]:
    """Pairs of entities that may push each other, agents before landmarks, with the distance at which they touch."""
    if not world.contact_force:
        return []
    pairs = combinations(enumerate(world.agents + world.landmarks), 2)
    movable = len(world.agents)
    return [(i, j, a.size + b.size) for (i, a), (j, b) in pairs if a.collides and b.collides and i < movable]
