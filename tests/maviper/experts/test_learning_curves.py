"""The manual's learning curves: drawn from the kept points, and quoted as they are."""

import json

import numpy as np

from maviper import manual
from tests.benchmarks import experts

KEPT = json.loads(experts.KEPT.read_text())


def test_the_picture_is_drawn_from_the_kept_points():
    assert experts.PICTURE.read_text() == experts.drawn(KEPT)
    assert experts.PICTURE.stat().st_size < 12_000


def test_means_over_seeds_are_drawn_and_changed_settings_are_not():
    one = [[5.0, 1_000_000, {"predators": 0.5, "prey": 2.0}], [9.0, 2_000_000, {"predators": 0.75, "prey": 1.0}]]
    other = [[5.1, 1_000_000, {"predators": 0.25, "prey": 3.0}]]
    changed = [[5.0, 1_000_000, {"predators": 9.0, "prey": 9.0}]]
    text = experts.drawn(
        {
            "predator-prey seed=1": one,
            "predator-prey seed=2": other,
            "predator-prey seed=1 scaled=1": changed,
            "physical-deception seed=1": [],
        }
    )
    assert "predators: 0.375" in text and "prey: 2.500" in text and "9.000" not in text
    assert text.count("predators: ") == text.count("prey: ") == 1  # only marks that all seeds have


def test_every_kept_curve_is_of_a_training_that_can_be_run_again():
    for called, points in KEPT.items():
        world, seed, *changed = called.split()
        assert world in experts.QUICK and seed.startswith("seed=") and set(changed) <= {"scaled=1"}
        seconds, steps, _ = zip(*points, strict=True)
        assert (np.diff(seconds) > 0).all() and (np.diff(steps) > 0).all()
        assert steps[-1] == experts.QUICK[world][0]["steps"]


def test_the_manual_has_the_ends_of_the_curves():
    page = " ".join(manual.page("experts").split())
    ends = [points[-1][2] for called, points in KEPT.items() if called == "predator-prey seed=30"]
    assert f"{ends[0]['predators']:.2f}".removeprefix("0") in page and f"{ends[0]['prey']:.2f}" in page
