"""The start region of a world: where its episodes start, and how fast agents may become.

Does: its bounds; whether a region is the start region, and what a region is called.
Assumes: a world whose coordinates are named by the profile's world spec.
Does not: belong to what proofs rest on. A certificate states its region's bounds.
"""

from collections.abc import Sequence
from fractions import Fraction

from codegen.errors import InputError
from codegen.ir import PolicyProfile, WorldSpec
from verify.claims.region import Interval, Region
from verify.exact import MAX_NUMBER

START = "start"  # the name of the start region


def positions(world: WorldSpec) -> tuple[str, ...]:
    """The coordinates that every region bounds: the positions of agents and landmarks, and the variables."""
    places = [f"{entity.name}.{axis}" for entity in world.agents + world.landmarks for axis in "xy"]
    return (*places, *(variable.name for variable in world.variables))


def velocities_of(world: WorldSpec) -> tuple[str, ...]:
    """The velocity coordinates of agents."""
    return tuple(f"{agent.name}.v{axis}" for agent in world.agents for axis in "xy")


def start_region(world: WorldSpec, velocities: Sequence[str] = ()) -> Region:
    """Every position that is a start, any goal, variables in their ranges; the named velocity coordinates as large as
    actions can make them.
    """
    return Region(start_bounds(world, velocities), world.goals, name=START)


def start_bounds(world: WorldSpec, velocities: Sequence[str]) -> dict[str, Interval]:
    """The bounds of the start region. InputError for a velocity that nothing bounds."""
    starts = [entity.start or (world.start_low, world.start_high) for entity in world.agents + world.landmarks]
    bounds = [start for start in starts for _ in "xy"] + [(one.low, one.high) for one in world.variables]
    exact_bounds = [(Fraction(low), Fraction(high)) for low, high in bounds]
    box = dict(zip(positions(world), exact_bounds, strict=True))
    for name in velocities:
        agent = next(entity for entity in world.agents if name.rpartition(".")[0] == entity.name)
        limits = [Fraction(agent.max_speed)] if agent.max_speed is not None else []
        if world.damping:  # what a push adds, summed over all steps: f dt (1 + (1 - d) + (1 - d)^2 + ...)
            limits.append(Fraction(agent.force) * Fraction(world.dt) / Fraction(world.damping))
        if not limits or min(limits) > MAX_NUMBER:
            lacking = f"has a damping of only {world.damping}" if world.damping else "has no damping"
            raise InputError(f"nothing bounds {name}: the world {lacking}", "", "state its bounds in a region file")
        box[name] = (-min(limits), min(limits))
    return box


def find_observed_velocities(profile: PolicyProfile) -> tuple[str, ...]:
    """The velocity coordinates that some agent observes, in the world's order."""
    meanings = [feature.meaning for policy in profile.agents for feature in policy.features if feature.meaning]
    seen = {name for meaning in meanings for _, name in meaning.terms}
    return tuple(name for name in velocities_of(profile.world) if name in seen)


def everywhere(profile: PolicyProfile) -> Region:
    """The start region of a profile: every start position, any goal, every observed velocity that actions can cause."""
    return start_region(profile.world, find_observed_velocities(profile))


def name_region(profile: PolicyProfile, region: Region) -> str:
    """Returns a region's name; `start` only where it is the start region, whatever its own name is."""
    return "" if region.name == START and not is_start(profile, region) else region.name


def is_start(profile: PolicyProfile, region: Region) -> bool:
    """Returns True if a region is the start region, by its bounds."""
    try:
        return region == everywhere(profile)
    except InputError:  # no damping bounds the velocities, so there is none
        return False
