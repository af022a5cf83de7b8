"""Names of imported features and actions: the source's own are kept, renamed or put in order, and never by position."""

import numpy as np
import pytest
from sklearn.tree import DecisionTreeClassifier

from codegen import ir, policy_json, profiles
from codegen.errors import InputError
from codegen.importers.names import actions_of, features_of, renaming
from codegen.importers.origin import Names, profile_of
from codegen.importers.python.source import from_python
from codegen.importers.scikit import from_sklearn

THERMOSTAT = "def thermostat(obs):\n    if obs[0] < 19.5: return 'on'\n    return 'off'\n"
CAR = "def car(obs):\n    if obs['gap'] < 30 and obs['speed'] > 1: return 'brake'\n    return 'go'\n"
MOUNTAIN = "def cart(obs):\n    position, velocity = obs\n    if velocity < 0: return 0\n    return 2\n"


def imported(text, **given):
    return profile_of(from_python(text.encode(), "policy.py"), Names(**given))


def taken(profile, *row):
    """The name of the action that the one agent takes."""
    (policy,) = profile.agents
    return policy.actions[int(ir.act(policy, [row])[0])].name


def actions(profile):
    return [(each.name, each.label) for each in profile.agents[0].actions]


# --- actions


@pytest.mark.parametrize("order", [None, ["off", "on"], ["on", "off"], ["OFF", "ON"]])
def test_the_order_that_is_given_changes_no_decision(order):
    profile = imported(THERMOSTAT, actions=order)
    assert (taken(profile, 18.0).lower(), taken(profile, 21.0).lower()) == ("on", "off")
    assert [name.lower() for name, _ in actions(profile)] == [each.lower() for each in order or ["on", "off"]]
    assert profile.provenance.training["thermostat actions"].startswith(f"0 {(order or ['on'])[0].lower()}")


def test_actions_are_renamed_by_their_old_names_and_keep_what_the_source_returns():
    profile = imported(THERMOSTAT, actions=["heat=on"])
    assert taken(profile, 18.0) == "heat" and actions(profile) == [("heat", "on"), ("off", "off")]
    assert profile.provenance.training["thermostat actions"] == "0 heat <- on, 1 off"
    assert profiles.loads(policy_json.dumps(profile)).agents[0].actions == profile.agents[0].actions


@pytest.mark.parametrize(
    ("given", "said"),
    [
        (["stop", "go"], "the source names its actions itself: on, off"),
        (["on"], "the source names its actions itself: on, off"),
        (["on", "off", "idle"], "the source names its actions itself: on, off"),
        (["heat=on", "off"], "some names are written new=old"),
        (["heat=on", "cool=on"], "one is renamed twice"),
        (["heat=om"], "unknown action 'om'"),
        (["x=on", "x=off"], "become the same action name, x"),
    ],
)
def test_other_names_are_refused(given, said):
    with pytest.raises(InputError) as caught:
        imported(THERMOSTAT, actions=given)
    assert said in caught.value.what and caught.value.next_step


def test_whole_numbers_are_the_places_of_their_actions():
    profile = imported(MOUNTAIN)
    assert actions(profile) == [("action_0", None), ("action_1", None), ("action_2", None)]
    assert int(ir.act(profile.agents[0], [[0, 0.1]])[0]) == 2
    assert profile.provenance.training["cart actions"] == "0 action_0 <- 0, 1 action_1 (no leaf), 2 action_2 <- 2"
    profile = imported(MOUNTAIN, actions=["left", "stay", "right"])
    assert taken(profile, 0, 0.1) == "right" and taken(profile, 0, -0.1) == "left"
    assert [name for name, _ in actions(imported(MOUNTAIN, actions=["coast=1"]))] == ["action_0", "coast", "action_2"]
    with pytest.raises(InputError, match="2 action names for the numbers 0 to 2"):
        imported(MOUNTAIN, actions=["left", "right"])


@pytest.mark.parametrize("classes", [[0, 2], [0.0, 2.0], ["0", "2"]])
def test_scikit_learns_classes_are_places_where_they_are_whole_numbers(classes):
    tree = DecisionTreeClassifier().fit([[-1], [1]], classes)
    policy = from_sklearn(tree).agents[0]
    assert (
        ir.act(policy, [[-1.0], [1.0]]).tolist() == [0, 2] == [int(float(each)) for each in tree.predict([[-1], [1]])]
    )


def test_names_of_the_sources_numbers_stay_with_them():
    text = f"LEFT = 0\nRIGHT = 2\n{MOUNTAIN}".replace("return 0", "return LEFT").replace("return 2", "return RIGHT")
    assert [name for name, _ in actions(imported(text))] == ["LEFT", "action_1", "RIGHT"]
    assert [name for name, _ in actions(imported(text, actions=["left", "stay", "right"]))] == ["left", "stay", "right"]
    assert [name for name, _ in actions(imported(text, actions=["west=LEFT"]))] == ["west", "action_1", "RIGHT"]
    with pytest.raises(InputError, match="the source calls the action 0 LEFT, not right"):
        imported(text, actions=["right", "stay", "left"])


@pytest.mark.parametrize(
    ("labels", "kept"),
    [
        ((-1, 0, 1), [-1, 0, 1]),
        ((0.5, 1.5), [0.5, 1.5]),
        ((0, 1000), [0, 1000]),
        (tuple(range(300)), [None] * 300),
        ((255,), [None] * 256),
        (("go left", "b"), ["go left", "b"]),
        (("a", "b"), [None, None]),
        ((0, 2**60), ["0", str(2**60)]),
        ((False, True), [None, None]),
        ((np.int64(0), np.int64(2)), [None] * 3),
    ],
)
def test_labels_are_kept_where_neither_place_nor_name_says_them(labels, kept):
    found = actions_of(labels, {}, renaming(None))
    assert list(found.labels) == kept
    for label, place in zip(labels, found.place, strict=True):
        assert found.labels[place] in (None, label, str(label)) and (
            found.labels[place] is not None or place == label or found.names[place] == label
        )


# --- features


def test_a_source_that_looks_features_up_takes_any_order_and_more_of_them():
    for order in (["speed", "gap"], ["gap", "speed"], ["speed", "noise", "gap"]):
        profile = imported(CAR, features=order)
        assert [each.name for each in profile.agents[0].features] == order
        for gap, speed, wanted in ((10, 2, "brake"), (2, 10, "brake"), (40, 2, "go"), (2, 0.5, "go")):
            row = [{"gap": gap, "speed": speed}.get(name, 99.0) for name in order]
            assert taken(profile, *row) == wanted


def test_parameters_keep_their_names_in_any_order():
    text = "def car(speed, gap):\n    if gap < 30: return 'brake'\n    return 'go'\n"
    assert taken(imported(text), 10, 99) == "go" and taken(imported(text, features=["gap", "speed"]), 10, 99) == "brake"
    renamed = imported(text, features=["v=speed"])
    assert [each.name for each in renamed.agents[0].features] == ["v", "gap"]
    assert renamed.provenance.training["car features"] == "0 v <- speed, 1 gap"
    for given in (["v", "d"], ["speed"], ["speed", "gap", "noise"]):
        with pytest.raises(InputError, match="the source names its features itself: speed, gap"):
            imported(text, features=given)


def test_names_that_are_numbers_alone_are_no_names():
    for own in (("x0", "x1"), ("Column_0", "Column_1"), ()):
        assert features_of(own, 2, renaming(["speed", "gap"])).names == ("speed", "gap")
        assert features_of(own, 2, renaming(["x1", "x0"])).place == ((1, 0) if own[:1] == ("x0",) else (0, 1))
    with pytest.raises(InputError, match="1 feature names for 2"):
        features_of((), 2, renaming(["a"]))
    with pytest.raises(InputError, match="names its features itself"):
        features_of(("x1", "x2"), 2, renaming(["a", "b"]))


def test_a_renaming_needs_one_agent_that_has_the_name():
    text = f"{THERMOSTAT}\n{CAR}"
    profile = imported(text, actions=["stop=brake"], features=["distance=gap"])
    assert [[each.name for each in policy.actions] for policy in profile.agents] == [["on", "off"], ["stop", "go"]]
    with pytest.raises(InputError, match="unknown feature 'gab'"):
        imported(text, features=["distance=gab"])
