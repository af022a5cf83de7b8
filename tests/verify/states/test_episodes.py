"""Whole episodes: motion by hand in exact steps, and claims about them by the distances of every step."""

from dataclasses import replace
from fractions import Fraction as F
from itertools import permutations

import numpy as np
import pytest

from codegen.errors import DisagreementError, InputError
from maviper.worlds import find
from tests.support.games import random_profile
from tests.support.small import small_profile
from tests.support.teams import RIGHT, STAY, team, tree
from verify.claims.episodes import Covers, KeepsApart, Reaches
from verify.claims.region_files import start_region
from verify.question import Question
from verify.states import episodes
from verify.states.state import State, actions_at
from verify.subjects import Game

PROFILE = team(small_profile(), tree(RIGHT), tree(STAY))
NAMES = PROFILE.world.coordinates()
TEAM = ["agent_0", "agent_1"]
MARKS = ["landmark_0", "landmark_1"]


def start(**moved):
    position = dict.fromkeys(start_region(PROFILE.world).box, 0.0)
    return State(position | {name.replace("__", "."): value for name, value in moved.items()}, "landmark_0")


def drawn_courses(profile, seed, count=12, steps=9):
    """Random walks over all coordinates, coarse enough that distances meet radii exactly."""
    rng = np.random.default_rng(seed)
    return rng.integers(-6, 7, (steps + 1, count, len(profile.world.coordinates()))) / 8


def test_a_push_is_felt_one_step_later_and_friction_takes_its_part():
    """x moves with the old velocity; a velocity keeps what damping leaves of it and takes the push for a step."""
    course, actions = episodes.courses(PROFILE, [start()], 4)
    world = PROFILE.world
    entity = next(one for one in world.agents if one.name == "agent_0")
    place, speed = 0.0, 0.0
    for step in range(5):
        assert course[step, 0, NAMES.index("agent_0.x")] == place
        assert course[step, 0, NAMES.index("agent_0.vx")] == speed
        place, speed = place + speed * world.dt, speed * (1 - world.damping) + entity.force * world.dt
    assert (actions[:, 0, [one.name for one in world.agents].index("agent_0")] == RIGHT).all()
    still = [NAMES.index(f"{name}.{axis}") for name in ("agent_1", *MARKS) for axis in "xy"]
    assert (course[:, :, still] == course[0][:, still]).all()


@pytest.mark.parametrize("name", ["physical-deception,velocity=1", "predator-prey"])
def test_each_step_is_chosen_in_the_state_before_it_and_starts_rest(name):
    profile = random_profile(name)
    world, rng = find(name), np.random.default_rng(1)
    coordinates = world.coordinates(world.start(3, rng)) + 0.0
    names = profile.world.coordinates()
    moving = [names.index(f"{one.name}.v{axis}") for one in profile.world.agents for axis in "xy"]
    coordinates[:, moving] = 7.0
    course, actions = episodes.play(profile, coordinates, 3)
    assert course.shape == (4, 3, len(names)) and (course[0][:, moving] == 0).all()
    goals = [one.name for one in profile.world.landmarks]
    for step in range(3):
        for row in range(3):
            at = dict(zip(names, course[step, row].tolist(), strict=True))
            goal = next((g for g in goals if all(at[f"{g}.{x}"] == at.get(f"goal.{x}") for x in "xy")), None)
            state = State({key: value for key, value in at.items() if not key.startswith("goal.")}, goal)
            for team_name in {policy.team for policy in profile.agents}:
                for agent, action in actions_at(profile, team_name, state).items():
                    order = [one.name for one in profile.world.agents]
                    assert actions[step, row, order.index(agent)] == action


def far(course, a, b):
    """Distances [steps + 1] of two entities, exactly."""
    columns = [[NAMES.index(f"{one}.{axis}") for axis in "xy"] for one in (a, b)]
    steps = zip(*(course[:, c] for c in columns), strict=True)
    return [max(abs(F(p) - F(q)) for p, q in zip(x, y, strict=True)) for x, y in steps]


@pytest.mark.parametrize("seed", range(4))
def test_claims_fail_where_the_distances_of_their_steps_say_so(seed):
    courses, radius, steps = drawn_courses(PROFILE, seed), F(3, 8), 9
    reaches = Reaches("defenders", steps, radius=radius, landmarks=("landmark_1", "landmark_0"))
    covers = Covers("defenders", steps, radius=radius)
    apart = KeepsApart("defenders", steps, radius=radius, others=("adversary_0",))
    told = {True: 0, False: 0}
    for row in range(courses.shape[1]):
        course = courses[:, row]
        wanted = {
            reaches: all(min(far(course, a, b)) <= radius for a, b in zip(TEAM, reaches.landmarks, strict=True)),
            covers: any(
                all(far(course, a, b)[-1] <= radius for a, b in zip(TEAM, own, strict=True))
                for own in permutations(MARKS)
            ),
            apart: all(min(far(course, a, "adversary_0")) >= radius for a in TEAM),
        }
        for claim, holds in wanted.items():
            assert episodes.fails(PROFILE, claim, course) == (not holds), claim.name
            assert episodes.meets_claim(PROFILE, claim, courses)[row] == holds, claim.name
            told[holds] += 1
    assert min(told.values()) > 3


def test_an_episode_without_numbers_violates_nothing():
    claim = Covers("defenders", 9, radius=F(1, 8))
    course = drawn_courses(PROFILE, 0)[:, 0]
    assert episodes.fails(PROFILE, claim, course)
    course[3, 0] = np.nan
    assert not episodes.fails(PROFILE, claim, course)


def test_ways_are_all_matchings_unless_landmarks_are_named():
    free, named = Covers("defenders", 5), Covers("defenders", 5, landmarks=("landmark_1", "landmark_0"))
    assert set(episodes.find_matchings(PROFILE, free)) == {(0, 1), (1, 0)}
    assert episodes.find_matchings(PROFILE, named) == [(1, 0)]
    assert episodes.name_pairs(PROFILE, named) == [(("agent_0", "landmark_1"), ("agent_1", "landmark_0"))]
    assert episodes.name_pairs(PROFILE, KeepsApart("defenders", 5, radius=F(1))) == [(("agent_0", "agent_1"),)]


def test_the_distance_to_oneself_is_infinite():
    course = drawn_courses(PROFILE, 2)
    found = episodes.gaps(PROFILE, KeepsApart("defenders", 5, radius=F(1)), course)
    assert found.shape == (*course.shape[:2], 2, 2) and np.isinf(found[..., [0, 1], [0, 1]]).all()
    assert found[3, 1, 0, 1] == found[3, 1, 1, 0] == float(far(course[:, 1], *TEAM)[3])


def test_how_an_agent_fares():
    """agent_0 goes right past landmark_0, which is at 0.5; agent_1 rests on landmark_1."""
    at = start(landmark_0__x=0.5)
    claim = Reaches("defenders", 8, radius=F(1, 10), landmarks=tuple(MARKS))
    episode = episodes.agree_on_course(PROFILE, at, 8, {})
    first, second = episodes.ways_of(PROFILE, claim, episode)
    xs = [x for x, _ in first.places]
    gaps = [abs(x - 0.5) for x in xs]
    assert (first.nearest, first.step, first.last) == (min(gaps), gaps.index(min(gaps)), gaps[-1])
    assert first.actions == ("right",) * 8 and xs == sorted(xs) and xs[-1] > 0.5
    assert (second.nearest, second.step, second.last) == (0.0, 0, 0.0)


def test_another_world_that_differs_by_one_bit_is_a_disagreement():
    at = start()
    same = episodes.agree_on_course(PROFILE, at, 5, {})
    for change, word in ((("coordinates", (4, 0)), "positions"), (("actions", (2, 1)), "actions")):
        name, place = change
        data = getattr(same, name).copy()
        data[place] = np.nextafter(data[place], 9) if name == "coordinates" else data[place] + 1
        other = replace(same, **{name: data})
        rollouts = {"copy": lambda *_: same, "other": lambda *_, other=other: other}
        with pytest.raises(DisagreementError, match="another episode") as raised:
            episodes.agree_on_course(PROFILE, at, 5, rollouts)
        assert word in raised.value.where


def test_the_first_start_that_fails_must_lie_in_the_region():
    claim = Reaches("defenders", 3, radius=F(1, 4), landmarks=tuple(MARKS))
    near, away, outside = start(), start(landmark_1__x=1.0), start(landmark_1__x=2.0)
    question = Question(Game(PROFILE), claim, start_region(PROFILE.world))
    assert episodes.first_failing(question, [near, outside]) is None
    assert episodes.first_failing(question, [near, outside, away, start(landmark_1__y=1.0)]) is away
    assert episodes.first_failing(question, []) is None


def test_rest_bounds_every_velocity_by_zero():
    profile = random_profile("physical-deception,velocity=1")
    speeds = [name for name in profile.world.coordinates() if name.endswith((".vx", ".vy"))]
    region = start_region(profile.world, speeds)
    still = episodes.at_rest(region)
    assert {still.box[name] for name in speeds} == {(0, 0)} and any(region.box[name] != (0, 0) for name in speeds)
    assert all(still.box[name] == bounds for name, bounds in region.box.items() if name not in speeds)


def test_what_cannot_be_played_is_refused():
    episodes.playable(PROFILE)
    with pytest.raises(InputError, match="adversary_0 has no policy"):
        episodes.playable(replace(PROFILE, agents=PROFILE.agents[1:]))
    with pytest.raises(InputError, match="does not state its dynamics"):
        episodes.playable(replace(PROFILE, world=replace(PROFILE.world, dt=0.0)))
