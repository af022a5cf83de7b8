"""The register of tests/benchmarks/roles.py: its cells can be made, and its numbers are what it says."""

import json

import pytest

from maviper.experts.finding import find_expert
from maviper.extraction.settings import AGENT
from tests.benchmarks import compact, roles

REGISTER, DIGEST = roles.read_register()


def document(cell, joint, shift=0.3, interaction=0.1):
    """A cell whose expert has D = 2."""
    told = {"expert": 2.0, "alone": 4.0, "joint": 4.0 - 2 * joint, "voted": 4.0 - 2 * joint}
    terms = {"gap": 2.0, "individual": 1.0, "shift": 2 * shift, "interaction": 2 * interaction}
    return {"register": DIGEST, "D": told, "why": terms, "seconds": 1.0}


def test_all_ways_play_equally_many_episodes():
    for agents in REGISTER["agents"]:
        world = find_expert(f"{REGISTER['game']},agents={agents}@mixed-roles-0.5")[1]
        for way in REGISTER["ways"]:
            settings = roles.settings_of(REGISTER, world, 400, way)
            playing = agents if settings.rollouts_by == AGENT else 1
            judged = agents if settings.selection_by == AGENT else 1
            dealt = playing * settings.rollouts, judged * settings.selection_episodes
            assert dealt == tuple(REGISTER["per_round"].values()) and settings.iterations == 20
            assert settings.weights == "equal" and not settings.refinement


def test_slopes_and_differences_are_found_again(tmp_path):
    """A gain that is half the share and a fifth of the shift."""
    for place, cell in enumerate(roles.cells_of(REGISTER)):
        shift = 0.1 * (place % 3)
        told = document(cell, joint=0.5 * float(cell.share) + 0.2 * shift, shift=shift, interaction=0.01 * (place % 5))
        if cell.seed != 405 or cell.agents != 6:
            (tmp_path / cell.name).write_text(json.dumps(told))
    found = roles.found_in(REGISTER, DIGEST, tmp_path)
    told = roles.hypotheses(REGISTER, found)
    assert {len(each) for each in told.values()} == {5}  # the last seed is not whole
    assert len(told) == 3 + 2 * len(REGISTER["agents"])
    assert told["H4 shift less interaction, 2 agents"][0] == pytest.approx(0.1 * (4 % 3) - 0.01 * 4)
    text = "\n".join(roles.table_lines(REGISTER, found))
    assert "not every seed is whole" in text and "no word yet" in text


def test_words_follow_the_hypotheses():
    told = {"H1": [0.2, 0.21, 0.19], "H2b": [0.3, 0.31, 0.29], "H3": [-0.2, -0.21, -0.19], "H4": [0.1, -0.1, 0.05]}
    lines = list(roles.words(REGISTER, told, True))
    assert [line.split()[-1] for line in lines] == [roles.HOLDS, roles.REFUTED, roles.REFUTED, roles.OPEN]


def test_a_cell_of_another_register_ends_the_run(tmp_path):
    cell = roles.cells_of(REGISTER)[0]
    (tmp_path / cell.name).write_text(json.dumps({**document(cell, 0.1), "register": "0" * 64}))
    with pytest.raises(SystemExit, match="another register"):
        roles.found_in(REGISTER, DIGEST, tmp_path)


def test_the_committed_record_is_what_its_cells_say(tmp_path):
    record = roles.FILE.parents[2] / "generated" / "reproduction" / "roles"
    found = roles.found_in(REGISTER, DIGEST, record)
    assert found and len(found) == len(compact.unpacked(record / compact.FILE)["cells"])
    roles.recorded(REGISTER, DIGEST, found, tmp_path / "again")
    for path in record.iterdir():
        assert path.read_bytes() == (tmp_path / "again" / path.name).read_bytes()
    cell, told = next(iter(found.items()))  # a file goes before what the record has
    (tmp_path / "again" / cell.name).write_text(json.dumps({**told, "seconds": 0.5}))
    assert roles.found_in(REGISTER, DIGEST, tmp_path / "again") == {**found, cell: {**told, "seconds": 0.5}}


def test_the_manual_says_what_the_committed_record_says():
    root = roles.FILE.parents[2]
    tables = (root / "generated" / "reproduction" / "roles" / "tables.txt").read_text().splitlines()
    page = (root / "maviper" / "manual" / "theory.md").read_text()
    cells = {(row[0], row[1]): row for row in map(str.split, tables) if len(row) == 9 and row[0].isdigit()}
    words = {line.split(":")[0].strip(): line.split(":")[1].split() for line in tables if line.startswith("  H")}
    rows = {row[0]: row[1:] for row in (line.strip("| ").split("|") for line in page.splitlines()) if len(row) == 7}
    for agents in map(str, REGISTER["agents"]):
        none, all_of = cells[agents, "0"], cells[agents, "1"]
        slope = words[f"H1 joint by share, {agents} agents"]
        told = [none[3], all_of[3], none[7], all_of[7], " ".join(slope[:3]), slope[3]]
        found = next(row for name, row in rows.items() if name.strip() == agents)
        assert [cell.strip() for cell in found] == [cell.replace("+", "").replace("0.", ".") for cell in told]
    shift, fewest = words["H2 joint by shift"], words["H4 shift less interaction, 2 agents"]
    assert " ".join(shift[:3]).replace("+", "").replace("0.", ".") in " ".join(page.split()) and shift[3] == "OPEN"
    assert fewest[3] == "REFUTED" and ".215 [.144, .285]" in page and fewest[:3] == ["-0.215", "[-0.285,", "-0.144]"]
    shifts = [float(row[5]) for row in cells.values()]
    assert sum(value < 0 for value in shifts) == 18 and len(shifts) == 20
    assert [word for name, (*_, word) in words.items() if name[:2] in ("H2", "H3")] == ["OPEN"] * 3
