"""Registered runs of several experts: the expert is the unit, and the report says what their records found."""

import json
import re
from itertools import product

import numpy as np
import pytest

from maviper.reproduction.statistics import of_differences
from tests.benchmarks import published
from tests.benchmarks.registered import HERE, Cell, Found, cells_of

REGISTER, DIGEST = published.read_register("random-experts")
LABELS = tuple(f"mappo-{seed}" for seed in range(200, 208))
FIRST = Cell("physical-deception", LABELS[0], "paper", "maviper-every-round", 4, 500)
GAMES = {"physical-deception": "deception", "cooperative-navigation": "navigation"}
IN_README = {"deception": "deception, MAPPO", "navigation": "navigation, MAPPO"}  # the row of its table, by family
IN_README |= {row: row for row in ("deception, MADDPG", "navigation, MADDPG")}
TOLD_UNDER = {"random-experts": "## Experts as a random level", "more-experts": "## MADDPG experts as a random level"}
REPORT = (published.RECORDS / "README.md").read_text()
CALLED = {**{name: name for name in GAMES.values()}, "deception-maddpg": "deception, MADDPG"}
CALLED |= {"navigation-maddpg": "navigation, MADDPG", "predators-mappo": "predators, MAPPO"}
CALLED |= {"predators-maddpg": "predators, MADDPG"}
OVER = {"iviper": "over IVIPER", "imitation": "over imitation", "return": "prey's return", "touches": "prey's touches"}
DEFENDERS, ADVERSARIES = "defenders success r=0.316", "adversaries success r=0.316"


def document(reached, network):
    """A cell in which the defenders reach so much, and their expert .8."""
    values = {"joint:defenders": {DEFENDERS: [reached] * 2}, "joint:adversaries": {ADVERSARIES: [0.5, 0.5]}}
    values["expert"] = {DEFENDERS: [0.6, 1.0], ADVERSARIES: [0.5, 0.5]}
    told = {"register": DIGEST, "expert": network, "training": {"stopped_after": 100}, "seconds": 1.0}
    return {**told, "values": values}


def fill(folder, lifts):
    """Cells of deception: by algorithm and place of the tree's seed, what it reaches more than .6 for each expert."""
    for cell in cells_of(REGISTER, REGISTER["groups"][0]):
        place = LABELS.index(cell.expert)
        lift = lifts[cell.algorithm](place, cell.seed % 2)
        (folder / cell.name).write_text(json.dumps(document(0.6 + lift, f"network {place}")))


def lines_of(folder):
    return published.family_lines(REGISTER, Found(REGISTER, DIGEST, folder), "deception")


def test_the_unit_is_the_expert(tmp_path):
    """Its seeds give one number; half of an expert gives none."""
    ours = {"maviper-every-round": lambda place, seed: 0.1 + 0.01 * place + 0.06 * seed}
    fill(tmp_path, {**ours, "iviper": lambda place, seed: 0.02 * seed, "imitation": lambda place, seed: 0.0})
    (claim, *_) = REGISTER["claims"]
    pair = Found(REGISTER, DIGEST, tmp_path).paired(claim, LABELS, 4)
    differences = [(0.12 + 0.01 * place) / 0.8 for place in range(8)]
    assert pair.differences == pytest.approx(differences)
    assert pair.interval() == pytest.approx(of_differences(differences).interval())
    low, high = (np.mean(differences) + side * 2.364624 * np.std(differences, ddof=1) / 8**0.5 for side in (-1, 1))
    assert pair.interval() == pytest.approx((low, high), rel=1e-5)  # t of 7 degrees of freedom
    assert any(
        "experts-deception-iviper, 8 experts" in line and "BETTER; SMALLER" in line for line in lines_of(tmp_path)
    )
    (tmp_path / FIRST.name).unlink()
    assert len(Found(REGISTER, DIGEST, tmp_path).paired(claim, LABELS, 4).differences) == 7
    assert lines_of(tmp_path)[1:] == [
        "family deception: not whole, so no word is given yet",
        "  experts-deception-iviper, 8 experts, depth 4: 7 of 8 experts",
        "  experts-deception-imitation, 8 experts, depth 4: 7 of 8 experts",
    ]


def rows_of(text):
    """The rows of the tables of a text, without the space that aligns them."""
    return [" | ".join(map(str.strip, line.strip("| ").split("|"))) for line in text.splitlines() if line[:1] == "|"]


@pytest.mark.parametrize("name", ["random-experts", "more-experts"])
def test_the_report_says_what_the_record_found(name):
    """How many experts there are, what each algorithm keeps of them; words where a family is whole, and only there."""
    register, digest = published.read_register(name)
    found = Found(register, digest, published.RECORDS / name)
    said = REPORT.partition(TOLD_UNDER[name])[2].partition("\n#")[0]
    rows = rows_of(said)
    for group in register["groups"]:
        claim, ratios = {"game": group["game"], "measure": group["measures"][0]}, []
        for algorithm in group["algorithms"]:
            side = {"preset": group["preset"], "algorithm": algorithm}
            ratios.append(found.ratios({**claim, "row": side}, "row", tuple(group["experts"]), 4))
        count = min(map(len, ratios))  # experts come one after the other, so the last may lack an algorithm
        means = [f"{np.mean([*each.values()][:count]):.3f}".removeprefix("0") for each in ratios if count]
        row = f"{CALLED[group['name']]} | {count} of {len(group['experts'])} | {' | '.join(means)}"
        assert not count or row in rows, row
    for family in published.families(register):
        for line in published.family_lines(register, found, family)[2:]:
            claim, _, told = line.strip().partition(": ")
            if "]" not in told:
                continue
            interval, _, words = told.partition("]  ")
            mean, low, high = (number.strip("+,") for number in interval.replace("[", "").split())
            lead = f"{mean} [{low}, {high}]".replace("0.", ".")
            over = OVER[claim.partition(",")[0].partition("-")[2].partition("-")[2]]
            word, size = words.partition(" against")[0].split("; ")
            row = f"{family}, {over} | {lead} | {word.replace(' the rule of the ceiling', '')} | {size}"
            assert row in rows, row
            if family in IN_README and over == "over IVIPER":
                readme = (HERE.parents[1] / "README.md").read_text()
                assert re.search(rf"\| {IN_README[family]} [^\n]*\| {re.escape(lead)} +\|", readme)
    whole = sum(len(cells_of(register, group)) for group in register["groups"])
    assert ("is partial" in said) == (len(found.documents) < whole)


def test_the_report_has_all_leads_over_iviper_in_one_table():
    """Of each team and kind of expert: with one expert, with fresh ones, and the paper's, by the registers."""
    rows = rows_of(REPORT)
    for team, kind in product(("deception", "navigation", "predators"), ("maddpg", "mappo")):
        name = "random-experts" if kind == "mappo" and team != "predators" else "more-experts"
        one = "rounds-predators" if team == "predators" else f"rounds-{team}-{kind}"
        fresh = f"experts-{team}-iviper" if name == "random-experts" else f"{kind}-{team}-iviper"
        told = []
        for register_name, wanted in (("published", one), (name, fresh)):
            register, digest = published.read_register(register_name)
            found = Found(register, digest, published.RECORDS / register_name)
            (claim,) = (each for each in register["claims"] if each["id"] == wanted)
            experts = tuple(claim["experts"]) if register_name == name else kind
            pair = found.paired(claim, experts, 4)
            told.append("{:.3f} [{:.3f}, {:.3f}]".format(pair.mean, *pair.interval()))
        paper = f"{claim['effect']:.3f}" if kind == "maddpg" and claim["from"].startswith("table") else "-"
        assert " | ".join([f"{team}, {kind.upper()}", *told, paper]).replace("0.", ".") in rows


@pytest.mark.parametrize("name", ["learner-experts", "learner-more-experts"])
def test_the_report_has_the_table_of_the_learner(name):
    """What each algorithm keeps over eight experts, and the lead over the best of the others, at each depth."""
    register, digest = published.read_register(name)
    found = Found(register, digest, published.RECORDS / name)
    rows = rows_of(REPORT)
    by = {(c["game"], tuple(c["experts"]), c["second"]["algorithm"]): c for c in register["claims"]}
    for game, experts, depth in {(c["game"], tuple(c["experts"]), d) for c in register["claims"] for d in c["depths"]}:
        (measure,) = {claim["measure"] for (of, who, _), claim in by.items() if (of, who) == (game, experts)}
        means = {}
        for algorithm in ("best-response", "maviper", "iviper", "imitation"):
            claim = {"game": game, "measure": measure, "row": {"preset": "equal", "algorithm": algorithm}}
            ratios = found.ratios(claim, "row", experts, depth)
            if len(ratios) < len(experts):
                break  # a family that is not whole has no row
            means[algorithm] = float(np.mean(list(ratios.values())))
        else:
            best = max((each for each in means if each != "best-response"), key=means.__getitem__)
            pair = found.paired(by[game, experts, best], experts, depth)
            kind = experts[0].partition("-")[0].upper()
            numbers = [f"{GAMES.get(game, 'predators')}, {kind}, {depth}", *(f"{mean:.3f}" for mean in means.values())]
            lead = "{:.3f} [{:.3f}, {:.3f}]".format(pair.mean, *pair.interval())
            assert " | ".join([*numbers, lead]).replace("0.", ".") in rows
