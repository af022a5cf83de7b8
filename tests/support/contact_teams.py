"""What several tests use of `verify.episodes.test_contacts`."""

from fractions import Fraction

from tests.support.contacts import played
from tests.support.teams import DOWN, LEFT, RIGHT, UP, tree

SPREAD, TAG = "cooperative-navigation", "predator-prey"
HALF = Fraction(1, 40)


def going(*actions, name=SPREAD):
    return played(name, [tree(action) for action in actions])


def homing(k):
    """Goes to landmark k of cooperative navigation: first in y while that is far, then in x, then in y."""
    dx, dy = 4 + 2 * k, 5 + 2 * k
    return tree(
        (dy, -0.8, 1, 2), DOWN, (dy, 0.8, 3, 10), (dx, -0.3, 4, 5), LEFT, (dx, 0.3, 6, 9), (dy, 0.0, 7, 8), DOWN, UP,
        RIGHT, UP,
    )  # fmt: skip


HOMING = played(SPREAD, [homing(k) for k in range(3)])
LANES = [(-0.8, -0.8), (0, -0.8), (0.8, -0.8), (-0.8, 0.8), (0, 0.8), (0.8, 0.8)]
