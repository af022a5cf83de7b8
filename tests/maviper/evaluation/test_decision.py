"""One decision explained: the leaf is the reference's, and each test turns where its room says."""

from dataclasses import replace

import numpy as np
import pytest

from codegen import ir
from codegen.errors import InputError
from codegen.observe import observe
from codegen.policy_json import dumps
from maviper.cli.main import run as command
from maviper.evaluation.show import lines, observation_of, observe_state, room
from verify.states.state import path


@pytest.fixture(scope="module")
def file(profile, tmp_path_factory):
    path = tmp_path_factory.mktemp("decision") / "profile.json"
    path.write_text(dumps(profile))
    return str(path)


def test_the_leaf_is_the_references_and_tests_turn_at_their_room(profile):
    rng = np.random.default_rng(0)
    for policy in profile.agents:
        for seen in rng.uniform(-2, 2, (200, len(policy.features))).astype(np.float32):
            leaf = int(ir.apply(policy.tree, seen[None])[0])
            met = path(policy, seen.tolist())
            assert leaf in (policy.tree.left[met[-1].node], policy.tree.right[met[-1].node])
            assert next(lines(policy, seen)).endswith(f"(leaf {leaf})")
            names = [feature.name for feature in policy.features]
            for test in met:
                turned = seen.astype(float)
                turned[names.index(test.feature)] += (room(test) + 1e-6) * (1 if test.left else -1)
                assert int(ir.apply(policy.tree, turned[None].astype(np.float32))[0]) != leaf


def test_an_observation_is_read_in_order_or_by_name(profile):
    policy = profile.agents[0]
    numbers = [0.25 * place for place in range(len(policy.features))]
    in_order = observation_of(policy, ",".join(map(str, numbers)))
    named = [f"{one.name}={number}" for one, number in zip(policy.features, numbers, strict=True)]
    assert (in_order == observation_of(policy, ", ".join(reversed(named)))).all()
    assert in_order.dtype == np.float32


def test_a_state_is_observed_as_everywhere(profile):
    names = [name for name in profile.world.coordinates() if not name.startswith("goal.")]
    rng = np.random.default_rng(1)
    given = dict(zip(names, rng.uniform(-1, 1, len(names)).tolist(), strict=True))
    goal = profile.world.goals[1]
    seen = observe_state(profile, ",".join([*(f"{name}={value!r}" for name, value in given.items()), f"goal={goal}"]))
    whole = given | {f"goal.{axis}": given[f"{goal}.{axis}"] for axis in "xy"}
    at = np.array([[whole[name] for name in profile.world.coordinates()]])
    for policy in profile.agents:
        assert (seen[policy.agent] == observe(policy.features, at, profile.world, policy.numbers)[0]).all()
        assert next(lines(policy, seen[policy.agent])).startswith(f"{policy.agent}, team {policy.team}: ")


@pytest.mark.parametrize(
    "text", ["1,2", "landmark_0_dx=1", "landmark_0_dx=one", "nobody=1", "1,two", "", "landmark_0_dx", "=1"]
)
def test_what_is_no_observation_is_refused(profile, text):
    with pytest.raises(InputError):
        observation_of(profile.agents[0], text)


def test_nan_is_said_to_fail_a_test_and_has_no_room(profile):
    policy = profile.agents[0]
    for line in list(lines(policy, np.full(len(policy.features), np.nan, np.float32)))[1:]:
        assert " = nan, not " in line and "by" not in line and ">" not in line.replace("not >", "")
    with pytest.raises(InputError, match=f"2 numbers for {len(policy.features)} features of {policy.agent}"):
        observation_of(policy, "1,2")


def test_without_meanings_no_coordinate_is_asked_for(profile):
    features = [replace(each, meaning=None) for each in profile.agents[0].features]
    bare = replace(profile, agents=(replace(profile.agents[0], features=tuple(features)), *profile.agents[1:]))
    with pytest.raises(InputError, match=rf"has no meaning(.|\n)*--agent {bare.agents[0].agent} --obs"):
        observe_state(bare, "speed=1")


@pytest.mark.parametrize("text", ["agent_0.x=0", "goal=nowhere", "agent_9.x=0", "agent_0.x", ""])
def test_what_is_no_state_is_refused(profile, text):
    with pytest.raises(InputError):
        observe_state(profile, text)


def test_the_command_explains_one_decision(file, capsys):
    assert command(["show", file, "--agent", "agent_0", "--obs", ",".join(["0.5"] * 10)]) == 0
    told = capsys.readouterr().out.splitlines()
    assert told[0].startswith("agent_0, team defenders: ") and all(", by " in line for line in told[1:])
    assert command(["show", file, "--obs", "1"]) == 2
    assert command(["show", file, "--agent", "agent_0", "--obs", "1", "--state", "agent_0.x=1"]) == 2
    assert command(["show", file, "--format", "html", "--agent", "agent_0"]) == 2
    assert "a page shows all agents" in capsys.readouterr().err
