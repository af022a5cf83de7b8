"""The checker's bounds of contact forces: against the forces of the simulator, whose courses are those of mpe2."""

from fractions import Fraction

import numpy as np
import pytest

from codegen.dynamics import contact_force, partners
from maviper.worlds import find
from verify.checker.episodes import contacts
from verify.checker.episodes.reading import GRID

SPREAD, TAG = "cooperative-navigation", "predator-prey"
ROOM = 1e-9  # roundings of the simulator, and what is left out beyond touching


def grid(value):
    return int(Fraction(float(value)) * GRID)


def boxes(rng, count):
    """Boxes of gaps on a grid of 2^-20, so that their ends are exact: [count, 2, 2] of axis and end."""
    low = np.round(rng.uniform(-0.4, 0.4, (count, 2)) * 2**20) / 2**20
    sides = np.round(rng.choice([0.0, 1e-5, 1e-3, 0.1, 0.3], (count, 2)) * 2**20) / 2**20
    return np.stack([low, low + sides], axis=2)


def outside(world, pair, touching, found, push):
    """How many sampled gaps of boxes have a force beyond its bounds."""
    rng, missed = np.random.default_rng(1), 0
    for box in found:
        points = rng.uniform(box[:, 0], box[:, 1], (40, 2))
        points[:4] = [[x, y] for x in box[0] for y in box[1]]
        bounds = np.array(push(pair, tuple((grid(low), grid(high)) for low, high in box)), dtype=float) / GRID
        rows, force = contact_force(world, points[:, 0], points[:, 1], touching)
        within = (bounds[:, :1] - ROOM <= force) & (force <= bounds[:, 1:] + ROOM)
        missed += int((~within).sum())
        assert not len(rows) or force.shape == (2, len(rows))
    return missed


@pytest.mark.parametrize("name", [SPREAD, TAG])
def test_forces_lie_between_their_bounds(name):
    world = find(name).spec
    found = boxes(np.random.default_rng(3), 300)
    for pair, (first, second, touching) in zip(contacts.contacts(world), partners(world), strict=True):
        assert (pair.first, pair.second) == (first, second)
        assert outside(world, pair, touching, found, contacts.Contact.push) == 0


@pytest.mark.parametrize(
    "wrong",
    [
        lambda pair, gap: tuple((-high, -low) for low, high in pair.push(gap)),
        lambda pair, gap: pair._replace(force=pair.force / 2).push(gap),
        lambda pair, gap: pair._replace(margin=pair.margin / 2).push(gap),
        lambda pair, gap: pair._replace(touching=pair.touching - Fraction(1, 1000)).push(gap),
        lambda pair, gap: pair._replace(reach=pair.reach - GRID // 30).push(gap),
    ],
    ids=["sign", "force", "margin", "size", "reach"],
)
def test_that_test_sees_wrong_pushes(wrong):
    world = find(SPREAD).spec
    found = boxes(np.random.default_rng(3), 100)
    assert outside(world, contacts.contacts(world)[0], partners(world)[0][2], found, wrong) > 0


def test_bounds_of_a_single_gap_are_tight():
    """Only then what zones prove has a certificate."""
    world, rng = find(SPREAD).spec, np.random.default_rng(5)
    pair, (_, _, touching) = contacts.contacts(world)[0], partners(world)[0]
    for x, y in rng.uniform(-0.22, 0.22, (200, 2)):
        _, force = contact_force(world, np.array([x]), np.array([y]), touching)
        bounds = pair.push(((grid(x), grid(x)), (grid(y), grid(y))))
        for (low, high), one in zip(bounds, force, strict=True):
            assert low / GRID <= one[0] + ROOM and high / GRID >= one[0] - ROOM and (high - low) / GRID < 1e-8


def test_overlaps_far_and_near():
    """Where the exponential is beyond any float, and where it is all that there is."""
    pair = contacts.contacts(find(SPREAD).spec)[0]._replace(margin=Fraction(1, 10**9))
    for distance in (0, GRID // 10, GRID // 4):
        low, high = pair.overlap(distance)
        assert low <= pair.touching * GRID - distance <= high and high - low <= 4
    low, high = pair._replace(margin=Fraction(1)).overlap(grid(float(pair.touching)))
    assert low / GRID <= np.log(2) <= high / GRID and high - low <= 4
    assert pair.overlap(8 * GRID) == (0, 1)


def test_who_may_push_whom():
    world = find(TAG).spec
    assert [(pair.first, pair.second) for pair in contacts.contacts(world)] == [pair[:2] for pair in partners(world)]
    assert contacts.contacts(find("physical-deception").spec) == ()


def test_speeds_are_cut_between_bounds():
    rng = np.random.default_rng(0)
    for low in np.round(rng.uniform(-3, 3, (200, 2)) * 2**20) / 2**20:
        high = low + np.round(rng.uniform(0, 2, 2) * 2**20) / 2**20
        given = tuple((grid(a), grid(b)) for a, b in zip(low, high, strict=True))
        found = np.array(contacts.limit_speed(given, Fraction(1.3)), dtype=float) / GRID
        velocity = rng.uniform(low, high, (60, 2))
        velocity[:4] = [[x, y] for x in (low[0], high[0]) for y in (low[1], high[1])]
        velocity *= np.minimum(1, 1.3 / np.hypot(*velocity.T))[:, None]
        assert (velocity >= found[:, 0] - 1e-12).all() and (velocity <= found[:, 1] + 1e-12).all()


def test_one_place():
    world = find(f"{SPREAD},agents=2").spec
    start = dict.fromkeys(world.coordinates(), Fraction(0))
    assert contacts.coincident(world, start)
    assert not contacts.coincident(world, start | {"agent_1.y": Fraction(1, 10**140)})
    assert contacts.coincident(world, start | {"agent_1.y": Fraction(1, 10**160)})
