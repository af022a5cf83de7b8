"""Claims about episodes against episodes: small trees over signs and other functions, every corner of small regions."""

from dataclasses import replace
from fractions import Fraction
from itertools import product

import numpy as np
import pytest

from codegen import ir
from codegen.errors import InputError
from codegen.profiles import ensure
from tests.support.altered import altered, read_game
from tests.support.contacts import played
from tests.support.teams import RIGHT, STAY, tree
from verify.certificates.games import to_json
from verify.checker.episodes.certificates import FORM, ProofPart, check_certificate
from verify.checker.reading import RejectedError
from verify.claims.catalogue import find_claim
from verify.claims.region import Region
from verify.claims.region_files import everywhere
from verify.episodes.certificates import NoCertificateError, build_certificate
from verify.episodes.composition import decide
from verify.question import Budgets, Question
from verify.result import Verdict
from verify.states.episodes import courses, fails, first_failing
from verify.states.state import State
from verify.subjects import Game

pytestmark = pytest.mark.solver

TEAM = "defenders"
FUNCTIONS = ("", *ir.FUNCTIONS, "sign", "sign")
THRESHOLDS = (-1.0, -0.5, 0.0, 0.5, 1.0)
SIDE = 1 / 16
INTERVALS = ((0, 0), (0, SIDE), (-SIDE, 0), (-SIDE, SIDE))
VALUES = (0.0, SIDE, -SIDE, 2.0**-40, -(2.0**-40), 5e-324, SIDE / 2)  # starts: the corners, and what lies beside 0
MAX_STARTS = 1_500


def observing(profile, agent, *features):
    """The profile with an agent that observes features [(function, terms)], and its tree as it is."""
    specs = tuple(
        ir.FeatureSpec(f"f{number}", "none", -9.0, 9.0, ir.Meaning(tuple(terms), function))
        for number, (function, terms) in enumerate(features)
    )
    changed = replace(profile.policy(agent), features=specs)
    return replace(profile, agents=tuple(changed if one.agent == agent else one for one in profile.agents))


def with_tree(profile, agent, grown):
    changed = replace(profile.policy(agent), tree=grown)
    return replace(profile, agents=tuple(changed if one.agent == agent else one for one in profile.agents))


def _features(rng, agent, others):
    """The offset of the first of the others on x, or a function of it, and two of any kind."""
    found = [(str(rng.choice(FUNCTIONS)), [(1, f"{others[0]}.x"), (-1, f"{agent}.x")])]
    for _ in range(2):
        axis, other = rng.choice(["x", "x", "y"]), str(rng.choice(others))
        kinds = [
            [(1, f"{other}.{axis}"), (-1, f"{agent}.{axis}")],
            [(-1, f"{other}.{axis}"), (1, f"{agent}.{axis}")],
            [(1, f"goal.{axis}"), (-1, f"{others[0]}.{axis}")],
            [(1, f"{agent}.{axis}")],
            [(1, f"{agent}.v{axis}")],
        ]
        found.append((str(rng.choice(FUNCTIONS)), kinds[rng.integers(len(kinds))]))
    return found


def _grown(rng, depth, place=0):
    """The nodes of a random tree whose root stands at `place`, in preorder; most tests are of the first feature."""
    if not depth:
        return [int(rng.choice([STAY, STAY, STAY, rng.integers(5)]))]
    left = _grown(rng, depth - 1 - int(rng.integers(2)) * (depth > 1), place + 1)
    right = _grown(rng, depth - 1, place + 1 + len(left))
    feature, threshold = int(rng.choice([0, 0, 0, 1, 2])), float(rng.choice(THRESHOLDS))
    return [(feature, threshold, place + 1, place + 1 + len(left)), *left, *right]


def _between(rng):
    """Two tests of one feature, and an action of its own for what lies between them."""
    low, high = sorted(float(rng.choice(THRESHOLDS)) for _ in range(2))
    outside, inside = (STAY, int(rng.integers(5))) if rng.integers(4) else (int(rng.integers(5)), STAY)
    if rng.integers(2):
        return [(0, low, 1, 2), outside, (0, high, 3, 4), inside, outside]
    return [(0, high, 1, 4), (0, low, 2, 3), outside, inside, outside]


def random_question(seed):
    """(profile, claim, region), with ends of the region's intervals at 0 and tests that turn there."""
    rng = np.random.default_rng(seed)
    count = 1 + int(rng.integers(3) == 0)
    profile = played(f"physical-deception,defenders={count}", [tree(STAY)] * (count + 1))
    entities = [entity.name for entity in profile.world.agents + profile.world.landmarks]
    for policy in profile.agents:
        others = ["landmark_0", "goal", *(name for name in entities if name != policy.agent)]
        profile = observing(profile, policy.agent, *_features(rng, policy.agent, others))
        nodes = _between(rng) if rng.integers(2) else _grown(rng, int(rng.integers(1, 4)))
        profile = with_tree(profile, policy.agent, tree(*nodes))
    start = everywhere(profile)
    box = {name: tuple(map(Fraction, INTERVALS[rng.choice([0, 0, 1, 2, 3])])) for name in start.box}
    box |= {name: (Fraction(-4), Fraction(4)) for name in box if name.endswith((".vx", ".vy"))}
    radius = Fraction(rng.choice(["1/16", "3/50", "1/8", "1/5"]))
    steps = int(rng.choice([0, 1, 2, 4, 6, 8]))
    kind = str(rng.choice(["reaches", "covers", "keeps_apart"]))
    others = [str(rng.choice([name for name in entities if not name.startswith("agent")]))]
    radius = max(radius, Fraction(1, 64)) if kind == "keeps_apart" else radius
    others = others if kind == "keeps_apart" else []
    return profile, find_claim(kind, profile, TEAM, steps=steps, radius=radius, others=others), Region(box, start.goals)


def corners(profile, region, seed):
    """Float64 starts at the ends of a region's intervals and beside 0: all of them, or as many as MAX_STARTS."""
    rng, still = np.random.default_rng(seed), {name: 0.0 for name in region.box if ".v" in name}
    places = [name for name in region.box if name not in still]
    values = [[v for v in VALUES if region.box[name][0] <= Fraction(v) <= region.box[name][1]] for name in places]
    if np.prod([len(each) for each in values], dtype=float) <= MAX_STARTS:
        rows = list(product(*values))
    else:
        drawn = [np.array(each, float)[rng.integers(len(each), size=MAX_STARTS)] for each in values]
        rows = np.stack(drawn, axis=1).tolist()
    goals = region.goal_cases
    return [State(dict(zip(places, row, strict=True)) | still, goal) for row in rows for goal in goals]


def disagreement(seed):
    """What is wrong with the answers to a random question, or ""; and the verdict."""
    profile, claim, region = random_question(seed)
    ensure(profile)
    try:
        found = decide(Question(Game(profile), claim, region, budgets=Budgets(max_zones=20_000)))
    except InputError as error:
        return f"refused: {error}", None
    fails_at = first_failing(Question(Game(profile), claim, region), corners(profile, region, seed))
    if found.verdict is Verdict.PROVED and fails_at is not None:
        return f"proved by zones, fails at {fails_at}", found.verdict
    if found.verdict is Verdict.VIOLATED:
        episode = courses(profile, [found.state], claim.steps)[0][:, 0]
        return "" if fails(profile, claim, episode) else "refuted, does not fail", found.verdict
    if claim.name == "keeps_apart":
        return "", found.verdict
    followed = tuple(policy.agent for policy in profile.team(TEAM))
    own = [("", "")] if not claim.landmarks else zip(followed, claim.landmarks, strict=True)
    try:
        proved = found.parts if found.verdict is Verdict.PROVED else [ProofPart(*p, "", followed, b"") for p in own]
        check_certificate(build_certificate(Question(Game(profile), claim, region), proved, 20_000), profile)
    except NoCertificateError as error:
        wrong = found.verdict is Verdict.PROVED and "answers" not in str(error)
        return f"proved by zones, {error}" if wrong else "", found.verdict
    return f"certified, fails at {fails_at}" if fails_at is not None else "", found.verdict


# --- tests that turn at the same number


ZERO, NEAR, BESIDE = (Fraction(0),) * 2, (Fraction(0), Fraction(1, 20)), (Fraction(-1, 20), Fraction(1, 20))
BETWEEN = tree((0, -0.5, 1, 2), STAY, (0, 0.5, 3, 4), RIGHT, STAY)  # goes right where the sign is 0
SIGN = ("sign", [(1, "agent_0.x"), (-1, "landmark_0.x")])


def placed(profile, **bounds):
    """A region with the given bounds of coordinates; all others are 0."""
    start = everywhere(profile)
    return replace(start, box={name: bounds.get(name.replace(".", "_"), ZERO) for name in start.box})


def answers(profile, claim, region):
    """The verdict of the zones, and whether the second reading has a certificate."""
    whole = [ProofPart("", "", "", ("agent_0",), b"")]
    try:
        return decide(Question(Game(profile), claim, region)).verdict, bool(
            build_certificate(Question(Game(profile), claim, region), whole)
        )
    except NoCertificateError:
        return decide(Question(Game(profile), claim, region)).verdict, False


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
    profile = with_tree(played("physical-deception,defenders=1", [tree(STAY)] * 2), "agent_0", grown)
    profile = observing(profile, "agent_0", SIGN)
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
    profile = played("physical-deception,features=signs", [still, grown, still])
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
    profile = with_tree(played("physical-deception,defenders=1", [tree(STAY)] * 2), "agent_0", grown)
    profile = observing(profile, "agent_0", (function, SIGN[1]))
    claim = find_claim("covers", profile, TEAM, steps=8, radius=Fraction(3, 50))
    wide = placed(profile, agent_0_x=NEAR, agent_0_y=BESIDE, landmark_0_x=NEAR)
    assert answers(profile, claim, wide) == (Verdict.PROVED, True)


def test_what_is_not_zero_stays_so():
    """Both readings know it in a second test; form 1 of certificates does not."""
    grown = tree((0, 0.25, 1, 2), STAY, (0, 0.75, 3, 4), RIGHT, STAY)
    profile = with_tree(played("physical-deception,defenders=1", [tree(STAY)] * 2), "agent_0", grown)
    profile = observing(profile, "agent_0", ("zero", SIGN[1]))
    claim = find_claim("covers", profile, TEAM, steps=6, radius=Fraction(3, 50))
    region = placed(profile, agent_0_x=NEAR, landmark_0_x=NEAR)
    certificate = build_certificate(
        Question(Game(profile), claim, region), decide(Question(Game(profile), claim, region)).parts
    )
    assert certificate.header.certificate == "maviper-episode-certificate-2"
    assert read_game(to_json(certificate)) == certificate and check_certificate(certificate, profile) > 0
    with pytest.raises(RejectedError):
        check_certificate(altered(certificate, certificate=FORM), profile)


def test_sums_of_three_are_refused():
    """A coordinate that cancels still rounds: such a test is another one than that of what is left of it."""
    profile = with_tree(played("physical-deception,defenders=1", [tree(STAY)] * 2), "agent_0", BETWEEN)
    rounding = [*SIGN[1], (1, "landmark_0.x")]
    profile = observing(profile, "agent_0", ("", rounding))
    claim = find_claim("keeps_apart", profile, TEAM, steps=8, others=["landmark_0"])
    found = decide(Question(Game(profile), claim, placed(profile)))
    assert found.verdict is Verdict.UNKNOWN and "not a coordinate or a difference of two" in found.reason


# --- random questions


@pytest.mark.parametrize("part", range(4))
def test_answers_are_those_of_the_episodes(part):
    answers = [disagreement(seed) for seed in range(12 * part, 12 * part + 12)]
    assert [said for said, _ in answers if said] == []
    assert {verdict for _, verdict in answers} >= {Verdict.PROVED, Verdict.VIOLATED}
