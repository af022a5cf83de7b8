"""Whole episodes of a profile: what closed-loop verdicts are refereed by.

Does: plays batches of episodes by the world's spec in float64, and says where a closed-loop claim fails, exactly.
Assumes: features have meanings, actions have effects.
Does not: search.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from operator import le, lt

import numpy as np
import numpy.typing as npt

from codegen import ir
from codegen.dynamics import COINCIDENT, partners, push
from codegen.errors import DisagreementError, InputError
from codegen.ir import Bool, Float64, PolicyProfile
from verify.claims.episode_properties import apart_pairs
from verify.claims.episodes import KEEPS_APART, EpisodeClaim
from verify.claims.matching import matchings
from verify.claims.region import Region
from verify.claims.verifiable import verifiable
from verify.question import EpisodeQuestion
from verify.states.state import State, chosen, inside

Actions = npt.NDArray[np.int64]
ALIKE = 1e-6  # what two courses with contacts may differ by; contacts make differences of roundings larger


@dataclass(frozen=True)
class Episode:
    """One episode: all world coordinates after each step, start first, and what each agent chose."""

    coordinates: Float64  # [steps + 1, n_coordinates]
    actions: Actions  # [steps, n_agents]


EpisodeReplay = Callable[
    [State, int], Episode
]  # a start and a number of steps -> the course that the caller's world takes


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
    names = world.coordinates()
    position = np.array([[names.index(f"{entity.name}.{axis}") for axis in "xy"] for entity in world.agents])
    velocity = np.array([[names.index(f"{entity.name}.v{axis}") for axis in "xy"] for entity in world.agents])
    now = start.copy()
    now[:, velocity] = 0.0
    episode, actions = [now], []
    for _ in range(steps):
        choice = np.stack([chosen(policy, now, world) for policy in _in_order(profile)], axis=1).astype(np.int64)
        following = now.copy()
        following[:, position] += now[:, velocity] * world.dt
        pushes = _pushes(profile, now, choice)
        for agent, entity in enumerate(world.agents):
            speed = now[:, velocity[agent]] * (1.0 - world.damping) + pushes[agent] * world.dt
            if entity.max_speed is not None:
                size = np.sqrt((speed**2).sum(axis=1))
                fast = np.flatnonzero(size > entity.max_speed)
                speed[fast] = speed[fast] / size[fast, None] * entity.max_speed
            following[:, velocity[agent]] = speed
        episode.append(following)
        actions.append(choice)
        now = following
    chosen_all = np.array(actions, dtype=np.int64).reshape(steps, len(start), len(world.agents))
    return np.array(episode), chosen_all


def _pushes(profile: PolicyProfile, now: Float64, choice: Actions) -> Float64:
    """The forces on each agent, of its action and of contacts, [n_agents, batch, 2]."""
    world = profile.world
    names = world.coordinates()
    effects = [np.array([action.effect for action in policy.actions]) for policy in _in_order(profile)]
    found = np.stack([effects[agent][choice[:, agent]] * entity.force for agent, entity in enumerate(world.agents)])
    x, y = (
        [now[:, names.index(f"{entity.name}.{axis}")] for entity in world.agents + world.landmarks] for axis in "xy"
    )
    for a, b, touching in partners(world):
        rows, force = push(world, x[a] - x[b], y[a] - y[b], touching)
        found[a, rows] += force.T
        if b < len(found):
            found[b, rows] -= force.T
    return found


def _in_order(profile: PolicyProfile) -> list[ir.AgentPolicy]:
    return [profile.policy(entity.name) for entity in profile.world.agents]


def marks(profile: PolicyProfile, claim: EpisodeClaim) -> list[str]:
    """The entities from which a claim measures distances: landmarks, or those from whom the team keeps apart."""
    if claim.name == KEEPS_APART:
        return list(claim.others) or [policy.agent for policy in profile.team(claim.team)]
    return [entity.name for entity in profile.world.landmarks]


def gaps(profile: PolicyProfile, claim: EpisodeClaim, episode: Float64) -> Float64:
    """L-infinity distances of the team's agents to the claim's marks, [..., agents, marks], in float64; infinite from
    an agent to itself.
    """
    names = profile.world.coordinates()

    def places(entities: Sequence[str]) -> Float64:
        columns = [[names.index(f"{entity}.{axis}") for axis in "xy"] for entity in entities]
        return episode[..., np.array(columns)]

    team, others = [policy.agent for policy in profile.team(claim.team)], marks(profile, claim)
    found = np.abs(places(team)[..., :, None, :] - places(others)[..., None, :, :]).max(axis=-1)
    return np.where(np.equal.outer(team, others), np.inf, found)


def owned(profile: PolicyProfile, claim: EpisodeClaim) -> list[tuple[int, ...]]:
    """The matchings that fulfil the claim: for each agent of the team its landmark's number."""
    landmarks = [entity.name for entity in profile.world.landmarks]
    if claim.landmarks:
        return [tuple(landmarks.index(name) for name in claim.landmarks)]
    return matchings(len(profile.team(claim.team)), len(landmarks))


def coinciding(profile: PolicyProfile, episode: Float64) -> Bool:
    """In which episodes of [steps + 1, ..., n_coordinates] the centres of two that push each other ever coincide: the
    reference has no number there, and claims are not about them.
    """
    names, found = profile.world.coordinates(), np.zeros(episode.shape[1:-1], dtype=bool)
    entities = [entity.name for entity in profile.world.agents + profile.world.landmarks]
    for a, b, _ in partners(profile.world):
        first, second = ([names.index(f"{entities[one]}.{axis}") for axis in "xy"] for one in (a, b))
        found |= (np.abs(episode[..., first] - episode[..., second]).max(axis=-1) <= COINCIDENT).any(axis=0)
    return found


def fulfilled(profile: PolicyProfile, claim: EpisodeClaim, episode: Float64) -> Bool:
    """Which episodes of [steps + 1, batch, n_coordinates] fulfil the claim, up to float64 rounding of distances."""
    if claim.name == KEEPS_APART:
        return np.asarray((gaps(profile, claim, episode) >= float(claim.radius)).all(axis=(0, 2, 3)))
    near: Bool = np.asarray(gaps(profile, claim, episode) <= float(claim.radius))
    near = np.asarray(near.any(axis=0) if claim.name == "reaches" else near[-1])
    agents = np.arange(len(profile.team(claim.team)))
    return np.logical_or.reduce([near[:, agents, list(own)].all(axis=1) for own in owned(profile, claim)])


def fails(profile: PolicyProfile, claim: EpisodeClaim, episode: Float64) -> bool:
    """Whether one episode [steps + 1, n_coordinates] violates the claim: float64 positions, exact distances.

    An episode in which centres coincide, where the reference leaves the numbers, violates nothing.
    """
    if not np.isfinite(episode).all() or coinciding(profile, episode):
        return False
    names = {name: place for place, name in enumerate(profile.world.coordinates())}
    team = [policy.agent for policy in profile.team(claim.team)]
    landmarks = [entity.name for entity in profile.world.landmarks]

    def near(step: int, a: str, b: str, within: Callable[[Fraction, Fraction], bool] = le) -> bool:
        pairs = ((episode[step, names[f"{a}.{axis}"]], episode[step, names[f"{b}.{axis}"]]) for axis in "xy")
        return all(within(abs(Fraction(float(p)) - Fraction(float(q))), claim.radius) for p, q in pairs)

    if claim.name == KEEPS_APART:
        pairs = apart_pairs(profile, claim)
        return any(near(step, *pair, within=lt) for step in range(len(episode)) for pair in pairs)
    steps = range(len(episode)) if claim.name == "reaches" else [len(episode) - 1]
    return not any(
        all(any(near(step, agent, landmarks[own]) for step in steps) for agent, own in zip(team, matching, strict=True))
        for matching in owned(profile, claim)
    )


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


def alike(profile: PolicyProfile, one: Episode, other: Episode) -> bool:
    """Whether two courses are the same: bit for bit, but for the roundings of contacts where agents collide."""
    if not np.array_equal(one.actions, other.actions):
        return False
    if not partners(profile.world):
        return np.array_equal(one.coordinates, other.coordinates)
    return bool((np.abs(one.coordinates - other.coordinates) <= ALIKE).all())


def agreed(profile: PolicyProfile, state: State, steps: int, rollouts: Mapping[str, EpisodeReplay]) -> Episode:
    """The course from a start; DisagreementError where a caller's world takes another one."""
    coordinates, actions = courses(profile, [state], steps)
    episode = Episode(coordinates[:, 0], actions[:, 0])
    for name, rollout in rollouts.items():
        other = rollout(state, steps)
        if not alike(profile, other, episode):
            differ = "positions" if np.array_equal(other.actions, episode.actions) else "actions"
            raise DisagreementError(
                f"the {name} plays another episode from the counterexample's start",
                f"the {differ} differ",
                "this is a bug",
            )
    return episode


def fails_in_all(
    profile: PolicyProfile, claim: EpisodeClaim, state: State, rollouts: Mapping[str, EpisodeReplay]
) -> bool:
    """Whether a start fails the claim here and, on a course that is alike, in every caller's world."""
    coordinates, actions = courses(profile, [state], claim.steps)
    episode = Episode(coordinates[:, 0], actions[:, 0])
    if not fails(profile, claim, episode.coordinates):
        return False
    others = (rollout(state, claim.steps) for rollout in rollouts.values())
    return all(alike(profile, other, episode) and fails(profile, claim, other.coordinates) for other in others)


def at_rest(region: Region) -> Region:
    """The region with velocities fixed to zero, from which starts are sampled."""
    still = {name: (Fraction(0), Fraction(0)) for name in region.box if name.endswith((".vx", ".vy"))}
    return Region({**region.box, **still}, region.goals, region.differences, region.apart, region.name)


@dataclass(frozen=True)
class Way:
    """How one agent of the team fares in an episode."""

    agent: str
    landmark: str  # its own; where any matching would do the one that it ends nearest to; or whom it comes nearest to
    nearest: float  # least L-infinity distance from the landmark, length units
    step: int  # at which it is nearest first
    last: float  # distance after the last step
    actions: tuple[str, ...]
    places: tuple[tuple[float, float], ...]  # after each step, start first

    def __str__(self) -> str:
        nearest = f"{self.agent} comes within {self.nearest:.3g} of {self.landmark} (step {self.step})"
        return f"{nearest} and ends {self.last:.3g} from it"


def ways_of(profile: PolicyProfile, claim: EpisodeClaim, episode: Episode) -> tuple[Way, ...]:
    """How the team's agents fare in an episode."""
    landmarks = marks(profile, claim)
    apart = gaps(profile, claim, episode.coordinates)
    names, order = profile.world.coordinates(), [entity.name for entity in profile.world.agents]
    found = []
    for number, policy in enumerate(profile.team(claim.team)):
        nearest = apart[:, number].min(axis=0) if claim.name == KEEPS_APART else apart[-1, number]
        own = landmarks.index(claim.landmarks[number]) if claim.landmarks else int(nearest.argmin())
        distances = apart[:, number, own]
        columns = [names.index(f"{policy.agent}.{axis}") for axis in "xy"]
        actions = episode.actions[:, order.index(policy.agent)]
        found.append(
            Way(
                agent=policy.agent,
                landmark=landmarks[own],
                nearest=float(distances.min()),
                step=int(distances.argmin()),
                last=float(distances[-1]),
                actions=tuple(policy.actions[action].name for action in actions),
                places=tuple((float(x), float(y)) for x, y in episode.coordinates[:, columns]),
            )
        )
    return tuple(found)
