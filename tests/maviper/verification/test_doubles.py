"""Agents that compare float64 from file to certificate: verdicts exact to the last double, and what refuses them."""

import csv
import json
import math

import pytest

from codegen import ir
from maviper.cli import main
from maviper.page.document import Contents
from maviper.page.page import FILE, page
from tests.maviper.page.browsers import in_node
from tests.support.games import NAMES, doubled, random_profile
from tests.support.observations import robust

pytestmark = pytest.mark.solver
CART = """
def cart(x):
    angle, spin = x
    if angle <= 0.1:
        return "left"
    return "right" if spin > 0.3 else "left"
"""
ABOVE = math.nextafter(0.1, 1.0)
CLAIMS = """
[[property]]
label = "right just above"
formula = "angle > 0.1000000000000000055511151231257827021181583404541015625 and spin > 0.5 implies acts(cart) == right"

[[property]]
label = "false at the threshold"
formula = "angle >= 0.1 and spin > 0.5 implies acts(cart) == right"
"""


@pytest.fixture
def place(tmp_path, monkeypatch):
    """A folder with the tree, imported, its claims and an observation."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "cart.py").write_text(CART)
    (tmp_path / "cart.toml").write_text(CLAIMS)
    (tmp_path / "seen.csv").write_text(f"angle,spin\n{ABOVE!r},0.5\n")
    assert main.run(["import", "--agents", "cart=cart.py", "-o", "cart.json"]) == 0
    return tmp_path


def test_verdicts_and_certificates(place, capsys):
    assert main.run(["verify", "cart.json", "--claims", "cart.toml", "-o", "answers"]) == 1
    said = "".join(capsys.readouterr())
    assert "PROVED" in said and "VIOLATED" in said and "no page" not in said
    assert (place / "answers" / FILE).exists()
    assert main.run(["check", "answers/certificate-1-formula.json", "--profile", "cart.json"]) == 0
    assert (
        "cart): what they observe is not rounded"
        in json.loads((place / "answers/report.json").read_text())["semantics"]
    )
    # the certificate is about these numbers: with float32 thresholds it is not this profile's
    assert main.run(["import", "--agents", "cart=cart.py", "--numbers", "float32", "-o", "single.json"]) == 0
    assert main.run(["check", "answers/certificate-1-formula.json", "--profile", "single.json"]) != 0


def test_the_radius_is_exact_among_doubles(place):
    assert main.run(robust("cart.json", "seen.csv", "-o", "radii", certify=True)) == 0
    (row,) = csv.DictReader((place / "radii" / "radii.csv").read_text().splitlines())
    assert 0 < float(row["radius"]) < ABOVE - 0.1 == 2.0**-56


def test_pages_play_them(tmp_path):
    """A page of doubles rounds nothing: next to a threshold it decides as the reference does."""
    profile = doubled(random_profile(NAMES[1]))
    (policy, *_) = profile.agents
    node = next(ir.splits(policy.tree))
    edge = float(policy.tree.threshold[node])
    row = [0.0] * len(policy.features)
    rows = [
        [*row[: int(policy.tree.feature[node])], value, *row[int(policy.tree.feature[node]) + 1 :]]
        for value in (math.nextafter(edge, -math.inf), edge, math.nextafter(edge, math.inf))
    ]
    script = "return given.map((seen) => Engine.path(game.agents[0].tree, seen).pop());"
    found = in_node(page(profile, Contents((), ())), script, rows, tmp_path)
    assert found == ir.apply(policy.tree, rows).tolist()
