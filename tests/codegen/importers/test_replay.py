"""Replays of imports: an origin that differs anywhere next to a threshold is found out."""

from dataclasses import replace

import numpy as np
import pytest

from codegen import ir
from codegen.agreement import probes
from codegen.errors import DisagreementError, InputError
from codegen.importers import replay
from codegen.importers.origin import Names, profile_of
from codegen.importers.python.source import from_python

TEXT = b"""
def act(a, b, c):
    if a <= 0.1:
        if b < -3:
            return 1
        return 2
    if c >= 1e6 and a < 5:
        return 3
    return 1
"""


def origin():
    return from_python(TEXT, "policy.py")["act"]


@pytest.mark.parametrize("place", range(4))
@pytest.mark.parametrize("side", [-np.inf, np.inf])
def test_a_threshold_that_is_a_float_off_is_found(place, side):
    good = origin()
    splits = np.flatnonzero(good.grown.feature >= 0)
    threshold = good.grown.threshold.copy()
    threshold[splits[place]] = np.nextafter(np.float32(threshold[splits[place]]), np.float32(side))
    threshold[splits[place]] = np.nextafter(np.float32(threshold[splits[place]]), np.float32(side))
    arrays = good.grown
    bad = replace(good, grown=ir.GrownTree(arrays.feature, threshold, arrays.left, arrays.right, arrays.action))
    assert profile_of({"a": good}, Names())
    with pytest.raises(DisagreementError, match="imported tree takes action"):
        profile_of({"a": bad}, Names())


def test_boundary_observations_are_those_of_the_probes():
    (policy,) = profile_of({"a": origin()}, Names()).agents
    rows = replay.observations(policy, nan=False, finite=False)
    for node, low, high in probes.paths(policy.tree, 3):
        feature = policy.tree.feature[node]
        for value in probes.neighbours(float(policy.tree.threshold[node]), policy.numbers):
            here = rows[rows[:, feature] == value]
            others = [k for k in range(3) if k != feature]
            assert ((here[:, others] > low[others]) & (here[:, others] <= high[others])).all(axis=1).sum() >= 16


def test_numbers_that_the_origin_does_not_take_are_left_out():
    (policy,) = profile_of({"a": origin()}, Names()).agents
    assert np.isnan(replay.observations(policy, nan=True, finite=False)).any()
    rows = replay.observations(policy, nan=False, finite=False)
    assert not np.isnan(rows).any() and np.isinf(rows).any()
    assert np.isfinite(replay.observations(policy, nan=False, finite=True)).all()
    rows = replay.observations(policy, nan=True, finite=True)  # as trees of scikit-learn
    assert np.isnan(rows).any() and not np.isinf(rows).any()


def test_what_does_not_fit_into_memory_is_refused(monkeypatch):
    monkeypatch.setattr(replay, "MAX_NUMBERS", 1_000)
    with pytest.raises(InputError, match="more than can be replayed"):
        profile_of({"a": origin()}, Names())
