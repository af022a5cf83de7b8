"""The question: what is derived from profile, claim, region, semantics and budgets, and what stays as it is."""

from dataclasses import FrozenInstanceError, replace
from fractions import Fraction

import numpy as np
import pytest

from codegen.errors import InputError
from tests.support.observations import blind
from tests.support.teams import LEFT, STAY, team, tree
from tests.support.zone_cases import deception
from verify.claims.decisions import DistinctTargets, formula
from verify.claims.formula import for_goal
from verify.claims.region_files import everywhere
from verify.kinds import REAL
from verify.question import SAMPLED, Budgets, Question, from_start, list_shuffled
from verify.result import Control, Verdict
from verify.subjects import Game

CLAIM = DistinctTargets("defenders")


@pytest.fixture(name="question")
def _question():
    base, _ = deception(np.random.default_rng(0), 1)
    return from_start(team(base, tree((0, 0.0, 1, 2), STAY, LEFT), tree(STAY)), CLAIM)


def test_derives(question):
    assert question.formula == formula(question.profile, CLAIM) and question.formula is question.formula
    assert question.formula_for("landmark_1") == for_goal(question.formula, "landmark_1")
    assert question.goals == question.region.goals == ("landmark_0", "landmark_1")
    assert question.within(replace(question.region, goals=())).goals == (None,)
    assert question.for_one_goal("landmark_1").goals == ("landmark_1",)
    assert question.for_one_goal(None).goals == (None,)
    assert [policy.agent for policy in question.team] == ["agent_0", "agent_1"]
    assert question.budgets == Budgets() and question.region == everywhere(question.profile)


def test_neighbours_differ_in_one_part(question):
    other = question.with_margin(Fraction(1, 2))
    assert other.claim == replace(CLAIM, margin=Fraction(1, 2)) and other.formula != question.formula
    assert other.region is question.region and other.profile is question.profile
    assert question.with_eps(Fraction(1, 8)).claim.eps == Fraction(1, 8)
    assert question.by(REAL).semantics == REAL
    spent = question.spending(max_nodes=7).budgets
    assert spent == replace(Budgets(), max_nodes=7)
    control, *_ = question.controls
    assert (control.claim, control.region, control.budgets) == (question.claim, question.region, question.budgets)


def test_small_trees_are_shuffled_in_every_other_way():
    """A tree that is fulfilled by no other order was said to be weak, as one order of four happened to do."""
    branches = tree((0, 0.0, 1, 4), (1, 0.0, 2, 3), 0, 1, (1, 1.0, 5, 6), 1, 0)
    for nodes, count in ((branches, 5), (tree((0, 0.0, 1, 2), 0, 0), 0), (tree((0, 0.0, 1, 2), 0, 1), 1)):
        found = list_shuffled(blind({"a": nodes, "b": tree(0)}), "")
        actions = {tuple(one.agents[0].tree.action.tolist()) for one in found}
        assert len(actions) == len(found) == count and tuple(nodes.action.tolist()) not in actions
        assert all(sorted(each) == sorted(nodes.action.tolist()) for each in actions)
    large = blind(dict.fromkeys("ab", branches))
    found = list_shuffled(large, "")
    assert len(found) == len({tuple(each.tree.action.tobytes() for each in one.agents) for one in found}) == SAMPLED
    assert list_shuffled(large, "nobody") == []


def test_a_control_says_what_most_say():
    control = Control.of([Verdict.PROVED, Verdict.VIOLATED, Verdict.VIOLATED, Verdict.UNKNOWN])
    assert (control.words, control.verdict) == ("1 of 4 fulfil the claim, 1 without an answer", Verdict.UNKNOWN)
    assert Control.of([Verdict.PROVED] * 2 + [Verdict.VIOLATED]).verdict is Verdict.PROVED
    assert (Control().words, Control().verdict) == ("", Verdict.SKIPPED)


def test_is_frozen_and_refuses_whom_it_cannot_be_about(question):
    with pytest.raises(FrozenInstanceError):
        question.claim = CLAIM
    blind = replace(question.profile.policy("agent_1"), features=())
    with pytest.raises(InputError, match="team"):
        _ = question.about(replace(CLAIM, team="nobody")).team
    unknown = replace(
        question.profile.policy("agent_0"),
        features=tuple(replace(one, meaning=None) for one in question.profile.policy("agent_0").features),
    )
    with pytest.raises(InputError, match="meaning"):
        _ = Question(Game(replace(question.profile, agents=(unknown, blind))), CLAIM, question.region).team
