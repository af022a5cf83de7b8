"""What several tests use of `verify.episodes.test_certificates`."""

import numpy as np

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
