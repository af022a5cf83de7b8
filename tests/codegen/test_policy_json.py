"""The JSON form: round trip, schema, and the path of every fault."""

import json

import jsonschema
import pytest
from hypothesis import given

from codegen import ir, policy_json, profiles
from codegen.errors import ProfileError
from codegen.profiles import check, schema
from tests.support import strategies
from tests.support.games import NAMES, random_profile


@given(strategies.profiles())
@pytest.mark.smoke
def test_round_trip_keeps_every_byte(profile):
    text = policy_json.dumps(profile)
    again = profiles.loads(text)
    assert policy_json.dumps(again) == text
    assert policy_json.content_hash(again) == policy_json.content_hash(profile)
    for before, after in zip(profile.agents, again.agents, strict=True):
        assert before.tree.threshold.tobytes() == after.tree.threshold.tobytes()
        assert before.grown is not None and after.grown is not None
        assert before.grown.threshold.tobytes() == after.grown.threshold.tobytes()
        assert before.features == after.features and before.actions == after.actions
    assert again.world == profile.world


@pytest.mark.parametrize("name", NAMES)
def test_every_game_reads_back(name):
    """Contacts, start regions, options and every kind of meaning."""
    profile = random_profile(name)
    assert check(profile) == ()
    text = policy_json.dumps(profile)
    jsonschema.validate(json.loads(text), schema())
    again = profiles.loads(text)
    assert policy_json.dumps(again) == text and again.world == profile.world
    assert [policy.features for policy in again.agents] == [policy.features for policy in profile.agents]
    assert again.world.options == profile.world.options


MEANINGS = {
    "0": ir.Meaning(()),
    "agent_0.vx": ir.Meaning(((1, "agent_0.vx"),)),
    "- goal.x + agent_1.y": ir.Meaning(((-1, "goal.x"), (1, "agent_1.y"))),
    "sign(goal.x - agent_0.x)": ir.Meaning(((1, "goal.x"), (-1, "agent_0.x")), "sign"),
    "sign(agent_0.x)": ir.Meaning(((1, "agent_0.x"),), "sign"),
    "positive(goal.x - agent_0.x)": ir.Meaning(((1, "goal.x"), (-1, "agent_0.x")), "positive"),
    "positive(- agent_0.vy)": ir.Meaning(((-1, "agent_0.vy"),), "positive"),
    "goal.x - agent_0.x - 0.25*agent_0.vx": ir.Meaning(((1, "goal.x"), (-1, "agent_0.x"), (-0.25, "agent_0.vx"))),
    "- 2*goal.x + 64*goal.y": ir.Meaning(((-2, "goal.x"), (64, "goal.y"))),
    "agent_0.x + agent_1.x - landmark_0.x": ir.Meaning(((1, "agent_0.x"), (1, "agent_1.x"), (-1, "landmark_0.x"))),
}


@pytest.mark.parametrize("text", MEANINGS)
def test_meanings_read_back(profile, text):
    document = json.loads(edited(profile, ["agents", 1, "features", 0, "meaning"], text))
    del document["content_hash"]
    again = profiles.loads(json.dumps(document))
    assert again.agents[1].features[0].meaning == MEANINGS[text]
    assert json.loads(policy_json.dumps(again))["agents"][1]["features"][0]["meaning"] == text
    assert profiles.loads(policy_json.dumps(again)).agents[1].features == again.agents[1].features


@pytest.mark.parametrize(
    "text",
    ["", " ", "positive()", "sign()", "sign(goal.x", "positive(goal.x", "positiv(goal.x)", "sign(positive(goal.x))",
     "0 + goal.x", "0.0", "00", "goal.x)", "positive(goal.z)", "sign(goal.x)\n", "SIGN(goal.x)"],
)  # fmt: skip
def test_other_meanings_are_refused_with_the_path(profile, text):
    with pytest.raises(ProfileError) as error:
        profiles.loads(edited(profile, ["agents", 1, "features", 0, "meaning"], text), "x.json")
    assert "x.json: $.agents[1].features[0].meaning" in str(error.value)


def edited(profile, path, value):
    document = json.loads(policy_json.dumps(profile))
    here = document
    for key in path[:-1]:
        here = here[key]
    if value is KeyError:
        del here[path[-1]]
    else:
        here[path[-1]] = value
    return json.dumps(document)


FAULTS = [
    (["agents", 1, "tree", 0, "threshold"], "abc", "$.agents[1].tree[0].threshold"),
    (["agents", 1, "tree", 0, "threshold"], 0.123, "$.agents[1].tree[0].threshold"),
    (["agents", 1, "tree", 0, "float32"], "zzz", "$.agents[1].tree[0].float32"),
    (["agents", 1, "tree", 0, "float32"], "0x1.000000001p+0", "$.agents[1].tree[0].float32"),
    (["agents", 1, "tree", 0, "left"], KeyError, "$.agents[1].tree[0]"),
    (["agents", 1, "tree", 0, "left"], 2**40, "$.agents[1].tree[0]"),
    (["agents", 1, "tree", 0, "left"], 0, "$.agents[1].tree[0].left"),
    (["agents", 1, "tree", 0, "feature"], "goal_dz", "$.agents[1].tree[0].feature"),
    (["agents", 1, "features", 0, "meaning"], "goal.x minus", "$.agents[1].features[0].meaning"),
    (["agents", 1, "features", 0, "meaning"], "goal.z - agent_0.x", "$.agents[1].features[0].meaning"),
    (["agents", 1, "features", 0, "range"], [1, -1], "$.agents[1].features[0]"),
    (["agents", 1, "agent"], "agent_7", "$.agents[1].agent"),
    (["agents", 1, "grown", "action", 0], 99, "$.agents[1].grown[0].action"),
    (["agents", 1, "grown", "action", -1], 2**32, "$.agents[1].grown: a number is out of range"),
    (["agents", 1, "grown", "left", 0], 2**32 + 1, "$.agents[1].grown: a number is out of range"),
    (["agents", 1, "features", 0, "range"], [-1e300, 1e300], "$.agents[1].features[0]"),
    (["world", "start_box"], [-1e308, 1e308], "$.world.start_low"),
    (["world", "landmarks", 0, "name"], "agent_0", "$.world.landmarks[0]"),
    (["world", "agents", 0, "name"], "goal", "$.world.agents[0]"),
    (["world", "dt"], KeyError, "$.world"),
    (["world", "extra"], 1, "$.world"),
    (["world", "contact_force"], 1e300, "$.world.contact_force"),
    (["world", "contact_force"], "much", "$.world.contact_force"),
    (["world", "contact_margin"], -1e300, "$.world.contact_margin"),
    (["world", "contact_margin"], KeyError, "$.world: Object missing required field `contact_margin`"),
    (["world", "options"], KeyError, "$.world: Object missing required field `options`"),
    (["world", "options"], {"prey": 1.5}, "$.world.options"),
    (["world", "options"], [], "$.world.options"),
    (["world", "agents", 0, "start_box"], KeyError, "$.world.agents[0]"),
    (["world", "agents", 0, "start_box"], [1, -1], "$.world.agents[0].start_box"),
    (["world", "landmarks", 1, "start_box"], [1], "$.world.landmarks[1].start_box"),
    (["world", "landmarks", 1, "start_box"], [-1e300, 0], "$.world.landmarks[1].start_box"),
    (["world", "contact_margin"], 1.0, "$.content_hash"),
    (["world", "options"], {"prey": 1}, "$.content_hash"),
    (["world", "landmarks", 0, "start_box"], [-0.5, 0.5], "$.content_hash"),
    (["world", "goals", 0], "landmark_9", "$.world.goals[0]"),
    (["schema_version"], 2, "$.schema_version"),
    (["semantics"], "round to nearest", "$.semantics"),
    (["world", "damping"], 0.5, "$.content_hash"),
    (["provenance", "seed"], 12345, "$.content_hash"),
]


@pytest.mark.parametrize(("path", "value", "where"), FAULTS)
def test_an_edited_profile_is_refused_with_the_path(profile, path, value, where):
    with pytest.raises(ProfileError) as error:
        profiles.loads(edited(profile, path, value), "x.json")
    assert f"x.json: {where}" in str(error.value)


def test_a_misspelt_feature_gets_its_closest_match(profile):
    text = edited(profile, ["agents", 1, "tree", 0, "feature"], "landmark_0_dz")
    with pytest.raises(ProfileError, match="did you mean 'landmark_0_d"):
        profiles.loads(text)


def test_an_edit_made_on_purpose_drops_the_hash(profile):
    document = json.loads(edited(profile, ["world", "damping"], 0.5))
    del document["content_hash"]
    assert profiles.loads(json.dumps(document)).world.damping == 0.5


@pytest.mark.parametrize("text", [b"\xff\xfe", b"[" * 100_000, b"null", b"{}", b"[]", b'"profile"', b"1e999"])
@pytest.mark.smoke
def test_what_is_not_a_profile_is_refused(text):
    with pytest.raises(ProfileError):
        profiles.loads(text)


def test_a_node_is_one_line(profile):
    text = policy_json.dumps(profile)
    assert text.count('"float32"') == sum(1 for line in text.splitlines() if '"float32"' in line)
    assert sum(len(policy.tree.feature) for policy in profile.agents) == sum(
        1 for line in text.splitlines() if line.strip().startswith(('{"feature"', '{"action"'))
    )


def test_every_value_of_the_profile_is_under_the_hash(profile):
    from dataclasses import replace

    other = replace(profile, world=replace(profile.world, dt=0.2))
    assert policy_json.content_hash(other) != policy_json.content_hash(profile)
    policy = profile.agents[0]
    action = policy.tree.action.copy()
    leaf = ir.leaves(policy.tree)[0]
    action[leaf] = (action[leaf] + 1) % 5
    changed = replace(policy, tree=replace(policy.tree, action=action))
    assert policy_json.content_hash(
        replace(profile, agents=(changed, *profile.agents[1:]))
    ) != policy_json.content_hash(profile)


def test_a_truncated_profile_is_told_with_the_path(profile):
    text = policy_json.dumps(profile)
    cut = text.index('"tree"', text.index('"agent": "agent_1"'))
    third = cut + [match for match in range(len(text) - cut) if text[cut + match] == "{"][2]
    told = r"x\.json: \$\.agents\[2\]\.tree\[2\] \(line \d+\): Input data was truncated"
    with pytest.raises(ProfileError, match=told):
        profiles.loads(text[: third + 5], "x.json")
    with pytest.raises(ProfileError, match=r"\$\.world\.dt \(line \d+\): JSON is malformed"):
        profiles.loads(text.replace('"dt": 0.1', '"dt": zero'), "x.json")
