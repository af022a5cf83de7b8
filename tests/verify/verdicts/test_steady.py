"""Errors of features: one per feature and agent, decided exactly, replayed with the errors of the counterexample."""

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from codegen import ir
from codegen.lowering.deploy import deploy_tree
from tests.support.meanings import asking, meanings, tied_points, with_meanings
from tests.support.steady_zones import CLAIM, EPS
from tests.support.strategies import grown_trees
from tests.support.teams import LEFT, RIGHT, STAY, UP, team, towards, tree
from verify.claims.decisions import DistinctTargets
from verify.claims.region_files import start_region
from verify.question import Question, from_start
from verify.result import Verdict
from verify.states import noise, shares
from verify.states.state import State, error_name, inside, measurable, observe_state, sample, violates
from verify.subjects import Game
from verify.verdicts.decisions import verify

pytestmark = pytest.mark.usefixtures("few_states_throughout")


def mistaken_points(profile, count, seed):
    """World states on a coarse grid, with errors on a grid too, so that sums meet thresholds."""
    rng = np.random.default_rng(seed)
    for state in tied_points(count, seed):
        errors = {}
        for policy in profile.team("defenders"):
            for feature in policy.features:
                error = float(rng.choice([0.0, 0.0, 0.1, -0.1, 0.0625, -0.0625, 1e-9]))
                if abs(Fraction(error)) <= EPS:  # the float64 number 0.1 is more than a tenth
                    errors[error_name(policy.agent, feature.name)] = error
        yield State(state.position, state.goal, errors)


@pytest.mark.solver
@settings(max_examples=40)
@given(grown_trees(n_features=14, max_depth=3), grown_trees(n_features=14, max_depth=3), st.integers(0, 999))
def test_states_with_errors_against_the_referee(first, second, seed):
    """Every kind of meaning, errors at thresholds: the solver's constraints are what the referee computes."""
    trees = {"agent_0": deploy_tree(first), "agent_1": deploy_tree(second)}
    assume(not any(((t.threshold != 0) & (np.abs(t.threshold) < 2.0**-126)).any() for t in trees.values()))
    profile = with_meanings(trees)
    asked = asking(profile, CLAIM)
    for state in mistaken_points(profile, 12, seed):
        assert asked(state) == violates(from_start(profile, CLAIM), state), state


@pytest.mark.solver
@pytest.mark.parametrize("threshold", [-0.5, -0.0, 0.0625, 0.25, 0.5])
@pytest.mark.parametrize("kind", range(14))
def test_each_meaning_with_errors_against_the_referee(kind, threshold):
    profile = with_meanings({"agent_0": tree((kind, threshold, 1, 2), LEFT, UP), "agent_1": tree(UP)})
    asked = asking(profile, CLAIM)
    for state in mistaken_points(profile, 8, seed=kind):
        assert asked(state) == violates(from_start(profile, CLAIM), state), state


def test_constants_and_equalities_have_no_errors():
    found = [measurable(meaning) for meaning in meanings("agent_0")]
    assert [str(m) for m, kept in zip(meanings("agent_0"), found, strict=True) if not kept] == [
        "0", "zero(goal.x - landmark_0.x)", "zero(landmark_0.x - agent_0.x)",
    ]  # fmt: skip


@pytest.mark.solver
def test_violations_hold_their_errors_and_replay(profile):
    """Fixed roles are proved without errors; with large ones they fail, in a state that the referee confirms."""
    roles = team(profile, towards(0, 0), towards(1, 1))
    region = start_region(roles.world)
    claim = DistinctTargets("defenders", eps=Fraction(1, 4))
    replayed = []

    def replay(state):
        replayed.append(state)
        return [int(ir.act(policy, observe_state(roles, policy, state))[0]) for policy in roles.team("defenders")]

    found = verify(Question(Game(roles), claim, region), {"again": replay})
    assert found.verdict is Verdict.VIOLATED and found.evidence.control.verdict is Verdict.VIOLATED
    state = found.evidence.counterexample.state
    assert state.errors and replayed == [state] and violates(from_start(roles, claim), state) and inside(region, state)
    assert not violates(from_start(roles, claim), State(state.position, state.goal)), (
        "without its errors nothing is wrong"
    )
    assert all(len(repr(value)) <= 8 for value in state.errors.values()), "errors are not shrunk"
    shown = {name for view in found.evidence.counterexample.agents for name, _ in view.errors}
    assert shown == {name.split(":")[1] for name in state.errors}


def test_random_errors_never_leave_what_is_called_reachable(profile):
    roles = team(profile, towards(0, 0), towards(0, 1))
    region = start_region(roles.world)
    coordinates, goals = sample(region, roles.world, 200, 0)
    able = {policy.agent: noise.reachable(policy, coordinates, roles.world, float(EPS)) for policy in roles.agents}
    bad, changes = (
        noise.violable(from_start(roles, CLAIM), coordinates),
        noise.changeable(from_start(roles, CLAIM), coordinates),
    )
    assert 0 < changes.sum() < 200 and 0 < bad.sum() < 200
    rng, names = np.random.default_rng(1), roles.world.coordinates()
    met = dict.fromkeys(range(200), False)
    for row in range(200):
        position = {name: float(coordinates[row, names.index(name)]) for name in region.box}
        for _ in range(5):
            errors = {
                error_name(policy.agent, feature.name): float(rng.uniform(-0.1, 0.1))
                for policy in roles.team("defenders")
                for feature in policy.features
            }
            state = State(position, f"landmark_{goals[row]}", errors)
            for policy in roles.team("defenders"):
                action = int(ir.act(policy, observe_state(roles, policy, state))[0])
                assert able[policy.agent][row, action]
            met[row] |= violates(from_start(roles, CLAIM), state)
        assert bad[row] or not met[row]
        if bad[row]:
            found = noise.mistaken(from_start(roles, CLAIM), State(position, f"landmark_{goals[row]}"))
            assert found is not None and violates(from_start(roles, CLAIM), found)
    assert shares.violating(from_start(roles, CLAIM), coordinates).sum() == bad.sum()


@pytest.mark.parametrize("threshold", [-1.0, -0.5, 0.0, 0.5])
@pytest.mark.parametrize("function", ["sign", "positive", "zero"])
def test_what_errors_reach_where_a_function_turns(profile, function, threshold):
    """The whole error, towards 0 and no farther."""
    eps = Fraction(1, 8)
    policy = team(profile, tree((2, threshold, 1, 2), LEFT, RIGHT), tree(STAY)).policy("agent_0")
    meaning = replace(policy.features[2].meaning, function=function)
    features = [replace(one, meaning=meaning) if place == 2 else one for place, one in enumerate(policy.features)]
    policy = replace(policy, features=tuple(features))
    turned = replace(profile, agents=tuple(policy if one.agent == "agent_0" else one for one in profile.agents))
    for offset in (-0.25, -0.125, -0.0625, 0.0, 0.0625, 0.125, 0.25):
        position = dict.fromkeys(start_region(turned.world).box, 0.0) | {"landmark_0.x": offset}
        state = State(position, "landmark_1")
        name, found = error_name("agent_0", features[2].name), set()
        for error in (-0.125, 0.0, 0.125):
            found.add(int(ir.act(policy, observe_state(turned, policy, replace(state, errors={name: error})))[0]))
        able = noise.reachable(policy, state.coordinates(turned), turned.world, float(eps))[0]
        assert set(np.flatnonzero(able).tolist()) >= found, (offset, found)
        assert function != "sign" or threshold >= 0 or set(np.flatnonzero(able).tolist()) == found, (offset, found)


@pytest.mark.compile
@pytest.mark.solver
def test_errors_replay_in_compiled_code_and_in_the_environment(profile):
    from maviper.verification.run import verify_claims

    roles = team(profile, towards(0, 0), towards(1, 1))
    claim = DistinctTargets("defenders", eps=Fraction(1, 4))
    (found,) = verify_claims([Question(Game(roles), claim, start_region(roles.world))])
    assert found.verdict is Verdict.VIOLATED and found.evidence.counterexample.state.errors
    assert found.evidence.counterexample.replayed == ("reference", "compiled C", roles.world.reference)
