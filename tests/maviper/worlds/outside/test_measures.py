"""Measures that an environment states: numbers in its infos, by how they add up in an episode."""

import json

import numpy as np
import pytest

from maviper.cli import main
from maviper.episodes import measures
from maviper.episodes.play import Policies
from maviper.worlds import find
from tests.support.environments import measured

SEEDS = range(3_000_000, 3_000_003)
PLACE = "tests.support.environments"


def to_and_fro(seen):
    """To the right from even steps on, else to the left or nowhere, by where it stands."""
    return np.where(seen[:, 1] % 2 == 0, 2, np.where(seen[:, 0] > 0.5, 0, 1))


def by_hand(seed, goal):
    """Each agent's steps, way and last place in an episode."""
    env = measured(goal=goal)
    seen, _ = env.reset(seed=seed)
    steps, ways = (dict.fromkeys(env.agents, 0) for _ in range(2))
    while env.agents:
        chosen = {agent: int(to_and_fro(seen[agent][None])[0]) for agent in env.agents}
        for agent, action in chosen.items():
            steps[agent] += 1
            ways[agent] += action != 1
        seen, *_ = env.step(chosen)
    return {agent: (ways[agent], ways[agent] / steps[agent], env.place[agent]) for agent in steps}


def test_each_is_reduced_as_stated_over_the_steps_that_tell_it():
    world = find(f"{PLACE}:measured,goal=5")
    found = measures.values(world, [Policies([to_and_fro] * 2)] * 2, SEEDS)
    for k, seed in enumerate(SEEDS):
        told = {measure.label: row[k] for measure, row in found.items()}
        for agent, (way, pace, place) in by_hand(seed, 5).items():
            team = {"left runner": "left", "runner_1": "runner"}[agent]
            assert [told[f"{team} {name}"] for name in ("way", "pace", "place")] == [way, pace, place]
    world.close()


def test_a_team_has_the_mean_of_its_agents_that_tell():
    world = find(f"{PLACE}:measured,wrap=rivals")
    joined = find(f"{PLACE}:measured_team")
    apart, together = (measures.values(each, [Policies([to_and_fro] * 2)] * 2, SEEDS) for each in (world, joined))
    for name in ("way", "pace", "place"):
        rows = [row for measure, row in apart.items() if measure.name == name]
        assert len(rows) == 2
        (team,) = (row for measure, row in together.items() if measure.name == name)
        assert (team == np.mean(rows, axis=0)).all()
    for each in (world, joined):
        each.close()


def test_evaluate_prints_them_and_says_which_way_is_better(capsys):
    asked = ["evaluate", "random", "--world", f"{PLACE}:measured", "--episodes", "3"]
    assert main.run([*asked, "--json"]) == 0
    rows = json.loads(capsys.readouterr().out)["against"]["random"]["measures"]
    lower = {row["measure"]: row["lower_is_better"] for row in rows if row["team"] == "left"}
    assert lower == {"return": False, "way": True, "pace": True, "place": False}


def test_extraction_may_be_judged_by_one(tmp_path, capsys):
    asked = ["extract", f"{PLACE}:still", "--world", f"{PLACE}:measured", "--critic", "none"]
    assert main.run([*asked, "--set", "measure=way", "--max-episodes", "20", "-o", str(tmp_path / "profile.json")]) == 0
    assert "way: left 0.000 (expert 0.000" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("name", "said"), [("mismeasured", "does not state the measure way"), ("unmeasured", "no agent is told left way")]
)
def test_what_cannot_be_a_measure_is_refused(name, said, capsys):
    assert main.run(["evaluate", "random", "--world", f"{PLACE}:{name}", "--episodes", "2"]) == 2
    assert said in capsys.readouterr().err
