"""Intervals cover, tests are the literature's, and one draw of seeds and episodes serves all that is compared."""

import numpy as np
import pytest
from scipy import stats

from maviper.reproduction.statistics import (
    OPPOSITE,
    PAPER,
    RATIO,
    REWARD,
    SAME_SIZE,
    SIZE_OPEN,
    SMALLER,
    Estimate,
    Term,
    estimate,
    holm,
    of_differences,
    size,
    untestable,
)


def simulated(rng, seeds=10, episodes=60, between=0.05, common=0.3, noise=0.3, mean=0.7):
    """Values [seeds, episodes] of a team whose seeds differ, in episodes of which some are hard for all seeds."""
    return (
        mean
        + between * rng.normal(size=(seeds, 1))
        + common * rng.normal(size=(1, episodes))
        + noise * rng.normal(size=(seeds, episodes))
    )


def covered(make, truth, times=300):
    inside = [low <= truth <= high for low, high in (make().interval() for _ in range(times))]
    return float(np.mean(inside))


@pytest.mark.parametrize("between", [0.0, 0.05, 0.5])
def test_intervals_of_a_mean_cover_it(between):
    """Whether seeds or episodes make the spread: 95 % of the intervals hold the mean, or somewhat more."""
    rng = np.random.default_rng(5)
    share = covered(lambda: estimate([Term(1.0, simulated(rng, between=between))], crossed=True), 0.7)
    assert 0.93 <= share <= 0.995


@pytest.mark.parametrize("between", [0.0, 0.5])
def test_intervals_cover_where_each_seed_has_episodes_of_its_own(between):
    rng = np.random.default_rng(4)

    def own():
        rows = [simulated(rng, seeds=1, between=between) for _ in range(10)]
        return estimate([Term(1.0, np.concatenate(rows))])

    assert 0.93 <= covered(own, 0.7) <= 0.97


def test_with_episodes_of_their_own_seeds_are_compared_as_by_the_paired_t_test():
    rng = np.random.default_rng(3)
    one, other = rng.normal(0.1, 1, size=(10, 50)), rng.normal(size=(10, 50))
    found = estimate([Term(1.0, one), Term(-1.0, other)])
    wanted = stats.ttest_rel(one.mean(axis=1), other.mean(axis=1))
    assert found.p_differs() == pytest.approx(wanted.pvalue, abs=0.02)
    assert found.interval() == pytest.approx(tuple(wanted.confidence_interval()), abs=0.02)


def test_holm_is_what_r_gives():
    """`p.adjust(..., "holm")`: the least counts as often as there are p-values, and none is less than one before."""
    given = [0.01, 0.02, 0.03, 0.04, 0.05]
    assert holm(given) == pytest.approx([0.05, 0.08, 0.09, 0.09, 0.09])
    assert holm([0.0254, 0.0003, 0.0134]) == pytest.approx([0.0268, 0.0009, 0.0268])


def test_two_one_sided_tests_are_two_t_tests():
    rng = np.random.default_rng(9)
    for mean in (0.0, 0.015, 0.05):
        drawn = rng.normal(mean, 0.02, size=12)
        wanted = max(
            stats.ttest_1samp(drawn, -0.02, alternative="greater").pvalue,
            stats.ttest_1samp(drawn, 0.02, alternative="less").pvalue,
        )
        assert of_differences(drawn).p_equal(0.02) == pytest.approx(wanted)


def test_the_effect_that_could_be_seen_is_seen_that_often():
    rng = np.random.default_rng(10)
    error = 1 / 10**0.5
    effect = Estimate(0.0, error, 9).detectable(0.05, 0.8)
    drawn = rng.normal(effect, 1, size=(4_000, 10))
    assert (stats.ttest_1samp(drawn, 0, axis=1).pvalue <= 0.05).mean() == pytest.approx(0.8, abs=0.03)


def test_one_seed_leaves_the_episodes_and_one_number_leaves_nothing():
    rng = np.random.default_rng(11)
    values = rng.normal(1.0, 0.5, size=(1, 400))
    alone = estimate([Term(1.0, values)])
    wanted = stats.ttest_1samp(values[0], 0).confidence_interval()
    assert alone.interval() == pytest.approx(tuple(wanted), abs=0.01)
    single = estimate([Term(1.0, np.ones((1, 1)))])
    assert single.value == 1 and single.interval() == (-np.inf, np.inf) and single.p_differs() == 1


def test_a_ratio_to_nothing_is_no_number():
    found = estimate([Term(1.0, np.ones((5, 4)), np.zeros((5, 4)), RATIO)])
    assert not np.isfinite(found.value) and found.p_differs() == 1 and found.interval() == (-np.inf, np.inf)
    nothing = Term(1.0, np.zeros((5, 4)), np.zeros((5, 4)), RATIO)
    both = estimate([nothing, Term(-1.0, np.ones((5, 4)), np.zeros((5, 4)), RATIO)])
    assert not np.isfinite(both.value) and both.p_above(0) == both.p_equal(1.0) == 1


def test_equal_numbers_are_certain():
    found = estimate([Term(1.0, np.full((5, 4), 0.5))])
    assert found.p_above(0.4) == 0 and found.p_above(0.6) == 1 and found.p_equal(0.02) == 1
    assert found.interval() == pytest.approx((0.5, 0.5))


def test_ratios_of_rewards():
    """The paper's formula hides the sign of the difference; ours says half the expert's loss as 1.5."""
    ours, theirs = np.full((5, 4), -1.0), np.full((5, 4), -2.0)
    assert estimate([Term(1.0, ours, theirs, REWARD)]).value == 1.5
    assert estimate([Term(1.0, ours, theirs, PAPER)]).value == -0.5
    assert estimate([Term(1.0, -ours, theirs, PAPER)]).value == -0.5


@pytest.mark.parametrize(
    ("low", "high", "word"),
    [
        (-0.3, -0.01, OPPOSITE),
        (-0.3, 0.0, SMALLER),
        (0.05, 0.19, SMALLER),
        (0.05, 0.2, SIZE_OPEN),
        (-0.1, 0.5, SIZE_OPEN),
        (0.2, 0.3, SAME_SIZE),
        (0.6, 0.9, SAME_SIZE),
        (float("-inf"), float("inf"), SIZE_OPEN),
    ],
)
def test_a_size_is_judged_against_half_of_the_published_effect(low, high, word):
    assert size(0.4, low, high) == word


def test_a_baseline_at_the_ceiling_leaves_no_lead_to_be_seen():
    assert untestable(0.97) and untestable(1.1)
    assert not untestable(0.969) and not untestable(float("-inf"))
