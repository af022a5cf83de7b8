"""What zones promise where entities collide: every start stays between the bounds of a zone, step by step; teams
that touch.
"""

from fractions import Fraction

import numpy as np

from maviper.worlds import find
from tests.support.episode_cases import arriving
from tests.support.teams import nested, team_in, tree
from verify.claims.region import Region
from verify.claims.region_files import start_region
from verify.episodes.contacts import travels
from verify.episodes.unroll import EpisodeSearch, build_group, strides
from verify.episodes.zones import SCALE, Zones, starts
from verify.states.episodes import at_rest, play
from verify.states.state import sample

ROOM = 64  # units of 1 / SCALE that this check's own arithmetic may lose
MOVED = 2**10  # and the one of whole courses


def random_team(name, depth, seed):
    """A profile with full random trees over features that are not constant."""
    world, rng, trees = find(name), np.random.default_rng(seed), []
    for features, actions in zip(world.features, world.actions, strict=True):
        useful = [number for number, feature in enumerate(features) if feature.meaning.terms]

        def grown(levels, useful=useful, actions=actions):
            if not levels:
                return int(rng.integers(len(actions)))
            sides = grown(levels - 1), grown(levels - 1)
            threshold = round(float(rng.uniform(-0.6, 0.6)), 2)
            return int(rng.choice(useful)), threshold, *sides

        trees.append(nested(grown(depth)))
    return team_in(name, trees)


def around(profile, half, middles):
    """A region of boxes of half the side `half` around middles, (x, y) an entity in the world's order."""
    names = [name for name in start_region(profile.world).box if not name.endswith((".vx", ".vy"))]
    places = [Fraction(str(round(float(value), 3))) for middle in middles for value in middle]
    box = {name: (place - half, place + half) for name, place in zip(names, places, strict=True)}
    return Region(box, profile.world.goals)


def escaped(profile, region, steps, agents, count=100, budget=20_000):
    """How many (start, step) lie in no zone whose bounds hold the start's own course; None when zones are too many.

    Also the number of zones that were touched. Zones must not be given up (MAX_DRIFT).
    """
    parts = starts(region, profile.world)
    group = build_group(profile, agents, None, [], travels(profile.world, strides(profile), parts, steps))
    seen = [[] for _ in range(steps + 1)]

    def cut(zones, step):
        seen[step].append(zones)
        return zones

    search = EpisodeSearch(group, steps, cut, budget)
    first = np.array([part.project(group.entities) for part in parts])
    begun = Zones.at_start(first, np.arange(len(first)), len(agents), group.tests, group.contacts is not None)
    if not search.run(begun, lambda zones: None):
        return None, search.touched
    coordinates, _ = sample(at_rest(region), profile.world, count, 1)
    course, _ = play(profile, coordinates, steps)
    names = profile.world.coordinates()
    columns = np.array([[names.index(f"{name}.{axis}") for axis in "xy"] for name in group.entities])
    place = np.concatenate([np.zeros((len(coordinates), 1, 2)), coordinates[:, columns]], axis=1)
    gaps = (place[:, :, None] - place[:, None]).transpose(0, 3, 1, 2) * SCALE
    missing = 0
    for step, batches in enumerate(seen):
        zones = Zones.join(batches)
        moved = (course[step] - course[0])[:, columns[: len(agents)]] * SCALE
        for gap, far in zip(gaps, moved, strict=True):
            mine = zones.take((gap <= zones.bounds + ROOM).all(axis=(1, 2, 3)))
            more = 0 if mine.loose is None else mine.loose.drift
            between = (far >= mine.offset - MOVED) & (far <= mine.offset + more + MOVED)
            missing += not between.all(axis=(1, 2)).any()
    return missing, search.touched


SPREAD, TAG = "cooperative-navigation", "predator-prey"
HALF = Fraction(1, 40)


def going(*actions, name=SPREAD):
    return team_in(name, [tree(action) for action in actions])


HOMING = team_in(SPREAD, [arriving(k, first=4) for k in range(3)])
LANES = [(-0.8, -0.8), (0, -0.8), (0.8, -0.8), (-0.8, 0.8), (0, 0.8), (0.8, 0.8)]
