"""Monitors of proofs about agents that test sums or give numbers: vouched for is what holds for all roundings."""

from dataclasses import replace

import numpy as np
import pytest

from codegen.errors import InputError
from codegen.ir import act, outputs
from codegen.lowering.lower import lower
from codegen.lowering.watching import watch_cover
from codegen.targets import emit, monitor
from maviper.cli import main
from maviper.compilation import covers
from maviper.compilation.monitors import load_proof, lower_monitor
from maviper.files.profiles import load
from tests.support import monitors
from tests.support.generated import FOLDER
from tests.support.giving import GIVES, integrator
from tests.support.monitors import INVALID, LEAVING, OK, OUTSIDE, asked_of_cover, said_of_cover
from tests.support.outputs import given_by

GAME = FOLDER.parent / "verdicts" / "physical_deception" / "certificate-1-distinct_targets.json"
TWO = ("c", "python")
CLIPPED = """
import numpy as np
def cart(x, v):
    if x + v >= 3.0:
        return -2.0
    return np.clip(-x - 1.5 * v, -2.0, 2.0)
"""
TURNS = """
def cart(x, v):
    if x + 1.5 * v > 0.2:
        return "left"
    return "right" if x + 1.5 * v < -0.2 else "rest"
"""
CLAIMS = """
[[property]]
name = "stays_in"
region = { box = { x = [-1.5, 1.5], v = [-1.5, 1.5] } }
[[property]]
name = "always"
region = { box = { x = [-2, 2], v = [-3, 3] } }
[[property]]
formula = "out(cart).push <= 2"
"""
CHOOSES = '[agents.cart.actions]\nleft = { push = "-1.5 m/s^2" }\nright = { push = "1.5 m/s^2" }\nrest = {}'


def proved(folder, source, acts, more):
    """A folder with certificates about a controller."""
    (folder / "cart.py").write_text(source)
    (folder / "world.toml").write_text(integrator("0.1", acts) + CLAIMS)
    given = ["import", "--agents", f"cart={folder / 'cart.py'}", "--arrays", "float64", *more]
    assert main.run([*given, "-o", str(folder / "cart.json")]) == 0
    asked = ["verify", str(folder / "cart.json"), "--world", str(folder / "world.toml"), "-o", str(folder / "out")]
    assert main.run(asked) == 0
    return folder


@pytest.fixture(scope="module")
def giving(tmp_path_factory):
    return proved(tmp_path_factory.mktemp("giving"), CLIPPED, GIVES, ["--outputs", "push"])


@pytest.fixture(scope="module")
def choosing(tmp_path_factory):
    return proved(tmp_path_factory.mktemp("choosing"), TURNS, CHOOSES, [])


def made(folder, number):
    """Of a certificate the profile, the cover, and the lowered monitor."""
    profile = load(folder / "cart.json", sums=True)
    (certificate,) = (folder / "out").glob(f"certificate-{number}-*.json")
    proof = load_proof(certificate, profile)
    return profile, proof.region, lower_monitor(profile, lower(profile), proof)


@pytest.mark.parametrize("agent", ["giving", "choosing"])
@pytest.mark.parametrize("number", [1, 2])
def test_it_vouches_for_all_episodes_of_the_agent_itself(agent, number, request):
    """With the roundings that the deployed tree makes, from the start, and from any state that is vouched for."""
    profile, cover, _ = made(request.getfixturevalue(agent), number)
    assert [one.name for one in cover.variables] == ["x", "v"] and cover.ever is (number == 2)
    policy, rng = profile.agents[0], np.random.default_rng(3)
    pushes = {"left": -1.5, "right": 1.5, "rest": 0.0}
    w = rng.uniform([-1.0, -0.1], [1.0, 0.1], (50, 2))
    steps = 25 if cover.ever else len(cover.steps)
    for step in range(steps):
        assert cover.holds(w, step).all()
        assert (np.abs(w) <= ([2.0, 3.0] if cover.ever else [1.5, 1.5])).all()
        moved = w + rng.normal(scale=0.05, size=w.shape)
        w = np.where(cover.holds(moved, step)[:, None], moved, w)
        if policy.outputs:
            push = outputs(policy, w)[:, 0]
        else:
            push = np.array([pushes[policy.actions[action].name] for action in act(policy, w)])
        w = np.stack([w[:, 0] + 0.1 * w[:, 1], w[:, 1] + 0.1 * push], axis=1)
    assert cover.ever or not cover.holds(w, steps).any()


@pytest.mark.compile
@pytest.mark.parametrize("languages", [TWO, pytest.param(monitors.LANGUAGES, marks=pytest.mark.slow)])
def test_all_languages_say_what_the_proof_says(languages, choosing, tmp_path):
    for number in (1, 2):
        folder = tmp_path / str(number)
        folder.mkdir()
        profile, cover, watched = made(choosing, number)
        texts = {**emit(profile, languages), **monitor.emit(watched, languages)}
        rows = asked_of_cover(cover, 600, 5)
        wanted = said_of_cover(cover, rows)
        assert {OK, OUTSIDE, INVALID} <= set(wanted)
        assert [action.name for action in profile.agents[0].actions][watched.fallbacks[0].action] == "rest"
        acted = [i % 3 if word in (OK, LEAVING) else watched.fallbacks[0].action for i, word in enumerate(wanted)]
        monitors.ensure_said_by_all(texts, watched, folder, rows, (wanted, acted), languages)


def test_the_fallback_is_the_action_that_does_nothing_wherever_a_profile_has_it(choosing):
    """The actions of a profile may stand in another order than in the file."""
    profile, cover, watched = made(choosing, 2)
    policy = profile.agents[0]
    order = [2, 0, 1]
    tree = replace(policy.tree, action=np.argsort(order)[policy.tree.action].astype(policy.tree.action.dtype))
    turned = replace(policy, actions=tuple(policy.actions[at] for at in order), tree=tree)
    assert [action.name for action in turned.actions] == ["rest", "left", "right"]
    other = replace(profile, agents=(turned,))
    again = watch_cover(other, lower(other), cover, watched.certificate, watched.claim)
    assert (watched.fallbacks[0].action, again.fallbacks[0].action) == (2, 0)
    assert watch_cover(profile, lower(profile), replace(cover, rests={}), "0", "").fallbacks[0].action == 0


@pytest.mark.compile
def test_outputs_are_given_while_the_state_is_vouched_for(giving, tmp_path):
    profile, _, watched = made(giving, 2)
    texts = {**emit(profile, monitors.LANGUAGES), **monitor.emit(watched, monitors.LANGUAGES)}
    (output,) = profile.agents[0].outputs
    assert (output.low, output.high) == (-2.0, 2.0)
    given = [[0.5], [-2.0], [np.nextafter(2.0, 3.0)], [np.nan], [-np.inf]]
    wanted = [[OK, 0.5], [OK, -2.0], *[[INVALID, 0.0]] * 3]
    for language, rows in given_by(texts, watched, tmp_path, given).items():
        assert rows == wanted, language


def test_a_claim_about_single_decisions_has_a_monitor_too(giving):
    _, cover, watched = made(giving, 3)
    assert cover.ever and not cover.paced and len(watched.places) == 2
    assert cover.holds(np.array([[5.0, -5.0], [np.nextafter(5.0, 6.0), 0.0]]), 0).tolist() == [True, False]


def test_boxes_that_do_not_hold_all_roundings_are_dropped(giving, monkeypatch):
    """What is proved of some roundings is proved of no state."""
    whole = made(giving, 2)[1].steps[0][0]
    together = covers._together

    def cut(lists):
        boxes = together(lists)
        boxes.high[::2, 2:] = 0.0  # of every second one the roundings
        return boxes

    monkeypatch.setattr(covers, "_together", cut)
    assert len(made(giving, 2)[1].steps[0][0].low) < len(whole.low)


def test_a_certificate_about_a_game_is_refused(giving):
    with pytest.raises(InputError, match="about tests of single features"):
        load_proof(GAME, load(giving / "cart.json", sums=True))
