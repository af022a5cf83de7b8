"""A reproduction killed at any instant: finished cells stay, and the same call again ends as if nothing was."""

from maviper.reproduction import grid
from maviper.reproduction.cells import table
from maviper.reproduction.cells.table import CELL_FILE, Store
from tests.maviper.reproduction.small import cheap, contents, reproduced
from tests.support.killing import killed_at, needs_fork

TINY = {"games": ("physical-deception",), "depths": (4,), "seeds": 1}
OTHERS = 12  # instants between the first and the last call


@needs_fork
def test_a_reproduction_killed_at_many_of_its_calls(tmp_path, monkeypatch):
    for module, name, value in ((grid, "make_cell", cheap()), (grid, "POLL", 0.02), (table, "NAMELESS", 0.05)):
        monkeypatch.setattr(module, name, value)
    reproduced(tmp_path / "whole", **TINY)  # which also imports what a process imports once
    cut, total = killed_at(0, lambda: reproduced(tmp_path / "counted", **TINY))
    assert not cut and total > 100
    whole, found = contents(tmp_path / "whole"), set()
    for last in range(1, total, total // OTHERS):
        folder = tmp_path / str(last)
        cut, _ = killed_at(last, lambda folder=folder: reproduced(folder, **TINY))
        assert cut
        left = {place.parent.name for place in folder.rglob(CELL_FILE)}
        found.add(len(left))
        assert all(Store(folder).is_done(cell) for cell in left)
        again = reproduced(folder, **TINY)
        assert again.made == len(again.plan.tasks) - len(left)
        assert set(contents(folder)) == set(whole)
        assert contents(folder) == whole
        assert not [place for place in folder.rglob("*") if place.name.startswith((".", "claim-"))]
    assert len(found) > OTHERS // 2
    given_back = next((tmp_path / "whole").rglob(CELL_FILE)).parent / "claim-0"
    given_back.write_text("", encoding="utf-8")  # as one killed between its cell and the end of its claim leaves it
    reproduced(tmp_path / "whole", **TINY)
    assert not given_back.exists()
