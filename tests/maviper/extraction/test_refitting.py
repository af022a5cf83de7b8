"""Extraction with counterexamples: labels that fulfil the claim, fewer violations, the same bytes again, refusals."""

import json
import shlex
from dataclasses import replace
from fractions import Fraction
from itertools import product

import numpy as np
import pytest

from codegen import policy_json
from codegen.errors import InputError
from codegen.policy_json import content_hash
from maviper import load
from maviper.cli import main
from maviper.console import Console
from maviper.episodes import measures
from maviper.extraction import extraction, refine, refitting, released
from maviper.extraction.algorithms import extract
from maviper.extraction.arena import Arena
from maviper.extraction.dataset import Dataset
from maviper.extraction.extraction import Examples, Running, lesson_of
from maviper.extraction.settings import Settings
from maviper.verification.ask import Asked
from maviper.verification.bench import state_of, states_of
from maviper.verification.files.states import FORM, blank, read_failing, states_files
from maviper.verification.run import verify_claims
from maviper.worlds import find
from tests.support.teams import team, towards
from tests.support.tiers import first_of
from verify.claims.catalogue import find_property
from verify.claims.decisions import DistinctTargets, formula
from verify.claims.formula import FALSE, TRUE, Acts, conjunction, disjunction, holds
from verify.claims.region import Region
from verify.claims.region_files import everywhere, region_toml
from verify.claims.wording import formula_document
from verify.question import Question, from_start
from verify.states.shares import failures, violating
from verify.states.state import State, inside, sample, violates
from verify.subjects import Game
from verify.verdicts.decisions import Result

SMALL = ["--max-depth", "3", "--iterations", "4", "--rollouts", "30", "--selection-episodes", "30"]
SMALL += ["--refinement-episodes", "0"]
STATES = "states-1-distinct_targets.json"
pytestmark = pytest.mark.solver


@pytest.fixture(autouse=True)
def quick(request):
    """What is compared with the whole command has its thousand held-out episodes."""
    if "after" not in request.fixturenames:
        request.getfixturevalue("few_episodes")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """An extracted team that violates `distinct_targets`, and what `maviper verify -o` wrote about it."""
    place = tmp_path_factory.mktemp("refit")
    words = ["extract", "physical-deception@clone", *SMALL, "--seed", "2", "-o", str(place / "before.json")]
    assert main.run(words) == 0
    assert main.run(["verify", str(place / "before.json"), "-o", str(place / "out")]) == 1
    return place


@pytest.fixture(scope="module")
def after(folder):
    words = ["extract", "physical-deception@clone", *SMALL, "--seed", "2", "--counterexamples", str(folder / "out")]
    assert main.run([*words, "-o", str(folder / "after.json")]) == 0
    return words


@pytest.fixture(scope="session")
def expert(clone):
    """The clone: what this module teaches, trees learn at once."""
    return clone


def task(world, expert, *paths):
    return refitting.task_of(paths, world, expert, Console(quiet=True))


# --- states as files


def test_further_states_are_written_and_each_violates_the_claim(folder, world):
    before = load(folder / "before.json")
    document = json.loads((folder / "out" / STATES).read_text())
    assert document["states"] == FORM and document["profile"] == content_hash(before)
    (found,), skipped = read_failing([folder / "out"], world)
    assert len(found.states) == len(document["positions"]) + 1 > 100 and not skipped, "the counterexample comes first"
    claim = find_property("distinct_targets", before)
    assert all(violates(from_start(before, claim), state) for state in found.states)
    assert found.region == everywhere(before) and found.claim.label == "distinct_targets"
    kept = found.before()
    assert kept and content_hash(kept) == content_hash(before) and found.claim.statement == formula(before, claim)
    (alone,), _ = read_failing([folder / "out" / "counterexample-1-distinct_targets.json"], world)
    assert alone.states == found.states[:1] and alone.region is None
    (twice,), _ = read_failing([folder / "out", folder / "out" / STATES], world)
    assert twice.states == found.states, "each state once"


def test_states_lie_in_their_region_with_errors_where_the_claim_allows_them(profile):
    same = team(profile, towards(0, 0), towards(1, 1))
    claim = find_property("steady", same, of="own_target", eps=Fraction(1, 10))
    box = {**everywhere(same).box, "agent_0.x": (Fraction(0), Fraction(1, 3))}
    region = Region(box, ("landmark_1",), name="near.toml")
    states = failures(Question(Game(same), claim, region), 40)
    assert len(states) == 40 and all(
        inside(region, state) and violates(from_start(same, claim), state) for state in states
    )
    assert any(state.errors for state in states) and all(state.goal == "landmark_1" for state in states)
    assert failures(Question(Game(same), claim, region), 40) == states


def test_states_files_keep_region_errors_and_command(profile, tmp_path, world):
    same = team(profile, towards(0, 0), towards(0, 1))
    claim = find_property("steady", same, of="own_target", eps=Fraction(1, 10))
    region = Region(
        {**everywhere(same).box, "agent_0.x": (Fraction(0), Fraction(1, 3))}, ("landmark_1",), name="n.toml"
    )
    # the verdict on the claim without errors, which is quicker, stands for the one with them
    (result,) = verify_claims([Question(Game(same), find_property("own_target", same), region)])
    assert isinstance(result, Result)
    asked = [Asked(Question(Game(same), claim, region), "maviper verify team.json --claim steady --region n.toml")]
    files = states_files(same, asked, [replace(result, question=result.question.about(claim))])
    assert list(files) == ["states-1-steady.json"]
    (tmp_path / "s.json").write_text(files["states-1-steady.json"])
    (found,), _ = read_failing([tmp_path / "s.json"], world)
    assert found.region == region and found.region.name == "n.toml" and found.claim.eps == claim.eps
    assert list(found.states) == failures(Question(Game(same), claim, region))
    assert found.command == "maviper verify profile.json --claim steady --region n.toml"
    assert found.before() is None


# --- labels


def examples_of(world, expert, statement, states, which="defenders"):
    world_state = states_of(world.spec, states)
    columns = dict(zip(world.spec.coordinates(), world.coordinates(world_state).T, strict=True))
    return lesson_of(world, expert, which, statement, columns, world.observe(world_state), world_state)


def drawn(world, n, bounds=None):
    region = everywhere(blank(world))
    region = replace(region, box={**region.box, **(bounds or {})})
    coordinates, goals = sample(region, world.spec, n, 3)
    names = world.spec.coordinates()
    return [
        State({name: row[names.index(name)] for name in region.box}, world.spec.landmarks[goal].name)
        for row, goal in zip(coordinates, goals, strict=True)
    ]


def test_states_of_points_are_those_one_by_one(world):
    states = drawn(world, 5)
    together = world.coordinates(states_of(world.spec, states))
    for row, state in zip(together, states, strict=True):
        assert (world.coordinates(state_of(blank(world), state))[0] == row).all()
        assert (state.coordinates(blank(world))[0] == row).all()


def test_labels_fulfil_one_way_of_the_claim_and_change_few_agents(world, expert):
    states, policies = drawn(world, 400), blank(world)
    stated = formula(policies, DistinctTargets("defenders"))
    found = examples_of(world, expert, stated, states)
    world_state = states_of(world.spec, states)
    observed = world.observe(world_state)
    wanted = expert.act(range(3), observed, world_state)

    def true(part, row, acted):
        at = dict(zip(world.spec.coordinates(), world.coordinates(world_state)[row], strict=True))
        exact = {name: Fraction(float(value)) for name, value in at.items()}
        return holds(part, exact, {f"agent_{k}": acted[k] for k in (0, 1)})

    often = [sum(true(part, row, wanted[row, 1:]) for row in range(len(states))) for part in stated.parts]
    usual = stated.parts[int(np.argmax(often))]
    assert len(found) == len(states) and (found.labels[:, 0] == wanted[:, 0]).all()
    changed = np.flatnonzero((found.labels != wanted).any(axis=1))
    assert len(changed), "the expert's own actions would show nothing"
    for row in sorted({*range(10), *changed}):
        label = found.labels[row]
        able = [joint for joint in product(range(5), repeat=2) if true(usual, row, joint)]
        assert tuple(label[1:]) in able, "in every state some actions fulfil the usual way"
        fewest = min(int((np.array(joint) != wanted[row, 1:]).sum()) for joint in able)
        assert (label[1:] != wanted[row, 1:]).sum() == fewest
        nearest = [joint for joint in able if (np.array(joint) != wanted[row, 1:]).sum() == fewest]

        def worth(joint, row=row):
            full = np.array([[wanted[row, 0], *joint]])
            one = [seen[row : row + 1] for seen in observed]
            asked = np.full((1, 3), extraction.AS_GIVEN)
            return np.mean([expert.q(agent, one, world_state[[row]], asked, full)[0, 0] for agent in (1, 2)])

        assert worth(tuple(label[1:])) == pytest.approx(max(map(worth, nearest)), rel=1e-5)


def test_states_in_which_nothing_fulfils_the_claim_are_left_out_and_said(world, expert, capsys, tmp_path, folder):
    states = drawn(world, 6)
    assert len(examples_of(world, expert, FALSE, states)) == 0
    assert len(examples_of(world, expert, disjunction(Acts("agent_0", 3), FALSE), states)) == 6
    document = json.loads((folder / "out" / STATES).read_text())
    document["formula"] = {"all": [document["formula"], {"sum": [["1", "agent_0.x"]], "most": "0"}]}
    (tmp_path / "half.json").write_text(json.dumps(document))
    found = refitting.task_of([tmp_path / "half.json"], world, expert, Console())
    left_out = sum(row[document["coordinates"].index("agent_0.x")] > 0 for row in document["positions"])
    assert 0 < left_out == len(document["positions"]) - len(found.examples)
    assert f"{left_out} left out" in capsys.readouterr().err
    document["formula"] = {"any": []}
    (tmp_path / "none.json").write_text(json.dumps(document))
    with pytest.raises(InputError, match="cannot be fulfilled in any of the states"):
        task(world, expert, tmp_path / "none.json")


def test_large_teams_are_labelled_by_few_changes():
    assert [len(level) for level in extraction._moves([5] * 24)] == [1, 96]
    assert sum(len(level) for level in extraction._moves([5, 5, 5])) == 125


def test_what_an_agent_measures_wrongly_is_what_it_learns_from(world, expert, profile, tmp_path):
    same = team(profile, towards(0, 0), towards(1, 1))
    claim = find_property("steady", same, of="own_target", eps=Fraction(1, 10))
    state = next(state for state in failures(Question(Game(same), claim, everywhere(same)), 40) if state.errors)
    document = {
        "states": FORM,
        "world": "physical-deception",
        "profile": "",
        "property": "steady",
        "team": "defenders",
        "formula": formula_document(formula(same, claim)),
        "eps": "1/10",
        "region": "start",
        "bounds": region_toml(everywhere(same)),
        "command": "maviper verify profile.json",
        "coordinates": list(state.position),
        "positions": [list(state.position.values())],
        "goals": [state.goal],
        "errors": [dict(state.errors)],
    }
    (tmp_path / "s.json").write_text(json.dumps(document))
    (lesson,) = task(world, expert, tmp_path / "s.json").examples.lessons
    exact = world.observe(states_of(world.spec, [state]))
    for name, error in state.errors.items():
        agent, feature = name.split(":")
        place = world.agents.index(agent)
        column = [one.name for one in world.features[place]].index(feature)
        assert lesson.observations[place][0, column] == pytest.approx(exact[place][0, column] + error, abs=1e-6)


# --- data


def test_examples_carry_their_share_of_a_teams_weight(world, expert, folder):
    learned = task(world, expert, folder / "out").examples
    n, k = 20_000, len(learned)
    observed = tuple(np.zeros((n, len(features)), dtype=np.float32) for features in world.features)
    weights = np.random.default_rng(0).random((n, 3))
    weights[:, 2] = 0  # drawn alike
    data = Dataset(observed, np.zeros((n, 3), dtype=np.int64), weights, np.ones((n, 3), dtype=bool))
    found = learned.before(world, data)
    assert len(found) == n + k and (found.weights[:k, 0] == 0).all()
    assert (found.weights[k:, :2] == weights[:, :2]).all() and (found.weights[k:, 2] == 1).all()
    for column in (1, 2):
        assert found.weights[:k, column].sum() / found.weights[:, column].sum() == pytest.approx(extraction.SHARE)
    alone = learned.before(world, replace(data, weights=weights[:, 1:2]), [1])
    assert alone.weights[:, 0] == pytest.approx(found.weights[:, 1])
    few = Examples((examples_of(world, expert, TRUE, drawn(world, 1)),))
    first = few.before(world, data).weights[0]
    assert first[1:] == pytest.approx([extraction.MAX_EACH * weights[:, 1].mean(), extraction.MAX_EACH])
    assert not learned.of_teams("adversaries").lessons and learned.of_teams("defenders") == learned
    assert Examples().before(world, data) is data


@pytest.mark.parametrize(
    "more",
    first_of(
        4,
        [
            {"algorithm": "iviper"},
            {"algorithm": "imitation"},
            {"algorithm": "maviper-no-prediction", "preset": "paper"},
            {"preset": "released"},
            {"algorithm": "viper", "agent": "agent_1"},
            {"algorithm": "iviper", "preset": "released"},
            {"algorithm": "imitation", "preset": "released"},
        ],
    ),
    ids=lambda more: "-".join(more.values()),
)
def test_every_algorithm_that_learns_from_labels_learns_from_them(world, expert, more, monkeypatch):
    monkeypatch.setattr(released, "WARM_UP", 20)
    left, right = (Fraction(-1), Fraction(-9, 10)), (Fraction(9, 10), Fraction(1))
    corner = {"agent_0.x": left, "agent_1.x": left, "landmark_0.x": right}
    standing = conjunction(Acts("agent_0", 0), Acts("agent_1", 0))  # which the expert does not do there
    learned = Examples((examples_of(world, expert, standing, drawn(world, 300, corner)),))
    settings = Settings.of(
        {"max_depth": 3, "iterations": 2, "rollouts": 10, "selection_episodes": 5, "refinement": 0, **more}
    )
    plain, taught = extract(world, expert, settings), extract(world, expert, settings, examples=learned)
    share = [
        learned.measure_claims(world, {world.agents.index(p.agent): p.grown for p in found.agents})
        for found in (plain, taught)
    ]
    assert share[0] < 0.1 and share[1] > 0.8, share
    assert taught.provenance.training["counterexamples"] == len(learned)
    assert "counterexamples" not in plain.provenance.training
    assert content_hash(extract(world, expert, settings, examples=learned)) == content_hash(taught)


@pytest.mark.usefixtures("kept_processes")
def test_agents_side_by_side_give_the_same_trees(world, expert, folder):
    learned = task(world, expert, folder / "out").examples
    few = {"max_depth": 2, "iterations": 1, "rollouts": 5, "selection_episodes": 5, "refinement": 0}
    settings = Settings.of({"algorithm": "iviper", **few})
    one, two = (extract(world, expert, settings, Running(jobs=jobs), examples=learned) for jobs in (1, 2))
    assert policy_json.dumps(one) == policy_json.dumps(two)


def test_refinement_keeps_what_was_learned(world, expert, folder, monkeypatch):
    learned = task(world, expert, folder / "out").examples
    profile = load(folder / "before.json")
    trees = [profile.policy(f"agent_{k}").grown for k in (0, 1)]

    def fulfilled(trees):
        return learned.measure_claims(world, dict(zip([1, 2], trees, strict=True)))

    monkeypatch.setattr(refine, "KEPT", 1e6)
    arena = Arena(world, expert, [1, 2], range(measures.REFINEMENT_SEEDS, measures.REFINEMENT_SEEDS + 10_000))
    monkeypatch.setattr(refine, "LAST", refine.FIRST)
    rng = np.random.default_rng(0)
    start = fulfilled(trees)
    for _ in range(4):
        now = fulfilled(trees)
        trees, _ = refine.refine_once(arena, trees, [[], []], refine.Limits(3), rng, learned)
        assert fulfilled(trees) >= now
    assert fulfilled(trees) > start + 0.3, "no state was fulfilled before, and play alone does not ask for it"


# --- the command


def test_the_claim_fails_less_often_and_the_cost_is_told(folder, after, world, capsys):
    before, found = load(folder / "before.json"), load(folder / "after.json")
    claim = find_property("distinct_targets", before)
    drawn = sample(everywhere(before), world.spec, 100_000, 41)[0]
    shares = [float(violating(from_start(profile, claim), drawn).mean()) for profile in (before, found)]
    assert shares[1] < shares[0] / 2, shares
    (cost,) = json.loads((folder / "after.refit.json").read_text())["claims"]
    assert cost["profile_before"] == content_hash(before) and cost["profile"] == content_hash(found)
    assert cost["violating"]["after"]["share"] < cost["violating"]["before"]["share"] / 2
    assert cost["fulfilled"]["share"] > 0.9 and cost["counterexamples"] == cost["fulfilled"]["samples"]
    assert 0 < cost["changed"]["region"]["share"] < 1 and cost["changed"]["met"]["samples"] == 25_000
    assert cost["trees"]["agent_0"]["after"]["depth"] <= 3
    assert [row["episodes"] for row in cost["measures"]] == [1_000] * len(cost["measures"])
    for row in cost["measures"]:
        assert abs(row["after"]["value"] - row["before"]["value"] - row["difference"]["value"]) < 3e-6
    assert main.run(shlex.split(cost["verify"])[1:]) in (0, 1)
    assert found.provenance.training["counterexamples"] == cost["counterexamples"]


def test_the_same_again_gives_the_same_bytes(folder, after):
    assert main.run([*after, "-o", str(folder / "again.json")]) == 0
    for one, two in (("after.json", "again.json"), ("after.refit.json", "again.refit.json")):
        assert (folder / one).read_text() == (folder / two).read_text().replace("again.json", "after.json")


def test_a_run_goes_on_with_the_same_counterexamples_only(folder, after, tmp_path, capsys):
    run = tmp_path / "run"
    assert main.run([*after, "-o", str(run)]) == 0
    assert (run / "profile.json").read_text() == (folder / "after.json").read_text()
    assert json.loads((run / "config.json").read_text())["counterexamples"]
    written = (run / "refit.json").read_bytes()
    for name in ("profile.json", "refit.json", "steps/0002-trees.safetensors", "steps/0003-trees.safetensors"):
        (run / name).unlink()
    assert main.run([*after, "-o", str(run), "--resume"]) == 0
    assert (run / "profile.json").read_text() == (folder / "after.json").read_text()
    assert (run / "refit.json").read_bytes() == written
    capsys.readouterr()
    single = folder / "out" / "counterexample-1-distinct_targets.json"
    assert main.run([*after[:-1], str(single), "-o", str(run), "--resume"]) == 2
    assert "counterexamples differ" in capsys.readouterr().err
    assert main.run([*after[:-2], "-o", str(run), "--resume"]) == 2
    assert "counterexamples differ" in capsys.readouterr().err


def test_without_the_policy_before_or_with_some_agents_only_the_reason_is_told(folder, tmp_path, capsys):
    (tmp_path / STATES).write_bytes((folder / "out" / STATES).read_bytes())
    tiny = ["extract", "physical-deception", "--max-depth", "2", "--iterations", "1", "--rollouts", "5"]
    tiny += ["--set", "selection_episodes=5", "--refinement-episodes", "0", "--counterexamples", str(tmp_path / STATES)]
    assert main.run([*tiny, "-o", str(tmp_path / "a.json")]) == 0
    assert refitting.NO_POLICY in capsys.readouterr().err
    (cost,) = json.loads((tmp_path / "a.refit.json").read_text())["claims"]
    assert cost["profile_before"] is None and cost["violating"]["before"] is None and "measures" not in cost
    assert cost["violating"]["after"]["samples"] == 100_000
    one = ["--algorithm", "viper", "--agent", "agent_0", "-o", str(tmp_path / "b.json")]
    assert main.run([*tiny, *one]) == 0
    assert refitting.SOME_AGENTS in capsys.readouterr().err
    (tmp_path / "profile.json").write_bytes((folder / "before.json").read_bytes())
    assert main.run([*tiny, "--features", "goal", "-o", str(tmp_path / "c.json")]) == 0
    assert refitting.OTHER_AGENTS in capsys.readouterr().err


# --- bad input


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"states": "maviper-states-9"}, "another version"),
        ({"world": "cooperative-navigation"}, "of another world"),
        ({"team": "nobody"}, "another world"),
        ({"formula": {"agent": "agent_7", "takes": 1}}, "another world: .*agent_7|agent_7"),
        ({"formula": {"sum": [["1", "agent_0.z"]], "most": "0"}}, "agent_0.z"),
        ({"formula": {"goal": 7}}, "formula"),
        ({"goals": ["landmark_7"]}, "landmark_7"),
        ({"goals": []}, "not a file of states"),
        ({"positions": []}, "not a file of states"),
        ({"positions": [[0.5]]}, "numbers in each row"),
        ({"coordinates": ["agent_0.x"]}, "numbers in each row"),
        ({"errors": [{"agent_0:smell": 0.1}]}, "smell"),
        ({"eps": "1/0"}, "not a file of states"),
        ({"bounds": "box = 1"}, "box must be a table"),
        ({"more": 1}, "not a file of states"),
        ({"formula": {"goal": "landmark_9"}}, "landmark_9"),
        ({"formula": {"agent": "agent_0", "takes": 99}}, "action 99 of agent_0"),
        ({"formula": {"sum": [["1" + "0" * 400, "agent_0.x"]], "most": "0"}}, "too large"),
        ({"positions": [[1e300] * 10]}, "is beyond"),
        ({"eps": "-1"}, "eps must be between"),
        ({"eps": "1" + "0" * 20}, "eps must be between"),
        ({"command": 'maviper verify "x'}, "No closing quotation"),
        ({"command": "rm -rf x"}, "is not `maviper verify`"),
    ],
    ids=lambda value: "-".join(value) if isinstance(value, dict) else "",
)
def test_damaged_states_are_told(folder, tmp_path, world, change, said):
    document = json.loads((folder / "out" / STATES).read_text())
    document |= {"positions": document["positions"][:1], "goals": document["goals"][:1], **change}
    (tmp_path / "damaged.json").write_text(json.dumps(document))
    with pytest.raises(InputError) as caught:
        read_failing([tmp_path / "damaged.json"], world)
    assert any(part in str(caught.value) for part in said.split("|"))


@pytest.mark.parametrize("number", ["NaN", "1e999", "-Infinity"])
@pytest.mark.parametrize("name", [STATES, "counterexample-1-distinct_targets.json"])
def test_numbers_that_are_none_are_told(folder, tmp_path, world, number, name):
    document = json.loads((folder / "out" / name).read_text())
    if name == STATES:
        document["positions"][0][0] = 12345.0
    else:
        document["position"]["agent_0.x"] = 12345.0
    (tmp_path / "strange.json").write_text(json.dumps(document).replace("12345.0", number))
    with pytest.raises(InputError, match=r"not a (counterexample|file of states)"):
        read_failing([tmp_path / "strange.json"], world)


def test_a_file_nested_too_deep_is_told(folder, tmp_path, world, capsys):
    for name in (STATES, "counterexample-1-distinct_targets.json"):
        document = json.loads((folder / "out" / name).read_text()) | {"formula": "@"}
        (tmp_path / name).write_text(json.dumps(document).replace('"@"', '{"not":' * 5_000 + "1" + "}" * 5_000))
        with pytest.raises(InputError, match="not a file of states" if name == STATES else "not a counterexample"):
            read_failing([tmp_path / name], world)
    assert main.run(["replay", str(tmp_path / name), "--profile", str(folder / "before.json")]) == 2


def test_files_that_cannot_be_learned_from_are_told(folder, tmp_path, capsys, world):
    empty, episode = tmp_path / "empty", tmp_path / "episode"
    empty.mkdir()
    episode.mkdir()
    (episode / "counterexample-1-reaches.json").write_text('{"counterexample": "maviper-episode-counterexample-1"}')
    (tmp_path / "cut.json").write_bytes((folder / "out" / STATES).read_bytes()[:300])

    def refused(expert, *words):
        capsys.readouterr()
        assert main.run(["extract", expert, *words, "-o", str(tmp_path / "p.json")]) == 2
        return capsys.readouterr().err

    deception = "physical-deception"
    assert "cannot read the file" in refused(deception, "--counterexamples", str(tmp_path / "missing.json"))
    assert "not a file of states" in refused(deception, "--counterexamples", str(tmp_path / "cut.json"))
    (tmp_path / "deep.json").write_text('{"states": "maviper-states-1", "profile": ' + "[" * 10**5)
    assert "not a file of states" in refused(deception, "--counterexamples", str(tmp_path / "deep.json"))
    assert "holds no counterexamples" in refused(deception, "--counterexamples", str(empty))
    assert "whole episodes" in refused(deception, "--counterexamples", str(episode))
    one = str(episode / "counterexample-1-reaches.json")
    assert "not a counterexample to a claim about single" in refused(deception, "--counterexamples", one)
    out = ["--counterexamples", str(folder / "out")]
    assert "another world" in refused("cooperative-navigation", *out)
    assert "another world" in refused("predator-prey", *out)
    assert "learns from rewards" in refused(deception, "--algorithm", "fitted-q", *out)
    assert not (tmp_path / "p.json").exists()
    for name in ("counterexample-1-distinct_targets.json", STATES):
        (episode / name).write_bytes((folder / "out" / name).read_bytes())
    _, skipped = read_failing([episode], world)
    assert [said.split()[0] for said in skipped] == ["counterexample-1-reaches.json"], "the others are learned from"


def test_a_world_of_a_users_has_no_states_to_learn_from(expert, tmp_path):
    with pytest.raises(InputError, match="does not declare"):
        task(object(), expert, tmp_path)
    assert task(find("physical-deception"), expert) is refitting.NOTHING
