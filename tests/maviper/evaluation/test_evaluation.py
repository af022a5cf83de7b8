"""Evaluation: numbers equal a slow loop written out, intervals, mixes, notes, JSON, and every error."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from codegen import ir, policy_json
from codegen.errors import ExitCode, InputError, UnknownNameError
from codegen.intervals import Share
from maviper.cli import main
from maviper.episodes import measures as metrics
from maviper.episodes.play import tree_policies
from maviper.episodes.trees import on_policy
from maviper.evaluation import crossplay
from maviper.evaluation.crossplay import Stage, Uniform, resample_means
from maviper.evaluation.run import MAX_EPISODES, Contest, document, evaluate, request
from maviper.experts import network
from maviper.experts.expert import Measured
from maviper.experts.scripted import build_script
from maviper.extraction.algorithms import extract
from maviper.extraction.settings import Settings
from maviper.worlds import Measure, find
from maviper.worlds.outside.pettingzoo import PettingZooWorld
from tests.support.environments import Line
from tests.support.teams import team_in, tree
from tests.support.verifying import run

FEW = 5
SEEDS = range(metrics.MEASUREMENT_SEEDS, metrics.MEASUREMENT_SEEDS + FEW)


@pytest.fixture(scope="module", params=["cooperative-navigation", "predator-prey,prey=1"])
def other(request):
    """A world, its scripted expert, and a profile from a tiny extraction."""
    world = find(request.param)
    script = Measured(world, build_script(world), horizon=1)
    return world, script, extract(world, script, Settings(max_depth=2, iterations=1, rollouts=1, selection_episodes=2))


def command(capsys, *arguments):
    return run(capsys, "evaluate", *arguments)


# --- numbers, against loops


def decided(policy, row):
    """An action and the comparisons that it took."""
    node = comparisons = 0
    while policy.tree.feature[node] >= 0:
        goes_left = row[policy.tree.feature[node]] <= policy.tree.threshold[node]
        node = (policy.tree.left if goes_left else policy.tree.right)[node]
        comparisons += 1
    return policy.tree.action[node], comparisons


def slow(world, who, trees, expert, seeds=SEEDS):
    """One game after the other, one agent after the other. `who`: `tree`, `expert` or a function to a controller, for
    each agent. Returns the episodes' measures and returns, the share of the expert's actions, mean comparisons.
    """
    measures, paid, alike, compared = [], [], np.zeros(len(who)), np.zeros(len(who))
    for seed in seeds:
        others = {agent: make(seed) for agent, make in enumerate(who) if callable(make)}
        state, states, total = world.start_from_seeds([seed]), [], np.zeros(len(who))
        for _ in range(world.spec.episode_steps):
            seen, actions = world.observe(state), np.zeros((1, len(who)), dtype=np.int64)
            for agent, policy in enumerate(trees):
                mine, comparisons = decided(policy, seen[agent][0])
                wanted = expert.act([agent], seen, state)[0, 0]
                alike[agent] += mine == wanted
                compared[agent] += comparisons
                if agent in others:
                    actions[0, agent] = others[agent].act([agent], seen, state)[0, 0]
                else:
                    actions[0, agent] = {"tree": mine, "expert": wanted}[who[agent]]
            state = world.step(state, actions)
            states.append(state)
            total += world.rewards(state)[0]
        measures.append(world.values(states)[:, 0])
        paid.append([np.mean(total[world.members(team)]) for team in world.teams])
    named = [*world.measures, *(Measure(team, "return") for team in world.teams)]
    steps = len(seeds) * world.spec.episode_steps
    values = dict(zip(named, np.concatenate([measures, paid], axis=1).mean(axis=0), strict=True))
    return values, alike / steps, compared / steps


def lineup(world, team, ours, others):
    """What plays for each agent: trees for `ours`, the expert for the rest of the team, `others` elsewhere."""
    home = world.teams[team]
    return ["tree" if agent in ours else "expert" if agent in home else others for agent in world.agents]


def reference_ratio(measure, ours, theirs):
    if measure.lower_is_better:
        return theirs / ours
    return 1 + (ours - theirs) / abs(theirs)


def check_against_loops(world, profile, expert, found, others):
    """Every number of an evaluation beside the slow loop's. `others`: as an entry of `slow`'s `who`."""
    trees = profile.agents
    for name, rows in found.against.items():
        for team, members in world.teams.items():

            def measured(ours, team=team, elsewhere=others[name]):
                return slow(world, lineup(world, team, ours, elsewhere), trees, expert)[0]

            joint, theirs, alone = measured(members), measured([]), {agent: measured([agent]) for agent in members}
            mine = [row for row in rows if row.measure.team == team and row.measure not in world.beside]
            assert {row.measure for row in mine} == {measure for measure in joint if measure.team == team}
            for row in mine:
                measure = row.measure
                assert row.value.value == pytest.approx(joint[measure])
                assert row.expert.value == pytest.approx(theirs[measure])
                assert set(row.agents) == set(members)
                each = [row.agents[agent] for agent in members]
                for agent in members:
                    assert row.agents[agent].value.value == pytest.approx(alone[agent][measure])
                assert row.individual.value.value == pytest.approx(np.mean([a.value.value for a in each]))
                divisors = [joint[measure], *(alone[agent][measure] for agent in members)]
                if not (all(divisors) if measure.lower_is_better else theirs[measure]):
                    assert row.joint is None or row.individual.ratio is None
                    continue
                assert row.joint.value == pytest.approx(reference_ratio(measure, joint[measure], theirs[measure]))
                ratios = [reference_ratio(measure, alone[agent][measure], theirs[measure]) for agent in members]
                assert row.individual.ratio.value == pytest.approx(np.mean(ratios))


def test_numbers_are_those_of_slow_loops(world, expert, profile):
    """Deception, against the expert and against chance, whose draws follow from the episode's seed alone."""
    ours, chance = tree_policies(profile.agents), Uniform(world)
    opponents = {"expert": [expert] * 3, "random": [chance] * 3}
    found = evaluate(Contest(world, [ours] * 3, opponents, expert, profile.agents), episodes=FEW)
    others = {"expert": "expert", "random": lambda seed: Uniform(world, [seed])}
    check_against_loops(world, profile, expert, found, others)
    _, own, comparisons = slow(world, ["tree"] * 3, profile.agents, expert)
    _, theirs, _ = slow(world, ["expert"] * 3, profile.agents, expert)
    for agent, policy in enumerate(profile.agents):
        facts = found.trees[policy.agent]
        assert facts.comparisons.value == pytest.approx(comparisons[agent])
        assert facts.fidelity_own.value == pytest.approx(own[agent])
        assert facts.fidelity_expert.value == pytest.approx(theirs[agent])
        assert facts.leaves == len(ir.leaves(policy.tree)) and facts.depth == ir.depth(policy.tree).max() <= 3


def test_the_other_games(other):
    world, script, profile = other
    everybody = range(len(world.agents))
    ours = [tree_policies(profile.agents) for _ in everybody]
    found = evaluate(
        Contest(world, ours, {"script": [script] * len(world.agents)}, script, profile.agents), episodes=FEW
    )
    check_against_loops(world, profile, script, found, {"script": "expert"})
    _, own, _ = slow(world, ["tree"] * len(world.agents), profile.agents, script)
    for agent, policy in enumerate(profile.agents):
        assert found.trees[policy.agent].fidelity_own.value == pytest.approx(own[agent])
    assert any(row.measure.lower_is_better for row in found.against["script"])


@pytest.mark.smoke
def test_a_trees_comparisons_are_the_depths_of_its_leaves(world, profile):
    """Trees of known shape: one leaf, and a chain whose long arm is never taken."""
    chain = tree((0, 1e6, 1, 2), 3, (0, 2e6, 3, 4), 1, 2)
    policies = [
        replace(profile.agents[0], tree=tree(0), grown=None),
        replace(profile.agents[1], tree=chain, grown=None),
    ]
    subject = [tree_policies((*policies, profile.agents[2]))] * 3
    found = evaluate(Contest(world, subject, {"itself": subject}, None, policies), episodes=FEW).trees
    facts = [found[policy.agent] for policy in policies]
    assert [(each.leaves, each.depth, each.comparisons.value) for each in facts] == [(1, 0, 0.0), (3, 2, 1.0)]
    assert all(each.fidelity_own is None and each.fidelity_expert is None for each in facts)


def test_batches_and_asking_for_one_team_change_nothing(world, expert, profile, monkeypatch):
    ours, others = [tree_policies(profile.agents)] * 3, {"random": [Uniform(world)] * 3}
    whole = evaluate(Contest(world, ours, others, expert, profile.agents), episodes=20)
    monkeypatch.setattr(crossplay, "MAX_GAMES", 7)
    monkeypatch.setattr(crossplay, "MAX_COUNTS", 20 * 300)
    assert evaluate(Contest(world, ours, others, expert, profile.agents), episodes=20) == whole
    one = evaluate(Contest(world, ours, others, expert, profile.agents), ["defenders"], episodes=20)
    assert one.against["random"] == tuple(row for row in whole.against["random"] if row.measure.team == "defenders")
    assert set(one.trees) == {"agent_0", "agent_1"} and one.trees["agent_0"] == whole.trees["agent_0"]


def test_a_line_up_is_played_once(world, expert, profile):
    played = []
    ours = [tree_policies(profile.agents)] * 3
    found = evaluate(
        Contest(world, ours, {"expert": [expert] * 3}, expert, profile.agents),
        episodes=2,
        on_played=lambda *n: played.append(n),
    )
    # the experts, the subject, each team of the subject, and one defender after the other
    assert played == [(2 * done, 12) for done in range(1, 7)]
    assert found.episodes == 2 and found.world == "physical-deception"


def test_the_measures_are_those_of_an_extraction(world, expert, profile):
    """1,000 held-out episodes against expert opponents are what a profile's provenance states."""
    ours = [tree_policies(profile.agents)] * 3
    found = evaluate(Contest(world, ours, {"expert": [expert] * 3}, expert))
    for row in found.against["expert"]:
        if row.measure.name != "return":
            assert row.value.value == profile.provenance.evaluation[row.measure.label]
            assert row.value.low == pytest.approx(profile.provenance.evaluation[f"{row.measure.label} low"], abs=1e-6)


# --- intervals


def test_the_bootstrap_is_the_written_out_one():
    values = np.random.default_rng(3).normal(size=(2, 9))
    found, rng = resample_means(values, draws=50, seed=4), np.random.default_rng(4)
    for draw in range(50):
        rows = rng.integers(9, size=9)
        np.testing.assert_allclose(found[:, draw], values[:, rows].mean(axis=1))


def test_intervals_contain_the_point_and_repeat(world, expert, profile):
    ours = [tree_policies(profile.agents)] * 3
    first = evaluate(Contest(world, ours, {"expert": [expert] * 3}, expert, profile.agents), episodes=200)
    assert evaluate(Contest(world, ours, {"expert": [expert] * 3}, expert, profile.agents), episodes=200) == first
    for row in first.against["expert"]:
        ratios = [row.joint, row.individual.ratio, *(alone.ratio for alone in row.agents.values())]
        values = [row.value, row.expert, row.individual.value, *(alone.value for alone in row.agents.values())]
        for found in [*ratios, *values]:
            assert found is None or found.low <= found.value <= found.high
        members = len(row.agents)
        if members == 1:
            assert (row.individual.value, row.individual.ratio) == (row.value, row.joint)
        if row.measure.share:
            assert row.individual.value.low >= 0 and row.individual.value.high <= 1


def test_pairing_makes_a_ratio_certain_where_both_do_the_same(world, expert):
    """An expert compared with a copy of itself, in the same episodes: the ratio is 1, without doubt."""
    copy = network.load("physical-deception")[0]
    found = evaluate(Contest(world, [copy] * 3, {"expert": [expert] * 3}, expert), episodes=50)
    for row in found.against["expert"]:
        if row.joint is not None:
            assert (row.joint.value, row.joint.low, row.joint.high) == (1, 1, 1)
        assert row.value == row.expert and (row.value.low < row.value.value or row.value.value == 0)


class Given:
    """A world of one team whose episodes have given values."""

    beside = return_first = ()

    def __init__(self, lower_is_better):
        self.teams, self.measures = {"a": ("x",)}, (Measure("a", "m", lower_is_better=lower_is_better),)


@pytest.mark.parametrize("lower", [False, True])
def test_ratios_where_samples_divide_by_zero(lower):
    """A divisor that is zero in many samples leaves the interval open above; always zero, there is no ratio."""
    stage = Stage(Given(lower), range(20))
    ours, theirs = (object(),), (object(),)
    rare, usual = np.tile(np.eye(20)[0], (2, 1)), np.ones((2, 20))
    measure = stage.measures[0]
    tops, bottoms = (ours, theirs) if not lower else (theirs, ours)
    stage._played = {crossplay.key(tops): (tops, usual), crossplay.key(bottoms): (bottoms, rare)}
    found = crossplay.ratio(stage, measure, [ours], theirs)
    assert found.value == pytest.approx(20) and 1 < found.low < 20 and found.high == np.inf
    stage._played[crossplay.key(bottoms)] = (bottoms, np.zeros((2, 20)))
    stage._draws = {}
    assert crossplay.ratio(stage, measure, [ours], theirs) is None


def ratio_of(ours, theirs, lower=False):
    """The ratio of two shares, given by episode."""
    stage = Stage(Given(lower), range(len(ours)))
    stage.measures = (measure := Measure("a", "m", share=True, lower_is_better=lower),)
    one, other = (object(),), (object(),)
    stage._played = {crossplay.key(one): (one, np.array([ours])), crossplay.key(other): (other, np.array([theirs]))}
    return crossplay.ratio(stage, measure, [one], other)


def test_the_interval_of_a_ratio_of_shares_leaves_0_and_1():
    """0 successes of 60 beside 21 of 60 had [0, 0]."""
    none, some, all_ = np.zeros(60), np.arange(60.0) < 21, np.ones(60)
    found = ratio_of(none, 1.0 * some)
    assert found.value == found.low == 0 and 0.1 < found.high < 0.3
    found = ratio_of(np.append(np.ones(59), 0.0), all_)
    assert found.low < 0.95 < found.value < 1 < found.high < 1.1
    found = ratio_of(1.0 * some, none + (np.arange(60) == 0), lower=True)
    assert found.low < 1 / 21 < found.high


@pytest.mark.parametrize(("p", "q"), [(0.02, 0.35), (0.98, 0.97), (0.01, 0.05)])
def test_the_interval_of_a_ratio_of_rare_shares_covers_it(p, q):
    """Of 60 episodes, counted where the divisor is not 0."""
    rng, covered = np.random.default_rng(3), []
    for hits, others in zip(rng.binomial(60, p, 2_000), rng.binomial(60, q, 2_000), strict=True):
        if others:
            low, high = crossplay._ratio_of_shares(Share(int(hits), 60), Share(int(others), 60))
            covered.append(low <= p / q <= high)
    assert np.mean(covered) > 0.93


def test_one_episode_says_nothing_of_intervals(world, expert, profile):
    ours = [tree_policies(profile.agents)] * 3
    found = evaluate(Contest(world, ours, {"expert": [expert] * 3}, expert, profile.agents), episodes=1)
    returns = [row for row in found.against["expert"] if row.measure.name == "return"]
    assert all(row.joint.high == np.inf and row.value.low == -np.inf for row in returns)


def test_chance_is_uniform_and_keeps_to_its_seeds(world):
    seeds = range(400)
    observations = world.observe(world.start_from_seeds(seeds))
    some, all_of_them = Uniform(world, seeds), Uniform(world, seeds)
    counts = np.zeros(5)
    for _ in range(world.spec.episode_steps):
        two, three = some.act([2, 0], observations, None), all_of_them.act([0, 1, 2], observations, None)
        assert (two == three[:, [2, 0]]).all()
        counts += np.bincount(three.ravel(), minlength=5)
    assert counts / counts.sum() == pytest.approx(np.full(5, 0.2), abs=0.01)


# --- names, mixes, notes


def asked(text, **options):
    return request(str(text), **options, episodes=FEW)


def test_the_experts_of_profiles_are_recognised(profile_file, profile, world):
    found = asked(profile_file)
    assert found.expert.id == profile.provenance.expert and found.notes == ()
    assert list(found.against) == ["physical-deception"] and found.world.name == world.name
    named = asked(profile_file, expert="physical-deception@0", against=("physical-deception",))
    assert named.expert.id != profile.provenance.expert and "another expert" in named.notes[0]


def test_without_a_known_expert_ratios_are_left_out(profile, tmp_path, capsys):
    stranger = replace(profile, provenance=replace(profile.provenance, expert="ab" * 32))
    (tmp_path / "p.json").write_text(policy_json.dumps(stranger))
    code, out, _ = command(capsys, tmp_path / "p.json", "--episodes", FEW)
    assert code == ExitCode.DONE and "not a shipped one; --expert names it" in out and "against itself" in out
    assert "ratio " not in out and "fidelity in" not in out
    code, out, _ = command(capsys, tmp_path / "p.json", "--episodes", FEW, "--expert", "physical-deception", "--json")
    assert json.loads(out)["against"]["physical-deception"]["measures"][0]["expert"] is not None
    assert "another expert" in json.loads(out)["notes"][0]


def test_a_mix(profile_file, profile, world, expert):
    """The expert's adversary, one defender by its tree, one by chance."""
    found = asked("physical-deception", replaced=(f"defenders={profile_file}", "agent_1=random"))
    assert [player.kind for player in found.players] == ["expert", "profile", "random"]
    assert found.expert is found.subject  # what the profile was extracted from
    subject = [player.controller for player in found.players]
    rows = evaluate(
        Contest(world, subject, {"e": [expert] * 3}, found.expert.controller, profile.agents[1:2]), episodes=FEW
    )
    joint = slow(world, ["expert", "tree", lambda seed: Uniform(world, [seed])], profile.agents, expert)[0]
    alone = slow(world, ["expert", "tree", "expert"], profile.agents, expert)[0]
    for row in rows.against["e"]:
        if row.measure.team == "defenders":
            assert row.value.value == pytest.approx(joint[row.measure])
            assert row.agents["agent_0"].value.value == pytest.approx(alone[row.measure])
    assert list(rows.trees) == ["agent_0"]


def test_a_mix_without_an_expert_plays_against_itself(capsys):
    arguments = ["physical-deception", "--with", "adversary_0=scripted", "--episodes", FEW, "--json"]
    code, out, _ = command(capsys, *arguments)
    found = json.loads(out)
    assert code == 0 and list(found["against"]) == ["physical-deception"]
    assert found["against"]["physical-deception"]["opponents"] is None and found["expert"] is None
    assert found["with"] == {"adversary_0": {"name": "scripted", "kind": "scripted", "id": ""}}


def test_a_users_environment(profile, tmp_path):
    world = PettingZooWorld(Line, "tests.support.environments:Line,length=6", games=1)
    made = team_in(world, [tree((0, 0.0, 1, 2), 2, 0)] * len(world.agents))
    (tmp_path / "p.json").write_text(policy_json.dumps(replace(made, provenance=profile.provenance)))
    with pytest.raises(InputError) as error:
        asked(tmp_path / "p.json")
    assert error.value.next_step == "add --world tests.support.environments:Line"
    from maviper.evaluation.players import find_player

    player, _ = find_player(str(tmp_path / "p.json"), "SUBJECT", world)
    others = {"random": [Uniform(world)] * 2}
    found = evaluate(Contest(world, [player.controller] * 2, others, player.controller, player.trees), episodes=3)
    assert [row.measure.label for row in found.against["random"]] == [f"{team} return" for team in world.teams]
    assert all(row.joint.value == 1 for row in found.against["random"])
    assert found.trees[world.agents[0]].fidelity_own.value == 1


# --- what is printed


def test_json_says_everything_and_nothing_else_is_printed(profile_file, capsys):
    arguments = [profile_file, "--episodes", 30, "--against", "random", "--against", profile_file, "--json"]
    code, out, err = command(capsys, *arguments)
    found = json.loads(out)
    assert code == 0 and "evaluating" in err and str(profile_file.parent) not in out
    assert command(capsys, *arguments)[1] == out
    assert list(found["against"]) == ["random", "profile.json"] and list(found["trees"]) == [
        "adversary_0",
        "agent_0",
        "agent_1",
    ]
    assert (found["episodes"], found["first_episode_seed"]) == (30, metrics.MEASUREMENT_SEEDS)
    places = asked(profile_file, against=("random", str(profile_file)))
    everybody = [player.controller for player in places.players]
    others = {name: [player.controller] * 3 for name, player in places.against.items()}
    again = evaluate(
        Contest(places.world, everybody, others, places.expert.controller, places.subject.trees), episodes=30
    )
    assert json.loads(json.dumps(document(places, again))) == found
    for row in found["against"]["random"]["measures"]:
        assert list(row["subject"]) == ["value", "low", "high"] and row["individual"]["subject"] and row["agents"]


def test_tables_have_the_absolute_values_beside_every_ratio(profile_file, capsys):
    code, out, _ = command(capsys, profile_file, "--episodes", 30)
    assert code == 0
    text = out.splitlines()
    head = next(line for line in text if line.startswith("team"))
    places = [head.index(word) for word in ("measure", "kind", "subject", "expert", "ratio")]
    body = text[text.index(head) + 1 : text.index("", text.index(head))]
    body = [line for line in body if not line.startswith("the expert is below 0")]
    assert len(body) == 9  # two teams, two radii and the return; defenders joint and individual
    for line in body:
        cells = [line[low:high].strip() for low, high in zip(places, [*places[1:], None], strict=True)]
        assert all(cells) and all("[" in cell for cell in cells[2:4])
    assert any(line.startswith("tree") for line in text) and all(name in out for name in ("adversary_0", "agent_1"))


def test_lower_is_better_is_said(capsys):
    code, out, _ = command(capsys, "predator-prey,prey=1", "--expert", "scripted", "--episodes", 20)
    assert code == 0 and "lower is better" in out and "in touches" in out


def test_one_team_has_no_opponents(capsys):
    code, out, _ = command(capsys, "cooperative-navigation,agents=2", "--expert", "scripted", "--episodes", 2)
    assert code == 0 and "against" not in out and "D + collisions" in out
    assert "the ratio 1 + (subject - expert) / |expert|, in return" in out  # negative here


# --- errors


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["{profile}", "--with", "defender=random"], "did you mean 'defenders'?"),
        (["{profile}", "--with", "agent_0"], "write --with AGENT=SUBJECT"),
        (["{profile}", "--with", "agent_0="], "write --with AGENT=SUBJECT"),
        (["{profile}", "--team", "defender"], "did you mean 'defenders'?"),
        (["{profile}", "--against", "predator-prey"], "predator-prey, not physical-deception"),
        (["{profile}", "--against", "rando"], "unknown player"),
        (["{profile}", "--expert", "physical-deception,velocity=1"], "velocity=1, not physical-deception"),
        (["{profile}", "--expert", "random"], "random is not an expert"),
        (["predator-prey", "--against", "{profile}"], "physical-deception, not predator-prey"),
        (["cooperative-navigation", "--against", "random"], "there are no opponents in this world"),
        (["{profile}", "--episodes", "100001"], "from 1 to 100000, not 100001"),
        (["{profile}", "--episodes", "many"], "not a valid integer"),
        (["{folder}/expert.json"], "an expert's file, not a policy profile"),
        (["{folder}/profile"], "a JSON file, not an expert's file"),
        (["{folder}/missing.json"], "cannot read the file"),
        (["{folder}/foreign.json"], "the profile's world cannot be played"),
        (["physical-deception", "--with", "agent_0={folder}/foreign.json"], "in another version"),
        (["random"], "does not say which world"),
        (["scripted", "--world", "physical-decption"], "did you mean 'physical-deception'?"),
        (["physical-deception", "--world", "predator-prey"], "physical-deception, not predator-prey"),
        ([""], "error:"),
    ],
)
def test_bad_input_is_answered_in_three_lines(capsys, profile, profile_file, arguments, message):
    folder = profile_file.parent
    (folder / "profile").write_bytes(profile_file.read_bytes())
    shipped = Path(network.__file__).parent / "shipped" / network.SHIPPED["physical-deception"]
    (folder / "expert.json").write_bytes(shipped.read_bytes())
    foreign = replace(profile, world=replace(profile.world, dt=0.2))
    (folder / "foreign.json").write_text(policy_json.dumps(foreign))
    code, out, err = command(capsys, *(word.format(profile=profile_file, folder=folder) for word in arguments))
    assert code == ExitCode.INPUT and message in err and "Traceback" not in err and out == ""
    assert len([line for line in err.splitlines() if not line.startswith("evaluating")]) <= 3


def test_the_function_checks_what_it_is_given(world, expert):
    with pytest.raises(UnknownNameError):
        evaluate(Contest(world, [expert] * 3, {"e": [expert] * 3}), teams=["attackers"])
    with pytest.raises(InputError):
        evaluate(Contest(world, [expert] * 3, {"e": [expert] * 3}), episodes=MAX_EPISODES + 1)
    assert metrics.MEASUREMENT_SEEDS + MAX_EPISODES <= metrics.ON_POLICY_SEEDS


# --- fidelity: how far trees act as their expert


def test_fidelity_counts_what_is_equal(world, expert, profile):

    from maviper.evaluation.comparison import fidelity

    episodes = on_policy(profile, world)
    found = fidelity(profile, world, episodes)
    assert [item.agent for item in found] == list(world.agents)
    for agent, (item, policy) in enumerate(zip(found, profile.agents, strict=True)):
        seen = episodes.observations[agent].reshape(-1, len(policy.features))
        state = [world.observe(each) for each in episodes.states[:-1]]
        wanted = np.concatenate([expert.act([agent], each, None)[:, 0] for each in state])
        equal = ir.act(policy, seen) == wanted
        assert (item.whole.agreeing, item.whole.states) == (equal.sum(), len(equal))
        assert item.whole.share == equal.mean() and 0.3 < item.whole.share < 1
        for table in (item.by_action, item.by_leaf):
            assert sum(each.states for each in table.values()) == len(equal)
            assert sum(each.agreeing for each in table.values()) == equal.sum()
        assert item.by_action["left"].states == (wanted == 1).sum()
        assert set(item.by_leaf) == {int(leaf) for leaf in ir.leaves(policy.tree)}
    unknown = replace(profile, provenance=replace(profile.provenance, expert="0" * 64))
    assert fidelity(unknown, world, episodes) == ()


def test_prey_are_told_by_return_first_with_what_leaving_costs(capsys):
    """Touches inside are a mean over some episodes; where there is none, that is said."""
    given = ["evaluate", "predator-prey@scripted", "--expert", "predator-prey@maddpg", "--team", "prey"]
    assert main.run([*given, "--episodes", "60"]) == 0
    rows = [line.split("  ")[1].strip() for line in capsys.readouterr().out.splitlines() if line.startswith("prey ")]
    assert list(dict.fromkeys(rows)) == ["return", "touches", "fine", "inside", "touches inside"]
    assert main.run([*given, "--episodes", "60", "--json"]) == 0
    (against,) = json.loads(capsys.readouterr().out)["against"].values()
    found = {row["measure"]: row for row in against["measures"]}
    assert found["touches inside"]["individual"] is None and found["touches inside"]["subject"]["value"] > 0
    expected = -found["return"]["subject"]["value"] - 5 * found["touches"]["subject"]["value"]
    assert found["fine"]["subject"]["value"] == pytest.approx(expected)


def test_a_partial_measure_that_no_episode_knows(capsys):
    world = find("predator-prey")
    script = build_script(world)
    stage = crossplay.Stage(world, range(3))
    stage.play((script,) * 4)
    partial = next(measure for measure in world.beside if measure.partial)
    stage._played = {key: (lineup, np.full_like(values, np.nan)) for key, (lineup, values) in stage._played.items()}
    assert crossplay._where_known(stage, partial, (script,) * 4) is None
