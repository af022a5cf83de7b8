"""Where claims hold: zones against points, shares against sampling and brute force, regions against both engines."""

import json
from dataclasses import replace
from fractions import Fraction
from itertools import permutations, product
from math import lcm

import numpy as np
import pytest

from codegen import ir
from maviper.verification.run import verify_claims
from tests.support.steady_zones import stands
from tests.support.teams import STAY, UP, team, towards, tree
from tests.support.zone_cases import (
    actions_at,
    deception,
    grid_points,
    navigation,
    near_roles,
    noisy,
    random_region,
    switching,
    with_long_bounds,
)
from verify.claims.catalogue import find_property
from verify.claims.decisions import DistinctTargets, engages, formula
from verify.claims.formula import And, Goal, Linear, Not, Or, holds
from verify.claims.region import Region
from verify.claims.region_files import everywhere, read_region, region_toml, start_region
from verify.claims.wording import OwnFormula
from verify.extent import largest as where
from verify.extent import violations
from verify.extent.largest import GRID, obstacles
from verify.extent.violations import union
from verify.kinds import MACHINE, REAL
from verify.question import Budgets, Question
from verify.reports import report
from verify.reports import where as where_report
from verify.result import Verdict
from verify.solver.solve import decide
from verify.spending import listening
from verify.states import shares
from verify.subjects import Game
from verify.verdicts import decisions
from verify.zones.search import SLOWER
from verify.zones.tables import EPSILON, Problem

pytestmark = [pytest.mark.solver, pytest.mark.usefixtures("few_states_throughout")]
CLAIM = DistinctTargets("defenders")


@pytest.fixture
def same(profile):
    """Two agents that both go to landmark 0."""
    return team(profile, towards(0, 0), towards(0, 1))


def about(profile, claim, region, **budgets):
    return Question(Game(profile), claim, region, budgets=Budgets(**budgets))


def located(profile, claim, region, verdict=Verdict.VIOLATED, name="", **budgets):
    return where.where(about(profile, claim, region, **budgets), verdict, name)


def contains(bounds, state):
    """Whether a zone contains a rational point, its open faces left out; `state`: (numerators, common denominator)."""
    at, scale = state
    for (a, b), (over, under, below) in bounds:
        gap, most = (at[a] - at[b]) * under, over * scale
        if gap > most or (below and gap == most):
            return False
    return True


def whole_numbers(bounds):
    """Bounds of a zone, compared many times, without fractions: (ends, (numerator, denominator, open))."""
    return [(ends, (*most.as_integer_ratio(), below)) for ends, (most, below) in bounds.items()]


def scaled(state):
    """A rational point as numerators of one denominator, and the origin."""
    scale = lcm(*(value.denominator for value in state.values()))
    return {name: int(value * scale) for name, value in state.items()} | {"": 0}, scale


def fails_at(profile, claim, state, goal, machine=True):
    at = state | {f"goal.{axis}": state.get(f"{goal}.{axis}", Fraction(0)) for axis in "xy"}
    return not holds(formula(profile, claim), at, actions_at(profile, state, goal, machine))


def check_points(profile, claim, region, semantics, rng, count=40):
    """Every violating point lies in exactly one zone of its goal, every other one in none; returns how many violate."""
    found, seen = violations.violations(Question(Game(profile), claim, region, semantics)), 0
    assert [one.goal for one in found] == list(region.goal_cases) and all(one.complete for one in found)
    zones_of = [[whole_numbers(one.bounds(zone)) for zone in one.zones] for one in found]
    for state in grid_points(rng, region, count):
        at = scaled(state)
        for failing, zones_here in zip(found, zones_of, strict=True):
            fails = fails_at(profile, claim, state, failing.goal, semantics == MACHINE)
            assert sum(contains(bounds, at) for bounds in zones_here) == fails
            seen += fails
    return seen


@pytest.mark.parametrize(
    ("draw", "semantics", "questions", "least", "seed"),
    [
        (lambda rng, _: deception(rng, 3), MACHINE, 24, 60, 21),
        (lambda rng, _: deception(rng, 3), REAL, 24, 60, 21),
        (near_roles, MACHINE, 12, 10, 21),
        *((lambda rng, _: navigation(rng, 2), MACHINE, 3, 10, seed) for seed in (4, 6)),  # of few zones, in each claim
    ],
)
def test_zones_hold_exactly_the_violating_points(profile, draw, semantics, questions, least, seed):
    """Every meaning, sharp thresholds, velocities; regions with equalities, differences and distances: on boundaries
    too.
    """
    rng, seen = np.random.default_rng(seed), 0
    for _ in range(questions):
        asked, claim = draw(rng, profile)
        region = start_region(asked.world) if draw is near_roles else random_region(rng, asked)
        seen += check_points(asked, claim, region, semantics, rng)
    assert seen > least


def test_zones_name_the_leaves_that_the_agents_are_in(same):
    for failing in violations.violations(about(same, CLAIM, everywhere(same))):
        assert failing.agents == ("agent_0", "agent_1")
        for leaves, _ in failing.zones:
            for agent, leaf in zip(failing.agents, leaves, strict=True):
                assert same.policy(agent).tree.feature[leaf] == ir.NO_FEATURE


def test_an_assumption_keeps_zones_inside_it(same):
    right = Linear(((Fraction(-1), "agent_0.x"),), Fraction(0))
    claim = replace(CLAIM, assume=right)
    found = violations.violations(about(same, claim, everywhere(same)))
    assert check_points(same, claim, everywhere(same), MACHINE, np.random.default_rng(1)) > 0
    share = violations.exact_share(about(same, claim, everywhere(same)), found)
    low, high = shares.measure(about(same, claim, everywhere(same)), 3).violating.interval
    assert low <= share.value <= high


# --- shares


def sampled_and_exact(profile, claim, region, seed):
    found = violations.violations(about(profile, claim, region))
    share = violations.exact_share(about(profile, claim, region), found)
    return found, share, shares.measure(about(profile, claim, region), seed, 20_000).violating


def test_exact_shares_lie_in_the_sampled_intervals():
    """Of many random questions about as many as the intervals' level says, and none far outside."""
    rng, inside, asked = np.random.default_rng(25), 0, 0
    for seed in range(40):
        profile, claim = deception(rng, 3)
        region = random_region(rng, profile)
        _, share, sampled = sampled_and_exact(profile, claim, region, seed)
        if sampled.count < 1000:
            continue
        low, high = sampled.interval
        asked += 1
        inside += low <= share.value <= high
        assert low - (high - low) <= share.value <= high + (high - low)
    assert asked > 15 and inside >= 0.9 * asked


def test_shares_of_what_is_known(profile):
    """Two agents that stay violate where not each is at a landmark of its own: an area that can be told by hand."""
    still = team(profile, tree(STAY), tree(UP))
    region = everywhere(still)
    claim = find_property("own_target", still, radius=Fraction(1, 10))
    share = violations.exact_share(about(still, claim, region), violations.violations(about(still, claim, region)))
    # one axis: |a - b| <= r for uniform numbers of [-1, 1]; the second agent also closes when it is below
    near = Fraction(1, 10) - Fraction(1, 400)
    at_first, at_second = near**2, Fraction(1, 2) + near * near / 2
    assert share.value == 1 - at_first * at_second == share.upper
    assert sum(map(sum, share.zones)) == share.least and all(share.zones)


def test_a_region_that_is_flat_in_some_coordinates(same):
    """A fixed goal and a fixed difference: the share is among the states that there are."""
    box = dict(everywhere(same).box) | {"landmark_0.x": (Fraction(1, 2), Fraction(1, 2))}
    fixed = Region(box, ("landmark_0",))
    _, share, sampled = sampled_and_exact(same, CLAIM, fixed, 1)
    low, high = sampled.interval
    assert low <= share.value <= high and 0 < share.value < 1
    joined = replace(fixed, differences=(("agent_0.y", "agent_1.y", (Fraction(1, 4), Fraction(1, 4))),))
    assert set(violations.find_fixed_coordinates(joined)) == {"landmark_0.x", "agent_1.y"}
    thick = replace(joined, differences=(("agent_0.y", "agent_1.y", (Fraction(1, 4), Fraction(2501, 10_000))),))
    flat, near = (sampled_and_exact(same, CLAIM, region, 1)[1].value for region in (joined, thick))
    assert abs(flat - near) < Fraction(1, 1000)


def test_distances_of_a_region_are_made_disjoint(same):
    apart = (("landmark_0", "landmark_1", Fraction(4, 5)), ("agent_0", "agent_1", Fraction(1, 2)))
    region = replace(everywhere(same), apart=apart)
    _, share, sampled = sampled_and_exact(same, CLAIM, region, 5)
    low, high = sampled.interval
    assert low <= share.value <= high
    impossible = replace(everywhere(same), apart=(("agent_0", "agent_1", Fraction(2)),))
    assert sampled_and_exact(same, CLAIM, impossible, 5)[1] == "the region has no volume"


def test_bounds_of_hundreds_of_digits(same):
    """Long denominators, each of its own: the share is that of the rounded bounds, told at every stage."""
    start = everywhere(same)
    question, told = about(same, CLAIM, with_long_bounds(start), max_cells=60), list[str]()
    with listening(lambda done, most, words: told.append(words)):
        found = violations.violations(question)
        share = violations.exact_share(question, found)
    assert found[0].limit == Budgets().max_nodes // SLOWER and found[0].problem.scale.bit_length() > 256
    assert {"search nodes of zones", "volumes of failing cells added up"} <= set(told)
    plain = about(same, CLAIM, start, max_cells=60)
    usual = violations.exact_share(plain, violations.violations(plain))
    assert abs(share.value - usual.value) < Fraction(1, 10**100) and share.value != usual.value
    assert violations.exact_share(question, found, 100) == "it takes more than 3 faces"


# --- features that are off


@pytest.mark.slow
def test_zones_hold_exactly_the_states_that_some_errors_make_fail(profile):
    """Every meaning, thresholds nearer than errors; regions with equalities, differences and distances."""
    rng, seen = np.random.default_rng(31), 0
    for _ in range(25):
        pair, claim = noisy(rng, profile)
        region = random_region(rng, pair)
        found = violations.violations(about(pair, claim, region))
        for state in grid_points(rng, region, 30):
            for failing in found:
                holding = sum(contains(whole_numbers(failing.bounds(zone)), scaled(state)) for zone in failing.zones)
                assert bool(holding) != stands(pair, claim, state, failing.goal)
                seen += bool(holding)
    assert seen > 40


def test_the_region_found_holds_though_features_are_off(same):
    claim, region = DistinctTargets("defenders", eps=Fraction(1, 50)), everywhere(same)
    plain = located(same, replace(claim, eps=Fraction(0)), region)
    found = located(same, claim, region)
    assert found.complete and found.share.exact and found.share.value > plain.share.value
    result = decisions.verify(about(same, claim, found.part.region), {})
    assert result.verdict is Verdict.PROVED and result.evidence.certificate.header.eps == claim.eps
    assert found.part.exact > Fraction(1, 100)


def test_reports_say_that_cells_with_errors_overlap(same, monkeypatch):
    claim, region = DistinctTargets("defenders", eps=Fraction(1, 50)), everywhere(same)
    for parts, exact in ((violations.DEFAULT_PARTS, True), (3, False)):
        monkeypatch.setattr(violations, "DEFAULT_PARTS", parts)
        result = verify_claims([about(same, claim, region)], where=True)[0]
        facts = report.document(same, [result], [""])
        told = facts["results"][0]["where"]
        assert told["overlapping"] == where_report.OVERLAPPING and bool(told["exact"]) == exact
        low, high = result.evidence.where.share.value, result.evidence.where.share.upper
        assert exact or told["between"] == [float(low), float(high)]
        text = report.as_text(facts)
        assert ("of the region violate the claim: zones of different leaves overlap" in text) != exact
        assert where_report.OVERLAPPING in text and where_report.OVERLAPPING in report.as_html(facts)
        assert (json.loads(where_report.zones_json(same, result))["share"] is None) != exact


# --- regions


def teams_to_locate(profile):
    """Teams that violate their claim somewhere, not everywhere."""
    yield profile
    yield team(profile, towards(0, 0), towards(0, 1))
    first, second = switching(0.1)
    wrong = first.action.copy()
    wrong[-1] = UP
    yield team(profile, replace(first, action=wrong), second)


@pytest.mark.parametrize("number", range(3))
def test_the_region_found_is_proved_by_both_engines(profile, number):
    asked = list(teams_to_locate(profile))[number]
    claim, region = find_property("distinct_targets", asked), everywhere(asked)
    found = located(asked, claim, region, name="region-1.toml")
    part = found.part
    assert found.complete and part.region.name == "region-1.toml"
    again = read_region(region_toml(part.region), asked.world, "region-1.toml")
    assert again == part.region
    result = decisions.verify(about(asked, claim, again), {})
    assert result.verdict is Verdict.PROVED and result.evidence.certificate is not None
    assert {opinion.verdict for opinion in result.evidence.opinions} == {Verdict.PROVED}
    assert result.evidence.shares.conflict.hits > 0 and result.evidence.shares.violating.hits == 0
    low, high = part.share.interval
    assert low <= part.exact <= high and part.exact > Fraction(1, 50)
    # no zone of its goals meets the inside of it
    for failing in violations.violations(about(asked, claim, part.region)):
        assert not failing.zones


def test_a_region_inside_a_region_keeps_its_bounds(same):
    gap = (("agent_0.x", "landmark_1.x", (Fraction(-1, 2), Fraction(1, 3))),)
    apart = (("landmark_0", "landmark_1", Fraction(1, 4)),)
    region = replace(everywhere(same), goals=("landmark_1",), differences=gap, apart=apart)
    found = located(same, CLAIM, region)
    assert found.part.region.goals == ("landmark_1",) and found.part.region.apart == apart
    assert all(
        region.box[name][0] <= low and high <= region.box[name][1]
        for name, (low, high) in found.part.region.box.items()
    )
    low, high = next(one[2] for one in found.part.region.differences if one[:2] == gap[0][:2])
    assert low >= Fraction(-1, 2) and high <= Fraction(1, 3)
    assert decide(about(same, CLAIM, found.part.region)).verdict is Verdict.PROVED
    assert found.part.start.value < found.part.share.value


def test_cuts_remove_the_zones_that_they_say(same):
    failing = violations.violations(about(same, CLAIM, everywhere(same)))
    space = obstacles(failing)
    for direction in range(0, len(space.directions), 7):
        at = space.thresholds(space.zones, direction)
        most = int(np.median(at))
        a, b = space.pair(direction)
        kept = 0
        for one in failing:
            for zone in one.zones:
                bounds = one.bounds(zone)
                lower = bounds.get((b, a)) or (bounds[b, ""][0] + bounds["", a][0], False)
                kept += -lower[0] <= Fraction(most, GRID)
        assert len(space.cut_zones(space.zones, direction, most)[0]) == kept


def test_too_many_cells_leave_a_region_inside_a_smaller_one(same):
    """For two agents, and for three with velocities: no state of the region found fails, and both engines prove it."""
    rng, found_for = np.random.default_rng(41), 0
    trios = [navigation(rng, 2) for _ in range(2)]
    for asked, claim in [(same, CLAIM), *trios]:
        question = about(asked, claim, everywhere(asked), max_cells=40)
        found = where.where(question, Verdict.VIOLATED, name="region-1.toml")
        if found.complete or found.part is None:
            continue
        found_for += 1
        assert found.share is None and "more than 40" in found.share_reason and not found.part_reason
        inner = question.within(found.part.region)
        assert decide(inner).verdict is Verdict.PROVED and shares.measure(inner, 3, 5_000).conflict.hits > 0
        for state in grid_points(rng, found.part.region, 60):
            assert not any(fails_at(asked, claim, state, goal) for goal in found.part.region.goal_cases)
        assert found.part.exact is None or 0 < found.part.exact < 1
    assert found_for > 0


# --- what there is to say


def test_a_proved_claim_holds_everywhere(profile):
    roles = team(profile, towards(0, 0), towards(1, 1))
    claim, region = find_property("distinct_targets", roles), everywhere(roles)
    assert located(roles, claim, region, Verdict.PROVED) == where.Where(everywhere=True)
    assert not any(one.zones for one in violations.violations(about(roles, claim, region)))


@pytest.mark.parametrize(
    ("name", "verdict", "reason"),
    [
        ("aligned", Verdict.VIOLATED, where.BEYOND),
        ("assignment", Verdict.VIOLATED, where.BEYOND),
        ("alive_leaves", Verdict.VIOLATED, where.OF_LEAVES),
        ("distinct_targets", Verdict.VACUOUS, "the claim is about no world state of the region"),
    ],
)
def test_what_cannot_be_had_has_its_reason(profile, name, verdict, reason):
    found = located(profile, find_property(name, profile), everywhere(profile), verdict)
    assert found.reason == reason and not found.everywhere and found.part is None


def test_a_budget_of_zones_that_ends_says_so(same):
    region = everywhere(same)
    every = located(same, CLAIM, region)
    few = located(same, CLAIM, region, max_cells=5)
    assert few.count == 5 and not few.complete and few.share is None and few.part is not None
    assert few.share_reason.startswith("not all violating zones are known")
    assert few.share_reason.endswith("there are more than 5; a larger --effort lists more")
    short = located(same, CLAIM, region, max_nodes=60)
    assert short.part_reason.endswith("the search ended after 60 nodes; a larger --effort goes on")
    exactly = located(same, CLAIM, region, max_cells=every.count)
    assert exactly.complete and exactly.share == every.share


def test_a_team_that_always_fails_has_no_region(profile):
    still = team(profile, tree(STAY), tree(STAY))
    claim = find_property("distinct_targets", still, radius=Fraction(0))
    found = located(still, claim, everywhere(still))
    assert found.share.value == 1 and found.part is None and "none both conflicts" in found.part_reason


# --- in words


def test_bounds_in_words_are_all_that_a_zone_needs():
    """With the region's box they imply the zone; regions with fixed coordinates and differences too."""
    rng, seen = np.random.default_rng(31), 0
    for _ in range(20):
        profile, claim = deception(rng, 2)
        region = random_region(rng, profile)
        for failing in violations.violations(about(profile, claim, region)):
            for zone in failing.zones[:5]:
                bounds = failing.bounds(zone)
                names = ["", *failing.problem.places]
                least = {(name, ""): (high, False) for name, (_, high) in region.box.items()}
                least |= {("", name): (-low, False) for name, (low, _) in region.box.items()}
                for name, low, high in where_report._select_bounds(failing, zone, region):
                    a, b = name.split(" - ") if " - " in name else (name, "")
                    least |= {(b, a): (-low[0], low[1])} if low else {}
                    least |= {(a, b): high} if high else {}
                for k, a, b in product(names, repeat=3):
                    if (a, k) in least and (k, b) in least and len({a, b, k}) == 3:
                        most = least[a, k][0] + least[k, b][0], least[a, k][1] or least[k, b][1]
                        least[a, b] = min(least.get((a, b), most), most, key=lambda end: (end[0], not end[1]))
                assert {pair: least[pair] for pair in bounds} == dict(bounds)
                seen += 1
    assert seen > 50


def test_leaves_of_different_agents_are_not_counted_together(profile):
    """A claim that speaks of one agent for one goal and of another for the other."""
    still = team(profile, tree(STAY), tree(STAY))
    goal_0, goal_1 = Goal("landmark_0"), Goal("landmark_1")
    first, second = (engages(still.policy(f"agent_{k}"), f"landmark_{k}", CLAIM) for k in (0, 1))
    stated = And((Or((Not(goal_0), first)), Or((Not(goal_1), second))))
    claim = OwnFormula(CLAIM.team, statement=stated)
    region = everywhere(still)
    result = decisions.verify(about(still, claim, region), {})
    found = located(still, claim, region, result.verdict)
    result = replace(result, evidence=replace(result.evidence, where=found))
    told = where_report.where_facts(still, result)["most"]
    assert [[one["agent"] for one in zone["agents"]] for zone in told] == [["agent_0"], ["agent_1"]]
    assert [zone["goal"] for zone in told] == ["landmark_0", "landmark_1"]


def test_a_region_without_sampled_states_says_so(same):
    """A difference that has one value: there are states and zones, and no draw meets one."""
    flat = (("agent_0.y", "agent_1.y", (Fraction(1, 4), Fraction(1, 4))),)
    found = located(same, CLAIM, replace(everywhere(same), differences=flat))
    assert found.count and 0 < found.share.value < 1
    assert found.part is None and found.part_reason == "no sampled state lies in the region"


def test_of_zones_that_are_not_all_the_file_holds_the_first(same, monkeypatch):
    region = everywhere(same)
    monkeypatch.setattr(where_report, "FIRST", 4)
    result = decisions.verify(about(same, CLAIM, region), {})
    for most, complete in ((9, False), (Budgets().max_cells, True)):
        found = where.where(about(same, CLAIM, region, max_cells=most), result.verdict)
        written = json.loads(
            where_report.zones_json(same, replace(result, evidence=replace(result.evidence, where=found)))
        )
        assert written["complete"] is complete and written["found"] == found.count > 4
        assert len(written["violating"]) == (found.count if complete else 4)


SIDE = 4  # zones lie in a cube of this side, all their bounds integers
# of each simplex of a unit cube (one for each order of the coordinates' fractions) a point: any such zone holds all of
# the simplex, or none of it but edges
POINTS = [
    [4 * corner + part for corner, part in zip(cube, order, strict=True)]  # in quarters
    for cube in product(range(SIDE), repeat=3)
    for order in permutations((1, 2, 3))
]
ENDS = np.array([[0, *point] for point in POINTS])
NODES = 4  # the origin, and three coordinates
CUBE = Problem([NODES], [], [], 1 << 40, EPSILON, {name: (0, k + 1) for k, name in enumerate("xyz")})


def drawn(rng):
    """The cells of a random zone, closed, with some strict bounds; None where it is empty."""
    most = [[0 if a == b else SIDE for b in range(NODES)] for a in range(NODES)]
    for k in range(1, NODES):
        low, high = sorted(rng.choice(SIDE + 1, 2, replace=False).tolist())
        most[k][0], most[0][k] = high, -low
    for _ in range(int(rng.integers(0, 3))):
        a, b = rng.choice(np.arange(1, NODES), 2, replace=False)
        most[a][b] = int(rng.integers(-1, 3))
    cells = [
        [cell * EPSILON - (a != b and rng.random() < 0.3) for b, cell in enumerate(row)] for a, row in enumerate(most)
    ]
    for through, a, b in product(range(NODES), repeat=3):
        cells[a][b] = min(cells[a][b], cells[a][through] + cells[through][b])
    return None if any(cells[a][a] < 0 for a in range(NODES)) else [cell for row in cells for cell in row]


def inside(zone):
    """Which of POINTS a zone holds."""
    gaps = ENDS[:, :, None] - ENDS[:, None, :]
    return (gaps * EPSILON <= 4 * np.array(zone[1]).reshape(NODES, NODES)).all(axis=(1, 2))


def count(zone):
    """The simplices in a zone: six times its volume."""
    return int(inside(zone).sum())


def together(zones):
    return int(np.any([inside(zone) for zone in zones], axis=0).sum())


def test_what_several_zones_hold_is_counted_once_and_nothing_is_lost():
    """Exactly: a part that is lost or counted twice shows however small it is."""
    rng, overlapping, cut = np.random.default_rng(7), 0, 0
    for _ in range(40):
        zones = [((), cells) for cells in (drawn(rng) for _ in range(12)) if cells is not None]
        own = [count(zone) for zone in zones]
        found = union(CUBE, zones, own, {}, count, 10_000)
        wanted = together(zones)
        assert found.least == found.most == wanted
        overlapping += wanted < sum(own)
        cut += found.parts > len(zones)
    assert overlapping > 20 and cut > 10


@pytest.mark.parametrize("budget", [0, 1, 3])
def test_a_spent_budget_leaves_bounds(budget):
    rng = np.random.default_rng(8)
    zones = [((), cells) for cells in (drawn(rng) for _ in range(20)) if cells is not None]
    found = union(CUBE, zones, [count(zone) for zone in zones], {}, count, budget)
    wanted = together(zones)
    assert found.least <= wanted <= found.most and found.least < found.most
