"""An algorithm's name is a bundle of settings: the same bytes as before there were any, one difference a rung."""

import hashlib
import json
from dataclasses import replace
from itertools import pairwise, product

import numpy as np
import pytest

from codegen import policy_json
from maviper.cli import main
from maviper.evaluation import held_out
from maviper.experts.expert import Measured
from maviper.experts.finding import find_expert
from maviper.experts.scripted import build_script
from maviper.extraction import released
from maviper.extraction.algorithms import extract
from maviper.extraction.journal import NOTHING_KEPT, Journal
from maviper.extraction.settings import (
    AGENT,
    ALGORITHMS,
    ALL,
    EQUAL,
    EXPERTS,
    JOINT,
    MEMBER,
    PARTS,
    RACE,
    ROLLOUTS_BY,
    RUNGS,
    SELECTION_BY,
    TEAM,
    UNIFORM,
    VIPER,
    Settings,
    bundle,
    group_agents,
)
from maviper.worlds import find

SMALL = {"iterations": 3, "rollouts": 6, "selection_episodes": 12, "max_depth": 3, "refinement": 0}
TINY = {"iterations": 2, "rollouts": 3, "selection_episodes": 6}  # where two ways are compared that must be one


@pytest.fixture(autouse=True)
def quick(monkeypatch):
    monkeypatch.setattr(held_out, "EVALUATION_EPISODES", 10)
    monkeypatch.setattr(released, "WARM_UP", 8)


@pytest.fixture(scope="module")
def games():
    """Experts whose Q is counted and not a network's, so that its bits are every machine's."""
    deception = find("physical-deception")
    expert, coordination = find_expert("coordination,agents=3,kinds=2")
    return {
        "deception": (deception, Measured(deception, build_script(deception), horizon=2)),
        "coordination": (coordination, expert),
    }


def settings_of(world, **given):
    agent = {"agent": world.agents[-1]} if given.get("algorithm") == VIPER else {}
    return Settings.of({**SMALL, **agent, **given}, world)


def text_of(world, expert, **given):
    """A profile as it was before leaves were counted."""
    found = extract(world, expert, settings_of(world, **given))
    agents = tuple(replace(each, tree=replace(each.tree, visits=np.zeros(0))) for each in found.agents)
    return policy_json.dumps(replace(found, agents=agents, provenance=replace(found.provenance, tool="any")))


def test_the_names_give_the_bytes_that_they_gave_before_they_were_bundles(games, golden):
    """The golden hashes were written by the code that had a path for each name."""
    found = {}
    for (game, (world, expert)), algorithm, preset in product(games.items(), ALGORITHMS, ("paper", "default")):
        then = {"splits": "exact"} if preset == "paper" else {}
        then |= {"patience": 10} if preset == "paper" and algorithm in JOINT else {}
        text = text_of(world, expert, algorithm=algorithm, preset=preset, seed=5, **then)
        found[f"{game} {algorithm} {preset}"] = hashlib.sha256(text.encode()).hexdigest()
    golden("tests/golden", {"bundles.json": json.dumps(found, indent=2) + "\n"})


# --- the ladder


@pytest.mark.parametrize("preset", ["paper", "default"])
def test_each_rung_is_one_difference(preset):
    rungs = [Settings.of({"preset": preset, **given}) for given in RUNGS.values()]
    differing = [
        [name for name in PARTS if getattr(below, name) != getattr(above, name)] for below, above in pairwise(rungs)
    ]
    assert differing == [["rollouts_by"], ["selection_by"], ["weights"], ["least_right"], ["least_right"]]


@pytest.mark.parametrize("preset", ["paper", "default"])
def test_a_rung_is_the_same_from_either_side(preset, games):
    """What IVIPER becomes with MAVIPER's settings is what MAVIPER becomes with IVIPER's."""
    world, expert = games["deception"]

    def trees(**given):
        found = extract(world, expert, settings_of(world, preset=preset, **TINY, **given))
        return [(policy.grown.feature.tolist(), policy.grown.threshold.tolist()) for policy in found.agents]

    whole = bundle("maviper", Settings.of({"preset": preset}).selection)["selection_by"]
    below = {
        "joint-rollouts": {"algorithm": "iviper", "rollouts_by": ALL},
        "joint-selection": {"algorithm": "iviper", "rollouts_by": ALL, "selection_by": whole},
        "averaged-weights": {"algorithm": "maviper", "least_right": "0"},
        "vote-N-1": {"algorithm": "maviper-no-prediction", "least_right": "N-1"},
    }
    found = {name: trees(patience=10, **RUNGS[name]) for name in RUNGS}
    for name, given in below.items():
        assert trees(patience=10, **given) == found[name], name
    assert trees(algorithm="maviper-iviper-resampling", least_right="0") == found["joint-selection"]
    assert len({str(each) for each in found.values()}) >= 4


def test_ivipers_rollouts_have_the_others_at_their_experts(games, tmp_path):
    """By `team`, team-mates' trees play together against experts, so that each team has data of its own."""
    world, expert = games["deception"]
    counts = {}
    for by in ROLLOUTS_BY:
        place = tmp_path / by
        settings = settings_of(world, algorithm="maviper", preset="paper", rollouts_by=by, **TINY)
        extract(world, expert, settings, journal=Journal(place))
        counts[by] = len(list(place.rglob("0001-rollouts*.safetensors")))
    assert counts == {EXPERTS: 1, AGENT: 3, TEAM: 2, ALL: 1}


def test_members_with_data_of_their_own_vote_on_it(games, tmp_path):
    """As many votes as nobody needs leave the trees as they are without votes: the same draws, bins and splits."""
    world, expert = games["deception"]
    for splits, selection in (("exact", TEAM), ("histogram", AGENT)):
        given = {"rollouts_by": AGENT, "selection_by": selection, "weights": "own", "splits": splits}
        given |= {"iterations": 2, "rollouts": 3, "selection_episodes": 4}

        def trees(votes, place="", given=given):
            journal = Journal(tmp_path / place) if place else NOTHING_KEPT
            found = extract(world, expert, settings_of(world, **given, least_right=votes), journal=journal)
            return [(policy.grown.feature.tolist(), policy.grown.threshold.tolist()) for policy in found.agents]

        place, voted = f"{splits}-{selection}", trees("N")
        assert trees("0") == trees("N-9") != voted == trees("N", place)
        last = sorted((tmp_path / place).rglob("0001-*"))
        assert len(last) >= 5  # each agent's rollouts, each team's trees
        for step in last:
            step.unlink()
        assert trees("N", place) == voted


@pytest.mark.parametrize("by", SELECTION_BY)
def test_what_is_chosen_together_is_of_one_round(by, games, tmp_path):
    world, expert = games["deception"]
    selection = RACE if by == MEMBER else UNIFORM
    settings = settings_of(world, preset="paper", selection_by=by, selection=selection, iterations=5)
    found = extract(world, expert, settings, journal=Journal(tmp_path))
    told = {name: value for name, value in found.provenance.training.items() if name.startswith("best_iteration")}
    assert len(told) == {AGENT: 3, MEMBER: 3, TEAM: 2, ALL: 1}[by]
    for unit, place in zip(group_agents(world, AGENT if by == MEMBER else by, range(3)), told.values(), strict=True):
        arrays = Journal(tmp_path).arrays(f"{place - 1:04d}-trees", pytest.fail)
        for agent in unit:
            assert found.agents[agent].grown.threshold.tobytes() == arrays[f"{agent:03d}.threshold"].tobytes()


def test_equal_weights_draw_nothing(games):
    """Each state counts once, whatever the seed; and no critic is asked."""
    world, expert = games["coordination"]

    class Silent:
        def __getattr__(self, name):
            assert name != "q", "the critic is asked"
            return getattr(expert, name)

    settings = settings_of(world, preset="paper", weights="equal", iterations=1)
    extract(world, Silent(), settings)


# --- what is said


def test_a_run_folder_says_all_of_it_and_goes_on_only_with_the_same(tmp_path, capsys):
    run = tmp_path / "run"
    asked = ["extract", "coordination,agents=2", "--preset", "paper", "--max-episodes", "60", "--max-depth", "1"]
    assert main.run([*asked, "-o", str(run)]) == 0
    config = json.loads((run / "config.json").read_text())["settings"]
    assert {name: config[name] for name in PARTS} == bundle("maviper", "uniform")
    assert main.run([*asked, "-o", str(run), "--resume", "--set", "selection_by=all"]) == 0, "as it was"
    assert main.run([*asked, "-o", str(run), "--resume", "--set", "weights=own"]) == 2
    assert "weights differ" in capsys.readouterr().err


@pytest.mark.parametrize("budget", [100, 500, 29_999])
@pytest.mark.parametrize(("rollouts_by", "selection_by"), list(product(ROLLOUTS_BY, SELECTION_BY)))
def test_a_budget_is_kept_by_every_combination(budget, rollouts_by, selection_by):
    world = find("physical-deception")
    selection = RACE if selection_by == MEMBER else UNIFORM
    given = {"budget": budget, "rollouts_by": rollouts_by, "selection_by": selection_by, "selection": selection}
    found = Settings.of({**given, "least_right": "0"}).deal_budget(world)
    played = len(group_agents(world, rollouts_by, range(3))) * found.iterations * found.rollouts
    scored = {AGENT: 3, MEMBER: 2, TEAM: 2, ALL: 2}[selection_by] * found.iterations
    expert = len(group_agents(world, found.together, range(3)))
    assert 0.7 * budget <= played + (scored + expert) * found.selection_episodes <= budget


def test_without_a_q_states_of_an_own_world_count_once():
    """Draws would only lose some. A Q, a preset of others' and the games of the paper leave weights as they were."""
    own, ours = find("tests.benchmarks.doorway:make"), find("cooperative-navigation")
    assert Settings.of({}, own, weighed=False).weights == EQUAL
    assert Settings.of({}, own).weights == bundle("maviper", RACE)["weights"] != EQUAL
    assert Settings.of({}, ours, weighed=False) == Settings.of({}, ours)
    assert Settings.of({"weights": "own"}, own, weighed=False).weights == "own"
    for preset in ("paper", "released"):
        assert Settings.of({"preset": preset}, own, weighed=False) == Settings.of({"preset": preset}, own)


def test_an_own_world_has_more_rounds_of_fewer_episodes():
    """Its episodes take longer than growth does, and small trees of different rounds differ widely."""
    given = {"budget": 300, "held_out": 37}
    worlds = [find("tests.benchmarks.doorway:make"), find("cooperative-navigation")]
    own, ours = [Settings.of(given, world).deal_budget(world) for world in worlds]
    assert (own.iterations, own.rollouts) == (11, 10) and ours.iterations == 5
