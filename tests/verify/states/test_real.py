"""Real arithmetic: verdicts and counterexamples against an account by plain fractions, and what is said of them."""

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

from codegen.errors import DisagreementError
from tests.support.real_cases import (
    ABOVE,
    TEAM,
    THIRD,
    T,
    fails,
    is_short,
    leaf_of,
    machine_leaves,
    may_fail,
    measured,
    question_on_paper,
    random_question,
    state_at,
    states,
    within,
)
from tests.support.teams import RIGHT, STAY, UP, team, tree
from verify.claims.catalogue import find_property
from verify.claims.region import Region
from verify.claims.region_files import everywhere, start_region
from verify.claims.wording import AliveLeaves
from verify.counterexamples.uniqueness import Unique
from verify.kinds import REAL
from verify.question import Question, from_start
from verify.reports import report
from verify.result import Verdict
from verify.solver.leaves import leaf_findings
from verify.states import noise, real, shares
from verify.states.state import State, measurements, sample, violates
from verify.subjects import Game
from verify.verdicts import decisions
from verify.verdicts.decisions import verify

pytestmark = [pytest.mark.solver, pytest.mark.usefixtures("few_states_throughout")]
MEASURE = decisions.measure


@pytest.fixture(autouse=True)
def few_samples(monkeypatch):
    """Sampled states are fewer, for speed."""
    monkeypatch.setattr("verify.counterexamples.search.SAMPLES", 2_000)
    monkeypatch.setattr(
        "verify.verdicts.decisions.measure", lambda *given, **named: MEASURE(*given, **named, count=500)
    )


# --- against the account


def exactly(state):
    return {name: Fraction(value) for name, value in state.position.items()}


def ensure_right(profile, claim, region, pair, found):
    """Verdict, state and what is said of it, by the account alone."""
    (goal,) = region.goals
    tried = list(states(profile, claim, region, goal, *pair))
    wrong = [state for state in tried if may_fail(profile, claim, state, goal)]
    if not tried:
        assert found.verdict is Verdict.VACUOUS
        return "vacuous"
    assert found.verdict is (Verdict.VIOLATED if wrong else Verdict.PROVED)
    if not wrong:
        return "proved"
    state, position = found.evidence.counterexample.state, exactly(found.evidence.counterexample.state)
    assert state.goal == goal and within(region, position)
    if claim.eps:
        ensure_errors_right(profile, claim, found.evidence.counterexample)
        return "errors" if state.errors else "steady"
    ensure_leaves_right(profile, claim, found.evidence.counterexample)
    ensure_explained(profile, claim, region, found, wrong)
    floats = [state for state in wrong if all(map(is_short, state.values()))]
    assert state.floats or not floats, "a float64 state of few bits exists"
    if not state.floats:
        assert not found.evidence.counterexample.replayed and "no float64 state" in found.evidence.counterexample.says
        return "rational"
    leaves = machine_leaves(profile, position, goal)
    alike = all(
        profile.policy(view.agent).tree.action[leaves[view.agent]] == profile.policy(view.agent).tree.action[view.leaf]
        for view in found.evidence.counterexample.agents
    )
    assert found.evidence.counterexample.deployed.violated == fails(profile, claim, position, goal, leaves)
    assert bool(found.evidence.counterexample.replayed) == alike
    if found.evidence.counterexample.deployed.violated:
        return "both"
    assert not any(fails(profile, claim, state, goal, machine_leaves(profile, state, goal)) for state in floats)
    return "real"


def ensure_leaves_right(profile, claim, shown):
    position = exactly(shown.state)
    assert fails(profile, claim, position, shown.state.goal)
    for view in shown.agents:
        policy = profile.policy(view.agent)
        assert view.leaf == leaf_of(policy, state_at(position, shown.state.goal))
        assert view.action == policy.actions[policy.tree.action[view.leaf]].name
        for step in view.path:
            assert (Fraction(step.value) <= Fraction(step.threshold)) == step.left


def ensure_errors_right(profile, claim, shown):
    at, leaves = state_at(exactly(shown.state), shown.state.goal), {}
    for agent in TEAM:
        policy = profile.policy(agent)
        wrong = [Fraction(shown.state.errors.get(f"{agent}:{one.name}", 0)) for one in policy.features]
        assert all(abs(error) <= claim.eps for error in wrong)
        node = 0
        while policy.tree.feature[node] >= 0:
            place = policy.tree.feature[node]
            left = measured(policy.features[place].meaning, at, wrong[place]) <= Fraction(
                float(policy.tree.threshold[node])
            )
            node = int((policy.tree.left if left else policy.tree.right)[node])
        leaves[agent] = node
    assert fails(profile, claim, exactly(shown.state), shown.state.goal, leaves)
    assert {view.agent: view.leaf for view in shown.agents} == leaves


def ensure_explained(profile, claim, region, found, wrong):
    """Whether other leaves fail, and each coordinate's interval: at its ends, in it, and beyond it."""
    (goal,), position = region.goals, exactly(found.evidence.counterexample.state)
    here = {view.agent: view.leaf for view in found.evidence.counterexample.agents}
    elsewhere = [{agent: leaf_of(profile.policy(agent), state_at(one, goal)) for agent in TEAM} for one in wrong]
    other = found.evidence.explanation.uniqueness
    assert (other.answer is Unique.ONLY) == all(leaves == here for leaves in elsewhere)
    if other.answer is not Unique.ONLY:
        assert fails(profile, claim, exactly(other.other), goal) and within(region, exactly(other.other))
        reached = {agent: leaf_of(profile.policy(agent), state_at(exactly(other.other), goal)) for agent in TEAM}
        assert reached == dict(other.leaves) != here
    for span in found.evidence.explanation.spans:
        low, high = Fraction(span.low), Fraction(span.high)
        tiny = Fraction(1, 2**200)
        tried = [(low, "low" not in span.excluded), (high, "high" not in span.excluded), ((low + high) / 2, True)]
        # beyond an end that is left out the claim may fail again
        tried += [(low - tiny, False)] if "low" not in span.excluded else []
        tried += [(high + tiny, False)] if "high" not in span.excluded else []
        for value, kept in tried:
            moved = {**position, span.name: value}
            alike = {agent: leaf_of(profile.policy(agent), state_at(moved, goal)) for agent in TEAM} == here
            assert (within(region, moved) and alike and fails(profile, claim, moved, goal)) == kept, (span, value)


@pytest.mark.parametrize("seed", range(10))
def test_verdicts_and_states_are_those_of_plain_fractions(seed):
    rng = np.random.default_rng([seed, 77])
    for _ in range(2):
        profile, claim, region, pair = random_question(rng)
        ensure_right(profile, claim, region, pair, verify(Question(Game(profile), claim, region, REAL), {}))


def test_so_are_those_where_the_deployed_arithmetic_decides_otherwise():
    rng, kinds = np.random.default_rng(81), []
    for _ in range(12):
        profile, claim, region, pair = question_on_paper(rng)
        found = verify(Question(Game(profile), claim, region, REAL), {})
        kinds.append(ensure_right(profile, claim, region, pair, found))
    assert "real" in kinds and "both" in kinds and "proved" in kinds


@pytest.mark.parametrize("seed", range(5))
def test_so_are_those_of_features_that_are_off(seed):
    rng = np.random.default_rng([seed, 78])
    for _ in range(3):
        profile, claim, region, pair = random_question(rng, 1)
        eps = Fraction(rng.choice([Fraction(1, 20), T, Fraction(1, 30), ABOVE - T]))
        claim = replace(claim, eps=eps)
        ensure_right(profile, claim, region, pair, verify(Question(Game(profile), claim, region, REAL), {}))


# --- states that are chosen


def settled(profile, **given):
    """World states in which all is settled but what is given: coordinate -> bounds."""
    box = dict.fromkeys(start_region(profile.world).box, (Fraction(0), Fraction(0)))
    box |= {f"landmark_{k}.{axis}": (Fraction(1), Fraction(1)) for k in (0, 1) for axis in "xy"}
    return Region(box | {name.replace("__", "."): bounds for name, bounds in given.items()}, ("landmark_0",))


def test_the_state_shown_fails_by_the_arithmetic_asked(profile):
    """Just above a threshold the machine still stays where on paper the agent goes right: no state to end in."""
    one = team(profile, tree((2, float(T), 1, 2), RIGHT, (2, float(ABOVE), 3, 4), STAY, RIGHT), tree(UP))
    claim = find_property("own_target", one, radius=Fraction(0))
    sliver = settled(one, landmark_0__x=(ABOVE, ABOVE + Fraction(1, 10**9)))
    found = verify(Question(Game(one), claim, sliver, REAL), {})
    state = found.evidence.counterexample.state
    assert found.verdict is Verdict.VIOLATED and Fraction(state.position["landmark_0.x"]) == ABOVE
    assert found.evidence.counterexample.deployed.violated and found.evidence.counterexample.replayed == ("reference",)
    nearly = replace(
        sliver, box=sliver.box | {"landmark_0.x": (ABOVE + Fraction(1, 10**12), ABOVE + Fraction(1, 10**9))}
    )
    assert verify(Question(Game(one), claim, nearly, REAL), {}).verdict is Verdict.PROVED
    assert verify(Question(Game(one), claim, nearly), {}).verdict is Verdict.VIOLATED


def test_a_region_without_float64_states_is_violated_by_a_rational_one(profile):
    """Where it is UNKNOWN for the deployed arithmetic; a box, and a difference that is pinned."""
    still = team(profile, tree(STAY), tree(STAY))
    claim = find_property("own_target", still)
    box = settled(still, agent_0__x=(THIRD, THIRD))
    start = start_region(still.world)
    pinned = Region(start.box, ("landmark_0",), (("agent_0.x", "agent_1.x", (THIRD, THIRD)),))
    for region in (box, pinned):
        assert verify(Question(Game(still), claim, region), {}).verdict is Verdict.UNKNOWN
        found = verify(Question(Game(still), claim, region, REAL), {})
        position = exactly(found.evidence.counterexample.state)
        assert found.verdict is Verdict.VIOLATED and not found.evidence.counterexample.state.floats
        assert position["agent_0.x"] - position["agent_1.x"] == THIRD
        assert all(value.denominator <= 10 for value in position.values()), "few digits"
    with pytest.raises(AssertionError, match="no float64 state"):
        violates(from_start(still, claim), found.evidence.counterexample.state)


def test_replays_are_asked_about_float64_states_alone(profile):
    """And a replay that differs from the reference is an error, whatever real arithmetic says."""
    still = team(profile, tree(STAY), tree(STAY))
    claim = find_property("own_target", still)
    asked = []

    def replay(state, actions=(STAY, STAY)):
        asked.append(state)
        return list(actions)

    third = settled(still, agent_0__x=(THIRD, THIRD))
    found = verify(Question(Game(still), claim, third, REAL), {"other": replay})
    assert found.verdict is Verdict.VIOLATED and not asked and found.evidence.counterexample.replayed == ()
    half = settled(still, agent_0__x=(Fraction(1, 2), Fraction(1, 2)))
    found = verify(Question(Game(still), claim, half, REAL), {"other": replay})
    assert len(asked) == 1 and found.evidence.counterexample.replayed == ("reference", "other")
    with pytest.raises(DisagreementError):
        verify(Question(Game(still), claim, half, REAL), {"other": lambda state: [STAY, UP]})


def test_leaves_are_reached_by_rational_states(profile):
    third = Region(dict.fromkeys(start_region(profile.world).box, (THIRD, THIRD)), ("landmark_0",))
    one = team(profile, tree((2, 0.0, 1, 2), UP, STAY), tree(STAY))
    found, _ = leaf_findings(Question(Game(one), AliveLeaves("defenders"), third, REAL))
    assert [finding.verdict for finding in found] == [Verdict.PROVED, Verdict.VIOLATED, Verdict.PROVED]
    assert found[0].witness.position["agent_0.x"] == THIRD
    result = verify(Question(Game(one), find_property("alive_leaves", one), third, REAL), {})
    assert result.verdict is Verdict.VIOLATED and result.semantics == REAL
    document = report.document(one, [result], [""])
    assert document["results"][0]["leaves"][0]["state"]["position"]["agent_0.x"] == "1/3"


def test_a_leaf_between_the_machines_thresholds_is_reached_on_paper(profile):
    """From the threshold to where the machine turns: by float64 states, that the reference takes elsewhere."""
    one = team(profile, tree((2, float(T), 1, 2), UP, STAY), tree(STAY))
    sliver = settled(one, landmark_0__x=(T + Fraction(1, 2**40), T + Fraction(1, 2**39)))
    for semantics, dead in (("machine", [2]), (REAL, [1])):
        found, _ = leaf_findings(Question(Game(one), AliveLeaves("defenders"), sliver, semantics))
        assert [f.leaf for f in found if f.agent == "agent_0" and f.verdict is Verdict.VIOLATED] == dead


# --- batches


@pytest.mark.parametrize("seed", range(3))
def test_batches_decide_as_exact_measurements_do(seed):
    """At sharp differences, and one float64 number beside them."""
    rng = np.random.default_rng([seed, 80])
    for _ in range(4):
        profile, *_ = random_question(rng, 4)
        coordinates, _ = sample(everywhere(profile), profile.world, 60, seed)
        sharp = rng.choice([0.0, float(T), float(ABOVE), -float(T), 0.5, 0.1], coordinates.shape)
        coordinates = np.where(rng.random(coordinates.shape) < 0.6, sharp, coordinates)
        columns = list(profile.world.coordinates())
        coordinates[:, columns.index("landmark_0.x")] = coordinates[:, columns.index("agent_0.x")] + float(T)
        beside = np.nextafter(coordinates, rng.choice([-9.0, 9.0], coordinates.shape))
        coordinates = np.where(rng.random(coordinates.shape) < 0.2, beside, coordinates)
        for agent in TEAM:
            policy = profile.policy(agent)
            found = real.leaves_of(policy.tree, real.comparable(policy.features, coordinates, profile.world))
            for row, leaf in zip(coordinates, found, strict=True):
                at = {name: Fraction(value) for name, value in zip(columns, row.tolist(), strict=True)}
                assert leaf == leaf_of(policy, at)
                assert leaf == real.leaf_of(
                    policy.tree, [real.measure_feature(one.meaning, at) for one in policy.features]
                )


def test_shares_are_judged_by_the_arithmetic_asked(profile):
    """In a region between the threshold and where the machine turns, all states fail on paper and none as deployed."""
    one = team(profile, tree((2, float(T), 1, 2), RIGHT, STAY), tree(UP))
    claim = find_property("own_target", one, radius=Fraction(0))
    sliver = settled(one, landmark_0__x=(T + Fraction(1, 2**40), T + Fraction(1, 2**30)))
    for semantics, share in (("machine", 0), (REAL, 1)):
        assert shares.measure(Question(Game(one), claim, sliver, semantics), 0, 200).violating.value == share
    off = find_property("steady", one, of="own_target", radius=Fraction(0), eps=Fraction(1, 2**50))
    found = shares.measure(Question(Game(one), off, sliver, REAL), 0, 200)
    assert found.violating.value == 1 and found.changing.value == 0


def test_errors_that_lead_elsewhere_are_found_exactly(profile):
    """A third below the threshold, an error of a third leads to the right of it by nothing, and one more by a hair."""
    one = team(profile, tree((2, 0.5, 1, 2), RIGHT, STAY), tree(UP))
    hair = Fraction(1, 2**90)
    for eps, found in ((THIRD, False), (THIRD + hair, True)):
        claim = find_property("steady", one, of="own_target", radius=Fraction(0), eps=eps)
        state = State(
            dict.fromkeys(start_region(one.world).box, 0.0)
            | {f"landmark_{k}.{axis}": 1.0 for k in (0, 1) for axis in "xy"}
            | {"agent_0.x": Fraction(5, 6)},
            "landmark_0",
        )
        wrong = noise.mistaken(from_start(one, claim, REAL), state)
        assert (wrong is not None) == found
        if wrong is not None:
            (error,) = wrong.errors.values()
            assert THIRD < Fraction(error) <= eps and violates(from_start(one, claim, REAL), wrong)
            assert measurements(one, one.policy("agent_0"), wrong)[2] > Fraction(1, 2)
