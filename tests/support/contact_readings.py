"""What several tests use of `verify.checker.episodes.test_contact_reading`."""

from fractions import Fraction

import numpy as np

from tests.support.contacts import around, random_team
from verify.checker.episodes.contacts import CUT, ContactReading
from verify.checker.episodes.reading import AWAY, GRID, SLACK, Gap
from verify.claims.catalogue import find_claim
from verify.claims.episodes import Reaches
from verify.states.episodes import at_rest, play
from verify.states.state import sample

SPREAD, TAG = "cooperative-navigation", "predator-prey"
WORLDS = (SPREAD, TAG, f"{SPREAD},agents=2", f"{TAG},predators=1,prey=1,obstacles=1")


class Course:
    """A played episode: world coordinates by step, exact and in 1 / GRID."""

    def __init__(self, profile, coordinates, actions):
        self.names, self.steps = profile.world.coordinates(), coordinates
        self.order = [entity.name for entity in profile.world.agents]
        self.actions = actions

    def at(self, step, name):
        return Fraction(float(self.steps[step, self.names.index(name)])) * GRID

    def chosen(self, step, followed):
        return tuple(int(self.actions[step, self.order.index(agent)]) for agent in followed)


def crowded(seed, kind, count=12):
    """A reading of a small region in which many may touch, and episodes from there."""
    name, rng = WORLDS[seed % len(WORLDS)], np.random.default_rng(seed)
    profile = random_team(name, seed % 3, seed)
    entities = len(profile.world.agents) + len(profile.world.landmarks)
    region = around(profile, Fraction(1, 50), rng.uniform(-0.35, 0.35, (entities, 2)))
    agents = [agent.name for agent in profile.world.agents]
    followed = agents if seed % 5 != 4 else agents[-1:]
    steps, far = 4 + seed % 5, Fraction(3, 10)
    mark = "landmark_0" if name.startswith(SPREAD) else "obstacle_0"
    own = profile.agents[-1].agent
    side = profile.agents[-1].team
    claim = find_claim("keeps_apart", profile, side, steps=steps, others=[mark], radius=far)
    if seed % 2:
        claim = Reaches(side, steps, far, (mark,))
    episode = kind(profile, claim, region, None, followed, [((own, mark),)])
    starts, _ = sample(at_rest(region), profile.world, count, 1)
    course, actions = play(profile, starts, steps)
    return (
        episode,
        (own, mark),
        followed,
        [Course(profile, course[:, row], actions[:, row]) for row in range(count)],
        rng,
    )


def within(low, value, high, room=0):
    return low - room <= value <= high + room


def possible(episode, node, course, now):
    """The ends of a question that a start may come to, as its answers say."""
    if isinstance(node, int):
        return {node}
    found, unit = set(), episode.unit
    for side in node:
        upper, lower, most = episode.bound(side, now)
        gap = (course.at(0, episode.names[upper]) if upper else 0) - (
            course.at(0, episode.names[lower]) if lower else 0
        )
        if gap * unit <= most + 1:  # strict bounds are one less
            found |= possible(episode, side.child, course, now)
    return found


def strays(seed, kind=ContactReading):
    """What played episodes do that the reading does not know of, and how many pushes were known between bounds."""
    found, touched = [], 0
    episode, pair, followed, courses, rng = crowded(seed, kind)
    for course in courses:
        now = episode.start
        for step in range(episode.steps + 1):
            found += beyond(episode, course, now)
            near = all(
                abs(course.at(step, f"{pair[0]}.{a}") - course.at(step, f"{pair[1]}.{a}")) < 0.3 * GRID for a in "xy"
            )
            good = near != episode._apart
            if not good and AWAY not in possible(episode, episode.claim, course, now):
                found.append(f"step {step}: the claim")
            if step == episode.steps:
                break
            chosen = course.chosen(step, followed)
            for asked, action in zip(episode.trees, chosen, strict=True):
                if action not in possible(episode, asked, course, now):
                    found.append(f"step {step}: an action")
            now = cut(episode, course, now, rng)
            touched += len(episode._forces(now, episode._asking))
            now = episode._later(now, chosen)
    return found, touched


def beyond(episode, course, now):
    """Offsets and velocities that are not within their bounds now."""
    for entity, (x, y) in zip(course.order, episode.places, strict=False):
        for axis, place in (("x", x), ("y", y)):
            name, speed = f"{entity}.{axis}", f"{entity}.v{axis}"
            velocity = episode._number[speed]
            if not within(now.shift[place], course.at(now.step, name) - course.at(0, name), now.most[place], SLACK / 2):
                yield f"step {now.step}: {name}"
            if not within(now.shift[velocity], course.at(now.step, speed), now.most[velocity]):
                yield f"step {now.step}: {speed}"
            if not now.moved[place] and course.at(now.step, name) != course.at(0, name):
                yield f"step {now.step}: {name} is said not to have moved"


def cut(episode, course, now, rng):
    """Gaps cut at random, the part kept in which a start lies."""
    for number in episode._asking:
        gap, pair = Gap(number, now.gaps[number]), episode.contacts[number]
        for axis in rng.integers(0, 2, rng.integers(0, 9)):
            low, high = gap.starts[axis]
            at = int(rng.integers(low, high)) // CUT * CUT
            if low < at < high:
                names = [episode.names[episode.places[one][axis]] for one in (pair.first, pair.second)]
                is_below = course.at(0, names[0]) - course.at(0, names[1]) <= at
                gap = gap.within(axis, (low, at) if is_below else (at, high))
        now = now._replace(gaps=(*now.gaps[:number], gap.starts, *now.gaps[number + 1 :]))
    return now


def pushing(change):
    """A reading for which every push, least and most, is another."""

    class Pushing(ContactReading):
        def _forces(self, now, pairs):
            found = super()._forces(now, pairs)
            return {agent: tuple(change(*ends) for ends in force) for agent, force in found.items()}

    return Pushing


Weak = pushing(lambda low, high: (low // 2, high // 2))
Pulling = pushing(lambda low, high: (-high, -low))
Rigid = pushing(lambda low, high: ((low + high) // 2,) * 2)  # the middle stands for all of it


class Late(ContactReading):
    """Contacts are noticed too late."""

    def __init__(self, *given):
        super().__init__(*given)
        self.contacts = tuple(pair._replace(reach=pair.reach - GRID // 6) for pair in self.contacts)


class Tame(ContactReading):
    """Takes those who are not followed to stand still."""

    def _bound_places(self):
        return [self.start._replace(step=step) for step in range(self.steps + 1)]
