"""Claims about episodes: verdicts against simulation, Z3 and known teams; courses that replay bit for bit."""

from dataclasses import replace
from fractions import Fraction

import pytest
import z3
from hypothesis import given, settings
from hypothesis import strategies as st

from codegen import ir
from codegen.errors import InputError, UnknownNameError
from maviper.worlds import PhysicalDeception
from tests.support.episode_cases import arriving, centred, grown_pair, lost, verdicts_wrong
from tests.support.episode_certificates import failures, replays_of
from tests.support.strategies import grown_trees, with_trees
from tests.support.teams import LEFT, RIGHT, STAY, UP, team, team_in, towards, tree
from verify.claims.catalogue import find_claim
from verify.claims.region import Region
from verify.claims.region_files import everywhere
from verify.claims.wording import account_of
from verify.episodes.composition import decide
from verify.question import Budgets, Question
from verify.result import Verdict
from verify.solver.terms import half_line
from verify.states.episodes import find_matchings
from verify.states.state import inside
from verify.subjects import Game
from verify.verdicts.episodes import verify_episodes

pytestmark = [pytest.mark.solver, pytest.mark.usefixtures("few_states_throughout")]

AXES = "xy"


@pytest.fixture
def arrivers(profile):
    return team(profile, arriving(0), arriving(1))


# --- teams whose answers are known


def test_a_team_that_arrives_is_proved_from_everywhere_agent_by_agent(arrivers):
    claim = find_claim("reaches", arrivers)
    result = verify_episodes(Question(Game(arrivers), claim, everywhere(arrivers)), {})
    assert result.verdict is Verdict.PROVED
    assert result.evidence.followed == (("agent_0",), ("agent_1",))
    assert result.evidence.control.verdict is Verdict.VIOLATED
    assert result.evidence.violating.hits == 0 and result.evidence.idle.value < 0.03
    assert failures(arrivers, claim, result.region, 10_000, 1) == 0


@pytest.mark.smoke
def test_heading_is_not_arriving(profile):
    """This team satisfies own_target everywhere, but swings to and fro in x."""
    swinging = team(profile, towards(0, 0), towards(1, 1))
    for name in ("reaches", "covers"):
        question = Question(Game(swinging), find_claim(name, swinging), everywhere(swinging))
        assert decide(question).verdict is Verdict.VIOLATED


def test_matchings_are_what_is_asked(arrivers):
    crossed = find_claim("reaches", arrivers, landmarks=["landmark_1", "landmark_0"])
    assert decide(Question(Game(arrivers), crossed, everywhere(arrivers))).verdict is Verdict.VIOLATED
    swapped = team(arrivers, arriving(1), arriving(0))
    assert decide(Question(Game(swapped), crossed, everywhere(swapped))).verdict is Verdict.PROVED
    assert "landmark_1, landmark_0" in account_of(crossed).sentence


def test_a_violation_that_sampling_misses_is_found_by_zones(arrivers):
    """agent_0 stands still where its landmark lies in a strip 2e-6 wide."""
    late = tree((2, -0.5, 1, 2), LEFT, (2, 0.7, 3, 4), STAY, (2, 0.700002, 5, 6), STAY, RIGHT)
    on_axis = centred(arrivers, Fraction(0), {"landmark_0": (0, 0), "landmark_1": (0, 0), "agent_1": (0, 0)})
    box = dict(on_axis.box) | {"agent_0.x": (Fraction(-1), Fraction("-0.7000001")), "agent_0.y": (Fraction(0),) * 2}
    claim = find_claim("reaches", arrivers)
    sliver = team(arrivers, late, tree(STAY))
    result = verify_episodes(Question(Game(sliver), claim, replace(on_axis, box=box)), {})
    assert result.evidence.violating.hits == 0 and result.cost.spent > 0
    assert result.verdict is Verdict.VIOLATED
    assert Fraction("-0.70001") < Fraction(result.evidence.state.position["agent_0.x"]) <= Fraction("-0.7000001")


# --- the first steps


def test_nobody_moves_before_the_second_next_state(profile):
    runner = team(profile, tree(RIGHT), tree(STAY))
    places = {"agent_0": (0, 0), "landmark_0": (0.4375, 0), "agent_1": (0, 0), "landmark_1": (0, 0)}
    region = centred(runner, Fraction(0), places)
    verdicts = [
        decide(Question(Game(runner), find_claim("reaches", runner, steps=steps), region)).verdict for steps in range(4)
    ]
    # 0.05 after the second step is the first that it comes
    assert verdicts == [Verdict.VIOLATED, Verdict.VIOLATED, Verdict.PROVED, Verdict.PROVED]


@pytest.mark.parametrize("steps", [0, 1])
def test_without_moves_a_claim_is_one_about_starts(profile, steps):
    for half, wanted in ((Fraction(19, 100), Verdict.PROVED), (Fraction(21, 100), Verdict.VIOLATED)):
        names = ("agent_0", "agent_1", "landmark_0", "landmark_1")
        region = centred(profile, half, dict.fromkeys(names, (0, 0)))
        for name in ("reaches", "covers"):
            assert decide(Question(Game(profile), find_claim(name, profile, steps=steps), region)).verdict is wanted


# --- against simulation


@pytest.mark.parametrize("steps", [2, 5])
@pytest.mark.parametrize("trees", [(towards(0, 0), towards(1, 1)), (arriving(0), arriving(1)), (arriving(0), tree(UP))])
def test_against_unrolling_by_z3(profile, trees, steps):
    played = team(profile, *trees)
    for half, radius in ((Fraction(1, 4), Fraction(2, 5)), (Fraction(1, 8), Fraction(7, 10))):
        names = ("agent_0", "agent_1", "landmark_0", "landmark_1")
        region = centred(played, half, dict.fromkeys(names, (0.25, 0)), ("landmark_0",))
        for name in ("reaches", "covers"):
            claim = find_claim(name, played, steps=steps, radius=radius)
            wanted = Verdict.VIOLATED if unrolled(played, claim, region, "landmark_0") else Verdict.PROVED
            assert decide(Question(Game(played), claim, region)).verdict is wanted


@settings(max_examples=40)
@given(grown_trees(max_depth=3), grown_trees(max_depth=3), st.integers(0, 7), st.booleans())
def test_every_start_lies_in_a_zone_that_moves_as_it_does(profile, first, second, steps, ties):
    """Also agents that read each other and the adversary, and starts on which thresholds tie."""
    random = grown_pair(profile, first, second, ties)
    assert lost(random, steps, steps, 100, 0.125 if ties else None, budget=50_000) in (0, None)


@pytest.mark.parametrize("lattice", [None, 0.125])
def test_starts_keep_their_zones_over_whole_episodes(profile, arrivers, lattice):
    for played in (arrivers, team(profile, towards(0, 0), towards(1, 1))):
        for agent in ("agent_0", "agent_1"):
            assert lost(played, 25, 5, 200, lattice, (agent,)) == 0


def test_known_verdicts(profile):
    assert not verdicts_wrong(profile)


# --- who is followed


def test_the_adversary_may_do_anything(profile):
    """A tree that flees from the adversary: proved where both ways arrive, else about the profile's own adversary."""
    shy = tree((6, 0.0, 1, 2), RIGHT, UP)
    pair = with_trees({"agent_0": shy, "agent_1": tree(STAY), "adversary_0": tree(STAY)}, profile)
    places = {"agent_0": (0, 0), "landmark_0": (0.3, 0.3), "agent_1": (0, 0), "landmark_1": (0, 0)}
    region = centred(pair, Fraction(1, 100), places)
    claim = find_claim("reaches", pair, steps=6)
    free = decide(Question(Game(pair), claim, region))
    assert free.verdict is Verdict.PROVED and free.followed == (("agent_0",), ("agent_1",))
    # the profile's own adversary stays on the right, so agent_0 only ever goes up; another one could make it go right
    far = find_claim("reaches", pair, steps=12, radius=Fraction(1, 5))
    above = centred(pair, Fraction(1, 100), {**places, "landmark_0": (0, 0.5)})
    right = replace(above, box={**above.box, "adversary_0.x": (Fraction(1, 2), Fraction(1))})
    assert failures(pair, far, right, 1_000, 0) == 0
    found = decide(Question(Game(pair), far, right))
    assert found.verdict is Verdict.PROVED and ("adversary_0", "agent_0", "agent_1") in found.followed
    assert decide(Question(Game(pair), far, right, budgets=Budgets(max_zones=500))).verdict is Verdict.UNKNOWN
    left = replace(above, box={**above.box, "adversary_0.x": (Fraction(-1), Fraction(-1, 2))})
    assert decide(Question(Game(pair), far, left)).verdict is Verdict.VIOLATED


def test_goals_are_told_apart(profile):
    """agent_0 runs to the goal: right when landmark_0 is the goal, wrong when landmark_1 is."""
    seeker = tree((0, 0.0, 1, 2), LEFT, RIGHT)
    pair = team(profile, seeker, tree(STAY))
    places = {"agent_0": (0, 0), "landmark_0": (0.8, 0), "agent_1": (-0.8, 0), "landmark_1": (-0.8, 0)}
    region = centred(pair, Fraction(1, 100), places)
    claim = find_claim("reaches", pair, steps=10)
    assert decide(Question(Game(pair), claim, replace(region, goals=("landmark_0",)))).verdict is Verdict.PROVED
    found = decide(Question(Game(pair), claim, region))
    assert found.verdict is Verdict.VIOLATED and found.state.goal == "landmark_1"


# --- budgets, regions, refusals, replays


def test_a_spent_budget_is_unknown_with_the_same_count(arrivers):
    question = Question(Game(arrivers), find_claim("reaches", arrivers), everywhere(arrivers))
    found = [decide(question.spending(max_zones=500)) for _ in range(2)]
    assert found[0] == found[1]
    assert found[0].verdict is Verdict.UNKNOWN and "--effort" in found[0].reason and found[0].zones <= 500


def test_empty_regions_are_vacuous(arrivers):
    start = everywhere(arrivers)
    claim = find_claim("reaches", arrivers)
    apart = replace(start, apart=(("agent_0", "agent_1", Fraction(5)),))
    assert verify_episodes(Question(Game(arrivers), claim, apart), {}).verdict is Verdict.VACUOUS
    differing = replace(start, differences=(("agent_0.x", "agent_1.x", (Fraction(3), Fraction(4))),))
    assert decide(Question(Game(arrivers), claim, differing)).verdict is Verdict.VACUOUS
    moving = replace(start, box={**start.box, "agent_0.vx": (Fraction(1), Fraction(2))})
    assert decide(Question(Game(arrivers), claim, moving)).verdict is Verdict.VACUOUS


def test_regions_with_differences_and_distances(profile):
    """Agents that stand still have arrived exactly where the region says so."""
    still = team(profile, tree(STAY), tree(STAY))
    start = everywhere(still)
    near = (Fraction(-2, 5), Fraction(2, 5))
    pairs = [(f"agent_{number}.{axis}", f"landmark_{number}.{axis}") for number in range(2) for axis in AXES]
    close = replace(start, differences=tuple((a, b, near) for a, b in pairs))
    claim = find_claim("reaches", still, steps=3)
    tight = replace(close, differences=tuple((a, b, (near[0] / 2, near[1] / 2)) for a, b in pairs))
    assert decide(Question(Game(still), claim, tight)).verdict is Verdict.PROVED
    apart = replace(tight, apart=(("agent_0", "agent_1", Fraction(1, 2)), ("landmark_0", "landmark_1", Fraction(1, 5))))
    assert decide(Question(Game(still), claim, apart)).verdict is Verdict.PROVED
    wide = replace(close, differences=tuple((a, b, (near[0], Fraction(1, 2))) for a, b in pairs))
    found = decide(Question(Game(still), claim, wide))
    assert found.verdict is Verdict.VIOLATED and inside(wide, found.state)
    off = replace(start, apart=(("agent_0", "landmark_0", Fraction(1, 2)),))
    assert decide(Question(Game(still), claim, off)).verdict is Verdict.VIOLATED


def test_the_edge_itself_is_left_open_or_refuted_never_proved(profile):
    """Standing exactly at the radius counts as arrived for the referee; the relaxed zones cannot say so."""
    still = team(profile, tree(STAY), tree(STAY))
    places = {"agent_0": (0, 0), "landmark_0": (0.5, 0), "agent_1": (0, 0), "landmark_1": (0, 0)}
    region = centred(still, Fraction(0), places)
    found = decide(Question(Game(still), find_claim("reaches", still, radius=Fraction(1, 2)), region))
    assert found.verdict is Verdict.UNKNOWN and "at starts that are not float64" in found.reason


def test_courses_equal_simulator_compiled_c_and_mpe2(profile):
    """Whole courses bit by bit, from a violation found by zones and beyond the usual length."""
    swinging = team(profile, towards(0, 0), towards(1, 1))
    for steps in (25, 40):
        claim = find_claim("reaches", swinging, steps=steps)
        with replays_of(swinging) as replays:
            assert {"simulator", "mpe2.simple_adversary_v3"} <= set(replays)
            result = verify_episodes(Question(Game(swinging), claim, everywhere(swinging)), replays)
        assert result.verdict is Verdict.VIOLATED
        assert len(result.evidence.ways[0].places) == steps + 1 and len(result.evidence.ways[0].actions) == steps


def test_speed_limits_and_observed_velocities(profile):
    """A spec with a speed limit and trees that observe their velocity: play and zones agree."""
    world = PhysicalDeception(velocity=1)
    braking = tree((10, 0.3, 1, 2), RIGHT, STAY)  # accelerates up to a speed
    found = team_in(world, [braking if name == "agent_0" else tree(STAY) for name in world.agents])
    agents = tuple(replace(entity, max_speed=0.4) for entity in world.spec.agents)
    limited = replace(found, world=replace(world.spec, agents=agents))
    assert limited.policy("agent_0").features[10].name == "vx"
    places = {"agent_0": (0, 0), "landmark_0": (0.9, 0), "agent_1": (0, 0), "landmark_1": (0, 0)}
    region = centred(limited, Fraction(1, 100), places)
    verdicts = []
    for steps in range(14, 22):
        claim = find_claim("reaches", limited, steps=steps)
        verdicts.append(decide(Question(Game(limited), claim, region)).verdict)
        assert (failures(limited, claim, region, 500, 1) > 0) >= (verdicts[-1] is not Verdict.PROVED)
    assert verdicts[0] is Verdict.VIOLATED and verdicts[-1] is Verdict.PROVED


def test_what_cannot_be_asked_is_refused(profile):
    with pytest.raises(UnknownNameError, match="reaches"):
        find_claim("reach", profile)
    with pytest.raises(InputError, match="steps must be"):
        find_claim("reaches", profile, steps=1_001)
    with pytest.raises(InputError, match="radius must be"):
        find_claim("reaches", profile, radius=Fraction(-1))
    with pytest.raises(InputError, match="different landmark"):
        find_claim("reaches", profile, landmarks=["landmark_0", "landmark_0"])
    huge = Region(dict.fromkeys(everywhere(profile).box, (Fraction(-(10**6)), Fraction(10**6))), ("landmark_0",))
    with pytest.raises(InputError, match="rounding over 25 steps"):
        decide(Question(Game(profile), find_claim("reaches", profile), huge))


def number(value):
    return z3.RealVal(f"{value.numerator}/{value.denominator}")


def unrolled(profile, claim, region, goal, limit=0):
    """Whether an episode from `region` violates the claim, by one query over all steps; None after `limit` ms.

    Positions and velocities of each step are variables; trees are nested conditions on positions, over the reals.
    Agents of other teams stand still.
    """
    solver = z3.SolverFor("QF_LRA")
    if limit:
        solver.set("timeout", limit)
    world = profile.world
    entities = [entity.name for entity in world.agents + world.landmarks]
    place = {f"{name}.{axis}": z3.Real(f"{name}.{axis}") for name in entities for axis in "xy"}
    for name, variable in place.items():
        low, high = region.box[name]
        solver.add(variable >= number(low), variable <= number(high))
    speed = {f"{entity.name}.{axis}": number(Fraction(0)) for entity in world.agents for axis in "xy"}
    team, forces = profile.team(claim.team), {entity.name: Fraction(entity.force) for entity in world.agents}
    course = [place]
    dt, kept = Fraction(world.dt), 1 - Fraction(world.damping)
    for step in range(claim.steps):
        following, faster = dict(place), dict(speed)
        for policy in team:
            pushes = _pushes(policy, place, goal)
            for axis, push in zip("xy", pushes, strict=True):
                name = f"{policy.agent}.{axis}"
                following[name], faster[name] = z3.Reals(f"{name}@{step + 1} {name}'@{step + 1}")
                solver.add(following[name] == place[name] + number(dt) * speed[name])
                solver.add(faster[name] == number(kept) * speed[name] + number(dt * forces[policy.agent]) * push)
        place, speed = following, faster
        course.append(place)
    steps = course if claim.name == "reaches" else course[-1:]
    landmarks = [landmark.name for landmark in world.landmarks]
    ways = [
        z3.And(
            *(
                z3.Or(*(_at(now, policy.agent, landmarks[own], claim.radius) for now in steps))
                for policy, own in zip(team, matching, strict=True)
            )
        )
        for matching in find_matchings(profile, claim)
    ]
    solver.add(z3.Not(z3.Or(*ways)))
    answer = solver.check()
    return None if answer == z3.unknown else answer == z3.sat


def _at(place, agent, landmark, radius):
    gaps = [place[f"{agent}.{axis}"] - place[f"{landmark}.{axis}"] for axis in "xy"]
    return z3.And(*(side for gap in gaps for side in (gap <= number(radius), gap >= number(-radius))))


def _pushes(policy, place, goal):
    """The direction that a tree chooses, per axis, as nested conditions."""
    tree, found = policy.tree, {}
    at = {**place, **{f"goal.{axis}": place[f"{goal}.{axis}"] for axis in "xy"}}
    for node in reversed(range(len(tree.feature))):
        if tree.feature[node] == ir.NO_FEATURE:
            effect = policy.actions[tree.action[node]].effect
            found[node] = [number(Fraction(part)) for part in effect]
            continue
        terms = policy.features[tree.feature[node]].meaning.terms
        measured = z3.Sum(*(weight * at[name] for weight, name in terms))
        line = half_line(float(tree.threshold[node]), True)
        below = measured < number(line.end) if line.strict else measured <= number(line.end)
        sides = zip(found[int(tree.left[node])], found[int(tree.right[node])], strict=True)
        found[node] = [z3.If(below, left, right) for left, right in sides]
    return found[ir.ROOT]
