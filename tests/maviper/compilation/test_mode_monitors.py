"""Monitors of systems with modes: a number between the values of a mode is no state, and nothing is proved of it."""

import json

import numpy as np
import pytest

from codegen.errors import InputError
from codegen.importers.origin import Names, Said, profile_of
from codegen.importers.python.source import from_python
from codegen.lowering.covering import Boxes
from codegen.policy_json import dumps
from maviper import load, verify_system
from maviper.compilation import modes
from maviper.compilation.modes import split_modes
from maviper.compilation.monitors import load_proof
from verify.checker.envelope import body_hash
from verify.systems.files import statement_of

TREE = """
def a(x, number):
    if number <= 0.2:
        if x <= 0.25:
            return 1
        return 0
    if number <= 0.7:
        return 2
    return 0
"""  # never high in a mode, but between two
HEATER = """
name = "heater"
steps = 4
[variables]
x = { unit = "1", range = [-50, 50] }
heat = { modes = ["off", "low", "high"] }
[agents.a.features]
x = "x"
number = "heat"
[agents.a.actions]
off = {}
low = { power = 0.2 }
high = { power = 40 }
[start]
box = { x = [-1, 1], heat = "off" }
"""
STEPS = """
[[dynamics.piece]]
when = "heat == high"
next = { x = "0.5*x + 40", heat = "acts(a)" }
[[dynamics.piece]]
when = "otherwise"
next = { x = "0.5*x + a.power", heat = "acts(a)" }
"""
FLOW = """
[dynamics]
period = "0.5 s"
flow = { x = "(a.power - x)/1[s]" }
next = { heat = "acts(a)" }
"""
WITHIN = "region = { box = { x = [-1.5, 1.5] } }"
WARM = 'where = ["x >= -1", "x <= 1", "heat == '
CLAIMS = {
    "decides": (STEPS, 'formula = "not acts(a) == high"'),
    "stays": (STEPS, f'name = "stays_in"\n{WITHIN}'),
    "always": (STEPS, f'name = "always"\n{WITHIN}'),
    "a region": (STEPS, f'name = "always"\n{WITHIN}\ninvariant = [{{ {WARM}off"] }}, {{ {WARM}low"] }}]'),
    "flow": (FLOW, f'name = "stays_in"\n{WITHIN}'),
}


@pytest.mark.parametrize("name", CLAIMS)
def test_what_is_no_mode_is_vouched_for_nowhere(name, tmp_path):
    moves, claim = CLAIMS[name]
    (tmp_path / "world.toml").write_text(HEATER + moves)
    (tmp_path / "properties.toml").write_text(f"[[property]]\n{claim}\n")
    said, names = Said(arrays="float64"), Names(actions=("off", "low", "high"))
    (tmp_path / "profile.json").write_text(dumps(profile_of(from_python(TREE.encode(), "a.py", said), names)))
    profile = load(tmp_path / "profile.json")
    found = verify_system(profile, tmp_path / "world.toml", tmp_path / "properties.toml")
    ((_, certificate),) = found.certificates.items()
    if name == "flow":  # its sets are turned boxes; joined in cells they are boxes
        body = json.loads(certificate) | {"cells": {"x": "1/8", "heat": "1"}}
        body.pop("content_hash")
        certificate = json.dumps(body | {"content_hash": body_hash(body)})
    (tmp_path / "certificate.json").write_text(certificate)
    cover = load_proof(tmp_path / "certificate.json", profile).region
    x, heat = (each.ravel() for each in np.meshgrid(np.linspace(-1.0, 1.0, 21), np.linspace(-0.5, 2.5, 25)))
    w, whole = np.column_stack([x, heat]), np.isin(heat, [0.0, 1.0, 2.0])
    held = [cover.holds(w, step) for step in range(len(cover.steps))]
    assert not any(each[~whole].any() for each in held)
    assert all(each[whole].any() for each in held)


def test_boxes_are_cut_to_the_values_of_modes(monkeypatch):
    """Not where a mode may be any number, and not into more than there is room for."""
    statement = statement_of(HEATER + STEPS, "world.toml")
    low, high = np.array([[0.0, 0.0], [1.0, 0.5], [2.0, -np.inf]]), np.array([[9.0, 2.0], [9.0, 1.0], [9.0, np.inf]])
    boxes = split_modes(statement, Boxes(low, high), "here")
    assert boxes.low[:, 0].tolist() == [0.0, 0.0, 0.0, 1.0, 2.0]
    assert list(zip(boxes.low[:, 1].tolist(), boxes.high[:, 1].tolist(), strict=True)) == [
        (0.0, 0.0),
        (1.0, 1.0),
        (2.0, 2.0),
        (1.0, 1.0),
        (-np.inf, np.inf),
    ]
    monkeypatch.setattr(modes, "MAX_GIVEN", 4)
    with pytest.raises(InputError, match="more than 4 boxes, one for each value of its modes"):
        split_modes(statement, Boxes(low, high), "here")
