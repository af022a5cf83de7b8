"""How often each leaf decides: counted in held-out episodes, kept by profiles, shown, dropped where a tree changes."""

import re
from dataclasses import replace

import numpy as np
import pytest

from codegen import ir, policy_json, profiles
from codegen.errors import ProfileError
from codegen.profiles import check
from maviper.episodes.measures import MEASUREMENT_SEEDS
from maviper.episodes.play import rollout
from maviper.episodes.trees import among
from maviper.evaluation import held_out
from maviper.evaluation.show import rules
from maviper.worlds import find
from tests.support.teams import team_in

EPISODES = 12


def test_visits_are_the_leaves_met_against_experts(profile, world, expert, monkeypatch):
    monkeypatch.setattr(held_out, "EVALUATION_EPISODES", EPISODES)
    bare = [replace(policy, tree=replace(policy.tree, visits=np.zeros(0))) for policy in profile.agents]
    rows, counted = held_out.evaluate_trees(world, bare, expert)
    assert rows == held_out.evaluation(world, bare, expert)
    seeds = range(MEASUREMENT_SEEDS, MEASUREMENT_SEEDS + EPISODES)
    for policy in counted:
        place, team = world.agents.index(policy.agent), world.team_of(policy.agent)
        trees = [each for each in bare if each.team == team]
        (played,) = rollout(world, among(world, trees, [expert] * len(world.agents)), seeds)
        seen = played.observations[place].reshape(-1, len(policy.features))
        leaves = ir.apply(policy.tree, seen)
        assert policy.tree.visits.tolist() == np.bincount(leaves, minlength=len(policy.tree.feature)).tolist()
        assert policy.tree.visits.sum() == EPISODES * world.spec.episode_steps


def test_those_who_have_left_visit_nothing(monkeypatch):
    from tests.support.ends import Expert, world_of

    monkeypatch.setattr(held_out, "EVALUATION_EPISODES", 4)
    relay = world_of("relay")
    leaf = ir.Tree(*(np.array([value]) for value in (ir.NO_FEATURE, 0, ir.NO_CHILD, ir.NO_CHILD, 0)))
    policies = list(team_in(relay, [leaf] * len(relay.agents)).agents)
    _, counted = held_out.evaluate_trees(relay, policies, Expert(relay))
    (first, *rest) = rollout(relay, [Expert(relay)] * 3, range(MEASUREMENT_SEEDS, MEASUREMENT_SEEDS + 4))
    steps = sum(each.alive.sum(axis=(0, 1)) for each in [first, *rest])
    assert [int(policy.tree.visits[0]) for policy in counted] == steps.tolist()
    assert len(set(steps.tolist())) > 1


def test_profiles_keep_them_and_rules_show_them(profile):
    again = profiles.loads(policy_json.dumps(profile))
    for ours, theirs in zip(profile.agents, again.agents, strict=True):
        assert ours.tree.visits.tolist() == theirs.tree.visits.tolist() != []
    policy = again.agents[0]
    shown = list(rules(policy))
    assert all(f"of {policy.tree.visits.sum():,} decisions)" in line for line in shown)
    bare = replace(policy, tree=replace(policy.tree, visits=np.zeros(0)))
    assert all("decisions" not in line for line in rules(bare))
    text = policy_json.dumps(replace(profile, agents=(bare, *profile.agents[1:])))
    assert not len(profiles.loads(text).agents[0].tree.visits)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda text: text.replace('"visits": ', '"visits": -', 1), "visits are from 0"),
        (lambda text: text.replace(', "visits": ', ', "ignored": ', 1), "unknown field"),
        (lambda text: re.sub(r', "visits": \d+', "", text, count=1), r"of \d+ leaves have visits"),
        (lambda text: text.replace('"left": 1,', '"left": 1, "visits": 5,', 1), r"tree\[0\]: a split has visits"),
    ],
)
def test_damaged_visits_are_refused(profile, change, said):
    with pytest.raises(ProfileError, match=said):
        profiles.loads(change(policy_json.dumps(profile)))


def test_visits_of_another_tree_are_refused(profile):
    policy = profile.agents[0]
    wrong = replace(policy, tree=replace(policy.tree, visits=policy.tree.visits[1:]))
    assert any("visits" in each.message for each in check(replace(profile, agents=(wrong, *profile.agents[1:]))))
    assert find("physical-deception").agents[0] == policy.agent


def test_pictures_of_other_people_s_games_have_the_kept_shares(profile):
    """Where no world of ours can be played, the shares below leaves are those of the profile."""
    from maviper.page.page import svg

    elsewhere = replace(profile, world=replace(profile.world, name="elsewhere", reference="mygame:make"))
    policy = profile.agents[0]
    bare = replace(policy, tree=replace(policy.tree, visits=np.zeros(0)))
    unknown = replace(elsewhere, agents=(bare, *profile.agents[1:]))
    assert "%" in svg(elsewhere, [policy.agent]) and "%" not in svg(unknown, [policy.agent])
