"""What an extraction shows while it runs: the plan, and the time left of all that is still to come."""

import re
from types import SimpleNamespace

import pytest

from codegen.errors import ExitCode
from codegen.ir import NO_CHILD, NO_FEATURE, leaves
from maviper.cli import main
from maviper.episodes import play
from maviper.episodes.measures import Mean
from maviper.episodes.play import TALLY
from maviper.extraction import run
from maviper.extraction.extraction import WHOLE
from maviper.extraction.journal import EXTRACTING, MEASURING, REFINING, SELECTING, Part, Progress, Underway
from maviper.extraction.run import Stages, say_plan
from maviper.extraction.settings import Settings
from maviper.files.profiles import load
from maviper.worlds import find


class Lines:
    """A console that keeps what its live lines are told, and the lines."""

    of, quiet = "", False

    def __init__(self):
        self.told, self.said = [], []

    def line(self, label, text=""):
        self.said.append((label, text))

    def live(self, label, total, begun=0):
        return Live(self, label, total)


class Live:
    def __init__(self, console, label, total):
        self.console, self.label, self.total, self.started = console, label, total, 0.0
        self.elapsed = 5.0

    def __enter__(self):
        return self

    def __exit__(self, *caught):
        pass

    def ahead(self, done):
        return 2.0 * (self.total - done)  # seconds

    def update(self, done, text, left):
        self.console.told.append((self.label, done, self.total, text, left))


SLOW = SimpleNamespace(games=1)  # a world in which each episode takes as long


@pytest.fixture
def tally(monkeypatch):
    """Episodes of one second each."""
    fresh = play.Tally(10, 10.0)
    monkeypatch.setattr(run, "TALLY", fresh)
    return fresh


def test_a_batch_of_our_games_takes_some_time_and_each_of_its_episodes_more():
    ours, tally = SimpleNamespace(games=None), play.Tally()
    assert tally.expect(ours, 1_000) == 0
    tally.add(50, 1.5)
    assert tally.expect(ours, 1_000) == 1.5
    tally.starting = 0.5
    tally.add(150, 2.0)
    assert tally.expect(ours, 2_500, 10) == pytest.approx(4 + 25.1)
    tally.add(1, 0.0)
    assert 0 < tally.expect(ours, 1) < tally.expect(ours, 1_000)


def step(done, part=WHOLE):
    return Progress(EXTRACTING, done, 4, 0.5, 0.5, {}, None, 3, part=part)


def test_the_time_left_is_that_of_all_stages(tally):
    console = Lines()
    with Stages(console, SLOW, None, {"start": 4, SELECTING: 6, MEASURING: 8}) as stages:
        stages.show(step(4))
        stages.underway(Underway(0, 6, "episodes of the race", SELECTING))
        tally.add(6, 6.0)
        stages.underway(Underway(0, 8, "held-out episodes", MEASURING))
        tally.add(4, 4.0)
        tally.add(4, 4.0)
    assert [(label, done, total, left) for label, done, total, _, left in console.told] == [
        ("extracting", 4, 4, 14.0),
        ("selecting", 6, 6, 8.0),
        ("measuring", 4, 8, 8.0),
        ("measuring", 8, 8, 0.0),
    ]
    assert "14 episodes" in console.told[-1][3]  # beyond those before it


def test_the_time_left_counts_the_teams_that_are_refined_later(tally):
    """Three teams of four steps: two seconds a step, of which 5 are over in the first team's."""
    console = Lines()
    with Stages(console, SLOW, None, {"start": 4}) as stages:
        for place, done in ((0, 1), (0, 4), (2, 1)):
            given = 0.5, 0.5, {str(place): Mean(0.5, 0.1, 9)}, None, 3
            stages.show(Progress(REFINING, done, 4, *given, part=Part(place, 3)))
    assert [(label, done, total, left) for label, done, total, _, left in console.told] == [
        ("refining", 1, 4, 6 + 2 * (5 + 6)),
        ("refining", 4, 4, 2 * 5),
        ("refining", 1, 4, 6),
    ]


def test_agents_that_are_extracted_one_by_one_are_named_and_counted_on(tally):
    console = Lines()
    with Stages(console, SLOW, None, {"start": 4}) as stages:
        stages.show(step(4, Part(0, 2, "left")))
        stages.underway(Underway(0.5, 4, "weighing", part=Part(1, 2, "right")))
    (_, done, total, text, _), (_, later, whole, words, _) = console.told
    assert (done, total, later, whole) == (4, 8, 4.5, 8)
    assert text.startswith("left, best") and words.startswith("right, weighing")  # not the figures of the first


@pytest.mark.parametrize("algorithm", ["maviper", "iviper"])
def test_a_plan_of_our_own_games_has_the_held_out_episodes_on_top(algorithm):
    world = find("physical-deception")
    settings = Settings.of({"budget": 500, "algorithm": algorithm}).complete().deal_budget(world)
    plan, console = settings.plan(world), Lines()
    say_plan(plan, console, 500)
    counted = sum(plan.values()) - plan[MEASURING]
    assert plan[MEASURING] == 3_000 and 350 <= counted <= 500
    told = f"up to {counted + 3_000:,} episodes, {counted} of them within --max-episodes: "
    assert console.said[0][1].startswith(told)


def test_what_is_written_is_the_tree_that_is_meant(tmp_path):
    """The default preset writes no split both sides of which do the same; the paper's writes what it grows."""

    def idle_splits(preset):
        asked = ["extract", "physical-deception", "--preset", preset, "--max-episodes", "60", "--held-out", "20"]
        assert main.run([*asked, "--max-depth", "5", "-o", str(tmp_path / f"{preset}.json")]) == ExitCode.DONE
        count = 0
        for tree in (policy.tree for policy in load(tmp_path / f"{preset}.json").agents):
            for left, right in zip(tree.left, tree.right, strict=True):
                both = left != NO_CHILD and (tree.feature[[left, right]] == NO_FEATURE).all()
                count += bool(both and tree.action[left] == tree.action[right])
        return count

    assert idle_splits("default") == 0 < idle_splits("paper")


def test_leaves_without_a_decision_are_told(tmp_path, capsys):
    asked = ["extract", "physical-deception", "--max-episodes", "60", "--held-out", "1", "--max-depth", "6"]
    assert main.run([*asked, "-o", str(tmp_path / "p.json")]) == ExitCode.DONE
    found = re.findall(r"(\d+) of (\w+)'s \d+ leaves", capsys.readouterr().err)
    told = {agent: int(count) for count, agent in found}
    for policy in load(tmp_path / "p.json").agents:
        idle = int((policy.tree.visits[leaves(policy.tree)] == 0).sum())
        assert told.get(policy.agent, 0) == idle
    assert told


def test_nothing_is_played_that_is_not_announced(tmp_path, capsys):
    """Features are chosen before the plan, which has all the rest."""
    before = TALLY.episodes
    asked = ["extract", "physical-deception", "--max-episodes", "40", "--max-depth", "2", "--features", "auto"]
    assert main.run([*asked, "-o", str(tmp_path / "p.json")]) == ExitCode.DONE
    said = capsys.readouterr().err
    (tried,) = re.findall(r"tried on (\d+) episodes", said)
    (most,) = re.findall(r"up to ([\d,]+) episodes", said)
    assert TALLY.episodes - before <= int(tried) + int(most.replace(",", ""))
