"""The world that a profile was learned in.

Does: finds our world with exactly the profile's spec, agents, features and actions; refuses worlds without places.
Assumes: a checked profile.
Does not: play.
"""

from collections.abc import Iterable

from codegen import ir
from codegen.errors import InputError
from codegen.ir import FeatureSpec
from maviper.worlds import ParticleWorld, World, built_in
from maviper.worlds.world import world_name

NO_WORLD = "no world of this version has the profile's spec, agents, features and actions"
FEATURES_FILE = "features_file"  # in a provenance: the hash of a file that named the features
OBSERVED = "claim what agents do over observations: see `maviper guide claims`"


def matching_world(profile: ir.PolicyProfile) -> World | None:
    """Our world with exactly the profile's spec, agents, teams, features and actions, or None."""
    try:
        world = built_in(world_name(profile.world))
    except InputError:  # another's world, or options of another version
        return None
    return world if plays(profile, world) else None


def matching_places(profile: ir.PolicyProfile) -> ParticleWorld | None:
    """As `matching_world`, where agents have places, or None."""
    world = matching_world(profile)
    return world if isinstance(world, ParticleWorld) else None


def ensure_places(world: ir.WorldSpec, features: Iterable[FeatureSpec], advice: str = OBSERVED) -> None:
    """InputError, with an advice, where a world has neither landmarks nor a feature that says where something is."""
    if not world.landmarks and all(feature.meaning is None for feature in features):
        what = f"claims speak of places and landmarks, and {world.name} has none"
        raise InputError(what, "", advice)


def plays(profile: ir.PolicyProfile, world: World) -> bool:
    """Whether a world has exactly the profile's spec, agents, teams, features and actions. Where a file named the
    profile's features, they are what the world has by their number alone.
    """
    named = FEATURES_FILE in profile.provenance.training
    ours = [
        (agent, world.team_of(agent), len(features) if named else features, actions)
        for agent, features, actions in zip(world.agents, world.features, world.actions, strict=True)
    ]
    theirs = [
        (policy.agent, policy.team, len(policy.features) if named else policy.features, policy.actions)
        for policy in profile.agents
    ]
    return world.spec == profile.world and ours == theirs
