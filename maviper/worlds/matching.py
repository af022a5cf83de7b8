"""The world that a profile was learned in.

Does: finds our world with exactly the profile's spec, agents, features and actions; refuses worlds without places.
Assumes: a checked profile.
Does not: play.
"""

from collections.abc import Iterable, Sequence
from dataclasses import replace

from codegen import ir
from codegen.errors import InputError
from codegen.floats import FLOAT32
from codegen.ir import FeatureSpec
from maviper.worlds import WORLDS, ParticleWorld, World, find_built_in
from maviper.worlds.world import find_misplaced, world_name

NO_WORLD = "no built-in game has the profile's world, agents, features and actions, with float32 observations"
REPLAYED = "episode replay: only built-in games can be replayed"
OWN_NAMES = "names"  # in a provenance: of features and actions, where the world has no more than numbers
FEATURES_FILE = "features_file"  # in a provenance: the hash of a file that named the features
UNREPAIRED = (
    "repairs are for claims about landmarks; to change what this team does over observations, change the file that it "
    "came from, or learn from counterexamples: `maviper extract --counterexamples`"
)
OBSERVED = "claim what agents do over observations: see `maviper guide claims`"


def matching_world(profile: ir.PolicyProfile) -> World | None:
    """Our world with exactly the profile's spec, agents, teams, features and actions, or None."""
    try:
        world = find_built_in(world_name(profile.world))
    except InputError:  # another's world, or options of another version
        return None
    return world if plays(profile, world) else None


def not_ours(world: ir.WorldSpec) -> str:
    """Why no episode of a game can be replayed that is none of ours; "" for one of ours, in whatever version."""
    if world.name in WORLDS:
        return ""
    return (
        f"{REPLAYED}, and {world.reference or 'an imported tree plays none'}{' is not one' if world.reference else ''}"
    )


def matching_places(profile: ir.PolicyProfile) -> ParticleWorld | None:
    """Returns the world of `matching_world` if agents have places in it, or None."""
    world = matching_world(profile)
    return world if isinstance(world, ParticleWorld) else None


def ensure_places(world: ir.WorldSpec, features: Iterable[FeatureSpec], advice: str = OBSERVED) -> None:
    """InputError, with an advice, where a world has neither landmarks nor a feature that says where something is."""
    if not world.landmarks and all(feature.meaning is None for feature in features):
        what = f"claims speak of places and landmarks, and {world.name} has none"
        raise InputError(what, "", advice)


def plays(profile: ir.PolicyProfile, world: World) -> bool:
    """Returns True if a world has exactly the profile's spec, agents, teams, features and actions, and shows agents
    what they compare. Where a file named the profile's features, they are what the world has by their number alone;
    where an imported tree did, by their number and ranges, unless a name is the world's for something else.
    """
    facts = profile.provenance.training
    named, own = FEATURES_FILE in facts, OWN_NAMES in facts
    everything = zip(world.agents, world.features, world.actions, world.given, strict=True)
    ours = [
        (
            agent,
            world.team_of(agent),
            len(features) if named else _nameless(features, own),
            _nameless(actions, own),
            outputs,
        )
        for agent, features, actions, outputs in everything
    ]
    theirs = [
        (
            policy.agent,
            policy.team,
            len(policy.features) if named else _nameless(policy.features, own),
            _nameless(policy.actions, own),
            policy.outputs,
        )
        for policy in profile.agents
    ]
    called = [
        *zip(world.actions, (policy.actions for policy in profile.agents), strict=False),
        *zip(world.features, (policy.features for policy in profile.agents), strict=False),
    ]
    misplaced = (find_misplaced([a.name for a in known], [b.name for b in said]) is not None for known, said in called)
    single = all(policy.numbers == FLOAT32 for policy in profile.agents)  # as worlds show what agents observe
    return single and world.spec == profile.world and ours == theirs and not any(misplaced)


def _nameless(specs: Sequence[FeatureSpec] | Sequence[ir.ActionSpec], own: bool) -> tuple[object, ...]:
    """Features or actions; without their names where these are a tree's `own`."""
    return tuple(replace(each, name="") for each in specs) if own else tuple(specs)
