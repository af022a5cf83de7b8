"""Whether the zones of an episode allow for all of its rounding.

Does: bounds how far the rounded motion may be from the exact one, and how large its numbers get.
Assumes: the motion of the world spec: speeds damped, then pushed, then added to places.
Does not: step zones (unroll.py).
"""

from fractions import Fraction

from codegen.errors import InputError
from codegen.ir import WorldSpec
from verify.episodes.contacts import bound_neglected, farthest, fastest
from verify.episodes.zones import LIMIT, SLACK


def ensure_exact(world: WorldSpec, steps: int, largest: Fraction, push: float) -> None:
    """InputError unless the relaxation of tests covers all rounding, and numbers keep below LIMIT.

    `largest`: the region's largest coordinate; `push`: the most that an action adds to a velocity on an axis.
    """
    reach, speed, place = 0.0, 0.0, 0.0
    for _ in range(steps):
        place += speed * world.dt
        speed = speed * (1 - world.damping) + push
        reach = max(reach, speed)
    size = float(largest) + place
    apart = steps * (2.0**-45 + 2.0**-53 * size + 3 * steps * world.dt * 2.0**-53 * reach) + bound_neglected(
        world, steps
    )
    most = max(size + farthest(world, steps), reach + fastest(world, steps))
    if not (2 * apart + 2.0**-50 * size <= SLACK and most <= LIMIT / 8):
        raise InputError(
            f"rounding over {steps} steps from positions up to {float(largest):g} may exceed what the proof allows for",
            "--steps",
            "ask for fewer steps or a smaller region",
        )
