"""What zones promise: every start lies in a zone that moves as the start's own episode does."""

from dataclasses import replace
from fractions import Fraction

import numpy as np
from hypothesis import assume

from codegen.lowering.deploy import deploy_tree
from tests.support.strategies import with_trees
from tests.support.teams import DOWN, LEFT, RIGHT, STAY, UP, team, tree
from verify.claims.catalogue import find_claim
from verify.claims.region import Region
from verify.claims.region_files import everywhere, start_region
from verify.episodes.composition import decide
from verify.episodes.unroll import EpisodeSearch, build_group
from verify.episodes.zones import SCALE, Zones, starts
from verify.question import Budgets, Question
from verify.result import Verdict
from verify.states.episodes import at_rest, play
from verify.states.state import sample
from verify.subjects import Game

ROOM = 64  # units of 1 / SCALE that float64 arithmetic in this check may lose; tests are relaxed by 2^14 of them


def arriving(k, first=2):
    """Goes to landmark k: first in y while that is far, then in x, then in y. Arrives from every start. `first`: the
    feature that tells how far landmark 0 is in x.
    """
    dx, dy = first + 2 * k, first + 1 + 2 * k
    return tree(
        (dy, -0.8, 1, 2), DOWN, (dy, 0.8, 3, 10), (dx, -0.3, 4, 5), LEFT, (dx, 0.3, 6, 9), (dy, 0.0, 7, 8), DOWN, UP,
        RIGHT, UP,
    )  # fmt: skip


def centred(profile, half, middles, goals=None):
    """A region of boxes of half the side `half` around middles {entity: (x, y)}; others are anywhere."""
    start = start_region(profile.world)
    box = dict(start.box)
    for name, place in middles.items():
        for axis, middle in zip("xy", place, strict=True):
            box[f"{name}.{axis}"] = (Fraction(str(middle)) - half, Fraction(str(middle)) + half)
    return Region(box, start.goals if goals is None else goals)


def grown_pair(profile, first, second, ties=False):
    """The profile with two trees, which hypothesis drew; `ties`: their thresholds are rounded, so that starts meet
    them.
    """
    trees = [on_lattice(deploy_tree(grown)) if ties else deploy_tree(grown) for grown in (first, second)]
    assume(all(not (np.abs(each.threshold[each.threshold != 0]) < 2.0**-126).any() for each in trees))
    return with_trees({"agent_0": trees[0], "agent_1": trees[1]}, profile)


def on_lattice(tree):
    """The tree with its thresholds rounded to eighths, at most 2."""
    return replace(tree, threshold=np.round(np.clip(tree.threshold, -2, 2) * 8) / 8)


def verdicts_wrong(profile):
    """Whether zones give teams whose answer is known another one."""
    arrivers = team(profile, arriving(0), arriving(1))
    still = team(profile, tree(STAY), tree(STAY))
    start = everywhere(profile)

    def beside(gap):
        box = {name: (Fraction(0), Fraction(0)) for name in start.box}
        return replace(start, box={**box, "agent_0.y": (gap, gap), "landmark_1.x": (gap, gap)})

    # each landmark at one of two agents, in either order: no one matching fits all starts
    box = {name: (Fraction(0), Fraction(0)) for name in start.box}
    box |= {f"agent_{number}.x": (Fraction(side, 4),) * 2 for number, side in enumerate((-1, 1))}
    box |= {f"landmark_{number}.x": (Fraction(-3, 10), Fraction(3, 10)) for number in range(2)}
    shared = replace(start, box=box, apart=(("landmark_0", "landmark_1", Fraction(1, 2)),))
    known = [
        (arrivers, "reaches", start, Verdict.PROVED),
        (arrivers, "covers", start, Verdict.VIOLATED),
        (arrivers, "reaches", replace(start, goals=("landmark_1",)), Verdict.PROVED),
        (still, "reaches", beside(Fraction(3, 8)), Verdict.PROVED),
        (still, "covers", beside(Fraction(3, 8)), Verdict.PROVED),
        (still, "covers", beside(Fraction(7, 16)), Verdict.VIOLATED),
        (still, "reaches", shared, Verdict.VIOLATED),
        (still, "covers", shared, Verdict.PROVED),
    ]
    return any(
        decide(Question(Game(one), find_claim(name, one), region, budgets=Budgets(max_zones=100_000))).verdict
        is not verdict
        for one, name, region, verdict in known
    )


def signs_wrong(profile):
    """Whether zones lose the starts at which a sign is 0, between two of its tests."""
    grown = tree((2, -0.5, 1, 2), STAY, (2, 0.5, 3, 4), RIGHT, STAY)
    own = profile.policy("agent_0")
    meaning = replace(own.features[2].meaning, function="sign")
    features = [replace(one, meaning=meaning) if number == 2 else one for number, one in enumerate(own.features)]
    stays = replace(profile.policy("agent_1"), tree=tree(STAY))
    changed = {"agent_0": replace(own, features=tuple(features), tree=grown), "agent_1": stays}
    turning = replace(profile, agents=tuple(changed.get(one.agent, one) for one in profile.agents))
    start = everywhere(turning)
    box = {name: (Fraction(0), Fraction(0)) for name in start.box}
    box |= dict.fromkeys(("agent_0.x", "landmark_0.x"), (Fraction(0), Fraction(1, 20)))
    claim = find_claim("covers", turning, steps=8, radius=Fraction(3, 50))
    return (
        decide(Question(Game(turning), claim, replace(start, box=box), budgets=Budgets(max_zones=10_000))).verdict
        is not Verdict.VIOLATED
    )


def lost(profile, steps, seed, count=200, lattice=None, agents=("agent_0", "agent_1"), budget=1_000_000):
    """How many sampled starts lie in no zone with their own history; None when the zones are too many.

    `lattice`: starts are rounded to multiples of it, where thresholds may tie.
    """
    region, missing = everywhere(profile), 0
    landmarks = [entity.name for entity in profile.world.landmarks]
    parts = starts(region, profile.world)
    coordinates, goals = sample(at_rest(region), profile.world, count, seed)
    if lattice:
        coordinates = np.round(coordinates / lattice) * lattice
    episode, _ = play(profile, coordinates, steps)
    names = profile.world.coordinates()
    for number, goal in enumerate(region.goals):
        group = build_group(profile, agents, goal, landmarks)
        first = np.array([part.project(group.entities) for part in parts])
        kept = []
        search = EpisodeSearch(group, steps, lambda zones, step: zones, budget)
        if not search.run(Zones.at_start(first, np.arange(len(first)), len(agents), group.tests), kept.append):
            return None
        zones = Zones.join(kept)
        columns = np.array([[names.index(f"{name}.{axis}") for axis in "xy"] for name in group.entities])
        limits = zones.bounds + ROOM
        for row in np.flatnonzero(goals == number):
            place = np.vstack([np.zeros((1, 2)), coordinates[row][columns]])  # [nodes, 2]
            gaps = (place[:, None] - place[None]).transpose(2, 0, 1) * SCALE
            moved = (episode[-1, row] - episode[0, row])[columns[: len(agents)]] * SCALE
            # every choice but the last shows in how far an agent has come
            alike = np.flatnonzero((np.abs(zones.offset - moved) < 2**10).all(axis=(1, 2)))
            missing += not (gaps <= limits[alike]).all(axis=(1, 2, 3)).any()
    return missing
