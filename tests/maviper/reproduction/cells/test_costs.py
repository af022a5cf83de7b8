"""What cells are estimated to cost: from the table, and from what is most like them where the table lacks them."""

from dataclasses import replace

import pytest

from maviper.reproduction.cells import cell as cells
from maviper.reproduction.cells.cell import EXTRACTION, Cell, Source, Task
from maviper.reproduction.cells.plan import Asked, plan_cells

TABLE = {
    "extraction physical-deception maviper paper histogram": {"2": 2.0, "4": 4.0, "6": 10.0},
    "extraction predator-prey maviper paper histogram": {"4": 20.0},
    "expert physical-deception": {"0": 0.25},
    "effort steps": {"1000": 0.5},
}


@pytest.fixture
def table(monkeypatch):
    monkeypatch.setattr(cells, "load_costs", lambda: TABLE)


def cost(game="physical-deception", algorithm="maviper", depth=4, splits="histogram", kind=EXTRACTION, effort=None):
    cell = Cell(kind, game, "mappo", "paper" * (kind == EXTRACTION), algorithm, depth, 0, splits)
    return cells.estimate(Task(cell, Source(game, world=game), "", "", effort=effort or {}))


@pytest.mark.usefixtures("table")
def test_depths_between_those_that_were_measured():
    assert [cost(depth=depth) for depth in (2, 3, 5, 6, 9)] == [2, 3, 7, 10, 10]


@pytest.mark.usefixtures("table")
def test_what_was_not_measured_counts_as_what_is_most_like_it():
    assert cost(algorithm="maviper-no-prediction") == pytest.approx(0.75 * 4)
    assert cost("predator-prey", depth=6) == 20
    assert cost(algorithm="fitted-q") == cells.UNKNOWN  # nothing here is like it


@pytest.mark.usefixtures("table")
def test_networks_that_respond_are_counted():
    assert cost(effort={"steps": 4_000, "refinement": 0}) == 4 + 2


@pytest.mark.parametrize("quick", [True, False])
def test_every_cell_of_a_tier_is_like_one_that_was_measured(quick):
    tasks = plan_cells(Asked(quick, seeds=1), "").tasks
    assert all(cells.estimate(task) != cells.UNKNOWN for task in tasks)
    responding = [task for task in tasks if task.effort]
    trained = [replace(task, effort={"steps": 0, "refinement": 0}) for task in responding]
    more = sum(map(cells.estimate, responding)) - sum(map(cells.estimate, trained))
    assert (more > 0) == (not quick)
