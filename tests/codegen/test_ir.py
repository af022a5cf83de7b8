"""The IR: reference semantics and the checker."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given

from codegen import ir
from codegen.errors import ProfileError
from codegen.profiles import check, ensure
from codegen.world import RegionSpec
from maviper.verification.files.states import blank
from maviper.worlds import WORLDS, find
from tests.support.strategies import WORLD, grown_trees

STUMP = ir.Tree([0, -1, -1], [0.5, 0, 0], [1, -1, -1], [2, -1, -1], [-1, 1, 2])


def defender(tree: ir.Tree) -> ir.AgentPolicy:
    return ir.AgentPolicy("agent_0", "defenders", WORLD.features[1], WORLD.actions[1], tree)


def rows(*values):
    obs = np.zeros((len(values), 10), dtype=np.float32)
    obs[:, 0] = values
    return obs


def test_left_iff_at_most_the_threshold_and_nan_goes_right():
    above = np.nextafter(np.float32(0.5), np.float32(1))
    obs = rows(0.5, above, np.nan, np.inf, -np.inf)
    assert ir.act(defender(STUMP), obs).tolist() == [1, 2, 2, 2, 1]


def test_doubles_are_rounded_to_float32_first():
    assert ir.act(defender(STUMP), rows(0).astype(np.float64) + 0.5 + 1e-9).tolist() == [1]


def walk(tree, x):
    node = 0
    while tree.feature[node] != ir.NO_FEATURE:
        node = tree.left[node] if x[tree.feature[node]] <= tree.threshold[node] else tree.right[node]
    return int(node)


@given(grown_trees())
def test_apply_is_a_walk(tree):
    obs = np.random.default_rng(0).uniform(-2, 2, (50, 10)).astype(np.float32)
    assert ir.apply(tree, obs).tolist() == [walk(tree, x) for x in obs]


def test_arrays_cannot_be_changed():
    with pytest.raises(ValueError, match="read-only"):
        STUMP.threshold[0] = 1


def broken(**arrays):
    columns = {name: getattr(STUMP, name).copy() for name in ("feature", "threshold", "left", "right", "action")}
    for name, value in arrays.items():
        columns[name] = np.array(value)
    return ir.Tree(**columns)


@pytest.mark.parametrize(
    ("tree", "path", "message"),
    [
        (broken(feature=[10, -1, -1]), "tree[0].feature", "below 10"),
        (broken(feature=[-2, -1, -1]), "tree[0].feature", "below 10"),
        (broken(threshold=[np.nan, 0, 0]), "tree[0].threshold", "finite"),
        (broken(threshold=[np.inf, 0, 0]), "tree[0].threshold", "finite"),
        (broken(left=[3, -1, -1]), "tree[0].left, right", "1 to 2"),
        (broken(left=[0, -1, -1]), "tree[0].left, right", "1 to 2"),
        (broken(left=[2, -1, -1]), "tree[2]", "preorder"),
        (broken(left=[1, -1, -1], right=[1, -1, -1]), "tree[1]", "twice"),
        (broken(left=[2, -1, -1], right=[1, -1, -1]), "tree[2]", "preorder"),
        (broken(right=[2, 2, -1]), "tree[1].left, right", "leaf has no children"),
        (broken(action=[0, 1, 2]), "tree[0].action", "split has no action"),
        (broken(action=[-1, 5, 2]), "tree[1].action", "0 to 4"),
        (broken(action=[-1, 1]), "tree", "different lengths"),
    ],
)
def test_each_broken_invariant_is_named_with_its_path(tree, path, message, profile):
    agents = tuple(replace(p, tree=tree, grown=None) if p.agent == "agent_0" else p for p in profile.agents)
    found = check(replace(profile, agents=agents))
    assert any(item.path == f"$.agents[1].{path}" and message in item.message for item in found), found


@pytest.mark.parametrize(
    ("change", "path"),
    [
        ({"contact_force": np.inf}, "$.world.contact_force"),
        ({"contact_margin": np.nan}, "$.world.contact_margin"),
        ({"agents": {"start": (1.0, -1.0)}}, "$.world.agents[0].start_box"),
        ({"landmarks": {"start": (np.nan, 1.0)}}, "$.world.landmarks[0].start_box"),
        ({"landmarks": {"start": (0.0, np.inf)}}, "$.world.landmarks[0].start_box"),
        ({"landmarks": {"size": np.inf}}, "$.world.landmarks[0].size"),
        ({"landmarks": {"size": -0.1}}, "$.world.landmarks[0].size"),
        ({"agents": {"max_speed": 0.0}}, "$.world.agents[0].max_speed"),
        ({"agents": {"max_speed": np.nan}}, "$.world.agents[0].max_speed"),
        ({"contact_force": -1.0, "contact_margin": 1.0}, "$.world.contact_force"),
        ({"contact_force": 1.0, "contact_margin": 1e-320}, "$.world.contact_margin"),
        ({"contact_margin": -1.0}, "$.world.contact_margin"),
        ({"dt": -0.1}, "$.world.dt"),
        ({"dt": np.nan}, "$.world.dt"),
        ({"damping": 1.5}, "$.world.damping"),
        ({"damping": -0.25}, "$.world.damping"),
        ({"damping": np.nan}, "$.world.damping"),
        ({"start_low": 1.0, "start_high": -1.0}, "$.world.start_low"),
        ({"start_low": np.nan}, "$.world.start_low"),
        ({"start_high": np.inf}, "$.world.start_high"),
        ({"episode_steps": 0}, "$.world.episode_steps"),
        ({"agents": {"force": -5.0}}, "$.world.agents[0].force"),
        ({"landmarks": {"force": -5.0}}, "$.world.landmarks[0].force"),
        ({"agents": {"force": np.nan}}, "$.world.agents[0].force"),
        ({"agents": {"size": np.nan}}, "$.world.agents[0].size"),
        ({"agents": {"max_speed": np.inf}}, "$.world.agents[0].max_speed"),
    ],
)
def test_each_broken_rule_of_the_world_is_named_with_its_path(change, path, profile):
    for group in ("agents", "landmarks"):
        if group in change:
            first, *rest = getattr(profile.world, group)
            change = {group: (replace(first, **change[group]), *rest)}
    found = check(replace(profile, world=replace(profile.world, **change)))
    assert [item.path for item in found] == [path], found


MEANINGS = [
    ir.Meaning((), "sign"),  # always 0 has one spelling
    ir.Meaning((), "positive"),
    ir.Meaning((), "zero"),
    ir.Meaning(((1, "agent_0.x"),), "cosine"),
    ir.Meaning(((0.3, "agent_0.x"),)),  # its product would be rounded
    ir.Meaning(((0.5, "agent_0.x"),), "sign"),
]
RANGES = [(np.nan, 1.0), (0.0, np.nan), (1.0, -1.0), (-np.inf, 0.0), (0.0, 1e10)]


@pytest.mark.parametrize(
    ("group", "change", "path"),
    [
        *(("features", {"meaning": meaning}, "features[0].meaning") for meaning in MEANINGS),
        *(("features", {"low": low, "high": high}, "features[0]") for low, high in RANGES),
        *(("actions", {"effect": (0.0, part)}, "actions[0].effect") for part in (np.nan, -np.inf, 1e10)),
    ],
)
def test_each_broken_rule_of_a_feature_or_an_action_is_named_with_its_path(group, change, path, profile):
    first, policy, *rest = profile.agents
    one, *others = getattr(policy, group)
    changed = replace(policy, **{group: (replace(one, **change), *others)})
    found = check(replace(profile, agents=(first, changed, *rest)))
    assert [item.path for item in found] == [f"$.agents[1].{path}"], found


def test_a_region_has_doubles_within_its_bounds(profile):
    """Code compares doubles, and none is a third."""
    for bounds in (("1/3", "1/3"), ("0.1", "0.10000000000000000001")):
        region = RegionSpec(profile.world.goals, {"agent_0.x": bounds})
        found = check(replace(profile, region=region))
        assert [item.path for item in found] == ["$.region.box.agent_0.x"] and "no double" in found[0].message
    for bounds in (("0", "0"), ("0.25", "0.25"), ("1/3", "2/3"), ("-1", "0")):
        assert check(replace(profile, region=RegionSpec(profile.world.goals, {"agent_0.x": bounds}))) == ()


VARIANTS = [
    *WORLDS, "physical-deception,velocity=1", "physical-deception,defenders=4", "physical-deception,defenders=1",
    "physical-deception,features=goal+differences+signs", "cooperative-navigation,agents=24",
    "cooperative-navigation,agents=2,features=signs", "predator-prey,observation=mpe2",
    "predator-prey,observation=released,prey=1", "predator-prey,predators=3,prey=1,obstacles=0",
]  # fmt: skip


@pytest.mark.parametrize("name", VARIANTS)
def test_every_world_keeps_the_rules(name):
    world = find(name)
    assert check(blank(world)) == ()


def test_a_start_region_may_be_a_point(profile):
    landmarks = tuple(replace(entity, start=(0.5, 0.5)) for entity in profile.world.landmarks)
    assert check(replace(profile, world=replace(profile.world, landmarks=landmarks))) == ()


def test_all_violations_are_reported_at_once(profile):
    tree = broken(feature=[10, -1, -1], threshold=[np.nan, 0, 0])
    agents = tuple(replace(policy, tree=tree) for policy in profile.agents)
    with pytest.raises(ProfileError) as error:
        ensure(replace(profile, agents=agents), "x.json")
    assert str(error.value).count("tree[0].threshold") == 3


def test_names_must_stay_apart_after_folding(profile):
    actions = (*profile.agents[0].actions[:4], ir.ActionSpec("LEFT", None))
    agents = (replace(profile.agents[0], actions=actions), *profile.agents[1:])
    assert any("appears twice" in item.message for item in check(replace(profile, agents=agents)))


def test_trees_have_a_greatest_depth(profile):
    n = ir.MAX_DEPTH + 1
    feature = [0] * n + [-1] * (n + 1)
    left = [*range(1, n + 1)] + [-1] * (n + 1)
    right = [2 * n - node for node in range(n)] + [-1] * (n + 1)
    action = [-1] * n + [0] * (n + 1)
    tree = ir.Tree(feature, np.zeros(2 * n + 1), left, right, action)
    agents = (replace(profile.agents[0], tree=tree, grown=None), *profile.agents[1:])
    assert [item.message for item in check(replace(profile, agents=agents))] == ["deeper than 64 splits"]
