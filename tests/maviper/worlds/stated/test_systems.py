"""World's files in play: the same seed gives the same episode, steps are those of the file, and `worlds check`."""

import re
from fractions import Fraction as F

import numpy as np
import pytest

from codegen.errors import InputError
from maviper.cli import main
from maviper.worlds import find
from maviper.worlds.checking import Mark, check, new, usable
from maviper.worlds.stated.deviation import deviation
from maviper.worlds.stated.environment import StatedEnv
from maviper.worlds.stated.systems import box, start
from maviper.worlds.stated.systems import read as read_world
from tests.support.systems import CART, CURVED, MOUNTAIN
from verify.systems.files import statement_of


@pytest.fixture
def cart(tmp_path):
    path = tmp_path / "cart.toml"
    path.write_text(CART)
    return path


def test_a_file_is_a_world(cart):
    world = find(f"system:{cart}")
    assert world.agents == ("cart",) and world.spec.episode_steps == 10
    assert world.spec.name == "cart" and world.spec.reference == "system:cart.toml"
    assert [feature.name for feature in world.features[0]] == ["place", "ahead", "side", "moving", "near"]
    assert [(feature.low, feature.high) for feature in world.features[0]] == [
        (-10, 10), (-15, 15), (-1, 1), (0, 1), (-1, 1),
    ]  # fmt: skip
    assert [action.name for action in world.actions[0]] == ["stay", "left", "right"]
    world.close()


def test_steps_are_those_of_the_statement(cart):
    """An episode in floats against the same one in exact numbers."""
    statement = read_world(cart)
    env, piece = StatedEnv(statement, "cart"), statement.system.pieces[0]
    seen, _ = env.reset(seed=3)
    state = {name: F(number) for name, number in env.state.items()}
    rng = np.random.default_rng(0)
    for step in range(10):
        place, ahead, side, moving, near = seen["cart"]
        assert place == np.float32(env.state["x"]) and side == np.sign(env.state["x"] - 0.1)
        assert ahead == pytest.approx(env.state["x"] + env.state["v"], abs=1e-6) and moving == (env.state["v"] > 0)
        assert near == np.float32(np.clip(env.state["x"], -1, 1))
        action = int(rng.integers(3))
        seen, rewards, ended, cut, _ = env.step({"cart": action})
        state = piece.step(state, {"cart": ("stay", "left", "right")[action]}, {})
        assert all(abs(float(number) - env.state[name]) < 1e-12 for name, number in state.items())
        assert rewards == {"cart": 0.0} and ended == {"cart": False} and cut == {"cart": step == 9}


def test_the_same_seed_gives_the_same_episode():
    env = StatedEnv(statement_of(CURVED + "[dynamics.error]\nx = 0.1\n", "f"), "f")

    def played(seed):
        env.reset(seed=seed)
        states = [dict(env.state)]
        for _ in range(4):
            if env.agents:
                env.step({"one": 0, "two": 1})
            states.append(dict(env.state))
        return states

    assert played(5) == played(5) != played(6)


def test_starts_lie_in_the_start_region():
    text = CART.replace("v = [0, 0] }", 'v = [0.1, 0.5] }\nwhere = ["x + 1[s]*v <= 0", "x >= -0.8"]')
    statement = statement_of(text, "f")
    assert box(statement) == {"x": (F(-4, 5), F(1)), "v": (F(1, 10), F(1, 2))}
    rng = np.random.default_rng(0)
    starts = [start(statement, rng) for _ in range(50)]
    assert all(each["x"] >= -0.8 and each["x"] + each["v"] <= 0 and 0.1 <= each["v"] <= 0.5 for each in starts)
    thin = statement_of(CART.replace("v = [0, 0] }", 'v = [0, 1] }\nwhere = ["x == 1[s]*v"]'), "f")
    with pytest.raises(InputError, match="too thin"):
        start(thin, rng)


def test_an_episode_ends_where_the_statement_ends():
    env = StatedEnv(statement_of(CART.replace("[-10, 10]", "[-1, 1]").replace("v = [0, 0]", "v = [5, 5]"), "f"), "f")
    env.reset(seed=0)
    ended = {}
    for _ in range(10):
        if env.agents:
            *_, ended, cut, _ = env.step({"cart": 0})
    assert ended == {"cart": True} and cut == {"cart": False} and env.state["x"] == 1


def test_deviation_from_the_environment():
    found = deviation(statement_of(MOUNTAIN, "f"), 4_000)
    assert found.placed and found.steps == 4_000 and not found.outside and not found.beyond
    assert all(-1e-15 < low <= high < 1e-15 for low, high in found.off.values())


def test_deviation_beyond_the_error_is_told():
    wrong = deviation(statement_of(MOUNTAIN.replace("0.0025", "0.0024"), "f"), 500)
    assert wrong.beyond > 400 and wrong.worst.startswith("position is off by")
    assert max(wrong.off["velocity"]) == pytest.approx(1e-4, rel=0.1)
    covered = MOUNTAIN.replace("0.0025", "0.0024").replace("1e-12", "1.01e-4")
    assert not deviation(statement_of(covered, "f"), 500).beyond
    near = MOUNTAIN.replace("[-1.1, 0.53]", "[0.5, 0.6]").replace("[-0.55, -0.45]", "[0.5, 0.6]")
    walled = deviation(statement_of(near, "f"), 500)
    assert walled.beyond, "the environment stops the car at 0.6"


def test_a_reference_that_shows_its_state_in_observations():
    """Observations are rounded to float32, which is a deviation too."""
    text = MOUNTAIN.replace('state = "state"\n', "")
    found = deviation(statement_of(text, "f"), 400)
    assert not found.placed and found.beyond
    assert not deviation(statement_of(text.replace("1e-12", "1e-7"), "f"), 400).beyond


def test_a_statement_about_other_states_measures_nothing(tmp_path):
    """The car starts right of -0.6, and the ranges end at -0.7."""
    text = MOUNTAIN.replace('state = "state"\n', "").replace("[-1.1, 0.53]", "[-1.1, -0.7]")
    text = text.replace("[-0.55, -0.45]", "[-0.9, -0.8]")
    with pytest.raises(InputError, match="nothing was measured: 10 steps"):
        deviation(statement_of(text, "f"), 10)


@pytest.mark.parametrize(
    ("old", "new", "what"),
    [
        ("MountainCar-v0", "MountainKar-v0", "MountainKar"),
        ('state = "state"', 'state = "stat"', "no attribute 'stat'"),
        ('state = "state"', 'state = "gravity"', "holds 1 numbers, and there are 2 variables"),
        ("coast = {}\n", "", "2 actions, and 3 in the reference"),
        ('state = "state"\n', "", "nothing shows velocity"),
        ("gymnasium:MountainCar-v0", "MountainCar", "no environment that can be played"),
    ],
)
def test_a_reference_that_cannot_be_compared(old, new, what):
    text = MOUNTAIN.replace(old, new)
    text = text.replace('velocity = "velocity"\n', "") if "nothing" in what else text
    with pytest.raises(InputError, match=what):
        deviation(statement_of(text, "f"), 10)


def test_check_a_file(cart, tmp_path):
    found = check(str(cart))
    assert usable(found) and found == check(f"system:{cart}")
    assert [finding.what for finding in found if finding.mark is not Mark.OK] == ["claims: none"]
    assert "cart" in found[0].what
    broken = tmp_path / "broken.toml"
    broken.write_text(CART.replace('"x + dt*v"', '"x + v"'))
    told = check(str(broken))
    cart.write_text(CART + '[[property]]\nformula = "acts(cart) == up"\n')
    assert not usable(check(str(cart))) and "unknown action of cart 'up'" in check(str(cart))[-1].what
    assert not usable(told) and "units do not fit: m and m/s (broken.toml, line " in told[0].what
    assert "dynamics.next.x, column 3; x + v)" in told[0].what


def test_check_measures_the_deviation(tmp_path, monkeypatch):
    monkeypatch.setattr("maviper.worlds.stated.deviation.STEPS", 500)
    path = tmp_path / "car.toml"
    path.write_text(MOUNTAIN)
    assert usable(check(str(path)))
    path.write_text(MOUNTAIN.replace("0.0025", "0.0024"))
    wrong = [finding for finding in check(str(path)) if finding.mark is Mark.WRONG]
    assert len(wrong) == 1 and "beyond the stated error" in wrong[0].what


def test_check_tells_how_far_it_is(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr("maviper.worlds.stated.deviation.STEPS", 500)
    monkeypatch.setattr("maviper.console.PLAIN_SECONDS", 0.0)
    (tmp_path / "car.toml").write_text(MOUNTAIN)
    assert main.run(["worlds", "check", str(tmp_path / "car.toml")]) == 0
    said = capsys.readouterr()
    assert re.search(r"^checking +\d+/500  steps of the reference compared", said.err, re.MULTILINE)
    assert "checking" not in said.out and main.run(["-q", "worlds", "check", str(tmp_path / "car.toml")]) == 0
    assert capsys.readouterr() == (said.out, "")


def test_a_new_file_can_be_used(tmp_path):
    path = tmp_path / "my world.toml"
    new(path)
    assert usable(check(str(path)))
    with pytest.raises(InputError, match="the file exists"):
        new(path)


def test_findings_do_not_steer_the_terminal(tmp_path):
    """A name of a file is shown, not obeyed."""
    (tmp_path / "odd.toml").write_text(CART.replace("x = { unit", '"\\u001b[31mx" = { unit', 1))
    (finding,) = check(str(tmp_path / "odd.toml"))
    assert not usable([finding]) and str(finding).isprintable() and "\\x1b[31mx" in str(finding)
