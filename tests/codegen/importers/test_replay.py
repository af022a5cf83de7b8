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
from codegen.importers.replay import ROWS, choose_rows, list_values

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


# --- the numbers of a source


def test_a_number_its_negation_one_beside_and_its_neighbours_are_asked():
    plain, special = list_values([0.1], "float64")
    single = np.float32(0.1)
    beside = [np.nextafter(single, np.float32(end)) for end in (-np.inf, np.inf)]
    wanted = [0.1, -0.1, 1.1, 0.9, -1.1, np.nextafter(0.1, 1), np.nextafter(0.1, 0), single, *beside]
    assert {float(each) for each in wanted} <= set(plain.tolist()) and 0.0 in plain
    assert np.isnan(special).any() and {np.inf, -np.inf} <= set(special.tolist())
    assert np.signbit(special[special == 0]).all()


@pytest.mark.parametrize(
    ("kind", "code"), [("int32", 100_000_001), ("int64", 2**53 + 1), ("uint64", 2**64 - 2), ("int32", -(2**31) + 1)]
)
def test_whole_numbers_are_exact(kind, code):
    plain, _ = list_values([code], kind)
    assert plain.dtype == kind and {code - 1, code, code + 1} <= {int(each) for each in plain}


def test_whole_numbers_stay_in_their_width():
    plain, _ = list_values([200.5, 10**400, float("inf"), float("nan")], "uint8")
    assert plain.tolist() == [0, 1, 199, 200, 201, 202, 255]


def test_all_pairs_are_asked_where_they_fit():
    columns = choose_rows([3], ["int8", "bool"])
    values = list_values([3], "int8")[0]
    asked = set(zip(columns[0].tolist(), columns[1].tolist(), strict=True))
    assert asked >= {(int(one), other) for one in values for other in (False, True)}
    assert [each.dtype for each in columns] == [np.int8, np.bool_]


@pytest.mark.parametrize("count", [1, 2, 7])
def test_rows_end_at_the_limit_and_are_the_same_each_time(count):
    numbers = [each / 7 for each in range(300)]
    first, again = (choose_rows(numbers, ["float32"] * count, most=5000) for _ in range(2))
    assert all(np.array_equal(one, other, equal_nan=True) for one, other in zip(first, again, strict=True))
    assert {len(each) for each in first} == {len(first[0])} and len(first[0]) <= 5000 < ROWS
    assert all(np.isnan(each).any() for each in first)
