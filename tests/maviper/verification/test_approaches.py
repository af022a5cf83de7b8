"""How near episodes come to the border of a claim: against what a sum by hand gives."""

from fractions import Fraction

import pytest

from codegen.errors import InputError
from codegen.importers.origin import Names, profile_of
from codegen.importers.python.source import from_python
from maviper.verification.ask import VerifyOptions
from maviper.verification.run import verify_world
from verify.reports.systems import lines

WORLD = """
name = "walker"
steps = 5
dt = "2 s"
[variables]
x = { unit = "m", range = [-10, 10] }
y = { unit = "m", range = [-10, 10] }
[agents.legs.features]
place = "x"
[agents.legs.actions]
rest = {}
walk = { speed = "0.05 m/s" }
[start]
box = { x = [0, 0.05], y = [1, 1] }
[dynamics.next]
x = "x + dt*legs.speed"
y = "y"
"""
LEGS = "def legs(place):\n    return 'walk' if place < 100 else 'rest'\n"


def told(folder, text, world=WORLD, legs=LEGS):
    """The facts and the report about one claim: the walker goes 0.1 m each step."""
    (folder / "walker.toml").write_text(f"{world}\n[[property]]\n{text}\n")
    profile = profile_of(from_python(legs.encode(), "legs.py"), Names(actions=["rest", "walk"]))
    done = verify_world(profile, VerifyOptions(world=folder / "walker.toml"))
    return done.document["results"][0], done.files["report.txt"]


@pytest.mark.parametrize(
    ("claim", "verdict", "border", "gap", "step"),
    [
        ('name = "stays_in"\nregion = { box = { x = [-1, 1] } }', "PROVED", "x = 1", 0.45, 5),
        ('name = "stays_in"\nregion = { box = { x = [-1, 0.5] } }', "VIOLATED", "x = 0.5", 0.05, 5),
        ('name = "avoids"\nregion = { box = { x = [2, 3] } }', "PROVED", "x = 2", 1.45, 5),
        ('name = "avoids"\nregion = { where = ["x - y >= 0.6"] }', "PROVED", "-x + y = -0.6", 1.05, 5),
        ('name = "reaches"\nregion = { box = { x = [0.8, 3] } }', "VIOLATED", "x = 0.8", None, 5),
    ],
    ids=["stays", "leaves", "avoids", "sum", "misses"],
)
def test_the_closest_approach_is_the_one_that_sums_by_hand_give(tmp_path, claim, verdict, border, gap, step):
    facts, text = told(tmp_path, claim)
    near = facts["approach"]
    assert (facts["verdict"], near["border"]) == (verdict, border), text
    assert near["step"] == step and near["unit"] == ("" if "y" in border else "m")
    assert near["episodes"] == (1_000 if verdict == "PROVED" else 0)
    if gap is None:
        assert 0.25 - 1e-9 <= near["gap"] <= 0.3 + 1e-9 and "short of x = 0.8, at step 5 (10 s)" in text
    else:
        assert near["gap"] == pytest.approx(gap, abs=1e-9) or (verdict == "VIOLATED" and 0 < near["gap"] <= gap + 1e-9)
        assert ("closest approach: " if verdict == "PROVED" else " m beyond ") in text
        assert "at step 5 (10 s)" in text


def test_a_claim_that_an_episode_fulfils_has_no_closest_approach(tmp_path):
    facts, text = told(tmp_path, 'name = "reaches"\nregion = { box = { x = [0.4, 3] } }')
    assert facts["verdict"] == "PROVED" and "approach" not in facts and "border" not in text


def test_an_episode_that_ends_on_the_border_comes_as_near_as_that(tmp_path):
    """Three steps of 0.1 are beyond 0.3 in float64, by a rounding."""
    world = WORLD.replace("steps = 5", "steps = 3").replace("x = [0, 0.05]", "x = [0, 0]")
    facts, text = told(tmp_path, 'name = "stays_in"\nregion = { box = { x = [-1, 0.3] } }', world)
    near = facts["approach"]
    assert facts["verdict"] == "PROVED" and (near["border"], near["gap"], near["step"]) == ("x = 0.3", 0.0, 3), text


def test_episodes_with_errors_that_no_rule_has_tell_of_no_closest_approach(tmp_path):
    squared = WORLD.replace('y = "y"', 'y = "y*y/1[m]"')
    facts, text = told(tmp_path, 'name = "stays_in"\nregion = { box = { y = [-1, 2] } }', squared)
    assert facts["verdict"] == "UNKNOWN" and "within the enclosure error" in facts["reason"]
    assert "approach" not in facts and "border" not in text


@pytest.mark.parametrize(
    ("formula", "split", "place"),
    [
        ("x > 0.1 and x <= 0.5 implies acts(legs) == rest", "<= 0.1", "0.1 + "),
        ("x > 0.0999999999999 implies acts(legs) == rest", "< 0.1", "0.0999999999999"),
        ("x > 0.0999999999999 implies acts(legs) == rest", "<= 0.1", "0.1"),
    ],
    ids=["between floats", "many digits", "six digits"],
)
def test_a_counterexample_is_told_as_closely_as_the_claim_needs(tmp_path, formula, split, place):
    legs = f"def legs(place):\n    return 'walk' if place {split} else 'rest'\n"
    facts, text = told(tmp_path, f'formula = "{formula}"', legs=legs)
    assert facts["verdict"] == "VIOLATED", text
    closely = facts["counterexample"].get("closely", {}).get("x", "0.1")
    assert closely.startswith(place) and (len(closely) > len("0.1")) == (len(place) > len("0.1"))
    assert f"x = {closely}\n" in text and f"in x {closely}, y " in "\n".join(lines(facts))


def test_the_last_state_of_an_episode_is_told_as_closely_as_the_claim_needs(tmp_path):
    facts, text = told(tmp_path, 'name = "avoids"\nregion = { box = { x = [0.5499999999, 0.5499999999999] } }')
    assert facts["verdict"] == "VIOLATED"
    closely = facts["counterexample"]["closely"]["x"]
    assert Fraction("0.5499999999") <= Fraction(closely) <= Fraction("0.5499999999999")
    assert f"x = {closely}\n" in text and f": x {closely}, y " in "\n".join(lines(facts))


def test_a_tree_of_another_name_is_told_how_to_be_imported(tmp_path):
    (tmp_path / "walker.toml").write_text(f"{WORLD}\n[[property]]\nname = 'reaches'\nregion.box.x = [0.4, 3]\n")
    other = profile_of(from_python(LEGS.replace("legs", "feet").encode(), "feet.py"), Names(actions=["rest", "walk"]))
    with pytest.raises(InputError, match=r"unknown agent 'feet'(.|\n)*known: legs; .* --agents legs=FILE"):
        verify_world(other, VerifyOptions(world=tmp_path / "walker.toml"))
