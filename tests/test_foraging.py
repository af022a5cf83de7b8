"""generated/foraging/: a game of another package that demands coordination, from its adapter to a compiled header."""

import sys

import numpy as np
import pytest

from codegen import ir
from codegen.agreement.compiled import find_compiler
from maviper import load
from maviper.cli import main
from maviper.episodes import measures
from maviper.episodes.play import Policies, tree_policies
from maviper.evaluation import held_out
from maviper.worlds.checking import check, usable
from maviper.worlds.matching import plays
from tests.test_generated import FOLDER

PLACE = FOLDER.parent / "foraging"
SEEDS = range(100)
pytest.importorskip("lbforaging", reason="the extra maviper[foraging]")


@pytest.fixture(autouse=True, scope="module")
def adapter():
    """The example as its users import it."""
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(str(PLACE))
        import foraging  # pyright: ignore[reportMissingImports]

        yield foraging
        sys.modules.pop("foraging")


@pytest.fixture(scope="module")
def expert(adapter):
    found = adapter.agreed()
    yield found
    found.world.close()


def returned(world, controllers, seeds=SEEDS):
    (values,) = measures.values(world, controllers, seeds).values()
    assert set(np.unique(values)) <= {0.0, 0.5, 1.0}, "no share of two foods"
    return values


def test_the_environment_is_sound():
    found = check("foraging:make")
    assert usable(found) and [each.mark.value for each in found].count("missing") == 1, "meanings alone are missing"


def test_one_agent_alone_scores_nothing(expert):
    stays = Policies([lambda seen: np.zeros(len(seen), dtype=np.int64)] * 2)
    for lineup in ([expert, stays], [stays, expert]):
        assert not returned(expert.world, lineup).any()


def test_agreeing_on_a_food_is_what_counts(adapter, expert):
    greedy = adapter.Forager(expert.world, together=False)
    agreed, alone = returned(expert.world, [expert] * 2), returned(expert.world, [greedy] * 2)
    gain = measures.estimate(expert.world.measures[0], agreed - alone)
    assert agreed.mean() > 0.8 and gain.interval[0] > 0.2


def test_the_committed_trees_agree_too_and_beat_the_greedy_foragers(adapter, expert):
    profile = load(PLACE / "profile.json")
    assert plays(profile, expert.world) and profile.provenance.training["critic"] == "none"
    greedy = adapter.Forager(expert.world, together=False)
    trees = returned(expert.world, [tree_policies(profile.agents)] * 2)
    gain = measures.estimate(expert.world.measures[0], trees - returned(expert.world, [greedy] * 2))
    assert gain.interval[0] > 0.1


@pytest.mark.compile
def test_the_committed_header_is_the_profiles(tmp_path):
    if find_compiler() is None:
        pytest.skip("no C compiler")
    assert (
        main.run(["compile", str(PLACE / "profile.json"), "--target", "c", "--prefix", "foraging", "-o", str(tmp_path)])
        == 3
    )
    assert (tmp_path / "foraging.h").read_bytes() == (PLACE / "foraging.h").read_bytes()


@pytest.mark.slow
@pytest.mark.compile
def test_from_the_expert_to_a_header(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(held_out, "EVALUATION_EPISODES", 20)
    budget = [
        "--critic",
        "none",
        "--max-depth",
        "5",
        "--iterations",
        "2",
        "--rollouts",
        "20",
        "--selection-episodes",
        "10",
    ]
    profile = tmp_path / "profile.json"
    assert main.run(["extract", "foraging:agreed", *budget, "-o", str(profile)]) == 0
    found = load(profile)
    assert max(int(ir.depth(policy.tree).max()) for policy in found.agents) <= 5
    assert main.run(["compile", str(profile), "--target", "c", "-o", str(tmp_path / "code")]) == 3
    assert " 0 differ" in capsys.readouterr().err


def test_other_sizes_are_options(adapter):
    world = adapter.agreed(size=7, agents=3, food=3).world
    assert len(world.agents) == 3 and world.spec.options == {"size": 7, "agents": 3, "food": 3}
    (values,) = measures.values(world, [adapter.Forager(world, together=True)] * 3, range(20)).values()
    assert values.mean() > 0.1, "three have to meet at one food"
    world.close()


@pytest.mark.train
@pytest.mark.slow
def test_a_network_can_be_trained_on_it(tmp_path):
    chosen = [f"--set={each}" for each in ("batch=64", "steps_per_update=50", "checkpoint_steps=400", "games=2")]
    asked = ["--algorithm", "vdn", "--steps", "800", *chosen, "-o", str(tmp_path / "run")]
    from maviper.experts.training import train as training

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(training, "CHECKPOINT_EPISODES", 40)
        patch.setattr(training, "FINAL_EPISODES", 40)
        assert main.run(["train", "foraging:make", *asked]) == 0
    assert (tmp_path / "run" / "expert.safetensors").exists()
