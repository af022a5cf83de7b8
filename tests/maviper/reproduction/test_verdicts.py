"""Verdicts on tables with known effects: an order is found, equality is found, and noise decides nothing."""

import math
from itertools import product

import numpy as np
import pytest

from maviper.reproduction import register, report, verdicts
from maviper.reproduction.cells import table
from maviper.reproduction.recipes import Book, Finder, Number, Place
from maviper.reproduction.statistics import OPPOSITE, SAME_SIZE, SIZE_OPEN, SMALLER, Estimate
from maviper.reproduction.verdicts import AGREES, DIFFERS, NOT_COMPARABLE, NOT_DECIDED
from tests.maviper.reproduction import tables
from tests.maviper.reproduction.tables import ABLATIONS, DECEPTION, FOUR, ORDERED, PREDATORS

UNPLAYED = {"exploitability-defenders-depths", "exploitability-adversary-depths", "joint-fitted-q-exploring"}
SIZES = {OPPOSITE, SMALLER, SAME_SIZE, SIZE_OPEN}
SAME = dict.fromkeys((*FOUR, *ABLATIONS), 0.8)
TURNED = dict(zip(ORDERED, reversed(ORDERED.values()), strict=True))


def judge(folder, expert="mappo"):
    found = verdicts.judge_claims(Book(table.read_table(folder)), register.read(), expert)
    return {verdict.claim.id: verdict for verdict in found}


@pytest.fixture(scope="module")
def ordered(tmp_path_factory):
    return judge(tables.whole(tmp_path_factory.mktemp("ordered")))


def test_a_true_order_is_found(ordered):
    """MAVIPER .85, IVIPER .6, imitation .4 and fitted Q .05 of the expert in every game."""
    words = {name: verdict.word for name, verdict in ordered.items()}
    orders = {name for name, verdict in ordered.items() if verdict.claim.test == register.GREATER}
    not_so = {"reward-individual-imitation", "exploitability-adversary", "robust-prey-bold"}
    assert {name for name in orders if words[name] == AGREES} == orders - not_so - UNPLAYED
    assert {words[name] for name in not_so} == {DIFFERS} and {words[name] for name in UNPLAYED} == {NOT_DECIDED}
    assert len([word for word in words.values() if word in (AGREES, DIFFERS)]) >= 30


def test_claims_of_equality_differ_where_there_is_an_order(ordered):
    equal = [verdict for verdict in ordered.values() if verdict.claim.test == register.EQUAL]
    assert len(equal) >= 6 and {verdict.word for verdict in equal} == {DIFFERS}
    assert "better" in ordered["joint-navigation-imitation"].reason


@pytest.mark.parametrize(
    ("strengths", "word"),
    [
        ((0.85, 0.6, 0.4, 0.05), AGREES),
        ((0.6, 0.85, 0.1, 0.05), AGREES),  # one is better
        ((0.6, 0.85, 0.8, 0.05), DIFFERS),  # two are
        ((0.6, 0.61, 0.59, 0.6), NOT_DECIDED),
    ],
)
def test_second_best_is_decided_against_each_opponent(tmp_path, strengths, word):
    strength = dict(zip(FOUR, strengths, strict=True))
    found = judge(tables.whole(tmp_path, (PREDATORS,), (4,), strength=strength, noise=0.01))
    verdict = found["robust-prey-each"]
    assert verdict.word == word and len(verdict.run) == 15


def test_claims_about_one_number_count_once(ordered):
    told = [(name, verdict.word) for name, verdict in ordered.items()]
    text = report.counts(told)
    repeats = {"robust-defenders-each": "robust-defenders", "robust-adversary-each": "robust-adversary"}
    assert register.read().repeats == repeats
    assert f"of {len(told) - 2} claims" in text and text.endswith("; 2 more repeat one of these numbers")
    assert report.counts(told[:1]).startswith("1 of 1 claim agrees") and "repeat" not in report.counts(told[:1])


def test_sizes_stand_beside_the_verdict_depth_by_depth(ordered):
    """MAVIPER less IVIPER is .25, imitation .45, fitted Q .8, where the paper has .488."""
    verdict = ordered["joint-defenders"]
    sizes = {(each.depth, each.label.split()[2].rstrip(",")): each.size for each in verdict.run}
    assert {depth for depth, _ in sizes} == {2, 4, 6}
    assert {sizes[depth, "imitation"] for depth in (2, 4, 6)} == {SAME_SIZE}
    assert set(verdict.by_depth) == {2, 4, 6} and verdict.by_depth[4].startswith("AGREES (")
    assert "SAME SIZE" in verdict.by_depth[4] and verdict.by_depth[4].endswith("of 3)")
    assert {each.size for each in ordered["individual-adversary"].run} == {""}, "equality has no size"
    plain = report.document([verdict], register.read())["claims"][0]
    assert plain["by_depth"]["4"] == verdict.by_depth[4] and plain["comparisons"][0]["size"] in SIZES


def test_a_baseline_at_the_ceiling_makes_a_claim_untestable(tmp_path):
    found = judge(tables.whole(tmp_path, (DECEPTION,), strength=dict.fromkeys((*FOUR, *ABLATIONS), 0.99), noise=0.002))
    verdict = found["joint-defenders"]
    assert verdict.word == DIFFERS and all(each.untestable for each in verdict.run)
    assert {each.size for each in verdict.run} == {SMALLER} and "3 UNTESTABLE" in verdict.by_depth[4]


def test_bounds(ordered):
    assert ordered["individual-floor-maviper"].word == AGREES  # .925 of the expert alone
    assert ordered["individual-floor-iviper"].word == AGREES  # .8
    assert ordered["individual-heights"].word == AGREES
    assert ordered["robust-adversary-guesses"].word == DIFFERS  # MAVIPER's adversaries reach .765
    assert "contradicted by 10 of 20 comparisons: maviper" in ordered["robust-adversary-guesses"].reason


def test_attention(ordered):
    assert ordered["features-apart"].word == AGREES and ordered["features-goal"].word == AGREES
    assert ordered["features-apart"].run[0].number.value == 1


def test_equality_is_a_finding(tmp_path):
    found = judge(tables.whole(tmp_path, (DECEPTION,), strength=SAME, noise=0.005))
    assert found["individual-adversary"].word == found["robust-adversary"].word == AGREES
    assert found["joint-defenders"].word == found["ablation-joint"].word == DIFFERS
    assert "equal" in found["joint-defenders"].reason


def test_what_noise_hides_is_not_decided_and_the_visible_effect_is_said(tmp_path):
    found = judge(tables.whole(tmp_path, (DECEPTION,), strength=SAME, noise=0.3))
    verdict = found["joint-defenders"]
    assert verdict.word == NOT_DECIDED and "would have been detected" in verdict.reason
    assert 0.02 < verdict.visible < 2


def test_the_opposite_order_differs(tmp_path):
    found = judge(tables.whole(tmp_path, (DECEPTION,), strength=TURNED))
    assert found["joint-defenders"].word == found["robust-defenders"].word == DIFFERS
    assert "worse" in found["joint-defenders"].reason


def test_few_seeds_decide_nothing(tmp_path):
    found = judge(tables.whole(tmp_path, (DECEPTION,), seeds=1))
    decided = {name for name, verdict in found.items() if verdict.word not in (NOT_DECIDED, NOT_COMPARABLE)}
    assert not decided and "1 of at least 5 seeds" in found["joint-defenders"].reason
    assert all(math.isinf(each.visible) for verdict in found.values() for each in verdict.comparisons)


def test_seeds_that_share_their_episodes_are_judged_too(tmp_path):
    assert judge(tables.whole(tmp_path, (DECEPTION,), shared=True))["joint-defenders"].word == AGREES


def test_more_than_ten_seeds_are_compared_with_the_expert_in_their_own_episodes(tmp_path):
    found = judge(tables.whole(tmp_path, (DECEPTION,), depths=(4,), seeds=12))
    assert found["joint-defenders"].run[0].number.seeds == found["robust-defenders"].run[0].number.seeds == 12
    assert found["robust-defenders"].word == AGREES


def test_a_claim_whose_cells_are_missing_names_the_command(tmp_path):
    found = judge(tables.whole(tmp_path, (DECEPTION,), depths=(4,)))
    assert found["joint-navigation"].reason == (
        "not run: maviper reproduce -o FOLDER --games cooperative-navigation --depths 2,4,6"
    )
    joint = found["joint-defenders"]
    assert joint.word == NOT_DECIDED and joint.reason.startswith("6 of 9 comparisons not run: maviper reproduce")
    assert found["robust-defenders"].word == AGREES


def test_a_command_names_the_expert_that_lacks_the_cells(tmp_path):
    folder = tables.whole(tmp_path, (DECEPTION,), depths=(4,), seeds=1, experts=("maddpg", "mine"))
    maddpg, mine = (judge(folder, name)["joint-navigation"].reason for name in ("maddpg", "mine"))
    assert maddpg.endswith(" --experts maddpg") and mine.endswith(" --experts mine=EXPERT")


def test_absolute_numbers_are_not_compared(ordered):
    found = [verdict for verdict in ordered.values() if verdict.word == NOT_COMPARABLE]
    assert {verdict.claim.test for verdict in found} == {register.NUMBER}
    assert all(verdict.reason and verdict.run for verdict in found)


def test_a_weak_expert_is_said_beside_the_verdict(tmp_path):
    folder = tables.whole(tmp_path, (DECEPTION,), depths=(4,))
    assert not judge(folder)["joint-defenders"].notes
    for path in (folder / "cells").glob("*/episodes.csv"):
        lines = path.read_text().splitlines()
        weak = [f"{head},{float(value) / 2!r}" for head, _, value in (line.rpartition(",") for line in lines[1:])]
        path.write_text("\n".join([lines[0], *weak]) + "\n")
    (note,) = judge(folder)["joint-defenders"].notes
    assert note.startswith("weak expert: defenders success r=0.316 0.45") and note.endswith("the paper's 0.9")


@pytest.mark.parametrize("statistic", ["robustness", "robustness by opponent"])
def test_fewer_opponents_than_the_papers_are_not_averaged(tmp_path, statistic):
    """As by --algorithms maviper,iviper: a mean over those left would be another number under the same name."""
    maker = tables.Maker(tmp_path)
    maker.expert(DECEPTION)
    for algorithm, seed in product(("maviper", "iviper"), range(maker.seeds)):
        maker.extraction(DECEPTION, algorithm, 4, seed)
    for seed in range(maker.seeds):
        maker.crossplay(DECEPTION, seed, players=("maviper", "iviper", "expert"))
    found = judge(maker.write())
    about = [
        each
        for each in found.values()
        if each.claim.statistic == statistic and DECEPTION in each.claim.cells.values()
        if not each.claim.family.startswith(register.FURTHER)
    ]
    assert about and {verdict.word for verdict in about} == {NOT_DECIDED}
    assert all("not run against all of maviper, iviper, imitation, fitted-q, expert" in each.reason for each in about)
    run = {comparison.label for verdict in about for comparison in verdict.run}
    assert bool(run) == (statistic != "robustness") and not any("imitation" in label for label in run)


def test_the_error_of_a_family_holds_for_all_its_words_together():
    """Five comparisons of equals and five that differ by the margin: "equal" and an order may both be said falsely."""
    known, rng = register.read(), np.random.default_rng(3)
    claim = next(each for each in known.claims if each.test == register.GREATER)
    truth, freedom, rounds, wrong = np.repeat([0.0, known.margin], 5), 9, 400, 0
    for _ in range(rounds):
        errors = known.margin / 12 * np.sqrt(rng.chisquare(freedom, len(truth)) / freedom)
        values = truth + known.margin / 12 * rng.normal(size=len(truth))
        numbers = [Number("", (), Estimate(*pair, freedom), 10, 200) for pair in zip(values, errors, strict=True)]
        said = verdicts.decide_family([verdicts.comparison(claim, "", number) for number in numbers], known)
        false = [("better", "worse")] * 5 + [("equal", "worse")] * 5
        wrong += any(each.word in words for each, words in zip(said, false, strict=True))
    assert wrong / rounds <= known.alpha + 3 * math.sqrt(known.alpha * (1 - known.alpha) / rounds)


def test_experts_are_judged_apart(tmp_path):
    folder = tables.whole(tmp_path, (DECEPTION,), depths=(4,), experts=("mappo", "maddpg"))
    one, other = judge(folder), judge(folder, "maddpg")
    first, second = (each["robust-defenders"].run[0].number for each in (one, other))
    assert first.seeds == second.seeds == 6 and first.value != second.value


def test_the_expert_alone_is_found_whatever_seeds_there_are(tmp_path):
    rows = [table.Row("expert", DECEPTION, "mappo", "", "", 0, 0, "", seed, f"from {seed}", 0.0) for seed in (310, 300)]
    alone = Finder(table.Results(tmp_path, tuple(sorted(rows)), {})).alone(Place(DECEPTION, "mappo"))
    assert alone.places == (("from 300", "expert"),)
