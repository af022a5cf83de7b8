"""Whole episodes of a profile: what closed-loop verdicts are refereed by.

Does: plays batches of episodes by the world's spec in float64, and says where a closed-loop claim fails, exactly.
Assumes: features have meanings, actions have effects.
Does not: search.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cache

import numpy as np
import numpy.typing as npt

from codegen.dynamics import COINCIDENT, Motion, partners
from codegen.errors import DisagreementError, InputError
from codegen.ir import Bool, Float64, PolicyProfile
from verify.claims.claim import verifiable
from verify.claims.decisions import matchings
from verify.claims.episodes import EpisodeClaim
from verify.claims.region import Region
from verify.claims.wording import ORIGIN, Pairs, account_of
from verify.question import EpisodeQuestion
from verify.states.state import State, choose_actions, inside

Actions = npt.NDArray[np.int64]


@dataclass(frozen=True)
class Episode:
    """One episode: all world coordinates after each step, start first, and what each agent chose."""

    coordinates: Float64  # [steps + 1, n_coordinates]
    actions: Actions  # [steps, n_agents]


# a start and a number of steps -> the course that the caller's world takes
EpisodeReplay = Callable[[State, int], Episode]


def playable(profile: PolicyProfile) -> None:
    """InputError when a world's motion is not what closed-loop claims cover, or an agent has no policy."""
    world = profile.world
    acting = {policy.agent for policy in profile.agents}
    missing = [entity.name for entity in world.agents if entity.name not in acting]
    if missing:
        raise InputError(
            f"{missing[0]} has no policy in the profile", world.name, "in an episode every agent needs a policy"
        )
    if world.dt <= 0:
        raise InputError(
            "the world's spec does not state its dynamics", world.name, "claims about episodes need dt and damping"
        )
    for team in dict.fromkeys(policy.team for policy in profile.agents):
        verifiable(profile, team)


def play(profile: PolicyProfile, start: Float64, steps: int) -> tuple[Float64, Actions]:
    """Episodes of the profile's own trees from rest. `start`: [batch, n_coordinates]; velocities are taken as zero.

    Returns coordinates [steps + 1, batch, n_coordinates] and actions [steps, batch, n_agents]. Operation by operation
    what the world's spec says: positions move with the old velocity.
    """
    world = profile.world
    policies = [profile.policy(entity.name) for entity in world.agents]
    motion = Motion(world, [policy.actions for policy in policies])
    names = world.coordinates()
    entities = [entity.name for entity in world.agents + world.landmarks]
    position = np.array([[names.index(f"{entity}.{axis}") for axis in "xy"] for entity in entities])
    velocity = np.array([[names.index(f"{entity.name}.v{axis}") for axis in "xy"] for entity in world.agents])
    now = start.copy()
    now[:, velocity] = 0.0
    episode, actions = [now], list[Actions]()
    for _ in range(steps):
        choice = np.stack([choose_actions(policy, now, world) for policy in policies], axis=1).astype(np.int64)
        places, speeds = motion.step(_planes(now, position), _planes(now, velocity), choice)
        now = now.copy()
        now[:, position], now[:, velocity] = places.transpose(2, 0, 1), speeds.transpose(2, 0, 1)
        episode.append(now)
        actions.append(choice)
    chosen_all = np.array(actions, dtype=np.int64).reshape(steps, len(start), len(world.agents))
    return np.array(episode), chosen_all


def _planes(coordinates: Float64, columns: Actions) -> Float64:
    """Some columns [n, 2] of coordinates [batch, n_coordinates] as planes [n, 2, batch]."""
    return np.ascontiguousarray(coordinates[:, columns].transpose(1, 2, 0))


def gaps(profile: PolicyProfile, claim: EpisodeClaim, episode: Float64) -> Float64:
    """L-infinity distances of the team's agents to the claim's marks, [..., agents, marks], in float64; infinite from
    an agent to itself.
    """
    names = profile.world.coordinates()

    def places(entities: Sequence[str]) -> Float64:
        if entities == [ORIGIN]:
            return np.zeros((*episode.shape[:-1], 1, 2))
        columns = [[names.index(f"{entity}.{axis}") for axis in "xy"] for entity in entities]
        return episode[..., np.array(columns)]

    team, others = [policy.agent for policy in profile.team(claim.team)], account_of(claim).marks(profile)
    distances = np.abs(places(team)[..., :, None, :] - places(others)[..., None, :, :]).max(axis=-1)
    return np.where(np.equal.outer(team, others), np.inf, distances)


def ways(profile: PolicyProfile, claim: EpisodeClaim) -> list[Pairs]:
    """Lists the ways to fulfil the claim: that all pairs of one of the ways have their distances."""
    account = account_of(claim)
    only = account.way(profile)
    if only is not None:
        return [only]
    return [tuple(enumerate(own)) for own in matchings(len(profile.team(claim.team)), len(account.marks(profile)))]


def find_matchings(profile: PolicyProfile, claim: EpisodeClaim) -> list[tuple[int, ...]]:
    """The matchings that fulfil a claim to arrive: for each agent of the team its landmark's number."""
    return [tuple(mark for _, mark in way) for way in ways(profile, claim)]


def name_pairs(profile: PolicyProfile, claim: EpisodeClaim) -> list[tuple[tuple[str, str], ...]]:
    """Lists the ways to fulfil a claim: for each way its pairs of an agent and a mark, by name."""
    team, marks = [policy.agent for policy in profile.team(claim.team)], account_of(claim).marks(profile)
    return [tuple((team[agent], marks[mark]) for agent, mark in way) for way in ways(profile, claim)]


def coinciding(profile: PolicyProfile, episode: Float64) -> Bool:
    """In which episodes of [steps + 1, ..., n_coordinates] the centres of two that push each other ever coincide: the
    reference has no number there, and claims are not about them.
    """
    names, coincide = profile.world.coordinates(), np.zeros(episode.shape[1:-1], dtype=bool)
    entities = [entity.name for entity in profile.world.agents + profile.world.landmarks]
    for a, b, _ in partners(profile.world):
        first, second = ([names.index(f"{entities[one]}.{axis}") for axis in "xy"] for one in (a, b))
        coincide |= (np.abs(episode[..., first] - episode[..., second]).max(axis=-1) <= COINCIDENT).any(axis=0)
    return coincide


def find_met_ways(profile: PolicyProfile, claim: EpisodeClaim, episode: Float64) -> Bool:
    """Returns which ways to fulfil the claim episodes of [steps + 1, batch, n_coordinates] are, [ways, batch], up to
    float64 rounding of distances.
    """
    account = account_of(claim)
    met = account.is_met(gaps(profile, claim, account.select_counted(episode)), float(claim.radius))
    pairs = (np.array(way).T for way in ways(profile, claim))
    return np.array([met[:, agents, marks].all(axis=1) for agents, marks in pairs])


def meets_claim(profile: PolicyProfile, claim: EpisodeClaim, episode: Float64) -> Bool:
    """Returns which episodes [steps + 1, batch, n_coordinates] fulfil the claim up to float64 rounding of distances."""
    return np.logical_or.reduce(find_met_ways(profile, claim, episode))


def fails(profile: PolicyProfile, claim: EpisodeClaim, episode: Float64) -> bool:
    """Returns True if one episode [steps + 1, n_coordinates] violates the claim: float64 positions, exact distances.

    An episode in which centres coincide, where the reference leaves the numbers, violates nothing.
    """
    if not np.isfinite(episode).all() or coinciding(profile, episode):
        return False
    names = {name: place for place, name in enumerate(profile.world.coordinates())}
    account = account_of(claim)
    counted = account.select_counted(episode)

    def places(entity: str) -> Float64:
        return counted[:, [names[f"{entity}.{axis}"] for axis in "xy"]]

    @cache
    def is_met(a: str, b: str) -> bool:
        first = places(a)
        second = np.zeros_like(first) if b == ORIGIN else places(b)
        steps = zip(first.tolist(), second.tolist(), strict=True)
        distances = [max(abs(Fraction(p) - Fraction(q)) for p, q in zip(a, b, strict=True)) for a, b in steps]
        return bool(account.is_met(np.array(distances, dtype=object), claim.radius))

    return not any(all(is_met(*pair) for pair in way) for way in name_pairs(profile, claim))


def courses(profile: PolicyProfile, states: Sequence[State], steps: int) -> tuple[Float64, Actions]:
    """`play` from points: coordinates [steps + 1, points, n_coordinates] and actions [steps, points, n_agents]."""
    return play(profile, np.concatenate([state.coordinates(profile) for state in states]), steps)


def first_failing(question: EpisodeQuestion, states: Sequence[State]) -> State | None:
    """The first of some starts that lies in the region and fails the claim, both exactly."""
    states = [state for state in states if inside(question.region, state)]
    if not states:
        return None
    profile, claim = question.profile, question.claim
    coordinates, _ = courses(profile, states, claim.steps)
    return next((p for row, p in enumerate(states) if fails(profile, claim, coordinates[:, row])), None)


def agree_on_course(profile: PolicyProfile, state: State, steps: int, rollouts: Mapping[str, EpisodeReplay]) -> Episode:
    """The course from a start; DisagreementError where a caller's world takes another one, by a single bit."""
    coordinates, actions = courses(profile, [state], steps)
    episode = Episode(coordinates[:, 0], actions[:, 0])
    for name, rollout in rollouts.items():
        other = rollout(state, steps)
        acts = np.array_equal(other.actions, episode.actions)
        if not acts or not np.array_equal(other.coordinates, episode.coordinates):
            differ = "positions" if acts else "actions"
            raise DisagreementError(
                f"the {name} plays another episode from the counterexample's start",
                f"the {differ} differ",
                "this is a bug",
            )
    return episode


def at_rest(region: Region) -> Region:
    """The region with velocities fixed to zero, from which starts are sampled."""
    still = {name: (Fraction(0), Fraction(0)) for name in region.box if name.endswith((".vx", ".vy"))}
    return Region({**region.box, **still}, region.goals, region.differences, region.apart, region.name)


@dataclass(frozen=True)
class Way:
    """The course of one agent of the team in an episode."""

    agent: str
    landmark: str  # its own; where any matching would do the one that it ends nearest to; or whom it comes nearest to
    nearest: float  # least L-infinity distance from the landmark, length units; from the origin the greatest one
    step: int  # at which it is there first
    last: float  # distance after the last step
    actions: tuple[str, ...]
    places: tuple[tuple[float, float], ...]  # after each step, start first

    def __str__(self) -> str:
        if self.landmark == ORIGIN:
            farthest = f"{self.agent} is {self.nearest:.3g} from the origin at step {self.step}"
            return f"{farthest} and ends {self.last:.3g} from it"
        nearest = f"{self.agent} comes within {self.nearest:.3g} of {self.landmark} (step {self.step})"
        return f"{nearest} and ends {self.last:.3g} from it"


def ways_of(profile: PolicyProfile, claim: EpisodeClaim, episode: Episode) -> tuple[Way, ...]:
    """Describes the ways of the team's agents in an episode."""
    account = account_of(claim)
    landmarks = account.marks(profile)
    apart = gaps(profile, claim, episode.coordinates)
    names, order = profile.world.coordinates(), [entity.name for entity in profile.world.agents]
    ways: list[Way] = []
    for number, policy in enumerate(profile.team(claim.team)):
        own = account.mark_of(profile, number, apart[:, number])
        distances = apart[:, number, own]
        step = account.worst(distances)
        columns = [names.index(f"{policy.agent}.{axis}") for axis in "xy"]
        actions = episode.actions[:, order.index(policy.agent)]
        ways.append(
            Way(
                agent=policy.agent,
                landmark=landmarks[own],
                nearest=float(distances[step]),
                step=step,
                last=float(distances[-1]),
                actions=tuple(policy.actions[int(action)].name for action in actions),
                places=tuple((float(x), float(y)) for x, y in episode.coordinates[:, columns]),
            )
        )
    return tuple(ways)
