"""A user's environment as a world: like our games where it is the same game, and clear about whatever is wrong."""

import gc
import json
import multiprocessing
import re
import sys
import threading
from dataclasses import replace

import numpy as np
import pytest

from codegen import policy_json, profiles
from codegen.errors import InputError, ProfileError, UnknownNameError
from codegen.ir import NAME
from codegen.profiles import violations
from maviper.cli import main
from maviper.compilation import compile
from maviper.episodes import measures
from maviper.episodes.play import Policies, rollout
from maviper.evaluation import held_out
from maviper.experts.expert import AS_GIVEN
from maviper.extraction import refine
from maviper.extraction.algorithms import extract
from maviper.extraction.settings import EPISODES_PER_SEED, Settings
from maviper.worlds import find, find_built_in
from maviper.worlds.checking import Mark, check, usable
from maviper.worlds.matching import matching_world, not_ours
from maviper.worlds.outside import sources
from maviper.worlds.outside.making import import_maker, make_environment
from maviper.worlds.outside.pettingzoo import PROBE_STEPS, PettingZooWorld
from maviper.worlds.outside.playing import EnvStates
from maviper.worlds.outside.processes import Copies
from maviper.worlds.outside.sources import LOG_FILE, is_named_by_user, logging_output, parse_source
from maviper.worlds.outside.spaces import legal_names
from maviper.worlds.seeds import TRAINING, fold_seed
from maviper.worlds.world import world_name


@pytest.fixture(autouse=True)
def no_process_is_left(no_kept_processes):
    yield
    if multiprocessing.active_children():
        gc.collect()
    assert not multiprocessing.active_children()


@pytest.fixture
def here(monkeypatch):
    """One copy, in this process."""
    monkeypatch.setattr("maviper.worlds.outside.processes.cores", lambda: 1)


def world_of(text, games=1):
    text = f"tests.support.environments:{text}"
    return PettingZooWorld(import_maker(parse_source(text)), text, games)


@pytest.mark.parametrize("apart", [False, True])
def test_what_copies_print_goes_to_the_log_of_a_run(apart, tmp_path, capfd):
    source, said = parse_source("tests.support.hostile:make,mode=prints"), []
    copies = Copies(source, lambda: make_environment(import_maker(source), source), 2, apart)
    run, log = tmp_path / "a" / "run", tmp_path / "a" / "run" / LOG_FILE
    with logging_output(run, lambda *line: said.append(line)):
        assert not log.stat().st_size
        copies.ask("reset", [0, 1])
    copies.close()
    capfd.readouterr()  # outside a command, descriptor 1 is not ours
    assert said == [("output", f"of the environment: {log}")] and log.read_text(errors="replace").count("reset") == 2
    assert ("descriptor 1" in log.read_text(errors="replace")) is apart
    with logging_output(run, lambda *line: said.append(line)):
        pass
    assert len(said) == 1 and log.exists()


def test_a_run_whose_environment_prints_nothing_has_no_log(tmp_path):
    with pytest.raises(InputError, match="no such world"), logging_output(tmp_path / "a" / "run", print):
        raise InputError("no such world", "")
    assert not list(tmp_path.iterdir())
    (tmp_path / LOG_FILE).mkdir()
    with pytest.raises(InputError, match=r"cannot write environment\.log"), logging_output(tmp_path, print):
        pytest.fail("it cannot be written")


def played(world, state, actions):
    states = [state]
    for acted in actions:
        states.append(world.step(states[-1], acted))
    return states


# --- the same game


def test_deception_is_our_own_world_bit_for_bit_in_processes_of_its_own():
    ours, theirs = find_built_in("physical-deception"), world_of("adversary", games=2)
    assert theirs.agents == ours.agents and theirs.spec.episode_steps == ours.spec.episode_steps
    rng = np.random.default_rng(0)
    for _ in range(3):
        seeds = rng.integers(2**60, size=2)
        actions = rng.integers(5, size=(ours.spec.episode_steps, 2, 3))
        expected = played(ours, ours.start_from_seeds([fold_seed(int(seed)) for seed in seeds]), actions)
        found = played(theirs, theirs.start_from_seeds(seeds), actions)
        for a, b in zip(expected, found, strict=True):
            for seen, wanted in zip(theirs.observe(b), ours.observe(a), strict=True):
                assert seen.dtype == np.float32 and seen.tobytes() == np.ascontiguousarray(wanted).tobytes()
        rewards = [theirs.rewards(state) for state in found[1:]]
        for mine, state in zip(rewards, expected[1:], strict=True):
            assert np.array_equal(mine, ours.rewards(state))
        returns = np.sum(rewards, axis=0)
        assert np.allclose(theirs.values(found[1:]), [returns[:, 0], returns[:, 1:].mean(axis=1)])
        assert found[-1].done.all() and not found[-2].done.any()
    theirs.close()


def test_rollouts_are_split_into_as_many_games_as_there_are_copies():
    world = world_of("early", games=2)
    policies = Policies([lambda seen: (seen[:, 0] > 0).astype(int)] * 2)
    parts = rollout(world, [policies] * 2, range(5))
    assert [len(part.states[0]) for part in parts] == [2, 2, 1]
    alone = world_of("early")
    again = rollout(alone, [policies] * 2, range(5))
    assert np.array_equal(
        np.concatenate([part.values for part in parts], axis=1), np.concatenate([part.values for part in again], axis=1)
    )


# --- states


def test_an_agent_that_is_done_keeps_its_last_observation_and_gains_nothing():
    world = world_of("early")
    states = played(world, world.start_from_seeds([7]), np.full((world.spec.episode_steps, 1, 2), 2))
    done = np.array([state.done[0] for state in states])
    assert done[:, 0].tolist() == [False] * 3 + [True] * 6 and done[:, 1].tolist() == [False] * 8 + [True]
    left = np.array([world.observe(state)[0][0] for state in states])
    assert left[:, 1].tolist() == [0, 1, 2, 3, 3, 3, 3, 3, 3]
    assert np.array([world.observe(state)[1][0][1] for state in states]).tolist() == list(range(9))
    rewards = np.array([world.rewards(state)[0] for state in states])
    assert rewards[0].tolist() == [0, 0] and (rewards[1:4, 0] < 0).all() and not rewards[4:, 0].any()
    assert (rewards[1:, 1] < 0).all()
    assert np.allclose(world.values(states[1:])[:, 0], rewards.sum(axis=0))
    after = world.step(states[-1], np.zeros((1, 2), int))  # a longer episode than the environment's adds nothing
    assert not world.rewards(after).any() and after.done.all()
    assert np.array_equal(world.observe(after)[1], world.observe(states[-1])[1])


def test_only_the_newest_state_can_be_stepped():
    world, other = world_of("early"), world_of("early")
    start = world.start_from_seeds([1])
    actions = np.zeros((1, 2), int)
    newest = world.step(start, actions)
    foreign = other.start_from_seeds([1])
    for old in (start, newest[:], EnvStates.concatenate([newest]), foreign):
        with pytest.raises(RuntimeError, match="newest"):
            world.step(old, actions)
    world.close()
    with pytest.raises(RuntimeError, match="newest"):
        world.step(newest, actions)
    assert len(world.start(1, np.random.default_rng(0))) == 1
    with pytest.raises(AssertionError):
        world.start(2, np.random.default_rng(0))


# --- seeds


def test_an_environment_that_takes_seeds_below_two_to_the_32_is_played_for_every_purpose(monkeypatch, here):
    """Rollouts, selection, refinement, evaluation and training, with the largest seed of an extraction."""
    monkeypatch.setattr(held_out, "EVALUATION_EPISODES", 2)
    for name, value in (("FIRST", 2), ("LAST", 2), ("MOVES", 2)):
        monkeypatch.setattr(refine, name, value)
    world = world_of("small_seeds")
    settings = Settings(max_depth=2, iterations=2, rollouts=2, selection_episodes=2, seed=2**32 - 1)
    rounds = replace(settings, refinement=2 * refine.round_cost())
    assert extract(world, Expert(world), rounds).provenance.training["refinement_episodes"]
    assert len(world.start(1, np.random.default_rng(0))) == 1
    for algorithm in ("fitted-q", "imitation", "iviper"):
        extract(world, Expert(world), replace(settings, algorithm=algorithm))


def test_seeds_that_are_too_large_are_refused_before_any_work(tmp_path, capsys):
    """The last of several: 2**32 is one too many."""
    out = tmp_path / "out"
    few = ["--iterations", "1", "--rollouts", "2", "--set", "selection_episodes=2", "--preset", "paper"]
    for command in (["extract", *few], ["train"]):
        asked = [*command, "physical-deception", "--seed", str(2**32 - 1), "--seeds", "2", "-o", str(out)]
        assert main.run(asked) == 2
        assert "from 0 to 4294967295" in capsys.readouterr().err and not list(tmp_path.rglob("seed-*"))


def test_seeds_of_different_purposes_stay_apart():
    """Held-out ones are as they are told; those of one extraction are as many as before; trainings have their own."""
    held_out = range(max(measures.ON_POLICY_SEEDS, measures.MEASUREMENT_SEEDS) + 10**6)
    assert all(fold_seed(seed) == seed for seed in (0, held_out.stop, 2**31 - 1)) and held_out.stop < TRAINING[0]
    purposes = (measures.ROLLOUT_SEEDS, measures.SELECTION_SEEDS, measures.REFINEMENT_SEEDS)
    places = []
    for purpose in purposes:
        for seed in (0, 1, 2_684, 2**32 - 1):
            found = {fold_seed(each) for each in Settings(seed=seed).episodes(purpose)}
            assert len(found) == EPISODES_PER_SEED and TRAINING[1] <= min(found) and max(found) < 2**31
            places.append((purpose, min(found) // 2**28, max(found) // 2**28))
    blocks = [{block for name, *both in places if name == purpose for block in both} for purpose in purposes]
    assert [len(block) for block in blocks] == [1, 1, 1] and len(set.union(*blocks)) == 3


def test_trainings_draw_from_seeds_of_their_own(here, monkeypatch):
    world, asked = world_of("early"), []
    monkeypatch.setattr(world, "_ask_copies", lambda verb, seeds: asked.extend(seeds))
    for each in range(1_000):
        world.start(1, np.random.default_rng(each))
    assert TRAINING[0] <= min(asked) and max(asked) < TRAINING[1] and len(set(asked)) > 990


# --- what the environment says about itself


def test_what_an_environment_says_is_in_the_world():
    world = world_of("described,max_steps=4")
    assert world.env_agents == ("left runner", "runner_1") and world.agents == ("left_runner", "runner_1")
    assert world.teams == {"first_": ("runner_1",), "second": ("left_runner",)}
    assert [measure.label for measure in world.measures] == ["first_ return", "second return"]
    assert world.spec.episode_steps == 4 and world.length_known
    assert str(world.features[1][0].meaning) == "runner_1.x" and world.features[0][0].meaning is None
    assert world.features[0][0].name == "feature_0" and (world.features[0][0].low, world.features[0][0].high) == (
        -20,
        20,
    )
    assert world.actions[0][2].name == "action_2" and world.actions[0][2].effect is None


@pytest.mark.parametrize(
    ("text", "steps", "known"),
    [("described", 6, True), ("short,length=5", 5, True), ("vanishing", PROBE_STEPS, False), ("spread", 25, True)],
)
def test_how_long_episodes_are(text, steps, known):
    world = world_of(text)
    assert (world.spec.episode_steps, world.length_known) == (steps, known)


@pytest.mark.parametrize(
    ("text", "teams"),
    [
        ("shared", {"team": ("left", "right", "third_0")}),
        ("shared,rewards=pairs", {"team_0": ("left", "right"), "third": ("third_0",)}),
        ("shared,rewards=own", {"left": ("left",), "right": ("right",), "third": ("third_0",)}),
        ("shared,rewards=nothing", {"left": ("left",), "right": ("right",), "third": ("third_0",)}),
        ("shared,wrap=rivals", {"left": ("left",), "right": ("right",), "third_0": ("third_0",)}),
    ],
)
def test_agents_with_equal_rewards_are_one_team(text, teams):
    """They were rivals, and MAVIPER voted and measured among opponents."""
    name = f"tests.support.environments:{text}"
    assert find(name).teams == teams
    (said,) = [str(each) for each in check(name) if each.what.startswith("teams: ")]
    assert ("equal rewards in a random episode" in said) == any(team.startswith("team") for team in teams)


def test_unbounded_observations_have_the_widest_range():
    assert {(feature.low, feature.high) for feature in world_of("spread").features[0]} == {(-1e9, 1e9)}


def test_names_become_legal_and_stay_apart():
    given = ["a b", "a_b", "A-b", "0", "", "a b", "ä" * 90, "_x"]
    found = legal_names(given, "agent")
    assert found == ("a_b", "a_b_2", "A-b_3", "agent_0", "agent_", "a_b_4", "agent__", "agent__x")
    assert all(NAME.fullmatch(name) for name in found)


# --- whatever may be wrong


@pytest.mark.parametrize("games", [1, 2])
def test_an_environment_that_raises_is_an_input_error(games):
    text = "tests.support.environments:raising,max_steps=5"
    with pytest.raises(InputError, match="step raised ArithmeticError: the line is broken") as caught:
        world_of("raising")  # already while its length is looked for
    world = world_of("raising,max_steps=5", games)
    for _ in range(2):  # and again, with fresh copies
        states = played(world, world.start_from_seeds(range(games)), np.zeros((2, games, 2), int))
        with pytest.raises(InputError, match="step raised ArithmeticError: the line is broken") as caught:
            world.step(states[-1], np.zeros((games, 2), int))
        assert re.fullmatch(rf"{text}: .*environments\.py:\d+, in step", caught.value.where)
        assert "worlds check" in caught.value.next_step
        assert not multiprocessing.active_children()


def test_all_agents_must_be_there_at_the_start():
    world = world_of("late")
    with pytest.raises(InputError, match="no observation of runner_1") as caught:
        world.start_from_seeds([1])
    assert "from the start" in caught.value.next_step


def test_who_is_dropped_without_a_word_has_left_for_good():
    """Not done by the environment's own flags, and in `agents` again later: it is over, and was not cut."""
    world = world_of("dropping")
    states = played(world, world.start_from_seeds([1]), np.ones((5, 1, 2), int))
    assert [world.alive(state)[0].tolist() for state in states] == [[True, True]] * 2 + [[True, False]] * 4
    assert world.terminated(states[-1]).tolist() == [[False, True]] and world.alive(states[-1]).any()


def test_a_world_that_is_forgotten_ends_its_processes():
    world = world_of("early", games=2)
    world.start_from_seeds([1, 2])
    assert len(multiprocessing.active_children()) == 2
    del world
    gc.collect()
    assert not multiprocessing.active_children()


def test_a_world_may_be_collected_while_output_is_put_aside(monkeypatch, here):
    """That happens wherever memory is asked for, and closes its copies."""
    monkeypatch.setattr("maviper.worlds.outside.processes.WAKING", 10.0)  # seconds, so that copies play here
    worlds = [find("tests.support.environments:early")]
    worlds[0].start_from_seeds([1])
    assert not worlds[0]._copies.apart

    def collecting():
        worlds.clear()
        gc.collect()

    monkeypatch.setattr(sources, "open_log", collecting)
    before, waiting = (
        sys.stdout,
        threading.Thread(target=import_maker, args=[parse_source("tests.support.environments:spread")], daemon=True),
    )
    waiting.start()
    waiting.join(30)
    assert not waiting.is_alive() and not worlds and sys.stdout is before


def test_quick_copies_play_here_and_slow_ones_apart_with_the_same_outcomes(monkeypatch, here):
    monkeypatch.setattr("maviper.worlds.outside.processes.cores", lambda: 2)
    actions = np.random.default_rng(3).integers(3, size=(8, 2, 2))
    found = {}
    for waking in (10.0, -10.0):  # seconds: so slow, and so fast, that either is the quicker way
        monkeypatch.setattr("maviper.worlds.outside.processes.WAKING", waking)
        world = find("tests.support.environments:early")
        states = played(world, world.start_from_seeds([4, 5]), actions)
        assert bool(multiprocessing.active_children()) == (waking < 0) == world._copies.apart
        found[waking] = [np.concatenate([*world.observe(state), world.rewards(state)], axis=1) for state in states]
        world.close()
        assert not multiprocessing.active_children()
    assert all(a.tobytes() == b.tobytes() for a, b in zip(*found.values(), strict=True))


def test_copies_that_would_disturb_each_other_play_apart(monkeypatch, here):
    """They draw from numpy's one generator, so an episode follows from its seed only where it is alone."""
    monkeypatch.setattr("maviper.worlds.outside.processes.cores", lambda: 2)
    monkeypatch.setattr("maviper.worlds.outside.processes.WAKING", 10.0)
    world = find("tests.support.environments:disturbing")
    actions = np.ones((5, 2, 2), int)
    together = played(world, world.start_from_seeds([4, 5]), actions)
    assert world._copies.apart
    alone = PettingZooWorld(world._function, world.name, games=1)
    for row, seed in enumerate((4, 5)):
        for mine, theirs in zip(played(alone, alone.start_from_seeds([seed]), actions[:, :1]), together, strict=True):
            assert mine.observations[0][0].tobytes() == theirs.observations[0][row].tobytes()
    world.close()


@pytest.mark.parametrize(("says", "games", "apart"), [("True", 4, True), ("machine", 1, False)])
def test_an_environment_may_say_that_it_must_be_alone(monkeypatch, says, games, apart):
    """Then nothing is tried."""
    monkeypatch.setattr("maviper.worlds.outside.processes.cores", lambda: 4)
    monkeypatch.setattr("maviper.worlds.outside.processes.may_share", lambda *given: pytest.fail("it was tried"))
    world = find(f"tests.support.environments:solitary,says={says}")
    assert (world.games, world._copies.apart) == (games, apart)


def test_functions_that_other_processes_cannot_import_are_played_here(monkeypatch):
    from tests.support import environments

    monkeypatch.setattr("maviper.worlds.outside.processes.cores", lambda: 4)
    assert PettingZooWorld(environments.early, "tests.support.environments:early").games == 4
    assert PettingZooWorld(lambda: environments.early(), "tests.support.environments:early").games == 1
    assert PettingZooWorld(environments.early, "__main__:early").games == 1


def test_what_an_environment_prints_is_not_output(capsys):
    world = world_of("talking")
    world.start_from_seeds([1])
    out, err = capsys.readouterr()
    assert out == "" and "hello from the function" in err and "hello from the environment" in err


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("tests.enviroments:spread", "no module 'tests.enviroments'"),
        ("nowhere.at_all:make", "no module 'nowhere'"),
        ("tests.support.environments:sread", "did you mean 'spread'"),
        ("tests.support.environments:Discrete.n", "module:function"),
        ("tests/support/environments.py:spread", "module:function"),
        ("tests.support.environments:", "module:function"),
        ("tests.support.environments:spread,", "cannot read the option ''"),
        ("tests.support.environments:spread,N=", "cannot read the option 'N='"),
        ("tests.support.environments:spread,n=3", "spread raised TypeError.*'n'"),
        ("tests.support.environments:short,lenght=3", "unknown option 'lenght'\n.*\ndid you mean 'length'"),
        ("tests.support.environments:early,n=3", "unknown option 'n'\n.*\nknown: max_steps"),
        ("tests.support.environments:short", "short raised TypeError"),
        ("tests.support.environments:early,max_steps=0", "max_steps is '0'"),
        ("tests.support.environments:early,max_steps=many", "max_steps is 'many'"),
        ("tests.support.environments:nothing", "returns a str, not a PettingZoo environment"),
        ("tests.support.environments:in_turns", "AEC.*\n.*\n.*aec_to_parallel"),
        ("tests.support.environments:continuous", "some agents give numbers, others choose"),
        ("tests.support.environments:leaving", "leaving raised SystemExit: this is a script"),
        ("tests.support.environments:mistaken_teams", "teams do not match its agents"),
        ("tests.support.environments:misdescribed", r"did you mean 'runner_1\.x'"),
    ],
)
def test_a_name_that_leads_to_no_world_is_an_input_error(name, message):
    with pytest.raises(InputError) as caught:
        find(name)
    assert re.search(message, str(caught.value)) and caught.value.next_step


def test_the_current_folder_is_importable_and_broken_modules_are_named(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", list(sys.path))
    (tmp_path / "lying_here.py").write_text("from tests.support.environments import short as make\n")
    (tmp_path / "broken_here.py").write_text("import no_such_library\n")
    assert find("lying_here:make,length=2").spec.name == "lying_here-make"
    with pytest.raises(InputError, match="importing broken_here raised ModuleNotFoundError: No module named 'no_such"):
        find("broken_here:make")


# --- checking


@pytest.mark.parametrize(
    ("text", "mark", "message"),
    [
        ("spread", Mark.MISSING, "meanings: .*; claims can only be about observations"),
        ("early", Mark.OK, "names: .*left runner is left_runner"),
        ("early", Mark.OK, "teams: left: left_runner; runner: runner_1"),
        ("early", Mark.OK, "repeats: "),
        ("vanishing", Mark.MISSING, "episode length: .*max_steps=NUMBER"),
        ("small_space", Mark.WRONG, "left runner's number 1 is 2 at step 2, outside its space"),
        ("not_a_number", Mark.WRONG, "left runner observes NaN, number 0"),
        ("continuous", Mark.WRONG, r"observations: left runner: the space has shape \(2, 2\)"),
        ("raising", Mark.WRONG, r"step raised ArithmeticError: the line is broken \(.*environments.py:\d+, in step\)"),
        ("nondeterministic", Mark.WRONG, "repeats: .* from its start on"),
        ("small_seeds", Mark.OK, "reset: with a seed"),
        ("tiny_seeds", Mark.WRONG, "reset: takes seed 0 but not .*too large.*default_rng"),
        ("late", Mark.WRONG, "reset: no observation of runner_1, or missing from `agents`; all of possible_agents"),
        ("in_turns", Mark.WRONG, "AEC.*aec_to_parallel"),
        ("nothing", Mark.WRONG, "not a PettingZoo environment"),
        ("misdescribed", Mark.WRONG, "did you mean 'runner_1.x'"),
        ("sread", Mark.WRONG, "unknown function.*did you mean 'spread'"),
    ],
)
def test_check_finds(here, text, mark, message):
    found = check(f"tests.support.environments:{text}")
    assert any(each.mark is mark and re.search(message, str(each)) for each in found), "\n".join(map(str, found))
    assert usable(found) == (mark is not Mark.WRONG)
    assert all(each.next_step for each in found if each.mark is not Mark.OK)


def test_check_plays_in_a_process_of_its_own(monkeypatch):
    monkeypatch.setattr("maviper.worlds.outside.processes.cores", lambda: 2)
    assert usable(check("tests.support.environments:described"))
    assert "ended by itself" in str(check("tests.support.environments:dying")[-1])


@pytest.mark.parametrize("name", ["physical-deception", "cooperative-navigation,agents=2"])
def test_check_compares_our_own_games_with_the_reference(name):
    found = check(name)
    assert {each.mark for each in found} == {Mark.OK}
    assert any("the same observations after reset" in each.what for each in found)


def test_the_command(here, capsys):
    assert main.run(["worlds", "check", "tests.support.environments:early"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == "ok       import: tests.support.environments:early" and lines[-1].startswith(
        "missing  meanings: "
    )
    assert main.run(["worlds", "check", "tests.support.environments:nondeterministic"]) == 2
    assert "\nwrong    repeats: " in capsys.readouterr().out
    assert main.run(["worlds", "check", "physical-decption"]) == 2
    assert "did you mean 'physical-deception'" in capsys.readouterr().err
    assert main.run(["worlds", "show", "tests.support.environments:described"]) == 0
    out = capsys.readouterr().out
    assert "tests.support.environments:described, after tests.support.environments:described, 6 steps\n" in out
    assert "no meaning" in out and "[-20, 20]  runner_1.x" in out


# --- the whole path


class Expert:
    """Runs towards the middle, as its critic would have it."""

    card: dict = {}  # noqa: RUF012
    hash = ""
    centralized = True

    def __init__(self, world):
        self.agents = world.agents

    def act(self, agents, observations, state):
        assert len(state) == len(observations[0])
        return np.stack([np.where(observations[agent][:, 0] > 0, 0, 2) for agent in agents], axis=1)

    def q(self, agent, observations, state, joint, given):
        wanted = self.act([agent], observations, state)[:, 0]
        own = np.where(joint[:, agent] == AS_GIVEN, given[:, agent, None], joint[None, :, agent])
        return -np.abs(own - wanted[:, None]).astype(float)


@pytest.fixture(scope="module")
def extracted():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(held_out, "EVALUATION_EPISODES", 10)
        world = world_of("early", games=2)
        settings = Settings(max_depth=2, iterations=2, rollouts=4, selection_episodes=4)
        profile = extract(world, Expert(world), settings)
        world.close()
    return profile


@pytest.mark.compile
@pytest.mark.usefixtures("few_observations")
def test_a_profile_is_extracted_and_compiles(extracted):
    assert not list(violations(extracted))
    assert policy_json.content_hash(profiles.loads(policy_json.dumps(extracted))) == policy_json.content_hash(extracted)
    assert (
        extracted.world.reference == "tests.support.environments:early"
        and extracted.world.name == "tests-support-environments-early"
    )
    seen = np.array([[-3.0, 0, 0], [4.0, 2, 0]], np.float32)
    for policy in extracted.agents:
        assert Policies([lambda obs, p=policy: compile.ir.act(p, obs)]).act([0], [seen], None).tolist() == [[2], [0]]
    compiled = compile.compile_profile(extracted)
    assert compiled.elsewhere == not_ours(extracted.world) and compiled.complete
    assert extracted.world.reference in compiled.elsewhere and all(len(each.seen) == 3 for each in extracted.agents)
    assert {"c", "python", "json"} <= {item.target for item in compiled.report.agreements}


def test_a_data_file_never_causes_an_import(extracted, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", [str(tmp_path), *sys.path])
    (tmp_path / "hostile_module.py").write_text("raise AssertionError('imported')\n")
    named = replace(extracted, world=replace(extracted.world, name="hostile_module", reference="hostile_module:make"))
    for options in ({}, {"x": "hostile_module:make"}, {"hostile_module:make": 1}):
        sneaky = replace(named, world=replace(named.world, options=options))
        assert not is_named_by_user(world_name(sneaky.world))
        assert matching_world(sneaky) is None
        compile.compile_profile(sneaky, ["json"])
    document = json.loads(policy_json.dumps(extracted))
    del document["content_hash"]
    document["world"]["name"] = "hostile_module:make"
    with pytest.raises(ProfileError, match="not a valid policy profile"):
        profiles.loads(json.dumps(document))
    with pytest.raises(UnknownNameError):
        find_built_in("hostile_module:make")
    assert "hostile_module" not in sys.modules
