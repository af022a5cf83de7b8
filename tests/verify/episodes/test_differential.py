"""Claims about episodes of agents that observe signs and other functions, whose tests turn at the same number."""

from dataclasses import replace
from fractions import Fraction

import pytest

from codegen import ir
from tests.support.altered import altered, read_game
from tests.support.teams import RIGHT, STAY, team_in, tree
from verify.certificates.games import to_json
from verify.checker.episodes.certificates import FORM, ProofPart, check_certificate
from verify.checker.reading import RejectedError
from verify.claims.catalogue import find_claim
from verify.claims.region_files import everywhere
from verify.episodes.certificates import NoCertificateError, build_certificate
from verify.episodes.composition import decide
from verify.question import Question
from verify.result import Verdict
from verify.subjects import Game

pytestmark = pytest.mark.solver

TEAM = "defenders"


def alone(grown, function, terms):
    """A defender with a tree, alone with the adversary, that observes a function of terms and nothing else."""
    profile = team_in("physical-deception,defenders=1", [tree(STAY)] * 2)
    seen = ir.FeatureSpec("f0", "none", -9.0, 9.0, ir.Meaning(tuple(terms), function))
    changed = replace(profile.policy("agent_0"), tree=grown, features=(seen,))
    return replace(profile, agents=tuple(changed if one.agent == "agent_0" else one for one in profile.agents))


ZERO, NEAR, BESIDE = (Fraction(0),) * 2, (Fraction(0), Fraction(1, 20)), (Fraction(-1, 20), Fraction(1, 20))
BETWEEN = tree((0, -0.5, 1, 2), STAY, (0, 0.5, 3, 4), RIGHT, STAY)  # goes right where the sign is 0
SIGN = ("sign", [(1, "agent_0.x"), (-1, "landmark_0.x")])


def placed(profile, **bounds):
    """A region with the given bounds of coordinates; all others are 0."""
    start = everywhere(profile)
    return replace(start, box={name: bounds.get(name.replace(".", "_"), ZERO) for name in start.box})


def answers(profile, claim, region):
    """The verdict of the zones, and whether the second reading has a certificate."""
    question = Question(Game(profile), claim, region)
    verdict, whole = decide(question).verdict, [ProofPart("", "", "", ("agent_0",), b"")]
    try:
        return verdict, bool(build_certificate(question, whole))
    except NoCertificateError:
        return verdict, False


@pytest.mark.parametrize(
    ("grown", "holds"),
    [
        (BETWEEN, False),
        (tree((0, 0.5, 1, 4), (0, -0.5, 2, 3), STAY, RIGHT, STAY), False),
        (tree((0, -1.0, 1, 2), STAY, (0, 0.0, 3, 4), RIGHT, STAY), False),
        (tree((0, -0.5, 1, 2), STAY, (0, -0.25, 3, 4), RIGHT, STAY), True),  # no sign lies between
        (tree((0, 0.5, 1, 2), STAY, (0, 0.75, 3, 4), RIGHT, STAY), True),
        (tree((0, 0.0, 1, 2), STAY, (0, 1.0, 3, 4), STAY, RIGHT), True),  # no sign is above 1
    ],
)
def test_a_sign_is_negative_zero_or_positive(grown, holds):
    """Where agent and landmark are at the same x, the tests at -0.5 and 0.5 part."""
    profile = alone(grown, *SIGN)
    claim = find_claim("covers", profile, TEAM, steps=8, radius=Fraction(3, 50))
    wanted = (Verdict.PROVED, True) if holds else (Verdict.VIOLATED, False)
    assert answers(profile, claim, placed(profile)) == wanted
    wide = placed(profile, agent_0_x=NEAR, agent_0_y=BESIDE, landmark_0_x=NEAR)
    assert answers(profile, claim, wide) == wanted
    beside = placed(profile, agent_0_x=(Fraction(1, 100), Fraction(1, 20)))
    assert answers(profile, claim, beside) == (Verdict.PROVED, True)


def test_a_sign_that_a_shipped_world_shows():
    still = tree(STAY)
    grown = tree((10, -0.5, 1, 2), STAY, (10, 0.5, 3, 4), RIGHT, STAY)
    profile = team_in("physical-deception,features=signs", [still, grown, still])
    assert profile.policy("agent_0").features[10].name == "agent_1_dx_sign"
    claim = find_claim("covers", profile, TEAM, steps=8, radius=Fraction(3, 50))
    for region in (placed(profile), placed(profile, agent_0_x=NEAR, agent_0_y=BESIDE, agent_1_x=NEAR)):
        assert decide(Question(Game(profile), claim, region)).verdict is Verdict.VIOLATED
    beside = placed(profile, agent_0_x=(Fraction(1, 100), Fraction(1, 20)))
    assert decide(Question(Game(profile), claim, beside)).verdict is Verdict.PROVED


@pytest.mark.parametrize("function", ["positive", "zero"])
def test_functions_of_two_values_turn_once(function):
    """Whatever the thresholds between 0 and 1, nothing lies between the two values."""
    grown = tree((0, 0.25, 1, 2), STAY, (0, 0.75, 3, 4), RIGHT, STAY)
    profile = alone(grown, function, SIGN[1])
    claim = find_claim("covers", profile, TEAM, steps=8, radius=Fraction(3, 50))
    wide = placed(profile, agent_0_x=NEAR, agent_0_y=BESIDE, landmark_0_x=NEAR)
    assert answers(profile, claim, wide) == (Verdict.PROVED, True)


def test_what_is_not_zero_stays_so():
    """Both readings know it in a second test; form 1 of certificates does not."""
    grown = tree((0, 0.25, 1, 2), STAY, (0, 0.75, 3, 4), RIGHT, STAY)
    profile = alone(grown, "zero", SIGN[1])
    claim = find_claim("covers", profile, TEAM, steps=6, radius=Fraction(3, 50))
    region = placed(profile, agent_0_x=NEAR, landmark_0_x=NEAR)
    question = Question(Game(profile), claim, region)
    certificate = build_certificate(question, decide(question).parts)
    assert certificate.header.certificate == "maviper-episode-certificate-2"
    assert read_game(to_json(certificate)) == certificate and check_certificate(certificate, profile) > 0
    with pytest.raises(RejectedError):
        check_certificate(altered(certificate, certificate=FORM), profile)


def test_sums_of_three_are_refused():
    """A coordinate that cancels still rounds: such a test is another one than that of what is left of it."""
    profile = alone(BETWEEN, "", [*SIGN[1], (1, "landmark_0.x")])
    claim = find_claim("keeps_apart", profile, TEAM, steps=8, others=["landmark_0"])
    found = decide(Question(Game(profile), claim, placed(profile)))
    assert found.verdict is Verdict.UNKNOWN and "not a coordinate or a difference of two" in found.reason
