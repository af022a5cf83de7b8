"""Races and refinement: many trees at once, common episodes, moves, and runs that go on."""

import json

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from codegen import ir, policy_json, profiles
from codegen.errors import InputError
from codegen.lowering.deploy import deploy_tree
from codegen.profiles import check
from maviper.cli import main
from maviper.episodes import measures
from maviper.episodes.play import tree_policies
from maviper.episodes.trees import agent_policies
from maviper.evaluation import held_out
from maviper.experts.finding import find_expert
from maviper.extraction import arena, refine, released
from maviper.extraction.algorithms import extract
from maviper.extraction.arena import (
    Arena,
    Stack,
    halving,
    merge_leaves,
    reaching,
    with_leaf,
    with_new_split,
    with_split,
)
from maviper.extraction.extraction import QUIETLY, Extraction, Running
from maviper.extraction.journal import Journal
from maviper.extraction.selection import Selection
from maviper.extraction.settings import Settings
from maviper.worlds import find
from tests.support.strategies import grown_trees
from tests.support.tiers import first_of

pytestmark = pytest.mark.usefixtures("few_episodes")
TREES = st.lists(grown_trees(n_features=3, max_depth=4), min_size=1, max_size=5)


def rows_near(trees, n=200):
    """Observations at, beside and away from the thresholds."""
    rng = np.random.default_rng(len(trees))
    cuts = np.concatenate([tree.threshold for tree in trees]).astype(np.float32)
    picked = rng.choice(cuts, size=(n, 3))
    beside = np.nextafter(picked, rng.choice(np.array([-9, 9], dtype=np.float32), size=picked.shape))
    return np.where(rng.random(picked.shape) < 0.5, picked, beside).astype(np.float32)


def same(a, b):
    return all(np.array_equal(getattr(a, name), getattr(b, name)) for name in packed_names())


def packed_names():
    return ("feature", "threshold", "left", "right", "action")


@given(TREES)
def test_a_stack_decides_as_each_deployed_tree(trees):
    rows = rows_near(trees)
    which = np.arange(len(rows)) % len(trees)
    found = Stack.of(trees).act(which, rows)
    for index, tree in enumerate(trees):
        mine = which == index
        at = deploy_tree(tree)
        assert (found[mine] == at.action[ir.apply(at, rows[mine])]).all()


@given(TREES)
def test_merging_changes_no_decision_and_leaves_nothing_to_merge(trees):
    for tree in trees:
        small, rows = merge_leaves(tree), rows_near([tree])
        assert (small.action[ir.apply(small, rows)] == tree.action[ir.apply(tree, rows)]).all()
        assert len(small.feature) <= len(tree.feature) and same(small, merge_leaves(small))
        for node in np.flatnonzero(small.feature != ir.NO_FEATURE):
            a, b = small.left[node], small.right[node]
            assert small.feature[a] >= 0 or small.feature[b] >= 0 or small.action[a] != small.action[b]


@given(grown_trees(n_features=3, max_depth=3), st.data())
def test_changes_are_local(tree, data):
    rows = rows_near([tree])
    before = tree.action[ir.apply(tree, rows)]
    node = data.draw(st.sampled_from(sorted(reaching(tree, rows))))
    inside = np.isin(np.arange(len(rows)), reaching(tree, rows)[node])

    def acts(changed):
        assert check(profile_of(changed)) == ()
        return changed.action[ir.apply(changed, rows)]

    cut = acts(with_leaf(tree, node, 4))
    assert (cut[inside] == 4).all() and (cut[~inside] == before[~inside]).all()
    if tree.feature[node] == ir.NO_FEATURE:
        grown = acts(with_new_split(tree, node, 1, 0.0, (3, 4)))
        assert (grown[inside] == np.where(rows[inside, 1] <= 0, 3, 4)).all() and (grown == before)[~inside].all()
    else:
        moved = acts(with_split(tree, node, 2, 9.0e9))
        assert (moved == before)[~inside].all()


def profile_of(tree):
    features = tuple(ir.FeatureSpec(f"f{k}", "none", -1e9, 1e9, None) for k in range(3))
    actions = tuple(ir.ActionSpec(f"a{k}", None) for k in range(5))
    policy = ir.AgentPolicy("agent_0", "team", features, actions, deploy_tree(tree), tree)
    spec = find("cooperative-navigation,agents=1").spec
    return ir.PolicyProfile(spec, (policy,), ir.Provenance("x", "x", 0, "", "x"))


# --- the arena


def constant(action):
    return ir.GrownTree([ir.NO_FEATURE], [0.0], [-1], [-1], [action])


def test_scores_are_the_measures_of_the_same_episodes(world, expert):
    """Candidates together score as each alone does by `metrics`, everybody else being the expert."""
    seeds = range(500, 600)
    ring = Arena(world, expert, [1, 2], seeds)
    candidates = [[constant(a), constant(b)] for a, b in ((0, 0), (1, 4), (2, 4))]
    found = ring.scores(candidates, 60)
    again = ring.scores(candidates, 60)  # 40 fresh episodes, then from the start
    assert (again[:, 40:] == found[:, :20]).all() and ring.played == 360 and ring.used == 120
    for scored, trees in zip(found, candidates, strict=True):
        team = tree_policies([*agent_policies(world, [constant(0)], [0]), *agent_policies(world, trees, [1, 2])])
        alone = measures.values(world, [expert, team, team], seeds[:60])
        assert (alone[world.primary("defenders")] == scored).all()


def test_halving_finds_the_best_and_keeps_to_its_budget():
    rng, values = np.random.default_rng(0), np.linspace(0, 0.9, 30)
    hits, spent = 0, 0

    def scores(arms, episodes):
        nonlocal spent
        spent += len(arms) * episodes
        luck = rng.random(episodes)  # common random numbers
        return (luck < values[arms][:, None]).astype(float)

    for _ in range(20):
        order = halving(scores, [np.zeros(0)] * 30, 3_000, finalists=3)
        assert len(order) == len(set(order)) == 3
        hits += order[0] >= 28
    assert hits >= 18 and spent <= 20 * 3_000
    warm = [np.full(50, value) for value in values]
    assert halving(scores, warm, 0)[0] == 29, "without episodes the warm start decides"
    assert halving(scores, warm[:1], 100) == [0]


@pytest.mark.parametrize("episodes", [24, 240])
def test_scores_from_elsewhere_do_not_decide_a_race(episodes):
    """An arm that shone there and is poor here loses, however many those scores are."""
    here = np.array([0.2, 0.9, 0.1, 0.1, 0.1, 0.1, 0.1, 0.1])
    there = [np.full(1_000, value) for value in (1.0, 0.5, 0.4, 0.3, 0.2, 0.1, 0.0, 0.0)]

    def scores(arms, count):
        return np.repeat(here[arms][:, None], count, axis=1)

    assert halving(scores, there, episodes)[0] == 1
    assert halving(scores, there, episodes, finalists=4)[:2] == [1, 0]
    assert halving(scores, there[:2], episodes, finalists=2) == [1, 0]


def test_scores_of_the_same_play_count_as_those_of_a_race():
    """A thousand episodes before a race outweigh the few of each arm in it."""
    here, there = np.array([0.4, 0.6, 0.5, 0.5]), [np.full(1_000, value) for value in (0.9, 0.1, 0.2, 0.8)]

    def scores(arms, count):
        return np.repeat(here[arms][:, None], count, axis=1)

    assert halving(scores, there, 40) == [3]
    assert halving(scores, there, 40, alike=True) == [0]


def test_a_race_is_won_against_experts_not_in_rollouts(quick, world, expert):
    """Each team takes its own best, though rollouts say the contrary of what the teams do against experts."""
    settings = Settings.of({**SMALL, "refinement": 0})
    race = Selection(Extraction(world, expert, settings), range(3), QUIETLY)
    good = extract(world, expert, Settings.of({**SMALL, "iterations": 6, "rollouts": 40, "refinement": 0}))
    trees = [policy.grown for policy in good.agents]
    race.offer([trees[0], *[constant(0)] * 2])
    race.note_rollouts({"adversaries": np.zeros(1_000), "defenders": np.ones(1_000)}, 0.5)
    race.offer([constant(0), *trees[1:]])
    race.note_rollouts({"adversaries": np.ones(1_000), "defenders": np.zeros(1_000)}, 0.5)
    race.offer([constant(0)] * 3)
    chosen = race.choose_trees()
    assert [mine[0] is tree for mine, tree in zip(chosen, trees, strict=True)] == [True] * 3
    assert race.facts == {"stopped_after": 3, "best_iteration_adversaries": 1, "best_iteration_defenders": 2}


def test_moves_differ_in_one_tree_and_keep_the_depth(world, expert):
    rng = np.random.default_rng(0)
    trees = [with_new_split(constant(1), 0, 2, 0.0, (2, 3)), constant(4)]
    ring = Arena(world, expert, [1, 2], range(1_000))
    ring.scores([trees], 20)
    others = [[constant(0)], []]
    found = refine.proposals(ring, trees, others, refine.Limits(2), rng)
    assert any(a is others[0][0] and b is trees[1] for a, b in found), "trees of other iterates are moves too"
    assert len(found) > 12
    for a, b in found:
        assert (a is trees[0]) != (b is trees[1])
        assert max(ir.depth(a).max(), ir.depth(b).max()) <= 2


def test_a_round_costs_what_it_says_and_never_takes_what_does_not_pay(world, expert, monkeypatch):
    for name, value in (("FIRST", 8), ("LAST", 32), ("MOVES", 10)):
        monkeypatch.setattr(refine, name, value)
    ring = Arena(world, expert, [1, 2], range(10_000))
    trees = [constant(0), constant(0)]
    found, scores = refine.refine_once(ring, trees, [[], []], refine.Limits(2), np.random.default_rng(0))
    assert ring.played <= refine.round_cost() == 8 + 11 * 8 + 5 * 24 and len(scores) == 24
    worse = lambda candidates, episodes: -np.arange(len(candidates))[:, None] * np.ones(episodes)  # noqa: E731
    monkeypatch.setattr(ring, "scores", worse)
    kept, _ = refine.refine_once(ring, found, [[], []], refine.Limits(2), np.random.default_rng(1))
    assert kept is found


def test_refinement_raises_the_measure(world, expert, profile):
    """Of real trees, in a few rounds; on episodes that it has not seen."""
    settings = Settings(max_depth=3, refinement=4 * refine.round_cost())
    start = [[policy.grown] for policy in profile.agents[1:]]
    said = []
    trees, facts = refine.refine_trees(Extraction(world, expert, settings), [1, 2], start, Running(said.append))
    assert 0 < facts["refinement_episodes"] <= settings.refinement and len(said) == 4
    reached = []
    for team in ([trees[0] for trees in start], trees):
        policies = tree_policies([*agent_policies(world, [constant(0)], [0]), *agent_policies(world, team, [1, 2])])
        found = measures.evaluate(world, [expert, policies, policies], range(500))
        reached.append(found[world.primary("defenders")].value)
    assert reached[1] > reached[0] + 0.01


# --- the default preset, its runs and their journal

SMALL = {"iterations": 3, "rollouts": 8, "selection_episodes": 20, "max_depth": 3}


@pytest.fixture
def quick(monkeypatch):
    for name, value in (("FIRST", 8), ("LAST", 32), ("MOVES", 10)):
        monkeypatch.setattr(refine, name, value)


@pytest.mark.parametrize("algorithm", ["maviper", "iviper", "imitation"])
def test_any_step_may_be_the_last_before_an_interruption(quick, world, expert, algorithm, tmp_path):
    """Stopped after each step, then gone on with: the same bytes; the steps that were done are not done again."""
    settings = Settings.of({**SMALL, "algorithm": algorithm, "rollouts": 4, "refinement": refine.round_cost()})
    whole = policy_json.dumps(extract(world, expert, settings, journal=Journal(tmp_path / "whole")))
    assert policy_json.dumps(extract(world, expert, settings)) == whole
    steps = sorted(path.relative_to(tmp_path / "whole") for path in (tmp_path / "whole").rglob("*.safetensors"))
    assert len(steps) >= 9

    class Stopped(Exception):
        pass

    for stop in (0, 2, 5, len(steps) - 1):

        class Stopping(Journal):
            def arrays(self, name, compute, *arguments, stop=stop):
                done = len(list((tmp_path / f"cut {stop}").rglob("*.safetensors")))
                fresh = not (self.folder / f"{name}.safetensors").exists()
                if fresh and done >= stop:
                    raise Stopped
                return super().arrays(name, compute, *arguments)

            def part(self, name):
                return Stopping(self.folder / name)

        folder = tmp_path / f"cut {stop}"
        with pytest.raises(Stopped):
            extract(world, expert, settings, journal=Stopping(folder))
        kept = {path: path.stat().st_mtime_ns for path in folder.rglob("*.safetensors")}
        assert len(kept) == stop
        assert policy_json.dumps(extract(world, expert, settings, journal=Journal(folder))) == whole
        assert all(path.stat().st_mtime_ns == when for path, when in kept.items())
        assert sorted(path.relative_to(folder) for path in folder.rglob("*.safetensors")) == steps


@pytest.mark.usefixtures("kept_processes")
def test_jobs_change_nothing(world, expert):
    settings = Settings.of({**SMALL, "iterations": 2, "rollouts": 4, "refinement": refine.round_cost()})
    alone, beside = (extract(world, expert, settings, Running(jobs=jobs)) for jobs in (1, 2))
    assert policy_json.dumps(alone) == policy_json.dumps(beside)


def test_run_folders_are_the_runs_own(quick, tmp_path, capsys):
    asked = ["extract", "physical-deception", "--iterations", "1", "--max-depth", "1", "--refinement-episodes", "0"]
    asked += ["--rollouts", "4", "--set", "selection_episodes=4", "-o"]
    folder = tmp_path / "run"

    def refused(*arguments):
        assert main.run(list(arguments)) == 2
        return capsys.readouterr().err

    assert "no run to resume" in refused(*asked, str(folder), "--resume")
    assert main.run([*asked, str(folder)]) == 0
    profile = (folder / "profile.json").read_bytes()
    assert main.run([*asked, str(folder), "--resume"]) == 0
    assert (folder / "profile.json").read_bytes() == profile
    assert "already holds a run" in refused(*asked, str(folder))
    error = refused(*asked, str(folder), "--resume", "--seed", "1")
    assert "seed differ" in error and "--iterations 1" in error
    assert "expert differ" in refused("extract", "physical-deception@0", *asked[2:], str(folder), "--resume")
    config = json.loads((folder / "config.json").read_text())
    (folder / "config.json").write_text(json.dumps({**config, "tool": "maviper 0.0.0"}))
    assert "tool differ" in refused(*asked, str(folder), "--resume")
    (folder / "config.json").write_text(json.dumps(config))
    step = folder / "steps" / "0000-trees.safetensors"
    step.write_bytes(step.read_bytes()[:-3])
    assert "a step of the run is damaged" in refused(*asked, str(folder), "--resume")
    assert "only a run folder can be resumed" in refused(*asked, str(tmp_path / "x.json"), "--resume")


# --- budgets


@pytest.mark.parametrize("budget", [100, 500, 1_000, 29_999, 30_000, 100_000])
@pytest.mark.parametrize("algorithm", ["maviper", "iviper", "viper"])
def test_a_budget_is_kept(budget, algorithm, world):
    given_ = {"budget": budget, "algorithm": algorithm, "agent": "agent_0" if algorithm == "viper" else ""}
    found = Settings.of(given_).deal_budget(world)
    runs, sides = (3, 1) if algorithm == "iviper" else (1, 1 if algorithm == "viper" else 2)
    spent = runs * found.iterations * found.rollouts
    spent += runs * (found.iterations * sides + 1) * found.selection_episodes
    spent += found.refinement * (1 if algorithm == "viper" else 2)
    assert 0.7 * budget <= spent <= budget
    assert (found.refinement >= refine.round_cost()) == (budget >= 30_000)


def test_what_a_budget_spends_is_what_is_played(world, expert, monkeypatch):
    played = []
    play = arena.play

    def counted(world, controllers, start, *keep):
        played.append(len(start))
        return play(world, controllers, start, *keep)

    from maviper.episodes import play as module

    monkeypatch.setattr(arena, "play", counted)
    monkeypatch.setattr(module, "play", counted)
    monkeypatch.setattr(held_out, "EVALUATION_EPISODES", 1)
    extract(world, expert, Settings.of({"budget": 400, "max_depth": 2}))
    assert 300 <= sum(played) - 3 <= 400  # three episodes for the profile's own figures


def test_budgets_that_cannot_be(world, expert):
    with pytest.raises(InputError, match="4 episodes are too few"):
        extract(world, expert, Settings.of({"budget": 4}))
    with pytest.raises(InputError, match="too few for one round of refinement"):
        extract(world, expert, Settings.of({"refinement": 10}))


def test_a_users_environment_is_not_refined_unasked():
    slow = type("Slow", (), {"games": 2, "outputs": (), "continuous": False})()
    assert Settings.of({}, slow).refinement == 0 and Settings.of({"refinement": 50_000}, slow).refinement == 50_000
    assert Settings.of({}, find("physical-deception")).refinement > 0


# --- further features


@pytest.mark.parametrize("groups", ["velocity", "goal+differences"])
@pytest.mark.usefixtures("few_observations")
def test_further_features_are_played_compiled_and_verified(groups, quick, tmp_path, capsys):
    profile = tmp_path / "profile.json"
    asked = ["--iterations", "2", "--refinement-episodes", "0", "--set", "selection_episodes=10", "-o", str(profile)]
    assert main.run(["extract", "physical-deception", "--features", groups, *asked]) == 0
    found = profiles.loads(profile.read_bytes(), "profile")
    assert found.world.options == {"features": groups}
    assert main.run(["compile", str(profile), "-o", str(tmp_path / "out")]) == 0
    assert "episodes driven" in capsys.readouterr().err
    assert main.run(["evaluate", str(profile), "--episodes", "20", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)
    code = main.run(["verify", "-v", str(profile)])
    said = capsys.readouterr()
    if groups == "velocity":
        assert code in (0, 1) or "which regions cannot bound yet" in said.err
    else:
        assert code in (0, 1) and ("replayed by reference, compiled C, mpe2" in said.err) == (code == 1)


def test_the_expert_sees_what_it_knows(expert, world):
    wrapped, wide = find_expert("physical-deception", features="goal+differences")
    named, again = find_expert("physical-deception,features=goal+differences")
    state = wide.start(50, np.random.default_rng(0))
    seen, plain = wide.observe(state), world.observe(state)
    assert all((a[:, : b.shape[1]] == b).all() and a.shape[1] > b.shape[1] for a, b in zip(seen, plain, strict=True))
    wanted = expert.act([0, 1, 2], plain, state)
    assert (wrapped.act([0, 1, 2], seen, state) == wanted).all() and again.name == wide.name
    assert (named.act([0, 1, 2], seen, state) == wanted).all() and wrapped.hash == expert.hash
    is_goal = seen[1][:, [feature.name for feature in wide.features[1]].index("goal_is_landmark_0")]
    assert (is_goal == (state.goal == 0)).all()
    assert "goal_is_landmark_0" not in [feature.name for feature in wide.features[0]], "the adversary may not know"


def test_features_that_cannot_be(tmp_path, capsys):
    def refused(*arguments):
        assert main.run(["extract", *arguments, "-o", str(tmp_path / "p.json")]) == 2
        return capsys.readouterr().err

    assert "did you mean 'goal'" in refused("physical-deception", "--features", "gaol")
    assert "named twice" in refused("physical-deception", "--features", "goal+goal")
    assert "add nothing here" in refused("predator-prey", "--features", "goal")
    assert "already has additional features" in refused("physical-deception,features=goal", "--features", "signs")


def test_the_automatic_choice_keeps_what_helps(world, expert):
    """A script whose actions depend on a difference that is in a group; and the expert, whom none helps enough."""
    from maviper.extraction.run import helpful_features

    class Ahead:
        """Goes right where landmark 0 is right of landmark 1."""

        def act(self, agents, observations, state):
            del observations
            landmarks = state.position[:, -2:, 0]
            return np.repeat(1 + (landmarks[:, :1] > landmarks[:, 1:]), len(agents), axis=1)

    assert helpful_features(world, Ahead(), Settings.of({"max_depth": 1})) == "differences"
    assert helpful_features(world, expert, Settings.of({})) in ("", "differences")


# --- unusual experts


class Stubborn:
    """Always does the same, and finds every action worth the same or, with `sure`, its own worth more."""

    card, hash, agents, centralized = {}, "", ("adversary_0", "agent_0", "agent_1"), True

    def __init__(self, sure):
        self.sure = sure

    def act(self, agents, observations, state):
        return np.full((len(observations[0]), len(agents)), 3)

    def q(self, agent, observations, state, joint, given):
        return np.zeros((len(given), len(joint))) + self.sure * (joint[:, agent] == 3)


@pytest.mark.parametrize("preset", ["paper", "default", "released"])
@pytest.mark.parametrize("sure", [0, 1])
@pytest.mark.parametrize("algorithm", first_of(1, ["maviper", "iviper", "imitation"]))
def test_points_without_weight_and_actions_that_are_never_used(world, preset, sure, algorithm, quick, monkeypatch):
    """Where all weights are 0, all points count alike; an action that the expert never takes is never a leaf's."""
    monkeypatch.setattr(released, "WARM_UP", 5)
    settings = Settings.of({**SMALL, "preset": preset, "algorithm": algorithm, "refinement": 0})
    found = extract(world, Stubborn(sure), settings)
    assert all(policy.tree.action.tolist() == [3] for policy in found.agents)
    assert all(len(policy.actions) == 5 for policy in found.agents)


@pytest.mark.usefixtures("kept_processes")
def test_several_seeds_side_by_side(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(held_out, "EVALUATION_EPISODES", 1_000)  # as in the processes of --jobs
    asked = ["extract", "physical-deception", "--iterations", "1", "--max-depth", "2", "--refinement-episodes", "0"]
    asked += ["--rollouts", "20", "--set", "selection_episodes=4", "--seed", "5", "-o", str(tmp_path / "run")]
    assert main.run([*asked, "--seeds", "2", "--jobs", "2"]) == 0
    assert main.run([*asked[:-1], str(tmp_path / "beside"), "--seeds", "2", "--preset", "paper"]) == 0
    said = capsys.readouterr().err
    assert all(f"seed {seed}      extracting 1/1  best " in said for seed in (5, 6))
    found = json.loads((tmp_path / "run" / "seeds.json").read_text())
    scores = {seed: row["score"] for seed, row in found["seeds"].items()}
    assert set(scores) == {"5", "6"} and scores[str(found["best"])] == max(scores.values())
    chosen = (tmp_path / "run" / "profile.json").read_bytes()
    assert chosen == (tmp_path / "run" / f"seed-{found['best']}" / "profile.json").read_bytes()
    (tmp_path / "run" / "seed-6" / "profile.json").unlink()
    assert main.run([*asked, "--seeds", "2", "--resume"]) == 0
    assert (tmp_path / "run" / "profile.json").read_bytes() == chosen
    assert (tmp_path / "run" / "seed-6" / "profile.json").exists()
    capsys.readouterr()
    assert main.run([*asked[:-1], str(tmp_path / "x.json"), "--seeds", "2"]) == 2
    assert "several seeds need a run folder" in capsys.readouterr().err
    assert main.run([*asked, "--seeds", "0"]) == 2


def test_an_extraction_that_stops_early_says_so(tmp_path, capsys):
    small = ["--preset", "paper", "--rollouts", "1", "--set", "selection_episodes=4", "--max-depth", "1"]
    asked = ["extract", "physical-deception", *small, "-o", str(tmp_path / "p.json"), "--iterations", "9"]
    assert main.run([*asked, "--set", "patience=1"]) == 0
    rounds = json.loads((tmp_path / "p.json").read_text())["provenance"]["training"]["stopped_after"]
    said = capsys.readouterr().err
    assert rounds < 9 and f"stopped     after {rounds} of 9 rounds: no significant improvement in 1 round " in said
    assert main.run([*asked, "--set", "patience=9"]) == 0
    assert "stopped" not in capsys.readouterr().err


def test_an_extraction_says_how_its_expert_learned(tmp_path, capsys):
    small = ["--max-episodes", "20", "--max-depth", "1", "-o", str(tmp_path / "p.json")]
    assert main.run(["extract", "physical-deception", *small]) == 0
    assert "it learned by 921,600 steps of reward\n" in capsys.readouterr().err
    assert main.run(["extract", "physical-deception@clone", *small]) == 0
    assert "it learned by 102,400 steps of imitating a script, 0 of reward\n" in capsys.readouterr().err
    assert main.run(["extract", "physical-deception@scripted", *small]) == 0
    assert "learned by" not in capsys.readouterr().err
