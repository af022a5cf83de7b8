"""Monitors of systems whose agents remember: what is remembered is a number of the state, as the policy counts it.

Each is compared with the boxes of its proof in all languages, and its system is moved by hand, the C written again
in Python, from every memory that it vouches for.
"""

import numpy as np
import pytest

import maviper
from codegen.errors import InputError
from codegen.importers.c.source import from_c
from codegen.importers.origin import Names, profile_of
from codegen.importers.reading import Said
from codegen.lowering.lower import lower
from codegen.memory import step_memory
from maviper.compilation.monitors import load_proof, lower_monitor
from tests.support import monitors
from tests.support.monitors import INVALID, OK, OUTSIDE, CoverTwin, asked_of_cover, module_of
from tests.support.remembering import HEATER, make_world

LEAST = """#include <stdint.h>
int act(float t) {
    static int8_t left = -3; /* minutes that it heats at least */
    if (t < 19.0f) left = 2;
    else if (left > -3) left--;
    return left > -3;
}"""
ALWAYS = '[[claim]]\nname = "always"\nregion = { box = { t = [18, 22.5] } }\n'


def by_hand(name, t, known):
    """The action and what is remembered then."""
    if name == "heater":
        on = 1 if t < 19 else 0 if t > 21 else known
        return on, on
    left = 2 if t < 19 else known - 1 if known > -3 else known
    return int(left > -3), left


@pytest.fixture(scope="module", params=["heater", "least"])
def made(request, tmp_path_factory):
    """A name, a profile, what is proved of it, and the lowered monitor."""
    folder = tmp_path_factory.mktemp(request.param)
    source = {"heater": HEATER, "least": LEAST}[request.param]
    profile = profile_of(from_c(source.encode(), "act.c", Said(run=False)), Names())
    (folder / "world.toml").write_text(make_world(profile.agents[0], ALWAYS))
    for file, text in maviper.verify_system(profile, folder / "world.toml").files.items():
        (folder / file).write_text(text)
    proved = load_proof(folder / "certificate-1-always.json", profile)
    return request.param, profile, proved, lower_monitor(profile, lower(profile), proved)


@pytest.mark.compile
def test_all_languages_say_what_the_proof_says(made, tmp_path):
    _, profile, proved, watched = made
    rows = asked_of_cover(proved.region, 1_000, 5)
    wanted = CoverTwin(proved.region).said(rows)
    assert {OK, OUTSIDE, INVALID} <= set(wanted)
    monitors.ensure_alike(profile, watched, rows, wanted, tmp_path)


def test_what_it_vouches_for_keeps_the_claim_and_is_vouched_for_later(made):
    name, profile, proved, _ = made
    cover, memory = proved.region, profile.agents[0].memory[0]
    values = np.arange(memory.low, memory.high + 1)
    assert [one[1:] for one in cover.variables if one.name != "t"] == [(memory.low, memory.high)]
    w = np.array([(t, known) for t in np.linspace(17.5, 23, 2_000) for known in values])
    held = cover.holds(w, 0)
    starts = (w[:, 0] >= 18) & (w[:, 0] <= 22) & (w[:, 1] == memory.initial)
    assert held[starts].all() and not held.all() and cover.holds(w + np.array([0, 0.5]), 0).any() == (name == "heater")
    for t, known in w[held].tolist():
        action, after = by_hand(name, np.float32(t), int(known))
        told = step_memory(profile.agents[0], [[int(known)]], [[t]])
        assert (told[0][0], told[1][0, 0]) == (action, after)
        moved = t - 0.02 * (t - 10) + 0.5 * action
        assert 18 <= t <= 22.5 and cover.holds(np.array([[moved, after]]), 0)[0]


def test_actions_that_only_change_memory_are_none_and_its_header_says_when_memory_is_read(made):
    _, profile, _, watched = made
    space = module_of(watched)
    assert space["N_ACTIONS"] == {"act": 2} and len(profile.agents[0].actions) > 2
    assert "with what is remembered before the decision" in space["__doc__"]
    found = space["Monitor"]()
    found.renew_all()
    assert found.step([20.0, profile.agents[0].memory[0].initial], space["DT"]).name == "OK"
    assert found.act("act", 2) == space["FALLBACK"]["act"] and found.word.name == "INVALID"


def test_a_certificate_about_a_game_says_nothing_of_what_remembers(made, tmp_path):
    """In a game `heat` and `heat, on := 1` are two actions: a proof of the plain tree would be read of this one."""
    (tmp_path / "certificate.json").write_text('{"certificate": "certificate-2"}')
    with pytest.raises(InputError, match="does not take memory yet"):
        load_proof(tmp_path / "certificate.json", made[1])
