"""Certificates of claims about whole episodes: the document with its proofs, and whether it is accepted.

Does: reads the document; whether one fits a profile and passes the checker.
Assumes: a profile that was read and checked; proofs of the form that README.md specifies, made by anyone.
Does not: make proofs, or write (verify/certificates).
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from fractions import Fraction
from typing import Any, ClassVar

import msgspec

from codegen.ir import PolicyProfile
from codegen.policy_json import content_hash
from verify.checker.decisions.certificates import Certificate, ensure_known_names, region_from
from verify.checker.envelope import ensure_about, ensure_readable, ensure_whole, numbers, read_proof
from verify.checker.episodes import walk as episodes
from verify.checker.episodes.contact_reading import ContactReading
from verify.checker.episodes.contacts import coincident
from verify.checker.episodes.reading import FARTHEST, EpisodeReading, PartedReading, ProofPart, certifiable
from verify.checker.reading import RejectedError, region_formula
from verify.claims.episodes import EpisodeClaim
from verify.claims.formula import TRUE, holds
from verify.claims.region import Interval, Region, goal_of
from verify.exact import read_number
from verify.semantics import MACHINE

FORM = "maviper-episode-certificate-1"
PUSHED = "maviper-episode-certificate-3"
Side = tuple[str, bool, str | None]  # of an edge: coordinate; whether it is the upper one; goal
READINGS = {FORM: EpisodeReading, "maviper-episode-certificate-2": PartedReading, PUSHED: ContactReading}


@dataclass(frozen=True)
class EpisodeCertificate:
    """A claim about the episodes of a profile from a region, with a proof for each of its parts."""

    profile: str  # content hash
    claim: EpisodeClaim
    region: Region
    inhabitant: Mapping[str, Fraction]  # a start of the region, which shows that it is not empty
    parts: tuple[ProofPart, ...]
    semantics: str = MACHINE
    region_said: str = field(default="", compare=False)  # what a file that was read calls its region; says nothing
    form: str = FORM  # by which the proofs are to be read

    edges: ClassVar[Mapping[str, Interval]] = {}  # which claims for ever have (forever.py)
    proofs: ClassVar[Mapping[Side, bytes]] = {}

    @property
    def size(self) -> int:
        """Bytes of all proofs."""
        return sum(len(part.proof) for part in self.parts)

    @property
    def followed(self) -> tuple[tuple[str, ...], ...]:
        """The agents that are followed together in each part."""
        return tuple(part.followed for part in self.parts)

    def reading(self, reader: Callable[[bytes], bytes]) -> "EpisodeCertificate":
        """The same with its proofs given to a reader."""
        return replace(self, parts=tuple(replace(part, proof=reader(part.proof)) for part in self.parts))

    def check(self, profile: PolicyProfile) -> int:
        """Checks the certificate; see `check_certificate`."""
        return check_certificate(self, profile)


def check_certificate(certificate: EpisodeCertificate, profile: PolicyProfile) -> int:
    """Checks a certificate; the number of branches that its proofs close.

    InputError when it is about another policy or names what the profile does not have; RejectedError when a proof is
    missing or does not hold.
    """
    region, claim = certificate.region, certificate.claim
    ensure_about(certificate.profile, content_hash(profile), "profile", "--profile")
    ensure_started(profile, claim, region, certificate.inhabitant, certificate.semantics)
    if claim.by_edges:
        raise RejectedError(f"{claim.name} for ever has proofs of another form")
    if coincident(profile.world, certificate.inhabitant):
        raise RejectedError("at its inhabitant two that push each other stand in one place, where claims say nothing")
    agents, marks = {each.agent for each in profile.agents}, {mark.name for mark in profile.world.landmarks}
    marks |= agents if certificate.claim.apart else set()
    for part in certificate.parts:
        if not {part.agent} <= agents | {""} or not {*part.followed} <= agents or not part.followed:
            raise RejectedError("a part is about agents that the profile does not have")
        if (
            not {part.landmark} <= marks | {""}
            or part.goal not in (None, *region.goals)
            or (bool(part.agent) != bool(part.landmark))
        ):
            whom = "others" if certificate.claim.apart else "landmarks"
            raise RejectedError(f"a part is about {whom} that the profile does not have")
    proofs = [(part, numbers(part.proof)) for part in certificate.parts]
    return episodes.check(profile, certificate.claim, region, proofs, READINGS[certificate.form])


def ensure_started(
    profile: PolicyProfile, claim: EpisodeClaim, region: Region, start: Mapping[str, Fraction], semantics: str
) -> None:
    """InputError for a region that names what the profile does not have, RejectedError unless it holds the start."""
    ensure_known_names(
        Certificate(content_hash(profile), None, TRUE, region, semantics, start, {}), profile, claim.team
    )
    if any(value and name.endswith((".vx", ".vy")) for name, value in start.items()) or any(
        abs(value) > FARTHEST or Fraction(float(value)) != value for value in start.values()
    ):
        raise RejectedError("its inhabitant is not a start that proofs cover: float64 positions, at rest")
    if semantics != MACHINE:
        raise RejectedError(f"proofs about episodes are for {MACHINE} arithmetic")
    if not holds(region_formula(region), start, {}):
        raise RejectedError("its inhabitant is not a start in the region, so the claim may be vacuous")


class EpisodePartJson(msgspec.Struct, forbid_unknown_fields=True):
    """A part of the claim and its proof."""

    agent: str
    landmark: str
    goal: str
    followed: list[str]
    proof: list[str]


class EpisodeCertificateJson(msgspec.Struct, forbid_unknown_fields=True):
    """The members of the file; numbers are exact texts."""

    certificate: str
    profile: str
    property: str
    team: str
    steps: int
    radius: str
    semantics: str
    region: dict[str, Any]
    inhabitant: dict[str, str]
    parts: list[EpisodePartJson]
    content_hash: str
    landmarks: list[str] | msgspec.UnsetType = msgspec.UNSET  # of claims that an agent arrives
    others: list[str] | msgspec.UnsetType = msgspec.UNSET  # of claims that it keeps apart


def from_json(text: str | bytes, where: str = "certificate") -> EpisodeCertificate:
    """The certificate in a text. InputError when it is damaged, of another version, or edited; RejectedError for claims
    that have no certificates.
    """
    with ensure_readable(where):
        raw = msgspec.json.decode(text, type=EpisodeCertificateJson)
        ensure_whole(raw, raw.certificate if raw.certificate in READINGS else FORM, where)
        parts = [
            ProofPart(
                part.agent,
                part.landmark,
                goal_of(part.goal),
                tuple(part.followed),
                read_proof(part.proof, f"$.parts[{place}]"),
            )
            for place, part in enumerate(raw.parts)
        ]
        return EpisodeCertificate(
            profile=raw.profile,
            claim=_claim(raw),
            region=region_from(raw.region),
            inhabitant={name: read_number(value) for name, value in raw.inhabitant.items()},
            parts=tuple(parts),
            semantics=raw.semantics,
            region_said=str(raw.region["name"]),
            form=raw.certificate,
        )


def _claim(raw: EpisodeCertificateJson) -> EpisodeClaim:
    kind = certifiable(raw.property)
    stated = {name: names for name in ("landmarks", "others") if (names := getattr(raw, name)) is not msgspec.UNSET}
    if stated.keys() != {kind.whom}:
        raise ValueError(f"$.{kind.whom}: {kind.title} states these, and no other names")
    named: dict[str, Any] = {kind.whom: tuple(stated[kind.whom])}
    return kind(raw.team, raw.steps, read_number(raw.radius), **named)
