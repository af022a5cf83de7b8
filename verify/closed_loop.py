"""Claims about whole episodes from rest: does each agent arrive, do all keep apart, from every start of a region?

Does: states `reaches`, `covers` and `keeps_apart`, decides them by zones, agent by agent where trees allow, replays
  counterexamples.
Assumes: a world whose dynamics its spec states; rollouts of other simulators are given by the caller.
Does not: merge zones; when there are too many the answer is UNKNOWN with their number.

Agents outside a group that is followed together may do anything, from rest: a proof holds whatever they do. A violation
is an episode in which every agent follows its own tree. Contacts are known between bounds (contacts.py), so where they
matter a proof may be missed, never given wrongly.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import partial

import numpy as np

from codegen.errors import InputError, UnknownNameError
from codegen.ir import PolicyProfile
from verify import episode_certificate
from verify.batch import LIMIT, SCALE
from verify.composition import Decision, decide
from verify.contacts import MOST_DRIFT, partners
from verify.counterexample import simplest
from verify.engine import CONTROL_SEED, shuffled
from verify.episode_certificate import EpisodeCertificate, NoCertificateError
from verify.episode_explanation import EpisodeExplanation, explained
from verify.episodes import DEFAULT_ZONES, KEEPS_APART, RADIUS, ClosedLoop
from verify.properties import check_landmarks, check_range, team_for
from verify.rollout import (
    Course,
    Rollout,
    Way,
    agreed,
    apart_pairs,
    at_rest,
    fails_in_all,
    first_failing,
    fulfilled,
    play,
    playable,
    ways_of,
)
from verify.shares import SAMPLE_SEED, Share
from verify.spec import Region, Verdict
from verify.world import Point, point_of, sample

CLOSED_LOOP = {
    "reaches": "from every start of the region, at rest, each of the {team} comes within {radius} of its own landmark "
    "({own}) at some step up to step {steps}",
    "covers": "from every start of the region, at rest, after {steps} steps the {team} are matched one-to-one to the "
    "landmarks{own}, each within {radius} of its own",
    KEEPS_APART: "from every start of the region, at rest, each of the {team} stays at least {radius} (L-infinity) "
    "away from {own} up to step {steps}",
}
MOST_STEPS = 1_000
MOST_ZONES = 10**12
MOST_RADIUS = LIMIT // 8  # zones hold lengths below LIMIT
SAMPLES = 20_000
NOT_ALIKE = "a start was found from which the claim fails here, but not in every simulator: contacts magnify roundings"
TRIED_STARTS = 100  # sampled starts that fail in float64, looked at exactly


@dataclass(frozen=True)
class LoopResult:
    """A verdict about whole episodes, with everything that a report says about it."""

    claim: ClosedLoop
    region: Region
    verdict: Verdict
    reason: str
    zones: int
    budget: int
    followed: tuple[tuple[str, ...], ...]
    violating: Share  # of sampled starts
    idle: Share  # of sampled starts from which a team that stands still fulfils the claim
    control: Verdict  # of the same team with shuffled leaves
    point: Point | None  # the start of the counterexample
    course: Course | None
    ways: tuple[Way, ...]  # how the team's agents fare in it
    replays: tuple[str, ...]
    skipped: tuple[str, ...]
    contacts: str  # how they were treated, in words; "" where nothing collides
    opponents: bool  # whether the proof follows agents of other teams by their own trees
    explanation: EpisodeExplanation | None = None  # of the counterexample
    certificate: EpisodeCertificate | None = None  # of a proof; the checker accepted it
    branches: int = 0  # that the certificate closes
    uncertified: str = ""  # why a proof has no certificate

    @property
    def whatever(self) -> str:
        """For what other agents a proof holds."""
        return whatever(self.opponents)


def whatever(opponents: bool) -> str:
    """For what other agents a proof holds that follows, or does not follow, opponents."""
    return "for opponents as in this profile" if opponents else "whatever all others do"


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
) -> ClosedLoop:
    """The named closed-loop claim for a team of `profile`, by default over a whole episode.

    `landmarks`: one for each agent of the team; without them `reaches` takes the world's order, `covers` any matching.
    `zones`: how many may be visited. `others`: from whom the team keeps apart, without them from one another.
    `radius`: without it RADIUS; of `keeps_apart` the largest distance at which two of them touch.
    """
    if name not in CLOSED_LOOP:
        raise UnknownNameError("property", name, CLOSED_LOOP)
    team = team_for(name, profile, team, any_size=name == KEEPS_APART)
    check_landmarks(profile, team, landmarks)
    if name == KEEPS_APART:
        radius = _checked_apart(profile, ClosedLoop(name, team, 0, others=tuple(others)), radius)
    radius = RADIUS if radius is None else radius
    steps = profile.world.episode_steps if steps is None else steps
    check_range("steps", steps, MOST_STEPS)
    check_range("radius", radius, MOST_RADIUS)
    check_range("zones", zones, MOST_ZONES, 1)
    if name == "reaches" and not landmarks:
        landmarks = [entity.name for entity in profile.world.landmarks][: len(profile.team(team))]
    return ClosedLoop(name, team, steps, radius, tuple(landmarks), tuple(others), zones)


def _checked_apart(profile: PolicyProfile, claim: ClosedLoop, radius: Fraction | None) -> Fraction:
    """The radius of `keeps_apart`; InputError where it speaks of nobody, of who does not exist, or says nothing."""
    sizes = {entity.name: entity.size for entity in profile.world.agents + profile.world.landmarks}
    for name in claim.others:
        if name not in sizes:
            raise UnknownNameError("entity", name, sizes, "others")
    pairs = apart_pairs(profile, claim)
    if not pairs:
        raise InputError(f"{KEEPS_APART} needs two", f"team {claim.team}", "name others from whom it keeps apart")
    touching = max(Fraction(str(sizes[a])) + Fraction(str(sizes[b])) for a, b in pairs)
    radius = touching if radius is None else radius
    if radius == 0:
        raise InputError(f"{KEEPS_APART} within 0 says nothing", "radius", "give a radius above 0")
    return radius


def sentence(claim: ClosedLoop) -> str:
    """The claim in words."""
    own = ", ".join(claim.landmarks)
    own = f" (in this order: {own})" if own and claim.name == "covers" else own
    own = ", ".join(claim.others) or "all others of them" if claim.name == KEEPS_APART else own
    return CLOSED_LOOP[claim.name].format(team=claim.team, radius=claim.radius, steps=claim.steps, own=own)


def in_general(name: str) -> str:
    """A named claim in words, without values."""
    own = "in the order of `landmarks`" if name == "reaches" else " (in the order of `landmarks`, if given)"
    own = "each of the `others` (without these, of the team)" if name == KEEPS_APART else own
    return CLOSED_LOOP[name].format(team="team", radius="`radius`", steps="`steps`", own=own)


def verify_episodes(
    profile: PolicyProfile,
    claim: ClosedLoop,
    region: Region,
    rollouts: Mapping[str, Rollout],
    skipped: Sequence[str] = (),
) -> LoopResult:
    """The verdict on a claim about episodes: by sampled starts, then by zones; `rollouts` replay counterexamples."""
    playable(profile)
    coordinates, _ = sample(at_rest(region), profile.world, SAMPLES, SAMPLE_SEED)
    still = fulfilled(profile, claim, coordinates[None])
    decision, violating = _settled(profile, claim, region)
    control = Verdict.SKIPPED
    if decision.verdict in (Verdict.PROVED, Verdict.VIOLATED):
        control = _settled(shuffled(profile, claim.team, CONTROL_SEED), claim, region)[0].verdict
    certificate, branches, uncertified = _certified(profile, claim, region, decision)
    point = course = None
    stands = partial(_stands, profile, claim, region, rollouts)
    if decision.point is not None and not stands(decision.point):
        decision = replace(decision, verdict=Verdict.UNKNOWN, reason=NOT_ALIKE, point=None)
    if decision.point is not None:
        point = simplest(profile.world, decision.point, stands)
        course = agreed(profile, point, claim.steps, rollouts)
    return LoopResult(
        claim=claim,
        region=region,
        verdict=decision.verdict,
        reason=decision.reason,
        zones=decision.zones,
        budget=claim.zones,
        followed=decision.followed,
        violating=violating,
        idle=Share(int(still.sum()), len(still)),
        control=control,
        point=point,
        course=course,
        ways=() if course is None else ways_of(profile, claim, course),
        replays=tuple(rollouts),
        skipped=tuple(skipped),
        contacts=_contacts(profile, decision),
        opponents=any(profile.policy(agent).team != claim.team for group in decision.followed for agent in group),
        explanation=None if course is None or point is None else explained(profile, claim, region, point, course),
        certificate=certificate,
        branches=branches,
        uncertified=uncertified,
    )


def _certified(
    profile: PolicyProfile, claim: ClosedLoop, region: Region, decision: Decision
) -> tuple[EpisodeCertificate | None, int, str]:
    """The certificate of a proof, the branches that it closes as the checker says, or why there is none."""
    if decision.verdict is not Verdict.PROVED:
        return None, 0, ""
    try:
        certificate = episode_certificate.made(profile, claim, region, decision.parts)
    except NoCertificateError as error:
        return None, 0, str(error)
    return certificate, episode_certificate.accepted(certificate, profile), ""


def _settled(profile: PolicyProfile, claim: ClosedLoop, region: Region) -> tuple[Decision, Share]:
    """The verdict, and the share of sampled starts that fail: one of them settles the claim without zones."""
    coordinates, goals = sample(at_rest(region), profile.world, SAMPLES, SAMPLE_SEED)
    bad = ~fulfilled(profile, claim, play(profile, coordinates, claim.steps)[0])
    violating = Share(int(bad.sum()), len(bad))
    rows = np.flatnonzero(bad)[:TRIED_STARTS]
    points = [point_of(region, profile.world, coordinates[row], int(goals[row])) for row in rows]
    point = first_failing(profile, claim, region, [_resting(point) for point in points])
    if point is not None:
        return Decision(Verdict.VIOLATED, 0, point=point), violating
    return decide(profile, claim, region, claim.zones), violating


def _resting(point: Point) -> Point:
    still = {name: 0.0 if name.endswith((".vx", ".vy")) else value for name, value in point.position.items()}
    return Point(still, point.goal)


def _stands(
    profile: PolicyProfile, claim: ClosedLoop, region: Region, rollouts: Mapping[str, Rollout], point: Point
) -> bool:
    """Whether a start is a counterexample. Where agents collide roundings grow, so it must fail wherever it is played;
    elsewhere all play alike, which `agreed` checks in the end.
    """
    if first_failing(profile, claim, region, [point]) is None:
        return False
    return not partners(profile.world) or fails_in_all(profile, claim, point, rollouts)


def _contacts(profile: PolicyProfile, decision: Decision) -> str:
    if not partners(profile.world) or not decision.zones or decision.verdict in (Verdict.VIOLATED, Verdict.VACUOUS):
        return ""
    if not decision.touched + decision.given_up:
        return "none comes near in any zone visited, so motion is followed exactly there"
    bounded = f"pushes over-approximated by intervals in {decision.touched:,} zones"
    lost = f"where somebody's place was not known within {MOST_DRIFT / SCALE:g}"
    given_up = f"; {decision.given_up:,} given up by the group then followed, {lost}"
    return bounded + (given_up if decision.given_up else "")
