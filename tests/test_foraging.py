"""generated/foraging/: a game of another package that demands coordination, from its adapter to a compiled header."""

import hashlib
import sys
from importlib.util import find_spec

import numpy as np
import pytest

from codegen import ir
from codegen.agreement.compiled import find_compiler
from maviper import load
from maviper.cli import main
from maviper.episodes import measures
from maviper.episodes.play import Policies, tree_policies
from maviper.evaluation import held_out
from maviper.experts import network
from maviper.worlds.checking import check, usable
from maviper.worlds.matching import plays
from tests.support.generated import FOLDER

PLACE = FOLDER.parent / "foraging"
SEEDS = range(100)
if find_spec("lbforaging") is None:  # which takes a second to import, and is not while tests are collected
    pytest.skip("the extra maviper[foraging]", allow_module_level=True)


@pytest.fixture(autouse=True, scope="module")
def adapter():
    """The example as its users import it."""
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(str(PLACE))
        import foraging  # pyright: ignore[reportMissingImports]

        yield foraging
        sys.modules.pop("foraging")


@pytest.fixture(scope="module")
def script(adapter):
    """Both go to one food."""
    found = adapter.agreed()
    yield found
    found.world.close()


@pytest.fixture(scope="module")
def greedy(adapter, script):
    """Each looks at itself alone."""
    return adapter.Forager(script.world, together=False)


@pytest.fixture(scope="module")
def expert(script):
    """What learned from reward."""
    return network.load(str(PLACE / "expert.safetensors"), script.world)[0]


def returned(world, controllers, seeds=SEEDS):
    (values,) = measures.values(world, controllers, seeds).values()
    assert set(np.unique(values)) <= {0.0, 0.5, 1.0}, "no share of two foods"
    return values


def least_gain(world, player, rival):
    """The low end of the interval of the difference between two teams of one player each."""
    difference = returned(world, [player] * 2) - returned(world, [rival] * 2)
    return measures.estimate(world.measures[0], difference).interval[0]


def test_the_environment_is_sound():
    found = check("foraging:make")
    assert usable(found) and [each.mark.value for each in found].count("missing") == 1, "meanings alone are missing"


def test_one_agent_alone_scores_nothing(script, expert):
    stays = Policies([lambda seen: np.zeros(len(seen), dtype=np.int64)] * 2)
    for player in (script, expert):
        for lineup in ([player, stays], [stays, player]):
            assert not returned(script.world, lineup).any()


def test_agreeing_on_a_food_is_what_counts(script, greedy):
    assert returned(script.world, [script] * 2).mean() > 0.8
    assert least_gain(script.world, script, greedy) > 0.2


def test_the_expert_learned_from_reward_alone_and_beats_both_scripts(script, greedy, expert):
    learned = expert.card["learned"]
    assert learned["reward"] > 0 and not learned["imitation"] and expert.card["reference"] == "foraging:make"
    for rival in (script, greedy):
        assert least_gain(script.world, expert, rival) > 0


def test_the_committed_trees_keep_the_success_of_their_expert(script, greedy, expert):
    profile, world = load(PLACE / "profile.json"), script.world
    assert plays(profile, world) and profile.provenance.expert == expert.hash
    trees = tree_policies(profile.agents)
    for rival, least in ((greedy, 0.4), (expert, -0.05)):
        assert least_gain(world, trees, rival) > least


@pytest.mark.compile
def test_the_header_has_the_hash_that_its_page_tells(tmp_path):
    if find_compiler() is None:
        pytest.skip("no C compiler")
    asked = ["compile", str(PLACE / "profile.json"), "--target", "c", "--prefix", "foraging", "-o", str(tmp_path)]
    assert main.run(asked) == 0
    digest = hashlib.sha256((tmp_path / "foraging.h").read_bytes()).hexdigest()
    assert digest in (PLACE / "README.md").read_text()


@pytest.mark.slow
@pytest.mark.compile
def test_from_the_expert_to_a_header(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(held_out, "EVALUATION_EPISODES", 20)
    small = {"max-depth": 5, "iterations": 2, "rollouts": 20, "selection-episodes": 10}
    budget = ["--world=foraging:make", *(f"--{name}={value}" for name, value in small.items())]
    profile = tmp_path / "profile.json"
    assert main.run(["extract", str(PLACE / "expert.safetensors"), *budget, "-o", str(profile)]) == 0
    found = load(profile)
    assert max(int(ir.depth(policy.tree).max()) for policy in found.agents) <= 5
    assert main.run(["compile", str(profile), "--target", "c", "-o", str(tmp_path / "code")]) == 0
    assert " 0 differ" in capsys.readouterr().err


def test_other_sizes_are_options(adapter):
    world = adapter.agreed(size=7, agents=3, food=3).world
    assert len(world.agents) == 3 and world.spec.options == {"size": 7, "agents": 3, "food": 3}
    (values,) = measures.values(world, [adapter.Forager(world, together=True)] * 3, range(20)).values()
    assert values.mean() > 0.1, "three have to meet at one food"
    world.close()


@pytest.mark.train
@pytest.mark.slow
@pytest.mark.parametrize(
    ("algorithm", "more"), [("mappo", ["shared=1", "gamma=0.97"]), ("vdn", ["batch=64", "steps_per_update=50"])]
)
def test_a_network_can_be_trained_on_it(tmp_path, algorithm, more):
    chosen = [f"--set={each}" for each in ("checkpoint_steps=400", "games=2", *more)]
    asked = ["--algorithm", algorithm, "--steps", "800", *chosen, "-o", str(tmp_path / "run")]
    from maviper.experts.training import train as training

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(training, "CHECKPOINT_EPISODES", 40)
        patch.setattr(training, "FINAL_EPISODES", 40)
        assert main.run(["train", "foraging:make", *asked]) == 0
    assert (tmp_path / "run" / "expert.safetensors").exists()
