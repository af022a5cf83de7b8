"""Claims for ever about games: edges that agents never cross, and what no certificate may say."""

from dataclasses import replace
from fractions import Fraction as F

import numpy as np
import pytest

from codegen.errors import InputError
from codegen.policy_json import content_hash
from tests.support.altered import altered, read_game
from tests.support.teams import DOWN, LEFT, RIGHT, STAY, UP, team, tree
from verify.certificates.games import to_json
from verify.certificates.proofs import count_bytes
from verify.checker import decisions
from verify.checker.certificate import read
from verify.checker.episodes.certificates import FORM, Parts, check_certificate
from verify.checker.episodes.unbounded import RUNAWAY, SLACK, EdgeReading
from verify.checker.reading import RejectedError
from verify.claims.catalogue import find_claim
from verify.claims.region_files import everywhere
from verify.episodes import unbounded
from verify.episodes.unbounded import decide, nest_proofs
from verify.question import Budgets, Question
from verify.result import Verdict
from verify.states.episodes import play
from verify.states.shares import SAMPLE_SEED
from verify.states.state import sample
from verify.subjects import Game


def asked(profile, name="stays_in", region=None, **given):
    claim = find_claim(name, profile, steps="always", **given)
    return Question(Game(profile), claim, everywhere(profile) if region is None else region)


def proved(profile, *options, **given):
    found = decide(asked(profile, *options, **given))
    assert found.verdict is Verdict.PROVED, found.reason
    assert check_certificate(found.certificate, profile) > 0
    return found.certificate


def homing(k):
    """Goes to landmark k along x until that is near, then along y; thresholds are float32."""
    dx, dy = 2 + 2 * k, 3 + 2 * k
    return tree((dx, -0.25, 1, 2), LEFT, (dx, 0.25, 3, 6), (dy, 0.0, 4, 5), DOWN, UP, RIGHT)


def placed(profile, half=F(1, 16), **middles):
    """A region of boxes around places; everything else near 0."""
    start = everywhere(profile)
    box = {name: (F(middles.get(name.replace(".", "_"), 0)) - half, F(middles.get(name.replace(".", "_"), 0)) + half)
           for name in start.box}  # fmt: skip
    return replace(start, box=box, goals=("landmark_0",))


@pytest.fixture(scope="module")
def homers(profile):
    return team(profile, homing(0), homing(1))


@pytest.fixture(scope="module")
def certificate(homers):
    return proved(homers)


def test_nobody_crosses_an_edge(homers, certificate):
    """Neither at random nor in the corners, in 300 steps."""
    start, names = everywhere(homers), homers.world.coordinates()
    coordinates, _ = sample(start, homers.world, 300, SAMPLE_SEED)
    coordinates = np.concatenate([coordinates, np.sign(coordinates[:60])])
    episode, _ = play(homers, coordinates, 300)
    for name, (low, high) in certificate.proof.edges.items():
        places = episode[..., names.index(name)]
        assert places.min() >= float(low) - 2**-30 and places.max() <= float(high) + 2**-30
        assert float(high) - places.max() < 0.6  # the edge says something
    assert certificate.proof.followed == (("agent_0",), ("agent_1",))


def test_a_text_is_read_back(homers, certificate):
    text = to_json(certificate)
    assert read_game(text) == certificate and to_json(read_game(text)) == text
    assert check_certificate(read_game(text), homers) > 0 and count_bytes(certificate.proof) < 2_000
    with pytest.raises(InputError, match="edited"):
        read_game(text.replace('"upper"', '"lower"', 1))
    with pytest.raises(InputError, match="not a certificate"):
        read(text, "here", decisions.FORMS)


def test_a_shipped_team_stays_whatever_all_others_do(profile):
    certificate = proved(profile, radius=F(5, 2))
    assert max(edge for both in certificate.proof.edges.values() for edge in both) < F(9, 4)
    assert {name.rpartition(".")[0] for name in certificate.proof.edges} == {"agent_0", "agent_1"}


def test_two_that_never_meet(homers):
    """Each homes in on a landmark of its own side; where landmarks may be nearer, their edges overlap."""
    region = placed(homers, agent_0_x=-4, landmark_0_x=-4, agent_1_x=4, landmark_1_x=4)
    certificate = proved(homers, "keeps_apart", region, radius=3)
    assert certificate.proof.edges["agent_0.x"][1] + 3 + 2 * SLACK <= certificate.proof.edges["agent_1.x"][0]
    still = team(homers, tree(STAY), tree(STAY))
    assert proved(still, "keeps_apart", placed(still, agent_0_x=1), radius=F(3, 4))
    assert proved(still, "keeps_apart", placed(still, landmark_0_x=1, landmark_1_y=1), radius=F(3, 4),
                  others=("landmark_0", "landmark_1"))  # fmt: skip
    near = decide(asked(homers, "keeps_apart", placed(homers, agent_0_x=-1, agent_1_x=1), radius=F(1, 2)))
    assert (
        near.verdict is Verdict.UNKNOWN and "the edges of agent_0 and agent_1 do not keep them 1/2 apart" in near.reason
    )


def test_who_may_leave_is_named(homers):
    """From where, by which action, and to where; a budget that ends says so."""
    found = decide(asked(homers, radius=F(3, 2)))
    assert found.verdict is Verdict.UNKNOWN and found.zones > 0
    assert "agent_0 may leave 1.5 along x: it goes left at agent_0.x = -0.57" in found.reason
    assert "at its top speed it then comes to rest at x = -1.57" in found.reason and "landmark_0.x = -" in found.reason
    spent = decide(replace(asked(homers), budgets=Budgets(max_zones=20)))
    assert spent.verdict is Verdict.UNKNOWN and "--effort" in spent.reason


def test_those_whom_a_tree_reads(profile, monkeypatch):
    """Who runs after another one has edges where that one has: together, and never alone."""
    monkeypatch.setattr(unbounded, "FARTHEST_EDGE", F(8))  # sooner too far
    number = [feature.name for feature in profile.policy("agent_0").features].index("agent_1_dx")
    chasing = tree((number, -0.25, 1, 2), LEFT, (number, 0.25, 3, 4), STAY, RIGHT)
    chased = team(profile, chasing, homing(1))
    assert proved(chased).proof.followed == (("agent_0",), ("agent_1",))
    runaway = team(profile, chasing, tree(RIGHT))
    alone = decide(asked(runaway))
    assert alone.verdict is Verdict.UNKNOWN and "agent_1 may leave 3 along x: it goes right" in alone.reason
    runaway = replace(runaway, agents=tuple(
        replace(policy, team="others") if policy.agent == "agent_1" else policy for policy in runaway.agents
    ))  # fmt: skip
    assert "agent_0 may leave 3" in decide(asked(runaway, team="defenders")).reason
    hiding = replace(runaway, agents=tuple(
        replace(policy, tree=homing(0)) if policy.agent == "agent_0" else policy for policy in runaway.agents
    ))  # fmt: skip
    assert proved(hiding, team="defenders").proof.followed == (("agent_0",),)


# --- what the checker refuses


def forgeries(certificate):
    """Certificates that say more than was proved: (what is wrong, certificate)."""
    held, proofs, claim = certificate.proof.edges, certificate.proof.sides, certificate.claim
    yield "another radius", altered(certificate, claim=replace(claim, radius=F(2)))
    for name, (low, high) in [*held.items()][:2]:
        for nearer in ((low, high - F(1, 4)), (low + F(1, 4), high), (low, F(9, 10))):
            yield f"{name} nearer", altered(certificate, edges={**held, name: nearer})
        yield f"{name} has none", altered(certificate, edges={each: held[each] for each in held if each != name})
    for side in [each for each in proofs if each[0] == "agent_0.x"]:
        yield (
            f"no {side}",
            altered(certificate, proofs=nest_proofs({each: proofs[each] for each in proofs if each != side})),
        )
        yield f"empty {side}", altered(certificate, proofs=nest_proofs({**proofs, side: b""}))
        yield f"short {side}", altered(certificate, proofs=nest_proofs({**proofs, side: proofs[side][:-1]}))
        yield f"long {side}", altered(certificate, proofs=nest_proofs({**proofs, side: proofs[side] + b"\0"}))
    wide = {**certificate.header.region.box, "landmark_0.x": (F(-2), F(2))}
    yield "landmarks elsewhere", altered(certificate, region=replace(certificate.header.region, box=wide))
    starts = {**certificate.header.region.box, "agent_0.x": (F(-4), F(1))}
    yield "starts elsewhere", altered(certificate, region=replace(certificate.header.region, box=starts))
    moving = {**certificate.header.inhabitant, "agent_0.x": F(1, 3)}
    yield "no float64 start", altered(certificate, inhabitant=moving)
    yield "exact arithmetic", altered(certificate, semantics="real")


def test_forged_edges_are_refused(homers, certificate):
    for what, forged in forgeries(certificate):
        with pytest.raises(RejectedError):
            check_certificate(forged, homers)
            pytest.fail(what)


def test_edges_of_another_team_are_refused(profile, homers, certificate):
    """With other trees all proofs are of other trees; the hash is made right, as a forger would."""
    for first in (tree(RIGHT), homing(1), tree((2, -3.0, 1, 2), LEFT, RIGHT)):
        other = team(profile, first, homing(1))
        with pytest.raises(RejectedError):
            check_certificate(altered(certificate, profile=content_hash(other)), other)


def test_no_claim_for_ever_from_some_steps(homers, certificate):
    """A proof about some steps is none for ever, and edges show no arrival."""
    ever = find_claim("keeps_apart", homers, steps="always", radius=F(1, 2))
    bounded = altered(certificate, certificate=FORM, claim=ever, proof=Parts(()))
    with pytest.raises(RejectedError, match="for ever"):
        check_certificate(bounded, homers)
    some = altered(certificate, claim=find_claim("keeps_apart", homers, steps=25))
    with pytest.raises(RejectedError, match="another form"):
        check_certificate(some, homers)


def test_worlds_without_edges(homers, certificate):
    """Contacts, limits of speed and worlds in which nobody comes to rest."""
    world, region = homers.world, everywhere(homers)
    hard = tuple(replace(agent, collides=True) for agent in world.agents)
    quick = tuple(replace(agent, max_speed=1.0) for agent in world.agents)
    for changed in (
        replace(world, agents=hard, contact_force=100.0), replace(world, agents=quick), replace(world, damping=0.0),
        replace(world, damping=1e-4), replace(world, dt=0.0), replace(world, dt=20.0),
    ):  # fmt: skip
        with pytest.raises(RejectedError):
            EdgeReading(replace(homers, world=changed), region)
    slow = EdgeReading(replace(homers, world=replace(world, damping=1 / 200)), region)
    assert slow.axes["agent_0.x"].coasting > 19


# --- rounding


def coasted(x, v, dt, kept):
    """How far what float64 does, while it only coasts, strays from where it should come to rest, exactly."""
    k = F(dt) / (1 - F(kept))
    begun, far = F(x) + k * F(v), F(0)
    for _ in range(4_000):
        x, v = x + v * dt, v * kept
        far = max(far, abs(F(x) + k * F(v) - begun))
    assert v * dt + x == x
    return far


def test_coasting_strays_by_less_than_edges_allow(homers):
    """Also near 0, where positions have many digits, and where velocities end as subnormal numbers."""
    rng = np.random.default_rng(7)
    kept = 1.0 - homers.world.damping
    for _ in range(2):
        x, v = rng.uniform(-3, 3), rng.uniform(-2, 2)
        assert coasted(x, v, homers.world.dt, kept) < SLACK / 1_000
    assert coasted(1e-300, -1e-290, homers.world.dt, kept) < SLACK / 1_000


def test_a_runaway_stops_far_away(homers):
    """Beyond 2^58 a step of 16 adds nothing, so that RUNAWAY bounds all places."""
    far = float(2**58)
    assert far + 16.0 == far and far < RUNAWAY
