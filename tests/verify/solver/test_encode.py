"""Machine thresholds: the ends of half lines, against the roundings themselves; meanings against the referee."""

import math
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from codegen.errors import InputError
from codegen.ir import Meaning
from codegen.lowering.deploy import deploy_tree
from maviper.worlds import find
from tests.support.meanings import WORLD, asking, meanings, tied_points, with_meanings
from tests.support.strategies import FLOAT32, grown_trees
from tests.support.teams import DOWN, LEFT, RIGHT, STAY, UP, team_in, tree
from verify.claims.decisions import DistinctTargets
from verify.claims.region import Region
from verify.claims.region_files import start_region
from verify.question import Question, from_start
from verify.result import Verdict
from verify.solver.encode import half_line, last_double
from verify.solver.solve import decide
from verify.states.state import inside, violates
from verify.subjects import Game
from verify.verdicts.decisions import verify

NORMAL = FLOAT32.filter(lambda value: value == 0 or abs(value) >= 2.0**-126)


def holds(line, d):
    return d < line.end if line.strict else d <= line.end


@given(NORMAL, st.integers(-3, 3), st.floats(-4, 4))
def test_half_line_is_what_two_roundings_do(threshold, steps, b):
    """For float64 a and b near the end, fl32(fl64(a - b)) <= t iff the exact a - b lies on the half line."""
    assume(abs(threshold) < 1e30)
    line = half_line(threshold, True)
    a = float(line.end + Fraction(b))
    for _ in range(abs(steps)):
        a = math.nextafter(a, math.copysign(math.inf, steps))
    observed = np.float32(np.float64(a) - np.float64(b))
    assert bool(observed <= np.float32(threshold)) == holds(line, Fraction(a) - Fraction(b))


@given(NORMAL, st.integers(-3, 3))
def test_one_rounding_of_a_coordinate(threshold, steps):
    assume(abs(threshold) < 1e38)
    line = last_double(threshold, True)
    z = float(line.end)
    for _ in range(abs(steps)):
        z = math.nextafter(z, math.copysign(math.inf, steps))
    with np.errstate(over="ignore"):
        assert bool(np.float32(z) <= np.float32(threshold)) == holds(line, Fraction(z))


def test_ties_are_decided_by_the_even_significand():
    one, above = np.float32(1), np.nextafter(np.float32(1), np.float32(2))
    tie = (Fraction(float(one)) + Fraction(float(above))) / 2
    assert last_double(1.0, True) == (tie, False)  # 1 is even: the tie rounds to it
    higher = np.nextafter(above, np.float32(2))
    tie = (Fraction(float(above)) + Fraction(float(higher))) / 2
    assert last_double(float(above), True) == (tie, True)


@pytest.mark.solver
def test_float32_theory_agrees_with_the_half_line():
    """Z3's own floating-point theory, which shares nothing with our arithmetic, at a few thresholds."""
    import z3

    mode = z3.RNE()
    d = z3.FP("d", z3.Float64())
    for threshold in (0.0, 0.1, -0.3, 1.0, float(np.nextafter(np.float32(1), np.float32(2)))):
        single = z3.fpFPToFP(mode, d, z3.Float32())
        line = last_double(float(np.float32(threshold)), True)
        end = float(line.end)
        assert Fraction(end) == line.end
        bound = z3.FPVal(end, z3.Float64())
        ours = z3.fpLT(d, bound) if line.strict else z3.fpLEQ(d, bound)
        theirs = z3.fpLEQ(single, z3.FPVal(float(np.float32(threshold)), z3.Float32()))
        solver = z3.Solver()
        solver.add(z3.Not(z3.fpIsNaN(d)), ours != theirs)
        assert solver.check() == z3.unsat, threshold


# --- every kind of meaning: what the solver is asked, against the referee, who observes and decides like the machine


CLAIM = DistinctTargets("defenders")
BACK = "agent_0"


@pytest.mark.solver
@pytest.mark.parametrize("kind", range(14))
def test_each_meaning_at_each_threshold_against_the_referee(kind):
    """At, between and beyond the values that signs and 0-or-1 features take."""
    assert len(meanings(BACK)) == 14
    beside = [float(np.nextafter(np.float32(end), np.float32(way))) for end in (-1, 1) for way in (-9, 9)]
    violated = []
    for place, threshold in enumerate([-2.0, -1.0, -0.5, -0.0, 0.0, 0.25, 0.5, 1.0, 2.0, *beside, 2.0**-126]):
        for low, high in ((LEFT, RIGHT), (DOWN, UP)):
            profile = with_meanings({BACK: tree((kind, threshold, 1, 2), low, high), "agent_1": tree(UP)})
            asked = asking(profile, CLAIM)
            for state in tied_points(4, seed=100 * kind + place):
                violated.append(violates(from_start(profile, CLAIM), state))
                assert asked(state) == violated[-1], (threshold, state)
    assert 0.1 < np.mean(violated) < 0.98


@pytest.mark.solver
@settings(max_examples=30)
@given(grown_trees(n_features=14, max_depth=3), grown_trees(n_features=14, max_depth=3), st.integers(0, 999))
def test_trees_over_all_meanings_against_the_referee(first, second, seed):
    trees = {BACK: deploy_tree(first), "agent_1": deploy_tree(second)}
    assume(not any(((t.threshold != 0) & (np.abs(t.threshold) < 2.0**-126)).any() for t in trees.values()))
    profile = with_meanings(trees)
    asked, asked_more = asking(profile, CLAIM), asking(profile, CLAIM, Fraction(1, 16))
    for state in tied_points(15, seed):
        wrong = violates(from_start(profile, CLAIM), state)
        assert asked(state) == wrong, state
        assert wrong or not asked_more(state), "a stronger question has more answers"


def sideways(sign):
    """Goes to landmark 0 along x, by whether it is to the right; where it is on neither side, up or left."""
    feature = meanings(BACK).index(Meaning(((1, "landmark_0.x"), (-1, f"{BACK}.x")), "sign" if sign else "positive"))
    if sign:
        return tree((feature, -0.5, 1, 2), LEFT, (feature, 0.5, 3, 4), UP, RIGHT)
    return tree((feature, 0.5, 1, 2), LEFT, RIGHT)


@pytest.mark.solver
@pytest.mark.parametrize("sign", [True, False])
@pytest.mark.smoke
def test_verdicts_that_hang_on_a_single_value(sign):
    """The agent misses its target only where it is exactly below it, or above: a state that no sample meets."""
    across = Region(start_region(WORLD.spec).box | {"agent_1.y": (Fraction(-2), Fraction(-2))}, ("landmark_0",))
    apart = replace(across, apart=((BACK, "landmark_0", Fraction(1, 2)),))
    second = tree(UP)  # closes on both
    profile = with_meanings({BACK: sideways(sign), "agent_1": second})
    found = verify(Question(Game(profile), CLAIM, apart), {})
    assert found.verdict is Verdict.VIOLATED and found.evidence.shares.violating.hits == 0
    state = found.evidence.counterexample.state
    assert state.position[f"{BACK}.x"] == state.position["landmark_0.x"] and violates(from_start(profile, CLAIM), state)
    assert inside(apart, state)
    # on one side of the target nothing is left to refute
    for low, high in ((Fraction(1, 1000), Fraction(2)), (Fraction(-2), Fraction(-1, 1000))):
        side = replace(apart, differences=((f"{BACK}.x", "landmark_0.x", (low, high)),))
        assert decide(Question(Game(profile), CLAIM, side)).verdict is Verdict.PROVED


@pytest.mark.solver
@pytest.mark.parametrize(("threshold", "reached"), [(0.0, 0), (-0.0, 0), (0.5, 0), (-0.5, 1), (-(2.0**-126), 1)])
def test_what_is_always_nought_takes_one_branch(threshold, reached):
    """A feature without terms: the other branch may do what it likes."""
    still = {BACK: tree(STAY), "agent_1": tree(UP)}
    region = start_region(WORLD.spec)
    box = dict.fromkeys(region.box, (Fraction(0), Fraction(0))) | {"agent_1.y": (Fraction(-2), Fraction(-2))}
    box |= {f"landmark_{k}.x": (Fraction(1), Fraction(2)) for k in (0, 1)}
    here = Region(box, ("landmark_0",))
    assert decide(Question(Game(with_meanings(still)), CLAIM, here)).verdict is Verdict.VIOLATED
    for good, verdict in ((1 - reached, Verdict.VIOLATED), (reached, Verdict.PROVED)):
        actions = [STAY, STAY]
        actions[good] = RIGHT
        profile = with_meanings(still | {BACK: tree((0, threshold, 1, 2), *actions)})
        assert decide(Question(Game(profile), CLAIM, here)).verdict is verdict


@pytest.mark.solver
def test_navigation_is_verified_like_deception():
    """Three agents, no goal, words that are always 0; velocities are refused, for a region does not bound them."""
    world = find("cooperative-navigation")
    claim = DistinctTargets("agents")
    names = [[feature.name for feature in features] for features in world.features]

    def profile(*trees):
        return team_in(world, trees)

    def roles(k):
        dx, dy = names[k].index(f"landmark_{k}_dx"), names[k].index(f"landmark_{k}_dy")
        word = names[k].index(f"agent_{(k + 1) % 3}_word1")
        return tree(
            (word, 0.0, 1, 8), (dx, -0.05, 2, 3), LEFT, (dx, 0.05, 4, 7), (dy, 0.0, 5, 6), DOWN, UP, RIGHT, STAY
        )

    region = start_region(world.spec)
    assert (
        region.goals == ()
        and decide(Question(Game(profile(*map(roles, range(3)))), claim, region)).verdict is Verdict.PROVED
    )
    lost = verify(Question(Game(profile(roles(0), roles(1), roles(1))), claim, region), {})
    assert lost.verdict is Verdict.VIOLATED
    assert violates(from_start(profile(roles(0), roles(1), roles(1)), claim), lost.evidence.counterexample.state)
    fast = tree((names[0].index("vx"), 0.0, 1, 2), LEFT, RIGHT)
    with pytest.raises(InputError, match=r"observes agent_0\.vx, which regions cannot bound"):
        decide(Question(Game(profile(fast, roles(1), roles(2))), claim, region))
