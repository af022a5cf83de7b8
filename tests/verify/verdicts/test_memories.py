"""Where two controllers that remember do otherwise, against all that they remember beside each number they test."""

from dataclasses import replace

import numpy as np
import pytest

import maviper
from codegen import ir
from codegen.errors import InputError
from codegen.importers.c.source import from_c
from codegen.importers.origin import Names, motionless, profile_of
from codegen.importers.reading import Said
from codegen.ir import ActionSpec, AgentPolicy, FeatureSpec, PolicyProfile, Provenance, Tree, Update
from codegen.memory import step_memory
from codegen.profiles import check
from tests.support.remembering import HEATER, LIGHT, adding

FEATURES = (
    FeatureSpec("t", "K", -50.0, 50.0, None),
    FeatureSpec("on", "none", 0.0, 1.0, None, 0),
    FeatureSpec("count", "none", -1.0, 3.0, None, 2),
)
PLAIN = (ActionSpec("off", None), ActionSpec("heat", None))
UPDATES = (
    (Update("on", False, 1),),
    (Update("on", False, 0), Update("count", False, 2)),
    (Update("count", False, 3),),
    (Update("count", True, 1),),
    (Update("count", True, -2), Update("on", False, 1)),
)


def draw(rng):
    """A controller with random tests and actions, whose additions stay in the range."""
    chosen = [(act, each) for act in ("off", "heat") for each in UPDATES if rng.random() < 0.7]
    more = [ActionSpec(f"a{place}", None, acts=act, updates=each) for place, (act, each) in enumerate(chosen)]
    actions, rows = (*PLAIN, *more), list[list[float]]()

    def grow(level):
        at = len(rows)
        rows.append([-1, 0.0, -1, -1, int(rng.integers(len(actions)))])
        if level and rng.random() < 0.9:
            tested = int(rng.integers(3))
            limits = ([19.0, 20.0, 21.0], [0.0, 0.25, 0.5], [-1.0, -0.5, 0.0, 0.75, 1.0, 2.0, 2.75])[tested]
            rows[at] = [tested, float(rng.choice(limits)), at + 1, -1, -1]
            grow(level - 1)
            rows[at][3] = len(rows)
            grow(level - 1)

    grow(4)
    policy = AgentPolicy("heater", "team", FEATURES, actions, Tree(*np.array(rows).T))
    profile = PolicyProfile(motionless("room", "", ["heater"]), (policy,), Provenance("imported", "", 0, "", "test"))
    return draw(rng) if check(profile) else profile


def find_differing(first, second):
    """The pairs of leaves that do otherwise, of all memories beside all numbers that are tested."""
    limits = np.concatenate([p.agents[0].tree.threshold[p.agents[0].tree.feature == 0] for p in (first, second)])
    numbers = np.float32([-50, 50, *limits, *np.nextafter(limits, np.float32(np.inf))])
    rows = np.array([(t, on, count) for t in numbers for on in (0, 1) for count in range(-1, 4)], np.float32)
    told = [np.column_stack(step_memory(p.agents[0], rows[:, 1:], rows[:, :1])) for p in (first, second)]
    leaves = np.column_stack([ir.apply(p.agents[0].tree, rows) for p in (first, second)])
    return {tuple(pair) for pair in leaves[(told[0] != told[1]).any(axis=1)].tolist()}


@pytest.mark.solver
def test_zones_are_where_an_action_or_an_update_differs():
    rng, alike = np.random.default_rng(0), 0
    for number in range(24):
        first = draw(rng)
        second = draw(rng) if number % 3 else change(rng, first)
        wanted, compared = find_differing(first, second), maviper.diff(first, second)
        (facts,) = compared.facts["agents"]
        assert facts["complete"] or not wanted
        assert {tuple(zone["leaves"]) for zone in facts["zones"]} == wanted, number
        assert facts["verdict"] == ("VIOLATED" if wanted else "PROVED")
        alike += not wanted
        for zone in facts["zones"]:
            state = {name: float(value) for name, value in zone["example"]["position"].items()}
            row = [[state[each.name] for each in FEATURES]]
            assert row[0][1:] == [int(value) for value in row[0][1:]]
            told = [step_memory(p.agents[0], [row[0][1:]], [row[0][:1]]) for p in (first, second)]
            assert any((a != b).any() for a, b in zip(*told, strict=True)), (number, state)
    assert 3 <= alike <= 16


def change(rng, profile):
    """The controller, and what it keeps is set to what it is; or one test moved between two whole numbers."""
    (policy,) = profile.agents
    tree, threshold = policy.tree, policy.tree.threshold.copy()
    for node in np.flatnonzero(tree.feature > 0):
        threshold[node] = np.floor(threshold[node]) + rng.choice(np.float32([0, 0.125, 0.5, 0.875]))
    return replace(profile, agents=(replace(policy, tree=replace(tree, threshold=threshold)),))


def imported(source):
    return profile_of(from_c(source.encode(), "act.c", Said(run=False)), Names())


def test_what_is_set_to_what_it_is_makes_no_difference_and_an_update_alone_does():
    """The C never heats otherwise in that step, but goes on from another memory."""
    again = imported(HEATER.replace("(t > 21.0f)", "(t > 21.0f && heating)"))
    compared = maviper.diff(imported(HEATER), again)
    assert str(compared.verdict) == "PROVED" and compared.facts["agents"][0]["uniform"] is None
    other = imported(LIGHT.replace("else if (queue < 0.5f)", "else if (queue < 0.5f && s.waiting < 60)"))
    assert str(maviper.diff(imported(LIGHT), other).verdict) == "PROVED"  # it is never green with 60 who wait
    first = imported(LIGHT)
    other = imported(LIGHT.replace("s.green_for = 0; }", "s.green_for = 1; }"))
    (facts,) = maviper.diff(first, other).facts["agents"]
    assert facts["verdict"] == "VIOLATED"
    assert {action.partition(",")[0] for zone in facts["zones"] for action in zone["actions"]} == {"GREEN"}


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (
            ("heating = false;\n    if", "heating = true;\n    if"),
            "remembers different things: heating 0 to 1, 0 first",
        ),
        (("return heating", "return !heating && t < 5.0f ? 1 : heating"), ""),
        (("bool heating", "int heat"), "remembers different things: heating 0 to 1, 0 first and heat 0 to 1"),
    ],
)
def test_other_memories_are_refused_by_name(change, said):
    text = HEATER.replace(*change)
    other = imported(text if "int heat" not in text else text.replace("heating", "heat"))
    if said:
        with pytest.raises(InputError, match=said):
            maviper.diff(imported(HEATER), other)
    else:
        assert str(maviper.diff(imported(HEATER), other).verdict) == "PROVED"  # below 19 it heats


def test_memory_beside_sums_is_not_compared_yet():
    """Programs of real numbers would find differences where memory is no whole number."""
    with pytest.raises(InputError, match="sums or give numbers does not take memory"):
        maviper.diff(adding(imported(HEATER)), adding(imported(HEATER)))


def test_a_region_is_of_whole_numbers(tmp_path):
    other = imported(HEATER.replace("21.0f", "20.0f"))
    for bounds, verdict in (("[0.25, 1]", "VIOLATED"), ("[-0.5, 0.75]", "PROVED"), ("[0.25, 0.75]", None)):
        region = tmp_path / "region.toml"
        region.write_text(f"box = {{ t = [10, 30], heating = {bounds} }}\n")
        if verdict is None:
            with pytest.raises(InputError, match="no whole number is in the region"):
                maviper.diff(imported(HEATER), other, region)
        else:
            assert str(maviper.diff(imported(HEATER), other, region).verdict) == verdict
