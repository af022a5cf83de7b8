"""Comparisons: numbers, words, the best trees by the rule that is stated; killed and resumed; experts of one's own."""

import csv
import json
import random
import re
from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import trim_mean

import maviper
from codegen import policy_json
from codegen.errors import ExitCode, InputError, UnknownNameError
from maviper.cli import main
from maviper.reproduction import compare, grid
from maviper.reproduction.cells import table
from maviper.reproduction.cells.cell import DONE, EXPERT, FORMAT, Document, Made
from maviper.reproduction.cells.making import EPISODES_FILE, FACTS_FILE, HEAD
from maviper.reproduction.cells.table import CELL_FILE, Store
from maviper.reproduction.compared import FILES, PROFILE_FIGURE, PROFILES, THRESHOLDS
from maviper.reproduction.statistics import interquartile, performance_profile
from tests.benchmarks import doorway
from tests.maviper.reproduction.small import QUIET, contents
from tests.support.killing import killed_at, needs_fork
from tests.support.latex import typeset
from tests.support.small import small_profile

GAME, OTHER = "cooperative-navigation", "cooperative-navigation@0"
MAIN = "agents D + collisions"
ASKED = {"algorithms": ["maviper", "imitation"], "depths": [2, 3], "seeds": 6}


def cheap(distance, calls=None):
    """What stands for `make_cell`: two episodes whose distance `distance` says by the cell; the expert's is 1."""

    def made(task, profiles):
        cell, first = task.cell, task.episodes.start
        if calls is not None:
            calls.append(cell.said)
        lineup, value = ("expert", 1.0) if cell.kind == EXPERT else ("joint:agents", distance(cell))
        rows = f"{lineup},{MAIN},{first},{value - 0.1}\n{lineup},{MAIN},{first + 1},{value + 0.1}\n"
        agents = [f"agent_{k}" for k in range(3)]
        told = {"trees": {agent: {"leaves": 2**cell.depth, "depth": cell.depth} for agent in agents}}
        told |= {"fidelity": dict.fromkeys(agents, 0.5), "played": 90}
        files = {EPISODES_FILE: HEAD + rows, FACTS_FILE: json.dumps(told), "profile.json": profile(cell.seed)}
        document = Document(FORMAT, cell, task.identity, DONE, "", [MAIN], 0.25)
        return Made(task.id, document, {name: text.encode() for name, text in files.items()})

    return made


def profile(seed):
    given = small_profile()
    return policy_json.dumps(replace(given, provenance=replace(given.provenance, seed=seed)))


def near(cell):
    """Trees of depth 3 are not better than those of depth 2 by a standard error; imitation is worse."""
    return 1.25 + 0.05 * cell.seed - 0.001 * cell.depth + (0.75 if cell.algorithm == "imitation" else 0.0)


def compared(folder, expert=GAME, **options):
    return compare.compare_algorithms(expert, folder, compare.request({**ASKED, **options}), QUIET)


def only(found, algorithm, depth):
    (row,) = [each for each in found.rows if (each["algorithm"], each["depth"]) == (algorithm, depth)][:1]
    return row


@pytest.fixture
def calls(monkeypatch):
    made = []
    monkeypatch.setattr(grid, "make_cell", cheap(near, made))
    return made


def test_numbers_words_and_the_best(tmp_path, calls):
    found = compared(tmp_path)
    assert len(calls) == 6 * (1 + 4) and found.code == ExitCode.DONE
    row, worse = only(found, "maviper", 2), only(found, "imitation", 2)
    values = np.array([1.248 + 0.05 * seed for seed in range(6)])
    assert row["measure"] == MAIN and row["better"] == "lower" and (row["seeds"], row["experts"]) == (6, 1)
    assert row["value"] == pytest.approx(values.mean()) and row["low"] < row["value"] < row["high"]
    assert row["expert"] == 1.0 and row["ratio"] == pytest.approx((1 / values).mean())
    assert row["iqm"] == pytest.approx(np.sort(1 / values)[1:5].mean())
    assert (row["leaves"], row["fidelity"], row["episodes"], row["cpu_seconds"]) == (12, 0.5, 90, 0.25)
    first = found.differences[0]
    assert (first["first"], first["second"], first["depth"]) == ("maviper", "imitation", 2)
    assert first["difference"] == pytest.approx(row["ratio"] - worse["ratio"]) and first["word"] == "better"
    assert found.chosen == {"algorithm": "maviper", "depth": 2, "expert": GAME, "seed": 0}
    assert (tmp_path / "best.json").read_text() == profile(0) == policy_json.dumps(found.best)
    assert set(FILES) <= {path.name for path in tmp_path.iterdir()}


def test_a_deeper_team_is_the_best_where_it_is_better(tmp_path, monkeypatch):
    monkeypatch.setattr(grid, "make_cell", cheap(lambda cell: 2 - 0.3 * cell.depth + 0.01 * cell.seed))
    assert compared(tmp_path).chosen["depth"] == 3


def test_experts_are_the_units_where_there_are_several(tmp_path, calls):
    found = compared(tmp_path, experts=[OTHER])
    row = only(found, "maviper", 2)
    assert found.experts == (GAME, OTHER) and (row["experts"], row["seeds"]) == (2, 6)
    assert row["value"] == pytest.approx(row["high"]) == pytest.approx(row["low"])  # both experts are alike here
    assert {each["word"] for each in found.differences} == {"not decided"}  # two of them decide nothing
    assert compared(tmp_path, experts=[GAME]).experts == (GAME,)  # which is named twice
    with pytest.raises(InputError, match="different worlds"):
        compared(tmp_path / "other", experts=["physical-deception"])


def test_interquartile_means_need_as_many_seeds_as_a_verdict(tmp_path, calls):
    few, enough = compared(tmp_path, seeds=4), compared(tmp_path, seeds=5)
    assert {row["iqm"] for row in few.rows} == {row["iqm low"] for row in few.rows} == {None}
    assert "IQM" not in few.latex and "{lrlllrr}" in few.latex and "  IQM" not in "\n".join(few.lines)
    assert "no interquartile means (IQM) of ratios: they need 5 seeds of each expert" in few.lines
    assert "IQM of ratios" in enough.latex and "  IQM  " in "\n".join(enough.lines)
    assert not any(line.startswith("no interquartile") for line in enough.lines)


def test_interquartile_means_are_those_of_the_definition():
    rng = np.random.default_rng(5)
    scores = [rng.normal(size=10), rng.normal(1, size=7)]
    value, low, high = interquartile(scores)
    assert value == pytest.approx(trim_mean(np.concatenate(scores), 0.25)) and low < value < high
    assert np.isnan(interquartile([np.array([1.0])])[1]) and np.isnan(interquartile([np.array([np.inf])])[0])


RUNS = [np.random.default_rng(5).normal(mean, size=10).round(1) for mean in (0, 1)]  # of two tasks
TAUS = np.array([-9.0, RUNS[0][0], 0.5, 9.0])


def test_performance_profiles_are_those_of_the_definition():
    """Strictly above each threshold, all runs alike."""
    shares, low, high = performance_profile(RUNS, TAUS)
    assert shares.tolist() == [sum(each > tau for row in RUNS for each in row) / 20 for tau in TAUS]
    assert (low <= shares).all() and (shares <= high).all() and low[2] < shares[2] < high[2]
    assert (low[0], high[0], low[3], high[3]) == (1, 1, 0, 0)


def test_bands_of_performance_profiles_draw_runs_within_each_task():
    """Beside a bootstrap of its own."""
    luck, shares = random.Random(0), list[list[float]]()
    for _ in range(4_000):
        drawn = [luck.choice(row) for row in RUNS for _ in row]
        shares.append([sum(each > tau for each in drawn) / len(drawn) for tau in TAUS])
    for tau, low, high in zip(range(len(TAUS)), *performance_profile(RUNS, TAUS)[1:], strict=True):
        column = sorted(row[tau] for row in shares)
        assert (low, high) == pytest.approx((column[100], column[3_899]), abs=0.051)  # one run of twenty


def test_performance_profiles_are_a_table_and_a_figure(tmp_path, calls):
    found = compared(tmp_path, experts=[OTHER])
    rows = [row for row in found.profiles if (row["algorithm"], row["depth"]) == ("maviper", 2)]
    ratios = [1 / (1.248 + 0.05 * seed) for seed in range(6)] * 2
    shares = [np.mean(np.array(ratios) > row["threshold"]) for row in rows]
    assert [row["share"] for row in rows] == shares and shares[0] == 1 and shares[-1] == 0
    assert all(row["share low"] <= row["share"] <= row["share high"] for row in rows)
    table = list(csv.DictReader((tmp_path / PROFILES).read_text().splitlines()))
    assert len(table) == 4 * len(rows) == 4 * THRESHOLDS and float(table[0]["share"]) == 1
    figure = (tmp_path / PROFILE_FIGURE).read_text()
    depth = found.chosen["depth"]
    assert f"share of seeds above a ratio, depth {depth}" in figure and figure.count('opacity="0.15"') == 2
    assert "profiles" in found.document and figure in found._repr_html_()
    few = compared(tmp_path / "few", seeds=4)
    assert not few.profiles and not {PROFILES, PROFILE_FIGURE} & set(few.files)


def test_the_answer_is_shown_as_others_are(tmp_path, calls, capsys):
    found = compared(tmp_path)
    assert len(repr(found)) < 500 and repr(found).startswith("AlgorithmsCompared in cooperative-navigation: 4 settings")
    assert "<svg" in found._repr_html_() and (tmp_path / "figure.svg").read_text() in found._repr_html_()
    assert (tmp_path / "table.csv").read_text() == found.to_csv()
    latex = found.to_latex()
    assert latex.count("\\\\") == 2 + 4 and "MAVIPER & 2 & 1.373" in latex and latex.endswith("\\end{tabular}\n")
    asked = ["compare", GAME, "--algorithms", "maviper,imitation", "--depths", "2,3", "--seeds", "6", "-o"]
    assert main.run([*asked, str(tmp_path)]) == ExitCode.DONE
    told = capsys.readouterr()
    assert "30 of 30 cells finished" in told.err and "best.json: maviper, depth 2, seed 0" in told.out
    assert main.run([*asked, str(tmp_path), "--json"]) == ExitCode.DONE
    assert json.loads(capsys.readouterr().out)["rows"] == found.rows


@pytest.mark.parametrize("seeds", [4, 6])
def test_the_table_is_typeset(tmp_path, calls, seeds):
    """With interquartile means and without."""
    found = compared(tmp_path, experts=[OTHER], seeds=seeds)
    typeset(found.to_latex(), "booktabs", tmp_path)


def test_another_budget_is_another_comparison_in_the_same_folder(tmp_path, calls):
    compared(tmp_path)
    before = len(calls)
    found = compared(tmp_path, max_episodes=400, depths=[2])
    assert len(calls) == before + 6 * 2 and {row["depth"] for row in found.rows} == {2}  # the expert's are the same


def test_teams_are_judged_by_the_measure_that_is_set(tmp_path, calls):
    asked = ["compare", GAME, "--algorithms", "maviper", "--depths", "2", "--seeds", "1", "--set", "measure=D"]
    assert main.run([*asked, "-o", str(tmp_path)]) == ExitCode.DONE
    assert "\nagents D, lower is better" in (tmp_path / "summary.txt").read_text()


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"algorithms": ["mavipr"]}, "did you mean"),
        ({"algorithms": []}, "algorithms"),
        ({"depths": [0]}, "depth"),
        ({"seeds": 0}, "--seeds"),
        ({"settings": {"mesure": "D"}}, "did you mean"),
        ({"settings": {"measure": "D + collision"}}, "did you mean"),
        ({"settings": {"explore": "much"}}, "explore is a number"),
        ({"settings": {"measure": ""}}, "measure has no value"),
        ({"settings": {"patience": 5}}, "already determines"),
        ({"max_episodes": 0}, "--max-episodes must be from 1"),
        ({"backend": "ray"}, "backend"),
        ({"world": "nobody"}, "world"),
    ],
)
def test_bad_options_are_told_before_anything_is_made(tmp_path, calls, options, said):
    with pytest.raises((InputError, UnknownNameError), match=said):
        compared(tmp_path / "new", **options)
    assert not calls and not (tmp_path / "new").exists()


def test_an_algorithm_that_cannot_learn_there_is_named_by_an_option_that_there_is(tmp_path, calls):
    with pytest.raises(InputError, match=r"^--algorithms fitted-q cannot be used with continuous actions") as caught:
        compared(tmp_path, "tests.support.steering:pulling", algorithms=["maviper", "fitted-q"])
    assert not re.search(r"--algorithm\b", str(caught.value)) and not calls


def test_nothing_of_somebody_else_is_written_over(tmp_path, calls):
    (tmp_path / "best.json").write_text("{}")
    with pytest.raises(InputError, match=re.escape("another best.json, which no comparison wrote")):
        compared(tmp_path)
    assert not calls


@needs_fork
def test_a_comparison_killed_at_many_of_its_calls(tmp_path, monkeypatch):
    for module, name, value in ((grid, "make_cell", cheap(near)), (grid, "POLL", 0.02), (table, "NAMELESS", 0.05)):
        monkeypatch.setattr(module, name, value)
    compared(tmp_path / "whole", seeds=2)  # which also imports what a process imports once
    cut, total = killed_at(0, lambda: compared(tmp_path / "counted", seeds=2))
    assert not cut and total > 100
    whole, found = contents(tmp_path / "whole"), set()
    for last in range(1, total, total // 8):
        folder = tmp_path / str(last)
        cut, _ = killed_at(last, lambda folder=folder: compared(folder, seeds=2))
        assert cut
        left = {place.parent.name for place in folder.rglob(CELL_FILE)}
        found.add(len(left))
        assert all(Store(folder).is_done(cell) for cell in left)
        compared(folder, seeds=2)
        assert contents(folder) == whole
    assert len(found) > 4


# --- for real


def test_an_expert_of_ones_own_without_a_file(tmp_path, monkeypatch):
    """Functions play here; a cell is made again where a function of the same name acts in another way."""
    asked = {"world": doorway.make, "algorithms": ["imitation"], "depths": [2], "seeds": 2, "max_episodes": 60}
    monkeypatch.setattr(compare, "OUTSIDE", 5)
    table = maviper.compare(doorway.act, tmp_path, **asked)
    (row,) = table.rows
    assert row["measure"] == "team return" and row["episodes"] <= 60 and 0 < row["fidelity"] <= 1
    env = doorway.make()
    seen, _ = env.reset(seed=0)
    assert set(table.best.act(seen)) == {"left", "right"}
    cells = {path: path.stat().st_mtime_ns for path in tmp_path.rglob(CELL_FILE)}
    again = maviper.compare(doorway.act, tmp_path, **asked)
    assert again.rows == table.rows and {path: path.stat().st_mtime_ns for path in cells} == cells

    def act(agent, observations):
        return np.full(len(observations), 2)

    act.__module__ = doorway.act.__module__
    monkeypatch.setattr(doorway, "act", act)
    other = maviper.compare(act, tmp_path, **asked)
    assert other.experts == table.experts and other.rows != table.rows
    assert len(list(tmp_path.rglob(CELL_FILE))) == 2 * len(cells)


def test_experts_that_act_alike_are_not_told_apart():
    def act(agent, observations):
        return doorway.act(agent, observations)

    with pytest.raises(InputError, match=r":act acts as .*:act does in the first 4 held-out episodes"):
        maviper.compare(doorway.act, experts=[act], world=doorway.make)


def test_two_jobs_play_an_environment_of_ones_own(monkeypatch):
    """Copies in processes of their own within a process of joblib's; trees are those of one job."""
    monkeypatch.setattr(compare, "OUTSIDE", 5)
    asked = {"world": doorway.make, "algorithms": ["imitation"], "depths": [2], "seeds": 2, "max_episodes": 60}
    one, two = (maviper.compare(doorway.act, jobs=jobs, **asked) for jobs in (1, 2))
    assert not two.failed
    assert [row | {"cpu_seconds": 0} for row in one.rows] == [row | {"cpu_seconds": 0} for row in two.rows]


def test_episodes_are_those_that_were_played(tmp_path):
    """In our games held-out ones come on top; agents that VIPER extracts alone share the budget."""
    found = maviper.compare(GAME, tmp_path, algorithms=["iviper", "viper"], depths=[1], seeds=1, max_episodes=90)
    assert all(60 < row["episodes"] <= 90 for row in found.rows)
    assert {row["experts"] for row in found.rows} == {1} and not found.failed
    cell = next(path for path in tmp_path.glob("cells/*/profile.json"))
    episodes = list(csv.DictReader((cell.parent / "episodes.csv").read_text().splitlines()))
    measured = maviper.evaluate(cell, expert=GAME, episodes=200)["agents", "D + collisions"]
    mine = [float(each["value"]) for each in episodes if each["measure"] == MAIN]
    assert len(mine) == 200 and measured.value == pytest.approx(np.mean(mine))
