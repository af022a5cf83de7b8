"""The lowered monitor: what is asked of a world state before a claim that is proved says something of it.

Does: joins a lowered profile, the region of a certificate, and ranges, motion and fallbacks from the world's spec.
Assumes: a checked profile whose world states have coordinates; a region whose proof was accepted.
Does not: write text (codegen/targets/monitor.py), or read a certificate.
"""

from dataclasses import dataclass, replace

from codegen import ir
from codegen.errors import InputError
from codegen.floats import decimal_literal, short_hex
from codegen.lowering.lower import region_of
from codegen.lowering.model import Agent, Double, Model, Place, Region
from codegen.region import RegionSpec

ROUNDED = 1.0 + 2.0**-20  # by which a speed at its limit may be above it: simulators round where they cut it
LATE = 1.5  # steps; inputs that are older, or checks that come later, are invalid
WORDS = ("OK", "LEAVING", "OUTSIDE", "INVALID")


@dataclass(frozen=True)
class Watched:
    """A coordinate that must be measured, new, finite and within `low` and `high`."""

    place: Place
    low: Double
    high: Double


@dataclass(frozen=True)
class Moved:
    """A position of the region, and the velocity by which it moves until the next step."""

    place: Place
    velocity: Place


@dataclass(frozen=True)
class Fallback:
    """An agent, and the action that it takes where the monitor does not vouch for its policy."""

    agent: Agent
    action: int

    @property
    def constant(self) -> str:
        """Its name in C: PREFIX_AGENT_FALLBACK."""
        return f"{self.agent.names.act.removesuffix('act').upper()}FALLBACK"


@dataclass(frozen=True)
class Watch:
    """A monitor, ready to be written."""

    model: Model  # of the profile; its region and the name of its check are the certificate's
    guard: str  # of the header of the profile
    certificate: str  # content hash
    claim: str  # in words
    watched: tuple[Watched, ...]
    moved: tuple[Moved, ...]
    fallbacks: tuple[Fallback, ...]
    max_age: str  # seconds

    @property
    def region(self) -> Region:
        """The region of the certificate."""
        assert self.model.region is not None
        return self.model.region

    @property
    def own_guard(self) -> str:
        """Of the header of the monitor."""
        return f"{self.model.prefix.upper()}_MONITOR_{self.certificate[:16].upper()}_H"

    @property
    def comparisons(self) -> int:
        """How many comparisons one step makes, whatever the state: no path is longer or shorter."""
        within = 2 * len(self.region.bounds) + 4 * len(self.region.apart) + 4 * len(self.region.goals)
        return 2 + 3 * len(self.watched) + 2 * within


def watch(profile: ir.PolicyProfile, model: Model, spec: RegionSpec, certificate: str, claim: str) -> Watch:
    """The monitor of a profile for the region of a certificate with this content hash, of a `claim` in words.

    InputError where agents do not decide from world states, so that no state can be watched.
    """
    if not model.located:
        what = "a monitor watches world states, and the features have no meanings"
        raise InputError(what, "--target monitor", "give each feature a meaning")
    region = region_of(spec)
    asked = {name for first, second, *_ in region.bounds for name in (first, second) if name}
    asked |= {f"{entity}_{axis}" for first, second, _ in region.apart for entity in (first, second) for axis in "XY"}
    asked |= {f"{entity}_{axis}" for entity in (*region.goals, *(["GOAL"] if region.goals else [])) for axis in "XY"}
    moved = tuple(
        Moved(place, model.places[name]) for upper, place in model.places.items()
        if upper in asked and (name := f"{upper[:-1]}V{upper[-1]}") in model.places
    )  # fmt: skip
    velocities = {each.velocity.upper for each in moved}
    ranges = _ranges(profile.world)
    watched = tuple(
        Watched(place, _double(ranges[place.name][0]), _double(ranges[place.name][1]))
        for upper, place in model.places.items()
        if place.readers or upper in asked or upper in velocities
    )
    fallbacks = [Fallback(agent, _at_rest(policy)) for agent, policy in zip(model.agents, profile.agents, strict=True)]
    names = replace(model.names, in_region=f"{model.prefix}_monitor_within")
    own = replace(model, region=region, names=names)
    age = decimal_literal(LATE * profile.world.dt)
    return Watch(own, model.names.guard, certificate, claim, watched, moved, tuple(fallbacks), age)


def _ranges(world: ir.WorldSpec) -> dict[str, tuple[float, float]]:
    """What each coordinate can be: speeds have limits where the world states them, other lengths the IR's."""
    found = dict.fromkeys(world.coordinates(), (-ir.MAX_LENGTH, ir.MAX_LENGTH))
    for agent in world.agents:
        if agent.max_speed is not None:
            limit = agent.max_speed * ROUNDED
            found |= {f"{agent.name}.v{axis}": (-limit, limit) for axis in "xy"}
    return found | {each.name: (each.low, each.high) for each in world.variables}


def _at_rest(policy: ir.AgentPolicy) -> int:
    """The first action that pushes nobody, else the first."""
    return next((i for i, action in enumerate(policy.actions) if action.effect in (None, (0.0, 0.0))), 0)


def _double(value: float) -> Double:
    return Double(short_hex(value), decimal_literal(value))
