"""Claims about episodes where entities collide: bounds of pushes against play, verdicts against samples and mpe2."""

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

from codegen import ir
from codegen.errors import DisagreementError, InputError, UnknownNameError
from maviper.worlds import find
from tests.support.contacts import HALF, HOMING, LANES, SPREAD, TAG, around, escaped, going, random_team, team_in
from tests.support.episode_certificates import failures, replays_of
from tests.support.teams import LEFT, RIGHT, STAY, team, tree
from tests.support.tiers import first_of
from verify.checker.episodes.certificates import check_certificate
from verify.claims.catalogue import find_claim, sentence
from verify.claims.region_files import everywhere
from verify.claims.wording import account_of
from verify.episodes import contacts
from verify.episodes.composition import decide
from verify.episodes.unroll import build_group, strides
from verify.episodes.zones import SCALE, Zones, starts
from verify.question import Budgets, Question
from verify.reports import report
from verify.result import Verdict
from verify.states.episodes import at_rest, coinciding, courses, fails, play
from verify.states.state import State, sample, state_at
from verify.subjects import Game
from verify.verdicts.episodes import verify_episodes

pytestmark = [pytest.mark.solver, pytest.mark.usefixtures("few_states_throughout")]

WORLDS = (SPREAD, TAG, f"{SPREAD},agents=2", f"{TAG},predators=1,prey=1,obstacles=1")


TURNING = tree((0, 0.3, 1, 2), RIGHT, LEFT)


def fails_nowhere(profile, claim, region):
    return failures(profile, claim, region, 20_000, 2) == 0


def escapes(seed):
    """Starts that leave their zones, of a random crowded team; None when zones are too many. And zones touched."""
    name, rng = WORLDS[seed % len(WORLDS)], np.random.default_rng(seed)
    profile = random_team(name, seed % 3, seed)
    count = len(profile.world.agents) + len(profile.world.landmarks)
    region = around(profile, Fraction(1, 50), rng.uniform(-0.35, 0.35, (count, 2)))
    agents = [agent.name for agent in profile.world.agents]
    return escaped(profile, region, 3 + seed % 4, agents[:1] if seed % 5 == 4 else agents)


# --- bounds


def test_starts_stay_within_the_bounds_of_their_zones(monkeypatch):
    monkeypatch.setattr(contacts, "MAX_DRIFT", SCALE << 10)
    found = [escapes(seed) for seed in range(12)]
    decided = [(missing, touched) for missing, touched in found if missing is not None]
    assert all(missing == 0 for missing, _ in decided)
    assert len(decided) >= 8 and sum(touched > 0 for _, touched in decided) >= 6


def test_that_test_sees_a_push_that_is_bounded_too_low(monkeypatch):
    monkeypatch.setattr(contacts, "MAX_DRIFT", SCALE << 10)
    whole = contacts._force
    monkeypatch.setattr(contacts, "_force", lambda *given: tuple(part / 2 for part in whole(*given)))
    assert sum(missing or 0 for missing, _ in map(escapes, range(8))) > 0


def test_that_test_sees_contacts_noticed_too_late(monkeypatch):
    monkeypatch.setattr(contacts, "MAX_DRIFT", SCALE << 10)
    monkeypatch.setattr(contacts, "SURE_MARGINS", -20)
    assert sum(missing or 0 for missing, _ in map(escapes, range(8))) > 0


@pytest.mark.parametrize("name", [SPREAD, TAG])
def test_nobody_gets_farther_than_travels_say(name):
    for seed in range(6):
        profile = random_team(name, 2, seed)
        middles = np.random.default_rng(seed).uniform(-0.9, 0.9, (len(everywhere(profile).box) // 2 + 4, 2))
        count = len(profile.world.agents) + len(profile.world.landmarks)
        region = around(profile, Fraction(1, 10), middles[:count])
        far = contacts.travels(profile.world, strides(profile), starts(region, profile.world), 10)
        coordinates, _ = sample(at_rest(region), profile.world, 200, seed)
        episode, _ = play(profile, coordinates, 10)
        for place, agent in enumerate(profile.world.agents):
            moved = np.abs(episode - episode[0])[:, :, 2 * place : 2 * place + 2].max(axis=(1, 2))
            assert (moved <= far[agent.name] / SCALE + 1e-9).all()


# --- verdicts


def test_lanes_far_apart_are_proved():
    region = around(HOMING, HALF, LANES)
    for name in ("reaches", "keeps_apart"):
        claim = find_claim(name, HOMING)
        result = verify_episodes(Question(Game(HOMING), claim, region), {})
        assert result.verdict is Verdict.PROVED and not result.evidence.opponents
        assert ("agent_0", "agent_1", "agent_2") in result.evidence.followed and result.evidence.contacts
        assert failures(HOMING, claim, region, 5_000, 5) == 0


def test_a_proof_through_a_contact():
    """Two that run into each other from afar still keep their centres apart, and neither passes the other."""
    profile = going(RIGHT, LEFT, name=f"{SPREAD},agents=2")
    region = around(profile, Fraction(1, 100), [(-0.5, 0), (0.5, 0), (0, 0.9), (0, -0.9)])
    claim = find_claim("keeps_apart", profile, steps=6, radius=Fraction(1, 20))
    assert fails_nowhere(profile, claim, region)
    found = decide(Question(Game(profile), claim, region))
    assert found.verdict is Verdict.PROVED
    closer = find_claim("keeps_apart", profile, steps=6, radius=Fraction(2, 5))
    assert decide(Question(Game(profile), closer, region)).verdict is Verdict.VIOLATED


def test_crowds_are_refuted_and_replayed_by_mpe2():
    profile = going(RIGHT, LEFT, STAY)
    region = around(profile, HALF, [(-0.6, 0), (0.6, 0), (0, 0.9), (0.5, 0.5), (-0.5, 0.5), (0, -0.5)])
    with replays_of(profile) as replays:
        assert {"simulator", "mpe2.simple_spread_v3"} <= set(replays)
        claim = find_claim("keeps_apart", profile)
        result = verify_episodes(Question(Game(profile), claim, region), replays)
        assert result.verdict is Verdict.VIOLATED and set(result.evidence.replays) == set(replays)
        assert result.evidence.ways[0].landmark == "agent_1" and result.evidence.ways[0].nearest < 0.3
        off = {"other": lambda state, steps: replays["simulator"](replace(state, position=_mirrored(state)), steps)}
        with pytest.raises(DisagreementError, match="other plays another episode"):
            verify_episodes(Question(Game(profile), claim, region), off)


def _mirrored(state):
    return {name: -value for name, value in state.position.items()}


@pytest.mark.parametrize("name", [SPREAD, f"{TAG},observation=mpe2"])
def test_courses_with_contacts_are_those_of_mpe2(name):
    profile = random_team(name, 2, 1)
    region = around(profile, Fraction(1, 5), np.zeros((len(profile.world.agents) + len(profile.world.landmarks), 2)))
    coordinates, _ = sample(at_rest(region), profile.world, 5, 3)
    with replays_of(profile) as replays:
        for row in coordinates:
            state = state_at(region, profile.world, row, 0)
            ours = [part[:, 0] for part in courses(profile, [state], 12)]
            same = [replay(state, 12) for replay in replays.values()]
            assert all(np.array_equal(other.coordinates, ours[0]) for other in same)  # mpe2's too, bit for bit
            assert all(np.array_equal(other.actions, ours[1]) for other in same)


@pytest.mark.parametrize("seed", first_of(4, range(8)))
def test_random_teams_on_small_boxes(seed):
    """Verdicts hold on dense samples, and every violation fails when played."""
    name, rng = WORLDS[seed % len(WORLDS)], np.random.default_rng(seed)
    profile = random_team(name, 1 + seed % 2, seed)
    count = len(profile.world.agents) + len(profile.world.landmarks)
    region = around(profile, Fraction(1, 50), rng.uniform(-0.9, 0.9, (count, 2)))
    side = profile.agents[-1].team
    for claim in (
        find_claim("reaches", profile, side, steps=8, radius=Fraction(7, 10)),
        find_claim("keeps_apart", profile, side, steps=8, others=[profile.agents[0].agent], radius=Fraction(1, 4)),
    ):
        found = decide(Question(Game(profile), claim, region, budgets=Budgets(max_zones=30_000)))
        if found.verdict is Verdict.PROVED:
            assert fails_nowhere(profile, claim, region)
        elif found.verdict is Verdict.VIOLATED:
            assert fails(profile, claim, courses(profile, [found.state], claim.steps)[0][:, 0])
        else:
            assert found.reason


def test_prey_that_flees_is_not_caught():
    """From a head start, whatever the predator does at first, and against this predator for longer."""
    profile = going(RIGHT, RIGHT, name=f"{TAG},predators=1,prey=1,obstacles=1")
    region = around(profile, Fraction(1, 20), [(-0.5, 0), (0.5, 0), (-0.5, -0.9)])
    claim = find_claim("keeps_apart", profile, "prey", others=["adversary_0"])
    assert claim.radius == Fraction(1, 8) and "adversary_0" in account_of(claim).sentence
    result = verify_episodes(Question(Game(profile), claim, region), {})
    assert result.verdict is Verdict.PROVED
    short = verify_episodes(Question(Game(profile), replace(claim, steps=6), region), {})
    assert short.verdict is Verdict.PROVED
    assert short.evidence.followed == (("agent_0",),) and not short.evidence.opponents
    lazy = going(RIGHT, STAY, name=f"{TAG},predators=1,prey=1,obstacles=1")
    assert decide(Question(Game(lazy), claim, region)).verdict is Verdict.VIOLATED


def test_only_the_team_is_matched_when_opponents_are_followed():
    """The predators go away; others could push the prey off. They need no landmark, and are too many for these."""
    world = find(TAG).spec
    open_ground = tuple(replace(entity, collides=False) for entity in world.landmarks)
    profile = replace(going(LEFT, LEFT, STAY, STAY, name=TAG), world=replace(world, landmarks=open_ground))
    middles = [(0, 0), (0, 0.6), (0.5, 0), (0.5, 0.6), (0.5, 0), (0.5, 0.6)]
    claim = find_claim("covers", profile, "prey", steps=12, radius=Fraction(1, 5))
    found = decide(Question(Game(profile), claim, around(profile, HALF, middles)))
    assert found.verdict is Verdict.PROVED
    assert found.followed[-1] == ("adversary_0", "adversary_1", "agent_0", "agent_1")


def test_a_crowd_is_not_parted_without_end(monkeypatch):
    """Six that may all touch one another: told apart by their gaps they would be millions of zones."""
    monkeypatch.setattr(contacts, "MAX_PARTS", 1 << 10)
    profile = random_team(TAG, 1, 0)
    agents = [policy.agent for policy in profile.agents]
    group = build_group(profile, agents, None, [])
    parts = starts(around(profile, Fraction(1, 5), np.zeros((6, 2))), profile.world)
    first = np.array([part.project(group.entities) for part in parts])
    begun = Zones.at_start(first, np.arange(len(first)), len(agents), group.tests, touching=True)
    assert 100 < group.contacts.split_by_contact(begun, 0).count < 10 << 10


# --- keeping apart without contacts, and what is refused


def test_defenders_keep_apart(profile):
    apart = team(profile, tree(LEFT), tree(RIGHT))
    start = everywhere(apart)
    box = dict(start.box) | {"agent_0.x": (Fraction(-1), Fraction(-1, 5)), "agent_1.x": (Fraction(1, 5), Fraction(1))}
    region = replace(start, box=box)
    claim = find_claim("keeps_apart", apart, steps=25, radius=Fraction(1, 4))
    assert decide(Question(Game(apart), claim, region)).verdict is Verdict.PROVED
    assert decide(Question(Game(team(profile, tree(RIGHT), tree(LEFT))), claim, region)).verdict is Verdict.VIOLATED
    assert verify_episodes(Question(Game(apart), claim, region), {}).evidence.contacts == ""


def test_where_contacts_have_no_force_nothing_is_pushed():
    profile = going(RIGHT, LEFT, name=f"{SPREAD},agents=2")
    profile = replace(profile, world=replace(profile.world, contact_force=0.0, contact_margin=0.0))
    region = around(profile, Fraction(1, 100), [(-0.12, 0), (0.12, 0), (0, 0.9), (0, -0.9)])
    for radius, verdict in ((Fraction(1, 10), Verdict.PROVED), (Fraction(3, 20), Verdict.VIOLATED)):
        claim = find_claim("keeps_apart", profile, steps=2, radius=radius)
        assert decide(Question(Game(profile), claim, region)).verdict is verdict
        assert fails_nowhere(profile, claim, region) == (verdict is Verdict.PROVED)
    claim = find_claim("reaches", profile, steps=2, radius=Fraction(1))
    assert decide(Question(Game(profile), claim, region)).verdict is Verdict.PROVED


def test_pushes_beyond_what_numbers_hold_are_refused():
    """Actions may push more strongly than a unit vector would."""
    for scale in (1e6, 1e8):
        profile = _pushing(team_in("physical-deception", [tree(LEFT)] * 3), scale)
        for name in ("covers", "keeps_apart"):
            with pytest.raises(InputError, match="rounding over 3 steps"):
                decide(Question(Game(profile), find_claim(name, profile, steps=3), everywhere(profile)))


def _pushing(profile, scale):
    def pushing(action):
        return replace(action, effect=tuple(scale * part for part in action.effect))

    stronger = [replace(policy, actions=tuple(map(pushing, policy.actions))) for policy in profile.agents]
    return replace(profile, agents=tuple(stronger))


def test_a_speed_beside_a_place_that_is_not_followed_is_asked_again():
    """The own speed turns the test at step 1, wherever the adversary is near the threshold."""
    profile = team_in("physical-deception", [tree(STAY)] * 3)
    own = profile.policy("agent_0")
    meaning = ir.Meaning(((1, "adversary_0.x"), (1, "agent_0.vx")))
    own = replace(own, features=(ir.FeatureSpec("odd", "length", -9.0, 9.0, meaning),), tree=TURNING)
    others = tuple(own if policy.agent == "agent_0" else policy for policy in profile.agents)
    profile = replace(profile, agents=others)
    region = around(profile, Fraction(1, 1000), [(0.2, 0), (0, 0), (5, 5), (0.08, 0), (0.5, 0.5)])
    claim = find_claim("keeps_apart", profile, steps=4, others=["landmark_0"], radius=Fraction(1, 400))
    assert failures(profile, claim, region, 300, 3) > 0
    assert decide(Question(Game(profile), claim, region)).verdict is Verdict.VIOLATED


def test_pairs_and_refusals():
    both = find_claim("keeps_apart", HOMING, others=["agent_0", "landmark_1"])
    pairs = both.pairs(HOMING)
    assert len(pairs) == 5 and ("agent_1", "agent_0") in pairs and ("agent_0", "landmark_1") in pairs
    assert find_claim("keeps_apart", HOMING).radius == Fraction(3, 10)
    with pytest.raises(UnknownNameError, match="unknown entity"):
        find_claim("keeps_apart", HOMING, others=["agent_9"])
    with pytest.raises(InputError, match="says nothing"):
        find_claim("keeps_apart", HOMING, radius=Fraction(0))
    alone = going(STAY, STAY, name=f"{TAG},predators=1,prey=1,obstacles=1")
    with pytest.raises(InputError, match="needs at least two"):
        find_claim("keeps_apart", alone, "prey")


# --- centres that coincide, where the reference has no number


def at_one_place(profile, half=0):
    return around(profile, Fraction(half), np.zeros((len(profile.world.agents) + len(profile.world.landmarks), 2)))


@pytest.mark.parametrize("name", [f"{SPREAD},agents=2", f"{TAG},predators=1,prey=1,obstacles=1"])
@pytest.mark.parametrize("kind", ["reaches", "covers", "keeps_apart"])
def test_no_claim_is_about_centres_that_coincide(name, kind):
    """Everybody is at its landmark at once, or nearer than allowed; and mpe2 gives NaN."""
    profile = going(STAY, STAY, name=name)
    region, side = at_one_place(profile), profile.agents[-1].team
    others = [profile.agents[0].agent] if name.startswith(TAG) and kind == "keeps_apart" else []
    claim = find_claim(kind, profile, side, steps=0 if kind == "covers" else 2, others=others)
    start = State(dict.fromkeys(region.box, 0.0), None)
    with replays_of(profile) as replays, np.errstate(invalid="ignore"):
        assert np.isnan(replays[profile.world.reference](start, 2).coordinates).any()
    for replays in ({}, {"simulator": lambda *_: pytest.fail("no start of the claim")}):
        result = verify_episodes(Question(Game(profile), claim, region), replays)
        assert result.verdict is Verdict.UNKNOWN and result.reason and not result.evidence.violating.hits
    assert "within 1e-150 of each other" in sentence(claim, profile.world)


def test_a_proof_says_which_starts_it_leaves_out():
    profile = going(STAY, STAY, name=f"{SPREAD},agents=2")
    claim = find_claim("reaches", profile, steps=0)
    result = verify_episodes(Question(Game(profile), claim, at_one_place(profile, "1/10")), {})
    assert result.verdict is Verdict.PROVED and "within 1e-150 of each other" in result.evidence.left_out
    assert result.evidence.branches == check_certificate(result.evidence.certificate, profile)
    facts = report.document(profile, [result], [""])
    for text in (report.as_text(facts), report.as_html(facts)):
        assert "within 1e-150 of each other" in text and "one reading, no certificate" not in text
    apart = team_in("physical-deception", [tree(STAY)] * 3)
    question = Question(Game(apart), find_claim("reaches", apart, steps=0), at_one_place(apart, "1/10"))
    still = verify_episodes(question, {})
    assert still.verdict is Verdict.PROVED and not still.evidence.left_out and not still.evidence.uncertified


@pytest.mark.parametrize(("gap", "wanted"), [(0.0, True), (1e-160, True), (1e-140, False)])
def test_when_centres_coincide(gap, wanted):
    """At any step, of any two that push each other."""
    profile = going(STAY, STAY, STAY, name=f"{TAG},predators=2,prey=1,obstacles=1")
    names = profile.world.coordinates()
    episode = np.random.default_rng(0).uniform(-1, 1, (4, 3, len(names)))
    for axis, far in (("x", gap), ("y", 0.0)):
        mark = episode[2, 1, names.index(f"obstacle_0.{axis}")] = 0.0
        episode[2, 1, names.index(f"adversary_1.{axis}")] = mark + far
    assert coinciding(profile, episode).tolist() == [False, wanted, False]
    claim = find_claim("keeps_apart", profile, "prey", others=["adversary_0"], radius=Fraction(9))
    assert [fails(profile, claim, episode[:, row]) for row in range(3)] == [True, not wanted, True]


def test_a_region_without_float64_starts_is_not_proved(profile):
    still = team(profile, tree(STAY), tree(STAY))
    start = everywhere(still)
    third = replace(start, box={name: (Fraction(1, 3), Fraction(1, 3)) for name in start.box})
    result = verify_episodes(Question(Game(still), find_claim("reaches", still, steps=0), third), {})
    assert result.verdict is Verdict.UNKNOWN and "no start in the region was found" in result.reason
