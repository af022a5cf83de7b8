"""The statistics of tests/benchmarks/joint.py: Holm, verdict words, and that its plan can be carried out."""

import numpy as np
import pytest
from scipy import stats

from maviper.experts.finding import find_expert
from maviper.extraction.settings import RUNGS
from maviper.reproduction.statistics import holm
from maviper.worlds import find
from tests.benchmarks import joint
from tests.benchmarks.paired import BETTER, NOT_DECIDED, WORSE, Paired, detectable, verdicts


def around(mean, deviation, seeds=10):
    """Differences with exactly that mean and standard deviation."""
    ends = np.linspace(-1, 1, seeds)
    return Paired(tuple((mean + deviation * ends / ends.std(ddof=1)).tolist()))


def test_holm_by_hand():
    """The least p-value counts once a comparison, the next one once less; none is less than one before."""
    assert holm([0.01, 0.04, 0.03, 0.005]) == pytest.approx([0.03, 0.06, 0.06, 0.02])
    assert holm([0.5, 0.6]) == [1.0, 1.0] and holm([]) == [] and holm([0.2]) == [0.2]


def test_the_paired_test_is_scipys():
    rng = np.random.default_rng(0)
    for size in (2, 3, 10):
        one, other = rng.normal(size=size), rng.normal(0.3, 1, size=size)
        found = Paired(tuple(one - other))
        wanted = stats.ttest_rel(one, other)
        assert found.p_differs() == pytest.approx(wanted.pvalue)
        assert found.interval() == pytest.approx(tuple(wanted.confidence_interval()))


def test_equal_means_that_both_sides_of_the_margin_are_excluded():
    """As the 90 % interval lying within the margin."""
    for deviation in (0.005, 0.02, 0.03, 0.05):
        for mean in (0.0, 0.01, 0.019, 0.03):
            found = around(mean, deviation)
            low, high = found.interval(0.9)
            assert (found.p_equal(0.02) <= 0.05) == (low > -0.02 and high < 0.02)


@pytest.mark.parametrize(
    ("mean", "deviation", "word"),
    [
        (0.1, 0.05, BETTER),
        (-0.1, 0.05, WORSE),
        (0.1, 0.5, NOT_DECIDED),
        (0.0, 0.5, NOT_DECIDED),
        (0.0, 0.01, "EQUAL within .02"),
        (0.01, 0.005, "EQUAL within .02"),  # a difference for certain, and too small to matter
        (0.03, 0.01, BETTER),
        (0.0, 0.0, "EQUAL within .02"),
        (0.5, 0.0, BETTER),
    ],
)
def test_words(mean, deviation, word):
    assert verdicts([around(mean, deviation)], 0.05, 0.02) == [word]
    assert verdicts([around(mean, deviation).turned()], 0.05, 0.02) == [{BETTER: WORSE, WORSE: BETTER}.get(word, word)]


def test_a_family_makes_a_word_harder_to_get():
    """A p-value of .03 is enough alone, and not beside nine others that are nothing."""
    one = around(0.1, 0.1 / stats.t.isf(0.015, 9) * 10**0.5)
    assert one.p_differs() == pytest.approx(0.03)
    assert verdicts([one], 0.05, 0.02) == [BETTER]
    assert verdicts([one, *[around(0.0, 1.0)] * 9], 0.05, 0.02) == [NOT_DECIDED] * 10


def test_one_seed_decides_nothing():
    assert verdicts([Paired((0.5,))], 0.05, 0.02) == [NOT_DECIDED]


def test_the_effect_that_is_seen_is_found_that_often():
    effect = detectable(1.0, 10, 0.05, 0.8)
    rng = np.random.default_rng(0)
    drawn = rng.normal(effect, 1, size=(4_000, 10))
    assert (stats.ttest_1samp(drawn, 0, axis=1).pvalue <= 0.05).mean() == pytest.approx(0.8, abs=0.03)


# --- the plan


def test_the_plan_is_about_rungs_experts_and_measures_that_there_are():
    plan, digest = joint.read_plan()
    assert plan["rungs"] == list(RUNGS) and set(plan["primary"]) <= set(RUNGS) and len(digest) == 64
    for label, asked in plan["worlds"].items():
        world = find(asked["game"])
        assert (asked["team"], asked["measure"]) in {(each.team, each.name) for each in world.measures}
        for where in filter(None, asked["experts"].values()):
            assert find_expert(where)[1].spec.name == asked["game"]
        seeds = [set(grid["seeds"]) for grid in asked["grids"].values()]
        pilot, full = set(asked["grids"]["pilot"]["seeds"]), set(asked["grids"]["equal"]["seeds"])
        assert len(pilot) == 3 and len(full) == 10 and not pilot & full and all(seeds)
        for cell in joint.cells_of(plan, [(label, "clone")], joint.FULL, ("equal", "paper"))[:36]:
            settings = joint.settings_of(plan, world, cell)
            assert settings.deal_budget(world).refinement == 0 and settings.max_depth == cell[3]


def test_a_missing_expert_is_said_and_a_new_one_needs_no_change_of_the_plan(capsys):
    plan, _ = joint.read_plan()
    found = joint.present(plan, ["deception"], {})
    said = capsys.readouterr().out
    assert "missing   deception roles: give --experts roles=FILE" in said and ("deception", "roles") not in found
    found = joint.present(plan, ["deception"], {"roles": "physical-deception@0", "clone": ""})
    assert [expert for _, expert in found] == ["roles", "clone"]
    assert not joint.present(plan, ["deception"], {"roles": "cooperative-navigation@clone"})
    assert "it plays cooperative-navigation" in capsys.readouterr().out


def test_cells_are_kept_reported_and_refused_under_another_plan(tmp_path, capsys, monkeypatch):
    plan, digest = joint.read_plan()
    for rung in ("iviper", "vote-N-1"):
        cell = ("deception", "clone", "quick", 1, rung, 7)
        joint.play(cell, "physical-deception@clone", "hash", digest, tmp_path)
        document = joint.checked(joint.place_of(tmp_path, cell), digest, "hash")
        assert 0 <= joint.value_of(plan, "deception", document) < 2
    before = joint.place_of(tmp_path, cell).read_bytes()
    joint.play(cell, "nobody", "hash", digest, tmp_path)
    assert joint.place_of(tmp_path, cell).read_bytes() == before, "it was there"
    with pytest.raises(SystemExit, match="another plan"):
        joint.play(cell, "nobody", "hash", "another", tmp_path)
    with pytest.raises(SystemExit, match="another plan or expert"):
        joint.play(cell, "nobody", "another", digest, tmp_path)
    cells = [("deception", "clone", "quick", 1, rung, 7) for rung in plan["rungs"]]
    found = joint.Found(plan, digest, tmp_path, cells)
    assert len(found.values) == 2
    assert len(found.paired("deception", "clone", "quick", plan["primary"], [1], [7]).differences) == 1
    assert not found.paired("deception", "clone", "quick", ("iviper", "vote-N"), [1], [7]).differences
