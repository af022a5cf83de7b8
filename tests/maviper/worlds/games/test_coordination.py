"""Coordination games: the rules, the reference environment, the script, and the whole way from expert to code."""

import json
from itertools import product

import numpy as np
import pytest

from codegen.errors import ExitCode, InputError, UnknownNameError
from codegen.profiles import loads
from maviper.cli import main
from maviper.episodes.play import play
from maviper.experts.finding import find_expert
from maviper.experts.scripted import build_script
from maviper.extraction.growth.weights import iviper_weights, maviper_weights
from maviper.worlds import find, parallel_env
from maviper.worlds.matching import matching_places, matching_world

VARIANTS = [
    "coordination",
    "coordination,agents=2,conventions=4,levels=4,signals=2,table=9",
    "coordination,agents=6,kinds=3,noise=20,blur=30,payoff=40,agree=30",
    "coordination,levels=3,noise=7,payoff=0",
    "coordination,agents=4,rule=climbing",
    "coordination,agents=2,noise=5,rule=penalty,table=3",
]
SEEDS = [*range(200), 2**29, 2**31 - 1, 10**15, 3 * 10**15 + 99_999]


def paid(name, roles):
    """The payoff of roles, which are conventions where the first is demanded, by the game's own function."""
    return find(name).payoff(np.array([roles]))[0]


@pytest.mark.parametrize("name", VARIANTS)
def test_equals_the_reference_environment(name):
    world, rng = find(name), np.random.default_rng(0)
    env = world.reference_env()
    acted = rng.integers(world.conventions, size=(len(SEEDS), len(world.agents)))
    state = world.start_from_seeds(SEEDS)
    seen, after = world.observe(state), world.step(state, acted)
    rewards = world.rewards(after)
    for row, seed in enumerate(SEEDS):
        observations, _ = env.reset(seed=seed)
        assert [observations[agent].tobytes() for agent in world.agents] == [each[row].tobytes() for each in seen]
        _, given, ended, cut, _ = env.step(dict(zip(world.agents, acted[row].tolist(), strict=True)))
        assert list(given.values()) == pytest.approx(rewards[row].tolist(), abs=1e-12)
        assert all(ended.values()) and not any(cut.values()) and not env.agents
    handed_out, _ = parallel_env(name).reset(seed=SEEDS[0])
    assert [handed_out[agent].tobytes() for agent in world.agents] == [each[0].tobytes() for each in seen]
    assert world.alive(state).all() and not world.alive(after).any()
    assert not world.terminated(state).any() and world.terminated(after).all()


@pytest.mark.filterwarnings("ignore::DeprecationWarning", "ignore::UserWarning")  # PettingZoo's tests warn of its games
def test_the_reference_environment_is_one_of_pettingzoo():
    from pettingzoo.test import parallel_api_test, parallel_seed_test

    make = find("coordination,noise=20").reference_env
    parallel_api_test(make(), num_cycles=20)
    parallel_seed_test(make, num_cycles=5)


@pytest.mark.parametrize("name", VARIANTS)
def test_readings_are_as_likely_as_said(name):
    world = find(name)
    state = world.start(40_000, np.random.default_rng(0))
    for agent in (0, 1):
        likelihood = world.likelihood(world.kind(agent))
        assert likelihood.sum(axis=1) == pytest.approx(np.ones(len(world.cells)))
        found = np.zeros_like(likelihood)
        np.add.at(found, (state.hidden, world.cell(state.readings[:, agent])), 1 / len(state))
        assert found == pytest.approx(likelihood / len(world.cells), abs=0.01)


def test_who_reads_what_clearly():
    world = find("coordination,agents=4,signals=4,noise=3,blur=10")
    assert [world.kind(agent) for agent in range(4)] == [0, 1, 0, 1]
    assert world.errors.tolist() == pytest.approx(np.array([[0.03, 0.13, 0.03, 0.13], [0.13, 0.03, 0.13, 0.03]]))


@pytest.mark.parametrize("table", range(5))
def test_every_convention_is_demanded_as_often_as_any(table):
    counts = np.bincount(find(f"coordination,table={table}").demanded, minlength=3)
    assert sorted(counts) == [2, 3, 3]
    assert find("coordination,table=1").demanded.tolist() != find("coordination,table=2").demanded.tolist()


def test_payoffs_by_hand():
    for roles, right, together in (([0, 0, 0], 1, 1), ([0, 0, 2], 2 / 3, 0), ([1, 1, 1], 0, 0.5), ([1, 2, 1], 0, 0)):
        assert paid("coordination,payoff=0", roles) == pytest.approx(right)
        assert paid("coordination,agree=50", roles) == pytest.approx(together)
        assert paid("coordination,agree=50,payoff=25", roles) == pytest.approx(0.75 * right + 0.25 * together)
        assert paid("coordination", roles) == (1 if right == 1 else 0)


CLIMBING = [[11, -30, 0], [-30, 7, 6], [0, 0, 5]]  # Claus and Boutilier 1998, the first agent in rows
PENALTY = [[10, 0, -10], [0, 2, 0], [-10, 0, 10]]  # k = -10


@pytest.mark.parametrize(("rule", "table"), [("climbing", CLIMBING), ("penalty", PENALTY)])
def test_the_games_of_claus_and_boutilier(rule, table):
    for a, b in product(range(3), repeat=2):
        assert paid(f"coordination,agents=2,rule={rule}", [a, b]) == table[a][b]
    three = (table[0][1] + table[0][2] + table[1][2]) / 3
    assert paid(f"coordination,rule={rule}", [0, 1, 2]) == pytest.approx(three)


def test_options_that_do_not_go_together():
    for name, what in (
        ("rule=climbing,conventions=2", "climbing has 3 conventions"),
        ("rule=penalty,payoff=50", "payoffs of its own"),
        ("rule=penalty,agree=5", "payoffs of its own"),
        ("agents=7", "give a number from 2 to 6"),
        ("agents=1", "give a number from 2 to 6"),
        ("payoff=101", "give a number from 0 to 100"),
    ):
        with pytest.raises(InputError, match=what):
            find(f"coordination,{name}")
    with pytest.raises(UnknownNameError, match="climbing"):
        find("coordination,rule=climbin")


def test_measures():
    world = find("coordination,payoff=50")
    state = world.start_from_seeds(range(3))
    wanted = world.demanded[state.hidden][:, None]
    acted = (wanted + np.array([[0, 0, 0], [0, 1, 2], [1, 1, 1]])) % 3
    payoff, right, all_right = world.values([world.step(state, acted)])
    assert payoff.tolist() == pytest.approx([1, 1 / 6, 0])
    assert right.tolist() == pytest.approx([1, 1 / 3, 0]) and all_right.tolist() == [1, 0, 0]


# --- the expert


def test_the_script_takes_its_own_reading_for_what_is_hidden():
    """Without noise it is always right; with it, exactly as often as its reading demands the same."""
    world = find("coordination,kinds=1")
    found = play(world, [build_script(world)] * 3, world.start_from_seeds(range(500)))
    assert (found.values == 1).all()
    world = find("coordination,noise=20,agents=2")
    state = world.start_from_seeds(range(100))
    script = build_script(world)
    acted = script.act([1, 0], world.observe(state), state)
    for row in range(100):
        for column, agent in enumerate((1, 0)):
            (cell,) = np.flatnonzero((world.cells == state.readings[row, agent]).all(axis=1))
            assert acted[row, column] == world.demanded[cell]


def test_q_is_the_payoff_of_the_joint_action_that_is_asked_for():
    expert, world = find_expert("coordination,noise=10,agree=40,payoff=60")
    state = world.start_from_seeds(range(50))
    observations = world.observe(state)
    joint = np.array(list(product(range(3), repeat=3)))
    found = expert.q(1, observations, state, joint, np.zeros((50, 3), dtype=np.int64))
    for column, actions in enumerate(joint):
        roles = (actions - world.demanded[state.hidden][:, None]) % 3
        assert found[:, column] == pytest.approx(world.payoff(roles))


def test_weights_say_when_an_agent_matters():
    """All or nothing among right experts: everything hangs on each agent. IVIPER sees all of it, MAVIPER the share of
    the others' joint actions, uniform ones, in which both others are right.
    """
    expert, world = find_expert("coordination,kinds=1")
    state = world.start_from_seeds(range(20))
    seen, wanted = world.observe(state), world.demanded[state.hidden][:, None].repeat(3, axis=1)
    assert iviper_weights(world, expert, seen, state, wanted, 0) == pytest.approx(np.ones(20))
    assert maviper_weights(world, expert, seen, state, wanted) == pytest.approx(np.full((20, 3), 1 / 9))


# --- like any other world


@pytest.mark.compile
@pytest.mark.usefixtures("few_observations")
def test_from_the_expert_to_code(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    few = ("--max-episodes", "400", "--max-depth", "2")
    assert main.run(["-q", "extract", "coordination,agents=2", *few, "-o", "team.json"]) == ExitCode.DONE
    profile = loads((tmp_path / "team.json").read_bytes(), "team.json")
    assert matching_world(profile).name == "coordination,agents=2" and matching_places(profile) is None
    assert main.run(["-q", "evaluate", "team.json", "--expert", "coordination,agents=2", "--json"]) == ExitCode.DONE
    assert json.loads(capsys.readouterr().out)["world"]
    assert main.run(["-q", "compile", "team.json", "-o", "code"]) == ExitCode.DONE
    assert "skipped" not in capsys.readouterr().err


def test_claims_about_places_are_refused(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert (
        main.run(["-q", "extract", "coordination,agents=2", "--max-episodes", "100", "-o", "team.json"])
        == ExitCode.DONE
    )
    for command in (
        ["repair", "team.json", "-o", "repaired"],
        ["verify", "--new", "coordination"],
    ):
        capsys.readouterr()
        assert main.run(command) == ExitCode.INPUT
        assert "claims speak of places and landmarks, and coordination has none" in capsys.readouterr().err
