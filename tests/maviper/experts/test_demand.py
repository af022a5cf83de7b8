"""Demand: a convention shows in the roles and in the cross-seed gap, roles that follow the state in the forest."""

import json

import numpy as np
import pytest

from maviper.episodes.play import rollout
from maviper.experts.demand import assignments, demand, roles
from maviper.experts.scripted import FIXED_ROLES, build_script
from maviper.worlds import find

SEEDS = range(8_000_000, 8_000_600)


class Swapped:
    """Another's team with its two defenders' landmarks exchanged: the other convention."""

    def __init__(self, world):
        self.world, self.script = world, build_script(world)

    def act(self, agents, observations, state):
        position = state.position.copy()
        position[:, [3, 4]] = position[:, [4, 3]]
        return self.script.act(agents, observations, type(state)(position, state.velocity, state.goal))


def test_two_conventions_do_not_fit_and_the_gap_says_so():
    world = find("physical-deception")
    found = demand(world, {0: build_script(world), 1: Swapped(world), 2: build_script(world)}, 0, SEEDS)
    team = found["team-mate of another seed"]["defenders"]
    assert team["measure"] == "success r=0.316" and team["own"] > 0.99
    assert team["mixed"]["1"] < 0.3 and team["mixed"]["2"] == team["own"]
    assert found["episodes"] == 600 and json.loads(json.dumps(found)) == found


def played(world, *kind):
    return rollout(world, [build_script(world, *kind)] * len(world.agents), SEEDS)[0]


def test_a_fixed_assignment_is_one_role_and_the_nearest_follows_the_state():
    world = find("cooperative-navigation,agents=2")
    fixed = roles(world, played(world, FIXED_ROLES))["agents"]
    assert fixed["shares"]["agent_0 landmark_0, agent_1 landmark_1"] > 0.95
    free = roles(world, played(world))["agents"]
    assert sum(free["shares"].values()) == pytest.approx(1, abs=1e-3)
    assert max(free["shares"].values()) < 0.6
    assert free["from the start state"] > free["always the most frequent"] + 0.2
    assert list(free["shares"].values()) == sorted(free["shares"].values(), reverse=True)


def test_the_assignment_is_that_of_least_distance_at_the_end():
    world = find("cooperative-navigation")
    (episodes,) = rollout(world, [build_script(world)] * 3, SEEDS[:50])
    names, taken = assignments(world, "agents", episodes)
    for row, position in enumerate(episodes.states[-1].position):
        apart = np.linalg.norm(position[:3, None] - position[None, 3:], axis=2)
        places = [int(part.split("landmark_")[1]) for part in names[taken[row]].split(", ")]
        assert sorted(places) == [0, 1, 2]
        for name in names:
            other = [int(part.split("landmark_")[1]) for part in name.split(", ")]
            assert apart[range(3), places].sum() <= apart[range(3), other].sum() + 1e-12


def test_predators_hold_the_prey_that_they_were_nearest_to():
    world = find("predator-prey")
    (episodes,) = rollout(world, [build_script(world)] * 4, SEEDS[:50])
    names, taken = assignments(world, "predators", episodes)
    place = np.stack([state.position for state in episodes.states[1:]])
    for row in range(50):
        gaps = np.linalg.norm(place[:, row, :2, None] - place[:, row, None, 2:4], axis=3).mean(axis=0)
        held = [f"adversary_{k} agent_{int(gaps[k].argmin())}" for k in range(2)]
        assert names[taken[row]] == ", ".join(held)
