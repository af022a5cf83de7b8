"""Which cells there are, what is left out and why, and how shards divide them."""

from collections import Counter
from pathlib import Path

import pytest

from codegen.errors import InputError, UnknownNameError
from maviper.experts import network
from maviper.reproduction.cells import cell
from maviper.reproduction.cells import plan as plans
from maviper.reproduction.cells.cell import CROSSPLAY, EXPERT, EXPLOITABILITY, EXTRACTION
from maviper.reproduction.cells.plan import Asked, experts_of, plan_cells, shard
from maviper.reproduction.cells.table import Store
from maviper.reproduction.run import describe_plan


def cells(**asked):
    return [task.cell for task in plan_cells(Asked(**asked).ensure_known(), "").tasks]


def test_quick_is_one_seed_of_deception_with_every_algorithm():
    found = cells(quick=True)
    assert {cell.game for cell in found} == {"physical-deception"} and {cell.seed for cell in found} == {0}
    names = {cell.algorithm for cell in found if cell.kind == EXTRACTION}
    assert names == {*plans.COMPARED, *plans.ABLATIONS} and {c.depth for c in found if c.kind == EXTRACTION} == {4}
    counts = Counter(cell.kind for cell in found if cell.kind != EXPLOITABILITY)
    assert counts == {EXPERT: 1, EXTRACTION: 6, CROSSPLAY: 1}


def test_the_default_is_the_papers_protocol():
    found = cells()
    main = [cell for cell in found if cell.kind == EXTRACTION and cell.algorithm in plans.COMPARED]
    assert {cell.splits for cell in main} == {"histogram"}
    assert len(main) == 3 * 3 * 4 * 10 and {cell.preset for cell in main} == {"paper"}
    ablations = {(c.game, c.depth) for c in found if c.algorithm in plans.ABLATIONS}
    assert ablations == {("physical-deception", 4)}
    table_1 = [cell for cell in found if cell.kind == CROSSPLAY]
    assert len(table_1) == 2 * 10 and {cell.depth for cell in table_1} == {4}


@pytest.mark.parametrize(("seeds", "experts"), [(1, [0]), (10, [0]), (11, [0, 10]), (30, [0, 10, 20])])
def test_the_expert_plays_the_episodes_of_every_seed(seeds, experts):
    found = cells(games=("cooperative-navigation",), seeds=seeds, algorithms=("imitation",), depths=(2,))
    alone = [cell for cell in found if cell.kind == EXPERT]
    assert [cell.seed for cell in alone] == experts
    played = {episode for cell in alone for episode in cell.episodes}
    assert played >= {episode for cell in found for episode in cell.episodes}


def test_seeds_begin_where_it_is_asked_and_responders_answer_the_depths_that_are_asked_for():
    asked = {"games": ("physical-deception",), "seeds": 2, "first_seed": 300}
    found = cells(**asked, exploit_depths=(2, 6))
    assert {cell.seed for cell in found if cell.kind != EXPERT} == {300, 301}
    assert {cell.depth for cell in found if cell.kind == EXPLOITABILITY} == {2, 6}
    assert {cell.depth for cell in cells(**asked) if cell.kind == EXPLOITABILITY} == {4}
    (expert,) = (cell for cell in found if cell.kind == EXPERT)
    played = {episode for cell in found if cell.kind != EXPERT for episode in cell.episodes}
    assert played == set(expert.episodes[:400])


def test_cells_of_several_profiles_need_the_extractions_of_its_own_seed():
    tasks = plan_cells(Asked(games=("physical-deception",), seeds=2), "").tasks
    known = {task.id: task.cell for task in tasks}
    for task in tasks:
        assert (task.cell.kind in (CROSSPLAY, EXPLOITABILITY)) == bool(task.of)
        for name, id_ in task.of.items():
            assert (known[id_].algorithm, known[id_].seed) == (name, task.cell.seed)


def test_missing_experts_are_told_with_the_command_that_trains_one(monkeypatch):
    kept = {name: file for name, file in network.SHIPPED.items() if name != "predator-prey@maddpg"}
    monkeypatch.setattr(network, "SHIPPED", kept)
    plan = plan_cells(Asked(experts=("maddpg",), seeds=1), "")
    assert {task.cell.game for task in plan.tasks} == {"physical-deception", "cooperative-navigation"}
    told = dict(plan.left_out)
    assert "maviper train predator-prey --algorithm maddpg" in told["maddpg for predator-prey"]
    with pytest.raises(InputError, match="no expert"):
        plan_cells(Asked(experts=("maddpg",), games=("predator-prey",)), "")


def test_an_expert_in_a_file_travels_as_bytes_and_is_the_shipped_one(tmp_path):
    file = Path(network.__file__).parent / "shipped" / "physical_deception.2.safetensors"
    mine = tmp_path / "mine.safetensors"
    mine.write_bytes(file.read_bytes())
    shipped, own = (plan_cells(Asked(quick=True, experts=(text,)), "").tasks for text in ("mappo", f"label={mine}"))
    assert [task.id for task in own] == [task.id for task in shipped]
    assert {task.cell.expert for task in own} == {"label"}
    mine.unlink()
    assert own[0].source.read()[0].hash == own[0].expert_hash


def test_experts_of_one_name_are_told_apart_and_one_without_a_card_says_so(tmp_path, monkeypatch):
    texts = ("same=physical-deception@0", "same=physical-deception@1")
    assert {cell.expert for cell in cells(quick=True, experts=texts)} == {"same", "same-2"}
    expert, world = network.load("physical-deception")

    class Bare:
        card, hash, agents = {}, "", expert.agents

    monkeypatch.setattr(plans, "find_expert", lambda text: (Bare(), world))
    assert {cell.expert for cell in cells(quick=True, experts=("my:expert",))} == {"my:expert (no card)"}


def test_a_family_is_every_shipped_expert_of_its_kind():
    plan = plan_cells(Asked(experts=("maddpg",), seeds=1), "")
    assert {(c.game, c.expert) for c in (task.cell for task in plan.tasks)} == {(g, "maddpg") for g in plans.GAMES}
    assert all("torch" in reason for _, reason in plan.left_out)  # nothing else is ever left out


def test_experts_of_a_family_may_be_named_one_by_one(tmp_path):
    shipped = Path(network.__file__).parent / "shipped"
    run = tmp_path / "run"
    run.mkdir()
    (run / "expert.safetensors").write_bytes((shipped / "cooperative_navigation.0.safetensors").read_bytes())
    texts = ("physical-deception@maddpg", "predator-prey@maddpg", f"maddpg={run}")
    tasks = plan_cells(Asked(experts=texts, seeds=1), "").tasks
    assert {(task.cell.game, task.cell.expert) for task in tasks} == {(game, "maddpg") for game in plans.GAMES}
    twice = plan_cells(Asked(experts=("maddpg", *texts[:2]), seeds=1), "").tasks
    assert {task.cell.expert for task in twice} == {"maddpg"}


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        ({"games": ("physical-decption",)}, "physical-deception"),
        ({"algorithms": ("mavper",)}, "maviper"),
        ({"presets": ("papr",)}, "paper"),
    ],
)
def test_unknown_names_are_suggested(asked, said):
    with pytest.raises(UnknownNameError, match=said):
        Asked(**asked).ensure_known()


def test_an_expert_of_another_game_is_refused():
    with pytest.raises(InputError, match="none of the paper's games"):
        plan_cells(Asked(experts=("coordination",)), "")


def test_every_cell_is_called_otherwise():
    found = cells(presets=("paper", "released"), seeds=2)
    assert len({cell.said for cell in found}) == len(found)


@pytest.mark.parametrize("of", [1, 2, 7])
def test_shards_divide_the_cells_and_wait_for_nobody(of):
    plan = plan_cells(Asked(seeds=3), "")
    parts = [shard(plan, number, of) for number in range(1, of + 1)]
    assert Counter(task.id for part in parts for task in part.tasks) == Counter(task.id for task in plan.tasks)
    for part in parts:
        assert all(id_ in part.ids for task in part.tasks for id_ in task.of.values())
        assert sum(map(cell.estimate, part.tasks)) > sum(map(cell.estimate, plan.tasks)) / of / 2


def test_cells_like_none_that_was_measured_are_counted_in_the_plan(tmp_path, monkeypatch):
    plan, store_ = plan_cells(Asked(quick=True), ""), Store(tmp_path)
    monkeypatch.setattr(cell, "load_costs", lambda: {"expert physical-deception": {"0": 1.0}})
    assert "11 cells were not measured" in "\n".join(describe_plan(plan, store_))
    like = "extraction physical-deception maviper-no-prediction paper histogram"
    monkeypatch.setattr(cell, "load_costs", lambda: {like: {"4": 1.0}})
    assert [task.cell.algorithm for task in plan.tasks if not cell.is_guessed(task.cell)] == ["maviper-no-prediction"]


def test_an_expert_of_a_world_with_options_is_one_name():
    """On the command line its comma has taken it apart; a label before it, or an expert after it, stays its own."""
    name = "predator-prey,physics=released@maddpg"
    for texts in ((f"fork={name}",), (*f"fork={name}".split(","), "maddpg")):
        found, _ = experts_of(Asked(experts=texts, games=("predator-prey",)))
        assert (found[0].label, found[0].game) == ("fork", "predator-prey,physics=released")
        assert [one.label for one in found[1:]] == ["maddpg"] * (len(texts) > 1)
    plain, _ = experts_of(Asked(experts=(name,), games=("predator-prey",)))
    assert plain[0].label == "maddpg" and plain[0].game == "predator-prey,physics=released"
