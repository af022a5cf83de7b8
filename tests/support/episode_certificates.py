"""What several tests of episodes use: samples that fail a claim, certificates, replays."""

from contextlib import contextmanager

import numpy as np

from codegen.agreement.compiled import build
from codegen.errors import InputError
from codegen.policy_json import content_hash
from maviper.verification.bench import rollouts
from maviper.worlds.matching import matching_world
from tests.support.altered import altered, read_game
from verify.certificates.games import to_json
from verify.checker.episodes.certificates import check_certificate
from verify.checker.reading import RejectedError
from verify.episodes.certificates import build_certificate
from verify.episodes.composition import decide
from verify.question import Question
from verify.result import Verdict
from verify.states.episodes import at_rest, meets_claim, play
from verify.states.state import sample
from verify.subjects import Game


def failures(profile, claim, region, count, seed=0, lattice=None):
    """How many sampled starts of a region fail the claim."""
    coordinates, _ = sample(at_rest(region), profile.world, count, seed)
    if lattice:
        coordinates = np.round(coordinates / lattice) * lattice
    return int((~meets_claim(profile, claim, play(profile, coordinates, claim.steps)[0])).sum())


def certified(profile, claim, region):
    found = decide(Question(Game(profile), claim, region))
    assert found.verdict is Verdict.PROVED, found
    return build_certificate(Question(Game(profile), claim, region), found.parts)


def stands(certificate, profile):
    """Whether a certificate of any content, its hashes made to fit, is accepted."""
    certificate = altered(certificate, profile=content_hash(profile))
    try:
        return check_certificate(read_game(to_json(certificate)), profile) >= 0
    except (RejectedError, InputError):
        return False


def share_of_bytes_refused(certificate, profile):
    """Of the bytes of the first part's proof: those that cannot be another. A proof that is too short or too long never
    stands. What is proved says nothing but how branches are closed; that it can be refused shows that it is read.
    """
    part, *others = certificate.proof.parts

    def is_as_good(proof):
        return stands(altered(certificate, parts=(altered(part, proof=proof), *others)), profile)

    assert not any(map(is_as_good, (part.proof[:-1], part.proof + b"\0", b"", part.proof + part.proof)))
    size = len(part.proof)
    flipped = (bytes(byte ^ (at == place) for at, byte in enumerate(part.proof)) for place in range(size))
    return sum(not is_as_good(proof) for proof in flipped) / size


@contextmanager
def replays_of(profile):
    with build(profile, ["c"]) as made:
        yield rollouts(made, matching_world(profile))
