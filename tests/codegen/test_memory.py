"""Policies that remember: their decisions beside a machine of Python, their profiles, and what breaks a rule."""

import json
import random
import shutil
from dataclasses import replace

import numpy as np
import pytest

from codegen.agreement.selfcheck import check_files
from codegen.deciding import REMEMBERING
from codegen.errors import InputError, ProfileError
from codegen.importers.origin import motionless
from codegen.ir import ActionSpec, AgentPolicy, FeatureSpec, PolicyProfile, Provenance, Tree, Update
from codegen.memory import initial_memory, step_memory
from codegen.policy_json import dumps
from codegen.profiles import check, loads
from codegen.targets import TARGETS, emit
from maviper.team import Team


def make_heater() -> PolicyProfile:
    """Heats below 19 until above 21, and counts the calls since it began, up to 3."""
    t, on, count = range(3)
    rows = [
        (t, 19.0, 1, 4, -1),
        (on, 0.5, 2, 3, -1),
        (-1, 0.0, -1, -1, 2),  # begins
        (-1, 0.0, -1, -1, 1),
        (t, 21.0, 5, 10, -1),
        (on, 0.5, 6, 7, -1),
        (-1, 0.0, -1, -1, 0),
        (count, 2.5, 8, 9, -1),
        (-1, 0.0, -1, -1, 3),
        (-1, 0.0, -1, -1, 1),
        (-1, 0.0, -1, -1, 4),
    ]
    tree = Tree(*np.array(rows).T)
    actions = (
        ActionSpec("off", None),
        ActionSpec("heat", None),
        ActionSpec("heat_begin", None, acts="heat", updates=(Update("on", False, 1), Update("count", False, 0))),
        ActionSpec("heat_count", None, acts="heat", updates=(Update("count", True, 1),)),
        ActionSpec("off_end", None, acts="off", updates=(Update("on", False, 0),)),
    )
    features = (
        FeatureSpec("t", "K", -50.0, 50.0, None),
        FeatureSpec("on", "none", 0.0, 1.0, None, 0),
        FeatureSpec("count", "none", 0.0, 3.0, None, 3),
    )
    policy = AgentPolicy("heater", "team", features, actions, tree)
    return PolicyProfile(motionless("room", "", ["heater"]), (policy,), Provenance("imported", "none", 0, "", "test"))


class Heater:
    """The same in Python."""

    def __init__(self) -> None:
        self.on, self.count = False, 3

    def act(self, t: float) -> str:
        if t <= 19:
            if not self.on:
                self.count = 0
            self.on = True
        elif t <= 21:
            if self.on and self.count < 3:
                self.count += 1
        else:
            self.on = False
        return "heat" if self.on else "off"


def test_a_team_remembers_until_it_is_reset() -> None:
    team, rng = Team.of(loads(dumps(make_heater()))), random.Random(0)
    for _ in range(20):
        team.reset()
        by_hand, t = Heater(), rng.uniform(15, 25)
        for _ in range(200):
            t += rng.uniform(-1, 1)
            seen = float(np.float32(t))
            assert team.act({"heater": [seen]}) == {"heater": ["off", "heat"].index(by_hand.act(seen))}


def test_what_is_remembered_is_said_for_many_states_at_once() -> None:
    policy = make_heater().agents[0]
    states = np.array([[on, count] for on in (0, 1) for count in range(4) for _ in range(5)])
    temperatures = np.tile(np.array([[18.0], [19.0], [20.0], [21.0], [22.0]]), (8, 1))
    actions, after = step_memory(policy, states, temperatures)
    for (on, count), (t,), action, known in zip(states, temperatures, actions, after, strict=True):
        by_hand = Heater()
        by_hand.on, by_hand.count = bool(on), int(count)
        assert ["off", "heat"][action] == by_hand.act(t) and known.tolist() == [by_hand.on, by_hand.count]
    assert initial_memory(policy).tolist() == [0, 3]


def test_a_profile_with_memory_has_a_schema_of_its_own() -> None:
    text = dumps(make_heater())
    assert json.loads(text)["schema_version"] == 3 and "after a reset" in json.loads(text)["semantics"]
    assert dumps(loads(text)) == text
    with pytest.raises(ProfileError, match="schema version"):
        loads(text.replace('"schema_version": 3', '"schema_version": 1'))


def test_rules_say_what_is_remembered() -> None:
    told = Team.of(make_heater()).to_text()
    assert "remembers on, 0 to 1, 0 after a reset" in told
    assert "if t <= 19 and on <= 0 -> heat, on := 1, count := 0  (leaf 2)" in told
    assert "-> heat, count += 1" in told


LANGUAGES = {
    "c": ("room.h", "c machine"),
    "python": ("room.py", "python machine"),
    "javascript": ("room.mjs", "javascript machine"),
    "json": ("room_reader.py", "json reader machine"),
    "st": ("room_heater.st", "st machine"),
}
MISTAKES = {
    "st": [("count + 1", "count + 2"), ("DINT := 3", "DINT := 2"), ("act := 0", "act := 1"), ("on <= 0", "on <= 1")],
    "c": [("count += 1", "count += 2"), ("state->on = 0", "state->on = 1"), ("state->count = 3", "state->count = 2")],
    "python": [("count += 1", "count += 2"), ("int = 3", "int = 2"), ("action = 0", "action = 1")],
    "javascript": [("count += 1", "count += 2"), ("count = 3", "count = 2"), ("return 0; // off", "return 1; // off")],
    "json": [('how == "add"', 'how == "set"'), ('each["initial"] for', "0 for"), ("self.taken[action]", "action")],
}


@pytest.mark.compile
@pytest.mark.parametrize("target", LANGUAGES)
def test_code_remembers_like_the_policy_and_a_mistake_is_seen(target: str) -> None:
    profile, (file, compared) = make_heater(), LANGUAGES[target]
    if target == "javascript" and shutil.which("node") is None:
        pytest.skip("Node.js is not installed")
    files = emit(profile, [target])
    for before, after in [("", ""), *MISTAKES[target]]:
        text = str(files[file])
        assert before in text
        found = check_files(profile, {**files, file: text.replace(before, after, 1) if before else text}, random=100)
        (machine,) = (each for each in found.agreements if each.target == compared)
        assert machine.observations > 100_000 and bool(machine.differences) == bool(before), (target, before)


@pytest.mark.parametrize("target", [each for each in TARGETS if each not in REMEMBERING])
def test_a_target_without_memory_says_so(target: str) -> None:
    with pytest.raises(InputError, match="does not take memory yet"):
        emit(make_heater(), [target])


def change(group: str, place: int, **values: object) -> PolicyProfile:
    """The heater with another feature or action."""
    profile = make_heater()
    (policy,) = profile.agents
    specs = list(getattr(policy, group))
    specs[place] = replace(specs[place], **values)
    return replace(profile, agents=(replace(policy, **{group: tuple(specs)}),))


@pytest.mark.parametrize(
    ("profile", "said"),
    [
        (change("features", 2, high=2.0), "low <= initial <= high"),
        (change("features", 1, high=0.5), "whole numbers"),
        (change("features", 1, initial=None), "each names one thing"),
        (change("features", 2, initial=None), "come last"),
        (change("features", 0, initial=0, low=0.0), "some are observed"),
        (change("actions", 2, acts="cool"), "acts names an action"),
        (change("actions", 2, acts=""), "acts names an action"),
        (change("actions", 2, updates=()), "acts names an action"),
        (change("actions", 0, acts="heat", updates=(Update("on", False, 1),)), "come first"),
        (change("actions", 2, updates=(Update("on", False, 2),)), "lies in its range"),
        (change("actions", 2, updates=(Update("on", False, 1), Update("on", False, 0))), "each names one thing"),
        (change("actions", 3, updates=(Update("count", True, 0),)), "adds 0"),
        (change("actions", 3, updates=(Update("count", True, 2),)), "may leave its range"),
        (change("actions", 1, effect=(0.0, 1.0)), "no outputs, effects or masks"),
    ],
)
def test_a_broken_rule_about_memory_is_named(profile: PolicyProfile, said: str) -> None:
    assert any(said in each.message for each in check(profile)), check(profile)
    assert not check(make_heater())
