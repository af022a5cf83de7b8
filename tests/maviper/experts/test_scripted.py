"""Scripted experts: as good as they are meant to be, at any number of agents, and what their look-ahead promises."""

from dataclasses import replace
from itertools import product
from types import SimpleNamespace

import numpy as np
import pytest

from codegen.errors import InputError
from maviper.episodes import measures
from maviper.episodes.play import Policies, play
from maviper.experts import scripted as module
from maviper.experts.scripted import HELD, HORIZON, PLANNED, Landing, build_script
from maviper.worlds import WorldState, find
from maviper.worlds.games.particle import planes
from maviper.worlds.games.physical_deception import ADVERSARIES, DEFENDERS
from maviper.worlds.games.predator_prey import PREDATORS, PREY

SPREAD = "cooperative-navigation"
STILL = Policies([lambda obs: np.zeros(len(obs), dtype=np.int64)] * 24)


def random_walk(seed):
    rng = np.random.default_rng(seed)
    return Policies([lambda obs: rng.integers(5, size=len(obs))] * 24)


def measured(world, controllers, episodes, first=9_000_000):
    """{label: estimate} on episodes of their own."""
    found = measures.evaluate(world, controllers, range(first, first + episodes))
    return {measure.label: value for measure, value in found.items()}


def sides(world, team, ours, theirs):
    """One controller for a team, another one for everybody else."""
    return [ours if world.team_of(agent) == team else theirs for agent in world.agents]


# --- how good they are


@pytest.mark.parametrize("defenders", [2, 3])
def test_defenders_always_split_up(defenders):
    world = find(f"physical-deception,defenders={defenders}")
    found = measured(world, [build_script(world)] * len(world.agents), 500)
    for radius in ("0.316", "0.1"):
        assert found[f"{DEFENDERS} success r={radius}"].value == 1
        assert found[f"{DEFENDERS} success r={radius}"].interval[0] >= 0.99


def test_the_adversary_cannot_do_much_better_than_guess():
    """Defenders that cover every target tell it nothing; it still lands on one of them."""
    world = find("physical-deception")
    found = measured(world, [build_script(world)] * 3, 1_000)
    assert 0.5 <= found[f"{ADVERSARIES} success r=0.1"].value <= 0.7
    still = measured(world, sides(world, ADVERSARIES, STILL, build_script(world)), 1_000)
    assert still[f"{ADVERSARIES} success r=0.1"].interval[1] < 0.1


def test_navigation_lands_on_all_targets():
    world = find(SPREAD)
    ours, still = measured(world, [build_script(world)] * 3, 500), measured(world, [STILL] * 3, 500)
    assert ours["agents D + collisions"].interval[1] < 0.65
    assert still["agents D + collisions"].interval[0] > 2 * ours["agents D + collisions"].interval[1]
    assert ours["agents success r=0.1"].interval[0] > 0.5


@pytest.mark.parametrize("name", ["predator-prey", "predator-prey,predators=3,prey=1,observation=mpe2"])
def test_pursuers_catch_and_fleers_get_away(name):
    world = find(name)
    script, walk = build_script(world), random_walk(0)
    touches = f"{PREDATORS} touches"
    nobody = measured(world, [walk] * len(world.agents), 500)[touches]
    hunted = measured(world, sides(world, PREDATORS, script, walk), 500)[touches]
    fled = measured(world, sides(world, PREY, script, walk), 500)[touches]
    both = measured(world, [script] * len(world.agents), 500)[touches]
    assert hunted.interval[0] > 5 * nobody.interval[1]
    assert fled.interval[1] < 0.5 * nobody.interval[0]
    assert fled.interval[1] < both.interval[0] and both.interval[1] < hunted.interval[0]


def test_fleers_stay_in_the_arena():
    """What prey pay beside touches is the price of the border."""
    world = find("predator-prey")

    def border(controller):
        found = measured(world, [controller] * 4, 500)
        return -found[f"{PREY} return"].value - 10 * found[f"{PREY} touches"].value / 2

    assert 0 <= border(build_script(world)) < 0.2 * border(random_walk(1))


# --- what they are made of


def moving_states(world, count, seed):
    """Moving states, everything within [-2, 2]."""
    rng = np.random.default_rng(seed)
    n_entities = len(world.agents) + len(world.spec.landmarks)
    position = rng.uniform(-2, 2, (count, n_entities, 2))
    velocity = rng.normal(size=(count, len(world.agents), 2))
    return WorldState(position, velocity, rng.integers(max(1, len(world.spec.goals)), size=count))


def test_landing_is_the_best_plan_of_the_simulator():
    """Every sequence of PLANNED actions, then coasting, played through the world: none ends with a smaller sum."""
    world = find(f"{SPREAD},agents=1")
    state = moving_states(world, 60, seed=1)
    state.position[:5, 0], state.velocity[:5] = state.position[:5, 1], 0  # there already
    costs = {}
    for plan in product(range(5), repeat=PLANNED):
        here, total = state, np.zeros(len(state))
        for step in range(HORIZON):
            acted = plan[step] if step < PLANNED else 0
            here = world.step(here, np.full((len(state), 1), acted))
            total += np.linalg.norm(here.position[:, 0] - here.position[:, 1], axis=1)
        costs[plan] = total
    best = np.min(list(costs.values()), axis=0)
    position, velocity = planes(state.position), planes(state.velocity)
    chosen = Landing(world)([0], position[1:] - position[:1], velocity)[:, 0]
    reachable = [min(costs[plan][row] for plan in costs if plan[0] == action) for row, action in enumerate(chosen)]
    np.testing.assert_allclose(reachable, best, rtol=0, atol=1e-9)
    assert set(chosen[:5].tolist()) == {0} and set(chosen[5:].tolist()) >= {1, 2, 3, 4}


def test_held_actions_go_where_the_simulator_goes():
    world = find("predator-prey,predators=1,prey=1,obstacles=0")
    state = moving_states(world, 40, seed=2)
    apart = np.linalg.norm(state.position[:, 0] - state.position[:, 1], axis=1) > 2
    state = state[apart]
    script = build_script(world)
    for agent in (0, 1):
        found = script._hold_actions(agent, planes(state.position)[agent], planes(state.velocity)[agent])
        for action in range(5):
            here = state
            for _ in range(HELD):
                here = world.step(here, np.full((len(state), 2), action))
            np.testing.assert_allclose(found[action].T, here.position[:, agent], rtol=0, atol=1e-9)


def test_defenders_do_not_look_at_the_goal():
    world = find("physical-deception,defenders=3")
    state = moving_states(world, 100, seed=3)
    other = replace(state, goal=(state.goal + 1) % 3)
    seen = world.observe(state)
    script = build_script(world)
    assert (script.act(range(4), seen, state) == script.act(range(4), seen, other)).all()


@pytest.mark.parametrize("name", ["physical-deception", SPREAD, "predator-prey"])
def test_agents_can_be_asked_in_any_order(name):
    world = find(name)
    script, state = build_script(world), moving_states(world, 50, seed=4)
    everybody = script.act(range(len(world.agents)), (), state)
    assert everybody.shape == (50, len(world.agents)) and everybody.min() >= 0 and everybody.max() <= 4
    assert (script.act([2, 0], (), state) == everybody[:, [2, 0]]).all()


@pytest.mark.parametrize("name", ["physical-deception", SPREAD, "predator-prey"])
def test_chunks_change_nothing(name, monkeypatch):
    world = find(name)
    script, state = build_script(world), moving_states(world, 50, seed=5)
    everybody = range(len(world.agents))
    whole = script.act(everybody, (), state)
    for times in (3, np.arange(50) % 4):  # branches of a state lie side by side
        assert (script.act(everybody, (), state[np.repeat(np.arange(50), times)]) == np.repeat(whole, times, 0)).all()
    monkeypatch.setattr(module, "GAMES_AT_ONCE", 7)
    assert (script.act(everybody, (), state) == whole).all()
    assert script.act(everybody, (), state[:0]).shape == (0, len(world.agents))


# --- what they cannot do


def test_there_is_no_script_for_other_worlds():
    with pytest.raises(InputError, match="no scripted expert") as error:
        build_script(SimpleNamespace(name="tennis", continuous=False))
    assert "tennis" in str(error.value)


def test_equal_games_and_half_the_digits_decide_as_each_game_alone_with_all_digits():
    """Equal games are looked at once, in float32 where that tells the best plan; near ties and far games among them."""
    landing, rng = Landing(find(f"{SPREAD},agents=2")), np.random.default_rng(3)
    near = rng.uniform(-1, 1, (4, 400)) * 10.0 ** rng.integers(-9, 4, 400)
    ties = np.repeat([[0.1], [0.1], [0.0], [0.0]], 20, axis=1) + rng.normal(0, 1e-9, (4, 20))
    seen = np.concatenate([np.repeat(near, rng.integers(1, 5, 400), axis=1), ties], axis=1)
    chosen = landing([0, 1], np.stack([seen[:2]] * 2), np.stack([seen[2:]] * 2))
    wanted = landing._costs(landing.force[0], seen, np.float64).argmin(axis=0) // landing.further
    assert chosen.T.tolist() == [wanted.tolist()] * 2 and set(wanted.tolist()) == set(range(5))
    assert landing([0], seen[None, :2, :0], seen[None, 2:, :0]).shape == (0, 1)


def test_roles_are_mixed_by_episode_and_in_the_share_that_is_asked_for():
    """Each episode has one kind of roles throughout, and acts as the script of that kind does."""
    world = find(SPREAD)
    start = world.start_from_seeds(range(4_000))
    for share in ("0", "0.25", "1"):
        mixed = build_script(world, f"mixed-roles-{share}")
        assert mixed.by_state(start).mean() == pytest.approx(float(share), abs=0.03)
    some = start[:300]
    mixed = build_script(world, "mixed-roles-0.5")
    which = mixed.by_state(some)
    played = play(world, [mixed] * 3, some)
    for state in played.states[::6]:
        assert (mixed.by_state(state) == which).all()
        actions = mixed.act(range(3), (), state)
        for rows, script in ((which, "scripted"), (~which, "fixed-roles")):
            assert (actions[rows] == build_script(world, script).act(range(3), (), state[np.flatnonzero(rows)])).all()
    assert 100 < which.sum() < 200


def test_roles_are_mixed_in_navigation_alone():
    with pytest.raises(InputError, match="in cooperative navigation alone"):
        build_script(find("physical-deception"), "mixed-roles-0.5")
