"""What several tests use of `verify.episodes.test_contacts`."""

from fractions import Fraction

from tests.support.contacts import played
from tests.support.episode_cases import arriving
from tests.support.teams import tree

SPREAD, TAG = "cooperative-navigation", "predator-prey"
HALF = Fraction(1, 40)


def going(*actions, name=SPREAD):
    return played(name, [tree(action) for action in actions])


HOMING = played(SPREAD, [arriving(k, first=4) for k in range(3)])
LANES = [(-0.8, -0.8), (0, -0.8), (0.8, -0.8), (-0.8, 0.8), (0, 0.8), (0.8, 0.8)]
