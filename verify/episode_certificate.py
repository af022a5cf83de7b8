"""Certificates of claims about whole episodes: the document, and the form of their proofs.

Does: makes a certificate of a proved claim; its JSON text; whether one fits a profile and passes the checker.
Assumes: a profile that was read and checked; parts of a claim that were proved by zones.
Does not: cover worlds with contacts, or what only holds when others act as in the profile.

The claim holds when for each goal either the team is matched, or each agent arrives at its own landmark of a matching.
Each such *part* has a proof, for one goal or for all: a sequence of natural numbers (each in groups of seven bits, low
ones first) that says why no start at rest fails when the followed agents act by their trees and all others as they
like. The search is fixed, but for the answers that are said to be the only ones (episode_reading.py, the checker):

Questions. A question has two sides or more, each an inequality `upper - lower <= most` between coordinates, or none,
and below it another question or an end. The region's bounds come first, one after the other, each a question with one
side; a pair apart has four. Then, at step 0, 1, ..., the claim is asked (`reaches`), or at the last step only
(`covers`): for each agent and landmark, is it beyond one of the four lines at the radius (x above, x below, y above, y
below), or else within it? The ends are AWAY (0) and ARRIVED (1). ARRIVED is closed; AWAY is open at the last step. Then
each followed agent's tree is asked, left side before right; the ends are actions. Then all move, by the machine's own
operations. Nothing is asked of the trees at step 1 when no tree reads a velocity, nor at the step before the last one.

Shifts. Inequalities are about starts: `most` is moved by how far the coordinates have come since. Those of trees have
the exact ends of thresholds.py while none of their coordinates has moved; after that they have 2^-30 more. An agent is
beyond a line, once something has moved, from 2^-30 before the line on, and within it up to there. A side of a tree that
speaks of an agent that is not followed, or of the goal where the proof is for all goals, says nothing of the start.

At each side the inequality is added to the branch, and one number is read; one also at each first question (of the
region, the claim or a tree that is no end at once), where nothing is added. With A answers (the most of any question):

    0         the search goes on below.
    1 .. A    all starts of the branch come to the answer 1 less. The sides that do not end in it are walked, with
              numbers as here but none of this kind, and all that ends elsewhere is closed. Then the search goes on from
              the whole branch as it was, with that answer. Of AWAY no walk is needed.
    A + 1 + m the branch is closed: no start is in it. The next m numbers are coordinates (0 is the number 0) between
              the side's lower and its upper one. The sum around this cycle, of the least bound that the branch has
              between each two neighbours and the side's own, is negative (or zero with a strict one).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

import msgspec
import numpy as np

from codegen.errors import InputError
from codegen.ir import PolicyProfile
from codegen.policy_json import content_hash, layout
from verify import episode_checker
from verify.batch import point_in, starts
from verify.bounds import RejectedError, region_formula
from verify.certificate import (
    Certificate,
    body_hash,
    ensure_whole,
    known_names,
    numbers,
    proof_lines,
    read_proof,
    region_from,
    undamaged,
)
from verify.episode_proof import MOST_ANSWERS, Prover, TooLongError
from verify.episode_reading import FARTHEST, Episode, Matching, Part, matchings
from verify.episodes import DEFAULT_ZONES, ClosedLoop
from verify.formula import TRUE, holds
from verify.formula_json import read_number
from verify.spec import MACHINE, Region

FORM = "maviper-episode-certificate-1"


@dataclass(frozen=True)
class EpisodeCertificate:
    """A claim about the episodes of a profile from a region, with a proof for each of its parts."""

    profile: str  # content hash
    claim: ClosedLoop
    region: Region
    inhabitant: Mapping[str, Fraction]  # a start of the region, which shows that it is not empty
    parts: tuple[Part, ...]
    semantics: str = MACHINE

    @property
    def size(self) -> int:
        """Bytes of all proofs."""
        return sum(len(part.proof) for part in self.parts)


class NoCertificateError(Exception):
    """Why a proved claim has no certificate."""


def made(
    profile: PolicyProfile, claim: ClosedLoop, region: Region, proved: Sequence[Part], most: int | None = None
) -> EpisodeCertificate:
    """The certificate of a claim whose parts were proved (with or without a proof in them).

    NoCertificateError when the second search leaves a start open, or looks at more than `most` answers: by
    default as many more than MOST_ANSWERS as the claim may visit more zones than by default.
    """
    most = max(MOST_ANSWERS, MOST_ANSWERS * claim.zones // DEFAULT_ZONES) if most is None else most
    limit, start = most, _inhabitant(profile, region)
    parts: list[Part] = []
    try:
        for part in _needed(profile, claim, region, proved):
            own = _own(part, matchings(profile, claim))
            prover = Prover(Episode(profile, claim, region, part.goal, part.followed, own), limit)
            parts.append(replace(part, proof=prover.run()))
            limit -= prover.looked
    except TooLongError:
        what = f"its proof takes more than {most:,} answers; a larger --zones allows more of them"
        raise NoCertificateError(what) from None
    except RejectedError as error:
        raise NoCertificateError(str(error)) from None
    return EpisodeCertificate(content_hash(profile), claim, region, start, tuple(parts))


def _own(part: Part, allowed: list[Matching]) -> list[Matching]:
    return [((part.agent, part.landmark),)] if part.agent else allowed


def _needed(profile: PolicyProfile, claim: ClosedLoop, region: Region, proved: Sequence[Part]) -> list[Part]:
    """The parts that show the claim for all goals, each once."""
    found: dict[Part, None] = {}
    for goal in region.goals or ("",):
        about = [part for part in proved if part.goal in ("", goal)]
        by_pair = {(part.agent, part.landmark): part for part in about}
        ways = [own for own in matchings(profile, claim) if by_pair.keys() >= set(own)]
        pairs = ways[0] if ways else (("", ""),)
        for pair in pairs:
            if pair not in by_pair:
                raise NoCertificateError("not all parts of the claim were proved one by one")
            found[by_pair[pair]] = None
    return list(found)


def _inhabitant(profile: PolicyProfile, region: Region) -> Mapping[str, Fraction]:
    """A float64 start of the region, at rest."""
    still = {name: Fraction(0) for name in region.box}
    for start in starts(region, profile.world):
        middle = point_in(start, (), np.zeros((2, 1, 1), dtype=np.int64), np.full((2, len(start.names)), 0.5))
        point = still | {name: Fraction(value) for name, value in (middle or {}).items()}
        if middle is not None and holds(region_formula(region), point, {}):
            return {name: point[name] for name in region.box}
    raise NoCertificateError("no float64 start of the region was found")


def accepted(certificate: EpisodeCertificate, profile: PolicyProfile) -> int:
    """Checks a certificate; the number of branches that its proofs close.

    InputError when it is about another policy or names what the profile does not have; RejectedError when a proof is
    missing or does not hold.
    """
    found, region = content_hash(profile), certificate.region
    if found != certificate.profile:
        raise InputError(
            "the certificate is about another policy",
            f"it names {certificate.profile[:16]}..., the profile is {found[:16]}...",
            "give the profile that it was made for with --profile",
        )
    start = certificate.inhabitant
    known_names(Certificate(found, None, TRUE, region, certificate.semantics, start, {}), profile)
    if any(value and name.endswith((".vx", ".vy")) for name, value in start.items()) or any(
        abs(value) > FARTHEST or Fraction(float(value)) != value for value in start.values()
    ):
        raise RejectedError("its inhabitant is no start: float64 positions that proofs cover, at rest")
    if certificate.semantics != MACHINE:
        raise RejectedError(f"proofs about episodes are for {MACHINE} arithmetic")
    if not holds(region_formula(region), start, {}):
        raise RejectedError("its inhabitant is no start of the region: the claim may be about nothing")
    agents, landmarks = ({entity.name for entity in group} for group in (profile.world.agents, profile.world.landmarks))
    for part in certificate.parts:
        if not {part.agent} <= agents | {""} or not {*part.followed} <= agents or not part.followed:
            raise RejectedError("a part is about agents that the profile does not have")
        if (
            not {part.landmark} <= landmarks | {""}
            or part.goal not in ("", *region.goals)
            or (bool(part.agent) != bool(part.landmark))
        ):
            raise RejectedError("a part is about landmarks that the profile does not have")
    proofs = [(part, numbers(part.proof)) for part in certificate.parts]
    return episode_checker.check(profile, certificate.claim, region, proofs)


# --- the text


class PartJson(msgspec.Struct, forbid_unknown_fields=True):
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
    landmarks: list[str]
    semantics: str
    region: dict[str, Any]
    inhabitant: dict[str, str]
    parts: list[PartJson]
    content_hash: str


def to_json(certificate: EpisodeCertificate) -> str:
    """The text of a certificate; equal certificates give equal bytes."""
    claim = certificate.claim
    body = {
        "certificate": FORM,
        "profile": certificate.profile,
        "property": claim.name,
        "team": claim.team,
        "steps": claim.steps,
        "radius": str(claim.radius),
        "landmarks": list(claim.landmarks),
        "semantics": certificate.semantics,
        "region": {"name": certificate.region.name, **certificate.region.document()},
        "inhabitant": {name: str(value) for name, value in certificate.inhabitant.items()},
        "parts": [
            {
                "agent": part.agent,
                "landmark": part.landmark,
                "goal": part.goal,
                "followed": list(part.followed),
                "proof": proof_lines(part.proof),
            }
            for part in certificate.parts
        ],
    }
    return layout(body | {"content_hash": body_hash(body)}) + "\n"


def from_json(text: str | bytes, where: str = "certificate") -> EpisodeCertificate:
    """The certificate in a text. InputError when it is damaged, of another version, or edited."""
    with undamaged(where):
        raw = msgspec.json.decode(text, type=EpisodeCertificateJson)
        ensure_whole(raw, FORM, where)
        parts = [
            Part(
                part.agent, part.landmark, part.goal, tuple(part.followed), read_proof(part.proof, f"$.parts[{place}]")
            )
            for place, part in enumerate(raw.parts)
        ]
        return EpisodeCertificate(
            profile=raw.profile,
            claim=ClosedLoop(raw.property, raw.team, raw.steps, read_number(raw.radius), tuple(raw.landmarks)),
            region=region_from(raw.region),
            inhabitant={name: read_number(value) for name, value in raw.inhabitant.items()},
            parts=tuple(parts),
            semantics=raw.semantics,
        )
