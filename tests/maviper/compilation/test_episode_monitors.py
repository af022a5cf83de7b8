"""Monitors of proofs about episodes of games: they vouch for a start, and for what follows from it by the rules."""

import numpy as np
import pytest

from codegen.errors import InputError
from codegen.lowering.lower import lower
from codegen.targets import emit, monitor
from maviper import load
from maviper.compilation.monitors import proved_by, watched_by
from maviper.episodes.on_policy import on_policy
from maviper.worlds.matching import matching_world
from tests.support import monitors
from tests.support.generated import FOLDER
from tests.support.monitors import INVALID, LEAVING, OK, OUTSIDE, TrackTwin, asked_of_episodes

VERDICTS = FOLDER.parent / "verdicts"
NAME = "certificate-7-reaches.json"


@pytest.fixture(scope="module")
def made():
    """A profile, what is proved of its episodes, and the lowered monitor."""
    profile = load(VERDICTS / "physical_deception" / "profile.json")
    proved = proved_by(VERDICTS / "physical_deception" / NAME, profile)
    return profile, proved.region, watched_by(profile, lower(profile), proved)


@pytest.mark.compile
def test_all_languages_say_what_follows(made, tmp_path):
    profile, start, watched = made
    texts = {**emit(profile, monitors.LANGUAGES), **monitor.emit(watched, monitors.LANGUAGES)}
    rows = asked_of_episodes(profile, start, 1_200, 4)
    twin, wanted = TrackTwin(profile, start), []
    for w, fresh, dt, begun, acts in zip(*rows, strict=True):
        if begun:
            twin.start()
        wanted.append(twin.step(w, fresh, dt))
        twin.acts = acts.tolist()
    assert {OK, LEAVING, OUTSIDE, INVALID} == set(wanted) and wanted.count(OK) > 500
    given, rest = rows[4][:, 0].tolist(), watched.fallbacks[0].action
    acted = [act if word in (OK, LEAVING) else rest for act, word in zip(given, wanted, strict=True)]
    monitors.ensure_said_by_all(texts, watched, tmp_path, rows, (wanted, acted))


@pytest.mark.compile
def test_it_vouches_for_the_simulators_episodes_and_for_no_push(made):
    """Episodes of the simulator from its own starts; a push, or an action that was not taken, is seen at once."""
    profile, _, watched = made
    (text,) = monitor.emit(watched, ["python"]).values()
    space = {}
    exec(compile(text, "monitor", "exec"), space)
    world = matching_world(profile)
    played = on_policy(profile, world, seeds=range(6))
    whole = np.stack([world.coordinates(state) for state in played.states[:-1]])  # [steps, batch, coordinates]
    for number in range(whole.shape[1]):
        states, actions = whole[:, number], played.actions[:, number]
        for pushed in (None, 5):
            found = space["Monitor"]()
            for step, (w, acts) in enumerate(zip(states, actions, strict=True)):
                seen = w + (1e-6 if step == pushed else 0.0) * (np.arange(len(w)) == 0)
                found.renew_all()
                word = int(found.step(seen.tolist(), profile.world.dt))
                assert word == (OK if pushed is None or step < pushed else OUTSIDE)
                for policy, act in zip(profile.agents, acts, strict=True):
                    found.act(policy.agent, int(act))


@pytest.mark.parametrize("game", ["cooperative_navigation", "predator_prey"])
def test_episodes_with_contacts_are_refused_with_the_reason(game):
    profile = load(VERDICTS / game / "profile.json")
    (certificate,) = (VERDICTS / game).glob("certificate-7-*.json")
    with pytest.raises(InputError, match="push each other"):
        watched_by(profile, lower(profile), proved_by(certificate, profile))
