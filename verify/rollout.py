"""Whole episodes of a profile in a world without contacts: what closed-loop verdicts are refereed by.

Does: plays batches of episodes by the world's spec in float64, and says where a closed-loop claim fails, exactly.
Assumes: no agent that matters touches another; features have meanings, actions have effects.
Does not: search.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction

import numpy as np
import numpy.typing as npt

from codegen import ir
from codegen.errors import DisagreementError, InputError
from codegen.ir import Bool, Float64, PolicyProfile
from verify.matching import matchings
from verify.spec import Region
from verify.world import Point, chosen, inside, verifiable

Actions = npt.NDArray[np.int64]
RADIUS = Fraction(2, 5)
DEFAULT_ZONES = 5_000_000  # visited for a claim; about a million a second


@dataclass(frozen=True)
class Course:
    """One episode: all world coordinates after each step, start first, and what each agent chose."""

    coordinates: Float64  # [steps + 1, n_coordinates]
    actions: Actions  # [steps, n_agents]


Rollout = Callable[[Point, int], Course]  # a start and a number of steps -> the course that the caller's world takes


@dataclass(frozen=True)
class ClosedLoop:
    """A claim about whole episodes from rest; `landmarks`: one for each agent, or none where any matching will do."""

    name: str
    team: str
    steps: int
    radius: Fraction = RADIUS
    landmarks: tuple[str, ...] = ()
    zones: int = field(default=DEFAULT_ZONES, compare=False)  # that deciding it may visit
    label: str = field(default="", compare=False)

    @property
    def shown(self) -> str:
        """The label, or else the name."""
        return self.label or self.name


def playable(profile: PolicyProfile) -> None:
    """InputError when a world's motion is not what closed-loop claims cover."""
    world = profile.world
    if world.dt <= 0:
        raise InputError("the world's spec states no dynamics", world.name, "closed-loop claims need dt and damping")
    if any(entity.collides for entity in world.agents):
        raise InputError(
            "closed-loop claims are for worlds without contacts",
            f"in {world.name} agents collide, and contact forces are not linear",
            "use claims about single decisions, such as distinct_targets",
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
    course, actions = [now], []
    for _ in range(steps):
        choice = np.stack([chosen(policy, now, world) for policy in _in_order(profile)], axis=1)
        following = now.copy()
        following[:, position] += now[:, velocity] * world.dt
        for agent, (policy, entity) in enumerate(zip(_in_order(profile), world.agents, strict=True)):
            effect = np.array([action.effect for action in policy.actions]) * entity.force * world.dt
            speed = now[:, velocity[agent]] * (1.0 - world.damping) + effect[choice[:, agent]]
            if entity.max_speed is not None:
                size = np.sqrt((speed**2).sum(axis=1))
                fast = np.flatnonzero(size > entity.max_speed)
                speed[fast] = speed[fast] / size[fast, None] * entity.max_speed
            following[:, velocity[agent]] = speed
        course.append(following)
        actions.append(choice)
        now = following
    chosen_all = np.array(actions, dtype=np.int64).reshape(steps, len(start), len(world.agents))
    return np.array(course), chosen_all


def _in_order(profile: PolicyProfile) -> list[ir.AgentPolicy]:
    return [profile.policy(entity.name) for entity in profile.world.agents]


def gaps(profile: PolicyProfile, claim: ClosedLoop, course: Float64) -> Float64:
    """L-infinity distances of the team's agents to all landmarks, [..., agents, landmarks], in float64."""
    names = profile.world.coordinates()

    def places(entities: Sequence[str]) -> Float64:
        columns = [[names.index(f"{entity}.{axis}") for axis in "xy"] for entity in entities]
        return course[..., np.array(columns)]

    agents = places([policy.agent for policy in profile.team(claim.team)])
    landmarks = places([entity.name for entity in profile.world.landmarks])
    return np.abs(agents[..., :, None, :] - landmarks[..., None, :, :]).max(axis=-1)


def owned(profile: PolicyProfile, claim: ClosedLoop) -> list[tuple[int, ...]]:
    """The matchings that fulfil the claim: for each agent of the team its landmark's number."""
    landmarks = [entity.name for entity in profile.world.landmarks]
    if claim.landmarks:
        return [tuple(landmarks.index(name) for name in claim.landmarks)]
    return matchings(len(profile.team(claim.team)), len(landmarks))


def fulfilled(profile: PolicyProfile, claim: ClosedLoop, course: Float64) -> Bool:
    """Which episodes of [steps + 1, batch, n_coordinates] fulfil the claim, up to float64 rounding of distances."""
    near: Bool = np.asarray(gaps(profile, claim, course) <= float(claim.radius))
    near = np.asarray(near.any(axis=0) if claim.name == "reaches" else near[-1])
    agents = np.arange(len(profile.team(claim.team)))
    return np.logical_or.reduce([near[:, agents, list(own)].all(axis=1) for own in owned(profile, claim)])


def fails(profile: PolicyProfile, claim: ClosedLoop, course: Float64) -> bool:
    """Whether one episode [steps + 1, n_coordinates] violates the claim: float64 positions, exact distances."""
    names = {name: place for place, name in enumerate(profile.world.coordinates())}
    team = [policy.agent for policy in profile.team(claim.team)]
    landmarks = [entity.name for entity in profile.world.landmarks]

    def at(step: int, agent: str, landmark: str) -> bool:
        pairs = ((course[step, names[f"{agent}.{axis}"]], course[step, names[f"{landmark}.{axis}"]]) for axis in "xy")
        return all(abs(Fraction(float(a)) - Fraction(float(b))) <= claim.radius for a, b in pairs)

    steps = range(len(course)) if claim.name == "reaches" else [len(course) - 1]
    return not any(
        all(any(at(step, agent, landmarks[own]) for step in steps) for agent, own in zip(team, matching, strict=True))
        for matching in owned(profile, claim)
    )


def courses(profile: PolicyProfile, points: Sequence[Point], steps: int) -> tuple[Float64, Actions]:
    """`play` from points: coordinates [steps + 1, points, n_coordinates] and actions [steps, points, n_agents]."""
    return play(profile, np.concatenate([point.coordinates(profile) for point in points]), steps)


def first_failing(profile: PolicyProfile, claim: ClosedLoop, region: Region, points: Sequence[Point]) -> Point | None:
    """The first of some starts that lies in the region and fails the claim, both exactly."""
    points = [point for point in points if inside(region, point)]
    if not points:
        return None
    coordinates, _ = courses(profile, points, claim.steps)
    return next((p for row, p in enumerate(points) if fails(profile, claim, coordinates[:, row])), None)


def agreed(profile: PolicyProfile, point: Point, steps: int, rollouts: Mapping[str, Rollout]) -> Course:
    """The course from a start; DisagreementError where a caller's world takes another one, bit for bit."""
    coordinates, actions = courses(profile, [point], steps)
    course = Course(coordinates[:, 0], actions[:, 0])
    for name, rollout in rollouts.items():
        other = rollout(point, steps)
        same = np.array_equal(other.actions, course.actions)
        if not (same and np.array_equal(other.coordinates, course.coordinates)):
            raise DisagreementError(
                f"the {name} takes another course from the counterexample",
                f"the {'positions' if same else 'actions'} differ",
                "this is a bug",
            )
    return course


def at_rest(region: Region) -> Region:
    """The region with velocities fixed to zero, from which starts are sampled."""
    still = {name: (Fraction(0), Fraction(0)) for name in region.box if name.endswith((".vx", ".vy"))}
    return Region({**region.box, **still}, region.goals, region.differences, region.apart, region.name)


@dataclass(frozen=True)
class Way:
    """How one agent of the team fares in an episode."""

    agent: str
    landmark: str  # its own, or where any matching would do the one that it ends nearest to
    nearest: float  # least L-infinity distance from the landmark, length units
    step: int  # at which it is nearest first
    last: float  # distance after the last step
    actions: tuple[str, ...]
    places: tuple[tuple[float, float], ...]  # after each step, start first

    def __str__(self) -> str:
        nearest = f"{self.agent} comes within {self.nearest:.3g} of {self.landmark} (step {self.step})"
        return f"{nearest} and ends {self.last:.3g} from it"


def ways_of(profile: PolicyProfile, claim: ClosedLoop, course: Course) -> tuple[Way, ...]:
    """How the team's agents fare in an episode."""
    landmarks = [entity.name for entity in profile.world.landmarks]
    apart = gaps(profile, claim, course.coordinates)
    names, order = profile.world.coordinates(), [entity.name for entity in profile.world.agents]
    found = []
    for number, policy in enumerate(profile.team(claim.team)):
        nearest_last = int(apart[-1, number].argmin())
        own = landmarks.index(claim.landmarks[number]) if claim.landmarks else nearest_last
        distances = apart[:, number, own]
        columns = [names.index(f"{policy.agent}.{axis}") for axis in "xy"]
        actions = course.actions[:, order.index(policy.agent)]
        found.append(
            Way(
                agent=policy.agent,
                landmark=landmarks[own],
                nearest=float(distances.min()),
                step=int(distances.argmin()),
                last=float(distances[-1]),
                actions=tuple(policy.actions[action].name for action in actions),
                places=tuple((float(x), float(y)) for x, y in course.coordinates[:, columns]),
            )
        )
    return tuple(found)
