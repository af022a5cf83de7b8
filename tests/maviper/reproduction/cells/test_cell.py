"""What makes two cells the same, and which episodes they play."""

from dataclasses import replace

import pytest

from maviper.reproduction.cells import cell as cells
from maviper.reproduction.cells.cell import EXPERT, EXTRACTION, Cell, Source, Task, settings_of
from maviper.worlds import find

SOURCE = Source("physical-deception", world="physical-deception")
CELL = Cell(EXTRACTION, "physical-deception", "mappo", "paper", "maviper", 4, 0, "histogram", 3)
TASK = Task(CELL, SOURCE, "e" * 64, "r" * 64)


def other(**changes):
    return replace(TASK, cell=replace(CELL, **changes))


@pytest.mark.parametrize(
    "task",
    [
        other(seed=4),
        other(depth=5),
        other(algorithm="iviper"),
        other(algorithm="vote-N"),
        other(preset="default"),
        other(splits="exact"),
        replace(TASK, expert_hash="f" * 64),
        replace(TASK, register="s" * 64),
        replace(TASK, source=Source("predator-prey", world="predator-prey")),
    ],
)
def test_whatever_changes_a_result_makes_another_cell(task):
    assert task.id != TASK.id and len(task.id) == 16


def test_what_an_expert_is_called_makes_no_other_cell():
    assert other(expert="mine").id == TASK.id


def test_another_version_of_the_tool_makes_another_cell(monkeypatch):
    before = TASK.id
    monkeypatch.setattr(cells, "version", lambda: "0.0.1")
    assert replace(TASK).id != before


def test_every_seed_plays_episodes_of_its_own_that_the_expert_plays_too():
    blocks = [episode for seed in range(20) for episode in replace(CELL, seed=seed).episodes]
    experts = [Cell(EXPERT, "physical-deception", "mappo", seed=first) for first in (0, 10)]
    assert len(set(blocks)) == 20 * 200
    assert blocks == [episode for expert in experts for episode in expert.episodes]
    assert len({expert.said for expert in experts}) == 2
    assert replace(CELL, algorithm="iviper", depth=6).episodes == CELL.episodes  # paired


@pytest.mark.parametrize(
    ("game", "algorithm", "iterations", "rollouts"),
    [
        ("physical-deception", "iviper", 50, 50),
        ("cooperative-navigation", "iviper", 100, 50),
        ("predator-prey", "iviper", 100, 100),
        ("predator-prey", "maviper", 100, 50),
    ],
)
def test_cells_of_preset_paper_have_the_papers_counts(game, algorithm, iterations, rollouts):
    settings = settings_of(replace(CELL, game=game, algorithm=algorithm), find(game))
    assert (settings.iterations, settings.rollouts, settings.max_samples) == (iterations, rollouts, 300_000)
    assert (settings.selection_episodes, settings.refinement, settings.splits) == (100, 0, "histogram")


def test_a_rung_stands_for_its_settings():
    settings = settings_of(replace(CELL, algorithm="joint-rollouts"), find("physical-deception"))
    assert (settings.algorithm, settings.weights, settings.least_right) == ("maviper", "own", "0")
