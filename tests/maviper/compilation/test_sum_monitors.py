"""Monitors of agents that test sums or give numbers: of a proof, which holds for all roundings; without a certificate,
of inputs and outputs alone.
"""

from dataclasses import replace

import numpy as np
import pytest

from codegen.errors import InputError
from codegen.ir import act, outputs
from codegen.lowering.lower import lower
from codegen.lowering.watching import watch, watch_inputs
from codegen.sums import DOUBLE_SUMS, FLOAT64_SUMS
from codegen.targets import emit, rendered
from maviper.cli import main
from maviper.compilation import covers
from maviper.compilation.compile import compile_and_prove, split_targets
from maviper.compilation.monitors import load_proof, lower_monitor
from maviper.files.profiles import load
from tests.support import monitors
from tests.support.generated import FOLDER
from tests.support.giving import GIVES, integrator
from tests.support.monitors import (
    INVALID,
    OK,
    OUTSIDE,
    CoverTwin,
    Machine,
    asked_of_cover,
    given_by,
    limits_of,
    module_of,
)
from tests.support.summed import policy, profile

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
    asked = ["verify", str(folder / "cart.json"), "--system", str(folder / "world.toml"), "-o", str(folder / "out")]
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
        rows = asked_of_cover(cover, 600, 5)
        wanted = CoverTwin(cover).said(rows)
        assert {OK, OUTSIDE, INVALID} <= set(wanted)
        assert [action.name for action in profile.agents[0].actions][watched.fallbacks[0].action] == "rest"
        monitors.ensure_alike(profile, watched, rows, wanted, folder, languages)


def test_the_fallback_is_the_action_that_does_nothing_wherever_a_profile_has_it(choosing):
    """The actions of a profile may stand in another order than in the file."""
    profile, cover, watched = made(choosing, 2)
    policy = profile.agents[0]
    order = [2, 0, 1]
    tree = replace(policy.tree, action=np.argsort(order)[policy.tree.action].astype(policy.tree.action.dtype))
    turned = replace(policy, actions=tuple(policy.actions[at] for at in order), tree=tree)
    assert [action.name for action in turned.actions] == ["rest", "left", "right"]
    other = replace(profile, agents=(turned,))
    again = watch(other, lower(other), cover, watched.certificate, watched.claim)
    assert (watched.fallbacks[0].action, again.fallbacks[0].action) == (2, 0)
    assert watch(profile, lower(profile), replace(cover, rests={}), "0", "").fallbacks[0].action == 0


@pytest.mark.compile
def test_outputs_are_given_while_the_state_is_vouched_for(giving, tmp_path):
    profile, _, watched = made(giving, 2)
    texts = {**emit(profile, monitors.LANGUAGES), **rendered.emit_monitors(watched, monitors.LANGUAGES)}
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


# --- without a certificate


def files(made):
    """The texts of code and monitors, and the lowered monitor."""
    model = lower(made)
    watched = watch_inputs(made, model)
    return {**emit(made, monitors.LANGUAGES), **rendered.emit_monitors(watched, monitors.LANGUAGES)}, watched


@pytest.mark.compile
@pytest.mark.parametrize("languages", [TWO, pytest.param(monitors.LANGUAGES, marks=pytest.mark.slow)])
def test_inputs_are_watched_in_all_languages(languages, tmp_path):
    """Ranges, finiteness and ages of what both agents observe; the word stays."""
    made = profile(policy(3, DOUBLE_SUMS), policy(4, DOUBLE_SUMS, agent="agent_1"))
    _, watched = files(made)
    rng, count, size = np.random.default_rng(5), 800, len(watched.places)
    assert size == 10 and watched.open == 10
    w = rng.uniform(-3.0, 3.0, (count, size))
    odd = rng.random(w.shape) < 0.01
    w[odd] = rng.choice([np.nan, np.inf, -np.inf, 3.0, -3.0, np.nextafter(3.0, 4.0), -3.1], odd.sum())
    fresh = (rng.random(w.shape) > 0.004).astype(np.int32)
    dt = rng.choice([1.0, 0.0, 1.5, 1.6, np.nan, -0.1], count, p=[0.9, *[0.02] * 5])
    start = (rng.random(count) < 0.4).astype(np.int32)
    assert set(limits_of(watched).values()) == {(-3.0, 3.0)}
    wanted = Machine(1.0, limits_of(watched)).said((w, fresh, dt, start))
    assert wanted.count(OK) > 100 < wanted.count(INVALID)
    monitors.ensure_alike(made, watched, (w, fresh, dt, start), wanted, tmp_path, languages)


@pytest.mark.compile
@pytest.mark.parametrize(
    ("arithmetic", "gives"), [(FLOAT64_SUMS, None), pytest.param(DOUBLE_SUMS, "float32", marks=pytest.mark.slow)]
)
def test_outputs_are_watched_in_all_languages(arithmetic, gives, tmp_path):
    """An output beyond its bounds, or no number, is INVALID; then the fallback is given, which is next to 0."""
    texts, watched = files(profile(policy(7, arithmetic, outputs=2, gives=gives)))
    given = [[0.5, -1.0], [1.5, 0.0], [1.75, 0.0], [0.0, -1.0625], [np.nan, 0.0], [0.0, np.inf], [-np.inf, 0.0]]
    wanted = [[OK, *row] if all(-1.0 <= y <= 1.5 for y in row) else [INVALID, 0.0, 0.0] for row in given]
    assert [row[0] for row in wanted] == [OK] * 2 + [INVALID] * 5
    for language, rows in given_by(texts, watched, tmp_path, given).items():
        assert rows == wanted, language


def test_outputs_of_another_number_are_invalid_and_what_has_no_bound_is_finite():
    _, watched = files(profile(policy(7, FLOAT64_SUMS, outputs=2, bounded=False)))
    space = module_of(watched)

    def told(given):
        found = space["Monitor"]()
        found.renew_all()
        assert found.step([0.0] * 5, 1.0) == OK
        return found.give("agent_0", given), found.word

    assert told([1e308, -7.0]) == ([1e308, -7.0], OK)
    for given in ([1.0], [1.0, 2.0, 3.0], [1.0, np.inf], [1.0, None]):
        assert told(given) == ([0.0, 0.0], INVALID)


def test_a_monitor_of_sums_needs_no_certificate_and_takes_none_of_single_features():
    made = profile(policy(3, DOUBLE_SUMS))
    with pytest.raises(InputError, match="about tests of single features"):
        compile_and_prove(made, ["python", "monitor"], certificate=GAME)
    assert split_targets(["monitor", "python"], None, sums=True) == (True, ("python",))
    code = compile_and_prove(made, ["python", "monitor"])
    text = next(text for name, text in code.files.items() if name.endswith("_monitor.py"))
    assert "it proves    nothing" in text
