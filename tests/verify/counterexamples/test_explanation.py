"""What is said about counterexamples: intervals against the referee, uniqueness against other engines, shortfalls."""

import math
from fractions import Fraction
from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from codegen import ir
from tests.support.teams import LEFT, STAY, UP, team, towards, tree
from tests.support.zone_cases import deception, near_roles, random_region, stated
from verify.checker.thresholds import sides
from verify.claims.decisions import DistinctTargets, formula
from verify.claims.formula import FALSE, TRUE, And, Linear, Not, Or, conjunction, disjunction, holds
from verify.claims.region import Region
from verify.claims.region_files import start_region
from verify.claims.wording import OwnFormula
from verify.counterexamples import uniqueness
from verify.counterexamples.explanation import along, around, explain_counterexample, line_between
from verify.counterexamples.search import explain, violating_samples
from verify.counterexamples.uniqueness import Unique, unique
from verify.question import Budgets, Question, from_start
from verify.result import Verdict
from verify.solver.encode import elsewhere, there
from verify.solver.solve import ask
from verify.states.state import State, inside, leaves_at, observe_state, shortfall, violates
from verify.states.values import tighten_formula, worth
from verify.subjects import Game
from verify.verdicts.decisions import verify
from verify.zones import engine

CLAIM = DistinctTargets("defenders")


@pytest.fixture(autouse=True)
def few_samples(few_states, monkeypatch):
    """Sampled violations of fewer states, for speed."""
    del few_states
    monkeypatch.setattr("verify.counterexamples.search.SAMPLES", 4_000)


def cases(count, seed, max_depth=2):
    """Random teams with every kind of feature, claims, regions, and a violation that the referee confirmed."""
    rng = np.random.default_rng(seed)
    while count:
        profile, claim = deception(rng, max_depth)
        region = random_region(rng, profile)
        state = next(violating_samples(Question(Game(profile), claim, region)), None)
        if state is not None:
            count -= 1
            yield rng, profile, claim, region, state


def keeps(profile, claim, region, state, name, value):
    """Whether a world state with another value of one coordinate still fails in the same leaves, by the referee."""
    moved = State({**state.position, name: value}, state.goal, state.errors)
    same = leaves_at(profile, claim.team, moved) == leaves_at(profile, claim.team, state)
    return same and inside(region, moved) and violates(from_start(profile, claim), moved)


def why(profile, claim, region, state):
    found = explain(from_start(profile, claim), state, {})
    return explain_counterexample(Question(Game(profile), claim, region), found)


# --- sets on a line


BOUNDS = st.integers(-6, 6).map(lambda n: Fraction(n, 4))
ATOMS = st.builds(
    lambda weight, other, bound, strict: Linear(((Fraction(weight), "x"), (Fraction(other), "y")), bound, strict),
    *(st.sampled_from([-2, -1, 0, 1, 3]), st.sampled_from([-1, 0, 1]), BOUNDS, st.booleans()),
)
FORMULAS = st.recursive(
    ATOMS | st.sampled_from([TRUE, FALSE]),
    lambda inner: st.one_of(
        st.lists(inner, max_size=3).map(lambda parts: And(tuple(parts))),
        st.lists(inner, max_size=3).map(lambda parts: Or(tuple(parts))),
        inner.map(Not),
    ),
    max_leaves=8,
)


@settings(max_examples=300)
@given(FORMULAS, BOUNDS)
def test_a_formula_along_a_line_is_its_truth(asked, y):
    at = {"x": Fraction(0), "y": y}
    found = along(asked, "x", at, line_between(Fraction(-2), Fraction(2)))
    assert list(found) == sorted(found) and all(low < high for low, high in found)
    for value in (Fraction(n, 24) for n in range(-60, 61)):
        within = any(low <= (value, 0) < high for low, high in found)
        assert within == (abs(value) <= 2 and holds(asked, at | {"x": value}, {}))


def test_a_gap_without_float64_numbers_is_no_gap():
    def without(hole):
        sides = [Linear(((Fraction(sign), "x"),), sign * hole, True) for sign in (1, -1)]
        return along(Or(tuple(sides)), "x", {}, line_between(Fraction(-1), Fraction(1)))

    line = without(Fraction(1, 10))
    assert len(line) == 2 and around(line, 0.0) == (-1.0, 1.0)  # 1/10 is no float64 number
    line = without(Fraction(1, 2))
    assert around(line, 0.0) == (-1.0, math.nextafter(0.5, 0)) and around(line, 0.75) == (math.nextafter(0.5, 1), 1.0)


# --- intervals


@pytest.mark.solver
def test_intervals_are_what_the_referee_says():
    """At the ends, beside them and inside; and they are the same from wherever in them one asks."""
    narrow = free = 0
    for rng, profile, claim, region, state in cases(8, 1):
        found = why(profile, claim, region, state)
        for span in found.spans:
            values = [span.low, span.high, *rng.uniform(span.low, span.high, 8)]
            assert all(keeps(profile, claim, region, state, span.name, float(value)) for value in values)
            for outside in (math.nextafter(span.low, -math.inf), math.nextafter(span.high, math.inf)):
                assert not keeps(profile, claim, region, state, span.name, outside)
                moved = State({**state.position, span.name: outside}, state.goal)
                narrow += inside(region, moved)
                assert not (span.free and inside(region, moved))
            if span.free:
                low, high = map(float, region.box[span.name])
                values = [low, high, *rng.uniform(low, high, 8)]
                states = [State({**state.position, span.name: float(value)}, state.goal) for value in values]
                assert all(violates(from_start(profile, claim), one) for one in states if inside(region, one))
                free += low < high
        end = max(found.spans, key=lambda span: span.high - span.low)
        moved = State({**state.position, end.name: end.high}, state.goal)
        there_too = next(one for one in why(profile, claim, region, moved).spans if one.name == end.name)
        assert (there_too.low, there_too.high) == (end.low, end.high)
    assert narrow > 8 and free > 30


@pytest.mark.solver
def test_features_say_which_values_lead_to_the_same_leaf():
    for rng, profile, claim, region, state in cases(12, 2, 4):
        for room in why(profile, claim, region, state).agents:
            policy = profile.policy(room.agent)
            names = [feature.name for feature in policy.features]
            obs = observe_state(profile, policy, state)
            leaf = int(ir.apply(policy.tree, obs)[0])

            def leaf_with(name, value, obs=obs, names=names, policy=policy):
                changed = obs.copy()
                changed[0, names.index(name)] = value
                return int(ir.apply(policy.tree, changed)[0])

            for name in room.untested:
                assert {leaf_with(name, value) for value in (-math.inf, *rng.uniform(-2, 2, 5), math.inf)} == {leaf}
            for one in room.tested:
                low, high = np.float32(one.low), np.float32(one.high)
                assert leaf_with(one.feature, np.nextafter(low, np.float32(np.inf))) == leaf
                assert leaf_with(one.feature, high) == leaf
                assert math.isinf(one.low) or leaf_with(one.feature, low) != leaf
                assert math.isinf(one.high) or leaf_with(one.feature, np.nextafter(high, np.float32(np.inf))) != leaf
            assert {one.feature for one in room.tested}.isdisjoint(room.untested)
            assert len(room.tested) + len(room.untested) == len(names)


@pytest.mark.solver
def test_a_test_turns_when_what_it_measures_moves_by_its_room(profile):
    turned, same = 0, team(profile, towards(0, 0), towards(0, 1))
    region = start_region(same.world)
    for state, _ in zip(violating_samples(Question(Game(same), CLAIM, region)), range(8), strict=False):
        for room in why(same, CLAIM, region, state).agents:
            policy = same.policy(room.agent)
            for turn in room.turns:
                place = next(k for k, one in enumerate(policy.features) if one.name == turn.step.feature)
                sign = next(w for w, name in policy.features[place].meaning.terms if name.startswith(policy.agent))
                name = f"{policy.agent}.{turn.step.feature[-1]}"
                assert turn.over == turn.step.value - turn.step.threshold and turn.room > 0
                for share, stays in ((1 - 1e-6, True), (1 + 1e-6, False)):
                    moved = state.position[name] + turn.room * share * (1 if turn.step.left else -1) * sign
                    value = observe_state(same, policy, State({**state.position, name: moved}, state.goal))[0, place]
                    assert bool(value <= np.float32(turn.step.threshold)) == (turn.step.left == stays), turn
                    turned += not stays
    assert turned > 20


@pytest.mark.solver
def test_errors_of_features_stay_as_they_are(profile):
    roles = team(profile, towards(0, 0), towards(1, 1))
    claim = DistinctTargets("defenders", eps=Fraction(1, 4))
    found = verify(Question(Game(roles), claim, start_region(roles.world)), {})
    state = found.evidence.counterexample.state
    why = found.evidence.explanation
    assert state.errors and why.shortfall == float(shortfall(from_start(roles, claim), state)) >= 0
    for span in why.spans:
        assert keeps(roles, claim, found.region, state, span.name, span.high)
        assert not keeps(roles, claim, found.region, state, span.name, math.nextafter(span.high, math.inf))
    assert any(span.low < span.high and not span.free for span in why.spans)
    assert all(turn.room >= 0 for room in why.agents for turn in room.turns)


# --- uniqueness


def in_leaves(profile, leaves):
    """That every agent reaches its leaf, as a formula with the zone engine's thresholds."""
    tests = []
    for agent, leaf in leaves.items():
        policy, node = profile.policy(agent), leaf
        while node != ir.ROOT:
            parent = int(np.flatnonzero((policy.tree.left == node) | (policy.tree.right == node))[0])
            feature = policy.features[policy.tree.feature[parent]]
            both = sides(feature, float(policy.tree.threshold[parent]), policy.numbers)
            tests.append(both[int(policy.tree.right[parent] == node)])
            node = parent
    return conjunction(*tests)


def elsewhere_by_pairs(profile, claim, region, leaves):
    """Whether the claim fails in other leaves, asked pair by pair."""
    every = [[(policy.agent, int(leaf)) for leaf in ir.leaves(policy.tree)] for policy in profile.team(claim.team)]
    others = [dict(pair) for pair in product(*every) if dict(pair) != leaves]
    question = Question(Game(profile), claim, region)
    return any(ask(there(question, goal, pair)).holds for pair in others for goal in region.goals)


@pytest.mark.solver
@pytest.mark.parametrize("kind", ["any", "near roles"])
def test_uniqueness_against_pairs_of_leaves_and_zones(kind, profile, monkeypatch):
    """The answer is that of all pairs of leaves, and of the other engine on the claim or these leaves."""
    rng, answers, by_zones = np.random.default_rng(4), [], 0
    monkeypatch.setattr(uniqueness, "violating_samples", lambda *_: iter(()))  # the solver must find them all
    while len(answers) < 14:
        found, claim = deception(rng, 2) if kind == "any" else near_roles(rng, profile)
        region = random_region(rng, found)
        question = Question(Game(found), claim, region)
        state = next(violating_samples(question), None)
        if state is None:
            continue
        leaves = leaves_at(found, claim.team, state)
        answer = unique(question, state)
        answers.append(answer.answer)
        wanted = elsewhere_by_pairs(found, claim, region, leaves)
        assert wanted == (answer.answer is not Unique.ONLY)
        try:
            other = engine.decide(stated(found, disjunction(formula(found, claim), in_leaves(found, leaves)), region))
            assert (other.verdict is Verdict.VIOLATED) == wanted
            by_zones += 1
        except engine.BeyondZonesError:
            pass
        if answer.other is not None:
            assert inside(region, answer.other) and violates(from_start(found, claim), answer.other)
            assert leaves_at(found, claim.team, answer.other) == dict(answer.leaves) != leaves
        if answer.answer is Unique.ONLY:
            goals = {goal for goal in region.goals if ask(there(question, goal, leaves)).holds}
            assert set(answer.goals) == goals and not answer.open_goals
        assert answer.answer is not Unique.OPEN or answer.reason == uniqueness.ONLY_REAL
    assert {Unique.ONLY, Unique.OTHERS} <= set(answers) and by_zones > 7


@pytest.mark.solver
def test_the_only_way_to_fail_is_told_with_its_goals(profile):
    """One agent stays where its landmark is on its left, and never comes there in the second goal's region."""
    roles = team(profile, tree((2, -0.5, 1, 2), STAY, *moved(towards(0, 0), 2)), towards(1, 1))
    found = verify(Question(Game(roles), CLAIM, start_region(roles.world)), {})
    assert found.verdict is Verdict.VIOLATED and found.evidence.explanation.uniqueness.answer is Unique.OTHERS
    still = team(profile, tree((2, -0.5, 1, 2), STAY, *moved(towards(0, 0), 2)), tree(LEFT))
    one = Fraction(1)
    box = dict(start_region(profile.world).box) | {"agent_1.x": (one, one), "landmark_1.x": (-one, -one)}
    everywhere = Question(Game(still), CLAIM, Region(box, ("landmark_0", "landmark_1")))
    said = verify(everywhere, {}).evidence.explanation.uniqueness
    assert said.answer is Unique.ONLY and said.goals == ("landmark_0", "landmark_1")
    assert str(said).startswith("the only one:") and said.document()["other"] is None
    only = verify(Question(Game(still), CLAIM, Region(box, ("landmark_1",))), {}).evidence.explanation.uniqueness
    assert only.goals == ("landmark_1",)


def moved(part, by):
    """The nodes of a tree, to be put behind `by` others."""
    columns = zip(part.feature, part.threshold, part.left, part.right, part.action, strict=True)
    return [
        int(action) if feature == ir.NO_FEATURE else (int(feature), float(threshold), int(left) + by, int(right) + by)
        for feature, threshold, left, right, action in columns
    ]


@pytest.mark.solver
def test_a_small_budget_leaves_it_open(profile, monkeypatch):
    monkeypatch.setattr(uniqueness, "violating_samples", lambda *_: iter(()))
    same = team(profile, towards(0, 0), towards(0, 1))
    region = start_region(same.world)
    state = next(violating_samples(Question(Game(same), CLAIM, region)))
    said = unique(Question(Game(same), CLAIM, region, budgets=Budgets(10)), state)
    assert said.answer is Unique.OPEN and "resource units" in said.reason and "not decided" in str(said)


@pytest.mark.solver
def test_trees_of_one_leaf_are_the_only_way(profile):
    still = team(profile, tree(STAY), tree(UP))
    found = verify(Question(Game(still), CLAIM, start_region(still.world)), {})
    assert found.evidence.explanation.uniqueness.answer is Unique.ONLY
    query = elsewhere(Question(Game(still), CLAIM, found.region), "landmark_0", {"agent_0": 0, "agent_1": 0})
    assert ask(query).holds is False
    assert all(room.nearest is None and len(room.untested) == 10 for room in found.evidence.explanation.agents)
    assert "nearest" not in found.evidence.explanation.says()


# --- shortfall


@settings(max_examples=200)
@given(FORMULAS.filter(lambda asked: "Not" not in repr(asked)), BOUNDS, BOUNDS)
def test_worth_is_by_how_much_bounds_may_move(asked, x, y):
    at, little = {"x": x, "y": y}, Fraction(1, 1000)
    value = worth(asked, at, {})
    assert value >= 0 if holds(asked, at, {}) else value <= 0
    if math.isinf(value):
        assert holds(asked, at, {}) == (value > 0)
        return
    assert holds(tighten_formula(asked, value - little), at, {})
    assert not holds(tighten_formula(asked, value + little), at, {})
    assert worth(Not(asked), at, {}) == -value


@pytest.mark.solver
def test_the_shortfall_of_a_known_team(profile):
    """Both go left, and landmark_1 is to the right of both."""
    both = team(profile, tree(LEFT), tree(LEFT))
    at = {"adversary_0": (0, 0), "agent_0": (0.5, 0), "agent_1": (0, 0.5)}
    at |= {"landmark_0": (-1, 0), "landmark_1": (0.75, 0.5)}
    position = {f"{name}.{axis}": float(v) for name, pair in at.items() for axis, v in zip("xy", pair, strict=True)}
    state = State(position, "landmark_0")
    assert violates(from_start(both, CLAIM), state)
    # agent_1 closes on landmark_0 by 1, agent_0 would on landmark_1 if that were a quarter further to the left
    assert shortfall(from_start(both, CLAIM), state) == Fraction(1, 4)
    assert not violates(from_start(both, CLAIM), State(position | {"agent_0.x": 1.0}, "landmark_0"))
    acting = OwnFormula("defenders", statement=FALSE)
    assert math.isinf(shortfall(from_start(both, acting), state))


@pytest.mark.solver
def test_what_the_region_fixes_is_not_said_to_make_no_difference(profile):
    """By its box, or by a difference that leaves one value."""
    still = team(profile, tree(STAY), tree(STAY))
    half = Fraction(1, 2)
    box = dict(start_region(still.world).box) | {"landmark_0.x": (half, half)}
    region = Region(box, ("landmark_0",), (("agent_0.y", "agent_1.y", (half, half)),))
    result = verify(Question(Game(still), CLAIM, region), {})
    said = result.evidence.explanation.document()["coordinates"]
    for name in ("landmark_0.x", "agent_0.y", "agent_1.y"):
        assert said[name]["says"] == "fixed by the region" and said[name]["matters"] is None
    assert said["adversary_0.x"]["matters"] is False
    assert set(result.evidence.explanation.free) & {"landmark_0.x", "agent_0.y", "agent_1.y"} == set()
    assert "adversary_0.x" in result.evidence.explanation.free
