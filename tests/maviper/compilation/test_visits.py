"""States that episodes visit: the same ones each time, and those that a proof leads to."""

from pathlib import Path

import numpy as np
import pytest

from codegen.lowering.lower import lower
from maviper import load
from maviper.compilation.monitors import load_proof, lower_monitor
from maviper.compilation.visits import EPISODES, list_visits
from maviper.worlds.stated.certified import read_certificate

GENERATED = Path(__file__).parents[3] / "generated"
CROSSING = GENERATED / "worlds" / "crossing" / "certificate-1-stays_in.json"


@pytest.mark.parametrize(
    "name", ["worlds/crossing/certificate-1-stays_in", "arch/tora_reach/certificate-1-reaches_and_stays"]
)
def test_episodes_visit_what_is_proved(name, monkeypatch):
    monkeypatch.setattr("maviper.compilation.visits.EPISODES", 6)
    certificate = GENERATED / f"{name}.json"
    profile = load(certificate.parent / "profile.json")
    cover = load_proof(certificate, profile).region
    proof, statement = read_certificate(certificate)
    names = [one.name for one in cover.variables]
    visits = list_visits(statement, profile, proof.claim.steps, names)
    assert len(visits) == len(cover.steps) and all(len(states) == 6 for states in visits)
    assert all(cover.holds(states, step).all() for step, states in enumerate(visits))
    again = list_visits(statement, profile, proof.claim.steps, names[::-1])
    assert all((one == other[:, ::-1]).all() for one, other in zip(visits, again, strict=True))


def test_most_of_what_episodes_visit_is_told_by_a_glance():
    """By one box for each step, at the crossing; where nothing is played, boxes are chosen by their size."""
    profile = load(CROSSING.parent / "profile.json")
    proved = load_proof(CROSSING, profile)
    cores = lower_monitor(profile, lower(profile), proved).lookup.cores
    visits = proved.region.visit()
    told = [
        ((states >= [float.fromhex(low.hex) for low in box.low]) & (states <= [float.fromhex(h.hex) for h in box.high]))
        for states, box in zip(visits, cores.boxes[1:], strict=True)  # the first one is of no step
    ]
    assert cores.axis is None and len(told) == len(proved.region.steps)
    assert np.concatenate(told).all(axis=1).mean() > 0.95 and len(visits[0]) == EPISODES
