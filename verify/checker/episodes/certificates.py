"""Certificates of claims about whole episodes: the members of their documents, and whether one is accepted.

Does: says what the members are; whether a certificate fits a profile and passes the checker.
Assumes: a profile that was read and checked; proofs of the form that README.md specifies, made by anyone.
Does not: make proofs, or write (verify/certificates).
"""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from typing import Any

import msgspec

from codegen.errors import InputError
from codegen.ir import PolicyProfile
from codegen.policy_json import content_hash
from verify.checker.certificate import REMAKE, Certificate, Forms, Members, ensure_about, numbers
from verify.checker.decisions.certificates import GameHeader, ensure_known_names
from verify.checker.episodes import unbounded
from verify.checker.episodes import walk as episodes
from verify.checker.episodes.contact_reading import ContactReading
from verify.checker.episodes.contacts import coincident
from verify.checker.episodes.reading import FARTHEST, EpisodeReading, PartedReading, ProofPart, certifiable
from verify.checker.episodes.unbounded import Edges
from verify.checker.reading import RejectedError, region_formula
from verify.claims.episodes import EpisodeClaim
from verify.claims.formula import holds
from verify.kinds import ALWAYS
from verify.semantics import MACHINE

FORM = "maviper-episode-certificate-1"
PUSHED = "maviper-episode-certificate-3"
UNBOUNDED = "maviper-episode-certificate-4"
READINGS = {FORM: EpisodeReading, "maviper-episode-certificate-2": PartedReading, PUSHED: ContactReading}


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
        kind, by_edges = certifiable(self.property), header.certificate == UNBOUNDED
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
        if not {part.agent} <= agents | {""} or not {*part.followed} <= agents or not part.followed:
            raise RejectedError("a part is about agents that the profile does not have")
        if (
            not {part.landmark} <= marks | {""}
            or part.goal not in ("", *header.region.goals)
            or (bool(part.agent) != bool(part.landmark))
        ):
            whom = "others" if claim.apart else "landmarks"
            raise RejectedError(f"a part is about {whom} that the profile does not have")
    proofs = [(part, numbers(part.proof)) for part in proof.parts]
    return episodes.check(profile, claim, header.region, proofs, READINGS[header.certificate])


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
