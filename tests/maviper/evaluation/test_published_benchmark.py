"""The registers of tests/benchmarks/published.py: they can be carried out, and their numbers are paired."""

import hashlib
import json
import lzma
from dataclasses import replace
from itertools import product
from pathlib import Path

import pytest

from codegen.errors import InputError
from maviper.extraction.settings import MAX_NUMBER, PARTS, bundle, group_agents
from tests.benchmarks import compact, published
from tests.benchmarks.paired import Paired
from tests.benchmarks.registered import (
    Cell,
    Found,
    beside_of,
    cells_of,
    comparisons_of,
    expert_of,
    made,
    settings_of,
    world_of,
)
from tests.benchmarks.trained import tree_seeds_of

REGISTER, DIGEST = published.read_register()
ROOT = Path(__file__).parents[3]
TOLD = {"rounds-deception-maddpg", "data-deception-maddpg", "released-deception-maddpg", "equal-deception"}
TOLD |= {"mended-deception-iviper", "rounds-deception-mappo"}
SPLITS_TOLD = ("deception-maddpg", "adversary-maddpg")
FACTORIAL_TOLD = ("rollouts", "weights", "votes", "choice", "rollouts-choice", "all-four")
RECORD = ROOT / "generated" / "reproduction" / "published"
REPORT = " ".join((RECORD.parent / "README.md").read_text().split())
FIRST = Cell("physical-deception", "maddpg", "paper", "maviper-every-round", 4, 100)


def everything():
    return [cell for group in REGISTER["groups"] for cell in cells_of(REGISTER, group)]


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


def test_six_primary_claims_are_one_family():
    primary = [each for each in comparisons_of(REGISTER) if each[0] == "primary"]
    assert len(primary) == 6
    assert len({claim["id"] for claim in REGISTER["claims"]}) == len(REGISTER["claims"])


def test_every_comparison_has_its_cells_and_a_measure_of_its_game():
    known = set(everything())
    assert len(known) == len(everything())
    for _, claim, expert, depth in comparisons_of(REGISTER):
        for side in (claim["first"], claim["second"]):
            cells = {Cell(claim["game"], expert, **side, depth=depth, seed=seed) for seed in REGISTER["seeds"]}
            assert cells <= known, claim["id"]
        group = next(each for each in REGISTER["groups"] if each["game"] == claim["game"])
        assert claim["measure"] in group["measures"], claim["id"]


@pytest.mark.parametrize("name", ["steps", "splits"])
def test_other_registers_can_be_carried_out_beside_the_record(name):
    """Every comparison and every row of a figure has its cells here or in the record, and settings that are allowed."""
    register, _ = published.read_register(name)
    own = {cell for group in register["groups"] for cell in cells_of(register, group)}
    beside = set(beside_of(register))
    assert len({claim["id"] for claim in register["claims"]}) == len(register["claims"])
    wanted = [
        Cell(claim["game"], expert, **claim[side], depth=depth, seed=seed)
        for _, claim, expert, depth in comparisons_of(register)
        for side in ("first", "second")
        for seed in register["seeds"]
    ]
    about = register.get("figure", {"rows": []})
    wanted += [
        Cell(about["game"], about["expert"], **row[side], depth=about["depth"], seed=seed)
        for row in about["rows"]
        for side in ("of", "less")
        if side in row
        for seed in register["seeds"]
    ]
    assert set(wanted) <= own | beside
    for cell in {replace(each, seed=0) for each in own}:
        settings = settings_of(register, expert_of(cell.game, cell.expert)[1], cell)
        assert settings.preset == {"steps": "released", "splits": "paper"}[name]
        assert (settings.splits == "exact") == (cell.preset != "paper")
        assert bool(settings.undo) == (name == "steps") and not settings.refinement


def test_the_factorial_has_both_algorithms_at_its_ends_and_equal_episodes():
    register, _ = published.read_register("factorial")
    (group,) = register["groups"]
    cells = [cell for cell in cells_of(register, group) if cell.seed == register["seeds"][0]]
    names = {cell.algorithm for cell in cells}
    assert len(cells) == 16 and names == set(group["seconds"]) == set(register["algorithms"])
    world, episodes = expert_of(group["game"], "maddpg")[1], set()
    found = {cell.algorithm: settings_of(register, world, cell) for cell in cells}
    for settings in found.values():
        playing = len(group_agents(world, settings.rollouts_by, range(3)))
        judged = 2 if settings.selection_by == "all" else 3  # teams, or agents
        rounds = playing * settings.rollouts + judged * settings.selection_episodes
        episodes.add(settings.iterations * rounds)
        assert settings.patience == MAX_NUMBER and settings.splits == "histogram"
    assert episodes == {50 * (48 + 198)}
    for name, algorithm in (("agent-own-free-agent", "iviper"), ("all-averaged-voted-all", "maviper")):
        usual = bundle(algorithm, "uniform")
        assert {part: getattr(found[name], part) for part in PARTS} == usual
    assert len({tuple(getattr(each, part) for part in PARTS) for each in found.values()}) == 16


@pytest.mark.parametrize("name", ["learner-experts", "learner-more-experts"])
def test_the_learner_has_the_episodes_of_what_it_is_compared_with(name):
    register, _ = published.read_register(name)
    known = {cell for group in register["groups"] for cell in cells_of(register, group)}
    for _, claim, expert, depth in comparisons_of(register):
        for label in expert if isinstance(expert, tuple) else (expert,):
            seed = tree_seeds_of(register, label)[0]
            assert {
                Cell(claim["game"], label, **claim[side], depth=depth, seed=seed) for side in ("first", "second")
            } < known
    for group in register["groups"]:
        world, measures = world_of(register, group["game"], group["experts"][0]), set()
        assert set(group["seconds"]) == set(group["algorithms"]) == set(register["algorithms"])
        cells = {replace(cell, seed=0) for cell in cells_of(register, {**group, "depths": [4]})}
        for cell in cells:
            settings, agents = settings_of(register, world, cell), range(len(world.agents))
            rollouts = len(group_agents(world, settings.rollouts_by, agents)) * settings.rollouts
            judged = len(agents) if settings.selection_by == "agent" else len(world.teams)
            assert settings.iterations * rollouts == 2_400 and not settings.refinement
            assert 9_800 <= settings.iterations * judged * settings.selection_episodes <= 9_900
            assert settings.patience == MAX_NUMBER and settings.splits == "histogram"
            measures.add(settings.measure_in(world))
        assert len(measures) == 1


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


def test_a_figure_has_the_rows_whose_cells_are_there(tmp_path):
    register, digest = published.read_register("steps")
    text = published.drawn(register, Found(register, digest, tmp_path))
    assert "MAVIPER, published: 0.844" in text and "released code: 0.645 [" in text and "mended leaves" not in text
    assert text.count("the text, all rounds: ") == 2


def test_a_record_of_another_register_is_not_stood_beside(monkeypatch):
    register, _ = published.read_register("steps")
    with pytest.raises(SystemExit, match="not the register that this one names"):
        beside_of({**register, "beside": {**register["beside"], "sha256": "0" * 64}})


def test_seeds_are_fresh_and_settings_are_the_published_ones():
    assert REGISTER["seeds"] == list(range(100, 110))
    for cell in everything():
        world = expert_of(cell.game, cell.expert)[1]
        settings, agents = settings_of(REGISTER, world, cell), len(world.agents)
        if cell.algorithm == "maviper-every-round" or cell.preset == "released":
            assert settings.patience == MAX_NUMBER
        if cell.algorithm == "maviper-every-round":
            assert (settings.iterations, settings.rollouts) == (100, 50)
        if cell.algorithm == "iviper-equal-episodes":
            assert 4_800 <= settings.iterations * settings.rollouts * agents <= 5_000


def test_numbers_are_paired_by_seed(folder):
    found = Found(REGISTER, DIGEST, folder)
    claim = next(claim for claim in REGISTER["claims"] if claim["id"] == "rounds-deception-maddpg")
    pair = found.paired(claim, "maddpg", 4)
    assert pair.differences == pytest.approx([(0.2 + 0.01 * place) / 0.8 for place in range(10)])
    text = "\n".join(published.table_lines(REGISTER, found))
    assert "rounds-deception-maddpg, maddpg, depth 4: +0.306" in text and "SAME SIZE against 0.488" in text
    assert "family primary: not whole, so no word is given yet" in text


def test_the_record_says_that_it_is_partial_and_holds_the_cells(folder, tmp_path):
    found = Found(REGISTER, DIGEST, folder)
    places = [tmp_path / name for name in ("one", "two")]
    for place in places:
        published.recorded(REGISTER, DIGEST, found, place)
    one, two = ({path.name: path.read_bytes() for path in place.iterdir()} for place in places)
    whole = {compact.FILE, "tables.txt", "README.md", "physical-deception.svg"}
    assert one == two and set(one) == whole
    drawing = one["physical-deception.svg"].decode()
    assert "expert by MADDPG: 0.8" in drawing and "MAVIPER, all rounds: " in drawing and "imitation" not in drawing
    text = one["README.md"].decode()
    assert "**This record is partial.**" in text and DIGEST in text
    assert Found(REGISTER, DIGEST, places[0]).documents == found.documents  # read again, it gives the same


def test_a_record_says_of_a_cell_what_its_episodes_come_to(folder):
    told = made(DIGEST, FIRST, folder)
    values = json.loads((folder / FIRST.name).read_text())["values"]
    assert told["values"]["expert"]["defenders success r=0.316"] == {"count": 2, "mean": 0.8}
    assert told["values"]["joint:defenders"]["defenders success r=0.316"]["mean"] == pytest.approx(0.6)
    table = compact.table_of(values, FIRST.episodes[0])
    assert table.splitlines()[1] == f"joint:defenders,defenders success r=0.316,{FIRST.episodes[0]},{0.4 + 0.2!r}"
    assert told["sha256"] == hashlib.sha256(table.encode()).hexdigest()
    values["expert"]["defenders success r=0.316"][1] = 1.0 - 2**-53
    assert compact.hash_of(compact.table_of(values, FIRST.episodes[0])) != told["sha256"]


def test_what_signs_and_leaving_prey_come_to_is_kept():
    values = {"joint:prey": {"prey touches": [0.0, 1.0, 2.0], "prey return": [1.0, -5.0, -25.0]}}
    told = compact.summed_up(values)["joint:prey"]
    assert told["prey return"] == {"count": 3, "mean": pytest.approx(-29 / 3), "size": pytest.approx(31 / 3)}
    assert told["prey touches"] == {"count": 3, "mean": 1.0}
    assert told["prey touches inside"] == {"count": 2, "mean": 0.5}
    assert compact.summed_up({"all": {"prey touches": [0.0], "prey return": [-9.0]}})["all"][compact.INSIDE] == {
        "count": 0
    }


def test_a_cell_is_made_again_beside_its_recorded_hash(folder):
    lines = published.again_lines(REGISTER, DIGEST, FIRST.name, folder, "published")
    assert lines[0] == f"{made(DIGEST, FIRST, folder)['sha256']}  {FIRST.name}"
    kept = compact.unpacked(RECORD / compact.FILE)["cells"][FIRST.name]["sha256"]
    assert lines[1] == f"{kept}  in the committed record" and len(kept) == 64
    with pytest.raises(SystemExit, match="no cell of the register"):
        published.again_lines(REGISTER, DIGEST, "cell.json", folder, "published")


def test_a_file_that_is_no_record_or_unpacks_to_more_than_any_is_refused(tmp_path, monkeypatch):
    place = tmp_path / compact.FILE
    place.write_bytes(lzma.compress(b'{"form": "other-1", "cells": {}}'))
    with pytest.raises(ValueError, match="not of the form"):
        compact.unpacked(place)
    monkeypatch.setattr(compact, "MAX_BYTES", 2**16)
    place.write_bytes(lzma.compress(bytes(2**17)))
    with pytest.raises(InputError, match="more than 65536 bytes"):
        compact.unpacked(place)


def test_a_cell_of_another_register_ends_the_run(folder):
    place = folder / FIRST.name
    place.write_text(json.dumps({**document(0.1), "register": "0" * 64}))
    with pytest.raises(SystemExit, match="another register"):
        made(DIGEST, FIRST, folder)


def test_the_plan_has_costs_and_power_for_everything():
    text = "\n".join(published.plan_lines(REGISTER))
    assert "CPU hours in all" in text
    assert all(claim["id"] in text for claim in REGISTER["claims"])


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
