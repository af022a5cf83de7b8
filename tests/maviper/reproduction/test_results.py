"""The page of all records: its tables of roles and of the fork's physics have the numbers of their records."""

import hashlib
import json
import re
import tomllib
from pathlib import Path

import numpy as np
import pytest

RECORDS = Path(__file__).parents[3] / "generated" / "reproduction"
PAGE = (RECORDS / "README.md").read_text()
ROWS = [[cell.strip() for cell in line.strip("| ").split("|")] for line in PAGE.splitlines() if line[:1] == "|"]
SAID = " ".join(PAGE.split())


def test_roles_are_those_of_their_record():
    register = (RECORDS / "roles" / "register.toml").read_bytes()
    assert hashlib.sha256(register).hexdigest() in (RECORDS / "roles" / "README.md").read_text()
    tables = (RECORDS / "roles" / "tables.txt").read_text().splitlines()
    cells = {(row[0], row[1]): row for row in map(str.split, tables) if len(row) == 10 and row[0].isdigit()}
    words = {line.split(":")[0].strip(): line.split(":")[1].split() for line in tables if line.startswith("  H")}
    for agents in map(str, tomllib.loads(register.decode())["agents"]):
        none, every = cells[agents, "0"], cells[agents, "1"]
        slope = words[f"H1 joint by share, {agents} agents"]
        told = [none[3], every[3], none[7], every[7], " ".join(slope[:3]), slope[3]]
        assert [agents, *(cell.replace("+", "").replace("0.", ".") for cell in told)] in ROWS
    shift, fewest = words["H2 joint by shift"], words["H4 shift less interaction, 2 agents"]
    assert " ".join(shift[:3]).replace("+", "").replace("0.", ".") in SAID and shift[3] == "OPEN"
    assert fewest[3] == "REFUTED" and ".215 [.144, .285]" in SAID and fewest[:3] == ["-0.215", "[-0.285,", "-0.144]"]
    shifts = [float(row[5]) for row in cells.values()]
    assert sum(value < 0 for value in shifts) == 18 and len(shifts) == 20
    assert [word for name, (*_, word) in words.items() if name[:2] in ("H2", "H3")] == ["OPEN"] * 3


def test_experts_by_the_forks_physics_are_those_of_their_record():
    """How many there are of each measure, what they reach on average and at least and most, also at the end."""
    known = json.loads((RECORDS / "physics.json").read_text())
    for row in tomllib.loads((RECORDS / "physics.toml").read_text())["spread"]:
        experts = known[row["world"]].values()
        told = []
        for which in ("reached", "last"):
            values = [expert[which][row["measure"]] for expert in experts]
            numbers = [re.sub(r"^0", "", f"{number:.3f}") for number in (np.mean(values), min(values), max(values))]
            told.append("{}, {} to {}".format(*numbers))
        paper = f"{row['published']:.2f}".removeprefix("0") if "published" in row else "-"
        assert [row["measure"], f"{len(experts)} of 8", *told, paper] in ROWS
    took = sum(expert["card"]["seconds"] for game in known.values() for expert in game.values())
    assert f"in {took / 3600:.0f} hours of one core" in SAID


@pytest.mark.parametrize("page", sorted(RECORDS.rglob("*.md")), ids=lambda page: page.relative_to(RECORDS).as_posix())
def test_links_and_benchmarks_of_a_page_are_there(page):
    """Or the page says that its script is in the history."""
    text = page.read_text()
    for target in re.findall(r"\]\(([^)#]+)[^)]*\)", text):
        assert target.startswith("https://") or (page.parent / target).exists(), target
    for line in re.findall(r"^.*python -m tests\.benchmarks\..*$", text, re.MULTILINE):
        for name in re.findall(r"tests\.benchmarks\.(\w+)", line):
            there = (RECORDS.parents[1] / "tests" / "benchmarks" / f"{name}.py").exists()
            assert there or "history" in line or "history at commit 223ff896" in text, line
