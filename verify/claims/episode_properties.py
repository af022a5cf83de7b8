"""The built-in claims about whole episodes: `reaches`, `covers` and `keeps_apart`.

Does: names and words them, finds one for a profile.
Assumes: landmarks and agents are those of the profile's world.
Does not: decide or play.
"""

from collections.abc import Sequence
from fractions import Fraction
from itertools import combinations, product

from codegen.dynamics import COINCIDENT, partners
from codegen.errors import InputError, UnknownNameError
from codegen.ir import PolicyProfile, WorldSpec
from verify.claims.decisions import check_landmarks, check_range, ensure_team, team_for
from verify.claims.episodes import DEFAULT_ZONES, KEEPS_APART, RADIUS, EpisodeClaim


def apart_pairs(profile: PolicyProfile, claim: EpisodeClaim) -> list[tuple[str, str]]:
    """Of `keeps_apart`: who keeps apart from whom, each pair once, an agent of the team first."""
    team = [policy.agent for policy in profile.team(claim.team)]
    pairs = product(team, claim.others) if claim.others else combinations(team, 2)
    return list({frozenset(pair): pair for pair in pairs if pair[0] != pair[1]}.values())


EPISODE_CLAIMS = {
    "reaches": "from every start of the region, at rest, each of the {team} comes within {radius} of its own landmark "
    "({own}) at some step up to step {steps}",
    "covers": "from every start of the region, at rest, after {steps} steps the {team} are matched one-to-one to the "
    "landmarks{own}, each within {radius} of its own",
    KEEPS_APART: "from every start of the region, at rest, each of the {team} stays at least {radius} (L-infinity) "
    "away from {own} up to step {steps}",
}


MAX_STEPS = 1_000


MAX_ZONES = 10**12


MAX_RADIUS = 1 << 13  # zones hold lengths below eight times that (episodes/zones.py)


def parameters(name: str) -> tuple[str, ...]:
    """What the named claim reads beside its team."""
    return ("steps", "radius", "others" if name == KEEPS_APART else "landmarks", "zones")


def find_claim(
    name: str,
    profile: PolicyProfile,
    team: str | None = None,
    landmarks: Sequence[str] = (),
    steps: int | None = None,
    radius: Fraction | None = None,
    zones: int = DEFAULT_ZONES,
    others: Sequence[str] = (),
) -> EpisodeClaim:
    """The named closed-loop claim for a team of `profile`, by default over a whole episode.

    `landmarks`: one for each agent of the team; without them `reaches` takes the world's order, `covers` any matching.
    `zones`: how many may be visited. `others`: from whom the team keeps apart, without them from one another.
    `radius`: without it RADIUS; of `keeps_apart` the largest distance at which two of them touch.
    """
    if name not in EPISODE_CLAIMS:
        raise UnknownNameError("property", name, EPISODE_CLAIMS)
    team = team_for(name, profile, team, any_size=name == KEEPS_APART)
    check_landmarks(profile, team, landmarks)
    if name == KEEPS_APART:
        radius = _checked_apart(profile, EpisodeClaim(name, team, 0, others=tuple(others)), radius)
    radius = RADIUS if radius is None else radius
    steps = profile.world.episode_steps if steps is None else steps
    check_range("steps", steps, MAX_STEPS)
    check_range("radius", radius, MAX_RADIUS)
    check_range("zones", zones, MAX_ZONES, 1)
    if name == "reaches" and not landmarks:
        landmarks = [entity.name for entity in profile.world.landmarks][: len(profile.team(team))]
    return EpisodeClaim(name, team, steps, radius, tuple(landmarks), tuple(others), zones)


def _checked_apart(profile: PolicyProfile, claim: EpisodeClaim, radius: Fraction | None) -> Fraction:
    """The radius of `keeps_apart`; InputError where it speaks of nobody, of who does not exist, or says nothing."""
    sizes = {entity.name: entity.size for entity in profile.world.agents + profile.world.landmarks}
    for name in claim.others:
        if name not in sizes:
            raise UnknownNameError("entity", name, sizes, "others")
    ensure_somebody(profile, claim)
    pairs = apart_pairs(profile, claim)
    touching = max(Fraction(str(sizes[a])) + Fraction(str(sizes[b])) for a, b in pairs)
    radius = touching if radius is None else radius
    if radius == 0:
        raise InputError(f"{KEEPS_APART} with radius 0 says nothing", "radius", "give a radius above 0")
    return radius


def sentence(claim: EpisodeClaim, world: WorldSpec | None = None) -> str:
    """The claim in words; for a world also which starts it is not about, if any."""
    own = ", ".join(claim.landmarks)
    own = f" (in this order: {own})" if own and claim.name == "covers" else own
    own = ", ".join(claim.others) or "all others of them" if claim.name == KEEPS_APART else own
    said = EPISODE_CLAIMS[claim.name].format(team=claim.team, radius=claim.radius, steps=claim.steps, own=own)
    return "; ".join(filter(None, [said, "" if world is None else _left_out(world)]))


def in_general(name: str) -> str:
    """A named claim in words, without values."""
    own = "in the order of `landmarks`" if name == "reaches" else " (in the order of `landmarks`, if given)"
    own = "each of the `others` (without these, of the team)" if name == KEEPS_APART else own
    said = EPISODE_CLAIMS[name].format(team="team", radius="`radius`", steps="`steps`", own=own)
    return f"{said}; where entities push each other {COINCIDING}"


COINCIDING = (
    f"not about starts from which the centres of two that push each other ever come within {COINCIDENT:g} of each "
    "other, where the reference has no number"
)


def _left_out(world: WorldSpec) -> str:
    """Which starts claims in a world are not about, in words; "" for none."""
    return COINCIDING if partners(world) else ""


def ensure_somebody(profile: PolicyProfile, claim: EpisodeClaim) -> None:
    """InputError for a claim about nobody, which would be true whatever the profile does."""
    ensure_team(profile, claim.team)
    if claim.name == KEEPS_APART and not apart_pairs(profile, claim):
        raise InputError(
            f"{KEEPS_APART} needs at least two entities",
            f"team {claim.team}",
            "name the others to keep apart from",
        )
