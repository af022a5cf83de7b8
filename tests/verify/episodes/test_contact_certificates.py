"""Certificates of episodes with contacts and of keeps_apart: made for what zones prove; forged ones are refused."""

from dataclasses import replace
from fractions import Fraction

import pytest

from codegen.errors import InputError
from tests.support import contact_readings as faults
from tests.support.altered import altered, read_game
from tests.support.contacts import HALF, HOMING, LANES, SPREAD, TAG, around, going
from tests.support.episode_certificates import certified, failures, share_of_bytes_refused
from tests.support.episode_mutations import judge_mutations
from tests.support.teams import LEFT, RIGHT, STAY
from verify.certificates.games import to_json
from verify.checker.certificate import numbers
from verify.checker.episodes import certificates as episodes
from verify.checker.episodes.certificates import PUSHED, ProofPart, check_certificate
from verify.checker.episodes.contacts import ContactReading
from verify.checker.episodes.reading import OpenBranchError
from verify.checker.reading import RejectedError
from verify.claims.catalogue import find_claim
from verify.claims.region import Region
from verify.episodes.certificates import EpisodeProver, TooLongError
from verify.question import Question
from verify.result import Verdict
from verify.subjects import Game
from verify.verdicts.episodes import verify_episodes

pytestmark = pytest.mark.solver

CHASE = f"{TAG},predators=1,prey=1,obstacles=1"
PAIR = f"{SPREAD},agents=2"
FACING = [(-0.5, 0), (0.5, 0), (0.4, 0), (-0.4, 0)]


@pytest.fixture(scope="module")
def cases():
    """Claims that hold, some of them just so: (profile, certificate)."""
    found = []
    homing = around(HOMING, HALF, LANES)
    for claim in (find_claim("reaches", HOMING, steps=11), find_claim("keeps_apart", HOMING, radius=Fraction(2, 5))):
        found.append((HOMING, certified(HOMING, claim, homing)))
    meeting = going(RIGHT, LEFT, name=PAIR)
    near = around(meeting, Fraction(1, 100), FACING)
    for claim in (
        find_claim("keeps_apart", meeting, steps=8, radius=Fraction(1, 20)),
        find_claim("reaches", meeting, steps=7, radius=Fraction(7, 20)),
    ):
        found.append((meeting, certified(meeting, claim, near)))
    fleeing = going(RIGHT, RIGHT, name=CHASE)
    chase = around(fleeing, Fraction(1, 20), [(-0.5, 0), (0.0, 0), (-0.5, -0.9)])
    claim = find_claim("keeps_apart", fleeing, "prey", others=["adversary_0"], steps=10, radius=Fraction(3, 8))
    found.append((fleeing, certified(fleeing, claim, chase)))
    return found


def test_what_is_proved_has_a_certificate(cases):
    """Reaching, keeping apart, and prey: each comes back from its text and is accepted."""
    for profile, certificate in cases:
        text = to_json(certificate)
        assert certificate.header.certificate == PUSHED
        assert read_game(text) == certificate and to_json(read_game(text)) == text
        assert check_certificate(certificate, profile) > 0
        assert failures(profile, certificate.claim, certificate.header.region, 2_000, seed=3) == 0
    names = [certificate.claim.name for _, certificate in cases]
    assert names == ["reaches", "keeps_apart", "keeps_apart", "reaches", "keeps_apart"]


def test_a_verdict_shows_its_certificate(cases):
    profile, certificate = cases[2]
    result = verify_episodes(Question(Game(profile), certificate.claim, certificate.header.region), {})
    assert result.evidence.certificate == certificate
    assert result.evidence.branches == check_certificate(certificate, profile)
    assert not result.evidence.uncertified and "over-approximated" in result.evidence.contacts


def test_opponents_as_in_the_profile_are_followed_in_the_proof_and_told(few_states):
    """The predator goes away; another one could come."""
    profile = going(LEFT, STAY, name=CHASE)
    region = around(profile, Fraction(1, 20), [(-0.5, 0), (0.5, 0), (0, -0.9)])
    claim = find_claim("keeps_apart", profile, "prey", others=["adversary_0"])
    result = verify_episodes(Question(Game(profile), claim, region), {})
    assert result.verdict is Verdict.PROVED and "opponents as in" in result.evidence.opponents_words
    assert result.evidence.opponents and ("adversary_0", "agent_0") in result.evidence.followed
    certificate = result.evidence.certificate
    assert [part.followed for part in certificate.proof.parts] == [("adversary_0", "agent_0")]
    alone = altered(certificate.proof.parts[0], followed=("agent_0",))
    with pytest.raises(RejectedError):
        check_certificate(altered(certificate, parts=(alone,)), profile)


# --- mutations


def test_no_mutation_makes_a_false_claim_accepted(cases):
    """150 mutations with hashes made to fit: what is accepted holds from all sampled starts."""
    found = list(judge_mutations(cases, seed=11, count=150, starts=100))
    assert sum(each.false for each in found) > 20
    assert sum(each.stood for each in found) > 10 and sum(not each.stood for each in found) > 75


def test_each_changed_byte_of_a_proof_is_refused_or_as_good(cases):
    assert share_of_bytes_refused(cases[2][1], cases[2][0]) > 0.7


# --- provers with faults


class Narrow(ContactReading):
    """Takes the gaps of starts for narrower than the region says."""

    def __init__(self, *given):
        super().__init__(*given)
        gaps = tuple(tuple(((low + high) // 2,) * 2 for low, high in gap) for gap in self.start.gaps)
        self.start = self.start._replace(gaps=gaps)


class Blind(ContactReading):
    """Knows no contacts."""

    def _forces(self, now, pairs):
        return {}


class Careless(ContactReading):
    """Follows only one of the two parts of a cut."""

    def cut(self, gap, number):
        return super().cut(gap, number)[:1]


class Generous(ContactReading):
    """Takes those who are too near for apart enough."""

    def onward(self, stage, answer, chosen, now):
        return super().onward(stage, 1 if stage == -1 else answer, chosen, now)


def asked():
    """(profile, claim, region, followed): claims that mostly do not hold."""
    meeting = going(RIGHT, LEFT, name=PAIR)
    for half in (Fraction(1, 100), Fraction(1, 25)):
        near = around(meeting, half, FACING)
        for number in range(2, 10):
            claim = find_claim("keeps_apart", meeting, steps=8, radius=Fraction(number, 20))
            yield meeting, claim, near, ("agent_0", "agent_1")
            claim = find_claim("reaches", meeting, steps=12, radius=Fraction(number, 20))
            yield meeting, claim, near, ("agent_0", "agent_1")
    lazy = going(RIGHT, STAY, name=CHASE)
    for number in range(1, 9):
        chase = around(lazy, Fraction(1, 50), [(-Fraction(number, 10), 0), (0, 0), (-0.5, -0.9)])
        yield lazy, find_claim("keeps_apart", lazy, "prey", others=["adversary_0"], steps=10), chase, ("agent_0",)


def forged(kind, profile, claim, region, followed):
    """What a search by some reading gives; None where it gives nothing."""
    pair = ("agent_0", claim.named[0]) if claim.named else ("agent_0", "agent_1")
    try:
        proof = EpisodeProver(kind(profile, claim, region, None, followed, [(pair,)]), 20_000).run()
    except (OpenBranchError, TooLongError):
        return None
    return ProofPart(*pair, "", followed, proof)


@pytest.mark.parametrize(
    "kind", [faults.Weak, faults.Pulling, faults.Late, faults.Rigid, faults.Tame, Narrow, Blind, Careless, Generous]
)
def test_faults_of_the_search_are_refused(kind):
    """Each fault proves something that does not follow, and none of it is accepted."""
    caught = 0
    for profile, claim, region, followed in asked():
        part = forged(kind, profile, claim, region, followed)
        if part is None or forged(ContactReading, profile, claim, region, followed) is not None:
            continue
        caught += 1
        own = [((part.agent, part.landmark),)]
        reading = ContactReading(profile, claim, region, None, followed, own)
        with pytest.raises(RejectedError):
            episodes.close(reading, numbers(part.proof))
    assert caught > 0


def test_what_a_certificate_must_say(cases):
    profile, certificate = cases[2]

    def refused(said, **changes):
        with pytest.raises((RejectedError, InputError), match=said):
            check_certificate(altered(certificate, **changes), profile)

    claim, part = certificate.claim, certificate.proof.parts[0]
    assert (part.agent, part.landmark) == ("agent_0", "agent_1")
    refused("do not make up the claim", parts=())
    refused("others that", parts=(altered(part, landmark="agent_7"),))
    refused("says nothing", claim=replace(claim, radius=Fraction(0)))
    refused("radius", claim=replace(claim, radius=Fraction(-1)))
    refused("unknown entity", claim=replace(claim, others=("agent_7",)))
    refused("another form", certificate="maviper-episode-certificate-2")
    zero, box = Fraction(0), certificate.header.region.box
    wide = {name: (min(low, zero), max(high, zero)) for name, (low, high) in box.items()}
    refused("stand in one place", inhabitant=dict.fromkeys(box, zero), region=Region(wide, ()))
    text = to_json(certificate)
    assert '"others": []' in text and '"landmarks"' not in text.replace('"landmark"', "")
