"""Certificates of claims about episodes of any length: edges that agents never cross.

Does: reads the document; says what agents must not do near an edge, and whether proofs of that show a claim.
Assumes: nothing beyond checker/reading.py, decisions/walk.py and thresholds.py; belongs to the trusted base.
Does not: look for edges (verify/episodes/edges.py).

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

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from fractions import Fraction
from math import ceil
from typing import Any, ClassVar, NamedTuple

import msgspec

from codegen.errors import InputError
from codegen.ir import EntitySpec, PolicyProfile
from codegen.policy_json import content_hash
from verify.checker.decisions.certificates import region_from
from verify.checker.decisions.walk import check
from verify.checker.envelope import REMAKE, ensure_about, ensure_readable, ensure_whole, numbers, read_proof
from verify.checker.episodes import certificates as over_steps
from verify.checker.episodes.certificates import EpisodeCertificate, Side, ensure_started
from verify.checker.episodes.reading import FARTHEST, ProofPart, certifiable, compute_push, ensure_stated
from verify.checker.reading import RejectedError
from verify.claims.claim import verifiable
from verify.claims.episodes import EpisodeClaim
from verify.claims.formula import Acts, Formula, Not, conjunction
from verify.claims.region import Interval, Region, goal_of
from verify.exact import read_number
from verify.kinds import ALWAYS
from verify.semantics import MACHINE, Semantics

FORM = "maviper-episode-certificate-4"
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


@dataclass(frozen=True)
class LastingCertificate:
    """A claim about the episodes of a profile from a region, and edges that agents never cross, with proofs."""

    profile: str  # content hash
    claim: EpisodeClaim
    region: Region
    inhabitant: Mapping[str, Fraction]  # a start of the region, which shows that it is not empty
    edges: Mapping[str, Interval]  # by coordinate of a place
    proofs: Mapping[Side, bytes]
    semantics: str = MACHINE
    region_said: str = field(default="", compare=False)  # what a file that was read calls its region; says nothing

    form: ClassVar[str] = FORM
    parts: ClassVar[tuple[ProofPart, ...]] = ()

    @property
    def size(self) -> int:
        """Bytes of all proofs."""
        return sum(map(len, self.proofs.values()))

    def reading(self, reader: Callable[[bytes], bytes]) -> "LastingCertificate":
        """The same with its proofs given to a reader."""
        return replace(self, proofs={side: reader(proof) for side, proof in self.proofs.items()})

    def check(self, profile: PolicyProfile) -> int:
        """Checks the certificate; see `check_certificate`."""
        return check_certificate(self, profile)

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
        self._profile, self._region = profile, region
        self.axes = {
            f"{entity.name}.{axis}": self._axis(entity, number, kept)
            for entity in world.agents
            for number, axis in enumerate("xy")
        }

    def _axis(self, entity: EntitySpec, number: int, kept: Fraction) -> Axis:
        world, policy = self._profile.world, self._profile.policy(entity.name)
        pushes = [Fraction(compute_push(action.effect, entity, world)[number]) for action in policy.actions]
        axis = Axis(tuple(pushes), Fraction(world.dt), kept)
        if max(axis.fastest(1), axis.fastest(-1)) * axis.dt > MAX_SPEED:
            raise RejectedError(f"{entity.name} may come farther than {MAX_SPEED} in a step")
        return axis

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

    def between(entity: str, axis: str) -> Interval:
        return places.get(f"{entity}.{axis}", (-RUNAWAY, RUNAWAY))

    broken = claim.describe_broken(profile, between)
    if broken:
        raise RejectedError(broken)


def check_certificate(certificate: LastingCertificate, profile: PolicyProfile) -> int:
    """Checks a certificate; the number of branches that its proofs close.

    InputError when it is about another policy or names what the profile does not have; RejectedError when a proof is
    missing or does not hold, or the edges do not show the claim.
    """
    ensure_about(certificate.profile, content_hash(profile), "profile", "--profile")
    start, semantics = certificate.inhabitant, certificate.semantics
    ensure_started(profile, certificate.claim, certificate.region, start, semantics)
    if not certificate.claim.by_edges:
        raise RejectedError(f"{certificate.claim.name} over some steps has proofs of another form")
    reading = EdgeReading(profile, certificate.region)
    reading.ensure(certificate.edges)
    ensure_shown(profile, certificate.claim, certificate.region, certificate.edges)
    sides = list(reading.sides(certificate.edges))
    if set(sides) != set(certificate.proofs):
        raise RejectedError("the proofs are not those of the edges")
    closed = 0
    for coordinate, upper, goal in sides:
        formula = reading.harmless(coordinate, upper)
        assert formula is not None
        region = reading.danger(certificate.edges, coordinate, upper)
        proof = numbers(certificate.proofs[coordinate, upper, goal])
        try:
            closed += check(profile, formula, region, goal, Semantics(MACHINE), proof)
        except RejectedError as error:
            edge = "upper" if upper else "lower"
            raise RejectedError(f"the {edge} edge of {coordinate}, goal {goal or 'none'}: {error}") from None
    return closed


# --- the text


class LastingCertificateJson(msgspec.Struct, forbid_unknown_fields=True):
    """The members of the file; numbers are exact texts. Proofs: by coordinate, `lower` or `upper`, and goal."""

    certificate: str
    profile: str
    property: str
    team: str
    steps: int | str
    radius: str
    semantics: str
    region: dict[str, Any]
    inhabitant: dict[str, str]
    edges: dict[str, tuple[str, str]]
    proofs: dict[str, dict[str, dict[str, list[str]]]]
    content_hash: str
    others: list[str] | msgspec.UnsetType = msgspec.UNSET


def from_json(text: str | bytes, where: str = "certificate") -> LastingCertificate:
    """The certificate in a text. InputError when it is damaged, of another version, or edited; RejectedError for claims
    that have no certificates.
    """
    with ensure_readable(where):
        raw = msgspec.json.decode(text, type=LastingCertificateJson)
        ensure_whole(raw, FORM, where)
        proofs = {
            (name, _upper(edge), goal_of(goal)): read_proof(lines, f"$.proofs.{name}.{edge}")
            for name, sides in raw.proofs.items()
            for edge, goals in sides.items()
            for goal, lines in goals.items()
        }
        return LastingCertificate(
            profile=raw.profile,
            claim=_claim(raw),
            region=region_from(raw.region),
            inhabitant={name: read_number(value) for name, value in raw.inhabitant.items()},
            edges={name: (read_number(low), read_number(high)) for name, (low, high) in raw.edges.items()},
            proofs=proofs,
            semantics=raw.semantics,
            region_said=str(raw.region["name"]),
        )


def _upper(edge: str) -> bool:
    if edge not in ("lower", "upper"):
        raise ValueError(f"$.proofs: {edge[:40]!r} is no edge")
    return edge == "upper"


def _claim(raw: LastingCertificateJson) -> EpisodeClaim:
    kind = certifiable(raw.property)
    if not kind.lasting:
        raise InputError(f"edges do not show {kind.title}", "$.property", REMAKE)
    if isinstance(raw.steps, str) and raw.steps != ALWAYS:
        raise ValueError(f"$.steps: {raw.steps[:40]!r}")
    named: dict[str, Any] = {} if isinstance(raw.others, msgspec.UnsetType) else {"others": tuple(raw.others)}
    if named.keys() != ({kind.whom} if kind.whom else set()):
        raise ValueError(f"$.others: {kind.title} states them, or has none")
    return kind(raw.team, radius=read_number(raw.radius), **kind.resolve_steps({"steps": raw.steps}), **named)


class _Head(msgspec.Struct):
    """Of what form a certificate is."""

    certificate: str = ""


def of_either(text: str | bytes, where: str = "certificate") -> EpisodeCertificate | LastingCertificate:
    """The certificate in a text, about episodes of some steps or of any length, as `from_json`."""
    with ensure_readable(where):
        form = msgspec.json.decode(text, type=_Head).certificate
    return from_json(text, where) if form == FORM else over_steps.from_json(text, where)
