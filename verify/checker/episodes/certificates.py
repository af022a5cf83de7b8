"""Certificates of claims about whole episodes: the members of their documents, and whether one is accepted.

Does: says what the members are; whether a certificate fits a profile; walks the search that README.md specifies, and
  adds exact numbers along the cycles of bounds that a proof names, so that each of its branches is closed again.
Assumes: a profile that was read and checked; proofs of the form that README.md specifies, made by anyone.
Does not: search for cycles, import an engine, or write (verify/certificates).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction
from itertools import pairwise
from typing import Any, TypeAlias

import msgspec

from codegen.errors import InputError
from codegen.ir import PolicyProfile
from codegen.policy_json import content_hash
from verify.checker.certificate import REMAKE, Bytes, Certificate, Forms, Members, ensure_about, numbers
from verify.checker.decisions import GameHeader, ensure_known_names
from verify.checker.episodes import unbounded
from verify.checker.episodes.contacts import ContactReading, coincident
from verify.checker.episodes.reading import (
    AWAY,
    CLAIM,
    FARTHEST,
    REGION,
    EpisodeReading,
    Gap,
    PartedReading,
    Place,
    Side,
    matchings,
)
from verify.checker.episodes.unbounded import Edges
from verify.checker.reading import LONGEST, RejectedError, region_formula
from verify.claims.episodes import EPISODE_CLAIMS, EpisodeClaim
from verify.claims.formula import holds
from verify.claims.region import Region, goal_of
from verify.kinds import ALWAYS, MACHINE

FORM = "maviper-episode-certificate-1"
PUSHED = "maviper-episode-certificate-3"
UNBOUNDED = "maviper-episode-certificate-4"
READINGS = {FORM: EpisodeReading, "maviper-episode-certificate-2": PartedReading, PUSHED: ContactReading}


class ProofPart(Members, frozen=True):
    """The statement of one proof: that an agent arrives at a landmark, or keeps apart from another entity; or (both
    names are "") that the team is matched, or all pairs keep apart.

    For one goal, or for all of them (goal is ""); `followed` agents act by their trees, others as they like.
    """

    agent: str
    landmark: str
    goal: str
    followed: tuple[str, ...]
    proof: Bytes


class Parts(Members, frozen=True):
    """A proof for each part of a claim."""

    parts: tuple[ProofPart, ...]

    @property
    def followed(self) -> tuple[tuple[str, ...], ...]:
        """The agents that are followed together in each part."""
        return tuple(part.followed for part in self.parts)


class _Claim(Members, frozen=True):
    property: str
    team: str
    steps: int | str
    radius: Fraction
    landmarks: tuple[str, ...] | msgspec.UnsetType = msgspec.UNSET  # of claims that an agent arrives
    others: tuple[str, ...] | msgspec.UnsetType = msgspec.UNSET  # of claims that it keeps apart

    def read(self, header: GameHeader) -> EpisodeClaim:
        """The claim. RejectedError for those that have no certificates."""
        if self.property not in EPISODE_CLAIMS:
            raise RejectedError(f"proofs of {ascii(self.property)[1:-1]} have no certificates about episodes")
        kind, by_edges = EPISODE_CLAIMS[self.property], header.certificate == UNBOUNDED
        if by_edges and not kind.lasting:
            raise InputError(f"edges do not show {kind.title}", "$.property", REMAKE)
        if isinstance(self.steps, str) and not (by_edges and self.steps == ALWAYS):
            raise ValueError(f"$.steps: {self.steps[:40]!r}")
        given = {name: getattr(self, name) for name in ("landmarks", "others")}
        named: dict[str, Any] = {name: names for name, names in given.items() if names is not msgspec.UNSET}
        if named.keys() != ({kind.whom} if kind.whom or not by_edges else set()):
            raise ValueError(f"$.{kind.whom or 'others'}: {kind.title} states these, and no other names")
        return kind(self.team, radius=self.radius, **kind.resolve_steps({"steps": self.steps}), **named)


EpisodeCertificate = Certificate[GameHeader, EpisodeClaim, Parts | Edges]
FORMS = Forms(GameHeader, _Claim, {**dict.fromkeys(READINGS, Parts), UNBOUNDED: Edges})


def check_certificate(certificate: EpisodeCertificate, profile: PolicyProfile) -> int:
    """Checks a certificate; the number of branches that its proofs close.

    InputError when it is about another policy or names what the profile does not have; RejectedError when a proof is
    missing or does not hold.
    """
    header, claim, proof = certificate.header, certificate.claim, certificate.proof
    ensure_about(header.profile, content_hash(profile), "profile", "--profile")
    ensure_started(profile, claim, header)
    if isinstance(proof, Edges):
        return unbounded.check(profile, claim, header.region, proof)
    if claim.by_edges:
        raise RejectedError(f"{claim.name} for ever has proofs of another form")
    if coincident(profile.world, header.inhabitant):
        raise RejectedError("at its inhabitant two that push each other stand in one place, where claims say nothing")
    agents, marks = {each.agent for each in profile.agents}, {mark.name for mark in profile.world.landmarks}
    marks |= agents if claim.apart else set()
    for part in proof.parts:
        if part.agent not in agents | {""} or not {*part.followed} <= agents or not part.followed:
            raise RejectedError("a part is about agents that the profile does not have")
        fits = part.landmark in marks | {""} and bool(part.agent) == bool(part.landmark)
        if not fits or part.goal not in ("", *header.region.goals):
            whom = "others" if claim.apart else "landmarks"
            raise RejectedError(f"a part is about {whom} that the profile does not have")
    return check_parts(profile, claim, header.region, proof.parts, READINGS[header.certificate])


def ensure_started(profile: PolicyProfile, claim: EpisodeClaim, header: GameHeader) -> None:
    """InputError for a region that names what the profile does not have, RejectedError unless it holds the start."""
    start: Mapping[str, Fraction] = header.inhabitant
    ensure_known_names(profile, header, claim.team)
    if any(value and name.endswith((".vx", ".vy")) for name, value in start.items()) or any(
        abs(value) > FARTHEST or Fraction(float(value)) != value for value in start.values()
    ):
        raise RejectedError("its inhabitant is not a start that proofs cover: float64 positions, at rest")
    if header.semantics != MACHINE:
        raise RejectedError(f"proofs about episodes are for {MACHINE} arithmetic")
    if not holds(region_formula(header.region), start, {}):
        raise RejectedError("its inhabitant is not a start in the region, so the claim may be vacuous")


GO_ON = 0  # the number of a branch below which the search goes on
EVERY = -1  # no answer: below every answer the search goes on


# A branch that must be closed: how many bounds it keeps, the side that it adds to them, its place, and either EVERY or
# the answer to which all its starts are said to come. A side's child is asked next, else the question of the place.
Branch: TypeAlias = tuple[int, Side | None, Place, int]


def check_parts(
    profile: PolicyProfile,
    claim: EpisodeClaim,
    region: Region,
    parts: Sequence[ProofPart],
    reading: type[EpisodeReading] = EpisodeReading,
) -> int:
    """The number of branches closed; RejectedError when the parts do not show the claim for all goals of the region."""
    allowed, closed = matchings(profile, claim), 0
    for goal in region.goal_cases:
        pairs = {(part.agent, part.landmark) for part in parts if part.goal in ("", goal)}
        whole_team = ("", "") in pairs
        if not whole_team and not any(pairs.issuperset(matching) for matching in allowed):
            raise RejectedError(f"goal {goal or 'none'}: the parts do not make up the claim")
    for part in parts:
        own = [((part.agent, part.landmark),)] if part.agent else allowed
        closed += close(reading(profile, claim, region, goal_of(part.goal), part.followed, own), numbers(part.proof))
    return closed


def close(episode: EpisodeReading, proof: Iterator[int]) -> int:
    """The number of branches closed; RejectedError when `proof` does not close all of them."""
    try:
        closed = EpisodeWalk(episode, proof).close()
    except (StopIteration, IndexError):
        raise RejectedError("the proof ends early, or names a bound that its branch does not have") from None
    if next(proof, None) is not None:
        raise RejectedError("the proof continues after its last branch")
    return closed


class EpisodeWalk:
    """The walk through an episode's questions, step by step."""

    def __init__(self, episode: EpisodeReading, proof: Iterator[int]) -> None:
        self.episode, self.proof, self.closed = episode, proof, 0
        self.bounds = BranchBounds(episode)

    def close(self) -> int:
        """Closes every branch; how many there are."""
        episode, bounds, proof = self.episode, self.bounds, self.proof
        branches: list[Branch] = [(0, None, (REGION, episode.region, (), episode.start), EVERY)]
        while branches:
            kept, side, place, only = branches.pop()
            stage, node, chosen, now = place
            bounds.keep(kept)
            if side is not None:
                bounds.add(*episode.bound(side, now))
                node, kept = side.child, kept + 1
            code = GO_ON if side is None and not isinstance(node, tuple) else next(proof)
            if code > episode.answers:
                self.ensure_empty(code - episode.answers - 1)
                self.closed += 1
                continue
            if isinstance(node, Gap):
                if code != GO_ON:
                    raise RejectedError(f"branch {self.closed} is said to answer how far two are apart")
                number = next(proof)
                node = episode.cut(node, number) if number else node
            elif code != GO_ON:  # all starts are said to come to one answer: the search goes on with it, at last
                if only != EVERY:
                    raise RejectedError(f"branch {self.closed} is said to answer two questions at once")
                only = code - 1
                branches.append((kept, None, (stage, only, chosen, now), EVERY))
                if (stage, only) == (CLAIM, AWAY):  # nothing need be shown: starts that have arrived may go on
                    continue
            if isinstance(node, tuple):
                branches += [(kept, side, place, only) for side in reversed(node) if side.child != only]
            elif only != EVERY:
                raise RejectedError(f"branch {self.closed} has an answer other than the one given as the only one")
            elif following := episode.onward(stage, node, chosen, now):
                branches.append((kept, None, following, EVERY))
        return self.closed

    def ensure_empty(self, between: int) -> None:
        """RejectedError unless the bounds around a cycle have a negative sum, so that no start meets them all.

        The cycle begins and ends with the bound that was added last; the proof names the coordinates in `between`.
        """
        upper, lower = self.bounds.last
        cycle = [upper, lower, *[next(self.proof) for _ in range(between)], upper]
        if len(cycle) > LONGEST or sum(self.bounds.most[p][q] for p, q in pairwise(cycle)) >= 0:
            raise RejectedError(f"the bounds of branch {self.closed} do not contradict each other: {cycle[1:10]}")


class BranchBounds:
    """The least bound on each difference of two coordinates that the branch at hand has, and what it had before."""

    def __init__(self, episode: EpisodeReading) -> None:
        self.most = [[episode.far] * episode.nodes for _ in range(episode.nodes)]  # [upper][lower]
        self.last = 0, 0  # (upper, lower) of the bound that was added or taken back last
        self._before: list[tuple[int, int, int]] = []

    def add(self, upper: int, lower: int, most: int) -> None:
        """Adds upper - lower <= most."""
        row, self.last = self.most[upper], (upper, lower)
        self._before.append((upper, lower, row[lower]))
        if most < row[lower]:
            row[lower] = most

    def keep(self, count: int) -> None:
        """Takes back all bounds but the first `count`."""
        while len(self._before) > count:
            upper, lower, before = self._before.pop()
            self.most[upper][lower] = before
            self.last = upper, lower
