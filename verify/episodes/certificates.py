"""Making certificates of claims about whole episodes.

Does: makes the certificate of a claim whose parts zones proved, in the first form that closes all branches.
Assumes: a profile that was read and checked; parts of a claim that were proved by zones.
Does not: state the form of proofs (checker/README.md does).
"""

from collections.abc import Mapping, Sequence
from contextlib import suppress
from fractions import Fraction

import msgspec

from codegen.ir import PolicyProfile
from codegen.policy_json import content_hash
from verify.checker.certificate import Certificate
from verify.checker.decisions import GameHeader
from verify.checker.episodes.certificates import PUSHED, READINGS, EpisodeCertificate, Parts, ProofPart
from verify.checker.episodes.contacts import ContactReading, coincident
from verify.checker.episodes.reading import EpisodeReading, Matching, OpenBranchError, matchings
from verify.checker.episodes.unbounded import Edges
from verify.checker.reading import RejectedError, region_formula
from verify.claims.episodes import EpisodeClaim
from verify.claims.formula import holds
from verify.claims.region import Region, goal_of
from verify.episodes.proof import MAX_ANSWERS, EpisodeProver, TooLongError
from verify.episodes.zones import points_of, starts
from verify.question import Budgets, EpisodeQuestion
from verify.states.shares import SAMPLE_SEED
from verify.unanswered import BeyondError


class NoCertificateError(BeyondError):
    """Why a proved claim has no certificate: it is beyond the second reading, or its proof is too large."""


class LeftOpenError(NoCertificateError):
    """The second reading leaves a start open, so the claim is not proved."""


def build_certificate(
    question: EpisodeQuestion, proved: Sequence[ProofPart], most: int | None = None
) -> EpisodeCertificate:
    """The certificate of a claim whose parts were proved (with or without a proof in them).

    LeftOpenError when the second search leaves a start open in some part, NoCertificateError when it looks at more than
    `most` answers: by default as many more than MAX_ANSWERS as more zones may be visited than by default.
    """
    profile, claim, region = question.profile, question.claim, question.region
    allowed = MAX_ANSWERS * question.budgets.max_zones // Budgets().max_zones
    most = max(MAX_ANSWERS, allowed) if most is None else most
    start, opened = inhabitant(profile, region), ""
    for form in _list_forms(profile, claim):
        try:
            parts = _prove_parts(READINGS[form], question, proved, most)
            return certify(question, form, start, Parts(parts))
        except OpenBranchError as error:
            opened = str(error)
        except RejectedError as error:
            raise NoCertificateError(str(error)) from None
    raise LeftOpenError(opened)


def certify(
    question: EpisodeQuestion, form: str, start: Mapping[str, Fraction], proof: Parts | Edges
) -> EpisodeCertificate:
    """The certificate of a claim with a proof. `start`: one of the region."""
    header = GameHeader(form, content_hash(question.profile), start, question.semantics, question.region)
    return Certificate(header, question.claim, proof)


def _prove_parts(
    reading: type[EpisodeReading],
    question: EpisodeQuestion,
    proved: Sequence[ProofPart],
    most: int,
) -> tuple[ProofPart, ...]:
    """The parts that are needed, with their proofs. OpenBranchError, or NoCertificateError where they are too large."""
    parts: list[ProofPart] = []
    profile, claim, region = question.profile, question.claim, question.region
    needed, left = _select_parts(question, proved), most
    for part in needed:
        own = _own(part, matchings(profile, claim))
        # a part that is too large keeps no other one from being searched: that may hold an open branch
        limit = max(left, most // len(needed))
        proof, looked = _search_proof(reading(profile, claim, region, goal_of(part.goal), part.followed, own), limit)
        parts += [msgspec.structs.replace(part, proof=proof)] if proof is not None else []
        left -= looked
    if len(parts) < len(needed):
        raise NoCertificateError(f"its proof takes more than {most:,} answers; a larger --max-zones allows more")
    return tuple(parts)


def _search_proof(episode: EpisodeReading, limit: int) -> tuple[bytes | None, int]:
    """A proof, None where it is too large, and how many answers were looked at. OpenBranchError.

    Where agents push each other, starts are told apart by how they touch only if it does not close otherwise.
    """
    if isinstance(episode, ContactReading):
        coarse = EpisodeProver(episode, limit, finely=False)
        with suppress(OpenBranchError, TooLongError):
            return coarse.run(), coarse.looked
    prover = EpisodeProver(episode, limit)
    with suppress(TooLongError):
        return prover.run(), prover.looked
    return None, prover.looked


def _own(part: ProofPart, allowed: list[Matching]) -> list[Matching]:
    return [((part.agent, part.landmark),)] if part.agent else allowed


def _select_parts(question: EpisodeQuestion, proved: Sequence[ProofPart]) -> list[ProofPart]:
    """The parts that show the claim for all goals, each once."""
    needed: dict[ProofPart, None] = {}
    allowed = matchings(question.profile, question.claim)
    for goal in question.goals:
        about = [part for part in proved if part.goal in ("", goal)]
        by_pair = {(part.agent, part.landmark): part for part in about}
        ways = [own for own in allowed if by_pair.keys() >= set(own)]
        pairs = ways[0] if ways else (("", ""),)
        for pair in pairs:
            if pair not in by_pair:
                raise LeftOpenError("not all parts of the claim were proved one by one")
            needed[by_pair[pair]] = None
    return list(needed)


def inhabitant(profile: PolicyProfile, region: Region) -> Mapping[str, Fraction]:
    """A float64 start of the region, at rest, that claims are about."""
    still = {name: Fraction(0) for name in region.box}
    for point in points_of(starts(region, profile.world), SAMPLE_SEED):
        state = still | {name: Fraction(value) for name, value in point.items()}
        if holds(region_formula(region), state, {}) and not coincident(profile.world, state):
            return {name: state[name] for name in region.box}
    raise NoCertificateError("no float64 start of the region was found")


# --- the text


def _list_forms(profile: PolicyProfile, claim: EpisodeClaim) -> list[str]:
    """The forms that a certificate may have, the simplest first."""
    pushed = claim.apart or any(agent.collides for agent in profile.world.agents)
    return [form for form in READINGS if (form == PUSHED) == pushed]
