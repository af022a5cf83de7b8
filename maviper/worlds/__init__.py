"""The games: batched simulators that reproduce the reference environments, one file a game.

Does: finds a world by its name.
Assumes: every game is a `ParticleWorld`.
Does not: know policies, experts or learning.
"""

from collections.abc import Callable

from codegen.errors import UnknownNameError
from maviper.worlds.particle import ParticleWorld, WorldState
from maviper.worlds.physical_deception import PhysicalDeception

WORLDS: dict[str, Callable[[], ParticleWorld]] = {"physical-deception": PhysicalDeception}


def find(name: str) -> ParticleWorld:
    """The world of that name; UnknownNameError with the closest match otherwise."""
    if name not in WORLDS:
        raise UnknownNameError("world", name, WORLDS)
    return WORLDS[name]()


__all__ = ["WORLDS", "ParticleWorld", "PhysicalDeception", "WorldState", "find"]
