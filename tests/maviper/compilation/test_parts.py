"""Replays in parts of bounded memory find what replays in one piece do, also where code is wrong."""

import numpy as np
import pytest

from codegen.agreement import probes, selfcheck
from codegen.agreement.compiled import build
from maviper.compilation.compile import compile_profile
from maviper.episodes import trees


@pytest.fixture
def in_small_parts():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(probes, "PART", 10_000)
        patch.setattr(trees, "AT_ONCE", 40_000)
        yield patch


@pytest.mark.usefixtures("few_observations")
def test_parts_find_what_one_piece_does(profile, in_small_parts):
    assert len(list(trees.in_parts(profile))) > 3
    parts = compile_profile(profile, ["c", "python", "json"])
    in_small_parts.undo()
    assert len(list(trees.in_parts(profile))) == 1
    whole = compile_profile(profile, ["c", "python", "json"])
    told = {(item.target, item.agent): item for item in whole.report.agreements}
    again = {(item.target, item.agent): item for item in parts.report.agreements}
    assert again == told
    assert [item.document() for item in parts.faithful] == [item.document() for item in whole.faithful]


@pytest.mark.usefixtures("unoptimised")
@pytest.mark.parametrize(
    ("ending", "old", "new"), [("h", "return", "return 1 -"), ("json", '"left": 1,', '"left": 2,')]
)
def test_a_fault_is_counted_over_all_parts(profile, in_small_parts, ending, old, new):
    """As often as in one piece, and with the same first observation."""
    found = []
    for _ in range(2):
        with build(profile, ["c", "json"]) as made:
            name = f"{made.model.prefix}.{ending}"
            at = made.files[name].rindex(old) if ending == "h" else made.files[name].index(old)
            files = {**made.files, name: made.files[name][:at] + new + made.files[name][at + len(old) :]}
        report = selfcheck.check_files(profile, files, random=1_000)
        found.append([item for item in report.agreements if item.differences])
        in_small_parts.undo()
    assert found[0] and found[0] == found[1]


def test_completions_are_fewer_where_there_are_many_features_but_every_value_is_asked(world):
    features = world.features[0]
    many = features * (200 // len(features) + 1)
    few, wide = (probes.special(each, np.random.default_rng(0)) for each in (features, many))
    assert len(few) == probes.FILLINGS * 11 * len(features) + 11
    assert len(wide) == 11 * len(many) + 11
    for place in range(len(many)):
        values = {str(value) for value in wide[:, place]}
        assert {str(value) for value in probes.SPECIAL["float32"]} <= values
