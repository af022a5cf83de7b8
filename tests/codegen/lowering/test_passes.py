"""Passes keep every decision, and the proof of it notices when they do not."""

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from codegen import ir, policy_json, profiles
from codegen.agreement import probes, selfcheck
from codegen.boxes import is_inside
from codegen.errors import DisagreementError, ProfileError
from codegen.lowering import passes
from codegen.lowering.deploy import deploy_tree
from codegen.profiles import ensure
from codegen.targets import USUAL, emit
from codegen.world import RegionSpec
from tests.support.strategies import grown_trees
from tests.support.teams import LEFT, RIGHT, STAY, UP, average_tests, tree

N_FEATURES = 10


def asked(one, rng):
    """Observations at and beside every threshold, special ones and random ones."""
    thresholds = np.unique(np.append(one.threshold[one.feature != ir.NO_FEATURE], np.zeros(1, np.float32)))
    with np.errstate(over="ignore", under="ignore"):
        beside = np.concatenate([np.nextafter(thresholds, np.float32(side)) for side in (-np.inf, np.inf)])
    values = np.concatenate([thresholds, beside, np.array([np.nan, np.inf, -np.inf, -0.0, 1e-40], np.float32)])
    rows = rng.choice(values, size=(3_000, N_FEATURES)).astype(np.float32)
    return np.concatenate([rows, rng.uniform(-2, 2, (1_000, N_FEATURES)).astype(np.float32)])


def acts(one, rows):
    return one.action[ir.apply(one, rows)]


@given(grown_trees(max_depth=5), st.integers(0, 99))
def test_merging_and_reordering_keep_every_decision(grown, seed):
    one, rng = deploy_tree(grown), np.random.default_rng(seed)
    rows = asked(one, rng)
    seen = rng.normal(size=(200, N_FEATURES)).astype(np.float32)
    merged = passes.merge_splits(one)
    better = passes.reorder_tests(merged, seen)
    for other in (merged, better):
        assert (acts(other, rows) == acts(one, rows)).all()
        assert passes.difference(one, other, N_FEATURES) is None
    assert len(better.feature) <= len(merged.feature) <= len(one.feature)
    assert ir.depth(better).max() <= ir.depth(merged).max() <= ir.depth(one).max()
    assert average_tests(better, seen) <= average_tests(merged, seen)
    assert passes.merge_splits(merged).feature.tolist() == merged.feature.tolist()


@given(grown_trees(max_depth=4), grown_trees(max_depth=4), st.integers(0, 99))
def test_a_difference_is_found_iff_there_is_one(first, second, seed):
    one, other = deploy_tree(first), deploy_tree(second)
    found = passes.difference(one, other, N_FEATURES)
    rows = np.concatenate([asked(one, np.random.default_rng(seed)), asked(other, np.random.default_rng(seed + 1))])
    if found is None:
        assert (acts(one, rows) == acts(other, rows)).all()
    else:
        assert acts(one, found[None]) != acts(other, found[None])


@given(grown_trees(max_depth=4), st.data())
def test_dropping_changes_only_what_dead_leaves_decide(grown, data):
    one = deploy_tree(grown)
    leaves = ir.leaves(one).tolist()
    dead = data.draw(st.sets(st.sampled_from(leaves), max_size=len(leaves) - 1))
    fewer = passes.drop_leaves(one, dead)
    rows = asked(one, np.random.default_rng(0))
    alive = ~np.isin(ir.apply(one, rows), list(dead))
    assert (acts(fewer, rows[alive]) == acts(one, rows[alive])).all()
    assert len(ir.leaves(fewer)) == len(leaves) - len(dead)


def test_equal_sides_and_decided_tests_go():
    same = tree((0, 1.0, 1, 2), LEFT, LEFT)
    assert passes.merge_splits(same).feature.tolist() == [ir.NO_FEATURE]
    # x0 <= 1 is known where x0 <= 0.5 held, and false where x0 > 2, NaN too
    twice = tree((0, 0.5, 1, 4), (0, 1.0, 2, 3), LEFT, RIGHT, (0, 0.25, 5, 6), UP, STAY)
    found = passes.merge_splits(twice)
    assert found.feature.tolist() == [0, -1, -1] and found.action.tolist() == [-1, LEFT, STAY]


def test_a_rare_test_goes_last():
    # the first test is nearly always false, and the second decides nearly everything
    rare = tree((0, -5.0, 1, 4), (1, 0.0, 2, 3), LEFT, UP, (1, 0.0, 5, 6), LEFT, RIGHT)
    seen = np.random.default_rng(0).normal(size=(500, 2)).astype(np.float32)
    found = passes.reorder_tests(rare, seen)
    assert found.feature[0] == 1 and len(found.feature) == 5
    assert average_tests(found, seen) < 1.6 < average_tests(rare, seen) == 2.0


def test_a_wrong_pass_is_caught(monkeypatch):
    one = tree((0, 1.0, 1, 2), LEFT, RIGHT)
    monkeypatch.setattr(passes, "_within", lambda node, box: RIGHT)
    with pytest.raises(DisagreementError, match="merge changes a decision"):
        passes.merge_splits(one)
    with pytest.raises(ValueError, match="every leaf is dead"):
        passes.drop_leaves(one, {1, 2})


def test_neighbouring_thresholds_and_nan_are_told_apart():
    t = np.float32(0.1)
    one, other = tree((0, t, 1, 2), LEFT, RIGHT), tree((0, np.nextafter(t, np.float32(1)), 1, 2), LEFT, RIGHT)
    found = passes.difference(one, other, 1)
    assert found is not None and found[0] == np.nextafter(t, np.float32(1))
    largest = float(np.finfo(np.float32).max)
    only_nan = tree((0, largest, 1, 2), LEFT, RIGHT)
    found = passes.difference(only_nan, tree(LEFT), 1)
    assert found is not None and not np.isfinite(found[0])


# --- a region as part of the contract


REGION = RegionSpec(
    goals=("landmark_1",),
    box={"agent_0.x": ("-1", "0.1"), "agent_1.y": ("-1/3", "0.75"), "landmark_1.x": ("-1", "1")},
    difference={"agent_0.x - agent_1.x": ("-0.7", "1/3")},
    apart={"landmark_0 - agent_1": "0.2"},
)


@pytest.mark.usefixtures("unoptimised")
def test_a_profile_with_a_region_is_written_read_and_compiled_with_its_check(profile):
    meant = replace(profile, region=REGION)
    again = profiles.loads(policy_json.dumps(meant))
    assert again.region == REGION and policy_json.content_hash(again) != policy_json.content_hash(profile)
    files = emit(meant, [*USUAL, "javascript", "rust"])
    report = selfcheck.check_files(meant, files, random=1_000).ensure()
    checked = [item for item in report.agreements if "region" in item.target]
    assert {item.target.split()[0] for item in checked} >= {"c", "python"}
    assert all(item.observations > 150 for item in checked)
    for name, text in files.items():
        assert "region" in text or name.endswith("_reader.py"), name
    header = files["physical_deception.h"]
    for text, other in ((" >= -0x1p+0", " > -0x1p+0"), ("possible == 0", "possible == 1"), ("(dy <= -0x", "(dy <= 0x")):
        assert text in header
        with pytest.raises(DisagreementError, match="c region input check"):
            changed = {"physical_deception.h": header.replace(text, other, 1)}
            selfcheck.check_files(meant, changed, random=1_000).ensure()


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"goals": ("landmark_7",)}, "landmark_7"),
        ({"box": {"agent_0.z": ("0", "1")}}, "agent_0.z"),
        ({"box": {"agent_0.x": ("0", "inf")}}, "inf"),
        ({"difference": {"agent_0.x": ("0", "1")}}, "difference"),
        ({"apart": {"agent_0 - nobody": "1"}}, "nobody"),
        ({"box": {"agent_0.x": ("1", "-1")}}, "above"),
        ({"apart": {"agent_0 - agent_1": "-1/2"}}, "above 0"),
        ({"apart": {"agent_0 - agent_0": "1"}}, "itself"),
        ({"goals": ()}, "goals"),
    ],
)
def test_a_region_that_cannot_be_is_refused(profile, change, said):
    with pytest.raises(ProfileError, match=said):
        ensure(replace(profile, region=replace(REGION, **change)))


def test_the_check_lets_no_state_outside_pass(profile):
    names = profile.world.coordinates()
    worlds = probes.bordering(REGION, profile.world, np.random.default_rng(1))
    let = worlds[is_inside(REGION, worlds, names)]
    assert len(let) > 20
    at = [{name: Fraction(float(value)) for name, value in zip(names, row, strict=True)} for row in let]
    for point in at:
        assert all(Fraction(low) <= point[name] <= Fraction(high) for name, (low, high) in REGION.box.items())
        assert Fraction(-7, 10) <= point["agent_0.x"] - point["agent_1.x"] <= Fraction(1, 3)
        gaps = [abs(point[f"landmark_0.{axis}"] - point[f"agent_1.{axis}"]) for axis in "xy"]
        assert max(gaps) >= Fraction(1, 5) and point["goal.x"] == point["landmark_1.x"]
