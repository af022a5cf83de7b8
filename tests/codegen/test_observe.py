"""Observations by their meanings, against the meanings read aloud."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from codegen.floats import FLOAT32
from codegen.ir import FUNCTIONS, EntitySpec, FeatureSpec, Meaning, WorldSpec
from codegen.observe import FEW, Observer, observe
from maviper.worlds import find
from tests.support.games import NAMES

SPEC = WorldSpec(
    name="flat",
    reference="none",
    agents=tuple(EntitySpec(name, 0.1, 5.0, None, False) for name in ("a", "b")),
    landmarks=(EntitySpec("c", 0.1, 0.0, None, False),),
    goals=("c",),
    dt=0.1,
    damping=0.25,
    start_low=-1.0,
    start_high=1.0,
    episode_steps=25,
)
COORDINATES = SPEC.coordinates()
TERMS = st.lists(st.tuples(st.sampled_from([-1, 1, 0.5, -0.25]), st.sampled_from(COORDINATES)), max_size=5).map(tuple)
MEANINGS = st.builds(
    lambda terms, kind: Meaning(terms, kind if terms else ""), TERMS, st.sampled_from(["", *FUNCTIONS])
)
# a coarse grid, so that sums are 0 and ties happen, and numbers that are rounded
NUMBERS = st.one_of(st.integers(-4, 4).map(lambda k: k / 4), st.floats(-3, 3, allow_subnormal=False))


def read_aloud(meaning, at):
    """One number at a time: added in float64 in the order of the terms, then rounded to float32."""
    total = np.float64(0)
    for place, (weight, name) in enumerate(meaning.terms):
        part = np.float64(weight) * np.float64(at[name])
        total = part if place == 0 else total + part
    if meaning.function == "sign":
        return np.float32(-1 if total < 0 else 1 if total > 0 else 0)
    if meaning.function == "positive":
        return np.float32(1 if total > 0 else 0)
    if meaning.function == "zero":
        return np.float32(1 if total == 0 else 0)
    return np.float32(total)


def features_of(meanings):
    return [FeatureSpec(f"f{k}", "none", -9.0, 9.0, meaning) for k, meaning in enumerate(meanings)]


@given(st.lists(MEANINGS, min_size=1, max_size=6), st.lists(st.tuples(*[NUMBERS] * len(COORDINATES)), max_size=5))
def test_observations_are_the_meanings_read_aloud(meanings, rows):
    coordinates = np.array(rows, dtype=np.float64).reshape(-1, len(COORDINATES))
    found = observe(features_of(meanings), coordinates, SPEC, FLOAT32)
    assert found.shape == (len(rows), len(meanings)) and found.dtype == np.float32
    for seen, row in zip(found, rows, strict=True):
        wanted = [read_aloud(meaning, dict(zip(COORDINATES, row, strict=True))) for meaning in meanings]
        assert (seen == np.array(wanted)).all()


def test_meanings_are_written_as_they_are_read():
    difference = ((-1, "a.vx"), (1, "goal.y"))
    assert [str(Meaning(())), str(Meaning(difference))] == ["0", "- a.vx + goal.y"]
    assert str(Meaning(difference, "sign")) == "sign(- a.vx + goal.y)"
    assert str(Meaning(difference, "positive")) == "positive(- a.vx + goal.y)"
    assert str(Meaning(((1, "b.x"), (-1, "a.x"), (-0.25, "a.vx")))) == "b.x - a.x - 0.25*a.vx"


def test_long_sums_round_after_each_addition():
    """2**53 + 1 is no float64 number, so adding 1 twice adds nothing, and adding 2 does."""
    ones = Meaning(((1, "a.x"), (1, "b.x"), (1, "b.y"), (-1, "c.x")))
    coordinates = np.zeros((2, len(COORDINATES)))
    for name, values in (("a.x", (2.0**53, 1)), ("b.x", (1, 1)), ("b.y", (1, 2.0**53)), ("c.x", (2.0**53,) * 2)):
        coordinates[:, COORDINATES.index(name)] = values
    assert observe(features_of([ones]), coordinates, SPEC, FLOAT32).tolist() == [[0], [2]]


def test_what_has_no_meaning_cannot_be_observed():
    with pytest.raises(ValueError, match="feature f has no meaning"):
        observe([FeatureSpec("f", "none", 0.0, 1.0, None)], np.zeros((1, len(COORDINATES))), SPEC, FLOAT32)


@pytest.mark.parametrize("name", NAMES)
def test_few_states_are_observed_as_many_are(name):
    """All differences at once, some, or one after the other: the same bits, also where coordinates are no numbers."""
    world, rng = find(name), np.random.default_rng(0)
    observer = Observer([feature for features in world.features for feature in features], world.spec)
    planes = rng.choice([0.0, -0.0, 0.1, np.nan, np.inf, *rng.normal(size=9)], (len(world.spec.coordinates()), 2 * FEW))
    with np.errstate(invalid="ignore"):
        together = observer(planes)
        for size in (60, FEW):
            parts = [observer(planes[:, low : low + size]) for low in range(0, 2 * FEW, size)]
            joined = np.concatenate(parts, axis=1)
            assert (np.isnan(joined) == np.isnan(together)).all()  # of what sign a NaN is, nobody asks
            assert np.nan_to_num(joined).tobytes() == np.nan_to_num(together).tobytes()


def test_features_are_looked_up_once_and_never_taken_for_others(monkeypatch):
    """Whoever observes state by state asks about the same features again and again."""
    world, built = find("physical-deception").spec, []
    made = Observer.__init__
    monkeypatch.setattr(Observer, "__init__", lambda self, *given: (built.append(given), made(self, *given))[1])
    sets = [tuple(find("physical-deception").features[agent]) for agent in range(3)]
    at = np.random.default_rng(0).normal(size=(1, len(world.coordinates())))
    for _ in range(3):
        for features in sets:
            alone = Observer.__new__(Observer)
            made(alone, features, world, "float32")
            assert (observe(features, at, world, "float32") == alone(at.T).T).all()
    assert len(built) == 3
    wide = observe(sets[1], at, world, "float64")
    assert wide.dtype == np.float64 and len(built) == 4
