"""Certificates about episodes: made for what zones prove, read back, and what their checker refuses."""

import json
from dataclasses import replace
from fractions import Fraction
from itertools import product
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from codegen.errors import InputError
from codegen.policy_json import content_hash
from maviper import load
from tests.support.altered import altered, read_game, sealed
from tests.support.episode_cases import arriving, centred, grown_pair
from tests.support.episode_certificates import certified, failures, share_of_bytes_refused
from tests.support.episode_mutations import judge_mutations
from tests.support.strategies import grown_trees, with_trees
from tests.support.teams import DOWN, LEFT, RIGHT, STAY, UP, team, towards, tree
from verify.certificates.games import to_json
from verify.checker.episodes import certificates as episodes
from verify.checker.episodes import reading as episode_reading
from verify.checker.episodes.certificates import ProofPart, check_certificate
from verify.checker.episodes.reading import CLAIM, EpisodeReading, matchings
from verify.checker.reading import RejectedError
from verify.claims.catalogue import find_claim
from verify.claims.region import Region
from verify.claims.region_files import everywhere, start_region
from verify.episodes.certificates import EpisodeProver, LeftOpenError, NoCertificateError, build_certificate
from verify.episodes.composition import ZonesDecision, decide
from verify.question import Budgets, Question
from verify.result import Verdict
from verify.states.episodes import at_rest, play
from verify.states.state import sample
from verify.subjects import Game
from verify.verdicts.episodes import verify_episodes

pytestmark = pytest.mark.solver

AXES = "xy"
BOTH = ("agent_0", "agent_1")
ENTITIES = (*BOTH, "landmark_0", "landmark_1")


def random_middles(seed, most=0.5):
    rng = np.random.default_rng(seed)
    return {name: tuple(round(float(v), 2) for v in rng.uniform(-most, most, 2)) for name in ENTITIES}


@pytest.fixture(scope="module")
def arrivers(profile):
    return team(profile, arriving(0), arriving(1))


@pytest.fixture(scope="module")
def proved(arrivers):
    """A claim about the whole start region and its certificate."""
    return certified(arrivers, find_claim("reaches", arrivers), everywhere(arrivers))


# --- the checker


def possible(episode, node, start, now):
    """The ends of a question that a start may come to, as its answers say."""
    if isinstance(node, int):
        return {node}
    found = set()
    for side in node:
        upper, lower, most = episode.bound(side, now)
        if (start[upper] - start[lower]) * unit(episode) <= most + 1:  # strict bounds are one less
            found |= possible(episode, side.child, start, now)
    return found


def unit(episode):
    return episode.unit * episode_reading.GRID


@settings(max_examples=25)
@given(grown_trees(max_depth=3), grown_trees(max_depth=3), st.integers(0, 9), st.booleans(), st.booleans())
def test_what_the_machine_does_is_always_among_the_answers(profile, first, second, steps, ties, alone):
    """Each choice of played episodes, and whether an agent is near, for starts of which thresholds may tie."""
    random = grown_pair(profile, first, second, ties)
    claim = find_claim("reaches", random, steps=steps)
    coordinates, goals = sample(at_rest(everywhere(random)), random.world, 20, steps)
    coordinates = np.round(coordinates * 8) / 8 if ties else coordinates
    names = random.world.coordinates()
    for axis in AXES:
        marks = np.array([names.index(f"landmark_{number}.{axis}") for number in range(2)])
        coordinates[:, names.index(f"goal.{axis}")] = coordinates[np.arange(len(coordinates)), marks[goals]]
    course, actions = play(random, coordinates, steps)
    followed = BOTH[:1] if alone else BOTH
    pair = ("agent_0", "landmark_0")
    for goal in (0, 1):
        episode = EpisodeReading(random, claim, everywhere(random), f"landmark_{goal}", followed, [(pair,)])
        for row in np.flatnonzero(goals == goal):
            exact = [Fraction(float(coordinates[row, names.index(name)])) for name in episode.names[1 : episode.nodes]]
            start, now = [Fraction(0), *exact], episode.start
            for step in range(steps + 1):
                ends = [
                    [Fraction(float(course[step, row, names.index(f"{one}.{axis}")])) for one in pair] for axis in AXES
                ]
                near = all(abs(a - b) <= claim.radius for a, b in ends)
                assert near or episode_reading.AWAY in possible(episode, episode.claim, start, now)
                if step == steps:
                    break
                chosen = tuple(int(actions[step, row, random.world.agents.index(_agent(random, a))]) for a in followed)
                for asked, action in zip(episode.trees, chosen, strict=True):
                    assert action in possible(episode, asked, start, now)
                now = episode._later(now, chosen)


def _agent(profile, name):
    return next(entity for entity in profile.world.agents if entity.name == name)


@settings(max_examples=25)
@given(
    grown_trees(max_depth=3), grown_trees(max_depth=3), st.integers(0, 12), st.integers(0, 3), st.sampled_from([3, 30])
)
def test_proofs_are_found_for_what_zones_prove_and_only_for_what_holds(profile, first, second, steps, seed, side):
    random = grown_pair(profile, first, second)
    region = centred(random, Fraction(1, side), random_middles(seed))
    for name in ("reaches", "covers"):
        claim = find_claim(name, random, steps=steps)
        decided = decide(Question(Game(random), claim, region, budgets=Budgets(max_zones=20_000)))
        if decided.verdict is Verdict.PROVED:
            certificate = build_certificate(Question(Game(random), claim, region), decided.parts)
            assert read_game(to_json(certificate)) == certificate
            assert check_certificate(certificate, random) > 0
        whole = [ProofPart("", "", "", BOTH, b"")]
        try:  # also without asking the zones first
            certificate = build_certificate(Question(Game(random), claim, region), whole, 20_000)
        except NoCertificateError:
            continue
        assert check_certificate(certificate, random) > 0
        assert failures(random, claim, region, 2_000, seed) == 0
        assert failures(random, claim, region, 500, seed, 0.125) == 0 or side == 30


def test_a_certificate_comes_back_and_is_accepted(arrivers, proved):
    text = to_json(proved)
    assert to_json(read_game(text)) == text
    assert read_game(text) == proved and check_certificate(proved, arrivers) > 10_000
    assert [part.followed for part in proved.proof.parts] == [("agent_0",), ("agent_1",)]
    result = verify_episodes(Question(Game(arrivers), proved.claim, everywhere(arrivers)), {})
    assert result.evidence.certificate == proved and result.evidence.branches == check_certificate(proved, arrivers)


def test_teams_that_need_a_matching_or_each_other(profile):
    """One proof of the team where no single matching fits, and one that follows both agents."""
    still = team(profile, tree(STAY), tree(STAY))
    box = {name: (Fraction(0), Fraction(0)) for name in start_region(profile.world).box}
    box |= {f"agent_{number}.x": (Fraction(side, 4),) * 2 for number, side in enumerate((-1, 1))}
    box |= {f"landmark_{number}.x": (Fraction(-3, 10), Fraction(3, 10)) for number in range(2)}
    shared = Region(box, ("landmark_0",), (), (("landmark_0", "landmark_1", Fraction(1, 2)),))
    certificate = certified(still, find_claim("covers", still), shared)
    assert [part.agent for part in certificate.proof.parts] == [""] and check_certificate(certificate, still) > 0

    pair = team(profile, tree((8, 0.25, 1, 2), RIGHT, STAY), tree(LEFT))
    places = {"agent_0": (0, 0), "agent_1": (1, 0), "landmark_0": (0.5, 0), "landmark_1": (0.5, 0)}
    region = centred(pair, Fraction(1, 100), places)
    certificate = certified(pair, find_claim("reaches", pair, steps=15, radius=Fraction(1, 5)), region)
    assert [part.followed for part in certificate.proof.parts] == [BOTH, ("agent_1",)]
    assert check_certificate(certificate, pair) > 0
    alone = altered(certificate.proof.parts[0], followed=BOTH[:1])
    with pytest.raises(RejectedError):
        check_certificate(altered(certificate, parts=(alone, certificate.proof.parts[1])), pair)


def test_goals_that_are_read_have_proofs_of_their_own(profile):
    seeker = team(profile, tree((0, 0.0, 1, 2), LEFT, RIGHT), tree(STAY))
    places = {"agent_0": (0, 0), "landmark_0": (0.8, 0), "agent_1": (0.75, 0), "landmark_1": (0.75, 0)}
    region = centred(seeker, Fraction(1, 100), places)
    claim = find_claim("reaches", seeker, steps=10)
    certificate = certified(seeker, claim, region)
    assert check_certificate(certificate, seeker) > 0
    assert {part.goal for part in certificate.proof.parts if part.agent == "agent_0"} == {"landmark_0", "landmark_1"}
    one = tuple(part for part in certificate.proof.parts if part.goal != "landmark_1")
    with pytest.raises(RejectedError, match="goal landmark_1"):
        check_certificate(altered(certificate, parts=one), seeker)
    forall = tuple(altered(part, goal="") for part in one)
    with pytest.raises(RejectedError):
        check_certificate(altered(certificate, parts=forall), seeker)


def test_the_committed_defenders_arrive_from_a_quarter_of_the_start_region():
    committed = load(Path(__file__).parents[3] / "generated" / "proved_defenders" / "profile.json")
    box = {name: (low / 4, high / 4) for name, (low, high) in everywhere(committed).box.items()}
    region = Region(box, committed.world.goals)
    certificate = certified(committed, find_claim("reaches", committed), region)
    assert check_certificate(certificate, committed) > 500 and {part.goal for part in certificate.proof.parts} == {""}


# --- mutations


def tight(profile):
    """Claims that just hold: (profile, certificate)."""
    walker = team(profile, tree((2, -0.05, 1, 2), LEFT, (2, 0.05, 3, 4), STAY, RIGHT), tree(STAY))
    places = {"agent_0": (0, 0), "landmark_0": (0.9, 0), "agent_1": (0, 0), "landmark_1": (0, 0)}
    region = centred(walker, Fraction(1, 50), places)
    reach = next(steps for steps in range(25) if _holds(walker, "reaches", steps, region))
    found = [(walker, certified(walker, find_claim("reaches", walker, steps=reach), region))]
    arrivers = team(profile, arriving(0), arriving(1))
    near = centred(arrivers, Fraction(1, 20), random_middles(2, 0.9), ("landmark_0",))
    for name in ("reaches", "covers"):
        steps = next(steps for steps in range(26) if _holds(arrivers, name, steps, near))
        found.append((arrivers, certified(arrivers, find_claim(name, arrivers, steps=steps), near)))
    return found


def _holds(profile, name, steps, region):
    return decide(Question(Game(profile), find_claim(name, profile, steps=steps), region)).verdict is Verdict.PROVED


def test_no_mutation_makes_a_false_claim_accepted(profile):
    """260 mutations: what is accepted holds in a dense sample and for the zone engine."""
    found = list(judge_mutations(tight(profile), seed=7, count=260, starts=300))
    for each in found:
        claim, region = each.certificate.claim, each.certificate.header.region
        assert not each.stood or decide(Question(Game(each.profile), claim, region)).verdict is not Verdict.VIOLATED
    assert sum(each.false for each in found) > 50 and sum(each.stood for each in found) > 5


def test_each_changed_byte_of_a_proof_is_refused_or_as_good(profile):
    walker, certificate = tight(profile)[0]
    assert share_of_bytes_refused(certificate, walker) > 0.8


# --- provers with faults


class Unrelaxed(EpisodeReading):
    """Forgets that tests have slack."""

    def bound(self, side, now):
        return super().bound(side._replace(slack=0), now)


class WrongSign(EpisodeReading):
    """Moves bounds the wrong way."""

    def bound(self, side, now):
        return super().bound(side, now._replace(shift=[-shift for shift in now.shift]))


class WrongDamping(EpisodeReading):
    """Takes the world to be one of twice the damping."""

    def __init__(self, *given):
        super().__init__(*given)
        self._kept = 0.5


class Eager(EpisodeReading):
    """Moves with the new velocity instead of the old one."""

    def _later(self, now, chosen):
        first = super()._later(now, chosen)
        second = super()._later(first, chosen)
        return first._replace(shift=[*second.shift[: self.nodes], *first.shift[self.nodes :]])


class Generous(EpisodeReading):
    """Takes whoever is within one more unit of length for arrived."""

    def onward(self, stage, answer, chosen, now):
        return None if stage == CLAIM and now.step == self.steps else super().onward(stage, answer, chosen, now)


class Still(EpisodeReading):
    """Takes what has moved for unmoved."""

    def bound(self, side, now):
        return super().bound(side, now._replace(moved=[False] * len(now.moved)))


def forged(kind, profile, claim, region):
    """What a faulty search gives for the agents alone, with the right text around it; None where it gives nothing."""
    parts = []
    for pair in matchings(profile, claim)[0]:
        followed = (pair[0],)
        try:
            proof = EpisodeProver(kind(profile, claim, region, None, followed, [(pair,)]), 50_000).run()
        except RejectedError:
            return None
        parts.append(ProofPart(*pair, "", followed, proof))
    return parts


@pytest.mark.parametrize("kind", [WrongSign, WrongDamping, Eager, Generous])
def test_faults_of_the_search_are_refused(kind, profile):
    """Each fault proves something false on some of these claims, and none of it is accepted."""
    opposite = np.array([STAY, RIGHT, LEFT, UP, DOWN])
    fleeing = [altered(one, action=np.where(one.action < 0, -1, opposite[one.action])) for one in map(arriving, (0, 1))]
    teams, caught = (team(profile, arriving(0), arriving(1)), team(profile, *fleeing)), 0
    for seed, played in product(range(6), teams):
        region = centred(played, Fraction(1, 20), random_middles(seed, 0.9), ("landmark_0",))
        for name, steps in (("reaches", 6 + 2 * seed), ("covers", 8 + 2 * seed)):
            claim = find_claim(name, played, steps=steps, landmarks=["landmark_0", "landmark_1"])
            parts = forged(kind, played, claim, region)
            if parts is None or decide(Question(Game(played), claim, region)).verdict is Verdict.PROVED:
                continue
            caught += 1
            with pytest.raises(RejectedError):
                episodes.check_parts(played, claim, region, parts)
    assert caught > 0


@pytest.mark.parametrize("kind", [Unrelaxed, Still])
def test_a_search_without_slack_is_refused(kind, profile):
    """The agent comes to rest just where the claim asks it to be, nearer than rounding is accounted for."""
    runner = team(profile, tree((2, 0.5, 1, 2), STAY, RIGHT), tree(STAY))
    places = {"agent_0": (0, 0), "landmark_0": (0.9, 0), "agent_1": (0, 0), "landmark_1": (0, 0)}
    region = centred(runner, Fraction(0), places, ("landmark_0",))
    course, _ = play(runner, sample(at_rest(region), runner.world, 1, 0)[0], 6)
    last = dict(zip(runner.world.coordinates(), map(Fraction, course[6, 0].tolist()), strict=True))
    gap = last["landmark_0.x"] - last["agent_0.x"]
    claim = find_claim("reaches", runner, steps=6, radius=gap + Fraction(1, 2**34))
    parts = forged(kind, runner, claim, region)
    assert parts is not None and forged(EpisodeReading, runner, claim, region) is None
    with pytest.raises(RejectedError):
        episodes.check_parts(runner, claim, region, parts)


# --- what is refused before a proof is read


def renamed(certificate, name):
    """The text of a certificate with another name of its claim, and the hash made again."""
    return sealed(json.loads(to_json(certificate)) | {"property": name})


def test_what_a_certificate_must_say(arrivers, proved):
    def refused(said, **changes):
        with pytest.raises((RejectedError, InputError), match=said):
            check_certificate(altered(proved, **changes), arrivers)

    claim, region, part = proved.claim, proved.header.region, proved.proof.parts[0]
    refused("the parts do not make up the claim", parts=proved.proof.parts[:1])
    refused("the parts do not make up the claim", parts=())
    refused("another profile", profile="0" * 64)
    refused("inhabitant", inhabitant={**proved.header.inhabitant, "agent_0.x": Fraction(2)})
    refused("inhabitant", inhabitant={**proved.header.inhabitant, "agent_0.x": Fraction(1, 3)})
    refused("machine arithmetic", semantics="real")
    with pytest.raises(RejectedError, match="own_target have no certificates"):
        read_game(renamed(proved, "own_target"))
    refused("the profile has no team nobody", claim=replace(claim, team="nobody"))
    refused("a landmark of its own", claim=replace(claim, landmarks=("landmark_0", "landmark_0")))
    refused("agents that", parts=(altered(part, followed=("agent_7",)), proved.proof.parts[1]))
    refused("not followed", parts=(altered(part, followed=("agent_1",)), proved.proof.parts[1]))
    refused("followed twice", parts=(altered(part, followed=("agent_0", "agent_0")), proved.proof.parts[1]))
    refused("landmarks that", parts=(altered(part, landmark=""), proved.proof.parts[1]))
    refused("landmarks that", parts=(altered(part, goal="landmark_7"), proved.proof.parts[1]))
    refused("steps must be", claim=replace(claim, steps=10**6))
    refused("rounding over", claim=replace(claim, steps=2_000))
    moving = replace(region, box={**region.box, "agent_0.vx": (Fraction(1, 4), Fraction(1))})
    refused("at rest", region=moving, inhabitant={**proved.header.inhabitant, "agent_0.vx": Fraction(1, 2)})
    far = Fraction(10**400)
    refused("not a start", inhabitant={**proved.header.inhabitant, "agent_0.x": far})
    refused("reaches beyond", region=replace(region, box={**region.box, "agent_0.x": (-far, far)}))
    some = {name: bounds for name, bounds in region.box.items() if name != "agent_0.x"}
    start = {name: proved.header.inhabitant[name] for name in some}
    refused("bound all positions", region=replace(region, box=some), inhabitant=start)


def test_forms_without_contacts_are_refused_where_agents_collide(arrivers, proved):
    colliding = tuple(replace(entity, collides=True) for entity in arrivers.world.agents)
    touching = replace(arrivers, world=replace(arrivers.world, agents=colliding))
    with pytest.raises(RejectedError, match="can push each other"):
        check_certificate(altered(proved, profile=content_hash(touching)), touching)
    still = centred(touching, Fraction(1, 20), dict.fromkeys(ENTITIES, (0, 0)))
    question = Question(Game(touching), find_claim("reaches", touching, steps=0), still)
    found = build_certificate(question, proved.proof.parts)
    assert found.header.certificate != proved.header.certificate and check_certificate(found, touching) > 0


def test_a_proof_that_is_too_long_is_told(arrivers, proved, monkeypatch):
    question = Question(Game(arrivers), proved.claim, proved.header.region)
    with pytest.raises(NoCertificateError, match="more than"):
        build_certificate(question, proved.proof.parts, 1_000)

    def too_long(*given):
        raise NoCertificateError("too long")

    monkeypatch.setattr("verify.verdicts.episodes.certificates.build_certificate", too_long)
    result = verify_episodes(question, {})
    assert result.verdict is Verdict.PROVED
    assert result.evidence.certificate is None and result.evidence.uncertified == "too long"


def test_what_the_second_reading_leaves_open_is_not_proved(arrivers, proved, monkeypatch):
    """Zones that prove what is not so, as a fault of theirs would."""
    swinging = team(arrivers, towards(0, 0), arriving(1))
    wrong = ZonesDecision(Verdict.PROVED, 1, parts=proved.proof.parts)
    monkeypatch.setattr("verify.verdicts.episodes.decide", lambda *_: wrong)
    monkeypatch.setattr("verify.verdicts.episodes.first_failing", lambda *_: None)
    result = verify_episodes(Question(Game(swinging), proved.claim, proved.header.region), {})
    assert result.verdict is Verdict.UNKNOWN and "left open at the last step" in result.reason
    assert result.evidence.certificate is None and not result.evidence.followed and not result.evidence.uncertified
    assert result.evidence.control.verdict is Verdict.SKIPPED


@pytest.mark.parametrize("order", [1, -1])
def test_a_part_that_is_too_large_hides_no_open_branch(arrivers, proved, order):
    """One agent's proof exceeds the limit, the other's fails."""
    swinging = team(arrivers, arriving(0), towards(1, 1))
    question = Question(Game(swinging), proved.claim, proved.header.region)
    with pytest.raises(LeftOpenError):
        build_certificate(question, proved.proof.parts[::order], 2_000)


def test_a_control_is_judged_by_both_readings_too(arrivers, proved, monkeypatch):
    monkeypatch.setattr("verify.question.list_shuffled", lambda profile, *_: [team(profile, tree(STAY), tree(STAY))])
    question = Question(Game(arrivers), proved.claim, proved.header.region)
    decided = iter([decide(question), ZonesDecision(Verdict.PROVED, 1, parts=proved.proof.parts)])
    monkeypatch.setattr("verify.verdicts.episodes.decide", lambda *_: next(decided))
    monkeypatch.setattr("verify.verdicts.episodes.first_failing", lambda *_: None)
    result = verify_episodes(question, {})
    assert result.verdict is Verdict.PROVED and result.evidence.control.verdict is Verdict.UNKNOWN


def test_files_that_are_none(proved):
    text = to_json(proved)
    for damaged, said in (
        (text.replace('"steps": 25', '"steps": 24'), "edited"),
        (text.replace("certificate-1", "certificate-9"), "another version"),
        (text[: len(text) // 2], "truncated"),
        (text.replace('"parts"', '"pieces"'), "not a certificate"),
        ("[]", "not a certificate"),
    ):
        with pytest.raises(InputError, match=said):
            read_game(damaged)


def test_the_adversary_may_do_anything(profile):
    """Both ways that a test of the adversary leaves open arrive."""
    pair = with_trees({"agent_0": tree((6, 0.0, 1, 2), RIGHT, UP), "agent_1": tree(STAY)}, profile)
    places = {"agent_0": (0, 0), "landmark_0": (0.3, 0.3), "agent_1": (0, 0), "landmark_1": (0, 0)}
    region = centred(pair, Fraction(1, 100), places)
    assert check_certificate(certified(pair, find_claim("reaches", pair, steps=6), region), pair) > 0
    swinging = team(profile, towards(0, 0), towards(1, 1))
    question = Question(Game(swinging), find_claim("reaches", swinging), everywhere(swinging))
    with pytest.raises(NoCertificateError, match="left open"):
        build_certificate(question, [ProofPart("", "", "", BOTH, b"")])
