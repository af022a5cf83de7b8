"""Claims about whole episodes from rest: does each agent arrive, do all keep apart, from every start of a region?

Does: decides `reaches`, `covers` and `keeps_apart` by zones, agent by agent where trees allow, and claims for ever by
  edges; replays counterexamples.
Assumes: a world whose dynamics its spec states; rollouts of other simulators are given by the caller.
Does not: merge zones; when there are too many the answer is UNKNOWN with their number.

Agents outside a group that is followed together may do anything, from rest: a proof holds whatever they do. A violation
is an episode in which every agent follows its own tree. Contacts are known between bounds (episodes/contacts.py), so
where they
matter a proof may be missed, never given wrongly.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from codegen.dynamics import partners
from codegen.intervals import Share
from codegen.ir import PolicyProfile
from verify.checker.episodes.certificates import EpisodeCertificate, check_certificate
from verify.checker.reading import RejectedError
from verify.claims.catalogue import describe_left_out, opponents_words
from verify.claims.episodes import EpisodeClaim
from verify.counterexamples.episode_explanation import EpisodeExplanation, explain_episode
from verify.counterexamples.search import simplest
from verify.episodes import certificates, unbounded
from verify.episodes.certificates import LeftOpenError, NoCertificateError
from verify.episodes.composition import ZonesDecision, decide
from verify.episodes.contacts import MAX_DRIFT
from verify.episodes.zones import SCALE, points_of, starts
from verify.question import EpisodeQuestion
from verify.result import SETTLED, Control, Cost, Evidence, Opinion, Result, Verdict
from verify.states.episodes import (
    Episode,
    EpisodeReplay,
    Way,
    agree_on_course,
    at_rest,
    coinciding,
    courses,
    fails,
    first_failing,
    meets_claim,
    play,
    playable,
    ways_of,
)
from verify.states.shares import SAMPLE_SEED
from verify.states.state import State, inside, sample, state_at

ENGINE, UNIT = "zones", "zones"
SAMPLES = 20_000
CONTROLS = 400_000  # zones for all shuffled leaves together: they mostly fail in a sampled start
LEFT_OPEN = "zones prove it, but the second reading of the policy does not: please report this"
NO_START = (
    "zones prove it, but no start in the region was found that the claim covers: one in float64 numbers, from which no "
    "two centres ever coincide; widen the region"
)
LONGER = 8  # times as long, about, as the usual ones are the episodes in which claims for ever are played
TRIED_STARTS = 100  # sampled starts that fail in float64, looked at exactly


@dataclass(frozen=True, kw_only=True, repr=False)
class EpisodeEvidence(Evidence):
    """The evidence for a verdict about whole episodes, and all else that a report says of it.

    For example:

        maviper.verify(team, claims.Covers()).evidence.ways
    """

    followed: tuple[tuple[str, ...], ...]
    violating: Share  #: of sampled starts
    idle: Share  #: of sampled starts from which a team that stands still fulfils the claim
    state: State | None  #: the start of the counterexample
    episode: Episode | None
    ways: tuple[Way, ...]  #: how the team's agents fare in it
    explanation: EpisodeExplanation | None = None  #: of the counterexample
    contacts: str  #: how they were treated, in words; "" where nothing collides
    opponents: bool  #: whether the proof follows agents of other teams by their own trees
    certificate: EpisodeCertificate | None = None
    uncertified: str = ""  #: why a proof has no certificate, and so one reading only

    @property
    def opponents_words(self) -> str:
        """For what other agents a proof holds."""
        return opponents_words(self.opponents)

    @property
    def failing_state(self) -> State | None:
        """The start of an episode that fails."""
        return self.state

    @property
    def plays_world(self) -> bool:
        """True if something beside the reference can play an episode again."""
        return bool(self.replays)


EpisodeResult = Result[EpisodeClaim, EpisodeEvidence]


def verify_episodes(
    question: EpisodeQuestion, rollouts: Mapping[str, EpisodeReplay], skipped: Sequence[str] = ()
) -> EpisodeResult:
    """The verdict on a claim about episodes: by sampled starts, then by zones; `rollouts` replay counterexamples."""
    profile, claim, region = question.profile, question.claim, question.region
    playable(profile)
    claim.ensure(profile)
    coordinates, _ = sample(at_rest(region), profile.world, _samples(claim), SAMPLE_SEED)
    still = meets_claim(profile, claim, coordinates[None])
    judged = _judge_question(question)
    decision, control = judged.decision, Control()
    if decision.verdict in SETTLED:
        controls = question.controls
        count = max(len(controls), 1)
        limits = {"max_zones": min(question.budgets.max_zones, CONTROLS) // count}
        judged_so = (_judge_question(each.spending(**limits), _samples(claim) // count) for each in controls)
        control = Control.of(each.decision.verdict for each in judged_so)
    state = episode = None
    if decision.state is not None:
        question = _shorten_question(question, decision.state)
        state = simplest(profile.world, decision.state, partial(_stands, question))
        question = _shorten_question(question, state)
        claim = question.claim
        episode = agree_on_course(profile, state, claim.steps, rollouts)
    evidence = EpisodeEvidence(
        followed=decision.followed,
        violating=judged.violating,
        idle=Share(int(still.sum()), len(still)),
        control=control,
        opinions=(Opinion(ENGINE, decision.verdict, decision.zones, UNIT),),
        state=state,
        episode=episode,
        ways=() if episode is None else ways_of(profile, claim, episode),
        replays=tuple(rollouts),
        skipped=tuple(skipped),
        contacts=_contacts(profile, decision),
        left_out=describe_left_out(profile.world),
        opponents=any(profile.policy(agent).team != claim.team for group in decision.followed for agent in group),
        explanation=None if episode is None or state is None else explain_episode(question, state, episode),
        certificate=judged.certificate,
        branches=judged.branches,
        uncertified=judged.uncertified,
    )
    cost = Cost(decision.zones, question.budgets.max_zones, UNIT)
    return Result(question, decision.verdict, decision.reason, evidence, cost)


def verdict(question: EpisodeQuestion) -> tuple[Verdict, str]:
    """The verdict of `verify_episodes` and its reason alone: without control, explanation and replays."""
    playable(question.profile)
    question.claim.ensure(question.profile)
    decision = _judge_question(question).decision
    return decision.verdict, decision.reason


@dataclass(frozen=True)
class _Judged:
    """A verdict that no reading leaves open, and what a proof rests on."""

    decision: ZonesDecision
    violating: Share
    certificate: EpisodeCertificate | None = None
    branches: int = 0
    uncertified: str = ""


def _judge_question(question: EpisodeQuestion, samples: int | None = None) -> _Judged:
    """The verdict, with so many sampled starts (None: the usual number): one of the zones that a proof is, only where
    the second reading leaves no start open. Where it gave up for size before it found an open branch, a proof has one
    reading, and says so.
    """
    decision, violating = _settle_question(question, _samples(question.claim) if samples is None else samples)
    if decision.verdict is Verdict.UNKNOWN and question.claim.by_edges:
        outcome = unbounded.decide(question)  # edges that agents never cross; who has some is followed alone
        decision = ZonesDecision(outcome.verdict, outcome.zones, outcome.reason)
        certificate = outcome.certificate
        if certificate is None:
            return _Judged(decision, violating)
        if not _has_start(question):
            return _Judged(_unknown(decision, NO_START), violating)
        try:
            branches = check_certificate(certificate, question.profile)
        except RejectedError as error:
            raise AssertionError(f"the checker refuses the edges of {question.claim.name}: {error}") from error
        return _Judged(replace(decision, followed=certificate.proof.followed), violating, certificate, branches)
    if decision.verdict is not Verdict.PROVED:
        return _Judged(decision, violating)
    if not _has_start(question):
        return _Judged(_unknown(decision, NO_START), violating)
    try:
        certificate = certificates.build_certificate(question, decision.parts)
        return _Judged(decision, violating, certificate, check_certificate(certificate, question.profile))
    except LeftOpenError as error:
        return _Judged(_unknown(decision, f"{LEFT_OPEN}: {error}"), violating)
    except NoCertificateError as error:
        return _Judged(decision, violating, uncertified=str(error))
    except RejectedError as error:
        raise AssertionError(f"the checker refuses the proof of {question.claim.name}: {error}") from error


def _unknown(decision: ZonesDecision, reason: str) -> ZonesDecision:
    return replace(decision, verdict=Verdict.UNKNOWN, reason=reason, followed=(), parts=())


def _has_start(question: EpisodeQuestion) -> bool:
    """Returns True if a start of the region was found that the claim is about."""
    profile, region = question.profile, question.region
    still = {name: 0.0 for name in region.box if name.endswith((".vx", ".vy"))}
    for position in points_of(starts(region, profile.world), SAMPLE_SEED):
        state = State(still | position, question.goals[0])
        if inside(region, state) and not coinciding(profile, courses(profile, [state], question.claim.steps)[0][:, 0]):
            return True
    return False


def _settle_question(question: EpisodeQuestion, samples: int) -> tuple[ZonesDecision, Share]:
    """The verdict, and the share of so many sampled starts that fail: one of them settles the claim without zones.
    UNKNOWN where edges are to show it.
    """
    profile, claim, region = question.profile, question.claim, question.region
    coordinates, goals = sample(at_rest(region), profile.world, samples, SAMPLE_SEED)
    episode, _ = play(profile, coordinates, claim.steps)
    bad = ~meets_claim(profile, claim, episode)
    bad[bad] = ~coinciding(profile, episode[:, bad])
    violating = Share(int(bad.sum()), len(bad))
    rows = np.flatnonzero(bad)[:TRIED_STARTS]
    resting = list[State]()
    for drawn in (state_at(region, profile.world, coordinates[row], int(goals[row])) for row in rows):
        still = {name: 0.0 if name.endswith((".vx", ".vy")) else value for name, value in drawn.position.items()}
        resting.append(State(still, drawn.goal))
    state = first_failing(question, resting)
    if state is not None:
        return ZonesDecision(Verdict.VIOLATED, 0, state=state), violating
    return ZonesDecision(Verdict.UNKNOWN, 0) if claim.by_edges else decide(question), violating


def _samples(claim: EpisodeClaim) -> int:
    """Returns the number of starts to play; fewer for a claim for ever, since its episodes are longer."""
    return SAMPLES // LONGER if claim.ever else SAMPLES


def _stands(question: EpisodeQuestion, state: State) -> bool:
    """Returns True if a start is a counterexample."""
    return first_failing(question, [state]) is not None


def _shorten_question(question: EpisodeQuestion, state: State) -> EpisodeQuestion:
    """The question about as many steps as a claim for ever needs to fail from a start."""
    profile, claim = question.profile, question.claim
    if not claim.ever:
        return question
    course = courses(profile, [state], claim.steps)[0][:, 0]
    steps = next(step for step in range(claim.steps + 1) if fails(profile, claim, course[: step + 1]))
    return question.about(replace(claim, steps=steps))


def _contacts(profile: PolicyProfile, decision: ZonesDecision) -> str:
    if not partners(profile.world) or not decision.zones or decision.verdict in (Verdict.VIOLATED, Verdict.VACUOUS):
        return ""
    if not decision.touched + decision.given_up:
        return "no two entities come near each other in any zone visited, so motion is followed exactly there"
    bounded = f"contact forces over-approximated by intervals in {decision.touched:,} zones"
    lost = f"since a position was not known within {MAX_DRIFT / SCALE:g}"
    given_up = f"; {decision.given_up:,} given up for the group then followed, {lost}"
    return bounded + (given_up if decision.given_up else "")
