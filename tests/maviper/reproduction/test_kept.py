"""Extractions that are kept for another machine: written again with the same bytes, or left to be made anew."""

import json
import lzma

import pytest

from maviper.files import runs
from maviper.reproduction.cells.cell import EXTRACTION, Cell, Source, Task
from maviper.reproduction.cells.making import make_cell
from maviper.reproduction.cells.table import Store
from tests.benchmarks import kept

GAME = "physical-deception"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder with one finished extraction."""
    place = tmp_path_factory.mktemp("made")
    cell = Cell(EXTRACTION, GAME, "mappo", "paper", "fitted-q", 2, splits="histogram", seed=300)
    source = Source(GAME, world=GAME)
    made = make_cell(Task(cell, source, source.read()[0].hash, "register"), {})
    Store(place).write(made)
    return place


def test_what_is_unpacked_is_what_was_packed(folder, tmp_path):
    assert kept.pack(folder, tmp_path / "kept.xz") == 1
    assert kept.unpack(tmp_path / "kept.xz", tmp_path / "again") == (1, [])
    files = sorted(path.relative_to(folder) for path in folder.rglob("*") if path.is_file())
    assert len(files) == 4
    assert all((folder / file).read_bytes() == (tmp_path / "again" / file).read_bytes() for file in files)
    assert kept.unpack(tmp_path / "kept.xz", tmp_path / "again") == (0, [])


def test_a_cell_that_plays_otherwise_is_left_out(folder, tmp_path):
    kept.pack(folder, tmp_path / "kept.xz")
    document = json.loads(lzma.decompress((tmp_path / "kept.xz").read_bytes()))
    (cell,) = document["cells"].values()
    cell["sha256"] = "0" * 64
    runs.write(tmp_path / "kept.xz", lzma.compress(json.dumps(document).encode()))
    written, others = kept.unpack(tmp_path / "kept.xz", tmp_path / "again")
    assert written == 0 and len(others) == 1 and not list(Store(tmp_path / "again").documents())
