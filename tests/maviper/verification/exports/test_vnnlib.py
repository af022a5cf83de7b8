"""Queries in VNN-LIB: read by the language's own package, they hold exactly where the referee sees the claim fail."""

from dataclasses import replace
from fractions import Fraction

import numpy as np
import onnxruntime
import pytest
import vnnlib

from codegen import ir, policy_json
from maviper.verification.exports.vnnlib import networks, vnnlib_files
from tests.support.queries import true
from tests.support.strategies import with_trees
from tests.support.teams import LEFT, RIGHT, STAY, team, towards, tree
from tests.support.verifying import run
from verify.claims.catalogue import find_claim
from verify.claims.formula import Acts, Not, below, disjunction
from verify.claims.region import Region
from verify.claims.uncertified.own import OwnFormula
from verify.claims.uncertified.starts import everywhere
from verify.question import Question
from verify.semantics import REAL
from verify.states.real import measure_feature
from verify.states.state import State, inside, sample, violates
from verify.subjects import Game


def values(question, state):
    """What the variables of a query are in a world state: by the meanings and the trees, not by the query."""
    exact = state.exactly(question.profile)
    at = {("W", (place,)): value for place, value in enumerate(exact.values())}
    for number_, policy in enumerate(question.team):
        seen = [measure_feature(feature.meaning, exact, Fraction(0)) for feature in policy.features]
        at |= {(f"X_{number_}", (0, place)): Fraction(value) for place, value in enumerate(seen)}
        node = ir.ROOT
        while (feature := policy.tree.feature[node]) != ir.NO_FEATURE:
            left = seen[feature] <= Fraction(float(policy.tree.threshold[node]))
            node = policy.tree.left[node] if left else policy.tree.right[node]
        at[f"Y_{number_}", (0,)] = Fraction(int(policy.tree.action[node]))
    return at


def states(question, count, seed):
    """World states of the region, some with coordinates that coincide, and some outside."""
    wide = Region({name: (low - 1, high + 1) for name, (low, high) in question.region.box.items()}, question.goals)
    rng = np.random.default_rng(seed)
    for region in (question.region, wide):
        if question.goals == (None,):
            region = Region(region.box, ())
        coordinates, goals = sample(region, question.profile.world, count, seed)
        names = question.profile.world.coordinates()
        for row, goal in zip(np.round(coordinates * 8) / 8, goals, strict=True):
            position = {name: float(row[names.index(name)]) for name in region.box}
            name = question.profile.world.landmarks[goal].name if region.goals else None
            yield State(position, name)
            some = list(position)
            position[some[rng.integers(len(some))]] = position[some[rng.integers(len(some))]]
            yield State(position, name)


def questions(profile):
    """A proved one and violated ones, over several regions."""
    same = team(profile, towards(0, 0), towards(0, 1))
    start = everywhere(profile)
    cut = Region(
        start.box,
        start.goals[:1],
        (("agent_0.x", "agent_1.x", (Fraction(-1, 3), Fraction(2, 3))),),
        (("agent_0", "agent_1", Fraction(1, 7)),),
    )
    lone = disjunction(Not(Acts("agent_0", LEFT)), below({"agent_0.x": 3, "landmark_0.x": -1}, Fraction(1, 3), True))
    return [
        Question(
            Game(team(profile, towards(0, 0), towards(1, 1))), find_claim("distinct_targets", profile), start, REAL
        ),
        Question(Game(same), find_claim("distinct_targets", profile), cut, REAL),
        Question(Game(same), find_claim("aligned", profile), cut, REAL),
        Question(Game(same), OwnFormula("defenders", Fraction(0), Fraction(1, 10), statement=lone), start, REAL),
    ]


def test_a_query_holds_where_the_claim_fails_in_the_region(profile):
    failing = 0
    for question in questions(profile):
        for goal in question.goals:
            (text,) = [
                text
                for name, text in vnnlib_files([question]).items()
                if name.endswith(".vnnlib") and (goal or "no-goal") in name
            ]
            asked = vnnlib.parse_query_string(text)
            assert [network.name for network in asked.networks] == ["world", "agent_0", "agent_1"]
            for state in states(question.for_one_goal(goal), 60, 3):
                at = values(question, state)
                holds = all(true(assertion.expr, at) for assertion in asked.assertions)
                wanted = inside(question.for_one_goal(goal).region, state) and violates(question, state)
                assert holds == wanted, (question.claim, state)
                failing += holds
    assert failing > 100


def test_errors_of_features_are_within_their_bound(profile):
    """A feature may be off by eps and no more, each on its own."""
    steady = find_claim("steady", profile, of="distinct_targets", eps=Fraction(1, 100))
    question = Question(Game(team(profile, towards(0, 0), towards(1, 1))), steady, everywhere(profile), REAL)
    text = vnnlib_files([question])[f"01-{steady.name}-landmark_0.vnnlib"]
    asked = vnnlib.parse_query_string(text)
    readings = [each.expr for each in asked.assertions if "X_0 [0, 2]" in str(each)]
    state = next(states(question.for_one_goal("landmark_0"), 1, 0))
    for off, allowed in ((0, True), (Fraction(1, 100), True), (-Fraction(1, 100), True), (Fraction(11, 1000), False)):
        at = values(question, state)
        at["X_0", (0, 2)] += off
        assert all(true(reading, at) for reading in readings) == allowed


@pytest.mark.parametrize("function", ["sign", "positive", "zero"])
def test_functions_of_sums(profile, function):
    """What the features of signs are, in states on both sides and on the boundary."""
    policy = profile.policy("agent_0")
    meaning = ir.Meaning(policy.features[2].meaning.terms, function)
    features = tuple(
        ir.FeatureSpec(each.name, each.unit, each.low, each.high, meaning if place == 2 else each.meaning)
        for place, each in enumerate(policy.features)
    )
    made = with_trees({"agent_0": tree((2, 0.5, 1, 2), LEFT, RIGHT), "agent_1": tree(STAY)}, profile)
    agents = [replace(each, features=features) if each.agent == "agent_0" else each for each in made.agents]
    made = replace(made, agents=tuple(agents))
    claim = OwnFormula("defenders", Fraction(0), Fraction(1, 10), statement=Acts("agent_0", LEFT))
    question = Question(Game(made), claim, everywhere(made), REAL)
    asked = vnnlib.parse_query_string(vnnlib_files([question])["01-formula-landmark_0.vnnlib"])
    seen = set()
    for state in states(question.for_one_goal("landmark_0"), 60, 1):
        at = values(question, state)
        holds = all(true(assertion.expr, at) for assertion in asked.assertions)
        assert holds == (inside(question.for_one_goal("landmark_0").region, state) and violates(question, state))
        value = at["X_0", (0, 2)]
        seen.add(value)
        for other in (-1, 0, 1):
            at["X_0", (0, 2)] = Fraction(other)
            reading = all(true(each.expr, at) for each in asked.assertions if "X_0 [0, 2]" in str(each))
            assert reading == (other == value)
    assert seen == ({-1, 0, 1} if function == "sign" else {0, 1})


def test_the_networks_are_the_trees(profile):
    made = networks(profile)
    world = onnxruntime.InferenceSession(made["physical_deception_world.onnx"])
    row = np.arange(len(profile.world.coordinates()), dtype=np.float64)
    assert np.array_equal(world.run(None, {"W": row})[0], row)
    for policy in profile.agents:
        session = onnxruntime.InferenceSession(made[f"physical_deception_{policy.agent}.onnx"])
        observed = np.random.default_rng(0).uniform(-1, 1, (500, len(policy.features))).astype(np.float32)
        assert np.array_equal(session.run(["action"], {"x": observed})[0], ir.act(policy, observed))


def test_the_command_writes_queries_and_networks(profile, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "same.json").write_text(policy_json.dumps(team(profile, towards(0, 0), towards(0, 1))))
    claims = ["--property", "no_double", "--property", "reaches", "--steps", "2"]
    code, out, err = run(capsys, "verify", "same.json", *claims, "--vnnlib", "queries", "--verdict-only")
    assert "not exported: reaches" in out + err
    names = {path.name for path in (tmp_path / "queries").iterdir()}
    assert names == {
        "01-no_double-landmark_0.vnnlib",
        "01-no_double-landmark_1.vnnlib",
        *(f"physical_deception_{name}.onnx" for name in ("adversary_0", "agent_0", "agent_1", "world")),
    }
    text = (tmp_path / "queries" / "01-no_double-landmark_1.vnnlib").read_text()
    assert "goal landmark_1" in text
    vnnlib.parse_query_string(text)
    code, out, err = run(capsys, "verify", "same.json", "--property", "reaches", "--steps", "2", "--vnnlib", "none")
    assert code == 2 and "--vnnlib" in err
