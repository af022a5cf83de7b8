"""Registered cells (tests/benchmarks/registered.py): records say what their cells say, the report what records say."""

import importlib.util
import json
import lzma
import re
import subprocess
import sys

import numpy as np
import pytest
from scipy.stats import linregress, t

from codegen.errors import InputError
from maviper.reproduction.statistics import holm, of_differences, size
from maviper.worlds import find_built_in
from tests.benchmarks import compact, registered
from tests.benchmarks.registered import RECORDS, ROOT, cells_of, read_register, settings_of

FOLDERS = ("experts", "parts")
REGISTERS = sorted(
    path for path in RECORDS.glob("*/*.toml") if 'format = "maviper-published-1"' in path.read_text(encoding="utf-8")
)
REPORT = (RECORDS / "README.md").read_text()
README = (ROOT / "README.md").read_text()
NUMBER = r"-?\d*\.\d{3}"
DEFENDERS = "defenders success r=0.316"


def script_of(folder="experts"):
    """The script of a record, as a module of its own."""
    spec = importlib.util.spec_from_file_location("recompute", RECORDS / folder / "recompute.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.parametrize("folder", [*FOLDERS, "roles"])
def test_tables_are_what_the_cells_say(folder):
    found = subprocess.run([sys.executable, RECORDS / folder / "recompute.py"], capture_output=True, check=True)
    assert found.stdout.decode() == (RECORDS / folder / "tables.txt").read_text()


def test_figures_are_what_the_cells_say():
    found = subprocess.run([sys.executable, RECORDS / "paper" / "figures.py"], capture_output=True, check=True)
    assert found.stdout.decode() == (RECORDS / "paper" / "figures.txt").read_text()


def test_records_have_one_script():
    assert len({(RECORDS / folder / "recompute.py").read_bytes() for folder in FOLDERS}) == 1


@pytest.mark.parametrize("folder", FOLDERS)
def test_every_cell_is_one_of_a_register(folder):
    """Or of the one whose cells stand beside, by its hash."""
    registers = [read_register(path) for path in REGISTERS if path.parent.name == folder]
    beside = {register["beside"]["sha256"] for register in registers if "beside" in register}
    names = {
        cell.name: register["sha256"]
        for register in registers
        for group in register["groups"]
        for cell in cells_of(register, group)
    }
    cells = compact.unpacked(RECORDS / folder / compact.FILE)["cells"]
    assert cells
    for name, cell in cells.items():
        assert cell["register"] == names[name] if name in names else cell["register"] in beside, name


@pytest.mark.parametrize("path", REGISTERS, ids=lambda path: path.stem)
def test_every_cell_of_a_register_can_be_asked_for(path):
    register = read_register(path)
    for group in register["groups"]:
        world = find_built_in(group["game"])
        for cell in cells_of(register, group)[: len(group["algorithms"]) * len(group["depths"])]:
            assert settings_of(register, world, cell).max_depth == cell.depth
    assert registered.plan_lines(register)[-1].endswith("by the register's seconds")


# --- numbers


@pytest.mark.parametrize("seed", range(5))
def test_words_are_those_of_the_product(seed):
    """Intervals, p-values and sizes of a script that needs numpy alone."""
    script, rng = script_of(), np.random.default_rng(seed)
    pairs = [rng.normal(mean, 0.02, int(rng.integers(3, 16))) for mean in (0.3, 0.0, 0.02, -0.1)]
    known = [of_differences(pair) for pair in pairs]
    p = holm([each for one in known for each in (one.p_differs(), one.p_equal(0.02))], len(known))
    told = []
    for one, differs, equal in zip(known, p[::2], p[1::2], strict=True):
        told.append(
            "EQUAL" if equal <= 0.05 else "NOT DECIDED" if differs > 0.05 else "BETTER" if one.value > 0 else "WORSE"
        )
    assert list(script.words_of(pairs, 0.05, 0.02)) == told
    for pair, one in zip(pairs, known, strict=True):
        assert script.interval(pair) == pytest.approx(one.interval(), abs=1e-5)
        assert script.size(0.2, *one.interval()) == size(0.2, *one.interval())


def document(reached):
    """A cell in which the defenders reach so much, and their expert .8."""
    values = {"joint:defenders": {DEFENDERS: {"mean": reached}}, "expert": {DEFENDERS: {"mean": 0.8}}}
    return {"values": values}


def test_the_unit_is_the_expert():
    """Its seeds give one number; half of an expert gives none."""
    script = script_of()
    register = script.read(RECORDS / "experts" / "random-experts.toml")
    claim = register["claims"][0]
    for cell in cells_of(register, register["groups"][0]):
        place = claim["experts"][0].index(cell.expert)
        ours = 0.1 + 0.01 * place if cell.algorithm == "maviper-every-round" else 0.0
        script.CELLS[cell.name] = document(0.5 + ours + 0.06 * (cell.seed % 2))
    (line, *_) = list(script.family_of(register, "deception"))[1:]
    assert line.startswith("  experts-deception-iviper, 8 experts, depth 4: +0.169 [") and "BETTER" in line
    del script.CELLS[cells_of(register, register["groups"][0])[0].name]
    found = list(script.family_of(register, "deception"))
    assert found[0].endswith("not whole, so no word is given yet") and found[1].endswith(": 7 of 8")


def test_effects_of_factors_are_means_over_the_others():
    """A ratio that is a sum of two effects and of one of both together gives exactly these."""
    script = script_of("parts")
    register = script.read(RECORDS / "parts" / "factorial.toml")
    machine = read_register(RECORDS / "parts" / "factorial.toml")
    for cell in cells_of(machine, machine["groups"][0]):
        rollouts, _, votes, _ = (level in ("all", "voted") for level in cell.algorithm.split("-"))
        script.CELLS[cell.name] = document(0.4 + 0.08 * rollouts - 0.04 * votes + 0.08 * (rollouts and votes))
    lines = [line for name in ("main", "together", "ends") for line in script.family_of(register, name)]
    told = {line.split(",")[0].strip(): float(line.split(": ")[1].split()[0]) for line in lines if "depth" in line}
    wanted = {"rollouts": 0.15, "votes": 0.0, "weights": 0.0, "choice": 0.0, "rollouts-votes": 0.05, "all-four": 0.15}
    assert {name: told[name] for name in wanted} == pytest.approx(wanted, abs=1e-3)


# --- the machine


def test_a_cell_is_made_again_and_recorded(tmp_path):
    text, few = (
        (RECORDS / "parts" / "rounds.toml").read_text(),
        "iterations = 1\nrollouts = 2\nselection_episodes = 2\n",
    )
    place = tmp_path / "rounds.toml"
    place.write_text(text.replace("iterations = 12\n", few))
    (tmp_path / "recompute.py").write_bytes((RECORDS / "parts" / "recompute.py").read_bytes())
    register = read_register(place)
    cell = next(each for each in cells_of(register, register["groups"][0]) if each.algorithm == "rounds-12")
    first = registered.again_lines(register, cell.name, tmp_path / "cells", None)
    assert first[1] == "none  in the record"
    assert registered.record(register, tmp_path / "cells") == 1
    assert registered.again_lines(register, cell.name, tmp_path / "more", None)[1].split()[0] == first[0].split()[0]
    assert "physical-deception maddpg 1 seeds paper rounds-12" in (tmp_path / "tables.txt").read_text()


def test_the_usual_assignment_of_an_expert_with_fixed_roles():
    cell = registered.Cell("physical-deception", "mappo", "equal", "iviper", 4, 1300)
    expert, world = registered.expert_of("physical-deception", "mappo")
    assert registered.usual_assignment(world, expert, cell) > 0.9


@pytest.mark.parametrize("grows, word", [(0.5, "HOLDS"), (-0.5, "REFUTED"), (0.0, "OPEN")])
def test_leads_over_demand_are_told_as_scipy_has_them(capsys, monkeypatch, grows, word):
    script, register, rng = (
        script_of("roles"),
        read_register(RECORDS / "roles" / "experts.toml"),
        np.random.default_rng(0),
    )
    cells, fits = {}, {}
    for group in register["groups"]:
        demand, label = rng.uniform(size=8), group["measures"][0]
        lead = 0.1 + grows * demand + rng.normal(0, 0.02, size=8)
        fits[group["name"]] = linregress(demand, lead)
        for cell in cells_of(register, group):
            at = group["experts"].index(cell.expert)
            kept = 0.4 + (lead[at] if cell.algorithm == "rollouts" else 0)
            ours = {label: {"mean": 1 / kept if label == "agents D" else kept}}
            values = {"expert": {label: {"mean": 1.0}}, f"joint:{label.partition(' ')[0]}": ours}
            cells[cell.name] = {"usual": 1 - demand[at], "values": values}
    monkeypatch.setattr(script, "CELLS", cells)
    script.trained()
    told = re.findall(
        rf"lead over demand, (\w+): ([+-]{NUMBER}) \[([+-]{NUMBER}), ([+-]{NUMBER})\]  (\w+)", capsys.readouterr().out
    )
    for name, *numbers, said in told:
        fit, half = fits[name], t.ppf(0.975, 6) * fits[name].stderr
        assert [float(number) for number in numbers] == pytest.approx(
            [fit.slope, fit.slope - half, fit.slope + half], abs=1e-3
        )
        assert said == word
    assert len(told) == 2


# --- what is said


def triples_of(text):
    """Every difference with its interval in a text, without signs that both share."""
    text = " ".join(text.replace("+", "").split())
    found = re.findall(rf"({NUMBER}) \[({NUMBER}), ({NUMBER})\]", text)
    return [tuple(float(number) for number in triple) for triple in found]


def test_every_difference_that_is_told_stands_in_a_table():
    """Also with the sides changed; those of pilots are of records that are no longer here."""
    tables = [*RECORDS.glob("*/tables.txt"), *RECORDS.glob("*/figures.txt")]
    known = {triple for path in tables for triple in triples_of(path.read_text())}
    known |= {(-mean, -high, -low) for mean, low, high in known}
    told = triples_of(REPORT.partition("## Pilots")[0]) + triples_of(README)
    assert len(told) > 150
    assert [triple for triple in told if triple not in known] == []


def test_levels_that_are_told_stand_in_tables():
    """The rows of what trees keep of the expert, by algorithm."""
    tables = [*RECORDS.glob("*/tables.txt"), *RECORDS.glob("*/figures.txt")]
    known = set(re.findall(r"\d\.\d{3}", "".join(path.read_text() for path in tables)))
    rows = [
        line for line in REPORT.splitlines() if re.match(r"\| (deception|navigation|predators), (MADDPG|MAPPO)", line)
    ]
    levels = [number for row in rows for number in re.findall(r"(?<![\d\[-])\.\d{3}(?= +\|)", row)]
    assert len(levels) > 80 and [each for each in levels if f"0{each}" not in known] == []


# --- the compact form


def test_what_signs_and_leaving_prey_come_to_is_kept():
    values = {"joint:prey": {"prey touches": [0.0, 1.0, 2.0], "prey return": [1.0, -5.0, -25.0]}}
    told = compact.summed_up(values)["joint:prey"]
    assert told["prey return"] == {"count": 3, "mean": pytest.approx(-29 / 3), "size": pytest.approx(31 / 3)}
    assert told["prey touches"] == {"count": 3, "mean": 1.0}
    assert told["prey touches inside"] == {"count": 2, "mean": 0.5}
    none = compact.summed_up({"all": {"prey touches": [0.0], "prey return": [-9.0]}})
    assert none["all"][compact.INSIDE] == {"count": 0}


def test_a_file_that_is_no_record_or_unpacks_to_more_than_any_is_refused(tmp_path, monkeypatch):
    place = tmp_path / compact.FILE
    place.write_bytes(lzma.compress(json.dumps({"form": "other-1", "cells": {}}).encode()))
    with pytest.raises(ValueError, match="not of the form"):
        compact.unpacked(place)
    monkeypatch.setattr(compact, "MAX_BYTES", 2**16)
    place.write_bytes(lzma.compress(bytes(2**17)))
    with pytest.raises(InputError, match="more than 65536 bytes"):
        compact.unpacked(place)
