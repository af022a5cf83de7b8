"""The physics of the authors' fork: bit for bit those of a plain referee, and refused where they do not count."""

import json

import numpy as np
import pytest

from codegen import policy_json, profiles
from codegen.errors import InputError, UnknownNameError
from maviper import manual
from maviper.cli import main
from maviper.evaluation import held_out
from maviper.evaluation.players import find_player, find_shipped
from maviper.experts.finding import find_expert
from maviper.extraction.algorithms import extract
from maviper.extraction.settings import Settings
from maviper.page.page import unplayable
from maviper.worlds import find
from maviper.worlds.matching import matching_world
from tests.benchmarks import physics
from tests.support.fork import ForkEnv, adversary, spread, tag
from tests.support.games import crowded
from verify.claims.claim import verifiable

FORK = "physics=released"
GAMES = {
    f"physical-deception,{FORK}": adversary,
    f"physical-deception,defenders=3,{FORK}": lambda: adversary(3),
    f"cooperative-navigation,{FORK}": spread,
    f"cooperative-navigation,agents=5,{FORK}": lambda: spread(5),
    f"predator-prey,{FORK}": tag,
    f"predator-prey,prey=1,predators=3,{FORK}": lambda: tag(3, 1),
}


def played(world, bodies, state, steps, rng, **changes):
    """Whether the simulator's states are the referee's after each step of each game, bit for bit."""
    alike = []
    for row in range(len(state)):
        env = ForkEnv(bodies(), **changes)
        env.reset(state.position[row], state.velocity[row])
        now = state[row : row + 1]
        for _ in range(steps):
            actions = rng.integers(5, size=(1, len(world.agents)))
            now = world.step(now, actions, exact=True)
            position, velocity = env.step(actions[0])
            alike.append((now.position[0] == position).all() and (now.velocity[0] == velocity).all())
    return alike


@pytest.mark.parametrize("name", GAMES)
def test_episodes_are_the_referees_bit_for_bit(name):
    world, rng = find(name), np.random.default_rng(1)
    assert all(played(world, GAMES[name], world.start_from_seeds(range(8)), 25, rng))


@pytest.mark.parametrize("name", GAMES)
def test_steps_in_crowds_and_at_speed_are_the_referees(name):
    """Also through contacts, from states that touch and move faster than allowed."""
    world = find(name)
    state = crowded(world, 60, 3)
    assert all(played(world, GAMES[name], state, 2, np.random.default_rng(2)))


@pytest.mark.parametrize("changes", [{"velocity_first": False}, {"twice": False}])
def test_a_referee_without_one_of_the_two_disagrees(changes):
    name = f"predator-prey,{FORK}"
    world = find(name)
    assert not any(played(world, tag, world.start_from_seeds(range(4)), 3, np.random.default_rng(1), **changes)[1::3])


def test_accelerations_that_no_game_states_count_once():
    assert [entity.force for entity in find(f"predator-prey,{FORK}").spec.agents] == [9.0, 9.0, 16.0, 16.0]
    for name in ("physical-deception", "cooperative-navigation"):
        moved, plain = find(f"{name},{FORK}"), find(name)
        assert {entity.force for entity in moved.spec.agents} == {5.0} and moved.features == plain.features


def test_its_spec_states_no_motion():
    """So nobody who reads a spec steps it as mpe2 does."""
    spec = find(f"physical-deception,{FORK}").spec
    assert (spec.dt, spec.damping) == (0.0, 0.0) and "fork" in spec.reference
    assert find("physical-deception,physics=mpe2").spec == find("physical-deception").spec


@pytest.mark.parametrize(
    ("name", "error", "said"),
    [
        ("predator-prey,physics=relased", UnknownNameError, "did you mean 'released'"),
        (f"cooperative-navigation,features=coasting,{FORK}", InputError, "comes to rest by mpe2's physics"),
        (f"coordination,{FORK}", UnknownNameError, "option"),
    ],
)
def test_what_there_is_not(name, error, said):
    with pytest.raises(error, match=said):
        find(name)


@pytest.mark.parametrize("text", ["predator-prey,physics=released@maddpg", "predator-prey,physics=released"])
def test_experts_of_the_plain_game_play_there(text):
    expert, world = find_expert(text)
    plain, _ = find_expert(text.replace(f",{FORK}", ""))
    assert world.name == f"predator-prey,{FORK}" and expert.hash == plain.hash
    player = find_shipped(expert.hash, world)
    assert player is not None and player.id == expert.hash
    assert find_player("predator-prey@maddpg", "--against", world)[1] is world


@pytest.fixture(scope="module")
def profile():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(held_out, "EVALUATION_EPISODES", 8)
        expert, world = find_expert("physical-deception,physics=released@maddpg")
        small = {"algorithm": "imitation", "preset": "paper", "iterations": 1, "rollouts": 4, "max_depth": 2}
        return extract(world, expert, Settings.of({**small, "selection_episodes": 4}, world))


def test_a_profile_finds_its_world_again(profile):
    again = profiles.loads(policy_json.dumps(profile))
    world = matching_world(again)
    assert (
        again.world.options == {"physics": "released"}
        and world is not None
        and world.name == find(f"physical-deception,{FORK}").name
    )


def test_claims_and_pages_are_refused_by_name(profile, tmp_path, capsys):
    with pytest.raises(InputError, match=r"claims cover mpe2's motion.*physics=released"):
        verifiable(profile, "defenders")
    assert "physics=released" in unplayable(profile)
    place = tmp_path / "trees.json"
    place.write_text(policy_json.dumps(profile))
    for command in (["verify", str(place)], ["play", str(place), "-o", str(tmp_path / "page.html")]):
        assert main.run(command) == 2, command
        assert "physics=released" in capsys.readouterr().err
    assert main.run(["evaluate", str(place), "--episodes", "20"]) == 0
    assert "defenders" in capsys.readouterr().out


def test_claims_over_observations_are_asked(profile, tmp_path):
    """They say nothing of motion."""
    place = tmp_path / "trees.json"
    place.write_text(policy_json.dumps(profile))
    (tmp_path / "claims.toml").write_text('[[property]]\nformula = "acts(agent_0) in [stay, left, right, down, up]"\n')
    words = ["verify", str(place), "--observations", "--properties", str(tmp_path / "claims.toml")]
    assert main.run([*words, "--region", "ranges", "--verdict-only"]) == 0


def test_worlds_show_and_check_say_it(capsys):
    assert main.run(["worlds", "show", f"predator-prey,{FORK}"]) == 0
    assert "physics=released: velocities change first" in capsys.readouterr().out
    assert main.run(["worlds", "check", f"predator-prey,{FORK}"]) == 0
    assert "no environment that can be installed moves so" in capsys.readouterr().out


def test_no_reference_environment_is_given():
    with pytest.raises(InputError, match="no environment that can be installed"):
        find(f"predator-prey,{FORK}").reference_env()


@pytest.mark.parametrize("variant", physics.VARIANTS)
def test_the_variants_of_the_benchmark_are_the_referees(variant):
    twice, velocity_first = physics.VARIANTS[variant]
    world = physics.moved("predator-prey", twice, velocity_first)
    switched = {"twice": twice, "velocity_first": velocity_first}
    assert all(played(world, tag, world.start_from_seeds(range(2)), 25, np.random.default_rng(4), **switched))
    state = world.start_from_seeds([1])
    plain = find("predator-prey" if variant == "mpe2" else f"predator-prey,{FORK}")
    acted = np.array([[1, 2, 3, 4]])
    same = (world.step(state, acted).velocity == plain.step(state, acted).velocity).all()
    assert same == (variant in ("mpe2", "both", "accelerations twice"))


def test_the_rows_of_the_benchmark_can_be_played():
    for row in physics.REGISTER["rows"]:
        found = physics.row_of(row, 4)
        assert set(found) == set(physics.VARIANTS) and all(np.isfinite(found[name]).all() for name in found)


def test_training_is_what_is_registered(tmp_path, monkeypatch):
    asked = []
    monkeypatch.setattr(physics.maviper, "train", lambda *given, **more: asked.append((given, more)))
    done = tmp_path / "predator-prey-0"
    done.mkdir()
    (done / physics.CARD_FILE).touch()
    physics.trained(tmp_path, [], [])
    assert len(asked) == 3 * 8 - 1 and {more["recipe"] for _, more in asked} == {"paper"}
    assert [more["seed"] for _, more in asked] == [0] * 2 + [seed for seed in range(1, 8) for _ in range(3)]
    shaped = {given[0] for given, more in asked if "shaping" in more["settings"]}
    assert shaped == {f"predator-prey,{FORK}"} and {more["settings"]["batch"] for _, more in asked} == {5_120}


def test_the_plan_has_all_registered_experts_and_the_manual_its_hours():
    *_, last = lines = physics.plan_lines()
    asked = physics.REGISTER["training"]
    assert len(lines) == len(asked["worlds"]) + 2 and set(asked["hours"]) == set(asked["worlds"])
    hours = last.partition(" CPU hours")[0]
    text = " ".join(manual.page("games").split())
    assert int(hours) <= 12 and f"planned at {hours} hours" in text
    games = json.loads(physics.RECORD.read_text()).values()
    took = sum(expert["card"]["seconds"] for game in games for expert in game.values())
    assert f"All 24 are trained, in {took / 3600:.0f} hours" in text


def test_the_spread_is_of_all_trained_experts(tmp_path, monkeypatch):
    """Two seeds of a game are there, another one is on the record, and two games have none."""
    name = f"physical-deception,{FORK}"
    for seed in (0, 3):
        run = physics.run_of(tmp_path, name, seed)
        run.mkdir()
        card = {"command": "maviper train", "schedule": "", "steps": 614_400, "seconds": 1.0, "score": 1.0}
        (run / physics.CARD_FILE).write_text(json.dumps(card))
        ends = {"defenders success r=0.316": [0.75, 0.7, 0.8], "adversaries success r=0.316": [0.5, 0.4, 0.6]}
        (run / physics.METRICS_FILE).write_text("{}\n" + json.dumps(ends) + "\n")
    monkeypatch.setattr(physics, "find_expert", lambda text: find_expert(f"{name}@maddpg"))
    monkeypatch.setattr(physics, "RECORD", tmp_path / "record.json")
    known = physics.reached_by(tmp_path, 6)
    number = known[name]["0"]["reached"]["defenders success r=0.316"]
    assert known[name]["0"] == known[name]["3"] and list(known) == [name]
    assert known[name]["0"]["card"] == {key: of for key, of in card.items() if key != "score"}
    once = {**known[name]["0"], "reached": dict.fromkeys(known[name]["0"]["reached"], number)}
    physics.RECORD.write_text(json.dumps({name: {"5": once}}))
    first, second, *others = physics.spread_lines(physics.reached_by(tmp_path, 6))[1:]
    assert first.split()[:7] == ["3", f"{number:.3f}", "0.000", f"{number:.3f}", f"{number:.3f}", "0.750", "0.90"]
    assert "0.62" in second and all(line.split()[0] == "0" for line in others)


def test_the_manual_has_the_experts_of_the_record():
    """How many there are of each measure, what they reach on average and at least and most, also at the end, and what
    is published.
    """
    known = json.loads(physics.RECORD.read_text())
    rows = [[cell.strip() for cell in line.strip("| ").split("|")] for line in manual.page("games").splitlines()]
    for row in physics.REGISTER["spread"]:
        experts = known.get(row["world"], {}).values()
        best, last = ([of[which][row["measure"]] for of in experts] for which in ("reached", "last"))
        numbers = [np.mean(best), min(best), max(best), np.mean(last), min(last), max(last)] if best else []
        mean, least, most, *end = (f"{number:.3f}".removeprefix("0") for number in numbers or [0] * 6)
        told = [f"{mean}, {least} to {most}", f"{end[0]}, {end[1]} to {end[2]}"] if best else ["-", "-"]
        paper = f"{row['published']:.2f}".removeprefix("0") if "published" in row else "-"
        assert [row["measure"], f"{len(experts)} of 8", *told, paper] in rows
