"""Regions of world files about games: where half spaces hold the goal."""

from fractions import Fraction

from maviper.worlds.stated.observing import PLACE, find_goal
from verify.systems.system import Affine, HalfSpace


def at_most(one, other, most=0):
    """That one coordinate is at most another, and so much more."""
    form = Affine.of({one: Fraction(1)}).plus(Affine.of({other: Fraction(1)}), Fraction(-1))
    return HalfSpace(form.plus(Affine((), Fraction(-most))))


def equal(one, other):
    return [at_most(one, other), at_most(other, one)]


def test_the_goal_is_at_the_landmark_that_it_equals_along_both_axes():
    x, y = (f"{PLACE}.{axis}" for axis in "xy")
    near = [at_most(x, "landmark_0.x", 1), at_most("landmark_0.x", x, 1), *equal(y, "landmark_0.y")]
    held = [*equal(x, "landmark_1.x"), *equal("landmark_1.y", y)]
    assert find_goal((*near, *held)) == "landmark_1"
    assert find_goal(tuple(near)) is None and find_goal(tuple(held[:3])) is None and find_goal(()) is None
    assert find_goal((*held[:2], *equal(y, "landmark_0.y"))) is None
