"""Registered runs (tests/benchmarks/published.py): numbers are paired, committed records say what their cells say."""

import json
import lzma
from dataclasses import replace
from itertools import product
from pathlib import Path

import pytest

from codegen.errors import InputError
from tests.benchmarks import compact, published
from tests.benchmarks.paired import Paired
from tests.benchmarks.registered import Cell, Found, cells_of

REGISTER, DIGEST = published.read_register()
ROOT = Path(__file__).parents[3]
TOLD = {"rounds-deception-maddpg", "data-deception-maddpg", "released-deception-maddpg", "equal-deception"}
TOLD |= {"mended-deception-iviper", "rounds-deception-mappo"}
SPLITS_TOLD = ("deception-maddpg", "adversary-maddpg")
FACTORIAL_TOLD = ("rollouts", "weights", "votes", "choice", "rollouts-choice", "all-four")
RECORD = ROOT / "generated" / "reproduction" / "published"
REPORT = " ".join((RECORD.parent / "README.md").read_text().split())
FIRST = Cell("physical-deception", "maddpg", "paper", "maviper-every-round", 4, 100)


def document(lift):
    """A cell in which the trees reach so much more than half of what the expert does."""
    defenders, adversaries = "defenders success r=0.316", "adversaries success r=0.316"
    values = {"joint:defenders": {defenders: [0.4 + lift, 0.4 + lift]}, "joint:adversaries": {adversaries: [0.5, 0.5]}}
    values["expert"] = {defenders: [0.6, 1.0], adversaries: [0.5, 0.5]}
    return {"register": DIGEST, "values": values, "training": {"stopped_after": 100}, "seconds": 1.0}


@pytest.fixture
def folder(tmp_path):
    """Three whole rows of one comparison."""
    for place, seed in enumerate(REGISTER["seeds"]):
        lifts = {"maviper-every-round": 0.2 + 0.01 * place, "iviper": 0.0, "maviper": 0.1}
        for algorithm, lift in lifts.items():
            cell = replace(FIRST, algorithm=algorithm, seed=seed)
            (tmp_path / cell.name).write_text(json.dumps(document(lift)))
    return tmp_path


def test_effects_of_factors_are_means_over_the_others(tmp_path):
    """A ratio that is a sum of two effects and of one of both together gives exactly these."""
    register, digest = published.read_register("factorial")
    for cell in cells_of(register, register["groups"][0]):
        rollouts, weights, votes, choice = cell.algorithm.split("-")
        high = {"rollouts": rollouts == "all", "votes": votes == "voted"}
        lift = 0.08 * high["rollouts"] - 0.04 * high["votes"] + 0.08 * all(high.values())
        told = {**document(lift), "register": digest}
        if not (cell.seed == 215 and weights == "own" and choice == "all"):
            (tmp_path / cell.name).write_text(json.dumps(told))
    found = Found(register, digest, tmp_path)
    effects = {claim["id"]: found.paired(claim, "maddpg", 4) for claim in register["claims"]}
    assert {len(pair.differences) for name, pair in effects.items() if name != "all-four"} == {15}
    means = {name: pytest.approx(pair.mean * 0.8) for name, pair in effects.items()}
    wanted = {"rollouts": 0.12, "votes": 0.0, "weights": 0.0, "choice": 0.0, "rollouts-votes": 0.04, "all-four": 0.12}
    assert {name: means[name] for name in wanted} == wanted
    assert means["rollouts-weights"] == 0.0 == means["votes-choice"]


def test_numbers_are_paired_by_seed(folder):
    found = Found(REGISTER, DIGEST, folder)
    claim = next(claim for claim in REGISTER["claims"] if claim["id"] == "rounds-deception-maddpg")
    pair = found.paired(claim, "maddpg", 4)
    assert pair.differences == pytest.approx([(0.2 + 0.01 * place) / 0.8 for place in range(10)])
    text = "\n".join(published.table_lines(REGISTER, found))
    assert "rounds-deception-maddpg, maddpg, depth 4: +0.306" in text and "SAME SIZE against 0.488" in text
    assert "family primary: not whole, so no word is given yet" in text


def test_what_signs_and_leaving_prey_come_to_is_kept():
    values = {"joint:prey": {"prey touches": [0.0, 1.0, 2.0], "prey return": [1.0, -5.0, -25.0]}}
    told = compact.summed_up(values)["joint:prey"]
    assert told["prey return"] == {"count": 3, "mean": pytest.approx(-29 / 3), "size": pytest.approx(31 / 3)}
    assert told["prey touches"] == {"count": 3, "mean": 1.0}
    assert told["prey touches inside"] == {"count": 2, "mean": 0.5}
    assert compact.summed_up({"all": {"prey touches": [0.0], "prey return": [-9.0]}})["all"][compact.INSIDE] == {
        "count": 0
    }


def test_a_file_that_is_no_record_or_unpacks_to_more_than_any_is_refused(tmp_path, monkeypatch):
    place = tmp_path / compact.FILE
    place.write_bytes(lzma.compress(b'{"form": "other-1", "cells": {}}'))
    with pytest.raises(ValueError, match="not of the form"):
        compact.unpacked(place)
    monkeypatch.setattr(compact, "MAX_BYTES", 2**16)
    place.write_bytes(lzma.compress(bytes(2**17)))
    with pytest.raises(InputError, match="more than 65536 bytes"):
        compact.unpacked(place)


def test_words_are_corrected_within_the_family():
    clear, none, open_ = ([mean + 0.01 * (-1) ** place for place in range(10)] for mean in (0.3, 0.0, 0.007))
    pairs = [Paired(tuple(each)) for each in (clear, none, open_)]
    assert published.words_of(pairs, 0.05, 0.02) == ["BETTER", "EQUAL", "EQUAL"]
    assert published.words_of(pairs, 0.05, 0.005) == ["BETTER", "NOT DECIDED", "NOT DECIDED"]


@pytest.fixture(scope="module")
def committed():
    """The cells of the committed record."""
    return read_again(REGISTER, DIGEST, RECORD)


def read_again(register, digest, place):
    """A committed record, all of whose cells its register names."""
    found = Found(register, digest, place)
    assert len(found.documents) == len(compact.unpacked(place / compact.FILE)["cells"])
    return found


def test_the_committed_record_is_what_its_cells_say(committed):
    found = committed
    assert "\n".join(published.table_lines(REGISTER, found)) + "\n" == (RECORD / published.TEXT).read_text()
    assert (RECORD / published.README).read_text() == published.page(REGISTER, DIGEST, found)


OTHERS = ["steps", "splits", "factorial"]


@pytest.mark.parametrize("name", [*OTHERS, "random-experts", "more-experts", "learner-experts", "learner-more-experts"])
def test_other_committed_records_are_what_their_cells_say(name):
    register, digest = published.read_register(name)
    place = RECORD.parent / name
    found = read_again(register, digest, place)
    assert "\n".join(published.table_lines(register, found)) + "\n" == (place / published.TEXT).read_text()
    assert (place / published.README).read_text() == published.page(register, digest, found)
    for claim in register["claims"]:
        if claim["id"] in (*SPLITS_TOLD, *FACTORIAL_TOLD):
            assert shown(found.paired(claim, "maddpg", 4)) in REPORT
    drawn = published.drawn(register, found) if "figure" in register else None
    assert drawn is None or drawn == (place / published.FIGURE).read_text()


def test_the_report_says_what_the_record_found(committed):
    said = REPORT[REPORT.index("## All rounds, and the released code") :].partition(" ## ")[0]
    for claim in REGISTER["claims"]:
        if claim["id"] in TOLD:
            assert shown(committed.paired(claim, claim["experts"][0], 4)) in said
    depths = next(claim for claim in REGISTER["claims"] if claim["id"] == "rounds-navigation-iviper-depths")
    for expert, depth in product(depths["experts"], depths["depths"]):
        assert shown(committed.paired(depths, expert, depth)) in said
    measure = "defenders success r=0.316"
    rows = [("paper", "maviper-every-round"), *(("released", name) for name in ("maviper", "iviper", "imitation"))]
    for preset, algorithm in rows:
        row = {"preset": preset, "algorithm": algorithm}
        claim = {"game": "physical-deception", "measure": measure, "row": row}
        values = committed.ratios(claim, "row", "maddpg", 4).values()
        assert len(values) == 10 and f"{sum(values) / 10:.3f}".removeprefix("0") in said


def test_the_report_gives_each_step_the_word_of_its_record():
    register, digest = published.read_register("steps")
    found, lines = read_again(register, digest, RECORD.parent / "steps"), []
    for family in published.families(register):
        lines += published.family_lines(register, found, family)
    for claim in register["claims"]:
        (line,) = (line for line in lines if line.startswith(f"  {claim['id']}, "))
        word, size = line.partition("]")[2].partition(" against")[0].strip().split("; ")
        pair = shown(found.paired(claim, "maddpg", 4))
        assert pair in REPORT if claim["id"] == "lead-undone" else f"| {pair} | {word} | {size} |" in REPORT


def shown(pair):
    """A difference with its interval, as the report writes it."""
    low, high = pair.interval()
    return f"{pair.mean:.3f} [{low:.3f}, {high:.3f}]".replace("0.", ".")
