"""Shares of starts that fail, against starts played by the hunt's judge, which shares nothing with `verify`."""

from dataclasses import replace
from fractions import Fraction
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest
from scipy.stats import binom

from codegen import policy_json
from maviper import load
from maviper.verification.ask import VerifyOptions
from maviper.verification.run import results
from tests.hunting import episodes as hunted
from tests.hunting import playing
from tests.hunting.places import Case
from tests.hunting.reading import MACHINE, read
from tests.support.episode_cases import arriving
from tests.support.teams import LEFT, RIGHT, STAY, team, tree
from verify.claims.catalogue import find_claim
from verify.claims.region import Region
from verify.claims.uncertified.starts import everywhere
from verify.episodes.composition import decide
from verify.extent.starts import NOBODY, NOT_APART, start_share
from verify.extent.sure import FLAT
from verify.question import Budgets, Question
from verify.reports.episodes import _starts
from verify.reports.lines import as_lines
from verify.reports.report import result_facts
from verify.result import Verdict
from verify.subjects import Game

pytestmark = [pytest.mark.solver, pytest.mark.usefixtures("few_states_throughout")]
GENERATED = Path(__file__).parents[3] / "generated"
UNLIKELY = 1e-7
HALF, TENTH = Fraction(1, 2), Fraction(1, 10)
CROSSING = tree((2, 0.0, 1, 4), (3, -0.25, 2, 3), LEFT, STAY, RIGHT)


def drawn(case, count, seed):
    """Uniform starts of a region: coordinate -> [starts], and the goal that they have; goals in equal numbers."""
    rng = np.random.default_rng(seed)
    box = np.array([[float(end) for end in ends] for ends in case.region["box"].values()])
    states = rng.uniform(box[:, 0], box[:, 1], (count, len(box)))
    states[:, [name.rpartition(".")[2].startswith("v") for name in case.names]] = 0.0
    at, kept = dict(zip(case.names, states.T, strict=True)), np.ones(count, dtype=bool)
    for a, b, (low, high) in case.region["differences"]:
        kept &= (at[a] - at[b] >= float(low)) & (at[a] - at[b] <= float(high))
    for a, b, least in case.region["apart"]:
        kept &= np.maximum(*(np.abs(at[f"{a}.{axis}"] - at[f"{b}.{axis}"]) for axis in "xy")) >= float(least)
    states = states[kept]
    return [(goal, states[place :: len(case.goals)]) for place, goal in enumerate(case.goals)]


def failing(case, count, seed):
    """How many of how many starts fail when the judge plays them."""
    hits = played = 0
    for goal, states in drawn(case, count, seed):
        course = playing.simulated(case.profile, case.at(states, goal), goal, case.claim["steps"])
        hits += int((~playing.fulfilled(case, course)).sum())
        played += len(states)
    return hits, played


def case_of(profile, claim, region):
    stated = {"name": claim.name, "team": claim.team, "landmarks": claim.landmarks, "others": (), "eps": Fraction(0)}
    stated |= {"steps": claim.steps, "radius": claim.radius}
    where = {"box": dict(region.box), "differences": list(region.differences), "apart": list(region.apart)}
    where["goals"] = list(region.goals)
    return Case(read(policy_json.dumps(profile)), stated, where, MACHINE)


def plausible(found, hits, count):
    """Whether starts fail as often as a share between the bounds allows."""
    below, above = binom.cdf(hits, count, float(found.least)), binom.sf(hits - 1, count, float(found.most))
    return found.least <= found.most and below > UNLIKELY and above > UNLIKELY


def checked(profile, name, region, count=100_000, seed=3, zones=500_000, **given):
    """The share of starts that fail, which as many played starts agree with."""
    claim = find_claim(name, profile, **given)
    found = start_share(Question(Game(profile), claim, region, budgets=Budgets(max_zones=zones)), Verdict.VIOLATED)
    hits, played = failing(case_of(profile, claim, region), count, seed)
    assert played > count // 50 and plausible(found, hits, played), (found, hits, played)
    return found


@pytest.fixture(scope="module")
def defenders():
    return load(GENERATED / "proved_defenders" / "profile.json")


def test_random_teams_fail_as_often_as_they_are_played_to():
    """Small regions, many of their intervals a single number; signs, tests that tie, agents that stand or wander."""
    asked, exact, both = 0, 0, 0
    for seed in range(70):
        one = hunted.drawn(seed)
        if one.case.claim["name"] == "keeps_apart" or one.case.profile.world["contact_force"]:
            continue
        found = start_share(one.question.spending(max_zones=200_000), Verdict.VIOLATED)
        hits, played = failing(one.case, 2_000, seed)
        assert plausible(found, hits, played), (seed, found, hits, played)
        asked += 1
        exact += found.exact and found.most - found.least < Fraction(1, 10_000)
        both += found.exact and found.least > 0 and found.most < 1
    assert asked > 28 and exact > 22 and both > 2, (asked, exact, both)


def test_the_whole_start_region(defenders):
    found = checked(defenders, "reaches", everywhere(defenders), steps=20)
    assert found.exact and found.most - found.least < Fraction(1, 10**5) < found.least


def test_matchings_of_any_kind_lie_between_bounds(defenders):
    found = checked(defenders, "covers", everywhere(defenders), zones=200_000, steps=12)
    assert not found.exact and found.spent == "answers" and 0 < found.least < found.most <= 1


def test_agents_that_share_what_they_read_are_followed_in_turn(profile):
    """Both read both landmarks, and the second one the first."""
    first, second = arriving(0), arriving(0)
    own = replace(second, feature=np.where(second.feature == 3, 6, second.feature))
    small = {name: (Fraction(-3, 8), Fraction(3, 8)) for name in everywhere(profile).box if name[-2] == "."}
    together = team(profile, first, own)
    region = replace(everywhere(together), box=everywhere(together).box | small, goals=("landmark_0",))
    found = checked(together, "reaches", region, steps=3, radius=TENTH, landmarks=("landmark_0", "landmark_1"))
    assert found.exact and 0 < found.least < found.most < 1


def test_a_share_that_can_be_told_by_hand(profile):
    """Two agents that stand: each is near its landmark on both axes, or not."""
    still = team(profile, tree(STAY), tree(STAY))
    near = TENTH - TENTH**2 / 4  # |a - b| <= r for uniform numbers of [-1, 1]
    for name in ("reaches", "covers"):
        claim = find_claim(name, still, radius=TENTH, landmarks=("landmark_0", "landmark_1"))
        found = start_share(Question(Game(still), claim, everywhere(still)), Verdict.VIOLATED)
        assert found.exact and found.least == found.most == 1 - near**4


def test_equal_bounds_leave_a_share_of_what_there_is(profile):
    """An agent beside its landmark by a fixed distance, exactly the radius; the other's alone counts."""
    still = team(profile, tree(STAY), tree(STAY))
    start = everywhere(still)
    beside = {"agent_0.x": (Fraction(1, 4),) * 2, "landmark_0.x": (Fraction(3, 20),) * 2}
    level = ("agent_0.y", "landmark_0.y", (Fraction(0),) * 2)
    named = {"landmarks": ("landmark_0", "landmark_1")}
    for radius, sure in ((TENTH, True), (TENTH - Fraction(1, 10**30), False)):
        claim = find_claim("reaches", still, radius=radius, **named)
        region = replace(start, box=start.box | beside, differences=(level,))
        found = start_share(Question(Game(still), claim, region), Verdict.VIOLATED)
        assert found.least == found.most and found.exact
        assert found.least == (1 - (radius - radius**2 / 4) ** 2 if sure else 1)


def test_a_single_start(profile):
    """A region of one point: the share is 0 or 1, as its episode is."""
    arrivers = team(profile, arriving(0), arriving(1))
    start = everywhere(arrivers)
    for place, share in ((Fraction(1, 8), 0), (Fraction(7, 8), 1)):
        box = {name: (place if name.startswith("agent") else Fraction(0),) * 2 for name in start.box}
        box = {name: ends if name[-2] == "." else start.box[name] for name, ends in box.items()}
        found = checked(arrivers, "reaches", replace(start, box=box), count=100, steps=3, radius=HALF)
        assert found.exact and found.least == found.most == share


def test_a_start_within_roundings_of_an_edge_is_not_said_to_hold_exactly(profile):
    """After two steps both stand on the edge of what counts as arrived, but for roundings."""
    movers = team(profile, tree(RIGHT), tree(RIGHT))
    start = everywhere(movers)
    box = {name: (Fraction(0),) * 2 if name[-2] == "." else ends for name, ends in start.box.items()}
    box |= dict.fromkeys(("landmark_0.x", "landmark_1.x"), (Fraction(3, 20),) * 2)
    question = Question(Game(movers), find_claim("reaches", movers, steps=2, radius=TENTH), replace(start, box=box))
    told = _starts(start_share(question, Verdict.UNKNOWN))
    assert (told["least"], told["most"]) == ("0", "1")
    assert told["says"] == "between 0 % and 100 % of starts fail: 100 % are within roundings of an edge"


def test_differences_and_distances_of_a_region(profile):
    """The parts that a distance leaves overlap at corners, and are counted once."""
    crossing = team(profile, CROSSING, arriving(1))
    start = everywhere(crossing)
    apart = (("landmark_0", "agent_0", Fraction(3, 5)), ("landmark_1", "agent_1", Fraction(1, 5)))
    gap = (("agent_0.y", "landmark_1.y", (Fraction(-1, 2), Fraction(1, 3))),)
    region = Region(dict(start.box), start.goals, gap, apart)
    found = checked(crossing, "reaches", region, steps=6, radius=HALF, zones=2_000_000)
    assert found.exact and 0 < found.least < found.most < 1
    impossible = replace(region, apart=(("landmark_0", "agent_0", Fraction(2)),))
    claim = find_claim("reaches", crossing, steps=6)
    assert start_share(Question(Game(crossing), claim, impossible), Verdict.UNKNOWN).reason == FLAT
    names = [entity.name for entity in crossing.world.agents + crossing.world.landmarks]
    crowd = replace(region, apart=tuple((a, b, TENTH) for a, b in combinations(names, 2)))
    assert "parts" in start_share(Question(Game(crossing), claim, crowd), Verdict.UNKNOWN).reason


def test_a_budget_that_ends_leaves_bounds(defenders):
    """The bounds hold at every budget, and more answers bring them no farther apart."""
    before = None
    for zones in (50, 1_000, 20_000, 400_000):
        found = checked(defenders, "reaches", everywhere(defenders), count=20_000, zones=zones, steps=16)
        assert before is None or (before.least <= found.least and found.most <= before.most)
        before = found
    assert before is not None and before.exact


def test_faces_that_end_leave_bounds(defenders):
    claim = find_claim("covers", defenders, steps=8)
    found = start_share(
        Question(Game(defenders), claim, everywhere(defenders)).spending(max_zones=20_000), Verdict.UNKNOWN, 0
    )
    assert 0 <= found.least <= found.most <= 1 and not found.exact


def test_what_has_no_share_says_why(profile, defenders):
    claim = find_claim("reaches", defenders)
    question = Question(Game(defenders), claim, everywhere(defenders))
    assert start_share(question, Verdict.PROVED).most == 0 and start_share(question, Verdict.VACUOUS).reason == NOBODY
    apart = find_claim("keeps_apart", profile, others=("landmark_0",))
    assert start_share(Question(Game(profile), apart, everywhere(profile)), Verdict.UNKNOWN).reason == NOT_APART
    crowded = load(GENERATED / "proved_navigation" / "profile.json")
    found = start_share(Question(Game(crowded), find_claim("reaches", crowded), everywhere(crowded)), Verdict.UNKNOWN)
    assert "push each other" in found.reason


def test_a_proof_leaves_no_failing_start(defenders):
    """What zones prove has no cell that surely fails."""
    claim = find_claim("reaches", defenders, steps=28)
    question = Question(Game(defenders), claim, everywhere(defenders))
    assert decide(question).verdict is Verdict.PROVED and start_share(question, Verdict.UNKNOWN).least == 0


def test_reports_and_terminal_tell_the_share(defenders):
    options = VerifyOptions(names=("reaches",), where=True, parameters={"steps": 8})
    result = results(defenders, options)[0]
    told = result_facts(defenders, result, "")["starts"]
    assert told["exact"] and Fraction(
        told["least"]
    ) <= result.evidence.starts.least < result.evidence.starts.most <= Fraction(told["most"])
    assert told["answers"] <= told["budget"] == Budgets().max_zones
    assert told["says"].startswith("exactly ") and " of starts fail; " in told["says"]
    assert told["says"] in as_lines(defenders, result)[1]
    unasked = results(defenders, replace(options, where=False))[0]
    assert "starts" not in result_facts(defenders, unasked, "")
