"""Bounds of a question: what they say at points is what the formulas say there, and their numbers keep their order."""

from dataclasses import replace
from fractions import Fraction as F
from itertools import product

import numpy as np
import pytest

from tests.support.small import small_profile
from tests.support.teams import LEFT, RIGHT, tree
from tests.support.zone_cases import deception, exactly_inside, grid_points, random_region
from verify.claims.decisions import formula
from verify.claims.formula import And, Linear, Or, atoms, below, conjunction, for_goal, holds
from verify.claims.region import Region
from verify.kinds import REAL
from verify.zones.tables import (
    EPSILON,
    BeyondZonesError,
    NodeKnown,
    Table,
    find_barred_sides,
    infinite,
    problem,
    split_sides,
    zone_tree,
)

BOX = {"a.x": (F(-1), F(1)), "b.x": (F(-1), F(1)), "c.x": (F(-1), F(1))}
NAMES = tuple(BOX)


def table(claim=None, profile=None, region=None, goal=None):
    return Table(profile or small_profile(), claim or conjunction(), region or Region(BOX, ()), goal)


def said(flat, bounds, at):
    """Whether bounds and choices hold at a point; None is false."""
    if flat is None:
        return False
    values = {"": F(0), **at}
    gaps = [(bounds[n], values[bounds[n].upper] - values[bounds[n].lower]) for n in flat.edges]
    met = all(gap < bound.most if bound.strict else gap <= bound.most for bound, gap in gaps)
    return met and all(any(said(part, bounds, at) for part in choice) for choice in flat.ors)


def random_formula(rng, depth):
    if depth and rng.random() < 0.7:
        parts = tuple(random_formula(rng, depth - 1) for _ in range(int(rng.integers(0, 4))))
        return (And, Or)[int(rng.integers(2))](parts)
    first, second = (str(name) for name in rng.choice(NAMES, 2, replace=False))
    weight = F(int(rng.choice([-2, -1, 1, 3])), 2)
    terms = ((weight, first),) if rng.random() < 0.4 else ((weight, first), (-weight, second))
    return Linear(terms, F(int(rng.integers(-4, 5)), 4), bool(rng.random() < 0.5))


@pytest.mark.parametrize("seed", range(30))
def test_a_formula_without_actions_holds_where_its_bounds_do(seed):
    rng = np.random.default_rng(seed)
    asked, made = random_formula(rng, 3), table()
    flat = made.side(asked)
    bounds = list(made.numbers)
    for values in product([F(n, 4) for n in (-4, -2, -1, 0, 1, 3)], repeat=3):
        at = dict(zip(NAMES, values, strict=True))
        assert said(flat, bounds, at) == holds(asked, at, {}), (asked, at)


@pytest.mark.parametrize("seed", range(8))
def test_region_and_denial_say_what_region_and_claim_say(seed):
    """For every goal and joint action: the denied claim given these actions, at points in and beside the region."""
    rng = np.random.default_rng(seed)
    profile, claim = deception(rng, 1)
    asked, region = formula(profile, claim), random_region(rng, profile)
    wide = Region({name: (F(-1), F(1)) for name in region.box}, region.goals)
    points = [*grid_points(rng, region, 3), *grid_points(rng, wide, 3)]
    for goal in region.goal_cases:
        made = Table(profile, for_goal(asked, goal), region, goal)
        names = [policy.agent for policy in made.policies]
        for actions in product(range(5), repeat=len(names)):
            denial = made.denial([NodeKnown(action, 0) for action in actions])
            bounds = list(made.numbers)
            for at in points:
                full = at | {f"goal.{axis}": at[f"{goal}.{axis}"] for axis in "xy" if goal}
                assert said(made.region, bounds, at) == exactly_inside(region, at)
                assert said(denial, bounds, at) != holds(
                    for_goal(asked, goal), full, dict(zip(names, actions, strict=True))
                )


def test_a_claim_about_nobodys_action_is_denied_by_its_opposite_bound():
    made = Table(small_profile(), Or((below({"agent_0.x": 1}, 0),)), Region({"agent_0.x": (F(-1), F(1))}, ()), None)
    assert not made.policies
    (number,) = made.denial([]).edges
    assert list(made.numbers)[number][:2] == ("", "agent_0.x") and list(made.numbers)[number].strict


@pytest.mark.parametrize("terms", [{"a.x": 1, "b.x": 1}, {"a.x": 1, "b.x": -2}, {"a.x": 1, "b.x": -1, "c.x": 1}])
def test_what_bounds_no_difference_is_beyond_zones(terms):
    with pytest.raises(BeyondZonesError):
        table().atom(Linear(tuple((F(weight), name) for name, weight in terms.items()), F(0)))


def test_a_sum_in_which_all_cancels_is_true_or_false():
    made = table()
    nothing = ((F(1), "a.x"), (F(-1), "a.x"))
    for bound, strict in product((F(-1), F(0), F(1)), (False, True)):
        found = made.atom(Linear(nothing, bound, strict))
        assert (found is not None) == (bound > 0 or (bound == 0 and not strict))
        assert found is None or found.edges == ()


def test_numbers_keep_each_bound_and_its_strictness():
    rng = np.random.default_rng(7)
    made = table()
    for _ in range(60):
        for atom in atoms(random_formula(rng, 2)):
            made.atom(atom, bool(rng.random() < 0.5))
    found = problem(made)
    for bound, (component, upper, lower), weight in zip(made.numbers, found.edges, found.weights, strict=True):
        assert F(weight + bound.strict, found.scale) == bound.most
        for name, node in ((bound.upper, upper), (bound.lower, lower)):
            assert (component, node) == (found.places[name] if name else (component, 0))
    assert found.scale % EPSILON == 0
    assert found.infinite > sum(map(abs, found.weights[: max(found.sizes)]))
    assert len(set(found.places.values())) == len(found.places) and sum(found.sizes) == len(NAMES) + len(found.sizes)


def test_coordinates_that_never_meet_are_in_different_components():
    made = table(region=Region(BOX, (), (("a.x", "b.x", (F(0), F(1))),)))
    found = problem(made)
    where = {name: component for name, (component, _) in found.places.items()}
    assert where["a.x"] == where["b.x"] != where["c.x"] and sorted(found.sizes) == [2, 3]


def test_infinite_is_beyond_every_path():
    assert infinite([1], []) > 0
    assert infinite([3, 5], [-7, 2]) > 5 * 7


def test_sides_that_tests_above_leave_empty_are_barred():
    """landmark_0_dx <= 0.5, and below it again at -0.5 and 0.75: nothing above 0.75 comes to the left side's right."""
    again = tree((2, 0.5, 1, 6), (2, 0.75, 2, 5), (2, -0.5, 3, 4), LEFT, RIGHT, LEFT, (2, 0.5, 7, 8), LEFT, RIGHT)
    policy = replace(small_profile().policy("agent_0"), tree=again, grown=None)
    splits = split_sides(policy, REAL)
    assert set(splits) == {(2, 0.5), (2, 0.75), (2, -0.5)}
    barred = find_barred_sides(policy, splits)
    assert barred == {(1, 1), (6, 0)}
    made = table(region=Region({n: (F(-1), F(1)) for n in ("agent_0.x", "landmark_0.x")}, ()))
    sides = zone_tree(made, policy, splits, barred).sides
    assert sides[1][1] is None and sides[6][0] is None
    assert all(flat is not None for node in (0, 2) for flat in sides[node])
    assert sides[3] == (None, None), "a leaf"
