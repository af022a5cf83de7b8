"""Proofs of claims about episodes of any length: edges that agents never cross.

Does: says what agents must not do near an edge, and whether proofs of that show a claim.
Assumes: nothing beyond checker/reading.py, decisions.py and thresholds.py; belongs to the trusted base.
Does not: look for edges (verify/episodes/unbounded.py).

Why edges hold. Along an axis an agent is at x with velocity v. Unless it is pushed, it comes to rest at z = x + k v,
where k = dt / damping: a step keeps z. A push by q adds k q to z. Let x and z be at most the edge. A step that does not
push outwards leaves z where it is or moves it inwards; x, which moves towards z, passes neither. A push outwards is
harmless while z + k q is at most the edge. Else x = z - k v is above edge - k q - k V, V being the top speed outwards.
There, whatever all else is, no tree may push outwards: this is a claim about single decisions, with a proof of its own.

Why float64 keeps it. A step errs by at most `once`. Without a push v shrinks by a factor, so that what x changes by
becomes nothing after some steps: the sum of all errors until the next push is at most `drift`, however long it takes.
A push inwards moves z by far more than that. So z exceeds the edge by at most `once + drift`, and x by that and `once`:
`_ensure_slack` asks that this is at most SLACK, by which every edge is widened wherever it is used.

Agents without edges may do anything. How fast they get is bounded all the same, and where they are, too: a float64
number that is large enough does not change when so little is added to it.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from fractions import Fraction
from math import ceil
from typing import Literal, NamedTuple

from codegen.ir import PolicyProfile
from verify.checker import decisions
from verify.checker.certificate import Bytes, Members, numbers
from verify.checker.episodes.reading import FARTHEST, compute_push, ensure_stated
from verify.checker.reading import RejectedError
from verify.claims.claim import verifiable
from verify.claims.episodes import EpisodeClaim
from verify.claims.formula import Acts, Formula, Not, conjunction
from verify.claims.region import Interval, Region, goal_of
from verify.kinds import MACHINE, Semantics

Side = tuple[str, bool, str | None]  # of an edge: coordinate; whether it is the upper one; goal
SLACK = Fraction(1, 1 << 30)  # what float64 may lose, length units
RUNAWAY = Fraction(1 << 60)  # nobody is ever farther away
MAX_SPEED = 16  # length units per step: nobody gets much farther than 2^58, since 2^58 + 16 is 2^58 in float64
LEAST_DAMPING, MAX_COASTING = Fraction(1, 256), 100_000  # steps
ROUNDED = Fraction(1, 1 << 50)  # relative error of a few operations
NOTHING = Fraction(1, 1 << 500)  # more than subnormal numbers ever add up to
GRID = 1 << 64  # speeds of the bound of coasting are rounded up to its multiples


class Axis(NamedTuple):
    """An agent's motion along one axis: what its actions add to the velocity in a step, and the rest of the world."""

    pushes: tuple[Fraction, ...]  # by action
    dt: Fraction
    kept: Fraction  # of the velocity, in a step

    @property
    def coasting(self) -> Fraction:
        """The distance that an agent still covers, for each unit of velocity."""
        return self.dt / (1 - self.kept)

    def strongest(self, outwards: int) -> Fraction:
        """The strongest push in a direction, 1 or -1; 0 for none."""
        return max(Fraction(0), *(outwards * push for push in self.pushes))

    def fastest(self, outwards: int) -> Fraction:
        """A bound of the velocity in a direction: a step from below it, and its rounding, stay below it."""
        return self.strongest(outwards) / (1 - self.kept) * (1 + Fraction(1, 1 << 40))

    def outward(self, outwards: int) -> list[int]:
        """The actions that push in a direction."""
        return [action for action, push in enumerate(self.pushes) if outwards * push > 0]


class Edges(Members, frozen=True):
    """Edges that agents never cross, and proofs of that: by coordinate, edge, and goal."""

    edges: Mapping[str, Interval]  # by coordinate of a place
    proofs: Mapping[str, Mapping[Literal["lower", "upper"], Mapping[str, Bytes]]]

    @property
    def sides(self) -> dict[Side, bytes]:
        """The proofs, by what each is about."""
        return {
            (name, edge == "upper", goal_of(goal)): proof
            for name, by_edge in self.proofs.items()
            for edge, by_goal in by_edge.items()
            for goal, proof in by_goal.items()
        }

    @property
    def followed(self) -> tuple[tuple[str, ...], ...]:
        """The agents that have edges, each of which is followed alone."""
        return tuple((agent,) for agent in dict.fromkeys(name.rpartition(".")[0] for name in self.edges))


class EdgeReading:
    """The parts of a profile that edges need. RejectedError for worlds that this reading does not cover."""

    def __init__(self, profile: PolicyProfile, region: Region) -> None:
        world = profile.world
        pushed = world.contact_force and any(agent.collides for agent in world.agents)
        if pushed or any(agent.max_speed is not None for agent in world.agents) or world.variables:
            raise RejectedError("in a world with contacts, speed limits or variables no edges are known for ever")
        kept = Fraction(1.0 - world.damping)
        if not (world.dt > 0 and 0 <= kept <= 1 - LEAST_DAMPING):
            raise RejectedError("the world's spec does not say that agents come to rest")
        ensure_stated(world, 0, region)
        if not {entity.name for entity in world.agents} <= {policy.agent for policy in profile.agents}:
            raise RejectedError("an agent of the world has no policy in the profile")
        self._profile, self._region, self.axes = profile, region, dict[str, Axis]()
        for entity in world.agents:
            pushes = [compute_push(action.effect, entity, world) for action in profile.policy(entity.name).actions]
            for number, name in enumerate("xy"):
                axis = Axis(tuple(Fraction(push[number]) for push in pushes), Fraction(world.dt), kept)
                if max(axis.fastest(1), axis.fastest(-1)) * axis.dt > MAX_SPEED:
                    raise RejectedError(f"{entity.name} may come farther than {MAX_SPEED} in a step")
                self.axes[f"{entity.name}.{name}"] = axis

    def danger(self, edges: Mapping[str, Interval], coordinate: str, upper: bool) -> Region:
        """Where a push beyond an edge may lead an agent across it."""
        axis, out = self.axes[coordinate], 1 if upper else -1
        box: dict[str, Interval] = {}
        for name, bounds in self._region.box.items():
            if name.endswith((".vx", ".vy")):
                moves = self.axes[f"{name[:-3]}.{name[-1]}"]
                box[name] = -moves.fastest(-1), moves.fastest(1)
            elif name in edges:
                box[name] = edges[name][0] - SLACK, edges[name][1] + SLACK
            else:
                box[name] = (-RUNAWAY, RUNAWAY) if name in self.axes else bounds
        reach = axis.coasting * (axis.strongest(out) + axis.fastest(out)) + SLACK
        low, high = edges[coordinate]
        box[coordinate] = (high - reach, high + SLACK) if upper else (low - SLACK, low + reach)
        return Region(box, self._region.goals)

    def harmless(self, coordinate: str, upper: bool) -> Formula | None:
        """That the agent does not push beyond an edge; None where no action of it does."""
        agent, actions = coordinate.rpartition(".")[0], self.axes[coordinate].outward(1 if upper else -1)
        return conjunction(*(Not(Acts(agent, action)) for action in actions)) if actions else None

    def sides(self, edges: Mapping[str, Interval]) -> Iterator[Side]:
        """Yields each side that has a proof: the edge's name, True for the upper edge, and the goal."""
        for name in edges:
            for upper in (False, True):
                if self.harmless(name, upper) is not None:
                    yield from ((name, upper, goal) for goal in self._region.goal_cases)

    def ensure(self, edges: Mapping[str, Interval]) -> None:
        """RejectedError unless all starts lie within the edges, and SLACK covers all rounding there."""
        for name, (low, high) in edges.items():
            if name not in self.axes:
                raise RejectedError("the edges are about places that no agent of the profile has")
            if not -FARTHEST <= low <= high <= FARTHEST:
                raise RejectedError(f"an edge lies beyond {FARTHEST}")
            start = self._region.box[name]
            if not low <= start[0] <= start[1] <= high:
                raise RejectedError(f"{name} may start beyond its edges")
            verifiable(self._profile, self._profile.policy(name.rpartition(".")[0]).team)
            _ensure_slack(self.axes[name], max(abs(low), abs(high)) + 1)


def _ensure_slack(axis: Axis, largest: Fraction) -> None:
    """RejectedError unless rounding moves an agent along an axis by less than SLACK until it is pushed again.

    `largest`: of its places. Of a step of x the sum rounds by at most half a unit in the last place of the result, and
    by no more than what is added, since x itself is a float64 number.
    """
    speed, coasting = max(axis.fastest(1), axis.fastest(-1)), axis.coasting
    step = ROUNDED * (largest + speed * axis.dt)  # of x in one step, as long as it changes by more than that
    once = step + coasting * ROUNDED * speed
    shrinks, steps, moving = axis.kept * (1 + ROUNDED), 0, speed * axis.dt
    while moving > step:
        moving, steps = Fraction(ceil(moving * shrinks * GRID), GRID), steps + 1
        if steps > MAX_COASTING:
            raise RejectedError("agents coast for too long")
    drift = steps * step + (2 * step + coasting * ROUNDED * speed) / (1 - shrinks) + NOTHING
    weakest = min((abs(push) for push in axis.pushes if push), default=Fraction(1)) * coasting
    if drift + 2 * once + step > SLACK or weakest < 2 * SLACK:
        raise RejectedError(f"rounding may move an agent by more than {float(SLACK):g} while it coasts")


def ensure_shown(profile: PolicyProfile, claim: EpisodeClaim, region: Region, edges: Mapping[str, Interval]) -> None:
    """RejectedError unless a claim holds of all places within the edges."""
    places = {name: (low - SLACK, high + SLACK) for name, (low, high) in edges.items()}
    agents = {entity.name for entity in profile.world.agents}
    places |= {name: bounds for name, bounds in region.box.items() if name.rpartition(".")[0] not in agents}
    claim.ensure(profile)
    claim.check_ranges()
    free = -RUNAWAY, RUNAWAY
    broken = claim.describe_broken(profile, lambda entity, axis: places.get(f"{entity}.{axis}", free))
    if broken:
        raise RejectedError(broken)


def check(profile: PolicyProfile, claim: EpisodeClaim, region: Region, proof: Edges) -> int:
    """The number of branches that the proofs of edges close; RejectedError when one is missing or does not hold, or the
    edges do not show the claim.
    """
    if not claim.by_edges:
        raise RejectedError(f"{claim.name} over some steps has proofs of another form")
    reading, edges, proofs = EdgeReading(profile, region), proof.edges, proof.sides
    reading.ensure(edges)
    ensure_shown(profile, claim, region, edges)
    sides = list(reading.sides(edges))
    if set(sides) != set(proofs):
        raise RejectedError("the proofs are not those of the edges")
    closed = 0
    for coordinate, upper, goal in sides:
        formula = reading.harmless(coordinate, upper)
        assert formula is not None
        read, danger = numbers(proofs[coordinate, upper, goal]), reading.danger(edges, coordinate, upper)
        try:
            closed += decisions.check(profile, (formula,), danger, goal, Semantics(MACHINE), read)
        except RejectedError as error:
            edge = "upper" if upper else "lower"
            raise RejectedError(f"the {edge} edge of {coordinate}, goal {goal or 'none'}: {error}") from None
    return closed
